//! Systems of linear equations.

/// Solves `matrix` x = `right` by Gauss's elimination with row pivots; `None` where the equations leave x open.
pub(super) fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let size = right.len();
    for column in 0..size {
        let largest = |&a: &usize, &b: &usize| matrix[a][column].abs().total_cmp(&matrix[b][column].abs());
        let pivot = (column..size).max_by(largest)?;
        if matrix[pivot][column].abs() < 1e-12 {
            return None;
        }
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        let (above, below) = matrix.split_at_mut(column + 1);
        let row = &above[column];
        for (offset, other) in below.iter_mut().enumerate() {
            let factor = other[column] / row[column];
            for (value, taken) in other[column..].iter_mut().zip(&row[column..]) {
                *value -= factor * taken;
            }
            right[column + 1 + offset] -= factor * right[column];
        }
    }
    for column in (0..size).rev() {
        let known: f64 = (column + 1..size).map(|k| matrix[column][k] * right[k]).sum();
        right[column] = (right[column] - known) / matrix[column][column];
    }
    Some(right)
}

/// The coefficients that fit `rows` of (factors, value, weight) with the least sum of weighted squares.
pub(super) fn least_squares(rows: &[(Vec<f64>, f64, f64)], unknowns: usize) -> Option<Vec<f64>> {
    let mut matrix = vec![vec![0.0; unknowns]; unknowns];
    let mut right = vec![0.0; unknowns];
    for (factors, value, weight) in rows {
        for (i, a) in factors.iter().enumerate().filter(|(_, a)| **a != 0.0) {
            right[i] += weight * a * value;
            for (j, b) in factors.iter().enumerate() {
                matrix[i][j] += weight * a * b;
            }
        }
    }
    solve(matrix, right)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_solved_fulfils_the_equations(values in proptest::collection::vec(-1.0..1.0, 12)) {
            let mut matrix: Vec<Vec<f64>> = values[..9].chunks(3).map(<[f64]>::to_vec).collect();
            (0..3).for_each(|at| matrix[at][(at + 1) % 3] += 3.0);
            let found = solve(matrix.clone(), values[9..].to_vec()).unwrap();
            for (row, right) in matrix.iter().zip(&values[9..]) {
                let left: f64 = row.iter().zip(&found).map(|(a, b)| a * b).sum();
                prop_assert!((left - right).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn open_equations_have_no_solution() {
        assert_eq!(solve(vec![vec![1.0, 2.0], vec![2.0, 4.0]], vec![1.0, 2.0]), None);
    }
}

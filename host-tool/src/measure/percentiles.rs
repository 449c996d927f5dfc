//! Percentiles of many values.

/// Returns the percentiles `percents` of the values, interpolated linearly between ranks; 0 where there are none.
pub fn percentiles<const N: usize>(values: &[f32], percents: [f64; N]) -> [f64; N] {
    if values.is_empty() {
        return [0.0; N];
    }
    let ranks = percents.map(|percent| (values.len() - 1) as f64 * percent.clamp(0.0, 100.0) / 100.0);
    let mut counts = vec![0usize; BINS];
    values.iter().for_each(|&value| counts[bin(value)] += 1);
    ranks.map(|rank| {
        let whole = rank.floor() as usize;
        let (index, within) = place(&counts, whole);
        let mut candidates: Vec<f32> = values.iter().copied().filter(|&value| bin(value) == index).collect();
        candidates.sort_unstable_by(f32::total_cmp);
        let below = candidates[within];
        let above = match candidates.get(within + 1) {
            _ if rank.fract() == 0.0 => below,
            Some(&above) => above,
            None => least_beyond(values, index),
        };
        f64::from(below) + rank.fract() * f64::from(above - below)
    })
}

const BINS: usize = 1 << 16;

/// The bin of a value: its sign, exponent and first bits, so that bins are in the values' order.
fn bin(value: f32) -> usize {
    let bits = value.to_bits();
    let ordered = if bits >> 31 == 1 { !bits } else { bits | 1 << 31 };
    (ordered >> 16) as usize
}

/// The bin of the value of rank `rank`, and its rank among those of that bin.
fn place(counts: &[usize], rank: usize) -> (usize, usize) {
    let mut before = 0;
    for (index, &count) in counts.iter().enumerate() {
        if rank < before + count {
            return (index, rank - before);
        }
        before += count;
    }
    (BINS, 0)
}

/// The least value beyond the bin `index`.
fn least_beyond(values: &[f32], index: usize) -> f32 {
    values.iter().copied().filter(|&value| bin(value) > index).min_by(f32::total_cmp).unwrap_or(f32::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn ranks_are_those_of_the_sorted_values(
            values in proptest::collection::vec(-2.0f32..2.0, 1..200),
            percent in 0.0..=100.0f64,
        ) {
            let mut sorted = values.clone();
            sorted.sort_by(f32::total_cmp);
            let rank = (sorted.len() - 1) as f64 * percent / 100.0;
            let (below, above) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
            let expected = f64::from(below) + rank.fract() * f64::from(above - below);
            let [found] = percentiles(&values, [percent]);
            prop_assert!((found - expected).abs() < 1e-6, "{} {}", found, expected);
        }
    }
}

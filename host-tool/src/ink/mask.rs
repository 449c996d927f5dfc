//! A mask of ranks whose every level is blue noise, made by void and cluster (Ulichney 1993, "The void-and-cluster
//! method for dither array generation", SPIE 1913).

/// Dots of a mask's side.
pub(super) const SIDE: usize = 64;
/// Dots of a mask.
pub(super) const DOTS: usize = SIDE * SIDE;

/// Width of the filter that finds voids and clusters, in dots, where dots are square; Ulichney's.
const SIGMA: f64 = 1.5;
/// Dots of the pattern that ranking starts from: a tenth.
const FIRST: usize = DOTS / 10;
/// The filter's value at its middle: whole numbers add up the same on every machine.
const UNIT: f64 = (1_u64 << 32) as f64;

/// What a threshold is a part of.
const FULL: usize = u16::MAX as usize + 1;

/// A threshold for each dot, all different, evenly spread over 0..65,536; the mask joins itself at its edges.
#[derive(Debug)]
pub(super) struct Mask(Vec<u16>);

impl Mask {
    /// Makes the mask for dots that lie `elongation` times as close along a row as along a column.
    pub(super) fn new(elongation: f64) -> Self {
        let mut pattern = Pattern::new(elongation);
        pattern.begin();
        let mut ranks = vec![0; DOTS];
        let prototype = pattern.clone();
        for rank in (0..FIRST).rev() {
            let cluster = pattern.tightest_cluster();
            pattern.flip(cluster);
            ranks[cluster] = rank;
        }
        pattern = prototype;
        for rank in FIRST..DOTS {
            let void = pattern.largest_void();
            pattern.flip(void);
            ranks[void] = rank;
        }
        const STEP: usize = FULL / DOTS;
        Self(ranks.into_iter().map(|rank| (rank * STEP + STEP / 2) as u16).collect())
    }

    /// The thresholds of a row.
    pub(super) fn row(&self, row: usize) -> &[u16] {
        let start = row % SIDE * SIDE;
        &self.0[start..start + SIDE]
    }
}

/// Which dots are set, and how many lie near each dot.
#[derive(Clone)]
struct Pattern {
    filter: Vec<i64>,
    set: Vec<bool>,
    nearby: Vec<i64>,
}

impl Pattern {
    fn new(elongation: f64) -> Self {
        // Distances are those on the film, scaled so that a dot's area stays 1.
        let (wide, high) = (SIGMA * elongation.sqrt(), SIGMA / elongation.sqrt());
        let distance = |index: usize| index.min(SIDE - index) as f64;
        let weight = |at: usize| {
            let (x, y) = (distance(at % SIDE) / wide, distance(at / SIDE) / high);
            (UNIT * (-(x * x + y * y) / 2.0).exp()).round() as i64
        };
        Self { filter: (0..DOTS).map(weight).collect(), set: vec![false; DOTS], nearby: vec![0; DOTS] }
    }

    /// Sets the first dots anywhere and spreads them until no move betters them.
    fn begin(&mut self) {
        // A linear congruence of full period (Hull and Dobell 1962) meets every dot once.
        let mut at = 1;
        for _ in 0..FIRST {
            at = (at * 1_365 + 1_021) % DOTS;
            self.flip(at);
        }
        for _ in 0..DOTS {
            let cluster = self.tightest_cluster();
            self.flip(cluster);
            let void = self.largest_void();
            self.flip(void);
            if void == cluster {
                break;
            }
        }
    }

    fn flip(&mut self, dot: usize) {
        self.set[dot] = !self.set[dot];
        let sign = if self.set[dot] { 1 } else { -1 };
        let (row, column) = (dot / SIDE, dot % SIDE);
        for (line, nearby) in self.nearby.chunks_exact_mut(SIDE).enumerate() {
            let start = (line + SIDE - row) % SIDE * SIDE;
            let filter = &self.filter[start..start + SIDE];
            let (left, right) = nearby.split_at_mut(column);
            for (near, weight) in right.iter_mut().zip(filter) {
                *near += sign * weight;
            }
            for (near, weight) in left.iter_mut().zip(&filter[SIDE - column..]) {
                *near += sign * weight;
            }
        }
    }

    fn tightest_cluster(&self) -> usize {
        let key = |&dot: &usize| (self.nearby[dot], std::cmp::Reverse(dot));
        (0..DOTS).filter(|&dot| self.set[dot]).max_by_key(key).unwrap_or(0)
    }

    fn largest_void(&self) -> usize {
        (0..DOTS).filter(|&dot| !self.set[dot]).min_by_key(|&dot| (self.nearby[dot], dot)).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The part of the variance that lies at wave numbers below `below`, in cycles a mask along either axis.
    fn slow_part(level: f64, mask: &Mask, below: i32) -> f64 {
        let level = (level * FULL as f64) as u16;
        let dots: Vec<f64> =
            (0..DOTS).map(|at| if mask.row(at / SIDE)[at % SIDE] < level { 1.0 } else { 0.0 }).collect();
        let mean = dots.iter().sum::<f64>() / DOTS as f64;
        let mut slow = 0.0;
        for u in -below..=below {
            for v in -below..=below {
                let (mut real, mut imaginary) = (0.0, 0.0);
                for (at, dot) in dots.iter().enumerate() {
                    let turns = f64::from(u * (at % SIDE) as i32 + v * (at / SIDE) as i32) / SIDE as f64;
                    let (sine, cosine) = (std::f64::consts::TAU * turns).sin_cos();
                    real += (dot - mean) * cosine;
                    imaginary += (dot - mean) * sine;
                }
                slow += real * real + imaginary * imaginary;
            }
        }
        let all = dots.iter().map(|dot| (dot - mean).powi(2)).sum::<f64>() * DOTS as f64;
        slow / all
    }

    #[test]
    fn every_threshold_is_there_once() {
        let mask = Mask::new(1.0);
        let mut ranks: Vec<usize> =
            (0..SIDE).flat_map(|row| mask.row(row).iter().map(|&t| usize::from(t) * DOTS / FULL)).collect();
        ranks.sort_unstable();
        assert!(ranks.iter().enumerate().all(|(index, &rank)| index == rank));
    }

    #[test]
    fn its_levels_are_blue_noise() {
        let mask = Mask::new(1.0);
        for level in [0.05, 0.3, 0.5, 0.8] {
            // White noise would have 13 x 13 of 64 x 64 waves there: 4 %.
            let slow = slow_part(level, &mask, 6);
            assert!(slow < 0.004, "level {level}: {slow}");
        }
    }
}

//! Sums over many pixels, in double precision, the same on any number of threads.

use rayon::prelude::*;

use crate::simd::vectorised;

/// Values that one task of the thread pool adds up.
const VALUES_AT_ONCE: usize = 1 << 13;

/// Numbers that processors add at once.
const LANES: usize = 4;

/// Returns the sums of `terms` over all pairs of values.
pub(super) fn sums<const N: usize>(
    a: &[f32],
    b: &[f32],
    terms: impl Fn(f32, f32) -> [f64; N] + Sync,
) -> [f64; N] {
    if a.len() <= VALUES_AT_ONCE {
        return vectorised(
            #[inline(always)]
            || part(a, b, &terms),
        );
    }
    let parts: Vec<[f64; N]> = a
        .par_chunks(VALUES_AT_ONCE)
        .zip(b.par_chunks(VALUES_AT_ONCE))
        .map(|(a, b)| {
            vectorised(
                #[inline(always)]
                || part(a, b, &terms),
            )
        })
        .collect();
    parts.iter().fold([0.0; N], |sums, part| std::array::from_fn(|index| sums[index] + part[index]))
}

#[inline(always)]
fn part<const N: usize>(a: &[f32], b: &[f32], terms: impl Fn(f32, f32) -> [f64; N]) -> [f64; N] {
    let mut lanes = [[0.0; LANES]; N];
    for (a, b) in a.chunks(LANES).zip(b.chunks(LANES)) {
        for (lane, (&a, &b)) in a.iter().zip(b).enumerate() {
            for (sums, term) in lanes.iter_mut().zip(terms(a, b)) {
                sums[lane] += term;
            }
        }
    }
    lanes.map(|sums| sums.iter().sum())
}

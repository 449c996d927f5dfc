//! Loops in the widest vectors that this processor has.

use fearless_simd::{Level, dispatch};

/// Runs `work` compiled for the processor at hand. `work` is to be marked `#[inline(always)]`, and so is all
/// that it calls, for only what is inlined here is compiled anew. Results do not depend on the processor:
/// no multiplication is fused with an addition.
pub(crate) fn vectorised<R>(work: impl FnOnce() -> R) -> R {
    dispatch!(Level::new(), simd => fearless_simd::Simd::vectorize(simd, work))
}

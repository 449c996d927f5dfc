//! Behaviour of the stores, above all when the power goes.

mod clock;
mod ring;
mod settings;
mod slots;
mod typed;
mod year;

/// How many of the possible cuts are tried: every n-th, starting elsewhere for each record. 1 tries all;
/// `VITRINE_CUT_STRIDE` sets it.
fn cut_stride(default: u64) -> usize {
    let default = if cfg!(miri) { default * 500 } else { default };
    let wanted = std::env::var("VITRINE_CUT_STRIDE").ok().and_then(|text| text.parse().ok());
    usize::try_from(wanted.unwrap_or(default)).unwrap_or(1).max(1)
}

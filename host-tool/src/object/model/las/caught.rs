//! Panics of the crate `laz`, whose decoder stops in one at some damaged data, as errors.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

use laz::LasZipError;

thread_local! {
    /// Whether a panic of this thread is told by an error alone.
    static IS_SILENT: Cell<bool> = const { Cell::new(false) };
}

/// Does `work`, which has to stay on this thread; a panic is an error, and nothing else is told of it.
pub(super) fn caught<T>(work: impl FnOnce() -> Result<T, LasZipError>) -> Result<T, String> {
    static SILENCE: Once = Once::new();
    SILENCE.call_once(|| {
        let hook = take_hook();
        set_hook(Box::new(move |panic| {
            if !IS_SILENT.get() {
                hook(panic);
            }
        }));
    });
    IS_SILENT.set(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    IS_SILENT.set(false);
    match done {
        Ok(done) => done.map_err(|error| error.to_string()),
        Err(_) => Err("the compressed points are damaged".to_owned()),
    }
}

//! What staff see and press: the status LED on the board, and the key.

use embassy_rp::gpio::{Input, Level, Output, Pull};
use embassy_time::{Duration, Ticker};
use portable_atomic::{AtomicBool, Ordering};
use vitrine_exhibit::controller::LED_BEAT;

use crate::board::FrontResources;
use crate::controller;
use crate::watchdog::{Client, check_in};

/// One beat of the LED's patterns, and the key's debounce: it must read the same twice.
const BEAT: Duration = Duration::from_millis(LED_BEAT.0 as u64);

static KEY_IS_PRESSED: AtomicBool = AtomicBool::new(false);

/// Tells whether the staff key is held down.
pub(crate) fn staff_key_is_pressed() -> bool {
    KEY_IS_PRESSED.load(Ordering::Relaxed)
}

/// Shows the state and reads the key for ever.
#[embassy_executor::task]
pub(crate) async fn run(resources: FrontResources) -> ! {
    let mut led = Output::new(resources.status_led, Level::Low);
    let key = Input::new(resources.staff_key, Pull::Up);
    let mut ticker = Ticker::every(BEAT);
    let mut was_low = false;
    for beat in (0_u32..).cycle() {
        let is_low = key.is_low();
        if is_low == was_low {
            KEY_IS_PRESSED.store(is_low, Ordering::Relaxed);
        }
        was_low = is_low;
        led.set_level(Level::from(controller::snapshot().led_is_lit(beat)));
        check_in(Client::Front);
        ticker.next().await;
    }
    core::future::pending().await
}

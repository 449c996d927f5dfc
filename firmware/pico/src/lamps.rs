//! The owner of both lamps: what the governor let through, at the pins.
//!
//! A command is good for a few steps of the controller. When no new one comes, the lamps go dark: a state's owner that
//! hangs does not leave them lit until the watchdog bites.

use core::convert::Infallible;

use defmt::warn;
use embassy_futures::yield_now;
use embassy_rp::gpio::{Level, Output};
use embassy_rp::peripherals::PWM_SLICE1;
use embassy_rp::pwm::{Config, Pwm};
use embassy_rp::{Peri, pac};
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, with_timeout};
use embedded_hal::pwm::{ErrorType, SetDutyCycle};
use fixed::types::U12F4;
use vitrine_drivers::lamps::{Counts, LampError, LampPair};
use vitrine_exhibit::duty::{PWM_FULL, PWM_TOP};
use vitrine_exhibit::governor::LampCommand;

use crate::board::LampsResources;
use crate::darkness;
use crate::watchdog::{Client, check_in};

/// The slice of [`PWM_SLICE1`].
const SLICE: usize = 1;

/// 125 MHz by 4 by 62,500 counts is 500 Hz.
const DIVIDER: U12F4 = U12F4::lit("4");

/// A command lapses after this time without another.
const COMMAND_LAPSES: Duration = Duration::from_millis(50);

/// The newest command of the governor.
pub(crate) static COMMAND: Signal<CriticalSectionRawMutex, LampCommand> = Signal::new();

/// Both lamps at their pins.
pub(crate) type Lamps = LampPair<Dimming, Dimming, Output<'static>>;

/// One dimming output. The library's own output stops one count short of always on.
pub(crate) struct Dimming {
    is_top: bool,
}

impl ErrorType for Dimming {
    type Error = Infallible;
}

impl SetDutyCycle for Dimming {
    fn max_duty_cycle(&self) -> u16 {
        PWM_FULL
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        // Read, change and write back: both outputs share the register, and only the owner of both writes it.
        pac::PWM.ch(SLICE).cc().modify(|compare| {
            if self.is_top {
                compare.set_a(duty);
            } else {
                compare.set_b(duty);
            }
        });
        Ok(())
    }
}

/// Takes the lamps' pins; both lamps are dark.
///
/// # Errors
/// The output that did not go dark.
pub(crate) fn take(resources: LampsResources) -> Result<(Lamps, Pwm<'static>), LampError> {
    let enable = Output::new(resources.enable, Level::Low);
    let slice: Peri<'static, PWM_SLICE1> = resources.slice;
    let mut config = Config::default();
    config.top = PWM_TOP;
    config.divider = DIVIDER;
    let pwm = Pwm::new_output_ab(slice, resources.top, resources.bottom, config);
    darkness::darken();
    Ok((LampPair::new(Dimming { is_top: true }, Dimming { is_top: false }, enable)?, pwm))
}

/// Brings the governor's commands to the pins.
#[embassy_executor::task]
pub(crate) async fn run(mut lamps: Lamps, _pwm: Pwm<'static>) -> ! {
    loop {
        let command = match with_timeout(COMMAND_LAPSES, COMMAND.wait()).await {
            Ok(command) => Some(command),
            Err(_) => {
                // After an erase the state's owner may be late for no fault of its own, and is woken by the same interrupt.
                yield_now().await;
                COMMAND.try_take()
            }
        };
        if command.is_none() {
            warn!("no lamp command for 50 ms: dark");
        }
        obey(&mut lamps, command.unwrap_or(LampCommand::DARK));
        check_in(Client::Lamps);
    }
}

fn obey(lamps: &mut Lamps, command: LampCommand) {
    let counts = command.counts();
    let counts = Counts { top: counts.top, bottom: counts.bottom };
    let lit = command.is_enabled()
        && darkness::light_unless_tripped(|| {
            // The outputs of this board cannot fail.
            let _ = lamps.light(counts);
        });
    if !lit {
        darkness::darken();
        let _ = lamps.dark();
    }
}

//! The owner of the sensor bus: both viewer sensors ten times a second, the ultraviolet sensor five times, the battery
//! clock once a minute.
//!
//! A device that does not answer is set up anew once a second, and does not hold up the others.

use defmt::{info, warn};
use embassy_rp::i2c::{self, I2c};
use embassy_rp::peripherals::I2C0;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;
use embassy_time::{Duration, Ticker, TimeoutError, with_timeout};
use vitrine_drivers::grid_eye::GridEye;
use vitrine_drivers::{battery_clock, uv_sensor};
use vitrine_exhibit::units::{Irradiance, UtcSeconds};

use crate::board::{Interrupts, SensorsResources};
use crate::watchdog::{Client, check_in};
use crate::{readings, settings};

/// The viewer sensors make ten frames a second.
const ROUND: Duration = Duration::from_millis(100);

/// A burst of 128 bytes takes 3 ms at 400 kHz; a device that holds the clock line longer hangs.
const TRANSFER_TIMEOUT: Duration = Duration::from_millis(20);

const ROUNDS_A_SECOND: u32 = 10;
const ROUNDS_A_MINUTE: u32 = 60 * ROUNDS_A_SECOND;

/// The left sensor (yawed to the negative side) and the right one.
const VIEWER_SENSORS: [GridEye; 2] = [GridEye::new(0x68), GridEye::new(0x69)];

/// The battery clock is to be set to the time that is known.
pub(crate) static SET_CLOCK: Signal<CriticalSectionRawMutex, ()> = Signal::new();

type Bus = I2c<'static, I2C0, i2c::Async>;

/// What of the bus answers.
#[derive(Clone, Copy, Default, PartialEq, Eq, defmt::Format)]
struct Answering {
    viewer: [bool; 2],
    ultraviolet: bool,
    clock: bool,
}

/// Reads all sensors for ever.
#[embassy_executor::task]
pub(crate) async fn run(resources: SensorsResources) -> ! {
    let mut config = i2c::Config::default();
    config.frequency = 400_000;
    let mut bus = I2c::new_async(resources.i2c, resources.scl, resources.sda, Interrupts, config);
    let mut answering = Answering::default();
    let mut told = answering;
    let mut ticker = Ticker::every(ROUND);
    for round in (0..ROUNDS_A_MINUTE).cycle() {
        if round % ROUNDS_A_SECOND == 0 {
            set_up_missing(&mut bus, &mut answering).await;
        }
        read_viewer_sensors(&mut bus, &mut answering).await;
        if round % 2 == 0 {
            read_ultraviolet(&mut bus, &mut answering).await;
        }
        if round == 0 || (!answering.clock && round % ROUNDS_A_SECOND == 0) {
            read_clock(&mut bus, &mut answering).await;
        }
        if SET_CLOCK.try_take().is_some() {
            set_clock(&mut bus, &mut answering).await;
        }
        if answering != told {
            info!("on the sensor bus: {}", answering);
            told = answering;
        }
        check_in(Client::Sensors);
        ticker.next().await;
    }
    core::future::pending().await
}

/// Gives a device its time on the bus. One that hangs must not keep the owner from saying that it is alive.
async fn transfer<F: Future>(work: F) -> Result<F::Output, TimeoutError> {
    let outcome = with_timeout(TRANSFER_TIMEOUT, work).await;
    check_in(Client::Sensors);
    outcome
}

async fn set_up_missing(bus: &mut Bus, answering: &mut Answering) {
    for (sensor, answers) in
        VIEWER_SENSORS.iter().zip(answering.viewer.iter_mut()).filter(|(_, answers)| !**answers)
    {
        *answers = matches!(transfer(sensor.set_up(bus)).await, Ok(Ok(())));
    }
    if !answering.ultraviolet {
        answering.ultraviolet = matches!(transfer(uv_sensor::set_up(bus)).await, Ok(Ok(())));
    }
}

async fn read_viewer_sensors(bus: &mut Bus, answering: &mut Answering) {
    for (index, (sensor, answers)) in VIEWER_SENSORS.iter().zip(answering.viewer.iter_mut()).enumerate() {
        if !*answers {
            continue;
        }
        match transfer(sensor.read(bus)).await {
            Ok(Ok(frame)) => readings::thermal(index, &frame.quarter_degrees),
            Ok(Err(error)) => {
                warn!("viewer sensor {}: {}", index, defmt::Debug2Format(&error));
                *answers = false;
            }
            Err(_) => {
                warn!("viewer sensor {} holds the bus", index);
                *answers = false;
            }
        }
    }
}

async fn read_ultraviolet(bus: &mut Bus, answering: &mut Answering) {
    if !answering.ultraviolet {
        return;
    }
    match transfer(uv_sensor::read(bus)).await {
        Ok(Ok(reading)) => {
            let irradiance = Irradiance(reading.irradiance_mw_m2);
            readings::ultraviolet(settings::with(|settings| settings.ultraviolet(irradiance)), reading.air);
        }
        Ok(Err(error)) => {
            warn!("ultraviolet sensor: {}", defmt::Debug2Format(&error));
            answering.ultraviolet = false;
        }
        Err(_) => answering.ultraviolet = false,
    }
}

/// The battery clock leads as long as it can be trusted; what a host set goes on when it cannot.
async fn read_clock(bus: &mut Bus, answering: &mut Answering) {
    match transfer(battery_clock::read(bus)).await {
        Ok(Ok(seconds)) => {
            if !answering.clock {
                info!("battery clock: {} s since 1970", seconds);
            }
            answering.clock = true;
            readings::clock_from_battery(UtcSeconds(seconds));
        }
        _ => answering.clock = false,
    }
}

async fn set_clock(bus: &mut Bus, answering: &mut Answering) {
    let Some(time) = readings::time() else { return };
    answering.clock = matches!(transfer(battery_clock::set(bus, time.0)).await, Ok(Ok(())));
    if !answering.clock {
        warn!("the battery clock did not take the time");
    }
    readings::clock_was_set(answering.clock.then_some(time));
}

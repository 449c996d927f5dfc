//! The owner of the converter: lamp board temperatures and lamp supply, twenty times a second.

use defmt::warn;
use embassy_rp::adc::{self, Adc, Channel};
use embassy_rp::gpio::Pull;
use embassy_time::{Duration, Ticker};
use vitrine_drivers::supply;
use vitrine_drivers::thermistor::{self, SensorFault};
use vitrine_exhibit::inputs::TemperatureReading;
use vitrine_exhibit::units::{CentiCelsius, Millivolts, PerLamp};

use crate::board::{AnalogResources, Interrupts};
use crate::watchdog::{Client, check_in};
use crate::{readings, settings};

const ROUND: Duration = Duration::from_millis(50);

/// Samples that are averaged: the converter's noise is a few steps.
const SAMPLES: u16 = 8;

/// Reads all inputs for ever.
#[embassy_executor::task]
pub(crate) async fn run(resources: AnalogResources) -> ! {
    let mut converter = Adc::new(resources.adc, Interrupts, adc::Config::default());
    let mut top = Channel::new_pin(resources.top_heat_sink, Pull::None);
    let mut bottom = Channel::new_pin(resources.bottom_heat_sink, Pull::None);
    let mut lamp_supply = Channel::new_pin(resources.lamp_supply, Pull::None);
    let mut ticker = Ticker::every(ROUND);
    loop {
        ticker.next().await;
        let readings = (
            average(&mut converter, &mut top).await,
            average(&mut converter, &mut bottom).await,
            average(&mut converter, &mut lamp_supply).await,
        );
        if let (Ok(top), Ok(bottom), Ok(lamp_supply)) = readings {
            let settings = settings::now();
            let boards = PerLamp::new(
                temperature(top, settings.top_beta_kelvin),
                temperature(bottom, settings.bottom_beta_kelvin),
            );
            let lamp_supply = supply::millivolts(lamp_supply, settings.supply_divider_permille);
            readings::analog(boards, Millivolts(lamp_supply));
        } else {
            warn!("the converter failed");
        }
        check_in(Client::Analog);
    }
}

async fn average(
    converter: &mut Adc<'static, adc::Async>,
    channel: &mut Channel<'static>,
) -> Result<u16, adc::Error> {
    let mut sum = 0;
    for _ in 0..SAMPLES {
        sum += converter.read(channel).await?;
    }
    Ok(sum / SAMPLES)
}

fn temperature(reading: u16, beta_kelvin: u16) -> TemperatureReading {
    match thermistor::temperature(reading, beta_kelvin) {
        Ok(temperature) => TemperatureReading::Celsius(CentiCelsius(temperature.0)),
        Err(SensorFault::Open) => TemperatureReading::OpenCircuit,
        Err(SensorFault::Shorted) => TemperatureReading::Shorted,
    }
}

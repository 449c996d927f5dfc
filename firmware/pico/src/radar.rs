//! The owner of the radar's port: its reports, ten a second, where one is fitted.

use defmt::{info, warn};
use embassy_futures::select::{Either, select};
use embassy_rp::uart::{self, BufferedUart};
use embassy_time::{Duration, Instant, Timer};
use static_cell::StaticCell;
use vitrine_drivers::radar::{BAUD, Radar};

use crate::board::{Interrupts, RadarResources};
use crate::readings;
use crate::watchdog::{ALIVE, Client, check_in};

/// A radar that has been silent for so long is gone.
const SILENT: Duration = Duration::from_secs(1);

/// Takes the radar's reports for ever.
#[embassy_executor::task]
pub(crate) async fn run(resources: RadarResources) -> ! {
    static SEND: StaticCell<[u8; 16]> = StaticCell::new();
    static RECEIVE: StaticCell<[u8; 128]> = StaticCell::new();
    let mut config = uart::Config::default();
    config.baudrate = BAUD;
    let (send, receive) = (SEND.init([0; 16]), RECEIVE.init([0; 128]));
    let mut port =
        BufferedUart::new(resources.uart, resources.tx, resources.rx, Interrupts, send, receive, config);
    let mut radar = Radar::new();
    let mut heard: Option<Instant> = None;
    loop {
        check_in(Client::Radar);
        match select(radar.read(&mut port), Timer::after(ALIVE)).await {
            Either::First(Ok(report)) => {
                readings::radar(report);
                if heard.replace(Instant::now()).is_none() {
                    info!("a radar reports");
                }
            }
            // Noise, or nobody there: the next whole report puts it right.
            Either::First(Err(_)) => Timer::after(ALIVE).await,
            Either::Second(()) => {}
        }
        if heard.is_some_and(|at| at.elapsed() > SILENT) {
            warn!("the radar is silent");
            heard = None;
        }
    }
}

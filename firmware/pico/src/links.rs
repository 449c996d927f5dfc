//! The wires to hosts: USB and the service port. Both speak the same frames.
//!
//! A link owns its wire and nothing else. Requests go to the store's owner, answers come back. A host that stops
//! reading loses its answer after a while, and holds up nobody but itself.

use defmt::{info, warn};
use embassy_futures::select::{Either, select};
use embassy_rp::peripherals::USB;
use embassy_rp::uart::{self, BufferedUart};
use embassy_rp::usb::Driver;
use embassy_time::{Duration, Instant, Timer, with_timeout};
use embassy_usb::class::cdc_acm::{CdcAcmClass, State};
use embassy_usb::driver::EndpointError;
use embassy_usb::{Builder, Config, UsbDevice};
use embedded_io_async::{Read, Write};
use portable_atomic::{AtomicU32, Ordering};
use static_cell::StaticCell;
use vitrine_exhibit::settings::ServicePort;
use vitrine_protocol::frame::Frame;
use vitrine_protocol::server::{Incoming, Link, Reach};
use vitrine_protocol::{USB_IDS, USB_PRODUCT};

use crate::board::{Interrupts, ServiceResources, UsbResources};
use crate::settings;
use crate::store::{ANSWERS, INCOMING};
use crate::watchdog::{ALIVE, Client, alive_while, check_in};

/// How many links there are.
pub(crate) const LINKS: usize = 2;

const USB_LINK: u8 = 0;
const SERIAL_LINK: u8 = 1;

/// A packet of full-speed USB.
const PACKET_BYTES: usize = 64;

/// A host that does not take an answer for so long does not get it.
const ANSWER_TIMEOUT: Duration = Duration::from_millis(500);

const SERIAL_BAUD: u32 = 115_200;

type UsbDriver = Driver<'static, USB>;

static DAMAGED_FRAMES: [AtomicU32; LINKS] = [const { AtomicU32::new(0) }; LINKS];

/// Frames that came damaged, over all links.
pub(crate) fn damaged_frames() -> u32 {
    DAMAGED_FRAMES.iter().fold(0, |sum, link| sum.saturating_add(link.load(Ordering::Relaxed)))
}

/// Sets up USB: the device, which must run, and its serial port.
pub(crate) fn usb(
    resources: UsbResources,
    serial_number: &'static str,
) -> (UsbDevice<'static, UsbDriver>, CdcAcmClass<'static, UsbDriver>) {
    static CONFIGURATION: StaticCell<[u8; 256]> = StaticCell::new();
    static OBJECT_STORE: StaticCell<[u8; 256]> = StaticCell::new();
    static CONTROL: StaticCell<[u8; 64]> = StaticCell::new();
    static STATE: StaticCell<State<'_>> = StaticCell::new();

    let (vendor, product) = USB_IDS;
    let mut config = Config::new(vendor, product);
    config.manufacturer = Some("Vitrine");
    config.product = Some(USB_PRODUCT);
    config.serial_number = Some(serial_number);
    config.max_power = 100;
    let driver = Driver::new(resources.controller, Interrupts);
    let mut builder = Builder::new(
        driver,
        config,
        CONFIGURATION.init([0; 256]),
        OBJECT_STORE.init([0; 256]),
        &mut [],
        CONTROL.init([0; 64]),
    );
    let class = CdcAcmClass::new(&mut builder, STATE.init(State::new()), PACKET_BYTES as u16);
    (builder.build(), class)
}

/// Runs the USB device for ever.
#[embassy_executor::task]
pub(crate) async fn run_usb_device(mut device: UsbDevice<'static, UsbDriver>) -> ! {
    alive_while(Client::UsbDevice, device.run()).await
}

/// Serves the host on USB for ever.
#[embassy_executor::task]
pub(crate) async fn run_usb(mut class: CdcAcmClass<'static, UsbDriver>) -> ! {
    let mut wire = Wire::new(USB_LINK);
    let mut packet = [0; PACKET_BYTES];
    let mut open = false;
    loop {
        check_in(Client::Usb);
        if open != class.dtr() {
            open = !open;
            wire.link.reset();
            info!("USB port {}", if open { "opened" } else { "closed" });
        }
        match select(class.read_packet(&mut packet), Timer::after(ALIVE)).await {
            Either::First(Ok(length)) => {
                // The processor has no 64-bit division: the time is asked for once for many bytes.
                let now_ms = Instant::now().as_millis();
                for byte in packet.iter().take(length) {
                    // No byte but a frame's last has anything to wait for, or to move about.
                    let Some(incoming) = wire.link.push(*byte, now_ms) else { continue };
                    let Some(answer) = alive_while(Client::Usb, wire.ask(incoming)).await else { continue };
                    let sent = with_timeout(ANSWER_TIMEOUT, send(&mut class, &answer));
                    if !matches!(alive_while(Client::Usb, sent).await, Ok(Ok(()))) {
                        warn!("a host on USB did not take its answer");
                    }
                }
                wire.tell_faults();
            }
            // Not connected: there is nothing to wait for but the next look.
            Either::First(Err(_)) => Timer::after(ALIVE).await,
            Either::Second(()) => {}
        }
    }
}

async fn send(class: &mut CdcAcmClass<'static, UsbDriver>, answer: &[u8]) -> Result<(), EndpointError> {
    for packet in answer.chunks(PACKET_BYTES) {
        class.write_packet(packet).await?;
    }
    // A transfer of whole packets ends with an empty one.
    if answer.len().is_multiple_of(PACKET_BYTES) {
        class.write_packet(&[]).await?;
    }
    Ok(())
}

/// Serves the host on the service port for ever.
#[embassy_executor::task]
pub(crate) async fn run_serial(resources: ServiceResources) -> ! {
    static SEND: StaticCell<[u8; 64]> = StaticCell::new();
    static RECEIVE: StaticCell<[u8; 256]> = StaticCell::new();
    let mut config = uart::Config::default();
    config.baudrate = SERIAL_BAUD;
    let (send, receive) = (SEND.init([0; 64]), RECEIVE.init([0; 256]));
    let mut port =
        BufferedUart::new(resources.uart, resources.tx, resources.rx, Interrupts, send, receive, config);
    let mut wire = Wire::new(SERIAL_LINK);
    let mut bytes = [0; 64];
    loop {
        check_in(Client::Serial);
        wire.link.set_reach(match settings::with(|settings| settings.service_port) {
            ServicePort::Cable => Reach::Cable,
            ServicePort::Network => Reach::Network,
        });
        match select(port.read(&mut bytes), Timer::after(ALIVE)).await {
            Either::First(Ok(length)) => {
                let now_ms = Instant::now().as_millis();
                for byte in bytes.iter().take(length) {
                    let Some(incoming) = wire.link.push(*byte, now_ms) else { continue };
                    let Some(answer) = alive_while(Client::Serial, wire.ask(incoming)).await else {
                        continue;
                    };
                    let sent = with_timeout(ANSWER_TIMEOUT, port.write_all(&answer));
                    let _ = alive_while(Client::Serial, sent).await;
                }
                wire.tell_faults();
            }
            // Noise on the wire: the next frame's end puts it right.
            Either::First(Err(_)) | Either::Second(()) => {}
        }
    }
}

/// One link and its way to the server.
struct Wire {
    number: u8,
    link: Link,
}

impl Wire {
    fn new(number: u8) -> Self {
        Self { number, link: Link::new(number, Reach::Cable) }
    }

    /// Has a request answered.
    async fn ask(&self, incoming: Incoming) -> Option<Frame> {
        let answers = ANSWERS.get(usize::from(self.number))?;
        INCOMING.send((self.number, incoming)).await;
        Some(answers.receive().await)
    }

    fn tell_faults(&self) {
        let faults = self.link.faults();
        if let Some(damaged) = DAMAGED_FRAMES.get(usize::from(self.number)) {
            damaged.store(faults.damaged.saturating_add(faults.too_long), Ordering::Relaxed);
        }
    }
}

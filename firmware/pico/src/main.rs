//! The image of the exhibit controller, for the RP2040 (Raspberry Pi Pico) and the RP2350 (Pico 2).
//!
//! Who owns what:
//!
//! | owner | runs | owns |
//! |---|---|---|
//! | [`guard`] | interrupt, highest priority | the interlock's edges: dark at once |
//! | [`controller`] | interrupt executor, 100 Hz | the state of the exhibit |
//! | [`lamps`] | interrupt executor | both PWM channels and the enable line |
//! | [`sensors`] | thread executor | the I2C bus: viewer sensors, ultraviolet sensor, battery clock |
//! | [`analog`] | thread executor | the converter: temperatures, supply |
//! | [`radar`] | thread executor | the radar's port |
//! | [`front`] | thread executor | status LED and staff key |
//! | [`store`] | thread executor | flash: plan, dose ledger, event log, new firmware; and what [`hosts`] may ask |
//! | [`links`] | thread executor | USB and the service port |
//! | [`watchdog`] | thread executor | the watchdog, fed when all have checked in |
//!
//! Values go from owner to owner; nobody shares what somebody owns. However the program ends, [`last_words`] makes
//! the lamps dark before anything else.
#![no_std]
#![no_main]
#![deny(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing)]

mod analog;
mod board;
mod chip;
mod controller;
mod darkness;
mod flash_map;
mod front;
mod guard;
#[cfg(feature = "bench")]
mod hooks;
mod hosts;
mod lamps;
mod last_words;
mod links;
mod live;
mod plans;
mod radar;
mod readings;
mod sensors;
mod settings;
mod steady_flash;
mod store;
mod updates;
mod watchdog;

use controller::PlanSlot;
use defmt::info;
use defmt_rtt as _;
use embassy_executor::{SpawnError, SpawnToken, Spawner};
use embassy_rp::executor::InterruptExecutor;
use embassy_rp::interrupt::{self, InterruptExt, Priority};
use heapless::String;
use static_cell::StaticCell;
use store::Store;
use vitrine_exhibit::controller::State;
use vitrine_exhibit::ledger::LedgerRecord;
use vitrine_exhibit::plan::ValidPlan;

/// Runs the tasks that must not wait for the others.
static PROMPT: InterruptExecutor = InterruptExecutor::new();

#[embassy_rp::interrupt]
unsafe fn SWI_IRQ_1() {
    // SAFETY: this is the interrupt that the executor was started on, and nobody else calls it.
    unsafe { PROMPT.on_interrupt() }
}

#[embassy_executor::main(executor = "embassy_rp::executor::Executor", entry = "cortex_m_rt::entry")]
async fn main(spawner: Spawner) {
    let resources = board::split(embassy_rp::init(chip::config()));
    darkness::darken();
    let dog = watchdog::Dog::wake(resources.dog);
    if let Some(ended) = last_words::take(dog.after_fault()) {
        // The log's owner finds it there; nothing else waits in the channel yet.
        let _ = controller::EVENTS.try_send(controller::Happened::now(ended));
    }
    set_priorities();
    let interlock = guard::arm(resources.interlock);
    let Ok((lamps, pwm)) = lamps::take(resources.lamps) else { last_words::end("the lamps did not go dark") };

    static SERIAL_NUMBER: StaticCell<String<24>> = StaticCell::new();
    let [plan, spare] = plan_slots();
    let (store, ledger) = Store::open(resources.storage, plan, spare);
    let serial_number = SERIAL_NUMBER.init(store.serial_number.clone());
    let state = state(ledger, dog.after_fault());
    let (usb_device, usb_port) = links::usb(resources.usb, serial_number);

    #[cfg(feature = "bench")]
    hooks::set_up();

    let prompt = PROMPT.start(interrupt::SWI_IRQ_1);
    prompt.spawn(started(lamps::run(lamps, pwm)));
    prompt.spawn(started(controller::run(state, interlock, plan)));
    spawner.spawn(started(sensors::run(resources.sensors)));
    spawner.spawn(started(analog::run(resources.analog)));
    spawner.spawn(started(radar::run(resources.radar)));
    spawner.spawn(started(store::run(store)));
    spawner.spawn(started(links::run_usb_device(usb_device)));
    spawner.spawn(started(links::run_usb(usb_port)));
    spawner.spawn(started(links::run_serial(resources.service)));
    spawner.spawn(started(front::run(resources.front)));
    spawner.spawn(started(watchdog::run(dog)));
    info!("started");
}

/// Rooms for two plans. Apart from its caller, whose stack lives while the plan is read.
#[inline(never)]
fn plan_slots() -> [PlanSlot; 2] {
    static PLANS: [StaticCell<Option<ValidPlan>>; 2] = [const { StaticCell::new() }; 2];
    PLANS.each_ref().map(|slot| slot.init(None))
}

/// The exhibit's mind at its start; apart from its caller too.
#[inline(never)]
fn state(ledger: LedgerRecord, after_fault: bool) -> &'static mut State {
    static STATE: StaticCell<State> = StaticCell::new();
    STATE.init_with(|| State::new(ledger, after_fault))
}

/// The interlock goes before everything; time and the state's owner before what talks to the world.
fn set_priorities() {
    chip::TIME_INTERRUPT.set_priority(Priority::P1);
    interrupt::SWI_IRQ_1.set_priority(Priority::P1);
    for slow in [
        interrupt::USBCTRL_IRQ,
        interrupt::UART0_IRQ,
        interrupt::UART1_IRQ,
        interrupt::I2C0_IRQ,
        interrupt::ADC_IRQ_FIFO,
    ] {
        slow.set_priority(Priority::P2);
    }
}

/// Each task is spawned once, into room made for one: a failure is a fault of the program.
fn started<S>(token: Result<SpawnToken<S>, SpawnError>) -> SpawnToken<S> {
    token.unwrap_or_else(|_| last_words::end("a task was started twice"))
}

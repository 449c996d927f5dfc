//! How the program ends: dark first, then a note that outlives the reset, then the reset.
//!
//! The note lies in RAM that no start-up code touches. Its checksum tells a note from what RAM holds after power-up.

use core::cell::UnsafeCell;
use core::fmt::Write;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use defmt::error;
use embassy_rp::pac;
use heapless::String;
use vitrine_exhibit::events::{Event, ProgramEnd};

use crate::darkness;

/// Bytes of a note; longer ones are cut.
const NOTE_BYTES: usize = 192;

/// Marks a note, besides its checksum.
const MAGIC: u32 = 0x6c61_7374;

/// In the watchdog's first scratch register: the reset was meant. The boot ROM uses only the last four.
const MEANT: u32 = 0x6d65_616e;

#[derive(Clone, Copy)]
#[repr(C)]
struct Note {
    magic: u32,
    length: u32,
    checksum: u32,
    /// 1 where the processor found the fault.
    hard_fault: u32,
    /// The faulting instruction's address, or the panic's line.
    at: u32,
    text: [u8; NOTE_BYTES],
}

#[repr(transparent)]
struct Keep(UnsafeCell<MaybeUninit<Note>>);

// SAFETY: written where the program ends with interrupts off, read once at the start before any task runs.
unsafe impl Sync for Keep {}

#[unsafe(link_section = ".uninit.last_words")]
static KEEP: Keep = Keep(UnsafeCell::new(MaybeUninit::uninit()));

/// Tells how the program before this one ended, if it ended badly: by its note, or, without one after the watchdog's reset,
/// by hanging.
pub(crate) fn take(after_fault: bool) -> Option<Event> {
    let Some((end, at, text)) = take_note() else {
        return after_fault.then_some(Event::ProgramEnded { end: ProgramEnd::Hang, at: 0 });
    };
    error!("the program before this one ended: {}", text.as_str());
    Some(Event::ProgramEnded { end, at })
}

fn take_note() -> Option<(ProgramEnd, u32, String<NOTE_BYTES>)> {
    // SAFETY: called before any task runs; every bit pattern is a valid `Note`, and volatile reads keep the compiler
    // from reasoning about memory that this program did not write.
    let note = unsafe { core::ptr::read_volatile(KEEP.0.get().cast::<Note>()) };
    let text = note.text.get(..usize::try_from(note.length).ok()?)?;
    if note.magic != MAGIC || note.checksum != checksum(text) {
        return None;
    }
    // SAFETY: as above; clearing the magic number forgets the note.
    unsafe { core::ptr::write_volatile(KEEP.0.get().cast::<u32>(), 0) };
    let end = if note.hard_fault == 0 { ProgramEnd::Panic } else { ProgramEnd::HardFault };
    Some((end, note.at, String::try_from(core::str::from_utf8(text).ok()?).ok()?))
}

fn leave(end: ProgramEnd, at: u32, text: &str) {
    let hard_fault = u32::from(end == ProgramEnd::HardFault);
    let mut note = Note { magic: MAGIC, length: 0, checksum: 0, hard_fault, at, text: [0; NOTE_BYTES] };
    for (kept, byte) in note.text.iter_mut().zip(text.bytes()) {
        *kept = byte;
        note.length += 1;
    }
    note.checksum = checksum(note.text.get(..note.length as usize).unwrap_or_default());
    // SAFETY: interrupts are off and the program ends here, so nobody else looks.
    unsafe { core::ptr::write_volatile(KEEP.0.get().cast::<Note>(), note) };
}

/// FNV-1a: enough to tell a note from noise.
fn checksum(text: &[u8]) -> u32 {
    text.iter().fold(0x811c_9dc5, |sum, byte| (sum ^ u32::from(*byte)).wrapping_mul(0x0100_0193))
}

/// Text that keeps what fits and drops the rest.
struct Clipped(String<NOTE_BYTES>);

impl Write for Clipped {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for letter in text.chars() {
            if self.0.push(letter).is_err() {
                break;
            }
        }
        Ok(())
    }
}

/// Ends the program for a reason of its own: dark, note, reset.
pub(crate) fn end(reason: &str) -> ! {
    end_with(ProgramEnd::Panic, 0, |note| note.write_str(reason))
}

/// Starts the program anew because it is meant to: dark and at once. The next start does not take it for a fault.
pub(crate) fn restart() -> ! {
    darkness::darken();
    cortex_m::interrupt::disable();
    // The state's owner may have lit the lamps between the two.
    darkness::darken();
    pac::WATCHDOG.scratch0().write_value(MEANT);
    reset()
}

/// Tells whether the program before this one ended by [`restart`], and forgets it.
pub(crate) fn take_meant() -> bool {
    let meant = pac::WATCHDOG.scratch0().read() == MEANT;
    pac::WATCHDOG.scratch0().write_value(0);
    meant
}

fn end_with(end: ProgramEnd, at: u32, write: impl FnOnce(&mut Clipped) -> core::fmt::Result) -> ! {
    darkness::darken();
    cortex_m::interrupt::disable();
    // The state's owner may have lit the lamps between the two.
    darkness::darken();
    let mut note = Clipped(String::new());
    // A note that cannot be written in full is still worth keeping.
    let _ = write(&mut note);
    leave(end, at, &note.0);
    reset()
}

/// All stages of the power-on state machine but the two oscillators: RP2040 data sheet 2.13.2, RP2350 data sheet 7.4.
const RESET_STAGES: u32 = if cfg!(feature = "rp2350") { 0x01ff_fff3 } else { 0x0001_fffc };

/// Resets the whole chip but its oscillators, at once. RAM and the watchdog's scratch registers keep their content.
fn reset() -> ! {
    pac::PSM.wdsel().write_value(pac::psm::regs::Wdsel(RESET_STAGES));
    pac::WATCHDOG.ctrl().write(|control| control.set_trigger(true));
    loop {
        cortex_m::asm::nop();
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let line = info.location().map_or(0, core::panic::Location::line);
    end_with(ProgramEnd::Panic, line, |note| write!(note, "{info}"))
}

/// The processor's fault: the frame says where.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    end_with(ProgramEnd::HardFault, frame.pc(), |note| {
        write!(note, "hard fault at {:#010x}, called from {:#010x}", frame.pc(), frame.lr())
    })
}

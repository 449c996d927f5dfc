//! What the firmware tells a technician as it runs, for hosts without a probe: the same bytes as over RTT.
//!
//! defmt leaves its frames in a ring in RAM and waits for nobody. A host reads there too, with a place of its own that
//! it sends along, so that neither it nor a probe takes anything from the other, and nothing here is in the way of those
//! who write. Who asks too seldom finds the ring overwritten, and its decoder goes on at the next frame.

/// The words of RTT's control block: 16 bytes of name, the number of channels each way, and the first channel's name,
/// buffer, size, place to write at and place to read from.
const BUFFER: usize = 7;
const SIZE: usize = 8;
const WRITE: usize = 9;
const WORDS: usize = 12;

unsafe extern "C" {
    #[link_name = "_SEGGER_RTT"]
    static CONTROL: [u32; WORDS];
}

/// Reads from a place of the ring on, or from the oldest byte on; gives where to go on and how many bytes were read. What
/// was never written reads as zeros.
pub(crate) fn read(from: Option<u16>, part: &mut [u8]) -> (u16, usize) {
    let (size, write) = (word(SIZE), word(WRITE));
    let oldest = if write + 1 < size { write + 1 } else { 0 };
    let mut at = from.map(u32::from).filter(|at| *at < size).unwrap_or(oldest);
    let mut read = 0;
    for place in part.iter_mut() {
        if at == write || size == 0 {
            break;
        }
        *place = byte(at);
        at = (at + 1) % size;
        read += 1;
    }
    (at as u16, read)
}

fn word(index: usize) -> u32 {
    // SAFETY: the library's control block has these words, as RTT lays them out; volatile, for interrupts write them.
    unsafe { core::ptr::read_volatile((&raw const CONTROL).cast::<u32>().add(index)) }
}

fn byte(at: u32) -> u8 {
    // SAFETY: `at` is below the size of the buffer to which the control block points.
    unsafe { core::ptr::read_volatile((word(BUFFER) as usize as *const u8).add(at as usize)) }
}

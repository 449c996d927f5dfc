use std::println;

use super::cut_stride;
use crate::{
    Opened, Ring, RingPosition,
    map::SECTOR_BYTES,
    mock::{EraseOrder, LastStep, MockError, MockFlash, Random},
};

const START: u32 = 0x1e_0000;
/// 16 entries a sector keep the tests small: 248 + 8 bytes.
const N: usize = 248;
const RING: Ring<N> = Ring::new(START, 3);

fn flash() -> MockFlash {
    MockFlash::new(START, RING.end())
}

fn payload(sequence: u32) -> [u8; N] {
    let mut random = Random(sequence.into());
    core::array::from_fn(|_| random.next() as u8)
}

fn open(flash: &mut MockFlash) -> RingPosition {
    let Opened { position, newest } = RING.open(flash).expect("readable flash");
    if position.next() > 1 {
        assert_eq!(newest, Some(payload(position.next() - 1)));
    } else {
        assert_eq!(newest, None);
    }
    position
}

fn append(flash: &mut MockFlash, position: &mut RingPosition) -> bool {
    let payload = payload(position.next());
    RING.append(flash, position, &payload).is_ok()
}

/// When sectors are erased: by the append that begins them, or ahead of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Erase {
    ByAppend,
    Ahead,
}

impl Erase {
    const BOTH: [Self; 2] = [Self::ByAppend, Self::Ahead];

    /// Adds an entry, and erases ahead where that is wanted.
    fn append(self, flash: &mut MockFlash, position: &mut RingPosition) -> bool {
        append(flash, position) && self.make_room(flash, position)
    }

    fn make_room(self, flash: &mut MockFlash, position: &mut RingPosition) -> bool {
        self == Self::ByAppend || !RING.wants_room(position) || RING.make_room(flash, position).is_ok()
    }
}

fn expect_all_kept(flash: &mut MockFlash, position: &RingPosition, least: u32) {
    assert!(position.next() - position.oldest() >= least.min(position.next() - 1));
    for sequence in position.oldest()..position.next() {
        assert_eq!(RING.read(flash, position, sequence), Ok(Some(payload(sequence))), "entry {sequence}");
    }
    assert_eq!(RING.read(flash, position, position.oldest() - 1), Ok(None));
    assert_eq!(RING.read(flash, position, position.next()), Ok(None));
}

#[test]
fn entries_are_numbered_from_one_and_the_newest_are_kept() {
    let mut flash = flash();
    let mut position = open(&mut flash);
    assert_eq!((position.oldest(), position.next()), (1, 1));
    for sequence in 1..=200 {
        assert_eq!(RING.append(&mut flash, &mut position, &payload(sequence)), Ok(sequence));
        assert_eq!(open(&mut flash), position, "opened anew after entry {sequence}");
        expect_all_kept(&mut flash, &position, RING.kept_at_least());
    }
}

#[test]
fn every_sector_wears_alike() {
    for (erase, wear) in [(Erase::ByAppend, [10, 10, 10]), (Erase::Ahead, [11, 10, 10])] {
        let mut flash = flash();
        let mut position = open(&mut flash);
        assert!(erase.make_room(&mut flash, &mut position));
        for _ in 0..10 * RING.appends_per_round() {
            assert!(erase.append(&mut flash, &mut position));
        }
        assert_eq!(flash.erases(), wear, "{erase:?}");
    }
}

#[test]
fn an_append_never_erases_where_room_was_made() {
    let mut flash = flash();
    let mut position = open(&mut flash);
    for _ in 0..3 * RING.appends_per_round() {
        assert!(Erase::Ahead.make_room(&mut flash, &mut position));
        assert!(!RING.wants_room(&position) && !RING.will_erase(&position));
        let erased = flash.erases().to_vec();
        assert!(append(&mut flash, &mut position));
        assert_eq!(flash.erases(), erased);
        expect_all_kept(&mut flash, &position, RING.kept_at_least());
    }
}

#[test]
fn what_was_erased_ahead_before_a_start_is_erased_again() {
    let mut flash = flash();
    let mut position = open(&mut flash);
    assert!(append(&mut flash, &mut position));
    RING.make_room(&mut flash, &mut position).expect("erased");
    let mut reopened = open(&mut flash);
    assert!(RING.wants_room(&reopened));
    let before: u32 = flash.erases().iter().sum();
    RING.make_room(&mut flash, &mut reopened).expect("erased");
    assert_eq!(flash.erases().iter().sum::<u32>(), before + 1);
    assert_eq!(reopened, position);
}

#[test]
fn a_refused_erase_changes_nothing() {
    let mut flash = flash();
    let mut position = open(&mut flash);
    for _ in 0..RING.appends_per_round() {
        assert!(append(&mut flash, &mut position));
    }
    let before = position;
    let mut refusing = WithoutErase { flash, outcome: Err(MockError::OutOfBounds) };
    let refused = Err(crate::Error::Flash(MockError::OutOfBounds));
    assert_eq!(RING.make_room(&mut refusing, &mut position), refused);
    let next = payload(position.next());
    assert_eq!(RING.append(&mut refusing, &mut position, &next).map(|_| ()), refused);
    assert_eq!(position, before);
    let mut flash = refusing.flash;
    assert!(append(&mut flash, &mut position));
    expect_all_kept(&mut flash, &position, RING.kept_at_least());
}

#[test]
fn an_append_says_before_whether_it_erases() {
    let mut flash = flash();
    let mut position = open(&mut flash);
    for _ in 0..100 {
        let erased: u32 = flash.erases().iter().sum();
        let announced = RING.will_erase(&position);
        assert!(append(&mut flash, &mut position));
        assert_eq!(flash.erases().iter().sum::<u32>() - erased, u32::from(announced));
    }
}

#[test]
fn flash_that_does_not_erase_is_an_error_and_no_endless_loop() {
    let mut flash = flash();
    flash.bytes_mut().fill(0x5a);
    let position = open(&mut flash);
    let mut worn = WithoutErase { flash, outcome: Ok(()) };
    let outcome = RING.append(&mut worn, &mut position.clone(), &payload(1));
    assert_eq!(outcome, Err(crate::Error::NotAsWritten));
}

#[test]
fn a_cut_at_any_step_loses_at_most_the_entry_being_written() {
    let stride = cut_stride(5);
    let mut cuts = 0_u64;
    for (order, erase) in
        EraseOrder::ALL.into_iter().flat_map(|order| Erase::BOTH.map(|erase| (order, erase)))
    {
        for last_step in LastStep::ALL {
            let mut flash = flash().tearing(order, last_step);
            let mut position = open(&mut flash);
            for number in 0..2 * RING.appends_per_round() as usize + 5 {
                let before = (flash.clone(), position);
                assert!(erase.append(&mut flash, &mut position));
                let steps = flash.steps() - before.0.steps();
                for cut in (0..steps).skip(number % stride).step_by(stride) {
                    cuts += 1;
                    let (mut cut_flash, mut cut_position) = before.clone();
                    cut_flash.cut_after(cut);
                    assert!(!erase.append(&mut cut_flash, &mut cut_position));
                    cut_flash.power_on();
                    let mut reopened = open(&mut cut_flash);
                    let next = reopened.next();
                    // What was acknowledged stays; what was cut is there as a whole or not at all.
                    assert!((cut_position.next()..=before.1.next() + 1).contains(&next), "{erase:?}: {next}");
                    assert!(erase.make_room(&mut cut_flash, &mut reopened));
                    assert!(erase.append(&mut cut_flash, &mut reopened));
                    if number % 7 == 0 {
                        // The cut cost one place, and its sector may have been erased early.
                        expect_all_kept(&mut cut_flash, &reopened, RING.kept_at_least() - 1);
                    }
                }
            }
        }
    }
    println!("ring: {cuts} cuts, no failure");
}

#[test]
fn many_cuts_one_after_another_keep_the_sequence_gapless() {
    let mut random = Random(7);
    for (order, erase) in
        EraseOrder::ALL.into_iter().flat_map(|order| Erase::BOTH.map(|erase| (order, erase)))
    {
        for last_step in LastStep::ALL {
            let mut flash = flash().tearing(order, last_step);
            let mut acknowledged = 0;
            let mut cuts = 0;
            while acknowledged < 1_000 {
                let mut position = open(&mut flash);
                assert!(position.next() > acknowledged, "an acknowledged entry is gone");
                assert!(position.next() <= acknowledged + 2, "an entry nobody wrote");
                let steps = random.below(2_000);
                flash.cut_after(steps);
                while erase.make_room(&mut flash, &mut position) && append(&mut flash, &mut position) {}
                acknowledged = position.next() - 1;
                flash.power_on();
                cuts += 1;
            }
            let position = open(&mut flash);
            expect_all_kept(&mut flash, &position, RING.kept_at_least() / 2);
            assert!(cuts > 100);
        }
    }
}

#[test]
fn the_maps_rings_have_the_sizes_they_are_documented_with() {
    let per_sector = SECTOR_BYTES / (crate::map::LOG_ENTRY_BYTES as u32 + 8);
    assert_eq!(crate::map::LOG.kept_at_least(), 30 * per_sector);
    assert_eq!(crate::map::LEDGER.appends_per_round(), 8 * 32);
}

/// Flash whose erases do nothing: it is worn out, or refuses them.
struct WithoutErase {
    flash: MockFlash,
    outcome: Result<(), MockError>,
}

impl embedded_storage::nor_flash::ErrorType for WithoutErase {
    type Error = MockError;
}

impl embedded_storage::nor_flash::ReadNorFlash for WithoutErase {
    const READ_SIZE: usize = 1;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.flash.read(offset, bytes)
    }
    fn capacity(&self) -> usize {
        self.flash.capacity()
    }
}

impl embedded_storage::nor_flash::NorFlash for WithoutErase {
    const WRITE_SIZE: usize = 1;
    const ERASE_SIZE: usize = SECTOR_BYTES as usize;
    fn erase(&mut self, _from: u32, _to: u32) -> Result<(), Self::Error> {
        self.outcome
    }
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.flash.write(offset, bytes)
    }
}

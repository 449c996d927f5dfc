use proptest::prelude::*;

use crate::rate::{BURST, Bucket, REFILL_MS};

#[test]
fn a_burst_passes_and_then_one_in_each_interval() {
    let mut bucket = Bucket::new();
    for _ in 0..BURST {
        assert_eq!(bucket.take(1_000), Ok(()));
    }
    assert_eq!(bucket.take(1_000), Err(REFILL_MS as u32));
    assert_eq!(bucket.take(1_000 + REFILL_MS - 1), Err(1));
    assert_eq!(bucket.take(1_000 + REFILL_MS), Ok(()));
    assert!(bucket.take(1_000 + REFILL_MS).is_err());
}

proptest! {
    #[test]
    fn no_more_pass_than_the_burst_and_the_refill(pauses in prop::collection::vec(0_u64..20, 1..500)) {
        let mut bucket = Bucket::new();
        let (mut now_ms, mut passed) = (0, 0);
        for pause in pauses {
            now_ms += pause;
            match bucket.take(now_ms) {
                Ok(()) => passed += 1,
                Err(retry) => prop_assert!((1..=REFILL_MS).contains(&u64::from(retry))),
            }
        }
        prop_assert!(passed <= u64::from(BURST) + now_ms / REFILL_MS);
    }

    #[test]
    fn waiting_as_told_is_enough(takes in 1_u64..200, start in 0_u64..1_000_000) {
        let mut bucket = Bucket::new();
        let mut now_ms = start;
        for _ in 0..takes {
            if let Err(retry) = bucket.take(now_ms) {
                now_ms += u64::from(retry);
                prop_assert_eq!(bucket.take(now_ms), Ok(()));
            }
        }
    }

    #[test]
    fn a_clock_that_goes_back_does_no_harm(times in prop::collection::vec(any::<u64>(), 1..100)) {
        let mut bucket = Bucket::new();
        for now_ms in times {
            let _ = bucket.take(now_ms);
        }
    }
}

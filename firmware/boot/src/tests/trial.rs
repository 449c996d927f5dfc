use vitrine_exhibit::units::{Milliseconds, Millivolts};

use crate::trial::{Health, LONGEST, SHORTEST, Verdict};

const GOOD: Health = Health { dark: true, supply: Some(Millivolts(24_000)), all_checked_in: true };

#[test]
fn only_a_dark_supplied_and_lively_image_is_confirmed() {
    assert_eq!(GOOD.judge(SHORTEST), Verdict::Confirm);
    for bad in [
        Health { dark: false, ..GOOD },
        Health { supply: None, ..GOOD },
        Health { supply: Some(Millivolts(5_000)), ..GOOD },
        Health { supply: Some(Millivolts(30_000)), ..GOOD },
        Health { all_checked_in: false, ..GOOD },
    ] {
        assert_eq!(bad.judge(SHORTEST), Verdict::Wait, "{bad:?}");
        assert_eq!(bad.judge(Milliseconds(LONGEST.0 - 1)), Verdict::Wait, "{bad:?}");
        assert_eq!(bad.judge(LONGEST), Verdict::GoBack, "{bad:?}");
    }
}

#[test]
fn a_confirmation_comes_neither_too_early_nor_too_late() {
    assert_eq!(GOOD.judge(Milliseconds(SHORTEST.0 - 1)), Verdict::Wait);
    assert_eq!(GOOD.judge(Milliseconds(LONGEST.0 - 1)), Verdict::Confirm);
    assert_eq!(GOOD.judge(LONGEST), Verdict::GoBack);
}

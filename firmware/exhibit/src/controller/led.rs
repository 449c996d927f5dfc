//! What the status LED tells from afar.

use super::Snapshot;
use crate::events::{Cut, Cuts, DarkReason};
use crate::units::Milliseconds;

/// One beat of the LED's patterns.
pub const LED_BEAT: Milliseconds = Milliseconds(50);

impl Snapshot {
    /// Whether the status LED is lit in this beat; beats follow each other by [`LED_BEAT`].
    ///
    /// | pattern | means |
    /// |---|---|
    /// | steady | lit as it should be |
    /// | steady with a short gap every second | lit, but dimmed by a rule, or a sensor is lost: `vitrine status` says which |
    /// | a short blink every second | dark as it should be |
    /// | blinking, twice a second | somebody has to do something: door, re-arm, plan, clock, new stack |
    /// | hurried, five times a second | a fault |
    pub fn led_is_lit(&self, beat: u32) -> bool {
        match self.dark {
            None if self.wants_attention() => !beat.is_multiple_of(20),
            None => true,
            Some(
                DarkReason::Starting
                | DarkReason::StaffKey
                | DarkReason::HostRequest
                | DarkReason::Closed
                | DarkReason::NobodyThere
                | DarkReason::NothingToShow
                | DarkReason::LedgerNotStored,
            ) => beat.is_multiple_of(20),
            Some(
                DarkReason::InterlockOpen
                | DarkReason::InterlockNotArmed
                | DarkReason::NoPlan
                | DarkReason::ClockInvalid
                | DarkReason::LifeDose,
            ) => beat % 10 < 5,
            Some(_) => beat % 4 < 2,
        }
    }

    /// Lit, and yet something for a technician. A fade is none, nor is a level that the driver cannot give.
    fn wants_attention(&self) -> bool {
        let told = |cuts: Cuts| cuts.iter().any(|cut| !matches!(cut, Cut::Slew | Cut::BelowFloor));
        told(self.cuts.top) || told(self.cuts.bottom) || self.ultraviolet_lost || self.viewer_sensor_lost
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::Lamp;

    /// How often the LED is lit, and how often it goes on, in the twenty beats of a second.
    fn pattern(snapshot: &Snapshot) -> (usize, usize) {
        let lit = |beat: &u32| snapshot.led_is_lit(*beat);
        let rises = (0..20).filter(|beat| lit(beat) && !lit(&((beat + 19) % 20)));
        ((0..20).filter(lit).count(), rises.count())
    }

    #[test]
    fn each_kind_of_news_has_its_own_pattern() {
        let dark = |reason| Snapshot { dark: Some(reason), ..Snapshot::default() };
        let lit = Snapshot { dark: None, ..Snapshot::default() };
        assert_eq!(pattern(&lit), (20, 0));
        assert_eq!(pattern(&dark(DarkReason::Closed)), (1, 1));
        assert_eq!(pattern(&dark(DarkReason::InterlockNotArmed)), (10, 2));
        assert_eq!(pattern(&dark(DarkReason::TooHot(Lamp::Top))), (10, 5));
        for cut in Cuts::ALL {
            let mut dimmed = lit;
            dimmed.cuts.bottom.insert(cut);
            let usual = matches!(cut, Cut::Slew | Cut::BelowFloor);
            assert_eq!(pattern(&dimmed), if usual { (20, 0) } else { (19, 1) }, "{cut:?}");
        }
        assert_eq!(pattern(&Snapshot { ultraviolet_lost: true, ..lit }), (19, 1));
        assert_eq!(pattern(&Snapshot { viewer_sensor_lost: true, ..lit }), (19, 1));
    }
}

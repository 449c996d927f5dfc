//! How long a lamp pair can be held in a day before the day's dose is used up.

use serde::{Deserialize, Serialize};

use super::exhibit::Exhibit;
use crate::optics::LampPair;
use crate::year::Year;

const MINUTES_A_DAY: usize = 24 * 60;

/// How long a lamp pair can be held in a day with somebody there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    /// Hours of the day with the longest opening times, those of weaker light counted in proportion, or the hours with
    /// somebody there, where they are known and fewer; the lamps' rests taken off.
    pub wanted_h: f64,
    /// Hours until the stronger lamp has used up the day's dose, at most `wanted_h`.
    pub held_h: f64,
}

impl Hold {
    /// Whether the pair lasts the whole day.
    pub fn is_whole(self) -> bool {
        self.held_h >= self.wanted_h
    }

    /// What a user is told where the pair of the view `id` does not last.
    pub fn in_words(self, id: &str) -> String {
        format!(
            "The lamps of {id} can be held for {:.1} h a day with somebody there; the longest day wants \
             {:.1} h. Then the day's dose is used up and the idle glow is left; level = {:.2} in [[schedule]] would last.",
            self.held_h,
            self.wanted_h,
            self.lasting_level()
        )
    }

    /// The level in `[[schedule]]` with which the pair would last, 0..=1.
    pub fn lasting_level(self) -> f64 {
        if self.wanted_h > 0.0 { self.held_h / self.wanted_h } else { 1.0 }
    }
}

impl Exhibit {
    /// How long `pair` can be held, the ceiling and the day's dose considered.
    pub fn hold(&self, pair: LampPair) -> Hold {
        let level = pair.top.max(pair.bottom) * self.level_under_the_ceiling();
        let irradiance = self.lamps.irradiance_w_m2 * level;
        let limits = &self.limits;
        let lit = limits.continuous_s / (limits.continuous_s + limits.rest_s);
        let hours = self.presence.expected_h_a_day.unwrap_or(f64::INFINITY).min(self.longest_day_h());
        let wanted_h = lit * hours;
        let held_h = limits.daily_dose_j_m2 / irradiance.max(f64::MIN_POSITIVE) / 3600.0;
        Hold { wanted_h, held_h: held_h.min(wanted_h) }
    }

    /// How long the dose of the stack's life lasts, as a sentence, `year` being one of this exhibit.
    ///
    /// The hours with somebody there decide it: unless they are known, somebody is taken to be there all the time.
    pub fn life_in_words(&self, year: &Year) -> String {
        let life_j_m2 = self.limits.life_dose_j_m2;
        let life = format!("the stack's {:.1} MJ/m2", life_j_m2 / 1e6);
        let Some(years) = year.life_years else { return format!("{life} are never used up") };
        match self.presence.expected_h_a_day.filter(|hours| *hours > 0.0) {
            Some(hours) => {
                let likely_j_m2 = (self.expected_dose_j_m2() * year.open_days as f64).min(year.dose_j_m2);
                let likely = life_j_m2 / likely_j_m2;
                format!(
                    "with somebody there for {hours} h of each open day {life} last {likely:.1} years; with somebody \
                     there all the time, {years:.1}"
                )
            }
            None if self.schedule.is_empty() => format!(
                "with somebody there day and night {life} last {years:.1} years: give opening hours in \
                 [[schedule]], or `expected_h_a_day` in [presence], and a likelier life is told"
            ),
            None => format!(
                "with somebody there in all of these hours {life} last {years:.1} years: give \
                 `expected_h_a_day` in [presence], and a likelier life is told"
            ),
        }
    }

    /// Hours at full level of the weekday that is open longest, whatever the season.
    fn longest_day_h(&self) -> f64 {
        if self.schedule.is_empty() {
            return 24.0;
        }
        // Two weeks, so that what passes midnight of the last day falls into the second.
        let mut levels = vec![0.0; 14 * MINUTES_A_DAY];
        for rule in &self.schedule {
            let (from, to) = (usize::from(rule.from_minute), usize::from(rule.to_minute));
            let length = if to > from { to - from } else { to + MINUTES_A_DAY - from };
            for day in (0..14).filter(|day| rule.days[day % 7]) {
                let start = day * MINUTES_A_DAY + from;
                let end = (start + length).min(levels.len());
                levels[start..end].fill(rule.level);
            }
        }
        let days = levels[7 * MINUTES_A_DAY..].chunks(MINUTES_A_DAY);
        days.map(|day| day.iter().sum::<f64>() / 60.0).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::parse;

    fn exhibit(text: &str) -> Exhibit {
        let view = "[[view]]\nid = \"a\"\npattern = \"photos/cat.jpg\"\n";
        let here = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("exhibit.toml");
        parse(&here, &format!("{text}{view}")).unwrap()
    }

    const DAYS: &str = "[[schedule]]\ndays = \"tue-sun\"\nfrom = \"10:00\"\nto = \"18:00\"\n\
        [[schedule]]\ndays = \"fri\"\nfrom = \"18:00\"\nto = \"02:00\"\nlevel = 0.5\n";

    #[test]
    fn the_longest_day_counts_weak_light_in_proportion() {
        // Friday: eight hours, and six of half light; Saturday two of half light after midnight, and eight.
        assert!((exhibit(DAYS).longest_day_h() - 11.0).abs() < 1e-9);
        assert_eq!(exhibit("").longest_day_h(), 24.0);
    }

    #[test]
    fn a_pair_is_held_until_the_stronger_lamp_has_used_up_the_day() {
        let lit = 600.0 / 660.0;
        let full = exhibit(DAYS).hold(LampPair::new(0.3, 1.0));
        assert!((full.held_h - 30_000.0 / 10.0 / 3600.0).abs() < 1e-9, "{full:?}");
        assert!((full.wanted_h - 11.0 * lit).abs() < 1e-9 && !full.is_whole());
        let dim = exhibit(DAYS).hold(LampPair::new(0.05, 0.01));
        assert!(dim.is_whole() && dim.lasting_level() == 1.0, "{dim:?}");
        let weaker = exhibit(&format!("[lamps]\nceiling_w_m2 = 5\n{DAYS}")).hold(LampPair::FULL);
        assert!((weaker.held_h - 2.0 * full.held_h).abs() < 1e-9, "{weaker:?}");
    }
}

//! What must be seen in a scenario.

use serde::Deserialize;
use vitrine_exhibit::events::{Cuts, Event};

use super::is_now;
use crate::bench::Bench;

/// Something that must hold at a moment, or all the time between two.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct See {
    at_s: Option<f64>,
    from_s: Option<f64>,
    to_s: Option<f64>,
    /// A reason such as "InterlockOpen" or "TooHot(Top)"; "none" is light.
    dark: Option<String>,
    /// The view's id, or "none".
    view: Option<String>,
    presence: Option<String>,
    /// Levels of both lamps as parts of full level, within `within`.
    top: Option<f64>,
    bottom: Option<f64>,
    #[serde(default = "within")]
    within: f64,
    /// Both levels are at most this.
    at_most: Option<f64>,
    /// At least one level is at least this.
    at_least: Option<f64>,
    /// A cut such as "Warm" is at work on one of the lamps; "none" for no cut at all.
    cut: Option<String>,
    viewers: Option<u8>,
    /// The bearing's angle and its tolerance, in degrees.
    horizontal_deg: Option<(f64, f64)>,
    vertical_deg: Option<(f64, f64)>,
    /// PWM counts of the top lamp: these, and no others, within the time.
    top_counts: Option<Vec<u16>>,
    /// What the status LED shows, of the twenty beats of a second: how often it is lit.
    led_beats: Option<usize>,
    ultraviolet_lost: Option<bool>,
    /// An event such as "Rearmed" comes at least once within the time.
    event: Option<String>,
    /// An event does not come within the time.
    no_event: Option<String>,
    /// Records in flash, in J/m2: the day's dose of the top lamp, at least and at most.
    day_dose_j_m2: Option<(f64, f64)>,
    #[serde(skip)]
    looked: bool,
    #[serde(skip)]
    came: bool,
}

const fn within() -> f64 {
    0.01
}

impl See {
    /// Looks at the bench after a step.
    ///
    /// # Errors
    /// What is seen instead.
    pub fn look(&mut self, time_s: f64, bench: &Bench, events: &[Event]) -> Result<(), String> {
        let now = match (self.at_s, self.from_s, self.to_s) {
            (Some(at_s), None, None) => is_now(at_s, time_s),
            (None, Some(from_s), Some(to_s)) => from_s <= time_s && time_s < to_s,
            _ => return Err("a [[see]] needs at_s, or from_s and to_s".into()),
        };
        if !now {
            return Ok(());
        }
        self.looked = true;
        let named = |event: &Event| format!("{event:?}");
        self.came |=
            self.event.as_ref().is_some_and(|wanted| events.iter().any(|event| named(event) == *wanted));
        let seen = self.look_at_lamps(bench).and_then(|()| self.look_at_viewers(bench));
        let unwanted = self.no_event.as_ref().filter(|no| events.iter().any(|event| named(event) == **no));
        let seen = unwanted.map_or(seen, |event| Err(format!("event {event}")));
        seen.map_err(|error| format!("at {time_s:.2} s: {error}; {}", describe(bench)))
    }

    /// Tells at the end whether everything that had to come has come.
    ///
    /// # Errors
    /// What has not come.
    pub fn finish(&self) -> Result<(), String> {
        match &self.event {
            _ if !self.looked => Err(format!("a [[see]] outside the scenario's time: {self:?}")),
            Some(event) if !self.came => Err(format!("event {event} did not come: {self:?}")),
            _ => Ok(()),
        }
    }

    fn look_at_lamps(&self, bench: &Bench) -> Result<(), String> {
        let now = bench.snapshot();
        let dark = now.dark.map_or("none".into(), |reason| format!("{reason:?}"));
        equal("dark", self.dark.as_ref(), &dark)?;
        let levels = now.levels.map(|level| f64::from(level.0) / 65_535.0);
        let near = |name: &str, wanted: Option<f64>, is: f64, within: f64| match wanted {
            Some(wanted) if (wanted - is).abs() > within => {
                Err(format!("{name} is {is:.3}, not {wanted:.3}"))
            }
            _ => Ok(()),
        };
        near("top", self.top, levels.top, self.within)?;
        near("bottom", self.bottom, levels.bottom, self.within)?;
        let most = levels.top.max(levels.bottom);
        if self.at_most.is_some_and(|bound| most > bound) || self.at_least.is_some_and(|bound| most < bound) {
            return Err(format!("the brighter lamp is at {most:.3}"));
        }
        let cuts = now.cuts.top.union(now.cuts.bottom);
        let cut = Cuts::ALL.into_iter().any(|cut| {
            cuts.contains(cut) && self.cut.as_ref().is_some_and(|wanted| format!("{cut:?}") == *wanted)
        });
        let no_cut = cuts == Cuts::default();
        if self.cut.as_ref().is_some_and(|wanted| if wanted == "none" { !no_cut } else { !cut }) {
            return Err(format!("cuts {:?}", cuts.iter().collect::<Vec<_>>()));
        }
        if self.ultraviolet_lost.is_some_and(|lost| lost != now.ultraviolet_lost) {
            return Err(format!("the ultraviolet sensor is lost: {}", now.ultraviolet_lost));
        }
        let lit_beats = (0..20).filter(|beat| now.led_is_lit(*beat)).count();
        if self.led_beats.is_some_and(|beats| beats != lit_beats) {
            return Err(format!("the LED is lit in {lit_beats} of 20 beats"));
        }
        let counts = bench.command.counts().top;
        if self.top_counts.as_ref().is_some_and(|wanted| !wanted.contains(&counts)) {
            return Err(format!("{counts} counts"));
        }
        let day = bench.flash.lamps.top.day.0 as f64 / 1e6;
        match self.day_dose_j_m2 {
            Some((least, most)) if !(least..=most).contains(&day) => {
                Err(format!("{day} J/m2 today in flash"))
            }
            _ => Ok(()),
        }
    }

    fn look_at_viewers(&self, bench: &Bench) -> Result<(), String> {
        let now = bench.snapshot();
        let view = now.view.and_then(|view| bench.plan.as_ref()?.views.get(usize::from(view)));
        equal("view", self.view.as_ref(), view.map_or("none", |view| view.id.as_str()))?;
        equal("presence", self.presence.as_ref(), &format!("{:?}", now.presence))?;
        if self.viewers.is_some_and(|viewers| viewers != now.viewers) {
            return Err(format!("{} viewers", now.viewers));
        }
        let bearing = |name: &str, wanted: Option<(f64, f64)>, is: Option<i16>| match (wanted, is) {
            (None, _) => Ok(()),
            (Some((wanted, within)), Some(is)) if (f64::from(is) / 100.0 - wanted).abs() <= within => Ok(()),
            (Some(_), is) => Err(format!("{name} is {is:?}")),
        };
        bearing("horizontal", self.horizontal_deg, now.bearing.map(|bearing| bearing.horizontal.0))?;
        bearing("vertical", self.vertical_deg, now.bearing.map(|bearing| bearing.vertical.0))
    }
}

fn equal(name: &str, wanted: Option<&String>, is: &str) -> Result<(), String> {
    match wanted {
        Some(wanted) if wanted != is => Err(format!("{name} is {is}, not {wanted}")),
        _ => Ok(()),
    }
}

fn describe(bench: &Bench) -> String {
    let now = bench.snapshot();
    format!(
        "dark {:?}, {:?}, view {:?}, bearing {:?}, {} viewers, levels {} {}",
        now.dark, now.presence, now.view, now.bearing, now.viewers, now.levels.top.0, now.levels.bottom.0
    )
}

//! Whether a plan asks for more than another: more light, more dose, less rest, or less watching.

use super::{LampCalibration, Limits, Plan};
use crate::units::{Lamp, PerLamp};

/// What of a plan bounds the light that it may give.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Bounds {
    limits: Limits,
    /// None where no lamps have been measured yet.
    lamps: Option<PerLamp<LampCalibration>>,
}

impl Default for Bounds {
    /// The bounds of a controller without a plan: the defaults of [`Limits`], under whatever lamps.
    fn default() -> Self {
        Self { limits: Limits::default(), lamps: None }
    }
}

impl Bounds {
    /// The bounds of a plan.
    pub fn of(plan: &Plan) -> Self {
        Self { limits: plan.limits.clone(), lamps: Some(plan.lamps.clone()) }
    }

    /// Tells whether a plan asks for more than these bounds allow.
    ///
    /// A lamp whose calibration says that it gives less than before, or gives it at another duty, would be driven harder for
    /// the same irradiance; an ultraviolet sensor that is said to read more, or that is no longer counted on, would be
    /// missed later.
    pub fn are_exceeded_by(&self, plan: &Plan) -> bool {
        let (allowed, asked) = (&self.limits, &plan.limits);
        let more = asked.ceiling > allowed.ceiling
            || asked.daily_dose > allowed.daily_dose
            || asked.life_dose > allowed.life_dose
            || asked.continuous > allowed.continuous
            || asked.rest < allowed.rest;
        let lamps = self.lamps.as_ref();
        more || lamps.is_some_and(|lamps| {
            [Lamp::Top, Lamp::Bottom]
                .into_iter()
                .any(|lamp| is_driven_harder(lamps.get(lamp), plan.lamps.get(lamp)))
        })
    }
}

fn is_driven_harder(before: &LampCalibration, after: &LampCalibration) -> bool {
    let (watched, watches) = (before.ultraviolet_at_full.0, after.ultraviolet_at_full.0);
    after.full_level < before.full_level
        || after.curve != before.curve
        || watched > 0 && (watches == 0 || watches > watched)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::CurvePoint;
    use crate::testing;
    use crate::units::Level;

    #[test]
    fn the_same_plan_asks_for_no_more() {
        let plan = testing::plan();
        assert!(!Bounds::of(&plan).are_exceeded_by(&plan));
        assert!(!Bounds::default().are_exceeded_by(&plan));
    }

    #[test]
    fn less_is_no_more() {
        let plan = testing::plan();
        let mut less = plan.clone();
        less.limits.ceiling.0 -= 1;
        less.limits.daily_dose.0 -= 1;
        less.limits.life_dose.0 -= 1;
        less.limits.continuous.0 -= 1;
        less.limits.rest.0 += 1;
        less.lamps.top.full_level.0 += 1;
        less.lamps.top.ultraviolet_at_full.0 += 1;
        assert!(!Bounds::of(&plan).are_exceeded_by(&less));
    }

    #[test]
    fn each_way_to_more_is_seen() {
        let ways: [fn(&mut Plan); 9] = [
            |plan| plan.limits.ceiling.0 += 1,
            |plan| plan.limits.daily_dose.0 += 1,
            |plan| plan.limits.life_dose.0 += 1,
            |plan| plan.limits.continuous.0 += 1,
            |plan| plan.limits.rest.0 -= 1,
            |plan| plan.lamps.bottom.full_level.0 -= 1,
            |plan| plan.lamps.top.curve.push(CurvePoint { level: Level(0), duty: 0 }).unwrap(),
            |plan| plan.lamps.top.ultraviolet_at_full.0 = 0,
            |plan| plan.lamps.bottom.ultraviolet_at_full.0 += 1,
        ];
        let mut plan = testing::plan();
        plan.lamps.top.ultraviolet_at_full.0 = 200;
        plan.lamps.bottom.ultraviolet_at_full.0 = 200;
        for (number, way) in ways.into_iter().enumerate() {
            let mut more = plan.clone();
            way(&mut more);
            assert!(Bounds::of(&plan).are_exceeded_by(&more), "{number}");
        }
    }
}

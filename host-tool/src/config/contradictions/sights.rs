//! Views that no viewer could ever come to.

use vitrine_exhibit::units::CentiDegrees;
use vitrine_exhibit::viewer::Bearing;

use super::super::exhibit::{Exhibit, ViewSettings, VisitorSettings};
use super::super::problem::Problems;
use super::{Places, contradiction};

pub(super) fn find(exhibit: &Exhibit, places: &Places<'_>, problems: &mut Problems) {
    for (index, view) in exhibit.views.iter().enumerate() {
        for other in exhibit.views.iter().take(index) {
            let apart_deg = f64::from(bearing(view).distance(bearing(other))) / 100.0;
            // Views in one direction are its pages.
            if apart_deg > 0.0 && apart_deg <= exhibit.visitors.hysteresis_deg {
                let message = format!(
                    "`{}` and `{}` stand {apart_deg:.1} degrees apart, no more than the hysteresis of {}: from one \
                     the other is never chosen",
                    other.id, view.id, exhibit.visitors.hysteresis_deg
                );
                let help = "part them, or lower `hysteresis_deg` in [visitors]";
                problems.push(contradiction(place(places, index), message, help));
            } else if is_in_dead_zone(view, other, &exhibit.visitors) {
                let message = format!(
                    "`{}` and `{}` stand on either side of an axis, both within the dead zone of {} degrees about it",
                    other.id, view.id, exhibit.visitors.dead_zone_deg
                );
                let help = "part them, or lower `dead_zone_deg` in [visitors]";
                problems.push(contradiction(place(places, index), message, help));
            }
        }
    }
}

fn place(places: &Places<'_>, index: usize) -> std::ops::Range<usize> {
    places.entry("view", index, Some("horizontal_deg"))
}

fn bearing(view: &ViewSettings) -> Bearing {
    let angle = |degrees: f64| CentiDegrees((degrees * 100.0).round() as i16);
    Bearing { horizontal: angle(view.horizontal_deg), vertical: angle(view.vertical_deg) }
}

/// Whether two views lie on opposite sides of an axis so near to it that the change between them is never made.
fn is_in_dead_zone(view: &ViewSettings, other: &ViewSettings, visitors: &VisitorSettings) -> bool {
    let held = |a: f64, b: f64| a * b < 0.0 && a.abs().max(b.abs()) < visitors.dead_zone_deg;
    held(view.horizontal_deg, other.horizontal_deg) || held(view.vertical_deg, other.vertical_deg)
}

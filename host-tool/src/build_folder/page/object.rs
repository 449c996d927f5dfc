//! The object of `report.html`: what became of its model.

use maud::{Markup, html};

use super::tables::table;
use crate::object::{ObjectReport, Tally};

/// What became of the object's model; nothing where there is none.
pub(super) fn section(object: Option<&ObjectReport>) -> Markup {
    let Some(object) = object else { return html! {} };
    let Tally { on_films, outside, not_finite, triangles, .. } = object.tally;
    let lost = object.tally.triangles_outside + object.tally.triangles_not_finite;
    html! {
        section aria-labelledby="object" {
            h2 id="object" { "Object" }
            p {
                (object.model) ", one unit of it being " (format!("{:.4}", object.unit_mm)) " mm"
                @if let Some([x, y, z]) = object.size_mm { (format!(": {x:.1} x {y:.1} x {z:.1} mm")) }
                ". " (object.voxels) " voxels have ink."
            }
            @for note in &object.notes { p { (note) } }
            (table("What became of the model", &["Of it", "On films", "Cut", "Outside", "Without finite coordinates"], html! {
                @if on_films + outside + not_finite > 0 {
                    tr { th scope="row" { "Points" } td { (on_films) } td {} td { (outside) } td { (not_finite) } }
                }
                @if triangles > 0 {
                    tr {
                        th scope="row" { "Triangles" }
                        td { (triangles - lost) }
                        td { (object.tally.triangles_cut) }
                        td { (object.tally.triangles_outside) }
                        td { (object.tally.triangles_not_finite) }
                    }
                }
            }))
        }
    }
}

//! The part of `report.html` in which one looks at the stack from anywhere.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, PreEscaped, html};
use serde_json::json;

use super::report::Report;
use crate::config::{Exhibit, ToneSetting};

const SCRIPT: &str = include_str!("viewer.js");

/// Films beyond this many bytes are not put into the page.
const MOST_BYTES: usize = 32 << 20;

/// The viewer with the stack's films, which are PNG files of 8 bits; nothing where they are too large for a page.
pub(super) fn viewer(exhibit: &Exhibit, report: &Report, films: &[Vec<u8>]) -> Markup {
    if films.iter().map(Vec::len).sum::<usize>() > MOST_BYTES {
        return html! {};
    }
    let first = report.views.first();
    let start = |value: Option<f64>| value.unwrap_or_default().to_string();
    let distance = first.map_or(exhibit.viewer.distance_mm, |view| view.distance_mm);
    html! {
        section id="viewer" {
            h2 { "Look at it" }
            p class="no-webgl" hidden { "This browser has no WebGL2: the pictures below show each view." }
            div class="stage" {
                div class="turntable" { canvas aria-label="What a viewer of the stack sees" {} }
                form autocomplete="off" {
                    @for (index, view) in report.views.iter().enumerate() {
                        button type="button" data-view=(index) { (view.id) }
                    }
                    (slider("horizontal", "Viewer to the right", [-60.0, 60.0, 0.5], "°", &start(first.map(|view| view.horizontal_deg))))
                    (slider("vertical", "Viewer above", [-60.0, 60.0, 0.5], "°", &start(first.map(|view| view.vertical_deg))))
                    (slider("distance", "Distance", [150.0, 3000.0, 10.0], " mm", &distance.unwrap_or(600.0).to_string()))
                    (slider("top", "Top lamp", [0.0, 1.0, 0.01], "", &start(first.map(|view| view.emphasis.top))))
                    (slider("bottom", "Bottom lamp", [0.0, 1.0, 0.01], "", &start(first.map(|view| view.emphasis.bottom))))
                    label { input type="checkbox" name="far" checked[distance.is_none()]; " from far away" }
                    label { input type="checkbox" name="ideal"; " without absorption" }
                    label { input type="checkbox" name="tilt" checked; " turn the picture with the viewer" }
                }
            }
            script type="application/json" id="stack" { (PreEscaped(stack(exhibit, report, films))) }
            script { (PreEscaped(SCRIPT)) }
        }
    }
}

fn slider(name: &str, title: &str, [least, most, step]: [f64; 3], unit: &str, value: &str) -> Markup {
    html! {
        label {
            span { (title) " " output for=(name) data-unit=(unit) { (value) (unit) } }
            input type="range" id=(name) name=(name) min=(least) max=(most) step=(step) value=(value);
        }
    }
}

/// What the script needs to know. No text in it can end the script: ids are letters, digits, `-` and `_`.
fn stack(exhibit: &Exhibit, report: &Report, films: &[Vec<u8>]) -> String {
    let stack = exhibit.film_stack();
    let views = report.views.iter().map(|view| {
        json!({
            "horizontal": view.horizontal_deg,
            "vertical": view.vertical_deg,
            "distance": view.distance_mm,
            "top": view.emphasis.top,
            "bottom": view.emphasis.bottom,
        })
    });
    json!({
        "films": stack.films,
        "width_px": stack.width_px,
        "height_px": stack.height_px,
        "pitch_mm": stack.film_pitch_mm(),
        "pixel_mm": stack.pixel_mm(),
        "index": stack.index,
        "tau_uv": stack.layer_tau_uv(),
        "tau_visible": stack.layer_tau_visible(),
        "light": exhibit.design.tone == ToneSetting::Linear,
        "views": views.collect::<Vec<_>>(),
        "pictures": films.iter().map(|film| STANDARD.encode(film)).collect::<Vec<_>>(),
    })
    .to_string()
}

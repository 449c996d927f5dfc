//! The part of `report.html` in which one looks at the stack from anywhere.

use std::collections::BTreeMap;

use maud::{Markup, PreEscaped, html};
use serde_json::json;

use super::{Base64, PageParts};
use crate::config::{Exhibit, FrameSetting, ToneSetting};

/// The page's scripts, in their order.
pub(super) const SCRIPTS: [&str; 4] = [
    include_str!("rays.js"),
    include_str!("picture.js"),
    include_str!("drawing.js"),
    include_str!("viewer.js"),
];

/// Films beyond this many bytes are not put into the page.
const MOST_BYTES: usize = 32 << 20;

/// Degrees to each side that `vitrine view` takes too.
const FARTHEST_DEG: i32 = 80;

/// The viewer with the stack's films; a word of why not where they are too large for a page.
pub(super) fn section(parts: &PageParts<'_>) -> Markup {
    html! {
        section id="viewer" aria-labelledby="look" {
            h2 id="look" { "Look at it" }
            @if fits(parts) {
                p class="pictures-instead" {
                    "In a browser with scripts and WebGL2 the stack can be turned here; the pictures below show each view."
                }
                @if parts.manifest.ink_bits > 8 {
                    p { "The films are drawn here with 8 of their " (parts.manifest.ink_bits) " bits." }
                }
                div class="stage" hidden {
                    (turntable())
                    (controls(parts))
                    (sights())
                }
            } @else {
                p { "These films are too large to be turned in a page: the pictures below show each view." }
            }
        }
    }
}

/// What moves the viewer; it goes to the end of the page, all of which it looks at.
pub(super) fn scripts(parts: &PageParts<'_>) -> Markup {
    html! {
        @if fits(parts) {
            script type="application/json" id="stack" {
                // The last field is the films' files, which are not copied on their way.
                (PreEscaped(open_stack(parts))) (PreEscaped(",\"pictures\":["))
                @for (film, png) in parts.films.iter().enumerate() {
                    @if film > 0 { "," }
                    (PreEscaped("\"")) (Base64(png)) (PreEscaped("\""))
                }
                "]}"
            }
            @for script in SCRIPTS { script { (PreEscaped(script)) } }
        }
    }
}

fn fits(parts: &PageParts<'_>) -> bool {
    parts.films.iter().map(|film| film.len()).sum::<usize>() <= MOST_BYTES
}

fn turntable() -> Markup {
    html! {
        div class="turntable" {
            canvas tabindex="0" role="application" aria-label="The stack in three dimensions" aria-describedby="turn" {}
            p id="turn" {
                "Drag it, or use the arrow keys, to walk around it. Two fingers, the wheel, + and - change your distance; "
                "Home is the first view."
            }
            p class="told" data-told="stack" {}
        }
    }
}

fn sights() -> Markup {
    html! {
        div class="row sights" {
            @for (name, caption) in [("seen", "What the viewer sees"), ("pattern", "Pattern"), ("error", "Error")] {
                figure {
                    canvas role="img" data-sight=(name) aria-label=(caption) {}
                    figcaption { b { (caption) } " " span data-told=(name) {} }
                }
            }
        }
    }
}

fn controls(parts: &PageParts<'_>) -> Markup {
    let distances = || parts.report.views.iter().filter_map(|view| view.distance_mm);
    let nearest_mm = distances().fold(nearest_mm(parts.exhibit), f64::min);
    let farthest_mm = distances().fold(3000.0, f64::max);
    let farthest_mm = farthest_mm.max(3.0 * nearest_mm);
    let usual_mm = parts.exhibit.viewer.distance_mm.unwrap_or(600.0).max(nearest_mm);
    let angle = f64::from(FARTHEST_DEG);
    html! {
        form class="controls" autocomplete="off" {
            fieldset {
                legend { "Views" }
                @for (index, view) in parts.report.views.iter().enumerate() {
                    button type="button" data-view=(index) aria-pressed="false" { (view.id) }
                }
            }
            fieldset {
                legend { "Viewer" }
                (slider("horizontal", "To the right", [-angle, angle, 0.1], "°", 0.0))
                (slider("vertical", "Above", [-angle, angle, 0.1], "°", 0.0))
                (slider("distance", "Distance", [nearest_mm, farthest_mm, 1.0], " mm", usual_mm))
                (tick("far", "from far away"))
            }
            fieldset {
                legend { "Light" }
                (slider("top", "Top lamp", [0.0, 1.0, 0.001], "", 1.0))
                (slider("bottom", "Bottom lamp", [0.0, 1.0, 0.001], "", 1.0))
                (tick("ideal", "nothing absorbs, all rays parallel"))
            }
            fieldset {
                legend { "Films" }
                (slider("apart", "Apart", [1.0, 12.0, 0.1], " times", 1.0))
                (tick("edges", "show their edges"))
                details {
                    summary { "Each film on and off" }
                    button type="button" data-films="all" { "All" }
                    button type="button" data-films="none" { "None" }
                    div class="films" {
                        @for film in 0..parts.exhibit.stack.films {
                            label { input type="checkbox" name="film" value=(film) checked; " " (film + 1) }
                        }
                    }
                }
            }
        }
    }
}

/// As near as one may come: clear of the stack, by what `view` demands and a little more.
fn nearest_mm(exhibit: &Exhibit) -> f64 {
    (2.0 * exhibit.film_stack().depth_mm()).max(50.0).ceil()
}

fn slider(name: &str, title: &str, [least, most, step]: [f64; 3], unit: &str, value: f64) -> Markup {
    html! {
        label {
            span { (title) " " output for=(name) { (value) (unit) } }
            input type="range" id=(name) name=(name) min=(least) max=(most) step=(step) value=(value) data-unit=(unit);
        }
    }
}

fn tick(name: &str, words: &str) -> Markup {
    html! { label { input type="checkbox" name=(name); " " (words) } }
}

/// What the scripts need to know, as JSON in which nothing can end the element that holds it; its last brace is left out,
/// so that more can follow.
fn open_stack(parts: &PageParts<'_>) -> String {
    let exhibit = parts.exhibit;
    let stack = exhibit.film_stack();
    let views = parts.report.views.iter().map(|view| {
        json!({
            "id": view.id,
            "horizontal": view.horizontal_deg,
            "vertical": view.vertical_deg,
            "distance": view.distance_mm,
            "top": view.emphasis.top,
            "bottom": view.emphasis.bottom,
        })
    });
    let json = json!({
        "films": stack.films,
        "width_px": stack.width_px,
        "height_px": stack.height_px,
        "pitch_mm": stack.film_pitch_mm(),
        "pixel_mm": stack.pixel_mm(),
        "index": stack.index,
        "tau_uv": stack.layer_tau_uv(),
        "tau_visible": stack.layer_tau_visible(),
        "light": exhibit.design.tone == ToneSetting::Linear,
        "drawn_out": exhibit.viewer.frame == FrameSetting::Viewer,
        "angles": angles(exhibit),
        "views": views.collect::<Vec<_>>(),
    });
    let mut open = json.to_string().replace('<', "\\u003c");
    open.pop();
    open
}

/// Tangent and cosine of each angle to which the viewer can be moved, by its degrees: browsers do not agree with this
/// program, nor with each other, on their last bit.
fn angles(exhibit: &Exhibit) -> BTreeMap<String, [f64; 2]> {
    let tenths = (0..=10 * FARTHEST_DEG).map(|tenths| f64::from(tenths) / 10.0);
    let of_views = exhibit.views.iter().flat_map(|view| [view.horizontal_deg.abs(), view.vertical_deg.abs()]);
    let both = |degrees: f64| (degrees.to_string(), [degrees.to_radians().tan(), degrees.to_radians().cos()]);
    tenths.chain(of_views).map(both).collect()
}

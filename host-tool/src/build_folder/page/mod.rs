//! `report.html`: the page to look at, one file that needs no other and asks no network for anything.

mod chart;
mod emphasis;
mod hours;
mod inputs;
mod object;
mod tables;
mod viewer;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, Render, html};
use sha2::{Digest, Sha256};
use vitrine_exhibit::plan::Plan;

use super::manifest::Manifest;
use super::report::{Report, ViewReport};
use crate::config::{Exhibit, LampSetting};

const STYLE: &str = include_str!("page.css");

/// The pictures of one view as PNG files.
pub(super) struct ViewPictures {
    /// The pattern as it was given, where it was adapted.
    pub(super) given: Option<Vec<u8>>,
    pub(super) pattern: Vec<u8>,
    pub(super) shown: Vec<u8>,
    /// How far what is shown is from the pattern, as code values.
    pub(super) error: Vec<u8>,
}

/// What the page of a design tells of.
pub(super) struct PageParts<'a> {
    pub(super) exhibit: &'a Exhibit,
    pub(super) report: &'a Report,
    pub(super) plan: &'a Plan,
    pub(super) pictures: &'a [ViewPictures],
    /// PNG files of 8 bits.
    pub(super) films: &'a [&'a [u8]],
    /// What went in, and all that comes out beside the page itself.
    pub(super) manifest: &'a Manifest,
}

/// Writes the page of a design.
pub(super) fn page(parts: &PageParts<'_>) -> String {
    let report = parts.report;
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(policy());
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (report.name) " - Vitrine" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { (report.name) }
                    p { (stack_in_words(parts.exhibit, report)) }
                    @if let Some(small) = report.in_small { p { strong { (small.in_words()) } } }
                    (key_figures(report))
                }
                main {
                    (viewer::section(parts))
                    section aria-labelledby="views" {
                        h2 id="views" { "Views" }
                        @for (view, pictures) in report.views.iter().zip(parts.pictures) { (view_row(view, pictures)) }
                    }
                    (object::section(report.object.as_ref()))
                    (tables::quality(report))
                    (tables::lamps(report))
                    (emphasis::section(parts.plan))
                    (hours::section(parts.exhibit, parts.plan))
                    (inputs::section(parts.manifest))
                }
                footer { "Designed with Vitrine " (report.vitrine) "." }
                (viewer::scripts(parts))
            }
        }
    };
    markup.into_string()
}

/// What the browser may do for this page: run its own scripts, which are named by their hashes, and show its own
/// pictures; nothing else, and no network at all.
fn policy() -> String {
    let hash = |text: &str| format!("'sha256-{}'", STANDARD.encode(Sha256::digest(text)));
    let scripts: Vec<String> = viewer::SCRIPTS.iter().map(|script| hash(script)).collect();
    format!(
        "default-src 'none'; img-src data:; style-src {}; script-src {}; base-uri 'none'; form-action 'none'",
        hash(STYLE),
        scripts.join(" ")
    )
}

fn stack_in_words(exhibit: &Exhibit, report: &Report) -> String {
    let stack = &exhibit.stack;
    let shown = stack.pixels.map(|pixels| pixels as usize);
    let [width, height] = report.in_small.map_or(shown, |small| small.film_pixels);
    let viewer = match exhibit.viewer.distance_mm {
        Some(distance_mm) => format!("seen from {distance_mm} mm"),
        None => "seen from far away".to_owned(),
    };
    format!(
        "{} films of {width} x {height} pixels, {} mm wide, {:.2} mm apart, {viewer}.",
        stack.films,
        stack.width_mm,
        stack.film_pitch_mm()
    )
}

/// What one wants to know first.
fn key_figures(report: &Report) -> Markup {
    let own = report.mean_under_lamps().1[0];
    html! {
        dl class="figures" {
            div { dt { "Views" } dd { (report.views.len()) } }
            div { dt { "Least view" } dd { (format!("{:.1} dB", report.least_psnr_db)) } }
            div { dt { "Mean" } dd { (format!("{:.1} dB / {:.2}", report.mean_psnr_db, report.mean_ssim)) } }
            div { dt { "Behind the real films" } dd { (format!("{:.1} dB / {:.2}", own.0, own.1)) } }
            @if let Some(built) = &report.as_built {
                div { dt { "In human hands" } dd { (format!("{:.1} dB / {:.2}", built.mean_psnr_db(), built.mean_ssim())) } }
            }
        }
    }
}

fn view_row(view: &ViewReport, pictures: &ViewPictures) -> Markup {
    let mut direction = format!("{}° horizontal, {}° vertical", view.horizontal_deg, view.vertical_deg);
    match view.lamp {
        Some(LampSetting::Top) => direction += ", under the top lamp alone",
        Some(LampSetting::Bottom) => direction += ", under the bottom lamp alone",
        None => {}
    }
    let pattern = match view.similarity_to_given {
        Some(similarity) => format!("Pattern, adapted (SSIM to the given picture {similarity:.2})"),
        None => "Pattern".to_owned(),
    };
    html! {
        article class="view" {
            h3 { (view.id) }
            p { (direction) }
            div class="row" {
                @if let Some(given) = &pictures.given {
                    (figure("Picture as given", &format!("Picture given for view {}", view.id), given, false))
                }
                (figure(&pattern, &format!("Pattern of view {}", view.id), &pictures.pattern, true))
                (figure("What the viewer sees", &format!("What the viewer of {} sees", view.id), &pictures.shown, false))
                (figure("Error", &format!("Where {} differs from its pattern", view.id), &pictures.error, false))
            }
        }
    }
}

fn figure(caption: &str, description: &str, png: &[u8], is_pattern: bool) -> Markup {
    html! {
        figure {
            img src={ "data:image/png;base64," (Base64(png)) } alt=(description) data-pattern[is_pattern];
            figcaption { (caption) }
        }
    }
}

/// A file within the page, which is written where it belongs without a copy of it beside.
struct Base64<'a>(&'a [u8]);

impl Render for Base64<'_> {
    fn render_to(&self, page: &mut String) {
        STANDARD.encode_string(self.0, page);
    }
}

#[cfg(test)]
mod tests;

//! `report.html`: the page to look at, one file that needs no other.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::report::{Report, ViewReport};
use super::viewer::viewer;
use crate::config::{Exhibit, LampSetting};
use crate::design::AsBuilt;

const STYLE: &str = include_str!("page.css");

/// The pictures of one view as PNG files.
pub(super) struct ViewPictures {
    /// The pattern as it was given, where it was adapted.
    pub(super) given: Option<Vec<u8>>,
    pub(super) pattern: Vec<u8>,
    pub(super) shown: Vec<u8>,
}

/// Writes the page of a design.
/// `films` are PNG files of 8 bits.
pub(super) fn page(
    exhibit: &Exhibit,
    report: &Report,
    pictures: &[ViewPictures],
    films: &[Vec<u8>],
) -> String {
    let markup = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (report.name) " - Vitrine" }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main {
                    h1 { (report.name) }
                    p { (stack_in_words(exhibit)) }
                    (viewer(exhibit, report, films))
                    h2 { "Views" }
                    div class="views" {
                        @for (view, pictures) in report.views.iter().zip(pictures) { (view_section(view, pictures)) }
                    }
                    h2 { "Quality" }
                    (figures_table(report))
                    h2 { "Lamps" }
                    (lamp_table(report))
                    (shared_table(report))
                    @if let Some(built) = &report.as_built { (as_built_table(report, built)) }
                    @if let Some(words) = report.hold_in_words() { p { (words) } }
                }
                footer { "Designed with Vitrine " (report.vitrine) "." }
            }
        }
    };
    markup.into_string()
}

fn stack_in_words(exhibit: &Exhibit) -> String {
    let stack = &exhibit.stack;
    let [width, height] = stack.pixels;
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

fn view_section(view: &ViewReport, pictures: &ViewPictures) -> Markup {
    let mut direction = format!("{}° horizontal, {}° vertical", view.horizontal_deg, view.vertical_deg);
    match view.lamp {
        Some(LampSetting::Top) => direction += ", under the top lamp alone",
        Some(LampSetting::Bottom) => direction += ", under the bottom lamp alone",
        None => {}
    }
    html! {
        section {
            h3 { (view.id) }
            p { (direction) }
            @if let Some(given) = &pictures.given {
                figure {
                    img src=(data_uri(given)) alt={ "Picture given for view " (view.id) };
                    figcaption { "Picture as given" }
                }
            }
            figure {
                img src=(data_uri(&pictures.pattern)) alt={ "Pattern of view " (view.id) };
                figcaption {
                    @match view.similarity_to_given {
                        Some(similarity) => { "Pattern, adapted (SSIM to the given picture " (format!("{similarity:.2}")) ")" }
                        None => { "Pattern" }
                    }
                }
            }
            figure {
                img src=(data_uri(&pictures.shown)) alt={ "What the viewer of " (view.id) " sees" };
                figcaption { "What the viewer sees" }
            }
        }
    }
}

/// A table with its caption, the heads of its columns and its rows.
fn table(caption: &str, columns: &[&str], rows: Markup) -> Markup {
    html! {
        div class="wide" { table {
            caption { (caption) }
            thead { tr {
                @for column in columns {
                    th scope="col" { (column) }
                }
            } }
            tbody { (rows) }
        } }
    }
}

fn figures_table(report: &Report) -> Markup {
    html! {
        (table("Of each view in the optics of the design, against its pattern", &["View", "PSNR", "SSIM", "Brightness", "Contrast", "Cross-talk"], html! {
            @for view in &report.views {
                tr {
                    th scope="row" { (view.id) }
                    td { (format!("{:.1} dB", view.quality.psnr_db)) }
                    td { (format!("{:.3}", view.quality.ssim)) }
                    td { (format!("{:.0} %", 100.0 * view.quality.efficiency)) }
                    td { (format!("{:.1}", view.quality.contrast)) }
                    td { (format!("{:+.2}", view.quality.cross_talk)) }
                }
            }
            tr {
                th scope="row" { "Mean" }
                td { (format!("{:.1} dB", report.mean_psnr_db)) }
                td { (format!("{:.3}", report.mean_ssim)) }
                td colspan="3" {}
            }
            tr {
                th scope="row" { "Least" }
                td { (format!("{:.1} dB", report.least_psnr_db)) }
                td { (format!("{:.3}", report.least_ssim)) }
                td colspan="3" {}
            }
        }))
    }
}

fn lamp_table(report: &Report) -> Markup {
    let level = |level: f64| format!("{:.0} %", 100.0 * level);
    html! {
        (table("The lamp pair that shows each view at its best, and the quality behind the real films", &["View", "Top", "Bottom", "Under its own pair", "Under the neutral pair", "Both lamps full"], html! {
            @for view in &report.views {
                tr {
                    th scope="row" { (view.id) }
                    td { (level(view.emphasis.top)) }
                    td { (level(view.emphasis.bottom)) }
                    @for figures in [view.under_own_lamps, view.under_neutral_lamps, view.under_full_lamps] {
                        td { (format!("{:.1} dB / {:.2}", figures.psnr_db, figures.ssim)) }
                    }
                }
            }
            tr {
                th scope="row" { "Mean" }
                td colspan="2" {}
                @for (psnr_db, ssim) in report.mean_under_lamps().1 {
                    td { (format!("{psnr_db:.1} dB / {ssim:.2}")) }
                }
            }
            tr {
                th scope="row" { "Neutral" }
                td { (level(report.neutral.top)) }
                td { (level(report.neutral.bottom)) }
                td colspan="3" {}
            }
        }))
    }
}

fn shared_table(report: &Report) -> Markup {
    html! {
        @if !report.shared.is_empty() {
            (table("For two viewers at once: the pair that is best for both views", &["Views", "Top", "Bottom"], html! {
                @for shared in &report.shared {
                    tr {
                        th scope="row" { (shared.views[0]) " and " (shared.views[1]) }
                        td { (format!("{:.0} %", 100.0 * shared.pair.top)) }
                        td { (format!("{:.0} %", 100.0 * shared.pair.bottom)) }
                    }
                }
            }))
        }
    }
}

fn as_built_table(report: &Report, built: &AsBuilt) -> Markup {
    let errors = &built.errors;
    html! {
        h2 { "In human hands" }
        p {
            (built.stacks) " random stacks. Standard deviations: films " (errors.misplacement_um)
            " µm beside their places, gaps " (errors.spacing_um) " µm, viewers " (errors.direction_deg)
            "° astray and " (format!("{:.0}", 100.0 * errors.distance_part)) " % nearer or further."
        }
        (table("Of each view under its own lamps behind the real films", &["View", "Mean of all stacks", "Worst stack"], html! {
            @for (view, of) in report.views.iter().zip(&built.views) {
                tr {
                    th scope="row" { (view.id) }
                    td { (format!("{:.1} dB / {:.2}", of.mean_psnr_db, of.mean_ssim)) }
                    td { (format!("{:.1} dB / {:.2}", of.worst_psnr_db, of.worst_ssim)) }
                }
            }
            tr {
                th scope="row" { "All" }
                td { (format!("{:.1} dB / {:.2}", built.mean_psnr_db(), built.mean_ssim())) }
                td { (format!("{:.1} dB / {:.2}", built.worst_psnr_db(), built.worst_ssim())) }
            }
        }))
    }
}

fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

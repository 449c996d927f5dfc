//! The tables of `report.html`: quality, lamps, and what human hands make of it.

use maud::{Markup, html};

use super::super::report::Report;
use crate::design::AsBuilt;

/// Pairs for two viewers that are shown without being asked for.
const MOST_PAIRS: usize = 15;

/// Quality of each view in the optics of the design.
pub(super) fn quality(report: &Report) -> Markup {
    html! {
        section aria-labelledby="quality" {
            h2 id="quality" { "Quality" }
            (figures_table(report))
        }
    }
}

/// Lamp pairs, what they are worth, and what human hands make of the design.
pub(super) fn lamps(report: &Report) -> Markup {
    html! {
        section aria-labelledby="lamps" {
            h2 id="lamps" { "Lamps" }
            (lamp_table(report))
            (shared_table(report))
            @if let Some(words) = report.hold_in_words() { p { (words) } }
        }
        section aria-labelledby="built" {
            h2 id="built" { "In human hands" }
            @match &report.as_built {
                Some(built) => { (as_built_table(report, built)) }
                None => { p { "This was not looked at." } }
            }
        }
    }
}

/// A table with its caption, the heads of its columns and its rows; where it is too wide it is scrolled.
pub(super) fn table(caption: &str, columns: &[&str], rows: Markup) -> Markup {
    html! {
        div class="wide" tabindex="0" role="region" aria-label=(caption) { table {
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
    let pairs = report.shared.len();
    html! {
        @if pairs > MOST_PAIRS {
            details { summary { "The " (pairs) " pairs for two viewers at once" } (pair_table(report)) }
        } @else if pairs > 0 {
            (pair_table(report))
        }
    }
}

fn pair_table(report: &Report) -> Markup {
    let columns = ["Views", "Top", "Bottom"];
    table(
        "For two viewers at once: the pair that is best for both views",
        &columns,
        html! {
            @for shared in &report.shared {
                tr {
                    th scope="row" { (shared.views[0]) " and " (shared.views[1]) }
                    td { (format!("{:.0} %", 100.0 * shared.pair.top)) }
                    td { (format!("{:.0} %", 100.0 * shared.pair.bottom)) }
                }
            }
        },
    )
}

fn as_built_table(report: &Report, built: &AsBuilt) -> Markup {
    let errors = &built.errors;
    html! {
        p {
            (built.stacks) " random stacks. Standard deviations: films " (errors.misplacement_um)
            " µm beside their places, gaps " (errors.spacing_um) " µm, viewers " (errors.direction_deg)
            "° astray and " (format!("{:.0}", 100.0 * errors.distance_part)) " % nearer or further. The spread is a standard deviation."
        }
        (table("Of each view under its own lamps behind the real films", &["View", "Mean of all stacks", "Spread", "Worst stack"], html! {
            @for (view, of) in report.views.iter().zip(&built.views) {
                tr {
                    th scope="row" { (view.id) }
                    td { (format!("{:.1} dB / {:.2}", of.mean_psnr_db, of.mean_ssim)) }
                    td { (format!("{:.2} dB", of.spread_psnr_db)) }
                    td { (format!("{:.1} dB / {:.2}", of.worst_psnr_db, of.worst_ssim)) }
                }
            }
            tr {
                th scope="row" { "All" }
                td { (format!("{:.1} dB / {:.2}", built.mean_psnr_db(), built.mean_ssim())) }
                td {}
                td { (format!("{:.1} dB / {:.2}", built.worst_psnr_db(), built.worst_ssim())) }
            }
        }))
    }
}

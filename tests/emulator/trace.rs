//! What a run looks like: a waveform file (VCD) of the pins, and a picture (SVG) of the exhibit over time.
//!
//! Written where the environment variable `VITRINE_TRACE` names a folder; `bench.sh --trace` does so.

use std::fmt::Write as _;
use std::path::PathBuf;

use crate::bench::{LAMP_BOTTOM, LAMP_ENABLE, LAMP_TOP, SECOND};
use crate::exhibit::VIEWS;
use crate::signals::Edge;

/// One moment of a run, for the picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    pub(crate) at: u64,
    /// Where somebody stands.
    pub(crate) person_deg: Option<f64>,
    /// Where the board believes that somebody stands.
    pub(crate) bearing_deg: Option<f64>,
    /// The index in the plan of the view that is shown.
    pub(crate) view: Option<u8>,
    /// Duty at the pins, 0 to 1.
    pub(crate) top: f64,
    pub(crate) bottom: f64,
    /// Temperature of the top lamp's board.
    pub(crate) celsius: f64,
    /// Dose of the top lamp in the day, J/m².
    pub(crate) dose: f64,
}

/// The folder for traces, if one is wanted.
pub(crate) fn folder() -> Option<PathBuf> {
    let folder = PathBuf::from(std::env::var_os("VITRINE_TRACE")?);
    std::fs::create_dir_all(&folder).expect("the trace's folder");
    Some(folder)
}

/// The pins' edges as a value change dump, which any waveform viewer opens.
pub(crate) fn waveform(edges: &[Edge]) -> String {
    let wires = [
        (LAMP_TOP, '!', "lamp_top_dim"),
        (LAMP_BOTTOM, '"', "lamp_bottom_dim"),
        (LAMP_ENABLE, '#', "lamp_enable"),
    ];
    let mut text = String::from("$timescale 1 ns $end\n$scope module vitrine $end\n");
    for (_, mark, name) in wires {
        let _ = writeln!(text, "$var wire 1 {mark} {name} $end");
    }
    text.push_str("$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n0!\n0\"\n0#\n$end\n");
    let mut last = None;
    for edge in edges {
        let Some((_, mark, _)) = wires.iter().find(|(pin, ..)| *pin == edge.pin) else { continue };
        if last != Some(edge.at) {
            let _ = writeln!(text, "#{}", edge.at);
            last = Some(edge.at);
        }
        let _ = writeln!(text, "{}{mark}", u8::from(edge.high));
    }
    text
}

const WIDTH: f64 = 1000.0;
const PANEL: f64 = 130.0;
const MARGIN: f64 = 60.0;

/// A panel of the picture: its title, its range, and its lines with their colours.
type Panel<'a> = (&'a str, f64, f64, Vec<(&'a str, &'a dyn Fn(&Moment) -> Option<f64>)>);

/// A picture of a run: bearing, view, levels, temperature and dose over time.
pub(crate) fn picture(run: &[Moment]) -> String {
    let most = |value: &dyn Fn(&Moment) -> f64| run.iter().map(value).fold(1.0, f64::max);
    let names: Vec<String> =
        VIEWS.iter().zip(1..).map(|((name, ..), number)| format!("{number} {name}")).collect();
    let views = format!("view that is shown: {}", names.join(", "));
    let panels: [Panel<'_>; 5] = [
        (
            "bearing in degrees: where somebody stands (grey), what the board sees (blue)",
            -50.0,
            50.0,
            vec![("#999", &|moment| moment.person_deg), ("#06c", &|moment| moment.bearing_deg)],
        ),
        (
            &views,
            0.0,
            VIEWS.len() as f64 + 1.0,
            vec![("#06c", &|moment| Some(f64::from(moment.view?) + 1.0))],
        ),
        (
            "duty at the pins: top (violet), bottom (orange)",
            0.0,
            1.0,
            vec![("#90c", &|moment| Some(moment.top)), ("#e70", &|moment| Some(moment.bottom))],
        ),
        (
            "top lamp board in degrees Celsius",
            20.0,
            most(&|moment| moment.celsius) + 5.0,
            vec![("#c22", &|moment| Some(moment.celsius))],
        ),
        (
            "dose of the top lamp in J/m2",
            0.0,
            most(&|moment| moment.dose),
            vec![("#363", &|moment| Some(moment.dose))],
        ),
    ];
    let end = run.last().map_or(1.0, |moment| moment.at as f64);
    let begin = run.first().map_or(0.0, |moment| moment.at as f64);
    let height = MARGIN + panels.len() as f64 * (PANEL + 30.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        WIDTH + 2.0 * MARGIN
    );
    for (index, (title, low, high, lines)) in panels.iter().enumerate() {
        let top = 30.0 + index as f64 * (PANEL + 30.0);
        let _ = writeln!(svg, "<text x=\"{MARGIN}\" y=\"{}\">{title}</text>", top - 6.0);
        let _ = writeln!(
            svg,
            "<rect x=\"{MARGIN}\" y=\"{top}\" width=\"{WIDTH}\" height=\"{PANEL}\" fill=\"none\" stroke=\"#ccc\"/>"
        );
        for (value, y) in [(high, top + 10.0), (low, top + PANEL)] {
            let _ = writeln!(svg, "<text x=\"5\" y=\"{y}\">{value:.0}</text>");
        }
        for (colour, value) in lines {
            let place = |moment: &Moment| {
                let y = top + PANEL * (1.0 - (value(moment)?.clamp(*low, *high) - low) / (high - low));
                Some((MARGIN + WIDTH * (moment.at as f64 - begin) / (end - begin).max(1.0), y))
            };
            // A gap where there is nothing to show.
            for part in run.split(|moment| value(moment).is_none()).filter(|part| part.len() > 1) {
                let points: String =
                    part.iter().filter_map(place).map(|(x, y)| format!("{x:.1},{y:.1} ")).collect();
                let _ = writeln!(
                    svg,
                    "<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.5\" points=\"{points}\"/>"
                );
            }
        }
    }
    let seconds = ((end - begin) / SECOND as f64).floor() as u32;
    for second in (0..=seconds).step_by(10) {
        let x = MARGIN + WIDTH * f64::from(second) * SECOND as f64 / (end - begin).max(1.0);
        let _ = writeln!(
            svg,
            "<text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{second} s</text>",
            height - 35.0
        );
    }
    svg.push_str("</svg>\n");
    svg
}

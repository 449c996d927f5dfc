//! The frontier of an exhibit as a drawing.

use std::path::Path;

use plotters::prelude::*;
use thiserror::Error;
use vitrine::build_folder::{try_file, write_file};
use vitrine::design::FrontierPoint;

/// Width and height of the drawing.
const SIZE: (u32, u32) = (1000, 440);
/// Contrast beyond this is drawn at the edge: the eye hardly tells it apart.
const MOST_CONTRAST: f64 = 100.0;

/// Why a frontier cannot be drawn.
#[derive(Debug, Error, miette::Diagnostic)]
pub(super) enum FrontierFailure {
    #[error("cannot draw the frontier: {0}")]
    #[diagnostic(
        code("vitrine::frontier::draw"),
        help("this is a fault of vitrine: please report it with the exhibit.toml")
    )]
    Draw(String),
    #[error("cannot write {path}: {source}")]
    #[diagnostic(
        code("vitrine::frontier::write"),
        help("check that the folder is there, may be written and has room")
    )]
    Write { path: String, source: std::io::Error },
    #[error("{0} is where the points go as JSON")]
    #[diagnostic(code("vitrine::frontier::name"), help("give the drawing a name that ends in .svg"))]
    Name(String),
}

/// Tries whether the drawing at `path` and the points beside it can be written, before they are computed.
pub(super) fn try_place(path: &Path) -> Result<(), FrontierFailure> {
    let points = path.with_extension("json");
    if points == path {
        return Err(FrontierFailure::Name(path.display().to_string()));
    }
    for path in [path, &points] {
        try_file(path)
            .map_err(|source| FrontierFailure::Write { path: path.display().to_string(), source })?;
    }
    Ok(())
}

/// Draws quality against brightness and against contrast into the SVG file at `path`, and writes the points
/// as JSON beside it.
pub(super) fn draw(points: &[FrontierPoint], path: &Path) -> Result<(), FrontierFailure> {
    let mut svg = String::new();
    plot(points, &mut svg).map_err(|error| FrontierFailure::Draw(error.to_string()))?;
    let json =
        serde_json::to_string_pretty(points).map_err(|error| FrontierFailure::Draw(error.to_string()))?;
    for (path, bytes) in [(path.to_owned(), svg.as_bytes()), (path.with_extension("json"), json.as_bytes())] {
        write_file(&path, bytes)
            .map_err(|source| FrontierFailure::Write { path: path.display().to_string(), source })?;
    }
    Ok(())
}

fn plot(points: &[FrontierPoint], svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let (left, right) = area.split_horizontally(SIZE.0 / 2);
    panel(&left, points, "Brightness (part of full ink)", |point| point.efficiency)?;
    panel(&right, points, "Contrast (up to 100)", |point| point.contrast.min(MOST_CONTRAST))?;
    area.present()?;
    Ok(())
}

/// Draws the quality over one measure, a curve for each pedestal.
fn panel(
    area: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    points: &[FrontierPoint],
    label: &str,
    across: fn(&FrontierPoint) -> f64,
) -> Result<(), Box<dyn std::error::Error>> {
    let most = points.iter().map(across).fold(0.0, f64::max) * 1.05;
    let qualities = || points.iter().map(|point| point.psnr_db);
    let (low, high) = (qualities().fold(f64::INFINITY, f64::min), qualities().fold(0.0, f64::max));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .x_label_area_size(44)
        .y_label_area_size(52)
        .build_cartesian_2d(0.0..most.max(1e-3), low.floor() - 1.0..high.ceil() + 1.0)?;
    chart.configure_mesh().x_desc(label).y_desc("Mean PSNR, dB").light_line_style(WHITE).draw()?;
    for (index, curve) in points.chunk_by(|a, b| a.pedestal == b.pedestal).enumerate() {
        let colour = Palette99::pick(index).to_rgba();
        let places: Vec<(f64, f64)> = curve.iter().map(|point| (across(point), point.psnr_db)).collect();
        let pedestal = curve.first().map_or(0.0, |point| 100.0 * point.pedestal);
        chart
            .draw_series(LineSeries::new(places.iter().copied(), colour.stroke_width(2)))?
            .label(format!("pedestal {pedestal:.0} %"))
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        chart.draw_series(places.iter().map(|&place| Circle::new(place, 4, colour.filled())))?;
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK.mix(0.3)).draw()?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frontier_becomes_a_drawing_and_its_points() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("frontier.svg");
        let points: Vec<FrontierPoint> = [(0.1, 0.0, 20.0), (0.4, 0.0, 18.0), (0.1, 0.4, 24.0)]
            .map(|(brightness, pedestal, psnr_db)| FrontierPoint {
                brightness,
                pedestal,
                psnr_db,
                least_psnr_db: psnr_db,
                ssim: 0.8,
                efficiency: brightness,
                contrast: 30.0,
            })
            .to_vec();
        draw(&points, &path).unwrap();
        let svg = std::fs::read_to_string(&path).unwrap();
        assert!(
            svg.starts_with("<svg") && svg.contains("pedestal 40 %") && svg.contains("<polyline"),
            "{svg}"
        );
        let json: serde_json::Value =
            serde_json::from_slice(&std::fs::read(path.with_extension("json")).unwrap()).unwrap();
        assert_eq!(json[1]["psnr_db"], 18.0);
    }
}

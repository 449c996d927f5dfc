//! The contact sheet: patterns above, what the viewer sees below, and what a walk past the stack looks like.

use embedded_graphics::mono_font::MonoFont;
use embedded_graphics::mono_font::iso_8859_1::{FONT_7X13, FONT_9X18_BOLD, FONT_10X20};
use image::{ImageBuffer, RgbImage};

use super::walk::Moment;
use crate::build_folder::{BuildFolder, LookRequest, OpenError, Report, look};
use crate::canvas::Canvas;
use crate::config::{Exhibit, ToneSetting, ViewSettings};
use crate::optics::{Direction, LampPair};
use crate::picture::Picture;
use crate::volume::Volume;

/// Width of a view's picture.
const TILE: u32 = 320;
const GAP: u32 = 16;
const LINE: u32 = 26;
/// Pictures of the walk at most.
const FRAMES: usize = 7;

/// Draws the contact sheet of `build`, whose figures are in `report`, with moments of a walk below.
///
/// # Errors
/// Fails when a picture or a film of the build cannot be read.
pub fn contact_sheet(build: &BuildFolder, report: &Report, walk: &[Moment]) -> Result<RgbImage, OpenError> {
    let exhibit = &build.manifest().exhibit;
    let views = from_left_to_right(exhibit);
    let frames = spread(walk, FRAMES);
    let layout = Layout::new(exhibit, views.len(), frames.len());
    let mut canvas = Canvas::new(layout.width, layout.height);
    canvas.caption(&exhibit.name, layout.width / 2, GAP, &FONT_10X20);
    for (column, view) in views.iter().enumerate() {
        let figures = report.views.iter().find(|figures| figures.id == view.id);
        let left = layout.column(column);
        let middle = left + TILE / 2;
        let place = |canvas: &mut Canvas, file: &str, top: u32| -> Result<(), OpenError> {
            canvas.picture(&build.picture(file)?, [left, top], [TILE, layout.tile_height]);
            Ok(())
        };
        place(&mut canvas, &format!("views/{}.target.png", view.id), layout.patterns)?;
        place(&mut canvas, &format!("views/{}.png", view.id), layout.seen)?;
        let below_pattern = layout.patterns + layout.tile_height + 4;
        canvas.caption(&format!("{}: pattern", view.id), middle, below_pattern, &FONT_9X18_BOLD);
        let below_seen = layout.seen + layout.tile_height + 4;
        canvas.caption(&format!("seen from {}", direction(view)), middle, below_seen, &FONT_9X18_BOLD);
        if let Some(figures) = figures {
            let text = format!(
                "{:.1} dB  SSIM {:.2}  top {:.0} %  bottom {:.0} %",
                figures.quality.psnr_db,
                figures.quality.ssim,
                100.0 * figures.emphasis.top,
                100.0 * figures.emphasis.bottom
            );
            canvas.caption(&text, middle, below_seen + LINE - 6, &FONT_7X13);
        }
    }
    if !frames.is_empty() {
        draw_walk(&mut canvas, &layout, exhibit, &build.films()?.volume, &frames);
    }
    Ok(canvas.into_image())
}

/// Where everything is on the sheet.
struct Layout {
    width: u32,
    height: u32,
    tile_height: u32,
    patterns: u32,
    seen: u32,
    walk: u32,
    frame: [u32; 2],
    margin: u32,
}

impl Layout {
    fn new(exhibit: &Exhibit, columns: usize, frames: usize) -> Self {
        let [width_px, height_px] = exhibit.stack.pixels;
        let scaled = |width: u32| (width * height_px / width_px).max(1);
        let columns = columns.max(1) as u32;
        let inner = (columns * TILE + (columns - 1) * GAP).max(2 * TILE);
        let tile_height = scaled(TILE);
        let patterns = GAP + LINE + GAP / 2;
        let seen = patterns + tile_height + LINE + GAP / 2;
        let walk = seen + tile_height + 2 * LINE + GAP;
        let frame_width = match frames as u32 {
            0 => 0,
            frames => (inner - (frames - 1) * GAP / 2) / frames,
        };
        let height = if frames == 0 { walk } else { walk + LINE + scaled(frame_width) + 2 * LINE + GAP };
        let margin = GAP + (inner - (columns * TILE + (columns - 1) * GAP)) / 2;
        Self {
            width: inner + 2 * GAP,
            height,
            tile_height,
            patterns,
            seen,
            walk,
            frame: [frame_width, scaled(frame_width.max(1))],
            margin,
        }
    }

    fn column(&self, column: usize) -> u32 {
        self.margin + column as u32 * (TILE + GAP)
    }
}

fn draw_walk(canvas: &mut Canvas, layout: &Layout, exhibit: &Exhibit, volume: &Volume, frames: &[&Moment]) {
    let font: &MonoFont<'_> = &FONT_7X13;
    let title = "A viewer walks from left to right, and the lamps follow";
    canvas.caption(title, layout.width / 2, layout.walk, &FONT_9X18_BOLD);
    for (index, moment) in frames.iter().enumerate() {
        let left = GAP + index as u32 * (layout.frame[0] + GAP / 2);
        let top = layout.walk + LINE;
        let mut request = LookRequest::new(exhibit, Direction::new(moment.viewer_deg, 0.0));
        request.lamps = LampPair::new(moment.top, moment.bottom);
        let seen = look(exhibit, volume, &request).picture;
        let seen = if exhibit.design.tone == ToneSetting::Linear { seen.encoded() } else { seen };
        canvas.picture(&to_image(&seen), [left, top], layout.frame);
        let middle = left + layout.frame[0] / 2;
        let below = top + layout.frame[1] + 4;
        let shown = moment.view.as_deref().unwrap_or("neutral pair");
        let angle = match moment.viewer_deg.round() {
            0.0 => "0".to_owned(),
            angle => format!("{angle:+.0}"),
        };
        canvas.caption(&format!("{angle}\u{b0} {shown}"), middle, below, font);
        let lamps = format!("{:.0} % / {:.0} %", 100.0 * moment.top, 100.0 * moment.bottom);
        canvas.caption(&lamps, middle, below + 15, font);
    }
}

/// The views as a viewer meets them who walks from left to right.
fn from_left_to_right(exhibit: &Exhibit) -> Vec<&ViewSettings> {
    let mut views: Vec<&ViewSettings> = exhibit.views.iter().collect();
    views.sort_by(|a, b| {
        a.horizontal_deg.total_cmp(&b.horizontal_deg).then(b.vertical_deg.total_cmp(&a.vertical_deg))
    });
    views
}

/// At most `count` of the moments, evenly spread, the first and the last among them.
fn spread(moments: &[Moment], count: usize) -> Vec<&Moment> {
    let count = count.min(moments.len());
    (0..count).filter_map(|index| moments.get(index * (moments.len() - 1) / (count - 1).max(1))).collect()
}

fn direction(view: &ViewSettings) -> String {
    let side = |degrees: f64, positive: &str, negative: &str| match degrees {
        0.0 => None,
        degrees => {
            Some(format!("{:.0}\u{b0} {}", degrees.abs(), if degrees > 0.0 { positive } else { negative }))
        }
    };
    let sides: Vec<String> =
        [side(view.horizontal_deg, "right", "left"), side(view.vertical_deg, "above", "below")]
            .into_iter()
            .flatten()
            .collect();
    if sides.is_empty() { "the front".to_owned() } else { sides.join(", ") }
}

fn to_image(picture: &Picture) -> RgbImage {
    let (width, height) = (picture.width() as u32, picture.height() as u32);
    ImageBuffer::from_raw(width, height, picture.rgb8()).unwrap_or_else(|| RgbImage::new(width, height))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_spread_from_the_first_to_the_last() {
        let moments: Vec<Moment> =
            (0..19).map(|index| Moment { viewer_deg: f64::from(index), ..Moment::default() }).collect();
        let degrees =
            |count| spread(&moments, count).iter().map(|moment| moment.viewer_deg).collect::<Vec<_>>();
        assert_eq!(degrees(7), [0.0, 3.0, 6.0, 9.0, 12.0, 15.0, 18.0]);
        assert_eq!(degrees(1), [0.0]);
        assert_eq!(degrees(40).len(), 19);
        assert!(spread(&[], 7).is_empty());
    }
}

//! From an exhibit to what the design engine is asked.

use std::ops::Range;
use std::path::Path;

use vitrine_exhibit::units::Lamp;

use super::exhibit::{
    Exhibit, FrameSetting, LampSetting, MethodSetting, OpticsSetting, ToneSetting, ViewSettings,
};
use crate::design::{
    DesignRequest, DesignSettings, Method, OpticsModel, PictureRows, Stop, StripRequest, Tone, ViewRequest,
    lifted, rows_within,
};
use crate::object::{Shown, Sight};
use crate::optics::Direction;
use crate::picture::{Fitted, Picture, PictureError};
use crate::projection::ViewerDistance;
use crate::stack::Stack;
use crate::volume::InkDepth;

impl Exhibit {
    /// The stack, in the engine's terms.
    pub fn film_stack(&self) -> Stack {
        let stack = &self.stack;
        Stack {
            films: stack.films as usize,
            width_px: stack.pixels[0] as usize,
            height_px: stack.pixels[1] as usize,
            width_mm: stack.width_mm,
            film_mm: stack.film_mm,
            spacer_mm: stack.spacer_mm,
            index: stack.index,
            tau_uv: stack.tau_uv,
            tau_visible: stack.tau_visible,
            spacer_tau_uv: stack.spacer_tau_uv,
            spacer_tau_visible: stack.spacer_tau_visible,
            strip: None,
            blur_um: stack.blur_um,
            ink_yields: stack.ink_yields,
            ink_absorbance: stack.ink_absorbance,
        }
    }

    /// The viewer's distance, in the engine's terms.
    pub fn viewer_distance(&self) -> ViewerDistance {
        distance(self.viewer.distance_mm)
    }

    /// In which values light adds up, in the engine's terms.
    pub fn tone(&self) -> Tone {
        match self.design.tone {
            ToneSetting::Linear => Tone::Linear,
            ToneSetting::Code => Tone::Code,
        }
    }

    /// Whether an object is shown without any picture around it.
    pub fn is_object_alone(&self) -> bool {
        self.object.is_some() && self.views.iter().all(|view| view.pattern.is_none())
    }

    /// From where the views look at the stack.
    pub fn sights(&self) -> Vec<Sight> {
        let sight = |view: &ViewSettings| Sight {
            direction: Direction::new(view.horizontal_deg, view.vertical_deg),
            distance: distance(view.distance_mm),
        };
        self.views.iter().map(sight).collect()
    }

    /// Reads the patterns, relative to `folder`, and asks for a design whose inks have `ink_depth`. Where an `object`
    /// stands in the stack, the patterns show it, alone or before the pictures.
    ///
    /// # Errors
    /// Fails when a pattern cannot be read whole.
    pub fn design_request(
        &self,
        folder: &Path,
        ink_depth: InkDepth,
        object: Option<&Shown>,
    ) -> Result<DesignRequest, PictureError> {
        let stack = self.film_stack();
        let views = self
            .views
            .iter()
            .map(|view| {
                let direction = Direction::new(view.horizontal_deg, view.vertical_deg);
                let read = |path: &Path| {
                    let picture = Picture::read_fitted(&folder.join(path), stack.width_px, stack.height_px)?;
                    Ok::<_, PictureError>(self.on_the_film(picture, direction))
                };
                let mask = view.mask.as_deref().map(read).transpose()?;
                let picture = match &view.pattern {
                    Some(pattern) => lifted(&read(pattern)?, self.design.pedestal, self.tone()),
                    None => Picture::new(stack.width_px, stack.height_px),
                };
                let eye = distance(view.distance_mm);
                Ok(ViewRequest {
                    id: view.id.clone(),
                    pattern: match object {
                        None => picture,
                        Some(object) if self.is_object_alone() => object.alone(direction, eye),
                        Some(object) => object.before(&picture, direction, eye),
                    },
                    direction,
                    weight: view.weight,
                    distance: Some(eye),
                    mask: mask.map(|mask| grey(&mask)),
                    lamp: view.lamp.map(|lamp| match lamp {
                        LampSetting::Top => Lamp::Top,
                        LampSetting::Bottom => Lamp::Bottom,
                    }),
                })
            })
            .collect::<Result<_, PictureError>>()?;
        Ok(DesignRequest {
            stack,
            distance: self.viewer_distance(),
            views,
            settings: self.settings(ink_depth),
            stop: Stop::default(),
        })
    }

    /// Asks for a design by strips of an exhibit without an object within `memory_mib`, and for the same in small with films of at most `small_px` pixels
    /// along their longer side; `None` where even one row takes more memory.
    ///
    /// # Errors
    /// Fails when a pattern cannot be read whole.
    pub fn strip_request(
        &self,
        folder: &Path,
        ink_depth: InkDepth,
        small_px: u32,
        memory_mib: f64,
    ) -> Result<Option<StripRequest>, PictureError> {
        let stack = self.film_stack();
        let rows = |path: &Path, pedestal: f64| {
            let picture = Picture::read_rows(&folder.join(path), stack.width_px, stack.height_px)?;
            let tone = self.tone();
            Ok::<_, PictureError>(Box::new(FittedRows { picture, pedestal, tone }) as Box<dyn PictureRows>)
        };
        let mut patterns = Vec::new();
        let mut masks = Vec::new();
        let mut held_mib = 0.0;
        for view in &self.views {
            let pattern = view.pattern.as_deref();
            patterns.extend(pattern.map(|pattern| rows(pattern, self.design.pedestal)).transpose()?);
            masks.push(view.mask.as_deref().map(|mask| rows(mask, 0.0)).transpose()?);
        }
        for picture in patterns.iter().chain(masks.iter().flatten()) {
            held_mib += picture.held_bytes() as f64 / f64::from(1 << 20);
        }
        let small = self.in_small(small_px).design_request(folder, ink_depth, None)?;
        let rows = rows_within(&stack, &small, memory_mib - held_mib);
        Ok(rows.map(|rows| StripRequest { small, stack, patterns, masks, rows }))
    }

    /// The same exhibit with at most `longer_px` pixels along its films' longer side.
    pub fn in_small(&self, longer_px: u32) -> Self {
        let [width, height] = self.stack.pixels;
        let longer = width.max(height);
        let less = |pixels: u32| {
            let small = f64::from(pixels) * f64::from(longer_px.min(longer)) / f64::from(longer);
            small.round().max(8.0) as u32
        };
        let mut small = self.clone();
        small.stack.pixels = [less(width), less(height)];
        small
    }

    /// Whether a volume of all films is larger than any that is held in memory.
    pub fn is_too_large_for_memory(&self) -> bool {
        self.film_stack().is_too_large_for_memory()
    }

    /// The exhibit, in small where its films are too large for memory.
    pub fn in_memory(&self) -> Self {
        const PREVIEW_PX: u32 = 512;
        if self.is_too_large_for_memory() { self.in_small(PREVIEW_PX) } else { self.clone() }
    }

    /// How the volume is computed, in the engine's terms.
    pub fn method(&self) -> Method {
        match self.design.method {
            MethodSetting::LeastSquares => Method::LeastSquares,
            MethodSetting::Product => Method::Product,
        }
    }

    /// A pattern as it has to stand on the film. An oblique viewer sees the film narrower by the cosine of the angle:
    /// in the viewer's frame the pattern's middle part is drawn out by as much.
    fn on_the_film(&self, pattern: Picture, direction: Direction) -> Picture {
        match self.viewer.frame {
            FrameSetting::Film => pattern,
            FrameSetting::Viewer => {
                let [x, y] = foreshortening(direction);
                pattern.drawn_out(x, y)
            }
        }
    }

    /// What is seen of a picture on the film: in the viewer's frame, it is narrower by the cosine of the angle.
    pub fn as_seen(&self, on_the_film: Picture, direction: Direction) -> Picture {
        match self.viewer.frame {
            FrameSetting::Film => on_the_film,
            FrameSetting::Viewer => {
                let [x, y] = foreshortening(direction);
                on_the_film.drawn_out(1.0 / x, 1.0 / y)
            }
        }
    }

    /// How to design, in the engine's terms, for films of this depth.
    pub fn settings(&self, ink_depth: InkDepth) -> DesignSettings {
        DesignSettings {
            method: self.method(),
            optics: match self.design.optics {
                OpticsSetting::Stack => OpticsModel::Stack,
                OpticsSetting::Ideal => OpticsModel::Ideal,
            },
            tone: self.tone(),
            brightness: self.design.brightness,
            misplacement_um: self.design.misplacement_um,
            spacing_um: self.design.spacing_um,
            direction_error_deg: self.design.direction_error_deg,
            distance_error_part: self.design.distance_error_part,
            white_ratio: self.design.white_ratio,
            structure: self.design.structure,
            balance: self.design.balance,
            tolerance_db: self.design.tolerance_db,
            iterations: self.design.iterations as usize,
            levels: self.print.levels,
            ink_depth,
        }
    }
}

/// A distance, in the engine's terms: `None` is for parallel rays.
pub fn distance(millimetres: Option<f64>) -> ViewerDistance {
    millimetres.map_or(ViewerDistance::Parallel, ViewerDistance::Millimetres)
}

/// A pattern or a mask, some rows at a time.
struct FittedRows {
    picture: Fitted,
    pedestal: f64,
    tone: Tone,
}

impl PictureRows for FittedRows {
    fn rows(&self, size: (usize, usize), rows: Range<usize>) -> Picture {
        lifted(&self.picture.rows(size, rows), self.pedestal, self.tone)
    }

    fn held_bytes(&self) -> usize {
        self.picture.held_bytes()
    }
}

/// The mean of a picture's channels.
fn grey(picture: &Picture) -> Vec<f32> {
    let [red, green, blue] = [0, 1, 2].map(|channel| picture.channel(channel));
    red.iter().zip(green).zip(blue).map(|((r, g), b)| (r + g + b) / 3.0).collect()
}

/// By how much the film looks narrower and lower from `direction`.
fn foreshortening(direction: Direction) -> [f64; 2] {
    [direction.horizontal_deg, direction.vertical_deg].map(|degrees| degrees.to_radians().cos())
}

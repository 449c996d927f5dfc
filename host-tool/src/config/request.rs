//! From an exhibit to what the design engine is asked.

use std::path::Path;

use super::exhibit::{Exhibit, FrameSetting, MethodSetting, OpticsSetting, ToneSetting};
use crate::design::{DesignRequest, DesignSettings, Method, OpticsModel, Tone, ViewRequest};
use crate::optics::Direction;
use crate::picture::{Picture, PictureError};
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
        }
    }

    /// The viewer's distance, in the engine's terms.
    pub fn viewer_distance(&self) -> ViewerDistance {
        self.viewer.distance_mm.map_or(ViewerDistance::Parallel, ViewerDistance::Millimetres)
    }

    /// In which values light adds up, in the engine's terms.
    pub fn tone(&self) -> Tone {
        match self.design.tone {
            ToneSetting::Linear => Tone::Linear,
            ToneSetting::Code => Tone::Code,
        }
    }

    /// Reads the patterns, relative to `folder`, and asks for a design whose inks have `ink_depth`.
    ///
    /// # Errors
    /// Fails when a pattern cannot be read whole.
    pub fn design_request(&self, folder: &Path, ink_depth: InkDepth) -> Result<DesignRequest, PictureError> {
        let stack = self.film_stack();
        let views = self
            .views
            .iter()
            .map(|view| {
                let path = folder.join(&view.pattern);
                let direction = Direction::new(view.horizontal_deg, view.vertical_deg);
                Ok(ViewRequest {
                    id: view.id.clone(),
                    pattern: self.on_the_film(
                        Picture::read_fitted(&path, stack.width_px, stack.height_px)?,
                        direction,
                    ),
                    direction,
                    weight: view.weight,
                })
            })
            .collect::<Result<_, PictureError>>()?;
        Ok(DesignRequest {
            stack,
            distance: self.viewer_distance(),
            views,
            settings: self.settings(ink_depth),
        })
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

    fn settings(&self, ink_depth: InkDepth) -> DesignSettings {
        DesignSettings {
            method: match self.design.method {
                MethodSetting::LeastSquares => Method::LeastSquares,
                MethodSetting::Product => Method::Product,
            },
            optics: match self.design.optics {
                OpticsSetting::Stack => OpticsModel::Stack,
                OpticsSetting::Ideal => OpticsModel::Ideal,
            },
            tone: self.tone(),
            brightness: self.design.brightness,
            misplacement_um: self.design.misplacement_um,
            levels: self.print.levels,
            ink_depth,
            ..DesignSettings::default()
        }
    }
}

/// By how much the film looks narrower and lower from `direction`.
fn foreshortening(direction: Direction) -> [f64; 2] {
    [direction.horizontal_deg, direction.vertical_deg].map(|degrees| degrees.to_radians().cos())
}

//! From a model in a file to films.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use serde::{Deserialize, Serialize};

use crate::build_folder::portable_name;
use crate::config::{HiddenSetting, ObjectSettings};
use crate::stack::Stack;

use super::hidden::{self, Sight};
use super::layers::{Layers, Tally};
use super::model::{Model, ModelError};
use super::placement::Placement;
use super::shape::{Box3, Point, Sink, Triangle};
use super::texture::Texture;

/// A model in the films.
pub struct Sliced {
    /// The films.
    pub layers: Layers,
    /// What became of the model.
    pub report: ObjectReport,
    /// The files that were read.
    pub files: Vec<PathBuf>,
}

/// What became of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObjectReport {
    /// The model, relative to exhibit.toml.
    pub model: String,
    /// Millimetres that one unit of the model stands for.
    pub unit_mm: f64,
    /// Width, height and depth of the turned model in mm; none where that did not matter.
    pub size_mm: Option<[f64; 3]>,
    /// What became of its points and triangles.
    #[serde(flatten)]
    pub tally: Tally,
    /// Voxels with ink: several points in one voxel are one.
    pub voxels: u64,
    /// Voxels that were taken away because no view sees them.
    pub hidden_voxels: u64,
    /// Points that went to each film, film 1 first.
    pub points_of_films: Vec<u64>,
    /// What was guessed or mended.
    pub notes: Vec<String>,
}

impl ObjectReport {
    /// What became of the model, as lines to read.
    pub fn summary(&self) -> String {
        let hidden = match self.hidden_voxels {
            0 => String::new(),
            hidden => format!(", {hidden} hidden ones taken away"),
        };
        let voxels =
            format!("{:<16} {}; {} voxels with ink{hidden}", self.model, self.tally.in_words(), self.voxels);
        std::iter::once(&voxels).chain(&self.notes).cloned().collect::<Vec<_>>().join("\n")
    }
}

/// Lays the model at `path` into the films of `stack`, which is looked at from `sights`.
///
/// # Errors
/// Fails when the model cannot be read, or when nothing of it lies on the films.
pub fn slice(
    path: &Path,
    settings: &ObjectSettings,
    stack: &Stack,
    sights: &[Sight],
) -> Result<Sliced, ModelError> {
    let model = Model::open(path)?;
    let mut turned = Box3::EMPTY;
    if Placement::needs_box(settings) {
        let around = Around::new(settings);
        model.read(&around)?;
        turned = around.found();
        if turned.is_empty() {
            return Err(ModelError::Empty {
                path: path.to_owned(),
                why: "there is no point with finite coordinates in it".to_owned(),
                help: "look at the model in another program, and export it again",
            });
        }
    }
    let placement = Placement::new(settings, &turned, stack);
    let layers = Layers::new(stack, placement, settings);
    let mut notes = model.read(&layers)?;
    let tally = layers.tally();
    let open_columns = layers.fill();
    if open_columns > 0 {
        notes.push(format!(
            "the mesh is not closed in {open_columns} of {} columns of voxels: nothing is filled there",
            stack.film_len()
        ));
    }
    let hidden_voxels = match settings.hidden {
        HiddenSetting::Keep => 0,
        HiddenSetting::Remove => hidden::remove(&layers, stack, sights),
    };
    let voxels = layers.voxels_taken();
    if voxels == 0 {
        return Err(ModelError::Empty {
            path: path.to_owned(),
            why: tally.in_words(),
            help: "let `unit_mm` be \"fit\" and `centre` be \"box\" in [object]: the model then fills the stack",
        });
    }
    if settings.colour.is_some() {
        notes.retain(|note| !note.contains("colours"));
    }
    let size_mm = (!turned.is_empty()).then(|| turned.size().map(|size| size * placement.unit_mm));
    let report = ObjectReport {
        model: portable_name(&settings.model),
        unit_mm: placement.unit_mm,
        size_mm,
        tally,
        voxels,
        hidden_voxels,
        points_of_films: layers.points_of_films(),
        notes,
    };
    Ok(Sliced { layers, report, files: model.files() })
}

/// The box around a turned model.
struct Around {
    turn: Placement,
    found: Mutex<Box3>,
}

impl Around {
    fn new(settings: &ObjectSettings) -> Self {
        Self { turn: Placement::turned(settings.turn_deg), found: Mutex::new(Box3::EMPTY) }
    }

    fn hold(&self, positions: impl Iterator<Item = [f64; 3]>) {
        let mut around = Box3::EMPTY;
        positions.for_each(|position| around.hold(self.turn.place(position)));
        let mut found = self.found.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        *found = found.with(around);
    }

    fn found(self) -> Box3 {
        self.found.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Sink for Around {
    fn points(&self, points: &[Point]) {
        self.hold(points.iter().map(|point| point.position));
    }

    fn triangles(&self, triangles: &[Triangle], _: Option<&Texture>) {
        self.hold(triangles.iter().flatten().map(|corner| corner.position));
    }
}

//! From a model in a file to films.

use std::ops::Range;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::build_folder::portable_name;
use crate::config::{Exhibit, HiddenSetting, ObjectSettings};
use crate::stack::Stack;

use super::around::{Around, Watched};
use super::hidden::{self, Sight};
use super::layers::{Layers, Tally};
use super::model::{Model, ModelError};
use super::placement::Placement;
use super::shape::{Box3, Sink};

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
    /// Voxels with ink on each film, film 1 first.
    pub voxels_of_films: Vec<u64>,
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

/// What can be said of an object in the stack of `exhibit` before it is designed.
pub fn foretold(exhibit: &Exhibit, report: &ObjectReport) -> String {
    let counts: Vec<String> = report.voxels_of_films.iter().map(u64::to_string).collect();
    let seen = match exhibit.is_object_alone() {
        true => "its brightest hundredth is shown as white".to_owned(),
        false => {
            let films = exhibit.design.brightness * f64::from(exhibit.stack.films);
            format!(
                "white of the pictures around it is the light of {films:.1} films of full ink, so that a surface on one film has \
                 {:.0} % of it",
                100.0 / films
            )
        }
    };
    format!("voxels of films {}\n{seen}", counts.join(" "))
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
    let laid = lay(&model, settings, stack, 0..stack.height_px)?;
    let mut report = laid.report(settings);
    let layers = laid.layers;
    let open_columns = layers.fill();
    if open_columns > 0 {
        report.notes.push(format!(
            "the mesh is not closed in {open_columns} of {} columns of voxels: nothing is filled there",
            stack.film_len()
        ));
    }
    if settings.hidden == HiddenSetting::Remove {
        report.hidden_voxels = hidden::remove(&layers, stack, sights);
    }
    report.voxels_of_films = layers.voxels_of_films();
    report.voxels = report.voxels_of_films.iter().sum();
    if report.voxels == 0 {
        return Err(ModelError::Empty {
            path: path.to_owned(),
            why: report.tally.in_words(),
            help: "let `unit_mm` be \"fit\" and `centre` be \"box\" in [object]: the model then fills the stack",
        });
    }
    Ok(Sliced { layers, report, files: model.files() })
}

/// A model in the films, as it was read.
pub(super) struct Laid {
    layers: Layers,
    pub(super) placement: Placement,
    /// The box around the turned model; empty where it did not matter.
    turned: Box3,
    notes: Vec<String>,
}

impl Laid {
    /// What became of the model but for its voxels.
    pub(super) fn report(&self, settings: &ObjectSettings) -> ObjectReport {
        let mut notes = self.notes.clone();
        if settings.colour.is_some() {
            notes.retain(|note| !note.contains("colours"));
        }
        let unit_mm = self.placement.unit_mm;
        ObjectReport {
            model: portable_name(&settings.model),
            unit_mm,
            size_mm: (!self.turned.is_empty()).then(|| self.turned.size().map(|size| size * unit_mm)),
            tally: self.layers.tally(),
            voxels: 0,
            voxels_of_films: Vec::new(),
            hidden_voxels: 0,
            points_of_films: self.layers.points_of_films(),
            notes,
        }
    }

    /// Lays what `read` gives into empty films.
    fn read(
        (settings, stack, rows): (&ObjectSettings, &Stack, &Range<usize>),
        turned: Box3,
        read: impl FnOnce(&Layers) -> Result<Vec<String>, ModelError>,
    ) -> Result<Self, ModelError> {
        let placement = Placement::new(settings, &turned, stack);
        let layers = Layers::of_rows(stack, placement, settings, rows.clone());
        let notes = read(&layers)?;
        Ok(Self { layers, placement, turned, notes })
    }
}

/// Lays `model` into films of which `rows` are kept; one whose box has to be known is read twice, unless its file tells of
/// it or it is a cloud that is kept.
pub(super) fn lay(
    model: &Model,
    settings: &ObjectSettings,
    stack: &Stack,
    rows: Range<usize>,
) -> Result<Laid, ModelError> {
    let place = (settings, stack, &rows);
    if !Placement::needs_box(settings) {
        return Laid::read(place, Box3::EMPTY, |layers| model.read(layers));
    }
    let around = Around::new(settings);
    let mut wrongly_told = None;
    if let Some(told) = model.told_box().and_then(|told| around.turned(&told)) {
        let laid = Laid::read(place, told, |layers| model.read(&Watched { around: &around, layers }))?;
        if around.is(&told) {
            return Ok(laid);
        }
        wrongly_told = Some("the header tells other bounds than the points have: theirs count".to_owned());
    }
    let read = match around.found() {
        seen if !seen.is_empty() => None,
        _ => Some(model.read(&around)?),
    };
    let turned = around.found();
    if turned.is_empty() {
        let why = std::iter::once("there is no point with finite coordinates in it".to_owned());
        return Err(ModelError::Empty {
            path: model.path().to_owned(),
            why: why.chain(read.into_iter().flatten()).collect::<Vec<_>>().join("; "),
            help: "look at the model in another program, and export it again",
        });
    }
    let mut laid = match (around.kept(), read) {
        (Some(points), Some(notes)) => Laid::read(place, turned, |layers| {
            points.par_iter().for_each(|points| layers.points(points));
            Ok(notes)
        })?,
        _ => Laid::read(place, turned, |layers| model.read(layers))?,
    };
    laid.notes.extend(wrongly_told);
    Ok(laid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::CentreSetting;
    use crate::object::model::las::tests::las;
    use crate::optics::Direction;
    use crate::projection::ViewerDistance;

    /// 8 films of 16 x 16 pixels of 1 mm, 1 mm apart.
    fn stack() -> Stack {
        Stack {
            films: 8,
            width_px: 16,
            height_px: 16,
            width_mm: 16.0,
            film_mm: 0.5,
            spacer_mm: 0.5,
            ..Stack::default()
        }
    }

    fn in_mm() -> ObjectSettings {
        ObjectSettings { unit_mm: Some(1.0), centre: CentreSetting::Origin, ..ObjectSettings::default() }
    }

    fn sliced(name: &str, text: &str, settings: &ObjectSettings, degrees: &[f64]) -> Sliced {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let sight = |degrees: &f64| Sight {
            direction: Direction::new(*degrees, 0.0),
            distance: ViewerDistance::Parallel,
        };
        slice(&path, settings, &stack(), &degrees.iter().map(sight).collect::<Vec<_>>()).unwrap()
    }

    /// A closed cube of 6 mm about the middle, red in front.
    const CUBE: &str = "v -3 -3 -3\nv 3 -3 -3\nv 3 3 -3\nv -3 3 -3\nv -3 -3 3 1 0 0\nv 3 -3 3 1 0 0\nv 3 3 3 1 0 0\n\
        v -3 3 3 1 0 0\nf 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 4 3 7 8\nf 1 4 8 5\nf 2 3 7 6\n";

    #[test]
    fn a_filled_cube_has_ink_inside_and_an_open_one_says_where_not() {
        let filled = ObjectSettings { filled: true, ..in_mm() };
        let hollow = sliced("a.obj", CUBE, &in_mm(), &[]).report;
        let solid = sliced("a.obj", CUBE, &filled, &[]);
        assert_eq!(solid.report.tally.triangles, 12);
        assert!(solid.report.notes.is_empty(), "{:?}", solid.report.notes);
        // The surface takes voxels 5 and 11 along each axis, the inside has those between.
        assert_eq!((hollow.voxels, solid.report.voxels), (7 * 7 * 7 - 5 * 5 * 5, 7 * 7 * 7));
        let at = |film: usize, row: usize, column: usize| (film * 16 + row) * 16 + column;
        assert!(solid.layers.occupied()[at(4, 8, 8)]);
        let ink = solid.layers.volume(crate::design::Tone::Code);
        assert_eq!(ink.film_rgb8(4)[3 * (8 * 16 + 8)..][..3], [255, 0, 0]);
        let open = CUBE.replace("f 5 6 7 8\n", "");
        let open = sliced("a.obj", &open, &filled, &[]).report;
        assert!(open.notes[0].contains("not closed in 36 of 256 columns"), "{:?}", open.notes);
    }

    #[test]
    fn what_no_view_sees_is_taken_away() {
        // A wall of points on the top film, and one point 3 mm behind its middle.
        let place = |at: u8| f64::from(at) - 2.5;
        let wall: String = (0..49).map(|at| format!("{} {} 3.5\n", place(at % 7), place(at / 7))).collect();
        let text = format!("{wall}0.5 0.5 0.5\n");
        let removed = |degrees: &[f64]| {
            let settings = ObjectSettings { hidden: HiddenSetting::Remove, ..in_mm() };
            sliced("a.xyz", &text, &settings, degrees).report.hidden_voxels
        };
        assert_eq!(removed(&[0.0]), 1);
        assert_eq!(removed(&[30.0, -30.0]), 1);
        // From so far to the side one looks past the wall's edge.
        assert_eq!(removed(&[0.0, 60.0]), 0);
        assert_eq!(sliced("a.xyz", &text, &in_mm(), &[0.0]).report.hidden_voxels, 0);
    }

    #[test]
    fn what_a_model_is_cut_of_is_told() {
        let moved = ObjectSettings { unit_mm: Some(2.0), ..in_mm() };
        let report = sliced("a.obj", CUBE, &moved, &[]).report;
        // Twice as large it is 12 mm: too deep, so that front and back lie outside and the sides are cut.
        let tally = report.tally;
        assert_eq!((tally.triangles, tally.triangles_outside, tally.triangles_cut), (12, 4, 8));
        assert_eq!(
            tally.in_words(),
            "of 12 triangles 8 on films, 8 of them cut at the stack's faces, 4 outside"
        );
        let fitted = sliced("a.obj", CUBE, &ObjectSettings::default(), &[]).report;
        assert_eq!(fitted.tally.triangles_cut, 0);
        assert!(fitted.size_mm.unwrap().iter().all(|size| (size - 8.0).abs() < 1e-4));
    }

    #[test]
    fn a_cloud_that_was_kept_is_laid_into_films_as_one_that_is_read_again() {
        let cloud = |[x, y, z]: [i32; 3]| -> String {
            (0..5000).map(|at| format!("{} {} {}\n", at % 83 - x, at % 61 - y, at % 17 - z)).collect()
        };
        let fitted = sliced("a.xyz", &cloud([0; 3]), &ObjectSettings::default(), &[]);
        // About its own middle, no box is looked for.
        let settings = ObjectSettings { unit_mm: Some(fitted.report.unit_mm), ..in_mm() };
        let other = sliced("a.xyz", &cloud([41, 30, 8]), &settings, &[]);
        assert_eq!(fitted.report.voxels_of_films, other.report.voxels_of_films);
        assert_eq!(fitted.report.tally, other.report.tally);
        assert_eq!(fitted.report.tally.on_films, 5000);
    }

    #[test]
    fn a_scan_is_fitted_by_its_header_unless_that_is_wrong() {
        let folder = tempfile::tempdir().unwrap();
        for (turn_deg, compressed) in
            [([0.0; 3], false), ([90.0, 0.0, 180.0], true), ([0.0, 30.0, 0.0], false)]
        {
            let settings = ObjectSettings { turn_deg, ..ObjectSettings::default() };
            let report = |bytes: &[u8]| {
                let path = folder.path().join("a.las");
                std::fs::write(&path, bytes).unwrap();
                slice(&path, &settings, &stack(), &[]).unwrap().report
            };
            let mut bytes = las(2, 300, 65_535, compressed);
            let fitted = report(&bytes);
            assert_eq!((fitted.tally.on_films, fitted.notes.len()), (300, 0), "{:?}", fitted.notes);
            // The largest x.
            bytes[179..187].copy_from_slice(&700_000.0_f64.to_le_bytes());
            let mended = report(&bytes);
            let is_told = turn_deg[1] == 0.0;
            assert_eq!(mended.notes.iter().any(|note| note.contains("other bounds")), is_told);
            assert_eq!(ObjectReport { notes: Vec::new(), ..mended }, fitted);
        }
    }
}

//! An object alone in films too large for memory, laid some rows at a time.
//!
//! For each strip of rows the model is read again, and only the voxels of these rows are kept: the same as in the films as
//! a whole, wherever strips are cut. What hides something may lie in the next strip, so as many rows as that can be away are
//! laid with a strip and thrown away. Only the printer's levels differ, which hand nothing on from strip to strip.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::hidden::{self, Sight};
use super::layers::Layers;
use super::levels;
use super::model::{Model, ModelError};
use super::placement::Placement;
use super::slice::{ObjectReport, Sliced, lay};
use crate::config::{Exhibit, HiddenSetting, ObjectSettings};
use crate::design::Tone;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Carried, InkDepth, Volume};

/// Films of a strip that are given at once.
const FILMS_AT_ONCE: usize = 4;
const MIB: f64 = 1024.0 * 1024.0;

/// An object in films too large for memory.
pub struct ObjectStrips {
    model: Model,
    settings: ObjectSettings,
    stack: Stack,
    sights: Vec<Sight>,
    tone: Tone,
    levels: Option<u16>,
    depth: InkDepth,
    placement: Placement,
    /// What became of the model in all films but for their voxels.
    counted: ObjectReport,
    /// Rows of a strip, and those on either side that are laid with it.
    rows: usize,
    around: usize,
}

/// A strip of an object; it gives its films from the top one down, some at a time, as they will be written.
pub struct ObjectStrip<'a> {
    object: &'a ObjectStrips,
    layers: Layers,
    rows: Range<usize>,
    /// Films that were given.
    given: usize,
    /// What they have lost by rounding.
    carried: Carried,
}

impl ObjectStrips {
    /// Reads once where the model at `path` stands in the stack of `exhibit` and what becomes of it. Strips have so many
    /// rows that laying one stays within `memory_mib`; `None` where not even one row does.
    ///
    /// # Errors
    /// Fails when the model cannot be read.
    pub fn open(
        path: &Path,
        exhibit: &Exhibit,
        depth: InkDepth,
        memory_mib: f64,
    ) -> Result<Option<Self>, ModelError> {
        let (stack, sights) = (exhibit.film_stack(), exhibit.sights());
        let settings = exhibit.object.clone().unwrap_or_default();
        let around = match settings.hidden {
            HiddenSetting::Keep => 0,
            HiddenSetting::Remove => hidden::rows_around(&stack, &sights),
        };
        let levels = exhibit.print.levels;
        let Some(rows) = rows_within(&stack, levels.is_some(), around, memory_mib) else { return Ok(None) };
        let model = Model::open(path)?;
        let laid = lay(&model, &settings, &stack, 0..0)?;
        let (placement, counted) = (laid.placement, laid.report(&settings));
        let tone = exhibit.tone();
        Ok(Some(Self {
            model,
            settings,
            stack,
            sights,
            tone,
            levels,
            depth,
            placement,
            counted,
            rows,
            around,
        }))
    }

    /// How many strips there are.
    pub fn strips(&self) -> usize {
        self.stack.height_px.div_ceil(self.rows)
    }

    /// The rows of strip `strip`.
    pub fn rows(&self, strip: usize) -> Range<usize> {
        let first = strip * self.rows;
        first..(first + self.rows).min(self.stack.height_px)
    }

    /// The files that the model is made of.
    pub fn files(&self) -> Vec<PathBuf> {
        self.model.files()
    }

    /// What became of the model: its voxels as they are in the films of `small`, everything else as it is in all films.
    pub fn report(&self, small: &Sliced) -> ObjectReport {
        let voxels = &small.report;
        let mut report = ObjectReport {
            voxels: voxels.voxels,
            voxels_of_films: voxels.voxels_of_films.clone(),
            hidden_voxels: voxels.hidden_voxels,
            notes: voxels.notes.clone(),
            ..self.counted.clone()
        };
        report.notes.push("voxels are counted in small; the films have more".to_owned());
        report
    }

    /// Lays strip `strip`.
    ///
    /// # Errors
    /// Fails when the model cannot be read again.
    pub fn strip(&self, strip: usize) -> Result<ObjectStrip<'_>, ModelError> {
        let rows = self.rows(strip);
        let laid = rows.start.saturating_sub(self.around)..(rows.end + self.around).min(self.stack.height_px);
        let layers = Layers::of_rows(&self.stack, self.placement, &self.settings, laid);
        self.model.read(&layers)?;
        layers.fill();
        if self.settings.hidden == HiddenSetting::Remove {
            hidden::remove(&layers, &self.stack, &self.sights);
        }
        let carried = Carried::start(self.stack.width_px, rows.start as i64..rows.end as i64);
        Ok(ObjectStrip { object: self, layers, rows, given: 0, carried })
    }
}

impl ObjectStrip<'_> {
    /// The ink of some films, each alone.
    fn ink_of(&self, films: Range<usize>) -> Vec<Volume> {
        let tone = self.object.tone;
        match self.object.levels {
            None => {
                films.map(|film| self.layers.volume_of(tone, film..film + 1, self.rows.clone())).collect()
            }
            Some(levels) => {
                let mut whole = self.layers.volume_of(tone, films.clone(), self.rows.clone());
                levels::lay(&mut whole, &self.layers.occupied_of(self.rows.clone()), levels);
                let alone = |film: usize| {
                    let mut alone = Volume::new(1, whole.height(), whole.width());
                    (0..CHANNELS)
                        .for_each(|ink| alone.channel_mut(ink).copy_from_slice(whole.film(ink, film)));
                    alone
                };
                (0..films.len()).map(alone).collect()
            }
        }
    }
}

impl Iterator for ObjectStrip<'_> {
    type Item = Vec<Volume>;

    fn next(&mut self) -> Option<Vec<Volume>> {
        let left = self.object.stack.films - self.given;
        // Levels hand their errors on to the films behind.
        let count = if self.object.levels.is_some() { left } else { left.min(FILMS_AT_ONCE) };
        if count == 0 {
            return None;
        }
        let mut films = self.ink_of(self.given..self.given + count);
        for film in &mut films {
            film.quantise_below(self.object.depth, &mut self.carried, self.rows.start as i64);
        }
        self.given += count;
        Some(films)
    }
}

/// The rows of a strip whose laying, with so many rows `around` it on either side, stays within `memory_mib`.
fn rows_within(stack: &Stack, has_levels: bool, around: usize, memory_mib: f64) -> Option<usize> {
    /// Bytes of a voxel while it is laid: its point, and whether it is taken, seen, and crossed by a mesh.
    const LAID: f64 = 7.0;
    /// Bytes of a voxel's three inks, and of what each lost by rounding.
    const INK: f64 = (CHANNELS * size_of::<f32>()) as f64;
    /// Bytes of a voxel's three inks on their way into a file.
    const FILE: f64 = 24.0;
    let films = stack.films as f64;
    let kept = match has_levels {
        true => films * (2.0 * INK + FILE + 1.0),
        false => FILMS_AT_ONCE as f64 * (INK + FILE),
    };
    let width = stack.width_px as f64;
    let for_rows = memory_mib * MIB - 2.0 * around as f64 * films * LAID * width;
    let rows = (for_rows / ((films * LAID + kept + INK) * width)) as usize;
    (rows > 0).then(|| rows.min(stack.height_px))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{CentreSetting, object_exhibit};
    use crate::object::slice;

    /// An exhibit of 6 films of 24 x 30 pixels of 1 mm, seen from below and near by.
    fn exhibit(settings: ObjectSettings) -> Exhibit {
        let mut exhibit = object_exhibit(settings);
        exhibit.stack.films = 6;
        exhibit.stack.pixels = [24, 30];
        exhibit.stack.width_mm = 24.0;
        exhibit.stack.film_mm = 1.0;
        exhibit.stack.spacer_mm = 1.0;
        exhibit.views[0].vertical_deg = -30.0;
        exhibit.views[1].distance_mm = Some(40.0);
        exhibit
    }

    fn in_mm() -> ObjectSettings {
        ObjectSettings { unit_mm: Some(1.0), centre: CentreSetting::Origin, ..ObjectSettings::default() }
    }

    /// The films of the model as a whole, and by strips of so many rows.
    fn both(name: &str, text: &str, exhibit: &Exhibit, rows: usize) -> [Volume; 2] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        let settings = exhibit.object.clone().unwrap();
        let stack = exhibit.film_stack();
        let sliced = slice(&path, &settings, &stack, &exhibit.sights()).unwrap();
        let mut whole = sliced.layers.volume(exhibit.tone());
        whole.quantise(InkDepth::Eight);
        let mut strips = ObjectStrips::open(&path, exhibit, InkDepth::Eight, 1000.0).unwrap().unwrap();
        strips.rows = rows;
        let mut grown = Volume::new(stack.films, stack.height_px, stack.width_px);
        for strip in 0..strips.strips() {
            let rows = strips.rows(strip);
            let mut film = 0;
            for alone in strips.strip(strip).unwrap().flatten() {
                for channel in 0..CHANNELS {
                    let kept = rows.start * stack.width_px..rows.end * stack.width_px;
                    grown.film_mut(channel, film)[kept].copy_from_slice(alone.channel(channel));
                }
                film += 1;
            }
            assert_eq!(film, stack.films);
        }
        let report = strips.report(&sliced);
        assert_eq!(report.tally, sliced.report.tally);
        assert_eq!(report.points_of_films, sliced.report.points_of_films);
        assert_eq!((report.unit_mm, report.size_mm), (sliced.report.unit_mm, sliced.report.size_mm));
        [whole, grown]
    }

    fn cloud(points: usize) -> String {
        let at = |index: usize, factor: usize, size: f64| {
            ((index * factor) % 9973) as f64 / 9973.0 * size - size / 2.0
        };
        let point = |index| {
            let [x, y, z] = [at(index, 7919, 26.0), at(index, 104_729, 32.0), at(index, 1_299_709, 13.0)];
            format!("{x} {y} {z} {} {} {}\n", index % 256, index * 7 % 256, index * 31 % 256)
        };
        (0..points).map(point).collect()
    }

    #[test]
    fn a_cloud_is_the_same_wherever_strips_are_cut() {
        for settings in [
            in_mm(),
            ObjectSettings::default(),
            ObjectSettings { point_mm: 3.4, ..in_mm() },
            ObjectSettings { depth_dither: true, colour: Some([9, 200, 30]), ..in_mm() },
            ObjectSettings { hidden: HiddenSetting::Remove, point_mm: 2.0, ..in_mm() },
        ] {
            for rows in [1, 7, 30] {
                let [whole, grown] = both("a.xyz", &cloud(1500), &exhibit(settings.clone()), rows);
                assert!(whole.values().iter().any(|value| *value > 0.0));
                assert!(whole == grown, "{settings:?} by {rows} rows");
            }
        }
    }

    #[test]
    fn a_mesh_is_the_same_wherever_strips_are_cut() {
        let mesh = "v -9 -13 -5 1 0 0\nv 9 -13 -5 0 1 0\nv 0 13 -5 0 0 1\nv 0 0 5\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
        let settings = ObjectSettings { filled: true, ..in_mm() };
        for (mesh, hidden) in
            [(mesh, HiddenSetting::Keep), (&mesh.replace("f 1 3 2\n", ""), HiddenSetting::Remove)]
        {
            for rows in [1, 7, 30] {
                let exhibit = exhibit(ObjectSettings { hidden, ..settings.clone() });
                let [whole, grown] = both("a.obj", mesh, &exhibit, rows);
                assert!(whole.values().iter().filter(|value| **value > 0.0).count() > 400);
                assert!(whole == grown, "{hidden:?} by {rows} rows");
            }
        }
    }

    #[test]
    fn levels_keep_the_ink_of_strips() {
        let mut exhibit = exhibit(ObjectSettings { colour: Some([150, 60, 255]), ..in_mm() });
        exhibit.print.levels = Some(2);
        let [whole, grown] = both("a.xyz", &cloud(4000), &exhibit, 7);
        for channel in 0..CHANNELS {
            assert!(grown.channel(channel).iter().all(|value| *value == 0.0 || *value == 1.0));
            let sum = |volume: &Volume| volume.channel(channel).iter().sum::<f32>();
            let ratio = sum(&grown) / sum(&whole);
            assert!((ratio - 1.0).abs() < 0.05, "{channel}: {ratio}");
        }
    }

    #[test]
    fn rows_fit_into_the_memory() {
        let stack = Stack { width_px: 23_840, height_px: 33_704, ..Stack::default() };
        assert!((100..1000).contains(&rows_within(&stack, false, 0, 1536.0).unwrap()));
        let fewer = rows_within(&stack, false, 20, 1536.0).unwrap();
        assert!(fewer < rows_within(&stack, false, 0, 1536.0).unwrap());
        assert!(rows_within(&stack, true, 0, 1536.0).unwrap() > 20);
        assert_eq!(rows_within(&stack, false, 0, 2.0), None);
        assert_eq!(rows_within(&stack, false, 5000, 1536.0), None);
    }
}

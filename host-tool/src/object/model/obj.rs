//! Wavefront OBJ with its materials (MTL) and textures.
//!
//! Of the format are read: `v` (with a colour behind, where there is one), `vt`, `f` with indices from either end, `p`,
//! `usemtl`, `mtllib`; of materials `newmtl`, `Kd` and `map_Kd`. Reading line by line, an error has its line: no known
//! crate tells lines, or bears damaged files without a panic.

#[cfg(test)]
mod tests;

use std::collections::{BTreeSet, HashMap};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::beside::{path_beside, texture_at};
use super::error::ModelError;
use super::text::Lines;
use super::{MOST_VERTICES, TriangleBatch, open};
use crate::object::shape::{Corner, Point, Sink, UNCOLOURED};
use crate::object::texture::Texture;
use crate::picture::srgb_decode;

/// A model whose materials have been read.
#[derive(Clone, Debug)]
pub(super) struct Obj {
    path: PathBuf,
    materials: HashMap<String, Material>,
    /// The files beside the model that were read.
    pub(super) files: Vec<PathBuf>,
    notes: Vec<String>,
}

/// What a surface is painted with.
#[derive(Clone, Debug)]
struct Material {
    /// Light of each channel.
    light: [f32; 3],
    texture: Option<Arc<Texture>>,
    /// What its file names as its texture.
    named: Option<Named>,
}

/// A file that another one names.
#[derive(Clone, Debug)]
struct Named {
    by: PathBuf,
    file: String,
}

impl Obj {
    /// Reads the materials of the model at `path` that its faces take, and nothing that only others name.
    pub(super) fn open(path: &Path) -> Result<Self, ModelError> {
        let mut model =
            Self { path: path.to_owned(), materials: HashMap::new(), files: Vec::new(), notes: Vec::new() };
        let (mut libraries, mut used) = (Vec::new(), BTreeSet::new());
        let mut material = None;
        let mut lines = lines(path)?;
        while let Some(line) = lines.next()? {
            match split(line) {
                Some(("mtllib", name)) if !name.trim().is_empty() => libraries.push(name.trim().to_owned()),
                Some(("usemtl", name)) => material = Some(name.trim().to_owned()),
                Some(("f", _)) => used.extend(material.take()),
                _ => {}
            }
        }
        if !used.is_empty() {
            for name in &libraries {
                model.read_materials(&path_beside(path, name)?, name)?;
            }
        }
        model.read_textures(&used)?;
        Ok(model)
    }

    fn read_materials(&mut self, path: &Path, name: &str) -> Result<(), ModelError> {
        let mut lines = match lines(path) {
            Ok(lines) => lines,
            Err(_) => {
                self.notes.push(format!("the materials {name} are missing: the model goes without them"));
                return Ok(());
            }
        };
        self.files.push(path.to_owned());
        let mut current: Option<String> = None;
        while let Some(line) = lines.next()? {
            if let Some(name) = argument(line, "newmtl") {
                self.materials.insert(name.clone(), Material { light: [1.0; 3], texture: None, named: None });
                current = Some(name);
                continue;
            }
            let Some(material) = current.as_ref().and_then(|name| self.materials.get_mut(name)) else {
                continue;
            };
            if let Some(colour) = argument(line, "Kd") {
                let numbers: Vec<f32> =
                    colour.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect();
                let Ok(light) = <[f32; 3]>::try_from(numbers) else {
                    return Err(lines.damaged("Kd wants three numbers"));
                };
                material.light = light.map(|code| srgb_decode(if code.is_finite() { code } else { 1.0 }));
            } else if let Some(arguments) = argument(line, "map_Kd") {
                // Options stand before the name, which ends the line.
                let file = if arguments.starts_with('-') {
                    arguments.split_ascii_whitespace().last().unwrap_or_default().to_owned()
                } else {
                    arguments
                };
                material.named = Some(Named { by: path.to_owned(), file });
            }
        }
        Ok(())
    }

    /// Reads the textures of the materials that are `used`, each once.
    fn read_textures(&mut self, used: &BTreeSet<String>) -> Result<(), ModelError> {
        let mut read: HashMap<PathBuf, Option<Arc<Texture>>> = HashMap::new();
        for name in used {
            let Some(material) = self.materials.get_mut(name) else { continue };
            let Some(Named { by, file }) = &material.named else { continue };
            let place = path_beside(by, file)?;
            let texture = read.entry(place).or_insert_with_key(|place| {
                let texture = texture_at(place, file, &mut self.notes).map(Arc::new);
                self.files.extend(texture.is_some().then(|| place.clone()));
                texture
            });
            material.texture = texture.clone();
        }
        Ok(())
    }

    /// Reads the model into `sink`.
    pub(super) fn read(&self, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
        self.read_within(MOST_VERTICES, sink)
    }

    /// Reads the model, of at most so many vertices and texture places, into `sink`.
    pub(super) fn read_within(&self, most: usize, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
        let mut notes = self.notes.clone();
        let mut mesh = Mesh::default();
        let mut unknown: Option<String> = None;
        let mut material: Option<&Material> = None;
        let mut batch = TriangleBatch::new(sink, None);
        let mut lines = lines(&self.path)?;
        while let Some(line) = lines.next()? {
            let Some((keyword, rest)) = split(line) else { continue };
            let done = match keyword {
                "v" => mesh.vertex(rest),
                "vt" => mesh.texture_place(rest),
                "f" => mesh.face(rest, material).map(|corners| batch.fan(&corners)),
                "p" => mesh.points(rest).map(|points| sink.points(&points)),
                "usemtl" => {
                    material = self.materials.get(rest.trim());
                    if material.is_none() {
                        unknown.get_or_insert_with(|| rest.trim().to_owned());
                    }
                    batch.paint(material.and_then(|material| material.texture.as_deref()));
                    Ok(())
                }
                _ => Ok(()),
            };
            done.map_err(|what| lines.damaged(what))?;
            if mesh.vertices.len().max(mesh.texture_places.len()) > most {
                return Err(ModelError::TooManyVertices { path: self.path.clone(), most });
            }
        }
        batch.flush();
        if mesh.faces == 0 && mesh.points == 0 {
            notes.push("the model has no faces: its vertices are taken as points".to_owned());
            mesh.vertices.chunks(super::POINTS_AT_ONCE).for_each(|points| sink.points(points));
        }
        if mesh.lost_places > 0 {
            notes.push(format!(
                "{} corners name places in a texture that are not there: they take its upper left corner",
                mesh.lost_places
            ));
        }
        if let Some(name) = unknown.filter(|_| !self.materials.is_empty()) {
            notes.push(format!("there is no material {name}: what has it is white"));
        } else if self.materials.is_empty() && !mesh.coloured {
            notes.push("the model has no colours of its own: it is white".to_owned());
        }
        Ok(notes)
    }
}

/// What has been read of a model so far.
#[derive(Default)]
struct Mesh {
    vertices: Vec<Point>,
    coloured: bool,
    texture_places: Vec<[f32; 2]>,
    faces: u64,
    points: u64,
    /// Corners whose place in the texture is not there.
    lost_places: u64,
}

impl Mesh {
    fn vertex(&mut self, rest: &str) -> Result<(), String> {
        let numbers = numbers::<6>(rest)?;
        let (position, colour) = match numbers.as_slice() {
            [x, y, z] | [x, y, z, _] => ([*x, *y, *z], UNCOLOURED),
            [x, y, z, red, green, blue] => {
                self.coloured = true;
                let full = if [*red, *green, *blue].iter().any(|value| *value > 1.0) { 1.0 } else { 255.0 };
                let code = |value: f64| (value * full).round().clamp(0.0, 255.0) as u8;
                ([*x, *y, *z], [code(*red), code(*green), code(*blue)])
            }
            other => return Err(format!("a vertex has {} numbers, not 3, 4 or 6", other.len())),
        };
        self.vertices.push(Point { position, colour });
        Ok(())
    }

    fn texture_place(&mut self, rest: &str) -> Result<(), String> {
        match numbers::<3>(rest)?.as_slice() {
            [across, up, ..] => self.texture_places.push([*across as f32, 1.0 - *up as f32]),
            [across] => self.texture_places.push([*across as f32, 0.0]),
            [] => return Err("vt has no number".to_owned()),
        }
        Ok(())
    }

    fn face(&mut self, rest: &str, material: Option<&Material>) -> Result<Vec<Corner>, String> {
        self.faces += 1;
        let light = material.map_or([1.0; 3], |material| material.light);
        let mut lost = 0;
        let corner = |word: &str| -> Result<Corner, String> {
            let mut indices = word.split('/');
            let vertex = *item(&self.vertices, indices.next().unwrap_or_default(), "vertex")?;
            let texture = match indices.next().filter(|index| !index.is_empty()) {
                Some(index) => match item(&self.texture_places, index, "vt") {
                    Ok(place) => *place,
                    Err(what) if index.parse::<i64>().is_err() => return Err(what),
                    Err(_) => {
                        lost += 1;
                        [0.0; 2]
                    }
                },
                None => [0.0; 2],
            };
            let own = Corner::of(vertex.position, vertex.colour);
            let light = [0, 1, 2].map(|channel| own.light[channel] * light[channel]);
            Ok(Corner { light, texture, ..own })
        };
        let corners = rest.split_ascii_whitespace().map(corner).collect();
        self.lost_places += lost;
        corners
    }

    fn points(&mut self, rest: &str) -> Result<Vec<Point>, String> {
        self.points += 1;
        rest.split_ascii_whitespace().map(|word| item(&self.vertices, word, "vertex").copied()).collect()
    }
}

/// The item that an index names: from 1 on, or from -1 back.
fn item<'a, T>(items: &'a [T], index: &str, what: &str) -> Result<&'a T, String> {
    let number: i64 = index.parse().map_err(|_| format!("\"{}\" is no index", shortened(index)))?;
    let place = match number {
        1.. => usize::try_from(number - 1).ok(),
        _ => usize::try_from(number.unsigned_abs())
            .ok()
            .filter(|back| *back > 0)
            .and_then(|back| items.len().checked_sub(back)),
    };
    let found = place.and_then(|place| items.get(place));
    found.ok_or_else(|| format!("names {what} {number}, but there are {} so far", items.len()))
}

/// The numbers of a line, at most `MOST`.
fn numbers<const MOST: usize>(rest: &str) -> Result<Vec<f64>, String> {
    let words = rest.split_ascii_whitespace().take(MOST);
    words.map(|word| word.parse().map_err(|_| format!("\"{}\" is no number", shortened(word)))).collect()
}

fn shortened(word: &str) -> String {
    word.chars().take(24).collect()
}

fn lines(path: &Path) -> Result<Lines, ModelError> {
    Ok(Lines::new(path, BufReader::new(open(path)?.0), 1))
}

/// The keyword of a line and what stands behind it.
fn split(line: &[u8]) -> Option<(&str, &str)> {
    let text = std::str::from_utf8(line).ok()?.trim_start();
    Some(text.split_once([' ', '\t']).unwrap_or((text, "")))
}

/// What stands behind `keyword` on a line that begins with it.
fn argument(line: &[u8], keyword: &str) -> Option<String> {
    let (found, rest) = split(line)?;
    (found == keyword && !rest.trim().is_empty()).then(|| rest.trim().to_owned())
}

//! glTF 2.0, as text with its files beside it or as one binary file (GLB).
//!
//! The crate `gltf-json` gives the document its types; nothing in it is followed without looking whether it is there, for
//! the crates' own ways through a damaged document end in panics. Points, triangles, strips and fans of the document's
//! scene are taken, with their base colours and base textures and the colours of their vertices.

mod accessor;
mod buffers;

#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use gltf_json as json;
use json::mesh::{Mode, Semantic};
use json::validation::Checked;

use super::error::{ModelError, Place};
use super::{POINTS_AT_ONCE, TriangleBatch};
use crate::object::shape::{Corner, Point, Sink, UNCOLOURED, Vector};
use crate::object::texture::Texture;
use crate::picture::srgb_encode;
use accessor::Accessors;
use buffers::Loaded;

/// Extensions that hide the shape, with what to do.
const COMPRESSIONS: [&str; 2] = ["KHR_draco_mesh_compression", "EXT_meshopt_compression"];
/// Extensions that hide the pictures of textures.
const PICTURES: [&str; 2] = ["KHR_texture_basisu", "MSFT_texture_dds"];
/// The index of what a document does not name.
const NOT_NAMED: usize = u32::MAX as usize;
/// How deep nodes may lie within each other.
const DEEPEST: usize = 256;

/// A model whose document, buffers and textures have been read.
#[derive(Clone, Debug)]
pub(super) struct Gltf {
    path: PathBuf,
    root: json::Root,
    buffers: Vec<Vec<u8>>,
    /// By the index of the image.
    textures: HashMap<usize, Texture>,
    /// The files beside the model that were read.
    pub(super) files: Vec<PathBuf>,
    notes: Vec<String>,
}

impl Gltf {
    /// Reads the document at `path` with its buffers and textures.
    pub(super) fn open(path: &Path) -> Result<Self, ModelError> {
        let Loaded { root, buffers, files } = buffers::load(path)?;
        let compressed = root.extensions_required.iter().find(|name| COMPRESSIONS.contains(&name.as_str()));
        if let Some(name) = compressed {
            return Err(ModelError::Damaged {
                path: path.to_owned(),
                place: Place::Element("extensionsRequired".to_owned()),
                what: format!("the model is compressed by {name}"),
                help: "export the model again without compression",
            });
        }
        if let Some(name) = root.extensions_required.iter().find(|name| PICTURES.contains(&name.as_str())) {
            return Err(ModelError::Damaged {
                path: path.to_owned(),
                place: Place::Element("extensionsRequired".to_owned()),
                what: format!("the textures are compressed by {name}"),
                help: "export the model again with PNG or JPEG pictures",
            });
        }
        let mut model =
            Self { path: path.to_owned(), root, buffers, textures: HashMap::new(), files, notes: Vec::new() };
        model.read_textures()?;
        Ok(model)
    }

    /// Reads the images that the base colours of what the scene shows take, and no others.
    fn read_textures(&mut self) -> Result<(), ModelError> {
        for image in self.shown_images() {
            if self.textures.contains_key(&image) {
                continue;
            }
            if image == NOT_NAMED {
                let note = "a texture has no picture in a format that is known: its colours are left out";
                if !self.notes.iter().any(|told| told == note) {
                    self.notes.push(note.to_owned());
                }
                continue;
            }
            if let Some(texture) = buffers::texture(self, image)? {
                self.textures.insert(image, texture);
            }
        }
        Ok(())
    }

    /// The indices of the images that the scene's meshes take.
    fn shown_images(&self) -> Vec<usize> {
        let mut visited = vec![false; self.root.nodes.len()];
        let mut waiting = self.first_nodes();
        let mut images = Vec::new();
        while let Some(index) = waiting.pop() {
            let Some(node) = self.root.nodes.get(index) else { continue };
            if std::mem::replace(&mut visited[index], true) {
                continue;
            }
            waiting.extend(node.children.iter().flatten().map(json::Index::value));
            let mesh = node.mesh.and_then(|mesh| self.root.meshes.get(mesh.value()));
            let primitives = mesh.into_iter().flat_map(|mesh| &mesh.primitives);
            let materials = primitives.filter_map(|primitive| primitive.material);
            let materials = materials.filter_map(|material| self.root.materials.get(material.value()));
            images.extend(materials.filter_map(|material| self.image_of(material)));
        }
        images
    }

    /// The index of the image that a material's colour takes.
    fn image_of(&self, material: &json::Material) -> Option<usize> {
        let info = colour_of(material).1?;
        Some(self.root.textures.get(info.index.value())?.source.value())
    }

    /// Reads the model into `sink`.
    pub(super) fn read(&self, sink: &dyn Sink) -> Result<Vec<String>, ModelError> {
        let mut walk = Walk {
            model: self,
            sink,
            visited: vec![false; self.root.nodes.len()],
            notes: self.notes.clone(),
        };
        for node in self.first_nodes() {
            walk.node(node, &IDENTITY, 0)?;
        }
        Ok(walk.notes)
    }

    /// The nodes of the document's scene, or all that are nobody's children.
    fn first_nodes(&self) -> Vec<usize> {
        let scene = self.root.scene.map_or(0, |scene| scene.value());
        if let Some(scene) = self.root.scenes.get(scene) {
            return scene.nodes.iter().map(json::Index::value).collect();
        }
        let children: Vec<usize> = self
            .root
            .nodes
            .iter()
            .filter_map(|node| node.children.as_ref())
            .flatten()
            .map(json::Index::value)
            .collect();
        (0..self.root.nodes.len()).filter(|node| !children.contains(node)).collect()
    }

    /// An error at a part of the document.
    fn damaged(&self, element: impl Into<String>, what: impl Into<String>) -> ModelError {
        ModelError::damaged(&self.path, Place::Element(element.into()), what)
    }
}

/// An affine map: rows of three factors and a shift.
type Affine = [[f64; 4]; 3];
const IDENTITY: Affine = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

/// A walk through the nodes of a scene.
struct Walk<'a> {
    model: &'a Gltf,
    sink: &'a dyn Sink,
    visited: Vec<bool>,
    notes: Vec<String>,
}

impl Walk<'_> {
    fn node(&mut self, index: usize, outer: &Affine, depth: usize) -> Result<(), ModelError> {
        let model = self.model;
        let element = || format!("nodes[{index}]");
        let Some(node) = model.root.nodes.get(index) else {
            return Err(model.damaged(element(), "a scene or node names this node, which is not there"));
        };
        if std::mem::replace(&mut self.visited[index], true) {
            return Err(model.damaged(element(), "the node stands in two places, or within itself"));
        }
        if depth > DEEPEST {
            return Err(
                model.damaged(element(), format!("nodes lie more than {DEEPEST} deep within each other"))
            );
        }
        let place = within(outer, &affine_of(node));
        if let Some(mesh) = node.mesh {
            self.mesh(mesh.value(), &place)?;
        }
        for child in node.children.iter().flatten() {
            self.node(child.value(), &place, depth + 1)?;
        }
        Ok(())
    }

    fn mesh(&mut self, index: usize, place: &Affine) -> Result<(), ModelError> {
        let Some(mesh) = self.model.root.meshes.get(index) else {
            return Err(self
                .model
                .damaged(format!("meshes[{index}]"), "a node names this mesh, which is not there"));
        };
        for (number, primitive) in mesh.primitives.iter().enumerate() {
            self.primitive(&format!("meshes[{index}].primitives[{number}]"), primitive, place)?;
        }
        Ok(())
    }

    fn primitive(
        &mut self,
        element: &str,
        primitive: &json::mesh::Primitive,
        place: &Affine,
    ) -> Result<(), ModelError> {
        let model = self.model;
        let Checked::Valid(mode) = primitive.mode else {
            return Err(model.damaged(element, "its mode is none of glTF's"));
        };
        let painted = Painted::of(model, primitive);
        let corners = Corners::of(model, element, primitive, place, &painted)?;
        let order = corners.order(model, element, primitive)?;
        let mut batch = TriangleBatch::new(self.sink, painted.texture);
        let triangle = |a: u32, b: u32, c: u32| -> Result<[Corner; 3], ModelError> {
            Ok([
                corners.at(model, element, a)?,
                corners.at(model, element, b)?,
                corners.at(model, element, c)?,
            ])
        };
        match mode {
            Mode::Points => {
                let points = order.iter().map(|index| corners.at(model, element, *index).map(as_point));
                let points: Vec<Point> = points.collect::<Result<_, _>>()?;
                points.chunks(POINTS_AT_ONCE).for_each(|points| self.sink.points(points));
            }
            Mode::Triangles => {
                for [a, b, c] in order.as_chunks().0 {
                    batch.push(triangle(*a, *b, *c)?);
                }
            }
            Mode::TriangleStrip => {
                for [a, b, c] in order.array_windows() {
                    batch.push(triangle(*a, *b, *c)?);
                }
            }
            Mode::TriangleFan => {
                if let [first, rest @ ..] = order.as_slice() {
                    for [b, c] in rest.array_windows() {
                        batch.push(triangle(*first, *b, *c)?);
                    }
                }
            }
            Mode::Lines | Mode::LineLoop | Mode::LineStrip => {
                self.notes.push(format!("{element} is lines: they are left out"));
            }
        }
        batch.flush();
        Ok(())
    }
}

/// A material's colour and its texture: those that scatter light, where it tells of gloss instead of metal, as
/// KHR_materials_pbrSpecularGlossiness does.
fn colour_of(material: &json::Material) -> ([f32; 4], Option<&json::texture::Info>) {
    let glossy = material.extensions.as_ref().and_then(|known| known.pbr_specular_glossiness.as_ref());
    match glossy {
        Some(glossy) => (glossy.diffuse_factor.0, glossy.diffuse_texture.as_ref()),
        None => {
            let base = &material.pbr_metallic_roughness;
            (base.base_color_factor.0, base.base_color_texture.as_ref())
        }
    }
}

/// What a primitive is painted with.
struct Painted<'a> {
    light: [f32; 3],
    texture: Option<&'a Texture>,
    /// Which of the texture coordinates the texture takes.
    coordinates: u32,
    /// From these to places in the texture: rows of two factors and a shift.
    laid: [[f32; 3]; 2],
}

/// Where texture coordinates are places in the texture.
const AS_IT_IS: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// Where KHR_texture_transform takes texture coordinates: scaled, then turned against the clock as the picture is seen,
/// then moved.
fn laid(transform: &json::extensions::texture::TextureTransform) -> [[f32; 3]; 2] {
    let ([across, down], [x, y]) = (transform.scale.0, transform.offset.0);
    let (sine, cosine) = transform.rotation.0.sin_cos();
    [[cosine * across, sine * down, x], [-sine * across, cosine * down, y]]
}

impl<'a> Painted<'a> {
    fn of(model: &'a Gltf, primitive: &json::mesh::Primitive) -> Self {
        let material = primitive.material.and_then(|material| model.root.materials.get(material.value()));
        let Some(material) = material else {
            return Self { light: [1.0; 3], texture: None, coordinates: 0, laid: AS_IT_IS };
        };
        let ([red, green, blue, _], info) = colour_of(material);
        let transform = info.and_then(|info| info.extensions.as_ref()?.texture_transform.as_ref());
        let own = info.map_or(0, |info| info.tex_coord);
        Self {
            light: [red, green, blue].map(|value| value.clamp(0.0, 1.0)),
            texture: model.image_of(material).and_then(|image| model.textures.get(&image)),
            coordinates: transform.and_then(|transform| transform.tex_coord).unwrap_or(own),
            laid: transform.map_or(AS_IT_IS, laid),
        }
    }
}

/// The corners of a primitive, placed in the scene.
struct Corners(Vec<Corner>);

impl Corners {
    fn of(
        model: &Gltf,
        element: &str,
        primitive: &json::mesh::Primitive,
        place: &Affine,
        painted: &Painted<'_>,
    ) -> Result<Self, ModelError> {
        let accessors = Accessors { model };
        let read = |semantic: Semantic, components: usize| {
            let accessor = primitive.attributes.get(&Checked::Valid(semantic));
            accessor.map(|accessor| accessors.read(accessor.value(), components)).transpose()
        };
        let Some(positions) = read(Semantic::Positions, 3)? else {
            return Err(model.damaged(element, "it has no POSITION"));
        };
        let colours = read(Semantic::Colors(0), 3)?.unwrap_or_default();
        let textures = match painted.texture {
            Some(_) => read(Semantic::TexCoords(painted.coordinates), 2)?.unwrap_or_default(),
            None => Vec::new(),
        };
        let corner = |(index, position): (usize, &[f32; 4])| {
            let colour = colours.get(index).copied().unwrap_or([1.0; 4]);
            let [across, down, ..] = textures.get(index).copied().unwrap_or_default();
            let [x, y, z, _] = position.map(f64::from);
            Corner {
                position: place.map(|row| row[0] * x + row[1] * y + row[2] * z + row[3]),
                light: [0, 1, 2].map(|channel| painted.light[channel] * colour[channel].clamp(0.0, 1.0)),
                texture: painted.laid.map(|row| row[0] * across + row[1] * down + row[2]),
            }
        };
        Ok(Self(positions.iter().enumerate().map(corner).collect()))
    }

    /// The order in which the corners are taken.
    fn order(
        &self,
        model: &Gltf,
        element: &str,
        primitive: &json::mesh::Primitive,
    ) -> Result<Vec<u32>, ModelError> {
        match primitive.indices {
            Some(accessor) => Accessors { model }.indices(accessor.value()),
            None => match u32::try_from(self.0.len()) {
                Ok(count) => Ok((0..count).collect()),
                Err(_) => Err(model.damaged(element, "it has too many vertices")),
            },
        }
    }

    fn at(&self, model: &Gltf, element: &str, index: u32) -> Result<Corner, ModelError> {
        self.0.get(index as usize).copied().ok_or_else(|| {
            model.damaged(element, format!("names vertex {index}, but there are {}", self.0.len()))
        })
    }
}

fn as_point(corner: Corner) -> Point {
    let colour = match corner.light {
        [1.0, 1.0, 1.0] => UNCOLOURED,
        light => light.map(|light| (srgb_encode(light) * 255.0).round() as u8),
    };
    Point { position: corner.position, colour }
}

/// Where a node stands within its parent: its matrix, or its scale, then its rotation, then its translation.
fn affine_of(node: &json::Node) -> Affine {
    if let Some(columns) = node.matrix {
        return [0, 1, 2].map(|row| [0, 1, 2, 3].map(|column| f64::from(columns[4 * column + row])));
    }
    let [x, y, z, w] = node.rotation.map_or([0.0, 0.0, 0.0, 1.0], |rotation| rotation.0.map(f64::from));
    let scale: Vector = node.scale.unwrap_or([1.0; 3]).map(f64::from);
    let shift: Vector = node.translation.unwrap_or_default().map(f64::from);
    let turn = [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ];
    [0, 1, 2].map(|row| {
        let [a, b, c] = [0, 1, 2].map(|column| turn[row][column] * scale[column]);
        [a, b, c, shift[row]]
    })
}

/// The map of what stands in `inner` within `outer`.
fn within(outer: &Affine, inner: &Affine) -> Affine {
    [0, 1, 2].map(|row| {
        [0, 1, 2, 3].map(|column| {
            let turned: f64 = (0..3).map(|at| outer[row][at] * inner[at][column]).sum();
            turned + if column == 3 { outer[row][3] } else { 0.0 }
        })
    })
}

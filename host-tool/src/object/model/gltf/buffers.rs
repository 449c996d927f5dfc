//! Gets the bytes of a glTF document: out of a GLB file, of data URIs, and of the files beside it.

use std::path::{Path, PathBuf};

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf_json as json;

use super::Gltf;
use crate::object::model::beside::{path_beside, read_whole, texture_at, texture_of};
use crate::object::model::error::{ModelError, Place};
use crate::object::texture::Texture;

/// A document with its buffers.
pub(super) struct Loaded {
    pub(super) root: json::Root,
    pub(super) buffers: Vec<Vec<u8>>,
    /// The files beside the model that were read.
    pub(super) files: Vec<PathBuf>,
}

/// Whether a document that cannot be read says that it is of the version before.
fn is_of_version_1(document: &[u8]) -> bool {
    let document: Option<serde_json::Value> = serde_json::from_slice(document).ok();
    let version = document.as_ref().and_then(|document| document["asset"]["version"].as_str());
    version.is_some_and(|version| version.starts_with("1."))
}

/// Reads the document at `path` and its buffers.
pub(super) fn load(path: &Path) -> Result<Loaded, ModelError> {
    let bytes = read_whole(path)?;
    let (document, mut binary) = match bytes.starts_with(b"glTF") {
        true => chunks(path, &bytes)?,
        false => (bytes.as_slice(), None),
    };
    let root: json::Root = json::deserialize::from_slice(document).map_err(|error| {
        let place = if bytes.starts_with(b"glTF") {
            Place::Element(format!("JSON chunk, line {}, column {}", error.line(), error.column()))
        } else {
            Place::Line(error.line() as u64)
        };
        match is_of_version_1(document) {
            true => ModelError::Damaged {
                path: path.to_owned(),
                place,
                what: "this is glTF of version 1".to_owned(),
                help: "export the model again as glTF 2.0",
            },
            false => ModelError::damaged(path, place, error.to_string()),
        }
    })?;
    let (mut buffers, mut files) = (Vec::new(), Vec::new());
    for (index, buffer) in root.buffers.iter().enumerate() {
        let fail =
            |what: String| Err(ModelError::damaged(path, Place::Element(format!("buffers[{index}]")), what));
        let bytes = match buffer.uri.as_deref() {
            None => match binary.take() {
                Some(binary) => binary.to_vec(),
                None => return fail("it has no uri, and the file has no binary chunk for it".to_owned()),
            },
            Some(uri) => match data(uri) {
                Some(Ok(bytes)) => bytes,
                Some(Err(what)) => return fail(what),
                None => {
                    let place = path_beside(path, &unescaped(uri))?;
                    let bytes = read_whole(&place)?;
                    files.push(place);
                    bytes
                }
            },
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            return fail(format!(
                "it tells of {} bytes, but there are {}",
                buffer.byte_length.0,
                bytes.len()
            ));
        }
        buffers.push(bytes);
    }
    Ok(Loaded { root, buffers, files })
}

/// The JSON chunk and the binary chunk of a GLB file.
fn chunks<'a>(path: &Path, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>), ModelError> {
    let fail = |at: usize, what: &str| Err(ModelError::damaged(path, Place::Byte(at as u64), what));
    let number = |at: usize| {
        bytes.get(at..).and_then(|bytes| bytes.first_chunk()).map(|four| u32::from_le_bytes(*four))
    };
    if number(4) != Some(2) {
        return fail(4, "this is no glTF of version 2");
    }
    let (mut document, mut binary) = (None, None);
    let mut at = 12;
    while let (Some(length), Some(kind)) = (number(at), bytes.get(at + 4..at + 8)) {
        let start = at + 8;
        let Some(chunk) = start.checked_add(length as usize).and_then(|end| bytes.get(start..end)) else {
            return fail(at, "a chunk reaches beyond the end of the file");
        };
        match kind {
            b"JSON" if document.is_none() => document = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        at = start + chunk.len();
    }
    match document {
        Some(document) => Ok((document, binary)),
        None => fail(12, "there is no JSON chunk"),
    }
}

/// The bytes of a data URI; nothing where it is none.
fn data(uri: &str) -> Option<Result<Vec<u8>, String>> {
    let rest = uri.strip_prefix("data:")?;
    let Some((_, text)) = rest.split_once(";base64,") else {
        return Some(Err("its data URI is not in base64".to_owned()));
    };
    Some(STANDARD.decode(text).map_err(|error| format!("its data URI is damaged: {error}")))
}

/// A relative reference with its escapes (`%20`) resolved.
fn unescaped(uri: &str) -> String {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped = (*first == b'%').then(|| tail.get(..2)).flatten();
        let value = escaped
            .and_then(|digits| std::str::from_utf8(digits).ok())
            .and_then(|digits| u8::from_str_radix(digits, 16).ok());
        match value {
            Some(value) => {
                bytes.push(value);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The texture of an image; none, with a note, where it is missing or damaged.
pub(super) fn texture(model: &mut Gltf, index: usize) -> Result<Option<Texture>, ModelError> {
    let name = format!("images[{index}]");
    let Some(image) = model.root.images.get(index) else {
        return Err(model.damaged(name, "a texture names this image, which is not there"));
    };
    let mut notes = Vec::new();
    let texture = match (image.buffer_view, image.uri.as_deref()) {
        (Some(view), _) => match model.view(view.value()) {
            Some(bytes) => texture_of(bytes, &name, &mut notes),
            None => return Err(model.damaged(name, "its bufferView lies beyond the buffers")),
        },
        (None, Some(uri)) => match data(uri) {
            Some(Ok(bytes)) => texture_of(&bytes, &name, &mut notes),
            Some(Err(what)) => return Err(model.damaged(name, what)),
            None => {
                let file = unescaped(uri);
                let place = path_beside(&model.path, &file)?;
                let texture = texture_at(&place, &file, &mut notes);
                if texture.is_some() {
                    model.files.push(place);
                }
                texture
            }
        },
        (None, None) => return Err(model.damaged(name, "it has neither a uri nor a bufferView")),
    };
    model.notes.append(&mut notes);
    Ok(texture)
}

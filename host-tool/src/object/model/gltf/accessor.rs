//! The numbers of a glTF document: where they are in the buffers, as its accessors tell.

use gltf_json as json;
use json::accessor::ComponentType;
use json::validation::Checked;

use super::Gltf;
use crate::object::model::error::ModelError;

/// Reads numbers out of the buffers of a model.
pub(super) struct Accessors<'a> {
    pub(super) model: &'a Gltf,
}

/// Numbers in a buffer: so many items of some components each, a stride apart.
struct Run<'a> {
    bytes: &'a [u8],
    stride: usize,
    kind: ComponentType,
    normalised: bool,
}

impl Accessors<'_> {
    /// The items of an accessor, the first `components` numbers of each and ones behind; integers that are normalised
    /// become parts of their largest.
    pub(super) fn read(&self, index: usize, components: usize) -> Result<Vec<[f32; 4]>, ModelError> {
        let name = || format!("accessors[{index}]");
        let fail = |what: &str| Err(self.model.damaged(name(), what));
        let Some(accessor) = self.model.root.accessors.get(index) else {
            return fail("it is named, but not there");
        };
        let (Checked::Valid(kind), Checked::Valid(shape)) = (accessor.component_type, accessor.type_) else {
            return fail("its type is none of glTF's");
        };
        if shape.multiplicity() < components || shape.multiplicity() > 4 {
            return fail("its items have another number of components than is needed here");
        }
        let Some(count) = usize::try_from(accessor.count.0).ok().filter(|count| *count <= self.most_items())
        else {
            return fail("it tells of more items than the buffers can hold");
        };
        let item = shape.multiplicity() * kind.0.size();
        let place = (
            accessor.buffer_view.map(|view| view.value()),
            accessor.byte_offset.map_or(0, |offset| offset.0),
        );
        let mut items = match self.run(place, count, item, kind.0, accessor.normalized, &name)? {
            Some(run) => (0..count).map(|at| run.item(at, shape.multiplicity())).collect(),
            None => vec![[0.0, 0.0, 0.0, 1.0]; count],
        };
        if let Some(sparse) = &accessor.sparse {
            let Some(changes) = usize::try_from(sparse.count.0).ok().filter(|changes| *changes <= count)
            else {
                return fail("it changes more items than it has");
            };
            let Checked::Valid(index_kind) = sparse.indices.component_type else {
                return fail("the type of its sparse indices is none of glTF's");
            };
            let at = (Some(sparse.indices.buffer_view.value()), sparse.indices.byte_offset.0);
            let indices = self.run(at, changes, index_kind.0.size(), index_kind.0, false, &name)?;
            let at = (Some(sparse.values.buffer_view.value()), sparse.values.byte_offset.0);
            let values = self.run(at, changes, item, kind.0, accessor.normalized, &name)?;
            if let (Some(indices), Some(values)) = (indices, values) {
                for change in 0..changes {
                    let Some(item) = items.get_mut(indices.number(change, 0) as usize) else {
                        return fail("a sparse index is beyond its items");
                    };
                    *item = values.item(change, shape.multiplicity());
                }
            }
        }
        Ok(items)
    }

    /// The indices of an accessor.
    pub(super) fn indices(&self, index: usize) -> Result<Vec<u32>, ModelError> {
        let name = || format!("accessors[{index}]");
        let fail = |what: &str| Err(self.model.damaged(name(), what));
        let Some(accessor) = self.model.root.accessors.get(index) else {
            return fail("it is named, but not there");
        };
        let Checked::Valid(kind) = accessor.component_type else { return fail("its type is none of glTF's") };
        let Some(count) = usize::try_from(accessor.count.0).ok().filter(|count| *count <= self.most_items())
        else {
            return fail("it tells of more items than the buffers can hold");
        };
        let place = (
            accessor.buffer_view.map(|view| view.value()),
            accessor.byte_offset.map_or(0, |offset| offset.0),
        );
        match self.run(place, count, kind.0.size(), kind.0, false, &name)? {
            Some(run) => Ok((0..count).map(|at| run.number(at, 0) as u32).collect()),
            None => fail("indices have no bufferView"),
        }
    }

    /// No accessor has more items than the buffers have bytes.
    fn most_items(&self) -> usize {
        self.model.buffers.iter().map(Vec::len).sum()
    }

    /// Where `count` items of `item` bytes lie; nothing where there is no view.
    fn run(
        &self,
        (view, offset): (Option<usize>, u64),
        count: usize,
        item: usize,
        kind: ComponentType,
        normalised: bool,
        name: &dyn Fn() -> String,
    ) -> Result<Option<Run<'_>>, ModelError> {
        let Some(view) = view else { return Ok(None) };
        let fail = |what: &str| Err(self.model.damaged(name(), what));
        let Some(bytes) = self.model.view(view) else {
            return fail("its bufferView lies beyond the buffers");
        };
        let stride = self.model.root.buffer_views[view].byte_stride.map_or(item, |stride| stride.0);
        let needed = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(item));
        let bytes = usize::try_from(offset).ok().and_then(|offset| bytes.get(offset..));
        match (bytes, needed) {
            (Some(bytes), Some(needed)) if needed <= bytes.len() => {
                Ok(Some(Run { bytes, stride, kind, normalised }))
            }
            _ => fail("its items reach beyond its bufferView"),
        }
    }
}

impl Gltf {
    /// The bytes of a buffer view.
    pub(super) fn view(&self, index: usize) -> Option<&[u8]> {
        let view = self.root.buffer_views.get(index)?;
        let buffer = self.buffers.get(view.buffer.value())?;
        let start = usize::try_from(view.byte_offset.map_or(0, |offset| offset.0)).ok()?;
        buffer.get(start..start.checked_add(usize::try_from(view.byte_length.0).ok()?)?)
    }
}

impl Run<'_> {
    fn item(&self, index: usize, components: usize) -> [f32; 4] {
        let mut item = [0.0, 0.0, 0.0, 1.0];
        item.iter_mut().take(components).enumerate().for_each(|(at, value)| *value = self.value(index, at));
        item
    }

    fn value(&self, index: usize, component: usize) -> f32 {
        let number = self.number(index, component);
        let full = match self.kind {
            _ if !self.normalised => 1.0,
            ComponentType::I8 => 127.0,
            ComponentType::U8 => 255.0,
            ComponentType::I16 => 32_767.0,
            ComponentType::U16 => 65_535.0,
            ComponentType::U32 | ComponentType::F32 => 1.0,
        };
        (number / full).max(if self.normalised { -1.0 } else { f64::MIN }) as f32
    }

    /// One number; 0 beyond the end, which no run that was checked has.
    fn number(&self, index: usize, component: usize) -> f64 {
        let start = index * self.stride + component * self.kind.size();
        let bytes = self.bytes.get(start..).unwrap_or_default();
        fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
            bytes.first_chunk().copied().unwrap_or([0; N])
        }
        match self.kind {
            ComponentType::I8 => f64::from(i8::from_le_bytes(array(bytes))),
            ComponentType::U8 => f64::from(u8::from_le_bytes(array(bytes))),
            ComponentType::I16 => f64::from(i16::from_le_bytes(array(bytes))),
            ComponentType::U16 => f64::from(u16::from_le_bytes(array(bytes))),
            ComponentType::U32 => f64::from(u32::from_le_bytes(array(bytes))),
            ComponentType::F32 => f64::from(f32::from_le_bytes(array(bytes))),
        }
    }
}

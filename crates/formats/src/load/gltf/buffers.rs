//! Buffers, their views, and accessors: typed numbers in bytes.
//!
//! In: the JSON and the bytes of the buffers. Out: numbers, each accessor as a list. Elements of
//! all accessors read are counted against a limit and reserved before they are allocated, since an
//! accessor without a buffer may state any number of zeros, and many may share one buffer.
//!
//! Source: glTF 2.0 Specification, sections 3.6.1 (Buffers and Buffer Views) and 3.6.2 (Accessors).

use super::json::Json;
use crate::load::{LoadContext, LoadError, LoadErrorKind, LoadMemory, url};
use fbptr_core::memory::Reservation;
use std::borrow::Cow;

/// Most elements of all accessors that are read.
const MAX_ELEMENTS: u64 = 1 << 26;

/// Bytes of all buffers, with the reservations of those that were read or decoded.
pub(super) struct Buffers<'a> {
    bytes: Vec<Cow<'a, [u8]>>,
    elements: u64,
    _held: Vec<Reservation>,
}

/// Reads the file or data URI that `uri` names.
///
/// # Errors
/// If there is none, or it may not be read.
pub(super) fn referenced(
    uri: &Json,
    text: &str,
    context: &mut LoadContext,
    names_outside: &mut bool,
) -> Result<(Vec<u8>, Reservation), LoadError> {
    // A data URI exists as text without escapes and as bytes.
    let room = if url::is_data(text) { 2 * text.len() as u64 } else { 0 };
    let mut held = context.memory.work(room).map_err(|kind| uri.refuse(kind))?;
    if let Some(decoded) = url::data(text) {
        let reason = |reason: &str| LoadErrorKind::Undecodable { format: "URI", reason: reason.to_owned() };
        return Ok((decoded.map_err(|e| uri.refuse(reason(e)))?, held));
    }
    let paths = url::local_paths(context.folder, text);
    if let Some(bytes) = paths.iter().find_map(|path| (context.opener)(path)) {
        held.try_grow(bytes.len() as u64).map_err(|e| uri.refuse(LoadErrorKind::OverBudget(e)))?;
        return Ok((bytes, held));
    }
    let what = match url::is_outside(context.folder, text) {
        true => {
            *names_outside = true;
            "a file outside of the folder that it may be read from:"
        }
        false => "file",
    };
    Err(uri.refuse(LoadErrorKind::Missing { what, name: text.chars().take(80).collect() }))
}

impl<'a> Buffers<'a> {
    /// Reads all buffers of a file; `binary` is that of a GLB file.
    pub(super) fn read(
        root: &Json<'a>,
        binary: Option<&'a [u8]>,
        context: &mut LoadContext,
        names_outside: &mut bool,
    ) -> Result<Self, LoadError> {
        let (mut bytes, mut held) = (Vec::new(), Vec::new());
        for (i, buffer) in root.member("buffers").items()?.iter().enumerate() {
            let uri = buffer.member("uri");
            let found: Cow<[u8]> = match (uri.text()?, binary) {
                (Some(text), _) => {
                    let (bytes, room) = referenced(&uri, text, context, names_outside)?;
                    held.push(room);
                    Cow::Owned(bytes)
                }
                (None, Some(binary)) if i == 0 => Cow::Borrowed(binary),
                // Allowed for buffers of extensions; whoever uses it is refused.
                (None, _) => Cow::Borrowed(&[]),
            };
            let length = buffer.member("byteLength");
            let stated = length.whole()?;
            if uri.is_there() && stated > found.len() as u64 {
                let reason = format!("a buffer of {stated} bytes, and its file has {}", found.len());
                return Err(length.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
            }
            bytes.push(found);
        }
        Ok(Buffers { bytes, elements: 0, _held: held })
    }

    /// Returns the bytes of a buffer view, and its stride if it has one.
    pub(super) fn view(&self, view: &Json) -> Result<(&[u8], Option<usize>), LoadError> {
        let buffer = view.member("buffer").index("buffer", self.bytes.len())?;
        let bytes = &self.bytes[buffer];
        let offset = view.member("byteOffset").whole_or(0)?;
        let length = view.member("byteLength").whole()?;
        let end = offset.checked_add(length).filter(|end| *end <= bytes.len() as u64);
        let Some(end) = end else {
            let reason =
                format!("{length} bytes from byte {offset} on, and buffer {buffer} has {}", bytes.len());
            return Err(view.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
        };
        let stride = view.member("byteStride");
        let stride = match stride.is_there() {
            true => Some(stride.whole()?)
                .filter(|s| (4..=252).contains(s))
                .ok_or_else(|| stride.wrong("a stride from 4 to 252 bytes"))?,
            false => 0,
        };
        Ok((&bytes[offset as usize..end as usize], (stride > 0).then_some(stride as usize)))
    }

    /// Reads an accessor of one of these numbers of components.
    pub(super) fn read_accessor(
        &mut self,
        root: &Json,
        accessor: &Json,
        widths: &[usize],
        memory: &LoadMemory,
    ) -> Result<Numbers, LoadError> {
        let kind = accessor.member("type");
        let width = match kind.text()? {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4") => 4,
            Some("MAT4") => 16,
            _ => 0,
        };
        if !widths.contains(&width) {
            let names = widths.iter().map(|w| match w {
                1 => "SCALAR",
                2 => "VEC2",
                3 => "VEC3",
                4 => "VEC4",
                _ => "MAT4",
            });
            return Err(kind.wrong(names.collect::<Vec<_>>().join(" or ")));
        }
        let component = Component::read(&accessor.member("componentType"))?;
        let is_normalized = accessor.member("normalized").bool_or(false)?;
        let count = self.count(&accessor.member("count"), width)?;
        let held = memory.work((count * width * 8) as u64).map_err(|kind| accessor.refuse(kind))?;
        let mut values = Vec::with_capacity(count * width);
        let view = accessor.member("bufferView");
        let layout = Layout { width, component, is_normalized };
        match view.is_there() {
            true => {
                let place = layout.place(root, &view, &accessor.member("byteOffset"), count)?;
                let (bytes, _) = self.view(&place.view)?;
                layout.read(bytes, &place, count, &mut values);
            }
            false => values.resize(count * width, 0.0),
        }
        let sparse = accessor.member("sparse");
        if sparse.is_there() {
            self.replace(root, &sparse, layout, &mut values, memory)?;
        }
        if let Some(wrong) = values.iter().find(|v| !v.is_finite()) {
            let what = "a component of an accessor";
            return Err(accessor.refuse(LoadErrorKind::Number { what, found: wrong.to_string() }));
        }
        Ok(Numbers { values, width, _held: held })
    }

    /// Reads a count of elements, and adds it to the sum of all.
    fn count(&mut self, count: &Json, width: usize) -> Result<usize, LoadError> {
        let elements = count.whole()?;
        self.elements = self.elements.saturating_add(elements.saturating_mul(width as u64));
        // Up to 16 components each.
        let (found, limit) = (self.elements, MAX_ELEMENTS * 4);
        if found > limit {
            return Err(count.refuse(LoadErrorKind::TooBig {
                what: "numbers of all accessors",
                found,
                limit,
            }));
        }
        Ok(elements as usize)
    }

    /// Replaces elements by those of a sparse accessor.
    fn replace(
        &mut self,
        root: &Json,
        sparse: &Json,
        layout: Layout,
        values: &mut [f64],
        memory: &LoadMemory,
    ) -> Result<(), LoadError> {
        let width = layout.width;
        let count = self.count(&sparse.member("count"), width)?;
        let room = (count * (width + 1) * 8) as u64;
        let _held = memory.work(room).map_err(|kind| sparse.refuse(kind))?;
        let (mut indices, mut replaced) = (Vec::with_capacity(count), Vec::with_capacity(count * width));
        let from = sparse.member("indices");
        let component = Component::read(&from.member("componentType"))?;
        let scalar = Layout { width: 1, component, is_normalized: false };
        let place = scalar.place(root, &from.member("bufferView"), &from.member("byteOffset"), count)?;
        scalar.read(self.view(&place.view)?.0, &place, count, &mut indices);
        let from = sparse.member("values");
        let place = layout.place(root, &from.member("bufferView"), &from.member("byteOffset"), count)?;
        layout.read(self.view(&place.view)?.0, &place, count, &mut replaced);
        let elements = values.len() / width;
        for (index, value) in indices.iter().zip(replaced.chunks_exact(width)) {
            let Some(element) = values.chunks_exact_mut(width).nth(*index as usize) else {
                let kind =
                    LoadErrorKind::Index { what: "element", index: *index as i64, count: elements as u64 };
                return Err(sparse.member("indices").refuse(kind));
            };
            element.copy_from_slice(value);
        }
        Ok(())
    }
}

/// Numbers of an accessor, element after element.
pub(super) struct Numbers {
    pub(super) values: Vec<f64>,
    pub(super) width: usize,
    _held: Reservation,
}

impl Numbers {
    /// Returns the number of elements.
    pub(super) fn count(&self) -> usize {
        self.values.len() / self.width
    }

    /// Returns the elements, each as the first `N` of its components; missing ones are `rest`.
    pub(super) fn elements<const N: usize>(&self, rest: f64) -> impl Iterator<Item = [f64; N]> {
        let element = move |e: &[f64]| std::array::from_fn(|i| e.get(i).copied().unwrap_or(rest));
        self.values.chunks_exact(self.width).map(element)
    }
}

/// Type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn read(code: &Json) -> Result<Component, LoadError> {
        Ok(match code.whole()? {
            5120 => Component::I8,
            5121 => Component::U8,
            5122 => Component::I16,
            5123 => Component::U16,
            5125 => Component::U32,
            5126 => Component::F32,
            _ => return Err(code.wrong("5120 to 5123, 5125 or 5126")),
        })
    }

    fn size(self) -> usize {
        match self {
            Component::I8 | Component::U8 => 1,
            Component::I16 | Component::U16 => 2,
            Component::U32 | Component::F32 => 4,
        }
    }

    /// Returns the largest value of a type of whole numbers.
    fn largest(self) -> f64 {
        match self {
            Component::I8 => 127.0,
            Component::U8 => 255.0,
            Component::I16 => 32767.0,
            Component::U16 => 65535.0,
            Component::U32 => f64::from(u32::MAX),
            Component::F32 => 1.0,
        }
    }

    /// Returns the number in the first bytes.
    fn number(self, bytes: &[u8]) -> f64 {
        let [a, b, c, d] = std::array::from_fn(|i| bytes.get(i).copied().unwrap_or(0));
        match self {
            Component::I8 => f64::from(a as i8),
            Component::U8 => f64::from(a),
            Component::I16 => f64::from(i16::from_le_bytes([a, b])),
            Component::U16 => f64::from(u16::from_le_bytes([a, b])),
            Component::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Component::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
        }
    }
}

/// Shape of an element.
#[derive(Clone, Copy)]
struct Layout {
    width: usize,
    component: Component,
    is_normalized: bool,
}

/// Place of elements in a view that has room for them.
struct Place<'a> {
    view: Json<'a>,
    offset: usize,
    stride: usize,
}

impl Layout {
    /// Finds the elements' place; refuses a view that is too short for `count` of them.
    fn place<'a>(
        self,
        root: &Json<'a>,
        view: &Json<'a>,
        offset: &Json,
        count: usize,
    ) -> Result<Place<'a>, LoadError> {
        let views = root.member("bufferViews");
        let at = views.item(view.index("buffer view", views.count())?);
        let size = self.width * self.component.size();
        let stride = at.member("byteStride").whole_or(size as u64)?.max(1);
        let start = offset.whole_or(0)?;
        let length = at.member("byteLength").whole()?;
        let rows = (count as u64).saturating_sub(1).saturating_mul(stride);
        let needed = start.saturating_add(rows).saturating_add(size as u64);
        if count > 0 && needed > length {
            let reason = format!("{count} elements need {needed} bytes, and the view has {length}");
            return Err(view.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
        }
        Ok(Place { view: at, offset: start as usize, stride: stride as usize })
    }

    fn read(self, bytes: &[u8], place: &Place, count: usize, values: &mut Vec<f64>) {
        let size = self.component.size();
        let largest = self.component.largest();
        for i in 0..count {
            for c in 0..self.width {
                let at = place.offset + i * place.stride + c * size;
                let number = self.component.number(bytes.get(at..).unwrap_or(&[]));
                values.push(match self.is_normalized {
                    true => (number / largest).max(-1.0),
                    false => number,
                });
            }
        }
    }
}

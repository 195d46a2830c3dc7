//! Rows of a PLY file's elements.
//!
//! In: a reader at an element's first row. Out: the known properties of all rows; the others are
//! passed over. A vertex whose position is not finite keeps its index and is marked; a row that ends
//! early is one that is left out.

use super::header::{Element, Property};
use super::reader::Reader;
use crate::load::defects::Defects;
use crate::load::error::short;
use crate::load::{LoadError, LoadErrorKind, LoadMemory};
use glam::{DVec2, DVec3, DVec4};
use std::ops::Range;

/// Rows between two looks at the token that cancels.
const ROWS_AT_ONCE: u64 = 4096;
/// The colour of a splat is 1/2 + this times its coefficient of degree 0: 1 / (2 sqrt(pi)).
const HARMONIC: f64 = 0.282_094_791_773_878_14;
/// Colours of real types above this are bytes.
const MOST_REAL: f64 = 1.001;

/// Defects of the rows of a file, by kind.
#[derive(Default)]
pub(super) struct RowDefects {
    /// Lines with more values than their row.
    pub(super) long: Defects,
    /// Rows with fewer values than properties.
    pub(super) cut: Defects,
    /// Positions that are not finite.
    pub(super) positions: Defects,
    /// Other attributes that are not finite.
    pub(super) attributes: Defects,
}

/// Rows of one kind, to which each row read is added.
pub(super) trait Rows {
    /// Names of the known properties, in lower case; a name's slot is its place.
    const NAMES: &'static [&'static [&'static str]];

    /// Prepares for an element with these properties, each with its slot.
    fn begin(&mut self, _properties: &[(Option<usize>, &Property)]) {}

    /// Takes a number of a known property, or of its list.
    fn take(&mut self, slot: usize, value: f64);

    /// Ends a row, which began at this place; `is_whole` is false if it ended early.
    fn end(&mut self, reader: &Reader, place: u64, is_whole: bool, defects: &mut RowDefects);
}

/// Reads the rows of an element.
///
/// # Errors
/// If the file ends before its rows do, a list has no length, or `memory` is cancelled.
pub(super) fn read<R: Rows>(
    reader: &mut Reader,
    element: &Element,
    rows: &mut R,
    defects: &mut RowDefects,
    memory: &LoadMemory,
) -> Result<(), LoadError> {
    let slot_of = |p: &Property| R::NAMES.iter().position(|names| names.contains(&p.name.as_str()));
    let properties: Vec<_> = element.properties.iter().map(|p| (slot_of(p), p)).collect();
    rows.begin(&properties);
    for number in 0..element.count {
        reader.begin_row();
        let place = reader.place();
        let refuse = |reader: &Reader, kind| LoadError::new(reader.position(place), kind);
        if number.is_multiple_of(ROWS_AT_ONCE) {
            memory.check_cancelled().map_err(|kind| refuse(reader, kind))?;
        }
        let is_whole = row(reader, &properties, rows).map_err(|kind| refuse(reader, kind))?;
        if !is_whole {
            let name = short(&element.name);
            if !reader.has_row_each() {
                let count = element.count;
                let reason = format!("the file ends in row {} of {count} of {name:?}", number + 1);
                let kind = LoadErrorKind::Undecodable { format: "PLY", reason };
                return Err(refuse(reader, kind));
            }
            let reason = format!("a row of {name:?} with fewer values than its properties take");
            defects.cut.note(|| refuse(reader, LoadErrorKind::Undecodable { format: "PLY", reason }));
        }
        rows.end(reader, place, is_whole, defects);
        if reader.end_row() && is_whole {
            let reason =
                || format!("a row of {:?} with more values than its properties take", short(&element.name));
            defects
                .long
                .note(|| refuse(reader, LoadErrorKind::Undecodable { format: "PLY", reason: reason() }));
        }
    }
    Ok(())
}

/// Reads one row. Returns false if it ends early.
fn row(
    reader: &mut Reader,
    properties: &[(Option<usize>, &Property)],
    rows: &mut impl Rows,
) -> Result<bool, LoadErrorKind> {
    for (slot, property) in properties {
        let count = match property.length {
            None => 1,
            Some(length) => match reader.length(length, property.scalar)? {
                Some(count) => count,
                None => return Ok(false),
            },
        };
        for _ in 0..count {
            let Some(value) = reader.number(property.scalar) else { return Ok(false) };
            if let Some(slot) = slot {
                rows.take(*slot, value);
            }
        }
    }
    Ok(true)
}

/// Rows of an element that is left out.
pub(super) struct Skipped;

impl Rows for Skipped {
    const NAMES: &'static [&'static [&'static str]] = &[];

    fn take(&mut self, _: usize, _: f64) {}

    fn end(&mut self, _: &Reader, _: u64, _: bool, _: &mut RowDefects) {}
}

/// Returns the error for a number that is not finite.
fn not_finite(reader: &Reader, place: u64, what: &'static str, values: &[f64]) -> LoadError {
    let found = values.iter().find(|x| !x.is_finite()).map_or_else(String::new, f64::to_string);
    LoadError::new(reader.position(place), LoadErrorKind::Number { what, found })
}

/// Slots of a vertex: position, normal, texture coordinate, colour, coefficients of a splat.
const NORMAL: usize = 3;
const TEXCOORD: usize = 6;
const COLOR: usize = 8;
const ALPHA: usize = 11;
const SPLAT: usize = 12;
const SLOTS: usize = 15;

/// Attributes of the vertices; a list is empty if the properties are not there.
pub(super) struct Vertices {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    pub(super) texcoords: Vec<DVec2>,
    pub(super) colors: Vec<DVec4>,
    /// Indices of the vertices whose positions are not finite, ascending.
    pub(super) unusable: Vec<u32>,
    /// Set if colours of a real type were above 1.
    pub(super) has_bytes: bool,
    /// Set if a vertex element has no x, y and z.
    pub(super) lacks_positions: bool,
    /// The row that is being read; a property that is not there is not finite.
    values: [f64; SLOTS],
    has: [bool; SLOTS],
    full: [f64; SLOTS],
}

impl Default for Vertices {
    fn default() -> Self {
        Vertices {
            positions: Vec::new(),
            normals: Vec::new(),
            texcoords: Vec::new(),
            colors: Vec::new(),
            unusable: Vec::new(),
            has_bytes: false,
            lacks_positions: false,
            values: [f64::NAN; SLOTS],
            has: [false; SLOTS],
            full: [1.0; SLOTS],
        }
    }
}

impl Vertices {
    fn three(&self, first: usize) -> Option<[f64; 3]> {
        let all = first..first + 3;
        self.has[all.clone()]
            .iter()
            .all(|has| *has)
            .then(|| std::array::from_fn(|i| self.values[all.start + i]))
    }

    /// Returns the colour of the row, if it has one.
    fn color(&self) -> Option<DVec4> {
        let part = |slot: usize| self.values[slot] / self.full[slot];
        if self.three(COLOR).is_some() {
            let alpha = if self.has[ALPHA] { part(ALPHA) } else { 1.0 };
            return Some(DVec4::new(part(COLOR), part(COLOR + 1), part(COLOR + 2), alpha));
        }
        let rgb = self.three(SPLAT)?.map(|f| (0.5 + HARMONIC * f).clamp(0.0, 1.0));
        Some(DVec3::from_array(rgb).extend(1.0))
    }
}

impl Rows for Vertices {
    const NAMES: &'static [&'static [&'static str]] = &[
        &["x"],
        &["y"],
        &["z"],
        &["nx", "normal_x"],
        &["ny", "normal_y"],
        &["nz", "normal_z"],
        &["s", "u", "texture_u", "texcoord_u"],
        &["t", "v", "texture_v", "texcoord_v"],
        &["red", "r", "diffuse_red"],
        &["green", "g", "diffuse_green"],
        &["blue", "b", "diffuse_blue"],
        &["alpha", "a", "diffuse_alpha"],
        &["f_dc_0"],
        &["f_dc_1"],
        &["f_dc_2"],
    ];

    fn begin(&mut self, properties: &[(Option<usize>, &Property)]) {
        (self.has, self.full) = ([false; SLOTS], [1.0; SLOTS]);
        for (slot, property) in properties.iter().filter_map(|(slot, p)| Some(((*slot)?, p))) {
            self.has[slot] = true;
            self.full[slot] = property.scalar.full();
        }
        self.lacks_positions |= self.three(0).is_none();
    }

    fn take(&mut self, slot: usize, value: f64) {
        self.values[slot] = value;
    }

    fn end(&mut self, reader: &Reader, place: u64, is_whole: bool, defects: &mut RowDefects) {
        let position = self.three(0).map_or(DVec3::NAN, DVec3::from_array);
        let usable = is_whole && position.is_finite();
        if is_whole && !usable {
            defects.positions.note(|| not_finite(reader, place, "a position", &position.to_array()));
        }
        if !usable {
            self.unusable.push(self.positions.len() as u32);
        }
        self.positions.push(if usable { position } else { DVec3::ZERO });
        let mut is_finite = true;
        if let Some(normal) = self.three(NORMAL).map(DVec3::from_array) {
            is_finite &= normal.is_finite();
            self.normals.push(if normal.is_finite() { normal } else { DVec3::ZERO });
        }
        if self.has[TEXCOORD] && self.has[TEXCOORD + 1] {
            let uv = DVec2::new(self.values[TEXCOORD], self.values[TEXCOORD + 1]);
            is_finite &= uv.is_finite();
            self.texcoords.push(if uv.is_finite() { uv } else { DVec2::ZERO });
        }
        if let Some(color) = self.color() {
            is_finite &= color.is_finite();
            let color = if color.is_finite() { color } else { DVec4::ONE };
            self.has_bytes |= self.full[COLOR] == 1.0 && color.max_element() > MOST_REAL;
            self.colors.push(color);
        }
        if usable && !is_finite {
            let values = self.values;
            defects
                .attributes
                .note(|| not_finite(reader, place, "an attribute of a vertex", &values[NORMAL..]));
        }
        self.values = [f64::NAN; SLOTS];
    }
}

/// Rows that are lists of vertices: faces, or strips of triangles.
#[derive(Default)]
pub(super) struct Lists {
    pub(super) rows: Vec<List>,
    /// Indices of all rows; -1 separates strips.
    pub(super) indices: Vec<i64>,
    /// Texture coordinates of all rows.
    pub(super) texcoords: Vec<DVec2>,
    /// Set if colours of a real type were above 1.
    pub(super) has_bytes: bool,
    /// Rows that were in the file, those left out included.
    pub(super) count: u64,
    /// First number of a pair of texture coordinates.
    s: Option<f64>,
    color: [f64; 4],
    full: [f64; 4],
    texture: f64,
}

/// One row: ranges of the lists, and what it has of its own.
pub(super) struct List {
    /// Place of the row.
    pub(super) place: u64,
    pub(super) indices: Range<usize>,
    pub(super) texcoords: Range<usize>,
    pub(super) color: Option<DVec4>,
    /// Number of its texture.
    pub(super) texture: usize,
}

/// Returns a number as a vertex index; one that is no whole number is out of every range.
fn index(value: f64) -> i64 {
    if value.fract() == 0.0 && value.abs() < 1e15 { value as i64 } else { i64::MIN }
}

impl Rows for Lists {
    const NAMES: &'static [&'static [&'static str]] = &[
        &["vertex_indices", "vertex_index"],
        &["texcoord"],
        &["red", "diffuse_red"],
        &["green", "diffuse_green"],
        &["blue", "diffuse_blue"],
        &["alpha", "diffuse_alpha"],
        &["texnumber"],
    ];

    fn begin(&mut self, properties: &[(Option<usize>, &Property)]) {
        self.full = [1.0; 4];
        for (slot, property) in properties {
            if let Some(slot @ 2..6) = slot {
                self.full[slot - 2] = property.scalar.full();
            }
        }
        (self.color, self.texture) = ([f64::NAN, f64::NAN, f64::NAN, self.full[3]], 0.0);
    }

    fn take(&mut self, slot: usize, value: f64) {
        match slot {
            0 => self.indices.push(index(value)),
            1 => match self.s.take() {
                None => self.s = Some(value),
                Some(s) => self.texcoords.push(DVec2::new(s, value)),
            },
            2..6 => self.color[slot - 2] = value,
            _ => self.texture = value,
        }
    }

    fn end(&mut self, _: &Reader, place: u64, is_whole: bool, _: &mut RowDefects) {
        let begun = self.rows.last().map_or((0, 0), |row| (row.indices.end, row.texcoords.end));
        self.s = None;
        self.count += 1;
        if !is_whole {
            self.indices.truncate(begun.0);
            self.texcoords.truncate(begun.1);
            return;
        }
        let (indices, texcoords) = (begun.0..self.indices.len(), begun.1..self.texcoords.len());
        let color: [f64; 4] = std::array::from_fn(|i| self.color[i] / self.full[i]);
        let color = Some(DVec4::from_array(color)).filter(|c| c.is_finite());
        self.has_bytes |= self.full[0] == 1.0 && color.is_some_and(|c| c.max_element() > MOST_REAL);
        let texture = if self.texture >= 0.0 { self.texture as usize } else { 0 };
        self.rows.push(List { place, indices, texcoords, color, texture });
    }
}

/// Edges: the place of each row, and its two vertices.
#[derive(Default)]
pub(super) struct Edges {
    pub(super) rows: Vec<(u64, [i64; 2])>,
    pub(super) count: u64,
    ends: [i64; 2],
}

impl Rows for Edges {
    const NAMES: &'static [&'static [&'static str]] = &[&["vertex1"], &["vertex2"]];

    fn begin(&mut self, _: &[(Option<usize>, &Property)]) {
        self.ends = [i64::MIN; 2];
    }

    fn take(&mut self, slot: usize, value: f64) {
        self.ends[slot] = index(value);
    }

    fn end(&mut self, _: &Reader, place: u64, is_whole: bool, _: &mut RowDefects) {
        self.count += 1;
        if is_whole {
            self.rows.push((place, self.ends));
        }
    }
}

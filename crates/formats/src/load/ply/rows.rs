//! Rows of a PLY file, as `serde-ply` gives them: each row is a map from property names to numbers
//! and lists, in the header's order.

use glam::{DVec2, DVec3, DVec4};
use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor,
};
use serde_ply::{DeserializeError, PlyReader};
use std::cell::Cell;
use std::fmt;
use std::io::BufRead;
use std::marker::PhantomData;
use std::ops::Range;

/// Rows of one kind, to which each row read is added.
pub(super) trait Rows {
    /// Reads one row; `at` counts the bytes read.
    fn row<'de, M: MapAccess<'de>>(&mut self, map: M, at: &Cell<usize>) -> Result<(), M::Error>;
}

/// Reads the rows of a reader's next element.
pub(super) fn read<R: BufRead>(
    reader: &mut PlyReader<R>,
    rows: &mut impl Rows,
    at: &Cell<usize>,
) -> Result<(), DeserializeError> {
    reader.deserialize_map(Element { rows, at })
}

/// Visitor of an element, of its rows, and of a row.
struct Element<'a, T> {
    rows: &'a mut T,
    at: &'a Cell<usize>,
}

impl<'de, T: Rows> Visitor<'de> for Element<'_, T> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("an element")
    }

    fn visit_map<M: MapAccess<'de>>(self, mut map: M) -> Result<(), M::Error> {
        map.next_value_seed(All(self))
    }
}

struct All<'a, T>(Element<'a, T>);

impl<'de, T: Rows> DeserializeSeed<'de> for All<'_, T> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de, T: Rows> Visitor<'de> for All<'_, T> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("rows")
    }

    fn visit_seq<S: SeqAccess<'de>>(self, mut rows: S) -> Result<(), S::Error> {
        let Element { rows: all, at } = self.0;
        while rows.next_element_seed(One(Element { rows: &mut *all, at }))?.is_some() {}
        Ok(())
    }
}

struct One<'a, T>(Element<'a, T>);

impl<'de, T: Rows> DeserializeSeed<'de> for One<'_, T> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, T: Rows> Visitor<'de> for One<'_, T> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a row")
    }

    fn visit_map<M: MapAccess<'de>>(self, map: M) -> Result<(), M::Error> {
        self.0.rows.row(map, self.0.at)
    }
}

/// Names of a set of properties; a name's number is its place.
trait Names {
    const NAMES: &'static [&'static [&'static str]];
}

/// Number of a property among the known ones; `None` for others.
struct Known<N>(Option<usize>, PhantomData<N>);

impl<'de, N: Names> Deserialize<'de> for Known<N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Name<N>(PhantomData<N>);
        impl<N: Names> Visitor<'_> for Name<N> {
            type Value = Known<N>;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("the name of a property")
            }

            fn visit_bytes<E: Error>(self, name: &[u8]) -> Result<Known<N>, E> {
                let is = |known: &&[&str]| known.iter().any(|k| k.as_bytes() == name);
                Ok(Known(N::NAMES.iter().position(is), PhantomData))
            }
        }
        deserializer.deserialize_any(Name(PhantomData))
    }
}

/// A finite number, and the largest of its type if that has whole numbers, else 1.
#[derive(Clone, Copy, Debug)]
struct Number {
    value: f64,
    full: f64,
}

impl Number {
    /// Returns the number as a part of the largest one.
    fn part(self) -> f64 {
        (self.value / self.full).clamp(0.0, 1.0)
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Any;
        fn whole<E>(value: impl Into<f64>, full: impl Into<f64>) -> Result<Number, E> {
            Ok(Number { value: value.into(), full: full.into() })
        }
        impl Visitor<'_> for Any {
            type Value = Number;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number")
            }

            fn visit_i8<E>(self, v: i8) -> Result<Number, E> {
                whole(v, i8::MAX)
            }

            fn visit_u8<E>(self, v: u8) -> Result<Number, E> {
                whole(v, u8::MAX)
            }

            fn visit_i16<E>(self, v: i16) -> Result<Number, E> {
                whole(v, i16::MAX)
            }

            fn visit_u16<E>(self, v: u16) -> Result<Number, E> {
                whole(v, u16::MAX)
            }

            fn visit_i32<E>(self, v: i32) -> Result<Number, E> {
                whole(v, i32::MAX)
            }

            fn visit_u32<E>(self, v: u32) -> Result<Number, E> {
                whole(v, u32::MAX)
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Number, E> {
                match value.is_finite() {
                    true => Ok(Number { value, full: 1.0 }),
                    false => Err(E::custom(format_args!("expected a finite number, found {value}"))),
                }
            }
        }
        deserializer.deserialize_any(Any)
    }
}

/// Reads a list of numbers: each is given to the function.
struct Items<F>(F);

impl<'de, F: FnMut(Number) -> Result<(), &'static str>> DeserializeSeed<'de> for Items<F> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de, F: FnMut(Number) -> Result<(), &'static str>> Visitor<'de> for Items<F> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a list")
    }

    fn visit_seq<S: SeqAccess<'de>>(mut self, mut items: S) -> Result<(), S::Error> {
        while let Some(number) = items.next_element()? {
            self.0(number).map_err(S::Error::custom)?;
        }
        Ok(())
    }
}

/// Rows of an element that is left out.
pub(super) struct Skipped;

impl Rows for Skipped {
    fn row<'de, M: MapAccess<'de>>(&mut self, mut map: M, _: &Cell<usize>) -> Result<(), M::Error> {
        while map.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(())
    }
}

/// Attributes of the vertices; a list is empty if the properties are not there.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<DVec3>,
    pub(super) normals: Vec<DVec3>,
    pub(super) texcoords: Vec<DVec2>,
    pub(super) colors: Vec<DVec4>,
}

struct OfVertex;

impl Names for OfVertex {
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
    ];
}

impl Rows for Vertices {
    fn row<'de, M: MapAccess<'de>>(&mut self, mut map: M, _: &Cell<usize>) -> Result<(), M::Error> {
        let mut found = [None::<Number>; 12];
        while let Some(Known::<OfVertex>(number, _)) = map.next_key()? {
            match number {
                Some(number) => found[number] = Some(map.next_value()?),
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        let three = |first: usize| Some([found[first]?, found[first + 1]?, found[first + 2]?]);
        let vector = |first| three(first).map(|v| DVec3::from_array(v.map(|n| n.value)));
        let lacks = || M::Error::custom("a vertex has no x, y and z");
        self.positions.push(vector(0).ok_or_else(lacks)?);
        self.normals.extend(vector(3));
        if let (Some(s), Some(t)) = (found[6], found[7]) {
            self.texcoords.push(DVec2::new(s.value, t.value));
        }
        if let Some(rgb) = three(8) {
            let rgb = DVec3::from_array(rgb.map(Number::part));
            self.colors.push(rgb.extend(found[11].map_or(1.0, Number::part)));
        }
        Ok(())
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
}

/// One row: ranges of the lists, and what it has of its own.
pub(super) struct List {
    /// Byte at which the row ends.
    pub(super) at: usize,
    pub(super) indices: Range<usize>,
    pub(super) texcoords: Range<usize>,
    pub(super) color: Option<DVec4>,
}

struct OfList;

impl Names for OfList {
    const NAMES: &'static [&'static [&'static str]] = &[
        &["vertex_indices", "vertex_index"],
        &["texcoord"],
        &["red", "diffuse_red"],
        &["green", "diffuse_green"],
        &["blue", "diffuse_blue"],
        &["alpha", "diffuse_alpha"],
    ];
}

/// Returns a vertex index.
fn index(number: Number) -> Result<i64, &'static str> {
    match number.full > 1.0 {
        true => Ok(number.value as i64),
        false => Err("a vertex index must be of a whole-number type"),
    }
}

impl Rows for Lists {
    fn row<'de, M: MapAccess<'de>>(&mut self, mut map: M, at: &Cell<usize>) -> Result<(), M::Error> {
        let (indices, texcoords) = (self.indices.len(), self.texcoords.len());
        let mut color = [None::<Number>; 4];
        while let Some(Known::<OfList>(number, _)) = map.next_key()? {
            match number {
                Some(0) => {
                    map.next_value_seed(Items(|n| index(n).map(|i| self.indices.push(i))))?;
                }
                Some(1) => {
                    let mut before = None;
                    map.next_value_seed(Items(|n: Number| {
                        match before.take() {
                            Some(s) => self.texcoords.push(DVec2::new(s, n.value)),
                            None => before = Some(n.value),
                        }
                        Ok(())
                    }))?;
                }
                Some(number) => color[number - 2] = Some(map.next_value()?),
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        let color = match color {
            [Some(r), Some(g), Some(b), a] => {
                Some(DVec4::new(r.part(), g.part(), b.part(), a.map_or(1.0, Number::part)))
            }
            _ => None,
        };
        let (indices, texcoords) = (indices..self.indices.len(), texcoords..self.texcoords.len());
        self.rows.push(List { at: at.get(), indices, texcoords, color });
        Ok(())
    }
}

/// Edges: the byte at which each row ends, and its two vertices.
#[derive(Default)]
pub(super) struct Edges(pub(super) Vec<(usize, [i64; 2])>);

struct OfEdge;

impl Names for OfEdge {
    const NAMES: &'static [&'static [&'static str]] = &[&["vertex1"], &["vertex2"]];
}

impl Rows for Edges {
    fn row<'de, M: MapAccess<'de>>(&mut self, mut map: M, at: &Cell<usize>) -> Result<(), M::Error> {
        let mut ends = [None; 2];
        while let Some(Known::<OfEdge>(number, _)) = map.next_key()? {
            match number {
                Some(number) => ends[number] = Some(index(map.next_value()?).map_err(M::Error::custom)?),
                None => drop(map.next_value::<IgnoredAny>()?),
            }
        }
        let [Some(a), Some(b)] = ends else {
            return Err(M::Error::custom("an edge has no vertex1 and vertex2"));
        };
        self.0.push((at.get(), [a, b]));
        Ok(())
    }
}

//! First pass of the line check: vertices, and the keywords of all other statements.

use super::{Lexer, WHAT, WORD};
use crate::load::obj::lines::{Lines, finite, keyword, shown, words};
use crate::load::{FilePosition, LoadError, LoadErrorKind};
use std::io::Write;

/// Scale of the vertex colours of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColorScale {
    /// 1 is full.
    Unit,
    /// 255 is full: one is above 1.
    Bytes,
}

impl ColorScale {
    /// Returns the scale, if any `v` of the file has a colour: then every vertex gets one.
    pub(super) fn of(bytes: &[u8]) -> Option<Self> {
        // Conversions leave numbers that are a little above 1.
        const MOST: f64 = 1.001;
        let mut scale = None;
        for (_, statement) in Lines::new(bytes) {
            let (word, arguments) = keyword(&statement);
            if word != b"v" || words(arguments).nth(5).is_none() {
                continue;
            }
            if words(arguments).skip(3).take(3).any(|c| finite(c).is_some_and(|c| c > MOST)) {
                return Some(ColorScale::Bytes);
            }
            scale = Some(ColorScale::Unit);
        }
        scale
    }

    fn full(self) -> f64 {
        if self == ColorScale::Bytes { 255.0 } else { 1.0 }
    }
}

impl Lexer<'_> {
    /// Handles a statement of the first pass: vertices are passed on; every other statement is
    /// accepted, skipped with a warning, or refused.
    pub(super) fn vertex_statement(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
        match word {
            [] | [b'#', ..] => return Ok(()),
            b"v" => self.position(arguments)?,
            b"vt" => self.vertex(1, arguments, 1..=3)?,
            b"vn" => self.vertex(2, arguments, 3..=3)?,
            b"f" | b"fo" | b"l" | b"p" | b"usemtl" | b"mtllib" | b"o" | b"g" | b"s" => {}
            b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"shadow_obj" | b"trace_obj"
            | b"maplib" | b"usemap" => {}
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm"
            | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech" | b"stech" | b"bsp"
            | b"bzp" | b"cdc" | b"cdp" | b"res" => {
                self.warn_of(word, "is skipped: free-form curves and surfaces are not drawn")
            }
            b"call" | b"csh" => self.warn_of(word, "is skipped: other files and programs are not run"),
            _ => {
                self.first_unknown.get_or_insert((self.line, shown(word)));
                self.warn_of(word, "is not an OBJ statement: it is skipped");
                return Ok(());
            }
        }
        self.known_statements += 1;
        Ok(())
    }

    /// Handles `v x y z`, `v x y z w` or `v x y z r g b`; other numbers after them are left out.
    fn position(&mut self, arguments: &[u8]) -> Result<(), LoadError> {
        let mut values = [f64::NAN; 8];
        let mut count = 0;
        for word in words(arguments).take(8) {
            values[count] = finite(word).unwrap_or(f64::NAN);
            count += 1;
        }
        let weight = if count == 4 { values[3] } else { 1.0 };
        let [x, y, z] = [0, 1, 2].map(|i| values[i] / weight);
        if ![x, y, z].iter().all(|c| c.is_finite()) {
            return self.unusable_vertex(0, arguments, "a position");
        }
        if count == 5 || count > 6 {
            self.warn_of(b"v", "has more numbers than a position and a colour: they are left out");
        }
        self.out.extend_from_slice(b"v");
        if let Some(scale) = self.colors {
            // With a colour, tobj has no place for a weight.
            let color = [3, 4, 5].map(|i| values[i] / scale.full());
            let has_color = count > 5 && color.iter().all(|c| c.is_finite());
            let [r, g, b] = if has_color { color } else { [1.0; 3] };
            write!(self.out, " {x:?} {y:?} {z:?} {r:?} {g:?} {b:?}").expect("memory can be written");
            if !has_color {
                self.warn_of(b"v", "has no colour, others have: white is taken");
            }
        } else {
            for word in words(arguments).take(if count == 4 { 4 } else { 3 }) {
                self.out.push(b' ');
                self.out.extend_from_slice(word);
            }
        }
        self.out.push(b'\n');
        self.count(0)
    }

    /// Passes on a vertex that cannot be used, so that the indices after it keep their meaning.
    fn unusable_vertex(&mut self, list: usize, found: &[u8], what: &'static str) -> Result<(), LoadError> {
        let place = FilePosition::line(self.file_name, self.line);
        let kind = || LoadErrorKind::Number { what, found: shown(found) };
        self.elements.left_out.vertices[list].note(|| LoadError::new(place, kind()));
        // Of a vertex beyond the limit the count below is an error.
        self.unusable[list].push(u32::try_from(self.counts[list]).unwrap_or(u32::MAX));
        let zeros: &[u8] = match (list, self.colors) {
            (0, Some(_)) => b"v 0 0 0 1 1 1\n",
            (0, None) => b"v 0 0 0\n",
            (1, _) => b"vt 0 0\n",
            _ => b"vn 0 0 0\n",
        };
        self.out.extend_from_slice(zeros);
        self.count(list)
    }

    /// Handles `vt` (`list` 1) and `vn` (`list` 2) with one of `counts` numbers.
    fn vertex(
        &mut self,
        list: usize,
        arguments: &[u8],
        counts: std::ops::RangeInclusive<usize>,
    ) -> Result<(), LoadError> {
        let count = words(arguments).count();
        let most = *counts.end();
        let is_usable = count >= *counts.start() && words(arguments).take(most).all(|w| finite(w).is_some());
        if !is_usable {
            return self.unusable_vertex(list, arguments, ["", "a texture coordinate", "a normal"][list]);
        }
        if count > most {
            self.warn_of(WORD[list], &format!("has more numbers than a {}: they are left out", WHAT[list]));
        }
        self.out.extend_from_slice(WORD[list]);
        // The third number of a texture coordinate is depth, which pictures do not have.
        for word in words(arguments).take(if list == 1 { 2 } else { most }) {
            self.out.push(b' ');
            self.out.extend_from_slice(word);
        }
        if list == 1 && count == 1 {
            self.out.extend_from_slice(b" 0");
        }
        self.out.push(b'\n');
        self.count(list)
    }

    /// Counts a vertex, up to the limit of 32-bit indices.
    fn count(&mut self, list: usize) -> Result<(), LoadError> {
        self.counts[list] += 1;
        let (found, limit) = (self.counts[list], u64::from(u32::MAX - 1));
        match found > limit {
            true => Err(self.refuse(LoadErrorKind::TooBig { what: "vertices", found, limit })),
            false => Ok(()),
        }
    }
}

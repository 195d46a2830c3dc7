//! First pass of the line check: vertices, and the keywords of all other statements.

use super::{Lexer, WHAT, WORD};
use crate::load::obj::lines::{Lines, keyword, number, shown, words};
use crate::load::{LoadError, LoadErrorKind};
use std::io::Write;

impl Lexer<'_> {
    /// Handles a statement of the first pass: vertices are passed on; every other statement is
    /// accepted, skipped with a warning, or refused.
    pub(super) fn vertex_statement(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
        match word {
            [] | [b'#', ..] => return Ok(()),
            b"v" => self.position(arguments)?,
            b"vt" => self.vertex(1, arguments, 1..=3, "1 to 3 numbers")?,
            b"vn" => self.vertex(2, arguments, 3..=3, "3 numbers")?,
            b"f" | b"fo" | b"l" | b"p" | b"usemtl" | b"mtllib" | b"o" | b"g" | b"s" => {}
            b"mg" | b"lod" | b"bevel" | b"c_interp" | b"d_interp" | b"shadow_obj" | b"trace_obj"
            | b"maplib" | b"usemap" => {}
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm"
            | b"trim" | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech" | b"stech" | b"bsp"
            | b"bzp" | b"cdc" | b"cdp" | b"res" => {
                self.warn_of(word, "is skipped: free-form curves and surfaces are not drawn")
            }
            b"call" | b"csh" => self.warn_of(word, "is skipped: other files and programs are not run"),
            [first, ..] if first.is_ascii_alphabetic() => {
                self.first_unknown.get_or_insert((self.line, shown(word)));
                self.warn_of(word, "is not an OBJ statement: it is skipped");
                return Ok(());
            }
            _ => return Err(self.syntax("expected an OBJ statement", word)),
        }
        self.known_statements += 1;
        Ok(())
    }

    /// Handles `v x y z`, `v x y z w` or `v x y z r g b`.
    fn position(&mut self, arguments: &[u8]) -> Result<(), LoadError> {
        let mut values = [0.0; 8];
        let mut count = 0;
        let mut list = words(arguments);
        for word in list.by_ref().take(8) {
            values[count] = number(word, "a coordinate", || self.place())?;
            count += 1;
        }
        let mut used = 3;
        match count {
            3 => {}
            4 => {
                used = 4;
                if values[3] == 0.0 || values[..3].iter().any(|c| !(c / values[3]).is_finite()) {
                    let found = shown(arguments);
                    let what = "a position divided by its weight";
                    return Err(self.refuse(LoadErrorKind::Number { what, found }));
                }
            }
            6 | 7 => {
                used = 6;
                if count == 7 {
                    self.warn_of(b"v", "has a 7th number: it is left out");
                }
            }
            _ => {
                let expected = "a position has 3 numbers, 4 with a weight, 6 with a colour";
                return Err(self.syntax(expected, arguments));
            }
        }
        let weight = if used == 4 { values[3] } else { 1.0 };
        self.out.extend_from_slice(b"v");
        if self.has_colors {
            // With a colour, tobj has no place for a weight.
            for c in &values[..3] {
                write!(self.out, " {:?}", c / weight).expect("memory can be written");
            }
            match used {
                6 => values[3..6]
                    .iter()
                    .for_each(|c| write!(self.out, " {c:?}").expect("memory can be written")),
                _ => self.out.extend_from_slice(b" 1 1 1"),
            }
            if used != 6 {
                self.warn_of(b"v", "has no colour, others have: white is taken");
            }
        } else {
            for word in words(arguments).take(used) {
                self.out.push(b' ');
                self.out.extend_from_slice(word);
            }
        }
        self.out.push(b'\n');
        self.count(0)
    }

    /// Handles `vt` (`list` 1) and `vn` (`list` 2) with one of `counts` numbers.
    fn vertex(
        &mut self,
        list: usize,
        arguments: &[u8],
        counts: std::ops::RangeInclusive<usize>,
        expected: &str,
    ) -> Result<(), LoadError> {
        self.out.extend_from_slice(WORD[list]);
        let mut count = 0;
        for word in words(arguments) {
            number(word, "a coordinate", || self.place())?;
            // The third number of a texture coordinate is depth, which pictures do not have.
            if list != 1 || count < 2 {
                self.out.push(b' ');
                self.out.extend_from_slice(word);
            }
            count += 1;
        }
        if !counts.contains(&count) {
            return Err(self.syntax(&format!("a {} has {expected}", WHAT[list]), arguments));
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

/// Returns whether any `v` of the file has a colour: then every vertex gets one.
pub(super) fn has_colors(bytes: &[u8]) -> bool {
    Lines::new(bytes).any(|(_, statement)| {
        let (word, arguments) = keyword(&statement);
        word == b"v" && words(arguments).nth(5).is_some()
    })
}

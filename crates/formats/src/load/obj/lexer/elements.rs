//! Second pass of the line check: elements, their indices and their state (`usemtl`, `s`).

use super::{Element, ElementKind, Lexer, WHAT, WORD};
use crate::load::obj::lines::{text, words};
use crate::load::smooth::UNGROUPED;
use crate::load::{LoadError, LoadErrorKind};

/// Most points of one element of a cloud.
pub(in crate::load::obj) const POINTS: u64 = 64;

impl Lexer<'_> {
    /// Handles a statement of the second pass: elements are passed on with their indices checked;
    /// vertices are counted for relative indices.
    pub(super) fn element_statement(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
        match word {
            b"v" => self.counts[0] += 1,
            b"vt" => self.counts[1] += 1,
            b"vn" => self.counts[2] += 1,
            b"f" | b"fo" => self.element(ElementKind::Face, arguments, 3, "a face has at least 3 corners")?,
            b"l" => self.element(ElementKind::Line, arguments, 2, "a line has at least 2 points")?,
            b"p" => {
                self.element(ElementKind::Points, arguments, 1, "a point element has at least 1 point")?
            }
            b"usemtl" => {
                let name = text(arguments).trim().to_owned();
                let next = self.elements.uses.len() as u32;
                self.material_use = *self.use_numbers.entry(name.clone()).or_insert(next);
                if self.material_use == next {
                    self.elements.uses.push((name, self.line));
                }
            }
            b"s" => self.smoothing_group = smoothing_group(arguments),
            b"mtllib" => {
                let names = text(arguments).trim().to_owned();
                match names.is_empty() {
                    true => self.warn_of(b"mtllib", "names no file: it is left out"),
                    false => self.elements.libraries.push((names, self.line)),
                }
            }
            _ => {}
        }
        Ok(())
    }

    /// Checks an element of at least `least` corners, and adds it.
    fn element(
        &mut self,
        kind: ElementKind,
        arguments: &[u8],
        least: usize,
        expected: &str,
    ) -> Result<(), LoadError> {
        let mut corners = std::mem::take(&mut self.corners);
        corners.clear();
        for word in words(arguments) {
            corners.push(self.corner(word)?);
        }
        if corners.len() < least {
            return Err(self.syntax(expected, arguments));
        }
        self.add(kind, &corners)?;
        self.corners = corners;
        Ok(())
    }

    /// Passes on positions from `first` as points, at most [`POINTS`], and returns the next one.
    pub(super) fn cloud(&mut self, first: u32) -> Result<u32, LoadError> {
        let end = self.totals[0].min(u64::from(first) + POINTS) as u32;
        let corners: Vec<_> = (first..end).map(|position| [Some(position), None, None]).collect();
        self.add(ElementKind::Points, &corners)?;
        Ok(end)
    }

    /// Records the properties of an element, and passes it on as `f`.
    fn add(&mut self, kind: ElementKind, corners: &[[Option<u32>; 3]]) -> Result<(), LoadError> {
        self.sizes.add(corners.len(), kind == ElementKind::Face).map_err(|kind| self.refuse(kind))?;
        // An attribute counts only if all corners of the element have it.
        let mut has = [true; 3];
        for list in 1..3 {
            let with = corners.iter().filter(|c| c[list].is_some()).count();
            has[list] = with == corners.len();
            if with != 0 && !has[list] {
                self.warn(format!(
                    "some corners have a {0} and others none: the element has none",
                    WHAT[list]
                ));
            }
        }
        self.out.extend_from_slice(b"f");
        for corner in corners {
            for list in 0..3 {
                self.out.push(if list == 0 { b' ' } else { b'/' });
                if self.totals[list] > 0 {
                    // If the file has the attribute but this element lacks it, tobj gets the index
                    // of the first entry, which is ignored later.
                    let index = corner[list].filter(|_| has[list]).unwrap_or(0);
                    self.elements.order[list].note(index);
                    push_decimal(&mut self.out, index + 1);
                }
            }
        }
        self.out.push(b'\n');
        self.elements.faces.push(Element {
            kind,
            has_texcoords: has[1],
            has_normals: has[2],
            material_use: self.material_use,
            smoothing_group: self.smoothing_group,
        });
        Ok(())
    }

    /// Parses `v`, `v/vt`, `v//vn` or `v/vt/vn` to indices from 0.
    fn corner(&mut self, word: &[u8]) -> Result<[Option<u32>; 3], LoadError> {
        let mut corner = [None; 3];
        for (list, part) in word.split(|b| *b == b'/').enumerate() {
            if list > 2 || (list == 0 && part.is_empty()) {
                return Err(self.syntax("a corner is v, v/vt, v//vn or v/vt/vn", word));
            }
            if part.is_empty() {
                continue;
            }
            if list > 0 && self.totals[list] == 0 && part != b"0" {
                self.warn_of(
                    WORD[list],
                    "is named by corners and stands nowhere in the file: it is left out",
                );
                continue;
            }
            let Some(index) = decimal(part) else {
                return Err(self.syntax("an index is a whole number", part));
            };
            let position = match index {
                1.. => index - 1,
                0 => -1,
                _ => self.counts[list] as i64 + index,
            };
            if position < 0 || position >= self.totals[list] as i64 {
                // A relative index refers to the vertices above it, an absolute one to all of the
                // file.
                let count = if index < 0 { self.counts[list] } else { self.totals[list] };
                return Err(self.refuse(LoadErrorKind::Index { what: WHAT[list], index, count }));
            }
            corner[list] = Some(position as u32);
        }
        Ok(corner)
    }
}

/// Returns the group of an `s` statement: an integer, or 0 for `off`. Another word becomes a group
/// by a hash of its bytes.
fn smoothing_group(arguments: &[u8]) -> u32 {
    match words(arguments).next() {
        None | Some(b"off" | b"0" | b"null") => 0,
        Some(word) => match std::str::from_utf8(word).ok().and_then(|w| w.parse::<u32>().ok()) {
            Some(number) if number < UNGROUPED => number,
            _ => {
                // FNV-1a, mapped to the numbers between the two with special meanings.
                let mix = |hash: u32, byte: &u8| (hash ^ u32::from(*byte)).wrapping_mul(0x0100_0193);
                word.iter().fold(0x811c_9dc5, mix) % (UNGROUPED - 1) + 1
            }
        },
    }
}

/// Parses `[+-]?digits`; a number too long for 64 bits saturates, and is out of every range.
fn decimal(word: &[u8]) -> Option<i64> {
    let (negative, digits) = match word {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let size = digits.iter().fold(0i64, |n, d| n.saturating_mul(10).saturating_add((d - b'0').into()));
    Some(if negative { -size } else { size })
}

fn push_decimal(out: &mut Vec<u8>, mut n: u32) {
    let mut digits = [0; 10];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (n % 10) as u8;
        n /= 10;
        if n == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}

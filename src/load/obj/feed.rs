//! Checked lines, one at a time, for `tobj` to read.
//!
//! The file is walked twice: first `v`, `vt` and `vn`, then `f`, `l` and `p`, so that an element may name a vertex that comes
//! after it, and every index is checked against all that there are, on its own line. Indices are handed on counted from 1.

use super::lines::{Lines, keyword, number, shown, text, words};
use crate::load::{LoadError, LoadErrorKind, LoadWarning, Place};
use std::collections::{HashMap, HashSet};
use std::io::{self, BufRead, Read, Write};

/// What an element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementKind {
    Face,
    Line,
    Points,
}

/// What the check noted of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub(super) kind: ElementKind,
    /// Whether its corners have texture coordinates.
    pub(super) has_texcoords: bool,
    /// Whether its corners have normals.
    pub(super) has_normals: bool,
    /// Which `usemtl`, or `u32::MAX` before the first one.
    pub(super) material_use: u32,
}

/// Which of a list of vertices were used, and in which order first.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstUse {
    /// Indices from 0, in the order of first use: the order in which `tobj` returns what they name.
    pub(super) order: Vec<u32>,
    seen: Vec<bool>,
}

impl FirstUse {
    fn note(&mut self, index: u32) {
        let i = index as usize;
        if i >= self.seen.len() {
            self.seen.resize(i + 1, false);
        }
        if !std::mem::replace(&mut self.seen[i], true) {
            self.order.push(index);
        }
    }

    /// For each used index in order of first use, its rank among the used ones in the file's order.
    pub(super) fn ranks(&self) -> Vec<u32> {
        let before = self.seen.iter().scan(0, |rank, seen| {
            let own = *rank;
            *rank += u32::from(*seen);
            Some(own)
        });
        let ranks: Vec<u32> = before.collect();
        self.order.iter().map(|i| ranks[*i as usize]).collect()
    }
}

/// What the check noted of a whole file.
pub(super) struct Elements {
    /// The elements, in the file's order.
    pub(super) faces: Vec<Element>,
    /// The names that `usemtl` gives, each once, with the line of its first use.
    pub(super) uses: Vec<(String, u32)>,
    /// First uses of positions, texture coordinates and normals.
    pub(super) order: [FirstUse; 3],
    /// What `mtllib` says, with its line.
    pub(super) libraries: Vec<(String, u32)>,
    /// What was skipped.
    pub(super) warnings: Vec<LoadWarning>,
}

/// At most this many warnings of a file are kept.
const MAX_WARNINGS: usize = 100;

/// The sum over large polygons of their corners squared: what cutting them into ears may cost.
const MAX_EAR_WORK: u64 = 4_000_000_000;
/// A polygon with fewer corners costs nothing to speak of.
const LARGE_POLYGON: u64 = 64;

/// The three lists of vertices: their statements, and what they are called.
const WORD: [&[u8]; 3] = [b"v", b"vt", b"vn"];
const WHAT: [&str; 3] = ["position", "texture coordinate", "normal"];

enum Pass {
    Vertices,
    Elements,
    Done,
}

/// The checked lines of a file, as a reader. A line that is refused ends it with an error, kept for [`Feed::take_error`].
pub(super) struct Feed<'a> {
    bytes: &'a [u8],
    file_name: &'a str,
    lines: Lines<'a>,
    line: u32,
    pass: Pass,
    /// The line that is being read, and how far.
    out: Vec<u8>,
    consumed: usize,
    /// Vertices so far: in the second pass, those above the element.
    counts: [u64; 3],
    /// Vertices in the whole file.
    totals: [u64; 3],
    has_colors: bool,
    corner_count: u64,
    ear_work: u64,
    known_statements: u64,
    first_unknown: Option<(u32, String)>,
    warned: HashSet<String>,
    dropped_warnings: u64,
    use_numbers: HashMap<String, u32>,
    material_use: u32,
    corners: Vec<[Option<u32>; 3]>,
    elements: Elements,
    error: Option<LoadError>,
}

impl<'a> Feed<'a> {
    pub(super) fn new(bytes: &'a [u8], file_name: &'a str) -> Self {
        let elements = Elements {
            faces: Vec::new(),
            uses: Vec::new(),
            order: Default::default(),
            libraries: Vec::new(),
            warnings: Vec::new(),
        };
        Feed {
            bytes,
            file_name,
            lines: Lines::new(bytes),
            line: 0,
            pass: Pass::Vertices,
            out: Vec::new(),
            consumed: 0,
            counts: [0; 3],
            totals: [0; 3],
            has_colors: has_colors(bytes),
            corner_count: 0,
            ear_work: 0,
            known_statements: 0,
            first_unknown: None,
            warned: HashSet::new(),
            dropped_warnings: 0,
            use_numbers: HashMap::new(),
            material_use: u32::MAX,
            corners: Vec::new(),
            elements,
            error: None,
        }
    }

    /// The line that was handed out last.
    pub(super) fn place(&self) -> Place {
        Place::line(self.file_name, self.line)
    }

    /// Why the check ended the file early, if it did.
    pub(super) fn take_error(&mut self) -> Option<LoadError> {
        self.error.take()
    }

    /// What was noted, once the file has been read.
    pub(super) fn into_elements(mut self) -> Elements {
        if self.dropped_warnings > 0 {
            let message = format!("{} more warnings are not shown", self.dropped_warnings);
            self.elements.warnings.push(LoadWarning { place: Place::file(self.file_name), message });
        }
        self.elements
    }

    fn refuse(&self, kind: LoadErrorKind) -> LoadError {
        LoadError::new(self.place(), kind)
    }

    fn syntax(&self, expected: &str, found: &[u8]) -> LoadError {
        self.refuse(LoadErrorKind::Syntax { expected: expected.into(), found: shown(found) })
    }

    fn warn(&mut self, message: String) {
        match self.elements.warnings.len() < MAX_WARNINGS {
            true => self.elements.warnings.push(LoadWarning { place: self.place(), message }),
            false => self.dropped_warnings += 1,
        }
    }

    /// Warns once for each keyword and reason.
    fn warn_of(&mut self, keyword: &[u8], why: &str) {
        let message = format!("{:?} {why}", shown(keyword));
        if self.warned.len() >= MAX_WARNINGS {
            self.dropped_warnings += u64::from(!self.warned.contains(&message));
        } else if self.warned.insert(message.clone()) {
            self.warn(message);
        }
    }

    /// Puts the next checked line into `out`; `out` stays empty at the end of the file.
    fn advance(&mut self) -> Result<(), LoadError> {
        self.out.clear();
        self.consumed = 0;
        while self.out.is_empty() {
            let Some((line, statement)) = self.lines.next() else {
                match self.pass {
                    Pass::Vertices => self.begin_elements()?,
                    Pass::Elements | Pass::Done => {
                        self.pass = Pass::Done;
                        return Ok(());
                    }
                }
                continue;
            };
            self.line = line;
            let (word, arguments) = keyword(&statement);
            match self.pass {
                Pass::Vertices => self.vertex_statement(word, arguments)?,
                _ => self.element_statement(word, arguments)?,
            }
        }
        Ok(())
    }

    fn begin_elements(&mut self) -> Result<(), LoadError> {
        if let (0, Some((line, found))) = (self.known_statements, self.first_unknown.take()) {
            let expected = "expected an OBJ statement such as v or f".into();
            let kind = LoadErrorKind::Syntax { expected, found };
            return Err(LoadError::new(Place::line(self.file_name, line), kind));
        }
        self.totals = std::mem::take(&mut self.counts);
        self.lines = Lines::new(self.bytes);
        self.pass = Pass::Elements;
        Ok(())
    }

    /// First pass: vertices are handed on, and every other statement is known, skipped with a warning, or refused.
    fn vertex_statement(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
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

    /// `v x y z`, `v x y z w` or `v x y z r g b`.
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
            // With a colour there is no place for a weight.
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

    /// `vt` and `vn`.
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
            // Of a texture coordinate the third is depth, which pictures do not have.
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

    fn count(&mut self, list: usize) -> Result<(), LoadError> {
        self.counts[list] += 1;
        let (found, limit) = (self.counts[list], u64::from(u32::MAX - 1));
        match found > limit {
            true => Err(self.refuse(LoadErrorKind::TooBig { what: "vertices", found, limit })),
            false => Ok(()),
        }
    }

    /// Second pass: elements are handed on with their indices checked; vertices are counted for relative indices.
    fn element_statement(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
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
                if name.is_empty() {
                    return Err(self.syntax("usemtl is followed by a material's name", arguments));
                }
                let next = self.elements.uses.len() as u32;
                self.material_use = *self.use_numbers.entry(name.clone()).or_insert(next);
                if self.material_use == next {
                    self.elements.uses.push((name, self.line));
                }
            }
            b"mtllib" => {
                let names = text(arguments).trim().to_owned();
                if names.is_empty() {
                    return Err(self.syntax("mtllib is followed by a file's name", arguments));
                }
                self.elements.libraries.push((names, self.line));
            }
            _ => {}
        }
        Ok(())
    }

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
        let n = corners.len() as u64;
        self.corner_count += n;
        let (found, limit) = (self.corner_count, u64::from(u32::MAX - 1));
        if found > limit {
            return Err(self.refuse(LoadErrorKind::TooBig { what: "corners", found, limit }));
        }
        if kind == ElementKind::Face && n > LARGE_POLYGON {
            self.ear_work = self.ear_work.saturating_add(n.saturating_mul(n));
            let (found, limit) = (self.ear_work, MAX_EAR_WORK);
            if found > limit {
                let what = "squared corners of large polygons";
                return Err(self.refuse(LoadErrorKind::TooBig { what, found, limit }));
            }
        }
        // A corner has an attribute where all of its element have it.
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
        for corner in &corners {
            for list in 0..3 {
                self.out.push(if list == 0 { b' ' } else { b'/' });
                if self.totals[list] > 0 {
                    // Where the file has an attribute but this element has not, tobj is given the first: it is not used.
                    let index = corner[list].filter(|_| has[list]).unwrap_or(0);
                    self.elements.order[list].note(index);
                    push_decimal(&mut self.out, index + 1);
                }
            }
        }
        self.out.push(b'\n');
        self.corners = corners;
        self.elements.faces.push(Element {
            kind,
            has_texcoords: has[1],
            has_normals: has[2],
            material_use: self.material_use,
        });
        Ok(())
    }

    /// `v`, `v/vt`, `v//vn` or `v/vt/vn`, as indices from 0.
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
                // A relative index counts what stands above it, an absolute one all there are.
                let count = if index < 0 { self.counts[list] } else { self.totals[list] };
                return Err(self.refuse(LoadErrorKind::Index { what: WHAT[list], index, count }));
            }
            corner[list] = Some(position as u32);
        }
        Ok(corner)
    }
}

/// Whether any `v` of the file has a colour: then all are given one.
fn has_colors(bytes: &[u8]) -> bool {
    Lines::new(bytes).any(|(_, statement)| {
        let (word, arguments) = keyword(&statement);
        word == b"v" && words(arguments).nth(5).is_some()
    })
}

/// `[+-]?digits` as a number; one too long for 64 bits becomes the largest, which names nothing.
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

impl Read for Feed<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl BufRead for Feed<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.consumed == self.out.len()
            && let Err(error) = self.advance()
        {
            self.error = Some(error);
            return Err(io::Error::other("refused by the line check"));
        }
        Ok(&self.out[self.consumed..])
    }

    fn consume(&mut self, amount: usize) {
        self.consumed += amount;
    }
}

//! Line check of OBJ files: a reader that gives `tobj` one checked line at a time.
//!
//! The file is read twice: first `v`, `vt` and `vn`, then `f`, `l` and `p`, so that an element may
//! refer to a vertex after it, and every index is checked against the totals, with its own line
//! number. Indices are passed on as absolute, from 1. If there are no elements, all positions are
//! passed on as points.

mod elements;
mod vertices;

pub(super) use elements::POINTS;

use super::lines::{Lines, keyword, shown};
use crate::load::mesh::PolygonSizes;
use crate::load::smooth::UNGROUPED;
use crate::load::{FilePosition, LoadError, LoadErrorKind, LoadWarning};
use std::collections::{HashMap, HashSet};
use std::io::{self, BufRead, Read};
use vertices::has_colors;

/// Kind of an element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ElementKind {
    Face,
    Line,
    Points,
}

/// Properties of an element, recorded by the check.
#[derive(Clone, Copy, Debug)]
pub(super) struct Element {
    pub(super) kind: ElementKind,
    /// True if its corners have texture coordinates.
    pub(super) has_texcoords: bool,
    /// True if its corners have normals.
    pub(super) has_normals: bool,
    /// Index of the current `usemtl` name, or `u32::MAX` before the first one.
    pub(super) material_use: u32,
    /// Smoothing group set by the last `s`: 0 for `off`, [`UNGROUPED`] before the first one.
    pub(super) smoothing_group: u32,
}

/// Used entries of a vertex list, and the order of their first uses.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstUse {
    /// Indices from 0 in the order of first use: the order in which `tobj` returns the vertices.
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

    /// Returns, for each used index in order of first use, its rank among the used ones in the
    /// file's order.
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

/// Properties of a whole file, recorded by the check.
pub(super) struct Elements {
    /// Elements in the file's order.
    pub(super) faces: Vec<Element>,
    /// Names given by `usemtl`, each once, with the line of its first use.
    pub(super) uses: Vec<(String, u32)>,
    /// First uses of positions, texture coordinates and normals.
    pub(super) order: [FirstUse; 3],
    /// Arguments of each `mtllib`, with its line.
    pub(super) libraries: Vec<(String, u32)>,
    /// Warnings about skipped parts.
    pub(super) warnings: Vec<LoadWarning>,
}

/// Most warnings stored per file.
const MAX_WARNINGS: usize = 100;

/// Keywords and names of the three vertex lists.
const WORD: [&[u8]; 3] = [b"v", b"vt", b"vn"];
const WHAT: [&str; 3] = ["position", "texture coordinate", "normal"];

/// Current pass over the file.
enum Pass {
    Vertices,
    Elements,
    /// Points of a file without elements, with the next position.
    Cloud(u32),
    Done,
}

/// The checked lines of a file, as a reader. An invalid line ends it with an error, which
/// [`Lexer::take_error`] returns.
pub(super) struct Lexer<'a> {
    bytes: &'a [u8],
    file_name: &'a str,
    lines: Lines<'a>,
    line: u32,
    pass: Pass,
    /// Line that is being read, and the number of bytes consumed of it.
    out: Vec<u8>,
    consumed: usize,
    /// Vertices so far: in the second pass, those above the current element.
    counts: [u64; 3],
    /// Vertices of the whole file.
    totals: [u64; 3],
    has_colors: bool,
    sizes: PolygonSizes,
    known_statements: u64,
    first_unknown: Option<(u32, String)>,
    warned: HashSet<String>,
    dropped_warnings: u64,
    use_numbers: HashMap<String, u32>,
    material_use: u32,
    smoothing_group: u32,
    corners: Vec<[Option<u32>; 3]>,
    elements: Elements,
    error: Option<LoadError>,
}

impl<'a> Lexer<'a> {
    pub(super) fn new(bytes: &'a [u8], file_name: &'a str) -> Self {
        let elements = Elements {
            faces: Vec::new(),
            uses: Vec::new(),
            order: Default::default(),
            libraries: Vec::new(),
            warnings: Vec::new(),
        };
        Lexer {
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
            sizes: PolygonSizes::default(),
            known_statements: 0,
            first_unknown: None,
            warned: HashSet::new(),
            dropped_warnings: 0,
            use_numbers: HashMap::new(),
            material_use: u32::MAX,
            smoothing_group: UNGROUPED,
            corners: Vec::new(),
            elements,
            error: None,
        }
    }

    /// Returns the position of the line that was passed on last.
    pub(super) fn place(&self) -> FilePosition {
        FilePosition::line(self.file_name, self.line)
    }

    /// Returns the error that ended the file early, if any.
    pub(super) fn take_error(&mut self) -> Option<LoadError> {
        self.error.take()
    }

    /// Returns the recorded properties, once the file has been read.
    pub(super) fn into_elements(mut self) -> Elements {
        if self.dropped_warnings > 0 {
            let message = format!("{} more warnings are not shown", self.dropped_warnings);
            self.elements.warnings.push(LoadWarning { place: FilePosition::file(self.file_name), message });
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

    /// Warns once for each combination of keyword and reason.
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
                    Pass::Elements if self.elements.faces.is_empty() => self.pass = Pass::Cloud(0),
                    Pass::Cloud(first) if u64::from(first) < self.totals[0] => {
                        self.pass = Pass::Cloud(self.cloud(first)?);
                    }
                    Pass::Elements | Pass::Cloud(_) | Pass::Done => {
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

    /// Starts the second pass. A file with unknown statements only is not OBJ, which is an error.
    fn begin_elements(&mut self) -> Result<(), LoadError> {
        if let (0, Some((line, found))) = (self.known_statements, self.first_unknown.take()) {
            let expected = "expected an OBJ statement such as v or f".into();
            let kind = LoadErrorKind::Syntax { expected, found };
            return Err(LoadError::new(FilePosition::line(self.file_name, line), kind));
        }
        self.totals = std::mem::take(&mut self.counts);
        self.lines = Lines::new(self.bytes);
        self.pass = Pass::Elements;
        Ok(())
    }
}

impl Read for Lexer<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(buffer)?;
        self.consume(read);
        Ok(read)
    }
}

impl BufRead for Lexer<'_> {
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

//! STL as text: keywords and numbers, wherever lines end.
//!
//! In: the bytes of a text. Out: facets, and the defects that were passed over. Programs differ in
//! case, line ends and indentation, write a whole file in one line, join or part keywords
//! (`outerloop`, `end loop`), and leave out `endsolid`; so the text is read word by word, and a
//! keyword alone ends what was before it. Normals are not read at all: some are `nan` or `-1.#IND`.
//! The name after `solid` and `endsolid` goes to the end of the line, or to `facet normal`.

use super::Facets;
use crate::load::defects::{Defects, earliest};
use crate::load::error::short;
use crate::load::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use glam::DVec3;

/// Words between two looks at the token that cancels.
const WORDS_AT_ONCE: u64 = 1 << 16;

/// Words of a text, with the line in which the last one stands.
#[derive(Clone, Copy)]
struct Words<'a> {
    rest: &'a [u8],
    /// Number of the line, from 1.
    line: u32,
}

impl<'a> Words<'a> {
    /// Passes white space and line ends: LF, CR, or both.
    fn pass_blanks(&mut self) {
        while let [byte, rest @ ..] = self.rest
            && (byte.is_ascii_whitespace() || *byte == 0)
        {
            let is_end = *byte == b'\n' || (*byte == b'\r' && rest.first() != Some(&b'\n'));
            self.line = self.line.saturating_add(u32::from(is_end));
            self.rest = rest;
        }
    }

    /// Passes the rest of the line.
    fn pass_line(&mut self) {
        let end = self.rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
        self.rest = &self.rest[end.unwrap_or(self.rest.len())..];
    }

    /// Returns the next word without passing it.
    fn peek(&self) -> Option<&'a [u8]> {
        self.clone().next()
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        self.pass_blanks();
        let end = self.rest.iter().position(|b| b.is_ascii_whitespace() || *b == 0);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        (!word.is_empty()).then_some(word)
    }
}

/// Keywords of the format, in lower case.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keyword {
    Solid,
    EndSolid,
    Facet,
    EndFacet,
    EndLoop,
    Vertex,
    Normal,
    /// `outer`, `loop`, and both in one.
    Loop,
}

fn keyword(word: &[u8]) -> Option<Keyword> {
    const ALL: [(&str, Keyword); 10] = [
        ("solid", Keyword::Solid),
        ("endsolid", Keyword::EndSolid),
        ("facet", Keyword::Facet),
        ("endfacet", Keyword::EndFacet),
        ("endloop", Keyword::EndLoop),
        ("vertex", Keyword::Vertex),
        ("normal", Keyword::Normal),
        ("outer", Keyword::Loop),
        ("loop", Keyword::Loop),
        ("outerloop", Keyword::Loop),
    ];
    ALL.iter().find(|(name, _)| word.eq_ignore_ascii_case(name.as_bytes())).map(|(_, keyword)| *keyword)
}

/// State of reading a text.
struct Text<'a, 'b, 'c> {
    words: Words<'a>,
    facets: &'c mut Facets<'b>,
    /// Corners of the facet that is being read, and the line of its first word.
    corners: Vec<DVec3>,
    facet_line: u32,
    /// Set if a corner of the facet cannot be used.
    is_bad: bool,
    /// Set from `solid` to `endsolid`.
    is_in_solid: bool,
    /// Corners that cannot be read, and facets of another number than three.
    bad_corners: Defects,
    bad_facets: Defects,
    strays: Defects,
    /// Line of the last word that is none of the format's.
    stray_line: u32,
}

/// Reads the facets of a text.
///
/// # Errors
/// If there is no facet that can be drawn and something that cannot be read, or `memory` is
/// cancelled.
pub(super) fn read(
    bytes: &[u8],
    facets: &mut Facets<'_>,
    memory: &LoadMemory,
    warnings: &mut Vec<LoadWarning>,
) -> Result<(), LoadError> {
    let mut text = Text {
        words: Words { rest: bytes, line: 1 },
        facets,
        corners: Vec::new(),
        facet_line: 0,
        is_bad: false,
        is_in_solid: false,
        bad_corners: Defects::default(),
        bad_facets: Defects::default(),
        strays: Defects::default(),
        stray_line: 0,
    };
    let mut count = 0_u64;
    while let Some(word) = text.words.next() {
        if count.is_multiple_of(WORDS_AT_ONCE) {
            memory.check_cancelled().map_err(|kind| text.refuse(kind))?;
        }
        count += 1;
        text.word(word)?;
    }
    text.end_facet()?;
    let Text { words, facets, is_in_solid, bad_corners, bad_facets, strays, .. } = text;
    if facets.mesh.polygons.is_empty()
        && let Some(error) = earliest([&bad_corners, &bad_facets, &strays])
    {
        return Err(error);
    }
    warnings.extend(bad_corners.warning("the facet is left out"));
    warnings.extend(bad_facets.warning("one of fewer is left out"));
    warnings.extend(strays.warning("other words of its line are left out"));
    if is_in_solid {
        let place = FilePosition::line(facets.file_name, words.line);
        warnings.push(LoadWarning { place, message: "the text ends without endsolid".into() });
    }
    Ok(())
}

impl Text<'_, '_, '_> {
    fn place(&self) -> FilePosition {
        FilePosition::line(self.facets.file_name, self.words.line)
    }

    fn refuse(&self, kind: LoadErrorKind) -> LoadError {
        LoadError::new(self.place(), kind)
    }

    /// Handles a word.
    fn word(&mut self, word: &[u8]) -> Result<(), LoadError> {
        let mut known = keyword(word);
        if word.eq_ignore_ascii_case(b"end")
            && let Some(part) = self.words.peek()
            && let Some(joined) = keyword(&[b"end", part].concat())
        {
            self.words.next();
            known = Some(joined);
        }
        match known {
            Some(Keyword::Facet) => {
                self.end_facet()?;
                self.facet_line = self.words.line;
            }
            Some(Keyword::EndFacet | Keyword::EndLoop) => self.end_facet()?,
            Some(begin @ (Keyword::Solid | Keyword::EndSolid)) => {
                self.end_facet()?;
                self.is_in_solid = begin == Keyword::Solid;
                self.pass_name();
            }
            Some(Keyword::Vertex) => self.vertex(),
            Some(Keyword::Normal) => {
                for _ in 0..3 {
                    if self.words.peek().is_some_and(|word| keyword(word).is_none()) {
                        self.words.next();
                    }
                }
            }
            Some(Keyword::Loop) => {}
            None if word.starts_with(b"#") || word.starts_with(b";") || word.starts_with(b"//") => {
                self.words.pass_line();
            }
            None => self.stray(word),
        }
        Ok(())
    }

    /// Passes the name of a solid, which may be any words in any encoding.
    fn pass_name(&mut self) {
        let line = self.words.line;
        loop {
            let before = self.words;
            let Some(word) = self.words.next() else { return };
            let is_facet = keyword(word) == Some(Keyword::Facet)
                && self.words.peek().and_then(keyword) == Some(Keyword::Normal);
            let is_keyword = matches!(keyword(word), Some(Keyword::EndSolid | Keyword::Vertex));
            if self.words.line != line || is_facet || is_keyword {
                self.words = before;
                return;
            }
        }
    }

    /// Reads the three numbers of a corner.
    fn vertex(&mut self) {
        let mut corner = [0.0_f32; 3];
        for number in &mut corner {
            let word = self.words.peek().filter(|word| keyword(word).is_none());
            let Some(word) = word else {
                let found = String::from_utf8_lossy(self.words.peek().unwrap_or(b"the end")).into_owned();
                let error =
                    self.refuse(LoadErrorKind::Number { what: "a facet's corner", found: short(&found) });
                self.bad_corners.note(|| error);
                self.is_bad = true;
                return;
            };
            self.words.next();
            let parsed = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f32>().ok());
            match parsed.filter(|x| x.is_finite()) {
                Some(x) => *number = x,
                None => {
                    // One count for each facet.
                    if !std::mem::replace(&mut self.is_bad, true) {
                        let found = short(&String::from_utf8_lossy(word));
                        let error = self.refuse(LoadErrorKind::Number { what: "a facet's corner", found });
                        self.bad_corners.note(|| error);
                    }
                }
            }
        }
        self.corners.push(DVec3::from_array(corner.map(f64::from)));
    }

    /// Adds the facet whose corners were read, if there is one.
    fn end_facet(&mut self) -> Result<(), LoadError> {
        let count = self.corners.len();
        if count > 0 && count != 3 && !self.is_bad {
            let kind = LoadErrorKind::Syntax {
                expected: "expected 3 corners in a facet".into(),
                found: count.to_string(),
            };
            let error = LoadError::new(FilePosition::line(self.facets.file_name, self.facet_line), kind);
            self.bad_facets.note(|| error);
        }
        if count >= 3 && !self.is_bad {
            self.facets.push(&self.corners).map_err(|kind| self.refuse(kind))?;
        }
        self.corners.clear();
        self.is_bad = false;
        Ok(())
    }

    /// Notes a word that is none of the format's, once a line.
    fn stray(&mut self, word: &[u8]) {
        if std::mem::replace(&mut self.stray_line, self.words.line) != self.words.line {
            let found = short(&String::from_utf8_lossy(word));
            let expected = "expected a keyword of STL".into();
            let error = self.refuse(LoadErrorKind::Syntax { expected, found });
            self.strays.note(|| error);
        }
    }
}

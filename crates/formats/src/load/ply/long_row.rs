//! Lines of a text with more values than the header's properties.
//!
//! In: an element, and the text of the rows that were read up to an error. Out: the first line that
//! is too long for its row, which shifts all values after it, so that the error itself stands at a
//! later place. Lines of several whole rows are none, and where a row goes on in the next line
//! nothing is known.

use crate::load::error::short;
use serde_ply::{ElementDef, PropertyType};
use std::ops::Range;

/// Returns the byte after the first one of such a line, and the reason to refuse it.
pub(super) fn find(element: &ElementDef, bytes: &[u8], rows: Range<usize>) -> Option<(usize, String)> {
    let mut at = rows.start;
    // The last line is searched to its end, though it was read up to the error alone.
    for line in bytes.get(rows.start..)?.split_inclusive(|b| *b == b'\n') {
        if at >= rows.end {
            break;
        }
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).peekable();
        let found = words.clone().count();
        let mut expected = None;
        while words.peek().is_some() {
            match (take_row(element, &mut words), expected) {
                (Some(taken), None) => expected = Some(taken),
                (Some(_), Some(_)) => {}
                (None, None) => return None,
                (None, Some(expected)) => {
                    let name = short(&element.name);
                    let row = format!("a row of {name:?} with {found} values");
                    return Some((at + 1, format!("{row}, and its properties take {expected} of them")));
                }
            }
        }
        at += line.len();
    }
    None
}

/// Takes the words of one row, and returns their number; `None` if there are too few, or the length
/// of a list is no number.
fn take_row<'a>(element: &ElementDef, words: &mut impl Iterator<Item = &'a [u8]>) -> Option<usize> {
    let mut taken = 0;
    for property in &element.properties {
        let first = words.next()?;
        taken += 1;
        if let PropertyType::List { .. } = property.property_type {
            let length: usize = std::str::from_utf8(first).ok()?.parse().ok()?;
            for _ in 0..length {
                words.next()?;
            }
            taken += length;
        }
    }
    Some(taken)
}

//! Many figures of one kind in one call, from arrays of numbers.
//!
//! In: the numbers of all figures, row by row, and one colour or one for each. Out: the command of
//! each. Right is what the verb draws with the same numbers, called once for each row: the tests
//! compare the pictures.

use fbptr::command::{Command, Figure, RampColor, RealRect};
use pyo3::buffer::{Element, PyBuffer};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Kinds of figures that batches have.
#[derive(Clone, Copy)]
enum Kind {
    Pixel,
    Line,
    Rect,
    Disc,
}

/// Figures of one kind.
pub struct Batch {
    kind: Kind,
    numbers: Vec<f64>,
    colors: Vec<[u8; 4]>,
}

impl Batch {
    /// Takes the numbers of figures of the kind `points`, `lines`, `rects` or `discs`, and their
    /// colours as bytes R, G, B, A.
    ///
    /// # Errors
    /// `ValueError` if the numbers are no whole rows, or there is neither one colour nor one a row.
    pub fn new(kind: &str, numbers: &Bound<'_, PyAny>, colors: &Bound<'_, PyAny>) -> PyResult<Self> {
        let kind = match kind {
            "points" => Kind::Pixel,
            "lines" => Kind::Line,
            "rects" => Kind::Rect,
            _ => Kind::Disc,
        };
        let numbers: Vec<f64> = elements(numbers)?;
        let bytes: Vec<u8> = elements(colors)?;
        let (colors, rest) = bytes.as_chunks::<4>();
        let batch = Batch { kind, numbers, colors: colors.to_vec() };
        let (per, count) = (batch.per(), batch.len());
        if !batch.numbers.len().is_multiple_of(per) {
            let message = format!("each takes {per} numbers, got {} in all", batch.numbers.len());
            return Err(PyValueError::new_err(message));
        }
        if !rest.is_empty() || colors.len() != 1 && colors.len() != count {
            let message = format!("one colour or one for each of {count}, got {}", colors.len());
            return Err(PyValueError::new_err(message));
        }
        if let Some((row, number)) = batch.unusable() {
            let needs = if batch.is_whole() { "whole numbers of 32 bits" } else { "finite numbers" };
            return Err(PyValueError::new_err(format!("row {row}: expected {needs}, got {number}")));
        }
        Ok(batch)
    }

    /// Returns whether the verb takes whole numbers.
    fn is_whole(&self) -> bool {
        matches!(self.kind, Kind::Pixel | Kind::Line)
    }

    /// Returns the first number that the verb would refuse, and its row.
    fn unusable(&self) -> Option<(usize, f64)> {
        let range = f64::from(i32::MIN)..=f64::from(i32::MAX);
        let is_whole = |v: f64| v.fract() == 0.0 && range.contains(&v);
        let is_usable = |v: &f64| if self.is_whole() { is_whole(*v) } else { v.is_finite() };
        let at = self.numbers.iter().position(|v| !is_usable(v))?;
        Some((at / self.per(), self.numbers[at]))
    }

    /// Returns the numbers that one figure takes.
    fn per(&self) -> usize {
        match self.kind {
            Kind::Pixel => 2,
            Kind::Disc => 3,
            Kind::Line | Kind::Rect => 4,
        }
    }

    /// Returns the number of figures.
    pub fn len(&self) -> usize {
        self.numbers.len() / self.per()
    }

    /// Returns the commands in the order of the rows.
    pub fn commands(&self) -> impl Iterator<Item = Command> + '_ {
        // They are whole: `new` refuses others.
        let whole = |v: f64| v as i32;
        self.numbers.chunks_exact(self.per()).enumerate().map(move |(i, row)| {
            let color = self.colors[if self.colors.len() == 1 { 0 } else { i }];
            let figure = match *row {
                [x, y] => return Command::Pixel { x: whole(x), y: whole(y), color },
                [cx, cy, r] => Figure::FillCircle { cx, cy, r, color },
                _ => match self.kind {
                    Kind::Line => Figure::Line {
                        p0: [whole(row[0]), whole(row[1])],
                        p1: [whole(row[2]), whole(row[3])],
                        color: RampColor::from(color),
                    },
                    _ => Figure::FillRect {
                        rect: RealRect { x: row[0], y: row[1], w: row[2], h: row[3] },
                        color,
                    },
                },
            };
            Command::Figure(figure)
        })
    }
}

/// Copies the elements of a buffer of this type.
fn elements<T: Element>(from: &Bound<'_, PyAny>) -> PyResult<Vec<T>> {
    PyBuffer::<T>::get(from)?.to_vec(from.py())
}

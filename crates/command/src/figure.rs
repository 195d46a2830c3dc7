//! Drawing of figures: calls the function that a figure's row of the verb table names.
//!
//! In: a figure. Out: its pixels on a target, or the reason for which it was refused. The table's
//! macros implement it.

use fbptr_core::draw2d::{AreaColors, DrawError, FigureTarget, RampColor, RealRect, Rect};

/// A figure that can be drawn on a target.
#[doc(hidden)]
pub trait DrawFigure {
    /// Draws it within the window of rows of the target's memory.
    fn draw(&self, target: &mut FigureTarget<'_>) -> Result<(), DrawError>;
}

impl<T: DrawFigure> DrawFigure for &T {
    fn draw(&self, target: &mut FigureTarget<'_>) -> Result<(), DrawError> {
        T::draw(self, target)
    }
}

/// A return type of a figure's function.
pub(super) trait Drawn {
    /// Returns it as a result.
    fn drawn(self) -> Result<(), DrawError>;
}

impl Drawn for () {
    fn drawn(self) -> Result<(), DrawError> {
        Ok(())
    }
}

impl Drawn for Result<(), DrawError> {
    fn drawn(self) -> Result<(), DrawError> {
        self
    }
}

/// An argument of a figure, lent to the function that draws it: a list by reference, all else by
/// value. A figure that is drawn in
/// bands is kept.
pub(super) trait Lend {
    /// Its type as a parameter.
    type Lent<'a>
    where
        Self: 'a;

    /// Lends it.
    fn lend(&self) -> Self::Lent<'_>;
}

impl<T> Lend for Vec<T> {
    type Lent<'a>
        = &'a [T]
    where
        T: 'a;

    fn lend(&self) -> &[T] {
        self
    }
}

impl Lend for String {
    type Lent<'a> = &'a str;

    fn lend(&self) -> &str {
        self
    }
}

macro_rules! lend_by_value {
    ($($type:ty),*) => {
        $(impl Lend for $type {
            type Lent<'a> = $type;

            fn lend(&self) -> $type {
                *self
            }
        })*
    };
}

lend_by_value!(bool, i32, f64, [i32; 2], [f64; 2], [[i32; 2]; 3], [[f64; 2]; 3], [[f64; 2]; 4]);
lend_by_value!([u8; 4], Rect, RealRect, RampColor, AreaColors);

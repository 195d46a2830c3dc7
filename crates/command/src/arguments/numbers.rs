//! Whole numbers, reals, vectors, rectangles, and lists of them.

use super::keywords::take_keyword;
use super::{Argument, TextArgument, finite, from_zero};
use crate::args::{Args, ParseError};
use crate::commands::{RealRect, Rect};
use crate::encode::{EncodeError, LineWriter};
use crate::plain_line::PlainWords;
use crate::verb::{Arity, ParameterKind};
use fbptr_core::error::{Code, Fault};
use glam::{DMat4, DVec3};

impl Argument for i32 {
    type Value = i32;
    const KIND: ParameterKind = ParameterKind::Integer;
    const WORDS: Arity = Arity::ONE;

    fn write(value: &i32, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.word(value);
        Ok(())
    }
}

impl TextArgument for i32 {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<i32, ParseError> {
        args.int()
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<i32> {
        words.int()
    }
}

impl Argument for f64 {
    type Value = f64;
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::ONE;

    fn check_numbers(value: &f64) -> Result<(), Fault> {
        finite(&[*value])
    }

    fn write(value: &f64, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.reals(&[*value]);
        Ok(())
    }
}

impl TextArgument for f64 {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<f64, ParseError> {
        args.real()
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<f64> {
        words.real()
    }
}

/// An angle in radians, or in degrees before `deg`.
pub struct Angle;

impl Argument for Angle {
    type Value = f64;
    const KIND: ParameterKind = ParameterKind::Angle;
    const WORDS: Arity = Arity::ONE;

    fn check_numbers(value: &f64) -> Result<(), Fault> {
        f64::check_numbers(value)
    }

    fn write(value: &f64, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        f64::write(value, line)
    }
}

impl TextArgument for Angle {
    fn read(args: &mut Args<'_>) -> Result<f64, ParseError> {
        args.angle()
    }
}

/// Two angles, each as [`Angle`].
pub struct Angles;

impl Argument for Angles {
    type Value = [f64; 2];
    const KIND: ParameterKind = ParameterKind::Angle;
    const WORDS: Arity = Arity::exactly(2);

    fn check_numbers(angles: &[f64; 2]) -> Result<(), Fault> {
        finite(angles)
    }

    fn write(angles: &[f64; 2], line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.reals(angles);
        Ok(())
    }
}

impl TextArgument for Angles {
    fn read(args: &mut Args<'_>) -> Result<[f64; 2], ParseError> {
        Ok([args.angle()?, args.angle()?])
    }
}

/// Two radii in reals.
pub struct Radii;

impl Argument for Radii {
    type Value = [f64; 2];
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::exactly(2);

    fn check_numbers(radii: &[f64; 2]) -> Result<(), Fault> {
        finite(radii)
    }

    fn check_sizes(radii: &[f64; 2]) -> Result<(), Fault> {
        radii.iter().try_for_each(|radius| from_zero("radius", *radius))
    }

    fn write(radii: &[f64; 2], line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.reals(radii);
        Ok(())
    }
}

impl TextArgument for Radii {
    fn read(args: &mut Args<'_>) -> Result<[f64; 2], ParseError> {
        args.reals()
    }

    fn read_plain(words: &mut PlainWords<'_>) -> Option<[f64; 2]> {
        <[f64; 2]>::read_plain(words)
    }
}

/// A time in seconds: 0 to 60.
pub struct Seconds;

impl Argument for Seconds {
    type Value = f64;
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::ONE;

    fn check_numbers(seconds: &f64) -> Result<(), Fault> {
        finite(&[*seconds])
    }

    fn check_sizes(seconds: &f64) -> Result<(), Fault> {
        match (0.0..=60.0).contains(seconds) {
            true => Ok(()),
            false => Err(Fault::new(Code::Range, "the seconds must be 0 to 60").got(seconds.to_string())),
        }
    }

    fn write(seconds: &f64, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        f64::write(seconds, line)
    }
}

impl TextArgument for Seconds {
    fn read(args: &mut Args<'_>) -> Result<f64, ParseError> {
        args.real()
    }
}

/// Magnification of letters: 1 to 8.
pub struct TextScale;

impl Argument for TextScale {
    type Value = i32;
    const KIND: ParameterKind = ParameterKind::Keyword(&["1", "2", "3", "4", "5", "6", "7", "8"]);
    const WORDS: Arity = Arity::ONE;

    fn check_sizes(size: &i32) -> Result<(), Fault> {
        match (1..=8).contains(size) {
            true => Ok(()),
            false => Err(Fault::new(Code::Range, "the size must be 1 to 8").got(size.to_string())),
        }
    }

    fn write(size: &i32, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        i32::write(size, line)
    }
}

impl TextArgument for TextScale {
    fn read(args: &mut Args<'_>) -> Result<i32, ParseError> {
        args.int()
    }
}

/// Defines a number that must not be negative.
macro_rules! size {
    ($(#[$doc:meta])* $name:ident: $type:ty, $what:literal) => {
        $(#[$doc])*
        pub struct $name;

        impl Argument for $name {
            type Value = $type;
            const KIND: ParameterKind = <$type>::KIND;
            const WORDS: Arity = Arity::ONE;

            fn check_numbers(value: &$type) -> Result<(), Fault> {
                <$type>::check_numbers(value)
            }

            fn check_sizes(value: &$type) -> Result<(), Fault> {
                from_zero($what, *value)
            }

            fn write(value: &$type, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
                <$type>::write(value, line)
            }
        }

        impl TextArgument for $name {
            #[inline]
            fn read(args: &mut Args<'_>) -> Result<$type, ParseError> {
                <$type>::read(args)
            }

            #[inline]
            fn read_plain(words: &mut PlainWords<'_>) -> Option<$type> {
                <$type>::read_plain(words)
            }
        }
    };
}

size! {
    /// A radius in pixels.
    Radius: i32, "radius"
}
size! {
    /// A radius in reals.
    RealRadius: f64, "radius"
}
size! {
    /// The width of a line in reals.
    LineWidth: f64, "width"
}
size! {
    /// A side of a canvas.
    Side: i32, "side"
}
size! {
    /// A number of bytes.
    ByteCount: i32, "byte count"
}
size! {
    /// The index of a light.
    LightIndex: i32, "light's index"
}

impl<T, const N: usize> Argument for [T; N]
where
    T: Argument<Value = T>,
{
    type Value = [T; N];
    const KIND: ParameterKind = T::KIND;
    const WORDS: Arity = T::WORDS.times(N);

    fn check_numbers(values: &[T; N]) -> Result<(), Fault> {
        values.iter().try_for_each(T::check_numbers)
    }

    fn write(values: &[T; N], line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        values.iter().try_for_each(|value| T::write(value, line))
    }
}

impl<T, const N: usize> TextArgument for [T; N]
where
    T: TextArgument + Argument<Value = T> + Copy + Default,
    [T; N]: Default,
{
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<[T; N], ParseError> {
        let mut values = <[T; N]>::default();
        for value in &mut values {
            *value = T::read(args)?;
        }
        Ok(values)
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<[T; N]> {
        let mut values = <[T; N]>::default();
        for value in &mut values {
            *value = T::read_plain(words)?;
        }
        Some(values)
    }
}

impl<T> Argument for Vec<[T; 2]>
where
    T: Argument<Value = T>,
{
    type Value = Vec<[T; 2]>;
    const KIND: ParameterKind = T::KIND;
    const WORDS: Arity = Arity::at_least(2);

    fn check_numbers(points: &Vec<[T; 2]>) -> Result<(), Fault> {
        points.iter().try_for_each(<[T; 2]>::check_numbers)
    }

    fn check_content(points: &Vec<[T; 2]>) -> Result<(), Fault> {
        match points.is_empty() {
            true => Err(Fault::new(Code::Args, "there must be a point")),
            false => Ok(()),
        }
    }

    fn write(points: &Vec<[T; 2]>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        points.iter().try_for_each(|point| <[T; 2]>::write(point, line))
    }
}

/// Points after a colour, to the end of the line.
impl<T> TextArgument for Vec<[T; 2]>
where
    T: TextArgument + Argument<Value = T> + Copy + Default,
{
    /// Requires an odd number of words: the colour and pairs.
    fn expect(args: &Args<'_>) -> Result<(), ParseError> {
        match args.count() {
            count if count % 2 == 1 => Ok(()),
            count => Err(ParseError::new(
                Code::Args,
                format!("takes a colour and pairs of coordinates, not {} numbers", count - 1),
                args.nth_left(count - 1),
            )),
        }
    }

    fn read(args: &mut Args<'_>) -> Result<Vec<[T; 2]>, ParseError> {
        (0..args.left() / 2).map(|_| <[T; 2]>::read(args)).collect()
    }

    fn read_plain(words: &mut PlainWords<'_>) -> Option<Vec<[T; 2]>> {
        let mut points = Vec::new();
        while words.has_more() {
            points.push(<[T; 2]>::read_plain(words)?);
        }
        Some(points)
    }
}

impl Argument for DVec3 {
    type Value = DVec3;
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::exactly(3);

    fn check_numbers(value: &DVec3) -> Result<(), Fault> {
        finite(&value.to_array())
    }

    fn write(value: &DVec3, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.vectors(&[*value]);
        Ok(())
    }
}

impl TextArgument for DVec3 {
    fn read(args: &mut Args<'_>) -> Result<DVec3, ParseError> {
        args.vector()
    }
}

/// A matrix, row by row.
impl Argument for DMat4 {
    type Value = DMat4;
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::exactly(16);

    fn check_numbers(matrix: &DMat4) -> Result<(), Fault> {
        finite(&matrix.to_cols_array())
    }

    fn write(matrix: &DMat4, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.reals(&matrix.transpose().to_cols_array());
        Ok(())
    }
}

impl TextArgument for DMat4 {
    fn read(args: &mut Args<'_>) -> Result<DMat4, ParseError> {
        let rows: [f64; 16] = args.reals()?;
        Ok(DMat4::from_cols_array(&rows).transpose())
    }
}

impl Argument for Rect {
    type Value = Rect;
    const KIND: ParameterKind = ParameterKind::Integer;
    const WORDS: Arity = Arity::exactly(4);

    fn check_sizes(rect: &Rect) -> Result<(), Fault> {
        from_zero("width", rect.w)?;
        from_zero("height", rect.h)
    }

    fn write(rect: &Rect, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.ints(&[rect.x, rect.y, rect.w, rect.h]);
        Ok(())
    }
}

impl TextArgument for Rect {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<Rect, ParseError> {
        let [x, y, w, h] = args.ints()?;
        Ok(Rect { x, y, w, h })
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<Rect> {
        let [x, y, w, h] = <[i32; 4]>::read_plain(words)?;
        Some(Rect { x, y, w, h })
    }
}

/// A rectangle, or `OFF` for none.
pub struct ClipRect;

impl Argument for ClipRect {
    type Value = Option<Rect>;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::ONE.or(Rect::WORDS);

    fn check_sizes(rect: &Option<Rect>) -> Result<(), Fault> {
        rect.iter().try_for_each(Rect::check_sizes)
    }

    fn write(rect: &Option<Rect>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        match rect {
            Some(rect) => return Rect::write(rect, line),
            None => line.word("OFF"),
        }
        Ok(())
    }
}

impl TextArgument for ClipRect {
    fn read(args: &mut Args<'_>) -> Result<Option<Rect>, ParseError> {
        if args.left() == 1 {
            return take_keyword(args, "OFF").map(|()| None);
        }
        Rect::read(args).map(Some)
    }
}

/// A rectangle, or nothing for the whole frame.
impl Argument for Option<Rect> {
    type Value = Option<Rect>;
    const KIND: ParameterKind = ParameterKind::Integer;
    const WORDS: Arity = Arity::ZERO.or(Rect::WORDS);

    fn check_sizes(rect: &Option<Rect>) -> Result<(), Fault> {
        rect.iter().try_for_each(Rect::check_sizes)
    }

    fn write(rect: &Option<Rect>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        rect.iter().try_for_each(|rect| Rect::write(rect, line))
    }
}

impl TextArgument for Option<Rect> {
    fn read(args: &mut Args<'_>) -> Result<Option<Rect>, ParseError> {
        Ok(if args.left() == 0 { None } else { Some(Rect::read(args)?) })
    }
}

impl Argument for RealRect {
    type Value = RealRect;
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::exactly(4);

    fn check_numbers(rect: &RealRect) -> Result<(), Fault> {
        finite(&[rect.x, rect.y, rect.w, rect.h])
    }

    fn check_sizes(rect: &RealRect) -> Result<(), Fault> {
        from_zero("width", rect.w)?;
        from_zero("height", rect.h)
    }

    fn write(rect: &RealRect, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.reals(&[rect.x, rect.y, rect.w, rect.h]);
        Ok(())
    }
}

impl TextArgument for RealRect {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<RealRect, ParseError> {
        let [x, y, w, h] = args.reals()?;
        Ok(RealRect { x, y, w, h })
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<RealRect> {
        let [x, y, w, h] = <[f64; 4]>::read_plain(words)?;
        Some(RealRect { x, y, w, h })
    }
}

/// Two bytes of a binary command, little-endian.
impl Argument for u16 {
    type Value = u16;
    const KIND: ParameterKind = ParameterKind::Integer;

    fn write(value: &u16, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.binary(&value.to_le_bytes());
        Ok(())
    }
}

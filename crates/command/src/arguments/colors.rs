//! Colours of pixels, lines, areas and light.

use super::{Argument, TextArgument, finite, from_zero, light_form};
use crate::args::{Args, ParseError};
use crate::commands::{AreaColors, RampColor};
use crate::encode::{EncodeError, LineWriter};
use crate::plain_line::PlainWords;
use crate::verb::{Arity, ParameterKind};
use fbptr_core::error::Fault;
use fbptr_core::memory::Rgba;
use glam::DVec3;

impl Argument for Rgba {
    type Value = Rgba;
    const KIND: ParameterKind = ParameterKind::Color;
    const WORDS: Arity = Arity::ONE;

    fn write(color: &Rgba, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.color(*color);
        Ok(())
    }
}

impl TextArgument for Rgba {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<Rgba, ParseError> {
        args.color()
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<Rgba> {
        words.color()
    }
}

/// A colour, opaque black unless given.
pub struct ClearColor;

impl Argument for ClearColor {
    type Value = Rgba;
    const KIND: ParameterKind = ParameterKind::Color;
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

    fn write(color: &Rgba, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        Rgba::write(color, line)
    }
}

impl TextArgument for ClearColor {
    fn read(args: &mut Args<'_>) -> Result<Rgba, ParseError> {
        if args.left() == 0 { Ok([0, 0, 0, 255]) } else { args.color() }
    }
}

/// A colour, or nothing.
impl Argument for Option<Rgba> {
    type Value = Option<Rgba>;
    const KIND: ParameterKind = ParameterKind::Color;
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

    fn write(color: &Option<Rgba>, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        color.iter().for_each(|color| line.color(*color));
        Ok(())
    }
}

impl TextArgument for Option<Rgba> {
    fn read(args: &mut Args<'_>) -> Result<Option<Rgba>, ParseError> {
        if args.left() == 0 { Ok(None) } else { args.color().map(Some) }
    }
}

/// One colour, or those of both ends.
impl Argument for RampColor {
    type Value = RampColor;
    const KIND: ParameterKind = ParameterKind::Color;
    const WORDS: Arity = Arity::ONE.or(Arity::exactly(2));

    fn write(color: &RampColor, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.color(color.from);
        color.to.iter().for_each(|to| line.color(*to));
        Ok(())
    }
}

impl TextArgument for RampColor {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<RampColor, ParseError> {
        let from = args.color()?;
        let to = if args.left() == 0 { None } else { Some(args.color()?) };
        Ok(RampColor { from, to })
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<RampColor> {
        let from = words.color()?;
        let to = if words.has_more() { Some(words.color()?) } else { None };
        Some(RampColor { from, to })
    }
}

/// One colour, or one for each corner.
impl Argument for AreaColors {
    type Value = AreaColors;
    const KIND: ParameterKind = ParameterKind::Color;
    const WORDS: Arity = Arity::ONE.or(Arity::exactly(3));

    fn write(colors: &AreaColors, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        match colors {
            AreaColors::One(color) => line.color(*color),
            AreaColors::Three(colors) => colors.iter().for_each(|color| line.color(*color)),
        }
        Ok(())
    }
}

impl TextArgument for AreaColors {
    #[inline]
    fn read(args: &mut Args<'_>) -> Result<AreaColors, ParseError> {
        let first = args.color()?;
        Ok(match args.left() {
            0 => AreaColors::One(first),
            _ => AreaColors::Three([first, args.color()?, args.color()?]),
        })
    }

    #[inline]
    fn read_plain(words: &mut PlainWords<'_>) -> Option<AreaColors> {
        let first = words.color()?;
        Some(match words.has_more() {
            false => AreaColors::One(first),
            true => AreaColors::Three([first, words.color()?, words.color()?]),
        })
    }
}

/// The four bytes of a binary pixel.
pub struct RawColor;

impl Argument for RawColor {
    type Value = Rgba;
    const KIND: ParameterKind = ParameterKind::Color;

    fn write(color: &Rgba, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        line.binary(color);
        Ok(())
    }
}

/// The colour of light as the only argument: three reals, or one word.
pub struct LightColor;

/// Checks that light takes nothing away: sums of negative colours have no meaning.
pub(super) fn not_negative(color: DVec3) -> Result<(), Fault> {
    color.to_array().into_iter().try_for_each(|channel| from_zero("colour of light", channel))
}

impl Argument for LightColor {
    type Value = DVec3;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::at_least(1);

    fn check_numbers(color: &DVec3) -> Result<(), Fault> {
        finite(&color.to_array())
    }

    fn check_sizes(color: &DVec3) -> Result<(), Fault> {
        not_negative(*color)
    }

    fn write(color: &DVec3, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        DVec3::write(color, line)
    }
}

impl TextArgument for LightColor {
    fn read(args: &mut Args<'_>) -> Result<DVec3, ParseError> {
        let form = light_form(args, &[3], "AMBIENT r g b or its name")?;
        args.light_color(form)
    }
}

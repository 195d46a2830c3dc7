//! Parsers of lines and areas.

use super::Parsed;
use super::memory::rectangle;
use crate::command::args::{Args, ParseError};
use crate::command::commands::{AreaColors, Command, Figure, RampColor, RealRect};
use crate::error::Code;

pub fn line(args: &mut Args<'_>) -> Parsed {
    let [x0, y0, x1, y1] = args.ints()?;
    let from = args.color()?;
    let to = if args.left() == 0 { None } else { Some(args.color()?) };
    Ok(Command::Figure(Figure::Line { p0: [x0, y0], p1: [x1, y1], color: RampColor { from, to } }))
}

fn colors(args: &mut Args<'_>) -> Result<AreaColors, ParseError> {
    let first = args.color()?;
    Ok(match args.left() {
        0 => AreaColors::One(first),
        _ => AreaColors::Three([first, args.color()?, args.color()?]),
    })
}

pub fn tri(args: &mut Args<'_>) -> Parsed {
    let points = [args.ints()?, args.ints()?, args.ints()?];
    Ok(Command::Figure(Figure::Triangle { points, colors: colors(args)? }))
}

pub fn fill(args: &mut Args<'_>) -> Parsed {
    let points = [args.reals()?, args.reals()?, args.reals()?];
    Ok(Command::Figure(Figure::Fill { points, colors: colors(args)? }))
}

pub fn rect(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Figure(Figure::Rect { rect: rectangle(args)?, color: args.color()? }))
}

pub fn fillrect(args: &mut Args<'_>) -> Parsed {
    let [x, y, w, h] = args.reals()?;
    Ok(Command::Figure(Figure::FillRect { rect: RealRect { x, y, w, h }, color: args.color()? }))
}

pub fn circle(args: &mut Args<'_>) -> Parsed {
    let [cx, cy, r] = args.ints()?;
    Ok(Command::Figure(Figure::Circle { cx, cy, r, color: args.color()? }))
}

pub fn fillcircle(args: &mut Args<'_>) -> Parsed {
    let [cx, cy, r] = args.reals()?;
    Ok(Command::Figure(Figure::FillCircle { cx, cy, r, color: args.color()? }))
}

/// Returns the number of coordinate pairs after the colour. An odd count of words is required: the
/// colour and pairs.
fn expect_pairs(args: &Args<'_>) -> Result<usize, ParseError> {
    match args.count() {
        count if count % 2 == 1 => Ok(count / 2),
        count => Err(ParseError::new(
            Code::Args,
            format!("takes a colour and pairs of coordinates, not {} numbers", count - 1),
            args.nth_left(count - 1),
        )),
    }
}

pub fn poly(args: &mut Args<'_>) -> Parsed {
    let pairs = expect_pairs(args)?;
    let color = args.color()?;
    let points = (0..pairs).map(|_| args.ints()).collect::<Result<_, _>>()?;
    Ok(Command::Figure(Figure::Poly { color, points }))
}

pub fn fillpoly(args: &mut Args<'_>) -> Parsed {
    let pairs = expect_pairs(args)?;
    let color = args.color()?;
    let points = (0..pairs).map(|_| args.reals()).collect::<Result<_, _>>()?;
    Ok(Command::Figure(Figure::FillPoly { color, points }))
}

pub fn text(args: &mut Args<'_>) -> Parsed {
    let [x, y] = args.ints()?;
    Ok(Command::Figure(Figure::Text { x, y, color: args.color()?, utf8: Vec::new() }))
}

pub fn lineaa(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Figure(Figure::LineAa { p0: args.reals()?, p1: args.reals()?, color: args.color()? }))
}

pub fn blend(args: &mut Args<'_>) -> Parsed {
    let over = args.keyword("replace or over", |word| match () {
        () if word.eq_ignore_ascii_case("replace") => Some(false),
        () if word.eq_ignore_ascii_case("over") => Some(true),
        () => None,
    })?;
    Ok(Command::Blend { over })
}

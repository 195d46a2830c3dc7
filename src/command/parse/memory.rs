//! Pixels and bytes.

use super::Parsed;
use crate::command::args::{Args, Refusal};
use crate::command::color::hex_digit;
use crate::command::model::{Command, Rect};
use crate::error::Code;

pub fn px(args: &mut Args<'_>) -> Parsed {
    let [x, y] = args.ints()?;
    Ok(match args.left() {
        0 => Command::GetPixel { x, y },
        _ => Command::Pixel { x, y, color: args.color()? },
    })
}

pub fn offset(args: &mut Args<'_>) -> Parsed {
    let [x, y] = args.ints()?;
    Ok(Command::Offset { x, y })
}

/// Four whole numbers: x, y, w, h.
pub fn rectangle(args: &mut Args<'_>) -> Result<Rect, Refusal> {
    let [x, y, w, h] = args.ints()?;
    Ok(Rect { x, y, w, h })
}

pub fn poke(args: &mut Args<'_>) -> Parsed {
    let offset = args.int()?;
    let hex = args.word();
    let (pairs, odd) = hex.as_chunks::<2>();
    let bytes = pairs.iter().map(|p| Some(hex_digit(p[0])? << 4 | hex_digit(p[1])?)).collect::<Option<_>>();
    match bytes {
        Some(bytes) if odd.is_empty() => Ok(Command::Poke { offset, bytes }),
        _ => Err(Refusal::new(Code::Format, "argument 2 must be bytes of two hex digits each", hex)),
    }
}

pub fn peek(args: &mut Args<'_>) -> Parsed {
    let [offset, n] = args.ints()?;
    Ok(Command::Peek { offset, n })
}

pub fn blit(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Blit { rect: rectangle(args)?, rgba: Vec::new() })
}

pub fn read(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Read { rect: rectangle(args)? })
}

pub fn copy(args: &mut Args<'_>) -> Parsed {
    let source = rectangle(args)?;
    let [dx, dy] = args.ints()?;
    Ok(Command::Copy { source, dx, dy })
}

pub fn points(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Points { packed: Vec::new() })
}

pub fn crc(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Crc { rect: if args.left() == 0 { None } else { Some(rectangle(args)?) } })
}

pub fn clear(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Clear { color: if args.left() == 0 { [0, 0, 0, 255] } else { args.color()? } })
}

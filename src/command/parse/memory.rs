//! Parsers of pixel and memory commands.

use super::Parsed;
use crate::command::args::{Args, ParseError};
use crate::command::commands::{Command, Rect};
use crate::error::Code;
use crate::memory::read_hex;

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

/// Takes four integers: x, y, w, h.
pub fn rectangle(args: &mut Args<'_>) -> Result<Rect, ParseError> {
    let [x, y, w, h] = args.ints()?;
    Ok(Rect { x, y, w, h })
}

pub fn poke(args: &mut Args<'_>) -> Parsed {
    let offset = args.int()?;
    let hex = args.word();
    let mut bytes = vec![0; hex.len() / 2];
    match hex.len().is_multiple_of(2) && read_hex(hex, &mut bytes) {
        true => Ok(Command::Poke { offset, bytes }),
        false => Err(ParseError::new(Code::Format, "argument 2 must be bytes of two hex digits each", hex)),
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

//! Commands in pieces that go through a list: records of POINTS, pixels of PXMULTI, letters of TEXT,
//! bytes of a PEEK, rows of a CRC.

use super::Piecewise;
use super::bands::band_rows;
use crate::Session;
use crate::clock::Instant;
use crate::engine::Engine;
use fbptr_command::{Command, Figure, Rect};
use fbptr_core::draw2d::{self, DrawError, TextCursor};
use fbptr_core::error::Fault;
use fbptr_core::memory::Rgba;
use std::ops::Range;

/// Records of `POINTS` in one piece.
const PIECE_RECORDS: usize = 1 << 15;
/// Bytes of a record.
const RECORD_BYTES: usize = 8;
/// Bytes of `TEXT` of the smallest letters in one piece.
const PIECE_LETTERS: usize = 1 << 15;
/// Pixels of `PXMULTI` in one piece.
const PIECE_PIXELS: usize = 1 << 18;
/// Bytes of a `PEEK` in one piece.
const PIECE_BYTES: usize = 1 << 18;
/// Bands of rows of a `CRC` in one piece: reading takes less time than drawing.
const CRC_BANDS: u32 = 16;

/// `POINTS`, and the byte at which the next piece begins.
#[derive(Debug)]
pub(super) struct Records {
    packed: Vec<u8>,
    at: usize,
}

impl Records {
    pub fn new(packed: Vec<u8>) -> Self {
        Records { packed, at: 0 }
    }
}

impl Piecewise for Records {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, _: Option<Instant>) -> Result<bool, Fault> {
        let Records { packed, at } = self;
        let end = (*at + PIECE_RECORDS * RECORD_BYTES).min(packed.len());
        // An incomplete list is refused by its first piece, before anything is drawn.
        let is_whole = packed.len().is_multiple_of(RECORD_BYTES);
        let piece = if is_whole { &packed[*at..end] } else { &packed[..] };
        engine.points(s, piece)?;
        *at = end;
        Ok(end == packed.len())
    }

    fn give_up(&mut self, engine: &mut Engine, _: &Session) -> (Range<u32>, String) {
        (0..engine.framebuffer.height(), format!("after {} records", self.at / RECORD_BYTES))
    }

    fn payload_bytes(&self) -> usize {
        self.packed.capacity()
    }

    fn into_command(self: Box<Self>) -> Command {
        Command::Points { packed: self.packed }
    }
}

/// `PXMULTI`, and the pixel of its run at which the next piece begins.
#[derive(Debug)]
pub(super) struct Run {
    x: u16,
    y: u16,
    rgba: Vec<u8>,
    at: usize,
}

impl Run {
    pub fn new(x: u16, y: u16, rgba: Vec<u8>) -> Self {
        Run { x, y, rgba, at: 0 }
    }
}

impl Piecewise for Run {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, _: Option<Instant>) -> Result<bool, Fault> {
        let Run { x, y, rgba, at } = self;
        let pixels = rgba.len() / 4;
        let end = (*at + PIECE_PIXELS).min(pixels);
        // An incomplete run is refused by its first piece, before anything is drawn.
        let is_whole = rgba.len().is_multiple_of(4);
        let piece = if is_whole { &rgba[*at * 4..end * 4] } else { &rgba[..] };
        let width = engine.framebuffer.width() as usize;
        let place = usize::from(*y) * width + usize::from(*x) + *at;
        match (u16::try_from(place % width), u16::try_from(place / width)) {
            (Ok(x), Ok(y)) => engine.framebuffer.pixel_run(s, x, y, piece)?,
            // Below all frames.
            _ => s.count_pixels(end - *at, 0),
        }
        *at = end;
        Ok(end == pixels)
    }

    fn give_up(&mut self, engine: &mut Engine, _: &Session) -> (Range<u32>, String) {
        (0..engine.framebuffer.height(), format!("after {} pixels", self.at))
    }

    fn payload_bytes(&self) -> usize {
        self.rgba.capacity()
    }

    fn into_command(self: Box<Self>) -> Command {
        Command::PixelRun { x: self.x, y: self.y, rgba: self.rgba }
    }
}

/// `TEXT`, and the place of its next letter.
#[derive(Debug)]
pub(super) struct Letters {
    start: [i32; 2],
    color: Rgba,
    utf8: Vec<u8>,
    cursor: TextCursor,
    /// Bytes in one piece.
    most: usize,
}

impl Letters {
    pub fn new(start: [i32; 2], color: Rgba, utf8: Vec<u8>, size: u8) -> Self {
        let most = PIECE_LETTERS / usize::from(size).pow(2);
        Letters { start, color, utf8, cursor: TextCursor::scaled(start, size), most }
    }
}

impl Piecewise for Letters {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, _: Option<Instant>) -> Result<bool, Fault> {
        let Letters { utf8, cursor, color, most, .. } = self;
        if cursor.bytes() == 0 {
            // Checked before the first piece, so that nothing is drawn if the text is refused.
            let not_utf8 = |e: std::str::Utf8Error| DrawError::NotUtf8 { at: e.valid_up_to() as u64 };
            std::str::from_utf8(utf8).map_err(not_utf8)?;
        }
        let memory = &mut engine.framebuffer.memory;
        Ok(draw2d::text_piece(memory, cursor, utf8, *color, s.blend, *most)?)
    }

    fn give_up(&mut self, engine: &mut Engine, _: &Session) -> (Range<u32>, String) {
        (0..engine.framebuffer.height(), format!("after {} bytes", self.cursor.bytes()))
    }

    fn payload_bytes(&self) -> usize {
        self.utf8.capacity()
    }

    fn into_command(self: Box<Self>) -> Command {
        let Letters { start: [x, y], color, utf8, .. } = *self;
        Command::Figure(Figure::Text { x, y, color, utf8 })
    }
}

/// `PEEK`, and the digits so far.
#[derive(Debug)]
pub(super) struct Digits {
    offset: i32,
    n: i32,
    at: usize,
    reply: Vec<u8>,
}

impl Digits {
    pub fn new(offset: i32, n: i32) -> Self {
        Digits { offset, n, at: 0, reply: Vec::new() }
    }
}

impl Piecewise for Digits {
    fn run(&mut self, engine: &mut Engine, _: &mut Session, _: Option<Instant>) -> Result<bool, Fault> {
        if self.at == 0 {
            let bytes = engine.peek_head(self.offset, self.n, &mut self.reply)?;
            self.reply.reserve_exact(2 * bytes + 1);
        }
        let len = self.n as usize;
        let bytes = PIECE_BYTES.min(len - self.at);
        engine.peek_digits(self.offset, self.at..self.at + bytes, &mut self.reply)?;
        self.at += bytes;
        Ok(self.at == len)
    }

    fn end(&mut self, _: &mut Engine, _: &mut Session, replies: &mut Vec<u8>) {
        self.reply.push(b'\n');
        match replies.is_empty() {
            true => std::mem::swap(replies, &mut self.reply),
            false => replies.append(&mut self.reply),
        }
    }

    fn give_up(&mut self, _: &mut Engine, _: &Session) -> (Range<u32>, String) {
        (0..0, "without effect".to_owned())
    }

    fn into_command(self: Box<Self>) -> Command {
        Command::Peek { offset: self.offset, n: self.n }
    }
}

/// `CRC`, and the checksum of the rows so far.
#[derive(Debug)]
pub(super) struct Checksum {
    rect: Option<Rect>,
    next_row: u32,
    crc: crc32fast::Hasher,
}

impl Checksum {
    pub fn new(rect: Option<Rect>) -> Self {
        Checksum { rect, next_row: 0, crc: crc32fast::Hasher::new() }
    }
}

impl Piecewise for Checksum {
    fn run(&mut self, engine: &mut Engine, _: &mut Session, _: Option<Instant>) -> Result<bool, Fault> {
        let [w, h] = [engine.framebuffer.width(), engine.framebuffer.height()].map(|side| side as i32);
        let rect = self.rect.unwrap_or(Rect { x: 0, y: 0, w, h });
        let rows = draw2d::rows(&engine.framebuffer.memory, rect)?;
        let count = CRC_BANDS * band_rows(engine);
        rows.skip(self.next_row as usize).take(count as usize).for_each(|row| self.crc.update(row));
        self.next_row += count;
        Ok(i64::from(self.next_row) >= i64::from(rect.h))
    }

    fn end(&mut self, _: &mut Engine, _: &mut Session, replies: &mut Vec<u8>) {
        replies.extend(format!("CRC {:08x}\n", self.crc.clone().finalize()).into_bytes());
    }

    fn give_up(&mut self, _: &mut Engine, _: &Session) -> (Range<u32>, String) {
        (0..0, "without effect".to_owned())
    }

    fn into_command(self: Box<Self>) -> Command {
        Command::Crc { rect: self.rect }
    }
}

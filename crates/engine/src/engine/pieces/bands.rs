//! Commands in pieces that are bands of rows, from the top down.
//!
//! In: a command and a band. Out: the part of the command that lies in the band. For COPY and READ
//! the band is of rows of their rectangle.

use super::Piecewise;
use crate::Session;
use crate::clock::Instant;
use crate::engine::{Decoded, Engine};
use fbptr_command::{Command, Figure, Rect};
use fbptr_core::draw2d::{self, Blend};
use fbptr_core::error::Fault;
use fbptr_core::memory::{Rgba, VideoMemory};
use std::fmt;
use std::ops::Range;
use std::time::Duration;

/// Pixels of a band of rows, about.
const BAND_PIXELS: u32 = 1 << 15;
/// Estimated nanoseconds of a band of a figure for each thread that draws it.
const THREAD_BAND_NS: u64 = 1_000_000;
/// Rows of the first band, whose time is not known.
const FIRST_ROWS: u32 = 4;

/// Returns the number of rows of a band.
pub(in crate::engine) fn band_rows(engine: &Engine) -> u32 {
    (BAND_PIXELS / engine.framebuffer.width()).max(1)
}

/// Returns the part of a rectangle of pixels that lies in a band of rows of the target, and where its
/// RGBA bytes are among those of the rectangle. The sides are not negative.
pub(in crate::engine) fn part_in(Rect { x, y, w, h }: Rect, rows: &Range<u32>) -> (Rect, Range<usize>) {
    let row = |row: u32| (i64::from(row) - i64::from(y)).clamp(0, i64::from(h));
    let (start, end) = (row(rows.start), row(rows.end));
    // Within the band, so it is a row of the target.
    let top = (i64::from(y) + start) as i32;
    let stride = w as usize * 4;
    (Rect { x, y: top, w, h: (end - start) as i32 }, start as usize * stride..end as usize * stride)
}

/// Draws the part of a picture that lies in a band of rows.
fn blit_band(
    memory: &mut VideoMemory,
    rect: Rect,
    rgba: &[u8],
    blend: Blend,
    rows: &Range<u32>,
) -> Result<(), Fault> {
    let is_whole = rect.w >= 0 && rect.h >= 0 && rgba.len() as u64 == rect.w as u64 * rect.h as u64 * 4;
    let (part, bytes) = match is_whole {
        true => part_in(rect, rows),
        // Refused before anything is drawn.
        false => (rect, 0..rgba.len()),
    };
    Ok(draw2d::blit(memory, part, &rgba[bytes], blend)?)
}

/// A command that can be restricted to a band of rows.
pub(super) trait Band: fmt::Debug + Send {
    /// Runs the part of the command that lies in `rows`.
    ///
    /// # Errors
    /// As [`Piecewise::run`].
    fn run(&mut self, engine: &mut Engine, s: &mut Session, rows: Range<u32>) -> Result<(), Fault>;

    /// Returns the number of rows of a band, at most. To be asked on the surface of the command.
    fn most_rows(&self, engine: &Engine, _: &Session) -> u32 {
        band_rows(engine)
    }

    /// Completes the command, as [`Piecewise::end`].
    fn end(&mut self, _: &mut Engine, _: &mut Session, _: &mut Vec<u8>) {}

    /// Returns the rows of the frame in which it may have drawn, `next` being the next row of
    /// `height`.
    fn drawn_rows(&self, next: u32, _height: u32) -> Range<u32> {
        0..next
    }

    /// Returns the bytes of its payload.
    fn payload_bytes(&self) -> usize {
        0
    }

    /// Returns the command.
    fn into_command(self) -> Command;
}

/// Time of a band from which the next one has fewer rows, and up to which it has more.
const LONG_BAND: Duration = Duration::from_millis(1);
const SHORT_BAND: Duration = Duration::from_micros(300);

/// A command in bands, and the first row of the next one. A band has at most [`Band::most_rows`], and
/// as many fewer as it takes to keep its time: what a row costs beside its pixels need not be known.
#[derive(Debug)]
pub(super) struct Bands<B> {
    band: B,
    next_row: u32,
    /// Rows of the next band.
    rows: u32,
}

impl<B: Band + 'static> Bands<B> {
    /// Begins a command at the top.
    pub fn boxed(band: B) -> Box<dyn Piecewise> {
        Box::new(Bands { band, next_row: 0, rows: FIRST_ROWS })
    }
}

impl<B: Band> Piecewise for Bands<B> {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, _: Option<Instant>) -> Result<bool, Fault> {
        let height = engine.framebuffer.height();
        let count = self.rows.min(self.band.most_rows(engine, s));
        let rows = self.next_row..(self.next_row + count).min(height);
        self.next_row = rows.end;
        let begun = Instant::now();
        self.band.run(engine, s, rows)?;
        match Instant::now().duration_since(begun) {
            long if long > LONG_BAND => self.rows = (count / 2).max(1),
            short if short < SHORT_BAND => self.rows = count * 2,
            _ => {}
        }
        Ok(self.next_row >= height)
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, replies: &mut Vec<u8>) {
        self.band.end(engine, s, replies);
    }

    fn give_up(&mut self, engine: &mut Engine, _: &Session) -> (Range<u32>, String) {
        let height = engine.framebuffer.height();
        let rows = self.band.drawn_rows(self.next_row, height);
        let how_far = match rows.is_empty() {
            true => "without effect".to_owned(),
            false => format!("after {} of {height} rows", self.next_row),
        };
        (rows, how_far)
    }

    fn payload_bytes(&self) -> usize {
        self.band.payload_bytes()
    }

    fn into_command(self: Box<Self>) -> Command {
        self.band.into_command()
    }
}

/// `CLEAR`.
#[derive(Debug)]
pub(super) struct ClearBands {
    pub color: Rgba,
}

impl Band for ClearBands {
    fn run(&mut self, engine: &mut Engine, _: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        engine.framebuffer.memory.clear_rows(rows, self.color);
        Ok(())
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>) {
        engine.framebuffer.end_clear(s);
    }

    fn into_command(self) -> Command {
        Command::Clear { color: self.color }
    }
}

/// A figure.
#[derive(Debug)]
pub(super) struct FigureBands {
    pub figure: Figure,
}

impl Band for FigureBands {
    /// Several threads draw more rows in the same time.
    fn most_rows(&self, engine: &Engine, s: &Session) -> u32 {
        let threads = engine.executor().threads() as u64;
        let ns_a_row = engine.figure_ns(s, &self.figure) / u64::from(engine.framebuffer.height());
        let shared = if threads > 1 { THREAD_BAND_NS * threads / ns_a_row.max(1) } else { 0 };
        band_rows(engine).max(shared.min(u64::from(engine.framebuffer.height())) as u32)
    }

    fn run(&mut self, engine: &mut Engine, s: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        engine.framebuffer.memory.set_window(rows);
        let drawn = engine.figure(s, &self.figure);
        engine.end_band();
        Ok(drawn?)
    }

    fn into_command(self) -> Command {
        Command::Figure(self.figure)
    }
}

/// `READ`: its reply is appended band by band.
#[derive(Debug)]
pub(super) struct ReadBands {
    pub rect: Rect,
    pub reply: Vec<u8>,
}

impl Band for ReadBands {
    fn run(&mut self, engine: &mut Engine, _: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        if rows.start == 0 {
            let bytes = engine.read_head(self.rect, &mut self.reply)?;
            self.reply.reserve_exact(bytes as usize);
        }
        let count = rows.len();
        draw2d::rows(&engine.framebuffer.memory, self.rect)?
            .skip(rows.start as usize)
            .take(count)
            .for_each(|row| self.reply.extend_from_slice(row));
        Ok(())
    }

    fn end(&mut self, _: &mut Engine, _: &mut Session, replies: &mut Vec<u8>) {
        match replies.is_empty() {
            true => std::mem::swap(replies, &mut self.reply),
            false => replies.append(&mut self.reply),
        }
    }

    fn drawn_rows(&self, _: u32, _: u32) -> Range<u32> {
        0..0
    }

    fn into_command(self) -> Command {
        Command::Read { rect: self.rect }
    }
}

/// `COPY`: from the top of the rectangle, or from its bottom if the copy moves down.
#[derive(Debug)]
pub(super) struct CopyBands {
    pub source: Rect,
    pub dest: [i32; 2],
}

impl Band for CopyBands {
    fn run(&mut self, engine: &mut Engine, _: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        let CopyBands { source, dest: [dx, dy] } = *self;
        if rows.start == 0 {
            // Checked before the first band, so that nothing is copied if the command is refused.
            drop(draw2d::rows(&engine.framebuffer.memory, source)?);
        }
        let h = source.h;
        let (from, to) = ((rows.start as i32).min(h), (rows.end as i32).min(h));
        let top = if dy > source.y { h - to } else { from };
        let Some(to_y) = dy.checked_add(top) else { return Ok(()) };
        let band = Rect { y: source.y + top, h: to - from, ..source };
        // Like the command in one piece, it stores the pixels whatever BLEND is.
        Ok(draw2d::copy(&mut engine.framebuffer.memory, band, [dx, to_y], Blend::Replace)?)
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>) {
        let CopyBands { source, dest: [x, y] } = *self;
        s.stats.pixels += engine.framebuffer.visible(Rect { x, y, ..source });
    }

    fn drawn_rows(&self, _: u32, height: u32) -> Range<u32> {
        0..height
    }

    fn into_command(self) -> Command {
        let [dx, dy] = self.dest;
        Command::Copy { source: self.source, dx, dy }
    }
}

/// `STAMP`: from the top of the target, or from its bottom if the target is stamped on itself and
/// moves down.
#[derive(Debug)]
pub(super) struct StampBands {
    pub name: String,
    pub at: [i32; 2],
    pub key: Option<Rgba>,
}

impl Band for StampBands {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        engine.stamp_band(s, &self.name, self.at, self.key, rows)
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>) {
        engine.end_stamp(s, &self.name, self.at);
    }

    fn drawn_rows(&self, _: u32, height: u32) -> Range<u32> {
        0..height
    }

    fn into_command(self) -> Command {
        let [x, y] = self.at;
        Command::Stamp { name: self.name, x, y, key: self.key }
    }
}

/// `BLIT`.
#[derive(Debug)]
pub(super) struct BlitBands {
    pub rect: Rect,
    pub rgba: Vec<u8>,
}

impl Band for BlitBands {
    fn run(&mut self, engine: &mut Engine, _: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        blit_band(&mut engine.framebuffer.memory, self.rect, &self.rgba, Blend::Replace, &rows)
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>) {
        s.count_pixels(self.rgba.len() / 4, engine.framebuffer.visible(self.rect));
    }

    fn payload_bytes(&self) -> usize {
        self.rgba.capacity()
    }

    fn into_command(self) -> Command {
        Command::Blit { rect: self.rect, rgba: self.rgba }
    }
}

/// `IMAGE` with its picture decoded.
#[derive(Debug)]
pub(super) struct ImageBands {
    pub rect: Rect,
    pub picture: Decoded,
    pub file: Vec<u8>,
}

impl Band for ImageBands {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        blit_band(&mut engine.framebuffer.memory, self.rect, self.picture.rgba(), s.blend, &rows)
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>) {
        engine.framebuffer.count_image(s, self.rect);
    }

    fn into_command(self) -> Command {
        Command::Image { x: self.rect.x, y: self.rect.y, file: self.file }
    }
}

/// `DRAWEYE` with its picture made.
#[derive(Debug)]
pub(super) struct EyeBands {
    pub name: String,
    pub rect: Rect,
}

impl Band for EyeBands {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, rows: Range<u32>) -> Result<(), Fault> {
        engine.put_eye_band(s, &self.name, self.rect, rows)
    }

    fn end(&mut self, engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>) {
        engine.note_eye(s, self.rect);
    }

    fn into_command(self) -> Command {
        Command::DrawEye { name: self.name, rect: self.rect }
    }
}

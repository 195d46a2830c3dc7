//! Long commands that access the video memory, run in pieces of a few rows, letters or records.
//!
//! In: a command that may take more than about two milliseconds, as [`Engine::is_long`] estimates.
//! Out: the same bytes, reply and recording as if it ran at once. Figures are defined pixel by
//! pixel and each pixel belongs to one band of rows, so bands are exact, under BLEND over, too;
//! POINTS is split between records, TEXT between letters, COPY between rows in the direction that
//! overlap requires. The pieces of DRAW and DRAWSCENE are those of [`super::long_draw`].
//!
//! Promises, together with the scheduler:
//! - One command at a time is in pieces. Meanwhile queries of other connections run, and see the
//!   memory as it is between two pieces; all other commands wait, and foreign writes to the shared
//!   file are not taken in. So the command is recorded as one, at its end, and a replay gives the
//!   same bytes.
//! - A command that exceeds the time limit ([`crate::server::Limits::command_time`]) is ended with
//!   `EQUOTA`. The pixels that it has drawn stay, and are recorded as runs of pixels, which is
//!   exact; the message says how far it got. Depths that a draw may have written are cleared, in the
//!   recording too.
//! - When the server ends, a command in pieces is abandoned: the memory contains a part of it, the
//!   recording nothing.
//!
//! An error here would show as bytes that differ from those of the command in one piece (tests
//! below), or from those of a replay.

use super::drawing::Drawing;
use super::long_draw::LongDraw;
use super::{Engine, Request};
use crate::command::{AreaColors, Command, Figure, RealRect, Rect};
use crate::draw2d::{self, Blend, DrawError, TextCursor};
use crate::error::{Code, Fault};
use crate::memory::{DepthFormat, MemoryUse, Reservation};
use crate::server::{Budget, Session};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Pixels of a band of rows, about.
const BAND_PIXELS: u32 = 1 << 15;
/// Records of `POINTS` in one piece.
const PIECE_RECORDS: usize = 1 << 17;
/// Bytes of `TEXT` in one piece.
const PIECE_LETTERS: usize = 1 << 15;
/// Estimated nanoseconds from which a command runs in pieces.
const LONG_NS: u64 = 2_000_000;

/// A command that runs in pieces.
#[derive(Debug)]
pub(in crate::server) struct Pieces {
    command: Command,
    next: Next,
    reply: Vec<u8>,
    begun: Instant,
    /// Set once it was given up, with a part of it drawn.
    was_given_up: bool,
    /// The memory budget's reservation for its payload.
    _held: Reservation,
}

/// Position of the next piece.
#[derive(Debug)]
enum Next {
    Row(u32),
    Record(usize),
    Letter(TextCursor),
    CrcRow(u32, crc32fast::Hasher),
    Draw(LongDraw),
}

impl Pieces {
    /// Returns the command's verb.
    pub fn verb(&self) -> &'static str {
        self.command.verb()
    }

    /// Returns whether it was given up, with a part of it drawn.
    pub fn was_given_up(&self) -> bool {
        self.was_given_up
    }

    /// Returns whether its first piece runs in the slice in which it begins. A draw waits for the
    /// next one, because its thread prepares it meanwhile.
    pub fn runs_at_once(&self) -> bool {
        !matches!(self.next, Next::Draw(_))
    }
}

impl Engine {
    /// Returns whether a command may take so long that others should not wait for all of it.
    pub(super) fn is_long(&self, s: &Session, command: &Command) -> bool {
        use Command as C;
        let frame = self.framebuffer.area();
        // Estimated nanoseconds per pixel.
        let composed = if s.blend == Blend::Over { 2 } else { 1 };
        let cost = match command {
            C::Clear { .. } | C::Crc { rect: None } => frame / 4,
            C::Crc { rect: Some(rect) } => self.framebuffer.visible(*rect) / 4,
            C::Read { rect } => self.framebuffer.visible(*rect),
            C::Copy { source, .. } => self.framebuffer.visible(*source),
            C::Figure(Figure::FillRect { rect: RealRect { x, y, w, h }, .. }) => {
                self.visible_box([*x, *y], [x + w, y + h]).0 * composed / 2
            }
            C::Figure(Figure::FillCircle { cx, cy, r, .. }) => {
                self.visible_box([cx - r, cy - r], [cx + r, cy + r]).0 * composed / 2
            }
            C::Figure(Figure::Fill { points, colors }) => {
                let (pixels, is_near) = self.visible_of(points);
                let per_pixel = if matches!(colors, AreaColors::Three(_)) { 2 } else { 1 };
                match is_near {
                    true => pixels * per_pixel * composed,
                    // Coordinates need arbitrary precision, so each row may be expensive.
                    false => pixels * 64,
                }
            }
            C::Figure(Figure::FillPoly { points, .. }) => {
                let (pixels, _) = self.visible_of(points);
                pixels * composed + u64::from(self.framebuffer.height()) * points.len() as u64 * 32
            }
            C::Points { packed } => packed.len() as u64,
            C::Figure(Figure::Text { utf8, .. }) => utf8.len() as u64 * 8 * u64::from(s.text_size).pow(2),
            C::Figure(Figure::FillEllipse { center: [cx, cy], radii: [rx, ry], .. }) => {
                self.visible_box([cx - rx, cy - ry], [cx + rx, cy + ry]).0 * composed / 2
            }
            C::Figure(Figure::Arc { center: [cx, cy], radii: [_, r], .. }) => {
                let (pixels, is_near) = self.visible_box([cx - r, cy - r], [cx + r, cy + r]);
                if is_near { pixels * composed } else { pixels * 64 }
            }
            C::Figure(Figure::WideLine { p0, p1, width, .. }) => {
                let (pixels, is_near) = self.visible_stroke(&[*p0, *p1], *width);
                if is_near { pixels * composed } else { pixels * 64 }
            }
            C::Figure(Figure::Bezier { points, width, .. }) => {
                // Up to 8192 steps, each of which may meet every row.
                let (pixels, _) = self.visible_stroke(points, *width);
                pixels * composed + if pixels > 0 { draw2d::bezier_steps(points) * 4000 } else { 0 }
            }
            _ => return false,
        };
        cost > LONG_NS
    }

    /// Returns the number of visible pixels in the bounding box of points, and whether all of them
    /// are close enough for fixed-width integers.
    fn visible_of(&self, points: &[[f64; 2]]) -> (u64, bool) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points {
            (low, high) = ([0, 1].map(|i| low[i].min(p[i])), [0, 1].map(|i| high[i].max(p[i])));
        }
        self.visible_box(low, high)
    }

    /// Returns the same of the points nearer than half a width to some points' bounding box.
    fn visible_stroke(&self, points: &[[f64; 2]], width: f64) -> (u64, bool) {
        let reach = width / 2.0;
        let around = |p: &[f64; 2]| [[p[0] - reach, p[1] - reach], [p[0] + reach, p[1] + reach]];
        let corners: Vec<_> = points.iter().flat_map(around).collect();
        self.visible_of(&corners)
    }

    fn visible_box(&self, low: [f64; 2], high: [f64; 2]) -> (u64, bool) {
        let size = [self.framebuffer.width(), self.framebuffer.height()].map(f64::from);
        let side = |i: usize| (high[i].min(size[i]) - low[i].max(0.0)).max(0.0).ceil() as u64;
        let is_near = low.iter().chain(&high).all(|v| v.abs() < f64::from(1 << 20));
        (side(0) * side(1), is_near)
    }

    /// Prepares the first piece of a long command, which has been counted.
    pub(super) fn begin_in_pieces(&mut self, s: &mut Session, command: Command) -> Pieces {
        let next = match &command {
            Command::Points { .. } => Next::Record(0),
            Command::Figure(Figure::Text { x, y, .. }) => {
                Next::Letter(TextCursor::scaled([*x, *y], s.text_size))
            }
            Command::Crc { .. } => Next::CrcRow(0, crc32fast::Hasher::new()),
            _ => Next::Row(0),
        };
        let payload = match &command {
            Command::Points { packed } => packed.capacity(),
            Command::Figure(Figure::Text { utf8, .. }) => utf8.capacity(),
            _ => 0,
        };
        let taken_over = s.payload_held.take();
        let mut held = taken_over.unwrap_or_else(|| self.quotas.budget.empty(MemoryUse::Payloads));
        held.set(payload as u64);
        Pieces { command, next, reply: Vec::new(), begun: Instant::now(), was_given_up: false, _held: held }
    }

    /// Prepares the pieces of a draw, which has been counted.
    ///
    /// # Errors
    /// Returns the draw if the system has no thread to give.
    pub(super) fn begin_draw_in_pieces(&mut self, drawing: Drawing) -> Result<Pieces, Drawing> {
        let command = drawing.command();
        let draw = self.begin_long_draw(drawing)?;
        Ok(self.pieces_of(command, Next::Draw(draw)))
    }

    /// Prepares the pieces of `DRAWEYE`, which has been counted and has its picture.
    pub(super) fn begin_eye_in_pieces(&mut self, name: String, rect: Rect) -> Pieces {
        self.pieces_of(Command::DrawEye { name, rect }, Next::Row(0))
    }

    fn pieces_of(&self, command: Command, next: Next) -> Pieces {
        let held = self.quotas.budget.empty(MemoryUse::Payloads);
        Pieces { command, next, reply: Vec::new(), begun: Instant::now(), was_given_up: false, _held: held }
    }

    /// Runs at least one piece, and more until the budget's time is used up. Returns whether the
    /// last one has run.
    ///
    /// # Errors
    /// The reason for which the command was refused or ended early.
    pub(super) fn advance(
        &mut self,
        s: &mut Session,
        pieces: &mut Pieces,
        budget: Budget,
    ) -> Result<bool, Fault> {
        loop {
            let is_last = self.run_piece(s, pieces, budget.until)?;
            #[cfg(test)]
            self.meet_defect(pieces.command.verb());
            if is_last {
                return Ok(true);
            }
            let now = Instant::now();
            if let Some(limit) = budget.command_time.filter(|&limit| now >= pieces.begun + limit) {
                return Err(self.give_up_pieces(s, pieces, limit));
            }
            if budget.until.is_some_and(|until| now >= until) {
                return Ok(false);
            }
        }
    }

    /// Completes a command after its last piece: appends its reply. Returns the command.
    pub(super) fn end_pieces(
        &mut self,
        s: &mut Session,
        mut pieces: Pieces,
        replies: &mut Vec<u8>,
    ) -> Request<'static> {
        match (&pieces.command, &pieces.next) {
            (Command::Clear { .. }, _) => self.framebuffer.end_clear(s),
            (Command::DrawEye { rect, .. }, _) => self.note_eye(s, *rect),
            (Command::Copy { source, dx, dy }, _) => {
                s.stats.pixels += self.framebuffer.visible(Rect { x: *dx, y: *dy, ..*source });
            }
            (Command::Crc { .. }, Next::CrcRow(_, crc)) => {
                pieces.reply = format!("CRC {:08x}\n", crc.clone().finalize()).into_bytes();
            }
            _ => {}
        }
        match replies.is_empty() {
            true => std::mem::swap(replies, &mut pieces.reply),
            false => replies.append(&mut pieces.reply),
        }
        Request::Command(pieces.command)
    }

    /// Runs one piece, or waits until `until` for a draw that needs no memory. Returns whether it was
    /// the last one.
    fn run_piece(
        &mut self,
        s: &mut Session,
        pieces: &mut Pieces,
        until: Option<Instant>,
    ) -> Result<bool, Fault> {
        let Pieces { command, next, reply, .. } = pieces;
        let height = self.framebuffer.height();
        match next {
            Next::Draw(draw) => self.run_long_draw(s, draw, until),
            Next::Row(row) => {
                let rows = *row..(*row + self.band_rows()).min(height);
                *row = rows.end;
                self.run_band(s, command, rows.clone(), reply)?;
                Ok(rows.end >= height)
            }
            Next::CrcRow(row, crc) => {
                let Command::Crc { rect } = command else { return Ok(true) };
                let whole = Rect { x: 0, y: 0, w: self.framebuffer.width() as i32, h: height as i32 };
                let rect = rect.unwrap_or(whole);
                let rows = draw2d::rows(&self.framebuffer.memory, rect)?;
                let band = (16 * self.band_rows()) as usize;
                rows.skip(*row as usize).take(band).for_each(|row| crc.update(row));
                *row += band as u32;
                Ok(i64::from(*row) >= i64::from(rect.h))
            }
            Next::Record(at) => {
                let Command::Points { packed } = command else { return Ok(true) };
                let end = (*at + PIECE_RECORDS * 8).min(packed.len());
                // An incomplete list is refused by its first piece, before anything is drawn.
                let piece = if packed.len().is_multiple_of(8) { &packed[*at..end] } else { &packed[..] };
                self.points(s, piece)?;
                *at = end;
                Ok(end == packed.len())
            }
            Next::Letter(cursor) => {
                let Command::Figure(Figure::Text { color, utf8, .. }) = command else { return Ok(true) };
                if cursor.bytes() == 0 {
                    // Checked before the first piece, so that nothing is drawn if the text is
                    // refused.
                    let not_utf8 = |e: std::str::Utf8Error| DrawError::NotUtf8 { at: e.valid_up_to() as u64 };
                    std::str::from_utf8(utf8).map_err(not_utf8)?;
                }
                Ok(draw2d::text_piece(
                    &mut self.framebuffer.memory,
                    cursor,
                    utf8,
                    *color,
                    s.blend,
                    PIECE_LETTERS,
                )?)
            }
        }
    }

    fn band_rows(&self) -> u32 {
        (BAND_PIXELS / self.framebuffer.width()).max(1)
    }

    /// Runs the part of a command that lies in `rows`. For COPY and READ these are rows of the
    /// rectangle.
    fn run_band(
        &mut self,
        s: &mut Session,
        command: &Command,
        rows: Range<u32>,
        reply: &mut Vec<u8>,
    ) -> Result<(), Fault> {
        match command {
            Command::Clear { color } => {
                self.framebuffer.memory.clear_rows(rows, *color);
                Ok(())
            }
            Command::Read { rect } => self.read_band(*rect, rows, reply),
            Command::Copy { source, dx, dy } => self.copy_band(*source, [*dx, *dy], rows),
            Command::DrawEye { name, rect } => self.put_eye_band(s, name, *rect, rows),
            Command::Figure(figure) => {
                self.framebuffer.memory.set_window(rows);
                let drawn = self.figure(s, figure);
                self.end_band();
                Ok(drawn?)
            }
            // The other commands have no bands.
            _ => Ok(()),
        }
    }

    /// Ends the restriction of figures to a band of rows.
    pub(super) fn end_band(&mut self) {
        self.framebuffer.memory.set_window(0..self.framebuffer.height());
    }

    fn read_band(&mut self, rect: Rect, rows: Range<u32>, reply: &mut Vec<u8>) -> Result<(), Fault> {
        if rows.start == 0 {
            let bytes = self.read_head(rect, reply)?;
            reply.reserve_exact(bytes as usize);
        }
        let count = rows.len();
        draw2d::rows(&self.framebuffer.memory, rect)?
            .skip(rows.start as usize)
            .take(count)
            .for_each(|row| reply.extend_from_slice(row));
        Ok(())
    }

    /// Copies a band of rows, from the top of the rectangle, or from its bottom if the copy moves
    /// down.
    fn copy_band(&mut self, source: Rect, [dx, dy]: [i32; 2], rows: Range<u32>) -> Result<(), Fault> {
        if rows.start == 0 {
            // Checked before the first band, so that nothing is copied if the command is refused.
            drop(draw2d::rows(&self.framebuffer.memory, source)?);
        }
        let h = source.h;
        let (from, to) = ((rows.start as i32).min(h), (rows.end as i32).min(h));
        let top = if dy > source.y { h - to } else { from };
        let Some(to_y) = dy.checked_add(top) else { return Ok(()) };
        let band = Rect { y: source.y + top, h: to - from, ..source };
        // Like the command in one piece, it stores the pixels whatever BLEND is.
        Ok(draw2d::copy(&mut self.framebuffer.memory, band, [dx, to_y], Blend::Replace)?)
    }

    /// Ends a command early, and records the pixels that it has drawn. The fault says how far it
    /// got.
    fn give_up_pieces(&mut self, s: &Session, pieces: &mut Pieces, limit: Duration) -> Fault {
        let height = self.framebuffer.height();
        let (rows, how_far) = match &mut pieces.next {
            Next::Draw(draw) => {
                self.stop_long_draw(draw);
                if draw.has_depth && !s.surfaces.has_target() {
                    self.discard_depths();
                }
                (0..height, "with a part of it drawn".to_owned())
            }
            _ if matches!(pieces.command, Command::Read { .. } | Command::Crc { .. }) => {
                (0..0, "without effect".to_owned())
            }
            Next::Row(row) => {
                let down = match &pieces.command {
                    Command::Copy { .. } => 0..height,
                    _ => 0..*row,
                };
                (down, format!("after {row} of {height} rows"))
            }
            Next::Record(at) => (0..height, format!("after {} records", *at / 8)),
            Next::Letter(cursor) => (0..height, format!("after {} bytes", cursor.bytes())),
            Next::CrcRow(..) => (0..0, "without effect".to_owned()),
        };
        pieces.was_given_up = !rows.is_empty();
        // A canvas is no frame of a recording: it is cleared instead.
        if !s.surfaces.has_target() {
            self.send_rows(rows);
        }
        let message = format!("given up after {} s, {how_far}", limit.as_secs_f64());
        Fault::new(Code::Quota, message)
    }
}

impl Engine {
    /// Clears the depths, which a draw that was given up has written in part, for the observers
    /// too.
    pub(super) fn discard_depths(&mut self) {
        let format = self.framebuffer.depth_format;
        let other = if format == DepthFormat::F32 { DepthFormat::U32 } else { DepthFormat::F32 };
        for format in [other, format] {
            self.framebuffer.set_depth_format(format);
            self.send_own(Command::Depth(format));
        }
    }

    /// Abandons a command in pieces, because its connection or the server ends.
    pub(in crate::server) fn abandon(&mut self, s: &mut Session, verb: &'static str, mut pieces: Pieces) {
        self.note_abandoned(verb);
        self.on_surface(s, verb, |engine, _| engine.stop_pieces(&mut pieces));
    }

    /// Ends what a command in pieces does beside the render thread.
    pub(super) fn stop_pieces(&mut self, pieces: &mut Pieces) {
        if let Next::Draw(draw) = &mut pieces.next {
            self.stop_long_draw(draw);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::server::engine::Progress;
    use crate::server::{Audience, Limits};

    const SIZE: (u32, u32) = (700, 330);

    /// Creates an engine whose frame has a different value at each place.
    fn engine() -> Engine {
        let mut engine = Engine::new(SIZE.0, SIZE.1).unwrap();
        for (i, byte) in engine.framebuffer.memory.bytes_mut().iter_mut().enumerate() {
            *byte = (i * 37 + i / 251) as u8;
        }
        engine.framebuffer.memory.take_damage();
        engine
    }

    fn rect_of_clip() -> Rect {
        Rect { x: 100, y: 50, w: 501, h: 203 }
    }

    fn commands() -> Vec<Command> {
        let [a, b, c] = [[255, 0, 9, 200], [0, 255, 0, 90], [3, 4, 255, 255]];
        let rect = |x, y, w, h| Rect { x, y, w, h };
        let fill = |points| Command::Figure(Figure::Fill { points, colors: AreaColors::Three([a, b, c]) });
        let records = (0..300_000u32).flat_map(|i| {
            let [x, y] = [i * 7 % 720, i * 13 % 340].map(|v| (v as u16).to_le_bytes());
            [x[0], x[1], y[0], y[1], i as u8, 7, 9, 100]
        });
        vec![
            fill([[-30.0, -20.0], [900.0, 10.0], [40.5, 600.25]]),
            fill([[-3e9, -2e9], [3e9, 1.5], [-1.25, 4e9]]),
            Command::Figure(Figure::Fill {
                points: [[0.5, 0.5], [690.0, 7.0], [5.0, 329.0]],
                colors: AreaColors::One(b),
            }),
            Command::Figure(Figure::FillPoly {
                color: b,
                points: vec![[0.0, 0.0], [699.0, 300.0], [3.0, 320.0], [600.0, 9.5]],
            }),
            Command::Figure(Figure::FillRect { rect: rect(-5, 7, 400, 300).into(), color: b }),
            Command::Figure(Figure::FillRect {
                rect: RealRect { x: 0.25, y: -1e9, w: 699.5, h: 2e9 },
                color: b,
            }),
            Command::Figure(Figure::FillCircle { cx: 300.25, cy: 100.5, r: 250.0, color: a }),
            Command::Figure(Figure::FillEllipse { center: [300.25, 100.5], radii: [400.0, 250.0], color: a }),
            Command::Figure(Figure::Ellipse { center: [300.25, 100.5], radii: [290.0, 150.0], color: a }),
            Command::Figure(Figure::Arc {
                center: [300.25, 100.5],
                radii: [20.0, 350.0],
                angles: [-1.0, 3.5],
                color: a,
            }),
            Command::Figure(Figure::WideLine {
                p0: [-30.0, 20.5],
                p1: [720.0, 300.0],
                width: 90.5,
                color: b,
            }),
            Command::Figure(Figure::Bezier {
                points: [[3.0, 4.0], [900.0, 20.0], [-200.0, 300.0], [690.0, 310.0]],
                width: 40.0,
                color: b,
            }),
            Command::Clear { color: c },
            Command::Copy { source: rect(3, 0, 600, 300), dx: 9, dy: 11 },
            Command::Copy { source: rect(3, 20, 600, 300), dx: 1, dy: -40 },
            Command::Copy { source: rect(3, 20, 600, 300), dx: 7, dy: 20 },
            Command::Points { packed: records.collect() },
            Command::Figure(Figure::Text {
                x: -20,
                y: 3,
                color: a,
                utf8: ("W\u{e9}g\r\u{1f600}Q".repeat(4000) + "\nabc").into_bytes(),
            }),
            Command::Read { rect: rect(10, 20, 600, 300) },
            Command::Crc { rect: None },
            Command::Crc { rect: Some(rect(10, 20, 600, 300)) },
        ]
    }

    #[test]
    fn a_command_in_pieces_is_the_command_in_one() {
        let clip = Some(rect_of_clip());
        for (blend, clip) in [(Blend::Replace, None), (Blend::Over, None), (Blend::Over, clip)] {
            for command in commands() {
                let [mut whole, mut cut] = [(); 2].map(|()| (engine(), Session::new(1, Audience::Owner)));
                (whole.1.surfaces.clip, cut.1.surfaces.clip) = (clip, clip);
                (whole.1.blend, cut.1.blend) = (blend, blend);
                let (mut want, mut got) = (Vec::new(), Vec::new());
                let _ = whole.0.run(&mut whole.1, command.clone(), &mut want).unwrap();
                let mut pieces = cut.0.begin_in_pieces(&mut cut.1, command.clone());
                let mut count = 1;
                let budget = Budget { until: Some(Instant::now()), ..Budget::NONE };
                while let Progress::Pieces(rest) =
                    cut.0.run_pieces(&mut cut.1, pieces, &mut got, budget).unwrap()
                {
                    (pieces, count) = (*rest, count + 1);
                }
                assert!(
                    count > 1 || matches!(command, Command::Crc { .. }),
                    "{} is one piece",
                    command.verb()
                );
                assert!(whole.0.memory().bytes() == cut.0.memory().bytes(), "{} {blend:?}", command.verb());
                assert!(want == got, "{} {blend:?}: the replies differ", command.verb());
                // The door counts commands before it prepares their pieces.
                cut.1.stats.commands += 1;
                assert_eq!(whole.1.stats, cut.1.stats, "{}", command.verb());
                let damage = whole.0.framebuffer.memory.take_damage();
                assert_eq!(damage, cut.0.framebuffer.memory.take_damage(), "{}", command.verb());
                assert_eq!(cut.0.memory().window(), 0..SIZE.1);
            }
        }
    }

    #[test]
    fn what_is_refused_is_refused_as_a_whole() {
        let rect = |x, y, w, h| Rect { x, y, w, h };
        let mut utf8 = vec![b'a'; 100_000];
        utf8[90_000] = 0xff;
        for command in [
            Command::Copy { source: rect(0, 100, 600, 300), dx: 1, dy: 2 },
            Command::Read { rect: rect(0, -1, 5, 5) },
            Command::Crc { rect: Some(rect(0, 0, -1, 5)) },
            Command::Figure(Figure::FillRect { rect: rect(0, 0, 5, -5).into(), color: [1; 4] }),
            Command::Points { packed: vec![0; 8 * 200_000 + 1] },
            Command::Figure(Figure::Text { x: 0, y: 0, color: [1; 4], utf8 }),
        ] {
            let (mut engine, mut session, mut out) = (engine(), Session::new(1, Audience::Owner), Vec::new());
            let before = engine.framebuffer.memory.bytes().to_vec();
            let want = engine.run(&mut session, command.clone(), &mut out).unwrap_err();
            let pieces = engine.begin_in_pieces(&mut session, command.clone());
            let got = engine.run_pieces(&mut session, pieces, &mut out, Budget::NONE).unwrap_err();
            assert_eq!((got, out.len()), (want, 0), "{}", command.verb());
            assert!(engine.framebuffer.memory.bytes() == before, "{} has drawn", command.verb());
            assert_eq!(session.stats.errors, 2);
        }
    }

    #[test]
    fn the_limit_of_replies_is_the_same_in_pieces() {
        let rect = Rect { x: 0, y: 0, w: 600, h: 300 };
        // Room for the pixels, and not for the line before them.
        let limits = Limits { reply_bytes: 600 * 300 * 4 + 5, ..Limits::default() };
        let mut engine = Engine::with_limits(SIZE.0, SIZE.1, limits).unwrap();
        let (mut session, mut out) = (Session::new(1, Audience::Owner), Vec::new());
        let want = engine.run(&mut session, Command::Read { rect }, &mut out).unwrap_err();
        let pieces = engine.begin_in_pieces(&mut session, Command::Read { rect });
        let got = engine.run_pieces(&mut session, pieces, &mut out, Budget::NONE).unwrap_err();
        assert_eq!((got, out.len()), (want, 0));
    }
}

//! Long commands that access the video memory, run in pieces of a few rows, letters or records.
//!
//! In: a command that may take more than about two milliseconds, as [`Engine::is_long`] estimates.
//! Out: the same bytes, reply and recording as if it ran at once. Figures are defined pixel by
//! pixel and each pixel belongs to one band of rows, so bands are exact, under BLEND over, too;
//! POINTS is split between records, TEXT between letters, COPY between rows in the direction that
//! overlap requires. The pieces of DRAW and DRAWSCENE are those of [`super::long_draw`].
//!
//! A command in pieces is a [`Piecewise`]: [`bands`] has those that go by rows, [`lists`] those that
//! go by records, letters or rows of a checksum.
//!
//! Promises, together with the scheduler:
//! - One command at a time is in pieces. Meanwhile queries of other connections run, and see the
//!   memory as it is between two pieces; all other commands wait, and foreign writes to the shared
//!   file are not taken in. So the command is recorded as one, at its end, and a replay gives the
//!   same bytes.
//! - A command that exceeds the time limit ([`crate::Limits::command_time`]) is ended with
//!   `EQUOTA`. The pixels that it has drawn stay, and are recorded as runs of pixels, which is
//!   exact; the message says how far it got. Depths that a draw may have written are cleared, in the
//!   recording too.
//! - When the server ends, a command in pieces is abandoned: the memory contains a part of it, the
//!   recording nothing.
//!
//! An error here would show as bytes that differ from those of the command in one piece (the tests),
//! or from those of a replay.

mod bands;
mod cost;
mod lists;
#[cfg(test)]
mod tests;

use super::drawing::Drawing;
use super::long_draw::LongDraw;
use super::{Decoded, Engine, Request};
use crate::clock::Instant;
use crate::{Budget, Session};
use bands::{
    Bands, BlitBands, ClearBands, CopyBands, EyeBands, FigureBands, ImageBands, ReadBands, StampBands,
};
pub(super) use bands::{band_rows, part_in};
use fbptr_command::{Command, Figure, Rect};
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{DepthFormat, MemoryUse, Reservation};
use lists::{Checksum, Digits, Letters, Records, Run};
use std::fmt;
use std::ops::Range;
use std::time::Duration;

/// A command and the position of its next piece.
trait Piecewise: fmt::Debug + Send {
    /// Runs the next piece; a draw may wait for it until a time. Returns whether it was the last
    /// one.
    ///
    /// # Errors
    /// The reason for which the command is refused: if it is the first piece, nothing was drawn.
    fn run(&mut self, engine: &mut Engine, s: &mut Session, until: Option<Instant>) -> Result<bool, Fault>;

    /// Completes the command after its last piece: counts what it did, and appends its reply.
    fn end(&mut self, _: &mut Engine, _: &mut Session, _: &mut Vec<u8>) {}

    /// Ends the command early. Returns the rows in which it may have drawn, and how far it got.
    fn give_up(&mut self, engine: &mut Engine, s: &Session) -> (Range<u32>, String);

    /// Ends what the command does beside the render thread.
    fn stop(&mut self, _: &mut Engine) {}

    /// Returns whether the first piece runs in the slice in which the command begins.
    fn runs_at_once(&self) -> bool {
        true
    }

    /// Returns the bytes of its payload.
    fn payload_bytes(&self) -> usize {
        0
    }

    /// Returns the command.
    fn into_command(self: Box<Self>) -> Command;
}

/// A command that runs in pieces.
#[derive(Debug)]
pub(crate) struct Pieces {
    verb: &'static str,
    work: Box<dyn Piecewise>,
    begun: Instant,
    /// Set once it was given up, with a part of it drawn.
    was_given_up: bool,
    /// The memory budget's reservation for its payload.
    _held: Reservation,
}

impl Pieces {
    /// Returns the command's verb.
    pub fn verb(&self) -> &'static str {
        self.verb
    }

    /// Returns whether it was given up, with a part of it drawn.
    pub fn was_given_up(&self) -> bool {
        self.was_given_up
    }

    /// Returns whether its first piece runs in the slice in which it begins. A draw waits for the
    /// next one, because its thread prepares it meanwhile.
    pub fn runs_at_once(&self) -> bool {
        self.work.runs_at_once()
    }
}

/// Returns the pieces of a command that [`Engine::is_long`] may find long; any other is given back.
fn pieces_of(s: &Session, command: Command) -> Result<Box<dyn Piecewise>, Command> {
    Ok(match command {
        Command::Clear { color } => Bands::boxed(ClearBands { color }),
        Command::Read { rect } => Bands::boxed(ReadBands { rect, reply: Vec::new() }),
        Command::Copy { source, dx, dy } => Bands::boxed(CopyBands { source, dest: [dx, dy] }),
        Command::Stamp { name, x, y, key } => Bands::boxed(StampBands { name, at: [x, y], key }),
        Command::Crc { rect } => Box::new(Checksum::new(rect)),
        Command::Peek { offset, n } => Box::new(Digits::new(offset, n)),
        Command::Blit { rect, rgba } => Bands::boxed(BlitBands { rect, rgba }),
        Command::PixelRun { x, y, rgba } => Box::new(Run::new(x, y, rgba)),
        Command::Points { packed } => Box::new(Records::new(packed)),
        Command::Figure(Figure::Text { x, y, color, utf8 }) => {
            Box::new(Letters::new([x, y], color, utf8, s.text_size))
        }
        Command::Figure(figure) => Bands::boxed(FigureBands { figure }),
        other => return Err(other),
    })
}

impl Engine {
    /// Prepares the first piece of a long command, which has been counted.
    ///
    /// # Errors
    /// Returns a command that has no pieces.
    pub(super) fn begin_in_pieces(&mut self, s: &mut Session, command: Command) -> Result<Pieces, Command> {
        let verb = command.verb();
        let work = pieces_of(s, command)?;
        let taken_over = s.payload_held.take();
        let mut held = taken_over.unwrap_or_else(|| self.quotas.budget.empty(MemoryUse::Payloads));
        held.set(work.payload_bytes() as u64);
        Ok(Pieces { verb, work, begun: Instant::now(), was_given_up: false, _held: held })
    }

    /// Prepares the pieces of a draw, which has been counted.
    ///
    /// # Errors
    /// Returns the draw if the system has no thread to give.
    pub(super) fn begin_draw_in_pieces(&mut self, drawing: Drawing) -> Result<Pieces, Drawing> {
        let command = drawing.command();
        let draw = self.begin_long_draw(drawing)?;
        Ok(self.without_payload(command.verb(), Box::new(DrawWork { command, draw })))
    }

    /// Prepares the pieces of `DRAWEYE`, which has been counted and has its picture.
    pub(super) fn begin_eye_in_pieces(&mut self, name: String, rect: Rect) -> Pieces {
        let verb = Command::DrawEye { name: String::new(), rect }.verb();
        self.without_payload(verb, Bands::boxed(EyeBands { name, rect }))
    }

    /// Prepares the pieces of `IMAGE`, which has been counted and has its picture.
    pub(super) fn begin_image_in_pieces(&mut self, rect: Rect, picture: Decoded, file: Vec<u8>) -> Pieces {
        let verb = Command::Image { x: 0, y: 0, file: Vec::new() }.verb();
        self.without_payload(verb, Bands::boxed(ImageBands { rect, picture, file }))
    }

    fn without_payload(&self, verb: &'static str, work: Box<dyn Piecewise>) -> Pieces {
        let held = self.quotas.budget.empty(MemoryUse::Payloads);
        Pieces { verb, work, begun: Instant::now(), was_given_up: false, _held: held }
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
            let is_last = pieces.work.run(self, s, budget.until)?;
            #[cfg(debug_assertions)]
            self.meet_defect(pieces.verb);
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
        pieces.work.end(self, s, replies);
        Request::Command(pieces.work.into_command())
    }

    /// Ends the restriction of figures to a band of rows.
    pub(super) fn end_band(&mut self) {
        self.framebuffer.memory.set_window(0..self.framebuffer.height());
    }

    /// Ends a command early, and records the pixels that it has drawn. The fault says how far it
    /// got.
    fn give_up_pieces(&mut self, s: &Session, pieces: &mut Pieces, limit: Duration) -> Fault {
        let (rows, how_far) = pieces.work.give_up(self, s);
        pieces.was_given_up = !rows.is_empty();
        // A canvas is no frame of a recording: it is cleared instead.
        if !s.surfaces.has_target() {
            self.send_rows(rows);
        }
        let message = format!("given up after {} s, {how_far}", limit.as_secs_f64());
        Fault::new(Code::Quota, message)
    }

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
    pub(crate) fn abandon(&mut self, s: &mut Session, verb: &'static str, mut pieces: Pieces) {
        self.note_abandoned(verb);
        self.on_surface(s, verb, |engine, _| engine.stop_pieces(&mut pieces));
    }

    /// Ends what a command in pieces does beside the render thread.
    pub(super) fn stop_pieces(&mut self, pieces: &mut Pieces) {
        pieces.work.stop(self);
    }
}

/// A `DRAW` or `DRAWSCENE` on the drawing thread.
#[derive(Debug)]
struct DrawWork {
    command: Command,
    draw: LongDraw,
}

impl Piecewise for DrawWork {
    fn run(&mut self, engine: &mut Engine, s: &mut Session, until: Option<Instant>) -> Result<bool, Fault> {
        engine.run_long_draw(s, &mut self.draw, until)
    }

    fn give_up(&mut self, engine: &mut Engine, s: &Session) -> (Range<u32>, String) {
        self.stop(engine);
        if self.draw.has_depth && !s.surfaces.has_target() {
            engine.discard_depths();
        }
        (0..engine.framebuffer.height(), "with a part of it drawn".to_owned())
    }

    fn stop(&mut self, engine: &mut Engine) {
        engine.stop_long_draw(&mut self.draw);
    }

    fn runs_at_once(&self) -> bool {
        false
    }

    fn into_command(self: Box<Self>) -> Command {
        self.command
    }
}

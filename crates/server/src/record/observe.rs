//! The recorder as an observer of the engine.
//!
//! In: the engine's events. Out: commands that have taken effect, in the recording. Runs on the
//! render thread. Promises that a command which was refused, or whose rest is left for later, leaves
//! nothing in the recording.

use super::Recorder;
use fbptr_command::{Command, Figure};
use fbptr_core::draw2d::{Blend, Line};
use fbptr_core::memory::{MemoryUse, VideoMemory};
use fbptr_engine::engine::{Event, FrameView, Observer, OutputState, OutputStatus, Request};
use std::time::Instant;

impl Observer for Recorder {
    fn event(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        if self.is_open {
            self.record(event, frame);
        }
        if matches!(event, Event::Tick(_) | Event::End) {
            // The writer of a recording that ended early still holds some bytes.
            let queued = self.stats().queued_bytes;
            self.held.iter_mut().for_each(|held| held.set(queued));
        }
    }

    fn wants_contents(&self) -> bool {
        self.is_open
    }

    fn deadline(&self, _: Instant, _: bool) -> Option<Instant> {
        self.next_deadline()
    }

    fn output(&self, _: FrameView<'_>) -> Option<OutputStatus> {
        let state = match self.has_failed() {
            true => OutputState::Failed,
            false if self.is_open => OutputState::On,
            false => return None,
        };
        let stats = self.stats();
        Some(output(state, stats.written_bytes, stats.queued_bytes))
    }
}

/// Returns the state of the output, with its bytes that have been written and those that have not.
pub(crate) fn output(state: OutputState, written_bytes: u64, queued_bytes: u64) -> OutputStatus {
    let figures = vec![("record_bytes", written_bytes), ("record_queue", queued_bytes)];
    OutputStatus { name: "record", state, figures }
}

impl Recorder {
    fn record(&mut self, event: &Event<'_>, frame: FrameView<'_>) {
        match event {
            Event::Attached(budget) => {
                self.held = Some(budget.empty(MemoryUse::Records));
                self.begin_with(frame.memory);
            }
            // A player's connections begin as the specification says.
            Event::Opened { connection, blend: Blend::Over } => {
                self.command(*connection, &Command::Blend { over: true });
            }
            Event::Closed { connection } => self.end(*connection),
            Event::Begins { connection, offset, request } => self.request(*connection, *offset, request),
            Event::Done { files: [], .. } => {}
            Event::Done { connection, files } => self.attach_files(*connection, files),
            Event::Undone => self.roll_back(),
            Event::Pixels(runs) => self.pixel_runs(runs, frame.memory),
            Event::Slice(now) => self.set_time(*now),
            Event::Tick(now) => self.tick(*now),
            Event::End => self.finish(),
            _ => {}
        }
    }

    /// Records the memory's contents, unless it is in the state in which a replay begins.
    fn begin_with(&mut self, memory: &VideoMemory) {
        let pixels = memory.bytes().as_chunks::<4>().0;
        if pixels.iter().any(|pixel| *pixel != VideoMemory::CLEAR) {
            self.pixel_runs(std::slice::from_ref(&(0..pixels.len() as u32)), memory);
        }
    }

    fn request(&mut self, connection: u64, offset: [i32; 2], request: &Request<'_>) {
        match *request {
            Request::Command(ref command) => self.command(connection, command),
            Request::Pixel { x, y, color } => self.command(connection, &Command::Pixel { x, y, color }),
            Request::Pixels(records) => self.pixels(connection, records, offset),
            Request::BinaryPixels(records) => self.binary_pixels(connection, records),
            Request::Lines(lines) => {
                for &Line { p0, p1, color } in lines {
                    self.command(connection, &Command::Figure(Figure::Line { p0, p1, color }));
                }
            }
            Request::PixelRun { x, y, rgba } => self.pixel_run(connection, x, y, rgba),
            Request::Blit { rect, rgba } => self.blit(connection, rect, rgba),
            Request::Points(packed) => self.points(connection, packed),
        }
    }
}

//! `step`: the last command once more, pixel by pixel, with the numbers that decide each.
//!
//! In: the command's line, and the frame before and after it. Out: its pixels, as
//! [`crate::server::figure_steps`] has them, which the viewer steps through as well. Tested by
//! `tests/cli/draw.rs`.

use crate::command::{Command, Decoder, EndOfInput, Flow, Limits, Sink, StreamError, StreamPosition};
use crate::memory::{Rgba, VideoMemory};
use crate::server::Step;

/// Returns the command of `line`, and its pixels.
pub(super) fn steps(line: &str, before: &VideoMemory, after: &VideoMemory) -> (Option<Command>, Vec<Step>) {
    let command = First::of(line);
    let steps = crate::server::figure_steps(command.as_ref(), before, after);
    (command, steps)
}

/// Keeps the first command of a stream.
#[derive(Default)]
struct First(Option<Command>);

impl First {
    fn of(line: &str) -> Option<Command> {
        let (mut first, mut decoder) = (First::default(), Decoder::new(Limits::default()));
        if decoder.feed(format!("{line}\n").as_bytes(), &mut first) != Flow::Stop {
            let _ = decoder.finish(EndOfInput::File, &mut first);
        }
        first.0
    }
}

impl Sink for First {
    fn pixel(&mut self, _: i32, _: i32, _: Rgba) {}

    fn binary_pixels(&mut self, _: &[u8]) {}

    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        self.0.get_or_insert(command);
        Flow::Stop
    }

    fn error(&mut self, _: StreamError) -> Flow {
        Flow::Stop
    }
}

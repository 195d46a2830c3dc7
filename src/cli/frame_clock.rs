//! Frame times that `--frame-times` of `play` and `view` prints.
//!
//! In: the moments at which frames begin and are complete. Out: one line on standard error. A first
//! frame that includes reading and preparation is printed separately.

use super::say_as_program;
use crate::measure::FrameTimes;
use std::time::{Duration, Instant};

/// Clock that is read at the end of every frame.
#[derive(Debug)]
pub(super) struct FrameClock {
    begin: Instant,
    /// Duration of the frame with the preparation.
    first: Option<Duration>,
    others: FrameTimes,
}

impl FrameClock {
    /// Creates the clock; a frame begins now.
    pub fn start() -> Self {
        FrameClock { begin: Instant::now(), first: None, others: FrameTimes::default() }
    }

    /// Begins a frame anew, so that what was done since the end of the last one is not counted.
    pub fn begin_frame(&mut self) {
        self.begin = Instant::now();
    }

    /// Ends a frame; the next one begins at the same moment.
    pub fn end_frame(&mut self) {
        let time = self.lap();
        self.others.push(time);
    }

    /// Ends a frame of a stream: the first one, which includes preparation, is kept separately.
    pub fn end_frame_of_stream(&mut self) {
        match self.first {
            None => self.first = Some(self.lap()),
            Some(_) => self.end_frame(),
        }
    }

    fn lap(&mut self) -> Duration {
        let begin = std::mem::replace(&mut self.begin, Instant::now());
        self.begin - begin
    }

    /// Prints the times.
    pub fn report(&self) {
        let first_ms = self.first.map(|first| first.as_secs_f64() * 1e3);
        match (self.others.is_empty(), first_ms) {
            (true, None) => say_as_program(
                "--frame-times: there were no frames to time: --frames asks for more, and a still picture is drawn once",
            ),
            (true, Some(ms)) => say_as_program(format_args!("one frame: {ms:.3} ms, including preparation")),
            (false, None) => say_as_program(&self.others),
            (false, Some(ms)) => {
                say_as_program(format_args!("{}; the first, including preparation, {ms:.3} ms", self.others))
            }
        }
    }
}

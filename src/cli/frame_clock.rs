//! Frame times that `--frame-times` of `play` and `view` prints.
//!
//! In: the moments at which frames are complete. Out: one line on standard error. The first frame is
//! told by itself, because it includes what is read and prepared once.

use super::say_as_program;
use crate::measure::FrameTimes;
use std::time::{Duration, Instant};

/// Clock that is read at the end of every frame.
#[derive(Debug)]
pub(super) struct FrameClock {
    begin: Instant,
    first: Option<Duration>,
    others: FrameTimes,
}

impl FrameClock {
    /// Creates the clock; the first frame begins now.
    pub fn start() -> Self {
        FrameClock { begin: Instant::now(), first: None, others: FrameTimes::default() }
    }

    /// Ends a frame; the next one begins at the same moment.
    pub fn end_frame(&mut self) {
        let now = Instant::now();
        let time = now - self.begin;
        match self.first {
            None => self.first = Some(time),
            Some(_) => self.others.push(time),
        }
        self.begin = now;
    }

    /// Begins the frame anew, so that what was done since the end of the last one is not counted.
    pub fn restart_frame(&mut self) {
        self.begin = Instant::now();
    }

    /// Prints the times.
    pub fn report(&self) {
        match self.first {
            None => say_as_program("--frame-times: there was no frame"),
            Some(first) => {
                let first_ms = first.as_secs_f64() * 1e3;
                match self.others.is_empty() {
                    true => {
                        say_as_program(format_args!("one frame: {first_ms:.3} ms, with what it prepared"))
                    }
                    false => say_as_program(format_args!(
                        "{}; the first, with what it prepared, {first_ms:.3} ms",
                        self.others
                    )),
                }
            }
        }
    }
}

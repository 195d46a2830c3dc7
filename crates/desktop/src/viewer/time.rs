//! Time in the viewer: animation, stepping by frames, and the frame rate.

use super::{Show, Subject, Viewer};
use std::time::Duration;

/// Time for which a message is shown.
const MESSAGE_TIME: Duration = Duration::from_secs(4);

/// Time of one turn of the turntable.
const TURN_SECONDS: f64 = 12.0;

/// Time of one turn of a polytope.
const POLYTOPE_SECONDS: f64 = 20.0;

/// Most frames of the tour between two pictures.
const MOST_TOUR_FRAMES: i64 = 3;

/// Frame rate measurement: pictures drawn since a time, and the last measured rate.
#[derive(Default)]
pub(super) struct Rate {
    pub(super) since: Duration,
    pub(super) pictures: u32,
    pub(super) per_second: f64,
}

/// Returns the frames a second at which a turntable makes one turn in `frames` frames.
pub fn turntable_rate(frames: u32) -> f64 {
    f64::from(frames) / TURN_SECONDS
}

impl Viewer {
    /// Returns whether the contents change over time.
    pub fn is_animated(&self) -> bool {
        match &self.subject {
            Subject::Space(space) => space.is_animated() || self.wishes.turns,
            Subject::Nd(_) => self.wishes.turns,
            Subject::Replay(replay) => replay.is_animated(),
            Subject::Tour(_) => true,
        }
    }

    /// Advances time by `by`: animation, messages and the frame rate.
    pub fn advance(&mut self, by: Duration) {
        self.clock += by;
        if self.message.as_ref().is_some_and(|(_, since)| self.clock >= *since + MESSAGE_TIME) {
            self.message = None;
        }
        let window = self.clock - self.rate.since;
        if window >= Duration::from_millis(500) {
            self.rate.per_second = f64::from(self.rate.pictures) / window.as_secs_f64();
            (self.rate.since, self.rate.pictures) = (self.clock, 0);
        }
        if self.exact.poll() {
            self.other_of = None;
        }
        if !self.is_running() {
            return;
        }
        self.passed += by.as_secs_f64() * self.fps;
        let frames = self.passed.floor();
        self.passed -= frames;
        // Every frame of the tour is played to reach the next: where that takes longer than the
        // frame lasts, the tour goes slower.
        let most = if matches!(self.subject, Subject::Tour(_)) { MOST_TOUR_FRAMES } else { i64::MAX };
        self.step((frames as i64).min(most));
    }

    /// Returns whether time passes: an exact picture belongs to one moment, so it stops while the
    /// difference is shown.
    fn is_running(&self) -> bool {
        !self.is_paused && self.is_animated() && self.show != Show::Difference
    }

    /// Returns the time from the last [`Viewer::advance`] to the next frame, if one is to come by
    /// itself. Whoever shows the frames sleeps no longer, or frames are left out.
    pub fn time_to_next_frame(&self) -> Option<Duration> {
        self.is_running().then(|| Duration::from_secs_f64((1.0 - self.passed).clamp(0.0, 1.0) / self.fps))
    }

    /// Moves time by `frames`, forwards or backwards.
    pub fn step(&mut self, frames: i64) {
        let last = match &self.subject {
            Subject::Replay(replay) => replay.last_frame().unwrap_or(u64::MAX),
            Subject::Tour(tour) => tour.last_frame(),
            _ => u64::MAX,
        };
        let frame = self.wishes.frame.saturating_add_signed(frames).min(last);
        if let (true, Subject::Nd(nd)) = (self.wishes.turns, &mut self.subject) {
            let [a, b] = nd.plane();
            nd.turn_by(a, b, frames as f64 * 360.0 / (POLYTOPE_SECONDS * self.fps));
            self.is_stale |= frames != 0;
        } else if self.wishes.turns {
            self.turned_frames += frames;
            let turns = self.turned_frames as f64 / (TURN_SECONDS * self.fps);
            self.wishes.turned_rad = (turns % 1.0) * std::f64::consts::TAU;
            self.is_stale |= frames != 0;
        }
        if frame != self.wishes.frame {
            self.set_frame(frame);
            self.is_stale = true;
        }
    }

    /// Sets the frame number, and the time that belongs to it.
    pub(super) fn set_frame(&mut self, frame: u64) {
        let first = if self.start_time > 0.0 { (self.start_time * self.fps) as u64 } else { 0 };
        self.wishes.frame = frame;
        self.wishes.time = self.start_time + (frame as f64 - first as f64) / self.fps;
    }

    /// Returns the time in seconds since the scene's start.
    pub fn time(&self) -> f64 {
        self.wishes.time
    }
}

//! `--after`: the moment at which the picture is taken and the program ended.

use std::str::FromStr;
use std::time::{Duration, Instant};

/// Time without a change that counts as still, if none is given.
const STILL: Duration = Duration::from_millis(500);

/// A moment in the program's life.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum After {
    /// So long after its start.
    Time(Duration),
    /// At this frame of those that differ from the one before, from 1.
    Frames(u64),
    /// The end of the first span of this length in which its picture did not change, from its first change on.
    Still(Duration),
}

impl FromStr for After {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected =
            || format!("--after: 2s, 500ms, a number of frames, still or still:2s is expected, not {text:?}");
        if text == "still" {
            return Ok(After::Still(STILL));
        }
        if let Some(time) = text.strip_prefix("still:") {
            return time_of(time).map(After::Still).ok_or_else(expected);
        }
        if text.bytes().all(|b| b.is_ascii_digit()) {
            return text.parse().ok().filter(|n| *n > 0).map(After::Frames).ok_or_else(expected);
        }
        time_of(text).map(After::Time).ok_or_else(expected)
    }
}

/// Parses a time with its unit: ms, s or m. At most a day.
pub fn time_of(text: &str) -> Option<Duration> {
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "ms" => 0.001,
        "s" => 1.0,
        "m" => 60.0,
        _ => return None,
    };
    let is_number = digits.starts_with(|c: char| c.is_ascii_digit());
    let seconds = digits.parse::<f64>().ok().filter(|_| is_number)? * unit;
    (0.0..=86_400.0).contains(&seconds).then(|| Duration::from_secs_f64(seconds))
}

/// Counts the frames of a program until its moment has come.
#[derive(Debug)]
pub struct Countdown {
    after: After,
    started: Instant,
    frames: u64,
    changed: Option<Instant>,
}

impl Countdown {
    pub fn new(after: After, now: Instant) -> Self {
        Countdown { after, started: now, frames: 0, changed: None }
    }

    /// Notes a frame, and returns whether the moment has come. While input is replayed, no picture
    /// is still.
    pub fn note(&mut self, is_changed: bool, is_replayed: bool, now: Instant) -> bool {
        self.frames += u64::from(is_changed);
        if is_changed || (is_replayed && self.changed.is_some()) {
            self.changed = Some(now);
        }
        match self.after {
            After::Time(time) => now >= self.started + time,
            After::Frames(frames) => self.frames >= frames,
            After::Still(time) => self.changed.is_some_and(|changed| now >= changed + time),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moments_are_times_frames_or_stillness() {
        for (text, after) in [
            ("2s", After::Time(Duration::from_secs(2))),
            ("1.5s", After::Time(Duration::from_millis(1500))),
            ("250ms", After::Time(Duration::from_millis(250))),
            ("30", After::Frames(30)),
            ("still", After::Still(STILL)),
            ("still:2s", After::Still(Duration::from_secs(2))),
        ] {
            assert_eq!(text.parse(), Ok(after), "{text}");
        }
        for text in ["", "0", "2", "s", "-1s", "1h", "still:", "still:x", "2 s", "infs", "1e9s", "é"] {
            assert_eq!(text.parse::<After>().is_ok(), text == "2", "{text}");
        }
    }

    #[test]
    fn a_countdown_ends_once_its_moment_has_come() {
        let now = Instant::now();
        let at = |ms: u64| now + Duration::from_millis(ms);
        let mut frames = Countdown::new(After::Frames(2), now);
        let seen = [
            frames.note(true, false, at(1)),
            frames.note(false, true, at(2)),
            frames.note(true, false, at(3)),
        ];
        assert_eq!(seen, [false, false, true]);
        let mut still = Countdown::new(After::Still(Duration::from_millis(100)), now);
        let seen = [
            still.note(false, true, at(500)),
            still.note(true, false, at(600)),
            still.note(false, true, at(650)),
        ];
        assert_eq!(seen, [false; 3]);
        assert!(!still.note(true, false, at(700)));
        assert!(!still.note(false, false, at(799)) && still.note(false, false, at(800)));
        let mut time = Countdown::new(After::Time(Duration::from_millis(50)), now);
        assert!(!time.note(true, false, at(49)) && time.note(false, true, at(50)));
    }
}

//! `--after`: the moment at which the picture is taken and the program ended.

use std::str::FromStr;
use std::time::{Duration, Instant};

/// Time without a change that counts as still, if none is given.
const STILL: Duration = Duration::from_millis(500);
/// Time that a picture has to become still, if no limit is given.
const STILL_LIMIT: Duration = Duration::from_secs(60);

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

/// Reads `--limit`: the time after which a program is ended in any case. One that waits for a still
/// picture has a limit of its own.
///
/// # Errors
/// A text that is no time.
pub fn limit_of(text: Option<&str>, after: Option<After>) -> Result<Option<Duration>, String> {
    match (text, after) {
        (Some(text), _) => match time_of(text) {
            Some(time) => Ok(Some(time)),
            None => Err(format!("--limit: 10s or 500ms is expected, not {text:?}")),
        },
        (None, Some(After::Still(_))) => Ok(Some(STILL_LIMIT)),
        (None, _) => Ok(None),
    }
}

/// Moment that has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// That of `--after`.
    After,
    /// The limit.
    Limit,
}

/// Counts the frames of a program until its moment has come.
#[derive(Debug)]
pub struct Countdown {
    after: Option<After>,
    limit: Option<Duration>,
    started: Instant,
    frames: u64,
    changed: Option<Instant>,
}

impl Countdown {
    pub fn new(after: Option<After>, limit: Option<Duration>, now: Instant) -> Self {
        Countdown { after, limit, started: now, frames: 0, changed: None }
    }

    /// Notes a frame, and returns the moment that has come. While input is replayed, no picture is
    /// still.
    pub fn note(&mut self, is_changed: bool, is_replayed: bool, now: Instant) -> Option<Moment> {
        self.frames += u64::from(is_changed);
        if is_changed || (is_replayed && self.changed.is_some()) {
            self.changed = Some(now);
        }
        let has_come = self.after.is_some_and(|after| match after {
            After::Time(time) => now >= self.started + time,
            After::Frames(frames) => self.frames >= frames,
            After::Still(time) => self.changed.is_some_and(|changed| now >= changed + time),
        });
        let is_over = || self.limit.is_some_and(|limit| now >= self.started + limit);
        match has_come {
            true => Some(Moment::After),
            false => is_over().then_some(Moment::Limit),
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
        let start = |after| Countdown::new(Some(after), None, now);
        let mut frames = start(After::Frames(2));
        let seen = [
            frames.note(true, false, at(1)),
            frames.note(false, true, at(2)),
            frames.note(true, false, at(3)),
        ];
        assert_eq!(seen, [None, None, Some(Moment::After)]);
        let mut still = start(After::Still(Duration::from_millis(100)));
        let seen = [
            still.note(false, true, at(500)),
            still.note(true, false, at(600)),
            still.note(false, true, at(650)),
        ];
        assert_eq!(seen, [None; 3]);
        assert_eq!(still.note(true, false, at(700)), None);
        assert_eq!(still.note(false, false, at(799)), None);
        assert_eq!(still.note(false, false, at(800)), Some(Moment::After));
        let mut time = start(After::Time(Duration::from_millis(50)));
        assert_eq!(time.note(true, false, at(49)), None);
        assert_eq!(time.note(false, true, at(50)), Some(Moment::After));
    }

    #[test]
    fn a_picture_that_is_never_still_has_a_limit() {
        let still = After::Still(STILL);
        assert_eq!(limit_of(None, Some(still)), Ok(Some(STILL_LIMIT)));
        assert_eq!(limit_of(None, Some(After::Frames(3))), Ok(None));
        assert_eq!(limit_of(Some("2s"), None), Ok(Some(Duration::from_secs(2))));
        assert!(limit_of(Some("2"), None).is_err());
        let now = Instant::now();
        let mut count = Countdown::new(Some(still), Some(Duration::from_secs(1)), now);
        let at = |ms: u64| now + Duration::from_millis(ms);
        let seen = [400, 800, 1200].map(|ms| count.note(true, false, at(ms)));
        assert_eq!(seen, [None, None, Some(Moment::Limit)]);
    }
}

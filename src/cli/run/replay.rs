//! Replayed input: `--keys FILE` and `--type TEXT`.

use super::after::time_of;
use crate::fbdev::typing;
use crate::input::InputEvent;
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Time between two typed characters.
const PER_CHARACTER: Duration = Duration::from_millis(50);
/// Time for which a key of a character or of `press` is held: a program that asks once a frame
/// which keys are held sees it.
const HELD: Duration = Duration::from_millis(25);
/// Time for which the picture must not change before `--type` begins.
const STILL: Duration = Duration::from_millis(500);

/// Events with their times, counted from the program's first opening of the framebuffer, and a text
/// that is typed after the last of them.
#[derive(Debug, Default)]
pub struct Replay {
    events: VecDeque<(Duration, InputEvent)>,
    /// Characters that are typed once the picture is still.
    text: VecDeque<char>,
    opened: Option<Instant>,
    /// Time of the picture's last change, or of the last event if that is later.
    changed: Option<Instant>,
    /// Events of the typed characters, once typing has begun.
    typed: Option<VecDeque<(Instant, InputEvent)>>,
}

impl Replay {
    /// Creates a replay of the lines of a file, and of a text.
    ///
    /// # Errors
    /// The first line that is none, with its number.
    pub fn new(lines: &str, text: &str) -> Result<Replay, String> {
        let mut events = Vec::new();
        for (number, line) in (1..).zip(lines.lines()) {
            let line = line.trim_end();
            if !line.is_empty() && !line.starts_with('#') {
                events.extend(line_events(line).ok_or_else(|| {
                    format!(
                        "line {number}: TIME and key down|up NAME, press NAME, type TEXT, mouse X Y BUTTONS or wheel DX DY \
                         is expected, as in 1.5s press left, not {line:?}"
                    )
                })?);
            }
        }
        events.sort_by_key(|(time, _)| *time);
        Ok(Replay { events: events.into(), text: text.chars().collect(), ..Replay::default() })
    }

    /// Returns whether all events have been returned by [`Replay::due`].
    pub fn is_over(&self) -> bool {
        self.events.is_empty() && self.text.is_empty() && self.typed.as_ref().is_none_or(VecDeque::is_empty)
    }

    /// Returns the events that are due.
    pub fn due(&mut self, is_open: bool, is_changed: bool, now: Instant) -> Vec<InputEvent> {
        if !is_open {
            return Vec::new();
        }
        let opened = *self.opened.get_or_insert(now);
        let mut due = Vec::new();
        while self.events.front().is_some_and(|(time, _)| now >= opened + *time) {
            due.extend(self.events.pop_front().map(|(_, event)| event));
        }
        // An event may change the picture later: the text waits for that.
        if is_changed || (!due.is_empty() && self.changed.is_some()) {
            self.changed = Some(now);
        }
        let is_still = self.changed.is_some_and(|changed| now >= changed + STILL);
        if is_still && self.events.is_empty() && self.typed.is_none() {
            let characters = std::mem::take(&mut self.text);
            self.typed = Some(timed_text(characters, now).into());
        }
        if let Some(typed) = &mut self.typed {
            while typed.front().is_some_and(|(time, _)| now >= *time) {
                due.extend(typed.pop_front().map(|(_, event)| event));
            }
        }
        due
    }
}

/// Returns the events of typing characters, from a time on.
fn timed_text<T: std::ops::Add<Duration, Output = T> + Copy>(
    characters: impl IntoIterator<Item = char>,
    start: T,
) -> Vec<(T, InputEvent)> {
    let timed = |(i, character)| {
        let down_at = start + PER_CHARACTER * i;
        let [down, up] = typing(character);
        let down = down.into_iter().map(move |event| (down_at, event));
        down.chain(up.into_iter().map(move |event| (down_at + HELD, event)))
    };
    (0u32..).zip(characters).flat_map(timed).collect()
}

/// Parses a line: its events, each with its time.
fn line_events(line: &str) -> Option<Vec<(Duration, InputEvent)>> {
    let (time, rest) = line.split_once(' ')?;
    let time = time_of(time)?;
    let (verb, rest) = rest.trim_start().split_once(' ')?;
    if verb == "type" {
        return Some(timed_text(rest.chars(), time));
    }
    let words: Vec<&str> = rest.split_whitespace().collect();
    let key = |name: &str, down| {
        crate::fbdev::keys::by_name(name).map(|_| InputEvent::Key { name: name.to_owned(), down })
    };
    let events = match (verb, &words[..]) {
        ("key", ["down", name]) => vec![key(name, true)?],
        ("key", ["up", name]) => vec![key(name, false)?],
        ("press", [name]) => return press(name, time),
        ("mouse", [x, y, buttons]) => {
            let buttons = buttons.parse().ok().filter(|b| *b < 8)?;
            vec![InputEvent::Mouse { x: x.parse().ok()?, y: y.parse().ok()?, buttons }]
        }
        ("wheel", [dx, dy]) => vec![InputEvent::Wheel { dx: dx.parse().ok()?, dy: dy.parse().ok()? }],
        _ => return None,
    };
    Some(events.into_iter().map(|event| (time, event)).collect())
}

/// Returns the events of pressing a key: with the character that it types, if it types one.
fn press(name: &str, time: Duration) -> Option<Vec<(Duration, InputEvent)>> {
    let key = crate::fbdev::keys::by_name(name)?;
    let control = match name {
        "enter" => Some('\n'),
        "tab" => Some('\t'),
        "escape" => Some('\x1b'),
        "backspace" => Some('\x08'),
        _ => None,
    };
    let typed = control.or_else(|| Some(char::from(key.characters[0])).filter(|c| *c != '\0'));
    let event = |down| InputEvent::Key { name: name.to_owned(), down };
    Some(match typed {
        Some(character) => timed_text([character], time),
        None => vec![(time, event(true)), (time + HELD, event(false))],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(name: &str, down: bool) -> InputEvent {
        InputEvent::Key { name: name.into(), down }
    }

    #[test]
    fn lines_are_events_in_the_order_of_their_times() {
        let text = "# a comment\n\n2s key up left\n500ms key down left\n1s mouse 3 -4 5\n1s wheel 0 -1\n";
        let mut replay = Replay::new(text, "").unwrap();
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        assert!(replay.due(false, false, start).is_empty());
        assert_eq!(replay.due(true, false, start), []);
        assert_eq!(replay.due(true, false, at(500)), [key("left", true)]);
        let later = replay.due(true, false, at(3000));
        let mouse = InputEvent::Mouse { x: 3, y: -4, buttons: 5 };
        assert_eq!(later, [mouse, InputEvent::Wheel { dx: 0, dy: -1 }, key("left", false)]);
        assert!(replay.is_over());
    }

    #[test]
    fn presses_type_what_their_keys_type() {
        assert_eq!(line_events("1s press left").unwrap().len(), 2);
        let events = line_events("0s press a").unwrap();
        assert_eq!(events[1].1, InputEvent::Text('a'));
        assert_eq!(line_events("0s type Ab").unwrap().len(), 8);
        for line in
            ["left", "1s", "1s press", "1s press nokey", "x press a", "1s mouse 1 2", "1s mouse 1 2 9"]
        {
            assert_eq!(line_events(line), None, "{line}");
        }
        let error = Replay::new("1s press a\n1s hop\n", "").unwrap_err();
        assert!(error.starts_with("line 2: "), "{error}");
    }

    #[test]
    fn a_text_is_typed_once_the_picture_is_still() {
        let mut replay = Replay::new("", "ab").unwrap();
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        assert!(replay.due(true, false, at(0)).is_empty() && replay.due(true, true, at(900)).is_empty());
        assert!(replay.due(true, false, at(1399)).is_empty());
        assert_eq!(replay.due(true, false, at(1400)), [key("a", true), InputEvent::Text('a')]);
        assert!(!replay.is_over());
        assert!(replay.due(true, false, at(1424)).is_empty());
        assert_eq!(replay.due(true, true, at(1430)), [key("a", false)]);
        assert_eq!(replay.due(true, true, at(1450)).len(), 2);
        assert!(!replay.is_over());
        assert_eq!(replay.due(true, true, at(1475)), [key("b", false)]);
        assert!(replay.is_over());
    }

    #[test]
    fn a_text_is_typed_after_the_last_event_of_the_file() {
        let mut replay = Replay::new("3s press left\n", "a").unwrap();
        let start = Instant::now();
        let at = |ms| start + Duration::from_millis(ms);
        assert!(replay.due(true, true, at(0)).is_empty());
        // Still for long, but the file goes on.
        assert!(replay.due(true, false, at(2999)).is_empty());
        assert_eq!(replay.due(true, false, at(3000)), [key("left", true)]);
        assert_eq!(replay.due(true, false, at(3025)), [key("left", false)]);
        assert!(replay.due(true, false, at(3524)).is_empty());
        assert_eq!(replay.due(true, false, at(3525)).len(), 2);
        assert_eq!(replay.due(true, false, at(3550)), [key("a", false)]);
        assert!(replay.is_over());
    }
}

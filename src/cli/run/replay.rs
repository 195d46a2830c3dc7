//! Replayed input: `--keys FILE` and `--type TEXT`.

use super::after::time_of;
use crate::fbdev::{UserEvent, typing};
use std::collections::VecDeque;
use std::time::{Duration, Instant};

/// Time between two typed characters.
const PER_CHARACTER: Duration = Duration::from_millis(30);
/// Time for which the picture must not change before `--type` begins.
const STILL: Duration = Duration::from_millis(500);

/// Events with their times, counted from the program's first opening of the framebuffer.
#[derive(Debug, Default)]
pub struct Replay {
    events: VecDeque<(Duration, UserEvent)>,
    /// Characters that are typed once the picture is still.
    text: VecDeque<char>,
    opened: Option<Instant>,
    changed: Option<Instant>,
    /// Time of the next character, once typing has begun.
    next_character: Option<Instant>,
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
        self.events.is_empty() && self.text.is_empty()
    }

    /// Returns the events that are due.
    pub fn due(&mut self, is_open: bool, is_changed: bool, now: Instant) -> Vec<UserEvent> {
        if !is_open {
            return Vec::new();
        }
        let opened = *self.opened.get_or_insert(now);
        if is_changed {
            self.changed = Some(now);
        }
        let mut due = Vec::new();
        while self.events.front().is_some_and(|(time, _)| now >= opened + *time) {
            due.extend(self.events.pop_front().map(|(_, event)| event));
        }
        let is_still = self.changed.is_some_and(|changed| now >= changed + STILL);
        if is_still && self.next_character.is_none() {
            self.next_character = Some(now);
        }
        while let Some(next) = self.next_character.filter(|next| now >= *next) {
            let Some(character) = self.text.pop_front() else { break };
            due.extend(typing(character));
            self.next_character = Some(next + PER_CHARACTER);
        }
        due
    }
}

/// Parses a line: its events, each with its time.
fn line_events(line: &str) -> Option<Vec<(Duration, UserEvent)>> {
    let (time, rest) = line.split_once(' ')?;
    let time = time_of(time)?;
    let (verb, rest) = rest.trim_start().split_once(' ')?;
    if verb == "type" {
        let typed = (0u32..).zip(rest.chars());
        return Some(
            typed
                .flat_map(|(i, c)| typing(c).into_iter().map(move |event| (time + PER_CHARACTER * i, event)))
                .collect(),
        );
    }
    let words: Vec<&str> = rest.split_whitespace().collect();
    let key = |name: &str, down| {
        crate::fbdev::keys::by_name(name).map(|_| UserEvent::Key { name: name.to_owned(), down })
    };
    let events = match (verb, &words[..]) {
        ("key", ["down", name]) => vec![key(name, true)?],
        ("key", ["up", name]) => vec![key(name, false)?],
        ("press", [name]) => press(name)?,
        ("mouse", [x, y, buttons]) => {
            let buttons = buttons.parse().ok().filter(|b| *b < 8)?;
            vec![UserEvent::Mouse { x: x.parse().ok()?, y: y.parse().ok()?, buttons }]
        }
        ("wheel", [dx, dy]) => vec![UserEvent::Wheel { dx: dx.parse().ok()?, dy: dy.parse().ok()? }],
        _ => return None,
    };
    Some(events.into_iter().map(|event| (time, event)).collect())
}

/// Returns the events of pressing a key: with the character that it types, if it types one.
fn press(name: &str) -> Option<Vec<UserEvent>> {
    let key = crate::fbdev::keys::by_name(name)?;
    let control = match name {
        "enter" => Some('\n'),
        "tab" => Some('\t'),
        "escape" => Some('\x1b'),
        "backspace" => Some('\x08'),
        _ => None,
    };
    let typed = control.or_else(|| Some(char::from(key.characters[0])).filter(|c| *c != '\0'));
    let event = |down| UserEvent::Key { name: name.to_owned(), down };
    Some(typed.map_or_else(|| vec![event(true), event(false)], typing))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(name: &str, down: bool) -> UserEvent {
        UserEvent::Key { name: name.into(), down }
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
        let mouse = UserEvent::Mouse { x: 3, y: -4, buttons: 5 };
        assert_eq!(later, [mouse, UserEvent::Wheel { dx: 0, dy: -1 }, key("left", false)]);
        assert!(replay.is_over());
    }

    #[test]
    fn presses_type_what_their_keys_type() {
        assert_eq!(line_events("1s press left").unwrap().len(), 2);
        let events = line_events("0s press a").unwrap();
        assert_eq!(events[1].1, UserEvent::Text('a'));
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
        assert_eq!(replay.due(true, false, at(1400)).len(), 3);
        assert!(!replay.is_over());
        assert_eq!(replay.due(true, true, at(1430)).len(), 3);
        assert!(replay.is_over());
    }
}

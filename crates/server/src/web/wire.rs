//! The messages of the page's WebSocket.
//!
//! In: text of browsers. Out: [`Request`]. Promise: any text is either understood or `None`.
//!
//! | from the page | meaning |
//! |---|---|
//! | `join [token]` | the first message: asks for the rights of the token |
//! | `ack sequence` | the frame of that sequence number is on the canvas |
//! | `line text` | lines of the command language |
//! | `key down\|up name`, `text hex`, `mouse x y buttons`, `wheel dx dy` | an event |
//! | `probe x y` | asks for the depth of a pixel |
//!
//! | to the page | meaning |
//! |---|---|
//! | `hello {json}` | size, tile size, rights |
//! | `stats {json}` | the values of the metrics |
//! | `title text`, `listeners n` | the window's title; number of clients that listen to events |
//! | `depth x y z` | the answer to `probe`; `-` if there is no depth |
//! | `ended` | the connection of the commands has ended; the next line opens another |
//! | binary, first byte 1 | a part of a frame: see [`tiles_message`] |
//! | binary, first byte 2 | bytes of replies |

use super::tiles::{EncodedTile, STREAM_END};
use fbptr_core::input::InputEvent;
use std::sync::Arc;

/// Bytes of compressed tiles in a message, at most, unless one tile alone has more.
pub(super) const MESSAGE_BYTES: usize = 64 << 10;
/// Bytes before the tile numbers of a message.
const HEADER_BYTES: usize = 20;
/// Longest name of a key.
const MAX_KEY_NAME: usize = 32;

/// A message of the page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Request {
    Join(String),
    Ack(u64),
    Line(String),
    Event(InputEvent),
    Probe(u32, u32),
}

/// Parses a message of the page.
pub(super) fn parse(text: &str) -> Option<Request> {
    let (verb, rest) = text.split_once(' ').unwrap_or((text, ""));
    if verb == "line" {
        return Some(Request::Line(rest.to_owned()));
    }
    let words: Vec<&str> = rest.split(' ').collect();
    Some(match (verb, &words[..]) {
        ("join", [token]) => Request::Join((*token).to_owned()),
        ("ack", [sequence]) => Request::Ack(sequence.parse().ok()?),
        ("key", [way @ ("down" | "up"), name]) if is_key_name(name) => {
            Request::Event(InputEvent::Key { name: (*name).to_owned(), down: *way == "down" })
        }
        ("text", [hex]) => {
            Request::Event(InputEvent::Text(char::from_u32(u32::from_str_radix(hex, 16).ok()?)?))
        }
        ("mouse", [x, y, buttons]) => {
            let buttons = buttons.parse().ok().filter(|b| *b < 8)?;
            Request::Event(InputEvent::Mouse { x: x.parse().ok()?, y: y.parse().ok()?, buttons })
        }
        ("wheel", [dx, dy]) => {
            Request::Event(InputEvent::Wheel { dx: dx.parse().ok()?, dy: dy.parse().ok()? })
        }
        ("probe", [x, y]) => Request::Probe(x.parse().ok()?, y.parse().ok()?),
        _ => return None,
    })
}

/// Returns whether a key may have this name: without blanks and control characters, so that it
/// cannot end the line of the event.
fn is_key_name(name: &str) -> bool {
    (1..=MAX_KEY_NAME).contains(&name.len()) && !name.contains(|c: char| c.is_whitespace() || c.is_control())
}

/// Builds a message of as many tiles as fit, from `tiles[*next]` on, and advances `next`.
///
/// Little-endian: kind 1 in one byte, 1 in the next if this is the frame's last message, the number
/// of tiles in two, the sequence number in eight, the number of `PRESENT` commands in eight; each
/// tile's number in four; then the tiles as a raw deflate stream.
pub(super) fn tiles_message(
    sequence: u64,
    frame: u64,
    tiles: &[(u32, Arc<EncodedTile>)],
    next: &mut usize,
) -> Vec<u8> {
    let mut bytes = 0;
    let fits = |(_, tile): &&(u32, Arc<EncodedTile>)| {
        let is_first = bytes == 0;
        bytes += tile.bytes.len();
        is_first || bytes <= MESSAGE_BYTES
    };
    let count = tiles[*next..].iter().take(usize::from(u16::MAX)).take_while(fits).count();
    let part = &tiles[*next..*next + count];
    *next += count;
    let sum: usize = part.iter().map(|(_, tile)| tile.bytes.len() + 4).sum();
    let mut message = Vec::with_capacity(HEADER_BYTES + sum + STREAM_END.len());
    message.extend([1, u8::from(*next == tiles.len())]);
    message.extend((count as u16).to_le_bytes());
    message.extend(sequence.to_le_bytes());
    message.extend(frame.to_le_bytes());
    part.iter().for_each(|(index, _)| message.extend(index.to_le_bytes()));
    part.iter().for_each(|(_, tile)| message.extend(&tile.bytes[..]));
    message.extend(STREAM_END);
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_understood_or_refused() {
        let key = |name: &str, down| Request::Event(InputEvent::Key { name: name.into(), down });
        for (text, request) in [
            ("join", Request::Join(String::new())),
            ("join abc", Request::Join("abc".into())),
            ("ack 18446744073709551615", Request::Ack(u64::MAX)),
            ("line PX 1 2 ff0000", Request::Line("PX 1 2 ff0000".into())),
            ("line", Request::Line(String::new())),
            ("key down left", key("left", true)),
            ("key up a", key("a", false)),
            ("text 1f600", Request::Event(InputEvent::Text('\u{1f600}'))),
            ("mouse -3 7 5", Request::Event(InputEvent::Mouse { x: -3, y: 7, buttons: 5 })),
            ("wheel 0 -1", Request::Event(InputEvent::Wheel { dx: 0, dy: -1 })),
            ("probe 3 4", Request::Probe(3, 4)),
        ] {
            assert_eq!(parse(text), Some(request), "{text}");
        }
        for bad in [
            "",
            "Join x",
            "join a b",
            "ack",
            "ack -1",
            "ack 1 2",
            "key down",
            "key left a",
            "key down a\nPX",
            "key down \u{2028}",
            "text d800",
            "text 110000",
            "text",
            "mouse 1 2 8",
            "mouse 1 2",
            "mouse 99999999999 0 0",
            "wheel 1",
            "probe -1 0",
            "probe 1.5 0",
            "steer",
        ] {
            assert_eq!(parse(bad), None, "{bad}");
        }
        assert_eq!(parse(&format!("key down {}", "x".repeat(33))), None);
    }
}

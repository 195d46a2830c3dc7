//! Detection of read-only queries before they are decoded, so that they can run while all other
//! commands wait.

use super::{Decoder, DecoderState};
use crate::args::words;
use crate::commands::{Command, Rect, SnapTarget};

/// Most pixels (or bytes of PEEK) of a query that counts as quick.
const FEW_PIXELS: u64 = 1 << 16;
/// Longest line considered, in bytes.
const SHORT_LINE: usize = 200;

impl Command {
    /// Returns whether the command changes nothing but counters and takes at most some 100
    /// microseconds.
    pub fn only_asks(&self) -> bool {
        use Command as C;
        match self {
            C::Read { rect } | C::Crc { rect: Some(rect) } => is_small(*rect),
            C::Peek { n, .. } => u64::try_from(*n).is_ok_and(|n| n <= FEW_PIXELS),
            C::GetPixel { .. } | C::Size | C::Help | C::Hello | C::Version | C::Stats | C::Sync { .. } => {
                true
            }
            C::DepthAt { .. } | C::Pick { .. } => true,
            _ => false,
        }
    }

    /// Returns whether the command changes nothing but counters, however long it takes: without a
    /// reader of its reply it need not run.
    pub fn only_answers(&self) -> bool {
        use Command as C;
        match self {
            C::Read { .. } | C::Crc { .. } | C::Peek { .. } | C::Snap(SnapTarget::Connection) => true,
            _ => self.only_asks(),
        }
    }
}

/// Returns whether a rectangle has at most [`FEW_PIXELS`] pixels, and no negative side.
fn is_small(rect: Rect) -> bool {
    match (u64::try_from(rect.w), u64::try_from(rect.h)) {
        (Ok(w), Ok(h)) => w * h <= FEW_PIXELS,
        _ => false,
    }
}

impl Decoder {
    /// Returns how many of `bytes` complete the next command, if that is a whole line that is
    /// empty, a comment, or a query by its words ([`Command::only_asks`]). `None` if it is anything
    /// else or incomplete.
    pub fn next_asks(&self, bytes: &[u8]) -> Option<usize> {
        if !matches!(self.state, DecoderState::Head) {
            return None;
        }
        let window = &bytes[..bytes.len().min(SHORT_LINE)];
        let end = window.iter().position(|&b| b == b'\n')? + 1;
        match self.head.is_empty() {
            true => line_asks(&window[..end]).then_some(end),
            false if self.head.len() > SHORT_LINE => None,
            false => line_asks(&[&self.head, &window[..end]].concat()).then_some(end),
        }
    }
}

/// Returns whether a line of text, its LF included, is a query, empty or a comment. A malformed
/// query counts: errors change nothing.
fn line_asks(line: &[u8]) -> bool {
    let mut parts = words(line.trim_ascii_end());
    let Some(verb) = parts.next() else { return true };
    if verb.starts_with(b"#") {
        return true;
    }
    let words: Vec<&[u8]> = parts.collect();
    // A command with a payload does not end with its line.
    if words.last().is_some_and(|word| word.starts_with(b":")) {
        return false;
    }
    let number = |i: usize| std::str::from_utf8(words[i]).ok()?.parse::<u64>().ok();
    let is_small = |i: usize, j: usize| {
        number(i)
            .zip(number(j))
            .and_then(|(w, h)| w.checked_mul(h))
            .is_some_and(|pixels| pixels <= FEW_PIXELS)
    };
    match (verb.to_ascii_uppercase().as_slice(), words.len()) {
        (b"SYNC", 1) | (b"PX" | b"DEPTHAT" | b"PICK", 2) => true,
        (b"SIZE" | b"HELP" | b"HELLO" | b"VERSION" | b"STATS", 0) => true,
        (b"READ" | b"CRC", 4) => is_small(2, 3),
        (b"PEEK", 2) => number(1).is_some_and(|n| n <= FEW_PIXELS),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Flow, Limits, Sink, StreamError, StreamPosition};

    #[derive(Default)]
    struct Heard(Vec<Command>);

    impl Sink for Heard {
        fn pixel(&mut self, _: i32, _: i32, _: [u8; 4]) {
            panic!("a pixel only asks?");
        }
        fn binary_pixels(&mut self, _: &[u8]) {
            panic!("a pixel only asks?");
        }
        fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
            self.0.push(command);
            Flow::Continue
        }
        fn error(&mut self, _: StreamError) -> Flow {
            Flow::Continue
        }
    }

    #[test]
    fn what_is_let_through_only_asks_however_it_is_cut() {
        let lines: &[(&[u8], bool)] = &[
            (b"SYNC a\n", true),
            (b"sync a\r\n", true),
            (b"SYNC :5\n", false),
            (b"PX 1 2\n", true),
            (b" PX 1 2\n", true),
            (b"PX 1 2 ff0000\n", false),
            (b"PB\n", false),
            (b"PX 1 x\n", true),
            (b"READ 0 0 256 256\n", true),
            (b"READ 0 0 257 256\n", false),
            (b"CRC\n", false),
            (b"CRC 0 0 4 4\n", true),
            (b"PEEK 0 65537\n", false),
            (b"STATS\n", true),
            (b"CLEAR\n", false),
            (b"OFFSET 1 1\n", false),
            (b"\n", true),
            (b"# CLEAR\n", true),
            (b"QUIT\n", false),
            (b"SNAP :\n", false),
        ];
        for &(line, want) in lines {
            for cut in 0..line.len() {
                let (mut decoder, mut heard) = (Decoder::new(Limits::default()), Heard::default());
                let (first, rest) = line.split_at(cut);
                if !first.is_empty() && (want || cut < 2) {
                    let _ = decoder.feed(first, &mut heard);
                    assert_eq!(decoder.next_asks(rest), want.then_some(rest.len()), "{line:?} {cut}");
                }
                if cut == 0 {
                    let both = [line, b"CLEAR\n"].concat();
                    assert_eq!(decoder.next_asks(&both), want.then_some(line.len()), "{line:?}");
                    if want {
                        let _ = decoder.feed(line, &mut heard);
                        assert!(heard.0.iter().all(Command::only_asks), "{line:?}: {:?}", heard.0);
                    }
                }
            }
        }
        assert_eq!(Decoder::new(Limits::default()).next_asks(b"SYNC a"), None, "not whole");
    }
}

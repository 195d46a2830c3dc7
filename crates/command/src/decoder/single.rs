//! Decoding of one command that is not part of a stream, for programs that have its words and its
//! payload as values.
//!
//! In: a line without its end, and the payload. Out: the command, after the checks that the decoder
//! of a stream makes. The line may be longer than one of a stream.

use super::line::{parse_error, read_command};
use crate::args::{Args, ParseError};
use crate::codec::Codec;
use crate::commands::Command;
use crate::stream_error::{StreamError, StreamPosition, Subject};
use crate::verb::Verb;
use fbptr_core::error::Code;

impl Command {
    /// Reads one command from its line, without `:N`, and its payload. The words of the line are
    /// separated by blanks; its length is not limited.
    ///
    /// ```
    /// use fbptr_command::{Command, Figure};
    ///
    /// let command = Command::parse(b"TEXT 2 3 white", Some(b"hello".to_vec()))?;
    /// assert_eq!(command, Figure::Text { x: 2, y: 3, color: [255; 4], utf8: b"hello".to_vec() }.into());
    /// assert!(Command::parse(b"TEXT 2 3 white", None).is_err());
    /// # Ok::<(), fbptr_command::StreamError>(())
    /// ```
    ///
    /// # Errors
    /// Those of [`Decoder`](super::Decoder), at the beginning of a stream.
    pub fn parse(line: &[u8], payload: Option<Vec<u8>>) -> Result<Command, StreamError> {
        let line = line.trim_ascii();
        let (word, args) = Args::of_line(line);
        let refused = |error: ParseError| StreamError::new(StreamPosition::START, Subject::of(word), error);
        if let Some(at) = line.iter().position(|&b| b == b'\n') {
            return Err(refused(ParseError::new(Code::Args, "a command is one line", &line[at..])));
        }
        let Some((verb, parse)) = Verb::find_parser(word) else {
            return Err(refused(ParseError::new(Code::Verb, "unknown verb", word)));
        };
        let length = payload.as_ref().map(|bytes| bytes.len() as u64);
        let mut command = read_command(verb, parse, args, length, word).map_err(refused)?;
        if let (Some(bytes), Some(place)) = (payload, command.payload_mut()) {
            *place = bytes;
            command.validate_payload().map_err(|fault| refused(parse_error(fault)))?;
        }
        Ok(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Figure;
    use crate::verb::Encoding;
    use fbptr_core::draw2d::Rect;

    #[test]
    fn every_example_of_the_table_is_read_as_by_the_decoder() {
        for verb in Verb::all().iter().filter(|v| v.encoding == Encoding::Text) {
            let (line, payload) = match verb.example.split_once('\n') {
                Some((line, payload)) => (line.rsplit_once(' ').expect("a length").0, Some(payload)),
                None => (verb.example, None),
            };
            let command = Command::parse(line.as_bytes(), payload.map(|p| p.as_bytes().to_vec()));
            let command = command.unwrap_or_else(|e| panic!("{line}: {e}"));
            assert_eq!(command.verb(), verb.name);
            assert_eq!(command.payload(), payload.map(str::as_bytes), "{line}");
        }
    }

    #[test]
    fn a_line_may_be_longer_than_one_of_a_stream() {
        let points: Vec<[i32; 2]> = (0..4000).map(|i| [i, i % 7]).collect();
        let words: String = points.iter().map(|[x, y]| format!(" {x} {y}")).collect();
        let command = Command::parse(format!("POLY white{words}").as_bytes(), None).unwrap();
        assert_eq!(command, Figure::Poly { color: [255; 4], points }.into());
    }

    #[test]
    fn wrong_lines_have_the_codes_of_a_stream() {
        let code = |line: &str, payload: Option<&[u8]>| {
            Command::parse(line.as_bytes(), payload.map(<[u8]>::to_vec)).unwrap_err().code
        };
        assert_eq!(code("", None), Code::Verb);
        assert_eq!(code("LIEN 1 2", None), Code::Verb);
        assert_eq!(code("LINE 1 2", None), Code::Args);
        assert_eq!(code("LINE 1 2 3 4 red\nCLEAR", None), Code::Args);
        assert_eq!(code("LINE 1 2 3 4 zz", None), Code::Colour);
        assert_eq!(code("CLEAR", Some(b"x")), Code::Args);
        assert_eq!(code("TEXT 1 2 red", None), Code::Args);
        assert_eq!(code("TEXT 1 2 red", Some(b"\xff")), Code::Format);
        assert_eq!(code("BLIT 0 0 1 1", Some(b"abc")), Code::Format);
        assert_eq!(code("MESH m BOX", Some(b"v 0 0 0")), Code::Args);
        assert_eq!(code("CIRCLE 1 2 -3 red", None), Code::Range);
        let blit = Command::parse(b"  blit 1 2 1 1 ", Some(b"abcd".to_vec())).unwrap();
        assert_eq!(blit, Command::Blit { rect: Rect { x: 1, y: 2, w: 1, h: 1 }, rgba: b"abcd".to_vec() });
    }
}

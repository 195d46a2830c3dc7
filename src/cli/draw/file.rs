//! The stream that `draw FILE` continues.
//!
//! In: a file's bytes. Out: its complete commands up to the end or `QUIT`, none of which lacks a
//! part of its payload, and the error of a last one that is cut off. Promise: the commands are those
//! that `play` runs, but for `SIZE`. Tested below and by `tests/cli/draw.rs`.

use super::{read_all, session};
use crate::cli::FrameSize;
use crate::cli::play::{open_stream, size_of_stream};
use crate::command::{Command, Decoder, EndOfInput, Flow, Limits, Sink, StreamError, StreamPosition};
use crate::memory::Rgba;
use crate::server::RECORD_MAGIC;
use std::path::Path;

/// Commands of a file.
#[derive(Debug, Default)]
pub(super) struct Stream {
    /// Name of the file, for messages.
    pub name: String,
    /// Complete commands.
    pub bytes: Vec<u8>,
    /// Frame size that the file states.
    pub size: Option<FrameSize>,
    /// Number of lines left out at the beginning.
    pub skipped_lines: u64,
    /// Message about a last command that is cut off.
    pub error: Option<String>,
}

impl Stream {
    /// Reads a file.
    ///
    /// # Errors
    /// A message if it cannot be read, or is no stream of commands.
    pub fn read(path: &Path) -> Result<Stream, String> {
        let name = path.display().to_string();
        let (file, _) = open_stream(path, &name)?;
        let bytes = read_all(file, &name)?;
        Stream::new(name, bytes)
    }

    /// Takes the bytes of the file `name`.
    fn new(name: String, mut bytes: Vec<u8>) -> Result<Stream, String> {
        if bytes.starts_with(RECORD_MAGIC) {
            return Err(format!("{name}: a recording, which `fbptr play` and `fbptr view` show"));
        }
        let size = size_of_stream(&bytes).map_err(|e| format!("{name}: {e}"))?;
        let mut ends = Ends::default();
        let mut decoder = Decoder::new(Limits::default());
        if decoder.feed(&bytes, &mut ends) != Flow::Stop {
            ends.is_at_end = true;
            // What is incomplete has been noted.
            let _ = decoder.finish(EndOfInput::File, &mut ends);
        }
        match ends.end {
            Some(end) => bytes.truncate(end as usize),
            // As in `play`, the last line of a file may lack its end.
            None if bytes.last().is_some_and(|&last| last != b'\n') => bytes.push(b'\n'),
            None => {}
        }
        let error = ends.error.map(|error| error.play_line(&name));
        let skipped_lines = u64::from(session::drop_size(&mut bytes));
        Ok(Stream { name, bytes, size, skipped_lines, error })
    }
}

/// Finds where the complete commands of a stream end.
#[derive(Default)]
struct Ends {
    is_at_end: bool,
    /// Position of a command that ends the stream or is cut off.
    end: Option<u64>,
    error: Option<StreamError>,
}

impl Sink for Ends {
    fn pixel(&mut self, _: i32, _: i32, _: Rgba) {}

    fn binary_pixels(&mut self, _: &[u8]) {}

    fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
        if matches!(command, Command::Quit) {
            self.end = Some(place.byte);
            return Flow::Stop;
        }
        Flow::Continue
    }

    fn error(&mut self, error: StreamError) -> Flow {
        // Other errors are those of commands that the connection refuses as well.
        if self.is_at_end || error.closes {
            self.end = Some(error.place.byte);
            self.error = Some(error);
            return Flow::Stop;
        }
        Flow::Continue
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_commands_are_kept_and_the_cut_one_is_reported() {
        for (bytes, kept, error) in [
            ("CLEAR red", "CLEAR red\n", None),
            ("SIZE 8 6\nCLEAR red\nQUIT\nCLEAR blue\n", "CLEAR red\n", None),
            ("CLEAR red\nTEXT 0 0 white :5\nhel", "CLEAR red\n", Some("f:2: EPROTO TEXT: ")),
            ("NOPE\nPX 1 1 ff0000\n", "NOPE\nPX 1 1 ff0000\n", None),
            ("CLEAR red\nNOPE", "CLEAR red\n", Some("f:2: EVERB NOPE: ")),
            // A binary pixel that lacks its last byte: an LF would complete it.
            ("CLEAR red\nPB123456\x01", "CLEAR red\n", Some("f:2: EPROTO PB: ")),
            ("CLEAR red\nTEXT 0 0 white :5\nhello", "CLEAR red\nTEXT 0 0 white :5\nhello\n", None),
            ("", "", None),
        ] {
            let stream = Stream::new("f".into(), bytes.into()).unwrap();
            assert_eq!(stream.bytes, kept.as_bytes(), "{bytes}");
            let found = stream.error.unwrap_or_default();
            assert!(error.map_or(found.is_empty(), |error| found.starts_with(error)), "{bytes}: {found}");
        }
        let recording = Stream::new("f".into(), b"#!fbptr-record 2 4x3\n".to_vec());
        assert!(recording.unwrap_err().starts_with("f: a recording"));
    }
}

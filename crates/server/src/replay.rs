//! Replay of a recording, each of its connections in a session of its own.
//!
//! In: a recording's bytes, split anywhere. Out: the same as from [`Stream::feed`], and an error
//! for a line that is not a header, for files that cannot be read, and for a recording that ends
//! early. The files that the recording contains are held in memory, once each.

use super::Budget;
use super::record::{END_MARK, RECORD_MAGIC};
use fbptr_command::{EndOfInput, StreamPosition};
use fbptr_core::error::{Code, Fault};
use fbptr_core::scene::Camera;
use fbptr_engine::engine::Engine;
use fbptr_engine::read_files::FileSet;
use fbptr_engine::session::{Audience, FileAccess};
use fbptr_engine::stream::{CommandError, Notice, Output, Resume, Stream, StreamState, feed_parts};
use std::collections::HashMap;
use std::sync::Arc;

/// A recording that is being replayed.
pub(crate) struct Replay {
    streams: HashMap<u64, Stream>,
    /// The connection that has begun a command. All others wait, because what follows was recorded
    /// after that command.
    suspended: Option<u64>,
    part: Part,
    /// Number of lines read.
    line: u64,
    /// True if the recording contains the files that its commands read, and an end mark: from
    /// version 2 on.
    is_self_contained: bool,
    has_end_mark: bool,
    /// File contents of the recording, by id.
    contents: HashMap<u64, Arc<[u8]>>,
    has_failed: bool,
    /// Camera of the connection whose commands ran last.
    camera: Camera,
}

/// The part of the recording that the next byte belongs to.
enum Part {
    /// A header line, of which these bytes have been read.
    Header(Vec<u8>),
    /// Commands of this connection, of which so many bytes are left; the byte after them is an LF.
    Commands { connection: u64, left: u64 },
    /// Files for this connection's next command, of which these bytes have been read.
    Files { connection: u64, left: u64, bytes: Vec<u8> },
}

/// Meaning of a header line.
enum Header {
    /// A blank line or a comment.
    Nothing,
    /// The beginning of the recording, and whether its version contains files.
    Begin {
        is_self_contained: bool,
    },
    Commands(u64, u64),
    Files(u64, u64),
    End(u64),
    EndMark,
}

/// Longest header line in bytes.
const MAX_HEADER_BYTES: usize = 200;

impl Replay {
    /// Creates a replay that has read nothing.
    pub fn new() -> Self {
        Replay {
            streams: HashMap::new(),
            suspended: None,
            part: Part::Header(Vec::new()),
            line: 0,
            is_self_contained: false,
            has_end_mark: false,
            contents: HashMap::new(),
            has_failed: false,
            camera: Camera::default(),
        }
    }

    /// Runs the commands that are complete in `bytes`; see [`Stream::feed`].
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        if budget.only_asks {
            return (0, StreamState::Yields);
        }
        if self.has_failed {
            return (bytes.len(), StreamState::Ended);
        }
        let budget = Budget { command_time: None, ..budget };
        feed_parts(bytes, |rest| {
            let (taken, state) = match &mut self.part {
                Part::Header(_) => (self.feed_header(engine, rest, out), StreamState::Ready),
                Part::Files { .. } => (self.feed_files(engine, rest, out), StreamState::Ready),
                &mut Part::Commands { connection, left } => {
                    let piece = &rest[..rest.len().min(usize::try_from(left).unwrap_or(usize::MAX))];
                    self.feed_commands(engine, connection, piece, out, budget)
                }
            };
            if self.has_failed { (rest.len(), StreamState::Ended) } else { (taken, state) }
        })
    }

    fn feed_header(&mut self, engine: &mut Engine, bytes: &[u8], out: &mut Output) -> usize {
        let Part::Header(head) = &mut self.part else { return 0 };
        let lf = bytes.iter().position(|&b| b == b'\n');
        let taken = lf.map_or(bytes.len(), |lf| lf + 1);
        head.extend_from_slice(&bytes[..taken.min(MAX_HEADER_BYTES + 1)]);
        if lf.is_some() || head.len() > MAX_HEADER_BYTES {
            let head = std::mem::take(head);
            self.line += 1;
            self.header(engine, &head, out);
        }
        taken
    }

    fn feed_files(&mut self, engine: &mut Engine, rest: &[u8], out: &mut Output) -> usize {
        let Part::Files { connection, left, bytes } = &mut self.part else { return 0 };
        let piece = &rest[..rest.len().min(usize::try_from(*left).unwrap_or(usize::MAX))];
        bytes.extend_from_slice(piece);
        *left -= piece.len() as u64;
        if *left == 0 {
            let (connection, bytes) = (*connection, std::mem::take(bytes));
            match parse_files(&bytes, &mut self.contents) {
                Ok(files) => {
                    let stream = self.stream(engine, connection);
                    stream.session_mut().file_access = FileAccess::Recording(Arc::new(files));
                }
                Err(message) => self.fail(message, &bytes, out),
            }
            self.line += count_lf(&bytes);
            self.part = Part::Header(Vec::new());
        }
        piece.len()
    }

    /// Runs a piece of a chunk of commands. Returns the number of its bytes consumed, and the
    /// stream's state.
    fn feed_commands(
        &mut self,
        engine: &mut Engine,
        connection: u64,
        piece: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        let first_notice = out.notices.len();
        let (taken, state) = match self.streams.get_mut(&connection) {
            Some(stream) => {
                let fed = stream.feed(engine, piece, out, budget);
                self.camera = stream.session().camera;
                fed
            }
            None => (piece.len(), StreamState::Ready),
        };
        self.place_notices(&mut out.notices[first_notice..]);
        // The rest of a chunk after the end of its stream is skipped.
        let taken = if state == StreamState::Ended { piece.len() } else { taken };
        if let Part::Commands { left, .. } = &mut self.part {
            *left -= taken as u64;
            if *left == 0 {
                self.part = Part::Header(Vec::new());
            }
        }
        self.line += count_lf(&piece[..taken]);
        (taken, self.after(engine, connection, state, out))
    }

    /// Updates the replay after a stream's piece: notes that the stream is suspended, or ends it.
    /// Returns the state of the replay, which does not end with one of its streams.
    fn after(
        &mut self,
        engine: &mut Engine,
        connection: u64,
        state: StreamState,
        out: &mut Output,
    ) -> StreamState {
        match state {
            StreamState::Works | StreamState::InPieces => self.suspended = Some(connection),
            StreamState::Ended => {
                self.end_of(engine, connection, out);
                return StreamState::Ready;
            }
            StreamState::Ready | StreamState::Yields | StreamState::WaitsFor(_) | StreamState::Pauses(_) => {}
        }
        state
    }

    /// Continues the suspended command of one of the streams; see [`Stream::resume`].
    pub fn resume(
        &mut self,
        engine: &mut Engine,
        resume: Resume,
        out: &mut Output,
        budget: Budget,
    ) -> StreamState {
        let Some(connection) = self.suspended.take() else { return StreamState::Ready };
        let Some(stream) = self.streams.get_mut(&connection) else { return StreamState::Ready };
        let first_notice = out.notices.len();
        let budget = Budget { command_time: None, ..budget };
        let state = stream.resume(engine, resume, out, budget);
        self.place_notices(&mut out.notices[first_notice..]);
        self.after(engine, connection, state, out)
    }

    /// Abandons the command that is in pieces, if there is one.
    pub fn abandon(&mut self, engine: &mut Engine) {
        if let Some(stream) = self.suspended.take().and_then(|id| self.streams.get_mut(&id)) {
            stream.abandon(engine);
        }
    }

    /// Sets the line of notices to that of the recording at which the piece that caused them
    /// begins.
    fn place_notices(&self, notices: &mut [Notice]) {
        for notice in notices {
            match notice {
                Notice::Refused(CommandError { place, .. }) | Notice::Remark { place, .. } => {
                    place.line = self.line + 1;
                }
                Notice::Warning(_) => {}
            }
        }
    }

    fn header(&mut self, engine: &mut Engine, line: &[u8], out: &mut Output) {
        match parse_header(line) {
            Ok(Header::Nothing) => {}
            Ok(Header::Begin { is_self_contained }) => {
                (self.is_self_contained, self.has_end_mark) = (is_self_contained, false);
            }
            Ok(Header::EndMark) => self.has_end_mark = true,
            Ok(Header::End(connection)) => self.end_of(engine, connection, out),
            Ok(Header::Commands(connection, left)) => {
                self.stream(engine, connection);
                if left > 0 {
                    self.part = Part::Commands { connection, left };
                }
            }
            Ok(Header::Files(connection, left)) => {
                self.part = Part::Files { connection, left, bytes: Vec::new() };
            }
            Err(message) => self.fail(message, line, out),
        }
    }

    fn stream(&mut self, engine: &mut Engine, connection: u64) -> &mut Stream {
        let is_self_contained = self.is_self_contained;
        self.streams.entry(connection).or_insert_with(|| {
            engine.open(connection);
            let mut stream = Stream::new(engine, connection, Audience::Owner);
            if is_self_contained {
                stream.session_mut().file_access = FileAccess::Recording(Arc::default());
            }
            stream
        })
    }

    /// Ends the replay with an error: nothing after this position can be trusted.
    fn fail(&mut self, message: &'static str, found: &[u8], out: &mut Output) {
        self.has_failed = true;
        let token = String::from_utf8_lossy(found).trim_end().chars().take(60).collect::<String>();
        self.refuse(Fault::new(Code::Proto, message).got(token), out);
    }

    fn refuse(&self, fault: Fault, out: &mut Output) {
        let place = StreamPosition { line: self.line, byte: 0 };
        let verb = "RECORD".into();
        out.notices.push(Notice::Refused(CommandError { place, verb, fault, raw_token: None }));
    }

    fn end_of(&mut self, engine: &mut Engine, connection: u64, out: &mut Output) {
        if let Some(mut stream) = self.streams.remove(&connection) {
            let first_notice = out.notices.len();
            let _ = stream.finish(engine, EndOfInput::Stream, out);
            self.place_notices(&mut out.notices[first_notice..]);
            engine.close(stream.session_mut());
        }
    }

    /// Returns the camera of the connection whose commands ran last.
    // Only the viewer asks.
    pub fn camera(&self) -> Camera {
        self.camera
    }

    /// Ends the input. Refuses a recording that is not complete, after its commands have run.
    pub fn finish(&mut self, engine: &mut Engine, out: &mut Output) {
        let mut connections: Vec<u64> = self.streams.keys().copied().collect();
        connections.sort_unstable();
        for connection in connections {
            self.end_of(engine, connection, out);
        }
        let missing = match &self.part {
            _ if self.has_failed => return,
            Part::Header(head) if head.is_empty() => match self.is_self_contained && !self.has_end_mark {
                true => "its end mark is missing".to_owned(),
                false => return,
            },
            Part::Header(_) => "the line of a chunk is cut off".to_owned(),
            Part::Commands { left, .. } | Part::Files { left, .. } => {
                format!("its last chunk lacks {left} bytes")
            }
        };
        self.refuse(Fault::new(Code::Proto, format!("the recording ends early: {missing}")), out);
    }
}

fn count_lf(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|&&b| b == b'\n').count() as u64
}

fn parse_header(line: &[u8]) -> Result<Header, &'static str> {
    let text = String::from_utf8_lossy(line);
    let text = text.trim_end();
    if let Some(rest) = text.as_bytes().strip_prefix(RECORD_MAGIC) {
        return match rest.split(|b| *b == b' ').next() {
            Some(b"1") => Ok(Header::Begin { is_self_contained: false }),
            Some(b"2") => Ok(Header::Begin { is_self_contained: true }),
            _ => Err("a recording has version 1 or 2"),
        };
    }
    let words: Vec<&str> = text.split(' ').collect();
    let number = |word: &str| word.parse::<u64>().map_err(|_| WRONG_HEADER);
    match words[..] {
        [END_MARK, ..] => Ok(Header::EndMark),
        [""] => Ok(Header::Nothing),
        [first, ..] if first.starts_with("#!") => Ok(Header::Nothing),
        ["#@", connection, _, "end"] => Ok(Header::End(number(connection)?)),
        ["#@", connection, _, "files", length] => Ok(Header::Files(number(connection)?, number(length)?)),
        ["#@", connection, _, length] => Ok(Header::Commands(number(connection)?, number(length)?)),
        _ => Err(WRONG_HEADER),
    }
}

const WRONG_HEADER: &str =
    "a recording's line must be \"#@ connection seconds [files] bytes\" or end with \"end\"";

const WRONG_FILES: &str =
    "a recording's file must be \"id name_bytes content_bytes\", its name and its content";

/// Parses the entries of a `files` chunk. New contents are added to `contents`; others are taken
/// from it.
fn parse_files(mut bytes: &[u8], contents: &mut HashMap<u64, Arc<[u8]>>) -> Result<FileSet, &'static str> {
    let mut files = FileSet::new();
    while !bytes.is_empty() {
        let lf = bytes.iter().take(MAX_HEADER_BYTES).position(|&b| b == b'\n').ok_or(WRONG_FILES)?;
        let line = std::str::from_utf8(&bytes[..lf]).map_err(|_| WRONG_FILES)?;
        bytes = &bytes[lf + 1..];
        let [id, name_bytes, content_bytes] = line.split(' ').collect::<Vec<_>>()[..] else {
            return Err(WRONG_FILES);
        };
        let id = id.parse::<u64>().map_err(|_| WRONG_FILES)?;
        let name = std::str::from_utf8(take(&mut bytes, name_bytes)?).map_err(|_| WRONG_FILES)?;
        if content_bytes != "-" {
            contents.insert(id, take(&mut bytes, content_bytes)?.into());
        }
        let content = contents.get(&id).ok_or("a recording's file has an id that none had before")?;
        files.insert(name.to_owned(), content.clone());
    }
    Ok(files)
}

/// Takes as many bytes as the word `length` says.
fn take<'a>(bytes: &mut &'a [u8], length: &str) -> Result<&'a [u8], &'static str> {
    let length = length.parse::<usize>().map_err(|_| WRONG_FILES)?;
    let (taken, rest) = bytes.split_at_checked(length).ok_or(WRONG_FILES)?;
    *bytes = rest;
    Ok(taken)
}

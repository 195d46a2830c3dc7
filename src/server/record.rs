//! Recordings: what was executed, in order, with each command's connection and time.
//!
//! ```text
//! #!fbptr-record 1 640x480
//! #@ 3 0.001234 14        connection, seconds since the start, bytes that follow
//! PX 1 1 ff0000
//! #@ 3 0.500000 end       the connection is over
//! ```
//! The bytes are commands of the protocol. Those of one connection at one time may share a header; connection 0 is what
//! others wrote into the shared file. Refused commands are not in it; files that LOAD read are, where one file was all, and
//! a SNAP into a file becomes a comment, so that playing a recording needs and touches nothing outside.

use super::{Audience, Budget, Engine, Notice, Output, Standing, Stream};
use crate::command::{Command, EndOfInput, SnapTarget, encode};
use crate::memory::{Rgba, VideoMemory};
use std::collections::HashMap;
use std::fmt;
use std::io::{self, Write};
use std::time::{Duration, Instant};

/// The first bytes of a recording.
pub const RECORD_MAGIC: &[u8] = b"#!fbptr-record 1 ";

/// A chunk is written when it is this long.
const CHUNK_BYTES: usize = 1 << 16;
/// What was written reaches the file within this time.
const FLUSH_EVERY: Duration = Duration::from_millis(200);
/// Pixels of one `PXMULTI` in a recording.
const RUN_PIXELS: usize = 1 << 20;

/// Writes a recording.
pub struct Recorder {
    out: Box<dyn Write + Send>,
    begun: Instant,
    now: Duration,
    /// Commands of `connection` at `chunk_time` that are not written yet.
    chunk: Vec<u8>,
    connection: u64,
    chunk_time: Duration,
    flushed_at: Instant,
    failure: Option<io::Error>,
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Recorder({} bytes in hand)", self.chunk.len())
    }
}

impl Recorder {
    /// A recording of a `width` x `height` frame into `out`, which should be buffered.
    pub fn new(mut out: Box<dyn Write + Send>, width: u32, height: u32) -> io::Result<Self> {
        out.write_all(RECORD_MAGIC)?;
        writeln!(out, "{width}x{height}")?;
        let begun = Instant::now();
        Ok(Recorder {
            out,
            begun,
            now: Duration::ZERO,
            chunk: Vec::new(),
            connection: 0,
            chunk_time: Duration::ZERO,
            flushed_at: begun,
            failure: None,
        })
    }

    /// What comes next happens at `now`.
    pub(super) fn set_time(&mut self, now: Instant) {
        self.now = now.saturating_duration_since(self.begun);
    }

    /// Begins a command of `connection`; a length for [`Recorder::roll_back`].
    fn begin(&mut self, connection: u64) -> usize {
        if connection != self.connection || self.now != self.chunk_time || self.chunk.len() >= CHUNK_BYTES {
            self.write_chunk();
            (self.connection, self.chunk_time) = (connection, self.now);
        }
        self.chunk.len()
    }

    /// Notes a command; a length for [`Recorder::roll_back`].
    pub(super) fn command(&mut self, connection: u64, command: &Command) -> usize {
        let before = self.begin(connection);
        match command {
            Command::Snap(SnapTarget::File(name)) => {
                writeln!(self.chunk, "# SNAP {name}").expect("a Vec takes all bytes");
            }
            // What cannot stand in a stream was refused before it was run.
            _ => drop(encode(command, &mut self.chunk)),
        }
        before
    }

    /// The last command was refused: it is not in the recording.
    pub(super) fn roll_back(&mut self, before: usize) {
        self.chunk.truncate(before);
    }

    pub(super) fn pixel(&mut self, connection: u64, x: i32, y: i32, color: Rgba) {
        self.command(connection, &Command::Pixel { x, y, color });
    }

    pub(super) fn binary_pixels(&mut self, connection: u64, records: &[u8]) {
        self.begin(connection);
        self.chunk.extend_from_slice(records);
    }

    /// Notes what others wrote into the shared file: pixel numbers, ascending.
    pub(super) fn foreign_pixels(&mut self, pixels: &[usize], memory: &VideoMemory) {
        let width = memory.width() as usize;
        let mut rest = pixels;
        while let [first, ..] = rest {
            let is_run = |(i, pixel): (usize, &usize)| *pixel == first + i;
            let run = rest.iter().enumerate().take(RUN_PIXELS).take_while(|&(i, p)| is_run((i, p))).count();
            let rgba = memory.bytes()[first * 4..(first + run) * 4].to_vec();
            let (x, y) = ((first % width) as u16, (first / width) as u16);
            self.command(0, &Command::PixelRun { x, y, rgba });
            rest = &rest[run..];
        }
    }

    /// A connection is over.
    pub(super) fn end(&mut self, connection: u64) {
        self.write_chunk();
        let now = self.now;
        self.write(|out| writeln!(out, "#@ {connection} {}.{:06} end", now.as_secs(), now.subsec_micros()));
    }

    fn write_chunk(&mut self) {
        if self.chunk.is_empty() {
            return;
        }
        let (chunk, connection, time) = (std::mem::take(&mut self.chunk), self.connection, self.chunk_time);
        self.write(|out| {
            let (seconds, micros) = (time.as_secs(), time.subsec_micros());
            writeln!(out, "#@ {connection} {seconds}.{micros:06} {}", chunk.len())?;
            out.write_all(&chunk)?;
            // A line of its own for the next header, whatever the chunk ends with.
            out.write_all(b"\n")
        });
        self.chunk = chunk;
        self.chunk.clear();
        self.chunk.shrink_to(CHUNK_BYTES * 4);
    }

    fn write(&mut self, action: impl FnOnce(&mut dyn Write) -> io::Result<()>) {
        if self.failure.is_none() {
            self.failure = action(&mut *self.out).err();
        }
    }

    /// When the file wants the rest, if there is any.
    pub(super) fn next_deadline(&self) -> Option<Instant> {
        (!self.chunk.is_empty()).then(|| self.flushed_at + FLUSH_EVERY)
    }

    /// Brings what is in hand to the file, if it is time.
    pub(super) fn tick(&mut self, now: Instant) {
        if now >= self.flushed_at + FLUSH_EVERY {
            self.flush(now);
        }
    }

    /// Brings what is in hand to the file.
    pub(super) fn flush(&mut self, now: Instant) {
        self.write_chunk();
        self.write(|out| out.flush());
        self.flushed_at = now;
    }

    /// Why the recording ends early, once.
    pub(super) fn take_failure(&mut self) -> Option<io::Error> {
        self.failure.take()
    }
}

/// A recording that is being played: its connections' streams, each with its own session.
pub(super) struct Replay {
    streams: HashMap<u64, Stream>,
    part: Part,
    /// Lines of the file so far.
    line: u64,
    has_failed: bool,
    /// Commands of the streams that are over.
    commands: u64,
}

enum Part {
    /// In a header line, of which this has come.
    Header(Vec<u8>),
    /// In a chunk of this connection, so many bytes before its end; the byte after it is a LF.
    Chunk { connection: u64, left: u64 },
}

/// Longer lines are no headers.
const MAX_HEADER_BYTES: usize = 200;

impl Replay {
    /// A recording from its first byte on.
    pub fn new() -> Self {
        Replay {
            streams: HashMap::new(),
            part: Part::Header(Vec::new()),
            line: 0,
            has_failed: false,
            commands: 0,
        }
    }

    /// Runs what is whole in `bytes`, as [`Stream::feed`].
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, Standing) {
        let mut used = 0;
        while used < bytes.len() && !self.has_failed {
            let rest = &bytes[used..];
            match &mut self.part {
                Part::Header(head) => {
                    let lf = rest.iter().position(|&b| b == b'\n');
                    let taken = lf.map_or(rest.len(), |lf| lf + 1);
                    used += taken;
                    head.extend_from_slice(&rest[..taken.min(MAX_HEADER_BYTES + 1)]);
                    if lf.is_some() || head.len() > MAX_HEADER_BYTES {
                        let head = std::mem::take(head);
                        self.line += 1;
                        self.header(engine, &head, out);
                    }
                }
                Part::Chunk { connection, left } => {
                    let connection = *connection;
                    let piece = &rest[..rest.len().min(usize::try_from(*left).unwrap_or(usize::MAX))];
                    let first_notice = out.notices.len();
                    let (taken, standing) = match self.streams.get_mut(&connection) {
                        Some(stream) => stream.feed(engine, piece, out, budget),
                        None => (piece.len(), Standing::Ready),
                    };
                    for notice in &mut out.notices[first_notice..] {
                        if let Notice::Refused(complaint) = notice {
                            complaint.place.line = self.line + 1;
                        }
                    }
                    // What follows the end of a stream in its chunk is not run.
                    let taken = if standing == Standing::Ended { piece.len() } else { taken };
                    used += taken;
                    *left -= taken as u64;
                    if *left == 0 {
                        self.part = Part::Header(Vec::new());
                    }
                    self.line += piece[..taken].iter().filter(|&&b| b == b'\n').count() as u64;
                    match standing {
                        Standing::Ready => {}
                        Standing::Ended => self.end_of(engine, connection, out),
                        Standing::Rests | Standing::WaitsFor(_) => return (used, standing),
                    }
                }
            }
        }
        if self.has_failed { (bytes.len(), Standing::Ended) } else { (used, Standing::Ready) }
    }

    fn header(&mut self, engine: &mut Engine, line: &[u8], out: &mut Output) {
        let text = String::from_utf8_lossy(line);
        let text = text.trim_end();
        if text.is_empty() || text.starts_with("#!") {
            return;
        }
        let words: Vec<&str> = text.split(' ').collect();
        let parsed = match words[..] {
            ["#@", connection, _, what] => connection.parse::<u64>().ok().zip(Some(what)),
            _ => None,
        };
        match parsed.map(|(connection, what)| (connection, what, what.parse::<u64>())) {
            Some((connection, "end", _)) => self.end_of(engine, connection, out),
            Some((connection, _, Ok(left))) => {
                self.streams.entry(connection).or_insert_with(|| {
                    engine.open();
                    Stream::new(engine, connection, Audience::Owner)
                });
                if left > 0 {
                    self.part = Part::Chunk { connection, left };
                }
            }
            _ => {
                self.has_failed = true;
                out.notices.push(Notice::Refused(super::Complaint {
                    place: crate::command::Place { line: self.line, byte: 0 },
                    verb: "RECORD".into(),
                    fault: crate::error::Fault::new(
                        crate::error::Code::Proto,
                        "a recording's line must be \"#@ connection seconds bytes\"",
                    )
                    .got(text.chars().take(60).collect::<String>()),
                    raw_token: None,
                }));
            }
        }
    }

    fn end_of(&mut self, engine: &mut Engine, connection: u64, out: &mut Output) {
        if let Some(mut stream) = self.streams.remove(&connection) {
            let _ = stream.finish(engine, EndOfInput::Stream, out);
            engine.close(stream.session_mut());
            self.commands += stream.session().stats.commands;
        }
    }

    /// Commands that were run or refused.
    pub fn commands(&self) -> u64 {
        self.commands + self.streams.values().map(|s| s.session().stats.commands).sum::<u64>()
    }

    /// Says that no more bytes come.
    pub fn finish(&mut self, engine: &mut Engine, out: &mut Output) {
        let mut connections: Vec<u64> = self.streams.keys().copied().collect();
        connections.sort_unstable();
        for connection in connections {
            self.end_of(engine, connection, out);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    #[derive(Clone, Default)]
    struct Sheet(Arc<Mutex<Vec<u8>>>);

    impl Write for Sheet {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_recording_of_two_connections_plays_to_the_same_memory_however_it_is_cut() {
        let sheet = Sheet::default();
        let mut engine = Engine::new(40, 30).unwrap();
        engine.set_recorder(Recorder::new(Box::new(sheet.clone()), 40, 30).unwrap());
        let mut streams = [1, 2].map(|id| Stream::new(&engine, id, Audience::Connection));
        let mut out = Output::default();
        let scripts: [&[u8]; 2] = [
            b"OFFSET 5 5\nPX 1 1 ff0000\nBLEND over\nPX 2 1 ff000080\nLINE 0 0 1\nFOO\nMESH m BOX\nSNAP :\n",
            b"PX 1 1 00ff00\nPB\x03\x00\x04\x00abcdTEXT 3 9 ffff00 :3\na\nbLINE 0 29 39 0 ffffff\nPX 1 1 zz\nDRAW m\n",
        ];
        for i in 0..200 {
            for (stream, script) in streams.iter_mut().zip(scripts) {
                let piece = script.iter().skip(i).take(1).copied().collect::<Vec<u8>>();
                let _ = stream.feed(&mut engine, &piece, &mut out, Budget::NONE);
            }
        }
        engine.close(streams[0].session_mut());
        let want = engine.memory().bytes().to_vec();
        drop(engine);
        let recording = sheet.0.lock().unwrap().clone();
        assert!(recording.starts_with(b"#!fbptr-record 1 40x30\n#@ "));
        for cut in 1..recording.len() {
            let (mut engine, mut replay) = (Engine::new(40, 30).unwrap(), Replay::new());
            let mut out = Output::default();
            for piece in recording.chunks(cut) {
                assert_eq!(
                    replay.feed(&mut engine, piece, &mut out, Budget::NONE),
                    (piece.len(), Standing::Ready)
                );
            }
            replay.finish(&mut engine, &mut out);
            assert_eq!(out.notices, [], "refused commands are not in a recording");
            assert!(engine.memory().bytes() == want, "pieces of {cut}");
        }
    }

    #[test]
    fn a_broken_recording_is_refused_with_its_line() {
        let (mut engine, mut replay) = (Engine::new(4, 3).unwrap(), Replay::new());
        let mut out = Output::default();
        let bytes = b"#!fbptr-record 1 4x3\n#@ 1 0.0 5\nSIZE\n\nPX 1 1 ff0000\n";
        assert_eq!(replay.feed(&mut engine, bytes, &mut out, Budget::NONE), (bytes.len(), Standing::Ended));
        let [Notice::Refused(complaint)] = &out.notices[..] else { panic!("{:?}", out.notices) };
        assert_eq!(complaint.place.line, 5);
    }
}

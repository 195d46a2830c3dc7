//! The render thread's side of a recording.
//!
//! In: executed commands, with connection and time, from [`super::observe`]. Out: blocks of chunks
//! to the writer's thread. A block contains finished chunks and the open one in place: a chunk's
//! length is written into its header when it ends. A block is submitted when it is large, and every
//! [`FLUSH_EVERY`].

use super::writer::{OnFailure, Patience, RecordStats, Writer};
use super::{END_MARK, RECORD_MAGIC, RecordFile};
use fbptr_command::{BINARY_PIXEL_BYTES, Command, Rect, SnapTarget, encode};
use fbptr_core::memory::{Reservation, VideoMemory};
use fbptr_engine::read_files::{Fingerprint, ReadFile};
use std::collections::HashMap;
use std::fmt;
use std::io::{self, Write};
use std::ops::Range;
use std::time::{Duration, Instant};

/// Length at which a chunk ends, and a block is submitted, in bytes.
const CHUNK_BYTES: usize = 1 << 16;
/// Age at which recorded bytes are submitted to the writer.
const FLUSH_EVERY: Duration = Duration::from_millis(200);
/// Most pixels of one `PXMULTI` in a recording.
const RUN_PIXELS: u32 = 1 << 20;
/// Number of digits of a chunk's length.
const LENGTH_DIGITS: usize = 12;
/// Coordinates that are outside every frame.
const OFF_FRAME: [u8; 4] = [0xff; 4];

/// The open chunk, to which commands are appended.
#[derive(Clone, Copy)]
struct Chunk {
    connection: u64,
    time: Duration,
    /// Offsets of its header and its bytes in the block.
    header_at: usize,
    body_at: usize,
}

/// Records the commands that an engine executes.
pub struct Recorder {
    writer: Writer,
    begun: Instant,
    now: Duration,
    block: Vec<u8>,
    chunk: Option<Chunk>,
    /// Position in the block of the command that was recorded last.
    last_at: usize,
    /// Set if the last command has no text form and is not in the recording.
    has_gap: bool,
    flushed_at: Instant,
    /// Ids of the file contents in the recording.
    file_ids: HashMap<Fingerprint, u64>,
    /// Cleared when the recording is complete, or is known to have ended early.
    pub(super) is_open: bool,
    /// The memory budget's reservation for recorded bytes that are not in their file.
    pub(super) held: Option<Reservation>,
}

impl fmt::Debug for Recorder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Recorder({} bytes in hand)", self.block.len())
    }
}

fn append(out: &mut Vec<u8>, text: fmt::Arguments<'_>) {
    out.write_fmt(text).expect("a Vec takes all bytes");
}

impl Recorder {
    /// Begins a recording of a `width` x `height` frame into `out`, written by a thread of its own.
    ///
    /// # Errors
    /// If the system has no thread to give.
    pub fn new(out: Box<dyn Write + Send>, width: u32, height: u32) -> io::Result<Self> {
        Recorder::start(out, Patience::FILE, None, width, height)
    }

    /// Begins a recording into an open file. `on_failure` is called once, on any thread, if the
    /// recording ends early.
    ///
    /// # Errors
    /// If the system has no thread to give.
    pub fn to_file(
        file: RecordFile,
        width: u32,
        height: u32,
        on_failure: impl FnOnce(&io::Error) + Send + 'static,
    ) -> io::Result<Self> {
        Recorder::start(Box::new(file.file), file.patience, Some(Box::new(on_failure)), width, height)
    }

    pub(super) fn start(
        out: Box<dyn Write + Send>,
        patience: Patience,
        on_failure: Option<OnFailure>,
        width: u32,
        height: u32,
    ) -> io::Result<Self> {
        let mut head = RECORD_MAGIC.to_vec();
        append(&mut head, format_args!("2 {width}x{height}\n"));
        let writer = Writer::start(out, patience, on_failure)?;
        let begun = Instant::now();
        // The head is written at once, so that a full disk is reported at the start.
        let block = writer.push(head);
        Ok(Recorder {
            writer,
            begun,
            now: Duration::ZERO,
            block,
            chunk: None,
            last_at: 0,
            has_gap: false,
            flushed_at: begun,
            file_ids: HashMap::new(),
            is_open: true,
            held: None,
        })
    }

    /// Sets the time of the following commands.
    pub(super) fn set_time(&mut self, now: Instant) {
        self.now = now.saturating_duration_since(self.begun);
    }

    /// Begins a command of `connection`. Returns its position in the block.
    fn begin(&mut self, connection: u64) -> usize {
        self.end_at_gap();
        let fits = |c: &Chunk| c.connection == connection && c.time == self.now;
        let is_open =
            self.chunk.as_ref().is_some_and(|c| fits(c) && self.block.len() - c.body_at < CHUNK_BYTES);
        if !is_open {
            self.end_chunk();
            self.begin_chunk(connection, "");
        }
        self.last_at = self.block.len();
        self.last_at
    }

    fn begin_chunk(&mut self, connection: u64, kind: &str) {
        let (header_at, time) = (self.block.len(), self.now);
        let (seconds, micros) = (time.as_secs(), time.subsec_micros());
        let (zero, digits) = (0, LENGTH_DIGITS);
        append(
            &mut self.block,
            format_args!("#@ {connection} {seconds}.{micros:06} {kind}{zero:0digits$}\n"),
        );
        self.chunk = Some(Chunk { connection, time, header_at, body_at: self.block.len() });
    }

    fn end_chunk(&mut self) {
        let Some(chunk) = self.chunk.take() else { return };
        let length = self.block.len() - chunk.body_at;
        if length == 0 {
            self.block.truncate(chunk.header_at);
        } else {
            let digits = LENGTH_DIGITS;
            let text = format!("{length:0digits$}");
            let place = chunk.body_at - 1 - LENGTH_DIGITS..chunk.body_at - 1;
            self.block[place].copy_from_slice(&text.as_bytes()[..LENGTH_DIGITS]);
            // The next header begins on a line of its own, whatever the chunk ends with.
            self.block.push(b'\n');
        }
        if self.block.len() >= CHUNK_BYTES {
            self.submit();
        }
    }

    fn submit(&mut self) {
        if !self.block.is_empty() {
            self.block = self.writer.push(std::mem::take(&mut self.block));
        }
    }

    /// Appends a command.
    pub(super) fn command(&mut self, connection: u64, command: &Command) {
        self.begin(connection);
        match command {
            Command::Snap(SnapTarget::File(name)) => {
                append(&mut self.block, format_args!("# SNAP {name}\n"));
            }
            // A command without a text form cannot come from a stream, but from a program that
            // embeds the server: a POLY with very many points.
            _ => self.has_gap = encode(command, &mut self.block).is_err(),
        }
    }

    /// Removes the last command, which was refused.
    pub(super) fn roll_back(&mut self) {
        self.block.truncate(self.last_at);
        self.has_gap = false;
    }

    /// Ends the recording if the previous command was executed and is not in it.
    fn end_at_gap(&mut self) {
        if std::mem::take(&mut self.has_gap) {
            self.writer.fail("a command was run that has no text");
        }
    }

    /// Inserts the files that the last command read before it.
    pub(super) fn attach_files(&mut self, connection: u64, files: &[ReadFile]) {
        let command = self.block.split_off(self.last_at);
        self.end_chunk();
        self.begin_chunk(connection, "files ");
        for file in files {
            let next = self.file_ids.len() as u64 + 1;
            let id = *self.file_ids.entry(file.fingerprint).or_insert(next);
            let name = file.path.as_bytes();
            append(&mut self.block, format_args!("{id} {} ", name.len()));
            match id == next {
                true => append(&mut self.block, format_args!("{}\n", file.bytes.len())),
                false => append(&mut self.block, format_args!("-\n")),
            }
            self.block.extend_from_slice(name);
            if id == next {
                self.block.extend_from_slice(&file.bytes);
            }
        }
        self.end_chunk();
        self.begin(connection);
        self.block.extend_from_slice(&command);
    }

    /// Appends text pixels as binary ones with the same effect. A record is u16 coordinates, not
    /// yet moved by OFFSET, and RGBA.
    pub(super) fn pixels(&mut self, connection: u64, records: &[[u8; 8]], offset: [i32; 2]) {
        for part in records.chunks(CHUNK_BYTES / BINARY_PIXEL_BYTES) {
            let start = self.begin(connection);
            self.block.resize(start + part.len() * BINARY_PIXEL_BYTES, 0);
            let out = self.block[start..].as_chunks_mut::<BINARY_PIXEL_BYTES>().0;
            match offset {
                [0, 0] => out.iter_mut().zip(part).for_each(|(out, record)| put_binary(out, *record)),
                _ => {
                    out.iter_mut().zip(part).for_each(|(out, record)| put_binary(out, moved(*record, offset)))
                }
            }
        }
    }

    /// Appends complete `PB` records.
    pub(super) fn binary_pixels(&mut self, connection: u64, records: &[u8]) {
        for part in records.chunks(CHUNK_BYTES / BINARY_PIXEL_BYTES * BINARY_PIXEL_BYTES) {
            self.begin(connection);
            self.block.extend_from_slice(part);
        }
    }

    /// Appends a `PXMULTI` of complete pixels.
    pub(super) fn pixel_run(&mut self, connection: u64, x: u16, y: u16, rgba: &[u8]) {
        self.begin(connection);
        // No frame has as many pixels as a run can have: the rest of a longer one is clipped
        // anyway.
        let count = u32::try_from(rgba.len() / 4).unwrap_or(u32::MAX);
        let rgba = &rgba[..count as usize * 4];
        self.block.extend_from_slice(b"PXMULTI");
        self.block.extend_from_slice(&x.to_le_bytes());
        self.block.extend_from_slice(&y.to_le_bytes());
        self.block.extend_from_slice(&count.to_le_bytes());
        self.block.extend_from_slice(rgba);
    }

    /// Appends a `BLIT`.
    pub(super) fn blit(&mut self, connection: u64, rect: Rect, rgba: &[u8]) {
        self.begin(connection);
        let Rect { x, y, w, h } = rect;
        append(&mut self.block, format_args!("BLIT {x} {y} {w} {h} :{}\n", rgba.len()));
        self.block.extend_from_slice(rgba);
    }

    /// Appends a `POINTS`.
    pub(super) fn points(&mut self, connection: u64, packed: &[u8]) {
        self.begin(connection);
        append(&mut self.block, format_args!("POINTS :{}\n", packed.len()));
        self.block.extend_from_slice(packed);
    }

    /// Appends the contents of runs of pixels, as writes to the shared file.
    pub(super) fn pixel_runs(&mut self, runs: &[Range<u32>], memory: &VideoMemory) {
        let width = memory.width();
        for run in runs {
            for first in run.clone().step_by(RUN_PIXELS as usize) {
                let end = run.end.min(first.saturating_add(RUN_PIXELS));
                let (x, y) = ((first % width) as u16, (first / width) as u16);
                self.pixel_run(0, x, y, &memory.bytes()[first as usize * 4..end as usize * 4]);
            }
        }
    }

    /// Appends the end of a connection.
    pub(super) fn end(&mut self, connection: u64) {
        self.end_chunk();
        let (seconds, micros) = (self.now.as_secs(), self.now.subsec_micros());
        append(&mut self.block, format_args!("#@ {connection} {seconds}.{micros:06} end\n"));
    }

    /// Returns the time of the next [`Recorder::tick`], if one is needed.
    pub(super) fn next_deadline(&self) -> Option<Instant> {
        (!self.block.is_empty()).then(|| self.flushed_at + FLUSH_EVERY)
    }

    /// Submits the recorded bytes to the writer, if that is due.
    pub(super) fn tick(&mut self, now: Instant) {
        if now >= self.flushed_at + FLUSH_EVERY {
            self.end_chunk();
            self.submit();
            self.flushed_at = now;
        }
        if self.has_failed() {
            self.is_open = false;
            (self.block, self.file_ids) = (Vec::new(), HashMap::new());
        }
    }

    /// Completes the recording, and waits for its last byte as long as writing makes progress.
    pub(super) fn finish(&mut self) {
        self.end_at_gap();
        self.end_chunk();
        let now = self.begun.elapsed();
        append(&mut self.block, format_args!("{END_MARK} {}.{:06}\n", now.as_secs(), now.subsec_micros()));
        self.submit();
        self.writer.finish();
        self.is_open = false;
    }

    /// Returns whether the recording has ended early.
    pub(super) fn has_failed(&self) -> bool {
        self.writer.has_failed()
    }

    /// Returns the reason for which the recording has ended early, if it has.
    pub fn failure(&self) -> Option<String> {
        self.writer.failure()
    }

    /// Returns the numbers of written and queued bytes.
    pub(super) fn stats(&self) -> RecordStats {
        self.writer.stats()
    }
}

#[inline]
fn put_binary(out: &mut [u8; BINARY_PIXEL_BYTES], record: [u8; 8]) {
    let (head, rest) = out.split_at_mut(2);
    head.copy_from_slice(b"PB");
    rest.copy_from_slice(&record);
}

/// Moves a record by OFFSET. A result outside the u16 range becomes a position outside every frame.
fn moved(record: [u8; 8], [dx, dy]: [i32; 2]) -> [u8; 8] {
    let [x0, x1, y0, y1, r, g, b, a] = record;
    let place = |low: u8, high: u8, d: i32| {
        u16::try_from(i32::from(u16::from_le_bytes([low, high])).saturating_add(d)).ok()
    };
    let [x0, x1, y0, y1] = match (place(x0, x1, dx), place(y0, y1, dy)) {
        (Some(x), Some(y)) => {
            let ([x0, x1], [y0, y1]) = (x.to_le_bytes(), y.to_le_bytes());
            [x0, x1, y0, y1]
        }
        _ => OFF_FRAME,
    };
    [x0, x1, y0, y1, r, g, b, a]
}

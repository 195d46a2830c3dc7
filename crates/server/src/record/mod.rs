//! Recordings: the commands that a server executed, in execution order, with the connection and
//! time of each.
//!
//! ```text
//! #!fbptr-record 2 640x480
//! #@ 3 0.001234 000000000014        connection, seconds since the start, bytes that follow
//! PX 1 1 ff0000
//! #@ 3 0.400000 files 000000000120  files that the next command of connection 3 reads
//! #@ 3 0.500000 end                 the connection is over
//! #!end 12.345678                   the recording is complete
//! ```
//! The bytes are commands of the protocol, followed by an LF that belongs to no command.
//! Consecutive commands of one connection at one time may share a header; connection 0 stands for
//! foreign writes to the shared file. Plain text pixels are stored as `PB` records, already moved
//! by OFFSET. Refused commands are left out, and a SNAP into a file becomes a comment.
//!
//! `files` contains what a command read from the load folder, so that a replay needs no folder. Its
//! bytes are entries, one per file: a line `id name_bytes content_bytes`, the name, the content.
//! Content that is in the recording already is not repeated: its entry has the same id, and `-` for
//! `content_bytes`. Files that were not found are not listed.
//!
//! Version 1 has neither `files` nor `#!end`, and its LOAD reads the folder again; it can still be
//! replayed.
//!
//! [`Recorder`] observes the engine on the render thread, [`writer`] is the thread that writes,
//! [`file`] opens and locks the file; [`super::replay::Replay`] runs a recording. Promise: a
//! recording is exact up to its end, and one that ends early has no `#!end`, which its replay
//! reports.

mod file;
mod observe;
mod recorder;
#[cfg(test)]
mod tests;
mod writer;

pub use file::RecordFile;
pub(super) use observe::output;
pub use recorder::Recorder;

/// First bytes of a recording; the version, a blank and the frame's size follow.
pub const RECORD_MAGIC: &[u8] = b"#!fbptr-record ";

/// Text before the time in the last line of a complete recording.
pub(super) const END_MARK: &str = "#!end";

/// Returns the frame's size from the first line of a recording, as `WIDTHxHEIGHT`; `None` for other
/// text.
pub fn recorded_size(first_line: &[u8]) -> Option<&str> {
    let rest = std::str::from_utf8(first_line.strip_prefix(RECORD_MAGIC)?).ok()?;
    rest.trim_end().split(' ').nth(1)
}

//! `serve --record`: the recording begins after the sockets are bound and before any client's first
//! command runs.

use super::say_as_program;
use crate::server::{RecordFile, Recorder, Server};
use crossbeam_channel::{Sender, bounded};
use std::path::Path;

/// Blocks the render thread until a recorder is set, or none is to be used.
pub(super) struct RecordGate {
    /// Dropped without a recorder, it lets the render thread continue without one.
    recorder: Sender<Recorder>,
    size: (u32, u32),
}

impl RecordGate {
    /// Blocks the render thread of `server`, which has no clients yet.
    pub fn close(server: &Server, size: (u32, u32)) -> RecordGate {
        let (recorder, chosen) = bounded(1);
        server.thread().run_between(move |engine| {
            if let Ok(recorder) = chosen.recv() {
                engine.attach(recorder);
            }
        });
        RecordGate { recorder, size }
    }

    /// Releases the render thread, recording into `path` if there is one.
    ///
    /// # Errors
    /// Fails if the recording cannot begin; the render thread continues without it.
    pub fn open(self, path: Option<&Path>) -> Result<(), String> {
        let Some(path) = path else { return Ok(()) };
        let name = path.display().to_string();
        let refused = |e: std::io::Error| format!("{}: {e}", path.display());
        let file = RecordFile::open(path).map_err(refused)?;
        let tell = move |error: &std::io::Error| {
            say_as_program(format_args!("{name}: the recording ends early: {error}"));
        };
        let recorder = Recorder::to_file(file, self.size.0, self.size.1, tell).map_err(refused)?;
        // A render thread that has ended records nothing, and the server ends anyway.
        let _ = self.recorder.send(recorder);
        Ok(())
    }
}

//! `serve --record`: the recording begins after the sockets are bound and before any client's first command runs.

use super::say_as_program;
use crate::server::{RecordFile, Recorder, Server};
use crossbeam_channel::{Sender, bounded};
use std::path::Path;

/// Holds the render thread until it is known whether and where to record.
pub(super) struct RecordGate {
    /// Dropped without a recorder, it lets the render thread go on without one.
    recorder: Sender<Recorder>,
    size: (u32, u32),
}

impl RecordGate {
    /// Stops the render thread of `server`, which nobody can reach yet.
    pub fn close(server: &Server, size: (u32, u32)) -> RecordGate {
        let (recorder, chosen) = bounded(1);
        server.thread().run_between(move |engine| {
            if let Ok(recorder) = chosen.recv() {
                engine.set_recorder(recorder);
            }
        });
        RecordGate { recorder, size }
    }

    /// Lets the render thread go, recording into `path` if there is one.
    ///
    /// # Errors
    /// When the recording cannot begin; the render thread goes on without it.
    pub fn open(self, path: Option<&Path>) -> Result<(), String> {
        let Some(path) = path else { return Ok(()) };
        let name = path.display().to_string();
        let refused = |e: std::io::Error| format!("{}: {e}", path.display());
        let file = RecordFile::open(path).map_err(refused)?;
        let tell = move |error: &std::io::Error| {
            say_as_program(format_args!("{name}: the recording ends early: {error}"));
        };
        let recorder = Recorder::to_file(file, self.size.0, self.size.1, tell).map_err(refused)?;
        // A render thread that is gone records nothing, and the server ends anyway.
        let _ = self.recorder.send(recorder);
        Ok(())
    }
}

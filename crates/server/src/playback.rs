//! Input that is played from its first byte to its last on the calling thread, one stream of
//! commands or a recording of many.
//!
//! In: the bytes of a file. Out: the same as from [`Stream::feed`]. Promises: what is drawn is what
//! `play` draws of the file. Tested by the viewer's tests.

use super::Budget;
use super::record::RECORD_MAGIC;
use super::replay::Replay;
use fbptr_command::EndOfInput;
use fbptr_core::scene::Camera;
use fbptr_engine::engine::Engine;
use fbptr_engine::session::Audience;
use fbptr_engine::stream::{Output, Stream, StreamState};

/// A stream or a recording that is being played.
pub struct Playback(Input);

enum Input {
    /// Commands in a session of their own.
    Stream(Box<Stream>),
    /// Commands of the recording's connections, each with its session.
    Recording(Box<Replay>),
}

impl Playback {
    /// Begins the input that has these bytes, which are not played yet.
    pub fn new(engine: &mut Engine, bytes: &[u8]) -> Self {
        if bytes.starts_with(RECORD_MAGIC) {
            return Playback(Input::Recording(Box::new(Replay::new())));
        }
        engine.open(1);
        Playback(Input::Stream(Box::new(Stream::new(engine, 1, Audience::Owner))))
    }

    /// Runs the commands that are complete in `bytes`; see [`Stream::feed`].
    pub fn feed(
        &mut self,
        engine: &mut Engine,
        bytes: &[u8],
        out: &mut Output,
        budget: Budget,
    ) -> (usize, StreamState) {
        match &mut self.0 {
            Input::Stream(stream) => stream.feed(engine, bytes, out, budget),
            Input::Recording(replay) => replay.feed(engine, bytes, out, budget),
        }
    }

    /// Ends the input, as a file that `play` reads ends.
    pub fn finish(&mut self, engine: &mut Engine, out: &mut Output) -> StreamState {
        match &mut self.0 {
            Input::Stream(stream) => stream.finish(engine, EndOfInput::File, out),
            Input::Recording(replay) => {
                replay.finish(engine, out);
                StreamState::Ended
            }
        }
    }

    /// Returns whether the input is one stream of commands, and no recording.
    pub fn is_stream(&self) -> bool {
        matches!(self.0, Input::Stream(_))
    }

    /// Returns the camera of the commands that ran last.
    pub fn camera(&self) -> Camera {
        match &self.0 {
            Input::Stream(stream) => stream.session().camera,
            Input::Recording(replay) => replay.camera(),
        }
    }
}

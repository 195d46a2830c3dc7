//! Player of one stream on the render thread, for `play` and for programs that embed it.

use super::message::Medium;
use super::record::RECORD_MAGIC;
use super::thread::RenderThread;
use super::transport::{ByteSource, Endpoint, Uncontrolled, serve_connection};
use super::{Audience, Notice};
use fbptr_command::EndOfInput;
use std::io::{self, Read, Write};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// A stream that is being played. Its errors go to its owner, its replies to a writer. A recording
/// (`serve --record`) is played as the connections that it contains.
#[derive(Debug)]
pub struct Player {
    end: Arc<End>,
}

#[derive(Default)]
struct End {
    state: Mutex<EndState>,
    changed: Condvar,
}

impl std::fmt::Debug for End {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "End")
    }
}

#[derive(Default)]
struct EndState {
    has_ended: bool,
    on_end: Option<Box<dyn FnOnce() + Send>>,
}

impl Player {
    /// Plays `input` to its end. `notify` is called with every error, and with warnings about
    /// files; replies are written to `output`.
    ///
    /// # Errors
    /// If the system has no thread to give.
    pub fn start(
        thread: &RenderThread,
        input: Box<dyn Read + Send>,
        output: Box<dyn Write + Send>,
        end: EndOfInput,
        notify: impl FnMut(Notice) + Send + 'static,
    ) -> io::Result<Player> {
        let ended = Arc::new(End::default());
        let signal = ended.clone();
        let endpoint = Endpoint {
            input: ByteSource::Alone(Box::new(Sniffing { input, has_begun: false })),
            output,
            control: Arc::new(Uncontrolled),
            end,
            audience: Audience::Owner,
            medium: Medium::Pipe,
            may_replay: true,
            on_notice: Some(Box::new(notify)),
            on_end: Some(Box::new(move || signal.notify())),
        };
        serve_connection(&thread.link(), endpoint)?;
        Ok(Player { end: ended })
    }

    /// Returns whether the last command has run.
    pub fn has_ended(&self) -> bool {
        self.end.state.lock().unwrap_or_else(PoisonError::into_inner).has_ended
    }

    /// Calls `action` on the render thread when the last command has run, or at once if it has.
    pub fn on_end(&self, action: impl FnOnce() + Send + 'static) {
        let mut state = self.end.state.lock().unwrap_or_else(PoisonError::into_inner);
        match state.has_ended {
            true => {
                drop(state);
                action();
            }
            false => state.on_end = Some(Box::new(action)),
        }
    }

    /// Waits until the last command has run.
    pub fn wait(&self) {
        let state = self.end.state.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.end.changed.wait_while(state, |s| !s.has_ended);
        drop(waited.unwrap_or_else(PoisonError::into_inner));
    }
}

impl End {
    fn notify(&self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.has_ended = true;
        let action = state.on_end.take();
        drop(state);
        self.changed.notify_all();
        if let Some(action) = action {
            action();
        }
    }
}

/// A reader whose first read returns enough bytes to tell a recording from a stream.
struct Sniffing {
    input: Box<dyn Read + Send>,
    has_begun: bool,
}

impl Read for Sniffing {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut filled = self.input.read(buffer)?;
        if !std::mem::replace(&mut self.has_begun, true) {
            // Reads on only while the bytes look like a recording, so that a typed stream is not
            // delayed.
            while filled < RECORD_MAGIC.len().min(buffer.len()) && RECORD_MAGIC.starts_with(&buffer[..filled])
            {
                match self.input.read(&mut buffer[filled..]) {
                    Ok(0) => break,
                    Ok(more) => filled += more,
                    Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
                    // The bytes so far are valid; the next read returns the error again.
                    Err(_) => break,
                }
            }
        }
        Ok(filled)
    }
}

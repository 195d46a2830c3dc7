//! Playing one stream on the render thread: `play`, and programs that embed it.

use super::thread::RenderThread;
use super::transport::{Conversation, Uncontrolled, converse};
use super::{Audience, Notice};
use crate::command::EndOfInput;
use std::io::{self, Read, Write};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

/// A stream that is being played. Its errors go to its owner, its replies to a writer.
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
    /// Plays `input` to its end. `notify` hears of every refused command, and of what files were warned about; replies are written to `output`.
    ///
    /// # Errors
    /// When the system has no thread to give.
    pub fn start(
        thread: &RenderThread,
        input: Box<dyn Read + Send>,
        output: Box<dyn Write + Send>,
        end: EndOfInput,
        notify: impl FnMut(Notice) + Send + 'static,
    ) -> io::Result<Player> {
        let ended = Arc::new(End::default());
        let told = ended.clone();
        let conversation = Conversation {
            input,
            output,
            control: Arc::new(Uncontrolled),
            end,
            audience: Audience::Owner,
            on_notice: Some(Box::new(notify)),
            on_end: Some(Box::new(move || told.tell())),
            slot: None,
        };
        converse(&thread.link(), conversation)?;
        Ok(Player { end: ended })
    }

    /// Whether its last command has run.
    pub fn has_ended(&self) -> bool {
        self.end.state.lock().unwrap_or_else(PoisonError::into_inner).has_ended
    }

    /// Calls `action` when the last command has run, on the render thread, or now if it has.
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
    fn tell(&self) {
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

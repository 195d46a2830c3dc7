//! The in-process client: a method for each verb of the protocol, with typed arguments and replies.
//!
//! ```
//! use fbptr_server::{Engine, Finish, RenderThread};
//!
//! let thread = RenderThread::start(Engine::new(320, 200)?)?;
//! let client = thread.client();
//! client.clear([0, 0, 64, 255]);
//! client.line([0, 0], [319, 199], [255, 255, 0, 255]);
//! client.fill([[40.0, 20.0], [280.0, 60.0], [100.0, 180.0]], [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]]);
//! client.text([8, 8], "hello", [255; 4]);
//! client.sync()?;
//! let picture = client.snapshot()?;
//! assert_eq!(picture.get_pixel(0, 0)?, [255, 255, 0, 255]);
//! thread.finish(Finish::Now);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod methods;
mod queries;
#[cfg(test)]
mod tests;
mod verbs;

use super::CommandError;
use super::message::{Id, Inbox, Item, Message};
use crossbeam_channel::{Sender, bounded};
use fbptr_command::{Command, EndOfInput};
use fbptr_core::error::{Code, Fault};
use fbptr_core::input::InputEvent;
use fbptr_core::memory::VideoMemory;
use std::fmt;
use std::sync::Arc;

/// A connection to the render thread from this process. Dropping it ends the connection.
///
/// Commands are queued and run in order; [`Client::send`] blocks only when it is thousands of
/// commands ahead. Errors are kept for [`Client::sync`]; methods that return a reply, and
/// [`Client::ask`], return theirs at once.
pub struct Client {
    id: Id,
    messages: Sender<Message>,
    inbox: Arc<Inbox>,
}

impl fmt::Debug for Client {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Client({})", self.id)
    }
}

fn has_ended() -> Fault {
    Fault::new(Code::Proto, "the render thread has ended")
}

impl Client {
    pub(super) fn new(id: Id, messages: Sender<Message>, inbox: Arc<Inbox>) -> Self {
        Client { id, messages, inbox }
    }

    fn put(&self, item: Item) {
        if self.inbox.put(item) == Some(true) {
            // Fails if the render thread has ended: then nobody needs the message.
            let _ = self.messages.send(Message::Mail(self.id));
        }
    }

    /// Queues a command. Its reply, if it is a query, is dropped: see [`Client::ask`].
    pub fn send(&self, command: Command) {
        self.put(Item::Command(command));
    }

    /// Runs a command after all earlier ones, and returns the bytes of its reply, which are empty
    /// if it is not a query.
    ///
    /// # Errors
    /// The reason for which the command was refused.
    pub fn ask(&self, command: Command) -> Result<Vec<u8>, Fault> {
        let (answer, result) = bounded(1);
        self.put(Item::Ask(command, answer));
        result.recv().unwrap_or_else(|_| Err(has_ended()))
    }

    /// Waits until all earlier commands have run.
    ///
    /// # Errors
    /// The first of the errors since the last call.
    pub fn sync(&self) -> Result<(), Fault> {
        self.ask(Command::Sync { tag: "-".into() })?;
        match self.errors().into_iter().next() {
            None => Ok(()),
            Some(CommandError { verb, mut fault, .. }) => {
                fault.message.insert_str(0, &format!("{verb}: "));
                Err(fault)
            }
        }
    }

    /// Returns the errors since the last call. The line of an error's place counts commands from 1.
    pub fn errors(&self) -> Vec<CommandError> {
        self.inbox.errors()
    }

    /// Returns the window's events since the last call, in order; none until `EVENTS on` was sent.
    pub fn events(&self) -> Vec<InputEvent> {
        self.inbox.events()
    }

    /// Returns a copy of the video memory after all earlier commands.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn snapshot(&self) -> Result<VideoMemory, Fault> {
        let (answer, result) = bounded(1);
        self.put(Item::Look(Box::new(move |engine| {
            // The client may be gone.
            let _ = answer.send(engine.memory().clone());
        })));
        result.recv().map_err(|_| has_ended())
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // The render thread takes the rest of the inbox before it handles this message.
        let _ = self.messages.send(Message::End(self.id, EndOfInput::Stream));
    }
}

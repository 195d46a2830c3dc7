//! The in-process client: the commands of the protocol as typed values.
//!
//! ```
//! use fbptr::server::{Engine, Finish, RenderThread};
//!
//! let thread = RenderThread::start(Engine::new(320, 200)?)?;
//! let client = thread.client();
//! client.clear([0, 0, 64, 255]);
//! client.line([0, 0], [319, 199], [255, 255, 0, 255]);
//! client.fill([[40.0, 20.0], [280.0, 60.0], [100.0, 180.0]], [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]]);
//! client.sync()?;
//! let picture = client.snapshot()?;
//! assert_eq!(picture.get_pixel(0, 0)?, [255, 255, 0, 255]);
//! thread.finish(Finish::Now);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use super::message::{Id, Inbox, Item, Message};
use super::{CommandError, InputEvent};
use crate::command::{AreaColors, Command, EndOfInput, Figure, MeshSource, RampColor, RealRect, Rect};
use crate::error::{Code, Fault};
use crate::memory::{Rgba, VideoMemory};
use crossbeam_channel::{Sender, bounded};
use glam::DVec3;
use std::fmt;
use std::sync::Arc;

/// A connection to the render thread from this process. Dropping it ends the connection.
///
/// Commands are queued and run in order; [`Client::send`] blocks only when it is thousands of
/// commands ahead. Errors are kept for [`Client::sync`], or returned at once by [`Client::ask`].
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

    /// Sends `PRESENT wait`: ends a frame and waits until it is shown. Returns its number.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn present(&self) -> Result<u64, Fault> {
        let reply = self.ask(Command::Present { wait: true })?;
        let text = String::from_utf8_lossy(&reply);
        text.trim_end().strip_prefix("FRAME ").and_then(|n| n.parse().ok()).ok_or_else(has_ended)
    }

    /// Sends `AUTO on|off`: selects whether the display follows the memory or shows complete frames
    /// only.
    pub fn auto(&self, on: bool) {
        self.send(Command::Auto(on));
    }

    /// Sends `CLEAR colour`.
    pub fn clear(&self, color: Rgba) {
        self.send(Command::Clear { color });
    }

    /// Sends `PX x y colour`.
    #[doc(alias = "putPixel")]
    pub fn pixel(&self, x: i32, y: i32, color: Rgba) {
        self.send(Command::Pixel { x, y, color });
    }

    /// Sends `LINE` in one colour.
    pub fn line(&self, p0: [i32; 2], p1: [i32; 2], color: Rgba) {
        self.send(Command::Figure(Figure::Line { p0, p1, color: RampColor { from: color, to: None } }));
    }

    /// Sends `LINE` with a colour ramp.
    pub fn ramp(&self, p0: [i32; 2], p1: [i32; 2], from: Rgba, to: Rgba) {
        self.send(Command::Figure(Figure::Line { p0, p1, color: RampColor { from, to: Some(to) } }));
    }

    /// Sends `FILL` with a colour at each corner.
    pub fn fill(&self, points: [[f64; 2]; 3], colors: [Rgba; 3]) {
        self.send(Command::Figure(Figure::Fill { points, colors: AreaColors::Three(colors) }));
    }

    /// Sends `FILLRECT`: fills the pixels whose centres lie in [x, x + w) x [y, y + h).
    pub fn fill_rect<T: Into<f64>>(&self, x: T, y: T, w: T, h: T, color: Rgba) {
        let [x, y, w, h] = [x, y, w, h].map(Into::into);
        self.send(Command::Figure(Figure::FillRect { rect: RealRect { x, y, w, h }, color }));
    }

    /// Sends `BLIT` with `h` rows of `w` RGBA pixels.
    pub fn blit(&self, x: i32, y: i32, w: i32, h: i32, rgba: Vec<u8>) {
        self.send(Command::Blit { rect: Rect { x, y, w, h }, rgba });
    }

    /// Sends `TEXT`.
    pub fn text(&self, x: i32, y: i32, color: Rgba, text: &str) {
        self.send(Command::Figure(Figure::Text { x, y, color, utf8: text.as_bytes().to_vec() }));
    }

    /// Sends `MESH`.
    pub fn mesh(&self, name: &str, source: MeshSource) {
        self.send(Command::Mesh { name: name.into(), source: Box::new(source) });
    }

    /// Sends `LOOKAT`.
    pub fn look_at(&self, eye: DVec3, reference: DVec3, up: DVec3) {
        self.send(Command::LookAt { eye, reference, up });
    }

    /// Sends `ROTATE`.
    pub fn rotate(&self, axis: DVec3, angle_rad: f64) {
        self.send(Command::Rotate { axis, angle_rad });
    }

    /// Sends `DRAW`.
    pub fn draw(&self, name: &str) {
        self.send(Command::Draw { name: name.into() });
    }

    /// Sends `CRC` of the video memory, and returns the checksum.
    ///
    /// # Errors
    /// If the render thread has ended.
    pub fn crc(&self) -> Result<u32, Fault> {
        let reply = self.ask(Command::Crc { rect: None })?;
        let text = String::from_utf8_lossy(&reply);
        let hex = text.trim_end().strip_prefix("CRC ").unwrap_or("");
        u32::from_str_radix(hex, 16).map_err(|_| has_ended())
    }
}

impl Drop for Client {
    fn drop(&mut self) {
        // The render thread takes the rest of the inbox before it handles this message.
        let _ = self.messages.send(Message::End(self.id, EndOfInput::Stream));
    }
}

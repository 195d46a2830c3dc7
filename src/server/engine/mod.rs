//! THE ENGINE: runs commands on the video memory, one by one, on whatever thread calls it.
//!
//! In: a [`Command`] and the [`Session`] of the connection that it came from. Out: changed memory, reply bytes, or a
//! [`Fault`] that says why nothing changed. It owns what all connections share: video memory, depth, the face ids of
//! PICK, names that begin with `@`, the count of frames, the totals. It starts no thread, and without a display, a
//! shared file or a folder it does no I/O. Order is the caller's: what runs first has taken effect for what runs next.
//!
//! ```
//! use fbptr::command::Command;
//! use fbptr::server::{Audience, Engine, Session};
//!
//! let mut engine = Engine::new(10, 6)?;
//! let mut session = Session::new(1, Audience::Owner);
//! let mut replies = Vec::new();
//! engine.run(&mut session, Command::Pixel { x: 1, y: 1, color: [255, 0, 0, 255] }, &mut replies)?;
//! engine.run(&mut session, Command::GetPixel { x: 1, y: 1 }, &mut replies)?;
//! assert_eq!(replies, b"PX 1 1 ff0000\n");
//! # Ok::<(), fbptr::error::Fault>(())
//! ```

mod control;
mod memory;
mod quality;
mod resources;
mod shared;
mod space;
mod trace;

use super::names::Names;
use super::record::Recorder;
use super::{Display, Limits, Session, Stats};
use crate::command::{Command, SparePayload};
use crate::error::Fault;
use crate::load::Folder;
use crate::memory::{DepthFormat, DepthMemory, IdMemory, Rgba, VideoMemory};
use crate::pipeline::Renderer;
use crate::pipeline::budget::Memo;
use crate::scene::Lens;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// What the caller has to do after a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Effect {
    /// Nothing.
    Done,
    /// Close the connection once its replies are out.
    Quit,
    /// `PRESENT wait` at a window: answer `FRAME n` when frame n is on the screen, and run nothing of this connection
    /// until then.
    WaitShown(u64),
}

/// See the module's text.
#[derive(Debug)]
pub struct Engine {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    depth_format: DepthFormat,
    ids: Option<IdMemory>,
    renderer: Renderer,
    /// What QUALITY chose for which state.
    budgets: Memo,
    lens: Lens,
    /// The names that ids stand for.
    id_names: IdNames,
    shared: Names,
    limits: Limits,
    snap_dir: Option<Folder>,
    load_dir: Option<Folder>,
    display: Option<Arc<Display>>,
    /// Rows that the display has not been given yet.
    unshown: Range<u32>,
    /// Presents so far.
    frames: u64,
    /// What all connections did, up to each one's last slice.
    totals: Stats,
    connections: usize,
    /// Sessions that want the display frozen, and those that want events.
    frozen: usize,
    listeners: usize,
    /// Bytes received and not run yet, told by the render thread.
    queue_bytes: u64,
    /// What the last 3-D draw did, in words without blanks.
    plan: String,
    tracing: Option<trace::Tracing>,
    shared_file: Option<shared::Shared>,
    recorder: Option<Recorder>,
    on_present: OnPresent,
    /// What stands in the recording for the command that is run.
    recorded_as: Option<Command>,
    /// Where the decoders of all connections put large payloads' buffers.
    spare: SparePayload,
    spare_swept: Instant,
}

/// What is told of every `PRESENT`.
struct OnPresent(Option<PresentAction>);

type PresentAction = Box<dyn FnMut(&VideoMemory) + Send>;

impl std::fmt::Debug for OnPresent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "OnPresent({})", self.0.is_some())
    }
}

/// Names that the id memory's numbers stand for.
#[derive(Debug, Default)]
struct IdNames {
    names: Vec<Arc<str>>,
    numbers: HashMap<Arc<str>, u32>,
    /// Where the names of the objects of the last scene drawn begin.
    last_scene: u32,
}

/// How long an unused buffer of a large payload is held for the next one.
const HOLD_SPARE: Duration = Duration::from_secs(1);

impl Engine {
    /// The buffer that decoders share.
    pub(crate) fn spare(&self) -> &SparePayload {
        &self.spare
    }

    /// Gives back the shared buffer when nobody has used it for a while. Answers when to look again, if at all.
    pub(crate) fn sweep_spare(&mut self, now: Instant) -> Option<Instant> {
        if now >= self.spare_swept + HOLD_SPARE {
            self.spare.sweep();
            self.spare_swept = now;
        }
        (self.spare.held_bytes() > 0).then(|| self.spare_swept + HOLD_SPARE)
    }

    /// An engine over a fresh frame of `width` x `height` pixels with the default limits.
    ///
    /// # Errors
    /// `ETOOBIG` for a frame that cannot be had.
    pub fn new(width: u32, height: u32) -> Result<Self, Fault> {
        Engine::with_limits(width, height, Limits::default())
    }

    /// The same with other limits.
    ///
    /// # Errors
    /// `ETOOBIG` for a frame that cannot be had, or is over `limits.frame_bytes`.
    pub fn with_limits(width: u32, height: u32, limits: Limits) -> Result<Self, Fault> {
        limits.check_frame(width, height)?;
        let memory = VideoMemory::new(width, height).map_err(|e| Fault::new(e.code(), e.to_string()))?;
        Ok(Engine {
            memory,
            depth: None,
            depth_format: DepthFormat::default(),
            ids: None,
            renderer: Renderer::default(),
            budgets: Memo::default(),
            lens: Lens::default(),
            id_names: IdNames::default(),
            shared: Names::default(),
            limits,
            snap_dir: None,
            load_dir: None,
            display: None,
            unshown: 0..height,
            frames: 0,
            totals: Stats::default(),
            connections: 0,
            frozen: 0,
            listeners: 0,
            queue_bytes: 0,
            plan: String::from("-"),
            tracing: None,
            shared_file: None,
            recorder: None,
            on_present: OnPresent(None),
            recorded_as: None,
            spare: SparePayload::default(),
            spare_swept: Instant::now(),
        })
    }

    /// Calls `action` with the frame at every `PRESENT` from now on, before anything else is run.
    pub fn set_on_present(&mut self, action: impl FnMut(&VideoMemory) + Send + 'static) {
        self.on_present = OnPresent(Some(Box::new(action)));
    }

    /// Sees what is drawn in three dimensions through `lens` from now on, whatever its author says.
    pub fn set_lens(&mut self, lens: Lens) {
        self.lens = lens;
    }

    /// Draws in three dimensions with `renderer` from now on; until then, with the calling thread alone.
    pub fn set_renderer(&mut self, renderer: Renderer) {
        self.renderer = renderer;
    }

    /// Lets SNAP write files, in this folder only.
    pub fn set_snap_dir(&mut self, folder: Folder) {
        self.snap_dir = Some(folder);
    }

    /// Lets LOAD read files, from this folder only.
    pub fn set_load_dir(&mut self, folder: Folder) {
        self.load_dir = Some(folder);
    }

    /// Shows the memory on `display` from now on; it must have the frame's size.
    pub fn set_display(&mut self, display: Arc<Display>) {
        assert_eq!((display.width(), display.height()), (self.memory.width(), self.memory.height()));
        display.set_listeners(self.listeners);
        self.display = Some(display);
    }

    /// Fills the frame, as it stands before any command.
    pub fn fill_frame(&mut self, color: Rgba) {
        self.memory.clear(color);
    }

    /// The video memory.
    pub fn memory(&self) -> &VideoMemory {
        &self.memory
    }

    /// The depth memory, if anything needed one yet.
    pub fn depth(&self) -> Option<&DepthMemory> {
        self.depth.as_ref()
    }

    /// The quotas.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Presents so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// What all connections did, as far as they were counted ([`Engine::count`]).
    pub fn totals(&self) -> Stats {
        self.totals
    }

    /// A connection begins.
    pub fn open(&mut self) {
        self.connections += 1;
    }

    /// A connection ends: what it asked of the display is over.
    pub fn close(&mut self, session: &mut Session) {
        self.connections = self.connections.saturating_sub(1);
        self.set_auto(session, true);
        self.set_events(session, false);
        self.count(session);
        if let Some(recorder) = &mut self.recorder {
            recorder.end(session.id);
        }
    }

    /// Adds what `session` did since the last call to the totals.
    pub fn count(&mut self, session: &mut Session) {
        self.totals += session.stats - session.counted;
        session.counted = session.stats;
    }

    /// Runs one command of `session`; replies are appended to `replies`, and left as they were on an error.
    ///
    /// # Errors
    /// Why the command was refused; it then changed nothing.
    pub fn run(
        &mut self,
        session: &mut Session,
        command: Command,
        replies: &mut Vec<u8>,
    ) -> Result<Effect, Fault> {
        session.stats.commands += 1;
        let connection = session.id;
        let start = replies.len();
        let recorded = self.recorder.as_mut().map(|r| r.command(connection, &command));
        let result = self.dispatch(session, command, replies).and_then(|effect| {
            let length = replies.len() - start;
            match length <= self.limits.reply_bytes {
                true => Ok(effect),
                false => Err(self.reply_too_long(length as u64)),
            }
        });
        if result.is_err() {
            replies.truncate(start);
            session.stats.errors += 1;
        }
        if let (Some(recorder), Some(before)) = (&mut self.recorder, recorded) {
            if let Some(command) = self.recorded_as.take().filter(|_| result.is_ok()) {
                recorder.roll_back(before);
                recorder.command(connection, &command);
            } else if result.is_err() {
                recorder.roll_back(before);
            }
        }
        result
    }

    /// One line a verb: this is the table of what each command does.
    fn dispatch(&mut self, s: &mut Session, command: Command, out: &mut Vec<u8>) -> Result<Effect, Fault> {
        use Command as C;
        if !is_pixelflut(&command) {
            s.has_used_other_verbs = true;
        }
        match command {
            C::Help => self.help(out),
            C::Size => self.size(out),
            C::GetPixel { x, y } => self.asked_pixel(s, x, y, out)?,
            C::Pixel { x, y, color } => {
                let (x, y) = Self::moved(s, x, y);
                self.pixel(s, x, y, color);
            }
            C::Offset { x, y } => s.offset = [x, y],
            C::Quit => return Ok(Effect::Quit),
            C::Stats => self.stats(s, out),
            C::BinaryPixel { x, y, color } => self.pixel(s, x.into(), y.into(), color),
            C::PixelRun { x, y, rgba } => self.pixel_run(s, x, y, &rgba)?,

            C::Poke { offset, bytes } => self.poke(s, offset, &bytes)?,
            C::Peek { offset, n } => self.peek(offset, n, out)?,
            C::Blit { rect, rgba } => self.blit(s, rect, &rgba)?,
            C::Read { rect } => self.read(rect, out)?,
            C::Copy { source, dx, dy } => self.copy(s, source, dx, dy)?,
            C::Points { packed } => self.points(s, &packed)?,
            C::Crc { rect } => self.crc(rect, out)?,
            C::Clear { color } => self.clear(s, color),

            C::Line { .. }
            | C::Triangle { .. }
            | C::Fill { .. }
            | C::Rect { .. }
            | C::FillRect { .. }
            | C::Circle { .. }
            | C::FillCircle { .. }
            | C::Poly { .. }
            | C::FillPoly { .. }
            | C::Text { .. }
            | C::LineAa { .. } => self.figure(s, command)?,
            C::Blend { over } => {
                s.blend = if over { crate::draw2d::Blend::Over } else { crate::draw2d::Blend::Replace };
            }

            C::Mesh { name, source } => self.make_mesh(s, &name, *source)?,
            C::Texture { name, file } => self.make_texture(s, &name, &file)?,
            C::Scene { x3d } => self.make_scene(s, &x3d)?,
            C::Eye { name, json } => self.make_eye(s, &name, &json)?,
            C::Free { name } => self.free(s, &name)?,
            C::Load { kind, name, path } => self.load(s, kind, &name, &path)?,

            C::LookAt { .. } | C::Projection(_) | C::Viewport { .. } => self.set_camera(s, command)?,
            C::Identity
            | C::Push
            | C::Pop
            | C::Translate(_)
            | C::Rotate { .. }
            | C::Scale(_)
            | C::Shear(_)
            | C::Matrix(_) => self.model_matrix(s, command)?,
            C::Ambient(color) => s.ambient = color,
            C::Light { index, light } => self.set_light(s, index, *light)?,
            C::Material(material) => s.material = *material,
            C::UseTexture { name, sampling } => self.use_texture(s, name, sampling)?,
            C::Shade(mode) => s.shade = mode,
            C::Cull(mode) => s.cull = mode,
            C::Hide(mode) => s.hide = mode,
            C::Depth(format) => self.set_depth_format(format),
            C::Interp(mode) => s.interp = mode,
            C::Quality(quality) => s.quality = quality,
            C::Draw { name } => self.draw(s, &name)?,
            C::DrawScene { time, sorted } => self.draw_scene(s, time, sorted)?,
            C::DrawEye { name, rect } => self.draw_eye(s, &name, rect)?,

            C::DepthAt { x, y } => self.depth_at(x, y, out)?,
            C::Pick { x, y } => self.pick(x, y, out)?,
            C::Sync { tag } => out.extend_from_slice(format!("SYNC {tag}\n").as_bytes()),
            C::Hello => self.hello(out),
            C::Version => out.extend_from_slice(VERSION_REPLY.as_bytes()),
            C::Auto(on) => self.set_auto(s, on),
            C::Present { wait } => return Ok(self.present(s, wait, out)),
            C::Events(on) => self.set_events(s, on),
            C::Errors(mode) => s.error_mode = Some(mode),
            C::Snap(target) => self.snap(target, out)?,
        }
        Ok(Effect::Done)
    }
}

const VERSION_REPLY: &str = concat!("VERSION fbptr ", env!("CARGO_PKG_VERSION"), "\n");

/// Whether a connection that uses this command is still a Pixelflut one.
fn is_pixelflut(command: &Command) -> bool {
    use Command as C;
    matches!(
        command,
        C::Help
            | C::Size
            | C::GetPixel { .. }
            | C::Pixel { .. }
            | C::BinaryPixel { .. }
            | C::PixelRun { .. }
            | C::Offset { .. }
            | C::Quit
            | C::Stats
    )
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.end();
    }
}

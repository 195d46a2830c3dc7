//! The engine: runs commands on the video memory, one by one, on the thread that calls it.
//!
//! In: a [`Command`](fbptr_command::Command) and the [`Session`] of the connection that it came
//! from. Out: changed memory, reply bytes, or a [`Fault`] that says why nothing changed. It owns
//! everything that connections share: video memory, depth buffer, the pick buffer, resources whose
//! names begin with `@`, the frame count, the totals. Displays, recordings and the like are its
//! observers ([`Observer`]). It starts no thread, and without observers or a folder it does no I/O.
//! The caller decides the order: a command has taken effect before the next one runs.
//!
//! ```
//! use fbptr_command::Command;
//! use fbptr_engine::{Audience, Engine, Session};
//!
//! let mut engine = Engine::new(10, 6)?;
//! let mut session = Session::new(1, Audience::Owner);
//! let mut replies = Vec::new();
//! engine.run(&mut session, Command::Pixel { x: 1, y: 1, color: [255, 0, 0, 255] }, &mut replies)?;
//! engine.run(&mut session, Command::GetPixel { x: 1, y: 1 }, &mut replies)?;
//! assert_eq!(replies, b"PX 1 1 ff0000\n");
//! # Ok::<(), fbptr_core::error::Fault>(())
//! ```

mod area_queue;
mod call;
mod default_view;
mod dispatch;
mod draw2d;
mod draw3d;
mod draw_log;
mod draw_queue;
mod draw_times;
mod drawing;
mod empty_draw;
#[cfg(test)]
mod example;
mod explain;
mod files;
mod frame_source;
mod image;
mod job;
#[cfg_attr(not(feature = "threads"), path = "no_long_draw.rs")]
mod long_draw;
mod observer;
mod observers;
mod pieces;
mod quality;
mod queries;
mod quotas;
mod request;
mod resources;
mod scene_request;
mod settings;
mod status;
mod steps;
mod surface;
mod trace;

use super::engine_frame::EngineFrame;
use super::read_files::FileHasher;
use super::resources::ResourceTable;
use super::{Limits, Session, Stats};
use fbptr_core::cancel::CancelToken;
use fbptr_core::draw2d::Blend;
use fbptr_core::error::{Code, Fault};
use fbptr_core::eye::Rotation;
use fbptr_core::memory::{DepthMemory, MemoryBudget, MemoryUse, OverBudget, Rgba, VideoMemory};
use fbptr_core::pipeline::Renderer;
use fbptr_core::pipeline::quality::MeshShapes;
use fbptr_core::scene::ViewOverrides;
use fbptr_formats::load::{QuotaDir, SandboxDir};
use std::sync::Arc;
use std::time::Duration;

pub(crate) use area_queue::{MOST_AREAS, MOST_AREAS_NS, QueuedArea};
use call::{Call, Outcome};
use draw_log::DrawLog;
pub(crate) use draw_queue::{MOST_DRAWS, MOST_NS};
use draw_times::DrawTimes;
pub(crate) use drawing::Drawing;
pub(crate) use files::FileReader;
use image::Decoded;
pub use job::{Job, JobResult};
use long_draw::DrawThread;
pub use observer::{Event, FrameView, Observer, Occasion, PendingRows, PixelRuns};
pub(crate) use pieces::Pieces;
use quotas::Quotas;
pub use request::Request;
pub use status::{OutputState, OutputStatus, Status};
pub use steps::{Step, figure_steps};
pub use trace::figure_numbers;

/// Action that the caller must take after a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Effect {
    /// Nothing.
    Done,
    /// Close the connection once its replies are sent.
    Quit,
    /// Of `PRESENT wait` with a window: answer `FRAME n` when frame n is shown, and run nothing of
    /// this connection until then.
    WaitShown(u64),
    /// Of `WAIT`, where a window shows what was drawn: run nothing of this connection for this time.
    Pause(Duration),
}

/// Progress of a command after a part of it has run.
#[derive(Debug)]
#[must_use]
pub(crate) enum Progress {
    /// It has taken effect.
    Done(Effect),
    /// Its job must be run next: see [`crate::jobs`].
    Job(Job),
    /// A piece of it has run, and pieces are left.
    Pieces(Box<Pieces>),
    /// It is a draw that waits for others: see [`Engine::draw_queued`].
    Queued(Drawing),
}

/// Initial state of connections, in points on which clients of the protocol disagree and which the
/// server decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// Blend mode of a connection that has not sent `BLEND`.
    pub blend: Blend,
    /// True if `PX x y g` with one hex digit is the grey `gg`; otherwise it is refused with
    /// `ECOLOUR`.
    pub grey_digits: bool,
}

impl Default for Dialect {
    fn default() -> Self {
        Dialect { blend: Blend::Replace, grey_digits: false }
    }
}

/// State that all connections share: video memory, shared resources and totals.
#[derive(Debug)]
pub struct Engine {
    framebuffer: EngineFrame,
    rendering: Rendering,
    resources: Resources,
    /// Limits of the requests that run.
    pub quotas: Quotas,
    /// Totals of all connections.
    pub counters: Counters,
    dialect: Dialect,
    /// Set if the first command of a stream may be `SIZE w h`.
    takes_size: bool,
    observers: Vec<Box<dyn Observer>>,
    /// Set if an observer needs the events of every figure.
    has_followed_figures: bool,
    /// Areas of the running stream that wait for others; kept to be used again.
    pub(crate) areas: Vec<QueuedArea>,
    /// Outputs that `STATS` names without an observer.
    offered_outputs: Vec<OutputStatus>,
    is_in_pieces: bool,
    /// Set if the running command may be suspended.
    may_suspend: bool,
    /// Set if the running command may be left to the stream as a draw that waits for others.
    queues_draw: bool,
    /// Set while a request ends that met a defect.
    has_defect: bool,
    /// Verb of requests that meet a defect when they have run, for tests.
    #[cfg(debug_assertions)]
    #[doc(hidden)]
    pub wanted_defect: Option<&'static str>,
}

/// The renderer, and what the engine keeps between 3-D draws.
#[derive(Debug)]
struct Rendering {
    renderer: Renderer,
    /// What `QUALITY max-error` knows of meshes.
    shapes: MeshShapes,
    view_overrides: ViewOverrides,
    /// Turns of the eye in N-dimensional scenes, beyond their own.
    eye_turns: Arc<[Rotation]>,
    /// The thread of long draws, once one was needed.
    draw_thread: Option<DrawThread>,
    /// Times of the last draws.
    draw_times: DrawTimes,
    /// Summary of the last draw, in words without blanks.
    plan: String,
    tracing: Option<trace::Tracing>,
    explaining: Option<explain::Explaining>,
    /// The draws since the last `CLEAR`, if they are logged.
    draw_log: Option<DrawLog>,
    /// Verb of the draw that was abandoned, if one was.
    abandoned: Option<&'static str>,
}

/// Resources that all connections share, and the folders of files.
#[derive(Debug, Default)]
struct Resources {
    shared: ResourceTable,
    snap_dir: Option<Arc<QuotaDir>>,
    /// True if SNAP must not use the names of periodic snapshots.
    reserves_snapshot_names: bool,
    load_dir: Option<SandboxDir>,
    /// Keys of the fingerprints of files, for observers.
    file_hasher: FileHasher,
}

/// Counters of an engine.
#[derive(Debug, Default)]
pub struct Counters {
    /// Counters of all connections, up to the last slice of each.
    totals: Stats,
    connections: usize,
    /// Number of `PRESENT` commands so far.
    frames: u64,
    /// Numbers of sessions that freeze the display, and of those that listen to events.
    frozen: usize,
    listeners: usize,
    /// Number of connections closed because they were idle.
    pub idle_closes: u64,
    /// Number of connections refused because they spoke another protocol.
    pub foreign_refused: u64,
    /// Received bytes that have not run.
    pub queue_bytes: u64,
}

impl Engine {
    /// Creates an engine with a cleared frame of `width` x `height` pixels and the default limits.
    ///
    /// # Errors
    /// `ETOOBIG` for a frame that cannot be allocated or is over the limit.
    pub fn new(width: u32, height: u32) -> Result<Self, Fault> {
        Engine::with_limits(width, height, Limits::default())
    }

    /// Creates an engine with a cleared frame of `width` x `height` pixels and these limits.
    ///
    /// # Errors
    /// `ETOOBIG` for a frame that cannot be allocated, or is over `limits.frame_bytes`.
    pub fn with_limits(width: u32, height: u32, limits: Limits) -> Result<Self, Fault> {
        limits.check_frame(width, height)?;
        let quotas = Quotas::new(limits);
        let mut renderer = Renderer::default();
        renderer.set_budget(&quotas.budget);
        let mut shapes = MeshShapes::default();
        shapes.set_budget(&quotas.budget);
        Ok(Engine {
            framebuffer: EngineFrame::new(width, height, &quotas.budget, MemoryUse::Frame)?,
            rendering: Rendering {
                renderer,
                shapes,
                view_overrides: ViewOverrides::default(),
                eye_turns: Arc::default(),
                draw_thread: None,
                draw_times: DrawTimes::default(),
                plan: String::from("-"),
                tracing: None,
                explaining: None,
                draw_log: None,
                abandoned: None,
            },
            resources: Resources::default(),
            quotas,
            counters: Counters::default(),
            dialect: Dialect::default(),
            takes_size: false,
            observers: Vec::new(),
            has_followed_figures: false,
            areas: Vec::new(),
            offered_outputs: Vec::new(),
            is_in_pieces: false,
            may_suspend: false,
            queues_draw: false,
            has_defect: false,
            #[cfg(debug_assertions)]
            wanted_defect: None,
        })
    }

    /// Applies `view_overrides` to all later 3-D draws, whatever their commands say.
    pub fn set_view_overrides(&mut self, view_overrides: ViewOverrides) {
        self.rendering.view_overrides = view_overrides;
    }

    /// Turns the eye of all N-dimensional scenes that are made later, about the middle of their
    /// facets. Turns in planes that a scene does not have are left out.
    pub fn set_eye_turns(&mut self, turns: &[Rotation]) {
        self.rendering.eye_turns = turns.into();
    }

    /// Sets the renderer of 3-D draws. The default one uses the calling thread only.
    pub fn set_renderer(&mut self, mut renderer: Renderer) {
        renderer.set_budget(&self.quotas.budget);
        self.rendering.renderer = renderer;
    }

    /// Returns the budget for the memory of everything that commands create.
    pub fn memory_budget(&self) -> &MemoryBudget {
        &self.quotas.budget
    }

    /// Calls `reserve`; if there is no room, frees the caches and calls it once more.
    fn with_room<T>(
        &mut self,
        mut reserve: impl FnMut(&mut Engine) -> Result<T, OverBudget>,
    ) -> Result<T, Fault> {
        if let Ok(reserved) = reserve(self) {
            return Ok(reserved);
        }
        self.free_caches();
        Ok(reserve(self)?)
    }

    /// Frees buffers that only serve speed, and tables of meshes that are gone.
    fn free_caches(&mut self) {
        self.rendering.renderer.release();
        self.rendering.shapes.forget_gone();
        self.quotas.payload_pool.clear();
    }

    /// Sets the token that cancels the running draw and every later one, until another token is
    /// set.
    pub fn set_cancel(&mut self, cancel: CancelToken) {
        self.rendering.renderer.set_cancel(cancel);
    }

    /// Takes the verb of the command that was abandoned because the server ended, if one was. The
    /// memory may contain a part of its picture; the recording has nothing of it.
    pub fn take_abandoned(&mut self) -> Option<&'static str> {
        self.rendering.abandoned.take()
    }

    /// Notes that a command in pieces was abandoned because the server ends.
    pub(crate) fn note_abandoned(&mut self, verb: &'static str) {
        self.rendering.abandoned = Some(verb);
    }

    /// Sets whether a command is in pieces. Meanwhile pixels that others write are not taken in.
    pub fn set_in_pieces(&mut self, is_in_pieces: bool) {
        self.is_in_pieces = is_in_pieces;
    }

    /// Sets whether the next commands may be suspended: be left as a job, or in pieces.
    pub(crate) fn set_may_suspend(&mut self, may_suspend: bool) {
        (self.may_suspend, self.queues_draw) = (may_suspend, false);
    }

    /// Refuses a draw that was cancelled.
    pub(super) fn check_abandoned(&mut self, verb: &'static str) -> Result<(), Fault> {
        match self.rendering.renderer.options().cancel.is_cancelled() {
            false => Ok(()),
            true => {
                self.rendering.abandoned = Some(verb);
                Err(Fault::new(Code::Quota, "abandoned, because the server ends: a part of it may be drawn"))
            }
        }
    }

    /// Allows SNAP to write files into this folder, up to `limits.snap_bytes`.
    pub fn set_snap_dir(&mut self, folder: SandboxDir) {
        self.resources.snap_dir = Some(Arc::new(QuotaDir::new(folder, self.quotas.limits.snap_bytes)));
    }

    /// Refuses names of periodic snapshots to SNAP, which writes into the same folder.
    pub fn reserve_snapshot_names(&mut self) {
        self.resources.reserves_snapshot_names = true;
    }

    /// Allows LOAD to read files from this folder.
    pub fn set_load_dir(&mut self, folder: SandboxDir) {
        self.resources.load_dir = Some(folder);
    }

    /// Replaces the folder from which LOAD may read files, and returns the earlier one.
    pub fn replace_load_dir(&mut self, folder: Option<SandboxDir>) -> Option<SandboxDir> {
        std::mem::replace(&mut self.resources.load_dir, folder)
    }

    /// Counts a copy of the frame that exists as long as the server. It is not refused if memory is
    /// short, because whoever runs the server asked for it.
    pub fn count_frame_copy(&mut self) {
        self.framebuffer.count_copy();
    }

    /// Fills the frame, before any command has run.
    pub fn fill_frame(&mut self, color: Rgba) {
        self.framebuffer.memory.clear(color);
    }

    /// Returns the video memory.
    pub fn memory(&self) -> &VideoMemory {
        &self.framebuffer.memory
    }

    /// Returns the video memory, and ends the engine with its observers.
    pub fn into_memory(mut self) -> VideoMemory {
        self.end();
        self.observers.clear();
        std::mem::replace(&mut self.framebuffer.memory, VideoMemory::vacant())
    }

    /// Returns the video memory for writing, to the program that owns the engine. Observers are not
    /// told what it writes.
    pub fn memory_mut(&mut self) -> &mut VideoMemory {
        &mut self.framebuffer.memory
    }

    /// Returns the depth buffer, if any draw has needed one.
    pub fn depth(&self) -> Option<&DepthMemory> {
        self.framebuffer.depth.as_ref()
    }

    /// Returns the quotas.
    pub fn limits(&self) -> &Limits {
        &self.quotas.limits
    }

    /// Sets the initial state of later connections.
    pub fn set_dialect(&mut self, dialect: Dialect) {
        self.dialect = dialect;
    }

    /// Lets the first command of a stream be `SIZE w h`. It changes nothing: the caller has made the
    /// frame as large as the stream says, or as was asked for instead.
    pub fn take_size(&mut self) {
        self.takes_size = true;
    }

    /// Returns the initial state of connections.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Returns the number of `PRESENT` commands so far.
    pub fn frames(&self) -> u64 {
        self.counters.frames
    }

    /// Returns the counters of all connections, as far as [`Engine::count`] has added them.
    pub fn totals(&self) -> Stats {
        self.counters.totals
    }

    /// Begins the connection `id`.
    pub fn open(&mut self, id: u64) {
        self.counters.connections += 1;
        self.send(&Event::Opened { connection: id, blend: self.dialect.blend });
    }

    /// Ends a connection: it freezes no display and listens to no events any more, and its counters
    /// are added to the totals.
    pub fn close(&mut self, session: &mut Session) {
        self.counters.connections = self.counters.connections.saturating_sub(1);
        self.set_auto(session, true);
        self.set_events(session, false);
        self.count(session);
        self.send(&Event::Closed { connection: session.id });
    }

    /// Adds the counters of `session` since the last call to the totals.
    pub fn count(&mut self, session: &mut Session) {
        self.counters.totals += session.stats - session.counted;
        session.counted = session.stats;
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.end();
    }
}

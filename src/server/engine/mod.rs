//! The engine: runs commands on the video memory, one by one, on the thread that calls it.
//!
//! In: a [`Command`] and the [`Session`] of the connection that it came from. Out: changed memory,
//! reply bytes, or a [`Fault`] that says why nothing changed. It owns everything that connections
//! share: video memory, depth buffer, the pick buffer, resources whose names begin with `@`, the
//! frame count, the totals. It starts no thread, and without a display, a shared file or a folder
//! it does no I/O. The caller decides the order: a command has taken effect before the next one
//! runs.
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

mod dispatch;
mod draw2d;
mod draw3d;
mod drawing;
mod empty_draw;
mod files;
mod job;
mod long_draw;
mod pieces;
mod quality;
mod queries;
mod resources;
mod scene_request;
mod shm;
mod trace;

use super::metrics::{MetricsBoard, VerbCounts};
use super::record::{FailedRecording, ReadFile, Recorder};
use super::resources::ResourceTable;
use super::{Display, Limits, Session, Stats};
use crate::cancel::CancelToken;
use crate::command::{Command, PayloadPool};
use crate::draw2d::Blend;
use crate::error::{Code, Fault};
use crate::load::{QuotaDir, SandboxDir};
use crate::memory::{
    DepthFormat, DepthMemory, MemoryBudget, MemoryUse, OverBudget, PickBuffer, Reservation, Rgba, VideoMemory,
};
use crate::pipeline::Renderer;
use crate::pipeline::quality::ChoiceCache;
use crate::scene::ViewOverrides;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

pub(in crate::server) use files::FileReader;
pub(in crate::server) use job::{Job, JobResult};
use long_draw::DrawThread;
pub(in crate::server) use pieces::Pieces;

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
}

/// Progress of a command after a part of it has run.
#[derive(Debug)]
#[must_use]
pub(in crate::server) enum Progress {
    /// It has taken effect.
    Done(Effect),
    /// Its job must be run next: see [`crate::server::jobs`].
    Job(Job),
    /// A piece of it has run, and pieces are left.
    Pieces(Box<Pieces>),
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

/// State that all connections share: video memory, shared resources, display, recording and totals.
#[derive(Debug)]
pub struct Engine {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    depth_format: DepthFormat,
    ids: Option<PickBuffer>,
    renderer: Renderer,
    /// Cached choices of `QUALITY max-error`.
    budgets: ChoiceCache,
    view_overrides: ViewOverrides,
    /// Names of the pick buffer's numbers.
    id_names: IdNames,
    shared: ResourceTable,
    limits: Limits,
    /// The memory budget, and the engine's own reservations from it.
    budget: MemoryBudget,
    held: Held,
    dialect: Dialect,
    /// Numbers of connections closed because they were idle, and refused because they spoke another
    /// protocol.
    idle_closes: u64,
    foreign_refused: u64,
    metrics: Option<Arc<MetricsBoard>>,
    verb_counts: VerbCounts,
    snap_dir: Option<Arc<QuotaDir>>,
    /// True if SNAP must not use the names of periodic snapshots.
    reserves_snapshot_names: bool,
    load_dir: Option<SandboxDir>,
    display: Option<Arc<Display>>,
    /// Rows that changed since the display was last updated.
    unshown: Range<u32>,
    /// Number of `PRESENT` commands so far.
    frames: u64,
    /// Counters of all connections, up to the last slice of each.
    totals: Stats,
    connections: usize,
    /// Numbers of sessions that freeze the display, and of those that listen to events.
    frozen: usize,
    listeners: usize,
    /// Received bytes that have not run, as the render thread has reported.
    queue_bytes: u64,
    /// Summary of the last 3-D draw, in words without blanks.
    plan: String,
    tracing: Option<trace::Tracing>,
    shared_file: Option<shm::Shared>,
    /// Reason why sharing of the file ended, and the function to call at the end.
    shared_failure: Option<String>,
    on_shared_failure: shm::OnSharedFailure,
    recorder: Option<Recorder>,
    on_present: OnPresent,
    /// The recording that ended early, if one did.
    record_failure: Option<FailedRecording>,
    /// Files that the running command has read, for the recording.
    files_read: Vec<ReadFile>,
    /// Verb of the draw that was abandoned, if one was.
    abandoned: Option<&'static str>,
    is_in_pieces: bool,
    /// Set if the running command may be suspended.
    may_suspend: bool,
    /// The thread of long draws, once one was needed.
    draw_thread: Option<DrawThread>,
    /// Pool of large payloads' buffers, which the decoders of all connections share.
    payload_pool: PayloadPool,
    payload_pool_swept: Instant,
}

/// The engine's own reservations from the memory budget.
#[derive(Debug)]
struct Held {
    frame: Reservation,
    depth: Reservation,
    ids: Reservation,
    /// Names of the pick buffer's numbers.
    names: Reservation,
    reply: Reservation,
    /// Received bytes that have not run.
    queue: Reservation,
    /// Recorded commands that have not been written to their file.
    records: Reservation,
}

/// Reply bytes that are always allowed for a connection that reads its replies.
const REPLY_BYTES: usize = 16 << 10;
/// Smallest change of the queued bytes that is reserved, in bytes.
const QUEUE_STEP: u64 = 64 << 10;

impl Held {
    fn new(budget: &MemoryBudget) -> Self {
        let frame = || budget.empty(MemoryUse::Frame);
        Held {
            frame: frame(),
            depth: frame(),
            ids: frame(),
            names: budget.empty(MemoryUse::Resources),
            reply: budget.empty(MemoryUse::Replies),
            queue: budget.empty(MemoryUse::Payloads),
            records: budget.empty(MemoryUse::Records),
        }
    }
}

/// The function to call at every `PRESENT`.
struct OnPresent(Option<PresentAction>);

type PresentAction = Box<dyn FnMut(&VideoMemory) + Send>;

impl std::fmt::Debug for OnPresent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "OnPresent({})", self.0.is_some())
    }
}

/// Names of the objects whose numbers are in the pick buffer.
#[derive(Debug, Default)]
struct IdNames {
    names: Vec<Arc<str>>,
    numbers: HashMap<Arc<str>, u32>,
    /// Bytes of memory that they take.
    bytes: u64,
    /// Number of the first object of the last drawn scene.
    last_scene: u32,
}

/// Time for which an unused payload buffer is kept for the next large payload.
const HOLD_PAYLOADS: Duration = Duration::from_secs(1);

impl Engine {
    /// Returns the pool of payload buffers, which all decoders share.
    pub(crate) fn payload_pool(&self) -> &PayloadPool {
        &self.payload_pool
    }

    /// Frees payload buffers that have not been used for a second. Returns the time of the next
    /// sweep, if one is needed.
    pub(crate) fn sweep_payload_pool(&mut self, now: Instant) -> Option<Instant> {
        if now >= self.payload_pool_swept + HOLD_PAYLOADS {
            self.payload_pool.sweep();
            self.payload_pool_swept = now;
        }
        (self.payload_pool.held_bytes() > 0).then(|| self.payload_pool_swept + HOLD_PAYLOADS)
    }

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
        let budget = MemoryBudget::new(limits.memory_bytes);
        let mut held = Held::new(&budget);
        held.frame.try_grow(u64::from(width) * u64::from(height) * 4)?;
        let mut renderer = Renderer::default();
        renderer.set_budget(&budget);
        let memory = VideoMemory::new(width, height).map_err(|e| Fault::new(e.code(), e.to_string()))?;
        Ok(Engine {
            memory,
            depth: None,
            depth_format: DepthFormat::default(),
            ids: None,
            renderer,
            budgets: ChoiceCache::default(),
            view_overrides: ViewOverrides::default(),
            id_names: IdNames::default(),
            shared: ResourceTable::default(),
            limits,
            held,
            dialect: Dialect::default(),
            idle_closes: 0,
            foreign_refused: 0,
            metrics: None,
            verb_counts: VerbCounts::default(),
            snap_dir: None,
            reserves_snapshot_names: false,
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
            shared_failure: None,
            on_shared_failure: shm::OnSharedFailure::default(),
            recorder: None,
            on_present: OnPresent(None),
            record_failure: None,
            files_read: Vec::new(),
            abandoned: None,
            is_in_pieces: false,
            may_suspend: false,
            draw_thread: None,
            payload_pool: PayloadPool::within(&budget),
            payload_pool_swept: Instant::now(),
            budget,
        })
    }

    /// Sets the function to call with the frame at every `PRESENT`, before any later command runs.
    pub fn set_on_present(&mut self, action: impl FnMut(&VideoMemory) + Send + 'static) {
        self.on_present = OnPresent(Some(Box::new(action)));
    }

    /// Applies `view_overrides` to all later 3-D draws, whatever their commands say.
    pub fn set_view_overrides(&mut self, view_overrides: ViewOverrides) {
        self.view_overrides = view_overrides;
    }

    /// Sets the renderer of 3-D draws. The default one uses the calling thread only.
    pub fn set_renderer(&mut self, mut renderer: Renderer) {
        renderer.set_budget(&self.budget);
        self.renderer = renderer;
    }

    /// Returns the budget for the memory of everything that commands create.
    pub fn memory_budget(&self) -> &MemoryBudget {
        &self.budget
    }

    /// Returns the number of reply bytes that a connection with `unread` unread bytes may be given.
    /// If memory is short, only connections wait whose clients do not read.
    pub(in crate::server) fn reply_room(&self, unread: usize) -> usize {
        let part = usize::try_from(self.budget.available() / 4).unwrap_or(usize::MAX);
        match unread {
            0 => part.max(REPLY_BYTES),
            _ => part,
        }
    }

    /// Reserves memory for the `bytes` of received commands that have not run.
    pub(in crate::server) fn count_queue(&mut self, bytes: u64) {
        // Changes of less than [`QUEUE_STEP`] are not worth a reservation.
        if self.held.queue.bytes().abs_diff(bytes) >= QUEUE_STEP || bytes == 0 {
            self.held.queue.set(bytes);
        }
    }

    /// Calls `reserve`; if there is no room, frees the caches and calls it once more.
    fn with_room<T>(
        &mut self,
        mut reserve: impl FnMut(&mut Engine) -> Result<T, OverBudget>,
    ) -> Result<T, Fault> {
        if let Ok(reserved) = reserve(self) {
            return Ok(reserved);
        }
        self.renderer.release();
        self.payload_pool.clear();
        Ok(reserve(self)?)
    }

    /// Sets the token that cancels the running draw and every later one, until another token is
    /// set.
    pub fn set_cancel(&mut self, cancel: CancelToken) {
        self.renderer.set_cancel(cancel);
    }

    /// Takes the verb of the command that was abandoned because the server ended, if one was. The
    /// memory may contain a part of its picture; the recording has nothing of it.
    pub fn take_abandoned(&mut self) -> Option<&'static str> {
        self.abandoned.take()
    }

    /// Notes that a command in pieces was abandoned because the server ends.
    pub(in crate::server) fn note_abandoned(&mut self, verb: &'static str) {
        self.abandoned = Some(verb);
    }

    /// Sets whether a command is in pieces. Meanwhile foreign writes to the shared file are not
    /// taken in.
    pub(in crate::server) fn set_in_pieces(&mut self, is_in_pieces: bool) {
        self.is_in_pieces = is_in_pieces;
    }

    /// Sets whether the next commands may be suspended: be left as a job, or in pieces.
    pub(in crate::server) fn set_may_suspend(&mut self, may_suspend: bool) {
        self.may_suspend = may_suspend;
    }

    /// Refuses a draw that was cancelled.
    pub(super) fn check_abandoned(&mut self, verb: &'static str) -> Result<(), Fault> {
        match self.renderer.options().cancel.is_cancelled() {
            false => Ok(()),
            true => {
                self.abandoned = Some(verb);
                Err(Fault::new(Code::Quota, "abandoned, because the server ends: a part of it may be drawn"))
            }
        }
    }

    /// Allows SNAP to write files into this folder, up to `limits.snap_bytes`.
    pub fn set_snap_dir(&mut self, folder: SandboxDir) {
        self.snap_dir = Some(Arc::new(QuotaDir::new(folder, self.limits.snap_bytes)));
    }

    /// Refuses names of periodic snapshots to SNAP, which writes into the same folder.
    pub fn reserve_snapshot_names(&mut self) {
        self.reserves_snapshot_names = true;
    }

    /// Allows LOAD to read files from this folder.
    pub fn set_load_dir(&mut self, folder: SandboxDir) {
        self.load_dir = Some(folder);
    }

    /// Shows the memory on `display`, which must have the frame's size.
    pub fn set_display(&mut self, display: Arc<Display>) {
        assert_eq!((display.width(), display.height()), (self.memory.width(), self.memory.height()));
        display.set_listeners(self.listeners);
        self.count_frame_copy();
        self.display = Some(display);
    }

    /// Counts a copy of the frame that exists as long as the server. It is not refused if memory is
    /// short, because whoever runs the server asked for it.
    pub(in crate::server) fn count_frame_copy(&mut self) {
        self.held.frame.set(self.held.frame.bytes() + self.memory.bytes().len() as u64);
    }

    /// Fills the frame, before any command has run.
    pub fn fill_frame(&mut self, color: Rgba) {
        self.memory.clear(color);
    }

    /// Returns the video memory.
    pub fn memory(&self) -> &VideoMemory {
        &self.memory
    }

    /// Returns the depth buffer, if any draw has needed one.
    pub fn depth(&self) -> Option<&DepthMemory> {
        self.depth.as_ref()
    }

    /// Returns the quotas.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Sets the initial state of later connections.
    pub fn set_dialect(&mut self, dialect: Dialect) {
        self.dialect = dialect;
    }

    /// Returns the initial state of connections.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Counts a connection that was closed for being idle.
    pub(super) fn note_idle_close(&mut self) {
        self.idle_closes += 1;
    }

    /// Counts a connection that was refused for speaking another protocol.
    pub(super) fn note_foreign(&mut self) {
        self.foreign_refused += 1;
    }

    /// Returns the number of `PRESENT` commands so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the counters of all connections, as far as [`Engine::count`] has added them.
    pub fn totals(&self) -> Stats {
        self.totals
    }

    /// Begins the connection `id`. A blend mode that it has by default is recorded as a command,
    /// because a player's connections begin as the specification says.
    pub fn open(&mut self, id: u64) {
        self.connections += 1;
        if let Some(recorder) = &mut self.recorder
            && self.dialect.blend == Blend::Over
        {
            recorder.command(id, &Command::Blend { over: true });
        }
    }

    /// Ends a connection: its requests to the display end, and its counters are added to the
    /// totals.
    pub fn close(&mut self, session: &mut Session) {
        self.connections = self.connections.saturating_sub(1);
        self.set_auto(session, true);
        self.set_events(session, false);
        self.count(session);
        if let Some(recorder) = &mut self.recorder {
            recorder.end(session.id);
        }
    }

    /// Adds the counters of `session` since the last call to the totals.
    pub fn count(&mut self, session: &mut Session) {
        self.totals += session.stats - session.counted;
        session.counted = session.stats;
    }
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.end();
    }
}

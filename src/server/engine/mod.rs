//! THE ENGINE: runs commands on the video memory, one by one, on whatever thread calls it.
//!
//! In: a [`Command`] and the [`Session`] of the connection that it came from.
//! Out: changed memory, reply bytes, or a [`Fault`] that says why nothing changed. It owns what all
//! connections share: video memory, depth, the face ids of PICK, names that begin with `@`, the
//! count of frames, the totals. It starts no thread, and without a display, a shared file or a
//! folder it does no I/O. Order is the caller's: what runs first has taken effect for what runs
//! next.
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
mod empty_draw;
mod files;
mod pieces;
mod quality;
mod queries;
mod resources;
mod shm;
mod trace;

use super::jobs::Job;
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
pub(in crate::server) use pieces::Pieces;

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

/// How far a command has come.
#[derive(Debug)]
#[must_use]
pub(in crate::server) enum Progress {
    /// It has taken effect.
    Done(Effect),
    /// Its job comes next: see [`crate::server::jobs`].
    Job(Job),
    /// A piece of it has run.
    Pieces(Box<Pieces>),
}

/// How connections begin: readings of the language that its clients do not agree on, and a server chooses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Dialect {
    /// What a connection that has not said `BLEND` does.
    pub blend: Blend,
    /// Whether `PX x y g` with one hex digit is the grey `gg`; otherwise it is `ECOLOUR`.
    pub grey_digits: bool,
}

impl Default for Dialect {
    fn default() -> Self {
        Dialect { blend: Blend::Replace, grey_digits: false }
    }
}

/// See the module's text.
#[derive(Debug)]
pub struct Engine {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    depth_format: DepthFormat,
    ids: Option<PickBuffer>,
    renderer: Renderer,
    /// What QUALITY chose for which state.
    budgets: ChoiceCache,
    view_overrides: ViewOverrides,
    /// The names that ids stand for.
    id_names: IdNames,
    shared: ResourceTable,
    limits: Limits,
    /// Bounds all of it, and what of it the frame, depths and ids hold, and a reply that is being made.
    budget: MemoryBudget,
    held: Held,
    dialect: Dialect,
    /// Connections closed because they were idle, and those that spoke another protocol.
    idle_closes: u64,
    foreign_refused: u64,
    metrics: Option<Arc<MetricsBoard>>,
    verb_counts: VerbCounts,
    snap_dir: Option<Arc<QuotaDir>>,
    /// Names of periodic snapshots are the server's own.
    reserves_snapshot_names: bool,
    load_dir: Option<SandboxDir>,
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
    shared_file: Option<shm::Shared>,
    /// Why the shared file is shared no more, and who is told.
    shared_failure: Option<String>,
    on_shared_failure: shm::OnSharedFailure,
    recorder: Option<Recorder>,
    on_present: OnPresent,
    /// The recording that ended early.
    record_failure: Option<FailedRecording>,
    /// The files that the command being run has read, for the recording.
    files_read: Vec<ReadFile>,
    /// The verb of the draw that was abandoned, if one was.
    abandoned: Option<&'static str>,
    is_in_pieces: bool,
    /// Where the decoders of all connections put large payloads' buffers.
    payload_pool: PayloadPool,
    payload_pool_swept: Instant,
}

/// What the engine itself holds of the budget.
#[derive(Debug)]
struct Held {
    frame: Reservation,
    depth: Reservation,
    ids: Reservation,
    /// The names that ids stand for.
    names: Reservation,
    reply: Reservation,
    /// Received bytes that wait to be run.
    queue: Reservation,
    /// Recorded commands that are not in their file yet.
    records: Reservation,
}

/// Replies of so many bytes a connection may always be given that reads what it is sent.
const REPLY_BYTES: usize = 16 << 10;
/// The bytes that wait to be run are told in steps.
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

/// What is told of every `PRESENT`.
struct OnPresent(Option<PresentAction>);

type PresentAction = Box<dyn FnMut(&VideoMemory) + Send>;

impl std::fmt::Debug for OnPresent {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "OnPresent({})", self.0.is_some())
    }
}

/// Names that the pick buffer's numbers stand for.
#[derive(Debug, Default)]
struct IdNames {
    names: Vec<Arc<str>>,
    numbers: HashMap<Arc<str>, u32>,
    /// Bytes that they take.
    bytes: u64,
    /// Where the names of the objects of the last scene drawn begin.
    last_scene: u32,
}

/// How long an unused buffer of a large payload is held for the next one.
const HOLD_PAYLOADS: Duration = Duration::from_secs(1);

impl Engine {
    /// The buffer that decoders share.
    pub(crate) fn payload_pool(&self) -> &PayloadPool {
        &self.payload_pool
    }

    /// Gives back the shared buffer when nobody has used it for a while. Answers when to look again, if at all.
    pub(crate) fn sweep_payload_pool(&mut self, now: Instant) -> Option<Instant> {
        if now >= self.payload_pool_swept + HOLD_PAYLOADS {
            self.payload_pool.sweep();
            self.payload_pool_swept = now;
        }
        (self.payload_pool.held_bytes() > 0).then(|| self.payload_pool_swept + HOLD_PAYLOADS)
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
            payload_pool: PayloadPool::within(&budget),
            payload_pool_swept: Instant::now(),
            budget,
        })
    }

    /// Calls `action` with the frame at every `PRESENT` from now on, before anything else is run.
    pub fn set_on_present(&mut self, action: impl FnMut(&VideoMemory) + Send + 'static) {
        self.on_present = OnPresent(Some(Box::new(action)));
    }

    /// Sees what is drawn in three dimensions through `view_overrides` from now on, whatever its author says.
    pub fn set_view_overrides(&mut self, view_overrides: ViewOverrides) {
        self.view_overrides = view_overrides;
    }

    /// Draws in three dimensions with `renderer` from now on; until then, with the calling thread alone.
    pub fn set_renderer(&mut self, mut renderer: Renderer) {
        renderer.set_budget(&self.budget);
        self.renderer = renderer;
    }

    /// What bounds the memory of everything that commands ask for.
    pub fn memory_budget(&self) -> &MemoryBudget {
        &self.budget
    }

    /// Bytes of replies that a connection may be given now, of whose replies so many are unread: where memory is short those
    /// wait whose client does not read, and no others.
    pub(in crate::server) fn reply_room(&self, unread: usize) -> usize {
        let part = usize::try_from(self.budget.available() / 4).unwrap_or(usize::MAX);
        match unread {
            0 => part.max(REPLY_BYTES),
            _ => part,
        }
    }

    /// States how many received bytes wait to be run.
    pub(in crate::server) fn count_queue(&mut self, bytes: u64) {
        // A few bytes more or less are not worth telling.
        if self.held.queue.bytes().abs_diff(bytes) >= QUEUE_STEP || bytes == 0 {
            self.held.queue.set(bytes);
        }
    }

    /// Does `reserve`; where there is no room, once more when what is kept for speed alone was given back.
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

    /// Ends the draw that is made when `cancel` is cancelled, and every later one, until another token is given.
    pub fn set_cancel(&mut self, cancel: CancelToken) {
        self.renderer.set_cancel(cancel);
    }

    /// The verb of the command that was abandoned because the server had to end, if one was: the memory may hold a part
    /// of its picture, the recording has nothing of it.
    pub fn take_abandoned(&mut self) -> Option<&'static str> {
        self.abandoned.take()
    }

    /// A command was abandoned in the middle because the server has to end.
    pub(in crate::server) fn note_abandoned(&mut self, verb: &'static str) {
        self.abandoned = Some(verb);
    }

    /// While a command is in pieces, what others write into the shared file waits.
    pub(in crate::server) fn set_in_pieces(&mut self, is_in_pieces: bool) {
        self.is_in_pieces = is_in_pieces;
    }

    /// Refuses a draw that was abandoned.
    pub(super) fn check_abandoned(&mut self, verb: &'static str) -> Result<(), Fault> {
        match self.renderer.options().cancel.is_cancelled() {
            false => Ok(()),
            true => {
                self.abandoned = Some(verb);
                Err(Fault::new(Code::Quota, "abandoned, because the server ends: a part of it may be drawn"))
            }
        }
    }

    /// Lets SNAP write files, in this folder only, up to `limits.snap_bytes` of them.
    pub fn set_snap_dir(&mut self, folder: SandboxDir) {
        self.snap_dir = Some(Arc::new(QuotaDir::new(folder, self.limits.snap_bytes)));
    }

    /// Keeps SNAP from the names of periodic snapshots in the same folder.
    pub fn reserve_snapshot_names(&mut self) {
        self.reserves_snapshot_names = true;
    }

    /// Lets LOAD read files, from this folder only.
    pub fn set_load_dir(&mut self, folder: SandboxDir) {
        self.load_dir = Some(folder);
    }

    /// Shows the memory on `display` from now on; it must have the frame's size.
    pub fn set_display(&mut self, display: Arc<Display>) {
        assert_eq!((display.width(), display.height()), (self.memory.width(), self.memory.height()));
        display.set_listeners(self.listeners);
        self.count_frame_copy();
        self.display = Some(display);
    }

    /// Counts a copy of the frame that is there as long as the server: whoever runs it asked for it, so it is not refused.
    pub(in crate::server) fn count_frame_copy(&mut self) {
        self.held.frame.set(self.held.frame.bytes() + self.memory.bytes().len() as u64);
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

    /// Begins connections so from now on.
    pub fn set_dialect(&mut self, dialect: Dialect) {
        self.dialect = dialect;
    }

    /// How connections begin.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Counts a connection closed for being idle.
    pub(super) fn note_idle_close(&mut self) {
        self.idle_closes += 1;
    }

    /// Counts a connection refused for speaking another protocol.
    pub(super) fn note_foreign(&mut self) {
        self.foreign_refused += 1;
    }

    /// Presents so far.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// What all connections did, as far as they were counted ([`Engine::count`]).
    pub fn totals(&self) -> Stats {
        self.totals
    }

    /// The connection `id` begins. A blend that it has not asked for is recorded as if it had: a player's connections
    /// begin as the specification says.
    pub fn open(&mut self, id: u64) {
        self.connections += 1;
        if let Some(recorder) = &mut self.recorder
            && self.dialect.blend == Blend::Over
        {
            recorder.command(id, &Command::Blend { over: true });
        }
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
}

impl Drop for Engine {
    fn drop(&mut self) {
        self.end();
    }
}

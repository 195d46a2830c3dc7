//! Long draws: a thread of their own draws them, and takes turns with the render thread.
//!
//! In: a [`Drawing`] that may take more than some milliseconds, and the time of the render thread's
//! slices. Out: the same bytes, depths, ids and statistics as if it were drawn at once.
//!
//! The frame, its depths and ids belong to one of the two threads at a time. The render thread lends
//! them for [`LOAN`] and waits; the draw hands them back at its next preemption point. Stages of the
//! draw that do not need them run beside the render thread, which then lends nothing and looks after
//! the draw once per slice.
//!
//! Promises:
//! - Whenever the render thread does something else, the engine has its frame, depths and ids; so
//!   what [`super::pieces`] says of commands in pieces holds for draws, too.
//! - The draw's renderer comes back at its end, however it ends. A draw that is given up, or
//!   abandoned because its connection or the server ends, is cancelled, and lent the frame once
//!   more; it then ends within the time of one unit of work.
//! - There is at most one long draw at a time, as there is one command in pieces.
//!
//! Verified by `tests/serving/preemption.rs`: others' replies before the draw's end, and the
//! bytes of draws with and without interruption, live and replayed.

use super::Engine;
use super::dispatch::guard;
use super::drawing::Drawing;
use crate::Session;
use crate::workers::DRAW_STACK_BYTES;
use crossbeam_channel::{Receiver, RecvTimeoutError, Sender, bounded, unbounded};
use fbptr_core::cancel::CancelToken;
use fbptr_core::error::Fault;
use fbptr_core::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use fbptr_core::pipeline::{DrawStats, PipelineError, Preemption, Renderer, Target, TargetOwner};
use fbptr_core::scene::HiddenSurface;
use std::fmt;
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Time for which the frame is lent: others wait for it and one unit of work, and handing the frame
/// over twice is less than a hundredth of it.
const LOAN: Duration = Duration::from_millis(4);

/// The memories that a draw writes.
struct Frame {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    ids: PickBuffer,
}

impl Frame {
    /// Creates memories without pixels, in the place of those that are lent.
    fn vacant() -> Self {
        Frame { memory: VideoMemory::vacant(), depth: None, ids: PickBuffer::new(0, 0) }
    }

    fn swap_with(&mut self, target: &mut Target) {
        std::mem::swap(&mut self.memory, target.memory);
        std::mem::swap(&mut self.depth, target.depth);
        if let Some(ids) = target.ids.as_deref_mut() {
            std::mem::swap(&mut self.ids, ids);
        }
    }
}

/// The frame, lent until a time.
struct Loan {
    frame: Box<Frame>,
    until: Instant,
}

/// A draw on its way to the drawing thread.
struct Task {
    drawing: Drawing,
    renderer: Renderer,
    depth_format: DepthFormat,
    loans: Receiver<Loan>,
    events: Sender<Event>,
}

/// Message of the drawing thread.
enum Event {
    /// The draw needs the frame.
    Wants,
    /// The draw hands the frame back.
    Returned(Box<Frame>),
    /// The draw is over.
    Ended(Box<Ended>),
}

/// End of a draw.
struct Ended {
    drawing: Drawing,
    renderer: Renderer,
    /// The frame, if it was lent.
    frame: Frame,
    /// `None` if the draw met a defect.
    result: Option<Result<DrawStats, PipelineError>>,
    /// Time of the draw, without that for which it waited for the frame.
    took: Duration,
}

/// The drawing thread, which ends when this is dropped.
#[derive(Debug)]
pub(super) struct DrawThread {
    tasks: Sender<Task>,
    /// Cancels its draws. Facts about geometries keep it, so it is the same for all draws until one
    /// is cancelled.
    cancel: CancelToken,
}

impl DrawThread {
    fn start() -> std::io::Result<Self> {
        let (tasks, received) = unbounded::<Task>();
        std::thread::Builder::new()
            .name("fbptr-draw".into())
            .stack_size(DRAW_STACK_BYTES)
            .spawn(move || received.into_iter().for_each(Task::run))?;
        Ok(DrawThread { tasks, cancel: CancelToken::new() })
    }
}

impl Task {
    /// Draws, and hands everything back.
    fn run(self) {
        let Task { drawing, mut renderer, depth_format, loans, events } = self;
        let borrower = Arc::new(Borrower {
            loans,
            events: events.clone(),
            begun: Instant::now(),
            due_ns: AtomicU64::new(0),
            waited_ns: AtomicU64::new(0),
        });
        renderer.set_preemption(Preemption::by(borrower.clone()));
        let mut frame = Frame::vacant();
        let draw = || {
            let Frame { memory, depth, ids } = &mut frame;
            let mut target = Target { memory, depth, depth_format, ids: Some(ids) };
            borrower.acquire(&mut target);
            drawing.run(&mut renderer, &mut target)
        };
        let result = guard(draw);
        renderer.set_preemption(Preemption::default());
        let waited = Duration::from_nanos(borrower.waited_ns.load(Relaxed));
        let took = borrower.begun.elapsed().saturating_sub(waited);
        // If the render thread has gone, nobody needs the result.
        let _ = events.send(Event::Ended(Box::new(Ended { drawing, renderer, frame, result, took })));
    }
}

/// The drawing thread's side of the loans.
struct Borrower {
    loans: Receiver<Loan>,
    events: Sender<Event>,
    begun: Instant,
    /// End of the loan, in nanoseconds since `begun`.
    due_ns: AtomicU64,
    /// Nanoseconds for which the draw waited for the frame.
    waited_ns: AtomicU64,
}

impl TargetOwner for Borrower {
    fn is_due(&self) -> bool {
        self.begun.elapsed().as_nanos() as u64 >= self.due_ns.load(Relaxed)
    }

    fn release(&self, target: &mut Target) {
        let mut frame = Box::new(Frame::vacant());
        frame.swap_with(target);
        let _ = self.events.send(Event::Returned(frame));
    }

    fn acquire(&self, target: &mut Target) {
        let waits = Instant::now();
        let _ = self.events.send(Event::Wants);
        let Ok(Loan { mut frame, until }) = self.loans.recv() else {
            // The render thread has gone. This ends the draw without a message.
            resume_unwind(Box::new("nobody needs this draw"));
        };
        self.waited_ns.fetch_add(waits.elapsed().as_nanos() as u64, Relaxed);
        let time = until.saturating_duration_since(self.begun);
        self.due_ns.store(time.as_nanos() as u64, Relaxed);
        frame.swap_with(target);
    }
}

/// The render thread's handle on a long draw.
pub(super) struct LongDraw {
    verb: &'static str,
    /// Set if the draw tests and writes depths.
    pub has_depth: bool,
    loans: Sender<Loan>,
    events: Receiver<Event>,
    /// Set while the draw waits for the frame.
    is_waiting: bool,
}

impl fmt::Debug for LongDraw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "LongDraw({})", self.verb)
    }
}

impl Engine {
    /// Hands a draw to the drawing thread, which begins when the frame is lent.
    ///
    /// # Errors
    /// Returns the draw if the system has no thread to give.
    pub(super) fn begin_long_draw(&mut self, drawing: Drawing) -> Result<LongDraw, Drawing> {
        let thread = match self.rendering.draw_thread.take().map_or_else(DrawThread::start, Ok) {
            Ok(thread) => self.rendering.draw_thread.insert(thread),
            Err(_) => return Err(drawing),
        };
        let options = self.rendering.renderer.options().clone();
        let mut renderer = std::mem::replace(&mut self.rendering.renderer, Renderer::new(options));
        renderer.set_cancel(thread.cancel.clone());
        let ((loans, lent), (sent, events)) = (bounded(1), unbounded());
        let has_depth = drawing.hide() == HiddenSurface::ZBuffer;
        let draw = LongDraw { verb: drawing.verb(), has_depth, loans, events, is_waiting: false };
        let task = Task {
            drawing,
            renderer,
            depth_format: self.framebuffer.depth_format,
            loans: lent,
            events: sent,
        };
        match thread.tasks.send(task) {
            Ok(()) => Ok(draw),
            Err(refused) => {
                // The thread has ended, which only a defect does.
                self.rendering.draw_thread = None;
                let Task { drawing, renderer, .. } = refused.into_inner();
                self.take_back(renderer);
                Err(drawing)
            }
        }
    }

    /// Lends the frame to a draw for a time; if the draw does not need it, waits for its next
    /// message until `until` at the latest. Returns whether the draw is complete.
    ///
    /// # Errors
    /// The reason for which the draw was refused.
    pub(super) fn run_long_draw(
        &mut self,
        s: &mut Session,
        draw: &mut LongDraw,
        until: Option<Instant>,
    ) -> Result<bool, Fault> {
        if !draw.is_waiting {
            let event = match until {
                Some(until) => draw.events.recv_deadline(until).map_err(|e| e == RecvTimeoutError::Timeout),
                None => draw.events.recv().map_err(|_| false),
            };
            match event {
                Ok(Event::Ended(ended)) => return self.end_long_draw(s, *ended),
                Ok(_) => draw.is_waiting = true,
                Err(true) => return Ok(false),
                Err(false) => return Err(self.note_defect()),
            }
        }
        match self.lend(draw, LOAN)? {
            Some(ended) => self.end_long_draw(s, *ended),
            None => Ok(false),
        }
    }

    /// Lends the frame, and waits until it is handed back. Returns the end of the draw if it is
    /// over.
    fn lend(&mut self, draw: &mut LongDraw, time: Duration) -> Result<Option<Box<Ended>>, Fault> {
        draw.is_waiting = false;
        let (width, height) = (self.framebuffer.width(), self.framebuffer.height());
        let mut frame = Box::new(Frame::vacant());
        frame.swap_with(&mut self.framebuffer.target());
        let lent = draw.loans.send(Loan { frame, until: Instant::now() + time });
        match lent.map_err(|e| e.into_inner().frame).map(|()| draw.events.recv()) {
            Ok(Ok(Event::Returned(mut frame))) => {
                frame.swap_with(&mut self.framebuffer.target());
                Ok(None)
            }
            Ok(Ok(Event::Ended(mut ended))) => {
                ended.frame.swap_with(&mut self.framebuffer.target());
                Ok(Some(ended))
            }
            Err(mut frame) => {
                frame.swap_with(&mut self.framebuffer.target());
                Err(self.note_defect())
            }
            // The thread has died with the frame, which not even a defect of a draw does.
            Ok(Ok(Event::Wants) | Err(_)) => {
                if let Ok(memory) = VideoMemory::new(width, height) {
                    self.framebuffer.memory = memory;
                }
                Err(self.note_defect())
            }
        }
    }

    /// Takes the renderer back from the drawing thread.
    fn take_back(&mut self, mut renderer: Renderer) {
        renderer.set_cancel(self.rendering.renderer.options().cancel.clone());
        self.rendering.renderer = renderer;
    }

    /// Completes a draw whose frame is back. Returns `true`.
    fn end_long_draw(&mut self, s: &mut Session, ended: Ended) -> Result<bool, Fault> {
        self.take_back(ended.renderer);
        let result = ended.result.ok_or_else(|| self.note_defect())?;
        if result.is_ok() {
            self.rendering.draw_times.note(&ended.drawing, ended.took);
        }
        self.end_drawing(s, &ended.drawing, result)?;
        Ok(true)
    }

    /// Ends a draw early. A part of it may be drawn.
    pub(super) fn stop_long_draw(&mut self, draw: &mut LongDraw) {
        // The next draw gets another token.
        if let Some(thread) = &mut self.rendering.draw_thread {
            std::mem::replace(&mut thread.cancel, CancelToken::new()).cancel();
        }
        loop {
            let ended = match draw.is_waiting {
                true => self.lend(draw, LOAN),
                false => match draw.events.recv() {
                    Ok(Event::Ended(ended)) => Ok(Some(ended)),
                    Ok(_) => {
                        draw.is_waiting = true;
                        continue;
                    }
                    Err(_) => break,
                },
            };
            match ended {
                Ok(Some(ended)) => {
                    self.take_back(ended.renderer);
                    break;
                }
                Ok(None) => {}
                Err(_) => break,
            }
        }
        self.framebuffer.count_target();
    }
}

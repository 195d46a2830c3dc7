//! Preemption of draws: the points at which a long draw hands its render target back, so that
//! others can use it before the draw goes on.
//!
//! In: an owner, which lends the target to a draw, and the stages of the draw, which say where the
//! target is whole and where they do not need it. Out: calls of the owner. A point is reached on
//! the thread that called the draw, outside of the pool; [`Slice::is_over`] is asked on any thread.
//!
//! The answer is right if
//! - bytes, depths, ids and statistics do not depend on where the draw was preempted: work on the
//!   target stops between units (a face, a face in a band of rows, the faces of one chunk in a
//!   tile) that are done in the same order, and remembers for each row of tiles or band the next
//!   unit;
//! - a draw hands the target back soon after it is due: no unit takes more than some milliseconds,
//!   and stages without a limit of time (facts about geometries, sorting, vertices, lighting ahead
//!   of the pixels, binning) run while the owner has the target;
//! - a draw without an owner pays one comparison at each point.
//!
//! Verified by the tests below, which preempt draws of every path at each of their points,
//! and by those of `tests/serving/preemption.rs`, where others are served meanwhile.

use super::draw_call::Target;
use crate::executor::Executor;
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Owner of a render target, which it lends to a draw for a time.
pub trait TargetOwner: Send + Sync {
    /// Returns whether the draw should hand the target back at its next preemption point.
    fn is_due(&self) -> bool;

    /// Takes the memories of the target back. The draw does not touch them until the next
    /// [`TargetOwner::acquire`].
    fn release(&self, target: &mut Target);

    /// Waits until the memories are lent again, and puts them into the target.
    fn acquire(&self, target: &mut Target);
}

/// A draw's handle on the owner of its target. [`Preemption::default`] has none: the draw is never
/// preempted.
#[derive(Clone, Default)]
pub struct Preemption(Option<Arc<dyn TargetOwner>>);

/// A draw that is never preempted.
pub(crate) static NOT_PREEMPTED: Preemption = Preemption(None);

/// Items (faces, vertices, objects) below which a stage keeps the target while it does not need it:
/// some hundred microseconds of work.
const FEW_ITEMS: usize = 4096;

/// Pixels of faces that are drawn one by one between two readings of the clock: some 100 us to a
/// millisecond of work.
pub(crate) const UNIT_PIXELS: i64 = 1 << 15;

impl fmt::Debug for Preemption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Preemption({})", self.0.is_some())
    }
}

impl Preemption {
    /// Creates the handle of draws whose target `owner` lends.
    pub fn by(owner: Arc<dyn TargetOwner>) -> Self {
        Preemption(Some(owner))
    }

    /// Returns whether draws can be preempted.
    pub fn is_possible(&self) -> bool {
        self.0.is_some()
    }

    /// Returns whether the target should be handed back at the next point.
    #[inline]
    pub fn is_due(&self) -> bool {
        self.0.as_ref().is_some_and(|owner| owner.is_due())
    }

    /// A preemption point: hands the target back if that is due, and waits until it is lent again.
    #[inline]
    pub fn point(&self, target: &mut Target) {
        if let Some(owner) = &self.0
            && owner.is_due()
        {
            owner.release(target);
            owner.acquire(target);
        }
    }

    /// Returns how many rows of a box of `columns` by `rows` pixels may be drawn between two points, at
    /// least 1.
    pub(crate) fn rows_at_once(&self, columns: i32, rows: i32) -> i32 {
        match self.is_possible() {
            true => (UNIT_PIXELS / i64::from(columns).max(1)).max(1) as i32,
            false => rows.max(1),
        }
    }

    /// Runs a draw, whose parts call [`Executor::run`]: on a thread of the pool, so that the parts
    /// need not wake one each; but on the calling thread if it can be preempted, so that no thread
    /// of the pool waits for the target.
    pub(crate) fn run_draw<R: Send>(&self, executor: &Executor, draw: impl FnOnce() -> R + Send) -> R {
        match self.is_possible() {
            false => executor.run(draw),
            true => draw(),
        }
    }

    /// Runs work on `items` items that does not need the target, which the owner has meanwhile if
    /// they are many.
    pub fn without<R>(&self, target: &mut Target, items: usize, work: impl FnOnce() -> R) -> R {
        self.point(target);
        match &self.0 {
            Some(owner) if items >= FEW_ITEMS => {
                owner.release(target);
                let result = work();
                owner.acquire(target);
                result
            }
            _ => work(),
        }
    }
}

/// The time between two preemption points, in which threads share work on the target.
pub(crate) struct Slice<'p> {
    preemption: &'p Preemption,
    /// Set when a unit has begun after the target was due.
    has_begun: AtomicBool,
}

impl<'p> Slice<'p> {
    /// Begins a slice.
    pub fn new(preemption: &'p Preemption) -> Self {
        Slice { preemption, has_begun: AtomicBool::new(false) }
    }

    /// Returns whether no further unit of work may begin. The first unit of a slice always may, so
    /// that each slice brings the draw forward.
    #[inline]
    pub fn is_over(&self) -> bool {
        self.preemption.is_due() && self.has_begun.swap(true, Relaxed)
    }
}

#[cfg(test)]
mod tests;

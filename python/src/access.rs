//! Access to the engine of a framebuffer: which thread may draw, and with which locks.
//!
//! In: a call from any Python thread. Out: the call has run with the engine to itself, or raised.
//!
//! Rules:
//! - Each call has the engine to itself: calls of several threads on one framebuffer run one after
//!   the other, in no given order.
//! - While no view of the memory is held, calls that draw release the interpreter's lock, so that
//!   other threads run, with framebuffers of their own at the same time. Short calls (single pixels,
//!   settings) keep it: to take it back would cost more than they do.
//! - While a view (`numpy`, `memoryview`) is held, the framebuffer belongs to the thread that asked
//!   for it. Its calls keep the interpreter's lock, so no Python code reads or writes the view while
//!   the engine does; calls of other threads raise `BufferError`.
//!
//! The engine's mutex is never waited for with the interpreter's lock held, and never held while
//! that lock is waited for, so the two cannot block each other.

use crate::errors::poisoned;
use fbptr::server::{Audience, Engine, Stream};
use pyo3::exceptions::PyBufferError;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};
use std::thread::ThreadId;

/// The engine, and the stream of the commands that are called as methods.
pub struct State {
    pub engine: Engine,
    pub stream: Stream,
    /// Sessions to which states are set back.
    pub saved: Vec<crate::framebuffer::SavedStates>,
}

impl State {
    pub fn new(engine: Engine) -> Self {
        let stream = Stream::new(&engine, 1, Audience::Owner);
        State { engine, stream, saved: Vec::new() }
    }
}

/// Duration of a call, roughly.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Length {
    /// Some hundred nanoseconds.
    Short,
    /// Possibly long.
    Long,
}

/// Views that are held, and the thread that asked for the first of them.
#[derive(Default)]
struct Views {
    owner: Option<ThreadId>,
}

/// An engine that several threads may call.
pub struct Shared {
    state: Mutex<State>,
    /// Number of views. Changed by a thread that has both the engine and the interpreter's lock, or
    /// lowered by one that has the latter.
    count: AtomicUsize,
    views: Mutex<Views>,
}

impl Shared {
    pub fn new(engine: Engine) -> Self {
        Shared { state: Mutex::new(State::new(engine)), count: AtomicUsize::new(0), views: Mutex::default() }
    }

    /// Runs `call` with the engine to itself, as the module's rules say.
    pub fn with<T: Send>(
        &self,
        py: Python<'_>,
        length: Length,
        mut call: impl FnMut(&mut State) -> T + Send,
    ) -> PyResult<T> {
        loop {
            let is_viewed = self.check_owner()?;
            if is_viewed || length == Length::Short {
                match self.state.try_lock() {
                    Ok(mut state) => {
                        let result = call(&mut state);
                        if is_viewed {
                            // The view's address stays good for what others do until the next call.
                            let memory = state.engine.memory_mut().bytes_mut();
                            let _ = memory.as_mut_ptr().expose_provenance();
                        }
                        return Ok(result);
                    }
                    Err(TryLockError::Poisoned(_)) => return Err(poisoned()),
                    Err(TryLockError::WouldBlock) => {}
                }
            }
            let done = py.detach(|| {
                let mut state = self.state.lock().map_err(|_| ())?;
                // A view may have been asked for before the engine was locked.
                Ok((self.count.load(Ordering::Acquire) == 0).then(|| call(&mut state)))
            });
            match done {
                Ok(Some(result)) => return Ok(result),
                Ok(None) => {}
                Err(()) => return Err(poisoned()),
            }
        }
    }

    /// Refuses a call while another thread's view is held. Returns whether one of this thread's is.
    fn check_owner(&self) -> PyResult<bool> {
        if self.count.load(Ordering::Acquire) == 0 {
            return Ok(false);
        }
        match self.views.lock().map_err(|_| poisoned())?.owner {
            Some(owner) if owner != std::thread::current().id() => Err(PyBufferError::new_err(
                "a view of this framebuffer (numpy, memoryview) is held, and only the thread that asked for it \
                 may use the framebuffer: drop the view, or take numpy(copy=True); or give each thread a \
                 framebuffer of its own",
            )),
            _ => Ok(true),
        }
    }

    /// Counts a view of the memory, for the calling thread, once no other thread draws.
    pub fn add_view<T>(&self, py: Python<'_>, view: impl FnOnce(&mut State) -> T) -> PyResult<T> {
        let mut state = self.lock_attached(py)?;
        let mut views = self.views.lock().map_err(|_| poisoned())?;
        if self.count.fetch_add(1, Ordering::AcqRel) == 0 {
            views.owner = Some(std::thread::current().id());
        }
        Ok(view(&mut state))
    }

    /// Uncounts a view.
    pub fn drop_view(&self) {
        self.count.fetch_sub(1, Ordering::AcqRel);
    }

    /// Returns the engine with the interpreter's lock held.
    fn lock_attached(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, State>> {
        loop {
            self.check_owner()?;
            match self.state.try_lock() {
                Ok(state) => return Ok(state),
                Err(TryLockError::Poisoned(_)) => return Err(poisoned()),
                Err(TryLockError::WouldBlock) => py.detach(|| drop(self.state.lock())),
            }
        }
    }
}

//! Readiness of sockets for reading and writing, from the system: epoll on Linux, kqueue and IOCP
//! elsewhere, through `mio`.
//!
//! In: sockets, each registered once under a number, and writers that wait. Out: the numbers of
//! readable sockets, and a signal to the writers of writable ones. Reports are edge-triggered:
//! after one, a socket is read or written until the system would block. Any thread may poll, one at
//! a time.

use mio::{Events, Interest, Poll, Registry, Token, Waker, event};
use std::collections::HashMap;
use std::fmt;
use std::io::{self, ErrorKind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError, TryLockError};
use std::time::Duration;

/// Reports taken from the system by one call.
const EVENTS: usize = 64;
/// Token of the selector's own waker.
const WAKE: Token = Token(usize::MAX);

/// A signal to the writer of a socket that the socket is writable.
#[derive(Debug, Default)]
pub(super) struct Writable {
    is_set: Mutex<bool>,
    changed: Condvar,
}

impl Writable {
    /// Signals that the socket is writable, or that waiting for it is of no use.
    pub fn set(&self) {
        *lock(&self.is_set) = true;
        self.changed.notify_all();
    }

    pub fn unset(&self) {
        *lock(&self.is_set) = false;
    }

    /// Blocks until the signal is set.
    pub fn wait(&self) {
        let is_set = lock(&self.is_set);
        drop(self.changed.wait_while(is_set, |is_set| !*is_set).unwrap_or_else(PoisonError::into_inner));
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Flags, lists and events are consistent even if a thread panicked while it held the lock.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

pub(super) struct Selector {
    system: Mutex<(Poll, Events)>,
    registry: Registry,
    waker: Waker,
    /// Signals of the waiting writers, by socket number.
    writers: Mutex<HashMap<u64, Arc<Writable>>>,
}

impl Selector {
    /// Creates a selector with its waker.
    ///
    /// # Errors
    /// If the system has no descriptor for it.
    pub fn new() -> io::Result<Self> {
        let poll = Poll::new()?;
        let registry = poll.registry().try_clone()?;
        let waker = Waker::new(&registry, WAKE)?;
        let system = Mutex::new((poll, Events::with_capacity(EVENTS)));
        Ok(Selector { system, registry, waker, writers: Mutex::default() })
    }

    /// Registers `source` for reports of bytes to read.
    ///
    /// # Errors
    /// If the system cannot watch one more.
    pub fn register(&self, source: &mut impl event::Source, id: u64) -> io::Result<()> {
        self.registry.register(source, Token(id as usize), Interest::READABLE)
    }

    /// Sets `writable` whenever `source` becomes writable, until [`Self::end_writer`]; at once if
    /// it is writable at the call.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn begin_writer(
        &self,
        source: &mut impl event::Source,
        id: u64,
        writable: Arc<Writable>,
    ) -> io::Result<()> {
        lock(&self.writers).insert(id, writable);
        let registered =
            self.registry.reregister(source, Token(id as usize), Interest::READABLE | Interest::WRITABLE);
        if registered.is_err() {
            lock(&self.writers).remove(&id);
        }
        registered
    }

    pub fn end_writer(&self, source: &mut impl event::Source, id: u64) {
        // Reports that nobody needs do no harm.
        let _ = self.registry.reregister(source, Token(id as usize), Interest::READABLE);
        lock(&self.writers).remove(&id);
    }

    /// Ends the wait of the thread that polls.
    pub fn wake(&self) {
        // Fails only if an earlier call has not been seen yet.
        let _ = self.waker.wake();
    }

    /// Blocks until a socket is readable or [`Self::wake`] is called, for `timeout` at most if
    /// there is one, and calls `notify` with the number of each readable socket. Returns whether
    /// [`Self::wake`] was called.
    ///
    /// # Errors
    /// If polling fails.
    pub fn wait(&self, timeout: Option<Duration>, notify: impl FnMut(u64)) -> io::Result<bool> {
        self.ask(&mut lock(&self.system), timeout, notify)
    }

    /// Calls `notify` with the number of each readable socket, without blocking. Returns whether
    /// [`Self::wake`] was called, which the thread that waits next does not see any more. Does
    /// nothing while another thread polls.
    ///
    /// # Errors
    /// If polling fails.
    pub fn look(&self, notify: impl FnMut(u64)) -> io::Result<bool> {
        match self.system.try_lock() {
            Ok(mut system) => self.ask(&mut system, Some(Duration::ZERO), notify),
            Err(TryLockError::WouldBlock) => Ok(false),
            Err(TryLockError::Poisoned(system)) => {
                self.ask(&mut system.into_inner(), Some(Duration::ZERO), notify)
            }
        }
    }

    fn ask(
        &self,
        (poll, events): &mut (Poll, Events),
        timeout: Option<Duration>,
        mut notify: impl FnMut(u64),
    ) -> io::Result<bool> {
        match poll.poll(events, timeout) {
            Err(e) if e.kind() == ErrorKind::Interrupted => return Ok(false),
            result => result?,
        }
        let mut is_woken = false;
        for event in events.iter() {
            if event.token() == WAKE {
                is_woken = true;
                continue;
            }
            let id = event.token().0 as u64;
            if (event.is_writable() || event.is_write_closed() || event.is_error())
                && let Some(writable) = lock(&self.writers).get(&id)
            {
                writable.set();
            }
            if event.is_readable() || event.is_read_closed() || event.is_error() {
                notify(id);
            }
        }
        Ok(is_woken)
    }
}

impl fmt::Debug for Selector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Selector")
    }
}

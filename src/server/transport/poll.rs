//! THE POLLER: a few threads that read all sockets, in turns.
//!
//! The system says which sockets have something; each of them is read once, into a [`Lease`], before any is read again.
//! A thread for each socket would read as well, but where many of them wake up they push the render thread aside, which
//! is the one that all wait for, and each wake-up costs a change of threads. A connection has at most [`AHEAD`] batches on their way: then it is not watched
//! until one came back, the system's socket buffer fills, and the sender is held back.

use super::lease::{Buffers, LEASE_BYTES, Lease};
use super::{Life, Socket};
use crate::command::EndOfInput;
use crate::server::thread::message::{Batch, Message};
use crossbeam_channel::Sender;
use rustix::event::{EventfdFlags, epoll, eventfd};
use rustix::io::Errno;
use rustix::net::{RecvFlags, recv};
use std::collections::HashMap;
use std::fmt;
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::OwnedFd;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::Builder;

/// Batches of one connection on their way.
const AHEAD: usize = 3;
/// Reads of so few bytes are copied, and the lease goes on.
const FEW_BYTES: usize = 8 << 10;
/// Threads that read. One is enough for pixels, but not for long rows, where copying out of the system is most of the work.
const READERS: usize = 2;
/// More ready sockets than this are many.
const MANY: usize = 16;
/// The name under which the poller itself is called.
const WAKE: u64 = u64::MAX;

/// All sockets that are read.
struct Shared {
    epoll: OwnedFd,
    wake: OwnedFd,
    watched: Mutex<HashMap<u64, (Arc<Watched>, Life)>>,
    buffers: Arc<Buffers>,
    is_ending: AtomicBool,
}

/// A socket that is read.
struct Watched {
    id: u64,
    socket: Socket,
    messages: Sender<Message>,
    end: EndOfInput,
    flow: Mutex<Flow>,
}

/// Whether and why a socket is not read.
#[derive(Default)]
struct Flow {
    on_their_way: usize,
    is_armed: bool,
    /// The render thread wants no more: what comes is thrown away.
    is_over: bool,
    /// Nothing more comes.
    is_at_end: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Counts and flags are whole at any time.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The hold on the threads. Each is started with its first socket, and ends when this is gone and the last socket closed.
pub(crate) struct Poller {
    buffers: Arc<Buffers>,
    readers: Mutex<Vec<Option<Arc<Shared>>>>,
}

impl Poller {
    pub fn new(buffers: Arc<Buffers>) -> Self {
        Poller { buffers, readers: Mutex::new(vec![None; READERS]) }
    }

    /// The thread that has the fewest sockets.
    fn shared(&self) -> io::Result<Arc<Shared>> {
        let mut readers = lock(&self.readers);
        let load = |r: &&mut Option<Arc<Shared>>| r.as_ref().map_or(0, |s| lock(&s.watched).len());
        let reader = readers.iter_mut().min_by_key(load).expect("there is one at least");
        if let Some(shared) = reader {
            return Ok(shared.clone());
        }
        let new = Arc::new(Shared {
            epoll: epoll::create(epoll::CreateFlags::CLOEXEC)?,
            wake: eventfd(0, EventfdFlags::CLOEXEC | EventfdFlags::NONBLOCK)?,
            watched: Mutex::new(HashMap::new()),
            buffers: self.buffers.clone(),
            is_ending: AtomicBool::new(false),
        });
        epoll::add(&new.epoll, &new.wake, epoll::EventData::new_u64(WAKE), epoll::EventFlags::IN)?;
        let for_thread = new.clone();
        Builder::new().name("read".into()).stack_size(super::STACK_BYTES).spawn(move || for_thread.run())?;
        *reader = Some(new.clone());
        Ok(new)
    }

    /// Gets ready to read a socket. Answers what the render thread gives its batches back to.
    ///
    /// # Errors
    /// When the system has no room for it; nothing has begun then.
    pub fn prepare(
        &self,
        id: u64,
        socket: Socket,
        end: EndOfInput,
        messages: Sender<Message>,
    ) -> io::Result<Return> {
        let shared = self.shared()?;
        Ok(Return {
            watched: Arc::new(Watched { id, socket, messages, end, flow: Mutex::default() }),
            shared,
        })
    }
}

impl Drop for Poller {
    fn drop(&mut self) {
        for shared in lock(&self.readers).drain(..).flatten() {
            shared.is_ending.store(true, Ordering::Release);
            let _ = rustix::io::write(&shared.wake, &1u64.to_ne_bytes());
        }
    }
}

impl fmt::Debug for Poller {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Poller({:?})", self.buffers)
    }
}

/// Where the batches of a connection are given back. When it is dropped the connection is over.
pub(crate) struct Return {
    watched: Arc<Watched>,
    shared: Arc<Shared>,
}

impl Return {
    /// Begins to read; `life` is dropped when nothing more comes.
    pub fn begin(&self, life: Life) {
        lock(&self.shared.watched).insert(self.watched.id, (self.watched.clone(), life));
        self.shared.go_on(&self.watched, &mut lock(&self.watched.flow));
    }

    /// Takes a batch back.
    pub fn put(&self) {
        let mut flow = lock(&self.watched.flow);
        flow.on_their_way -= 1;
        self.shared.go_on(&self.watched, &mut flow);
    }

    /// Another hold on the same, for whoever begins.
    pub fn share(&self) -> Return {
        Return { watched: self.watched.clone(), shared: self.shared.clone() }
    }

    /// The render thread wants no more.
    pub fn is_over(&self) {
        let mut flow = lock(&self.watched.flow);
        flow.is_over = true;
        self.shared.go_on(&self.watched, &mut flow);
    }
}

impl Shared {
    fn arm(&self, watched: &Watched, flow: &mut Flow) -> io::Result<()> {
        let name = epoll::EventData::new_u64(watched.id);
        epoll::add(&self.epoll, &watched.socket, name, epoll::EventFlags::IN)?;
        flow.is_armed = true;
        Ok(())
    }

    fn disarm(&self, watched: &Watched, flow: &mut Flow) {
        if std::mem::take(&mut flow.is_armed) {
            // It is watched, so this can be done.
            let _ = epoll::delete(&self.epoll, &watched.socket);
        }
    }

    /// Watches a socket again that was not, where something may come.
    fn go_on(&self, watched: &Watched, flow: &mut Flow) {
        if !flow.is_armed && !flow.is_at_end && self.arm(watched, flow).is_err() {
            // The system has no room to watch it: the connection ends, as one that died.
            flow.is_at_end = true;
            let ended = lock(&self.watched).remove(&watched.id);
            drop(ended);
            // The render thread may be the one who does this: it must not wait for room in its own channel.
            let _ = watched.messages.try_send(Message::End(watched.id, watched.end));
        }
    }

    /// Nothing more comes of this one.
    fn at_end(&self, watched: &Watched) {
        let mut flow = lock(&watched.flow);
        self.disarm(watched, &mut flow);
        let is_wanted = !std::mem::replace(&mut flow.is_at_end, true) && !flow.is_over;
        // The render thread may wait for the lock, and this for the render thread.
        drop(flow);
        if is_wanted {
            // A render thread that is gone needs no end.
            let _ = watched.messages.send(Message::End(watched.id, watched.end));
        }
    }

    fn run(&self) {
        let mut events = [MaybeUninit::<epoll::Event>::uninit(); 64];
        let mut lease = None;
        loop {
            let ready = match epoll::wait(&self.epoll, &mut events, None) {
                Ok((ready, _)) => ready,
                Err(Errno::INTR) => continue,
                // There is nothing else that it could say.
                Err(_) => return,
            };
            self.buffers.set_ready(ready.len());
            for event in ready.iter() {
                let id = event.data.u64();
                let watched = lock(&self.watched).get(&id).map(|(w, _)| w.clone());
                if let Some(watched) = watched
                    && self.read(&watched, &mut lease)
                {
                    // Its life ends outside of the lock.
                    let ended = lock(&self.watched).remove(&id);
                    drop(ended);
                }
            }
            if ready.len() < events.len() {
                self.buffers.set_ready(0);
            }
            if self.is_ending.load(Ordering::Acquire) {
                if lock(&self.watched).is_empty() {
                    return;
                }
                // Said once is enough.
                let _ = rustix::io::read(&self.wake, &mut [0; 8]);
            }
        }
    }

    /// Reads once. Whether nothing more comes.
    fn read(&self, watched: &Watched, lease: &mut Option<Lease>) -> bool {
        let mut own = lease.take().unwrap_or_else(|| self.buffers.lease());
        // Where many wait for their turn, each has a shorter one.
        let portion = if self.buffers.ready() > MANY { LEASE_BYTES / 2 } else { LEASE_BYTES };
        let filled = match recv(&watched.socket, &mut own.buffer[..portion], RecvFlags::DONTWAIT) {
            Err(Errno::INTR | Errno::AGAIN) => {
                *lease = Some(own);
                return false;
            }
            // A connection that died says no more than one that was closed: what came before still counts.
            Ok((0, _)) | Err(_) => {
                *lease = Some(own);
                self.at_end(watched);
                return true;
            }
            Ok((filled, _)) => filled,
        };
        {
            let mut flow = lock(&watched.flow);
            if flow.is_over {
                // Its last replies are on their way: a socket that is closed with bytes unread would take them along.
                *lease = Some(own);
                return false;
            }
            flow.on_their_way += 1;
            if flow.on_their_way >= AHEAD {
                self.disarm(watched, &mut flow);
            }
        }
        let batch = if filled <= FEW_BYTES {
            let buffer = own.buffer[..filled].to_vec();
            *lease = Some(own);
            Batch { buffer, lease: None, filled }
        } else {
            Batch { buffer: Vec::new(), lease: Some(own), filled }
        };
        if watched.messages.send(Message::Bytes(watched.id, batch)).is_err() {
            lock(&watched.flow).is_over = true;
        }
        false
    }
}

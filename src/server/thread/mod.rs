//! THE RENDER THREAD: owns the engine, and with it the video memory; runs what all connections send, in turns.
//!
//! In: batches of bytes and typed commands over one bounded channel; input from the display. Out: replies in each
//! connection's outbox, frames on the display. Promises: each connection's commands run in order and its replies keep
//! that order; connections take turns of [`SLICE_BYTES`] or [`SLICE_TIME`], whichever is used up first (one command more
//! at most; where many take turns, less time); the thread waits for no client, no window and no reader. A reader has few buffers and waits for the next
//! one, so what is received and not run is bounded, and the socket itself holds a fast sender back.

pub(crate) mod connection;
pub(crate) mod message;

use super::client::Client;
#[cfg(target_os = "linux")]
use super::transport::Poller;
use super::transport::{Buffers, LEASE_BYTES};
use super::{Audience, Budget, Engine, Input, Output, Pace, Standing};
use connection::{Connection, Leaving};
use crossbeam_channel::{Receiver, Sender, bounded, never, select};
use message::{Id, Inbox, Message, Opening, Source};
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Stream bytes of one connection before the next has its turn.
pub const SLICE_BYTES: usize = LEASE_BYTES;
/// Time of one connection before the next has its turn, and the time in which all of them have one, where that leaves
/// each no less than a tenth of it.
pub const SLICE_TIME: Duration = Duration::from_millis(2);
const ROUND_TIME: Duration = Duration::from_millis(24);
/// Messages that may wait. Each connection has few, so that this is never what limits one of them.
const CHANNEL_ROOM: usize = 8192;
/// The display is not given a new picture more often than this, but for PRESENT.
const SHOW_EVERY: Duration = Duration::from_millis(15);
/// How long a connection that is over may go without its client taking a byte.
const LEAVE_WITHIN: Duration = Duration::from_secs(20);
/// How long a client may keep its side open after it was sent everything.
const HANG_UP_WITHIN: Duration = Duration::from_secs(3);

/// How the render thread is to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Finish {
    /// When all that was and will be sent has run and every connection is over.
    WhenAllEnded,
    /// When what has been received has run and its replies are out, and at this time in any case.
    By(Instant),
    /// After the slice that is being run.
    Now,
}

/// A handle on the render thread.
#[derive(Debug)]
pub struct RenderThread {
    messages: Sender<Message>,
    thread: JoinHandle<Engine>,
    next_id: Arc<AtomicU64>,
    #[cfg(target_os = "linux")]
    poller: Arc<Poller>,
}

/// What transports need of the render thread: a way to send, and numbers for connections.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    pub messages: Sender<Message>,
    #[cfg(target_os = "linux")]
    pub poller: Arc<Poller>,
    next_id: Arc<AtomicU64>,
}

impl Link {
    /// A number that no other connection has.
    pub fn new_id(&self) -> Id {
        self.next_id.fetch_add(1, Ordering::Relaxed)
    }
}

impl RenderThread {
    /// Starts the thread.
    ///
    /// # Errors
    /// When the system has no thread to give.
    pub fn start(engine: Engine) -> std::io::Result<RenderThread> {
        let (sender, messages) = bounded(CHANNEL_ROOM);
        let own_sender = sender.clone();
        let buffers = Arc::new(Buffers::new());
        let for_loop = buffers.clone();
        let thread = std::thread::Builder::new()
            .name("render".into())
            .spawn(move || Loop::new(engine, messages, own_sender, for_loop).run())?;
        Ok(RenderThread {
            messages: sender,
            thread,
            next_id: Arc::new(AtomicU64::new(1)),
            #[cfg(target_os = "linux")]
            poller: Arc::new(Poller::new(buffers)),
        })
    }

    /// A client in this process, with a connection of its own.
    pub fn client(&self) -> Client {
        let (link, inbox) = (self.link(), Arc::new(Inbox::default()));
        let id = link.new_id();
        let opening = Opening {
            audience: Audience::Owner,
            may_replay: false,
            source: Source::Inbox(inbox.clone()),
            on_notice: None,
            on_end: None,
        };
        if link.messages.send(Message::Open(id, Box::new(opening))).is_err() {
            inbox.close();
        }
        Client::new(id, link.messages, inbox)
    }

    pub(crate) fn link(&self) -> Link {
        Link {
            messages: self.messages.clone(),
            #[cfg(target_os = "linux")]
            poller: self.poller.clone(),
            next_id: self.next_id.clone(),
        }
    }

    /// Goes on without the display: the window could not be had. `PRESENT wait` counts as shown from now on.
    pub fn drop_display(&self) {
        let _ = self.messages.send(Message::NoDisplay);
    }

    /// Runs `task` on the render thread between two slices of work.
    pub fn run_between(&self, task: impl FnOnce(&mut Engine) + Send + 'static) {
        let _ = self.messages.send(Message::Do(Box::new(task)));
    }

    /// Asks the thread to end; it does so on its own time.
    pub fn begin_finish(&self, how: Finish) {
        let _ = self.messages.send(Message::Finish(how));
    }

    /// Something that asks the thread to end at once, and can be called from anywhere, a signal's handler for instance.
    pub fn stopper(&self) -> impl Fn() + Send + 'static {
        let messages = self.messages.clone();
        move || drop(messages.send(Message::Finish(Finish::Now)))
    }

    /// Whether the thread has ended.
    pub fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends the thread and gives back its engine.
    ///
    /// # Panics
    /// When the render thread did, which is a defect.
    pub fn finish(self, how: Finish) -> Engine {
        self.begin_finish(how);
        let RenderThread { messages, thread, .. } = self;
        drop(messages);
        match thread.join() {
            Ok(engine) => engine,
            Err(panic) => std::panic::resume_unwind(panic),
        }
    }
}

struct Loop {
    engine: Engine,
    messages: Receiver<Message>,
    sender: Sender<Message>,
    inputs: Receiver<Input>,
    connections: HashMap<Id, Connection>,
    /// Those that can run, in the order of their turns.
    round: VecDeque<Id>,
    /// Those that wait for a frame to be shown.
    waiting: Vec<Id>,
    leaving: Vec<Leaving>,
    /// Where sockets' buffers come from, and how many connections have work that holds none.
    buffers: Arc<Buffers>,
    slow: usize,
    /// Stream bytes received and not run.
    queued_bytes: u64,
    output: Output,
    shown_at: Instant,
    finish: Option<Finish>,
}

impl Loop {
    fn new(
        engine: Engine,
        messages: Receiver<Message>,
        sender: Sender<Message>,
        buffers: Arc<Buffers>,
    ) -> Self {
        let inputs = engine.display().map_or_else(never, |d| d.inputs());
        Loop {
            engine,
            messages,
            sender,
            inputs,
            connections: HashMap::new(),
            round: VecDeque::new(),
            waiting: Vec::new(),
            leaving: Vec::new(),
            buffers,
            slow: 0,
            queued_bytes: 0,
            output: Output::default(),
            shown_at: Instant::now(),
            finish: None,
        }
    }

    fn run(mut self) -> Engine {
        loop {
            // Whatever came must be looked at before the thread may sleep.
            self.receive_all();
            self.look_around();
            if self.is_over() {
                return self.end();
            }
            match self.next_turn() {
                Some((id, pace)) => self.turn(id, pace),
                None => self.wait(),
            }
        }
    }

    fn is_over(&self) -> bool {
        match self.finish {
            None => false,
            Some(Finish::Now) => true,
            Some(Finish::WhenAllEnded) => self.connections.is_empty() && self.messages.is_empty(),
            Some(Finish::By(time)) => {
                let is_done = |c: &Connection| c.is_idle() && !c.is_ending();
                Instant::now() >= time || (self.connections.values().all(is_done) && self.messages.is_empty())
            }
        }
    }

    /// Takes all messages that wait. Each connection can have few, so this ends.
    fn receive_all(&mut self) {
        while let Ok(message) = self.messages.try_recv() {
            self.receive(message);
        }
        while let Ok(input) = self.inputs.try_recv() {
            self.input(input);
        }
    }

    fn receive(&mut self, message: Message) {
        match message {
            Message::Open(id, opening) => {
                self.engine.open();
                let mut connection = Connection::new(&self.engine, id, *opening);
                if matches!(self.finish, Some(Finish::By(_))) {
                    connection.stop_reading();
                }
                self.connections.insert(id, connection);
            }
            Message::Bytes(id, mut batch) if self.connections.contains_key(&id) => {
                self.queued_bytes += batch.filled as u64;
                // Its turn is far: others could use the buffer in the meantime.
                if self.slow > 0 {
                    batch.keep_from(0);
                }
                self.with(id, |c| {
                    c.add_bytes(batch);
                    c.shorten_leases();
                });
            }
            // Its connection is over.
            Message::Bytes(..) => {}
            Message::End(id, end) => self.with(id, |c| c.add_end(end)),
            Message::Mail(id) => self.with(id, Connection::add_mail),
            Message::Room(id) => self.with(id, Connection::note_room),
            Message::Do(task) => task(&mut self.engine),
            Message::NoDisplay => {
                self.engine.drop_display();
                self.inputs = never();
            }
            Message::Finish(how) => {
                self.finish = Some(how);
                if matches!(how, Finish::By(_)) {
                    self.connections.values_mut().for_each(Connection::stop_reading);
                }
            }
        }
    }

    /// Does something to a connection, and puts it into the round when it can run. One that is over is not there.
    fn with(&mut self, id: Id, action: impl FnOnce(&mut Connection)) {
        if let Some(connection) = self.connections.get_mut(&id) {
            action(connection);
            if connection.is_runnable() && !connection.is_queued {
                connection.is_queued = true;
                self.round.push_back(id);
            }
        }
    }

    fn input(&mut self, input: Input) {
        let Some(display) = self.engine.display().cloned() else { return };
        match input {
            Input::Look => display.answer_probe(self.engine.depth()),
            Input::Event(event) => {
                let limit = self.engine.limits().reply_bytes;
                for connection in self.connections.values_mut() {
                    if connection.stream.session().events {
                        connection.tell_event(&event, limit, &self.sender);
                    }
                }
            }
        }
    }

    /// Whose turn it is, and how much it may run: nobody's while the display is paused, but for single steps.
    fn next_turn(&mut self) -> Option<(Id, Pace)> {
        if self.round.is_empty() {
            return None;
        }
        let pace = match self.engine.display() {
            Some(display) if display.is_paused() && !display.is_closed() => match display.take_step() {
                true if self.engine.is_frozen() => Pace::OneFrame,
                true => Pace::OneCommand,
                false => return None,
            },
            _ => Pace::Free,
        };
        self.round.pop_front().map(|id| (id, pace))
    }

    fn turn(&mut self, id: Id, pace: Pace) {
        self.engine.set_queue_bytes(self.queued_bytes);
        let Some(connection) = self.connections.get_mut(&id) else { return };
        connection.is_queued = false;
        let queued_before = connection.queued_bytes;
        let limit = self.engine.limits().reply_bytes;
        let reply_bytes = limit.saturating_sub(connection.unread()).max(1);
        let now = Instant::now();
        let others = u32::try_from(self.round.len() + self.buffers.ready()).unwrap_or(u32::MAX);
        let time = (ROUND_TIME / others.saturating_add(1)).clamp(SLICE_TIME / 10, SLICE_TIME);
        let budget = Budget { until: Some(now + time), reply_bytes, pace };
        self.engine.set_time(now);
        self.engine.before_slice(now);
        let mut standing = Standing::Rests;
        // A step is a command, however many pieces of input it takes to find one.
        loop {
            let before = connection.commands();
            if connection.is_runnable() {
                // A panic outside of a command's own is a defect, too; it ends this connection and not the server.
                let run = || connection.run(&mut self.engine, SLICE_BYTES, budget, &mut self.output);
                standing = catch_unwind(AssertUnwindSafe(run)).unwrap_or(Standing::Ended);
            }
            let has_run = connection.commands() > before;
            if pace == Pace::Free || has_run || !connection.is_runnable() || standing == Standing::Ended {
                break;
            }
        }
        self.queued_bytes -= queued_before - connection.queued_bytes;
        self.engine.count(connection.stream.session_mut());
        if !self.output.replies.is_empty() {
            self.engine.before_replies();
        }
        connection.reply(&mut self.output.replies, limit, &self.sender);
        self.slow -= usize::from(connection.is_slow);
        connection.is_slow = standing != Standing::Ended && connection.shorten_leases();
        self.slow += usize::from(connection.is_slow);
        if standing == Standing::Ended {
            if let Some(connection) = self.connections.remove(&id) {
                self.queued_bytes -= connection.queued_bytes;
                self.leaving.extend(connection.close(&mut self.engine));
            }
        } else {
            if matches!(standing, Standing::WaitsFor(_)) {
                self.waiting.push(id);
            }
            self.with(id, |_| ());
        }
        if pace != Pace::Free {
            self.engine.show();
        }
    }

    /// Sleeps until there is something to do.
    fn wait(&mut self) {
        let until = self.next_deadline();
        let timeout = match until {
            Some(until) => until.saturating_duration_since(Instant::now()),
            None => Duration::from_secs(3600),
        };
        select! {
            recv(self.messages) -> message => match message {
                Ok(message) => self.receive(message),
                // The loop holds a sender itself: this cannot be.
                Err(_) => self.finish = Some(Finish::Now),
            },
            recv(self.inputs) -> input => if let Ok(input) = input {
                self.input(input);
            },
            default(timeout) => {}
        }
    }

    fn next_deadline(&mut self) -> Option<Instant> {
        let mut deadline = self.engine.next_deadline(Instant::now());
        let spare = self.engine.sweep_spare(Instant::now());
        let mut at = |time: Instant| deadline = Some(deadline.map_or(time, |d| d.min(time)));
        spare.into_iter().for_each(&mut at);
        if self.engine.has_unshown() && !self.engine.is_frozen() {
            at(self.shown_at + SHOW_EVERY);
        }
        if !self.leaving.is_empty() {
            at(Instant::now() + Duration::from_millis(100));
        }
        if let Some(Finish::By(time)) = self.finish {
            at(time);
        }
        deadline
    }

    /// What is done between slices: frames shown, the display, the shared file, those who leave.
    fn look_around(&mut self) {
        let now = Instant::now();
        self.engine.tick(now);
        if now >= self.shown_at + SHOW_EVERY && self.engine.has_unshown() {
            self.engine.show();
            self.shown_at = now;
        }
        self.answer_waiting();
        self.leaving.retain_mut(|l| !is_gone(l, now));
    }

    /// Answers those whose frame is on the screen, and lets them go on.
    fn answer_waiting(&mut self) {
        let limit = self.engine.limits().reply_bytes;
        for id in std::mem::take(&mut self.waiting) {
            let Some(connection) = self.connections.get_mut(&id) else { continue };
            match connection.waits_for {
                Some(frame) if !self.engine.is_shown(frame) => self.waiting.push(id),
                Some(_) => {
                    connection.frame_is_shown(&self.engine, &mut self.output);
                    connection.reply(&mut self.output.replies, limit, &self.sender);
                    self.with(id, |_| ());
                }
                None => {}
            }
        }
    }

    /// The end: the last replies go out, as long as there is time.
    fn end(mut self) -> Engine {
        let until = match self.finish {
            Some(Finish::By(time)) => time + Duration::from_millis(300),
            Some(Finish::Now) => Instant::now() + Duration::from_millis(300),
            // Whoever reads the replies takes the time it takes.
            _ => Instant::now() + Duration::from_secs(1 << 32),
        };
        for (_, connection) in self.connections.drain() {
            self.leaving.extend(connection.close(&mut self.engine));
        }
        for mut leaving in self.leaving.drain(..) {
            leaving.outbox.wait_done(until);
            leaving.port.abort();
        }
        self.engine.end();
        self.engine
    }
}

/// Whether a connection that is over needs no more care; aborts one whose client takes too long.
fn is_gone(leaving: &mut Leaving, now: Instant) -> bool {
    if leaving.port.is_gone() {
        return true;
    }
    let pending = leaving.outbox.pending();
    if pending != leaving.pending {
        (leaving.pending, leaving.since) = (pending, now);
    }
    let patience = if leaving.outbox.is_done() { HANG_UP_WITHIN } else { LEAVE_WITHIN };
    let is_late = now >= leaving.since + patience;
    if is_late {
        leaving.port.abort();
    }
    is_late
}

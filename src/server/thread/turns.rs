//! TURNS: the loop of the render thread. Takes what came, gives each connection its turn, and does what is due in between.

use super::connection::{Connection, Leaving};
use super::message::{Id, Message};
use super::{
    Finish, HANG_UP_WITHIN, IDLE_SCAN_EVERY, LEAVE_WITHIN, ROUND_TIME, SHOW_EVERY, SLICE_BYTES, SLICE_TIME,
};
use crate::cancel::CancelToken;
use crate::server::jobs::JobPool;
use crate::server::metrics;
use crate::server::transport::{Buffers, Hand, Next};
use crate::server::{Budget, Engine, Input, Output, Pace, Standing};
use crossbeam_channel::{Receiver, Sender, never, select};
use std::collections::{HashMap, VecDeque};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Room for replies that is kept when a connection has ended.
const KEPT_REPLY_BYTES: usize = 64 << 10;

/// After so much time of turns the sockets of those who ask for little are looked at, so many at once.
const BRIEF_EVERY: Duration = Duration::from_micros(50);
const BRIEF_AT_ONCE: usize = 16;

pub(super) struct Loop {
    engine: Engine,
    messages: Receiver<Message>,
    sender: Sender<Message>,
    inputs: Receiver<Input>,
    connections: HashMap<Id, Connection>,
    /// Those that can run, in the order of their turns.
    round: VecDeque<Id>,
    /// The same of those that ask for little. They have every other turn at most.
    brief: VecDeque<Id>,
    was_brief: bool,
    /// Those that wait for a frame to be shown.
    waiting: Vec<Id>,
    /// The step of a paused display that has begun and is not over.
    step: Option<Step>,
    leaving: Vec<Leaving>,
    /// Where sockets' buffers come from, and how many connections have work that holds none.
    buffers: Arc<Buffers>,
    slow: usize,
    /// The means to read sockets.
    hand: Hand,
    /// How long turns took since those who ask for little were looked for.
    ran_since: Duration,
    /// Stream bytes received and not run.
    queued_bytes: u64,
    output: Output,
    jobs: JobPool,
    /// Connections that wait for a job.
    working: Vec<Id>,
    /// When the next of them may have to be given up.
    jobs_until: Option<Instant>,
    /// The connection whose command is in pieces: the others may only ask.
    in_pieces: Option<Id>,
    shown_at: Instant,
    idle_scanned_at: Instant,
    metrics_at: Instant,
    /// Something has happened that the metrics do not show.
    metrics_are_stale: bool,
    finish: Option<Finish>,
}

impl Loop {
    pub fn new(
        engine: Engine,
        messages: Receiver<Message>,
        sender: Sender<Message>,
        buffers: Arc<Buffers>,
        hand: Hand,
    ) -> Self {
        let inputs = engine.display().map_or_else(never, |d| d.inputs());
        let jobs = JobPool::new(sender.clone());
        Loop {
            engine,
            messages,
            sender,
            inputs,
            connections: HashMap::new(),
            round: VecDeque::new(),
            brief: VecDeque::new(),
            was_brief: false,
            waiting: Vec::new(),
            step: None,
            leaving: Vec::new(),
            buffers,
            slow: 0,
            hand,
            ran_since: Duration::ZERO,
            queued_bytes: 0,
            output: Output::default(),
            jobs,
            working: Vec::new(),
            jobs_until: None,
            in_pieces: None,
            shown_at: Instant::now(),
            idle_scanned_at: Instant::now(),
            metrics_at: Instant::now(),
            metrics_are_stale: true,
            finish: None,
        }
    }

    pub fn run(mut self) -> Engine {
        loop {
            // Whatever came must be looked at before the thread may sleep.
            self.receive_all();
            self.look_around();
            if self.is_over() {
                return self.end();
            }
            self.read_brief();
            match self.next_turn() {
                Some((id, pace)) => {
                    self.hand.pass_on(Some(id));
                    self.turn(id, pace);
                }
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
        self.metrics_are_stale = true;
        match message {
            Message::Open(id, opening) => {
                self.engine.open(id);
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
                    if self.engine.memory_budget().available() < batch.filled as u64 {
                        self.queued_bytes -= batch.filled as u64;
                        return self.give_up(id);
                    }
                    batch.keep_from(0);
                    self.engine.count_queue(self.queued_bytes);
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
            Message::JobDone(id, number, result) => self.with(id, |c| c.job_done(number, *result)),
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

    /// Ends a connection for whose bytes there is no memory left, with a word.
    fn give_up(&mut self, id: Id) {
        let Some(mut connection) = self.connections.remove(&id) else { return };
        let limit = self.engine.memory_budget().limit();
        let message = format!("ERR 0 0 EQUOTA CONNECT: all of the {limit} bytes of memory are in use\n");
        connection.reply(&mut message.into_bytes(), usize::MAX, &self.sender);
        self.slow -= usize::from(connection.is_slow);
        self.in_pieces = self.in_pieces.filter(|other| *other != id);
        self.engine.set_in_pieces(self.in_pieces.is_some());
        self.queued_bytes -= connection.queued_bytes;
        self.engine.count_queue(self.queued_bytes);
        self.leaving.extend(connection.close(&mut self.engine));
    }

    /// Does something to a connection, and puts it into the round when it can run. One that is over is not there.
    fn with(&mut self, id: Id, action: impl FnOnce(&mut Connection)) {
        if let Some(connection) = self.connections.get_mut(&id) {
            action(connection);
            if connection.is_runnable() && !connection.is_queued {
                connection.is_queued = true;
                let queue = if connection.is_brief() { &mut self.brief } else { &mut self.round };
                queue.push_back(id);
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
                    let limit = limit.min(self.engine.reply_room(connection.unread()));
                    if connection.stream.session().events {
                        connection.tell_event(&event, limit, &self.sender);
                    }
                }
            }
        }
    }

    /// Whose turn it is, and how much it may run: nobody's while the display is paused, but for single steps.
    fn next_turn(&mut self) -> Option<(Id, Pace)> {
        if self.round.is_empty() && self.brief.is_empty() {
            return None;
        }
        match self.engine.display() {
            Some(display) if display.is_paused() && !display.is_closed() => {
                return self.continue_step().or_else(|| self.begin_step());
            }
            _ => self.step = None,
        }
        Some((self.next_in_turn()?, Pace::Free))
    }

    /// Goes on with the step that has begun, if its connection has something to run.
    fn continue_step(&mut self) -> Option<(Id, Pace)> {
        let Step { id, pace, .. } = self.step?;
        self.take_from_round(id).then_some((id, pace))
    }

    /// Takes this connection from the round. Whether it was there.
    fn take_from_round(&mut self, id: Id) -> bool {
        for queue in [&mut self.brief, &mut self.round] {
            if let Some(at) = queue.iter().position(|queued| *queued == id) {
                queue.remove(at);
                return true;
            }
        }
        false
    }

    /// Begins the step that the user asked for: a frame where `AUTO` is off, else a command. One that waits for a client
    /// to go on is given up.
    fn begin_step(&mut self) -> Option<(Id, Pace)> {
        if !self.engine.display().is_some_and(|display| display.take_step()) {
            return None;
        }
        // While a command is in pieces only its connection can do a step.
        let id = match self.in_pieces {
            Some(id) => self.take_from_round(id).then_some(id)?,
            None => self.next_in_turn()?,
        };
        let pace = if self.engine.is_frozen() { Pace::OneFrame } else { Pace::OneCommand };
        let before = self.progress_of(id, pace);
        self.step = Some(Step { id, pace, before });
        Some((id, pace))
    }

    /// Counts a step's connection up to its end.
    fn progress_of(&self, id: Id, pace: Pace) -> u64 {
        match pace {
            Pace::OneFrame => self.engine.frames(),
            _ => self.connections.get(&id).map_or(0, Connection::commands),
        }
    }

    /// Takes the next connection from the round.
    fn next_in_turn(&mut self) -> Option<Id> {
        self.was_brief = !self.brief.is_empty() && (!self.was_brief || self.round.is_empty());
        let queue = if self.was_brief { &mut self.brief } else { &mut self.round };
        queue.pop_front()
    }

    fn turn(&mut self, id: Id, pace: Pace) {
        self.engine.set_queue_bytes(self.queued_bytes);
        self.metrics_are_stale = true;
        let Some(connection) = self.connections.get_mut(&id) else { return };
        connection.is_queued = false;
        let queued_before = connection.queued_bytes;
        let limit = self.engine.limits().reply_bytes;
        let unread = connection.unread();
        let reply_bytes = limit.saturating_sub(unread).min(self.engine.reply_room(unread)).max(1);
        let now = Instant::now();
        let others =
            u32::try_from(self.round.len() + self.brief.len() + self.buffers.ready()).unwrap_or(u32::MAX);
        let time = (ROUND_TIME / others.saturating_add(1)).clamp(SLICE_TIME / 10, SLICE_TIME);
        let suspends = pace == Pace::Free;
        let only_asks = self.in_pieces.is_some_and(|other| other != id);
        let command_time = Some(self.engine.limits().command_time);
        let budget = Budget { until: Some(now + time), reply_bytes, pace, suspends, only_asks, command_time };
        self.engine.set_time(now);
        if self.in_pieces.is_none() {
            self.engine.before_slice(now);
        }
        let mut standing = Standing::Rests;
        if connection.is_runnable() {
            // A panic outside of a command's own is a defect, too; it ends this connection and not the server.
            let run = || connection.run(&mut self.engine, SLICE_BYTES, budget, &mut self.output);
            standing = catch_unwind(AssertUnwindSafe(run)).unwrap_or(Standing::Ended);
        }
        if !only_asks {
            self.in_pieces = Some(id).filter(|_| connection.is_in_pieces && standing != Standing::Ended);
            self.engine.set_in_pieces(self.in_pieces.is_some());
        }
        if let Some(job) = self.output.job.take() {
            match self.jobs.submit(id, job) {
                Ok(ticket) => {
                    connection.wait_for_job(ticket);
                    if !self.working.contains(&id) {
                        self.working.push(id);
                    }
                    self.jobs_until = Some(now);
                }
                // The system has no thread: everybody waits.
                Err(job) => connection.add_result(job.run(&CancelToken::default())),
            }
        }
        let run_bytes = queued_before - connection.queued_bytes;
        self.queued_bytes -= run_bytes;
        self.engine.count_queue(self.queued_bytes);
        let took = now.elapsed();
        connection.last_turn = took;
        self.ran_since += took;
        self.engine.count(connection.stream.session_mut());
        if !self.output.replies.is_empty() {
            self.engine.before_replies();
        }
        connection.reply(&mut self.output.replies, limit, &self.sender);
        self.slow -= usize::from(connection.is_slow);
        connection.is_slow = standing != Standing::Ended && connection.shorten_leases();
        self.slow += usize::from(connection.is_slow);
        if standing == Standing::Ended {
            self.end_connection(id);
        } else {
            if matches!(standing, Standing::WaitsFor(_)) {
                self.waiting.push(id);
            }
            self.with(id, |_| ());
        }
        if pace != Pace::Free {
            self.engine.show();
        }
        // A step takes as many turns, and pieces of input, as it needs; its connection's end is its end.
        let is_over = |step: &Step| {
            !self.connections.contains_key(&step.id) || self.progress_of(step.id, step.pace) > step.before
        };
        if self.step.as_ref().is_some_and(is_over) {
            self.step = None;
        }
    }

    fn end_connection(&mut self, id: Id) {
        if let Some(connection) = self.connections.remove(&id) {
            self.queued_bytes -= connection.queued_bytes;
            self.leaving.extend(connection.close(&mut self.engine));
            // Room that one client's replies took is not kept for the others.
            self.output.replies.shrink_to(KEPT_REPLY_BYTES);
        }
    }

    /// Closes the connections that were idle for the limit's time. Once a second, over all of them: bytes cost nothing more
    /// than a flag.
    fn close_idle(&mut self, now: Instant) {
        let Some(timeout) = self.engine.limits().idle_timeout else { return };
        if now < self.idle_scanned_at + IDLE_SCAN_EVERY {
            return;
        }
        self.idle_scanned_at = now;
        let is_timed_out = |(&id, c): (&Id, &mut Connection)| c.is_timed_out(now, timeout).then_some(id);
        let idle: Vec<Id> = self.connections.iter_mut().filter_map(is_timed_out).collect();
        for id in idle {
            if let Some(connection) = self.connections.get_mut(&id) {
                self.slow -= usize::from(std::mem::take(&mut connection.is_slow));
                let limit = self.engine.limits().reply_bytes;
                let mut farewell = connection.timeout_line(timeout).into_bytes();
                connection.reply(&mut farewell, limit, &self.sender);
            }
            self.engine.note_idle_close();
            self.end_connection(id);
        }
    }

    /// When the metrics are to be brought up to date: soon where something has happened, and now and then in any case, so
    /// that old ones mean a thread that is busy.
    fn metrics_due_at(&self) -> Instant {
        let period = if self.metrics_are_stale { metrics::UPDATE_EVERY } else { metrics::REFRESH_EVERY };
        self.metrics_at + period
    }

    /// Brings the metrics up to date, a few times a second and where there is a board for them.
    fn update_metrics(&mut self, now: Instant) {
        if now < self.metrics_due_at() {
            return;
        }
        let Some(board) = self.engine.metrics() else { return };
        let connections = || self.connections.values();
        let is_updated = board.update(now, |m| {
            self.engine.fill_metrics(m);
            m.queue_bytes = self.queued_bytes;
            m.reply_bytes = connections().map(|c| c.unread() as u64).sum();
            m.private_resource_bytes =
                connections().map(|c| metrics::resource_bytes(c.stream.session())).sum();
        });
        // Where it was being read it is tried again in a moment.
        if is_updated {
            (self.metrics_at, self.metrics_are_stale) = (now, false);
        }
    }

    /// Between turns of others, reads the sockets of those who ask for little: neither the readers' round nor the system,
    /// which may let many senders run before a reader, shall keep them waiting.
    fn read_brief(&mut self) {
        if self.ran_since < BRIEF_EVERY {
            return;
        }
        self.ran_since = Duration::ZERO;
        for _ in 0..BRIEF_AT_ONCE {
            let Some(next) = self.hand.next_brief() else { return };
            self.read_now(next);
        }
    }

    fn read_now(&mut self, next: Next) {
        // What came of this socket before comes first.
        self.receive_all();
        if let Some(message) = self.hand.read(next) {
            self.receive(message);
        }
    }

    /// Sleeps until there is something to do.
    fn wait(&mut self) {
        let until = self.next_deadline();
        if let Some(next) = self.hand.next() {
            self.read_now(next);
            return;
        }
        // There was none, or no buffer for it.
        self.hand.pass_on(None);
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
        if !self.working.is_empty() {
            self.jobs_until.into_iter().for_each(&mut at);
        }
        if !self.leaving.is_empty() {
            at(Instant::now() + Duration::from_millis(100));
        }
        if self.engine.limits().idle_timeout.is_some() && !self.connections.is_empty() {
            at(self.idle_scanned_at + IDLE_SCAN_EVERY);
        }
        if self.engine.metrics().is_some() {
            // Not at once where it was due and being read.
            at(self.metrics_due_at().max(Instant::now() + Duration::from_millis(1)));
        }
        if let Some(Finish::By(time)) = self.finish {
            at(time);
        }
        deadline
    }

    /// Gives up jobs that take too long.
    fn check_jobs(&mut self, now: Instant) {
        let limit = self.engine.limits().command_time;
        let mut next: Option<Instant> = None;
        for id in std::mem::take(&mut self.working) {
            let mut until = None;
            self.with(id, |c| until = c.check_job(now, limit));
            if let Some(until) = until {
                next = Some(next.map_or(until, |n| n.min(until)));
                self.working.push(id);
            }
        }
        self.jobs_until = next;
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
        if !self.working.is_empty() && self.jobs_until.is_none_or(|until| now >= until) {
            self.check_jobs(now);
        }
        self.close_idle(now);
        self.update_metrics(now);
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
        self.engine.set_cancel(CancelToken::default());
        self.engine.end();
        self.engine
    }
}

/// A step of a paused display: a frame or a command of one connection.
#[derive(Clone, Copy)]
struct Step {
    id: Id,
    pace: Pace,
    /// The connection's progress when it began.
    before: u64,
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

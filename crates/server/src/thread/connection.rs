//! A connection as the render thread sees it: its stream, its queued work, and where its replies
//! go.
//!
//! In: batches of bytes, typed commands, results of jobs. Out: replies in its reply queue or inbox,
//! notices for its owner. Runs on the render thread. Promises that work runs in the order of
//! arrival, and that nothing runs while the connection waits for a frame, a job or its client.

use super::work::Work;
use crate::jobs::Ticket;
use crate::message::{Batch, ConnectionSource, Item, Medium, Message, OpenConnection, Port};
use crate::record::RECORD_MAGIC;
use crate::replay::Replay;
use crate::reply_queue::ReplyQueue;
use crate::sniff::{Foreign, Sniffer, Verdict};
use crate::{Budget, Engine, Notice, Output, Stream, StreamState};
use crossbeam_channel::Sender;
use fbptr_command::{EndOfInput, LentPayload};
use fbptr_core::error::Fault;
use fbptr_core::input::InputEvent;
use fbptr_engine::engine::JobResult;
use fbptr_engine::stream::Resume;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Most bytes that an interactive connection has queued, and the longest time of its last slice:
/// its next slice is expected to be short.
const INTERACTIVE_BYTES: u64 = 8 << 10;
const INTERACTIVE_TIME: Duration = Duration::from_micros(200);

/// Longest reply that the render thread sends itself, if the client has read all earlier ones.
const SHORT_REPLY_BYTES: usize = 16 << 10;

/// Reply bytes at which a client that does not read is served nothing more, if no reply is longer: its
/// queries do not run ahead of its reading.
pub(super) const UNREAD_BYTES: usize = 256 << 10;

/// Time between checks of a job that waits for a worker.
const CHECK_JOBS: Duration = Duration::from_millis(100);

pub(super) struct Connection {
    pub id: u64,
    pub stream: Stream,
    /// Set until the first bytes show whether the stream is a recording; and the recording, if it
    /// is one.
    may_replay: bool,
    replay: Option<Replay>,
    /// Detects other protocols in the first bytes. TCP only: web pages cannot reach anything else.
    sniffer: Option<Sniffer>,
    medium: Medium,
    activity: Activity,
    work: VecDeque<Work>,
    /// Bytes in `work`.
    pub queued_bytes: u64,
    /// Set while the inbox has items that are not in `work` yet.
    has_mail: bool,
    mail: Vec<Item>,
    source: ConnectionSource,
    has_writer: bool,
    on_notice: Option<Box<dyn FnMut(Notice) + Send>>,
    on_end: Option<Box<dyn FnOnce() + Send>>,
    /// Set while it is in one of the scheduler's queues.
    pub is_queued: bool,
    /// Set if it had work left after its slice that is not in a pooled buffer.
    pub is_slow: bool,
    /// Duration of its last slice.
    pub last_slice: Duration,
    /// The number of the frame that it waits for.
    pub waits_for: Option<u64>,
    /// End of the pause that it has asked for.
    pub paused_until: Option<Instant>,
    /// The job that it waits for.
    job: Option<Ticket>,
    /// Set while it has begun a command that runs in pieces.
    pub is_in_pieces: bool,
    /// Set if its last slice was limited to queries, because another connection's command is in
    /// pieces.
    is_held: bool,
    /// Receiver of the reply to the running typed command, if the client waits for one.
    owed: Option<Sender<Result<Vec<u8>, Fault>>>,
    /// Set while it waits for its client to read replies.
    is_stalled: bool,
    is_ending: bool,
}

/// Activity of a connection, checked once a second to find idle ones.
struct Activity {
    /// Set if bytes have arrived since the last check.
    has_received: bool,
    /// Reply bytes that its client had not read at the last check.
    unread: usize,
    quiet_since: Instant,
}

/// A connection that has ended, while its transport still sends the last replies.
pub(super) struct ClosingConnection {
    pub reply_queue: Arc<ReplyQueue>,
    pub port: Box<dyn Port>,
    pub since: Instant,
    pub pending: usize,
}

impl Connection {
    pub fn new(engine: &Engine, id: u64, opening: OpenConnection) -> Self {
        let OpenConnection { audience, medium, may_replay, source, on_notice, on_end } = opening;
        if let ConnectionSource::Stream { reply_queue, .. } = &source {
            reply_queue.set_budget(engine.memory_budget());
        }
        Connection {
            id,
            stream: Stream::new(engine, id, audience),
            may_replay,
            replay: None,
            sniffer: (medium == Medium::TcpSocket).then(Sniffer::default),
            medium,
            activity: Activity { has_received: false, unread: 0, quiet_since: Instant::now() },
            work: VecDeque::new(),
            queued_bytes: 0,
            has_mail: false,
            mail: Vec::new(),
            source,
            has_writer: false,
            on_notice,
            on_end,
            is_queued: false,
            is_slow: false,
            last_slice: Duration::ZERO,
            waits_for: None,
            paused_until: None,
            job: None,
            is_in_pieces: false,
            is_held: false,
            owed: None,
            is_stalled: false,
            is_ending: false,
        }
    }

    pub fn add_bytes(&mut self, batch: Batch) {
        self.queued_bytes += batch.filled as u64;
        self.activity.has_received = true;
        self.work.push_back(Work::Bytes { batch, at: 0 });
    }

    pub fn add_payload(&mut self, payload: LentPayload) {
        self.activity.has_received = true;
        self.work.push_back(Work::Payload(payload));
    }

    /// Returns the pooled buffers of work that must wait longer than until the next slice: all of
    /// them if the connection waits for something, or if its slice ended within a batch. Returns
    /// whether it can run and has queued work without a pooled buffer.
    pub fn release_buffers(&mut self) -> bool {
        let is_parked = self.waits_for.is_some()
            || self.paused_until.is_some()
            || self.job.is_some()
            || self.is_stalled
            || self.is_in_pieces
            || self.is_held;
        if is_parked || matches!(self.work.front(), Some(Work::Bytes { at: 1.., .. })) {
            for work in &mut self.work {
                if let Work::Bytes { batch, at } = work
                    && batch.pooled.is_some()
                {
                    batch.unpool_from(std::mem::take(at));
                }
            }
        }
        let is_pooled = |work: &Work| matches!(work, Work::Bytes { batch, .. } if batch.pooled.is_some());
        self.is_runnable() && (self.has_mail || !self.work.iter().all(is_pooled))
    }

    pub fn add_end(&mut self, end: EndOfInput) {
        // Commands that an in-process client sent before the end come first.
        self.fetch_mail();
        self.work.push_back(Work::End(end));
    }

    pub fn add_mail(&mut self) {
        self.has_mail = true;
    }

    /// Ends the wait for the client to read replies, and if the client is gone, the waits for a frame
    /// and for a time, too.
    pub fn note_room(&mut self) {
        self.is_stalled = false;
        if let ConnectionSource::Stream { reply_queue, .. } = &self.source
            && reply_queue.has_failed()
        {
            self.stream.session_mut().is_unread = true;
            (self.waits_for, self.paused_until) = (None, None);
        }
    }

    /// Returns whether the client has sent all that it will send. It may be gone: a closed socket
    /// looks like one of which the sending side alone was closed.
    pub fn has_ended_input(&self) -> bool {
        matches!(self.work.back(), Some(Work::End(_)))
    }

    /// Returns whether there is work to run and nothing to wait for.
    pub fn is_runnable(&self) -> bool {
        (self.has_mail || !self.work.is_empty())
            && self.waits_for.is_none()
            && self.paused_until.is_none()
            && self.job.is_none()
            && !self.is_stalled
    }

    /// Returns whether its next slice is expected to be short, by its queued bytes and its last
    /// slice.
    pub fn is_interactive(&self) -> bool {
        let is_large = matches!(self.work.front(), Some(Work::Payload(_)));
        !is_large && self.queued_bytes <= INTERACTIVE_BYTES && self.last_slice <= INTERACTIVE_TIME
    }

    /// Returns whether everything received has run.
    pub fn is_idle(&self) -> bool {
        !self.has_mail && self.work.is_empty() && self.job.is_none()
    }

    /// Returns whether a socket has been idle for `timeout`, to within the second between checks:
    /// nothing was received and it waits for nothing from the server. Clients that listen to events
    /// are never idle; a client that does not read its replies is.
    pub fn is_timed_out(&mut self, now: Instant, timeout: Duration) -> bool {
        let unread = self.unread();
        let has_changed = std::mem::take(&mut self.activity.has_received)
            | (std::mem::replace(&mut self.activity.unread, unread) != unread);
        let is_working = self.job.is_some() || self.is_in_pieces || !(self.is_idle() || self.is_stalled);
        let is_paused = self.waits_for.is_some() || self.paused_until.is_some();
        let is_waiting = is_paused || self.stream.session().events;
        if has_changed || is_working || is_waiting || !self.medium.is_socket() {
            self.activity.quiet_since = now;
        }
        now.saturating_duration_since(self.activity.quiet_since) >= timeout
    }

    /// Returns the error line for a client that was idle for too long; empty if the client gets no
    /// error lines.
    pub fn timeout_line(&self, timeout: Duration) -> String {
        let (session, place) = (self.stream.session(), self.stream.place());
        match session.reports_errors() {
            true => {
                let (line, byte, seconds) = (place.line, place.byte, timeout.as_secs_f64());
                format!("ERR {line} {byte} EQUOTA CONNECT: idle for {seconds} seconds\n")
            }
            false => String::new(),
        }
    }

    /// Returns whether an end of input will still arrive, because reading was stopped.
    pub fn is_ending(&self) -> bool {
        self.is_ending
    }

    /// Runs one slice: at most `bytes` stream bytes, within the budget. Replies go to `out`.
    /// Returns the state after it, [`StreamState::Ended`] if the connection is over.
    pub fn run(
        &mut self,
        engine: &mut Engine,
        bytes: usize,
        budget: Budget,
        out: &mut Output,
    ) -> StreamState {
        if let ConnectionSource::Stream { reply_queue, .. } = &self.source
            // A command that holds up others continues even if its client does not read.
            && !self.is_in_pieces
            && reply_queue.is_full(budget.reply_bytes)
        {
            self.is_stalled = true;
            return StreamState::Yields;
        }
        let mut left = bytes;
        self.is_held = budget.only_asks;
        while left > 0 {
            if self.work.is_empty() && self.has_mail {
                self.fetch_mail();
            }
            let Some(work) = self.work.pop_front() else { return StreamState::Ready };
            if self.has_to_wait(&work, left, bytes) {
                self.work.push_front(work);
                return StreamState::Yields;
            }
            let state = match work {
                Work::Bytes { batch, at } => self.run_bytes(engine, batch, at, &mut left, budget, out),
                Work::Payload(payload) => {
                    let (used, state) = self.stream.take_back(engine, payload, out, budget);
                    left -= left.min(used);
                    self.give_back(None);
                    state
                }
                Work::Item(item) => {
                    left -= left.min(64);
                    self.run_item(engine, item, out, budget)
                }
                Work::Resume(resume) => self.resume(engine, resume, out, budget),
                Work::End(end) => {
                    if let Some(replay) = &mut self.replay {
                        replay.finish(engine, out);
                    }
                    self.stream.finish(engine, end, out)
                }
            };
            self.notify(&mut out.notices);
            match state {
                StreamState::Ready => {}
                StreamState::WaitsFor(frame) => {
                    self.waits_for = Some(frame);
                    return state;
                }
                StreamState::InPieces => {
                    self.is_in_pieces = true;
                    self.work.push_front(Work::Resume(Resume::Pieces));
                    return StreamState::Yields;
                }
                StreamState::Pauses(_) | StreamState::Yields | StreamState::Works | StreamState::Ended => {
                    return state;
                }
            }
        }
        StreamState::Yields
    }

    /// Returns whether work has to wait for another slice, of which `left` bytes of `bytes` are
    /// left.
    fn has_to_wait(&self, work: &Work, left: usize, bytes: usize) -> bool {
        match work {
            // A pooled batch is run in one slice: otherwise the rest of it would have to be copied.
            Work::Bytes { batch, at: 0 } => batch.pooled.is_some() && left < bytes.min(batch.filled),
            Work::Bytes { .. } => false,
            Work::Payload(_) | Work::Resume(_) | Work::End(_) => self.is_held,
            Work::Item(item) => self.is_held && !item.only_asks(),
        }
    }

    /// Runs a batch from `at` on, at most `left` bytes, and counts them off.
    fn run_bytes(
        &mut self,
        engine: &mut Engine,
        batch: Batch,
        at: usize,
        left: &mut usize,
        budget: Budget,
        out: &mut Output,
    ) -> StreamState {
        let end = batch.filled.min(at + *left);
        if std::mem::take(&mut self.may_replay) && batch.bytes()[..end].starts_with(RECORD_MAGIC) {
            self.replay = Some(Replay::new());
        }
        let piece = &batch.bytes()[at..end];
        let place = self.stream.place().byte;
        match self.sniffer.as_mut().map(|sniffer| sniffer.look(place, piece)) {
            None | Some(Verdict::Undecided) => {}
            Some(Verdict::Ours) => self.sniffer = None,
            Some(Verdict::Foreign(foreign)) => {
                self.give_back(Some(batch));
                return self.refuse_foreign(foreign, engine, out);
            }
        }
        let (used, state) = match &mut self.replay {
            Some(replay) => replay.feed(engine, piece, out, budget),
            None => self.stream.feed(engine, piece, out, budget),
        };
        *left -= used;
        self.queued_bytes -= used as u64;
        match at + used < batch.filled && state != StreamState::Ended {
            true => self.work.push_front(Work::Bytes { batch, at: at + used }),
            false => self.give_back(Some(batch)),
        }
        state
    }

    /// Goes on with a command that was interrupted.
    fn resume(
        &mut self,
        engine: &mut Engine,
        resume: Resume,
        out: &mut Output,
        budget: Budget,
    ) -> StreamState {
        self.is_in_pieces = false;
        let state = match &mut self.replay {
            Some(replay) => replay.resume(engine, resume, out, budget),
            None => self.stream.resume(engine, resume, out, budget),
        };
        if matches!(self.source, ConnectionSource::Inbox(_)) {
            self.answer(state, out);
        }
        state
    }

    /// Ends the connection of a client that speaks another protocol, with one error. None of its
    /// bytes have run.
    fn refuse_foreign(&mut self, foreign: Foreign, engine: &mut Engine, out: &mut Output) -> StreamState {
        engine.count_refused(self.stream.session_mut(), true);
        engine.counters.foreign_refused += 1;
        out.replies.extend_from_slice(foreign.reply().as_bytes());
        StreamState::Ended
    }

    fn run_item(&mut self, engine: &mut Engine, item: Item, out: &mut Output, budget: Budget) -> StreamState {
        match item {
            Item::Command(command) => {
                self.owed = None;
                let state = self.stream.run(engine, command, out, budget);
                self.answer(state, out);
                state
            }
            Item::Ask(command, answer) => {
                self.owed = Some(answer);
                let state = self.stream.run(engine, command, out, budget);
                self.answer(state, out);
                state
            }
            Item::Look(look) => {
                look(engine);
                StreamState::Ready
            }
        }
    }

    /// Sends the reply of a typed command to the client that waits for it, once it has taken
    /// effect.
    fn answer(&mut self, state: StreamState, out: &mut Output) {
        if matches!(state, StreamState::WaitsFor(_) | StreamState::Works | StreamState::InPieces) {
            return;
        }
        let Some(answer) = self.owed.take() else { return out.replies.clear() };
        let result = match out.notices.pop() {
            Some(Notice::Refused(refused)) => Err(refused.fault),
            _ => Ok(std::mem::take(&mut out.replies)),
        };
        // The client may be gone.
        let _ = answer.send(result);
    }

    /// Makes the connection wait for a job.
    pub fn wait_for_job(&mut self, ticket: Ticket) {
        self.job = Some(ticket);
    }

    /// Accepts the result of a finished job, if it is the one that the connection waits for.
    pub fn job_done(&mut self, number: u64, result: JobResult) {
        if self.job.as_ref().is_some_and(|ticket| ticket.number == number) {
            self.add_result(result);
        }
    }

    /// Ends the wait for a job: its result is the next work to run.
    pub fn add_result(&mut self, result: JobResult) {
        self.job = None;
        self.work.push_front(Work::Resume(Resume::Job(result)));
    }

    /// Returns the time that a job of this connection may take: none while it replays, since a
    /// recorded command had finished when it was recorded.
    pub fn job_limit(&self, limit: Duration) -> Option<Duration> {
        self.replay.is_none().then_some(limit)
    }

    /// Refuses the command whose job has run for longer than its limit. Returns the time of the
    /// next check if the connection still waits.
    pub fn check_job(&mut self, now: Instant) -> Option<Instant> {
        let ticket = self.job.as_ref().filter(|ticket| ticket.has_limit())?;
        let Some(until) = ticket.until() else { return Some(now + CHECK_JOBS) };
        if now < until {
            return Some(until);
        }
        ticket.cancel();
        let result = ticket.given_up();
        self.add_result(result);
        None
    }

    /// Answers the client that waited for this frame, and makes the connection runnable.
    pub fn frame_is_shown(&mut self, engine: &Engine, out: &mut Output) {
        if let Some(frame) = self.waits_for.take() {
            engine.answer_shown(frame, &mut out.replies);
            if let Some(owed) = self.owed.take() {
                // The client may be gone.
                let _ = owed.send(Ok(std::mem::take(&mut out.replies)));
            }
        }
    }

    fn fetch_mail(&mut self) {
        self.has_mail = false;
        if let ConnectionSource::Inbox(inbox) = &self.source {
            inbox.take(&mut self.mail);
            self.work.extend(self.mail.drain(..).map(Work::Item));
        }
    }

    /// Returns a batch, or notes that what was read into a payload has run.
    fn give_back(&mut self, batch: Option<Batch>) {
        if let ConnectionSource::Stream { recycle, .. } = &self.source {
            let (missing, stream) = (self.stream.missing_bytes(), &mut self.stream);
            recycle.put(batch, missing, &mut || stream.lend_payload());
        }
    }

    fn notify(&mut self, notices: &mut Vec<Notice>) {
        for notice in notices.drain(..) {
            match (&mut self.on_notice, &self.source, notice) {
                (Some(notify), _, notice) => notify(notice),
                (None, ConnectionSource::Inbox(inbox), Notice::Refused(refused)) => inbox.push_error(refused),
                (None, ..) => {}
            }
        }
    }

    /// Sends replies, or queues them for the writer, which is started with the first reply that
    /// cannot be sent at once.
    pub fn reply(&mut self, replies: &mut Vec<u8>, limit: usize, messages: &Sender<Message>) {
        if replies.is_empty() {
            return;
        }
        match &mut self.source {
            ConnectionSource::Inbox(_) => replies.clear(),
            ConnectionSource::Stream { reply_queue, port, .. } => {
                // Waking another thread takes longer than sending a short reply.
                if replies.len() <= SHORT_REPLY_BYTES && reply_queue.pending() == 0 {
                    let sent = port.send_now(replies);
                    replies.drain(..sent);
                    if replies.is_empty() {
                        return;
                    }
                }
                reply_queue.put(replies);
                if !std::mem::replace(&mut self.has_writer, true) {
                    let (id, messages) = (self.id, messages.clone());
                    // If the render thread has ended, nobody needs the message.
                    let on_room = move || drop(messages.send(Message::Room(id)));
                    let limit = limit.min(UNREAD_BYTES);
                    port.start_writer(reply_queue.clone(), limit, Box::new(on_room));
                }
            }
        }
    }

    /// Sends an event of the window. A client that does not read misses events, but no replies.
    pub fn push_event(&mut self, event: &InputEvent, limit: usize, messages: &Sender<Message>) {
        match &self.source {
            ConnectionSource::Inbox(inbox) => inbox.push_event(event),
            ConnectionSource::Stream { reply_queue, .. } if reply_queue.pending() < limit => {
                self.reply(&mut format!("{event}\n").into_bytes(), limit, messages);
            }
            ConnectionSource::Stream { .. } => {}
        }
    }

    /// Returns the number of reply bytes that the client has not read.
    pub fn unread(&self) -> usize {
        match &self.source {
            ConnectionSource::Inbox(_) => 0,
            ConnectionSource::Stream { reply_queue, .. } => reply_queue.pending(),
        }
    }

    /// Stops the transport's reading, if it can do that.
    pub fn stop_reading(&mut self) {
        if let ConnectionSource::Stream { port, .. } = &mut self.source {
            self.is_ending = port.stop_reading();
        }
    }

    /// Ends the connection and frees its state. Returns what is left while the last replies are
    /// sent.
    pub fn close(mut self, engine: &mut Engine) -> Option<ClosingConnection> {
        if let Some(ticket) = &self.job {
            ticket.cancel();
        }
        if self.is_in_pieces {
            match &mut self.replay {
                Some(replay) => replay.abandon(engine),
                None => self.stream.abandon(engine),
            }
        }
        engine.close(self.stream.session_mut());
        if let Some(on_end) = self.on_end.take() {
            on_end();
        }
        match self.source {
            ConnectionSource::Inbox(inbox) => {
                inbox.close();
                None
            }
            ConnectionSource::Stream { reply_queue, mut port, .. } => {
                reply_queue.close();
                if !self.has_writer {
                    port.end_without_writer(&reply_queue);
                }
                let pending = reply_queue.pending();
                Some(ClosingConnection { reply_queue, port, since: Instant::now(), pending })
            }
        }
    }
}

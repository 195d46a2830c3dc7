//! A connection as the render thread sees it: its stream, the work that waits, and where its replies go.

use super::message::{Batch, ConnectionSource, Item, Message, OpenConnection, Port};
use crate::command::EndOfInput;
use crate::error::{Code, Fault};
use crate::server::jobs::{JobResult, Ticket};
use crate::server::record::{RECORD_MAGIC, Replay};
use crate::server::reply_queue::ReplyQueue;
use crate::server::sniff::{Foreign, Sniffer, Verdict};
use crate::server::stream::Resume;
use crate::server::transport::Medium;
use crate::server::{Budget, Engine, InputEvent, Notice, Output, Stream, StreamState};
use crossbeam_channel::Sender;
use std::collections::VecDeque;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// A slice of so little work, after one of so little time, is expected to be short: the connection
/// is interactive.
const INTERACTIVE_BYTES: u64 = 8 << 10;
const INTERACTIVE_TIME: Duration = Duration::from_micros(200);

/// Replies of so many bytes are sent by the render thread itself, where the client has read those before.
const SHORT_REPLY_BYTES: usize = 16 << 10;

/// A job that waits for a worker is looked at this often.
const CHECK_JOBS: Duration = Duration::from_millis(100);

/// Something that waits to be run.
enum Work {
    Bytes {
        batch: Batch,
        at: usize,
    },
    Item(Item),
    /// The command in the middle of which it stands goes on. Comes before all else.
    Resume(Resume),
    End(EndOfInput),
}

pub(super) struct Connection {
    pub id: u64,
    pub stream: Stream,
    /// Whether the stream may be a recording, until its first bytes tell; and the recording, if it is one.
    may_replay: bool,
    replay: Option<Replay>,
    /// Looks for other protocols, until the first bytes tell. TCP alone: nothing else can be reached by a web page.
    sniffer: Option<Sniffer>,
    medium: Medium,
    activity: Activity,
    work: VecDeque<Work>,
    /// Bytes in `work`.
    pub queued_bytes: u64,
    /// The inbox has items that are not in `work` yet.
    has_mail: bool,
    mail: Vec<Item>,
    source: ConnectionSource,
    has_writer: bool,
    on_notice: Option<Box<dyn FnMut(Notice) + Send>>,
    on_end: Option<Box<dyn FnOnce() + Send>>,
    /// It is in one of the scheduler's queues.
    pub is_queued: bool,
    /// After its slice it had work left that holds no pooled buffer.
    pub is_slow: bool,
    /// How long its last slice took.
    pub last_slice: Duration,
    /// The frame that it waits for, and who asked, where that is an in-process client.
    pub waits_for: Option<u64>,
    /// The job that it waits for.
    job: Option<Ticket>,
    /// It is in the middle of a command that is run in pieces.
    pub is_in_pieces: bool,
    /// In its last slice, another one was.
    is_held: bool,
    /// Where the reply to a typed command goes, unless nobody asked.
    owed: Option<Sender<Result<Vec<u8>, Fault>>>,
    /// It waits for its client to read.
    is_stalled: bool,
    is_ending: bool,
}

/// What tells an idle connection from a busy one, looked at once a second.
struct Activity {
    /// Bytes have come since the last look.
    has_received: bool,
    /// Reply bytes that its client had not read at the last look.
    unread: usize,
    quiet_since: Instant,
}

/// A connection that is over, and whose transport is still busy with the last replies.
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

    /// Gives back the pooled buffers of what must wait longer than to the next slice: all of them
    /// when the connection waits for something, or when its slice ended within a batch. Returns
    /// whether it has work left that holds none.
    pub fn release_buffers(&mut self) -> bool {
        let is_parked = self.waits_for.is_some()
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
        // What an in-process client sent before it went comes first.
        self.fetch_mail();
        self.work.push_back(Work::End(end));
    }

    pub fn add_mail(&mut self) {
        self.has_mail = true;
    }

    pub fn note_room(&mut self) {
        self.is_stalled = false;
    }

    /// Whether there is something to run, and nothing to wait for.
    pub fn is_runnable(&self) -> bool {
        (self.has_mail || !self.work.is_empty())
            && self.waits_for.is_none()
            && self.job.is_none()
            && !self.is_stalled
    }

    /// Returns whether its slice will be short, by what waits and how the last one was.
    pub fn is_interactive(&self) -> bool {
        self.queued_bytes <= INTERACTIVE_BYTES && self.last_slice <= INTERACTIVE_TIME
    }

    /// Whether nothing that was received is left to run.
    pub fn is_idle(&self) -> bool {
        !self.has_mail && self.work.is_empty() && self.job.is_none()
    }

    /// Whether nothing has come from a socket and nothing was due to it for `timeout`, as far as looks once a second can
    /// tell. Listeners to events, who wait by trade, are never idle; a client that takes none of its replies is.
    pub fn is_timed_out(&mut self, now: Instant, timeout: Duration) -> bool {
        let unread = self.unread();
        let has_changed = std::mem::take(&mut self.activity.has_received)
            | (std::mem::replace(&mut self.activity.unread, unread) != unread);
        let is_working = self.job.is_some() || self.is_in_pieces || !(self.is_idle() || self.is_stalled);
        let is_waiting = self.waits_for.is_some() || self.stream.session().events;
        if has_changed || is_working || is_waiting || !self.medium.is_socket() {
            self.activity.quiet_since = now;
        }
        now.saturating_duration_since(self.activity.quiet_since) >= timeout
    }

    /// The line that tells a client that it was idle for too long; empty for one that is sent nothing unasked.
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

    /// Whether it will say when nothing more comes, because its reading was stopped.
    pub fn is_ending(&self) -> bool {
        self.is_ending
    }

    /// Commands that were run or refused.
    pub fn commands(&self) -> u64 {
        self.stream.session().stats.commands + self.replay.as_ref().map_or(0, Replay::commands)
    }

    /// Runs a slice of the work that waits, of at most `bytes` stream bytes and as the budget says; replies go to `out`.
    /// Answers how it stands: `Ended` when it is over.
    pub fn run(
        &mut self,
        engine: &mut Engine,
        bytes: usize,
        budget: Budget,
        out: &mut Output,
    ) -> StreamState {
        if let ConnectionSource::Stream { reply_queue, .. } = &self.source
            // What holds up others goes on whether its client reads or not.
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
            let state = match self.work.pop_front() {
                None => return StreamState::Ready,
                // A pooled one is run in one go: what is left of it would have to be copied.
                Some(Work::Bytes { batch, at: 0 })
                    if batch.pooled.is_some() && left < bytes.min(batch.filled) =>
                {
                    self.work.push_front(Work::Bytes { batch, at: 0 });
                    return StreamState::Yields;
                }
                Some(Work::Bytes { batch, at }) => {
                    let end = batch.filled.min(at + left);
                    if std::mem::take(&mut self.may_replay) && batch.bytes()[..end].starts_with(RECORD_MAGIC)
                    {
                        self.replay = Some(Replay::new());
                    }
                    let piece = &batch.bytes()[at..end];
                    let place = self.stream.place().byte;
                    match self.sniffer.as_mut().map(|sniffer| sniffer.look(place, piece)) {
                        None | Some(Verdict::Undecided) => {}
                        Some(Verdict::Ours) => self.sniffer = None,
                        Some(Verdict::Foreign(foreign)) => {
                            self.give_back(batch);
                            return self.refuse_foreign(foreign, engine, out);
                        }
                    }
                    let (used, state) = match &mut self.replay {
                        Some(replay) => replay.feed(engine, piece, out, budget),
                        None => self.stream.feed(engine, piece, out, budget),
                    };
                    left -= used;
                    self.queued_bytes -= used as u64;
                    match at + used < batch.filled && state != StreamState::Ended {
                        true => self.work.push_front(Work::Bytes { batch, at: at + used }),
                        false => self.give_back(batch),
                    }
                    state
                }
                Some(work @ (Work::Resume(_) | Work::End(_))) if self.is_held => {
                    self.work.push_front(work);
                    return StreamState::Yields;
                }
                Some(Work::Item(item)) if self.is_held && !item.only_asks() => {
                    self.work.push_front(Work::Item(item));
                    return StreamState::Yields;
                }
                Some(Work::Item(item)) => {
                    left -= left.min(64);
                    self.run_item(engine, item, out, budget)
                }
                Some(Work::Resume(resume)) => {
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
                Some(Work::End(end)) => {
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
                StreamState::Yields | StreamState::Works | StreamState::Ended => return state,
            }
        }
        StreamState::Yields
    }

    /// Ends the connection of a client that speaks another protocol: one error, and nothing of it has run.
    fn refuse_foreign(&mut self, foreign: Foreign, engine: &mut Engine, out: &mut Output) -> StreamState {
        let stats = &mut self.stream.session_mut().stats;
        stats.commands += 1;
        stats.errors += 1;
        engine.note_foreign();
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

    /// Gives the reply to a typed command to whoever asked, when it has taken effect.
    fn answer(&mut self, state: StreamState, out: &mut Output) {
        if matches!(state, StreamState::WaitsFor(_) | StreamState::Works | StreamState::InPieces) {
            return;
        }
        let Some(answer) = self.owed.take() else { return out.replies.clear() };
        let result = match out.notices.pop() {
            Some(Notice::Refused(refused)) => Err(refused.fault),
            _ => Ok(std::mem::take(&mut out.replies)),
        };
        // Whoever asked may be gone.
        let _ = answer.send(result);
    }

    /// It waits for this job from now on.
    pub fn wait_for_job(&mut self, ticket: Ticket) {
        self.job = Some(ticket);
    }

    /// A job is done: its result is what is run next, if it is the one that is waited for.
    pub fn job_done(&mut self, number: u64, result: JobResult) {
        if self.job.as_ref().is_some_and(|ticket| ticket.number == number) {
            self.add_result(result);
        }
    }

    /// The same where no worker could be had.
    pub fn add_result(&mut self, result: JobResult) {
        self.job = None;
        self.work.push_front(Work::Resume(Resume::Job(result)));
    }

    /// Refuses the command whose job has run since before `limit` ago. When to look again, if it waits for a job.
    pub fn check_job(&mut self, now: Instant, limit: Duration) -> Option<Instant> {
        // What was recorded was not given up, however long it takes here.
        let ticket = self.job.as_ref().filter(|_| self.replay.is_none())?;
        let Some(until) = ticket.begun().map(|begun| begun + limit) else { return Some(now + CHECK_JOBS) };
        if now < until {
            return Some(until);
        }
        ticket.cancel();
        let message = format!("given up after {} s, without effect", limit.as_secs_f64());
        self.add_result(JobResult::refused(Fault::new(Code::Quota, message)));
        None
    }

    /// The frame that it waited for is shown: answers, and goes on.
    pub fn frame_is_shown(&mut self, engine: &Engine, out: &mut Output) {
        if let Some(frame) = self.waits_for.take() {
            engine.answer_shown(frame, &mut out.replies);
            if let Some(owed) = self.owed.take() {
                // Whoever asked may be gone.
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

    fn give_back(&self, batch: Batch) {
        if let ConnectionSource::Stream { recycle, .. } = &self.source {
            recycle.put(batch, self.stream.missing_bytes());
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

    /// Sends replies, or hands them to the writer, which is started with the first that cannot be sent at once.
    pub fn reply(&mut self, replies: &mut Vec<u8>, limit: usize, messages: &Sender<Message>) {
        if replies.is_empty() {
            return;
        }
        match &mut self.source {
            ConnectionSource::Inbox(_) => replies.clear(),
            ConnectionSource::Stream { reply_queue, port, .. } => {
                // A change of threads takes longer than sending a short reply.
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
                    // A render thread that is gone needs no room.
                    let on_room = move || drop(messages.send(Message::Room(id)));
                    port.start_writer(reply_queue.clone(), limit, Box::new(on_room));
                }
            }
        }
    }

    /// Sends it an event; a client that does not read misses events, not replies.
    pub fn push_event(&mut self, event: &InputEvent, limit: usize, messages: &Sender<Message>) {
        match &self.source {
            ConnectionSource::Inbox(inbox) => inbox.push_event(event),
            ConnectionSource::Stream { reply_queue, .. } if reply_queue.pending() < limit => {
                self.reply(&mut format!("{event}\n").into_bytes(), limit, messages);
            }
            ConnectionSource::Stream { .. } => {}
        }
    }

    /// Bytes of replies that its client has not read.
    pub fn unread(&self) -> usize {
        match &self.source {
            ConnectionSource::Inbox(_) => 0,
            ConnectionSource::Stream { reply_queue, .. } => reply_queue.pending(),
        }
    }

    /// Ends the transport's reading, where that can be done.
    pub fn stop_reading(&mut self) {
        if let ConnectionSource::Stream { port, .. } = &mut self.source {
            self.is_ending = port.stop_reading();
        }
    }

    /// Ends the connection: frees its state and lets the last replies go.
    pub fn close(mut self, engine: &mut Engine) -> Option<ClosingConnection> {
        if let Some(ticket) = &self.job {
            ticket.cancel();
        }
        if self.is_in_pieces {
            let verb = self.replay.as_ref().map_or(self.stream.verb_in_pieces(), Replay::verb_in_pieces);
            verb.into_iter().for_each(|verb| engine.note_abandoned(verb));
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

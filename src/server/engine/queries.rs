//! Queries about the server, and the commands for frames, display, snapshots and recording.
//!
//! In: the engine's state. Out: replies; frames on the display; files in the snapshot folder.

use super::job::{Job, JobResult};
use super::{Effect, Engine, Progress};
use crate::command::{Command, SnapTarget, help_text};
use crate::error::{Code, Fault};
use crate::load::QuotaDir;
use crate::memory::{MemoryBudget, MemoryUse, SHARED_HEADER_BYTES, VideoMemory};
use crate::save::{self, SnapshotFormat};
use crate::server::metrics::{Metrics, MetricsBoard, RecordingState};
use crate::server::record::{RecordStats, Recorder};
use crate::server::snapshot_names::is_own_name;
use crate::server::{Display, Session};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

impl Engine {
    pub(super) fn help(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(help_text().as_bytes());
    }

    pub(super) fn hello(&self, out: &mut Vec<u8>) {
        let (w, h, stride) = (self.memory.width(), self.memory.height(), self.memory.stride_bytes());
        out.extend_from_slice(format!("HELLO fbptr 1 {w} {h} {stride} rgba\n").as_bytes());
    }

    /// Runs `STATS`: replies with one line of this connection's counters, the totals, the sizes of
    /// frame, buffers and resources, the layout of the shared file, and the states of its parts.
    pub(super) fn stats(&self, s: &Session, out: &mut Vec<u8>) {
        let mut totals = self.totals;
        totals += s.stats - s.counted;
        let depth_bytes = self.depth.as_ref().map_or(0, |d| d.size_bytes());
        let id_bytes = self.ids.as_ref().map_or(0, |i| i.size_bytes());
        let line = format!(
            "STATS {} {} queue={} connections={} width={} height={} shm_offset={SHARED_HEADER_BYTES} shm_stride={} \
             names={} resource_bytes={} shared_names={} shared_bytes={} memory_bytes={} depth_bytes={depth_bytes} \
             id_bytes={id_bytes} presents={} auto={} shm={} {} snap_bytes={} {} plan={}\n",
            s.stats.words(""),
            totals.words("total_"),
            self.queue_bytes,
            self.connections,
            self.memory.width(),
            self.memory.height(),
            self.memory.stride_bytes(),
            s.names.len(),
            s.names.size_bytes(),
            self.shared.len(),
            self.shared.size_bytes(),
            self.memory.bytes().len(),
            self.frames,
            if self.frozen > 0 { "off" } else { "on" },
            self.shared_word(),
            self.record_words(),
            self.snap_dir.as_ref().map_or(0, |folder| folder.used_bytes()),
            memory_words(&self.budget),
            self.plan,
        );
        out.extend_from_slice(line.as_bytes());
    }

    /// Counts commands by verb for `board`, which the render thread updates.
    pub fn set_metrics(&mut self, board: Arc<MetricsBoard>) {
        self.verb_counts.enable();
        self.metrics = Some(board);
    }

    /// Returns the metrics board, if there is one.
    pub fn metrics(&self) -> Option<&Arc<MetricsBoard>> {
        self.metrics.as_ref()
    }

    /// Fills in the metrics of the engine.
    pub(in crate::server) fn fill_metrics(&self, m: &mut Metrics) {
        m.totals = self.totals;
        m.connections = self.connections;
        m.idle_closes = self.idle_closes;
        m.foreign_refused = self.foreign_refused;
        m.frame_bytes = self.memory.bytes().len() as u64;
        m.depth_bytes = self.depth.as_ref().map_or(0, |d| d.size_bytes() as u64);
        m.id_bytes = self.ids.as_ref().map_or(0, |i| i.size_bytes() as u64);
        (m.memory_limit_bytes, m.memory_used_bytes) = (self.budget.limit(), self.budget.used());
        m.shared_resource_bytes = self.shared.size_bytes();
        let recorded;
        (m.recording, recorded) = self.recording();
        (m.recorded_bytes, m.record_queue_bytes) = (recorded.written_bytes, recorded.queued_bytes);
        m.snap_bytes = self.snap_dir.as_ref().map_or(0, |folder| folder.used_bytes());
        self.verb_counts.copy_to(&mut m.verbs);
    }

    /// Sets the number of received bytes that have not run, for `STATS`.
    pub fn set_queue_bytes(&mut self, bytes: u64) {
        self.queue_bytes = bytes;
    }

    pub(super) fn set_auto(&mut self, s: &mut Session, on: bool) {
        match (s.auto, on) {
            (true, false) => {
                // Pixels drawn before the freeze are still shown.
                self.show();
                self.frozen += 1;
            }
            (false, true) => self.frozen -= 1,
            _ => {}
        }
        s.auto = on;
    }

    pub(super) fn set_events(&mut self, s: &mut Session, on: bool) {
        match (s.events, on) {
            (false, true) => self.listeners += 1,
            (true, false) => self.listeners -= 1,
            _ => {}
        }
        s.events = on;
        if let Some(display) = &self.display {
            display.set_listeners(self.listeners);
        }
    }

    pub(super) fn present(&mut self, s: &mut Session, wait: bool, out: &mut Vec<u8>) -> Effect {
        self.frames += 1;
        s.stats.frames += 1;
        self.publish_frame();
        if let Some(action) = &mut self.on_present.0 {
            action(&self.memory);
        }
        self.publish();
        match (wait, &self.display) {
            (true, Some(display)) if !display.is_closed() => Effect::WaitShown(self.frames),
            (true, _) => {
                self.answer_shown(self.frames, out);
                Effect::Done
            }
            (false, _) => Effect::Done,
        }
    }

    /// Appends the reply to `PRESENT wait`, after `frame` was shown.
    pub fn answer_shown(&self, frame: u64, out: &mut Vec<u8>) {
        out.extend_from_slice(format!("FRAME {frame}\n").as_bytes());
    }

    /// Returns whether `PRESENT wait` for `frame` can be answered.
    pub fn is_shown(&self, frame: u64) -> bool {
        self.display.as_ref().is_none_or(|d| d.is_closed() || d.frame_on_screen() >= frame)
    }

    /// Shows the rows that changed, unless a connection has frozen the display.
    pub fn show(&mut self) {
        if self.frozen == 0 && self.has_unshown() {
            self.publish();
        }
    }

    /// Returns whether rows have changed since the display was last updated.
    pub fn has_unshown(&mut self) -> bool {
        self.collect_damage();
        self.display.is_some() && self.unshown.start < self.unshown.end
    }

    /// Returns whether a connection has frozen the display until its next `PRESENT`.
    pub fn is_frozen(&self) -> bool {
        self.frozen > 0
    }

    /// Returns the display, if there is one.
    pub fn display(&self) -> Option<&Arc<Display>> {
        self.display.as_ref()
    }

    /// Removes the display; the engine continues without it.
    pub fn drop_display(&mut self) {
        self.display = None;
    }

    /// Does periodic work on the shared file and the recording. Must be called at
    /// [`Engine::next_deadline`] at the latest.
    pub fn tick(&mut self, now: Instant) {
        self.tick_shared(now);
        if let Some(recorder) = &mut self.recorder {
            recorder.tick(now);
            if recorder.has_failed() {
                self.drop_recorder();
            }
        }
        self.count_records();
    }

    /// Reserves memory for recorded bytes that are not in their file, also those of a failed
    /// recording, as long as its writer holds them.
    fn count_records(&mut self) {
        if self.recorder.is_some() || self.record_failure.is_some() {
            let (_, stats) = self.recording();
            self.held.records.set(stats.queued_bytes);
        }
    }

    /// Returns the time of the next [`Engine::tick`], if one is needed.
    pub fn next_deadline(&self, now: Instant) -> Option<Instant> {
        let recorded = self.recorder.as_ref().and_then(|r| r.next_deadline());
        [self.shared_deadline(now), recorded].into_iter().flatten().min()
    }

    /// Records all later commands, after the current contents of the memory.
    pub fn set_recorder(&mut self, recorder: Recorder) {
        self.recorder = Some(recorder);
        self.record_memory();
    }

    /// Records the memory's contents, unless it is in the state in which a replay begins.
    pub(super) fn record_memory(&mut self) {
        let Some(recorder) = &mut self.recorder else { return };
        if self.memory.bytes().as_chunks::<4>().0.iter().any(|p| *p != VideoMemory::CLEAR) {
            let all: Vec<usize> = (0..self.memory.bytes().len() / 4).collect();
            recorder.foreign_pixels(&all, &self.memory);
        }
    }

    /// Records the contents of rows of the memory, as foreign pixels.
    pub(super) fn record_rows(&mut self, rows: Range<u32>) {
        let Some(recorder) = &mut self.recorder else { return };
        let stride = self.memory.stride_bytes();
        let at_once = (RECORDED_BYTES / stride).max(1);
        for y in rows.clone().step_by(at_once) {
            let end = rows.end.min(y + at_once as u32);
            recorder.pixel_run(
                0,
                0,
                y as u16,
                &self.memory.bytes()[y as usize * stride..end as usize * stride],
            );
        }
    }

    /// Sets the time of the following commands in the recording.
    pub fn set_time(&mut self, now: Instant) {
        if let Some(recorder) = &mut self.recorder {
            recorder.set_time(now);
        }
    }

    /// Returns the state and the counters of the recording, also of a failed one.
    fn recording(&self) -> (RecordingState, RecordStats) {
        match (&self.recorder, &self.record_failure) {
            (Some(recorder), _) if recorder.has_failed() => (RecordingState::Failed, recorder.stats()),
            (Some(recorder), _) => (RecordingState::On, recorder.stats()),
            (None, Some(failed)) => (RecordingState::Failed, failed.stats()),
            (None, None) => (RecordingState::Off, RecordStats::default()),
        }
    }

    /// Formats the recording's state for `STATS`.
    fn record_words(&self) -> String {
        let (state, bytes) = self.recording();
        let state = match state {
            RecordingState::Off => "off",
            RecordingState::On => "ok",
            RecordingState::Failed => "failed",
        };
        format!("record={state} record_bytes={} record_queue={}", bytes.written_bytes, bytes.queued_bytes)
    }

    /// Returns the reason why the recording ended early, if it did.
    pub fn record_failure(&self) -> Option<&str> {
        self.record_failure.as_ref().map(|failed| failed.reason.as_str())
    }

    /// Removes the recorder, and keeps its counters and the reason of its failure.
    fn drop_recorder(&mut self) {
        if let Some(recorder) = self.recorder.take() {
            self.record_failure = recorder.failure();
        }
    }

    /// Ends the engine's output: writes the last pixels to the shared file, and completes the
    /// recording.
    pub fn end(&mut self) {
        self.leave_shared();
        if let Some(recorder) = &mut self.recorder {
            recorder.finish();
            self.drop_recorder();
        }
        self.count_records();
    }

    /// Sends the rows that changed to the display, with the frame number.
    fn publish(&mut self) {
        self.collect_damage();
        let rows = std::mem::replace(&mut self.unshown, NO_ROWS);
        if let Some(display) = &self.display {
            display.publish(&self.memory, rows, self.frames, self.depth.as_ref());
        }
    }

    /// Adds the rows that changed in the memory to those due for the display and for the shared
    /// file.
    pub(super) fn collect_damage(&mut self) {
        let rows = self.memory.take_damage();
        if rows.start < rows.end {
            self.unshown = join(&self.unshown, &rows);
            self.owe_shared(&rows);
        }
    }

    /// Runs `SNAP`: copies the frame, which a job then encodes.
    pub(super) fn snap_job(&self, target: SnapTarget) -> Result<Progress, Fault> {
        let (w, h) = (self.memory.width(), self.memory.height());
        let folder = match (&target, &self.snap_dir) {
            (SnapTarget::Connection, _) => None,
            (SnapTarget::File(_), Some(folder)) => Some(folder.clone()),
            (SnapTarget::File(name), None) => {
                return Err(
                    Fault::new(Code::Perm, "snapshots need a folder, and there is none").got(name.as_str())
                );
            }
        };
        if let SnapTarget::File(name) = &target
            && self.reserves_snapshot_names
            && is_own_name(name)
        {
            let message = "names like wall-20260131-235959.png are the server's own here";
            return Err(Fault::new(Code::Perm, message).got(name.as_str()));
        }
        let is_small = folder.is_none() && u64::from(w) * u64::from(h) <= SMALL_SNAP_PIXELS;
        // The copy of the frame, its rows as they are packed, and the encoded file.
        let bytes = 3 * self.memory.bytes().len() as u64 + SNAP_BYTES;
        let mut held = self.budget.try_reserve(MemoryUse::Replies, bytes)?;
        let frame = self.memory.clone();
        Ok(Progress::Job(Job::new(is_small, move |_| {
            let reply = match (&target, &folder) {
                (SnapTarget::File(name), Some(folder)) => snap_file(folder, name, &frame),
                _ => {
                    let mut png = Vec::new();
                    save::png(&frame, &mut png).expect("a Vec takes all bytes");
                    let mut reply = format!("SNAP {w} {h} png :{}\n", png.len()).into_bytes();
                    reply.append(&mut png);
                    Ok(reply)
                }
            };
            drop(frame);
            let answered = |mut reply: Vec<u8>| {
                held.shrink_to(reply.len() as u64);
                move |_: &mut Engine, _: &mut Session, out: &mut Vec<u8>| {
                    match out.is_empty() {
                        true => std::mem::swap(out, &mut reply),
                        false => out.append(&mut reply),
                    }
                    drop(held);
                    Ok(Progress::Done(Effect::Done))
                }
            };
            JobResult::new(Command::Snap(target), reply.map(answered))
        })))
    }
}

/// Formats the memory budget as `key=value` words: its limit, its used bytes, and those of each
/// use.
fn memory_words(budget: &MemoryBudget) -> String {
    let mut words = format!("memory_limit={} memory_used={}", budget.limit(), budget.used());
    for purpose in MemoryUse::ALL {
        words += &format!(" memory_{}={}", purpose.as_str(), budget.used_for(purpose));
    }
    words
}

/// Working memory for encoding a frame, in bytes beside its pixels.
const SNAP_BYTES: u64 = 1 << 20;

/// Most bytes of rows that are recorded as one command.
const RECORDED_BYTES: usize = 4 << 20;

/// Most pixels of a frame that is encoded within some 100 us.
const SMALL_SNAP_PIXELS: u64 = 1 << 12;

/// Writes a frame into the snapshot folder. Returns the reply.
fn snap_file(folder: &QuotaDir, name: &str, frame: &VideoMemory) -> Result<Vec<u8>, Fault> {
    // The folder is checked first: an error of permission comes before one of format.
    let path = folder.folder().path_to_write(name)?;
    let format = SnapshotFormat::of_path(path.as_path())
        .map_err(|e| Fault::new(e.code(), "a snapshot's name ends in .png, .ppm or .raw").got(name))?;
    folder.write(name, |out| format.write(frame, out))?;
    let (w, h, crc) = (frame.width(), frame.height(), save::crc32(frame));
    Ok(format!("SNAP {name} {w} {h} {crc:08x}\n").into_bytes())
}

/// An empty range of rows, which leaves any range unchanged in [`join`].
pub(super) const NO_ROWS: Range<u32> = Range { start: u32::MAX, end: 0 };

/// Returns the smallest range that contains both.
pub(super) fn join(a: &Range<u32>, b: &Range<u32>) -> Range<u32> {
    a.start.min(b.start)..a.end.max(b.end)
}

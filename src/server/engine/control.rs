//! Queries about the server, frames, the display, snapshots.

use super::{Effect, Engine};
use crate::command::{SnapTarget, help_text};
use crate::error::{Code, Fault};
use crate::memory::{SHARED_HEADER_BYTES, VideoMemory};
use crate::save::{self, SnapshotFormat};
use crate::server::record::Recorder;
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

    /// One line: this connection's counters, those of all, what there is, and where the shared file's pixels begin.
    pub(super) fn stats(&self, s: &Session, out: &mut Vec<u8>) {
        let mut totals = self.totals;
        totals += s.stats - s.counted;
        let depth_bytes = self.depth.as_ref().map_or(0, |d| d.size_bytes());
        let id_bytes = self.ids.as_ref().map_or(0, |i| i.size_bytes());
        let line = format!(
            "STATS {} {} queue={} connections={} width={} height={} shm_offset={SHARED_HEADER_BYTES} shm_stride={} \
             names={} resource_bytes={} shared_names={} shared_bytes={} memory_bytes={} depth_bytes={depth_bytes} \
             id_bytes={id_bytes} presents={} auto={} shm={} {} snap_bytes={} plan={}\n",
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
            self.plan,
        );
        out.extend_from_slice(line.as_bytes());
    }

    /// Tells the engine how many bytes wait to be run, for `STATS`.
    pub fn set_queue_bytes(&mut self, bytes: u64) {
        self.queue_bytes = bytes;
    }

    pub(super) fn set_auto(&mut self, s: &mut Session, on: bool) {
        match (s.auto, on) {
            (true, false) => {
                // What was drawn before is still seen.
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
        self.tell_frame();
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

    /// The answer to `PRESENT wait` once `frame` is shown.
    pub fn answer_shown(&self, frame: u64, out: &mut Vec<u8>) {
        out.extend_from_slice(format!("FRAME {frame}\n").as_bytes());
    }

    /// Whether `PRESENT wait` for `frame` can be answered.
    pub fn is_shown(&self, frame: u64) -> bool {
        self.display.as_ref().is_none_or(|d| d.is_closed() || d.frame_on_screen() >= frame)
    }

    /// Shows what changed, unless some connection keeps the display frozen.
    pub fn show(&mut self) {
        if self.frozen == 0 && self.has_unshown() {
            self.publish();
        }
    }

    /// Whether something was drawn that the display has not been given.
    pub fn has_unshown(&mut self) -> bool {
        self.collect_damage();
        self.display.is_some() && self.unshown.start < self.unshown.end
    }

    /// Whether a connection keeps the display frozen until `PRESENT`.
    pub fn is_frozen(&self) -> bool {
        self.frozen > 0
    }

    /// The display, if there is one.
    pub fn display(&self) -> Option<&Arc<Display>> {
        self.display.as_ref()
    }

    /// Goes on without the display.
    pub fn drop_display(&mut self) {
        self.display = None;
    }

    /// To be called from time to time, at [`Engine::next_deadline`] at the latest.
    pub fn tick(&mut self, now: Instant) {
        self.tick_shared(now);
        let Some(recorder) = &mut self.recorder else { return };
        recorder.tick(now);
        if recorder.has_failed() {
            self.drop_recorder();
        }
    }

    /// When [`Engine::tick`] is wanted next, if at all.
    pub fn next_deadline(&self, now: Instant) -> Option<Instant> {
        let recorded = self.recorder.as_ref().and_then(|r| r.next_deadline());
        [self.shared_deadline(now), recorded].into_iter().flatten().min()
    }

    /// Records what is executed from now on; what the memory holds already comes first.
    pub fn set_recorder(&mut self, recorder: Recorder) {
        self.recorder = Some(recorder);
        self.record_memory();
    }

    /// Notes the whole memory where it is not as a player finds it.
    pub(super) fn record_memory(&mut self) {
        let Some(recorder) = &mut self.recorder else { return };
        if self.memory.bytes().as_chunks::<4>().0.iter().any(|p| *p != VideoMemory::CLEAR) {
            let all: Vec<usize> = (0..self.memory.bytes().len() / 4).collect();
            recorder.foreign_pixels(&all, &self.memory);
        }
    }

    /// What follows happens at `now`, for the recording.
    pub fn set_time(&mut self, now: Instant) {
        if let Some(recorder) = &mut self.recorder {
            recorder.set_time(now);
        }
    }

    /// The recording's state as words of `STATS`.
    fn record_words(&self) -> String {
        let state = match (&self.recorder, &self.record_failure) {
            (Some(recorder), _) if recorder.has_failed() => "failed",
            (Some(_), _) => "ok",
            (None, Some(_)) => "failed",
            (None, None) => "off",
        };
        let bytes = self.recorder.as_ref().map(Recorder::stats).unwrap_or_default();
        format!("record={state} record_bytes={} record_queue={}", bytes.written_bytes, bytes.queued_bytes)
    }

    /// Why the recording ended early, if it did.
    pub fn record_failure(&self) -> Option<&str> {
        self.record_failure.as_deref()
    }

    /// Goes on without the recorder; keeps the reason why it failed.
    fn drop_recorder(&mut self) {
        if let Some(recorder) = self.recorder.take() {
            self.record_failure = recorder.failure();
        }
    }

    /// The end: the shared file has the last pixels, the recording its last commands.
    pub fn end(&mut self) {
        self.leave_shared();
        if let Some(recorder) = &mut self.recorder {
            recorder.finish();
            self.drop_recorder();
        }
    }

    /// Gives the display what it has not got yet, with the frame number.
    fn publish(&mut self) {
        self.collect_damage();
        let rows = std::mem::replace(&mut self.unshown, NO_ROWS);
        if let Some(display) = &self.display {
            display.publish(&self.memory, rows, self.frames, self.depth.as_ref());
        }
    }

    /// Moves the memory's damage to those who wait for it.
    pub(super) fn collect_damage(&mut self) {
        let rows = self.memory.take_damage();
        if rows.start < rows.end {
            self.unshown = join(&self.unshown, &rows);
            self.owe_shared(&rows);
        }
    }

    pub(super) fn snap(&self, target: SnapTarget, out: &mut Vec<u8>) -> Result<(), Fault> {
        let (w, h) = (self.memory.width(), self.memory.height());
        match target {
            SnapTarget::Connection => {
                let mut png = Vec::new();
                save::png(&self.memory, &mut png).expect("a Vec takes all bytes");
                self.check_reply(png.len() as u64)?;
                out.extend_from_slice(format!("SNAP {w} {h} png :{}\n", png.len()).as_bytes());
                out.extend_from_slice(&png);
            }
            SnapTarget::File(name) => {
                let Some(folder) = &self.snap_dir else {
                    return Err(
                        Fault::new(Code::Perm, "snapshots need a folder, and there is none").got(name)
                    );
                };
                // The folder first: what is not allowed at all is no question of formats.
                let path = folder.folder().path_to_write(&name)?;
                let format = SnapshotFormat::of_path(path.as_path()).map_err(|e| {
                    Fault::new(e.code(), "a snapshot's name ends in .png, .ppm or .raw").got(&*name)
                })?;
                folder.write(&name, |out| format.write(&self.memory, out))?;
                let crc = save::crc32(&self.memory);
                out.extend_from_slice(format!("SNAP {name} {w} {h} {crc:08x}\n").as_bytes());
            }
        }
        Ok(())
    }
}

/// No rows: below its start and above its end.
pub(super) const NO_ROWS: Range<u32> = Range { start: u32::MAX, end: 0 };

/// The smallest range that holds both.
pub(super) fn join(a: &Range<u32>, b: &Range<u32>) -> Range<u32> {
    a.start.min(b.start)..a.end.max(b.end)
}

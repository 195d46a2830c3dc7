//! Queries about the server, and the commands for frames, events and snapshots.
//!
//! In: the engine's state. Out: replies; ends of frames, to the observers; files in the snapshot
//! folder.

use super::job::{Job, JobResult};
use super::{Call, Effect, Engine, Event, Progress};
use crate::Session;
use crate::snapshot_names::is_own_name;
use fbptr_command::{Command, SnapTarget, help_on, help_text};
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{MemoryBudget, MemoryError, MemoryUse, VideoMemory};
use fbptr_formats::load::QuotaDir;
use fbptr_formats::save::{self, SnapshotFormat};

impl Engine {
    pub(super) fn help(&self, call: &mut Call<'_>) {
        call.replies.extend_from_slice(help_text().as_bytes());
    }

    pub(super) fn help_on(&self, call: &mut Call<'_>, verb: String) -> Result<(), Fault> {
        call.replies.extend_from_slice(help_on(&verb)?.as_bytes());
        Ok(())
    }

    pub(super) fn hello(&self, call: &mut Call<'_>) {
        let (w, h, stride) =
            (self.framebuffer.width(), self.framebuffer.height(), self.framebuffer.memory.stride_bytes());
        call.answer(format_args!("HELLO fbptr 1 {w} {h} {stride} rgba"));
    }

    pub(super) fn version(&self, call: &mut Call<'_>) {
        call.answer(format_args!("VERSION fbptr {}", env!("CARGO_PKG_VERSION")));
    }

    pub(super) fn depth_at(&self, call: &mut Call<'_>, x: i32, y: i32) -> Result<(), MemoryError> {
        self.framebuffer.memory.get_pixel(x, y)?;
        let z = self.framebuffer.depth.as_ref().and_then(|d| d.z(x, y)).unwrap_or(1.0);
        call.answer(format_args!("DEPTHAT {x} {y} {}", nine_digits(z)));
        Ok(())
    }

    pub(super) fn pick(&self, call: &mut Call<'_>, x: i32, y: i32) -> Result<(), MemoryError> {
        self.framebuffer.memory.get_pixel(x, y)?;
        match self.framebuffer.face_at(x, y) {
            Some((name, triangle)) => call.answer(format_args!("PICK {x} {y} {name} {triangle}")),
            None => call.answer(format_args!("PICK {x} {y} none -1")),
        }
        Ok(())
    }

    /// Runs `STATS`: replies with one line of this connection's counters, the totals, the sizes of
    /// frame, buffers and resources, and the states of the outputs.
    pub(super) fn stats(&self, call: &mut Call<'_>) {
        let s = &*call.session;
        let status = self.status();
        let mut totals = status.totals;
        totals += s.stats - s.counted;
        let outputs: String = status.outputs.iter().map(|output| output.words() + " ").collect();
        let line = format!(
            "STATS {} {} queue={} connections={} width={} height={} names={} resource_bytes={} \
             shared_names={} shared_bytes={} memory_bytes={} depth_bytes={} id_bytes={} presents={} \
             auto={} {outputs}snap_bytes={} {} view={} plan={}\n",
            s.stats.words(""),
            totals.words("total_"),
            self.counters.queue_bytes,
            status.connections,
            self.framebuffer.width(),
            self.framebuffer.height(),
            s.names.len(),
            s.names.size_bytes() + s.surfaces.bytes(),
            self.resources.shared.len(),
            status.shared_resource_bytes,
            status.frame_bytes,
            status.depth_bytes,
            status.id_bytes,
            self.counters.frames,
            if self.counters.frozen > 0 { "off" } else { "on" },
            status.snap_bytes,
            memory_words(&self.quotas.budget),
            s.default_view.word(),
            self.rendering.plan,
        );
        call.replies.extend_from_slice(line.as_bytes());
    }

    pub(super) fn set_auto(&mut self, s: &mut Session, on: bool) {
        match (s.auto, on) {
            (true, false) => {
                // Pixels drawn before the freeze are still shown.
                self.show();
                self.counters.frozen += 1;
            }
            (false, true) => self.counters.frozen -= 1,
            _ => {}
        }
        s.auto = on;
    }

    pub(super) fn set_events(&mut self, s: &mut Session, on: bool) {
        match (s.events, on) {
            (false, true) => self.counters.listeners += 1,
            (true, false) => self.counters.listeners -= 1,
            _ => {}
        }
        s.events = on;
        self.send(&Event::Listeners(self.counters.listeners));
    }

    pub(super) fn present(&mut self, call: &mut Call<'_>, wait: bool) -> Effect {
        self.counters.frames += 1;
        call.stats.frames += 1;
        self.send_present();
        match wait {
            true if !self.is_shown(self.counters.frames) => return Effect::WaitShown(self.counters.frames),
            true => self.answer_shown(self.counters.frames, call.replies),
            false => {}
        }
        Effect::Done
    }

    /// Appends the reply to `PRESENT wait`, after `frame` was shown.
    pub fn answer_shown(&self, frame: u64, out: &mut Vec<u8>) {
        out.extend_from_slice(format!("FRAME {frame}\n").as_bytes());
    }

    /// Returns whether a connection has frozen the display until its next `PRESENT`.
    pub fn is_frozen(&self) -> bool {
        self.counters.frozen > 0
    }

    /// Runs `SNAP`: copies the frame, which a job then encodes.
    pub(super) fn snap_job(&self, _: &mut Session, target: SnapTarget) -> Result<Progress, Fault> {
        let (w, h) = (self.framebuffer.width(), self.framebuffer.height());
        let folder = match (&target, &self.resources.snap_dir) {
            (SnapTarget::Connection, _) => None,
            (SnapTarget::File(_), Some(folder)) => Some(folder.clone()),
            (SnapTarget::File(name), None) => {
                return Err(Fault::new(
                    Code::Perm,
                    "snapshots need a folder (--snap-dir), and there is none",
                )
                .got(name.as_str()));
            }
        };
        if let SnapTarget::File(name) = &target
            && self.resources.reserves_snapshot_names
            && is_own_name(name)
        {
            let message = "names like wall-20260131-235959.png are the server's own here";
            return Err(Fault::new(Code::Perm, message).got(name.as_str()));
        }
        let is_small = folder.is_none() && u64::from(w) * u64::from(h) <= SMALL_SNAP_PIXELS;
        // The copy of the frame, its rows as they are packed, and the encoded file.
        let bytes = 3 * self.framebuffer.memory.bytes().len() as u64 + SNAP_BYTES;
        let mut held = self.quotas.budget.try_reserve(MemoryUse::Replies, bytes)?;
        let frame = self.framebuffer.memory.clone();
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

/// Formats a number from 0 to 1 with nine significant digits, without an exponent.
fn nine_digits(z: f64) -> String {
    // The exponent form rounds first: 0.99999999996 becomes 1.00000000.
    let rounded = format!("{z:.8e}");
    let exponent: i32 = rounded.split_once('e').and_then(|(_, e)| e.parse().ok()).unwrap_or(0);
    let decimals = if z == 0.0 { 8 } else { (8 - exponent).max(0) as usize };
    format!("{z:.decimals$}")
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depths_have_nine_significant_digits() {
        for (z, text) in [
            (0.0, "0.00000000"),
            (1.0, "1.00000000"),
            (0.998_001_998_001_998, "0.998001998"),
            (0.099_999_999_99, "0.100000000"),
            (0.999_999_999_96, "1.00000000"),
            (1.234_567_891e-5, "0.0000123456789"),
        ] {
            assert_eq!(nine_digits(z), text);
        }
    }
}

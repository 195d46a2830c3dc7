//! Periodic snapshots: the frame as a PNG at regular intervals, in a folder of bounded size.
//!
//! In: copies of the frame, made on the render thread between two slices, in a buffer that is
//! reused. Out: files `wall-YYYYMMDD-HHMMSS.png` (UTC), each of which appears complete or not at
//! all; the oldest are removed when all of them together exceed the bound. Encoding, writing and
//! removing run on a thread of their own, so a slow disk delays pictures and nothing else. Promise:
//! no file of another name is touched. An interval that passes while a picture is being written has
//! no picture.

use super::message::Message;
use super::thread::RenderThread;
use crossbeam_channel::{RecvTimeoutError, Sender, bounded};
use fbptr_core::memory::VideoMemory;
use fbptr_engine::snapshot_names::{MOST_A_SECOND, format_name, parse_name};
use fbptr_formats::load::SandboxDir;
use fbptr_formats::save;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// Block size of disks, to which the sizes of files are rounded up, in bytes.
const BLOCK_BYTES: u64 = 4096;
/// Longest time to wait at the end for a picture that is being written.
const PATIENCE: Duration = Duration::from_millis(500);

/// Folder, interval and bound of periodic snapshots.
#[derive(Clone, Debug)]
pub struct SnapshotPlan {
    /// Folder of the pictures.
    pub folder: SandboxDir,
    /// Time between two pictures.
    pub every: Duration,
    /// Most bytes of all pictures together, in blocks of 4096.
    pub keep_bytes: u64,
}

/// Handle of the thread that writes pictures. Dropping it ends the thread.
#[derive(Debug)]
pub struct PeriodicSnapshots {
    stop: Option<Sender<()>>,
    thread: JoinHandle<()>,
}

impl PeriodicSnapshots {
    /// Starts the thread; the first picture is due after one interval. `say` is called with
    /// failures, once for consecutive failures of the same kind.
    ///
    /// # Errors
    /// If the system has no thread to give.
    pub fn start(
        thread: &RenderThread,
        plan: SnapshotPlan,
        mut say: impl FnMut(String) + Send + 'static,
    ) -> io::Result<PeriodicSnapshots> {
        let (stop, stopped) = bounded::<()>(0);
        let messages = thread.link().messages;
        let run = move || {
            let mut camera = Camera { messages, buffer: None };
            let mut last_failure = String::new();
            let mut due = Instant::now() + plan.every;
            while let Err(RecvTimeoutError::Timeout) = stopped.recv_deadline(due) {
                // The render thread has ended.
                let Some(frame) = camera.take() else { return };
                let failure = plan.write(frame, SystemTime::now()).err().unwrap_or_default();
                if !failure.is_empty() && failure != last_failure {
                    say(failure.clone());
                }
                last_failure = failure;
                due = (due + plan.every).max(Instant::now());
            }
        };
        let thread = Builder::new().name("snapshots".into()).spawn(run)?;
        Ok(PeriodicSnapshots { stop: Some(stop), thread })
    }
}

impl Drop for PeriodicSnapshots {
    fn drop(&mut self) {
        self.stop = None;
        let until = Instant::now() + PATIENCE;
        // A slower picture is abandoned with the process; its temporary file is removed at the next
        // start.
        while !self.thread.is_finished() && Instant::now() < until {
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Copies frames from the render thread.
struct Camera {
    messages: Sender<Message>,
    buffer: Option<VideoMemory>,
}

impl Camera {
    /// Copies the frame between two slices. Returns `None` if the render thread has ended.
    fn take(&mut self) -> Option<&VideoMemory> {
        let (answer, result) = bounded(1);
        let buffer = self.buffer.take();
        let copy = Message::Do(Box::new(move |engine| {
            let frame = match buffer {
                Some(mut buffer) => {
                    buffer.bytes_mut().copy_from_slice(engine.memory().bytes());
                    buffer
                }
                None => {
                    engine.count_frame_copy();
                    engine.memory().clone()
                }
            };
            // The receiver may be gone.
            let _ = answer.send(frame);
        }));
        self.messages.send(copy).ok()?;
        self.buffer = Some(result.recv().ok()?);
        self.buffer.as_ref()
    }
}

impl SnapshotPlan {
    /// Writes one picture, and removes the oldest ones beyond the bound.
    fn write(&self, frame: &VideoMemory, now: SystemTime) -> Result<(), String> {
        let root = self.folder.root();
        let pictures = own_pictures(root).map_err(|e| format!("{}: {e}", root.display()))?;
        // Frees room for a picture as large as the last one first: on a disk as small as the bound,
        // the next one must fit.
        let next = pictures.last().map_or(0, |picture| picture.bytes);
        prune(pictures, self.keep_bytes.saturating_sub(next), 0)?;
        let name =
            free_name(root, &stamp(now)).ok_or("a thousand snapshots in one second: one is left out")?;
        self.folder
            .write(&name, |out| save::png(frame, out))
            .map_err(|e| format!("{}: {e}", root.display()))?;
        let pictures = own_pictures(root).map_err(|e| format!("{}: {e}", root.display()))?;
        prune(pictures, self.keep_bytes, 1)
    }
}

/// A file with a name of the form of periodic snapshots.
#[derive(Debug, PartialEq, Eq)]
struct Picture {
    path: PathBuf,
    bytes: u64,
    key: (String, u32),
}

/// Returns the pictures in a folder, the oldest first.
fn own_pictures(folder: &Path) -> io::Result<Vec<Picture>> {
    let mut pictures = Vec::new();
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let Some(key) = entry.file_name().to_str().and_then(parse_name) else { continue };
        // The metadata of the entry itself, not of a link's target. An entry that was just removed
        // is skipped.
        let Ok(meta) = entry.metadata() else { continue };
        if meta.is_file() {
            pictures.push(Picture {
                path: entry.path(),
                bytes: meta.len().next_multiple_of(BLOCK_BYTES),
                key,
            });
        }
    }
    pictures.sort_unstable_by(|a, b| a.key.cmp(&b.key));
    Ok(pictures)
}

/// Removes the oldest pictures until the rest takes at most `limit` bytes, or `least` are left.
fn prune(pictures: Vec<Picture>, limit: u64, least: usize) -> Result<(), String> {
    let mut total: u64 = pictures.iter().map(|picture| picture.bytes).sum();
    let removable = pictures.len().saturating_sub(least);
    for picture in pictures.into_iter().take(removable) {
        if total <= limit {
            break;
        }
        fs::remove_file(&picture.path).map_err(|e| format!("{}: {e}", picture.path.display()))?;
        total -= picture.bytes;
    }
    Ok(())
}

/// Returns the first name for this second that no file has.
fn free_name(folder: &Path, stamp: &str) -> Option<String> {
    let mut names = (0..MOST_A_SECOND).map(|number| format_name(stamp, number));
    names.find(|name| fs::symlink_metadata(folder.join(name)).is_err())
}

/// Formats a time as `YYYYMMDD-HHMMSS` in UTC.
fn stamp(time: SystemTime) -> String {
    let [year, month, day, hour, minute, second] = utc_fields(time);
    format!("{year:04}{month:02}{day:02}-{hour:02}{minute:02}{second:02}")
}

/// Returns year (at most 9999), month, day, hour, minute and second of a time in UTC. Source: Howard
/// Hinnant, "chrono-Compatible Low-Level Date Algorithms", `civil_from_days`.
pub fn utc_fields(time: SystemTime) -> [u64; 6] {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    let (days, second) = (seconds / 86_400, seconds % 86_400);
    // Eras of 400 years begin on 1 March, so that leap days are last.
    let z = days + 719_468;
    let (era, day_of_era) = (z / 146_097, z % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    let year = year_of_era + era * 400 + u64::from(month <= 2);
    let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
    [year.min(9999), month, day, hour, minute, second]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: u64) -> SystemTime {
        UNIX_EPOCH + Duration::from_secs(seconds)
    }

    /// A folder that is removed after the test.
    struct Temporary(PathBuf);

    impl Temporary {
        fn new(name: &str) -> Temporary {
            let path = std::env::temp_dir().join(format!("fbptr-snapshots-{name}-{}", std::process::id()));
            let _ = fs::remove_dir_all(&path);
            fs::create_dir_all(&path).unwrap();
            Temporary(path)
        }

        fn names(&self) -> Vec<String> {
            let mut names: Vec<String> = fs::read_dir(&self.0)
                .unwrap()
                .map(|e| e.unwrap().file_name().into_string().unwrap())
                .collect();
            names.sort();
            names
        }
    }

    impl Drop for Temporary {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn stamps_are_utc_dates() {
        // From `date -u -d @N +%Y%m%d-%H%M%S`.
        for (seconds, text) in [
            (0, "19700101-000000"),
            (951_782_399, "20000228-235959"),
            (951_782_400, "20000229-000000"),
            (951_868_800, "20000301-000000"),
            (1_709_164_800, "20240229-000000"),
            (1_735_689_599, "20241231-235959"),
            (1_795_355_045, "20261122-134405"),
            (4_107_542_400, "21000301-000000"),
        ] {
            assert_eq!(stamp(at(seconds)), text, "{seconds}");
        }
    }

    #[test]
    fn the_oldest_own_files_go_and_others_stay() {
        let folder = Temporary::new("bound");
        let frame = VideoMemory::new(8, 8).unwrap();
        let mut one = Vec::new();
        save::png(&frame, &mut one).unwrap();
        for other in ["a.png", "wall-20000101-000000.txt", "wall-x.png"] {
            fs::write(folder.0.join(other), vec![0; 5000]).unwrap();
        }
        fs::create_dir(folder.0.join("wall-20000101-000001.png")).unwrap();
        assert!((one.len() as u64) < BLOCK_BYTES);
        let keep_bytes = 2 * BLOCK_BYTES + 1;
        let plan = SnapshotPlan {
            folder: SandboxDir::open(&folder.0).unwrap(),
            every: Duration::from_secs(1),
            keep_bytes,
        };
        for second in [10, 10, 11, 11, 12] {
            plan.write(&frame, at(second)).unwrap();
        }
        let own = ["wall-19700101-000011-1.png", "wall-19700101-000012.png"];
        let others = ["a.png", "wall-20000101-000000.txt", "wall-20000101-000001.png", "wall-x.png"];
        assert_eq!(folder.names(), [&others[..1], &own[..], &others[1..]].concat());
        assert_eq!(fs::read(folder.0.join(own[1])).unwrap(), one);
        // A bound below the size of one picture keeps only the newest.
        let plan = SnapshotPlan { keep_bytes: 1, ..plan };
        plan.write(&frame, at(13)).unwrap();
        assert_eq!(folder.names(), [&others[..1], &["wall-19700101-000013.png"], &others[1..]].concat());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_neither_followed_nor_removed() {
        let folder = Temporary::new("links");
        let target = folder.0.join("precious");
        fs::write(&target, vec![7; 9000]).unwrap();
        std::os::unix::fs::symlink(&target, folder.0.join("wall-19700101-000001.png")).unwrap();
        let plan = SnapshotPlan {
            folder: SandboxDir::open(&folder.0).unwrap(),
            every: Duration::from_secs(1),
            keep_bytes: 1,
        };
        plan.write(&VideoMemory::new(2, 2).unwrap(), at(1)).unwrap();
        assert_eq!(folder.names(), ["precious", "wall-19700101-000001-1.png", "wall-19700101-000001.png"]);
        assert_eq!(fs::read(&target).unwrap(), vec![7; 9000]);
    }
}

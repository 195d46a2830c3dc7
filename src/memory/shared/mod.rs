//! The shared file: video memory that other programs map, write and read (`--shm PATH`).
//!
//! In: the render thread's video memory and the rows it drew; foreign programs' stores into the map. Out: the same
//! pixels on both sides. FBptr\[offset\] is file byte 4096 + offset. Layout, little-endian:
//! ```text
//!   0 magic FBPTRSHM   8 u32 version 1   12 u32 header bytes 4096   16 u32 width   20 u32 height   24 u32 stride
//!  28 u32 format 1 (RGBA8)   32 u64 frame   40 u64 doorbell   48 u32 server pid   256 the same as key=value lines
//! ```
//! How both sides write without losing anything: `shadow` S is what the map F held when we last looked, M is our video
//! memory. F != S is a foreign write, M != S is ours. [`SharedFile::take_in`] copies foreign writes to M, except onto
//! pixels that we drew; [`SharedFile::give_out`] stores those of our pixels that differ from S, one by one, and never
//! touches another. So a foreign write is lost only where we drew the same pixel. Pixels travel as whole 32-bit words.
//!
//! The file's bytes are reserved before it is mapped, so that a full disk is an error and no signal. A file that another
//! program truncates is an error of the call that finds it, whenever it happens; nothing of it is taken in then.

mod header;
mod map;
mod reserve;
#[cfg(all(test, unix))]
mod tests;

pub use header::{SHARED_HEADER_BYTES, SHARED_MAGIC, SharedError};

use super::VideoMemory;
use header::{kind_of, read_header};
use map::Map;
use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicU32, Ordering, fence};

const FRAME_AT: usize = 32;
const DOORBELL_AT: usize = 40;
const PID_AT: usize = 48;
const TEXT_AT: usize = 256;
/// The text begins with the two numbers that change, 20 digits each, so that they can be rewritten in place.
const TEXT_FRAME_AT: usize = TEXT_AT + "frame=".len();
const TEXT_DOORBELL_AT: usize = TEXT_FRAME_AT + 20 + "\ndoorbell=".len();
/// Words of eight bytes compared before the loop looks whether any differed.
const BLOCK_WORDS: usize = 512;

/// A file of video memory that is mapped here, and may be mapped elsewhere.
#[derive(Debug)]
pub struct SharedFile {
    path: PathBuf,
    file: File,
    map: Map,
    width: u32,
    height: u32,
    /// What the map's pixels were when we last looked or stored.
    shadow: Vec<u8>,
    /// The frame number last told, and the doorbell as the text has it.
    frame: Cell<u64>,
    doorbell_in_text: Cell<u64>,
}

impl SharedFile {
    /// Opens the shared file at `path`, or makes it with `size` pixels.
    ///
    /// A file that is there keeps its pixels and must be a shared file; with `must_fit` also of that size. Nothing that
    /// fails a check is written to. The file is locked against other servers as long as this value lives.
    ///
    /// # Errors
    /// See [`SharedError`].
    pub fn open(path: &Path, size: (u32, u32), must_fit: bool) -> Result<Self, SharedError> {
        let io_error = |source| SharedError::Io { path: path.into(), source };
        let (file, (width, height), is_new) = match std::fs::symlink_metadata(path) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                let mut options = OpenOptions::new();
                options.read(true).write(true).create_new(true);
                #[cfg(unix)]
                std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
                (options.open(path).map_err(io_error)?, size, true)
            }
            Err(e) => return Err(io_error(e)),
            Ok(meta) => {
                let not_ours = |expected: String, found: String| SharedError::NotOurs {
                    path: path.into(),
                    expected,
                    found,
                };
                if !meta.is_file() {
                    return Err(not_ours("a regular file".into(), kind_of(&meta).into()));
                }
                let mut options = OpenOptions::new();
                options.read(true).write(true);
                #[cfg(unix)]
                {
                    // A pipe or a link that was put in its place is not waited for, nor followed.
                    let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOFOLLOW;
                    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, flags.bits() as i32);
                }
                let mut file = options.open(path).map_err(io_error)?;
                let found = read_header(&mut file).map_err(io_error)?.map_err(|(e, f)| not_ours(e, f))?;
                if must_fit && found != size {
                    let text = |(w, h): (u32, u32)| format!("{w}x{h} pixels");
                    return Err(not_ours(text(size), text(found)));
                }
                (file, found, false)
            }
        };
        match file.try_lock() {
            Ok(()) => (),
            Err(std::fs::TryLockError::WouldBlock) => return Err(SharedError::InUse { path: path.into() }),
            Err(std::fs::TryLockError::Error(source)) => return Err(io_error(source)),
        }
        let pixel_bytes = width as usize * height as usize * 4;
        let made = || -> io::Result<SharedFile> {
            reserve::reserve(&file, (SHARED_HEADER_BYTES + pixel_bytes) as u64)?;
            let map = Map::new(&file, SHARED_HEADER_BYTES + pixel_bytes)?;
            let shadow = vec![0; pixel_bytes];
            let file = file.try_clone()?;
            let (frame, doorbell_in_text) = (Cell::new(0), Cell::new(0));
            Ok(SharedFile { path: path.into(), file, map, width, height, shadow, frame, doorbell_in_text })
        };
        let mut shared = made().map_err(|e| {
            if is_new {
                // We made it a moment ago: nobody else's data goes.
                let _ = std::fs::remove_file(path);
            }
            match e.kind() {
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => SharedError::NoRoom {
                    path: path.into(),
                    bytes: (SHARED_HEADER_BYTES + pixel_bytes) as u64,
                },
                _ => io_error(e),
            }
        })?;
        if is_new {
            shared.store_all(&VideoMemory::CLEAR.repeat(pixel_bytes / 4));
        }
        shared.write_header();
        shared.check()?;
        Ok(shared)
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Copies all pixels of the file into `memory`: what a restarted server begins with.
    pub fn load_into(&mut self, memory: &mut VideoMemory) {
        for i in 0..self.shadow.len() / 4 {
            let pixel = self.word(i).load(Relaxed).to_ne_bytes();
            self.shadow[i * 4..i * 4 + 4].copy_from_slice(&pixel);
        }
        memory.bytes_mut().copy_from_slice(&self.shadow);
        memory.mark_rows(0..self.height);
    }

    /// Refuses a file that another program has truncated.
    ///
    /// # Errors
    /// [`SharedError::Truncated`], and [`SharedError::Io`] when the system does not tell.
    pub fn check(&self) -> Result<(), SharedError> {
        let meta =
            self.file.metadata().map_err(|source| SharedError::Io { path: self.path.clone(), source })?;
        let (expected, found) = ((SHARED_HEADER_BYTES + self.shadow.len()) as u64, meta.len());
        match found >= expected && !self.map.is_truncated() {
            true => Ok(()),
            false => Err(SharedError::Truncated { path: self.path.clone(), expected, found }),
        }
    }

    /// Takes in what others wrote since the last look, and says which pixels changed in `memory` (`changed` gets pixel
    /// numbers, ascending). Marks the rows. Pixels drawn by us and not yet given out stay ours.
    ///
    /// # Errors
    /// See [`SharedFile::check`]; what changed before it was found is in `memory`.
    pub fn take_in(
        &mut self,
        memory: &mut VideoMemory,
        mut changed: impl FnMut(usize),
    ) -> Result<(), SharedError> {
        self.check()?;
        // Pairs with the release that a client does by ringing the bell after writing.
        fence(Ordering::Acquire);
        let block_bytes = BLOCK_WORDS * 8;
        let width = self.width as usize;
        for start in (0..self.shadow.len()).step_by(block_bytes) {
            let end = (start + block_bytes).min(self.shadow.len());
            if !self.block_differs(start..end) {
                continue;
            }
            let mut block = [[0; 4]; BLOCK_WORDS * 2];
            for (i, pixel) in (start / 4..end / 4).zip(&mut block) {
                *pixel = self.word(i).load(Relaxed).to_ne_bytes();
            }
            // Bytes that are gone read as zeros: they were not written by anybody.
            self.check()?;
            for (i, &foreign) in (start / 4..end / 4).zip(&block) {
                let at = i * 4..i * 4 + 4;
                if foreign == self.shadow[at.clone()] {
                    continue;
                }
                let ours = &mut memory.bytes_mut()[at.clone()];
                if ours == &self.shadow[at.clone()] {
                    ours.copy_from_slice(&foreign);
                    memory.mark_row((i / width) as u32);
                    changed(i);
                }
                self.shadow[at].copy_from_slice(&foreign);
            }
        }
        Ok(())
    }

    /// Stores what we drew in `rows` into the file; pixels that we did not change are not touched.
    ///
    /// # Errors
    /// See [`SharedFile::check`].
    pub fn give_out(&mut self, memory: &VideoMemory, rows: Range<u32>) -> Result<(), SharedError> {
        let stride = memory.stride_bytes();
        for y in rows.start.min(self.height) as usize..rows.end.min(self.height) as usize {
            let row = y * stride..(y + 1) * stride;
            if memory.bytes()[row.clone()] == self.shadow[row.clone()] {
                continue;
            }
            let ours = memory.bytes()[row.clone()].as_chunks::<4>().0;
            for (x, pixel) in ours.iter().enumerate() {
                let at = row.start + x * 4;
                if self.shadow[at..at + 4] != *pixel {
                    self.word(at / 4).store(u32::from_ne_bytes(*pixel), Relaxed);
                    self.shadow[at..at + 4].copy_from_slice(pixel);
                }
            }
        }
        // Whoever sees a reply sent after this sees the pixels.
        fence(Ordering::Release);
        self.check()
    }

    /// How often clients have rung the bell.
    pub fn doorbell(&self) -> u64 {
        let count = u64::from_le(self.map.long(DOORBELL_AT).load(Ordering::Acquire));
        if count != self.doorbell_in_text.replace(count) {
            self.put_text(TEXT_DOORBELL_AT, format!("{count:020}").as_bytes());
        }
        count
    }

    /// Tells those who look how many frames there were.
    pub fn set_frame(&self, frame: u64) {
        self.frame.set(frame);
        self.map.long(FRAME_AT).store(frame.to_le(), Ordering::Release);
        self.put_text(TEXT_FRAME_AT, format!("{frame:020}").as_bytes());
    }

    /// Says that no server is at work on the file any more.
    pub fn sign_off(&self) {
        self.map.word_at(PID_AT).store(0, Relaxed);
    }

    /// Whether any of the map's bytes in `range` (of the pixels) differs from the shadow.
    fn block_differs(&self, range: Range<usize>) -> bool {
        let (words, rest) = self.shadow[range.clone()].as_chunks::<8>();
        let mut difference = 0;
        for (i, word) in words.iter().enumerate() {
            let at = SHARED_HEADER_BYTES + range.start + i * 8;
            difference |= self.map.long(at).load(Relaxed) ^ u64::from_ne_bytes(*word);
        }
        let rest_differs = || self.word((range.end - 4) / 4).load(Relaxed).to_ne_bytes() != rest;
        difference != 0 || (!rest.is_empty() && rest_differs())
    }

    fn store_all(&mut self, bytes: &[u8]) {
        for (i, pixel) in bytes.as_chunks::<4>().0.iter().enumerate() {
            self.word(i).store(u32::from_ne_bytes(*pixel), Relaxed);
        }
        self.shadow.copy_from_slice(bytes);
    }

    /// Fills the header in; the doorbell stays as it is, the magic comes last.
    fn write_header(&self) {
        let stride = self.width * 4;
        let words = [1, SHARED_HEADER_BYTES as u32, self.width, self.height, stride, 1];
        for (i, word) in words.iter().enumerate() {
            self.map.word_at(8 + i * 4).store(word.to_le(), Relaxed);
        }
        let pid = std::process::id();
        self.map.word_at(PID_AT).store(pid.to_le(), Relaxed);
        let text = format!(
            "frame={:020}\ndoorbell={:020}\nmagic=FBPTRSHM\nversion=1\nheader={SHARED_HEADER_BYTES}\nwidth={}\nheight={}\n\
             stride={stride}\nformat=1\nformat_name=RGBA8\npid={pid}\n",
            0,
            self.doorbell(),
            self.width,
            self.height
        );
        self.put_text(TEXT_AT, text.as_bytes());
        self.set_frame(self.frame.get());
        fence(Ordering::Release);
        self.map.long(0).store(u64::from_ne_bytes(SHARED_MAGIC), Ordering::Release);
    }

    fn put_text(&self, at: usize, text: &[u8]) {
        for (i, byte) in text.iter().enumerate() {
            self.map.byte_at(at + i).store(*byte, Relaxed);
        }
    }

    /// Pixel number `i` in the map.
    fn word(&self, i: usize) -> &AtomicU32 {
        self.map.word_at(SHARED_HEADER_BYTES + i * 4)
    }
}

impl Drop for SharedFile {
    fn drop(&mut self) {
        self.sign_off();
    }
}

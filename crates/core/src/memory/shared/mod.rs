//! Shared file: video memory that other programs map, read and write (`--shm PATH`).
//!
//! In: the render thread's video memory and the rows it drew; foreign programs' stores into the
//! map. Out: the same pixels on both sides. FBptr\[offset\] is file byte 4096 + offset. Layout,
//! little-endian:
//! ```text
//!   0 magic FBPTRSHM       8 u32 version 1            12 u32 header bytes 4096
//!  16 u32 width           20 u32 height              24 u32 stride
//!  28 u32 format 1 (RGBA8)   32 u64 frame            40 u64 doorbell
//!  48 u32 server pid     256 the same as key=value lines
//! ```
//! Merging without losing writes: `shadow` S is the map's content F at the last comparison, M is
//! the server's video memory. F != S is a foreign write, M != S is the server's.
//! [`SharedFile::take_in`] copies foreign writes to M, except onto pixels that the server drew;
//! [`SharedFile::give_out`] stores those pixels of the server that differ from S, one by one, and
//! touches no others. So a foreign write is lost only where the server drew the same pixel. Pixels
//! are read and written as whole 32-bit words.
//!
//! The file's blocks are reserved before it is mapped, so that a full disk is an error and not a
//! signal. If another program truncates the file, the call that finds it returns an error, and none
//! of the bytes that it found missing are taken in.

mod header;
pub(super) mod map;
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
/// Offset of the frame number in the text. The text begins with the two numbers that change, 20
/// digits each, so that they can be overwritten in place.
const TEXT_FRAME_AT: usize = TEXT_AT + "frame=".len();
/// Offset of the doorbell count in the text.
const TEXT_DOORBELL_AT: usize = TEXT_FRAME_AT + 20 + "\ndoorbell=".len();
/// Words of eight bytes that are compared between two checks for a difference.
const BLOCK_WORDS: usize = 512;

/// A mapped file of video memory that other processes may map, too.
#[derive(Debug)]
pub struct SharedFile {
    path: PathBuf,
    file: File,
    map: Map,
    width: u32,
    height: u32,
    /// The map's pixels at the last load or store.
    shadow: Vec<u8>,
    /// Last published frame number.
    frame: Cell<u64>,
    /// Doorbell count in the header's text.
    doorbell_in_text: Cell<u64>,
}

impl SharedFile {
    /// Opens the shared file at `path`, or creates it with `size` pixels.
    ///
    /// An existing file must be a shared file and keeps its pixels; with `must_fit` it must also
    /// have that size. A file that fails a check is not written to. The file is locked against
    /// other servers until this value is dropped.
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
                    // Do not wait for a pipe, nor follow a link, that has taken its place since the
                    // check.
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
                // This call created the file: no other data is lost.
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

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Copies all pixels of the file into `memory`, as a restarted server does.
    pub fn load_into(&mut self, memory: &mut VideoMemory) {
        for i in 0..self.shadow.len() / 4 {
            let pixel = self.word(i).load(Relaxed).to_ne_bytes();
            self.shadow[i * 4..i * 4 + 4].copy_from_slice(&pixel);
        }
        memory.bytes_mut().copy_from_slice(&self.shadow);
        memory.mark_rows(0..self.height);
    }

    /// Checks that no other program has truncated the file.
    ///
    /// # Errors
    /// [`SharedError::Truncated`], or [`SharedError::Io`] if the file's length cannot be read.
    pub fn check(&self) -> Result<(), SharedError> {
        let meta =
            self.file.metadata().map_err(|source| SharedError::Io { path: self.path.clone(), source })?;
        let (expected, found) = ((SHARED_HEADER_BYTES + self.shadow.len()) as u64, meta.len());
        match found >= expected && !self.map.is_truncated() {
            true => Ok(()),
            false => Err(SharedError::Truncated { path: self.path.clone(), expected, found }),
        }
    }

    /// Copies foreign writes since the last call into `memory`, marks their rows, and calls
    /// `changed` with the number of each changed pixel, ascending. Pixels that the server drew and
    /// has not given out are not overwritten.
    ///
    /// # Errors
    /// See [`SharedFile::check`]; changes found before the error are in `memory`.
    pub fn take_in(
        &mut self,
        memory: &mut VideoMemory,
        mut changed: impl FnMut(usize),
    ) -> Result<(), SharedError> {
        self.check()?;
        // Pairs with the release of a client that rings the bell after writing.
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
            // Missing bytes read as zeros that nobody wrote.
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

    /// Stores the server's changes in `rows` into the file; unchanged pixels are not touched.
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
        // A client that sees a reply sent after this sees the pixels.
        fence(Ordering::Release);
        self.check()
    }

    /// Returns the number of times that clients have rung the bell.
    pub fn doorbell(&self) -> u64 {
        let count = u64::from_le(self.map.long(DOORBELL_AT).load(Ordering::Acquire));
        if count != self.doorbell_in_text.replace(count) {
            self.put_text(TEXT_DOORBELL_AT, format!("{count:020}").as_bytes());
        }
        count
    }

    /// Publishes the number of frames in the header.
    pub fn set_frame(&self, frame: u64) {
        self.frame.set(frame);
        self.map.long(FRAME_AT).store(frame.to_le(), Ordering::Release);
        self.put_text(TEXT_FRAME_AT, format!("{frame:020}").as_bytes());
    }

    /// Clears the process id in the header: no server uses the file.
    pub fn sign_off(&self) {
        self.map.word_at(PID_AT).store(0, Relaxed);
    }

    /// Returns whether any of the map's pixel bytes in `range` differs from the shadow.
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

    /// Writes the header. The doorbell is kept, and the magic is stored last.
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

    /// Returns pixel number `i` of the map.
    fn word(&self, i: usize) -> &AtomicU32 {
        self.map.word_at(SHARED_HEADER_BYTES + i * 4)
    }
}

impl Drop for SharedFile {
    fn drop(&mut self) {
        self.sign_off();
    }
}

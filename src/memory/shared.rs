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
//! This is the one file outside `simd/` with unsafe code: the map can change under us at any time, so every access to
//! it is an atomic load or store through a raw pointer, never a reference to plain bytes.
#![allow(unsafe_code)]

use super::{MAX_SIDE, VideoMemory};
use crate::error::Code;
use memmap2::MmapRaw;
use std::cell::Cell;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicU8, AtomicU32, AtomicU64, Ordering, fence};

/// Bytes before the pixels.
pub const SHARED_HEADER_BYTES: usize = 4096;
/// The first eight bytes of a shared file.
pub const SHARED_MAGIC: [u8; 8] = *b"FBPTRSHM";

const FRAME_AT: usize = 32;
const DOORBELL_AT: usize = 40;
const PID_AT: usize = 48;
const TEXT_AT: usize = 256;
/// The text begins with the two numbers that change, 20 digits each, so that they can be rewritten in place.
const TEXT_FRAME_AT: usize = TEXT_AT + "frame=".len();
const TEXT_DOORBELL_AT: usize = TEXT_FRAME_AT + 20 + "\ndoorbell=".len();
/// Words of eight bytes compared before the loop looks whether any differed.
const BLOCK_WORDS: usize = 512;

/// Why a shared file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum SharedError {
    /// The file is there, and is not a shared video memory that fits. It is left as it is.
    #[error("{} is not a shared video memory of this server: expected {expected}, found {found}", path.display())]
    NotOurs {
        /// The file.
        path: PathBuf,
        /// What a shared file has.
        expected: String,
        /// What this one has.
        found: String,
    },
    /// Another server has it.
    #[error("{} is in use by another server", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl SharedError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            SharedError::NotOurs { .. } => Code::Format,
            SharedError::InUse { .. } | SharedError::Io { .. } => Code::Perm,
        }
    }
}

/// A file of video memory that is mapped here, and may be mapped elsewhere.
#[derive(Debug)]
pub struct SharedFile {
    path: PathBuf,
    file: File,
    map: MmapRaw,
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
                let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io_error)?;
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
            file.set_len((SHARED_HEADER_BYTES + pixel_bytes) as u64)?;
            let map = memmap2::MmapOptions::new().len(SHARED_HEADER_BYTES + pixel_bytes).map_raw(&file)?;
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
            io_error(e)
        })?;
        if is_new {
            shared.store_all(&VideoMemory::CLEAR.repeat(pixel_bytes / 4));
        }
        shared.write_header();
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

    /// Takes in what others wrote since the last look, and says which pixels changed in `memory` (`changed` gets pixel
    /// numbers, ascending). Marks the rows. Pixels drawn by us and not yet given out stay ours.
    pub fn take_in(&mut self, memory: &mut VideoMemory, mut changed: impl FnMut(usize)) {
        self.restore_length(memory);
        // Pairs with the release that a client does by ringing the bell after writing.
        fence(Ordering::Acquire);
        let block_bytes = BLOCK_WORDS * 8;
        let width = self.width as usize;
        for start in (0..self.shadow.len()).step_by(block_bytes) {
            let end = (start + block_bytes).min(self.shadow.len());
            if !self.block_differs(start..end) {
                continue;
            }
            for i in start / 4..end / 4 {
                let foreign = self.word(i).load(Relaxed).to_ne_bytes();
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
    }

    /// Stores what we drew in `rows` into the file; pixels that we did not change are not touched.
    pub fn give_out(&mut self, memory: &mut VideoMemory, rows: Range<u32>) {
        self.restore_length(memory);
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
    }

    /// How often clients have rung the bell.
    pub fn doorbell(&self) -> u64 {
        let count = u64::from_le(self.long(DOORBELL_AT).load(Ordering::Acquire));
        if count != self.doorbell_in_text.replace(count) {
            self.put_text(TEXT_DOORBELL_AT, format!("{count:020}").as_bytes());
        }
        count
    }

    /// Tells those who look how many frames there were.
    pub fn set_frame(&self, frame: u64) {
        self.frame.set(frame);
        self.long(FRAME_AT).store(frame.to_le(), Ordering::Release);
        self.put_text(TEXT_FRAME_AT, format!("{frame:020}").as_bytes());
    }

    /// Says that no server is at work on the file any more.
    pub fn sign_off(&self) {
        self.word_at(PID_AT).store(0, Relaxed);
    }

    /// Whether any of the map's bytes in `range` (of the pixels) differs from the shadow.
    fn block_differs(&self, range: Range<usize>) -> bool {
        let (words, rest) = self.shadow[range.clone()].as_chunks::<8>();
        let mut difference = 0;
        for (i, word) in words.iter().enumerate() {
            let at = SHARED_HEADER_BYTES + range.start + i * 8;
            difference |= self.long(at).load(Relaxed) ^ u64::from_ne_bytes(*word);
        }
        let rest_differs = || self.word((range.end - 4) / 4).load(Relaxed).to_ne_bytes() != rest;
        difference != 0 || (!rest.is_empty() && rest_differs())
    }

    /// A file that someone cut is made whole again before the map is touched: its pages would be gone.
    fn restore_length(&mut self, memory: &mut VideoMemory) {
        let expected = (SHARED_HEADER_BYTES + self.shadow.len()) as u64;
        let is_whole = self.file.metadata().is_ok_and(|m| m.len() >= expected);
        if !is_whole && self.file.set_len(expected).is_ok() {
            self.write_header();
            self.store_all(memory.bytes());
        }
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
            self.word_at(8 + i * 4).store(word.to_le(), Relaxed);
        }
        let pid = std::process::id();
        self.word_at(PID_AT).store(pid.to_le(), Relaxed);
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
        self.long(0).store(u64::from_ne_bytes(SHARED_MAGIC), Ordering::Release);
    }

    fn put_text(&self, at: usize, text: &[u8]) {
        for (i, byte) in text.iter().enumerate() {
            self.byte_at(at + i).store(*byte, Relaxed);
        }
    }

    /// Pixel number `i` in the map.
    fn word(&self, i: usize) -> &AtomicU32 {
        self.word_at(SHARED_HEADER_BYTES + i * 4)
    }

    fn word_at(&self, at: usize) -> &AtomicU32 {
        assert!(at.is_multiple_of(4) && at + 4 <= self.map.len());
        // SAFETY: the map is page aligned and `at` is a multiple of 4 inside it; it lives as long as `self`, and this
        // process touches it through atomics only. The file's length was checked before (restore_length).
        unsafe { AtomicU32::from_ptr(self.map.as_mut_ptr().add(at).cast()) }
    }

    fn byte_at(&self, at: usize) -> &AtomicU8 {
        assert!(at < self.map.len());
        // SAFETY: as in `word_at`, with 1 in place of 4.
        unsafe { AtomicU8::from_ptr(self.map.as_mut_ptr().add(at)) }
    }

    fn long(&self, at: usize) -> &AtomicU64 {
        assert!(at.is_multiple_of(8) && at + 8 <= self.map.len());
        // SAFETY: as in `word_at`, with 8 in place of 4. Words of all sizes are used by one thread only.
        unsafe { AtomicU64::from_ptr(self.map.as_mut_ptr().add(at).cast()) }
    }
}

fn kind_of(meta: &std::fs::Metadata) -> &'static str {
    match () {
        () if meta.is_symlink() => "a symbolic link",
        () if meta.is_dir() => "a folder",
        () => "a device or pipe",
    }
}

/// Checks a header: width and height, or what was expected and what was found.
fn read_header(file: &mut File) -> io::Result<Result<(u32, u32), (String, String)>> {
    let len = file.metadata()?.len();
    let refuse = |expected: &str, found: String| Ok(Err((expected.to_owned(), found)));
    if len < SHARED_HEADER_BYTES as u64 {
        return refuse("a header of 4096 bytes", format!("{len} bytes"));
    }
    let mut header = [0; 64];
    file.read_exact(&mut header)?;
    if header[..8] != SHARED_MAGIC {
        return refuse("the magic FBPTRSHM", format!("\"{}\"", header[..8].escape_ascii()));
    }
    let word = |at: usize| u32::from_le_bytes(std::array::from_fn(|i| header[at + i]));
    let (width, height) = (word(16), word(20));
    let checks = [("version", word(8), 1), ("header bytes", word(12), 4096), ("format", word(28), 1)];
    for (what, found, expected) in checks {
        if found != expected {
            return refuse(&format!("{what} {expected}"), found.to_string());
        }
    }
    let side = 1..=MAX_SIDE;
    if !side.contains(&width) || !side.contains(&height) || word(24) != width * 4 {
        return refuse("a size and its stride", format!("{width}x{height}, stride {}", word(24)));
    }
    let expected = SHARED_HEADER_BYTES as u64 + width as u64 * height as u64 * 4;
    match len == expected {
        true => Ok(Ok((width, height))),
        false => refuse(&format!("{expected} bytes"), format!("{len} bytes")),
    }
}

impl Drop for SharedFile {
    fn drop(&mut self) {
        if self.file.metadata().is_ok_and(|m| m.len() >= SHARED_HEADER_BYTES as u64) {
            self.sign_off();
        }
        let _ = self.file.flush();
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::FileExt;

    struct Folder(PathBuf);
    impl Folder {
        fn new(name: &str) -> Folder {
            let path = std::env::temp_dir().join(format!("fbptr-shm-{name}-{}", std::process::id()));
            let _ = std::fs::remove_dir_all(&path);
            std::fs::create_dir(&path).unwrap();
            Folder(path)
        }
    }
    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    fn outside(path: &Path) -> File {
        OpenOptions::new().read(true).write(true).open(path).unwrap()
    }

    fn pixel(file: &File, at: u64) -> [u8; 4] {
        let mut p = [0; 4];
        file.read_exact_at(&mut p, 4096 + at * 4).unwrap();
        p
    }

    #[test]
    fn both_sides_write_and_nothing_is_lost() {
        let folder = Folder::new("both");
        let path = folder.0.join("fb");
        let (w, h) = (1021, 7);
        let mut shared = SharedFile::open(&path, (w, h), true).unwrap();
        let mut memory = VideoMemory::new(w, h).unwrap();
        shared.load_into(&mut memory);
        let foreign = outside(&path);
        assert_eq!(pixel(&foreign, 0), VideoMemory::CLEAR);
        // They write one pixel in each row, also the very last; we write others in the same rows.
        for y in 0..h as u64 {
            foreign.write_all_at(&[y as u8, 1, 2, 3], 4096 + (y * w as u64 + (w as u64 - 1)) * 4).unwrap();
            memory.put_pixel(y as i32, y as i32, [50, 60, 70, 80]);
        }
        let rows = memory.take_damage();
        shared.give_out(&mut memory, rows);
        let mut seen = Vec::new();
        shared.take_in(&mut memory, |i| seen.push(i));
        assert_eq!(seen, (1..=h as usize).map(|y| y * w as usize - 1).collect::<Vec<_>>());
        for y in 0..h as i32 {
            assert_eq!(memory.get_pixel(w as i32 - 1, y).unwrap(), [y as u8, 1, 2, 3]);
            assert_eq!(pixel(&foreign, (y as u64) * w as u64 + y as u64), [50, 60, 70, 80]);
            assert_eq!(pixel(&foreign, (y as u64 + 1) * w as u64 - 1), [y as u8, 1, 2, 3]);
        }
        assert_eq!(memory.take_damage(), 0..h);
        shared.take_in(&mut memory, |i| panic!("pixel {i} seen twice"));
    }

    #[test]
    fn a_pixel_that_both_wrote_is_one_of_the_two_on_both_sides() {
        let folder = Folder::new("clash");
        let path = folder.0.join("fb");
        let mut shared = SharedFile::open(&path, (4, 1), true).unwrap();
        let mut memory = VideoMemory::new(4, 1).unwrap();
        let foreign = outside(&path);
        foreign.write_all_at(&[9; 4], 4096 + 8).unwrap();
        memory.put_pixel(2, 0, [5; 4]);
        shared.take_in(&mut memory, |_| ());
        shared.give_out(&mut memory, 0..1);
        assert_eq!(memory.get_pixel(2, 0).unwrap(), pixel(&foreign, 2));
    }

    #[test]
    fn it_survives_a_restart_and_refuses_what_is_not_its_own() {
        let folder = Folder::new("restart");
        let path = folder.0.join("fb");
        let mut shared = SharedFile::open(&path, (5, 3), true).unwrap();
        let mut memory = VideoMemory::new(5, 3).unwrap();
        memory.put_pixel(4, 2, [1, 2, 3, 4]);
        shared.give_out(&mut memory, 0..3);
        assert!(matches!(SharedFile::open(&path, (5, 3), true), Err(SharedError::InUse { .. })));
        drop(shared);
        assert!(matches!(SharedFile::open(&path, (6, 3), true), Err(SharedError::NotOurs { .. })));
        let mut again = SharedFile::open(&path, (640, 480), false).unwrap();
        assert_eq!((again.width(), again.height()), (5, 3), "the file's own size");
        let mut memory = VideoMemory::new(5, 3).unwrap();
        again.load_into(&mut memory);
        assert_eq!(memory.get_pixel(4, 2).unwrap(), [1, 2, 3, 4]);

        let letter = folder.0.join("letter");
        let cases: [&[u8]; 4] = [b"", b"dear friend", &[0; 5000], b"FBPTRSHM and then nothing of the sort"];
        for text in cases {
            std::fs::write(&letter, text).unwrap();
            assert!(matches!(SharedFile::open(&letter, (5, 3), true), Err(SharedError::NotOurs { .. })));
            assert_eq!(std::fs::read(&letter).unwrap(), text, "left as it was");
        }
        std::os::unix::fs::symlink(&path, folder.0.join("link")).unwrap();
        for other in [folder.0.join("link"), folder.0.clone(), "/dev/null".into()] {
            let e = SharedFile::open(&other, (5, 3), true).unwrap_err();
            assert!(matches!(e, SharedError::NotOurs { .. }), "{e}");
        }
    }

    #[test]
    fn the_header_says_what_the_layout_promises() {
        let folder = Folder::new("header");
        let path = folder.0.join("fb");
        let shared = SharedFile::open(&path, (300, 200), true).unwrap();
        shared.set_frame(77);
        let bytes = std::fs::read(&path).unwrap();
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!(&bytes[..8], b"FBPTRSHM");
        assert_eq!([8, 12, 16, 20, 24, 28].map(word), [1, 4096, 300, 200, 1200, 1]);
        assert_eq!((word(32), word(36), word(48)), (77, 0, std::process::id()));
        assert_eq!(bytes.len(), 4096 + 300 * 200 * 4);
        let text = std::str::from_utf8(&bytes[256..4096]).unwrap().split('\0').next().unwrap();
        assert!(
            text.starts_with("frame=00000000000000000077\ndoorbell=00000000000000000000\nmagic=FBPTRSHM\n")
        );
        assert!(text.contains("\nwidth=300\nheight=200\nstride=1200\n"), "{text}");
        outside(&path).write_all_at(&5u64.to_le_bytes(), 40).unwrap();
        assert_eq!(shared.doorbell(), 5);
    }

    #[test]
    fn a_file_cut_short_by_others_is_made_whole_again() {
        let folder = Folder::new("cut");
        let path = folder.0.join("fb");
        let mut shared = SharedFile::open(&path, (2000, 4), true).unwrap();
        let mut memory = VideoMemory::new(2000, 4).unwrap();
        memory.clear([1, 2, 3, 4]);
        outside(&path).set_len(10).unwrap();
        shared.take_in(&mut memory, |_| ());
        shared.give_out(&mut memory, 0..4);
        assert_eq!(std::fs::read(&path).unwrap()[4096..], *memory.bytes());
        assert_eq!(&std::fs::read(&path).unwrap()[..8], b"FBPTRSHM");
    }
}

//! Movie output: frames to a GIF, an APNG, a y4m stream or numbered PNGs.
//!
//! In: the frame's RGBA bytes, one call of [`Movie::push`] per frame, each shown for 1/rate
//! seconds. Out: a file that is complete after every push. Promise: a program that is killed at any
//! moment leaves a file that decoders read up to the last frame pushed. A frame is written after
//! the end marker of the file, and attached by one small write; nothing is buffered for later.
//! Tested by killing the program and decoding the file (`tests/cli/movie.rs`).
//!
//! Movies have no alpha, as a screen has none; numbered PNGs are snapshots and keep it. A frame
//! equal to the last one extends the last one's duration where the format has durations (GIF,
//! APNG).

mod apng;
mod gif;
mod numbered;
mod quantize;
mod y4m;

pub use numbered::numbered_path;

use super::temporary::{create_beside, remove_leftovers_beside};
use super::{SaveError, begin};
use fbptr_core::memory::VideoMemory;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// File format of a movie.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MovieFormat {
    /// GIF: at most 256 colours per frame (exact if there are no more), at most 50 frames per
    /// second.
    Gif,
    /// Animated PNG: R, G and B without loss.
    Apng,
    /// YUV4MPEG2 with full chroma (C444, BT.601, 16..235), which ffmpeg and mpv read from a pipe.
    Y4m,
    /// One PNG per frame: `name-0000.png`, `name-0001.png` and so on.
    NumberedPng,
}

/// Description of the valid file names of movies.
pub const MOVIE_ENDINGS: &str = ".gif, .apng, .y4m or .png (numbered), or - for y4m on standard output";

impl MovieFormat {
    /// Returns the format for the extension of a name, in either case; y4m for `-`.
    pub fn of_path(path: &Path) -> Result<Self, SaveError> {
        if path == Path::new("-") {
            return Ok(MovieFormat::Y4m);
        }
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("gif") => Ok(MovieFormat::Gif),
            Some("apng") => Ok(MovieFormat::Apng),
            Some("y4m") => Ok(MovieFormat::Y4m),
            Some("png") => Ok(MovieFormat::NumberedPng),
            _ => Err(SaveError::UnknownEnding { path: path.to_owned(), expected: MOVIE_ENDINGS }),
        }
    }

    /// Returns the highest frame rate of the format, or `None` if there is no practical limit.
    pub fn most_frames_per_second(self) -> Option<f64> {
        // Viewers replace a delay of 1/100 second by 10/100.
        (self == MovieFormat::Gif).then_some(50.0)
    }
}

/// A movie that is being written.
pub struct Movie {
    writer: Box<dyn FrameWriter + Send>,
    path: PathBuf,
    size: [u32; 2],
    frames: u64,
}

impl std::fmt::Debug for Movie {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Movie({}, {} frames)", self.path.display(), self.frames)
    }
}

/// Writer of one movie format.
trait FrameWriter {
    /// Appends a frame of the movie's size; it is in the file when this returns.
    fn frame(&mut self, memory: &VideoMemory) -> io::Result<()>;
}

impl Movie {
    /// Creates a movie of `width` x `height` pixels at `rate` frames per second. The file appears
    /// with its first frame, and replaces an older file of that name. `-` writes y4m to standard
    /// output. Unfinished files that killed programs left beside it are removed.
    ///
    /// # Errors An unknown extension, a rate out of range or too high for the format, a frame too
    /// large for it, a pipe that cannot be opened.
    pub fn create(path: &Path, width: u32, height: u32, rate: f64) -> Result<Self, SaveError> {
        let format = MovieFormat::of_path(path)?;
        let most = format.most_frames_per_second().unwrap_or(MAX_RATE);
        if !(rate >= MIN_RATE && rate <= most) {
            return Err(SaveError::Rate { path: path.to_owned(), least: MIN_RATE, most, found: rate });
        }
        if format == MovieFormat::Gif && width.max(height) > u32::from(u16::MAX) {
            let error = io::Error::new(io::ErrorKind::InvalidInput, "a GIF has at most 65535 pixels a side");
            return Err(SaveError::io(path, &error));
        }
        if format != MovieFormat::Y4m {
            remove_leftovers_beside(path);
        }
        let target = path.to_owned();
        let writer: Box<dyn FrameWriter + Send> = match format {
            MovieFormat::Gif => Box::new(gif::GifMovie::new(Growing::new(target), width, height, rate)),
            MovieFormat::Apng => Box::new(apng::Apng::new(Growing::new(target), width, height, rate)),
            MovieFormat::NumberedPng => Box::new(numbered::Numbered::new(target)),
            MovieFormat::Y4m if path == Path::new("-") => {
                Box::new(y4m::Y4m::new(Box::new(io::stdout()), width, height, rate))
            }
            MovieFormat::Y4m => {
                let file = begin(path).map_err(|e| SaveError::io(path, &e))?;
                Box::new(y4m::Y4m::new(Box::new(file), width, height, rate))
            }
        };
        Ok(Movie { writer, path: path.to_owned(), size: [width, height], frames: 0 })
    }

    /// Appends the frame; it is in the file when this returns.
    ///
    /// # Errors
    /// The error of the operating system. Frames already in the file stay readable.
    ///
    /// # Panics
    /// If the memory does not have the size of the movie.
    pub fn push(&mut self, memory: &VideoMemory) -> Result<(), SaveError> {
        assert_eq!([memory.width(), memory.height()], self.size, "one size a movie");
        self.writer.frame(memory).map_err(|e| SaveError::io(&self.path, &e))?;
        self.frames += 1;
        Ok(())
    }

    /// Returns the number of frames pushed.
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the path given to [`Movie::create`].
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Range of frame rates. A lower one makes no movie, and no clock reaches a higher one.
const MIN_RATE: f64 = 0.01;
const MAX_RATE: f64 = 1000.0;

/// A file that grows by frames and is complete after each: created under a temporary name, and
/// renamed with its first frame.
struct Growing {
    path: PathBuf,
    file: Option<File>,
    /// Length of its complete part in bytes.
    length: u64,
}

impl Growing {
    fn new(path: PathBuf) -> Self {
        Growing { path, file: None, length: 0 }
    }

    /// Creates the file with its first frame; `bytes` are the complete file.
    fn begin(&mut self, bytes: &[u8]) -> io::Result<()> {
        // A link is replaced.
        if fs::symlink_metadata(&self.path).is_ok_and(|m| !m.is_file() && !m.is_symlink()) {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "not a plain file: only y4m goes there"));
        }
        let (temporary, mut file) = create_beside(&self.path)?;
        let put = file.write_all(bytes).and_then(|()| fs::rename(&temporary, &self.path));
        if let Err(e) = put {
            // The first error is reported.
            let _ = fs::remove_file(&temporary);
            return Err(e);
        }
        (self.file, self.length) = (Some(file), bytes.len() as u64);
        Ok(())
    }

    /// Writes bytes at an offset in one piece.
    fn write_at(&mut self, offset: u64, bytes: &[u8]) -> io::Result<()> {
        let file = self.file.as_mut().ok_or_else(|| io::Error::other("a movie without its first frame"))?;
        file.seek(SeekFrom::Start(offset))?;
        file.write_all(bytes)
    }
}

/// Returns the bounding box of the pixels whose R, G or B differ, as x, y, width, height; `None` if
/// none do.
fn changed_box(before: &[u8], after: &[u8], width: u32) -> Option<[u32; 4]> {
    let stride = width as usize * 4;
    let differ = |a: &[u8], b: &[u8]| a[..3] != b[..3];
    let rows = || before.chunks_exact(stride).zip(after.chunks_exact(stride)).enumerate();
    let is_changed = |(a, b): (&[u8], &[u8])| {
        a != b && a.chunks_exact(4).zip(b.chunks_exact(4)).any(|(a, b)| differ(a, b))
    };
    let top = rows().find(|&(_, row)| is_changed(row))?.0;
    let bottom = rows().rev().find(|&(_, row)| is_changed(row)).map_or(top, |(y, _)| y);
    let (mut left, mut right) = (width as usize, 0);
    for (_, (a, b)) in rows().skip(top).take(bottom + 1 - top).filter(|(_, (a, b))| a != b) {
        let pixels = || a.chunks_exact(4).zip(b.chunks_exact(4));
        if let Some(x) = pixels().take(left).position(|(a, b)| differ(a, b)) {
            left = x;
        }
        if let Some(x) = pixels().rposition(|(a, b)| differ(a, b)) {
            right = right.max(x);
        }
    }
    Some([left, top, right + 1 - left, bottom + 1 - top].map(|n| n as u32))
}

/// Returns the pixels of a box as RGB, row after row.
fn cut_rgb(rgba: &[u8], width: u32, [x, y, w, h]: [u32; 4]) -> Vec<u8> {
    let mut out = Vec::with_capacity(w as usize * h as usize * 3);
    for row in rgba.chunks_exact(width as usize * 4).skip(y as usize).take(h as usize) {
        let row = &row[x as usize * 4..(x + w) as usize * 4];
        out.extend(row.as_chunks::<4>().0.iter().flat_map(|p| [p[0], p[1], p[2]]));
    }
    out
}

/// Frame durations in whole ticks: frame k lasts from tick `round(k / rate)` to that of the next,
/// so that rounding errors do not add up.
struct Ticks {
    per_frame: f64,
    frames: u64,
}

impl Ticks {
    fn new(ticks_per_second: f64, rate: f64) -> Self {
        Ticks { per_frame: ticks_per_second / rate, frames: 0 }
    }

    /// Returns the duration of the next frame in ticks, at least 1.
    fn next(&mut self) -> u64 {
        let at = |frames: u64| (frames as f64 * self.per_frame).round() as u64;
        let ticks = at(self.frames + 1) - at(self.frames);
        self.frames += 1;
        ticks.max(1)
    }
}

#[cfg(test)]
mod tests;

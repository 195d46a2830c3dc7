//! Golden-image tests: comparison of a frame with a reference PNG.
//!
//! ```no_run
//! use fbptr_core::memory::VideoMemory;
//! use fbptr_formats::save::golden::{Tolerance, assert_golden};
//!
//! let frame = VideoMemory::new(64, 64).unwrap();
//! assert_golden(&frame, "tests/golden/black.png", Tolerance::EXACT);
//! ```
//!
//! A test that fails leaves `black.actual.png` and, if the sizes agree, `black.diff.png` beside the
//! golden file. With `BLESS=1` in the environment the golden file is rewritten, and the test fails
//! all the same: a run that rewrites proves nothing.

use super::{SaveError, crc32, missing_folder, read_input, rgba8, to_path};
use fbptr_core::memory::{MemoryError, VideoMemory};
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder, ImageResult, Limits};
use std::error::Error;
use std::fmt;
use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};

/// Largest difference allowed between a frame and its golden picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tolerance {
    /// A pixel differs if one of its channels (R, G, B, A) differs by more than this.
    pub per_channel: u8,
    /// Number of pixels that may differ.
    pub pixels: u64,
}

impl Tolerance {
    /// No tolerance: every byte must be equal.
    pub const EXACT: Tolerance = Tolerance { per_channel: 0, pixels: 0 };
}

/// Use of the golden file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Compare the frame with it.
    Compare,
    /// Rewrite it, and fail.
    Bless,
}

impl Mode {
    /// Returns `Bless` if the environment has `BLESS=1`, otherwise `Compare`.
    pub fn from_env() -> Self {
        match std::env::var_os("BLESS") {
            Some(v) if v == "1" => Mode::Bless,
            _ => Mode::Compare,
        }
    }
}

/// Difference of two frames of the same size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Number of pixels with a channel difference above the tolerance.
    pub pixels: u64,
    /// Largest difference of a channel over all pixels, within the tolerance or not.
    pub max: u8,
    /// First pixel (x, y), row by row, with a channel difference above the tolerance.
    pub first: Option<(u32, u32)>,
}

/// Reason why a frame did not pass.
#[derive(Clone, Debug, PartialEq)]
pub enum GoldenError {
    /// The golden file does not exist.
    Missing {
        /// Path of the golden file.
        golden: PathBuf,
        /// File to which the frame was written.
        actual: PathBuf,
    },
    /// The folder of the golden file does not exist.
    NoFolder {
        /// Path of the golden file.
        golden: PathBuf,
        /// Path of the folder.
        folder: PathBuf,
    },
    /// The golden file is not a readable PNG.
    Unreadable {
        /// Path of the golden file.
        golden: PathBuf,
        /// Message of the system or of the decoder.
        reason: String,
    },
    /// The sizes differ.
    Size {
        /// Path of the golden file.
        golden: PathBuf,
        /// Width and height of the golden file.
        expected: (u32, u32),
        /// Width and height of the frame.
        found: (u32, u32),
        /// File to which the frame was written.
        actual: PathBuf,
    },
    /// Too many pixels differ.
    Differs {
        /// Path of the golden file.
        golden: PathBuf,
        /// Difference found.
        difference: Difference,
        /// Difference allowed.
        tolerance: Tolerance,
        /// File to which the frame was written.
        actual: PathBuf,
        /// File to which the magnified difference was written.
        diff: PathBuf,
    },
    /// The golden file was rewritten: run again without BLESS.
    Blessed {
        /// Path of the golden file.
        golden: PathBuf,
        /// CRC-32 of the frame's bytes.
        crc: u32,
    },
    /// A picture could not be written.
    Save(SaveError),
}

impl fmt::Display for GoldenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            GoldenError::Missing { golden, actual } => {
                let (golden, actual) = (golden.display(), actual.display());
                write!(f, "{golden}: no golden file; look at {actual}, and keep it with BLESS=1")
            }
            GoldenError::NoFolder { golden, folder } => {
                let (golden, folder) = (golden.display(), folder.display());
                write!(f, "{golden}: there is no folder {folder}; make it (mkdir -p), ")?;
                f.write_str("or run once with BLESS=1, which makes it and keeps the frame")
            }
            GoldenError::Unreadable { golden, reason } => write!(f, "{}: {reason}", golden.display()),
            GoldenError::Size { golden, expected: (width, height), found, actual } => {
                let (golden, actual) = (golden.display(), actual.display());
                write!(f, "{golden}: the golden file is {width}x{height}, ")?;
                write!(f, "the frame {}x{}; see {actual}", found.0, found.1)
            }
            GoldenError::Differs { golden, difference, tolerance, actual, diff } => {
                let Difference { pixels, max, first } = difference;
                let Tolerance { per_channel, pixels: allowed } = tolerance;
                let first = first.unwrap_or_default();
                let [golden, actual, diff] = [golden, actual, diff].map(|path| path.display());
                write!(f, "{golden}: {pixels} pixels differ by more than {per_channel} ({allowed} may), ")?;
                write!(f, "at most by {max}, first at {first:?}; see {actual} and {diff}")
            }
            GoldenError::Blessed { golden, crc } => {
                let golden = golden.display();
                write!(f, "{golden}: rewritten (crc {crc:08x}); this run fails, run again without BLESS")
            }
            GoldenError::Save(e) => write!(f, "{e}"),
        }
    }
}

impl Error for GoldenError {}

impl From<SaveError> for GoldenError {
    fn from(e: SaveError) -> Self {
        GoldenError::Save(e)
    }
}

/// Compares two frames; `None` if their sizes differ.
pub fn compare(actual: &VideoMemory, expected: &VideoMemory, per_channel: u8) -> Option<Difference> {
    if (actual.width(), actual.height()) != (expected.width(), expected.height()) {
        return None;
    }
    let mut difference = Difference { pixels: 0, max: 0, first: None };
    let pairs = actual.bytes().as_chunks::<4>().0.iter().zip(expected.bytes().as_chunks::<4>().0);
    for (i, (a, b)) in (0u32..).zip(pairs) {
        let off = distance(a, b).into_iter().max().unwrap_or(0);
        difference.max = difference.max.max(off);
        if off > per_channel {
            difference.pixels += 1;
            difference.first.get_or_insert((i % actual.width(), i / actual.width()));
        }
    }
    Some(difference)
}

/// Returns the absolute difference of each channel.
fn distance(a: &[u8; 4], b: &[u8; 4]) -> [u8; 4] {
    std::array::from_fn(|c| a[c].abs_diff(b[c]))
}

/// Returns the difference of two frames of the same size as a picture: the difference of each
/// channel, scaled so that the largest is 255; that of alpha is added as grey.
pub fn magnified(actual: &VideoMemory, expected: &VideoMemory) -> Result<VideoMemory, MemoryError> {
    let mut picture = VideoMemory::new(actual.width(), actual.height())?;
    let max = compare(actual, expected, 0).map_or(0, |d| d.max).max(1) as u32;
    let (a, b) = (actual.bytes().as_chunks::<4>().0, expected.bytes().as_chunks::<4>().0);
    for (pixel, (a, b)) in picture.bytes_mut().as_chunks_mut::<4>().0.iter_mut().zip(a.iter().zip(b)) {
        let d = distance(a, b);
        for c in 0..3 {
            pixel[c] = ((d[c] as u32 + d[3] as u32) * 255 / max).min(255) as u8;
        }
    }
    Ok(picture)
}

/// Limit of the size of a picture's file.
const MAX_BYTES: u64 = 4 << 30;

/// Reads a PNG file as a frame.
pub fn read_png(path: &Path) -> Result<VideoMemory, GoldenError> {
    let unreadable = |reason: String| GoldenError::Unreadable { golden: path.to_owned(), reason };
    let bytes = read_input(path, MAX_BYTES).map_err(|e| unreadable(e.to_string()))?;
    let picture = decode_png(&bytes).map_err(|e| unreadable(e.to_string()))?;
    let mut memory =
        VideoMemory::new(picture.width(), picture.height()).map_err(|e| unreadable(e.to_string()))?;
    memory.bytes_mut().copy_from_slice(&rgba8(picture));
    Ok(memory)
}

/// Decodes a PNG file within the default limits of `image`, whose `load_from_memory_with_format`
/// would compile the decoders of all formats for it.
fn decode_png(bytes: &[u8]) -> ImageResult<DynamicImage> {
    let mut limits = Limits::default();
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits.clone())?;
    // The decoder counts its own buffers alone.
    limits.reserve(decoder.total_bytes())?;
    DynamicImage::from_decoder(decoder)
}

/// Compares `actual` with the golden PNG at `golden`.
///
/// On failure the frame is written to `NAME.actual.png` and the magnified difference to
/// `NAME.diff.png` beside the golden file; on success these files of an earlier failure are
/// removed.
pub fn check(
    actual: &VideoMemory,
    golden: impl AsRef<Path>,
    tolerance: Tolerance,
    mode: Mode,
) -> Result<(), GoldenError> {
    let golden = golden.as_ref();
    let (actual_path, diff_path) = (golden.with_extension("actual.png"), golden.with_extension("diff.png"));
    // Files of an earlier run would be taken for this run's.
    for leftover in [&actual_path, &diff_path] {
        match fs::remove_file(leftover) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(SaveError::io(leftover, &e).into());
            }
            _ => {}
        }
    }
    if mode == Mode::Bless {
        if let Some(folder) = golden.parent() {
            fs::create_dir_all(folder).map_err(|e| SaveError::io(folder, &e))?;
        }
        to_path(actual, golden)?;
        return Err(GoldenError::Blessed { golden: golden.to_owned(), crc: crc32(actual) });
    }
    let golden = golden.to_owned();
    if let Some(folder) = missing_folder(&golden).map(Path::to_owned) {
        return Err(GoldenError::NoFolder { golden, folder });
    }
    if !golden.exists() {
        to_path(actual, &actual_path)?;
        return Err(GoldenError::Missing { golden, actual: actual_path });
    }
    let expected = read_png(&golden)?;
    let Some(difference) = compare(actual, &expected, tolerance.per_channel) else {
        to_path(actual, &actual_path)?;
        let expected = (expected.width(), expected.height());
        let found = (actual.width(), actual.height());
        return Err(GoldenError::Size { golden, expected, found, actual: actual_path });
    };
    if difference.pixels <= tolerance.pixels {
        return Ok(());
    }
    to_path(actual, &actual_path)?;
    let picture = magnified(actual, &expected).expect("a frame of this size exists already");
    to_path(&picture, &diff_path)?;
    Err(GoldenError::Differs { golden, difference, tolerance, actual: actual_path, diff: diff_path })
}

/// [`check`] for tests, with the mode from the environment.
///
/// # Panics
/// If the frame does not pass, with the number of pixels and the largest difference; always with
/// `BLESS=1`.
#[track_caller]
pub fn assert_golden(actual: &VideoMemory, golden: impl AsRef<Path>, tolerance: Tolerance) {
    if let Err(error) = check(actual, golden, tolerance, Mode::from_env()) {
        panic!("{error}");
    }
}

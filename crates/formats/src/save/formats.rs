//! Writers of snapshots and of depth.

use super::{SaveError, atomically};
use fbptr_core::memory::{DepthMemory, VideoMemory};
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use std::io::{self, Write};
use std::path::Path;

/// File format of a snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SnapshotFormat {
    /// PNG, 8-bit RGBA, with the frame's alpha.
    Png,
    /// PPM (`P6`), without alpha.
    Ppm,
    /// The RGBA bytes without a header.
    Raw,
}

impl SnapshotFormat {
    /// Returns the format for the extension of a file name, in either case.
    pub fn of_path(path: &Path) -> Result<Self, SaveError> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("png") => Ok(SnapshotFormat::Png),
            Some("ppm") => Ok(SnapshotFormat::Ppm),
            Some("raw") => Ok(SnapshotFormat::Raw),
            _ => Err(SaveError::UnknownEnding { path: path.to_owned(), expected: ".png, .ppm or .raw" }),
        }
    }

    /// Writes `memory` in this format.
    pub fn write(self, memory: &VideoMemory, out: &mut dyn Write) -> io::Result<()> {
        match self {
            SnapshotFormat::Png => png(memory, out),
            SnapshotFormat::Ppm => ppm(memory, out),
            SnapshotFormat::Raw => raw(memory, out),
        }
    }
}

/// Writes the frame as PNG: 8 bits RGBA.
pub fn png(memory: &VideoMemory, out: &mut dyn Write) -> io::Result<()> {
    let mut out = FirstError { out, error: None };
    let result = PngEncoder::new_with_quality(&mut out, CompressionType::Default, FilterType::Adaptive)
        .write_image(memory.bytes(), memory.width(), memory.height(), image::ExtendedColorType::Rgba8);
    match (out.error, result) {
        (Some(e), _) => Err(e),
        (None, result) => result.map_err(io::Error::other),
    }
}

/// A writer that stores its first error: the encoder reports it by its text alone, without its
/// kind.
struct FirstError<'a> {
    out: &'a mut dyn Write,
    error: Option<io::Error>,
}

impl Write for FirstError<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes).map_err(|e| self.keep(e))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush().map_err(|e| self.keep(e))
    }
}

impl FirstError<'_> {
    fn keep(&mut self, e: io::Error) -> io::Error {
        let kind = e.kind();
        if kind != io::ErrorKind::Interrupted {
            self.error.get_or_insert(e);
        }
        kind.into()
    }
}

/// Writes the frame as PPM: `P6`, width, height, 255, then R, G, B bytes; alpha is left out.
pub fn ppm(memory: &VideoMemory, out: &mut dyn Write) -> io::Result<()> {
    write!(out, "P6\n{} {}\n255\n", memory.width(), memory.height())?;
    let mut row = Vec::with_capacity(memory.width() as usize * 3);
    for rgba in memory.bytes().chunks_exact(memory.stride_bytes()) {
        row.clear();
        row.extend(rgba.as_chunks::<4>().0.iter().flat_map(|p| [p[0], p[1], p[2]]));
        out.write_all(&row)?;
    }
    Ok(())
}

/// Writes the frame's RGBA bytes, nothing else.
pub fn raw(memory: &VideoMemory, out: &mut dyn Write) -> io::Result<()> {
    out.write_all(memory.bytes())
}

/// Writes depth as PFM: `Pf`, scale -1.0 (little-endian), rows bottom-up, z in 0..1 for every depth
/// format, 1 where nothing was drawn.
pub fn pfm(depth: &DepthMemory, out: &mut dyn Write) -> io::Result<()> {
    let (width, height) = (depth.width() as usize, depth.height() as usize);
    write!(out, "Pf\n{width} {height}\n-1.0\n")?;
    let mut row = Vec::with_capacity(width * 4);
    for y in (0..height).rev() {
        row.clear();
        for x in 0..width {
            let z = depth.format().decode(depth.word(width * y + x));
            row.extend_from_slice(&(z as f32).to_le_bytes());
        }
        out.write_all(&row)?;
    }
    Ok(())
}

/// Writes the frame to `path` in the format of its extension, atomically.
pub fn to_path(memory: &VideoMemory, path: &Path) -> Result<(), SaveError> {
    let format = SnapshotFormat::of_path(path)?;
    atomically(path, |out| format.write(memory, out))
}

/// Writes depth to `path`, which must end in `.pfm`, atomically.
pub fn depth_to_path(depth: &DepthMemory, path: &Path) -> Result<(), SaveError> {
    check_depth_path(path)?;
    atomically(path, |out| pfm(depth, out))
}

/// Checks that a name is one for depth: that it ends in `.pfm`.
pub fn check_depth_path(path: &Path) -> Result<(), SaveError> {
    match path.extension() {
        Some(e) if e.eq_ignore_ascii_case("pfm") => Ok(()),
        _ => Err(SaveError::UnknownEnding { path: path.to_owned(), expected: ".pfm" }),
    }
}

/// Returns the CRC-32 (ISO-HDLC) of the frame's RGBA bytes, the value that `CRC` replies.
pub fn crc32(memory: &VideoMemory) -> u32 {
    crc32fast::hash(memory.bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A disk that is full after this many bytes.
    struct FullDisk(usize);

    impl Write for FullDisk {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            match self.0.min(bytes.len()) {
                0 => Err(io::ErrorKind::StorageFull.into()),
                fits => {
                    self.0 -= fits;
                    Ok(fits)
                }
            }
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_full_disk_is_the_same_error_in_every_format() {
        let mut memory = VideoMemory::new(64, 64).unwrap();
        let mut state = 1_u32;
        for byte in memory.bytes_mut() {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = (state >> 24) as u8;
        }
        for format in [SnapshotFormat::Png, SnapshotFormat::Ppm, SnapshotFormat::Raw] {
            for room in [0, 5, 9000] {
                let error = format.write(&memory, &mut FullDisk(room)).unwrap_err();
                assert_eq!(
                    error.kind(),
                    io::ErrorKind::StorageFull,
                    "{format:?} after {room} bytes: {error}"
                );
            }
        }
    }
}

//! Reader of the pictures that this room writes.

use super::{SaveError, SnapshotFormat, rgba8};
use fbptr_core::memory::VideoMemory;
use std::io;
use std::path::Path;

/// Reads a picture of any size from the bytes of the file at `path`, in the format of its extension;
/// `size` is that of a `.raw` file, which does not state it.
///
/// # Errors
/// If the bytes are no picture of that format.
#[doc(hidden)]
pub fn read_picture(path: &Path, bytes: &[u8], size: Option<[u32; 2]>) -> Result<VideoMemory, SaveError> {
    let invalid = |reason: String| SaveError::io(path, &io::Error::new(io::ErrorKind::InvalidData, reason));
    let format = match SnapshotFormat::of_path(path)? {
        SnapshotFormat::Png => image::ImageFormat::Png,
        SnapshotFormat::Ppm => image::ImageFormat::Pnm,
        SnapshotFormat::Raw => {
            let size = size.ok_or_else(|| invalid("a raw file does not state its size".to_owned()))?;
            return read_frame(path, bytes, size);
        }
    };
    let picture = image::load_from_memory_with_format(bytes, format).map_err(|e| invalid(e.to_string()))?;
    let mut memory =
        VideoMemory::new(picture.width(), picture.height()).map_err(|e| invalid(e.to_string()))?;
    memory.bytes_mut().copy_from_slice(&rgba8(picture));
    Ok(memory)
}

/// Reads a frame of `size` from the bytes of the file at `path`, in the format of its extension.
///
/// # Errors
/// If the bytes are no picture of that format and size.
#[doc(hidden)]
pub fn read_frame(path: &Path, bytes: &[u8], [width, height]: [u32; 2]) -> Result<VideoMemory, SaveError> {
    let invalid = |reason: String| SaveError::io(path, &io::Error::new(io::ErrorKind::InvalidData, reason));
    let mut memory = VideoMemory::new(width, height).map_err(|e| invalid(e.to_string()))?;
    let decode = |format| image::load_from_memory_with_format(bytes, format);
    let picture = match SnapshotFormat::of_path(path)? {
        SnapshotFormat::Png => decode(image::ImageFormat::Png),
        SnapshotFormat::Ppm => decode(image::ImageFormat::Pnm),
        SnapshotFormat::Raw => {
            if bytes.len() != memory.bytes().len() {
                let expected = memory.bytes().len();
                return Err(invalid(format!("expected {expected} bytes, found {}", bytes.len())));
            }
            memory.bytes_mut().copy_from_slice(bytes);
            return Ok(memory);
        }
    };
    let picture = picture.map_err(|e| invalid(e.to_string()))?;
    let (w, h) = (picture.width(), picture.height());
    if (w, h) != (width, height) {
        return Err(invalid(format!("expected a picture of {width}x{height} pixels, found {w}x{h}")));
    }
    memory.bytes_mut().copy_from_slice(&rgba8(picture));
    Ok(memory)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_read_as_they_were_written() {
        let mut memory = VideoMemory::new(3, 2).unwrap();
        for (i, byte) in (0u8..).zip(memory.bytes_mut()) {
            *byte = if i % 4 == 3 { 255 } else { i * 9 };
        }
        for format in [SnapshotFormat::Png, SnapshotFormat::Ppm, SnapshotFormat::Raw] {
            let path = format!("a.{format:?}");
            let mut bytes = Vec::new();
            format.write(&memory, &mut bytes).unwrap();
            let read = read_frame(Path::new(&path), &bytes, [3, 2]).unwrap();
            assert_eq!(read.bytes(), memory.bytes(), "{format:?}");
            let read = read_picture(Path::new(&path), &bytes, Some([3, 2])).unwrap();
            assert_eq!(read.bytes(), memory.bytes(), "{format:?}");
            assert_eq!(read_picture(Path::new(&path), &bytes, None).is_err(), format == SnapshotFormat::Raw);
            assert!(read_frame(Path::new(&path), &bytes, [2, 3]).is_err() || format == SnapshotFormat::Raw);
            assert!(read_frame(Path::new(&path), &bytes[1..], [3, 2]).is_err(), "{format:?}");
        }
    }
}

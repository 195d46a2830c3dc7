//! Animated PNG: a PNG whose `acTL` chunk counts the frames; each later frame is an `fcTL` chunk
//! and its `fdAT` chunks.
//!
//! A frame is written after the `IEND` that ends the file, followed by another `IEND`; then the old
//! one becomes an empty private chunk (`fbPt`) by one write of 8 bytes, and the count is raised by
//! another. Between the two the file has one frame more than it counts, which decoders ignore.
//!
//! Source: W3C, Portable Network Graphics, third edition, sections 11.3.6 (animation) and 5.4
//! (chunk names).

use super::{FrameWriter, Growing, Ticks, changed_box, cut_rgb};
use fbptr_core::memory::VideoMemory;
use image::ImageEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use std::io;

/// Ticks per second.
const TICKS: f64 = 1000.0;
/// Bytes of signature and IHDR, which precede `acTL`.
const HEAD_BYTES: usize = 8 + 25;
/// Bytes of length and type before a chunk's data.
const CHUNK_HEAD: usize = 8;
/// Bytes of a chunk without data.
const EMPTY_CHUNK: u64 = 12;

/// Writer of an APNG that grows by frames.
pub(super) struct Apng {
    file: Growing,
    size: [u32; 2],
    ticks: Ticks,
    last: Vec<u8>,
    frames: u32,
    /// Next sequence number; fcTL and fdAT chunks share them.
    sequence: u32,
    /// Offset of the last fcTL chunk, its data, and its delay in ticks.
    control_offset: u64,
    control: [u8; 26],
    delay: u64,
}

impl Apng {
    pub fn new(file: Growing, width: u32, height: u32, rate: f64) -> Self {
        Apng {
            file,
            size: [width, height],
            ticks: Ticks::new(TICKS, rate),
            last: Vec::new(),
            frames: 0,
            sequence: 0,
            control_offset: 0,
            control: [0; 26],
            delay: 0,
        }
    }

    /// Returns the data of an fcTL: sequence number, size, position, delay, then the operations
    /// "leave the frame" and "replace the pixels below".
    fn control(&mut self, [x, y, w, h]: [u32; 4], ticks: u64) -> [u8; 26] {
        let mut data = [0; 26];
        for (i, number) in [self.sequence, w, h, x, y].into_iter().enumerate() {
            data[i * 4..i * 4 + 4].copy_from_slice(&number.to_be_bytes());
        }
        data[20..22].copy_from_slice(&(ticks as u16).to_be_bytes());
        data[22..24].copy_from_slice(&(TICKS as u16).to_be_bytes());
        self.sequence += 1;
        data
    }

    /// Extends the duration of the last frame.
    fn lengthen(&mut self, ticks: u64) -> io::Result<()> {
        self.delay += ticks;
        self.control[20..22].copy_from_slice(&(self.delay as u16).to_be_bytes());
        let mut bytes = Vec::new();
        chunk(&mut bytes, b"fcTL", &self.control);
        self.file.write_at(self.control_offset, &bytes)
    }
}

impl FrameWriter for Apng {
    fn frame(&mut self, memory: &VideoMemory) -> io::Result<()> {
        let ticks = self.ticks.next();
        let (width, is_first) = (self.size[0], self.last.is_empty());
        let area = match is_first {
            true => [0, 0, width, self.size[1]],
            false => match changed_box(&self.last, memory.bytes(), width) {
                Some(area) => area,
                None if self.delay + ticks <= u64::from(u16::MAX) => return self.lengthen(ticks),
                None => [0, 0, 1, 1],
            },
        };
        let png = encode(&cut_rgb(memory.bytes(), width, area), area[2], area[3])?;
        let before = self.sequence;
        let control = self.control(area, ticks);
        let mut bytes = Vec::with_capacity(png.len() + 128);
        if is_first {
            bytes.extend_from_slice(&png[..HEAD_BYTES]);
            chunk(&mut bytes, b"acTL", &counted(1));
        }
        let control_at = bytes.len() as u64;
        chunk(&mut bytes, b"fcTL", &control);
        for data in image_data(&png) {
            match is_first {
                true => chunk(&mut bytes, b"IDAT", data),
                false => {
                    let numbered = [&self.sequence.to_be_bytes(), data].concat();
                    chunk(&mut bytes, b"fdAT", &numbered);
                    self.sequence += 1;
                }
            }
        }
        chunk(&mut bytes, b"IEND", &[]);
        let end = self.file.length;
        let written = match is_first {
            true => self.file.begin(&bytes),
            false => self.join(end, &bytes),
        };
        if let Err(e) = written {
            self.sequence = before;
            return Err(e);
        }
        self.frames += 1;
        (self.control_offset, self.control, self.delay) = (end + control_at, control, ticks);
        self.last.clear();
        self.last.extend_from_slice(memory.bytes());
        Ok(())
    }
}

impl Apng {
    /// Appends a frame, written from `end` on, to the file that ends there.
    fn join(&mut self, end: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.write_at(end, bytes)?;
        let mut filler = Vec::new();
        chunk(&mut filler, b"fbPt", &[]);
        self.file.write_at(end - EMPTY_CHUNK + 4, &filler[4..])?;
        self.file.length = end + bytes.len() as u64;
        let mut count = Vec::new();
        chunk(&mut count, b"acTL", &counted(self.frames + 1));
        self.file.write_at(HEAD_BYTES as u64, &count)
    }
}

/// Returns the data of `acTL`: the number of frames, repeated for ever.
fn counted(frames: u32) -> [u8; 8] {
    let mut data = [0; 8];
    data[..4].copy_from_slice(&frames.to_be_bytes());
    data
}

/// Appends a chunk: length, type, data, CRC.
fn chunk(out: &mut Vec<u8>, kind: &[u8; 4], data: &[u8]) {
    out.extend_from_slice(&(data.len() as u32).to_be_bytes());
    let start = out.len();
    out.extend_from_slice(kind);
    out.extend_from_slice(data);
    let crc = crc32fast::hash(&out[start..]);
    out.extend_from_slice(&crc.to_be_bytes());
}

/// Encodes an 8-bit RGB PNG.
fn encode(rgb: &[u8], width: u32, height: u32) -> io::Result<Vec<u8>> {
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Adaptive)
        .write_image(rgb, width, height, image::ExtendedColorType::Rgb8)
        .map_err(io::Error::other)?;
    Ok(png)
}

/// Returns the data of a PNG's IDAT chunks.
fn image_data(png: &[u8]) -> Vec<&[u8]> {
    let mut found = Vec::new();
    let mut rest = &png[8..];
    while let Some((head, tail)) = rest.split_at_checked(CHUNK_HEAD) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let Some((data, tail)) = tail.split_at_checked(length) else { break };
        if head[4..] == *b"IDAT" {
            found.push(data);
        }
        // Skips the CRC.
        rest = tail.get(4..).unwrap_or_default();
    }
    found
}

//! The frame as tiles: which of them have changed since a version, and their compressed bytes.
//!
//! In: the newest frame of a display. Out: tiles, each compressed once for all viewers. A tile's
//! bytes, rows from the top, R G B A, are one segment of a raw deflate stream (RFC 1951) that ends
//! at a byte's end with an empty block and refers to nothing before its own beginning: segments one
//! behind the other and [`STREAM_END`] are a stream that a browser inflates in one go. Runs on the
//! web thread. Promise: the tiles that [`TileFrame::since`] returns make the frame of that version
//! out of any earlier one.

use crate::{Display, ShownFrame};
use flate2::{Compress, Compression, FlushCompress};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Width and height of a tile in pixels, except at the right and lower edges.
pub(super) const TILE: u32 = 64;
/// End of a deflate stream: an empty final block.
pub(super) const STREAM_END: [u8; 2] = [0x03, 0x00];

/// A compressed tile, which is counted as long as it lives.
#[derive(Debug)]
pub(super) struct EncodedTile {
    pub bytes: Box<[u8]>,
    live: Arc<AtomicU64>,
}

impl Drop for EncodedTile {
    fn drop(&mut self) {
        self.live.fetch_sub(self.bytes.len() as u64, Ordering::Relaxed);
    }
}

#[derive(Debug)]
struct Tile {
    /// Version of the frame in which it changed last.
    version: u64,
    encoded: Option<Arc<EncodedTile>>,
}

/// The frame that viewers are sent, cut into tiles.
#[derive(Debug)]
pub(super) struct TileFrame {
    /// The display's newest frame.
    newest: ShownFrame,
    /// The frame of `version`.
    bytes: Vec<u8>,
    columns: u32,
    tiles: Vec<Tile>,
    /// Counts the frames that differ.
    version: u64,
    compress: Compress,
    buffer: Vec<u8>,
    /// Bytes of all compressed tiles that are cached or on their way.
    live: Arc<AtomicU64>,
}

impl TileFrame {
    /// Copies the display's frame.
    pub fn new(display: &Display) -> TileFrame {
        let mut newest = ShownFrame::default();
        display.copy_changes(0, &mut newest);
        let (columns, rows) = (newest.width.div_ceil(TILE), newest.height.div_ceil(TILE));
        let tiles = (0..columns * rows).map(|_| Tile { version: 1, encoded: None }).collect();
        TileFrame {
            bytes: newest.bytes.clone(),
            newest,
            columns,
            tiles,
            version: 1,
            compress: Compress::new(Compression::fast(), false),
            buffer: Vec::new(),
            live: Arc::default(),
        }
    }

    /// Returns the version; it is above 0.
    pub fn version(&self) -> u64 {
        self.version
    }

    /// Returns the number of `PRESENT` commands of this frame.
    pub fn frame(&self) -> u64 {
        self.newest.frame
    }

    /// Returns the bytes of all compressed tiles that are cached or on their way.
    pub fn live_bytes(&self) -> u64 {
        self.live.load(Ordering::Relaxed)
    }

    /// Takes the display's newest frame. Returns whether it is another one, in bytes or number.
    pub fn update(&mut self, display: &Display) -> bool {
        let (seen, frame) = (self.newest.version, self.newest.frame);
        let Some(rows) = display.copy_changes(seen, &mut self.newest) else { return false };
        let next = self.version + 1;
        let mut has_changed = frame != self.newest.frame;
        if !rows.is_empty() {
            for ty in rows.start / TILE..=(rows.end - 1) / TILE {
                for tx in 0..self.columns {
                    if self.take_tile(tx, ty) {
                        let tile = &mut self.tiles[(ty * self.columns + tx) as usize];
                        *tile = Tile { version: next, encoded: None };
                        has_changed = true;
                    }
                }
            }
        }
        if has_changed {
            self.version = next;
        }
        has_changed
    }

    /// Returns the ranges of bytes that a tile's rows are.
    fn rows_of(&self, tx: u32, ty: u32) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        let (width, height) = (self.newest.width, self.newest.height);
        let (x0, x1) = (tx * TILE, ((tx + 1) * TILE).min(width));
        (ty * TILE..((ty + 1) * TILE).min(height)).map(move |y| {
            let row = y as usize * width as usize;
            (row + x0 as usize) * 4..(row + x1 as usize) * 4
        })
    }

    /// Copies a tile of the newest frame. Returns whether it differs.
    fn take_tile(&mut self, tx: u32, ty: u32) -> bool {
        let mut differs = false;
        for row in self.rows_of(tx, ty) {
            if self.bytes[row.clone()] != self.newest.bytes[row.clone()] {
                self.bytes[row.clone()].copy_from_slice(&self.newest.bytes[row]);
                differs = true;
            }
        }
        differs
    }

    /// Returns the tiles that have changed since a version, 0 for all, with their numbers.
    pub fn since(&mut self, version: u64) -> Vec<(u32, Arc<EncodedTile>)> {
        let changed: Vec<u32> =
            (0..).zip(&self.tiles).filter(|(_, tile)| tile.version > version).map(|(i, _)| i).collect();
        changed.into_iter().map(|i| (i, self.encoded(i))).collect()
    }

    fn encoded(&mut self, index: u32) -> Arc<EncodedTile> {
        if let Some(encoded) = &self.tiles[index as usize].encoded {
            return encoded.clone();
        }
        self.buffer.clear();
        for row in self.rows_of(index % self.columns, index / self.columns) {
            self.buffer.extend_from_slice(&self.bytes[row]);
        }
        let bytes = segment(&mut self.compress, &self.buffer).into_boxed_slice();
        self.live.fetch_add(bytes.len() as u64, Ordering::Relaxed);
        let encoded = Arc::new(EncodedTile { bytes, live: self.live.clone() });
        self.tiles[index as usize].encoded = Some(encoded.clone());
        encoded
    }
}

/// Compresses bytes to a segment of a raw deflate stream.
fn segment(compress: &mut Compress, bytes: &[u8]) -> Vec<u8> {
    compress.reset();
    let mut segment = Vec::with_capacity(bytes.len() / 2 + 64);
    loop {
        let at = compress.total_in() as usize;
        // There are no errors for bytes without a dictionary.
        let _ = compress.compress_vec(&bytes[at..], &mut segment, FlushCompress::Sync);
        // A flush is complete if it leaves room.
        if segment.len() < segment.capacity() && compress.total_in() as usize == bytes.len() {
            return segment;
        }
        segment.reserve(segment.len().max(64));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::memory::VideoMemory;
    use std::io::Read;

    fn inflate(tiles: &[(u32, Arc<EncodedTile>)]) -> Vec<u8> {
        let mut stream: Vec<u8> = tiles.iter().flat_map(|(_, tile)| tile.bytes.to_vec()).collect();
        stream.extend(STREAM_END);
        let mut bytes = Vec::new();
        flate2::read::DeflateDecoder::new(&stream[..]).read_to_end(&mut bytes).unwrap();
        bytes
    }

    #[test]
    fn tiles_are_what_has_changed_and_inflate_to_the_frame() {
        let display = Display::new(150, 70);
        let mut memory = VideoMemory::new(150, 70).unwrap();
        let mut frame = TileFrame::new(&display);
        let all = frame.since(0);
        assert_eq!(all.len(), 6);
        assert_eq!(inflate(&all).len(), 150 * 70 * 4);
        assert!(frame.since(frame.version()).is_empty());
        assert!(!frame.update(&display));
        let before = frame.version();
        memory.put_pixel(149, 69, [1, 2, 3, 0]);
        display.publish(&memory, 0..70, 1, None);
        assert!(frame.update(&display));
        let changed = frame.since(before);
        assert_eq!(changed.iter().map(|(i, _)| *i).collect::<Vec<_>>(), [5], "rows alone are not enough");
        let bytes = inflate(&changed);
        assert_eq!((bytes.len(), &bytes[bytes.len() - 4..]), (22 * 6 * 4, &[1, 2, 3, 0][..]));
        display.publish(&memory, 0..70, 1, None);
        assert!(!frame.update(&display), "the same bytes are no news");
        display.publish(&memory, 0..0, 2, None);
        assert!(frame.update(&display) && frame.since(before + 1).is_empty() && frame.frame() == 2);
    }

    #[test]
    fn noise_is_compressed_whole_and_counted_until_it_is_dropped() {
        let display = Display::new(64, 128);
        let mut memory = VideoMemory::new(64, 128).unwrap();
        let mut state = 1u32;
        for y in 0..128 {
            for x in 0..64 {
                state = state.wrapping_mul(1664525).wrapping_add(1013904223);
                memory.put_pixel(x, y, state.to_be_bytes());
            }
        }
        display.publish(&memory, 0..128, 0, None);
        let mut frame = TileFrame::new(&display);
        let tiles = frame.since(0);
        assert_eq!(inflate(&tiles), memory.bytes());
        let sum: usize = tiles.iter().map(|(_, tile)| tile.bytes.len()).sum();
        assert_eq!(frame.live_bytes(), sum as u64);
        assert!(Arc::ptr_eq(&tiles[0].1, &frame.since(0)[0].1), "a tile is compressed once");
        memory.clear([9; 4]);
        display.publish(&memory, 0..128, 0, None);
        frame.update(&display);
        assert_eq!(frame.live_bytes(), sum as u64, "they are still held here");
        drop(tiles);
        assert_eq!(frame.live_bytes(), 0);
    }
}

//! Scan-out: converts the visible part of the device's memory to video memory.
//!
//! In: the device's mode, palette and memory as they are at a vertical blank. Out: rows of R, G, B,
//! A bytes. Runs on the render thread. A copy of the memory as it was last seen, in the device's
//! own format, tells which rows have changed: only these are converted, so what others draw into
//! the frame over the protocol stays until the program changes the same row. A mode smaller than
//! the frame is shown enlarged by the largest whole factor, in the middle.
//!
//! Where the device's bytes are those of the frame, and nobody else draws into it, video memory is
//! that copy: there is no second one, and nothing is converted. The device's memory itself cannot
//! be video memory: a program changes it while a checksum or an encoder reads it, and plain
//! references to such bytes are undefined behaviour.

use super::device::Device;
use super::layout as at;
use super::mode::{Format, REVERSED_PIXELS, Var, format_of};
use fbptr_core::memory::{Rgba, VideoMemory};
use fbptr_core::simd::{Level, Pixels, unpack};
use std::ops::Range;

/// Lowest bit and length of the channels in video memory.
const RGBA: [(u32, u32); 4] = [(0, 8), (8, 8), (16, 8), (24, 8)];
/// Palette of a device whose palette has not been read.
const NO_PALETTE: [Rgba; 256] = [[0, 0, 0, 255]; 256];

/// The state of the last scan-out.
#[derive(Debug)]
pub struct ScanOut {
    /// The device's memory as it was last seen; empty while video memory holds it.
    copy: Vec<u8>,
    /// True if others than the device's programs draw into video memory.
    is_shared: bool,
    /// The mode, and the number of times that it was set.
    mode: Option<(u32, Var)>,
    palette: [Rgba; 256],
    palette_sets: Option<u32>,
    pan: (u32, u32),
    is_blank: bool,
    /// The first row of the memory is the lowest.
    is_flipped: bool,
    /// Colours of a row before it is enlarged.
    row: Vec<Rgba>,
}

impl ScanOut {
    /// Creates the scan-out of a device: to a video memory that others draw into, too, or to one of
    /// its own.
    pub fn new(is_shared: bool) -> ScanOut {
        ScanOut {
            copy: Vec::new(),
            is_shared,
            mode: None,
            palette: NO_PALETTE,
            palette_sets: None,
            pan: (0, 0),
            is_blank: false,
            is_flipped: false,
            row: Vec::new(),
        }
    }

    /// Converts what has changed to `memory`, which has the device's size, and marks these rows.
    /// Returns whether there were any.
    pub fn update(&mut self, device: &Device, memory: &mut VideoMemory) -> bool {
        let pan = device.take_pan();
        let mut is_whole = self.take_mode(device, memory);
        is_whole |= std::mem::replace(&mut self.pan, pan) != pan;
        let Some((_, var)) = self.mode else { return is_whole };
        let Some(format) = format_of(&var, 0) else { return is_whole };
        is_whole |= self.take_palette(device, format);
        let is_blank = device.word(at::BLANK_AT) != 0;
        is_whole |= std::mem::replace(&mut self.is_blank, is_blank) != is_blank;
        if is_blank {
            if is_whole {
                memory.clear(VideoMemory::CLEAR);
            }
            return is_whole;
        }
        let is_padded = device.limits().line_length(&var) as usize != memory.stride_bytes();
        let is_flipped = device.word(at::FLIPPED_AT) != 0;
        is_whole |= std::mem::replace(&mut self.is_flipped, is_flipped) != is_flipped;
        if !self.is_shared && !is_padded && !is_flipped && is_same(&var, format, pan, memory) {
            self.copy = Vec::new();
            return take_bytes(device, memory, is_whole);
        }
        // A change of the mode or of the visible part has led here: all rows are converted.
        // A device may have room for more rows than any mode that is set.
        let rows = u64::from(pan.1.saturating_add(var.yres)) * u64::from(device.limits().line_length(&var));
        let len = device.memory().len_bytes();
        self.copy.resize(len.min(usize::try_from(rows).unwrap_or(len).next_multiple_of(4096)), 0);
        self.take_rows(device, memory, &var, format, is_whole)
    }

    /// Takes over a new mode; what is outside of its picture becomes black.
    fn take_mode(&mut self, device: &Device, memory: &mut VideoMemory) -> bool {
        let mode = device.mode();
        if self.mode == Some(mode) {
            return false;
        }
        let is_first = self.mode.is_none();
        self.mode = Some(mode);
        if !is_first {
            memory.clear(VideoMemory::CLEAR);
        }
        true
    }

    /// Takes over a new palette. Returns whether it changes the picture.
    fn take_palette(&mut self, device: &Device, format: &Format) -> bool {
        let sets = device.word(at::PALETTE_SETS_AT);
        if self.palette_sets.replace(sets) == Some(sets) {
            return false;
        }
        for (index, color) in self.palette.iter_mut().enumerate() {
            let [red, green, blue, _] = at::unpack_color(device.long(at::PALETTE_AT + index * 8));
            *color = [narrow(red), narrow(green), narrow(blue), 255];
        }
        format.is_indexed()
    }

    fn take_rows(
        &mut self,
        device: &Device,
        memory: &mut VideoMemory,
        var: &Var,
        format: &Format,
        is_whole: bool,
    ) -> bool {
        let Some(placement) = Placement::new(var, memory) else { return false };
        let line_length = device.limits().line_length(var);
        let mut is_changed = false;
        for y in 0..var.yres {
            let row = if self.is_flipped { var.yres - 1 - y } else { y };
            let Some(line) = visible_bytes(var, format.bits, line_length, self.pan, row, self.copy.len())
            else {
                continue;
            };
            if !device.memory().refresh(line.words.start, &mut self.copy[line.words.clone()]) && !is_whole {
                continue;
            }
            is_changed = true;
            self.row.resize(var.xres as usize, VideoMemory::CLEAR);
            let bytes = &self.copy[line.first_byte..line.words.end];
            let pixels = pixels(bytes, format, var, line.skip, &self.palette);
            if placement.is_identity {
                let stride = memory.stride_bytes();
                let at = y as usize * stride;
                unpack(Level::best(), pixels, memory.bytes_mut()[at..at + stride].as_chunks_mut().0);
                memory.mark_row(y);
            } else {
                unpack(Level::best(), pixels, &mut self.row);
                placement.put(&self.row, y, memory);
            }
        }
        is_changed
    }
}

/// Returns whether the first bytes of the device's memory are those of the frame.
fn is_same(var: &Var, format: &Format, pan: (u32, u32), memory: &VideoMemory) -> bool {
    let size = (memory.width(), memory.height());
    let is_rgba = format.bits == 32 && format.channels.map(|c| (c.offset, c.length)) == RGBA;
    is_rgba && pan == (0, 0) && (var.xres, var.yres) == size && (var.xres_virtual, var.yres_virtual) == size
}

/// Copies the rows that differ, as they are, and marks them. Returns whether there were any.
fn take_bytes(device: &Device, memory: &mut VideoMemory, is_whole: bool) -> bool {
    let stride = memory.stride_bytes();
    let mut is_changed = is_whole;
    for y in 0..memory.height() {
        let at = y as usize * stride;
        if device.memory().refresh(at, &mut memory.bytes_mut()[at..at + stride]) || is_whole {
            memory.mark_row(y);
            is_changed = true;
        }
    }
    is_changed
}

/// Returns a palette value in eight bits, as `CNVT_TOHW` of the kernel's `vfb.c` does.
fn narrow(value: u16) -> u8 {
    let value = u32::from(value);
    (((value << 8) + 0x7fff - value) >> 16) as u8
}

/// Bytes of the visible part of a row.
struct Line {
    /// Whole words of four bytes that hold it.
    words: Range<usize>,
    first_byte: usize,
    /// Pixels of the first byte that are left of it.
    skip: usize,
}

/// Returns the place of the visible part of row `y`; `None` if a program has set it off the memory.
fn visible_bytes(
    var: &Var,
    bits: u32,
    line_length: u32,
    pan: (u32, u32),
    y: u32,
    len: usize,
) -> Option<Line> {
    let line = u64::from(line_length);
    let first_bit = u64::from(pan.0) * u64::from(bits);
    let last_byte = (first_bit + u64::from(var.xres) * u64::from(bits)).div_ceil(8);
    let start = (u64::from(pan.1) + u64::from(y)).checked_mul(line).filter(|start| *start < len as u64)?;
    let words = start + first_bit / 32 * 4..start + last_byte.next_multiple_of(4);
    if words.end > len as u64 || last_byte > line {
        return None;
    }
    Some(Line {
        words: words.start as usize..words.end as usize,
        first_byte: (start + first_bit / 8) as usize,
        skip: (first_bit % 8 / u64::from(bits)) as usize,
    })
}

/// Describes a row's bytes to the conversion.
fn pixels<'a>(
    bytes: &'a [u8],
    format: &Format,
    var: &Var,
    skip: usize,
    palette: &'a [Rgba; 256],
) -> Pixels<'a> {
    let [red, green, blue, alpha] = format.channels;
    match format.bits {
        32 => {
            let shifts = [red.offset, green.offset, blue.offset, alpha.offset];
            Pixels::Words { bytes, shifts, has_alpha: alpha.length == 8 }
        }
        24 => Pixels::Triples { bytes, places: [red, green, blue].map(|c| c.offset as usize / 8) },
        16 => {
            let colors = [red, green, blue];
            Pixels::Halves { bytes, shifts: colors.map(|c| c.offset), lengths: colors.map(|c| c.length) }
        }
        bits => Pixels::Indices { bytes, bits, skip, high_first: var.nonstd & REVERSED_PIXELS != 0, palette },
    }
}

/// Place of a mode's picture in the frame.
struct Placement {
    is_identity: bool,
    scale: usize,
    origin: [usize; 2],
    width: usize,
}

impl Placement {
    /// Returns the place, or `None` for a mode that the frame has no room for.
    fn new(var: &Var, memory: &VideoMemory) -> Option<Placement> {
        let (width, height) = (memory.width(), memory.height());
        let scale = width.checked_div(var.xres)?.min(height.checked_div(var.yres)?);
        if scale == 0 {
            return None;
        }
        let origin = [(width - var.xres * scale) / 2, (height - var.yres * scale) / 2];
        Some(Placement {
            is_identity: (var.xres, var.yres) == (width, height),
            scale: scale as usize,
            origin: origin.map(|v| v as usize),
            width: var.xres as usize,
        })
    }

    /// Puts row `y` of the picture into the frame.
    fn put(&self, row: &[Rgba], y: u32, memory: &mut VideoMemory) {
        let stride = memory.stride_bytes();
        let first = self.origin[1] + y as usize * self.scale;
        for line in first..first + self.scale {
            let at = line * stride + self.origin[0] * 4;
            let target = &mut memory.bytes_mut()[at..at + self.width * self.scale * 4];
            for (block, color) in target.chunks_exact_mut(self.scale * 4).zip(row) {
                block.as_chunks_mut::<4>().0.fill(*color);
            }
            memory.mark_row(line as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fbdev::mode::{FORMATS, Format, check};
    use crate::fbdev::{Device, DeviceOptions};
    use std::os::unix::fs::FileExt;

    /// A device of `size` pixels with its scan-out and frame.
    struct Bench {
        device: Device,
        scan: ScanOut,
        memory: VideoMemory,
    }

    impl Bench {
        fn new(format: &str, size: (u32, u32)) -> Bench {
            let format = Format::index(format).unwrap();
            let device =
                Device::new(&DeviceOptions { size, format, hz: 60, line_length: 0, is_glut: false }).unwrap();
            let mut memory = VideoMemory::new(size.0, size.1).unwrap();
            memory.take_damage();
            Bench { scan: ScanOut::new(true), device, memory }
        }

        fn write(&self, at: u64, bytes: &[u8]) {
            self.device.memory().file().write_all_at(bytes, at).unwrap();
        }

        fn set_mode(&self, change: impl FnOnce(&mut Var)) {
            let (sets, mut var) = self.device.mode();
            change(&mut var);
            let var = check(&var, self.device.limits()).unwrap();
            for (i, word) in var.to_words().into_iter().enumerate() {
                self.device.set_word(at::mode_word_at(sets + 1, i), word);
            }
            self.device.set_word(at::MODE_SETS_AT, sets + 1);
        }

        fn pan(&self, x: u32, y: u32) {
            self.device.set_long(at::PAN_AT, u64::from(x) | u64::from(y) << 32);
        }

        fn update(&mut self) -> (bool, Range<u32>) {
            let is_changed = self.scan.update(&self.device, &mut self.memory);
            (is_changed, self.memory.take_damage())
        }

        fn pixel(&self, x: i32, y: i32) -> Rgba {
            self.memory.get_pixel(x, y).unwrap()
        }
    }

    #[test]
    fn only_changed_rows_are_converted_and_what_others_drew_stays() {
        let mut bench = Bench::new("bgrx", (21, 13));
        assert_eq!(bench.update(), (true, 0..13));
        assert!(!bench.update().0);
        bench.write((7 * 21 + 20) * 4, &[1, 2, 3, 77]);
        bench.memory.put_pixel(0, 6, [9; 4]);
        bench.memory.put_pixel(0, 7, [9; 4]);
        bench.memory.take_damage();
        assert_eq!(bench.update(), (true, 7..8));
        assert_eq!((bench.pixel(20, 7), bench.pixel(0, 6)), ([3, 2, 1, 255], [9; 4]));
        assert_eq!(bench.pixel(0, 7), [0, 0, 0, 255], "the program's row is shown whole");
        assert!(!bench.update().0);
    }

    #[test]
    fn rgba_is_taken_over_without_a_copy_unless_others_draw() {
        let mut bench = Bench::new("rgba", (21, 13));
        bench.scan = ScanOut::new(false);
        assert_eq!(bench.update(), (true, 0..13));
        assert_eq!(bench.pixel(3, 3), [0; 4]);
        assert!(!bench.update().0 && bench.scan.copy.is_empty());
        bench.write((7 * 21 + 20) * 4, &[1, 2, 3, 77]);
        assert_eq!((bench.update(), bench.pixel(20, 7)), ((true, 7..8), [1, 2, 3, 77]));
        // Two pages need a copy, and one page does not; both show what is in memory.
        bench.set_mode(|var| var.yres_virtual = 26);
        assert_eq!((bench.update(), bench.pixel(20, 7)), ((true, 0..13), [1, 2, 3, 77]));
        assert_eq!(bench.scan.copy.len(), bench.device.memory().len_bytes());
        bench.set_mode(|var| var.yres_virtual = 13);
        assert_eq!((bench.update(), bench.pixel(20, 7)), ((true, 0..13), [1, 2, 3, 77]));
        assert!(bench.scan.copy.is_empty() && !bench.update().0);
        bench.device.set_word(at::BLANK_AT, 1);
        assert!(bench.update().0 && bench.pixel(20, 7) == [0, 0, 0, 255] && !bench.update().0);
        bench.device.set_word(at::BLANK_AT, 0);
        assert_eq!((bench.update(), bench.pixel(20, 7)), ((true, 0..13), [1, 2, 3, 77]));
        bench.pan(0, 1);
        assert_eq!((bench.update(), bench.pixel(20, 6)), ((true, 0..13), [1, 2, 3, 77]));
        // What others have drawn stays where they draw.
        for (is_shared, expected) in [(true, [9; 4]), (false, [0; 4])] {
            let mut bench = Bench::new("rgba", (21, 13));
            bench.scan = ScanOut::new(is_shared);
            bench.update();
            bench.memory.put_pixel(5, 5, [9; 4]);
            bench.update();
            assert_eq!(bench.pixel(5, 5), expected, "others draw: {is_shared}");
            assert_eq!(bench.scan.copy.is_empty(), !is_shared);
        }
    }

    #[test]
    fn every_format_shows_its_channels() {
        for format in FORMATS.iter().filter(|f| f.bits >= 16) {
            let mut bench = Bench::new(format.name, (10, 9));
            let [red, _, blue, _] = format.channels;
            // A red pixel, then a blue one.
            let of = |c: super::super::mode::Bitfield| ((1u64 << c.length) - 1) << c.offset;
            let bytes = format.bits as usize / 8;
            bench.write(0, &of(red).to_le_bytes()[..bytes]);
            bench.write(bytes as u64, &of(blue).to_le_bytes()[..bytes]);
            bench.update();
            let alpha = if format.channels[3].length == 8 { 0 } else { 255 };
            let found = [bench.pixel(0, 0), bench.pixel(1, 0)];
            assert_eq!(found, [[255, 0, 0, alpha], [0, 0, 255, alpha]], "{}", format.name);
        }
    }

    #[test]
    fn every_value_of_every_channel_is_widened_by_the_kernels_rule() {
        for format in FORMATS.iter().filter(|f| f.bits >= 16) {
            let mut bench = Bench::new(format.name, (256, 8));
            for (channel, field) in format.channels.iter().enumerate().filter(|(_, field)| field.length > 0) {
                let values = 1u32 << field.length;
                let bytes = format.bits as usize / 8;
                let row: Vec<u8> = (0..values)
                    .flat_map(|v| (v << field.offset).to_le_bytes().into_iter().take(bytes))
                    .collect();
                bench.write(0, &row);
                bench.update();
                for v in 0..values {
                    // The value's bits again and again, from the highest down.
                    let repeated = v << (32 - field.length) | v << 32u32.saturating_sub(2 * field.length);
                    let found = bench.pixel(v as i32, 0);
                    let mut expected = [0, 0, 0, if format.channels[3].length == 8 { 0 } else { 255 }];
                    expected[channel] = (repeated >> 24) as u8;
                    assert_eq!(found, expected, "{} channel {channel}: {v}", format.name);
                }
            }
        }
    }

    #[test]
    fn each_of_256_indices_shows_its_entry_of_the_palette() {
        let mut bench = Bench::new("pal8", (256, 8));
        let indices: Vec<u8> = (0..=255).collect();
        bench.write(0, &indices);
        for i in 0..256u16 {
            let color = at::pack_color(i << 8 | i, (255 - i) * 257, (i ^ 0x5a) * 257, 0);
            bench.device.set_long(at::PALETTE_AT + usize::from(i) * 8, color);
        }
        bench.device.set_word(at::PALETTE_SETS_AT, 1);
        bench.update();
        for i in 0..=255u8 {
            assert_eq!(bench.pixel(i.into(), 0), [i, 255 - i, i ^ 0x5a, 255]);
        }
    }

    #[test]
    fn page_flips_show_no_mixed_frame_in_10_000() {
        const FLIPS: u32 = 10_000;
        let (width, height) = (16, 12);
        let mut bench = Bench::new("bgrx", (width, height));
        bench.set_mode(|var| var.yres_virtual = 2 * height);
        let Bench { device, scan, memory } = &mut bench;
        let device = &*device;
        let is_over = std::sync::atomic::AtomicBool::new(false);
        let (mut frames, mut colors) = (0, std::collections::HashSet::new());
        std::thread::scope(|scope| {
            scope.spawn(|| {
                // The program: each page has one colour, and is written while the other is visible.
                let page = u64::from(width * height * 4);
                for flip in 1..=FLIPS {
                    let (y, color) = (flip % 2, (flip % 251) as u8);
                    let bytes = vec![color; page as usize];
                    device.memory().file().write_all_at(&bytes, u64::from(y) * page).unwrap();
                    device.set_long(at::PAN_AT, u64::from(y * height) << 32);
                    device.set_word(at::PANS_AT, flip);
                    device.wait_for_pan(flip);
                }
                is_over.store(true, std::sync::atomic::Ordering::Release);
            });
            while !is_over.load(std::sync::atomic::Ordering::Acquire) {
                scan.update(device, memory);
                let pixels = memory.bytes().as_chunks::<4>().0;
                assert!(pixels.iter().all(|p| *p == pixels[0]), "frame {frames} is mixed: {pixels:?}");
                colors.insert(pixels[0]);
                frames += 1;
            }
        });
        assert!(frames >= FLIPS && colors.len() >= 251, "{frames} frames of {} colours", colors.len());
    }

    #[test]
    fn a_palette_changes_the_picture_without_its_memory() {
        for (name, bits) in [("pal8", 8), ("pal4", 4), ("pal2", 2), ("mono", 1)] {
            let mut bench = Bench::new(name, (16, 8));
            bench.write(0, &[1]);
            bench.update();
            bench.device.set_long(at::PALETTE_AT + 8, at::pack_color(0xffff, 0x8080, 0x0101, 0));
            assert!(!bench.update().0, "{bits}");
            bench.device.set_word(at::PALETTE_SETS_AT, 1);
            assert!(bench.update().0);
            assert_eq!(bench.pixel(0, 0), [255, 128, 1, 255], "{bits}");
            assert_ne!(bench.pixel(1, 0), bench.pixel(0, 0));
        }
    }

    #[test]
    fn palette_values_are_narrowed_as_the_kernel_does_it() {
        for value in 0..=u16::MAX {
            let wide = u64::from(value);
            assert_eq!(u64::from(narrow(value)), ((wide << 8) + 0x7fff - wide) >> 16);
        }
        assert_eq!([0, 128, 129, 0xff7f, 0xff80, 0xffff].map(narrow), [0, 0, 1, 254, 255, 255]);
        // Every eight-bit value that is repeated in both bytes comes back.
        assert!((0..=255u16).all(|v| u16::from(narrow(v << 8 | v)) == v));
    }

    #[test]
    fn the_first_row_is_the_lowest_where_the_program_says_so() {
        for format in ["rgba", "rgbx", "rgb24"] {
            let mut bench = Bench::new(format, (16, 10));
            bench.scan.is_shared = false;
            bench.write(0, &[1, 2, 3, 255]);
            bench.update();
            assert_eq!(bench.pixel(0, 0), [1, 2, 3, 255], "{format}");
            bench.device.set_word(at::FLIPPED_AT, 1);
            assert_eq!(bench.update(), (true, 0..10), "{format}");
            assert_eq!((bench.pixel(0, 9), bench.pixel(0, 0)[..3].to_vec()), ([1, 2, 3, 255], vec![0; 3]));
            assert!(!bench.update().0, "{format}: nothing has changed");
            let line = if format == "rgb24" { 48 } else { 64 };
            bench.write(9 * line, &[7, 8, 9, 255]);
            assert_eq!(bench.update(), (true, 0..1), "{format}");
            assert_eq!(bench.pixel(0, 0), [7, 8, 9, 255], "{format}");
        }
    }

    #[test]
    fn pages_are_flipped_and_a_place_off_the_memory_shows_nothing_new() {
        let mut bench = Bench::new("bgrx", (16, 10));
        bench.set_mode(|var| (var.xres_virtual, var.yres_virtual) = (17, 20));
        bench.write((17 * 10 + 1) * 4, &[7, 8, 9, 0]);
        bench.update();
        assert_eq!(bench.pixel(0, 0), [0, 0, 0, 255]);
        bench.pan(1, 10);
        assert_eq!(bench.update(), (true, 0..10));
        assert_eq!(bench.pixel(0, 0), [9, 8, 7, 255]);
        for (x, y) in [(u32::MAX, 0), (0, u32::MAX), (u32::MAX, u32::MAX), (2, 0), (0, 70)] {
            bench.pan(x, y);
            bench.update();
        }
        assert_eq!(bench.pixel(0, 0), [9, 8, 7, 255]);
    }

    #[test]
    fn a_smaller_mode_is_enlarged_in_the_middle_and_blanking_hides_it() {
        let mut bench = Bench::new("bgrx", (30, 20));
        bench.set_mode(|var| (var.xres, var.yres, var.xres_virtual, var.yres_virtual) = (14, 9, 14, 9));
        bench.write(0, &[1, 2, 3, 0]);
        bench.update();
        let shown: Vec<(i32, i32)> = (0..20)
            .flat_map(|y| (0..30).map(move |x| (x, y)))
            .filter(|(x, y)| bench.pixel(*x, *y) == [3, 2, 1, 255])
            .collect();
        assert_eq!(shown, [(1, 1), (2, 1), (1, 2), (2, 2)]);
        bench.device.set_word(at::BLANK_AT, 1);
        assert!(bench.update().0 && bench.pixel(1, 1) == [0, 0, 0, 255]);
        bench.device.set_word(at::BLANK_AT, 0);
        assert!(bench.update().0 && bench.pixel(1, 1) == [3, 2, 1, 255]);
    }

    #[test]
    fn a_row_whose_place_is_beyond_64_bits_shows_nothing() {
        let var = Var { xres: 16, yres: 10, xres_virtual: 1 << 30, bits_per_pixel: 32, ..Var::default() };
        // Rows of 2^32 bytes are none at all in 32 bits; those of one pixel less are almost that.
        let less = Var { xres_virtual: (1 << 30) - 1, ..var };
        let line = |var: &Var| var.xres_virtual.wrapping_mul(4);
        for y in [0, 9] {
            assert!(visible_bytes(&less, 32, line(&less), (0, u32::MAX), y, 4096).is_none());
            assert!(visible_bytes(&less, 32, line(&less), (u32::MAX, u32::MAX), y, 4096).is_none());
            assert!(visible_bytes(&var, 32, line(&var), (0, 1), y, 4096).is_none());
        }
        assert!(visible_bytes(&less, 32, line(&less), (0, 0), 0, 4096).is_some());
    }

    #[test]
    fn no_words_in_the_control_page_end_the_scan_out() {
        let mut bench = Bench::new("bgrx", (16, 10));
        let mut number = 1u32;
        for round in 0..3000 {
            number = number.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let value = if round % 3 == 0 { number } else { number >> (number % 32) };
            let at = (number >> 8) as usize % at::CONTROL_BYTES / 4 * 4;
            bench.device.set_word(at, value);
            if round % 50 == 0 {
                bench.device.set_word(at::MODE_SETS_AT, round);
            }
            bench.update();
        }
    }
}

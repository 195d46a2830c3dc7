//! PNG pictures up to their last row.
//!
//! In: the bytes of a file. Out: its pixels. The decoder of `image` unpacks everything that follows
//! the last row, too, which nobody sees: beside ten rows a file of some megabytes may hold gigabytes.
//! This one ends with the rows that the header announced; the rest of a short file is unpacked,
//! because that checks its sums.

use image::error::{DecodingError, UnsupportedError, UnsupportedErrorKind};
use image::{ColorType, ImageDecoder, ImageError, ImageFormat, ImageResult};
use std::io::{BufRead, Seek};

/// Longest file in bytes that is unpacked to its end: to 66 MB at most.
const SHORT_FILE: usize = 64 << 10;

/// First column and row of each pass of an interlaced picture, and their distances.
const PASSES: [[u32; 4]; 7] =
    [[0, 0, 8, 8], [4, 0, 8, 8], [0, 4, 4, 8], [2, 0, 4, 4], [0, 2, 2, 4], [1, 0, 2, 2], [0, 1, 1, 2]];

/// A decoder whose header was read.
pub(super) struct PngRows<R: BufRead + Seek> {
    reader: png::Reader<R>,
    color_type: ColorType,
    is_short: bool,
}

fn undecodable(error: png::DecodingError) -> ImageError {
    ImageError::Decoding(DecodingError::new(ImageFormat::Png.into(), error))
}

impl<R: BufRead + Seek> PngRows<R> {
    /// Reads the header of a file of `file_bytes`. Palettes and profiles may take `header_bytes`.
    ///
    /// # Errors
    /// If the header cannot be read.
    pub fn new(input: R, file_bytes: usize, header_bytes: usize) -> ImageResult<Self> {
        let mut decoder = png::Decoder::new_with_limits(input, png::Limits { bytes: header_bytes });
        decoder.set_ignore_text_chunk(true);
        // Palettes and fewer than eight bits become bytes; sixteen bits stay.
        decoder.set_transformations(png::Transformations::EXPAND);
        let reader = decoder.read_info().map_err(undecodable)?;
        use png::{BitDepth as Bits, ColorType as Kind};
        let color_type = match reader.output_color_type() {
            (Kind::Grayscale, Bits::Eight) => ColorType::L8,
            (Kind::Grayscale, Bits::Sixteen) => ColorType::L16,
            (Kind::GrayscaleAlpha, Bits::Eight) => ColorType::La8,
            (Kind::GrayscaleAlpha, Bits::Sixteen) => ColorType::La16,
            (Kind::Rgb, Bits::Eight) => ColorType::Rgb8,
            (Kind::Rgb, Bits::Sixteen) => ColorType::Rgb16,
            (Kind::Rgba, Bits::Eight) => ColorType::Rgba8,
            (Kind::Rgba, Bits::Sixteen) => ColorType::Rgba16,
            (kind, bits) => {
                let what = UnsupportedErrorKind::GenericFeature(format!("{kind:?} of {bits:?} bits"));
                let error = UnsupportedError::from_format_and_kind(ImageFormat::Png.into(), what);
                return Err(ImageError::Unsupported(error));
            }
        };
        Ok(PngRows { reader, color_type, is_short: file_bytes <= SHORT_FILE })
    }
}

/// Returns the number of rows of all passes of an interlaced picture.
fn interlaced_rows(width: u32, height: u32) -> u64 {
    let count = |length: u32, first: u32, step: u32| u64::from(length.saturating_sub(first).div_ceil(step));
    let rows = |&[x, y, dx, dy]: &[u32; 4]| match count(width, x, dx) {
        0 => 0,
        _ => count(height, y, dy),
    };
    PASSES.iter().map(rows).sum()
}

impl<R: BufRead + Seek> ImageDecoder for PngRows<R> {
    fn dimensions(&self) -> (u32, u32) {
        self.reader.info().size()
    }

    fn color_type(&self) -> ColorType {
        self.color_type
    }

    fn read_image(mut self, out: &mut [u8]) -> ImageResult<()> {
        let (width, height) = self.dimensions();
        let stride = self.reader.output_line_size(width);
        let bits = 8 * self.color_type.bytes_per_pixel();
        if self.reader.info().interlaced {
            for _ in 0..interlaced_rows(width, height) {
                let Some(row) = self.reader.next_interlaced_row().map_err(undecodable)? else { break };
                if let png::InterlaceInfo::Adam7(pass) = row.interlace() {
                    png::expand_interlaced_row(out, stride, row.data(), pass, bits);
                }
            }
        } else {
            for to in out.chunks_exact_mut(stride.max(1)) {
                let Some(row) = self.reader.next_row().map_err(undecodable)? else { break };
                to.copy_from_slice(row.data());
            }
        }
        if self.is_short {
            self.reader.next_row().map_err(undecodable)?;
        }
        if self.color_type.bytes_per_pixel() / self.color_type.channel_count() == 2 {
            let values = out.as_chunks_mut::<2>().0;
            values.iter_mut().for_each(|v| *v = u16::from_be_bytes(*v).to_ne_bytes());
        }
        Ok(())
    }

    fn read_image_boxed(self: Box<Self>, out: &mut [u8]) -> ImageResult<()> {
        (*self).read_image(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Write};

    fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
        let body = [&kind[..], data].concat();
        let sum = crc32fast::hash(&body);
        [&(data.len() as u32).to_be_bytes()[..], &body, &sum.to_be_bytes()].concat()
    }

    /// Returns a file of rows as they are filtered; `bits` of a channel, kind and interlace method.
    fn file([width, height]: [u32; 2], [bits, kind, interlace]: [u8; 3], rows: &[u8]) -> Vec<u8> {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        packer.write_all(rows).unwrap();
        let size = [width.to_be_bytes(), height.to_be_bytes()].concat();
        let header = [&size[..], &[bits, kind, 0, 0, interlace]].concat();
        let data = packer.finish().unwrap();
        let chunks = [chunk(b"IHDR", &header), chunk(b"IDAT", &data), chunk(b"IEND", &[])].concat();
        [b"\x89PNG\r\n\x1a\n", &chunks[..]].concat()
    }

    /// Returns the pixels by this decoder, and how many bytes it has read.
    fn decode(bytes: &[u8]) -> (Vec<u8>, u64) {
        let mut input = Cursor::new(bytes);
        let decoder = PngRows::new(&mut input, bytes.len(), 1 << 20).unwrap();
        let mut out = vec![0; decoder.total_bytes() as usize];
        decoder.read_image(&mut out).unwrap();
        (out, input.position())
    }

    #[test]
    fn what_follows_the_last_row_is_not_unpacked() {
        let mut rows = Vec::new();
        (0..10u8).for_each(|y| rows.extend([&[0][..], &[y; 40]].concat()));
        let picture: Vec<u8> = (0..10u8).flat_map(|y| [y; 40]).collect();
        rows.resize(100 << 20, 0);
        let bomb = file([10, 10], [8, 6, 0], &rows);
        assert!(bomb.len() > SHORT_FILE, "{}", bomb.len());
        let (pixels, read) = decode(&bomb);
        assert!(pixels == picture && read < SHORT_FILE as u64, "{read} of {}", bomb.len());
    }

    #[test]
    fn pixels_are_those_of_the_whole_decoder() {
        for kind in [0, 2, 4, 6] {
            for (interlace, bits) in [(0, 8), (0, 16), (1, 8), (1, 16)] {
                for [width, height] in [[1, 1], [3, 5], [9, 9], [17, 2]] {
                    let channels = [1, 0, 3, 0, 2, 0, 4][usize::from(kind)];
                    let bytes = channels * u32::from(bits) / 8;
                    let mut rows = Vec::new();
                    let whole = [[0, 0, 1, 1]];
                    let passes = if interlace == 1 { &PASSES[..] } else { &whole[..] };
                    for &[x, y, dx, dy] in passes {
                        let columns = width.max(x).abs_diff(x).div_ceil(dx);
                        let lines = height.max(y).abs_diff(y).div_ceil(dy);
                        for _ in 0..if columns == 0 { 0 } else { lines } {
                            let seed = rows.len() as u32;
                            rows.push(0);
                            rows.extend((0..columns * bytes).map(|i| ((seed + i) * 37 % 251) as u8));
                        }
                    }
                    let bytes = file([width, height], [bits, kind, interlace], &rows);
                    let whole = image::codecs::png::PngDecoder::new(Cursor::new(&bytes[..])).unwrap();
                    let mut want = vec![0; whole.total_bytes() as usize];
                    whole.read_image(&mut want).unwrap();
                    assert!(decode(&bytes).0 == want, "{kind} {interlace} {bits} {width}x{height}");
                }
            }
        }
    }
}

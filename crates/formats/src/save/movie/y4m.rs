//! YUV4MPEG2: a header line, then `FRAME` and three planes for each frame. It needs no end marker
//! and no seeking, so it suits pipes.
//!
//! C444 in studio range, by ITU-R BT.601 in integers, rounded half up (kr = .299, kb = .114): Y =
//! 16 + 219 (kr R + kg G + kb B) / 255, Cb = 128 + 224 (B - y) / (2 (1 - kb)) / 255, Cr likewise
//! with R and kr.

use super::FrameWriter;
use fbptr_core::memory::VideoMemory;
use std::io::{self, Write};

/// Writer of a y4m stream.
pub(super) struct Y4m {
    out: Box<dyn Write + Send>,
    header: Option<String>,
    planes: Vec<u8>,
}

impl Y4m {
    pub fn new(out: Box<dyn Write + Send>, width: u32, height: u32, rate: f64) -> Self {
        let [frames, seconds] = fraction(rate);
        let header = format!("YUV4MPEG2 W{width} H{height} F{frames}:{seconds} Ip A1:1 C444\n");
        Y4m { out, header: Some(header), planes: Vec::new() }
    }
}

impl FrameWriter for Y4m {
    fn frame(&mut self, memory: &VideoMemory) -> io::Result<()> {
        let pixels = memory.bytes().as_chunks::<4>().0;
        self.planes.clear();
        if let Some(header) = self.header.take() {
            self.planes.extend_from_slice(header.as_bytes());
        }
        self.planes.extend_from_slice(b"FRAME\n");
        for plane in 0..3 {
            self.planes.extend(pixels.iter().map(|&p| studio(p)[plane]));
        }
        self.out.write_all(&self.planes)?;
        self.out.flush()
    }
}

/// Returns Y, Cb, Cr of a pixel, computed with 16 fractional bits.
#[inline(always)]
fn studio([r, g, b, _]: [u8; 4]) -> [u8; 3] {
    let [r, g, b] = [r, g, b].map(i32::from);
    let round = |v: i32| ((v + (1 << 15)) >> 16) as u8;
    [
        round((16 << 16) + 16_829 * r + 33_039 * g + 6_416 * b),
        round((128 << 16) - 9_714 * r - 19_070 * g + 28_784 * b),
        round((128 << 16) + 28_784 * r - 24_103 * g - 4_681 * b),
    ]
}

/// Returns a rate as a reduced fraction, rounded to a thousandth.
fn fraction(rate: f64) -> [u64; 2] {
    let thousandths = (rate * 1000.0).round().max(1.0) as u64;
    let common = num_integer::gcd(thousandths, 1000);
    [thousandths / common, 1000 / common]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_corners_of_the_colour_cube_are_those_of_the_standard() {
        // ITU-R BT.601, 100 % colour bars in 8 bits.
        for (rgb, yuv) in [
            ([0, 0, 0], [16, 128, 128]),
            ([255, 255, 255], [235, 128, 128]),
            ([255, 0, 0], [81, 90, 240]),
            ([0, 255, 0], [145, 54, 34]),
            ([0, 0, 255], [41, 240, 110]),
            ([255, 255, 0], [210, 16, 146]),
        ] {
            assert_eq!(studio([rgb[0], rgb[1], rgb[2], 7]), yuv, "{rgb:?}");
        }
        // Greys have no colour at all.
        assert!((0..=255).all(|v| studio([v, v, v, 0])[1..] == [128, 128]));
    }

    #[test]
    fn rates_are_fractions() {
        assert_eq!([fraction(25.0), fraction(29.97), fraction(0.5)], [[25, 1], [2997, 100], [1, 2]]);
    }
}

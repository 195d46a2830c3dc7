//! Glowing lines: light that adds up, as on a screen of vectors.
//!
//! In: segments on the screen in pixels, with brightness and hue at both ends. Out: pixels. A
//! segment gives each pixel, at a distance of d pixels from it, the light
//! core (1 - d)^+ + halo / (1 + d^2 / s^2), which fades to nothing at [`REACH`]; the ends are round.
//! The sum of all light L becomes the byte 255 L / (1 + L), so that crossings are brighter and
//! nothing is cut off. Lines are smooth by themselves.

use fbptr_core::memory::VideoMemory;

/// Distance in pixels at which the glow has ended, on a frame of 720 rows.
const REACH: f32 = 26.0;
/// Light on the line itself.
const CORE: f32 = 2.6;
/// Light of the glow around it.
const HALO: f32 = 0.30;
/// Half width of the glow in pixels, on a frame of 720 rows.
const WIDTH: f32 = 4.0;

/// End of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    /// Place in pixels.
    pub at: [f32; 2],
    /// Brightness, 1 in the middle of the depth.
    pub light: f32,
    /// Colour: R, G, B in 0..=1.
    pub color: [f32; 3],
}

/// Light on a rectangle of pixels.
pub(super) struct Glow {
    size: [usize; 2],
    light: Vec<[f32; 3]>,
}

impl Glow {
    /// Creates a dark rectangle.
    pub fn new(size: [usize; 2]) -> Self {
        Glow { size, light: vec![[0.0; 3]; size[0] * size[1]] }
    }

    /// Adds the light of a segment.
    pub fn add(&mut self, a: End, b: End) {
        let scale = self.size[1] as f32 / 720.0;
        let (reach, width) = ((REACH * scale).max(6.0), (WIDTH * scale).max(1.2));
        let along = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
        let squared = along[0] * along[0] + along[1] * along[1];
        let finite = squared.is_finite() && a.at.iter().chain(&b.at).all(|v| v.abs() < 1e6);
        if !finite {
            return;
        }
        let rows = range(a.at[1].min(b.at[1]) - reach, a.at[1].max(b.at[1]) + reach, self.size[1]);
        for y in rows {
            // Only the columns near the part of the segment that this row can see.
            let (from, to) = columns(&a, along, [y as f32 + 0.5 - reach, y as f32 + 0.5 + reach]);
            for x in range(from - reach, to + reach, self.size[0]) {
                let off = [x as f32 + 0.5 - a.at[0], y as f32 + 0.5 - a.at[1]];
                let t = match squared > 0.0 {
                    true => ((off[0] * along[0] + off[1] * along[1]) / squared).clamp(0.0, 1.0),
                    false => 0.0,
                };
                let away = [off[0] - t * along[0], off[1] - t * along[1]];
                let d2 = away[0] * away[0] + away[1] * away[1];
                let fade = 1.0 - d2 / (reach * reach);
                if fade <= 0.0 {
                    continue;
                }
                let core = (1.35 - d2.sqrt()).clamp(0.0, 1.0) * CORE;
                let light = (core + HALO * fade * fade / (1.0 + d2 / (width * width)))
                    * (a.light + (b.light - a.light) * t);
                let sum = &mut self.light[y * self.size[0] + x];
                for (c, sum) in sum.iter_mut().enumerate() {
                    *sum += light * (a.color[c] + (b.color[c] - a.color[c]) * t);
                }
            }
        }
    }

    /// Adds the light to the pixels of a frame, from its upper left corner `at`.
    pub fn paint(&self, memory: &mut VideoMemory, at: [usize; 2]) {
        let width = memory.width() as usize;
        let pixels = memory.bytes_mut().as_chunks_mut::<4>().0;
        for (y, row) in self.light.chunks(self.size[0]).enumerate() {
            let start = (at[1] + y) * width + at[0];
            let Some(pixels) = pixels.get_mut(start..start + self.size[0]) else { return };
            for (pixel, light) in pixels.iter_mut().zip(row) {
                for (byte, l) in pixel.iter_mut().zip(light) {
                    *byte = (f32::from(*byte) + (255.0 - f32::from(*byte)) * l / (1.0 + l) + 0.5) as u8;
                }
            }
        }
    }
}

/// Returns the whole numbers from `from` to `to` that are below `end`.
fn range(from: f32, to: f32, end: usize) -> std::ops::Range<usize> {
    from.max(0.0) as usize..((to.max(0.0) + 1.0) as usize).min(end)
}

/// Returns the least and largest x of the part of a segment that lies between two heights.
fn columns(a: &End, along: [f32; 2], [top, bottom]: [f32; 2]) -> (f32, f32) {
    let (mut from, mut to) = (0.0_f32, 1.0_f32);
    if along[1] != 0.0 {
        let (t0, t1) = ((top - a.at[1]) / along[1], (bottom - a.at[1]) / along[1]);
        (from, to) = (from.max(t0.min(t1)), to.min(t0.max(t1)));
    }
    let (x0, x1) = (a.at[0] + along[0] * from, a.at[0] + along[0] * to.max(from));
    (x0.min(x1), x0.max(x1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn end(at: [f32; 2]) -> End {
        End { at, light: 1.0, color: [1.0, 0.5, 0.25] }
    }

    #[test]
    fn light_falls_with_the_distance_and_ends() {
        let mut glow = Glow::new([200, 100]);
        glow.add(end([30.5, 50.5]), end([160.5, 50.5]));
        let column: Vec<f32> = (50..100).map(|y| glow.light[y * 200 + 100][0]).collect();
        assert!(column[0] > 2.0 && column.windows(2).all(|w| w[1] <= w[0]), "{column:?}");
        assert_eq!(column[30], 0.0);
        let red: f32 = glow.light.iter().map(|l| l[0]).sum();
        let green: f32 = glow.light.iter().map(|l| l[1]).sum();
        assert!((red / green - 2.0).abs() < 1e-3);
    }

    #[test]
    fn the_rows_skip_no_light() {
        // Every pixel that a row's bounds leave out is dark: compare with one row at a time of a
        // segment turned on its side.
        let mut a = Glow::new([120, 120]);
        a.add(end([20.0, 13.0]), end([90.0, 101.0]));
        let mut b = Glow::new([120, 120]);
        b.add(end([13.0, 20.0]), end([101.0, 90.0]));
        for (x, y) in (0..120).flat_map(|y| (0..120).map(move |x| (x, y))) {
            let off = (a.light[y * 120 + x][0] - b.light[x * 120 + y][0]).abs();
            assert!(off < 1e-3, "{x} {y}: {off}");
        }
    }

    #[test]
    fn any_segment_is_harmless() {
        let mut glow = Glow::new([20, 10]);
        for at in [[f32::NAN, 0.0], [1e30, 5.0], [-500.0, -500.0], [5.0, 5.0]] {
            glow.add(end([5.0, 5.0]), end(at));
        }
        let mut memory = VideoMemory::new(20, 10).expect("small");
        glow.paint(&mut memory, [0, 0]);
        assert!(memory.bytes().iter().any(|&b| b != 0 && b != 255));
    }
}

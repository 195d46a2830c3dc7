//! Vector sampling compared with the definition, evaluated in f64: the mean of 2x2 texels for each
//! level, four texels interpolated, two levels weighted by the fraction of D = log2 L.

use super::*;
use crate::simd::{Kernel, Level};

/// Largest difference from the definition, colours being 0..1: f32 finds the level to about 1e-4.
const TOLERANCE: f64 = 3e-4;

/// Pixel: u, v, their steps to the right and below, and whether a neighbour lies beyond the
/// horizon.
#[derive(Clone, Copy, Debug)]
struct Pixel {
    uv: [f32; 2],
    steps: [[f32; 2]; 2],
    is_horizon: bool,
}

struct Look<'a>(&'a TextureSampler<'a>, &'a [Pixel]);

impl Kernel for Look<'_> {
    type Output = Vec<[f32; 3]>;
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let mut out = Vec::new();
        for pixels in self.1.chunks_exact(S::LANES) {
            let column = |of: &dyn Fn(&Pixel) -> f32| s.load(&pixels.iter().map(of).collect::<Vec<_>>());
            let [right, below] = [0, 1].map(|k| [0, 1].map(|axis| column(&|p| p.steps[k][axis])));
            let bits = pixels.iter().enumerate().map(|(i, p)| u32::from(p.is_horizon) << i).sum();
            let footprint = UvDerivatives { right, below, is_horizon: s.mask(bits) };
            let (zero, all) = (s.splat(0.0), s.mask(u32::MAX >> (32 - S::LANES)));
            let uv = [0, 1].map(|axis| column(&|p| p.uv[axis]));
            let sample_coord = self.0.sample_coord(s, [uv, [zero; 2]], [zero; 2], Some(footprint));
            let texel_addresses = self.0.texel_addresses(s, all, &sample_coord);
            let mut lanes = [[0f32; 16]; 3];
            let rgb = self.0.texel(s, all, &sample_coord, &texel_addresses);
            rgb.iter().zip(&mut lanes).for_each(|(c, lanes)| s.store(*c, &mut lanes[..S::LANES]));
            out.extend((0..S::LANES).map(|i| lanes.map(|c| c[i])));
        }
        out
    }
}

/// Size of a level and its texels, rows from below.
type Rows = (i64, i64, Vec<[f64; 3]>);

/// Returns every level: texel i is the mean of 2i and 2i+1 on both axes, or for a side of 1 of the
/// one texel twice.
fn levels(width: i64, height: i64, bytes: &[u8]) -> Vec<Rows> {
    let row = |y: i64| (0..width).map(move |x| 4 * ((height - 1 - y) * width + x) as usize);
    let texels = (0..height).flat_map(row).map(|at| [0, 1, 2].map(|c| f64::from(bytes[at + c]) / 255.0));
    let mut levels = vec![(width, height, texels.collect::<Vec<_>>())];
    while let Some((w, h, above)) = levels.last().filter(|l| (l.0, l.1) != (1, 1)) {
        let (half_w, half_h) = ((w / 2).max(1), (h / 2).max(1));
        let mean = |x: i64, y: i64| {
            // Rows are dropped at the lower edge of the picture, which is row 0 here.
            let first = if *h > 1 { h - 2 * half_h } else { 0 };
            let (xs, ys) = ([2 * x, (2 * x + 1).min(w - 1)], [first + 2 * y, (first + 2 * y + 1).min(h - 1)]);
            [0, 1, 2].map(|c| {
                xs.iter().flat_map(|x| ys.map(|y| above[(y * w + x) as usize][c])).sum::<f64>() / 4.0
            })
        };
        let below = (0..half_h).flat_map(|y| (0..half_w).map(move |x| (x, y))).map(|(x, y)| mean(x, y));
        let below = (half_w, half_h, below.collect());
        levels.push(below);
    }
    levels
}

/// Interpolates the four texels around u, v.
fn inputs((w, h, texels): &Rows, sampling: Sampling, [u, v]: [f32; 2]) -> [f64; 3] {
    let (x, y) = (f64::from(u) * *w as f64 - 0.5, f64::from(v) * *h as f64 - 0.5);
    let mut sum = [0.0; 3];
    for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let (i, j) = (x.floor() + f64::from(i), y.floor() + f64::from(j));
        let weight = (1.0 - (x - i).abs()) * (1.0 - (y - j).abs());
        let texel = texels[(at(j, sampling.wrap_t, *h) * w + at(i, sampling.wrap_s, *w)) as usize];
        sum.iter_mut().zip(texel).for_each(|(sum, c)| *sum += weight * c);
    }
    sum
}

fn at(texel: f64, wrap: Wrap, size: i64) -> i64 {
    match wrap {
        Wrap::Repeat => (texel as i64).rem_euclid(size),
        Wrap::Clamp => (texel as i64).clamp(0, size - 1),
    }
}

/// Returns the definition's colour; `None` within a thousandth of a discontinuity.
fn expected_texel(levels: &[Rows], sampling: Sampling, pixel: &Pixel) -> Option<[f64; 3]> {
    let (w, h) = (levels[0].0 as f64, levels[0].1 as f64);
    let length = |[u, v]: [f32; 2]| (f64::from(u) * w).hypot(f64::from(v) * h);
    let top = (levels.len() - 1) as f64;
    let longer = length(pixel.steps[0]).max(length(pixel.steps[1]));
    let d = if pixel.is_horizon { top } else { longer.log2().clamp(0.0, top) };
    let on = |level: f64| inputs(&levels[level.min(top) as usize], sampling, pixel.uv);
    match sampling.filter {
        Filter::Nearest => {
            let [x, y] = [f64::from(pixel.uv[0]) * w, f64::from(pixel.uv[1]) * h];
            let is_edge = [x, y].iter().any(|c| (c - c.round()).abs() < 1e-3);
            let (i, j) = (at(x.floor(), sampling.wrap_s, w as i64), at(y.floor(), sampling.wrap_t, h as i64));
            (!is_edge).then(|| levels[0].2[(j * w as i64 + i) as usize])
        }
        Filter::Bilinear => Some(on(0.0)),
        Filter::Mipmap => {
            ((d - d.floor() - 0.5).abs() > f64::from(LEVEL_EDGE)).then(|| on((d + 0.5).floor()))
        }
        Filter::Trilinear => {
            let (near, far, part) = (on(d.floor()), on(d.floor() + 1.0), d - d.floor());
            Some(std::array::from_fn(|c| near[c] * (1.0 - part) + far[c] * part))
        }
    }
}

/// Returns pixels with footprints from half a texel to beyond the top level, alternately along and
/// across the texture.
fn pixels(width: f32, height: f32) -> Vec<Pixel> {
    let spread = |i: u32, by: u32| (i.wrapping_mul(by) >> 8) as f32 / (1 << 24) as f32;
    (0..1600)
        .map(|i| {
            let (longer, turn) = ((i as f32 / 180.0 - 1.0).exp2(), i as f32 * 0.37);
            let step = |length: f32, turn: f32| [length * turn.cos() / width, length * turn.sin() / height];
            let (a, b) = (step(longer, turn), step(longer * 0.6, turn + 1.9));
            Pixel {
                uv: [spread(i, 2_654_435_761) * 3.0 - 1.0, spread(i, 2_246_822_519) * 3.0 - 1.0],
                steps: if i % 2 == 0 { [a, b] } else { [b, a] },
                is_horizon: i % 97 == 0,
            }
        })
        .collect()
}

#[test]
fn every_filter_gives_the_definitions_texels() {
    for (width, height) in [(64u32, 64u32), (64, 16), (37, 22)] {
        // Contrast at every scale, so that each level differs from the next: noise, a pattern of
        // all sizes, large squares.
        let texel = |i: u32| {
            let (x, y) = (i % width, i / width);
            let noise = (i.wrapping_mul(2_654_435_761) >> 24) as u8;
            [noise, ((x ^ y) * 4) as u8, if (x / 8 + y / 8) % 2 == 0 { 250 } else { 5 }, 255]
        };
        let bytes: Vec<u8> = (0..width * height).flat_map(texel).collect();
        let texture = Texture::new(width, height, bytes.clone()).unwrap();
        let levels = levels(width.into(), height.into(), &bytes);
        let pixels = pixels(width as f32, height as f32);
        for (filter, wrap) in Filter::ALL.iter().flat_map(|f| Wrap::ALL.iter().map(move |w| (*f, *w))) {
            let other = if wrap == Wrap::Clamp { Wrap::Repeat } else { Wrap::Clamp };
            let sampling = Sampling { filter, wrap_s: wrap, wrap_t: other };
            let shade = TextureSampler::new(&texture, sampling);
            for level in Level::ALL {
                let got = level.dispatch(Look(&shade, &pixels));
                let mut compared = 0;
                for (got, pixel) in got.iter().zip(&pixels) {
                    let Some(want) = expected_texel(&levels, sampling, pixel) else { continue };
                    compared += 1;
                    let error = (0..3).map(|c| (f64::from(got[c]) - want[c]).abs()).fold(0.0, f64::max);
                    assert!(
                        error < TOLERANCE,
                        "{width}x{height} {sampling:?} {pixel:?}: {got:?} for {want:?}"
                    );
                }
                assert!(compared > pixels.len() * 9 / 10, "{compared}");
            }
        }
    }
}

/// Returns the lanes that are too near to a level's edge, for steps of these lengths in texels.
struct Edges<'a>(&'a TextureSampler<'a>, &'a [f32]);

impl Kernel for Edges<'_> {
    type Output = Vec<bool>;
    fn run<S: Simd>(self, s: S) -> Self::Output {
        let (zero, all) = (s.splat(0.0), s.mask(u32::MAX >> (32 - S::LANES)));
        let needs_f64 = |length: &f32| {
            let right = [s.splat(*length / self.0.texture.width() as f32), zero];
            let footprint = UvDerivatives { right, below: [zero; 2], is_horizon: s.mask(0) };
            let sample_coord = self.0.sample_coord(s, [[zero; 2]; 2], [zero; 2], Some(footprint));
            self.0.texel_addresses(s, all, &sample_coord).needs_f64.any()
        };
        self.1.iter().map(needs_f64).collect()
    }
}

#[test]
fn pixels_next_to_where_the_level_changes_are_left_to_f64_on_both_sides() {
    let texture = Texture::new(64, 64, vec![128; 64 * 64 * 4]).unwrap();
    let sampling = Sampling { filter: Filter::Mipmap, ..Sampling::default() };
    let sampler = TextureSampler::new(&texture, sampling);
    // Level 2 is nearest for D = log2 L from 1.5 to 2.5.
    let lengths = [1.5f32, 2.5].map(|d| [-0.5, -4e-4, 0.0, 4e-4, 0.5].map(|off| (d + off).exp2()));
    for level in Level::ALL {
        for lengths in lengths {
            assert_eq!(level.dispatch(Edges(&sampler, &lengths)), [false, true, true, true, false]);
        }
        // Below level 0 nothing changes.
        assert_eq!(level.dispatch(Edges(&sampler, &[0.001, 0.25, 0.5f32.sqrt() * 0.5])), [false; 3]);
    }
}

//! Texture sampling: level of detail, wrapping and filtering.
//!
//! In: a texture, sampling modes, u, v and the pixel's footprint. Out: R, G, B, A in 0..1.
//! (0,0) is the lower left corner of the picture; texel centres are at .5. L is the longer of the
//! two footprint vectors to (x+1,y) and (x,y+1) in texels of level 0, D = log2 L (notes 003); each
//! level is sampled in its own size.

use crate::math::power::log2;
use crate::scene::{Filter, Sampling, Texture, Wrap};
use glam::DVec2;

/// Distance of neighbouring pixels on the texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Footprint {
    /// Steps of u, v to the pixel on the right and to the one below.
    Steps(DVec2, DVec2),
    /// A neighbour lies beyond the horizon of the face's plane.
    Horizon,
}

impl Footprint {
    /// Returns D = log2 of the longer step in texels; +inf beyond the horizon, -inf for a step of
    /// zero.
    pub fn level(&self, width: u32, height: u32) -> f64 {
        let Footprint::Steps(right, down) = self else { return f64::INFINITY };
        let size = DVec2::new(width as f64, height as f64);
        let longer = (*right * size).length_squared().max((*down * size).length_squared());
        if longer.is_nan() { f64::INFINITY } else { 0.5 * log2(longer) }
    }
}

/// Returns the texture's R, G, B, A in 0..1 at `uv`. `level` returns D; only the mip filters call
/// it.
pub(crate) fn sample(
    texture: &Texture,
    sampling: Sampling,
    uv: DVec2,
    level: impl FnOnce() -> f64,
) -> [f64; 4] {
    let last = texture.level_count() - 1;
    // Saturates: -inf and NaN give level 0, +inf the last.
    let clamped = |d: f64| (d.max(0.0) as u32).min(last);
    let texel = match sampling.filter {
        Filter::Nearest => nearest(texture, sampling, uv),
        Filter::Bilinear => bilinear(texture, sampling, uv, 0),
        Filter::Mipmap => bilinear(texture, sampling, uv, clamped((level() + 0.5).floor())),
        Filter::Trilinear => {
            let d = level().max(0.0);
            let (near, far) = (clamped(d.floor()), clamped(d.floor() + 1.0));
            let a = bilinear(texture, sampling, uv, near);
            if near == far {
                a
            } else {
                let b = bilinear(texture, sampling, uv, far);
                let t = d - d.floor();
                std::array::from_fn(|c| a[c] + (b[c] - a[c]) * t)
            }
        }
    };
    texel.map(|c| c / 255.0)
}

/// Converts a coordinate to texels of a side of `size` (0 at the left or lower end), within the
/// range where integers are exact.
fn in_texels(coordinate: f64, wrap: Wrap, size: u32) -> f64 {
    match wrap {
        // The integer part is dropped first: the rest is exact, however large the coordinate was.
        Wrap::Repeat => (coordinate - coordinate.floor()) * size as f64,
        Wrap::Clamp => (coordinate * size as f64).clamp(-1.0, size as f64 + 1.0),
    }
}

/// Returns a texel index wrapped into 0..size.
fn wrapped(texel: i64, wrap: Wrap, size: u32) -> u32 {
    match wrap {
        Wrap::Repeat => texel.rem_euclid(size as i64) as u32,
        Wrap::Clamp => texel.clamp(0, size as i64 - 1) as u32,
    }
}

/// Returns the texel in column i and row j of a level, counted from the lower left, with 0..255 per
/// channel.
fn fetch(texture: &Texture, sampling: Sampling, level: u32, i: i64, j: i64) -> [f64; 4] {
    let (w, h) = texture.level_size(level);
    let (x, y) = (wrapped(i, sampling.wrap_s, w), wrapped(j, sampling.wrap_t, h));
    // Rows are stored from the top, v counts from below.
    texture.texel(level, x, h - 1 - y).map(f64::from)
}

/// Returns the texel of level 0 that contains `uv`.
fn nearest(texture: &Texture, sampling: Sampling, uv: DVec2) -> [f64; 4] {
    let s = in_texels(uv.x, sampling.wrap_s, texture.width());
    let t = in_texels(uv.y, sampling.wrap_t, texture.height());
    fetch(texture, sampling, 0, s.floor() as i64, t.floor() as i64)
}

/// Interpolates the four texels of a level around `uv`.
fn bilinear(texture: &Texture, sampling: Sampling, uv: DVec2, level: u32) -> [f64; 4] {
    let (w, h) = texture.level_size(level);
    let s = in_texels(uv.x, sampling.wrap_s, w) - 0.5;
    let t = in_texels(uv.y, sampling.wrap_t, h) - 0.5;
    let (i, j) = (s.floor(), t.floor());
    let (fs, ft) = (s - i, t - j);
    let (i, j) = (i as i64, j as i64);
    let [a, b] = [0, 1].map(|dj| {
        let [a, b] = [0, 1].map(|di| fetch(texture, sampling, level, i + di, j + dj));
        std::array::from_fn::<f64, 4, _>(|c| a[c] + (b[c] - a[c]) * fs)
    });
    std::array::from_fn(|c| a[c] + (b[c] - a[c]) * ft)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture() -> Texture {
        // 2x2: red green / blue white, top row first.
        let bytes = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 0]];
        Texture::new(2, 2, bytes.concat()).unwrap()
    }

    fn with(filter: Filter, wrap: Wrap) -> Sampling {
        Sampling { filter, wrap_s: wrap, wrap_t: wrap }
    }

    #[test]
    fn lower_left_is_the_origin_and_centres_are_at_a_half() {
        let t = picture();
        for filter in [Filter::Nearest, Filter::Bilinear] {
            let at = |u, v| sample(&t, with(filter, Wrap::Repeat), DVec2::new(u, v), || 0.0);
            assert_eq!(at(0.25, 0.25), [0.0, 0.0, 1.0, 1.0], "{filter:?}");
            assert_eq!(at(0.25, 0.75), [1.0, 0.0, 0.0, 1.0], "{filter:?}");
            assert_eq!(at(10_000_000.75, -4.75), [1.0, 1.0, 1.0, 0.0], "{filter:?}");
        }
        let middle = sample(&t, with(Filter::Bilinear, Wrap::Clamp), DVec2::splat(0.5), || 0.0);
        assert_eq!(middle, [0.5, 0.5, 0.5, 0.75]);
    }

    #[test]
    fn repeat_goes_on_and_clamp_stands_still() {
        let t = picture();
        let at = |wrap, u| sample(&t, with(Filter::Bilinear, wrap), DVec2::new(u, 0.25), || 0.0);
        assert_eq!(at(Wrap::Repeat, 0.0), [0.5, 0.5, 1.0, 0.5]);
        assert_eq!(at(Wrap::Clamp, 0.0), [0.0, 0.0, 1.0, 1.0]);
        assert_eq!(at(Wrap::Clamp, 7.0), [1.0, 1.0, 1.0, 0.0]);
        assert_eq!(at(Wrap::Clamp, -1e300), [0.0, 0.0, 1.0, 1.0]);
    }

    #[test]
    fn levels_are_chosen_by_the_longer_step() {
        let bytes: Vec<u8> = (0..64).flat_map(|i| [i * 4, 0, 0, 255]).collect();
        let t = Texture::new(8, 8, bytes).unwrap();
        let step = |x: f64| Footprint::Steps(DVec2::new(x / 8.0, 0.0), DVec2::new(0.0, 0.25 / 8.0));
        assert_eq!([0.5, 1.0, 4.0].map(|x| step(x).level(8, 8)), [-1.0, 0.0, 2.0]);
        assert_eq!(Footprint::Horizon.level(8, 8), f64::INFINITY);
        assert_eq!(Footprint::Steps(DVec2::ZERO, DVec2::ZERO).level(8, 8), f64::NEG_INFINITY);
        let at = |filter, d: f64| sample(&t, with(filter, Wrap::Repeat), DVec2::splat(0.3), || d)[0];
        let on =
            |level| bilinear(&t, with(Filter::Bilinear, Wrap::Repeat), DVec2::splat(0.3), level)[0] / 255.0;
        assert_eq!(at(Filter::Mipmap, 1.49), on(1));
        assert_eq!(at(Filter::Mipmap, 1.5), on(2));
        assert_eq!(at(Filter::Trilinear, -3.0), on(0));
        assert!((at(Filter::Trilinear, 1.25) - (0.75 * on(1) + 0.25 * on(2))).abs() < 1e-15);
        for filter in [Filter::Mipmap, Filter::Trilinear] {
            for d in [3.0, 1e300, f64::INFINITY] {
                assert_eq!(at(filter, d), on(3), "{filter:?} {d}");
            }
        }
    }

    #[test]
    fn odd_and_narrow_textures_and_wild_coordinates_stay_inside() {
        for (w, h) in [(1, 1), (1, 7), (5, 1), (3, 5)] {
            let t = Texture::new(w, h, vec![9; (w * h * 4) as usize]).unwrap();
            for u in [0.0, -0.0, 1.0, -1e-20, 1e8, -1e8, 1e300, f64::NAN, f64::INFINITY] {
                for filter in Filter::ALL {
                    for wrap in Wrap::ALL {
                        let c = sample(&t, with(*filter, *wrap), DVec2::new(u, -u), || 1.3);
                        if u.is_finite() {
                            assert!(c.iter().all(|v| (v - 9.0 / 255.0).abs() < 1e-15), "{w}x{h} {u} {c:?}");
                        }
                    }
                }
            }
        }
    }
}

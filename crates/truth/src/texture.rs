//! Texture lookup by the rules of the specification, in f64, with the results on both sides of each
//! discontinuity.
//!
//! (0,0) is the lower left corner, texel centres are at .5, rows are stored from the top. Footprint
//! L is the longer of the two forward differences in texels, D = log2 L (source 003).

use fbptr_core::scene::{Filter, Sampling, Texture, Wrap};

/// Distance in texels from a texel's edge within which `nearest` may select either side.
pub const TEXEL_TURN: f64 = 1.0 / 256.0;
/// Distance from a level's edge within which `mipmap` may select either level.
pub const LEVEL_TURN: f64 = 1e-6;

/// R, G, B, A in 0..1.
pub type Texel = [f64; 4];

/// Mip levels of a texture in f64, without quantization.
#[derive(Clone, Debug)]
pub struct MipChain {
    levels: Vec<MipLevel>,
}

#[derive(Clone, Debug)]
struct MipLevel {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
}

/// Change of u and v from a pixel to its neighbours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum UvFootprint {
    /// Differences (du, dv) to (x+1, y) and to (x, y+1).
    Steps([[f64; 2]; 2]),
    /// One of the two neighbours lies beyond the horizon.
    AcrossHorizon,
}

impl MipChain {
    /// Computes all levels of a texture: texel i of level k+1 is the mean of texels 2i and 2i+1 of
    /// level k, in both directions.
    pub fn new(texture: &Texture) -> MipChain {
        let (width, height) = (texture.width() as usize, texture.height() as usize);
        let texels =
            texture.bytes().chunks_exact(4).map(|t| std::array::from_fn(|c| t[c] as f64 / 255.0)).collect();
        let mut levels = vec![MipLevel { width, height, texels }];
        loop {
            let last = &levels[levels.len() - 1];
            if last.width == 1 && last.height == 1 {
                return MipChain { levels };
            }
            let (width, height) = ((last.width / 2).max(1), (last.height / 2).max(1));
            let mut texels = Vec::with_capacity(width * height);
            for y in 0..height {
                for x in 0..width {
                    let (x1, y1) = ((2 * x + 1).min(last.width - 1), (2 * y + 1).min(last.height - 1));
                    let four = [(2 * x, 2 * y), (x1, 2 * y), (2 * x, y1), (x1, y1)];
                    let four = four.map(|(x, y)| last.texels[last.width * y + x]);
                    texels.push(std::array::from_fn(|c| four.iter().map(|t| t[c]).sum::<f64>() / 4.0));
                }
            }
            levels.push(MipLevel { width, height, texels });
        }
    }

    /// Returns the accepted results of a lookup at (u, v).
    pub fn sample(&self, sampling: Sampling, uv: [f64; 2], footprint: UvFootprint) -> Vec<Texel> {
        match sampling.filter {
            Filter::Nearest => self.levels[0].nearest(sampling, uv),
            Filter::Bilinear => vec![self.levels[0].bilinear(sampling, uv)],
            Filter::Mipmap => {
                let d = self.level_of(footprint);
                let mut at: Vec<f64> =
                    [d - LEVEL_TURN, d + LEVEL_TURN].iter().map(|d| (d + 0.5).floor()).collect();
                at.dedup();
                at.into_iter().map(|k| self.clamped(k).bilinear(sampling, uv)).collect()
            }
            Filter::Trilinear => {
                let d = self.level_of(footprint).max(0.0);
                let (near, far) = (self.clamped(d.floor()), self.clamped(d.floor() + 1.0));
                let (a, b) = (near.bilinear(sampling, uv), far.bilinear(sampling, uv));
                let t = if d.is_finite() { d - d.floor() } else { 0.0 };
                vec![std::array::from_fn(|c| a[c] * (1.0 - t) + b[c] * t)]
            }
        }
    }

    /// Returns D = log2 of the longer footprint in texels of level 0.
    pub fn level_of(&self, footprint: UvFootprint) -> f64 {
        let UvFootprint::Steps(steps) = footprint else { return f64::INFINITY };
        let (w, h) = (self.levels[0].width as f64, self.levels[0].height as f64);
        let length = |[du, dv]: [f64; 2]| ((du * w) * (du * w) + (dv * h) * (dv * h)).sqrt();
        libm::log2(length(steps[0]).max(length(steps[1])))
    }

    /// Returns the existing level nearest to number `k`.
    fn clamped(&self, k: f64) -> &MipLevel {
        &self.levels[k.clamp(0.0, (self.levels.len() - 1) as f64) as usize]
    }
}

/// Returns the texel index for coordinate `i` in texels from the left or bottom.
fn wrap(i: f64, size: usize, rule: Wrap) -> usize {
    let last = (size - 1) as f64;
    match rule {
        Wrap::Clamp => i.clamp(0.0, last) as usize,
        Wrap::Repeat => (i.rem_euclid(size as f64)).min(last) as usize,
    }
}

impl MipLevel {
    /// Returns texel (i, j), counted from the lower left.
    fn texel(&self, i: f64, j: f64, rules: Sampling) -> Texel {
        let x = wrap(i, self.width, rules.wrap_s);
        let row = self.height - 1 - wrap(j, self.height, rules.wrap_t);
        self.texels[self.width * row + x]
    }

    fn nearest(&self, rules: Sampling, [u, v]: [f64; 2]) -> Vec<Texel> {
        let both = |x: f64| {
            let (a, b) = ((x - TEXEL_TURN).floor(), (x + TEXEL_TURN).floor());
            if a == b { vec![a] } else { vec![a, b] }
        };
        let (columns, rows) = (both(u * self.width as f64), both(v * self.height as f64));
        let mut found: Vec<Texel> =
            columns.iter().flat_map(|&i| rows.iter().map(move |&j| self.texel(i, j, rules))).collect();
        found.dedup();
        found
    }

    fn bilinear(&self, rules: Sampling, [u, v]: [f64; 2]) -> Texel {
        let (s, t) = (u * self.width as f64 - 0.5, v * self.height as f64 - 0.5);
        let (i, j) = (s.floor(), t.floor());
        let (a, b) = (s - i, t - j);
        let [p, q, r, w] =
            [(i, j), (i + 1.0, j), (i, j + 1.0), (i + 1.0, j + 1.0)].map(|(i, j)| self.texel(i, j, rules));
        std::array::from_fn(|c| (p[c] * (1.0 - a) + q[c] * a) * (1.0 - b) + (r[c] * (1.0 - a) + w[c] * a) * b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 x 2 texels: red above blue on the left, green above white on the right.
    fn quarters() -> MipChain {
        let bytes = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255], [255, 255, 255, 255]].concat();
        MipChain::new(&Texture::new(2, 2, bytes).unwrap())
    }

    const STILL: UvFootprint = UvFootprint::Steps([[0.0; 2]; 2]);

    #[test]
    fn the_origin_is_the_lower_left_corner() {
        let rules = Sampling { filter: Filter::Nearest, ..Sampling::default() };
        assert_eq!(quarters().sample(rules, [0.25, 0.25], STILL), [[0.0, 0.0, 1.0, 1.0]]);
        assert_eq!(quarters().sample(rules, [0.75, 0.75], STILL), [[0.0, 1.0, 0.0, 1.0]]);
        // Near the edge between two texels both are accepted, with repetition on the left.
        assert_eq!(quarters().sample(rules, [1e-4, 0.25], STILL).len(), 2);
        assert_eq!(quarters().sample(rules, [-10.75, 7.25], STILL), [[0.0, 0.0, 1.0, 1.0]]);
    }

    #[test]
    fn bilinear_meets_the_texel_at_its_centre_and_the_mean_between() {
        let rules = Sampling::default();
        assert_eq!(quarters().sample(rules, [0.25, 0.75], STILL), [[1.0, 0.0, 0.0, 1.0]]);
        assert_eq!(quarters().sample(rules, [0.5, 0.5], STILL), [[0.5, 0.5, 0.5, 1.0]]);
        let clamp = Sampling { wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp, ..rules };
        assert_eq!(quarters().sample(clamp, [-5.0, 9.0], STILL), [[1.0, 0.0, 0.0, 1.0]]);
    }

    #[test]
    fn levels_follow_the_footprint() {
        let p = quarters();
        assert_eq!(p.level_of(UvFootprint::Steps([[1.0, 0.0], [0.0, 0.5]])), 1.0);
        let mip = Sampling { filter: Filter::Mipmap, ..Sampling::default() };
        assert_eq!(p.sample(mip, [0.1, 0.1], UvFootprint::AcrossHorizon), [[0.5, 0.5, 0.5, 1.0]]);
        // D = 0.5 exactly: level 0 or 1.
        let turn = UvFootprint::Steps([[2f64.sqrt() / 2.0, 0.0], [0.0, 0.0]]);
        assert_eq!(p.sample(mip, [0.25, 0.25], turn).len(), 2);
        let tri = Sampling { filter: Filter::Trilinear, ..Sampling::default() };
        let mixed = p.sample(tri, [0.25, 0.75], turn)[0];
        assert!((mixed[0] - 0.75).abs() < 1e-12 && (mixed[1] - 0.25).abs() < 1e-12);
        assert_eq!(p.sample(tri, [0.25, 0.75], STILL), [[1.0, 0.0, 0.0, 1.0]]);
    }
}

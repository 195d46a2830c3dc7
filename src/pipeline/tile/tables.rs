//! Colours found before any pixel is: at every vertex (Gouraud) or once a face (flat), a vector of points at a time.

use super::light::{Lighting, light, scale};
use super::shading::Eye;
use crate::simd::{F32, Kernel, Mask, Simd};

/// Lights one point in f64, where f32 lacks the digits: its number; matte and gloss.
pub type ExactPoint<'a> = &'a (dyn Fn(usize) -> [[f32; 3]; 2] + Sync);

/// Lights a run of points.
pub struct TableKernel<'a> {
    /// The material and its lights.
    pub lighting: &'a Lighting,
    /// The eye.
    pub eye: Eye,
    /// Rows that take object space to the shading frame.
    pub to_frame: [[f64; 4]; 3],
    /// Object-space x, y, z of the points.
    pub positions: [&'a [f64]; 3],
    /// Their unit normals in the shading frame.
    pub normals: &'a [[f32; 4]],
    /// What multiplies the matte part; empty for nothing.
    pub colors: &'a [[f32; 4]],
    /// The number of the first point.
    pub first: usize,
    /// For points that f32 does not carry.
    pub exact: ExactPoint<'a>,
    /// The matte part, or with an empty `gloss` all of it.
    pub matte: &'a mut [[f32; 4]],
    /// What a texture does not multiply.
    pub gloss: &'a mut [[f32; 4]],
}

#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
impl Kernel for TableKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let count = self.matte.len();
        let mut at = [[0f32; 16]; 3];
        // Whole vectors of points, whatever is left over in the last one.
        let mut points = [[0f64; 16]; 3];
        let mut out = [[0f32; 16]; 6];
        // Where nothing multiplies the one part only, both are one.
        let is_sum = self.colors.is_empty() && self.gloss.is_empty();
        let (zero, one) = (s.splat(0.0), s.splat(1.0));
        for start in (0..count).step_by(S::LANES) {
            let n = (count - start).min(S::LANES);
            for k in 0..3 {
                points[k][..n].copy_from_slice(&self.positions[k][start..start + n]);
            }
            for (row, lanes) in self.to_frame.iter().zip(&mut at) {
                for i in 0..S::LANES {
                    let (x, y, z) = (points[0][i], points[1][i], points[2][i]);
                    lanes[i] = (((row[0] * x + row[1] * y) + row[2] * z) + row[3]) as f32;
                }
            }
            let live = s.mask(u32::MAX >> (32 - n));
            let position = [s.load(&at[0]), s.load(&at[1]), s.load(&at[2])];
            let index = s.iota() + s.splat_i(start as i32);
            let [nx, ny, nz, _] = s.gather4(live, self.normals, s.select_i(live, index, s.splat_i(0)));
            let to_viewer = match self.eye {
                Eye::Perspective { .. } => {
                    let d2 = super::light::dot::<S>(position, position);
                    scale::<S>(position, zero - s.select(zero.lt(d2), one / d2.sqrt(), zero))
                }
                Eye::Parallel { to_viewer } => super::light::splat3(s, to_viewer),
            };
            let lit = light(s, self.lighting, position, [nx, ny, nz], to_viewer);
            let delicate = (lit.delicate & live).bits();
            if is_sum && delicate == 0 {
                for k in 0..3 {
                    s.store(lit.matte[k] + lit.gloss[k], &mut out[k]);
                }
                for (i, to) in self.matte[start..start + n].iter_mut().enumerate() {
                    *to = [out[0][i], out[1][i], out[2][i], 0.0];
                }
                continue;
            }
            for k in 0..3 {
                s.store(lit.matte[k], &mut out[k]);
                s.store(lit.gloss[k], &mut out[k + 3]);
            }
            for i in 0..n {
                let mut matte = [out[0][i], out[1][i], out[2][i]];
                let mut gloss = [out[3][i], out[4][i], out[5][i]];
                if delicate >> i & 1 != 0 {
                    [matte, gloss] = (self.exact)(self.first + start + i);
                }
                if let Some(color) = self.colors.get(start + i) {
                    matte = [0, 1, 2].map(|c| matte[c] * color[c]);
                }
                match self.gloss.get_mut(start + i) {
                    Some(to) => *to = [gloss[0], gloss[1], gloss[2], 0.0],
                    None => matte = [0, 1, 2].map(|c| matte[c] + gloss[c]),
                }
                self.matte[start + i] = [matte[0], matte[1], matte[2], 0.0];
            }
        }
    }
}

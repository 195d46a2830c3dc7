//! Lighting ahead of the pixels: at every vertex (Gouraud) or once for each face (flat), a vector
//! of points at a time.

use super::lighting::{MaterialLighting, light, scale};
use super::shading_state::Eye;
use crate::simd::{F32, Kernel, Mask, Simd};

/// Lights one point in f64, where f32 lacks the digits. Argument: its index; result: diffuse and
/// specular.
pub type ExactPoint<'a> = &'a (dyn Fn(usize) -> [[f32; 3]; 2] + Sync);

/// Lights a run of points.
pub struct VertexLightingKernel<'a> {
    /// Material and lights.
    pub lighting: &'a MaterialLighting,
    /// Position of the viewer.
    pub eye: Eye,
    /// Rows that take object space to shading space.
    pub to_frame: [[f64; 4]; 3],
    /// Object-space x, y and z of the points.
    pub positions: [&'a [f64]; 3],
    /// Unit normals of the points in shading space.
    pub normals: &'a [[f32; 4]],
    /// Colours that multiply the diffuse part; empty for none.
    pub colors: &'a [[f32; 4]],
    /// Index of the first point.
    pub first: usize,
    /// Lights points that f32 does not carry.
    pub exact: ExactPoint<'a>,
    /// Output: the diffuse part, or with an empty `specular` the sum of both.
    pub diffuse: &'a mut [[f32; 4]],
    /// Output: the part that a texture does not multiply.
    pub specular: &'a mut [[f32; 4]],
}

#[allow(clippy::needless_range_loop, reason = "lanes of several arrays go together")]
impl Kernel for VertexLightingKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let count = self.diffuse.len();
        let mut at = [[0f32; 16]; 3];
        // Whole vectors of points; unused lanes of the last one hold leftovers.
        let mut points = [[0f64; 16]; 3];
        let mut out = [[0f32; 16]; 6];
        // If nothing multiplies only one of the parts, they are stored as a sum.
        let is_sum = self.colors.is_empty() && self.specular.is_empty();
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
                Eye::Perspective { .. } | Eye::Interpolated => {
                    let d2 = super::lighting::dot::<S>(position, position);
                    scale::<S>(position, zero - s.select(zero.lt(d2), one / d2.sqrt(), zero))
                }
                Eye::Parallel { to_viewer } => super::lighting::splat3(s, to_viewer),
            };
            let lit = light(s, self.lighting, position, [nx, ny, nz], to_viewer);
            let needs_f64 = (lit.needs_f64 & live).bits();
            if is_sum && needs_f64 == 0 {
                for k in 0..3 {
                    s.store(lit.diffuse[k] + lit.specular[k], &mut out[k]);
                }
                for (i, to) in self.diffuse[start..start + n].iter_mut().enumerate() {
                    *to = [out[0][i], out[1][i], out[2][i], 0.0];
                }
                continue;
            }
            for k in 0..3 {
                s.store(lit.diffuse[k], &mut out[k]);
                s.store(lit.specular[k], &mut out[k + 3]);
            }
            for i in 0..n {
                let mut diffuse = [out[0][i], out[1][i], out[2][i]];
                let mut specular = [out[3][i], out[4][i], out[5][i]];
                if needs_f64 >> i & 1 != 0 {
                    [diffuse, specular] = (self.exact)(self.first + start + i);
                }
                if let Some(color) = self.colors.get(start + i) {
                    diffuse = [0, 1, 2].map(|c| diffuse[c] * color[c]);
                }
                match self.specular.get_mut(start + i) {
                    Some(to) => *to = [specular[0], specular[1], specular[2], 0.0],
                    None => diffuse = [0, 1, 2].map(|c| diffuse[c] + specular[c]),
                }
                self.diffuse[start + i] = [diffuse[0], diffuse[1], diffuse[2], 0.0];
            }
        }
    }
}

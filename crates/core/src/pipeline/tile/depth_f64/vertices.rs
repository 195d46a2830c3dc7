//! Vertex stage that retains depth in f64, in the steps of the plain path.

use crate::pipeline::tile::vertex::{ToScreen, WIDTH, affine, is_marked};
use crate::simd::{Kernel, Simd};
use std::sync::atomic::AtomicU8;

/// Vertex with column and row in pixels, and its depth in the format's sense (z or 1 - z); the last
/// number is 0.
pub type DepthVertex = [f64; 4];

/// Transforms a run of vertices.
pub struct DepthVertexKernel<'a> {
    /// Object-space x, y and z of the vertices.
    pub positions: [&'a [f64]; 3],
    /// Matrices of the draw.
    pub to_screen: &'a ToScreen,
    /// Row that takes view space to z of clip space, or to w - z.
    pub row: [f64; 4],
    /// Blocks of vertices that are used, as in
    /// [`VertexKernel`](crate::pipeline::tile::vertex::VertexKernel).
    pub marks: &'a [AtomicU8],
    /// Output: one for each position; NaN for points without a position on the screen.
    pub out: &'a mut [DepthVertex],
}

impl Kernel for DepthVertexKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let count = self.out.len();
        let mut start = 0;
        while start < count {
            let n = (count - start).min(WIDTH);
            if !is_marked(self.marks, start / WIDTH) {
                start += WIDTH;
                continue;
            }
            let mut p = [[0.0; WIDTH]; 3];
            for (lanes, from) in p.iter_mut().zip(self.positions) {
                lanes[..n].copy_from_slice(&from[start..start + n]);
            }
            let vertices = depth_vertices(self.to_screen, self.row, &p);
            self.out[start..start + n].copy_from_slice(&vertices[..n]);
            start += WIDTH;
        }
    }
}

#[inline(always)]
fn depth_vertices(t: &ToScreen, row: [f64; 4], p: &[[f64; WIDTH]; 3]) -> [DepthVertex; WIDTH] {
    let p = [&p[0], &p[1], &p[2]];
    let view = t.steps_to_view(p);
    let view = [&view[0], &view[1], &view[2]];
    let [p0, p1, _, p3] = t.projection;
    let (x, y, d, w) = (affine(p0, view), affine(p1, view), affine(row, view), affine(p3, view));
    let mut out = [[0.0; 4]; WIDTH];
    for i in 0..WIDTH {
        out[i] =
            [t.center[0] + x[i] / w[i] * t.half[0], t.center[1] + y[i] / w[i] * t.half[1], d[i] / w[i], 0.0];
    }
    out
}

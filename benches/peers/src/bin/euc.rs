//! W1 to W5 on euc 0.5.3, one thread. It has a nearest sampler only: W4 is `nearest`, by a fragment
//! shader of this file.

use euc::buffer::Buffer2d;
use euc::{Interpolate, Pipeline, Target, rasterizer};
use fbptr_peers::*;

const PEER: &str = "euc";

/// Values interpolated across a face.
#[derive(Clone, Copy)]
struct Varying<const N: usize>([f32; N]);

impl<const N: usize> Interpolate for Varying<N> {
    #[inline(always)]
    fn lerp2(a: Self, b: Self, x: f32, y: f32) -> Self {
        Varying(std::array::from_fn(|i| a.0[i] * x + b.0[i] * y))
    }
    #[inline(always)]
    fn lerp3(a: Self, b: Self, c: Self, x: f32, y: f32, z: f32) -> Self {
        Varying(std::array::from_fn(|i| a.0[i] * x + b.0[i] * y + c.0[i] * z))
    }
}

struct Spaces {
    model: Matrix,
    to_clip: Matrix,
}

impl Spaces {
    #[inline(always)]
    fn world(&self, v: &Vertex) -> ([f32; 3], [f32; 3]) {
        let [px, py, pz, _] = apply(&self.model, v.position, 1.0);
        let [nx, ny, nz, _] = apply(&self.model, v.normal, 0.0);
        ([px, py, pz], [nx, ny, nz])
    }
}

struct Phong(Spaces);

impl Pipeline for Phong {
    type Vertex = Vertex;
    type VsOut = Varying<6>;
    type Pixel = u32;

    #[inline(always)]
    fn vert(&self, v: &Vertex) -> ([f32; 4], Varying<6>) {
        let (p, n) = self.0.world(v);
        (apply(&self.0.to_clip, v.position, 1.0), Varying([p[0], p[1], p[2], n[0], n[1], n[2]]))
    }
    #[inline(always)]
    fn frag(&self, Varying([px, py, pz, nx, ny, nz]): &Varying<6>) -> u32 {
        word(lit([*px, *py, *pz], [*nx, *ny, *nz]))
    }
}

struct Gouraud(Spaces);

impl Pipeline for Gouraud {
    type Vertex = Vertex;
    type VsOut = Varying<3>;
    type Pixel = u32;

    #[inline(always)]
    fn vert(&self, v: &Vertex) -> ([f32; 4], Varying<3>) {
        let (p, n) = self.0.world(v);
        (apply(&self.0.to_clip, v.position, 1.0), Varying(lit(p, n)))
    }
    #[inline(always)]
    fn frag(&self, color: &Varying<3>) -> u32 {
        word(color.0)
    }
}

struct Textured<'a>(Spaces, &'a [u32]);

impl Pipeline for Textured<'_> {
    type Vertex = Vertex;
    type VsOut = Varying<2>;
    type Pixel = u32;

    #[inline(always)]
    fn vert(&self, v: &Vertex) -> ([f32; 4], Varying<2>) {
        (apply(&self.0.to_clip, v.position, 1.0), Varying(v.uv))
    }
    #[inline(always)]
    fn frag(&self, Varying(uv): &Varying<2>) -> u32 {
        let [x, y] = uv.map(|c| (c * 1024.0).floor() as i32 as usize & 1023);
        self.1[y * 1024 + x]
    }
}

struct Layers;

impl Pipeline for Layers {
    type Vertex = ([f32; 3], [f32; 3]);
    type VsOut = Varying<3>;
    type Pixel = u32;

    #[inline(always)]
    fn vert(&self, &([x, y, z], color): &Self::Vertex) -> ([f32; 4], Varying<3>) {
        ([x, y, z, 1.0], Varying(color))
    }
    #[inline(always)]
    fn frag(&self, color: &Varying<3>) -> u32 {
        word(color.0)
    }
}

fn run<P: Pipeline<Pixel = u32>>(workload: &str, pipeline: &P, vertices: &[P::Vertex]) {
    let mut color = Buffer2d::new([WIDTH, HEIGHT], BACKGROUND);
    let mut depth = Buffer2d::new([WIDTH, HEIGHT], 1.0f32);
    measure(PEER, workload, || {
        color.clear(BACKGROUND);
        depth.clear(1.0);
        pipeline.draw::<rasterizer::Triangles<_, rasterizer::BackfaceCullingEnabled>, _>(
            vertices,
            &mut color,
            Some(&mut depth),
        );
    });
    save_picture(PEER, workload, color.as_ref());
}

fn main() {
    let spaces = || Spaces { model: model(), to_clip: product(&camera(), &model()) };
    let knot = triangles("knot70k.bin");
    if is_wanted("W1") {
        run("W1_phong70k", &Phong(spaces()), &knot);
    }
    if is_wanted("W2") {
        run("W2_phong1M", &Phong(spaces()), &triangles("knot1m.bin"));
    }
    if is_wanted("W3") {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let quad = |i| {
            let (color, z) = layer(i);
            corners.map(|[x, y]| ([x, y, z], color))
        };
        run("W3_fill20", &Layers, &(0..LAYERS).flat_map(quad).collect::<Vec<_>>());
    }
    if is_wanted("W4") {
        run("W4_tex_nearest", &Textured(spaces(), &texture()), &knot);
    }
    if is_wanted("W5") {
        run("W5_gouraud70k", &Gouraud(spaces()), &knot);
    }
}

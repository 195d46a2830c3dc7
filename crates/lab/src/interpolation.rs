//! Interpolation of texture coordinates across a wall in perspective.

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture::{drawn_in_turns, truth_pixels};
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Cull, Filter, Interpolation, LightingModel, LookAt, Material, Mesh, NONE, Projection,
    Sampling, Scene, Texture, Wrap,
};
use fbptr_truth::Settings;
use fbptr_truth::scenes::{Case, object};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Experiment on interpolation.
pub(super) const INTERPOLATION: Experiment = Experiment {
    id: "interpolation",
    title: "Interpolation",
    about: "A wall whose distance grows from 1 to the given factor across the frame, with a texture of 16,384 texels in a row, \
            each of a colour that tells its number: a pixel's bytes tell which texel the wall has there. Error: the distance of \
            the true u from that texel's, in 256ths of the wall; none within it. The other ways compute u in a loop of their \
            own, without drawing.",
    truth: Truth {
        is: "u of the ray through the pixel's centre and the wall, a ratio of whole numbers",
        digits: "15, after one division",
        second_way: "homogeneous coordinates of 32 digits; pixels whose texel does not hold that u",
    },
    check,
    columns: &["largest error, texels", "RMSE, texels"],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// Wall on a frame `width` pixels wide, as far as 1 at the left end.
#[derive(Clone, Copy)]
struct Wall {
    width: usize,
    height: usize,
    /// Distance at the right end.
    far: f64,
}

/// Units of u along the wall.
const TEXELS: f64 = 256.0;
/// Texels of the texture along the wall.
const FINE: u32 = 16_384;
/// Fine texels of a unit of u.
const PARTS: f64 = FINE as f64 / TEXELS;

impl Wall {
    /// Returns u at the centre of column `x`: with n = 2x + 1 and W the width, n / (2 W far - n (far
    /// - 1)) of the wall's length.
    fn u(self, x: usize) -> f64 {
        let (n, width) = ((2 * x + 1) as f64, self.width as f64);
        TEXELS * n / (2.0 * width * self.far - n * (self.far - 1.0))
    }

    /// Returns 1/w and u/w at `t` in 0..1 across the frame.
    fn over_w(self, t: f64) -> (f64, f64) {
        let (near, far) = (1.0, 1.0 / self.far);
        (near * (1.0 - t) + far * t, TEXELS * far * t)
    }

    /// Returns 0..1 of column `x`'s centre across the frame.
    fn t(self, x: usize) -> f64 {
        (x as f64 + 0.5) / self.width as f64
    }

    /// Returns the wall as a case. The eye looks along -z with an angle of 90 degrees.
    fn case(self, interpolation: Interpolation) -> Case {
        let aspect = self.width as f64 / self.height as f64;
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let far = self.far;
        let positions = vec![
            corner(-aspect, -far, -1.0),
            corner(aspect * far, -far, -far),
            corner(aspect * far, far, -far),
            corner(-aspect, far, -1.0),
        ];
        let texcoords = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from_array).to_vec();
        let mut mesh = Mesh { positions, texcoords, ..Mesh::default() };
        let corner = |k| Corner { position: k, normal: NONE, texcoord: k, color: NONE };
        mesh.push_polygon(&[0, 1, 2, 3].map(corner), NONE);
        let mut wall = object("wall", mesh);
        wall.cull = Cull::None;
        wall.material = Material {
            emissive: DVec3::ONE,
            kd: DVec3::ZERO,
            model: LightingModel::Unlit,
            ..Material::default()
        };
        let sampling = Sampling { filter: Filter::Nearest, wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp };
        wall.texture = Some((numbers(), sampling));
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let fov_rad = std::f64::consts::FRAC_PI_2;
        let projection = Projection::Perspective { fov_rad, near: 0.5, far: 100.0, on_smaller_side: false };
        Case {
            name: "wall".into(),
            scene: Scene {
                camera: Some(Camera { look_at, projection }),
                objects: vec![wall],
                ..Scene::default()
            },
            settings: Settings { interpolation, ..Settings::default() },
            format: DepthFormat::F32,
            width: self.width as u32,
            height: self.height as u32,
        }
    }
}

/// Returns a row of texels whose red and green are the two bytes of their number.
fn numbers() -> Arc<Texture> {
    let bytes = (0..FINE).flat_map(|k| [k as u8, (k >> 8) as u8, 0, 255]).collect();
    Arc::new(Texture::new(FINE, 1, bytes).expect("16,384 x 1 texels"))
}

/// Returns the texel's number that bytes tell.
fn number_of(pixel: &[u8]) -> u32 {
    u32::from(pixel[0]) | u32::from(pixel[1]) << 8
}

type Fill = fn(Wall, &mut [f64]);

/// Interpolates with f32 increments along the row.
fn increments_f32(wall: Wall, row: &mut [f64]) {
    let at = |x: usize| {
        let (w, uw) = wall.over_w(wall.t(x));
        (w as f32, uw as f32)
    };
    let (mut now, next) = (at(0), at(1));
    let step = (next.0 - now.0, next.1 - now.1);
    for u in row.iter_mut() {
        *u = (now.1 / now.0) as f64;
        now = (now.0 + step.0, now.1 + step.1);
    }
}

/// Divides every N pixels, with linear interpolation between.
fn every<const N: usize>(wall: Wall, row: &mut [f64]) {
    let at = |x: usize| {
        let (w, uw) = wall.over_w(wall.t(x));
        uw / w
    };
    for (k, run) in row.chunks_mut(N).enumerate() {
        let (a, b) = (at(k * N), at(k * N + run.len()));
        let step = (b - a) / run.len() as f64;
        for (i, u) in run.iter_mut().enumerate() {
            *u = a + step * i as f64;
        }
    }
}

/// Returns the largest and the RMS distance of the true u from the texels, row by row.
fn errors_of(wall: Wall, texels: &[u32]) -> Vec<f64> {
    let (mut max, mut squares) = (0f64, 0f64);
    for row in texels.chunks(wall.width) {
        for (x, &k) in row.iter().enumerate() {
            let u = wall.u(x) * PARTS;
            let off = (f64::from(k) - u).max(u - f64::from(k + 1)).max(0.0) / PARTS;
            max = max.max(off);
            squares += off * off;
        }
    }
    vec![max, (squares / texels.len() as f64).sqrt()]
}

/// Shows a texel in the middle that is just beyond the bound.
fn mutate(wall: Wall, texels: &mut [u32], bound: &Bound) {
    let x = wall.width / 2;
    let (u, off) = (wall.u(x) * PARTS, bound.at_most * PARTS);
    let [above, below] = [(u + off).floor() + 1.0, (u - off).ceil() - 2.0];
    texels[x] = if above < f64::from(FINE) || below < 0.0 { above as u32 } else { below as u32 };
}

/// Counts the columns whose u lies in no texel that the reference of 32 digits accepts.
fn check(effort: &Effort) -> Check {
    let (width, height) = size(effort);
    let mut others = 0;
    for far in FARS {
        let wall = Wall { width, height, far };
        let row: Vec<[u32; 2]> = (0..width as u32).map(|x| [x, height as u32 / 2]).collect();
        let exact = truth_pixels(&wall.case(Interpolation::Perspective), &row);
        others += row
            .iter()
            .filter(|[x, y]| {
                let texel = (wall.u(*x as usize) * PARTS) as u32;
                !exact.states(*x, *y).iter().any(|s| number_of(&s.lo) == texel)
            })
            .count();
    }
    Check { difference: others as f64, at_most: 0.0 }
}

const FARS: [f64; 3] = [2.0, 8.0, 64.0];

fn size(effort: &Effort) -> (usize, usize) {
    effort.pick((256, 64), (1920, 256))
}

fn rows(effort: &Effort) -> Vec<Row> {
    let mut rows = Vec::new();
    for far in FARS {
        let (width, height) = size(effort);
        let wall = Wall { width, height, far };
        let pixels = (width * height) as f64;
        let subject = format!("distance 1 to {far}");
        let judged = |name: &str, standing, texels: &Vec<u32>, bound: Bound| {
            let mutate = |texels: &mut Vec<u32>, bound: &Bound| mutate(wall, texels, bound);
            let judge = |texels: &Vec<u32>| errors_of(wall, texels);
            Row::judged(effort, (&subject, name, standing), texels, vec![bound], judge, mutate)
        };
        let modes = modes(far);
        let cases = modes.map(|(mode, ..)| wall.case(mode));
        let drawn = drawn_in_turns(effort, &cases);
        for ((mode, standing, bound), (bytes, timing)) in modes.into_iter().zip(drawn) {
            let texels: Vec<u32> = bytes.chunks_exact(4).map(number_of).collect();
            rows.push(judged(mode.as_str(), standing, &texels, bound).timed(timing, pixels));
        }
        let work = |(_, fill, _): (&str, Fill, Bound)| -> Work<Vec<f64>> {
            Box::new(move || {
                let mut u = vec![0.0; width * height];
                u.chunks_mut(width).for_each(|row| fill(std::hint::black_box(wall), row));
                u
            })
        };
        let others = others(wall);
        let found = effort.run_in_turns(others.map(work).into());
        for ((name, _, bound), (u, timing)) in others.into_iter().zip(found) {
            let texel = |u: &f64| (u * PARTS).clamp(0.0, f64::from(FINE - 1)) as u32;
            let texels: Vec<u32> = u.iter().map(texel).collect();
            rows.push(judged(name, Standing::Comparison, &texels, bound).timed(timing, pixels));
        }
    }
    rows
}

/// Returns the modes of the renderer, each with its bound.
fn modes(far: f64) -> [(Interpolation, Standing, Bound); 2] {
    let root = far.sqrt();
    let affine = TEXELS * (root - 1.0) / (root + 1.0) + 1.0 / PARTS;
    [
        (
            Interpolation::Perspective,
            Standing::Default,
            Bound {
                column: 0,
                at_most: 1.0 / 256.0 / PARTS,
                because: "perspective: a texel's edge may be 1/256 texel off, by the specification",
            },
        ),
        (
            Interpolation::Affine,
            Standing::Mode,
            Bound {
                column: 0,
                at_most: affine,
                because: "affine: T (t - t / (f - t (f - 1))) is largest at t = (f - sqrt f) / (f - 1): T (sqrt f - 1) / \
                          (sqrt f + 1); and a texel",
            },
        ),
    ]
}

/// Returns the other ways, each with its bound.
fn others(wall: Wall) -> [(&'static str, Fill, Bound); 3] {
    let (width, far) = (wall.width as f64, wall.far);
    let bent = |n: f64| {
        let h = n / width;
        Bound {
            column: 0,
            at_most: h * h / 8.0 * 2.0 * TEXELS * far * (far - 1.0),
            because: "pieces of length h in t: h^2/8 max |u''|, u'' = 2 T f (f - 1) at the far end",
        }
    };
    let drift = Bound {
        column: 0,
        at_most: width * TEXELS * far / 16_777_216.0,
        because: "f32 increments: half an ulp a step, times f at the far end: W T f 2^-24",
    };
    [
        ("f32 increments", increments_f32, drift),
        ("divided every 8 pixels", every::<8>, bent(8.0)),
        ("divided every 16 pixels", every::<16>, bent(16.0)),
    ]
}

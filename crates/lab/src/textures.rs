//! Texture filters, compared with their definitions and with an ideal box filter of the screen.

use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Cull, Filter, LightingModel, LookAt, Material, Projection, Sampling, Scene, Texture, Wrap,
};
use fbptr_truth::Settings;
use fbptr_truth::compare::nearest_bytes;
use fbptr_truth::metrics::compare_bytes;
use fbptr_truth::scenes::{Case, object, terrain};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Experiment on texture filters.
pub(super) const TEXTURES: Experiment = Experiment {
    id: "textures",
    title: "Textures",
    about: "A textured floor to the horizon and a card before the eye. Each filter is held to its own definition; the other \
            columns compare it with an ideal box filter of the screen, of which nothing is promised.",
    truth: Truth {
        is: "each filter's formula; the box filter as the mean of 64 x 64 rays a pixel, cut with the plane, of the nearest texel",
        digits: "32, the box filter 15",
        second_way: "the box filter of 32 x 32 rays: RMS difference in 1/255, which halves with each doubling, so less is left beyond 64 x 64",
    },
    check,
    columns: &[
        "largest error against its definition, 1/255",
        "RMSE against the box filter, 1/255",
        "PSNR, dB",
        "SSIM",
    ],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// Rays per pixel of the box filter in each direction.
const RAYS: u32 = 64;

/// Place of the eye, on a line to the origin.
const EYE: DVec3 = DVec3::new(0.3, 0.0, 4.0);
/// Angle of the picture's height.
const FOV_RAD: f64 = 0.8;

/// Returns a texture of bricks of two colours with a little noise.
pub(super) fn bricks() -> Arc<Texture> {
    let bytes = (0..64 * 64u32).flat_map(|i| {
        let (x, y) = (i % 64, i / 64);
        let joint = y % 16 == 0 || (x + y / 16 % 2 * 16) % 32 == 0;
        let noise = (i.wrapping_mul(2_654_435_761) >> 27) as u8;
        if joint { [200, 200, 190, 255] } else { [150 + noise, 60 + noise, 40, 255] }
    });
    Arc::new(Texture::new(64, 64, bytes.collect()).expect("64 x 64 texels"))
}

fn floor() -> fbptr_core::scene::Mesh {
    let mut mesh = terrain(1, 24.0, || 0.0);
    mesh.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 12.0, -1.0, p.z * 12.0 - 8.0));
    mesh
}

fn card() -> fbptr_core::scene::Mesh {
    let mut mesh = terrain(1, 1.0, || 0.0);
    mesh.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 1.7, -p.z * 1.2, 0.0));
    mesh.texcoords.iter_mut().for_each(|t| *t = DVec2::new(t.x * 0.4, t.y * 0.3));
    mesh
}

fn case(mesh: fbptr_core::scene::Mesh, filter: Filter, width: u32, height: u32) -> Case {
    let mut o = object("surface", mesh);
    o.cull = Cull::None;
    o.material = Material { emissive: DVec3::ONE, model: LightingModel::Unlit, ..Material::default() };
    o.texture = Some((bricks(), Sampling { filter, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat }));
    let look_at = LookAt { eye: EYE, reference: DVec3::ZERO, up: DVec3::Y };
    let projection =
        Projection::Perspective { fov_rad: FOV_RAD, near: 0.1, far: 100.0, on_smaller_side: false };
    Case {
        name: "textures".into(),
        scene: Scene { camera: Some(Camera { look_at, projection }), objects: vec![o], ..Scene::default() },
        settings: Settings::default(),
        format: DepthFormat::F32,
        width,
        height,
    }
}

/// Textured rectangle: its mesh for the renderer, and the plane by itself for the truth.
struct Surface {
    name: &'static str,
    mesh: fn() -> fbptr_core::scene::Mesh,
    /// Returns u and v of the point where a ray from the eye meets the rectangle.
    uv: fn(DVec3) -> Option<[f64; 2]>,
}

const SURFACES: [Surface; 2] = [
    Surface { name: "floor to the horizon", mesh: floor, uv: uv_of_floor },
    Surface { name: "card before the eye", mesh: card, uv: uv_of_card },
];

/// Returns the repeats over -1..1 of both axes, if both are within.
fn repeats(p: [f64; 2], repeats: [f64; 2]) -> Option<[f64; 2]> {
    let is_inside = p.iter().all(|v| v.abs() <= 1.0);
    is_inside.then(|| [0, 1].map(|k| (p[k] + 1.0) / 2.0 * repeats[k]))
}

/// The floor is y = -1, 12 to either side of (0, -8) in x and z, with 24 repeats.
fn uv_of_floor(ray: DVec3) -> Option<[f64; 2]> {
    let t = (-1.0 - EYE.y) / ray.y;
    let p = EYE + ray * t;
    repeats([p.x / 12.0, (p.z + 8.0) / 12.0], [24.0, 24.0]).filter(|_| t > 0.0)
}

/// The card is z = 0, 1.7 to either side in x and 1.2 in y, with 0.4 and 0.3 of the texture.
fn uv_of_card(ray: DVec3) -> Option<[f64; 2]> {
    let p = EYE + ray * (-EYE.z / ray.z);
    repeats([p.x / 1.7, -p.y / 1.2], [0.4, 0.3])
}

/// Returns each pixel's mean of `rays` x `rays` texels, black beside the surface, as RGB in 0..255.
fn box_filter(uv: fn(DVec3) -> Option<[f64; 2]>, width: u32, height: u32, rays: u32) -> Vec<[f64; 3]> {
    let texture = bricks();
    let (columns, rows) = (f64::from(texture.width()), f64::from(texture.height()));
    let forward = (-EYE).normalize();
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let tan = libm::tan(FOV_RAD / 2.0);
    let aspect = f64::from(width) / f64::from(height);
    let texel = |ray: DVec3| {
        let [u, v] = uv(ray)?;
        // (0, 0) is the lower left corner; rows are stored from the top.
        let x = (u * columns).floor().rem_euclid(columns) as usize;
        let y = texture.height() as usize - 1 - (v * rows).floor().rem_euclid(rows) as usize;
        let first = 4 * (texture.width() as usize * y + x);
        Some([0, 1, 2].map(|c| f64::from(texture.bytes()[first + c])))
    };
    let ndc = |k: u32, i: u32, n: u32| {
        2.0 * (f64::from(k) + (f64::from(i) + 0.5) / f64::from(rays)) / f64::from(n) - 1.0
    };
    let mut means = Vec::with_capacity((width * height) as usize);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut sums = [0.0; 3];
        for (j, i) in (0..rays).flat_map(|j| (0..rays).map(move |i| (j, i))) {
            let ray = forward + right * (ndc(x, i, width) * tan * aspect) - up * (ndc(y, j, height) * tan);
            if let Some(color) = texel(ray) {
                (0..3).for_each(|c| sums[c] += color[c]);
            }
        }
        means.push(sums.map(|s| s / f64::from(rays * rays)));
    }
    means
}

fn size(effort: &Effort) -> (u32, u32) {
    effort.pick((48, 32), (160, 120))
}

fn check(effort: &Effort) -> Check {
    let (width, height) = size(effort);
    let difference = SURFACES.iter().fold(0f64, |worst, surface| {
        let [a, b] = [RAYS / 2, RAYS].map(|rays| box_filter(surface.uv, width, height, rays));
        let squares: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b) * (a - b)).sum();
        worst.max((squares / (3 * a.len()) as f64).sqrt())
    });
    Check { difference, at_most: 1.5 }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (width, height) = size(effort);
    let limit =
        Bound { column: 0, at_most: 2.0, because: "the limit of textured colours, by the specification" };
    let mut rows = Vec::new();
    for surface in SURFACES {
        let ideal: Vec<u8> = box_filter(surface.uv, width, height, RAYS)
            .into_iter()
            .flat_map(|[r, g, b]| [r, g, b, 255.0].map(|c| (c + 0.5) as u8))
            .collect();
        let of_filter = |filter: &Filter| case((surface.mesh)(), *filter, width, height);
        let cases: Vec<Case> = Filter::ALL.iter().map(of_filter).collect();
        let drawn = picture::drawn_in_turns(effort, &cases);
        for ((&filter, case), (found, timing)) in Filter::ALL.iter().zip(&cases).zip(drawn) {
            let exact = picture::truth(case);
            let judge = |found: &Vec<u8>| {
                let own = compare_bytes(width as usize, found, &nearest_bytes(&exact, found));
                let e = compare_bytes(width as usize, found, &ideal);
                vec![own.steps.max, e.steps.rmse, e.psnr_db, e.ssim]
            };
            let mutate =
                |found: &mut Vec<u8>, bound: &Bound| picture::raise_error(found, &exact, bound.at_most);
            let standing = if filter == Filter::default() { Standing::Default } else { Standing::Mode };
            let key = (surface.name, filter.as_str(), standing);
            let row = Row::judged(effort, key, &found, vec![limit], judge, mutate)
                .timed(timing, f64::from(width * height))
                .with_picture(width, found, ideal.clone());
            rows.push(row);
        }
    }
    rows
}

//! Texture filters, compared with a picture of 16 x 16 samples per pixel.

use super::experiment::{Bound, Effort, Experiment, Picture, Row};
use super::picture;
use crate::memory::DepthFormat;
use crate::scene::{
    Camera, Cull, Filter, LightingModel, LookAt, Material, Projection, Sampling, Scene, Texture, Wrap,
};
use crate::truth::Settings;
use crate::truth::metrics::compare_bytes;
use crate::truth::scenes::{Case, object, terrain};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Experiment on texture filters.
pub(super) const TEXTURES: Experiment = Experiment {
    id: "textures",
    title: "Textures",
    about: "A textured floor to the horizon and a card before the eye. The truth is the mean of 16 x 16 samples a pixel of the \
            finest level, its nearest texel: what an ideal box filter of the screen would show.",
    columns: &["largest error, 1/255", "RMSE, 1/255", "PSNR, dB", "SSIM"],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// Samples per pixel of the reference in each direction.
const SAMPLES: usize = 16;

/// Returns a texture of bricks of two colours with a little noise.
fn bricks() -> Arc<Texture> {
    let bytes = (0..64 * 64u32).flat_map(|i| {
        let (x, y) = (i % 64, i / 64);
        let joint = y % 16 == 0 || (x + y / 16 % 2 * 16) % 32 == 0;
        let noise = (i.wrapping_mul(2_654_435_761) >> 27) as u8;
        if joint { [200, 200, 190, 255] } else { [150 + noise, 60 + noise, 40, 255] }
    });
    Arc::new(Texture::new(64, 64, bytes.collect()).expect("64 x 64 texels"))
}

fn floor() -> crate::scene::Mesh {
    let mut mesh = terrain(1, 24.0, || 0.0);
    mesh.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 12.0, -1.0, p.z * 12.0 - 8.0));
    mesh
}

fn card() -> crate::scene::Mesh {
    let mut mesh = terrain(1, 1.0, || 0.0);
    mesh.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 1.7, -p.z * 1.2, 0.0));
    mesh.texcoords.iter_mut().for_each(|t| *t = DVec2::new(t.x * 0.4, t.y * 0.3));
    mesh
}

fn case(mesh: crate::scene::Mesh, filter: Filter, width: u32, height: u32) -> Case {
    let mut o = object("surface", mesh);
    o.cull = Cull::None;
    o.material = Material { emissive: DVec3::ONE, model: LightingModel::Unlit, ..Material::default() };
    o.texture = Some((bricks(), Sampling { filter, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat }));
    let look_at = LookAt { eye: DVec3::new(0.3, 0.0, 4.0), reference: DVec3::ZERO, up: DVec3::Y };
    let projection = Projection::Perspective { fov_rad: 0.8, near: 0.1, far: 100.0, on_smaller_side: false };
    Case {
        name: "textures".into(),
        scene: Scene { camera: Some(Camera { look_at, projection }), objects: vec![o], ..Scene::default() },
        settings: Settings::default(),
        format: DepthFormat::F32,
        width,
        height,
    }
}

/// Averages blocks of SAMPLES x SAMPLES pixels.
fn reduced(bytes: &[u8], width: usize, height: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(width * height * 4);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let mut sums = [0u32; 3];
        for j in 0..SAMPLES {
            let first = ((y * SAMPLES + j) * width + x) * SAMPLES * 4;
            for p in bytes[first..first + SAMPLES * 4].chunks_exact(4) {
                (0..3).for_each(|c| sums[c] += p[c] as u32);
            }
        }
        let n = (SAMPLES * SAMPLES) as u32;
        out.extend(sums.map(|s| ((s + n / 2) / n) as u8));
        out.push(255);
    }
    out
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (width, height) = effort.pick((48, 32), (160, 120));
    let mut rows = Vec::new();
    for (subject, mesh) in [("floor to the horizon", floor as fn() -> _), ("card before the eye", card)] {
        let many = SAMPLES as u32;
        let fine = picture::draw_case(&case(mesh(), Filter::Nearest, width * many, height * many)).memory;
        let truth = reduced(fine.bytes(), width as usize, height as usize);
        for &filter in Filter::ALL {
            let case = case(mesh(), filter, width, height);
            let (found, timing) = picture::drawn_as_usual(effort, &case);
            let e = compare_bytes(width as usize, &found, &truth);
            let at_most = if filter == Filter::Nearest { 64.0 } else { 48.0 };
            rows.push(Row {
                subject: subject.into(),
                alternative: filter.as_str().into(),
                is_default: filter == Filter::default(),
                errors: vec![e.steps.max, e.steps.rmse, e.psnr_db, e.ssim],
                bounds: vec![Bound { column: 1, at_most }],
                is_run: true,
                timing,
                work: (width * height) as f64,
                picture: Some(Picture { width, found, truth: truth.clone() }),
            });
        }
    }
    rows
}

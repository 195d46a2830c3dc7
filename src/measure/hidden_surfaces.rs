//! Hidden surfaces: painter's algorithm, back-face culling only, z-buffer.

use super::experiment::{Bound, Effort, Experiment, Picture, Row};
use super::picture;
use crate::memory::DepthFormat;
use crate::scene::{Cull, HiddenSurface, LightingModel, Material, Object, Scene, shapes};
use crate::truth::compare::nearest_bytes;
use crate::truth::metrics::compare_bytes;
use crate::truth::scenes::{Case, object};
use crate::truth::{Settings, Transparency};
use glam::{DMat4, DVec3};

/// Experiment on hidden surfaces.
pub(super) const HIDDEN: Experiment = Experiment {
    id: "hidden",
    title: "Hidden surfaces",
    about: "Pixels whose colour is off by more than one step from the z-buffer of the reference: faces sorted by their centres, \
            back faces left out and nothing else, and depth a pixel.",
    columns: &["pixels wrong", "part of the drawn pixels", "RMSE, 1/255"],
    plotted: 1,
    unit: "pixel",
    rows,
};

fn unlit(mut o: Object, color: DVec3) -> Object {
    o.material = Material { emissive: color, model: LightingModel::Unlit, ..Material::default() };
    o
}

/// Returns three bars that overlap in a cycle: no order of whole faces is correct.
fn cycle() -> Vec<Object> {
    (0..3)
        .map(|k| {
            let angle = k as f64 * std::f64::consts::TAU / 3.0;
            let positions = [[-1.6, -0.9, -0.5], [1.6, -0.9, 0.5], [1.6, -0.3, 0.5], [-1.6, -0.3, -0.5]];
            let mesh = crate::scene::Mesh::from_triangles(
                positions.map(DVec3::from_array).to_vec(),
                &[[0, 1, 2], [0, 2, 3]],
            );
            let mut o = unlit(object("bar", mesh), DVec3::from_array([0, 1, 2].map(|c| f64::from(c == k))));
            let (sin, cos) = libm::sincos(angle);
            o.model = DMat4::from_cols_array(&[
                cos, sin, 0.0, 0.0, -sin, cos, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
            ]);
            o.cull = Cull::None;
            o
        })
        .collect()
}

fn knot(effort: &Effort) -> Vec<Object> {
    let (nu, nv) = effort.pick((48, 10), (160, 24));
    let mut o = object("knot", shapes::knot(nu, nv).expect("a knot of some quads"));
    let size = o.geometry.mesh.bounds().map_or(1.0, |(lo, hi)| (hi - lo).max_element());
    o.model = crate::math::matrix::scale(DVec3::splat(3.2 / size));
    // Every polygon has its own colour, so that a wrong one is visible.
    let geometry = std::sync::Arc::make_mut(&mut o.geometry);
    let mesh = &mut geometry.mesh;
    for (i, p) in mesh.polygons.iter_mut().enumerate() {
        p.material = mesh.materials.len() as u32;
        let tone = |k: usize| (i * k % 23) as f64 / 22.0;
        let emissive = DVec3::new(tone(5), tone(7), tone(11));
        mesh.materials.push(Material { emissive, model: LightingModel::Unlit, ..Material::default() });
    }
    geometry.textures = Vec::new();
    vec![o]
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (width, height) = effort.pick((96, 72), (320, 240));
    let ways = [
        ("z-buffer", HiddenSurface::ZBuffer, None, 0.0),
        ("painter, by centres", HiddenSurface::Painter, None, 1.0),
        ("back faces only", HiddenSurface::None, Some(Cull::Back), 1.0),
        ("none", HiddenSurface::None, None, 1.0),
    ];
    let mut rows = Vec::new();
    for (subject, objects) in [("three bars in a cycle", cycle()), ("torus knot", knot(effort))] {
        let case = |hide, cull: Option<Cull>| {
            let mut objects = objects.clone();
            for o in &mut objects {
                o.cull = cull.unwrap_or(Cull::None);
            }
            Case {
                name: subject.into(),
                scene: Scene { objects, ..Scene::default() },
                settings: Settings {
                    hide,
                    transparency: Transparency::AfterOpaque(Default::default()),
                    ..Settings::default()
                },
                format: DepthFormat::F32,
                width,
                height,
            }
        };
        let exact = picture::truth(&case(HiddenSurface::ZBuffer, None));
        let covered = exact.depths().iter().filter(|z| **z < 1.0).count();
        for (name, hide, cull, at_most) in ways {
            let case = case(hide, cull);
            let (found, timing) = picture::drawn_as_usual(effort, &case);
            let truth = nearest_bytes(&exact, &found);
            let e = compare_bytes(width as usize, &found, &truth);
            let part = e.pixels_off as f64 / covered.max(1) as f64;
            rows.push(Row {
                subject: subject.into(),
                alternative: name.into(),
                is_default: hide == HiddenSurface::default(),
                errors: vec![e.pixels_off as f64, part, e.steps.rmse],
                bounds: vec![Bound { column: 1, at_most }],
                is_run: true,
                timing,
                work: (width * height) as f64,
                picture: Some(Picture { width, found, truth }),
            });
        }
    }
    rows
}

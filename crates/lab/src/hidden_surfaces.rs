//! Hidden surfaces: painter's algorithm, back-face culling only, z-buffer.

use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::picture;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{Cull, HiddenSurface, LightingModel, Material, Object, Scene, shapes};
use fbptr_truth::compare::nearest_bytes;
use fbptr_truth::metrics::compare_bytes;
use fbptr_truth::scenes::{Case, object};
use fbptr_truth::{Settings, Transparency};
use glam::{DMat4, DVec3};

/// Experiment on hidden surfaces.
pub(super) const HIDDEN: Experiment = Experiment {
    id: "hidden",
    title: "Hidden surfaces",
    about: "Pixels whose colour is off by more than one step from that of the nearest face: faces sorted by their centres, \
            back faces left out and nothing else, and depth a pixel. Each way is also held to its own definition.",
    truth: Truth {
        is: "the nearest face at each pixel's centre; for the last column, the faces in the order that the mode defines",
        digits: "32",
        second_way: "the plain path, a program apart; its largest difference in 1/255",
    },
    check,
    columns: &[
        "pixels wrong",
        "part of the drawn pixels",
        "RMSE, 1/255",
        "largest error against its own definition, 1/255",
    ],
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
            let mesh = fbptr_core::scene::Mesh::from_triangles(
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
    o.model = fbptr_core::math::matrix::scale(DVec3::splat(3.2 / size));
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

/// Returns the case of a subject's objects, with culling in place of their own.
fn case(effort: &Effort, objects: &[Object], hide: HiddenSurface, cull: Option<Cull>) -> Case {
    let (width, height) = effort.pick((96, 72), (320, 240));
    let mut objects = objects.to_vec();
    for o in &mut objects {
        o.cull = cull.unwrap_or(Cull::None);
    }
    Case {
        name: "hidden surfaces".into(),
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
}

fn subjects(effort: &Effort) -> [(&'static str, Vec<Object>); 2] {
    [("three bars in a cycle", cycle()), ("torus knot", knot(effort))]
}

fn check(effort: &Effort) -> Check {
    let difference = subjects(effort).iter().fold(0f64, |worst, (_, objects)| {
        worst.max(picture::plain_against_truth(&case(effort, objects, HiddenSurface::ZBuffer, None)))
    });
    Check { difference, at_most: 1.0 }
}

const OWN: Bound =
    Bound { column: 3, at_most: 1.0, because: "the limit of untextured colours, by the specification" };
const NONE_WRONG: Bound =
    Bound { column: 0, at_most: 0.0, because: "the z-buffer keeps the nearest face of every pixel" };

fn rows(effort: &Effort) -> Vec<Row> {
    let ways = [
        ("z-buffer", HiddenSurface::ZBuffer, None, vec![NONE_WRONG, OWN]),
        ("painter, by centres", HiddenSurface::Painter, None, vec![OWN]),
        ("back faces only", HiddenSurface::None, Some(Cull::Back), vec![OWN]),
        ("none", HiddenSurface::None, None, vec![OWN]),
    ];
    let mut rows = Vec::new();
    for (subject, objects) in subjects(effort) {
        let exact = picture::truth(&case(effort, &objects, HiddenSurface::ZBuffer, None));
        let covered = exact.depths().iter().filter(|z| **z < 1.0).count().max(1);
        let cases = ways.each_ref().map(|(_, hide, cull, _)| case(effort, &objects, *hide, *cull));
        let drawn = picture::drawn_in_turns(effort, &cases);
        for (((name, hide, _, bounds), case), (found, timing)) in ways.iter().zip(&cases).zip(drawn) {
            let own = picture::truth(case);
            let judge = |found: &Vec<u8>| {
                let e = compare_bytes(case.width as usize, found, &nearest_bytes(&exact, found));
                let own = compare_bytes(case.width as usize, found, &nearest_bytes(&own, found));
                let part = e.pixels_off as f64 / covered as f64;
                vec![e.pixels_off as f64, part, e.steps.rmse, own.steps.max]
            };
            let mutate = |found: &mut Vec<u8>, bound: &Bound| match bound.column {
                // A pixel counts as wrong from two steps on.
                0 => picture::raise_error(found, &exact, 1.0),
                _ => picture::raise_error(found, &own, bound.at_most),
            };
            let is_default = *hide == HiddenSurface::default();
            let standing = if is_default { Standing::Default } else { Standing::Mode };
            let truth = nearest_bytes(&exact, &found);
            let row = Row::judged(effort, (subject, *name, standing), &found, bounds.clone(), judge, mutate)
                .timed(timing, f64::from(case.width * case.height))
                .with_picture(case.width, found, truth);
            rows.push(row);
        }
    }
    rows
}

//! Tests of plane equations: the reference values of notes 003, and properties of all faces.

use super::*;
use crate::pipeline::golden;
use crate::pipeline::sampler::Footprint;
use crate::pipeline::shade::uv_from_first;
use glam::{DVec2, DVec4};
use proptest::prelude::*;
use serde_json::Value;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// NDC of a point in a frame of 64 x 64 pixels.
fn ndc(p: [f64; 2]) -> [f64; 2] {
    [p[0] / 32.0 - 1.0, 1.0 - p[1] / 32.0]
}

/// Returns a corner at a screen position, at distance `w` from the eye, with clip depth `z`.
fn corner(screen: [f64; 2], w: f64, z: f64) -> Vertex {
    let [x, y] = ndc(screen);
    let clip = DVec4::new(x * w, y * w, z, w);
    Vertex { position: clip.truncate(), clip, complement: w - z, view_z: -w, screen }
}

fn golden_plane(inputs: &Value, w: [f64; 3]) -> FacePlane {
    let v: [Vertex; 3] = std::array::from_fn(|i| {
        let p = &inputs[["P0", "P1", "P2"][i]];
        corner([number(&p[0]), number(&p[1])], w[i], 0.5 * w[i])
    });
    FacePlane::new([&v[0], &v[1], &v[2]]).unwrap()
}

fn barycentrics(plane: &FacePlane, pixel: [f64; 2], interp: Interpolation) -> [f64; 3] {
    plane.barycentrics(&plane.weights_at(ndc([pixel[0] + 0.5, pixel[1] + 0.5])), interp, true).unwrap()
}

#[test]
fn golden_barycentric_weights() {
    let g = golden("seed003_barycentric");
    let tolerance = number(&g["tolerance"]["absolute"]);
    for w in [[1.0; 3], [9.5, 10.5, 10.0]] {
        let plane = golden_plane(&g["inputs"], w);
        let found = barycentrics(&plane, [28.0, 22.0], Interpolation::Affine);
        for (i, name) in ["alpha", "beta", "gamma"].into_iter().enumerate() {
            assert!((found[i] - number(&g["expected"][name])).abs() <= tolerance, "{name} {found:?}");
        }
    }
}

#[test]
fn golden_perspective_interpolation() {
    let g = golden("seed003_perspective_interp");
    let tolerance = number(&g["tolerance"]["absolute"]);
    let z: [f64; 3] = std::array::from_fn(|i| number(&g["inputs"]["Z"][i]));
    let plane = golden_plane(&golden("seed003_barycentric")["inputs"], z);
    let found = barycentrics(&plane, [28.0, 22.0], Interpolation::Perspective);
    for i in 0..3 {
        assert!((found[i] - number(&g["expected"]["colour"][i])).abs() <= tolerance, "{found:?}");
    }
    let b = plane.weights_at(ndc([28.5, 22.5])).b;
    assert!((1.0 / (b[0] + b[1] + b[2]) - number(&g["expected"]["Z"])).abs() <= tolerance);
}

#[test]
fn golden_mip_level() {
    let g = golden("seed003_mip_level");
    let tolerance = number(&g["tolerance"]["absolute"]);
    let z: [f64; 3] = std::array::from_fn(|i| number(&g["inputs"]["Z"][i]));
    let uv = std::array::from_fn(|i| {
        let uv = &g["inputs"]["uv"][i];
        DVec2::new(number(&uv[0]), number(&uv[1]))
    });
    let plane = golden_plane(&g["inputs"], z);
    let size = number(&g["inputs"]["texture_size"]) as u32;
    for (interp, name) in
        [(Interpolation::Affine, "affine"), (Interpolation::Perspective, "perspective_correct")]
    {
        let expected = &g["expected"][name];
        let at = |pixel: &str| {
            let p = &g["inputs"]["pixels"][pixel];
            let found =
                uv[0] + uv_from_first(&uv, barycentrics(&plane, [number(&p[0]), number(&p[1])], interp));
            let wanted = DVec2::new(number(&expected["uv"][pixel][0]), number(&expected["uv"][pixel][1]));
            assert!((found - wanted).abs().max_element() <= tolerance, "{name} {pixel} {found}");
            found
        };
        let (here, right, below) = (at("p00"), at("p10"), at("p01"));
        let d = Footprint::Steps(right - here, below - here).level(size, size);
        assert!((d - number(&expected["D"])).abs() <= tolerance, "{name} {d}");
        assert_eq!((d + 0.5).floor(), number(&expected["level"]), "{name}");
    }
}

/// Receiver of computed numbers, each with the words that name it.
type Say<'a> = dyn FnMut(&str, f64) + 'a;

/// Weights of notes 003 rounded as they are printed.
const PRINTED_WEIGHTS: [f64; 3] = [0.668, 0.194, 0.139];

/// Computes the printed areas, weights, depths and colours.
fn say_weights(inputs: &Value, plane: &FacePlane, z: [f64; 3], say: &mut Say) {
    let w = barycentrics(plane, [28.0, 22.0], Interpolation::Affine);
    let p = |i: usize, k: usize| number(&inputs[["P0", "P1", "P2"][i]][k]);
    let double_area = (p(1, 0) - p(0, 0)) * (p(2, 1) - p(0, 1)) - (p(2, 0) - p(0, 0)) * (p(1, 1) - p(0, 1));
    let area = double_area.abs() / 2.0;
    for (what, value) in ["A", "A0", "A1", "A2"].iter().zip([1.0, w[0], w[1], w[2]]) {
        say(what, value * area);
    }
    for (i, what) in ["alpha", "beta", "gamma = A2/A"].into_iter().enumerate() {
        say(what, w[i]);
    }
    let rounded = PRINTED_WEIGHTS;
    say("gamma = 1 - alpha - beta (from the 3-decimal weights)", 1.0 - rounded[0] - rounded[1]);
    for (i, what) in ["alpha/Z0", "beta/Z1", "gamma/Z2"].into_iter().enumerate() {
        say(what, rounded[i] / z[i]);
    }
    say("Z (rounded weights)", 1.0 / (0..3).map(|i| rounded[i] / z[i]).sum::<f64>());
    let b = plane.weights_at(ndc([28.5, 22.5])).b;
    say("Z (exact weights)", 1.0 / (b[0] + b[1] + b[2]));
    let exact = barycentrics(plane, [28.0, 22.0], Interpolation::Perspective);
    for (i, c) in ["CR", "CG", "CB"].into_iter().enumerate() {
        say(&format!("{c} (printed Z=9.74 and rounded weights)"), 9.74 * rounded[i] / z[i]);
        say(&format!("{c} (exact weights)"), exact[i]);
    }
}

/// Computes the printed texture coordinates, their derivatives and mip levels.
fn say_uvs(plane: &FacePlane, say: &mut Say) {
    let uv = [DVec2::ZERO, DVec2::X, DVec2::new(0.5, 1.0)];
    let rounded = PRINTED_WEIGHTS;
    let by_rounded = uv[1] * rounded[1] + uv[2] * rounded[2];
    say("uv p00.u affine with the 3-decimal weights", by_rounded.x);
    say("uv p00.v affine with the 3-decimal weights", by_rounded.y);
    let places = [("p00", [28.0, 22.0]), ("p10", [29.0, 22.0]), ("p01", [28.0, 23.0])];
    let right = places.map(|(_, p)| uv_from_first(&uv, barycentrics(plane, p, Interpolation::Perspective)));
    for ((name, _), uv) in places.iter().zip(right) {
        say(&format!("uv {name}.u perspective-correct"), uv.x);
        say(&format!("uv {name}.v perspective-correct"), uv.y);
    }
    let printed = [[0.264, 0.139], [0.414, 0.129], [0.248, -0.010]].map(DVec2::from);
    let steps = |uv: [DVec2; 3]| (32.0 * (uv[1] - uv[0]), 32.0 * (uv[2] - uv[0]));
    let ((px, py), (cx, cy)) = (steps(printed), steps(right));
    say("du/dx from the printed UVs", px.x);
    say("du/dx perspective-correct", cx.x);
    say("dv/dx", px.y);
    say("du/dy from the printed UVs", py.x);
    say("du/dy perspective-correct", cy.x);
    say("dv/dy", py.y);
    let level = |x: DVec2, y: DVec2| Footprint::Steps(x / 32.0, y / 32.0).level(32, 32);
    let length = |x: DVec2, y: DVec2| crate::math::power::exp2(level(x, y));
    say("L from the printed derivatives", length(DVec2::new(4.8, -0.32), DVec2::new(-0.56, -4.8)));
    say("L from printed UVs (unrounded derivatives)", length(px, py));
    say("L perspective-correct", length(cx, cy));
    say("D = log2 L (L=4.83)", level(DVec2::new(4.83, 0.0), DVec2::ZERO));
    say("D perspective-correct", level(cx, cy));
}

/// Computes the printed depths.
fn say_depths(say: &mut Say) {
    for (range, near, far) in [("n=0.01 f=1000", 0.01, 1000.0), ("n=5 f=10", 5.0, 10.0)] {
        for (face, d) in [("red", 8.0), ("blue", 9.0)] {
            let projection =
                crate::scene::Projection::Perspective { fov_rad: 1.0, near, far, on_smaller_side: false };
            let camera = crate::scene::Camera { projection, ..Default::default() }.matrices(1.0).unwrap();
            let clip = camera.projection * DVec4::new(0.0, 0.0, -d, 1.0);
            let z = clip.z / clip.w;
            say(&format!("NDC {face} {range}"), 2.0 * z - 1.0);
            say(&format!("normalised {face} {range}"), z);
            for (name, format) in
                [("Int16", crate::memory::DepthFormat::U16), ("Int32", crate::memory::DepthFormat::U32)]
            {
                say(&format!("{name} {face} {range}"), format.encode(z, 1.0 - z) as f64);
            }
        }
    }
}

/// Every number printed in notes 003, computed from the pipeline's planes, logarithm and cameras.
#[test]
fn golden_printed_numbers() {
    let inputs = golden("seed003_mip_level")["inputs"].clone();
    let z = [9.5, 10.5, 10.0];
    let plane = golden_plane(&inputs, z);
    let mut found: Vec<(String, f64)> = Vec::new();
    let mut say = |what: &str, value: f64| found.push((what.to_owned(), value));
    say_weights(&inputs, &plane, z, &mut say);
    say_uvs(&plane, &mut say);
    say_depths(&mut say);
    let table = golden("seed003_printed_numbers_check");
    let table = table["expected"].as_array().unwrap();
    assert_eq!(table.len(), found.len());
    for row in table {
        let what = row["what"].as_str().unwrap();
        let value = found.iter().find(|f| f.0 == what).unwrap_or_else(|| panic!("nothing computes {what}")).1;
        assert!((value - number(&row["computed"])).abs() <= 1e-12 * value.abs().max(1.0), "{what}: {value}");
        let half_unit = 0.5 * libm::pow(10.0, -number(&row["printed_decimals"]));
        let agrees = (value - number(&row["printed"])).abs() <= half_unit * (1.0 + 1e-9);
        assert_eq!(agrees, row["agrees"].as_bool().unwrap(), "{what}: {value} against {}", row["printed"]);
    }
}

#[test]
fn a_face_of_constant_depth_has_one_depth_everywhere() {
    for (w, z) in [(1.0, 0.3), (7.3, 6.1)] {
        let v = [[1.3, 2.1], [60.2, 7.7], [20.0, 50.1]].map(|p| corner(p, w, z));
        let plane = FacePlane::new([&v[0], &v[1], &v[2]]).unwrap();
        for x in 0..60 {
            let weights = plane.weights_at(ndc([x as f64 + 0.5, 20.5]));
            assert_eq!(plane.depth(&weights), (z / w, (w - z) / w));
        }
    }
}

#[test]
fn clamped_weights_are_weights() {
    let v = [corner([1.0, 1.0], 2.0, 1.0), corner([9.0, 1.0], 4.0, 3.0), corner([1.0, 9.0], 3.0, 2.0)];
    let plane = FacePlane::new([&v[0], &v[1], &v[2]]).unwrap();
    let at = |p: [f64; 2]| {
        let w = plane.clamped(plane.weights_at(ndc(p))).unwrap();
        plane.barycentrics(&w, Interpolation::Affine, true).unwrap()
    };
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14);
    // Straight weights (.5, .25, .25) stay; (1.25, 0, -.25) become (1, 0, 0); (-.25, .625, .625)
    // halves.
    assert!(close(at([3.0, 3.0]), [0.5, 0.25, 0.25]));
    assert!(close(at([1.0, -1.0]), [1.0, 0.0, 0.0]));
    assert!(close(at([6.0, 6.0]), [0.0, 0.5, 0.5]));
}

fn place() -> impl Strategy<Value = [f64; 2]> {
    [-200.0f64..200.0, -200.0f64..200.0]
}

proptest! {
    #[test]
    fn depth_is_the_same_bits_in_any_corner_order(
        p in [place(), place(), place()],
        w in [0.1f64..50.0, 0.1f64..50.0, -5.0f64..50.0],
        at in place(),
    ) {
        let v: [Vertex; 3] = std::array::from_fn(|i| corner(p[i], w[i], 1.01 * w[i] - 0.2));
        let depth = |o: [usize; 3]| {
            let plane = FacePlane::new(o.map(|i| &v[i]))?;
            let weights = plane.clamped(plane.weights_at(ndc(at)))?;
            let (z, c) = plane.depth(&weights);
            Some((z.to_bits(), c.to_bits()))
        };
        let first = depth([0, 1, 2]);
        for order in [[0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]] {
            prop_assert_eq!(depth(order), first);
        }
    }

    /// Affine functions of the corners are reproduced at points of the face, also with corners
    /// behind the eye.
    #[test]
    fn shares_give_back_the_point(
        p in [place(), place(), place()],
        w in [0.1f64..50.0, -20.0f64..50.0, -20.0f64..50.0],
        mix in [0.0f64..1.0, 0.0f64..1.0, 0.0f64..1.0],
    ) {
        let v: [Vertex; 3] = std::array::from_fn(|i| corner(p[i], w[i], 1.01 * w[i] - 0.2));
        let sum: f64 = mix.iter().sum();
        prop_assume!(sum > 0.1);
        let point = (0..3).fold(DVec4::ZERO, |s, i| s + v[i].clip * (mix[i] / sum));
        prop_assume!(point.w > 0.01);
        let Some(plane) = FacePlane::new([&v[0], &v[1], &v[2]]) else { return Ok(()) };
        let weights = plane.weights_at([point.x / point.w, point.y / point.w]);
        let found = plane.barycentrics(&weights, Interpolation::Perspective, true).unwrap();
        let (z, complement) = plane.depth(&weights);
        let det = v[0].clip.truncate().with_z(w[0]).dot(v[1].clip.truncate().with_z(w[1]).cross(v[2].clip.truncate().with_z(w[2])));
        prop_assume!(det.abs() > 1.0);
        for i in 0..3 {
            prop_assert!((found[i] - mix[i] / sum).abs() < 1e-7, "{found:?} {mix:?}");
        }
        prop_assert!((z - point.z / point.w).abs() < 1e-7 * z.abs().max(1.0));
        prop_assert!((complement - (point.w - point.z) / point.w).abs() < 1e-7 * z.abs().max(1.0));
    }
}

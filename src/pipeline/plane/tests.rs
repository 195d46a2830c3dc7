//! The worked numbers of notes 003 on the plane of one face, and what must hold for every face.

use super::*;
use crate::pipeline::golden;
use crate::pipeline::sample::Footprint;
use crate::pipeline::shade::uv_from_first;
use glam::{DVec2, DVec4};
use proptest::prelude::*;
use serde_json::Value;

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap()
}

/// NDC in a frame of 64 x 64 pixels.
fn ndc(p: [f64; 2]) -> [f64; 2] {
    [p[0] / 32.0 - 1.0, 1.0 - p[1] / 32.0]
}

/// A corner at a place on the screen, at distance `w` from the eye, with clip depth `z`.
fn corner(screen: [f64; 2], w: f64, z: f64) -> Vertex {
    let [x, y] = ndc(screen);
    Vertex { clip: DVec4::new(x * w, y * w, z, w), complement: w - z, view_z: -w, screen }
}

fn golden_plane(inputs: &Value, w: [f64; 3]) -> FacePlane {
    let v: [Vertex; 3] = std::array::from_fn(|i| {
        let p = &inputs[["P0", "P1", "P2"][i]];
        corner([number(&p[0]), number(&p[1])], w[i], 0.5 * w[i])
    });
    FacePlane::new([&v[0], &v[1], &v[2]]).unwrap()
}

fn shares(plane: &FacePlane, pixel: [f64; 2], interp: Interpolation) -> [f64; 3] {
    plane.shares(&plane.weights_at(ndc([pixel[0] + 0.5, pixel[1] + 0.5])), interp, true).unwrap()
}

#[test]
fn golden_barycentric_weights() {
    let g = golden("seed003_barycentric");
    let tolerance = number(&g["tolerance"]["absolute"]);
    for w in [[1.0; 3], [9.5, 10.5, 10.0]] {
        let plane = golden_plane(&g["inputs"], w);
        let found = shares(&plane, [28.0, 22.0], Interpolation::Affine);
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
    let found = shares(&plane, [28.0, 22.0], Interpolation::Perspective);
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
            let found = uv[0] + uv_from_first(&uv, shares(&plane, [number(&p[0]), number(&p[1])], interp));
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
        plane.shares(&w, Interpolation::Affine, true).unwrap()
    };
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-14);
    // Straight weights (.5, .25, .25) stay; (1.25, 0, -.25) become (1, 0, 0); (-.25, .625, .625) halves.
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

    /// Any affine function of the corners comes back at points of the face, also for corners behind the eye.
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
        let found = plane.shares(&weights, Interpolation::Perspective, true).unwrap();
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

//! Cameras, projections, and the resulting depths.

use super::*;
use crate::camera::{Sight, transform};
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{Camera, ObliqueKind, Projection};

#[test]
fn camera_matrix_of_004() {
    for case in golden("seed004_camera_matrix")["expected"].as_array().unwrap() {
        let look_at = look_at(&case["eye"], &case["ref"], &case["vup"]);
        let camera = Camera { look_at, ..Camera::default() };
        let sight = Sight::new(&camera, &corners_viewport(4, 3)).unwrap();
        for (row, expected) in sight.view.iter().zip(case["C"].as_array().unwrap()) {
            all_near(&narrow(*row), expected, 1e-13);
        }
    }
}

#[test]
fn view_plane_distance_of_001() {
    for case in golden("seed001_pipeline_matrices")["expected"].as_array().unwrap() {
        let i = &case["inputs"];
        let (width, height) = (number(&i["width"]) as u32, number(&i["height"]) as u32);
        let projection = Projection::Plane { d: number(&i["d"]), near: 0.5, far: 20.0 };
        let camera = Camera { look_at: look_at(&i["eye"], &i["lookat"], &i["up"]), projection };
        let viewport = Viewport { rule: ViewportRule::Centres, ..corners_viewport(width, height) };
        let sight = Sight::new(&camera, &viewport).unwrap();
        let (sin, cos) = libm::sincos(number(&i["model_rotation_y"]));
        for p in case["points"].as_array().unwrap() {
            let o = numbers(&p["object"]);
            let turned =
                [o[0] * cos + o[2] * sin, o[1], -o[0] * sin + o[2] * cos, 1.0].map(DoubleDouble::new);
            let clip = transform(&sight.projection, transform(&sight.view, turned));
            let ndc = [clip[0] / clip[3], clip[1] / clip[3]];
            all_near(
                &ndc.map(DoubleDouble::to_f64),
                &Value::from(numbers(&p["canonical"])[..2].to_vec()),
                1e-12,
            );
            // The source's integers are pixel centres; here centres are at .5.
            let screen = sight.to_screen(ndc[0], ndc[1]).map(|c| c.to_f64() - 0.5);
            all_near(&screen, &Value::from(numbers(&p["screen"])[..2].to_vec()), 1e-12);
        }
    }
}

#[test]
fn viewing_transformation_of_000() {
    for case in golden("seed000_viewing_transformation")["expected"].as_array().unwrap() {
        let i = &case["inputs"];
        let n = |k: &str| number(&i[k]);
        let projection = Projection::Window {
            vrp: vector(&i["VRP"]),
            p: vector(&i["P"]),
            vup: vector(&i["VUP"]),
            center: [n("CU"), n("CV")],
            half: [n("SU"), n("SV")],
            dp: n("DP"),
            near: n("near"),
            far: n("far"),
        };
        let v = |k: &str| number(&i["viewport"][k]) as i32;
        let viewport = Viewport {
            x: v("umin"),
            y: v("vmin"),
            width: (v("umax") - v("umin") + 1) as u32,
            height: (v("vmax") - v("vmin") + 1) as u32,
            rule: ViewportRule::Centres,
        };
        let camera = Camera { projection, ..Camera::default() };
        let sight = Sight::new(&camera, &viewport).unwrap();
        let m1 = crate::camera::multiply(&sight.projection, &sight.view);
        for (row, expected) in m1.iter().zip(case["matrices"]["M1"].as_array().unwrap()) {
            all_near(&narrow(*row), expected, 1e-12);
        }
        for p in case["points"].as_array().unwrap() {
            let clip = transform(&m1, point4(&p["world"]));
            all_near(&narrow(clip), &p["clip"], 1e-12);
            let screen = sight.to_screen(clip[0] / clip[3], clip[1] / clip[3]).map(DoubleDouble::to_f64);
            all_near(&screen, &Value::from(numbers(&p["screen"])[..2].to_vec()), 1e-12);
        }
        for c in case["view_volume_corners"].as_array().unwrap() {
            let clip = transform(&m1, point4(&c["world"]));
            all_near(&[0, 1, 2].map(|k| (clip[k] / clip[3]).to_f64()), &c["ndc"], 1e-12);
        }
    }
}

/// The goldens use the picture's own units; a window of half extents 1 makes them NDC.
#[test]
fn parallel_projections_of_004() {
    let (window, near_far) = ([-1.0, 1.0, -1.0, 1.0], (-10.0, 10.0));
    let (near, far) = near_far;
    for case in golden("seed004_parallel_projections")["expected"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let oblique = |kind, degrees: f64| Projection::Oblique {
            kind,
            angle_rad: degrees.to_radians(),
            window,
            near,
            far,
        };
        // The oblique goldens shear about z = 0: a camera at z = 1 that looks at the origin.
        let projection = match name {
            "plan_xy" => Projection::Ortho { window, near, far },
            "cavalier_45" => oblique(ObliqueKind::Cavalier, 45.0),
            "cavalier_60" => oblique(ObliqueKind::Cavalier, 60.0),
            "cabinet_45" => oblique(ObliqueKind::Cabinet, 45.0),
            "cabinet_60" => oblique(ObliqueKind::Cabinet, 60.0),
            "isometric" => Projection::Isometric { window, near, far },
            "pseudo_isometric_30" => Projection::PseudoIsometric { window, near, far },
            // Elevations are plans of a rotated camera.
            "elevation_xz" | "elevation_zy" => continue,
            other => panic!("unknown golden {other}"),
        };
        let look_at = LookAt { eye: DVec3::Z, reference: DVec3::ZERO, up: DVec3::Y };
        let sight = Sight::new(&Camera { look_at, projection }, &corners_viewport(8, 8)).unwrap();
        let turns = name.contains("isometric");
        for p in case["unit_cube"].as_array().unwrap() {
            // The rotations are about the eye, which the golden has at the origin.
            let mut world = point4(&p["p"]);
            if turns {
                world[2] += DoubleDouble::ONE;
            }
            let clip = transform(&sight.projection, transform(&sight.view, world));
            all_near(&[clip[0].to_f64(), clip[1].to_f64()], &p["projected"], 1e-12);
        }
    }
}

#[test]
fn frustum_to_box_of_004() {
    for case in golden("seed004_frustum_to_box")["expected"].as_array().unwrap() {
        let (near, far) = (number(&case["near"]), number(&case["far"]));
        let window = [-1.0, 1.0, -1.0, 1.0];
        let projection = Projection::Frustum { window, near, far };
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let sight = Sight::new(&Camera { look_at, projection }, &corners_viewport(8, 8)).unwrap();
        for p in case["points"].as_array().unwrap() {
            let clip = transform(&sight.projection, transform(&sight.view, point4(&p["eye"])));
            let [x, y, z] = [0, 1, 2].map(|k| (clip[k] / clip[3]).to_f64());
            // The source's box is -near..-far; here it is 0..1.
            let boxed = [x, y, -(near + z * (far - near))];
            all_near(&boxed, &p["P"]["projected"], 1e-12);
        }
    }
}

#[test]
fn depth_values_of_003() {
    for case in golden("seed003_depth_values")["expected"].as_array().unwrap() {
        let (near_plane, far) = (number(&case["near"]), number(&case["far"]));
        let projection = Projection::Frustum { window: [-1.0, 1.0, -1.0, 1.0], near: near_plane, far };
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let sight = Sight::new(&Camera { look_at, projection }, &corners_viewport(8, 8)).unwrap();
        let p = [0.0, 0.0, -number(&case["view_distance"]), 1.0].map(DoubleDouble::new);
        let clip = transform(&sight.projection, transform(&sight.view, p));
        let z = clip[2] / clip[3];
        near(z.to_f64(), &case["normalised"], 1e-15);
        for (format, key) in [(DepthFormat::U16, "u16"), (DepthFormat::U32, "u32")] {
            use crate::picture::StoredDepth;
            let word = case[key].as_u64().unwrap();
            assert_eq!(format.words_around([z, z]), [word, word], "{key}");
            assert_eq!(format.encode(z.to_f64(), 1.0 - z.to_f64()) as u64, word);
        }
    }
}

//! Worked numbers of notes 000, 001 and 004, and properties of every camera.

use super::*;
use serde_json::Value;

fn golden(name: &str) -> Value {
    let path = format!("{}/../../tests/data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("not a number: {v}"))
}

fn vec3(v: &Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| number(&v[i])))
}

fn matrix4(v: &Value) -> DMat4 {
    matrix::from_rows(std::array::from_fn(|i| number(&v[i / 4][i % 4])))
}

#[track_caller]
fn assert_close(what: &str, a: DMat4, b: DMat4, tolerance: f64) {
    let off = (a.to_cols_array().iter().zip(b.to_cols_array()))
        .map(|(a, b)| (a - b).abs() / b.abs().max(1.0))
        .fold(0.0, f64::max);
    assert!(off <= tolerance, "{what} is off by {off}:\n{a}\n{b}");
}

fn look_at(eye: DVec3, reference: DVec3, up: DVec3) -> LookAt {
    LookAt { eye, reference, up }
}

#[test]
fn golden_camera_matrix() {
    let g = golden("seed004_camera_matrix");
    let tolerance = number(&g["tolerance"]["absolute"]);
    let cases = g["expected"].as_array().unwrap();
    assert!(cases.len() >= 3);
    for case in cases {
        let l = look_at(vec3(&case["eye"]), vec3(&case["ref"]), vec3(&case["vup"]));
        for (axis, name) in l.axes().unwrap().iter().zip(["xe", "ye", "ze"]) {
            assert!((*axis - vec3(&case[name])).abs().max_element() <= tolerance, "{name} {axis}");
        }
        assert_close("C", l.matrix().unwrap(), matrix4(&case["C"]), tolerance);
        let reference = l.matrix().unwrap().transform_point3(l.reference);
        assert!((reference - vec3(&case["ref_in_eye"])).abs().max_element() <= tolerance);
    }
}

#[test]
fn an_eye_whose_squares_overflow_is_refused() {
    let seen_from = |distance: f64, reference: DVec3| {
        let look_at = look_at(DVec3::new(0.0, -distance, 0.0), reference, DVec3::Z);
        Camera { look_at, ..Camera::default() }.matrices(1.0)
    };
    assert!(seen_from(1e150, DVec3::ZERO).is_ok());
    for (distance, reference) in [(1e154, DVec3::ZERO), (1e308, DVec3::ZERO), (1.0, DVec3::X * -1e154)] {
        let error = seen_from(distance, reference).unwrap_err();
        let far = distance.max(reference.abs().max_element());
        assert_eq!(error, CameraError::TooFar { distance: far });
        assert!(error.to_string().ends_with("from the origin, beyond 1e150"), "{error}");
    }
}

#[test]
fn golden_view_plane_pipeline() {
    let g = golden("seed001_pipeline_matrices");
    let tolerance = number(&g["tolerance"]["absolute"]);
    let cases = g["expected"].as_array().unwrap();
    assert!(cases.len() >= 3);
    for case in cases {
        let (i, m) = (&case["inputs"], &case["matrices"]);
        let view = look_at(vec3(&i["eye"]), vec3(&i["lookat"]), vec3(&i["up"])).matrix().unwrap();
        let projection = proj::view_plane(number(&i["d"]));
        let model = matrix::rotate(DVec3::Y, number(&i["model_rotation_y"])).unwrap();
        let viewport = proj::viewport_centres(number(&i["width"]) as u32, number(&i["height"]) as u32);
        assert_close("view", view, matrix4(&m["view"]), tolerance);
        assert_close("projection", projection, matrix4(&m["projection"]), tolerance);
        assert_close("model", model, matrix4(&m["model"]), tolerance);
        assert_close("viewport", viewport, matrix4(&m["viewport"]), tolerance);
        let all = projection * view * model;
        assert_close("model view projection", all, matrix4(&m["model_view_projection"]), tolerance);
        for p in case["points"].as_array().unwrap() {
            let clip = all * vec3(&p["object"]).extend(1.0);
            let screen = viewport * (clip / clip.w);
            for k in 0..3 {
                let wanted = number(&p["screen"][k]);
                assert!((screen[k] - wanted).abs() <= tolerance * wanted.abs().max(1.0), "{p}");
            }
        }
        // PLANE takes x, y and w from there, and z from its near and far.
        let plane = Camera {
            look_at: look_at(vec3(&i["eye"]), vec3(&i["lookat"]), vec3(&i["up"])),
            projection: Projection::Plane { d: number(&i["d"]), near: 0.5, far: 20.0 },
        };
        let found = plane.matrices(number(&i["width"]) / number(&i["height"])).unwrap();
        for row in [0, 1, 3] {
            assert_eq!(found.projection.row(row), projection.row(row));
        }
    }
}

#[test]
fn golden_viewing_transformation() {
    let g = golden("seed000_viewing_transformation");
    let tolerance = number(&g["tolerance"]["absolute"]);
    let cases = g["expected"].as_array().unwrap();
    assert!(cases.len() >= 3);
    for case in cases {
        let (i, m) = (&case["inputs"], &case["matrices"]);
        let pair = |a: &str, b: &str| [number(&i[a]), number(&i[b])];
        let (center, half, range) = (pair("CU", "CV"), pair("SU", "SV"), pair("near", "far"));
        let dp = number(&i["DP"]);
        let axes = ["u", "v", "n"].map(|a| vec3(&m[a]));
        let t = ViewingTransformation::new(vec3(&i["VRP"]), axes, center, half, dp, range);
        for (name, found) in [("A", t.a), ("B", t.b), ("C", t.c), ("D", t.d), ("P", t.p), ("M1", t.m1())] {
            assert_close(name, found, matrix4(&m[name]), tolerance);
        }
        let v = &i["viewport"];
        let side = |a: &str, b: &str| [number(&v[a]), number(&v[b])];
        let z = [number(&i["z_range"][0]), number(&i["z_range"][1])];
        let m2 = ViewingTransformation::m2(side("umin", "umax"), side("vmin", "vmax"), z);
        assert_close("M2", m2, matrix4(&m["M2"]), tolerance);
        // The camera is M1, in two parts.
        let camera = Camera {
            projection: Projection::Window {
                vrp: vec3(&i["VRP"]),
                p: vec3(&i["P"]),
                vup: vec3(&i["VUP"]),
                center,
                half,
                dp,
                near: range[0],
                far: range[1],
            },
            ..Camera::default()
        };
        let found = camera.matrices(1.0).unwrap();
        let m1 = found.projection * found.view;
        assert_close("projection view", m1, matrix4(&m["M1"]), tolerance);
        for corner in case["view_volume_corners"].as_array().unwrap() {
            let clip = m1 * vec3(&corner["world"]).extend(1.0);
            let off = (clip / clip.w - vec3(&corner["ndc"]).extend(1.0)).abs().max_element();
            assert!(off <= tolerance, "{corner}: off by {off}");
        }
        for p in case["points"].as_array().unwrap() {
            let clip = m1 * vec3(&p["world"]).extend(1.0);
            let screen = m2 * (clip / clip.w);
            for k in 0..3 {
                let wanted = number(&p["screen"][k]);
                assert!((screen[k] - wanted).abs() <= tolerance * wanted.abs().max(1.0), "{p}");
            }
            assert_eq!(
                [screen.x as i64, screen.y as i64].map(|v| v as f64),
                [0, 1].map(|k| number(&p["pixel"][k]))
            );
        }
    }
}

#[test]
fn golden_frustum_to_box() {
    let g = golden("seed004_frustum_to_box");
    let tolerance = number(&g["tolerance"]["absolute"]);
    for case in g["expected"].as_array().unwrap() {
        let (near, far) = (number(&case["near"]), number(&case["far"]));
        let (p, simple) = (proj::frustum_to_box(near, far), proj::simple_conical(near));
        assert_close("P", p, matrix4(&case["P"]), tolerance);
        assert_close("simple", simple, matrix4(&case["simple_conical"]), tolerance);
        for point in case["points"].as_array().unwrap() {
            for (m, name) in [(p, "P"), (simple, "simple")] {
                let h = m * vec3(&point["eye"]).extend(1.0);
                let off = (h.truncate() / h.w - vec3(&point[name]["projected"])).abs().max_element();
                assert!(off <= tolerance * 1000.0f64.max(far), "{name} {point}: {off}");
            }
        }
    }
}

#[test]
fn golden_parallel_projections() {
    let g = golden("seed004_parallel_projections");
    let tolerance = number(&g["tolerance"]["absolute"]);
    let drop_z = matrix::scale(DVec3::new(1.0, 1.0, 0.0));
    let degrees = |d: f64| d * std::f64::consts::PI / 180.0;
    let k = proj::pseudo_isometric_scale();
    let matrices = [
        ("plan_xy", DMat4::IDENTITY),
        ("cavalier_45", proj::oblique(1.0, degrees(45.0))),
        ("cavalier_60", proj::oblique(1.0, degrees(60.0))),
        ("cabinet_45", proj::oblique(0.5, degrees(45.0))),
        ("cabinet_60", proj::oblique(0.5, degrees(60.0))),
        ("isometric", proj::isometric()),
        ("pseudo_isometric_30", matrix::scale(DVec3::new(k, k, 1.0)) * proj::isometric()),
    ];
    let cases = g["expected"].as_array().unwrap();
    for (name, m) in matrices {
        let case = cases.iter().find(|c| c["name"] == name).unwrap();
        assert_close(name, drop_z * m, matrix4(&case["matrix"]), tolerance);
        for p in case["unit_cube"].as_array().unwrap() {
            let q = (drop_z * m).transform_point3(vec3(&p["p"]));
            assert!((q.x - number(&p["projected"][0])).abs() <= tolerance, "{name} {p}");
            assert!((q.y - number(&p["projected"][1])).abs() <= tolerance, "{name} {p}");
        }
    }
}

#[test]
fn golden_linear_transforms() {
    let g = golden("seed004_linear_transforms");
    let tolerance = number(&g["tolerance"]["absolute"]);
    for r in g["expected"]["rotations"].as_array().unwrap() {
        let angle = number(&r["q_deg"]) * std::f64::consts::PI / 180.0;
        let m = matrix::rotate(DVec3::Z, angle).unwrap();
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            assert!((m.row(row)[column] - number(&r["rotation"][row][column])).abs() <= tolerance, "{r}");
            let back = number(&r["basis_change_by_same_angle"][row][column]);
            assert!((m.transpose().row(row)[column] - back).abs() <= tolerance, "{r}");
        }
    }
    let angle = number(&g["inputs"]["axis_angle_deg"]) * std::f64::consts::PI / 180.0;
    let m = matrix::rotate(vec3(&g["inputs"]["axis"]), angle).unwrap();
    for (row, column) in (0..9).map(|i| (i / 3, i % 3)) {
        let wanted = number(&g["expected"]["axis_rotation"][row][column]);
        assert!((m.row(row)[column] - wanted).abs() <= tolerance, "{row} {column}");
    }
}

fn projections() -> Vec<Projection> {
    let (window, near, far) = ([-2.0, 3.0, -1.5, 1.0], 0.5, 40.0);
    let oblique = |kind| Projection::Oblique { kind, angle_rad: 0.7, window, near, far };
    vec![
        Projection::Perspective { fov_rad: 1.0, near, far, on_smaller_side: false },
        Projection::Perspective { fov_rad: 1.0, near, far, on_smaller_side: true },
        Projection::Plane { d: 2.0, near, far },
        Projection::Frustum { window, near, far },
        Projection::Ortho { window, near, far },
        oblique(ObliqueKind::Cavalier),
        oblique(ObliqueKind::Cabinet),
        Projection::Isometric { window, near, far },
        Projection::PseudoIsometric { window, near, far },
        Projection::Window {
            vrp: DVec3::new(4.0, 1.0, 3.0),
            p: DVec3::ZERO,
            vup: DVec3::Y,
            center: [0.2, -0.1],
            half: [1.0, 2.0],
            dp: 3.0,
            near,
            far,
        },
    ]
}

#[test]
fn z_runs_from_0_at_near_to_1_at_far_and_its_complement_agrees() {
    let look_at = look_at(DVec3::new(1.0, 2.0, 5.0), DVec3::new(0.0, 0.5, 0.0), DVec3::Y);
    for projection in projections() {
        let m = Camera { look_at, projection }.matrices(0.75).unwrap();
        let z = |view_z: f64| {
            let p = DVec4::new(0.3, -0.2, view_z, 1.0);
            let clip = m.projection * p;
            (clip.z / clip.w, m.one_minus_z_row.dot(p) / clip.w, clip.w)
        };
        assert_eq!((z(-0.5).0, z(-40.0).1), (0.0, 0.0), "{projection:?}");
        assert!((z(-0.5).2 - m.w_near).abs() < 1e-16, "{projection:?}");
        for view_z in [-0.5, -0.51, -3.0, -17.0, -40.0] {
            let (z, complement, w) = z(view_z);
            assert!((z + complement - 1.0).abs() < 1e-14 && w > 0.0, "{projection:?} at {view_z}");
        }
        assert_eq!(m.is_parallel, z(-3.0).2 == 1.0 && z(-9.0).2 == 1.0);
        assert!((m.to_viewer.length() - 1.0).abs() < 1e-15);
    }
}

#[test]
fn what_lies_on_the_projections_direction_falls_together() {
    let look_at = look_at(DVec3::new(1.0, 2.0, 5.0), DVec3::new(0.0, 0.5, 0.0), DVec3::Y);
    for projection in projections() {
        let m = Camera { look_at, projection }.matrices(1.0).unwrap();
        let p = DVec3::new(0.4, 0.3, -0.6);
        let to_viewer = if m.is_parallel { m.to_viewer } else { matrix::unit(m.eye - p).unwrap() };
        let ndc = |p: DVec3| {
            let clip = m.projection * (m.view * p.extend(1.0));
            clip.truncate() / clip.w
        };
        let (a, b) = (ndc(p), ndc(p + to_viewer));
        assert!((a - b).truncate().length() < 1e-13, "{projection:?}");
        assert!(b.z < a.z, "nearer to the viewer is less deep: {projection:?}");
    }
}

#[test]
fn fovmin_is_on_the_smaller_side() {
    let camera = |on_smaller_side| Camera {
        projection: Projection::Perspective { fov_rad: 1.0, near: 1.0, far: 2.0, on_smaller_side },
        ..Camera::default()
    };
    let k = 1.0 / libm::tan(0.5);
    let scale = |smaller, aspect| {
        let p = camera(smaller).matrices(aspect).unwrap().projection;
        (p.x_axis.x, p.y_axis.y)
    };
    assert_eq!(scale(false, 2.0), (k / 2.0, k));
    assert_eq!(scale(true, 2.0), (k / 2.0, k));
    assert_eq!(scale(false, 0.5), (k / 0.5, k));
    assert_eq!(scale(true, 0.5), (k, k * 0.5));
}

#[test]
fn cameras_that_make_no_picture_are_refused() {
    let good = Camera::default();
    let with = |f: &dyn Fn(&mut Camera)| {
        let mut c = good;
        f(&mut c);
        c.matrices(1.0).unwrap_err()
    };
    assert_eq!(with(&|c| c.look_at.reference = c.look_at.eye), CameraError::NoDirection);
    assert_eq!(with(&|c| c.look_at.up = DVec3::Z), CameraError::BadUp);
    assert_eq!(with(&|c| c.look_at.up = DVec3::ZERO), CameraError::BadUp);
    let perspective = |fov_rad, near, far| {
        with(&|c| c.projection = Projection::Perspective { fov_rad, near, far, on_smaller_side: false })
    };
    assert!(matches!(perspective(0.0, 1.0, 2.0), CameraError::BadExtent { .. }));
    assert!(matches!(perspective(3.2, 1.0, 2.0), CameraError::BadExtent { .. }));
    for (near, far) in
        [(0.0, 2.0), (-1.0, 2.0), (2.0, 2.0), (3.0, 2.0), (f64::NAN, 2.0), (1.0, f64::INFINITY)]
    {
        assert!(matches!(perspective(1.0, near, far), CameraError::BadDepthRange { .. }), "{near} {far}");
    }
    let ortho = |window| with(&|c| c.projection = Projection::Ortho { window, near: -1.0, far: 1.0 });
    assert!(matches!(ortho([1.0, 1.0, 0.0, 1.0]), CameraError::BadExtent { what: "window width", .. }));
    assert!(matches!(ortho([0.0, 1.0, 2.0, 2.0]), CameraError::BadExtent { what: "window height", .. }));
    // A parallel box may begin behind the eye.
    let ortho = Projection::Ortho { window: [-1.0, 1.0, -1.0, 1.0], near: -1.0, far: 1.0 };
    assert!(Camera { projection: ortho, ..good }.matrices(1.0).is_ok());
}

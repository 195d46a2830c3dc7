//! Tests that a trace equals the memory's contents, and reproduces the numbers printed in the
//! notes.

use super::*;
use crate::pipeline::{draw, draw_scene, golden};
use crate::scene::{
    Background, Camera, Filter, Geometry, Light, LookAt, Mesh, Object, Projection, Sampling, Texture,
};
use crate::scene::{Viewport, shapes};
use glam::dvec3;

fn camera(eye: DVec3, projection: Projection) -> Camera {
    Camera { look_at: LookAt { eye, reference: DVec3::ZERO, up: DVec3::Y }, projection }
}

fn perspective(near: f64, far: f64) -> Projection {
    Projection::Perspective { fov_rad: std::f64::consts::FRAC_PI_4, near, far, on_smaller_side: true }
}

/// The red and the blue triangle of notes 003.
fn two_triangles() -> Scene {
    let file = golden("seed003_tables_opaque");
    let object = |given: &serde_json::Value| {
        let list = |v: &serde_json::Value| DVec3::from_slice(&numbers(v));
        let points = given["points"].as_array().expect("points").iter().map(list).collect();
        Object {
            name: given["name"].as_str().expect("a name").to_owned(),
            geometry: std::sync::Arc::new(Geometry {
                mesh: Mesh::from_triangles(points, &[[0, 1, 2]]),
                ..Default::default()
            }),
            model: DMat4::from_translation(list(&given["translation"])),
            material: Material { emissive: list(&given["emissive"]), kd: DVec3::ZERO, ..Default::default() },
            back_material: None,
            cull: crate::scene::Cull::None,
            two_sided_lighting: false,
            shade: None,
            texture: None,
            lights: None,
            light_error: None,
            style: Default::default(),
        }
    };
    Scene {
        camera: Some(camera(dvec3(0.0, 0.0, 8.0), perspective(5.0, 10.0))),
        background: Background { color: Some(DVec3::ZERO) },
        objects: file["inputs"]["objects_in_order"].as_array().expect("objects").iter().map(object).collect(),
        ..Scene::default()
    }
}

fn numbers(v: &serde_json::Value) -> Vec<f64> {
    v.as_array().expect("numbers").iter().map(|n| n.as_f64().expect("a number")).collect()
}

#[test]
fn the_depths_of_notes_003_come_out_of_it() {
    let options = SceneOptions::new(12, 10);
    let scene = two_triangles();
    let mut count = 0;
    for (number, distance) in [(0, 8.0), (1, 9.0)] {
        for expected in golden("seed003_depth_values")["expected"].as_array().expect("cases") {
            let (near, far) = (expected["near"].as_f64().expect("n"), expected["far"].as_f64().expect("f"));
            if expected["view_distance"].as_f64() != Some(distance) {
                continue;
            }
            let scene =
                Scene { camera: Some(camera(dvec3(0.0, 0.0, 8.0), perspective(near, far))), ..scene.clone() };
            for (format, key) in [(DepthFormat::U16, "u16"), (DepthFormat::U32, "u32")] {
                let trace = trace_scene(&scene, &options, [12, 10], format, Probe::Triangle(number))
                    .expect("there is such a triangle");
                let pixel = trace.pixel.expect("some of it is seen");
                assert!((pixel.z - expected["normalised"].as_f64().expect("z")).abs() < 1e-12);
                assert_eq!(u64::from(pixel.depth_word), expected[key].as_u64().expect("a word"), "{key}");
                count += 1;
            }
        }
    }
    assert!(count >= 8, "{count} depths");
}

#[test]
fn a_pixel_is_followed_to_the_triangle_that_is_seen_there() {
    let (scene, options) = (two_triangles(), SceneOptions::new(12, 10));
    let mut memory = VideoMemory::new(12, 10).expect("a frame");
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    draw_scene(&mut target, &scene, &options).expect("drawn");
    let mut seen = [0; 2];
    for (x, y) in (0..10).flat_map(|y| (0..12).map(move |x| (x, y))) {
        let stored = memory.get_pixel(x, y).expect("on the frame");
        match trace_scene(&scene, &options, [12, 10], DepthFormat::F32, Probe::Pixel(x, y)) {
            Ok(trace) => {
                seen[trace.object.0] += 1;
                let pixel = trace.pixel.expect("it is seen");
                assert_eq!(pixel.bytes, stored, "({x}, {y})");
                assert!(pixel.is_covered);
                assert_eq!(pixel.offset, Some(FbPtr::of_pixel(12, x as u32, y as u32)));
            }
            Err(e) => {
                assert!(matches!(e, TraceError::NothingThere { .. }), "{e}");
                assert_eq!(stored, [0, 0, 0, 255], "({x}, {y})");
            }
        }
    }
    assert!(seen[0] > 10 && seen[1] > 10, "{seen:?}");
}

#[test]
fn the_corners_of_notes_001_come_out_of_it() {
    let file = golden("seed001_pipeline_matrices");
    let case = &file["inputs"]["cases"][0];
    let expected = &file["expected"][0];
    let d = case["d"].as_f64().expect("d");
    let eye = DVec3::from_slice(&numbers(&case["eye"]));
    let mesh =
        Mesh::from_triangles(vec![dvec3(-1., -1., 1.), dvec3(1., -1., 1.), dvec3(1., 1., 1.)], &[[0, 1, 2]]);
    let geometry = Geometry { mesh, ..Default::default() };
    let material = Material::default();
    let plane = Projection::Plane { d, near: 0.1, far: 100.0 };
    let viewport =
        Viewport { x: 0, y: 0, width: 512, height: 512, rule: crate::scene::ViewportRule::Centres };
    let call =
        DrawCall { camera: camera(eye, plane), viewport, ..DrawCall::new(&geometry, &material, 512, 512) };
    let trace =
        trace_draw(&call, [512, 512], DepthFormat::F32, Probe::Triangle(0)).expect("there is one triangle");
    // Points 1, 5 and 7 of the file are the triangle's corners.
    let points = expected["points"].as_array().expect("points");
    for (corner, i) in trace.corners.iter().zip([1, 5, 7]) {
        let (screen, clip) = (numbers(&points[i]["screen"]), numbers(&points[i]["clip"]));
        assert!((corner.clip.x - clip[0]).abs() < 1e-12 && (corner.clip.w - clip[3]).abs() < 1e-12);
        for axis in 0..2 {
            // The notes put pixel centres at integers.
            assert!(
                (corner.screen[axis] - 0.5 - screen[axis]).abs() < 1e-9,
                "{:?} {screen:?}",
                corner.screen
            );
        }
    }
}

#[test]
fn a_corner_behind_the_eye_has_no_ndc() {
    let points = vec![dvec3(-1.0, 0.0, 0.0), dvec3(1.0, 0.0, 0.0), dvec3(0.0, 1.0, 9.0)];
    let geometry = Geometry { mesh: Mesh::from_triangles(points, &[[0, 1, 2]]), ..Default::default() };
    let material = Material::default();
    let call = DrawCall {
        camera: camera(dvec3(0.0, 0.0, 5.0), perspective(1.0, 10.0)),
        cull: crate::scene::Cull::None,
        ..DrawCall::new(&geometry, &material, 64, 48)
    };
    let trace = trace_draw(&call, [64, 48], DepthFormat::F32, Probe::Triangle(0)).expect("a triangle");
    let text = trace.to_string();
    let corners: Vec<&str> = text.split("\ncorner ").skip(1).collect();
    assert_eq!(corners.len(), 3, "{text}");
    let is_behind = corners.iter().map(|corner| corner.contains("behind the eye")).collect::<Vec<_>>();
    assert_eq!(is_behind, [false, false, true], "{text}");
    assert!(corners[..2].iter().all(|corner| corner.contains("\n  NDC         (")), "{text}");
}

/// Draws and traces a lit, coloured knot under one shading mode; returns frame and trace.
fn knot(shade: ShadeMode, probe: Probe) -> (VideoMemory, Result<Trace, TraceError>) {
    let geometry = Geometry { mesh: shapes::knot(60, 10).expect("a knot"), ..Default::default() };
    let material = Material {
        ka: DVec3::splat(0.1),
        kd: dvec3(0.8, 0.4, 0.2),
        ks: DVec3::splat(0.5),
        n: 32.0,
        ..Default::default()
    };
    let lights = [Light::point(dvec3(3.0, 4.0, 5.0), DVec3::ONE)];
    let call = DrawCall {
        camera: camera(dvec3(0.0, 0.0, 5.2), perspective(1.0, 10.0)),
        ambient: DVec3::ONE,
        lights: &lights,
        shade,
        ..DrawCall::new(&geometry, &material, 64, 48)
    };
    let mut memory = VideoMemory::new(64, 48).expect("a frame");
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    draw(&mut target, &call).expect("drawn");
    (memory, trace_draw(&call, [64, 48], DepthFormat::F32, probe))
}

#[test]
fn every_shading_mode_ends_in_the_byte_that_is_stored() {
    for shade in [ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong] {
        let mut count = 0;
        for at in [[32, 20], [20, 24], [40, 30], [25, 15], [44, 22], [30, 33]] {
            let (memory, trace) = knot(shade, Probe::Pixel(at[0], at[1]));
            let Ok(trace) = trace else { continue };
            let pixel = trace.pixel.as_ref().expect("it is seen");
            assert_eq!(
                pixel.bytes,
                memory.get_pixel(at[0], at[1]).expect("on it"),
                "{shade:?} {at:?}\n{trace}"
            );
            // The terms add up to the light that is used.
            for lit in &pixel.lit {
                let sum = |part: fn(&LightTerm) -> DVec3| lit.terms.iter().map(part).sum::<DVec3>();
                let base = trace.material.ka * trace.ambient + sum(|t| t.ambient) + sum(|t| t.diffuse);
                assert!(
                    (base - lit.diffuse_ambient).abs().max_element() < 1e-15
                        && sum(|t| t.specular) == lit.specular_emissive
                );
            }
            let text = trace.to_string();
            for word in
                ["object", "world", "eye", "clip", "NDC", "snapped", "edges", "N.L", "bytes", "FBptr["]
            {
                assert!(text.contains(word), "{word}\n{text}");
            }
            // The tile renderer's values agree within its limits.
            let fast = trace.fast.as_ref().expect("there is always one");
            assert_eq!(fast.unsupported_reason, None);
            let (z, bytes) = fast.stored.expect("the pixel is lit");
            let most = bytes.iter().zip(pixel.bytes).map(|(a, b)| a.abs_diff(b)).max();
            assert!(most <= Some(1) && (z.expect("a z-buffer") - pixel.z).abs() < 4e-7, "{trace}");
            for (record, corner) in fast.corners.iter().zip(&trace.corners) {
                for axis in 0..2 {
                    let off = corner.screen[axis] - f64::from(record.position_fixed[axis]) / 65536.0;
                    assert!((0.0..1.0 / 65536.0).contains(&off), "{off}");
                }
                assert!((f64::from(record.inverse_w) * corner.clip.w - 1.0).abs() < 1e-6);
            }
            count += 1;
        }
        assert!(count >= 3, "{shade:?}: {count} pixels of the knot");
    }
}

#[test]
fn barycentrics_are_the_edge_functions_over_the_area() {
    let seen = knot(ShadeMode::Phong, Probe::Pixel(20, 24)).1.expect("the knot is seen there");
    let trace = knot(ShadeMode::Phong, Probe::Triangle(u64::from(seen.triangle.0)))
        .1
        .expect("there is that triangle");
    let pixel = trace.pixel.as_ref().expect("it covers at least that pixel");
    let edges = pixel.edges.expect("near the frame");
    let area = trace.doubled_area.expect("near the frame").unsigned_abs() as f64;
    for (edge, weight) in edges.iter().zip(pixel.screen_weights) {
        // Snapping moves a corner by at most 1/512 pixel.
        assert!((*edge as f64 / area - weight).abs() < 0.02, "{trace}");
    }
    assert!(matches!(
        knot(ShadeMode::Phong, Probe::Triangle(1 << 40)).1,
        Err(TraceError::NoTriangle { asked, .. }) if asked == 1 << 40
    ));
    assert!(matches!(
        knot(ShadeMode::Phong, Probe::Pixel(i32::MIN, i32::MAX)).1,
        Err(TraceError::NothingThere { .. })
    ));
    let far = knot(ShadeMode::Phong, Probe::TriangleAt(3, i32::MAX, i32::MIN)).1.expect("a plane has no end");
    assert!(far.pixel.is_none_or(|p| p.offset.is_none() && !p.is_covered));
}

/// Traces a triangle with these corners before an eye at (0, 0, 5), near 1 and far 10.
fn trace_triangle(points: [DVec3; 3], normals: [DVec3; 3]) -> Trace {
    let mut mesh = Mesh::from_triangles(points.to_vec(), &[[0, 1, 2]]);
    mesh.normals = normals.to_vec();
    mesh.corners.iter_mut().zip(0..).for_each(|(corner, i)| corner.normal = i);
    let geometry = Geometry { mesh, ..Default::default() };
    let material = Material { kd: DVec3::ONE, ..Default::default() };
    let lights = [Light::point(dvec3(3.0, 4.0, 5.0), DVec3::ONE)];
    let call = DrawCall {
        camera: camera(dvec3(0.0, 0.0, 5.0), perspective(1.0, 10.0)),
        cull: crate::scene::Cull::None,
        lights: &lights,
        ..DrawCall::new(&geometry, &material, 64, 48)
    };
    trace_draw(&call, [64, 48], DepthFormat::F32, Probe::Triangle(0)).expect("a triangle")
}

#[test]
fn a_triangle_is_followed_at_the_middle_of_its_pixels() {
    let points = [dvec3(-1.5, -1.0, 0.0), dvec3(1.0, -1.2, 0.5), dvec3(0.2, 1.5, -0.5)];
    let normals = [dvec3(0.0, 0.0, 1.0), dvec3(0.6, 0.0, 0.8), dvec3(0.0, -0.8, 0.6)];
    let trace = trace_triangle(points, normals);
    let pixel = trace.pixel.as_ref().expect("it is seen");
    for axis in 0..2 {
        let centroid = trace.corners.iter().map(|corner| corner.screen[axis]).sum::<f64>() / 3.0;
        assert!((f64::from(pixel.at[axis]) + 0.5 - centroid).abs() <= 1.0, "{:?} {trace}", pixel.at);
    }
    let mean = (0..3).map(|i| trace.corners[i].normal * pixel.weights[i]).sum::<DVec3>();
    assert!((pixel.normal.expect("Phong") - mean).length() < 1e-12, "{trace}");
}

#[test]
fn the_matrices_of_notes_000_are_printed_and_the_sign_of_d_is_the_side() {
    // The first camera of the golden example `seed000_viewing_transformation`.
    let projection = Projection::Window {
        vrp: DVec3::new(0.0, 0.0, -10.0),
        p: DVec3::ZERO,
        vup: DVec3::Y,
        center: [0.0; 2],
        half: [4.0, 3.0],
        dp: 8.0,
        near: 4.0,
        far: 20.0,
    };
    let corners = [DVec3::new(-1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(1.0, -1.0, -1.0)];
    let mesh = Geometry {
        mesh: Mesh::from_triangles(corners.to_vec(), &[[0, 1, 2], [0, 2, 1]]),
        ..Default::default()
    };
    let material = Material::default();
    let mut call = DrawCall::new(&mesh, &material, 640, 480);
    call.camera.projection = projection;
    let trace = |face| trace_draw(&call, [640, 480], DepthFormat::F32, Probe::Triangle(face)).unwrap();
    let [front, back] = [trace(0), trace(1)];
    let text = front.to_string();
    for rows in [
        "A           (1, 0, 0, 0)\n              (0, 1, 0, 0)\n              (0, 0, 1, 10)",
        "B           (-1, 0, 0, 0)",
        "D           (0.1, 0, 0, 0)",
        "P           (1, 0, 0, 0)\n              (0, 1, 0, 0)\n              (0, 0, 1.25, -0.25)",
        "M1 (clip)   (-0.1, 0, 0, 0)",
        "M2 (screen) (320, 0, 0, 320)\n              (0, -240, 0, 240)",
    ] {
        assert!(text.contains(rows), "{rows}\n{text}");
    }
    for corner in &front.corners {
        let clip = front.m1() * corner.world.extend(1.0);
        assert!((clip - corner.clip).abs().max_element() < 1e-15);
        let screen = front.to_screen * (clip / clip.w);
        assert!((screen.x - corner.screen[0]).abs() + (screen.y - corner.screen[1]).abs() < 1e-11);
    }
    assert_eq!(front.eye_plane().unwrap().w, -back.eye_plane().unwrap().w);
    assert!(text.contains("D > 0: the eye is in front of it") == (front.verdict == "seen from its front"));
    assert!(back.to_string().contains("D < 0: the eye is behind it") != text.contains("D < 0"));
}

#[test]
fn corners_are_printed_in_clip_space_and_the_side_is_named() {
    let [a, b, c] = [dvec3(-1.0, -1.0, 0.0), dvec3(1.0, -1.0, 0.0), dvec3(0.0, 1.0, 0.0)];
    let behind = dvec3(0.0, 1.0, 9.0);
    for (points, verdict) in [
        ([a, b, c], "seen from its front"),
        ([b, a, c], "seen from its back"),
        ([a, b, behind], "seen from its front, cut before the eye"),
        ([b, a, behind], "seen from its back, cut before the eye"),
    ] {
        let trace = trace_triangle(points, [DVec3::Z; 3]);
        assert_eq!(trace.verdict, verdict);
        let text = trace.to_string();
        let clip = text.lines().filter_map(|line| line.strip_prefix("  clip        ("));
        let printed: Vec<f64> = clip
            .flat_map(|line| line.trim_end_matches(')').split(", "))
            .map(|number| number.parse().expect("a number"))
            .collect();
        let stored: Vec<f64> = trace.corners.iter().flat_map(|corner| corner.clip.to_array()).collect();
        assert_eq!(printed.len(), 12, "{text}");
        for (printed, stored) in printed.iter().zip(stored) {
            assert!((printed - stored).abs() <= 1e-9 * stored.abs(), "{printed} {stored}");
        }
    }
}

#[test]
fn a_textured_pixel_names_its_texel_and_a_transparent_one_its_opacity() {
    let mut mesh = Mesh::from_triangles(
        vec![dvec3(-1.5, -1.0, 0.0), dvec3(1.5, -1.0, 0.0), dvec3(0.0, 1.5, 0.0)],
        &[[0, 1, 2]],
    );
    mesh.texcoords = vec![DVec2::ZERO, DVec2::X, DVec2::Y];
    mesh.corners.iter_mut().zip(0..).for_each(|(corner, i)| corner.texcoord = i);
    let geometry = Geometry { mesh, ..Default::default() };
    // Columns of red, green, blue and white.
    let columns = [[200, 0, 0, 255], [0, 100, 0, 255], [0, 0, 50, 255], [255; 4]];
    let texture = Texture::new(4, 4, columns.repeat(4).concat()).expect("a texture");
    let material = Material { kd: DVec3::ONE, transparency: 0.25, ..Default::default() };
    let lights = [Light::directional(DVec3::NEG_Z, DVec3::ONE)];
    for (filter, at) in [Filter::Nearest, Filter::Bilinear, Filter::Trilinear]
        .iter()
        .flat_map(|filter| [[26, 26], [30, 28], [36, 26], [33, 20]].map(|at| (*filter, at)))
    {
        let call = DrawCall {
            camera: camera(dvec3(0.0, 0.0, 5.0), perspective(1.0, 10.0)),
            lights: &lights,
            texture: Some(&texture),
            sampling: Sampling { filter, ..Sampling::default() },
            ..DrawCall::new(&geometry, &material, 64, 48)
        };
        let (mut memory, mut depth) = (VideoMemory::new(64, 48).expect("a frame"), None);
        let depth_format = DepthFormat::F32;
        let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
        draw(&mut target, &call).expect("drawn");
        let trace =
            trace_draw(&call, [64, 48], depth_format, Probe::Pixel(at[0], at[1])).expect("it is seen");
        let pixel = trace.pixel.as_ref().expect("it is seen");
        assert_eq!(pixel.bytes, memory.get_pixel(at[0], at[1]).expect("on it"), "{filter:?} {at:?}\n{trace}");
        let texel = pixel.texel.as_ref().expect("it has a texture");
        let uv: DVec2 = (0..3).map(|i| trace.corners[i].texcoord.expect("given") * pixel.weights[i]).sum();
        assert!((texel.uv - uv).length() < 1e-12 && texel.size == [4, 4], "{trace}");
        if filter == Filter::Nearest {
            let column = columns[(uv.x * 4.0) as usize].map(|byte| f64::from(byte) / 255.0);
            assert_eq!(texel.color, column, "{trace}");
        }
        // A unit square of texture covers about 36 pixels a side: 4 texels are magnified.
        assert!(texel.level < 0.0, "{trace}");
        assert!((pixel.opacity - 0.75).abs() < 1e-12, "{trace}");
        let text = trace.to_string();
        assert!(text.contains("\n  texture     4x4 at ("), "{text}");
        assert!(text.contains("\n  opacity     0.75: the bytes are over black\n"), "{text}");
    }
}

//! Extreme positions of faces: through the eye plane, thin, far out, without area, mirrored, many.

use super::*;

fn see(points: [[f64; 3]; 3]) -> Drawn {
    let shiny = Material { ka: DVec3::ONE, ks: DVec3::splat(0.5), n: 9.0, ..Material::default() };
    let scene = scene(eye_at_origin(0.1, 50.0), vec![both_sides(triangle(points), shiny)]);
    for shade in [ShadeMode::Flat, ShadeMode::Gouraud] {
        draw_right(&scene, 40, &Settings { shade, ..Settings::default() });
    }
    draw_right(&scene, 40, &Settings::default())
}

#[test]
fn a_triangle_through_the_eye_plane_is_cut_in_front_of_the_eye() {
    // One corner behind, two behind, and a floor that runs from far ahead to far behind.
    for points in [
        [[0.0, 0.5, 3.0], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[0.0, 0.5, -3.0], [-2.0, -1.0, 4.0], [2.0, -1.0, 4.0]],
        [[-1000.0, -1.0, -1000.0], [1000.0, -1.0, -1000.0], [0.0, -1.0, 1000.0]],
        [[-1000.0, -1.0, 1000.0], [1000.0, -1.0, 1000.0], [0.0, -1.0, -1000.0]],
    ] {
        let drawn = see(points);
        assert!(drawn.lit_pixels() > 100, "{points:?}");
        assert_eq!(drawn.stats.faces_cut, 1);
    }
}

#[test]
fn w_of_0_and_next_to_0_divides_by_nothing() {
    // A corner on the eye plane, one at the eye itself, one 1e-300 in front of it, two on the eye
    // plane.
    for points in [
        [[0.0, 1.0, 0.0], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[0.0, 0.0, 0.0], [-2.0, -1.0, -4.0], [2.0, -1.5, -4.0]],
        [[0.5, 1.0, -1e-300], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[0.5, 1.0, -1e-12], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[-1.0, 0.2, 0.0], [2.0, 0.3, 0.0], [2.0, -1.0, -4.0]],
    ] {
        see(points);
    }
    // Wholly on the eye plane, wholly behind, and edge-on: nothing is drawn.
    for points in [
        [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[-1.0, 0.0, 1.0], [1.0, 0.0, 2.0], [0.0, 1.0, 1.0]],
        [[-1.0, 0.0, -1.0], [1.0, 0.0, -2.0], [0.0, 0.0, 4.0]],
    ] {
        assert_eq!(see(points).lit_pixels(), 0, "{points:?}");
    }
}

#[test]
fn all_six_planes_at_once_and_no_pixel_outside() {
    // Through the near, far, left, right, top and bottom planes, and the eye plane too.
    let wild = triangle([[-300.0, -280.0, -60.0], [320.0, 10.0, -55.0], [-3.0, 90.0, 20.0]]);
    let mut s = scene(eye_at_origin(0.5, 50.0), vec![both_sides(wild, glowing(DVec3::ONE))]);
    assert!(draw_right(&s, 48, &Settings::default()).lit_pixels() > 200);
    for rule in [ViewportRule::Corners, ViewportRule::Centres] {
        // Inside the frame, across its edges, and outside of it.
        for (x, y, width, height) in
            [(10, 12, 20, 17), (-9, 30, 30, 40), (100, 0, 20, 20), (3, 3, 1, 1), (3, 3, 0, 5)]
        {
            let viewport = Viewport { x, y, width, height, rule };
            let settings = Settings { viewport: Some(viewport), ..Settings::default() };
            let drawn = if width > 1 {
                draw_right(&s, 48, &settings)
            } else {
                draw(&s, 48, DepthFormat::F32, &settings)
            };
            for (px, py) in (0..48 * 48).map(|i| (i % 48, i / 48)) {
                let inside = (x..x + width as i32).contains(&px) && (y..y + height as i32).contains(&py);
                let lit = drawn.memory.get_pixel(px, py).unwrap() != VideoMemory::CLEAR;
                assert!(inside || !lit, "({px},{py}) is outside {viewport:?}");
            }
        }
    }
    // The largest possible viewport shows one colour, in no time.
    let huge =
        Viewport { x: i32::MIN, y: i32::MIN, width: u32::MAX, height: u32::MAX, rule: ViewportRule::Corners };
    s.objects[0].shade = Some(ShadeMode::Wire);
    let start = Instant::now();
    draw(&s, 48, DepthFormat::F32, &Settings { viewport: Some(huge), ..Settings::default() });
    assert!(start.elapsed() < Duration::from_secs(1));
}

#[test]
fn slivers_a_millionth_of_a_pixel_thin_and_a_billion_pixels_long() {
    let camera = pixel_camera(64);
    for thickness in [1e-6, 1e-3, 0.3] {
        for (dx, dy) in [(1e9, 3e8), (-1e9, 7e8), (1e9, 1.0)] {
            let points =
                [[-dx, -dy, -1.0], [dx, dy, -1.0], [dx - dy * thickness / 1e9, dy + thickness, -1.0]];
            let s = scene(camera, vec![both_sides(triangle(points), glowing(DVec3::ONE))]);
            let start = Instant::now();
            let drawn = draw(&s, 64, DepthFormat::F32, &Settings::default());
            assert!(start.elapsed() < Duration::from_millis(500));
            // Equal to exact coverage, pixel for pixel.
            let to_pixels = |p: [f64; 3]| [32.0 + p[0], 32.0 - p[1]];
            let exact = fbptr::math::coverage::SnappedTriangle::new(points.map(to_pixels));
            let mut count = 0;
            let frame = fbptr::math::coverage::PixelRect { x0: 0, y0: 0, x1: 64, y1: 64 };
            exact.for_each_span(frame, |y, xs| {
                for x in xs {
                    count += 1;
                    assert_eq!(drawn.memory.get_pixel(x, y).unwrap(), [255; 4]);
                }
            });
            assert_eq!(drawn.lit_pixels(), count);
        }
    }
}

#[test]
fn corners_at_1e30_cover_exactly_and_cost_what_is_seen() {
    // Two faces that share an edge through the frame, and together cover all of it.
    let far = 1e30;
    let mesh = |side: f64| triangle([[-far, -far, -2.0], [far, far, -2.0], [-side * far, side * far, -2.0]]);
    let objects = vec![both_sides(mesh(1.0), glowing(DVec3::X)), both_sides(mesh(-1.0), glowing(DVec3::Y))];
    let s = scene(pixel_camera(64), objects);
    let start = Instant::now();
    let settings = Settings { hide: HiddenSurface::None, ..Settings::default() };
    let drawn = draw(&s, 64, DepthFormat::F32, &settings);
    assert!(start.elapsed() < Duration::from_secs(1));
    assert_eq!((drawn.stats.pixels_written, drawn.lit_pixels()), (64 * 64, 64 * 64), "each pixel once");
    let drawn = draw(&s, 64, DepthFormat::U24, &Settings::default());
    // Both lie in the plane z = -2 of a box from 0 to -10.
    assert!(
        (0..64 * 64).all(|i| (drawn.depth.as_ref().unwrap().z(i % 64, i / 64).unwrap() - 0.2).abs() < 1e-7)
    );
    // Even further out only termination is promised.
    for far in [1e150, 1e200, 1e308] {
        let s = scene(
            eye_at_origin(0.1, 10.0),
            vec![both_sides(
                triangle([[-far, -far, -far], [far, -far, far], [0.0, far, -1.0]]),
                glowing(DVec3::X),
            )],
        );
        draw(&s, 16, DepthFormat::F32, &Settings::default());
    }
}

#[test]
fn faces_without_area_and_repeated_corners_draw_nothing() {
    let same = triangle([[0.0, 0.0, -2.0]; 3]);
    let line = triangle([[-1.0, -1.0, -2.0], [0.0, 0.0, -2.0], [1.0, 1.0, -2.0]]);
    let repeated = Mesh::from_triangles(triangle([[-1.0, 0.0, -2.0]; 3]).positions, &[[0, 0, 1], [2, 1, 2]]);
    for mesh in [same, line, repeated] {
        let s = scene(eye_at_origin(0.1, 50.0), vec![both_sides(mesh, Material::default())]);
        for shade in ShadeMode::ALL.iter().filter(|s| **s != ShadeMode::Wire) {
            let drawn = draw(&s, 32, DepthFormat::F32, &Settings { shade: *shade, ..Settings::default() });
            assert_eq!(drawn.stats.pixels_written, 0, "{shade:?}");
        }
    }
}

#[test]
fn positions_that_are_not_numbers_draw_nothing() {
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1.7e308] {
        let mesh = triangle([[bad, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, 1.0, -3.0]]);
        let material = Material { ks: DVec3::ONE, ..Material::default() };
        let s = scene(eye_at_origin(0.1, 50.0), vec![both_sides(mesh, material)]);
        for shade in ShadeMode::ALL {
            let drawn = draw(&s, 16, DepthFormat::F32, &Settings { shade: *shade, ..Settings::default() });
            assert_eq!(drawn.lit_pixels(), 0, "{bad} {shade:?}");
        }
    }
}

#[test]
fn meshes_of_none_one_and_many_faces_and_concave_ones() {
    let camera = eye_at_origin(0.1, 50.0);
    let empty = draw(
        &scene(camera, vec![both_sides(Mesh::default(), Material::default())]),
        16,
        DepthFormat::F32,
        &Settings::default(),
    );
    assert!(empty.depth.is_none() && empty.lit_pixels() == 0, "an empty mesh needs no depth");
    // An L of six corners: its notch stays open.
    let mut l = Mesh::default();
    let outline = [[-1.0, -1.0], [1.0, -1.0], [1.0, -0.2], [-0.2, -0.2], [-0.2, 1.0], [-1.0, 1.0]];
    l.positions = outline.map(|[x, y]| DVec3::new(x, y, -2.0)).to_vec();
    let corners =
        [0, 1, 2, 3, 4, 5].map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE });
    l.push_polygon(&corners, NONE);
    let drawn =
        draw_right(&scene(camera, vec![both_sides(l, glowing(DVec3::ONE))]), 40, &Settings::default());
    assert_eq!(drawn.memory.get_pixel(25, 15).unwrap(), VideoMemory::CLEAR, "the notch");
    assert_eq!(drawn.memory.get_pixel(13, 25).unwrap(), [255; 4]);
    // 200,000 faces smaller than a pixel, as one surface: no hole, and no pixel drawn twice.
    let mut sheet = terrain(317, 1.0, || 0.0);
    sheet.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 3.0, -p.z * 3.0, -3.0));
    let settings = Settings { hide: HiddenSurface::None, ..Settings::default() };
    let s = scene(camera, vec![both_sides(sheet, glowing(DVec3::ONE))]);
    let drawn = draw(&s, 128, DepthFormat::F32, &settings);
    assert_eq!(drawn.stats.faces, 2 * 317 * 317);
    assert_eq!((drawn.stats.pixels_written, drawn.lit_pixels()), (128 * 128, 128 * 128));
}

#[test]
fn a_mirrored_model_keeps_its_front_faces_front() {
    let mesh = fbptr::truth::scenes::box_mesh(DVec3::new(1.0, 0.7, 0.4));
    for scale in [DVec3::ONE, DVec3::new(-1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, 1.0), -DVec3::ONE] {
        let model = matrix::translate(DVec3::new(0.3, -0.2, -3.0))
            * matrix::rotate(DVec3::new(1.0, 2.0, 0.5), 0.9).unwrap()
            * matrix::scale(scale);
        let thing = Object { model, ..object("box", mesh.clone()) };
        let drawn = draw_right(&scene(eye_at_origin(0.1, 50.0), vec![thing]), 40, &Settings::default());
        // The nearest corner of the box is nearer than its middle, so the front is visible.
        let nearest =
            (0..1600).map(|i| drawn.depth.as_ref().unwrap().z(i % 40, i / 40).unwrap()).fold(1.0, f64::min);
        let depth_of = |d: f64| 50.0 * (d - 0.1) / (d * 49.9);
        assert!(nearest < depth_of(2.8), "{scale}: {nearest}");
    }
}

#[test]
fn the_screen_area_and_the_world_normal_agree_on_what_is_seen_from_behind() {
    let mut r = fbptr::truth::scenes::Random::new(77);
    for _ in 0..200 {
        let p: [DVec3; 3] = std::array::from_fn(|_| r.point(-2.0, 2.0) - 4.0 * DVec3::Z);
        let normal = (p[1] - p[0]).cross(p[2] - p[0]);
        let towards_eye = normal.dot(-p[0]);
        if towards_eye.abs() < 0.05 {
            continue;
        }
        let thing = Object {
            cull: Cull::Back,
            ..both_sides(Mesh::from_triangles(p.to_vec(), &[[0, 1, 2]]), glowing(DVec3::ONE))
        };
        let drawn =
            draw(&scene(eye_at_origin(0.1, 50.0), vec![thing]), 64, DepthFormat::F32, &Settings::default());
        assert_eq!(drawn.stats.faces_culled == 0, towards_eye > 0.0, "{p:?}");
    }
}

//! Every row of the specification's table of hard cases that a draw can meet, by name, held to the truth where it says more
//! than "no panic".

use fbptr::math::matrix;
use fbptr::memory::{DepthFormat, DepthMemory, VideoMemory};
use fbptr::pipeline::{self, DrawCall, DrawStats, SceneOptions, Target};
use fbptr::scene::*;
use fbptr::truth::compare::compare;
use fbptr::truth::scenes::{object, terrain};
use fbptr::truth::{Settings, Transparency, TruthPicture};
use glam::{DVec2, DVec3};
use std::sync::Arc;
use std::time::{Duration, Instant};

const ORIGIN_VIEW: LookAt = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };

/// A camera at the origin that looks along -z with an angle of 90 degrees.
fn eye_at_origin(near: f64, far: f64) -> Camera {
    let fov_rad = std::f64::consts::FRAC_PI_2;
    let projection = Projection::Perspective { fov_rad, near, far, on_smaller_side: false };
    Camera { look_at: ORIGIN_VIEW, projection }
}

/// A parallel camera under which x and y are pixels, y up from the middle of a frame of `size` pixels; z from 0 to -10.
fn pixel_camera(size: u32) -> Camera {
    let h = size as f64 / 2.0;
    Camera {
        look_at: ORIGIN_VIEW,
        projection: Projection::Ortho { window: [-h, h, -h, h], near: 0.0, far: 10.0 },
    }
}

fn glowing(color: DVec3) -> Material {
    Material { emissive: color, kd: DVec3::ZERO, ..Material::default() }
}

fn lamp(position: DVec3) -> Light {
    Light {
        kind: LightKind::Point { position, attenuation: Attenuation::NONE, radius: f64::INFINITY },
        color: DVec3::ONE,
        ambient: DVec3::ZERO,
        clamp_attenuation: false,
    }
}

fn triangle(points: [[f64; 3]; 3]) -> Mesh {
    Mesh::from_triangles(points.map(DVec3::from).to_vec(), &[[0, 1, 2]])
}

/// An object that is drawn from both sides.
fn both_sides(mesh: Mesh, material: Material) -> Object {
    Object { material, cull: Cull::None, ..object("thing", mesh) }
}

struct Drawn {
    memory: VideoMemory,
    depth: Option<DepthMemory>,
    stats: DrawStats,
}

impl Drawn {
    fn lit_pixels(&self) -> usize {
        self.memory.bytes().as_chunks::<4>().0.iter().filter(|p| p[..3] != [0; 3]).count()
    }
}

fn draw(scene: &Scene, size: u32, format: DepthFormat, settings: &Settings) -> Drawn {
    let mut memory = VideoMemory::new(size, size).unwrap();
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
    let mut options = SceneOptions::new(size, size);
    options.viewport = settings.viewport.unwrap_or(options.viewport);
    (options.shade, options.hide, options.interp) = (settings.shade, settings.hide, settings.interpolation);
    let stats = pipeline::draw_scene(&mut target, scene, &options).unwrap();
    Drawn { memory, depth, stats }
}

/// Draws a scene, and asks the truth about every pixel.
#[track_caller]
fn draw_right(scene: &Scene, size: u32, settings: &Settings) -> Drawn {
    let settings =
        Settings { transparency: Transparency::AfterOpaque(TransparencyOrder::FileOrder), ..*settings };
    let drawn = draw(scene, size, DepthFormat::F32, &settings);
    let mut truth = TruthPicture::new(size, size, DepthFormat::F32);
    truth.draw(scene, &settings).unwrap();
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth);
    assert!(report.is_right(), "{report}");
    drawn
}

fn scene(camera: Camera, objects: Vec<Object>) -> Scene {
    Scene {
        camera: Some(camera),
        ambient: DVec3::splat(0.3),
        lights: vec![lamp(DVec3::new(1.0, 2.0, 0.5))],
        objects,
        ..Scene::default()
    }
}

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
    // A corner on the eye plane, one at the eye itself, one 1e-300 in front of it, two on the eye plane.
    for points in [
        [[0.0, 1.0, 0.0], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[0.0, 0.0, 0.0], [-2.0, -1.0, -4.0], [2.0, -1.5, -4.0]],
        [[0.5, 1.0, -1e-300], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[0.5, 1.0, -1e-12], [-2.0, -1.0, -4.0], [2.0, -1.0, -4.0]],
        [[-1.0, 0.2, 0.0], [2.0, 0.3, 0.0], [2.0, -1.0, -4.0]],
    ] {
        see(points);
    }
    // Wholly on the eye plane, wholly behind, and edge on: nothing.
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
    // The largest viewport that there is shows one colour, in no time.
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
            // As exact coverage has it, pixel for pixel.
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
    // Even further out nothing is promised but the end.
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
fn zero_and_cancelling_normals_fall_back_to_the_faces() {
    let points = [[-1.0, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, 1.0, -3.0]];
    let plain = triangle(points);
    // The file's normals are zero; the same face twice, once turned over, cancels the mean; normals that cancel on the way.
    let mut zero = plain.clone();
    zero.normals = vec![DVec3::ZERO];
    zero.corners.iter_mut().for_each(|c| c.normal = 0);
    let turned = Mesh::from_triangles(plain.positions.clone(), &[[0, 1, 2], [0, 2, 1]]);
    let mut pictures = Vec::new();
    for mesh in [plain, zero, turned] {
        for shade in [ShadeMode::Gouraud, ShadeMode::Phong] {
            let one = Object { cull: Cull::Back, ..both_sides(mesh.clone(), Material::default()) };
            let s = scene(eye_at_origin(0.1, 50.0), vec![one]);
            pictures.push((
                shade,
                draw_right(&s, 32, &Settings { shade, ..Settings::default() }).memory.bytes().to_vec(),
            ));
        }
    }
    for (shade, picture) in &pictures {
        let first = pictures.iter().find(|p| p.0 == *shade).unwrap();
        assert!(*picture == first.1 && picture.iter().any(|&b| b != 0 && b != 255), "{shade:?}");
    }
}

#[test]
fn positions_that_are_not_numbers_draw_nothing() {
    for bad in [f64::NAN, f64::INFINITY, -f64::INFINITY, 1.7e308] {
        let mesh = triangle([[bad, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, 1.0, -3.0]]);
        let mut material = Material::default();
        material.ks = DVec3::ONE;
        let s = scene(eye_at_origin(0.1, 50.0), vec![both_sides(mesh, material)]);
        for shade in ShadeMode::ALL {
            draw(&s, 16, DepthFormat::F32, &Settings { shade: *shade, ..Settings::default() });
        }
    }
}

#[test]
fn near_and_far_from_1_to_100_000_and_beyond_order_what_theory_says() {
    // Two faces square to the view; the farther is drawn first, so it is hidden only where the format tells them apart.
    let seen_apart = |near: f64, far: f64, d: f64, apart: f64, format| {
        let face = |d: f64, color| {
            let w = 3.0 * d;
            both_sides(triangle([[-w, -w, -d], [w, -w, -d], [0.0, w, -d]]), glowing(color))
        };
        let objects = vec![face(d + apart, DVec3::X), face(d, DVec3::Y)];
        let drawn = draw(&scene(eye_at_origin(near, far), objects), 8, format, &Settings::default());
        drawn.memory.get_pixel(4, 4).unwrap() == [0, 255, 0, 255]
    };
    for (near, far, d) in [(0.01, 1000.0, 8.0), (0.01, 1000.0, 500.0), (1.0, 10.0, 5.0), (1e-4, 1e4, 1.0)] {
        // dz/dd of z = f (d - n) / (d (f - n)).
        let slope = far * near / (d * d * (far - near));
        for (format, steps) in [
            (DepthFormat::U16, 65535.0),
            (DepthFormat::U24, 16_777_215.0),
            (DepthFormat::U32, 4_294_967_295.0),
        ] {
            let step = 1.0 / (steps * slope);
            let wide = 1.2 * step;
            if d + wide < far {
                assert!(seen_apart(near, far, d, wide, format), "{format:?} {near} {far} at {d}");
            }
            assert!(
                !seen_apart(near, far, d, step * 1e-3, format) || step * 1e-3 < d * 1e-12,
                "{format:?} at {d}"
            );
        }
    }
    // 1 : 1e9, at a distance of 1e5: only the reversed format still sees a thousandth of the distance.
    assert!(seen_apart(1e-3, 1e6, 1e5, 100.0, DepthFormat::Reversed));
    assert!(!seen_apart(1e-3, 1e6, 1e5, 100.0, DepthFormat::F32));
    assert!(!seen_apart(1e-3, 1e6, 1e5, 100.0, DepthFormat::U16));
}

#[test]
fn of_coplanar_faces_the_first_drawn_stays_in_any_corner_order() {
    // Slanted, at odd places, through a turned camera; and of constant depth with other corners.
    let points = [[-0.93, -0.71, 0.37], [1.13, -0.57, -0.41], [0.19, 1.07, 0.83]].map(DVec3::from).to_vec();
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let mut camera = Camera::default();
    camera.look_at =
        LookAt { eye: DVec3::new(1.3, 0.7, 4.1), reference: DVec3::new(0.1, 0.0, 0.2), up: DVec3::Y };
    for format in DepthFormat::ALL {
        for order in orders {
            let first = both_sides(Mesh::from_triangles(points.clone(), &[[0, 1, 2]]), glowing(DVec3::X));
            let second = both_sides(Mesh::from_triangles(points.clone(), &[order]), glowing(DVec3::Y));
            let drawn = draw(&scene(camera, vec![first, second]), 64, format, &Settings::default());
            let pixels = drawn.memory.bytes().as_chunks::<4>().0;
            assert!(pixels.iter().all(|p| p[1] == 0), "{format:?} {order:?}");
            assert!(drawn.lit_pixels() > 200);
        }
    }
    let flat = |seed: f64| triangle([[-3.0 * seed, -2.0, -2.7], [3.0, -2.0 - seed, -2.7], [seed, 4.0, -2.7]]);
    for format in DepthFormat::ALL {
        let objects =
            vec![both_sides(flat(1.0), glowing(DVec3::X)), both_sides(flat(1.37), glowing(DVec3::Y))];
        let drawn = draw(&scene(eye_at_origin(0.3, 70.0), objects), 40, format, &Settings::default());
        // Where the first is not, the second may be: but nowhere over the first.
        let alone = draw(
            &scene(eye_at_origin(0.3, 70.0), vec![both_sides(flat(1.0), glowing(DVec3::X))]),
            40,
            format,
            &Settings::default(),
        );
        for (a, b) in
            drawn.memory.bytes().as_chunks::<4>().0.iter().zip(alone.memory.bytes().as_chunks::<4>().0)
        {
            assert!(b[0] == 0 || a == b, "{format:?}");
        }
    }
}

#[test]
fn exponents_and_lights_in_odd_places_stay_finite_and_in_range() {
    let points = [[-1.0, -1.0, -3.0], [1.0, -1.0, -3.2], [0.0, 1.0, -2.8]];
    for n in [0.0, 1.0, 1e6] {
        // In front, on the surface at a corner, behind it, at the eye, at a tiny distance, and far away.
        for position in [
            [0.0, 0.0, -1.0],
            points[0],
            [0.0, 0.0, -9.0],
            [0.0; 3],
            [0.0, 0.0, -2.9999999999],
            [1e200, 1e200, 0.0],
        ] {
            for model in [LightingModel::Phong, LightingModel::Blinn] {
                let material = Material { ks: DVec3::ONE, n, model, ..Material::default() };
                let mut s = scene(eye_at_origin(0.1, 50.0), vec![both_sides(triangle(points), material)]);
                s.lights = vec![lamp(DVec3::from(position))];
                for shade in [ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong] {
                    draw_right(&s, 24, &Settings { shade, ..Settings::default() });
                }
            }
        }
    }
}

/// A picture of noise, the same on every machine.
fn noise(width: u32, height: u32) -> Arc<Texture> {
    let mut state = 12345u32;
    let bytes = (0..width * height).flat_map(|_| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        [(state >> 24) as u8, (state >> 16) as u8, (state >> 8) as u8, 255]
    });
    Arc::new(Texture::new(width, height, bytes.collect()).unwrap())
}

fn textured(mut mesh: Mesh, uv: [[f64; 2]; 3], texture: (u32, u32), sampling: Sampling) -> Scene {
    mesh.texcoords = uv.map(DVec2::from_array).to_vec();
    for (i, c) in mesh.corners.iter_mut().enumerate() {
        c.texcoord = i as u32;
    }
    let material = Material { ka: DVec3::ONE, kd: DVec3::ZERO, ..Material::default() };
    let thing =
        Object { texture: Some((noise(texture.0, texture.1), sampling)), ..both_sides(mesh, material) };
    Scene { ambient: DVec3::ONE, ..scene(eye_at_origin(0.1, 5000.0), vec![thing]) }
}

#[test]
fn texture_coordinates_of_ten_million_and_negative_ones_do_not_wobble() {
    let points = [[-2.0, -2.0, -3.0], [2.0, -2.0, -5.0], [0.0, 2.0, -4.0]];
    for filter in Filter::ALL {
        for wrap in Wrap::ALL {
            let sampling = Sampling { filter: *filter, wrap_s: *wrap, wrap_t: *wrap };
            for base in [0.0, -3.7, 1e7, -1e7] {
                let uv = [[base, base], [base + 1.5, base + 0.25], [base + 0.5, base + 2.0]];
                let s = textured(triangle(points), uv, (16, 16), sampling);
                assert!(draw_right(&s, 32, &Settings::default()).lit_pixels() > 100);
            }
            let s = textured(triangle(points), [[-1e8, 0.0], [1e8, 1e8], [0.0, -1e8]], (16, 16), sampling);
            draw(&s, 32, DepthFormat::F32, &Settings::default());
        }
    }
}

#[test]
fn a_floor_to_the_horizon_takes_the_top_level() {
    let floor = [[-4000.0, -1.0, -4900.0], [4000.0, -1.0, -4900.0], [0.0, -1.0, 900.0]];
    for filter in Filter::ALL {
        let sampling = Sampling { filter: *filter, ..Sampling::default() };
        let uv = [[-2000.0, -2450.0], [2000.0, -2450.0], [0.0, 450.0]];
        let s = textured(triangle(floor), uv, (32, 32), sampling);
        let drawn = draw_right(&s, 40, &Settings::default());
        assert!(drawn.lit_pixels() > 500 && drawn.stats.faces_cut == 1);
    }
}

#[test]
fn textures_of_one_texel_one_row_and_odd_sizes_are_read_inside() {
    let points = [[-2.0, -2.0, -3.0], [2.0, -2.0, -5.0], [0.0, 2.0, -4.0]];
    for size in [(1, 1), (1, 9), (7, 1), (5, 3), (33, 17)] {
        for filter in Filter::ALL {
            let sampling = Sampling { filter: *filter, ..Sampling::default() };
            let uv = [[-1.2, 0.3], [4.1, 0.0], [1.0, 3.3]];
            draw_right(&textured(triangle(points), uv, size, sampling), 32, &Settings::default());
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
    // 200,000 faces smaller than a pixel: as one sheet, without a hole and without a pixel drawn twice.
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
        // The nearest corner of the box is nearer than its middle, so its front is what is seen.
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

/// A scene with a piece of everything: floor and soup, textures, lights of each kind, glass, fog.
fn everything() -> Scene {
    let mut r = fbptr::truth::scenes::Random::new(2026);
    let mut floor = terrain(9, 12.0, || r.real(-0.1, 0.1));
    floor.positions.iter_mut().for_each(|p| *p = DVec3::new(p.x * 9.0, p.y - 1.0, p.z * 9.0 - 3.0));
    let soup: Vec<DVec3> = (0..60).map(|_| r.point(-2.5, 2.5) - 4.0 * DVec3::Z).collect();
    let faces: Vec<[u32; 3]> = (0..20).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let shiny = Material { ka: DVec3::ONE, ks: DVec3::splat(0.7), n: 37.0, ..Material::default() };
    let glass = Material { transparency: 0.4, model: LightingModel::Blinn, ..shiny.clone() };
    let sampling = Sampling { filter: Filter::Trilinear, ..Sampling::default() };
    let spot = LightKind::X3dSpot {
        position: DVec3::new(-1.0, 3.0, -3.0),
        direction: DVec3::new(0.2, -1.0, -0.3),
        beam_width_rad: 0.3,
        cut_off_rad: 0.7,
        attenuation: Attenuation { c: 0.2, l: 0.1, q: 0.01 },
        radius: 20.0,
    };
    let turn = matrix::rotate(DVec3::new(1.0, 2.0, 3.0), 0.7).unwrap();
    let objects = vec![
        Object { texture: Some((noise(37, 16), sampling)), ..both_sides(floor, shiny.clone()) },
        both_sides(Mesh::from_triangles(soup, &faces), glass),
        Object {
            model: matrix::translate(DVec3::new(0.5, 0.0, -4.0)) * turn,
            shade: Some(ShadeMode::Gouraud),
            ..object("box", fbptr::truth::scenes::box_mesh(DVec3::new(0.9, 0.6, 0.7)))
        },
    ];
    let mut s = scene(eye_at_origin(0.1, 60.0), objects);
    let direction = DVec3::new(0.4, -1.0, -0.8);
    s.lights.push(Light { kind: spot, clamp_attenuation: true, ..lamp(DVec3::ZERO) });
    s.lights.push(Light {
        kind: LightKind::Directional { direction },
        color: DVec3::new(0.1, 0.3, 0.6),
        ..lamp(DVec3::ZERO)
    });
    s.fog =
        Some(Fog { color: DVec3::new(0.5, 0.6, 0.7), kind: FogKind::Exponential, visibility_range: 30.0 });
    s.background.color = Some(DVec3::new(0.05, 0.1, 0.2));
    s
}

#[test]
fn the_same_bytes_every_time_and_on_every_machine() {
    let s = everything();
    let mut hasher = crc32fast::Hasher::new();
    for format in DepthFormat::ALL {
        for shade in [ShadeMode::Flat, ShadeMode::Phong] {
            let drawn = draw(&s, 96, format, &Settings { shade, ..Settings::default() });
            hasher.update(drawn.memory.bytes());
            (0..96 * 96).for_each(|i| hasher.update(&drawn.depth.as_ref().unwrap().word(i).to_le_bytes()));
        }
    }
    // Not measured against anything: what this code gave on x86-64. Any machine must give the same.
    assert_eq!(hasher.finalize(), 3_312_621_451);
    draw_right(&s, 64, &Settings::default());
}

#[test]
fn a_draw_of_a_whole_frame_takes_time_by_its_pixels() {
    // 64 layers of the whole frame, each nearer: the cost is in the pixels, so in a test build it is a few hundred ns each.
    let geometry = Geometry {
        mesh: triangle([[-9.0, -9.0, -2.0], [9.0, -9.0, -2.0], [0.0, 18.0, -2.0]]),
        textures: Vec::new(),
    };
    let material = glowing(DVec3::ONE);
    let mut memory = VideoMemory::new(128, 128).unwrap();
    let mut depth = None;
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
    let mut written = 0;
    for layer in 0..64 {
        let call = DrawCall {
            camera: eye_at_origin(0.1, 50.0),
            model: matrix::translate(DVec3::Z * (layer as f64 / 100.0)),
            ..DrawCall::new(&geometry, &material, 128, 128)
        };
        written += pipeline::draw(&mut target, &call).unwrap().pixels_written;
    }
    assert_eq!(written, 64 * 128 * 128);
}

//! Depths and colours at their limits.

use super::*;

#[test]
fn zero_and_cancelling_normals_fall_back_to_the_faces() {
    let points = [[-1.0, -1.0, -3.0], [1.0, -1.0, -3.0], [0.0, 1.0, -3.0]];
    let plain = triangle(points);
    // The file's normals are zero; a face and its reverse, so that the mean cancels; interpolated
    // normals that cancel.
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
fn near_and_far_from_1_to_100_000_and_beyond_order_what_theory_says() {
    // Two faces perpendicular to the view; the farther is drawn first, so the nearer hides it only
    // if the format separates them.
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
    // 1 : 1e9, at a distance of 1e5: only the reversed format resolves a thousandth of the
    // distance.
    assert!(seen_apart(1e-3, 1e6, 1e5, 100.0, DepthFormat::Reversed));
    assert!(!seen_apart(1e-3, 1e6, 1e5, 100.0, DepthFormat::F32));
    assert!(!seen_apart(1e-3, 1e6, 1e5, 100.0, DepthFormat::U16));
}

#[test]
fn of_coplanar_faces_the_first_drawn_stays_in_any_corner_order() {
    // Slanted, at uneven coordinates, through a rotated camera; and of constant depth with other
    // corners.
    let points = [[-0.93, -0.71, 0.37], [1.13, -0.57, -0.41], [0.19, 1.07, 0.83]].map(DVec3::from).to_vec();
    let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
    let look_at =
        LookAt { eye: DVec3::new(1.3, 0.7, 4.1), reference: DVec3::new(0.1, 0.0, 0.2), up: DVec3::Y };
    let camera = Camera { look_at, ..Camera::default() };
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
        // The second may be drawn where the first is not, but nowhere over the first.
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
        // In front, on the surface at a corner, behind it, at the eye, at a tiny distance, and far
        // away.
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

//! Textures far from the origin, at the horizon, and of odd sizes.

use super::*;

/// Returns a texture of noise, equal on every machine.
pub fn noise(width: u32, height: u32) -> Arc<Texture> {
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
    let uv = [[-1.2, 0.3], [4.1, 0.0], [1.0, 3.3]];
    let wraps = [Wrap::Repeat, Wrap::Clamp];
    for size in [(1, 1), (1, 9), (7, 1), (5, 3), (33, 17)] {
        for (filter, (wrap_s, wrap_t)) in
            Filter::ALL.iter().flat_map(|f| wraps.iter().flat_map(move |s| wraps.map(|t| (f, (*s, t)))))
        {
            let sampling = Sampling { filter: *filter, wrap_s, wrap_t };
            // From both of its sides.
            for [a, b, c] in [[0, 1, 2], [1, 0, 2]] {
                let scene = textured(
                    triangle([points[a], points[b], points[c]]),
                    [uv[a], uv[b], uv[c]],
                    size,
                    sampling,
                );
                draw_right(&scene, 32, &Settings::default());
            }
        }
    }
}

//! Parts of the scenes: a camera, a material, a texture, a box.

use fbptr_core::math::matrix;
use fbptr_core::scene::{
    Camera, Corner, Filter, LookAt, Material, Mesh, NONE, Projection, Sampling, Texture, Wrap,
};
use glam::{DMat4, DVec2, DVec3};
use std::sync::Arc;

pub(super) fn perspective(eye: DVec3, reference: DVec3, near: f64, far: f64) -> Camera {
    Camera {
        look_at: LookAt { eye, reference, up: DVec3::Y },
        projection: Projection::Perspective { fov_rad: 1.2, near, far, on_smaller_side: false },
    }
}

pub(super) fn material(kd: DVec3) -> Material {
    Material { ka: kd * 0.3, kd, ks: DVec3::splat(0.3), n: 24.0, ..Material::default() }
}

pub(super) fn turned(axis: DVec3, angle_rad: f64) -> DMat4 {
    matrix::rotate(axis, angle_rad).expect("an axis has a direction")
}

/// Returns a texture of squares of two colours with fine noise, so that filters differ.
pub(super) fn texture(side: u32) -> Arc<Texture> {
    let texel = |x: u32, y: u32| {
        let square = if ((x >> 4) + (y >> 4)) & 1 == 1 { 210u8 } else { 90 };
        [square, square.wrapping_add(((x * 7) ^ (y * 13)) as u8 % 24), 255 - square, 255]
    };
    let bytes = (0..side).flat_map(|y| (0..side).flat_map(move |x| texel(x, y))).collect();
    Arc::new(Texture::new(side, side, bytes).expect("a texture of ordinary size"))
}

/// Returns a box of 12 faces with texture coordinates, with its front outside or inside.
pub(super) fn box_of(size: DVec3, repeats: f64, is_inside_out: bool) -> Mesh {
    let half = size * 0.5;
    let corner = |i: i32| DVec3::from([1, 2, 4].map(|bit| if i & bit != 0 { 1.0 } else { -1.0 })) * half;
    let outward = [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y];
    let uv = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut mesh = Mesh {
        positions: (0..8).map(corner).collect(),
        texcoords: uv.map(|uv| DVec2::from_array(uv) * repeats).to_vec(),
        // Each side has its own normal.
        normals: outward.map(|n| if is_inside_out { -n } else { n }).to_vec(),
        ..Mesh::default()
    };
    let sides = [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]];
    for (side, mut at) in sides.into_iter().enumerate() {
        if is_inside_out {
            at.reverse();
        }
        let corner =
            |k: usize| Corner { position: at[k], normal: side as u32, texcoord: k as u32, color: NONE };
        mesh.push_polygon(&[0, 1, 2, 3].map(corner), NONE);
    }
    mesh
}

pub(super) fn textured(texture: &Arc<Texture>, filter: Filter) -> Option<(Arc<Texture>, Sampling)> {
    Some((Arc::clone(texture), Sampling { filter, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat }))
}

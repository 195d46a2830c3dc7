//! X3D's Box.

use super::{ShapeError, corner, length};
use crate::scene::{Mesh, NONE};
use glam::{DVec2, DVec3};

/// Faces in order: front, back, right, left, top, bottom. Each: outward normal, and the right and
/// up directions of its texture. The sides are upright; the top has -z up, the bottom +z up.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::Z, DVec3::X, DVec3::Y],
    [DVec3::NEG_Z, DVec3::NEG_X, DVec3::Y],
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::NEG_X, DVec3::Z, DVec3::Y],
    [DVec3::Y, DVec3::X, DVec3::NEG_Z],
    [DVec3::NEG_Y, DVec3::X, DVec3::Z],
];

/// Creates a box of `size` x, y, z about the origin: 8 positions, 6 quads with flat normals, each
/// with the whole texture.
///
/// # Errors
/// If a size is not positive and finite.
pub fn cuboid(size: DVec3) -> Result<Mesh, ShapeError> {
    let half = DVec3::new(
        length("box size x", size.x)?,
        length("box size y", size.y)?,
        length("box size z", size.z)?,
    ) / 2.0;
    let mut mesh = Mesh::default();
    // Bits of a position's number: bit 0 is x, bit 1 is y, bit 2 is z; a set bit is the positive
    // side.
    for i in 0..8 {
        let side = |bit: u32| if i & bit != 0 { 1.0 } else { -1.0 };
        mesh.positions.push(half * DVec3::new(side(1), side(2), side(4)));
    }
    mesh.normals = FACES.iter().map(|f| f[0]).collect();
    mesh.texcoords = vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
    for (face, [normal, right, up]) in (0..).zip(FACES) {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(s, t)| {
            let p = normal + right * s + up * t;
            (p.x > 0.0) as u32 | ((p.y > 0.0) as u32) << 1 | ((p.z > 0.0) as u32) << 2
        });
        let polygon: [_; 4] = std::array::from_fn(|k| corner(corners[k], k as u32, face));
        mesh.push_polygon(&polygon, NONE);
    }
    Ok(mesh)
}

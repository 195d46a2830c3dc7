//! The options `-s`, `-o` and `-clamp` of `map_Kd`: scale, offset and clamping of a material's
//! texture.
//!
//! In: a mesh and the options of each material. Out: the mesh with texture coordinates s * uv + o
//! where a material has such options; faces of other materials that share a coordinate keep theirs.
//! Clamping is a property of the texture ([`fbptr_core::scene::Texture::clamped`]): it ends at 0 and 1
//! of the coordinates that come out here.
//!
//! Source: the MTL format 4.2, "Options for texture map statements".

use fbptr_core::scene::{Mesh, NONE};
use glam::DVec2;
use std::collections::HashMap;

/// Texture options of a material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Placement {
    pub(super) scale: DVec2,
    pub(super) offset: DVec2,
    pub(super) is_clamped: bool,
}

impl Default for Placement {
    fn default() -> Self {
        Placement { scale: DVec2::ONE, offset: DVec2::ZERO, is_clamped: false }
    }
}

impl Placement {
    /// Returns whether the options change texture coordinates.
    pub(super) fn moves(&self) -> bool {
        (self.scale, self.offset) != (DVec2::ONE, DVec2::ZERO)
    }
}

/// Returns the working memory in bytes that [`place`] needs.
pub(super) fn working_bytes(mesh: &Mesh) -> u64 {
    mesh.corners.len() as u64 * 96
}

/// Applies scale and offset to the texture coordinates of the mesh; materials share a changed
/// coordinate with no other material.
pub(super) fn place(mesh: &mut Mesh, placements: &[Placement]) {
    let mut moved: HashMap<(u32, u32), u32> = HashMap::new();
    for polygon in &mesh.polygons {
        let Some(placement) = placements.get(polygon.material as usize) else { continue };
        if !placement.moves() {
            continue;
        }
        let first = polygon.first_corner as usize;
        for corner in &mut mesh.corners[first..first + polygon.corner_count as usize] {
            if corner.texcoord == NONE {
                continue;
            }
            let at = mesh.texcoords[corner.texcoord as usize] * placement.scale + placement.offset;
            if !at.is_finite() {
                continue;
            }
            let next = mesh.texcoords.len() as u32;
            let number = *moved.entry((polygon.material, corner.texcoord)).or_insert(next);
            if number == next {
                mesh.texcoords.push(at);
            }
            corner.texcoord = number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::Corner;
    use glam::DVec3;

    #[test]
    fn coordinates_move_for_the_material_that_says_so_alone() {
        let corner = |texcoord| Corner { position: 0, normal: NONE, texcoord, color: NONE };
        let mut mesh = Mesh {
            positions: vec![DVec3::ZERO],
            texcoords: vec![DVec2::ZERO, DVec2::new(0.5, 1.0), DVec2::ONE],
            ..Mesh::default()
        };
        for material in [0, 1, NONE, 1] {
            mesh.push_polygon(&[0, 1, 2].map(corner), material);
        }
        let moved =
            Placement { scale: DVec2::new(2.0, 3.0), offset: DVec2::new(0.25, -1.0), is_clamped: true };
        let placements = [Placement { is_clamped: true, ..Placement::default() }, moved];
        place(&mut mesh, &placements);
        let of = |p: usize| {
            mesh.polygon_corners(p).iter().map(|c| mesh.texcoords[c.texcoord as usize]).collect::<Vec<_>>()
        };
        let before = [DVec2::ZERO, DVec2::new(0.5, 1.0), DVec2::ONE];
        let after = [DVec2::new(0.25, -1.0), DVec2::new(1.25, 2.0), DVec2::new(2.25, 2.0)];
        assert_eq!([of(0), of(1), of(2), of(3)], [before, after, before, after].map(Vec::from));
        assert_eq!(mesh.texcoords.len(), 6, "each moved coordinate once");
    }
}

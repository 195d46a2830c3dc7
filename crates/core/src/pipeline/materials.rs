//! Lights and materials of a draw call: what applies to a mesh and to each of its polygons.

use super::assemble::Facing;
use super::draw_call::DrawCall;
use super::light::{Lighting, PreparedLight, ViewerPosition};
use crate::scene::{Cull, Material, NONE, Polygon, Projection, Texture};

impl<'a> DrawCall<'a> {
    /// Returns the lights that reach this mesh, in a list recycled from another draw.
    pub(crate) fn lighting(&self, viewer: ViewerPosition, recycled: Vec<PreparedLight>) -> Lighting {
        match self.light_subset {
            None => Lighting::new_in(self.lights.iter(), self.ambient, viewer, recycled),
            Some(subset) => {
                let chosen = subset.iter().filter_map(|&i| self.lights.get(i as usize));
                Lighting::new_in(chosen, self.ambient, viewer, recycled)
            }
        }
    }

    /// Returns the material and texture of a polygon seen from one side. The back material comes
    /// first, then the polygon's own material, then the draw's; the texture is the polygon's own or
    /// the draw's.
    pub(crate) fn material_of(&self, polygon: &Polygon, side: Facing) -> (&'a Material, Option<&'a Texture>) {
        let texture = self.geometry.textures.get(polygon.material as usize).and_then(|t| t.as_deref());
        let material = match (side, self.back_material) {
            (Facing::Back, Some(back)) => back,
            _ => self.own_material(polygon.material),
        };
        (material, texture.or(self.texture))
    }

    /// Returns the material of line segment `number`: its own, or the draw's.
    pub(crate) fn material_of_line(&self, number: usize) -> &'a Material {
        self.own_material(self.geometry.mesh.line_materials.get(number).copied().unwrap_or(NONE))
    }

    /// Returns the material of point `number`: its own, or the draw's.
    pub(crate) fn material_of_point(&self, number: usize) -> &'a Material {
        self.own_material(self.geometry.mesh.point_materials.get(number).copied().unwrap_or(NONE))
    }

    /// Returns the mesh's material of an index, or the draw's if there is none.
    fn own_material(&self, index: u32) -> &'a Material {
        self.geometry.mesh.materials.get(index as usize).unwrap_or(self.material)
    }

    /// Returns whether a face with this material and texture can be transparent, vertex colours
    /// aside.
    pub(crate) fn is_transparent(material: &Material, texture: Option<&Texture>) -> bool {
        material.transparency > 0.0 || texture.is_some_and(Texture::has_alpha)
    }

    /// Returns the sides of faces that CULL leaves visible.
    pub(crate) fn sides(&self) -> &'static [Facing] {
        match self.cull {
            Cull::Back => &[Facing::Front],
            Cull::Front => &[Facing::Back],
            Cull::None => &[Facing::Front, Facing::Back],
        }
    }

    /// Returns whether the camera's projection is parallel, so that w is 1 everywhere.
    pub(crate) fn is_parallel(&self) -> bool {
        !matches!(
            self.camera.projection,
            Projection::Perspective { .. }
                | Projection::Plane { .. }
                | Projection::Frustum { .. }
                | Projection::Window { .. }
        )
    }
}

//! The reasons why vector kernels leave a draw to the reference: its states, and values out of range
//! for f32.
//!
//! In: a prepared draw with the plan of its stages, and its target. Out: a reason for the plan, or
//! none. Only the plan asks; whoever draws follows the plan.

use crate::pipeline::draw_call::Target;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shading_space::f32s;
use crate::pipeline::tile::{FRAME_LIMITS, FogParams};
use crate::scene::{Cull, FillStyle, HiddenSurface, Material, ShadeMode, Texture};
use glam::DVec3;

/// Maximum number of texels that a face may span; beyond, f32 cannot tell texels apart.
const LONGEST_RUN: f64 = 8192.0;

impl<'a> PreparedDraw<'a> {
    /// Returns the reason why the tile renderer does not support the draw; `None` if it does.
    pub fn unsupported_reason(&self, target: &Target) -> Option<&'static str> {
        let (call, parts, mesh) = (self.call, self.parts, &self.call.geometry.mesh);
        if mesh.triangles.is_empty() {
            return Some("no face");
        }
        if call.shade == ShadeMode::Wire {
            return Some("SHADE wire is drawn line by line");
        }
        if call.stages.is_some() {
            return Some("several textures are joined pixel by pixel");
        }
        if call.fill != FillStyle::default() {
            return Some("hatched faces, or faces without filling, have no fast form");
        }
        if call.hide == HiddenSurface::Painter {
            return Some("HIDE painter sorts its faces");
        }
        if parts.uses(Part::ReadBack) {
            return Some("transparent faces are blended one after the other");
        }
        if !is_sized(target) {
            return Some("the frame is too narrow, too wide or too high for vectors");
        }
        let is_lit = parts.uses(Part::LightVertices) || parts.uses(Part::LightFaces);
        // Faces with one colour each have a table of colours, lit or not.
        let has_tables = is_lit || (call.shade == ShadeMode::Flat && !mesh.colors.is_empty());
        if call.back_material.is_some() && call.cull == Cull::None && has_tables {
            return Some(
                "a material for faces seen from behind, coloured at vertices or faces, has no fast form",
            );
        }
        if call.two_sided_lighting && call.cull != Cull::Back && is_lit {
            return Some("two-sided light at vertices or faces has no fast form");
        }
        if mesh.triangles.len() >= 1 << 30 || mesh.corners.len() >= 1 << 30 {
            return Some("the mesh is too large for vectors");
        }
        self.out_of_range()
    }

    /// Returns the values that the tile renderer cannot represent, as a reason; `None` if it can.
    fn out_of_range(&self) -> Option<&'static str> {
        let space = &self.space;
        if self.transform().screen.clip.is_empty() {
            return Some("the viewport is outside the frame");
        }
        if !space.is_in_range {
            return Some("positions or the camera are out of range for f32");
        }
        if self.parts.uses(Part::Fog) && self.fog_params(space.point(self.transform().camera.eye)).is_none() {
            return Some("the fog is out of range for f32");
        }
        for (material, texture) in self.materials(&self.geometry_info.materials) {
            if !self.lighting.is_in_range(material, |p| space.point(p), |d| space.axes * d) {
                return Some("a material or a light is out of range for f32");
            }
            let texels = |t: &Texture| f64::from(t.width().max(t.height()));
            // A file may omit texture coordinates that the texture needs: such a face is drawn
            // without it.
            if texture.is_some_and(|t| self.geometry_info.texcoord_run * texels(t) > LONGEST_RUN) {
                return Some("texture coordinates are missing, or out of range for f32");
            }
        }
        None
    }

    /// Returns the reason why the vector kernels cannot draw the faces in submission order; `None`
    /// if they can.
    pub fn blended_unsupported_reason(&self, target: &Target) -> Option<&'static str> {
        let (call, space) = (self.call, &self.space);
        if call.geometry.mesh.triangles.is_empty() {
            return Some("no face");
        }
        if call.shade == ShadeMode::Wire {
            return Some("SHADE wire: the plain path hides its lines");
        }
        if call.stages.is_some() || call.fill != FillStyle::default() {
            return Some("several textures, or hatches: the plain path");
        }
        if call.maps.is_some() {
            return Some("maps of emission, normals or occlusion: the plain path");
        }
        if !is_sized(target) {
            return Some("the frame is too narrow, too wide or too high for vectors: the plain path");
        }
        let is_in_range = |(material, _): (&Material, _)| {
            !self.lighting.depends_on_point(material)
                || self.lighting.is_in_range(material, |p| p - space.origin, |d| d)
        };
        let has_range = space.is_in_range
            && (!self.parts.uses(Part::Fog) || self.fog_params(DVec3::ZERO).is_some())
            && (!self.parts.uses(Part::LightPixels)
                || self.materials(&self.geometry_info.materials).all(is_in_range));
        (!has_range).then_some("positions, light or fog are out of range for f32: the plain path")
    }

    /// Returns the draw's fog seen from `eye`; `None` without fog, or if f32 does not carry it.
    pub(super) fn fog_params(&self, eye: DVec3) -> Option<FogParams> {
        let fog = self.call.fog.filter(|_| self.parts.uses(Part::Fog))?;
        FogParams::new(&fog, f32s(eye))
    }

    /// Iterates over the material and texture of each of these polygons on the sides that CULL
    /// leaves; once if both sides have the same.
    pub(super) fn materials(
        &self,
        polygons: &[u32],
    ) -> impl Iterator<Item = (&'a Material, Option<&'a Texture>)> {
        let call = self.call;
        let sides = if call.back_material.is_some() { call.sides() } else { &call.sides()[..1] };
        let of_side =
            move |side| polygons.iter().map(move |p| (side, &call.geometry.mesh.polygons[*p as usize]));
        sides.iter().flat_map(of_side).map(move |(side, polygon)| call.material_of(polygon, *side))
    }
}

/// Returns whether the frame's sides are within the limits of the vector kernels.
fn is_sized(target: &Target) -> bool {
    let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
    width >= FRAME_LIMITS.0 && width <= FRAME_LIMITS.1 && height <= FRAME_LIMITS.1
}

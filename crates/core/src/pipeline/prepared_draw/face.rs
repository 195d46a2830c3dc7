//! Per-face data of a prepared draw: corners, bounds, normals, and the inputs of its shading.

use super::PreparedDraw;
use crate::math::coverage::PixelRect;
use crate::pipeline::assemble::Facing;
use crate::pipeline::draw_call::{DrawCall, DrawStats};
use crate::pipeline::light::SurfacePoint;
use crate::pipeline::normals::polygon_normal;
use crate::pipeline::plan::Part;
use crate::pipeline::shade::{FaceShade, ShadingFrequency};
use crate::pipeline::surface_maps::FaceMaps;
use crate::pipeline::vertex::Vertex;
use crate::scene::{Corner, ShadeMode, TextureStages};
use glam::{DVec3, DVec4};

impl<'a> PreparedDraw<'a> {
    /// Returns the view z of a face's centre.
    pub fn center_z(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.corner_vertices(triangle).map(|v| v.view_z);
        (a + b + c) / 3.0
    }

    /// Returns the mesh corners of a triangle.
    pub fn corners(&self, triangle: u32) -> [&Corner; 3] {
        let mesh = &self.call.geometry.mesh;
        mesh.triangles[triangle as usize].map(|c| &mesh.corners[c as usize])
    }

    /// Returns the transformed vertices of a triangle.
    pub fn corner_vertices(&self, triangle: u32) -> [Vertex; 3] {
        self.corners(triangle).map(|c| self.vertex(c.position))
    }

    /// Returns a pixel rectangle, within the viewport, outside of which a triangle covers nothing.
    pub fn bounds_of(&self, triangle: u32) -> PixelRect {
        self.bounds_around(&self.corner_vertices(triangle))
    }

    /// Returns such a rectangle for the triangle with these corners; the viewport's if one is not
    /// finite.
    pub fn bounds_around(&self, corners: &[Vertex; 3]) -> PixelRect {
        let clip = self.transform().screen.clip;
        if corners.iter().any(|v| !(v.screen[0].is_finite() && v.screen[1].is_finite())) {
            return clip;
        }
        let low = |axis: usize| corners.iter().fold(f64::INFINITY, |m, v| m.min(v.screen[axis])) - 1.0;
        let high = |axis: usize| corners.iter().fold(f64::NEG_INFINITY, |m, v| m.max(v.screen[axis])) + 1.0;
        // Casts saturate, so that the farthest corners stay at the sides.
        PixelRect {
            x0: (low(0).floor() as i32).clamp(clip.x0, clip.x1),
            y0: (low(1).floor() as i32).clamp(clip.y0, clip.y1),
            x1: (high(0).ceil() as i32).clamp(clip.x0, clip.x1),
            y1: (high(1).ceil() as i32).clamp(clip.y0, clip.y1),
        }
    }

    /// Returns the index of a triangle's polygon.
    pub fn polygon_of(&self, triangle: u32) -> usize {
        self.call.geometry.mesh.triangle_polygon[triangle as usize] as usize
    }

    /// Returns whether a triangle is transparent, seen from a side that is visible.
    pub fn is_transparent(&self, triangle: u32) -> bool {
        if !self.parts.uses(Part::ReadBack) {
            return false;
        }
        let polygon = &self.call.geometry.mesh.polygons[self.polygon_of(triangle)];
        let corners = self.corners(triangle);
        // The visible side is known only once the face is on the screen, which matters only with a
        // back material.
        let side = match self.call.back_material.is_some() {
            false => Facing::Front,
            true => self.assembler.side(self.corner_vertices(triangle).each_ref()).unwrap_or(Facing::Front),
        };
        let (material, texture) = self.call.material_of(polygon, side);
        let texture = texture.filter(|_| self.texcoords(corners).is_some());
        DrawCall::is_transparent(material, texture)
            || self.call.stages.is_some_and(TextureStages::may_be_transparent)
            || corners.iter().any(|c| self.color(c).is_some_and(|c| c.w < 1.0))
    }

    /// Returns the vertex colour (R, G, B, alpha) of a corner, if it has one.
    fn color(&self, corner: &Corner) -> Option<DVec4> {
        self.call.geometry.mesh.colors.get(corner.color as usize).copied()
    }

    /// Returns the three corners' texture coordinates, if all of them have one.
    pub fn texcoords(&self, corners: [&Corner; 3]) -> Option<[glam::DVec2; 3]> {
        let uv = &self.call.geometry.mesh.texcoords;
        let [a, b, c] = corners.map(|c| uv.get(c.texcoord as usize).copied());
        Some([a?, b?, c?])
    }

    /// Returns the unit world normal of a triangle's polygon. Falls back to the triangle's own
    /// normal, then to zero for a face without area.
    pub fn face_normal(&self, triangle: u32) -> DVec3 {
        let mesh = &self.call.geometry.mesh;
        let polygon = self.polygon_of(triangle);
        let position = |c: &Corner| mesh.positions[c.position as usize];
        let whole = match self.normals().and_then(|n| n.of_polygon.get(polygon)) {
            Some(&n) => Some(n).filter(|n| *n != DVec3::ZERO),
            None => polygon_normal(mesh.polygon_corners(polygon).iter().map(position)),
        };
        let object = whole.or_else(|| polygon_normal(self.corners(triangle).into_iter().map(position)));
        object.and_then(|n| self.normal_matrix.apply(n)).unwrap_or(DVec3::ZERO)
    }

    /// Returns the unit world normal at a corner: the file's, else the mean of its faces', else the
    /// face's.
    pub fn corner_normal(&self, corner: &Corner, face_normal: DVec3) -> DVec3 {
        let given = self.call.geometry.mesh.normals.get(corner.normal as usize);
        given
            .and_then(|&n| self.normal_matrix.apply(n))
            .or_else(|| self.normal_matrix.apply(*self.normals()?.of_position.get(corner.position as usize)?))
            .unwrap_or(face_normal)
    }

    /// Computes the part of stages 8 and 9 that is done once per face.
    pub fn shade(&self, triangle: u32, side: Facing, stats: &mut DrawStats) -> FaceShade<'a> {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let polygon = self.polygon_of(triangle);
        let (material, texture) = call.material_of(&mesh.polygons[polygon], side);
        let corners = self.corners(triangle);
        let texcoords = texture.and_then(|t| Some((t, t.sampling(call.sampling), self.texcoords(corners)?)));
        let is_lit = self.lighting.depends_on_point(material);
        let fog = call.fog.filter(|_| self.parts.uses(Part::Fog));
        let positions = match is_lit || fog.is_some() {
            true => corners.map(|c| self.transform().world(mesh.positions[c.position as usize])),
            false => [DVec3::ZERO; 3],
        };
        let turn = if call.two_sided_lighting && side == Facing::Back { -1.0 } else { 1.0 };
        let mut colors = match corners.iter().any(|c| self.color(c).is_some()) {
            true => Some(corners.map(|c| self.color(c).unwrap_or(DVec4::ONE))),
            false => None,
        };
        let has_alpha = colors.is_some_and(|c| c.iter().any(|c| c.w < 1.0));
        let is_transparent = DrawCall::is_transparent(material, texcoords.map(|t| t.0))
            || has_alpha
            || call.stages.is_some_and(TextureStages::may_be_transparent);
        let mut opacity = 1.0 - material.transparency.clamp(0.0, 1.0);
        let mut light = match call.shade {
            _ if !is_lit => ShadingFrequency::Constant(self.lighting.constant(material)),
            ShadeMode::Flat => {
                stats.vertices_lit += 1;
                let point = SurfacePoint {
                    position: self.polygon_center(polygon),
                    normal: self.face_normal(triangle) * turn,
                };
                ShadingFrequency::Constant(self.lighting.at(point, material))
            }
            ShadeMode::Gouraud => {
                stats.vertices_lit += 3;
                let face_normal = self.face_normal(triangle);
                let at = |i: usize| {
                    let normal = self.corner_normal(corners[i], face_normal) * turn;
                    let mut lit = self.lighting.at(SurfacePoint { position: positions[i], normal }, material);
                    if let Some(colors) = &colors {
                        lit.diffuse_ambient *= colors[i].truncate();
                    }
                    lit
                };
                ShadingFrequency::Vertices([at(0), at(1), at(2)])
            }
            ShadeMode::Phong | ShadeMode::Wire => {
                let face_normal = self.face_normal(triangle);
                ShadingFrequency::Pixels {
                    material,
                    normals: corners.map(|c| self.corner_normal(c, face_normal) * turn),
                    face_normal: face_normal * turn,
                }
            }
        };
        match (&mut light, colors) {
            // Flat shading has one colour per face: the mean of its polygon's.
            (ShadingFrequency::Constant(lit), Some(_)) if call.shade == ShadeMode::Flat => {
                let mean = self.polygon_color(polygon);
                lit.diffuse_ambient *= mean.truncate();
                opacity *= mean.w;
                colors = None;
            }
            // The light includes the colours already; only their alpha is interpolated.
            (ShadingFrequency::Vertices(_), Some(c)) => {
                colors = has_alpha.then_some(c.map(|c| DVec4::new(1.0, 1.0, 1.0, c.w)));
            }
            _ => {}
        }
        let fog = fog.map(|f| (f, self.transform().camera.eye));
        let stages = call.stages.map(|stages| (stages, mesh.triangles[triangle as usize]));
        let (texture, fill) = (texcoords.filter(|_| stages.is_none()), call.fill);
        let maps = FaceMaps::of(call, material, mesh.triangles[triangle as usize], turn);
        FaceShade { light, colors, texture, stages, maps, fill, positions, opacity, fog, is_transparent }
    }

    /// Returns the mean of a polygon's corners in world space.
    pub fn polygon_center(&self, polygon: usize) -> DVec3 {
        let mesh = &self.call.geometry.mesh;
        let corners = mesh.polygon_corners(polygon);
        let sum = corners
            .iter()
            .fold(DVec3::ZERO, |sum, c| sum + self.transform().world(mesh.positions[c.position as usize]));
        sum / corners.len() as f64
    }

    /// Returns the mean of a polygon's vertex colours.
    fn polygon_color(&self, polygon: usize) -> DVec4 {
        let corners = self.call.geometry.mesh.polygon_corners(polygon);
        let sum = corners.iter().fold(DVec4::ZERO, |sum, c| sum + self.color(c).unwrap_or(DVec4::ONE));
        sum / corners.len() as f64
    }
}

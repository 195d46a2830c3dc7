//! A draw made ready: its plan, and the tables that hold for all of its faces.

use super::assemble::{Assembler, Face, Side};
use super::call::{DrawCall, DrawStats, PipelineError, Target};
use super::derive::derive;
use super::known::Known;
use super::light::{Lamp, Lighting, SurfacePoint, Viewer};
use super::normals::{NormalMatrix, Normals, polygon_normal};
use super::plan::{Part, Plan};
use super::raster::{Canvas, Raster, Writes};
use super::shade::{FaceShade, LightMode};
use super::vertex::{Transform, Vertex};
use super::viewport::Screen;
use crate::math::coverage::PixelRect;
use crate::memory::DepthMemory;
use crate::scene::{CameraMatrices, Corner, Interpolation, ShadeMode};
use glam::{DVec3, DVec4};
use std::sync::Arc;

/// Which faces of a draw are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    All,
    Opaque,
    Transparent,
}

/// Lists that a draw leaves to another one.
#[derive(Debug, Default)]
pub(crate) struct Spare {
    lamps: Vec<Lamp>,
    vertices: Vec<Vertex>,
}

impl Spare {
    /// Bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.lamps.capacity() * size_of::<Lamp>() + self.vertices.capacity() * size_of::<Vertex>()
    }
}

/// One draw with everything that is found once.
pub(crate) struct Prepared<'a> {
    pub call: &'a DrawCall<'a>,
    pub plan: Plan,
    pub assembler: Assembler,
    /// All vertices, or none yet.
    vertices: Vec<Vertex>,
    pub lighting: Lighting,
    pub known: Arc<Known>,
    pub normal_matrix: NormalMatrix,
}

impl<'a> Prepared<'a> {
    /// Stages 1 to 3. Nothing is written; an error leaves the memories untouched.
    pub fn new(
        call: &'a DrawCall<'a>,
        target: &Target,
        stats: &mut DrawStats,
    ) -> Result<Self, PipelineError> {
        let mut prepared =
            Prepared::with(call, target, Arc::new(Known::of(call.geometry)), Spare::default(), stats)?;
        prepared.transform_all();
        Ok(prepared)
    }

    /// The same with what is known of the geometry; positions are transformed one by one when they are asked for, until
    /// [`Prepared::transform_all`]. Its lists are made in `spare`.
    pub fn with(
        call: &'a DrawCall<'a>,
        target: &Target,
        known: Arc<Known>,
        spare: Spare,
        stats: &mut DrawStats,
    ) -> Result<Self, PipelineError> {
        let camera = Prepared::check(call, &known, None)?;
        let prepared = Prepared::of(call, camera, target, known, spare);
        stats.vertices += prepared.vertices_in();
        Ok(prepared)
    }

    /// Refuses what no picture can be made of; the camera's matrices, unless they are at hand.
    pub fn check(
        call: &DrawCall,
        known: &Known,
        camera: Option<CameraMatrices>,
    ) -> Result<CameraMatrices, PipelineError> {
        check(call, known)?;
        let aspect = call.viewport.width.max(1) as f64 / call.viewport.height.max(1) as f64;
        match camera {
            Some(camera) => Ok(camera),
            None => Ok(call.camera.matrices(aspect)?),
        }
    }

    /// A draw that was checked, seen by this camera.
    pub fn of(
        call: &'a DrawCall<'a>,
        camera: CameraMatrices,
        target: &Target,
        known: Arc<Known>,
        mut spare: Spare,
    ) -> Self {
        let screen = Screen::new(call.viewport, target.memory.width(), target.memory.height());
        let transform = Transform { model: call.model, camera, screen };
        let lighting = call.lighting_in(Viewer::of(&camera), spare.lamps);
        spare.vertices.clear();
        // 1: what this draw needs
        let plan = derive(call, target, &lighting, &known);
        Prepared {
            call,
            plan,
            assembler: Assembler::new(transform, call.cull),
            vertices: spare.vertices,
            lighting,
            known,
            normal_matrix: NormalMatrix::of(&call.model),
        }
    }

    /// Vertices that come in.
    pub fn vertices_in(&self) -> u64 {
        match self.plan.uses(Part::TransformVertices) {
            true => self.call.geometry.mesh.positions.len() as u64,
            false => 0,
        }
    }

    /// 2: all positions to clip space and the screen; 3: normals.
    pub fn transform_all(&mut self) {
        if self.vertices.is_empty() && self.plan.uses(Part::TransformVertices) {
            let positions = &self.call.geometry.mesh.positions;
            let transform = self.assembler.transform;
            self.vertices.extend(positions.iter().map(|&p| transform.vertex(p)));
        }
    }

    /// The lists, for another draw.
    pub fn into_spare(self) -> Spare {
        Spare { lamps: self.lighting.into_lamps(), vertices: self.vertices }
    }

    /// The vertex of a position.
    #[inline]
    pub fn vertex(&self, position: u32) -> Vertex {
        match self.vertices.get(position as usize) {
            Some(vertex) => *vertex,
            None => self.transform().vertex(self.call.geometry.mesh.positions[position as usize]),
        }
    }

    /// 3: the normals that the plan asks for.
    fn normals(&self) -> Option<&Normals> {
        let smooth = self.plan.uses(Part::VertexNormals);
        self.plan.uses(Part::FaceNormals).then(|| self.known.normals(&self.call.geometry.mesh, smooth))
    }

    pub fn transform(&self) -> &Transform {
        &self.assembler.transform
    }

    /// Makes the memories that the plan asks for and that are not there yet.
    pub fn open_memories(&self, target: &mut Target) {
        if !self.plan.uses(Part::DepthMemory) {
            return;
        }
        let (width, height, format) = (target.memory.width(), target.memory.height(), target.depth_format);
        let fits = |d: &DepthMemory| (d.width(), d.height(), d.format()) == (width, height, format);
        if !target.depth.as_ref().is_some_and(fits) {
            *target.depth = Some(DepthMemory::new(width, height, format));
        }
    }

    /// The triangles in the order in which they are drawn.
    pub fn face_order(&self) -> Vec<u32> {
        let mut order: Vec<u32> = (0..self.call.geometry.mesh.triangles.len() as u32).collect();
        if self.plan.uses(Part::SortFaces) {
            // Far first: view z is more negative there. Stable, so equals keep the file's order.
            order.sort_by(|&a, &b| self.center_z(a).total_cmp(&self.center_z(b)));
        }
        order
    }

    /// View z of a face's centre.
    pub fn center_z(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.corner_vertices(triangle).map(|v| v.view_z);
        (a + b + c) / 3.0
    }

    pub fn corners(&self, triangle: u32) -> [&Corner; 3] {
        let mesh = &self.call.geometry.mesh;
        mesh.triangles[triangle as usize].map(|c| &mesh.corners[c as usize])
    }

    pub fn corner_vertices(&self, triangle: u32) -> [Vertex; 3] {
        self.corners(triangle).map(|c| self.vertex(c.position))
    }

    /// Stages 4 and 5 for one triangle.
    pub fn assemble(&self, triangle: u32, stats: &mut DrawStats) -> Option<Face> {
        self.assembler.face(self.corner_vertices(triangle).each_ref(), stats)
    }

    /// Stages 4 to 10 for one triangle, if it belongs to `layer`.
    pub fn draw_face(&self, triangle: u32, layer: Layer, target: &mut Target, stats: &mut DrawStats) {
        if self.is_in(triangle, layer) {
            self.draw_any_face(triangle, target, stats);
        }
    }

    /// Whether a triangle belongs to `layer`.
    pub fn is_in(&self, triangle: u32, layer: Layer) -> bool {
        layer == Layer::All || self.is_transparent(triangle) == (layer == Layer::Transparent)
    }

    /// Stages 4 to 10 for one triangle.
    pub fn draw_any_face(&self, triangle: u32, target: &mut Target, stats: &mut DrawStats) {
        let Some(face) = self.assemble(triangle, stats) else { return };
        let shade = self.shade(triangle, face.side, stats);
        self.cover(&face, &shade, triangle, Writes::Color, target, stats);
    }

    /// Stages 6, 7 and 10 for one triangle, into the depth alone.
    pub fn draw_depth(&self, triangle: u32, target: &mut Target, stats: &mut DrawStats) {
        let Some(face) = self.assemble(triangle, stats) else { return };
        let shade = FaceShade {
            light: LightMode::Constant(super::light::Lit { base: DVec3::ZERO, extra: DVec3::ZERO }),
            colors: None,
            texture: None,
            positions: [DVec3::ZERO; 3],
            opacity: 1.0,
            fog: None,
            is_transparent: false,
        };
        self.cover(&face, &shade, triangle, Writes::DepthOnly, target, stats);
    }

    fn cover(
        &self,
        face: &Face,
        shade: &FaceShade,
        triangle: u32,
        writes: Writes,
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let mut canvas = self.canvas(target);
        self.raster(&mut canvas).face(face, shade, triangle, writes, stats);
        let written = canvas.written;
        target.memory.mark_rows(written);
    }

    /// The memories of this draw.
    pub fn canvas<'t>(&self, target: &'t mut Target) -> Canvas<'t> {
        Canvas::new(target, self.transform().screen.clip, self.plan.uses(Part::DepthMemory))
    }

    /// What covers and colours the faces of this draw.
    pub fn raster<'r, 't>(&'r self, canvas: &'r mut Canvas<'t>) -> Raster<'r, 't> {
        Raster {
            canvas,
            screen: &self.transform().screen,
            lighting: &self.lighting,
            interp: self.call.interp,
            divide: self.plan.uses(Part::PerspectiveDivision),
            name: self.call.name,
        }
    }

    /// Columns and rows outside of which a triangle covers nothing, inside the view.
    pub fn bounds_of(&self, triangle: u32) -> PixelRect {
        let corners = self.corner_vertices(triangle);
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

    pub fn polygon_of(&self, triangle: u32) -> usize {
        self.call.geometry.mesh.triangle_polygon[triangle as usize] as usize
    }

    /// Whether a triangle lets light through, from either side that can be seen.
    pub fn is_transparent(&self, triangle: u32) -> bool {
        if !self.plan.uses(Part::ReadBack) {
            return false;
        }
        let polygon = &self.call.geometry.mesh.polygons[self.polygon_of(triangle)];
        let corners = self.corners(triangle);
        // Which side is seen is known only once the face is on the screen; a back material of another kind is rare.
        let side = match self.call.back_material.is_some() {
            false => Side::Front,
            true => self.assembler.side(self.corner_vertices(triangle).each_ref()).unwrap_or(Side::Front),
        };
        let (material, texture) = self.call.material_of(polygon, side);
        let texture = texture.filter(|_| self.texcoords(corners).is_some());
        DrawCall::is_transparent(material, texture)
            || corners.iter().any(|c| self.color(c).is_some_and(|c| c.w < 1.0))
    }

    fn color(&self, corner: &Corner) -> Option<DVec4> {
        self.call.geometry.mesh.colors.get(corner.color as usize).copied()
    }

    /// The three corners' u, v, when all have one.
    pub fn texcoords(&self, corners: [&Corner; 3]) -> Option<[glam::DVec2; 3]> {
        let uv = &self.call.geometry.mesh.texcoords;
        let [a, b, c] = corners.map(|c| uv.get(c.texcoord as usize).copied());
        Some([a?, b?, c?])
    }

    /// The unit world normal of a triangle's polygon; its own where the polygon has none; zero without area.
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

    /// The unit world normal at a corner: the file's, or the mean, or the face's.
    pub fn corner_normal(&self, corner: &Corner, face_normal: DVec3) -> DVec3 {
        let given = self.call.geometry.mesh.normals.get(corner.normal as usize);
        given
            .and_then(|&n| self.normal_matrix.apply(n))
            .or_else(|| self.normal_matrix.apply(*self.normals()?.of_position.get(corner.position as usize)?))
            .unwrap_or(face_normal)
    }

    /// The part of stages 8 and 9 that is done once a face.
    pub fn shade(&self, triangle: u32, side: Side, stats: &mut DrawStats) -> FaceShade<'a> {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let polygon = self.polygon_of(triangle);
        let (material, texture) = call.material_of(&mesh.polygons[polygon], side);
        let corners = self.corners(triangle);
        let texcoords = texture.and_then(|t| Some((t, call.sampling, self.texcoords(corners)?)));
        let is_lit = self.lighting.depends_on_point(material);
        let fog = call.fog.filter(|_| self.plan.uses(Part::Fog));
        let positions = match is_lit || fog.is_some() {
            true => corners.map(|c| self.transform().world(mesh.positions[c.position as usize])),
            false => [DVec3::ZERO; 3],
        };
        let turn = if call.two_sided_lighting && side == Side::Back { -1.0 } else { 1.0 };
        let mut colors = match corners.iter().any(|c| self.color(c).is_some()) {
            true => Some(corners.map(|c| self.color(c).unwrap_or(DVec4::ONE))),
            false => None,
        };
        let has_alpha = colors.is_some_and(|c| c.iter().any(|c| c.w < 1.0));
        let is_transparent = DrawCall::is_transparent(material, texcoords.map(|t| t.0)) || has_alpha;
        let mut opacity = 1.0 - material.transparency.clamp(0.0, 1.0);
        let mut light = match call.shade {
            _ if !is_lit => LightMode::Constant(self.lighting.constant(material)),
            ShadeMode::Flat => {
                stats.vertices_lit += 1;
                let point = SurfacePoint {
                    position: self.polygon_center(polygon),
                    normal: self.face_normal(triangle) * turn,
                };
                LightMode::Constant(self.lighting.at(point, material))
            }
            ShadeMode::Gouraud => {
                stats.vertices_lit += 3;
                let face_normal = self.face_normal(triangle);
                let at = |i: usize| {
                    let normal = self.corner_normal(corners[i], face_normal) * turn;
                    let mut lit = self.lighting.at(SurfacePoint { position: positions[i], normal }, material);
                    if let Some(colors) = &colors {
                        lit.base *= colors[i].truncate();
                    }
                    lit
                };
                LightMode::Vertices([at(0), at(1), at(2)])
            }
            ShadeMode::Phong | ShadeMode::Wire => {
                let face_normal = self.face_normal(triangle);
                LightMode::Pixels {
                    material,
                    normals: corners.map(|c| self.corner_normal(c, face_normal) * turn),
                    face_normal: face_normal * turn,
                }
            }
        };
        match (&mut light, colors) {
            // One colour a face: the mean of its polygon's.
            (LightMode::Constant(lit), Some(_)) if call.shade == ShadeMode::Flat => {
                let mean = self.polygon_color(polygon);
                lit.base *= mean.truncate();
                opacity *= mean.w;
                colors = None;
            }
            // The colours are in the light already; only their alpha runs on.
            (LightMode::Vertices(_), Some(c)) => {
                colors = has_alpha.then_some(c.map(|c| DVec4::new(1.0, 1.0, 1.0, c.w)));
            }
            _ => {}
        }
        let fog = fog.map(|f| (f, self.transform().camera.eye));
        FaceShade { light, colors, texture: texcoords, positions, opacity, fog, is_transparent }
    }

    /// The mean of a polygon's corners, in the world.
    pub fn polygon_center(&self, polygon: usize) -> DVec3 {
        let mesh = &self.call.geometry.mesh;
        let corners = mesh.polygon_corners(polygon);
        let sum = corners
            .iter()
            .fold(DVec3::ZERO, |sum, c| sum + self.transform().world(mesh.positions[c.position as usize]));
        sum / corners.len() as f64
    }

    /// The mean of a polygon's vertex colours.
    fn polygon_color(&self, polygon: usize) -> DVec4 {
        let corners = self.call.geometry.mesh.polygon_corners(polygon);
        let sum = corners.iter().fold(DVec4::ZERO, |sum, c| sum + self.color(c).unwrap_or(DVec4::ONE));
        sum / corners.len() as f64
    }

    /// Whether values run straight on the screen.
    pub fn is_affine(&self) -> bool {
        self.call.interp == Interpolation::Affine
    }
}

/// Refuses what no picture can be made of.
fn check(call: &DrawCall, known: &Known) -> Result<(), PipelineError> {
    if !call.model.is_finite() {
        return Err(PipelineError::NotFinite { what: "the model matrix" });
    }
    let row = call.model.row(3).to_array();
    if row != [0.0, 0.0, 0.0, 1.0] {
        return Err(PipelineError::PerspectiveModel { row });
    }
    known.checked.clone()
}

//! A prepared draw: its parts, and the data that all of its faces share.
//!
//! In: a draw call, its target's size and format, and cached facts about its mesh. Out: a
//! [`PreparedDraw`], whose methods run the later stages face by face. Errors occur only while it is
//! made, so a refused draw leaves the target untouched.

mod face;

use crate::cancel::{CancelToken, NEVER};
use crate::memory::DepthMemory;
use crate::pipeline::assemble::{Assembler, Face};
use crate::pipeline::draw_call::{DrawCall, DrawStats, PipelineError, Target};
use crate::pipeline::geometry_cache::{GeometryInfo, Needs};
use crate::pipeline::light::{Lighting, PreparedLight, ViewerPosition};
use crate::pipeline::normals::{NormalMatrix, Normals};
use crate::pipeline::pixel::PixelRules;
use crate::pipeline::plan::{Part, Parts};
use crate::pipeline::planner::plan_draw;
use crate::pipeline::preemption::{NOT_PREEMPTED, Preemption};
use crate::pipeline::shading_space::ShadingSpace;
use crate::pipeline::target_rows::TargetRows;
use crate::pipeline::vertex::{Transform, Vertex};
use crate::pipeline::viewport::ViewportTransform;
use crate::scene::{CameraError, CameraMatrices, Interpolation, ShadeMode};
use std::sync::Arc;

/// Selection of a draw's faces by transparency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Layer {
    /// Every face.
    All,
    /// Faces that are not transparent.
    Opaque,
}

/// Buffers that one draw leaves to another for reuse.
#[derive(Debug, Default)]
pub(crate) struct RecycledLists {
    prepared_lights: Vec<PreparedLight>,
    vertices: Vec<Vertex>,
}

impl RecycledLists {
    /// Returns the bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.prepared_lights.capacity() * size_of::<PreparedLight>()
            + self.vertices.capacity() * size_of::<Vertex>()
    }
}

/// One draw with everything that is computed once per draw.
pub(crate) struct PreparedDraw<'a> {
    /// The draw call.
    pub call: &'a DrawCall<'a>,
    /// The parts of the pipeline that its plan uses.
    pub parts: Parts,
    /// Transformation, culling and clipping of its faces.
    pub assembler: Assembler,
    /// All transformed vertices, or empty before [`PreparedDraw::transform_all`].
    vertices: Vec<Vertex>,
    /// Lights that reach the mesh, and ambient light.
    pub lighting: Lighting,
    /// Cached facts about the mesh.
    pub geometry_info: Arc<GeometryInfo>,
    /// Transformation of normals to world space.
    pub normal_matrix: NormalMatrix,
    /// Space in which the vector kernels compute colours.
    pub space: ShadingSpace,
    /// Token that ends long loops over faces, lines and points early.
    pub cancel: &'a CancelToken,
    /// Handle by which the draw is preempted.
    pub preemption: &'a Preemption,
}

impl<'a> PreparedDraw<'a> {
    /// Runs stages 1 to 3. Nothing is written, so an error leaves the target untouched.
    pub fn new(
        call: &'a DrawCall<'a>,
        target: &Target,
        stats: &mut DrawStats,
    ) -> Result<Self, PipelineError> {
        let mut prepared = PreparedDraw::with(
            call,
            target,
            Arc::new(GeometryInfo::of(call.geometry, CancelToken::default())),
            RecycledLists::default(),
            stats,
        )?;
        prepared.transform_all();
        Ok(prepared)
    }

    /// Runs stage 1 with cached facts about the geometry. Positions are transformed one by one on
    /// demand until [`PreparedDraw::transform_all`] is called. Its lists reuse the buffers of
    /// `recycled`.
    pub fn with(
        call: &'a DrawCall<'a>,
        target: &Target,
        geometry_info: Arc<GeometryInfo>,
        recycled: RecycledLists,
        stats: &mut DrawStats,
    ) -> Result<Self, PipelineError> {
        check(call, &geometry_info)?;
        let camera = PreparedDraw::camera_of(call)?;
        let prepared = PreparedDraw::of(call, camera, target, geometry_info, recycled);
        stats.vertices += prepared.vertices_in();
        Ok(prepared)
    }

    /// Returns the matrices of the draw's camera.
    ///
    /// # Errors
    /// When the camera makes no picture.
    pub fn camera_of(call: &DrawCall) -> Result<CameraMatrices, CameraError> {
        call.camera.matrices(call.viewport.width.max(1) as f64 / call.viewport.height.max(1) as f64)
    }

    /// Prepares a draw that has passed [`check`], with this camera.
    pub fn of(
        call: &'a DrawCall<'a>,
        camera: CameraMatrices,
        target: &Target,
        geometry_info: Arc<GeometryInfo>,
        mut recycled: RecycledLists,
    ) -> Self {
        let screen = ViewportTransform::on(call.viewport, target.memory);
        let transform = Transform { model: call.model, camera, screen };
        let lighting = call.lighting(ViewerPosition::of(&camera), recycled.prepared_lights);
        recycled.vertices.clear();
        // Stage 1: the parts.
        let parts = plan_draw(call, target, &lighting, &geometry_info);
        PreparedDraw {
            call,
            parts,
            space: ShadingSpace::new(&transform, geometry_info.bounds),
            assembler: Assembler::new(transform, call.cull),
            vertices: recycled.vertices,
            lighting,
            geometry_info,
            normal_matrix: NormalMatrix::of(&call.model),
            cancel: &NEVER,
            preemption: &NOT_PREEMPTED,
        }
    }

    /// Returns the facts that this draw needs of its geometry.
    pub fn needs(&self) -> Needs {
        let (parts, is_lit) = (self.parts, self.parts.is_lit());
        let is_flat = self.call.shade == ShadeMode::Flat;
        let is_fast = parts.uses(Part::TileRenderer);
        Needs {
            normals: parts.uses(Part::FaceNormals).then(|| parts.uses(Part::VertexNormals)),
            prepared: is_fast.then_some(is_lit && !is_flat),
            faces: is_fast && is_flat && (is_lit || !self.call.geometry.mesh.colors.is_empty()),
        }
    }

    /// Returns the number of vertices to transform.
    pub fn vertices_in(&self) -> u64 {
        match self.parts.uses(Part::TransformVertices) {
            true => self.call.geometry.mesh.positions.len() as u64,
            false => 0,
        }
    }

    /// Stage 2: transforms all positions to clip space and the screen, unless that is done. A
    /// cancelled draw leaves the list incomplete.
    pub fn transform_all(&mut self) {
        if self.vertices.is_empty() && self.parts.uses(Part::TransformVertices) {
            let positions = &self.call.geometry.mesh.positions;
            let transform = self.assembler.transform;
            for some in positions.chunks(1 << 14).take_while(|_| !self.cancel.is_cancelled()) {
                self.vertices.extend(some.iter().map(|&p| transform.vertex(p)));
            }
        }
    }

    /// Takes the buffers of a finished draw, for another one to reuse.
    pub fn take_recycled(&mut self) -> RecycledLists {
        let prepared_lights = self.lighting.take_lights();
        RecycledLists { prepared_lights, vertices: std::mem::take(&mut self.vertices) }
    }

    /// Returns the transformed vertex of a position index.
    #[inline]
    pub fn vertex(&self, position: u32) -> Vertex {
        match self.vertices.get(position as usize) {
            Some(vertex) => *vertex,
            None => self.transform().vertex(self.call.geometry.mesh.positions[position as usize]),
        }
    }

    /// Stage 3: returns the normals that the plan requires.
    fn normals(&self) -> Option<&Normals> {
        let smooth = self.parts.uses(Part::VertexNormals);
        self.parts
            .uses(Part::FaceNormals)
            .then(|| self.geometry_info.normals(&self.call.geometry.mesh, smooth))
    }

    /// Returns the transformation of positions.
    pub fn transform(&self) -> &Transform {
        &self.assembler.transform
    }

    /// Returns the rules by which the draw's faces are coloured at a pixel.
    pub fn pixel_rules(&self) -> PixelRules<'_> {
        PixelRules {
            screen: &self.transform().screen,
            lighting: &self.lighting,
            interp: self.call.interp,
            divide: self.parts.uses(Part::PerspectiveDivision),
        }
    }

    /// Creates the depth memory if the plan requires it and the target has none that fits.
    pub fn open_buffers(&self, target: &mut Target) {
        if !self.parts.uses(Part::DepthMemory) {
            return;
        }
        let (width, height, format) = (target.memory.width(), target.memory.height(), target.depth_format);
        let fits = |d: &DepthMemory| (d.width(), d.height(), d.format()) == (width, height, format);
        if !target.depth.as_ref().is_some_and(fits) {
            *target.depth = Some(DepthMemory::new(width, height, format));
        }
    }

    /// Runs stages 4 and 5 for one triangle.
    pub fn assemble(&self, triangle: u32, stats: &mut DrawStats) -> Option<Face> {
        self.assembler.face(self.corner_vertices(triangle).each_ref(), stats)
    }

    /// Returns whether a triangle belongs to `layer`.
    pub fn is_in(&self, triangle: u32, layer: Layer) -> bool {
        layer == Layer::All || !self.is_transparent(triangle)
    }

    /// Returns the target's rows as this draw may write them.
    pub fn target_rows<'t>(&self, target: &'t mut Target) -> TargetRows<'t> {
        TargetRows::new(target, self.transform().screen.clip, self.parts)
    }

    /// Returns whether attributes are interpolated linearly on the screen.
    pub fn is_affine(&self) -> bool {
        self.call.interp == Interpolation::Affine
    }
}

/// Checks that the model matrix is finite and affine, and that the mesh's indices are valid.
pub(crate) fn check(call: &DrawCall, geometry_info: &GeometryInfo) -> Result<(), PipelineError> {
    if !call.model.is_finite() {
        return Err(PipelineError::NotFinite { what: "the model matrix" });
    }
    let row = call.model.row(3).to_array();
    if row != [0.0, 0.0, 0.0, 1.0] {
        return Err(PipelineError::PerspectiveModel { row });
    }
    geometry_info.checked.clone()
}

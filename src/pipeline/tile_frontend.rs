//! Front end of the tile renderer: decides whether it supports a draw, and builds its job for a
//! prepared draw.
//!
//! All setup is in f64: `shading_space` chooses the space in which colours are computed,
//! `light_setup` builds the tables that all faces share.

mod blended_raster;
mod blended_setup;
mod draw_batch;
mod draw_inputs;
mod light_setup;
mod memory_estimate;
mod shading_space;

use super::assemble::{Face, Facing};
use super::draw_call::{CoarseDepth, DrawCall, DrawStats, Target};
use super::indexed_mesh::IndexedMesh;
use super::plan::{Part, Plan};
use super::preemption::Slice;
use super::prepared_draw::PreparedDraw;
use super::sampler::Footprint;
use super::shade::ShadingFrequency;
use super::tile::{self, ExactFace, FRAME_LIMITS, FrameSlices, Scratch, TileDraw, TileStats};
use super::vertex::Vertex;
use crate::executor::Executor;
use crate::memory::opaque;
use crate::scene::{Cull, FillStyle, HiddenSurface, Interpolation, ShadeMode};
use crate::simd::Level;
pub(crate) use blended_raster::BlendedRaster;
pub(crate) use blended_setup::{BlendedSetup, blended_unsupported_reason};
pub(crate) use draw_batch::DrawBatch;
use glam::DVec3;
use light_setup::{RecycledBindings, Tables};
pub(crate) use memory_estimate::{binding_bytes, estimated_bytes, working_bytes};

/// SIMD level, executor and workspace of a draw.
pub(crate) struct DrawContext<'t> {
    pub level: Level,
    pub executor: &'t Executor,
    pub coarse: CoarseDepth,
    pub workspace: &'t mut TileWorkspace,
}

/// Buffers that are kept from draw to draw.
#[derive(Debug, Default)]
pub(crate) struct TileWorkspace {
    scratch: Scratch,
    tables: Tables,
    recycled: RecycledBindings,
}

impl TileWorkspace {
    /// Returns the bytes that the buffers take.
    pub fn size_bytes(&self) -> usize {
        self.scratch.size_bytes() + self.tables.size_bytes()
    }

    /// Returns the bytes of vertices and tables, without the tiles' face lists.
    fn table_bytes(&self) -> usize {
        self.scratch.vertex_bytes() + self.tables.size_bytes()
    }

    /// Returns the bytes that the tiles' face lists have room for.
    pub fn list_bytes(&self) -> u64 {
        self.scratch.lists_held() as u64
    }

    /// Sets the bytes of the tiles' face lists at which a draw is split into pieces.
    pub fn bound_lists(&mut self, bytes: usize) {
        self.scratch.list_bytes = bytes;
    }
}

/// Maximum number of faces of a mesh that the calling thread may draw alone.
const FEW_FACES: usize = 512;

/// Maximum work of a draw on the calling thread alone: pixels of the mesh's bounding box on the
/// screen, times one plus the lights per pixel.
const LITTLE_WORK: f64 = 40_000.0;

/// Returns the reason why the tile renderer does not support a draw, as far as the plan tells;
/// `None` if it does.
pub(crate) fn unsupported_reason(call: &DrawCall, target: &Target, plan: &Plan) -> Option<&'static str> {
    let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
    let mesh = &call.geometry.mesh;
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
    if plan.uses(Part::ReadBack) {
        return Some("transparent faces are blended one after the other");
    }
    if width < FRAME_LIMITS.0 || width > FRAME_LIMITS.1 || height > FRAME_LIMITS.1 {
        return Some("the frame is too narrow, too wide or too high for vectors");
    }
    let is_lit = plan.uses(Part::LightVertices) || plan.uses(Part::LightFaces);
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
    None
}

impl PreparedDraw<'_> {
    /// Draws the opaque faces by the tile renderer. Returns `false`, with nothing drawn, if the
    /// draw proves to be unsupported: its values are out of range for f32, or nothing is in view.
    pub fn draw_fast(&self, context: DrawContext<'_>, target: &mut Target, stats: &mut DrawStats) -> bool {
        let TileWorkspace { scratch, tables, recycled } = context.workspace;
        let Some(mut inputs) = self.inputs(recycled) else { return false };
        inputs.coarse = context.coarse;
        let serial = self.is_small().then(|| context.executor.serial());
        let executor = serial.as_ref().unwrap_or(context.executor);
        let (level, format) = (context.level, target.depth_format);
        let items = self.items();
        let result = self.preemption.run_draw(executor, || {
            let make_tables = || self.make_tables(&mut inputs, level, executor, tables);
            self.preemption.without(target, items, || executor.run(make_tables));
            self.with_job(&inputs, tables, format, |job| {
                self.draw_job(job, (level, executor), scratch, target)
            })
        });
        recycled.take_back(inputs.bindings);
        *stats += self.counted(result.draw);
        true
    }

    /// Draws a job by the tile renderer. The owner of the target has it while faces are binned, and
    /// between slices of the rows of tiles.
    fn draw_job(
        &self,
        job: &tile::DrawJob<'_>,
        (level, executor): (Level, &Executor),
        scratch: &mut Scratch,
        target: &mut Target,
    ) -> TileStats {
        let (preemption, items) = (self.preemption, self.items());
        let (width, has_depth) = (target.memory.width() as usize, self.plan.uses(Part::DepthMemory));
        let begin = || executor.run(|| TileDraw::new(level, executor, scratch, job, width));
        let mut draw = preemption.without(target, items, begin);
        while preemption.without(target, items, || executor.run(|| draw.bin(level, executor, scratch, job))) {
            while !executor.run(|| {
                let slice = &Slice::new(preemption);
                draw.draw_rows((level, executor, slice), scratch, job, frame_of(target, has_depth))
            }) {
                target.memory.mark_rows(draw.rows());
                preemption.point(target);
            }
            target.memory.mark_rows(draw.rows());
        }
        draw.into_stats()
    }

    /// Returns the number of faces and vertices, on which the time of most stages depends.
    pub fn items(&self) -> usize {
        let mesh = &self.call.geometry.mesh;
        mesh.triangles.len() + mesh.positions.len()
    }

    /// Returns the tile renderer's statistics with the lighting counts of the plain path, which
    /// lights overdrawn pixels too.
    fn counted(&self, mut draw: DrawStats) -> DrawStats {
        if self.plan.uses(Part::LightPixels) {
            draw.pixels_lit = draw.pixels_written;
        } else if self.plan.uses(Part::LightVertices) {
            draw.vertices_lit = draw.faces_drawn * 3;
        } else if self.plan.uses(Part::LightFaces) {
            draw.vertices_lit = draw.faces_drawn;
        }
        draw
    }

    /// Returns whether the draw is so small that waking another thread would take longer.
    fn is_small(&self) -> bool {
        let Some((low, high)) = self.geometry_info.bounds else { return true };
        if self.call.geometry.mesh.triangles.len() > FEW_FACES {
            return false;
        }
        let clip = self.transform().screen.clip;
        let (mut from, mut to) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in 0..8 {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let at = self.transform().vertex(DVec3::new(pick(0), pick(1), pick(2))).screen;
            if !(at[0].is_finite() && at[1].is_finite()) {
                return false;
            }
            (from, to) = ([0, 1].map(|a| at[a].min(from[a])), [0, 1].map(|a| at[a].max(to[a])));
        }
        let width = to[0].min(clip.x1 as f64) - from[0].max(clip.x0 as f64);
        let height = to[1].min(clip.y1 as f64) - from[1].max(clip.y0 as f64);
        let per_pixel = 1 + if self.plan.uses(Part::LightPixels) { self.lighting.light_count() } else { 0 };
        width.max(0.0) * height.max(0.0) * per_pixel as f64 <= LITTLE_WORK
    }
}

/// Returns the target's memories as the tile renderer's slices.
fn frame_of<'t>(target: &'t mut Target, has_depth: bool) -> FrameSlices<'t> {
    let (width, size) = (target.memory.width(), (target.memory.width(), target.memory.height()));
    let depth = target.depth.as_mut().filter(|_| has_depth).map(|d| d.cells_mut());
    let pick = match target.ids.as_deref_mut().filter(|i| (i.width(), i.height()) == size) {
        Some(ids) if has_depth => ids.ids_mut(),
        _ => &mut [],
    };
    FrameSlices { width: width as usize, bytes: target.memory.bytes_mut(), depth, pick }
}

impl PreparedDraw<'_> {
    /// Sets up a face as the plain path does, from the positions that the vector kernel has read.
    fn exact_face(&self, triangle: u32, mesh: &IndexedMesh, stats: &mut DrawStats) -> Option<ExactFace> {
        let corners = mesh.points_of(triangle).map(|point| self.transform().vertex(point));
        let face = self.assembler.face(corners.each_ref(), stats)?;
        Some(self.exact_face_of(triangle, corners, face))
    }

    /// Returns the record of a face that has been assembled.
    fn exact_face_of(&self, triangle: u32, corners: [Vertex; 3], face: Face) -> ExactFace {
        let screen = &self.transform().screen;
        let is_cut = corners.iter().any(|v| v.clip.w.is_nan() || v.clip.w <= 0.0);
        let bounds = self.bounds_around(&corners);
        let plane = face.plane.plane_equation(screen, self.call.interp);
        // Change of each barycentric over 16 columns; on the screen it is weight b times w.
        let runs = |k: usize| 16.0 * plane.barycentrics[k][1].abs() * corners[k].clip.w.abs();
        let is_gentle = !is_cut && (0..3).all(|k| runs(k) < 16.0);
        let is_smooth = !is_cut && (0..3).all(|k| runs(k) < 1.0);
        ExactFace {
            face: triangle,
            bounds,
            plane,
            is_between: face.wholly_between_near_and_far,
            z_range: face.z_range.map(|z| z as f32),
            exact_ranges: [face.z_range, complement_range(&corners)],
            is_cut,
            corner_w: match self.call.interp {
                Interpolation::Perspective => corners.map(|v| v.clip.w as f32),
                Interpolation::Affine => [1.0; 3],
            },
            is_gentle,
            is_smooth,
            is_back: face.side == Facing::Back,
            is_normal_flipped: self.call.two_sided_lighting && face.side == Facing::Back,
            outlines: face.outlines,
        }
    }

    /// Returns the bytes of one pixel of a face, as the plain path shades it.
    fn shaded_pixel(&self, triangle: u32, x: i32, y: i32) -> [u8; 4] {
        let stats = &mut DrawStats::default();
        let Some(face) = self.assemble(triangle, stats) else { return [0, 0, 0, 255] };
        let shade = self.shade(triangle, face.side, stats);
        match face.pixel(&shade, [x, y], &self.pixel_rules(), stats) {
            Some((rgb, _)) => opaque(rgb),
            // Beyond the horizon of the face's plane: use the colour at the face's middle.
            None => match shade.light {
                ShadingFrequency::Constant(lit) => opaque(lit.diffuse_ambient + lit.specular_emissive),
                _ => {
                    let third = [1.0 / 3.0; 3];
                    opaque(shade.at(third, |_| Footprint::Horizon, &self.lighting, stats).0)
                }
            },
        }
    }
}

/// Returns the minimum and maximum of 1 - z/w at the corners; infinite if some w <= 0.
fn complement_range(corners: &[Vertex; 3]) -> [f64; 2] {
    if !corners.iter().all(|v| v.clip.w > 0.0) {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    let [a, b, c] = corners.each_ref().map(|v| v.complement / v.clip.w);
    [a.min(b).min(c), a.max(b).max(c)]
}

/// Rounds a vector to f32.
fn f32s(v: DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}

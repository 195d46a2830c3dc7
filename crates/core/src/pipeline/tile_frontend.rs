//! Front end of the vector kernels: tells the plan whether they support a draw (`support`), and draws
//! prepared draws by the tile renderer (`draw_batch`).
//!
//! All setup is in f64: `draw_inputs` collects what holds for a draw, `light_setup` builds the tables
//! that all faces share.

mod blended_raster;
mod blended_setup;
mod draw_batch;
mod draw_inputs;
mod light_setup;
mod memory_estimate;
mod support;

use super::assemble::{Face, Facing};
use super::draw_call::{DrawStats, Target};
use super::indexed_mesh::IndexedMesh;
use super::plan::{Part, Parts};
use super::prepared_draw::PreparedDraw;
use super::sampler::Footprint;
use super::shade::ShadingFrequency;
use super::tile::{ExactFace, FrameSlices, RecycledBindings, Scratch, is_rough};
use super::vertex::Vertex;
use crate::executor::Executor;
use crate::memory::{PickBuffer, PickCells, opaque};
use crate::scene::{Interpolation, box_corners};
use crate::simd::Level;
pub(crate) use blended_raster::BlendedRaster;
pub(crate) use blended_setup::BlendedSetup;
pub(crate) use draw_batch::DrawBatch;
use light_setup::Tables;
pub(crate) use memory_estimate::{binding_bytes, estimated_bytes, working_bytes};

/// SIMD level and executor of a draw.
#[derive(Clone, Copy)]
pub(crate) struct DrawContext<'t> {
    pub level: Level,
    pub executor: &'t Executor,
}

/// Buffers that are kept from draw to draw.
#[derive(Debug, Default)]
struct TileWorkspace {
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
}

/// Maximum number of faces of a mesh that the calling thread may draw alone.
const FEW_FACES: usize = 512;

/// Maximum work of a draw on the calling thread alone: pixels of the mesh's bounding box on the
/// screen, times one plus the lights per pixel.
const LITTLE_WORK: f64 = 40_000.0;

impl PreparedDraw<'_> {
    /// Returns the number of faces and vertices, on which the time of most stages depends.
    pub fn items(&self) -> usize {
        let mesh = &self.call.geometry.mesh;
        mesh.triangles.len() + mesh.positions.len()
    }

    /// Returns the tile renderer's statistics with the lighting counts of the plain path, which
    /// lights overdrawn pixels too.
    fn counted(&self, mut draw: DrawStats) -> DrawStats {
        if self.parts.uses(Part::LightPixels) {
            draw.pixels_lit = draw.pixels_written;
        } else if self.parts.uses(Part::LightVertices) {
            draw.vertices_lit = draw.faces_drawn * 3;
        } else if self.parts.uses(Part::LightFaces) {
            draw.vertices_lit = draw.faces_drawn;
        }
        draw.coarse_draws = u64::from(self.parts.uses(Part::CoarseDepth));
        draw
    }

    /// Returns whether the draw is so small that waking another thread would take longer.
    fn is_small(&self) -> bool {
        let Some(bounds) = self.geometry_info.bounds else { return true };
        if self.call.geometry.mesh.triangles.len() > FEW_FACES {
            return false;
        }
        let clip = self.transform().screen.clip;
        let (mut from, mut to) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in box_corners(bounds) {
            let at = self.transform().vertex(corner).screen;
            if !(at[0].is_finite() && at[1].is_finite()) {
                return false;
            }
            (from, to) = ([0, 1].map(|a| at[a].min(from[a])), [0, 1].map(|a| at[a].max(to[a])));
        }
        let width = to[0].min(clip.x1 as f64) - from[0].max(clip.x0 as f64);
        let height = to[1].min(clip.y1 as f64) - from[1].max(clip.y0 as f64);
        let per_pixel = 1 + if self.parts.uses(Part::LightPixels) { self.lighting.light_count() } else { 0 };
        width.max(0.0) * height.max(0.0) * per_pixel as f64 <= LITTLE_WORK
    }
}

/// Returns the memories of the target that the draw uses, as the tile renderer's slices.
fn frame_of<'t>(target: &'t mut Target, parts: Parts) -> FrameSlices<'t> {
    let width = target.memory.width() as usize;
    let depth = target.depth.as_mut().filter(|_| parts.uses(Part::DepthMemory)).map(|d| d.cells_mut());
    let pick = target.ids.as_deref_mut().filter(|_| parts.uses(Part::PickBuffer));
    let pick = pick.map_or(PickCells::default(), PickBuffer::cells_mut);
    FrameSlices { width, bytes: target.memory.bytes_mut(), depth, pick }
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
        let factors = match self.call.interp {
            Interpolation::Perspective => [1.0; 3],
            Interpolation::Affine => corners.map(|v| v.clip.w),
        };
        let is_rough = is_rough(&plane, corners.map(|v| [v.clip.z, v.clip.w]), factors, face.z_range);
        ExactFace {
            face: triangle,
            bounds,
            plane,
            is_between: face.wholly_between_near_and_far,
            z_range: face.z_range.map(|z| z as f32),
            exact_ranges: [face.z_range, complement_range(&corners)],
            is_rough,
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
        let mut bytes = [0; 4];
        self.shade_run(triangle, [x, y], &mut bytes);
        bytes
    }

    /// Shades a run of pixels of a face from (x, y) on, as the plain path does.
    fn shade_run(&self, triangle: u32, [x, y]: [i32; 2], bytes: &mut [u8]) {
        let stats = &mut DrawStats::default();
        let (pixels, _) = bytes.as_chunks_mut::<4>();
        let Some(face) = self.assemble(triangle, stats) else { return pixels.fill([0, 0, 0, 255]) };
        let shade = self.shade(triangle, face.side, stats);
        let rules = self.pixel_rules();
        for (x, pixel) in (x..).zip(pixels) {
            *pixel = match face.pixel(&shade, [x, y], &rules, stats) {
                Some((rgb, _)) => opaque(rgb),
                // Beyond the horizon of the face's plane: use the colour at the face's middle.
                None => match shade.light {
                    ShadingFrequency::Constant(lit) if shade.maps.is_none() => {
                        opaque(lit.diffuse_ambient + lit.specular_emissive)
                    }
                    _ => {
                        let third = [1.0 / 3.0; 3];
                        opaque(shade.at(third, |_| Footprint::Horizon, &self.lighting, stats).0)
                    }
                },
            };
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

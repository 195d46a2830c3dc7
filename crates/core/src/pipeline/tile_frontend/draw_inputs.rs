//! Per-draw inputs of the tile renderer.

use super::DrawContext;
use super::light_setup::{Light, TableWork, Tables};
use crate::math::coverage::PixelRect;
use crate::memory::DepthFormat;
use crate::pipeline::draw_call::{CoarseDepth, DrawStats};
use crate::pipeline::indexed_mesh::IndexedMesh;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::tile::{
    ColorSource, DepthEncoder, DepthF64, DrawJob, Eye, FogParams, FragmentShader, MaterialBinding,
    RecycledBindings, ReferenceFace, Shading, ToScreen, UNSEEN, Winding,
};
use crate::scene::{Cull, Interpolation, ShadeMode};

/// Inputs of a draw, computed once and assembled into a [`DrawJob`] to draw it.
pub(crate) struct DrawInputs<'p> {
    prepared: &'p IndexedMesh,
    to_screen: ToScreen,
    /// Material bindings.
    pub bindings: Vec<MaterialBinding<'p>>,
    /// Pixels that may be drawn.
    pub view: PixelRect,
    light: Light,
    winding: Winding,
    flip_normal: i32,
    back: i32,
    fog: Option<FogParams>,
    is_lit: bool,
    needs_positions: bool,
}

impl PreparedDraw<'_> {
    /// Returns the inputs of this draw, which the tile renderer supports.
    pub(super) fn inputs<'p>(&'p self, recycled: &mut RecycledBindings) -> DrawInputs<'p> {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let (clip, eye) = (self.transform().screen.clip, self.transform().camera.eye);
        let is_lit = self.parts.is_lit();
        let fog = self.fog_params(self.space.point(eye));
        let prepared = self.geometry_info.prepared(mesh, is_lit && call.shade != ShadeMode::Flat);
        let bindings = self.bindings(prepared, recycled);
        let winding = match (call.cull, self.assembler.mirrored) {
            (Cull::None, _) => Winding::Both,
            (Cull::Back, false) | (Cull::Front, true) => Winding::CounterClockwise,
            (Cull::Back, true) | (Cull::Front, false) => Winding::Clockwise,
        };
        // Faces seen from behind flip their normal: clockwise ones, unless the model or window
        // mirrors.
        let flip_normal = match (call.two_sided_lighting, self.assembler.mirrored) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => -1,
        };
        let back = match call.back_material.is_some() && call.cull == Cull::None {
            true => prepared.materials.len() as i32,
            false => 0,
        };
        let needs_positions = (self.parts.uses(Part::InterpolatePositions) || fog.is_some())
            && (call.interp == Interpolation::Affine || matches!(self.space.eye, Eye::Parallel { .. }));
        DrawInputs {
            prepared,
            to_screen: self.to_screen(),
            bindings,
            view: clip,
            light: Light::Constant,
            winding,
            flip_normal,
            back,
            fog,
            is_lit,
            needs_positions,
        }
    }

    /// Computes the draw's lighting and position tables.
    pub(super) fn make_tables(
        &self,
        inputs: &mut DrawInputs<'_>,
        context: DrawContext<'_>,
        tables: &mut Tables,
    ) {
        let DrawInputs { prepared, bindings, is_lit, .. } = &*inputs;
        let DrawContext { level, executor } = context;
        let work = TableWork { prepared, bindings, is_lit: *is_lit, level, executor };
        let light = self.light_tables(&work, tables);
        if inputs.needs_positions {
            self.position_table(&work, &mut tables.positions);
        }
        inputs.light = light;
    }

    /// Calls `work` with the draw's job.
    pub(super) fn with_job<R>(
        &self,
        inputs: &DrawInputs<'_>,
        tables: &Tables,
        format: DepthFormat,
        work: impl FnOnce(&DrawJob<'_>) -> R,
    ) -> R {
        let (prepared, space) = (inputs.prepared, &self.space);
        let plain = |face: u32, own: &mut DrawStats| self.exact_face(face, prepared, own);
        let screen = self.transform().screen;
        let reference_face = |face: u32| {
            let face = self.assemble(face, &mut DrawStats::default())?;
            Some(ReferenceFace::new(face, screen))
        };
        let pixel = |face: u32, x: i32, y: i32| self.shaded_pixel(face, x, y);
        let run = |face: u32, at: [i32; 2], bytes: &mut [u8]| self.shade_run(face, at, bytes);
        let source = match inputs.light {
            Light::Pixels if space.has_own_normals => ColorSource::Pixels(&prepared.normals),
            Light::Pixels => ColorSource::Pixels(&tables.normals),
            Light::Vertices => ColorSource::Vertices(&tables.diffuse, &tables.specular),
            Light::Faces => ColorSource::Faces(&tables.diffuse, &tables.specular),
            Light::Constant => ColorSource::Constant,
        };
        let has_colors = !self.call.geometry.mesh.colors.is_empty();
        let runs_colors = has_colors && matches!(source, ColorSource::Pixels(_) | ColorSource::Constant);
        let has_depth = self.parts.uses(Part::DepthMemory);
        let positions: &[[f32; 4]] = if inputs.needs_positions { &tables.positions } else { &[] };
        let is_affine = self.is_affine() && self.parts.uses(Part::PerspectiveDivision);
        work(&DrawJob {
            mesh: prepared,
            to_screen: &inputs.to_screen,
            complement: self.transform().camera.one_minus_z_row.to_array(),
            winding: inputs.winding,
            view: inputs.view,
            shading: Shading {
                shader: FragmentShader {
                    source,
                    eye: match space.eye {
                        Eye::Perspective { .. } if is_affine => Eye::Interpolated,
                        eye => eye,
                    },
                    colors: if runs_colors { &prepared.colors } else { &[] },
                    texcoords: &prepared.texcoords,
                    positions,
                    fog: inputs.fog,
                    fog_positions: positions,
                },
                bindings: &inputs.bindings,
                back: inputs.back,
                back_facing: if self.assembler.mirrored { -1 } else { 1 },
                is_affine,
                flip_normal: inputs.flip_normal,
                light_error: self.call.light_error.map_or(UNSEEN, |steps| (steps / 255.0) as f32),
                plain: &pixel,
                maps: if self.parts.uses(Part::SurfaceMaps) { Some(&run) } else { None },
            },
            plain: &plain,
            reference_faces: &reference_face,
            name: self.call.name,
            depth_f64: has_depth.then(|| self.depth_f64(format)).flatten(),
            coarse: if self.parts.uses(Part::CoarseDepth) { CoarseDepth::On } else { CoarseDepth::Off },
        })
    }

    /// Returns the transformations from object space to the screen.
    pub fn to_screen(&self) -> ToScreen {
        let t = self.transform();
        let rows = |m: &glam::DMat4| m.transpose().to_cols_array_2d();
        let three = |m: [[f64; 4]; 4]| [m[0], m[1], m[2]];
        let clip = t.screen.clip;
        let sides = [[clip.x0 as f64, clip.x1 as f64], [clip.y0 as f64, clip.y1 as f64]];
        let (center, half) = t.screen.map();
        ToScreen {
            model: three(rows(&t.model)),
            view: three(rows(&t.camera.view)),
            projection: rows(&t.camera.projection),
            center,
            half,
            sides,
        }
    }

    /// Returns the f64 depth computation, if the format requires it.
    fn depth_f64(&self, format: DepthFormat) -> Option<DepthF64> {
        let encoder = DepthEncoder::of(format)?;
        let camera = &self.transform().camera;
        let row = if encoder.is_reversed { camera.one_minus_z_row } else { camera.projection.row(2) };
        Some(DepthF64 { encoder, row: row.to_array() })
    }
}

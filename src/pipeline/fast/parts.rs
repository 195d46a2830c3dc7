//! What a draw's job for the tile renderer is made of: found once a draw, and put together where the job is done.

use super::f32s;
use super::frame::ShadingFrame;
use super::light::{Light, SpareLists, TableWork, Tables};
use crate::memory::DepthFormat;
use crate::pipeline::call::{CoarseDepth, DrawStats};
use crate::pipeline::plan::Part;
use crate::pipeline::prepare::Prepared;
use crate::pipeline::tile::{
    Deep, Eye, Form, Haze, Job, Keep, PreparedMesh, Shading, Source, Surface, ToScreen, View, Workers,
};
use crate::scene::{Cull, Interpolation, ShadeMode};
use crate::simd::Level;

/// See the module's text.
pub(crate) struct Parts<'p> {
    prepared: &'p PreparedMesh,
    frame: ShadingFrame,
    /// The materials.
    pub surfaces: Vec<Surface<'p>>,
    /// Which pixels may be drawn.
    pub view: View,
    light: Light,
    keep: Keep,
    turned: i32,
    back: i32,
    haze: Option<Haze>,
    is_lit: bool,
    needs_positions: bool,
    /// Whether hidden faces are left out tile by tile: off unless it is set.
    pub coarse: CoarseDepth,
}

impl Prepared<'_> {
    /// The parts of this draw; `None` when it is beyond the tile renderer.
    pub(super) fn parts<'p>(&'p self, spare: &mut SpareLists) -> Option<Parts<'p>> {
        let (call, mesh) = (self.call, &self.call.geometry.mesh);
        let clip = self.transform().screen.clip;
        if clip.is_empty() {
            // Everything is outside; the plain path counts it.
            return None;
        }
        let is_lit = self.plan.uses(Part::LightPixels)
            || self.plan.uses(Part::LightVertices)
            || self.plan.uses(Part::LightFaces);
        let frame = self.shading_frame()?;
        let haze = match self.call.fog.filter(|_| self.plan.uses(Part::Fog)) {
            None => None,
            Some(fog) => {
                let eye = frame.axes * (self.transform().camera.eye - frame.origin);
                Some(Haze::new(&fog, f32s(eye))?)
            }
        };
        let prepared = self.known.prepared(mesh, is_lit && call.shade != ShadeMode::Flat);
        let surfaces = self.surfaces(prepared, &frame, spare)?;
        let keep = match (call.cull, self.assembler.mirrored) {
            (Cull::None, _) => Keep::Both,
            (Cull::Back, false) | (Cull::Front, true) => Keep::CounterClockwise,
            (Cull::Back, true) | (Cull::Front, false) => Keep::Clockwise,
        };
        // Faces seen from behind turn: clockwise ones, unless something mirrors.
        let turned = match (call.two_sided_lighting, self.assembler.mirrored) {
            (false, _) => 0,
            (true, false) => 1,
            (true, true) => -1,
        };
        let back = match call.back_material.is_some() && call.cull == Cull::None {
            true => prepared.materials.len() as i32,
            false => 0,
        };
        let needs_positions = (call.shade == ShadeMode::Phong && is_lit || haze.is_some())
            && (call.interp == Interpolation::Affine || matches!(frame.eye, Eye::Parallel { .. }));
        let view = View { x0: clip.x0, y0: clip.y0, x1: clip.x1, y1: clip.y1 };
        let light = Light::Constant;
        let coarse = CoarseDepth::Off;
        Some(Parts {
            prepared,
            frame,
            surfaces,
            view,
            light,
            keep,
            turned,
            back,
            haze,
            is_lit,
            needs_positions,
            coarse,
        })
    }

    /// Works out the tables of the draw.
    pub(super) fn make_tables(
        &self,
        parts: &mut Parts<'_>,
        level: Level,
        crew: &Workers,
        tables: &mut Tables,
    ) {
        let Parts { prepared, frame, surfaces, is_lit, .. } = &*parts;
        let work = TableWork { prepared, frame, surfaces, is_lit: *is_lit, level, crew };
        let light = self.light_tables(&work, tables);
        if parts.needs_positions {
            self.position_table(&work, &mut tables.positions);
        }
        parts.light = light;
    }

    /// Hands the draw's job to `work`.
    pub(super) fn with_job<R>(
        &self,
        parts: &Parts<'_>,
        tables: &Tables,
        format: DepthFormat,
        work: impl FnOnce(&Job<'_>) -> R,
    ) -> R {
        let Parts { prepared, frame, .. } = parts;
        let plain = |face: u32, own: &mut DrawStats| self.wide_face(face, prepared, own);
        let pixel = |face: u32, x: i32, y: i32| self.shaded_pixel(face, x, y);
        let source = match parts.light {
            Light::Pixels if frame.has_own_normals => Source::Pixels(&prepared.normals),
            Light::Pixels => Source::Pixels(&tables.normals),
            Light::Vertices => Source::Vertices(&tables.matte, &tables.gloss),
            Light::Faces => Source::Faces(&tables.matte, &tables.gloss),
            Light::Constant => Source::Constant,
        };
        let has_colors = !self.call.geometry.mesh.colors.is_empty();
        let runs_colors = has_colors && matches!(source, Source::Pixels(_) | Source::Constant);
        let has_depth = self.plan.uses(Part::DepthMemory);
        work(&Job {
            mesh: prepared,
            to_screen: self.to_screen(),
            complement: self.transform().camera.one_minus_z_row.to_array(),
            keep: parts.keep,
            view: parts.view,
            shading: Shading {
                source,
                eye: frame.eye,
                surfaces: &parts.surfaces,
                back: parts.back,
                behind: if self.assembler.mirrored { -1 } else { 1 },
                haze: parts.haze,
                colors: if runs_colors { &prepared.colors } else { &[] },
                texcoords: &prepared.texcoords,
                positions: if parts.needs_positions { &tables.positions } else { &[] },
                is_affine: self.call.interp == Interpolation::Affine
                    && self.plan.uses(Part::PerspectiveDivision),
                turned: parts.turned,
                plain: &pixel,
            },
            plain: &plain,
            name: self.call.name,
            deep: has_depth.then(|| self.deep(format)).flatten(),
            coarse: parts.coarse,
        })
    }

    /// The steps of an object's points to the screen.
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

    /// How depth is worked in f64, where its format asks for that.
    fn deep(&self, format: DepthFormat) -> Option<Deep> {
        let form = Form::of(format)?;
        let camera = &self.transform().camera;
        let row = if form.is_reversed { camera.one_minus_z_row } else { camera.projection.row(2) };
        Some(Deep { form, row: row.to_array() })
    }
}

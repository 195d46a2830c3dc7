//! Faces that are drawn one after the other, made ready for vectors: transparent ones, and those that the painter sorted.

use super::f32s;
use crate::pipeline::assemble::{Face, Side};
use crate::pipeline::call::{DrawCall, Target};
use crate::pipeline::light::Lit;
use crate::pipeline::plan::Part;
use crate::pipeline::prepare::Prepared;
use crate::pipeline::shade::{FaceShade, LightMode};
use crate::pipeline::tile::{Exponent, FRAME_LIMITS, Glow, Haze, Lighting, Sheet, Veil};
use crate::scene::{Material, ShadeMode};
use glam::DVec3;

/// What the faces of one draw share.
pub(crate) struct Veils {
    /// What positions are relative to.
    origin: DVec3,
    /// V, where it is the same everywhere.
    to_viewer: Option<[f32; 3]>,
    /// The materials that are lit at pixels, by their addresses.
    lightings: Vec<(usize, Lighting)>,
}

/// Why the plain path draws the faces of a draw that the tile renderer does not, as far as the plan tells; `None` where vectors
/// draw them one after the other.
pub(crate) fn veil_obstacle(call: &DrawCall, target: &Target) -> Option<&'static str> {
    let (width, height) = (target.memory.width() as usize, target.memory.height() as usize);
    let is_sized = width >= FRAME_LIMITS.0 && width <= FRAME_LIMITS.1 && height <= FRAME_LIMITS.1;
    if call.geometry.mesh.triangles.is_empty() {
        return Some("no face");
    }
    if call.shade == ShadeMode::Wire {
        return Some("SHADE wire: the plain path hides its lines");
    }
    (!is_sized).then_some("the frame is too narrow, too wide or too high for vectors: the plain path")
}

fn address(material: &Material) -> usize {
    std::ptr::from_ref(material).addr()
}

impl Prepared<'_> {
    /// What the faces of this draw share; `None` where the plain path draws them all.
    pub fn veils(&self, target: &Target) -> Option<Veils> {
        if veil_obstacle(self.call, target).is_some() {
            return None;
        }
        let frame = self.shading_frame()?;
        let camera = &self.transform().camera;
        let to_viewer = camera.is_parallel.then(|| f32s(camera.to_viewer));
        let mut lightings: Vec<(usize, Lighting)> = Vec::new();
        if self.plan.uses(Part::LightPixels) {
            let mesh = &self.call.geometry.mesh;
            for &polygon in &self.known.materials {
                for side in [Side::Front, Side::Back] {
                    let (material, _) = self.call.material_of(&mesh.polygons[polygon as usize], side);
                    let is_new = lightings.iter().all(|l| l.0 != address(material));
                    if let Some(lighting) = self.lighting_of(material, frame.origin).filter(|_| is_new) {
                        lightings.push((address(material), lighting));
                    }
                }
            }
        }
        Some(Veils { origin: frame.origin, to_viewer, lightings })
    }

    /// A material's lights in the world's axes, relative to `origin`; `None` where f32 does not carry them.
    fn lighting_of(&self, material: &Material, origin: DVec3) -> Option<Lighting> {
        let constant = self.lighting.constant(material);
        let (matte, gloss) = (f32s(constant.base), f32s(constant.extra));
        let is_finite = matte.iter().chain(&gloss).all(|c| c.abs() < 1e30);
        let exponent = match material.ks == DVec3::ZERO {
            true => Exponent::Whole(0),
            false => Exponent::new(material.n)?,
        };
        let lights = match self.lighting.depends_on_point(material) {
            true => self.lighting.fast(material, |p| p - origin, |d| d, Vec::new())?,
            false => Vec::new(),
        };
        is_finite.then_some(Lighting { matte, gloss, lights, exponent, model: material.model })
    }

    /// A face for vectors; `None` where it is the plain path's: lit by what f32 does not carry.
    pub fn veil<'v>(
        &self,
        veils: &'v Veils,
        triangle: u32,
        face: &Face,
        shade: &FaceShade<'v>,
    ) -> Option<Veil<'v>> {
        let wide = self.wide_of(triangle, self.corner_vertices(triangle), face.clone());
        let haze = match &shade.fog {
            None => None,
            Some((fog, eye)) if fog.visibility_range > 0.0 => {
                Some((Haze::new(fog, [0.0; 3])?, shade.positions.map(|p| f32s(p - *eye))))
            }
            Some(_) => None,
        };
        let parts = |lit: &Lit| [f32s(lit.base), f32s(lit.extra)];
        let glow = match &shade.light {
            LightMode::Constant(lit) => Glow::Solid(parts(lit)),
            LightMode::Vertices(lit) => Glow::Corners(lit.each_ref().map(parts)),
            LightMode::Pixels { material, normals, .. } => Glow::Pixels {
                lighting: &veils.lightings.iter().find(|l| l.0 == address(material))?.1,
                normals: normals.map(f32s),
                positions: shade.positions.map(|p| f32s(p - veils.origin)),
                to_viewer: veils.to_viewer,
            },
        };
        Some(Veil {
            wide,
            glow,
            tints: shade.colors.map(|c| c.map(|c| c.as_vec4().to_array())),
            sheet: shade.texture.map(|(texture, sampling, uv)| Sheet { texture, sampling, uv }),
            haze,
            opacity: shade.opacity as f32,
            is_transparent: shade.is_transparent,
        })
    }
}

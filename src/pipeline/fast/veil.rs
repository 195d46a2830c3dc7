//! Faces that are drawn one after the other, made ready for vectors: transparent ones, and those that the painter sorted.

use super::f32s;
use crate::pipeline::assemble::{Face, Side};
use crate::pipeline::call::{DrawCall, Target};
use crate::pipeline::light::Lit;
use crate::pipeline::plan::Part;
use crate::pipeline::prepare::Prepared;
use crate::pipeline::shade::{FaceShade, LightMode};
use crate::pipeline::tile::{Exponent, FRAME_LIMITS, FastLight, Glow, Haze, Lighting, Sheet, Veil};
use crate::scene::{FillStyle, Material, ShadeMode};
use glam::DVec3;

/// What the faces of one draw share; its lists are kept for another draw.
#[derive(Debug, Default)]
pub(crate) struct Veils {
    state: State,
    /// What positions are relative to.
    origin: DVec3,
    /// V, where it is the same everywhere.
    to_viewer: Option<[f32; 3]>,
    /// The materials that are lit at pixels, by their addresses.
    lightings: Vec<(usize, Lighting)>,
    /// Lists of lights that are not in use.
    spare: Vec<Vec<FastLight>>,
}

/// Who draws the faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum State {
    #[default]
    Unasked,
    Vectors,
    PlainPath,
}

impl Veils {
    /// Makes it ready for another draw.
    pub fn forget(&mut self) {
        self.state = State::Unasked;
        self.spare.extend(self.lightings.drain(..).map(|(_, l)| l.lights).filter(|l| l.capacity() > 0));
    }

    /// Whether it was not made yet.
    pub fn is_unasked(&self) -> bool {
        self.state == State::Unasked
    }

    /// Bytes that its lists take.
    pub fn size_bytes(&self) -> usize {
        let lights = self.spare.iter().chain(self.lightings.iter().map(|(_, l)| &l.lights));
        self.lightings.capacity() * size_of::<(usize, Lighting)>()
            + self.spare.capacity() * size_of::<Vec<FastLight>>()
            + lights.map(|l| l.capacity() * size_of::<FastLight>()).sum::<usize>()
    }
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
    if call.stages.is_some() || call.fill != FillStyle::default() {
        return Some("several textures, or hatches: the plain path");
    }
    (!is_sized).then_some("the frame is too narrow, too wide or too high for vectors: the plain path")
}

fn address(material: &Material) -> usize {
    std::ptr::from_ref(material).addr()
}

impl Prepared<'_> {
    /// Finds what the faces of this draw share, and whether the plain path draws them all.
    pub fn make_veils(&self, target: &Target, veils: &mut Veils) {
        veils.forget();
        veils.state = State::PlainPath;
        if veil_obstacle(self.call, target).is_some() {
            return;
        }
        let Some(frame) = self.shading_frame() else { return };
        veils.state = State::Vectors;
        veils.origin = frame.origin;
        let camera = &self.transform().camera;
        veils.to_viewer = camera.is_parallel.then(|| f32s(camera.to_viewer));
        let Veils { lightings, spare, .. } = veils;
        if self.plan.uses(Part::LightPixels) {
            let mesh = &self.call.geometry.mesh;
            for &polygon in &self.known.materials {
                for side in [Side::Front, Side::Back] {
                    let (material, _) = self.call.material_of(&mesh.polygons[polygon as usize], side);
                    if lightings.iter().any(|l| l.0 == address(material)) {
                        continue;
                    }
                    let mut lights = spare.pop().unwrap_or_default();
                    match self.lighting_of(material, frame.origin, &mut lights) {
                        Some(lighting) => {
                            lightings.push((address(material), Lighting { lights, ..lighting }))
                        }
                        None => spare.push(lights),
                    }
                }
            }
        }
    }

    /// A material's light in the world's axes, relative to `origin`, its lights in the list given; `None` where f32 does not carry
    /// them.
    fn lighting_of(
        &self,
        material: &Material,
        origin: DVec3,
        lights: &mut Vec<FastLight>,
    ) -> Option<Lighting> {
        lights.clear();
        let constant = self.lighting.constant(material);
        let (matte, gloss) = (f32s(constant.base), f32s(constant.extra));
        let is_finite = matte.iter().chain(&gloss).all(|c| c.abs() < 1e30);
        let exponent = match material.ks == DVec3::ZERO {
            true => Exponent::Whole(0),
            false => Exponent::new(material.n)?,
        };
        if self.lighting.depends_on_point(material) {
            self.lighting.fast(material, |p| p - origin, |d| d, lights)?;
        }
        is_finite.then_some(Lighting { matte, gloss, lights: Vec::new(), exponent, model: material.model })
    }

    /// A face for vectors; `None` where it is the plain path's: lit by what f32 does not carry.
    pub fn veil<'v>(
        &self,
        veils: &'v Veils,
        triangle: u32,
        face: &Face,
        shade: &FaceShade<'v>,
    ) -> Option<Veil<'v>> {
        if veils.state != State::Vectors {
            return None;
        }
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

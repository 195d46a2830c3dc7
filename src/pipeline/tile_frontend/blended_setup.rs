//! Setup of faces that vector kernels draw in submission order: transparent ones, and those sorted
//! by the painter's algorithm.

use super::f32s;
use crate::pipeline::assemble::{Face, Facing};
use crate::pipeline::draw_call::{DrawCall, Target};
use crate::pipeline::light::LitColor;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shade::{FaceShade, ShadingFrequency};
use crate::pipeline::tile::{
    BlendedFace, BlendedTexture, FRAME_LIMITS, FaceLighting, FastLight, FogParams, MaterialLighting,
};
use crate::scene::{FillStyle, Material, ShadeMode};
use glam::DVec3;

/// Data that the faces of one draw share; its lists are reused by later draws.
#[derive(Debug, Default)]
pub(crate) struct BlendedSetup {
    state: SetupState,
    /// Origin that positions are relative to.
    origin: DVec3,
    /// View vector V, if it is constant.
    to_viewer: Option<[f32; 3]>,
    /// Materials lit per pixel, keyed by address.
    lightings: Vec<(usize, MaterialLighting)>,
    /// Unused light lists.
    recycled: Vec<Vec<FastLight>>,
}

/// The code path that draws the faces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum SetupState {
    /// Not set up since the last reset.
    #[default]
    Unasked,
    /// Vector kernels, except for single faces that they do not support.
    Vectors,
    /// The plain path draws all faces.
    PlainPath,
}

impl BlendedSetup {
    /// Resets it for another draw, keeping its allocations.
    pub fn forget(&mut self) {
        self.state = SetupState::Unasked;
        self.recycled.extend(self.lightings.drain(..).map(|(_, l)| l.lights).filter(|l| l.capacity() > 0));
    }

    /// Returns whether it has not been set up since the last reset.
    pub fn is_unasked(&self) -> bool {
        self.state == SetupState::Unasked
    }

    /// Returns the bytes that its lists take.
    pub fn size_bytes(&self) -> usize {
        let lights = self.recycled.iter().chain(self.lightings.iter().map(|(_, l)| &l.lights));
        self.lightings.capacity() * size_of::<(usize, MaterialLighting)>()
            + self.recycled.capacity() * size_of::<Vec<FastLight>>()
            + lights.map(|l| l.capacity() * size_of::<FastLight>()).sum::<usize>()
    }
}

/// Returns the reason why the plain path must draw a draw's ordered faces, as far as the plan
/// tells; `None` if vector kernels can draw them.
pub(crate) fn blended_unsupported_reason(call: &DrawCall, target: &Target) -> Option<&'static str> {
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

/// Returns a vector as a record of a table.
fn corner(v: DVec3) -> [f32; 4] {
    v.extend(0.0).as_vec4().to_array()
}

/// Returns a material's address, by which its lighting is found.
fn address(material: &Material) -> usize {
    std::ptr::from_ref(material).addr()
}

impl PreparedDraw<'_> {
    /// Computes what the faces of this draw share, and decides which path draws them.
    pub fn set_up_blended(&self, target: &Target, setup: &mut BlendedSetup) {
        setup.forget();
        setup.state = SetupState::PlainPath;
        if blended_unsupported_reason(self.call, target).is_some() {
            return;
        }
        let Some(frame) = self.shading_space() else { return };
        setup.state = SetupState::Vectors;
        setup.origin = frame.origin;
        let camera = &self.transform().camera;
        setup.to_viewer = camera.is_parallel.then(|| f32s(camera.to_viewer));
        let BlendedSetup { lightings, recycled, .. } = setup;
        if self.plan.uses(Part::LightPixels) {
            let mesh = &self.call.geometry.mesh;
            for &polygon in &self.geometry_info.materials {
                for side in [Facing::Front, Facing::Back] {
                    let (material, _) = self.call.material_of(&mesh.polygons[polygon as usize], side);
                    if lightings.iter().any(|l| l.0 == address(material)) {
                        continue;
                    }
                    let point = |p| p - frame.origin;
                    if let Some(lighting) = self.material_lighting(material, point, |d| d, recycled) {
                        lightings.push((address(material), lighting));
                    }
                }
            }
        }
    }

    /// Returns a face for the vector kernels; `None` if the plain path must draw it, because its
    /// lighting or fog is out of range for f32.
    pub fn blended_face<'v>(
        &self,
        setup: &'v BlendedSetup,
        triangle: u32,
        face: &Face,
        shade: &FaceShade<'v>,
    ) -> Option<BlendedFace<'v>> {
        if setup.state != SetupState::Vectors {
            return None;
        }
        let exact_face = self.exact_face_of(triangle, self.corner_vertices(triangle), face.clone());
        let fog = match &shade.fog {
            None => None,
            Some((fog, eye)) if fog.visibility_range > 0.0 => {
                Some((FogParams::new(fog, [0.0; 3])?, shade.positions.map(|p| corner(p - *eye))))
            }
            Some(_) => None,
        };
        let parts = |lit: &LitColor| [lit.diffuse_ambient, lit.specular_emissive];
        let face_lighting = match &shade.light {
            ShadingFrequency::Constant(lit) => {
                let [diffuse, specular] = parts(lit).map(f32s);
                FaceLighting::Solid(MaterialLighting::constant(diffuse, specular))
            }
            ShadingFrequency::Vertices(lit) => {
                FaceLighting::Corners([0, 1].map(|part| lit.each_ref().map(|lit| corner(parts(lit)[part]))))
            }
            ShadingFrequency::Pixels { material, normals, .. } => FaceLighting::Pixels {
                lighting: &setup.lightings.iter().find(|l| l.0 == address(material))?.1,
                normals: normals.map(corner),
                positions: shade.positions.map(|p| corner(p - setup.origin)),
                to_viewer: setup.to_viewer,
            },
        };
        Some(BlendedFace {
            exact_face,
            face_lighting,
            vertex_colors: shade.colors.map(|c| c.map(|c| c.as_vec4().to_array())),
            texture: shade.texture.map(|(texture, sampling, uv)| BlendedTexture { texture, sampling, uv }),
            fog,
            opacity: shade.opacity as f32,
            is_transparent: shade.is_transparent,
        })
    }
}

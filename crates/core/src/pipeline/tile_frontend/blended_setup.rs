//! Setup of faces that vector kernels draw in submission order: transparent ones, and those sorted
//! by the painter's algorithm.

use crate::pipeline::assemble::Face;
use crate::pipeline::light::LitColor;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shade::{FaceShade, ShadingFrequency};
use crate::pipeline::shading_space::f32s;
use crate::pipeline::tile::{BlendedFace, BlendedTexture, FaceLighting, FastLight, MaterialLighting};
use crate::scene::Material;
use glam::DVec3;

/// Data that the faces of one draw share; its lists are reused by later draws.
#[derive(Debug, Default)]
pub(crate) struct BlendedSetup {
    is_set_up: bool,
    /// Materials lit per pixel, keyed by address.
    lightings: Vec<(usize, MaterialLighting)>,
    /// Unused light lists.
    recycled: Vec<Vec<FastLight>>,
}

impl BlendedSetup {
    /// Resets it for another draw, keeping its allocations.
    pub fn forget(&mut self) {
        self.is_set_up = false;
        self.recycled.extend(self.lightings.drain(..).map(|(_, l)| l.lights).filter(|l| l.capacity() > 0));
    }

    /// Returns whether it has been set up since the last reset.
    pub fn is_set_up(&self) -> bool {
        self.is_set_up
    }

    /// Returns the bytes that its lists take.
    pub fn size_bytes(&self) -> usize {
        let lights = self.recycled.iter().chain(self.lightings.iter().map(|(_, l)| &l.lights));
        self.lightings.capacity() * size_of::<(usize, MaterialLighting)>()
            + self.recycled.capacity() * size_of::<Vec<FastLight>>()
            + lights.map(|l| l.capacity() * size_of::<FastLight>()).sum::<usize>()
    }
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
    /// Computes what the faces of a draw share that its plan leaves to the vector kernels.
    pub fn set_up_blended(&self, setup: &mut BlendedSetup) {
        setup.forget();
        setup.is_set_up = true;
        if !self.parts.uses(Part::LightPixels) {
            return;
        }
        let BlendedSetup { lightings, recycled, .. } = setup;
        for (material, _) in self.materials(&self.geometry_info.materials) {
            let key = address(material);
            if self.lighting.depends_on_point(material) && lightings.iter().all(|l| l.0 != key) {
                let lights = recycled.pop().unwrap_or_default();
                let point = |p| p - self.space.origin;
                let tolerance = self.may_lack(BlendedFace::MAY_LACK);
                let lighting = self.lighting.of_material(material, tolerance, point, |d| d, lights);
                lightings.push((key, lighting));
            }
        }
    }

    /// Returns a face for the vector kernels; `None` if the plan leaves the draw to the reference.
    pub fn blended_face<'v>(
        &self,
        setup: &'v BlendedSetup,
        triangle: u32,
        face: &Face,
        shade: &FaceShade<'v>,
    ) -> Option<BlendedFace<'v>> {
        if !self.parts.uses(Part::FacesInOrder) {
            return None;
        }
        let exact_face = self.exact_face_of(triangle, self.corner_vertices(triangle), face.clone());
        let camera = &self.transform().camera;
        let positions_from = |origin: DVec3| shade.positions.map(|p| corner(p - origin));
        let fog = self.fog_params(DVec3::ZERO).map(|fog| (fog, positions_from(camera.eye)));
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
                positions: positions_from(self.space.origin),
                to_viewer: camera.is_parallel.then(|| f32s(camera.to_viewer)),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_of_lights_are_kept_for_the_next_draw() {
        let lighting = |capacity| MaterialLighting {
            lights: Vec::with_capacity(capacity),
            ..MaterialLighting::constant([0.0; 3], [0.0; 3])
        };
        let mut setup = BlendedSetup { is_set_up: true, ..BlendedSetup::default() };
        setup.lightings.extend([(1, lighting(8)), (2, lighting(0)), (3, lighting(5))]);
        setup.forget();
        assert!(setup.lightings.is_empty() && !setup.is_set_up());
        let mut capacities: Vec<usize> = setup.recycled.iter().map(Vec::capacity).collect();
        capacities.sort_unstable();
        assert_eq!(capacities, [5, 8]);
        assert!(setup.size_bytes() >= 13 * size_of::<FastLight>());
    }
}

//! Setup of faces that vector kernels draw in submission order: transparent ones, and those sorted
//! by the painter's algorithm.

use crate::pipeline::assemble::Face;
use crate::pipeline::light::LitColor;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shade::{FaceShade, ShadingFrequency};
use crate::pipeline::shading_space::f32s;
use crate::pipeline::tile::{
    BlendedFace, BlendedTexture, F32Error, FaceLighting, FastLight, MaterialLighting, Sphere, has_estimate,
};
use crate::scene::Material;
use glam::DVec3;

/// Data that the faces of one draw share; its lists are reused by later draws.
#[derive(Debug, Default)]
pub(crate) struct BlendedSetup {
    is_set_up: bool,
    /// Materials lit per pixel.
    materials: Vec<LitMaterial>,
    /// Unused light lists.
    recycled: Vec<Vec<FastLight>>,
}

impl BlendedSetup {
    /// Resets it for another draw, keeping its allocations.
    pub fn forget(&mut self) {
        self.is_set_up = false;
        self.recycled
            .extend(self.materials.drain(..).map(|m| m.lighting.lights).filter(|l| l.capacity() > 0));
    }

    /// Returns whether it has been set up since the last reset.
    pub fn is_set_up(&self) -> bool {
        self.is_set_up
    }

    /// Returns the bytes that its lists take.
    pub fn size_bytes(&self) -> usize {
        let lights = self.recycled.iter().chain(self.materials.iter().map(|m| &m.lighting.lights));
        self.materials.capacity() * size_of::<LitMaterial>()
            + self.recycled.capacity() * size_of::<Vec<FastLight>>()
            + lights.map(|l| l.capacity() * size_of::<FastLight>()).sum::<usize>()
    }
}

/// Material that is lit per pixel.
#[derive(Debug)]
struct LitMaterial {
    /// Address of the scene's material.
    address: usize,
    lighting: MaterialLighting,
    /// Error of all faces; `None` if each has its own.
    f32_error: Option<F32Error>,
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
        let BlendedSetup { materials, recycled, .. } = setup;
        let sphere = self.sphere();
        for (material, _) in self.materials(&self.geometry_info.materials) {
            let address = address(material);
            if self.lighting.depends_on_point(material) && materials.iter().all(|m| m.address != address) {
                let lights = recycled.pop().unwrap_or_default();
                let point = |p| p - self.space.origin;
                let tolerance = self.may_lack(BlendedFace::MAY_LACK);
                let lighting = self.lighting.of_material(material, tolerance, point, |d| d, lights);
                match has_estimate(lighting.exponent) {
                    true => {
                        let is_parallel = self.transform().camera.is_parallel;
                        let f32_error = sphere.and_then(|s| F32Error::of_mesh(&lighting, &s, is_parallel));
                        materials.push(LitMaterial { address, lighting, f32_error });
                    }
                    false => recycled.push(lighting.lights),
                }
            }
        }
    }

    /// Returns a sphere around the mesh, relative to shading space's origin; `None` without positions.
    fn sphere(&self) -> Option<Sphere> {
        let (low, high) = self.geometry_info.bounds?;
        let (center, half) = ((low + high) * 0.5, (high - low) * 0.5);
        let diagonals = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)];
        let lengths = diagonals
            .map(|(x, y)| self.transform().model.transform_vector3(half * DVec3::new(x, y, 1.0)).length());
        let center = self.transform().world(center) - self.space.origin;
        Some(Sphere { center, radius: lengths.into_iter().fold(0.0, f64::max) })
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
        let from = |origin: DVec3| shade.positions.map(|p| p - origin);
        let fog = self.fog_params(DVec3::ZERO).map(|fog| (fog, from(camera.eye).map(corner)));
        let parts = |lit: &LitColor| [lit.diffuse_ambient, lit.specular_emissive];
        let mut f32_error = F32Error::OF_COLORS;
        let face_lighting = match &shade.light {
            ShadingFrequency::Constant(lit) => {
                let [diffuse, specular] = parts(lit).map(f32s);
                FaceLighting::Solid(MaterialLighting::constant(diffuse, specular))
            }
            ShadingFrequency::Vertices(lit) => {
                FaceLighting::Corners([0, 1].map(|part| lit.each_ref().map(|lit| corner(parts(lit)[part]))))
            }
            ShadingFrequency::Pixels { material, normals, .. } => {
                let lit = setup.materials.iter().find(|m| m.address == address(material))?;
                let (lighting, corners) = (&lit.lighting, from(self.space.origin));
                f32_error = lit
                    .f32_error
                    .unwrap_or_else(|| F32Error::of_pixels(lighting, corners, camera.is_parallel));
                FaceLighting::Pixels {
                    lighting,
                    normals: normals.map(corner),
                    positions: corners.map(corner),
                    to_viewer: camera.is_parallel.then(|| f32s(camera.to_viewer)),
                }
            }
        };
        if let Some(fog) = self.call.fog.filter(|_| fog.is_some()) {
            f32_error = f32_error.in_fog(fog.visibility_range, from(camera.eye));
        }
        Some(BlendedFace {
            exact_face,
            f32_error,
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
        let material = |address, capacity| LitMaterial {
            address,
            lighting: MaterialLighting {
                lights: Vec::with_capacity(capacity),
                ..MaterialLighting::constant([0.0; 3], [0.0; 3])
            },
            f32_error: None,
        };
        let mut setup = BlendedSetup { is_set_up: true, ..BlendedSetup::default() };
        setup.materials.extend([material(1, 8), material(2, 0), material(3, 5)]);
        setup.forget();
        assert!(setup.materials.is_empty() && !setup.is_set_up());
        let mut capacities: Vec<usize> = setup.recycled.iter().map(Vec::capacity).collect();
        capacities.sort_unstable();
        assert_eq!(capacities, [5, 8]);
        assert!(setup.size_bytes() >= 13 * size_of::<FastLight>());
    }
}

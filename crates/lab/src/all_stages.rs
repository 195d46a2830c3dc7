//! Scenes made to run every stage: the switch behind which absence is measured.
//!
//! In: a scene. Out: one of the same picture, for which the plan leaves out less: depth is kept,
//! faces are lit although nothing answers the light, sampled from a texture of one white texel, and
//! fogged by fog that begins too far away. Promise: colours change by less than 1e-8 of full.
//! Blending, sorting and the division by w are left as they are: they would change the picture.

use fbptr_core::pipeline::{DepthUse, SceneOptions};
use fbptr_core::scene::{
    Filter, Fog, FogKind, Geometry, Light, LightingModel, Material, Object, Sampling, Scene, Texture,
};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Reflection that asks for light and shows none of it.
const UNSEEN: f64 = 1e-9;
/// Distance at which fog that nobody sees is complete.
const BEYOND: f64 = 1e12;

/// Returns the scene and the options with every stage that keeps the picture.
pub fn all_stages(scene: &Scene, options: &SceneOptions) -> (Scene, SceneOptions) {
    let mut scene = scene.clone();
    if scene.lights.is_empty() {
        scene.lights.push(Light::directional(DVec3::NEG_Z, DVec3::splat(UNSEEN)));
    }
    let nothing = Fog { color: DVec3::ZERO, kind: FogKind::Linear, visibility_range: BEYOND };
    scene.fog = scene.fog.or(Some(nothing));
    let white = Texture::new(1, 1, vec![255; 4]).ok().map(Arc::new);
    for object in &mut scene.objects {
        light(&mut object.material);
        if let Some(white) = &white {
            texture(object, white);
        }
    }
    (scene, SceneOptions { depth_use: DepthUse::Keep, ..options.clone() })
}

/// Makes a material answer lights.
fn light(material: &mut Material) {
    if material.model == LightingModel::Unlit {
        material.model = LightingModel::Phong;
        (material.ka, material.kd, material.ks) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    }
    if material.kd == DVec3::ZERO {
        material.kd = DVec3::splat(UNSEEN);
    }
}

/// Gives an object without textures a white one.
fn texture(object: &mut Object, white: &Arc<Texture>) {
    let has_textures = object.texture.is_some() || object.geometry.textures.iter().any(Option::is_some);
    if has_textures || object.style.stages.is_some() {
        return;
    }
    let geometry: &mut Geometry = Arc::make_mut(&mut object.geometry);
    if geometry.mesh.texcoords.is_empty() {
        geometry.mesh.texcoords.push(DVec2::ZERO);
        geometry.mesh.corners.iter_mut().for_each(|c| c.texcoord = 0);
    }
    geometry.mesh.materials.iter_mut().for_each(light);
    object.texture = Some((Arc::clone(white), Sampling { filter: Filter::Trilinear, ..Sampling::default() }));
}

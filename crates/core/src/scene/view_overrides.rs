//! Overrides of a scene's camera and modes by its viewer.
//!
//! In: the scene of its author. Out: the scene to draw. Promise: the default overrides change
//! nothing.

use super::{
    Camera, Cull, Geometry, HiddenSurface, LightKind, Material, Navigator, Object, Scene, ShadeMode,
};
use super::{Light, frame_mesh};
use glam::{DMat4, DVec3};
use std::sync::Arc;

/// Use of textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum TextureUse {
    /// As the author chose.
    #[default]
    AsGiven,
    /// No textures.
    Off,
}

/// Use of cheaper drawing that the author allows (`QUALITY`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum QualityUse {
    /// As the author allows.
    #[default]
    AsGiven,
    /// Always exact.
    Exact,
}

/// Overrides of a viewer; `None` keeps the author's choice.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ViewOverrides {
    /// Viewpoint and projection.
    pub navigator: Navigator,
    /// Shading of faces.
    pub shade: Option<ShadeMode>,
    /// Faces that are culled.
    pub cull: Option<Cull>,
    /// Side of points in pixels.
    pub point_size: Option<u32>,
    /// Hidden-surface removal.
    pub hide: Option<HiddenSurface>,
    /// Use of textures.
    pub textures: TextureUse,
    /// Use of cheaper drawing.
    pub quality: QualityUse,
}

impl ViewOverrides {
    /// Applies the overrides to a scene for a viewport of `aspect` = width / height. A scene
    /// without a camera is seen through `camera`.
    pub fn apply(&self, scene: &mut Scene, camera: Camera, aspect: f64) {
        if !self.navigator.is_home() {
            let given = scene.camera.unwrap_or(camera);
            let moved = self.navigator.apply(&given, scene.bounds(), aspect);
            scene.look_through(moved);
        }
        for object in &mut scene.objects {
            object.shade = self.shade.or(object.shade);
            object.cull = self.cull.unwrap_or(object.cull);
            object.style.point_size = self.point_size.unwrap_or(object.style.point_size);
            if self.textures == TextureUse::Off {
                object.texture = None;
                object.style.stages = None;
                let maps = object.style.maps.take();
                if maps.is_some_and(|maps| maps.emission.is_some()) {
                    // Without its map the whole surface would glow.
                    object.material.emissive = DVec3::ZERO;
                }
                if object.geometry.textures.iter().any(Option::is_some) {
                    object.geometry = Arc::new(object.geometry.without_textures());
                }
            }
        }
    }
}

impl Geometry {
    /// Returns the mesh with none of its materials' textures.
    pub fn without_textures(&self) -> Geometry {
        Geometry { mesh: self.mesh.clone(), textures: vec![None; self.textures.len()] }
    }
}

impl Scene {
    /// Replaces the camera; X3D's headlight follows it.
    pub fn look_through(&mut self, camera: Camera) {
        if let Some(theirs) = self.camera {
            let ahead = theirs.look_at.reference - theirs.look_at.eye;
            for light in &mut self.lights {
                match &mut light.kind {
                    LightKind::Directional { direction }
                        if *direction == ahead && light.clamp_attenuation =>
                    {
                        *direction = camera.look_at.reference - camera.look_at.eye;
                    }
                    _ => {}
                }
            }
        }
        self.camera = Some(camera);
    }

    /// Creates a scene of one mesh, framed for a picture of this aspect and lit from the viewer's
    /// upper left. If `is_open`, both sides of its faces are drawn and lit.
    pub fn of_mesh(geometry: Arc<Geometry>, name: &str, aspect: f64, is_open: bool) -> Scene {
        let bounds = geometry.mesh.bounds();
        let camera = bounds.map_or_else(Camera::default, |b| frame_mesh(&geometry.mesh, b, aspect, is_open));
        let object = Object {
            name: name.to_owned(),
            geometry,
            model: DMat4::IDENTITY,
            material: Material { ka: DVec3::splat(0.8), ..Material::default() },
            back_material: None,
            cull: if is_open { Cull::None } else { Cull::default() },
            two_sided_lighting: is_open,
            shade: None,
            texture: None,
            lights: None,
            light_error: None,
            style: Default::default(),
        };
        Scene {
            camera: Some(camera),
            ambient: DVec3::splat(0.15),
            lights: vec![viewers_light(&camera)],
            objects: vec![object],
            ..Scene::default()
        }
    }
}

/// Returns a white directional light from the viewer's upper left.
pub fn viewers_light(camera: &Camera) -> Light {
    let (eye, reference) = (camera.look_at.eye, camera.look_at.reference);
    let ahead = (reference - eye).normalize_or(DVec3::NEG_Z);
    let right = ahead.cross(camera.look_at.up).normalize_or(DVec3::X);
    let up = right.cross(ahead);
    Light::directional(ahead + right * 0.5 - up * 0.5, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ProjectionChoice, shapes};

    fn scene() -> Scene {
        Scene::of_mesh(
            Arc::new(Geometry { mesh: shapes::cuboid(DVec3::ONE).expect("a size"), textures: Vec::new() }),
            "box",
            1.0,
            false,
        )
    }

    #[test]
    fn the_default_lens_changes_nothing() {
        let (mut seen, given) = (scene(), scene());
        ViewOverrides::default().apply(&mut seen, Camera::default(), 1.0);
        assert_eq!(format!("{seen:?}"), format!("{given:?}"));
    }

    #[test]
    fn wishes_reach_every_object_and_the_headlight_follows() {
        let mut seen = scene();
        let camera = seen.camera.expect("framed");
        let ahead = camera.look_at.reference - camera.look_at.eye;
        seen.lights[0] = Light {
            kind: LightKind::Directional { direction: ahead },
            clamp_attenuation: true,
            ..seen.lights[0]
        };
        let mut view_overrides = ViewOverrides {
            shade: Some(ShadeMode::Wire),
            cull: Some(Cull::Front),
            ..ViewOverrides::default()
        };
        view_overrides.navigator.orbit(&camera, DVec3::Y, 1.0, 0.0);
        view_overrides.navigator.projection = ProjectionChoice::Orthographic;
        view_overrides.apply(&mut seen, Camera::default(), 1.0);
        assert_eq!((seen.objects[0].shade, seen.objects[0].cull), (Some(ShadeMode::Wire), Cull::Front));
        let moved = seen.camera.expect("moved").look_at;
        assert_ne!(moved.eye, camera.look_at.eye);
        let LightKind::Directional { direction } = seen.lights[0].kind else { panic!("a headlight") };
        assert_eq!(direction, moved.reference - moved.eye);
    }
}

//! The scene of a `DRAWSCENE`, built from its document.
//!
//! In: a document, a time, and what the session and the display change of the scene. Out: the scene,
//! the same on any thread.

use crate::Session;
use fbptr_core::scene::{Camera, Light, LightKind, Scene, ViewOverrides, Viewport};
use fbptr_formats::load::x3d::X3dDocument;
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Everything that a scene is built from.
pub(super) struct SceneRequest {
    document: Arc<X3dDocument>,
    time: f64,
    /// Width of the viewport over its height.
    aspect: f64,
    /// The session's camera, and whether it replaces the scene's.
    camera: Camera,
    has_own_camera: bool,
    ambient: DVec3,
    own_lights: BTreeMap<usize, Option<Light>>,
    view_overrides: ViewOverrides,
}

impl SceneRequest {
    /// Creates the request of a session.
    pub fn of(
        s: &Session,
        document: Arc<X3dDocument>,
        time: f64,
        viewport: Viewport,
        view_overrides: ViewOverrides,
    ) -> Self {
        SceneRequest {
            document,
            time,
            aspect: f64::from(viewport.width) / f64::from(viewport.height),
            camera: s.camera,
            has_own_camera: s.has_own_camera,
            ambient: s.ambient,
            own_lights: s.own_lights.clone(),
            view_overrides,
        }
    }

    /// Builds the scene, with the session's and the display's changes applied.
    pub fn build(&self) -> Scene {
        let dress = |mut scene: Scene| {
            self.apply_own_state(&mut scene);
            self.view_overrides.apply(&mut scene, self.camera, self.aspect);
            scene
        };
        let scene = dress(self.document.at(self.time));
        match scene.camera.filter(|_| self.document.depends_on_viewer()) {
            // LOD, Billboard and similar nodes depend on the camera in use.
            Some(camera) => {
                // Only one scene at a time is reserved in the memory budget.
                drop(scene);
                dress(self.document.seen_at(self.time, Some(&camera)))
            }
            None => scene,
        }
    }

    /// Applies the camera and lights that the session has set since its SCENE, which take precedence
    /// over the scene's.
    fn apply_own_state(&self, scene: &mut Scene) {
        if self.has_own_camera {
            if let Some(Camera { look_at: theirs, .. }) = scene.camera {
                // The headlight follows the eye.
                let ahead = theirs.reference - theirs.eye;
                for light in &mut scene.lights {
                    match &mut light.kind {
                        LightKind::Directional { direction }
                            if *direction == ahead && light.clamp_attenuation =>
                        {
                            *direction = self.camera.look_at.reference - self.camera.look_at.eye;
                        }
                        _ => {}
                    }
                }
            }
            scene.camera = Some(self.camera);
        }
        scene.ambient = self.ambient;
        for (&index, light) in &self.own_lights {
            match (scene.lights.get_mut(index), light) {
                (Some(theirs), Some(light)) => *theirs = *light,
                // Switched off in place, so that the numbers of later lights stay valid.
                (Some(theirs), None) => (theirs.color, theirs.ambient) = (DVec3::ZERO, DVec3::ZERO),
                (None, Some(light)) => {
                    let number = scene.lights.len() as u32;
                    scene.lights.push(*light);
                    scene.objects.iter_mut().filter_map(|o| o.lights.as_mut()).for_each(|l| l.push(number));
                }
                (None, None) => {}
            }
        }
    }
}

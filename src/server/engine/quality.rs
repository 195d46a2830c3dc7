//! `QUALITY max-error`: the cheapest way of a draw that stays within the error asked for.

use super::Engine;
use crate::error::Fault;
use crate::pipeline::budget::{Budget, BudgetKind, choose};
use crate::pipeline::{DrawCall, SceneOptions};
use crate::scene::{Geometry, Interpolation, Light, Object, Sampling, Scene, ShadeMode, Texture};
use std::sync::Arc;

/// What a DRAW does in place of what its modes say.
pub(super) struct CheaperDraw {
    pub shade: ShadeMode,
    pub sampling: Sampling,
    pub interp: Interpolation,
    pub lights: Vec<Light>,
}

impl Engine {
    /// The cheapest way of one DRAW: its own pixels, on a cleared frame of the memory's size, are what the error is counted on.
    pub(super) fn cheaper_draw(
        &mut self,
        call: &DrawCall,
        geometry: &Arc<Geometry>,
        texture: Option<&Arc<Texture>>,
        max_error: f64,
    ) -> Result<CheaperDraw, Fault> {
        let object = Object {
            name: String::new(),
            geometry: Arc::clone(geometry),
            model: call.model,
            material: call.material.clone(),
            back_material: None,
            cull: call.cull,
            two_sided_lighting: call.two_sided_lighting,
            shade: None,
            texture: texture.map(|t| (Arc::clone(t), call.sampling)),
            lights: None,
        };
        let mut scene = Scene {
            camera: Some(call.camera),
            ambient: call.ambient,
            lights: call.lights.to_vec(),
            objects: vec![object],
            ..Scene::default()
        };
        let (width, height) = (self.memory.width(), self.memory.height());
        let mut options = SceneOptions {
            viewport: call.viewport,
            shade: call.shade,
            hide: call.hide,
            interp: call.interp,
            ..SceneOptions::new(width, height)
        };
        self.choose(&mut scene, &mut options, BudgetKind::Draws, max_error)?;
        let object = &scene.objects[0];
        let kept = |i: &u32| scene.lights[*i as usize];
        Ok(CheaperDraw {
            shade: object.shade.unwrap_or(options.shade),
            sampling: object.texture.as_ref().map_or(call.sampling, |t| t.1),
            interp: options.interp,
            lights: match &object.lights {
                Some(lights) => lights.iter().map(kept).collect(),
                None => scene.lights.clone(),
            },
        })
    }

    /// Changes a scene to its cheapest way.
    pub(super) fn cheaper_scene(
        &mut self,
        scene: &mut Scene,
        options: &mut SceneOptions,
        max_error: f64,
    ) -> Result<(), Fault> {
        self.choose(scene, options, BudgetKind::Scene, max_error)
    }

    fn choose(
        &mut self,
        scene: &mut Scene,
        options: &mut SceneOptions,
        kind: BudgetKind,
        max_error: f64,
    ) -> Result<(), Fault> {
        let budget = Budget {
            scene,
            options,
            kind,
            depth_format: self.depth_format,
            width: self.memory.width(),
            height: self.memory.height(),
            max_error,
        };
        let choice = choose(&mut self.renderer, &budget)?;
        choice.apply(scene, options);
        Ok(())
    }
}

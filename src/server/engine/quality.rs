//! `QUALITY max-error`: the cheapest way of a draw that stays within the error asked for.

use super::Engine;
use crate::error::Fault;
use crate::pipeline::budget::{Budget, BudgetKind};
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
            style: Default::default(),
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
        let choice = self.budgets.choose(&mut self.renderer, &budget)?;
        choice.apply(scene, options);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Command, Decoder, EndOfInput, Flow, Place, Sink, StreamError};
    use crate::server::{Audience, Session};

    struct Runs<'a>(&'a mut Engine, &'a mut Session);

    impl Sink for Runs<'_> {
        fn pixel(&mut self, _: i32, _: i32, _: [u8; 4]) {}
        fn binary_pixels(&mut self, _: &[u8]) {}
        fn command(&mut self, command: Command, _: Place) -> Flow {
            let _ = self.0.run(self.1, command, &mut Vec::new()).expect("a sound command");
            Flow::Continue
        }
        fn error(&mut self, error: StreamError) -> Flow {
            panic!("{error:?}");
        }
    }

    #[test]
    fn a_stream_that_draws_the_same_again_searches_once() {
        let mut engine = Engine::new(32, 24).unwrap();
        let mut session = Session::new(1, Audience::Owner);
        let mut searches = |engine: &mut Engine, text: &str| {
            let mut decoder = Decoder::new(Default::default());
            let mut sink = Runs(engine, &mut session);
            let _ = decoder.feed(text.as_bytes(), &mut sink);
            let _ = decoder.finish(EndOfInput::Stream, &mut sink);
            engine.budgets.searches()
        };
        let scene = "LIGHT 0 DIR 0 0 -1 1 1 1\nMESH m SPHERE 1\nQUALITY max-error 4\nDRAW m\n";
        assert_eq!(searches(&mut engine, scene), 1);
        let frame = engine.memory.bytes().to_vec();
        assert_eq!(searches(&mut engine, "CLEAR 000000\nDRAW m\n"), 1);
        assert_eq!(engine.memory.bytes(), frame);
        assert_eq!(searches(&mut engine, "TRANSLATE 0.5 0 0\nDRAW m\n"), 2);
        assert_eq!(searches(&mut engine, "IDENTITY\nDRAW m\n"), 2);
        assert_eq!(searches(&mut engine, "QUALITY max-error 9\nDRAW m\n"), 3);
        assert_eq!(searches(&mut engine, "MESH m SPHERE 1\nDRAW m\n"), 4);
        assert_eq!(searches(&mut engine, "QUALITY exact\nDRAW m\n"), 4);
    }
}

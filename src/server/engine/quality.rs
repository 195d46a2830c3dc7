//! `QUALITY max-error`: cheaper settings of a draw that stay within the error asked for.
//!
//! In: a draw and its largest error. Out: a choice, or a job that tries one out for a state that is
//! drawn again and again; the draw then runs with the chosen settings.

use super::job::{Job, JobResult};
use super::{Engine, Progress};
use crate::command::Command;
use crate::error::Fault;
use crate::memory::{DepthFormat, MemoryUse};
use crate::pipeline::quality::{self, Budget, BudgetKind, Choice, Search};
use crate::pipeline::{DrawCall, RenderOptions, Renderer, SceneOptions};
use crate::scene::{Geometry, Light, Object, Sampling, Scene, ShadeMode, Texture};
use crate::server::Session;
use std::sync::Arc;

/// Settings of a `DRAW` that replace those of its session.
pub(super) struct CheaperDraw {
    pub shade: ShadeMode,
    pub sampling: Sampling,
    pub lights: Vec<Light>,
}

/// A draw within an error, with everything that the choice depends on. It owns its data, so that it
/// can be searched on another thread.
pub(super) struct QualityRequest {
    pub scene: Scene,
    pub options: SceneOptions,
    pub kind: BudgetKind,
    pub depth_format: DepthFormat,
    pub size: [u32; 2],
    pub max_error: f64,
}

/// Result of a trial.
pub(super) struct Found {
    pub request: QualityRequest,
    choice: Choice,
}

impl QualityRequest {
    fn budget(&self) -> Budget<'_> {
        let [width, height] = self.size;
        Budget {
            scene: &self.scene,
            options: &self.options,
            kind: self.kind,
            depth_format: self.depth_format,
            width,
            height,
            max_error: self.max_error,
        }
    }

    /// Creates a request for one `DRAW` as a scene. The error is measured on its own pixels, on a
    /// cleared frame of the memory's size.
    pub fn of_draw(
        engine: &Engine,
        call: &DrawCall,
        geometry: &Arc<Geometry>,
        texture: Option<&Arc<Texture>>,
        max_error: f64,
    ) -> QualityRequest {
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
        let scene = Scene {
            camera: Some(call.camera),
            ambient: call.ambient,
            lights: call.lights.to_vec(),
            objects: vec![object],
            ..Scene::default()
        };
        let (width, height) = (engine.framebuffer.width(), engine.framebuffer.height());
        let options = SceneOptions {
            viewport: call.viewport,
            shade: call.shade,
            hide: call.hide,
            interp: call.interp,
            ..SceneOptions::new(width, height)
        };
        QualityRequest::of_scene(engine, scene, options, BudgetKind::Draws, max_error)
    }

    /// Creates a request for a scene.
    pub fn of_scene(
        engine: &Engine,
        scene: Scene,
        options: SceneOptions,
        kind: BudgetKind,
        max_error: f64,
    ) -> QualityRequest {
        let (size, depth_format) =
            ([engine.framebuffer.width(), engine.framebuffer.height()], engine.framebuffer.depth_format);
        QualityRequest { scene, options, kind, depth_format, size, max_error }
    }

    /// Returns the mesh of a request from [`QualityRequest::of_draw`].
    pub fn geometry(self) -> Arc<Geometry> {
        Arc::clone(&self.scene.objects[0].geometry)
    }

    /// Returns the settings of the only object of [`QualityRequest::of_draw`], after
    /// [`Engine::settle`].
    pub fn cheaper_draw(&self, call: &DrawCall) -> CheaperDraw {
        let (QualityRequest { scene, options, .. }, object) = (self, &self.scene.objects[0]);
        CheaperDraw {
            shade: object.shade.unwrap_or(options.shade),
            sampling: object.texture.as_ref().map_or(call.sampling, |t| t.1),
            lights: match &object.lights {
                Some(lights) => lights.iter().map(|i| scene.lights[*i as usize]).collect(),
                None => scene.lights.clone(),
            },
        }
    }
}

impl Engine {
    /// Keeps the result of a trial, and returns its request.
    pub(super) fn note_found(&mut self, found: Found) -> QualityRequest {
        self.rendering.choices.replace(&found.request.budget(), found.choice);
        found.request
    }

    /// Counts the draw, and applies its choice to the request; returns the choice so far if the
    /// state is to be tried out.
    pub(super) fn settle(&mut self, request: &mut QualityRequest) -> Option<Choice> {
        match self.rendering.choices.look_up(&request.budget()) {
            Search::Use(choice) => {
                choice.apply(&mut request.scene);
                None
            }
            Search::TryOut(choice) => Some(choice),
        }
    }

    /// Creates the job that tries cheaper settings out; `then` continues the command on the render
    /// thread.
    ///
    /// The job has a renderer of its own. It may use the thread pool only if no other connection
    /// could need it.
    pub(super) fn trial_job(
        &self,
        command: Command,
        request: QualityRequest,
        so_far: Choice,
        then: impl FnOnce(&mut Engine, &mut Session, Found) -> Result<Progress, Fault> + Send + 'static,
    ) -> Result<Progress, Fault> {
        let options = self.rendering.renderer.options();
        let pool = options.pool.clone().filter(|_| self.counters.connections <= 1);
        let options = RenderOptions { pool, ..options.clone() };
        let [width, height] = request.size;
        let bytes = quality::trial_bytes(&request.scene, width, height);
        let (held, memory) =
            (self.quotas.budget.try_reserve(MemoryUse::Draws, bytes)?, self.quotas.budget.clone());
        Ok(Progress::Job(Job::new(false, move |cancel| {
            let mut renderer = Renderer::new(RenderOptions { cancel: cancel.clone(), ..options });
            renderer.set_budget(&memory);
            let choice = quality::try_out(&mut renderer, &request.budget(), so_far);
            let effect = choice.map(|choice| {
                let found = Found { request, choice };
                move |engine: &mut Engine, s: &mut Session, _: &mut Vec<u8>| then(engine, s, found)
            });
            drop((renderer, held));
            JobResult::new(command, effect.map_err(Into::into))
        })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::{Decoder, EndOfInput, Flow, Sink, StreamError, StreamPosition};
    use crate::server::Audience;

    struct Runs<'a>(&'a mut Engine, &'a mut Session);

    impl Sink for Runs<'_> {
        fn pixel(&mut self, _: i32, _: i32, _: [u8; 4]) {}
        fn binary_pixels(&mut self, _: &[u8]) {}
        fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
            let _ = self.0.run(self.1, command, &mut Vec::new()).expect("a sound command");
            Flow::Continue
        }
        fn error(&mut self, error: StreamError) -> Flow {
            panic!("{error:?}");
        }
    }

    #[test]
    fn a_state_that_is_drawn_again_and_again_is_tried_out_once() {
        let mut engine = Engine::new(96, 72).unwrap();
        let mut session = Session::new(1, Audience::Owner);
        let mut trials = |engine: &mut Engine, text: &str| {
            let mut decoder = Decoder::new(Default::default());
            let mut sink = Runs(engine, &mut session);
            let _ = decoder.feed(text.as_bytes(), &mut sink);
            let _ = decoder.finish(EndOfInput::Stream, &mut sink);
            engine.rendering.choices.trials()
        };
        let scene = "LIGHT 0 DIR 0 0 -1 1 1 1\nMESH m SPHERE 1\nQUALITY max-error 40\nDRAW m\n";
        assert_eq!(trials(&mut engine, scene), 0);
        assert_eq!(trials(&mut engine, &"DRAW m\n".repeat(98)), 0);
        assert_eq!(trials(&mut engine, "DRAW m\n"), 1);
        let frame = engine.framebuffer.memory.bytes().to_vec();
        assert_eq!(trials(&mut engine, &"CLEAR 000000\nDRAW m\n".repeat(101)), 1);
        assert_eq!(engine.framebuffer.memory.bytes(), frame);
        let others = "TRANSLATE 0.01 0 0\nDRAW m\n".repeat(150);
        assert_eq!(trials(&mut engine, &others), 1);
        assert_eq!(trials(&mut engine, &format!("QUALITY exact\n{}", "DRAW m\n".repeat(150))), 1);
    }
}

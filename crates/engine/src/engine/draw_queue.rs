//! Small draws that wait for their neighbours, so that threads can share them.
//!
//! In: `DRAW`s of small meshes, each resolved at its turn with the settings of its session. Out: the
//! same pictures, counts and remarks as if each were drawn at its turn. One small draw has too
//! little work for two threads; several that follow each other, with nothing but settings between
//! them, are drawn together ([`Renderer::draw_all`](fbptr_core::pipeline::Renderer::draw_all)).
//!
//! The stream owns the queue. It draws it before it runs anything but settings and small draws,
//! before it reports anything of a later command, and at the end of its slice: nobody sees a frame
//! without a draw that came before. Where something follows draws one by one (a recording, an
//! explanation, a trace), none are queued.

use super::drawing::{Drawing, LONG_NS};
use super::{Effect, Engine, Progress, Request};
use crate::Session;
use fbptr_command::Command;
use fbptr_core::error::Fault;
use fbptr_core::pipeline::{DrawCall, DrawStats};
use fbptr_core::scene::Geometry;
use std::sync::Arc;

/// Maximum number of faces of a mesh whose draw is queued.
const MOST_FACES: usize = 512;

/// Number of draws at which a queue is drawn: they take some hundred kilobytes.
pub(crate) const MOST_DRAWS: usize = 128;

/// Estimated nanoseconds of a queue's draws beyond which it is drawn.
pub(crate) const MOST_NS: u64 = LONG_NS;

/// Maximum number of lights of a session whose draws are queued, each with a copy of them.
const MOST_LIGHTS: usize = 8;

/// Returns whether a command sets something for later draws, and neither reads nor writes the frame
/// or a resource, nor replies.
fn is_setting(command: &Command) -> bool {
    use Command as C;
    matches!(
        command,
        C::LookAt { .. }
            | C::Projection(_)
            | C::Viewport { .. }
            | C::Identity
            | C::Push
            | C::Pop
            | C::Translate(_)
            | C::Rotate { .. }
            | C::Scale(_)
            | C::Shear(_)
            | C::Matrix(_)
            | C::Ambient(_)
            | C::Light { .. }
            | C::Material(_)
            | C::UseTexture { .. }
            | C::Shade(_)
            | C::Cull(_)
            | C::Hide(_)
            | C::Interp(_)
    )
}

impl Engine {
    /// Returns whether a command may run while draws before it wait, and notes whether it may wait
    /// itself.
    pub(crate) fn leaves_draws_waiting(&mut self, s: &Session, command: &Command) -> bool {
        let is_small = |g: Arc<Geometry>| (1..=MOST_FACES).contains(&g.mesh.triangles.len());
        self.queues_draw = match command {
            Command::Draw { name } => self.may_queue(s) && self.mesh(s, name).is_ok_and(is_small),
            _ => false,
        };
        self.queues_draw || is_setting(command)
    }

    /// Returns whether draws of a session may wait: there are threads to share them, and nothing
    /// follows them one by one.
    fn may_queue(&self, s: &Session) -> bool {
        let rendering = &self.rendering;
        rendering.renderer.options().pool.as_ref().is_some_and(|pool| pool.current_num_threads() > 1)
            && rendering.tracing.is_none()
            && rendering.explaining.is_none()
            && rendering.draw_log.is_none()
            && s.surfaces.are_plain()
            && s.lights.len() <= MOST_LIGHTS
            && !s.closes_on_error()
            && !self.wants_contents()
    }

    /// Estimates the nanoseconds of a draw on one thread.
    pub(crate) fn estimated_ns(&self, drawing: &Drawing) -> u64 {
        drawing.estimated_ns(self.framebuffer.area())
    }

    /// Draws queued draws in their order. Returns the result of each, with its remark; a single long
    /// one may be left in pieces.
    pub(crate) fn draw_queued(
        &mut self,
        s: &mut Session,
        mut draws: Vec<Drawing>,
    ) -> Vec<(Result<Progress, Fault>, Option<&'static str>)> {
        if draws.len() == 1
            && let Some(drawing) = draws.pop()
        {
            let command = drawing.command();
            let result = self.guarded(|engine| engine.draw_now(s, drawing));
            return vec![self.end_queued(s, result, command)];
        }
        let calls: Vec<DrawCall> = draws.iter().filter_map(Drawing::mesh_call).collect();
        let results = self.guarded(|engine| {
            let results = engine.rendering.renderer.draw_all(&mut engine.framebuffer.target(), &calls);
            engine.framebuffer.count_target();
            engine.check_abandoned("DRAW").map(|()| results)
        });
        let results: Vec<Result<DrawStats, Fault>> = match results {
            Ok(results) => results.into_iter().map(|result| result.map_err(Fault::from)).collect(),
            // None of them can be told from the one that met a defect.
            Err(fault) => vec![Err(fault); draws.len()],
        };
        let mut ended = Vec::with_capacity(draws.len());
        for (drawing, result) in draws.iter().zip(results) {
            let result = result.map(|stats| {
                self.note_drawn(s, drawing, &stats);
                Progress::Done(Effect::Done)
            });
            ended.push(self.end_queued(s, result, drawing.command()));
        }
        ended
    }

    /// Ends a draw that was queued: counts an error, and sends observers its beginning and end.
    fn end_queued(
        &mut self,
        s: &mut Session,
        result: Result<Progress, Fault>,
        command: Command,
    ) -> (Result<Progress, Fault>, Option<&'static str>) {
        let has_begun = !matches!(result, Ok(Progress::Pieces(_)));
        if has_begun {
            self.send_begin(s, &Request::Command(command));
        }
        let result = self.end_request(s, has_begun, result, &[], &mut Vec::new(), 0);
        (result, s.remark.take())
    }
}

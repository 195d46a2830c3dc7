//! The explanation of a stream's draws (`play --explain`).
//!
//! In: each draw, before it runs. Out: the text of the last one: what it draws, where its view and
//! lights come from, and its plan. The plan is that of the renderer that draws, so an error would
//! show as a stage that `--explain` leaves out and the counters of `STATS` have.

use super::Engine;
use super::drawing::Drawing;
use crate::Session;
use fbptr_core::pipeline::Plan;

/// The last explanation; empty before the first draw.
#[derive(Debug, Default)]
pub(super) struct Explaining {
    text: String,
}

impl Engine {
    /// Begins to explain draws.
    pub fn set_explain(&mut self) {
        self.rendering.explaining = Some(Explaining::default());
    }

    /// Returns the explanation of the last draw, `None` if there was none.
    pub fn explanation(&self) -> Option<&str> {
        let explaining = self.rendering.explaining.as_ref()?;
        Some(explaining.text.as_str()).filter(|text| !text.is_empty())
    }

    /// Explains a draw that is about to run, if this was asked for.
    pub(super) fn explain_drawing(&mut self, s: &Session, drawing: &Drawing) {
        if self.rendering.explaining.is_none() {
            return;
        }
        let target = self.framebuffer.target();
        let (what, plan): (_, Plan) = match drawing {
            Drawing::Mesh(draw) => {
                (format!("DRAW {}", draw.name), self.rendering.renderer.plan_draw(&target, &draw.call()))
            }
            Drawing::Scene(draw) => (
                format!("DRAWSCENE {}", draw.time),
                self.rendering.renderer.plan_scene(&target, &draw.scene, &draw.options),
            ),
        };
        let view = s.default_view.explanation();
        self.rendering.explaining = Some(Explaining { text: format!("{what}\nview: {view}\n{plan}") });
    }
}

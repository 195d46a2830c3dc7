//! The log of draws: the 3-D draws that the frame shows and its latest figures, for questions that are
//! asked afterwards.
//!
//! In: each `DRAW` and `DRAWSCENE` on the frame, and each figure that has numbers to trace. Out: the
//! numbers of a pixel or triangle, and the plans, of the draws since the last `CLEAR`. A logged draw
//! holds its mesh and textures, so only programs that own the engine turn the log on, and its length
//! is bounded.

use super::Engine;
use super::drawing::Drawing;
use super::request::Request;
use super::trace::{Tracing, figure_at};
use crate::Session;
use fbptr_command::{Command, Figure};
use fbptr_core::pipeline::Plan;
use fbptr_core::pipeline::trace::Probe;
use std::collections::VecDeque;
use std::fmt::{self, Write};

/// The latest draws.
pub(super) struct DrawLog {
    draws: VecDeque<Drawing>,
    most: usize,
    /// Number of earlier draws that are no longer logged.
    dropped: u64,
    /// The latest figures, each with the number of draws before it.
    figures: VecDeque<(u64, Figure)>,
}

/// Most figures that are logged, and most corners of one.
const MOST_FIGURES: usize = 4096;
const MOST_CORNERS: usize = 256;

impl DrawLog {
    /// Logs a figure that has numbers to trace.
    fn note(&mut self, figure: &Figure) {
        let is_traced = match figure {
            Figure::FillPoly { points, .. } => points.len() <= MOST_CORNERS,
            Figure::Line { .. } | Figure::LineAa { .. } | Figure::Circle { .. } | Figure::Fill { .. } => true,
            _ => false,
        };
        if is_traced {
            if self.figures.len() >= MOST_FIGURES {
                self.figures.pop_front();
            }
            self.figures.push_back((self.dropped + self.draws.len() as u64, figure.clone()));
        }
    }
}

impl fmt::Debug for DrawLog {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DrawLog({} draws)", self.draws.len())
    }
}

impl Engine {
    /// Logs the 3-D draws on the frame from now on, `most` of them at a time, until the next `CLEAR`
    /// of all of it. Draws that are suspended (those of a `RenderThread`) are
    /// not logged.
    pub fn log_draws(&mut self, most: usize) {
        self.rendering.draw_log =
            Some(DrawLog { draws: VecDeque::new(), most, dropped: 0, figures: VecDeque::new() });
    }

    /// Returns the numbers of a triangle, counted through the logged draws from 0, or of the surface
    /// seen at a pixel, as text; `None` if no logged draw has the triangle or reached the pixel. Where a
    /// figure drew the pixel later, its numbers, and the pixel as it is now.
    pub fn trace_logged(&self, probe: Probe) -> Option<String> {
        let log = self.rendering.draw_log.as_ref()?;
        let traced = |skipped: usize| {
            let mut tracing = Tracing::new(probe);
            log.draws.iter().skip(skipped).for_each(|drawing| tracing.follow(&self.framebuffer, drawing));
            tracing.into_found()
        };
        let Probe::Pixel(x, y) = probe else { return traced(0) };
        let memory = &self.framebuffer.memory;
        let numbers = |figure| figure_at(figure, [memory.width(), memory.height()], [x, y]);
        let latest = log.figures.iter().rev().find_map(|(before, figure)| Some((*before, numbers(figure)?)));
        let Some((before, numbers)) = latest else { return traced(0) };
        traced(before.saturating_sub(log.dropped) as usize).or_else(|| {
            let ([r, g, b, a], at) = (memory.get_pixel(x, y).ok()?, memory.offset_of(x.into(), y.into())?);
            Some(format!("{numbers}now         {r} {g} {b} {a} = #{r:02x}{g:02x}{b:02x} at FBptr[{at}]\n"))
        })
    }

    /// Logs the figures of a request on the frame, without a clip rectangle.
    #[inline]
    pub(super) fn log_figures(&mut self, s: &Session, request: &Request<'_>) {
        let Some(log) = self.rendering.draw_log.as_mut().filter(|_| s.surfaces.are_plain()) else { return };
        match request {
            Request::Command(Command::Figure(figure)) => log.note(figure),
            Request::Lines(lines) => lines
                .iter()
                .for_each(|line| log.note(&Figure::Line { p0: line.p0, p1: line.p1, color: line.color })),
            _ => {}
        }
    }

    /// Returns the plans of the logged draws, as text: the stages that run and the memories that
    /// exist, with the reasons.
    pub fn explain_logged(&mut self) -> String {
        let (width, height) = (self.framebuffer.width(), self.framebuffer.height());
        let log = self.rendering.draw_log.as_ref().filter(|log| !log.draws.is_empty());
        let Some(log) = log else { return Plan::of_2d(width, height).to_string() };
        let mut text = String::new();
        if log.dropped > 0 {
            writeln!(text, "{} earlier draws are no longer logged", log.dropped).expect("a String takes all");
        }
        let target = self.framebuffer.target();
        for drawing in &log.draws {
            let renderer = &self.rendering.renderer;
            let plan = match drawing {
                Drawing::Mesh(draw) => renderer.plan_draw(&target, &draw.call()),
                Drawing::Scene(draw) => renderer.plan_scene(&target, &draw.scene, &draw.options),
            };
            write!(text, "{plan}").expect("a String takes all");
        }
        text
    }

    /// Logs a draw that was made, unless it is on a canvas.
    pub(super) fn log_draw(&mut self, s: &Session, drawing: Drawing) {
        let Some(log) = self.rendering.draw_log.as_mut().filter(|_| !s.surfaces.has_target()) else { return };
        if log.draws.len() >= log.most {
            log.draws.pop_front();
            log.dropped += 1;
        }
        log.draws.push_back(drawing);
    }

    /// Forgets the logged draws, if all of the frame was cleared.
    pub(super) fn clear_draw_log(&mut self, s: &Session) {
        if let Some(log) = self.rendering.draw_log.as_mut().filter(|_| s.surfaces.are_plain()) {
            log.draws.clear();
            log.figures.clear();
            log.dropped = 0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Audience;

    fn run(engine: &mut Engine, session: &mut Session, lines: &str) {
        for line in lines.lines() {
            let command = Command::parse(line.as_bytes(), None).expect(line);
            let _ = engine.run(session, command, &mut Vec::new()).expect(line);
        }
    }

    #[test]
    fn a_pixel_is_traced_after_its_draw_until_the_frame_is_cleared() {
        let mut engine = Engine::new(64, 48).unwrap();
        let mut session = Session::new(1, Audience::Owner);
        assert_eq!(engine.trace_logged(Probe::Pixel(32, 24)), None);
        engine.log_draws(2);
        run(&mut engine, &mut session, "MESH ball SPHERE\nMESH box BOX 9 9 9\nDRAW ball");
        let text = engine.trace_logged(Probe::Pixel(32, 24)).expect("the ball");
        assert!(text.contains("ball") && text.contains("pixel (32, 24)"), "{text}");
        assert_eq!(engine.trace_logged(Probe::Pixel(0, 0)), None);
        // The bytes that the trace ends with are those of the frame.
        let [r, g, b, a] = engine.memory().get_pixel(32, 24).unwrap();
        assert!(text.contains(&format!("{r} {g} {b} {a} = #{r:02x}{g:02x}{b:02x} at FBptr[6272]")), "{text}");
        // A clear of a part, or of a canvas, keeps the draws.
        run(
            &mut engine,
            &mut session,
            "CLIP 0 0 4 4\nCLEAR\nCLIP OFF\nCANVAS c 8 8\nTARGET c\nDRAW box\nCLEAR",
        );
        run(&mut engine, &mut session, "TARGET FRAME");
        assert!(engine.trace_logged(Probe::Pixel(32, 24)).expect("the ball").contains("ball"));
        run(&mut engine, &mut session, "CLEAR");
        assert_eq!(engine.trace_logged(Probe::Pixel(32, 24)), None);
    }

    #[test]
    fn a_figure_is_traced_where_no_later_draw_covers_it() {
        let mut engine = Engine::new(64, 48).unwrap();
        let mut session = Session::new(1, Audience::Owner);
        engine.log_draws(2);
        run(
            &mut engine,
            &mut session,
            "MESH ball SPHERE\nLINE 0 24 63 24 red\nDRAW ball\nCIRCLE 32 24 3 blue",
        );
        let text = |x, y| engine.trace_logged(Probe::Pixel(x, y)).unwrap_or_default();
        assert!(text(1, 24).starts_with("line (0, 24) (63, 24), pixel (1, 24)"), "{}", text(1, 24));
        assert!(
            text(1, 24).ends_with("now         255 0 0 255 = #ff0000 at FBptr[6148]\n"),
            "{}",
            text(1, 24)
        );
        assert!(text(32, 24).contains("ball"));
        assert!(text(32, 21).starts_with("circle of radius 3"));
        run(&mut engine, &mut session, "CLEAR");
        assert_eq!(engine.trace_logged(Probe::Pixel(1, 24)), None);
    }

    #[test]
    fn the_plans_are_those_of_the_latest_draws() {
        let mut engine = Engine::new(64, 48).unwrap();
        let mut session = Session::new(1, Audience::Owner);
        engine.log_draws(2);
        assert!(engine.explain_logged().contains("nothing is drawn in 3-D"));
        run(&mut engine, &mut session, "MESH ball SPHERE\nSHADE flat\nDRAW ball\nSHADE phong\nDRAW ball");
        let text = engine.explain_logged();
        assert_eq!(text.matches("plan: draw of").count(), 2, "{text}");
        assert!(text.contains("+ light faces") && text.contains("+ light pixels"), "{text}");
        run(&mut engine, &mut session, "DRAW ball");
        assert!(engine.explain_logged().starts_with("1 earlier draws are no longer logged\nplan: "));
    }
}

//! Times of the last draws, by which a draw that may take long is taken for a short one.
//!
//! The estimate of a draw takes every face of a larger mesh to fill the viewport, so that nearly
//! each such draw would go to the drawing thread, which costs a small one up to half its time. A
//! program that draws a mesh again and again is better served by what the last draw took.
//!
//! In: draws that the estimate calls long, and the times of those that ran. Out: whether the next
//! one may run on the render thread. The answer is right if the other clients wait no longer than
//! for a draw of an estimated [`MOST_NS`]: so the last time must be below [`LONG_NS`], with the same
//! geometry and modes, and an upper bound of what the draw costs from wherever it is seen must be
//! below [`MOST_NS`] (`MeshExtent` bounds the pixels; a pixel costs what the estimate says). The
//! times decide only who draws: the bytes are the same.

use super::drawing::{Drawing, LONG_NS, bound_ns};
use crate::pipeline::Renderer;
use crate::scene::{Cull, Geometry, HiddenSurface, ShadeMode};
use std::sync::{Arc, Weak};
use std::time::Duration;

/// Greatest bound, in nanoseconds, of a draw that is taken for a short one.
pub(super) const MOST_NS: u64 = 40_000_000;
/// Greatest number of faces of a geometry whose areas are added up.
const MOST_FACES: usize = 400_000;
/// Greatest number of objects of a scene that is remembered.
const MOST_OBJECTS: usize = 16;
/// Number of draws that are remembered.
const MOST_KEPT: usize = 64;

/// Properties that draws must have in common to take similar times.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Modes {
    objects: usize,
    shade: ShadeMode,
    hide: HiddenSurface,
    cull: Cull,
    lights: usize,
    has_texture: bool,
}

/// Times of the last draws in nanoseconds, by their first geometry and modes; the oldest entry first.
#[derive(Debug, Default)]
pub(super) struct DrawTimes(Vec<(Weak<Geometry>, Modes, u64)>);

impl DrawTimes {
    /// Returns whether a draw by `renderer` is short by the last one like it. `frame` is the number
    /// of pixels of the frame.
    pub fn is_short(&self, drawing: &Drawing, frame: u64, renderer: &Renderer) -> bool {
        let Some((first, modes)) = key_of(drawing) else { return false };
        let was_short = self.0.iter().any(|(of, m, ns)| is_of(of, first) && *m == modes && *ns <= LONG_NS);
        was_short && bound_of(drawing, frame, renderer).is_some_and(|ns| ns <= MOST_NS)
    }

    /// Notes what a draw took.
    pub fn note(&mut self, drawing: &Drawing, took: Duration) {
        let Some((first, modes)) = key_of(drawing) else { return };
        let ns = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
        match self.0.iter_mut().find(|(of, m, _)| is_of(of, first) && *m == modes) {
            Some((.., last)) => *last = ns,
            None => {
                if self.0.len() >= MOST_KEPT {
                    self.0.remove(0);
                }
                self.0.push((Arc::downgrade(first), modes, ns));
            }
        }
    }
}

/// Returns an upper bound of the nanoseconds of a draw. Preparing a geometry takes longer than many
/// draws, so there is none if one is not prepared, nor for lines and points.
fn bound_of(drawing: &Drawing, frame: u64, renderer: &Renderer) -> Option<u64> {
    drawing.sum_of_calls(frame, &mut |geometry, call| {
        let mesh = &geometry.mesh;
        if mesh.triangles.len() > MOST_FACES || !(mesh.lines.is_empty() && mesh.points.is_empty()) {
            return None;
        }
        let extent = renderer.extent_of(geometry)?;
        bound_ns(call, frame, |to_clip, view| extent.coverage(to_clip, view))
    })
}

/// Returns whether `kept` refers to this geometry. Until it is dropped, no other one has the same
/// address.
fn is_of(kept: &Weak<Geometry>, geometry: &Arc<Geometry>) -> bool {
    std::ptr::eq(kept.as_ptr(), Arc::as_ptr(geometry))
}

/// Returns the geometry and the modes by which a draw is remembered; `None` for a scene without
/// objects, or with too many.
fn key_of(drawing: &Drawing) -> Option<(&Arc<Geometry>, Modes)> {
    match drawing {
        Drawing::Mesh(draw) => {
            let modes = Modes {
                objects: 0,
                shade: draw.shade,
                hide: draw.hide,
                cull: draw.cull,
                lights: draw.lights.len(),
                has_texture: draw.texture.is_some(),
            };
            Some((&draw.geometry, modes))
        }
        Drawing::Scene(draw) => {
            let objects = &draw.scene.objects;
            let first = objects.first().filter(|_| objects.len() <= MOST_OBJECTS)?;
            let modes = Modes {
                objects: objects.len(),
                shade: draw.options.shade,
                hide: draw.options.hide,
                cull: first.cull,
                lights: draw.scene.lights.len(),
                has_texture: first.texture.is_some(),
            };
            Some((&first.geometry, modes))
        }
    }
}

#[cfg(all(test, feature = "server"))]
mod tests {
    use super::*;
    use crate::command::Command;
    use crate::server::engine::{Engine, Progress, Request};
    use crate::server::{Audience, Budget, Session};

    /// Runs a command as a stream does, and returns whether it went to the drawing thread.
    fn goes_to_its_thread(engine: &mut Engine, session: &mut Session, line: &str) -> bool {
        let command = Command::parse(line.as_bytes(), None).unwrap();
        engine.set_may_suspend(true);
        let mut replies = Vec::new();
        let mut progress = engine.begin(session, Request::Command(command), &mut replies).unwrap();
        let mut is_long = false;
        while let Progress::Pieces(pieces) = progress {
            is_long = true;
            progress = engine.run_pieces(session, *pieces, &mut replies, Budget::NONE).unwrap();
        }
        assert!(matches!(progress, Progress::Done(_)), "{line}");
        is_long
    }

    #[test]
    fn a_draw_goes_to_the_drawing_thread_until_one_like_it_was_short() {
        let (mut engine, mut session) = (Engine::new(320, 240).unwrap(), Session::new(1, Audience::Owner));
        let knot = Command::parse(b"MESH m KNOT 40 20", None).unwrap();
        let _ = engine.run(&mut session, knot, &mut Vec::new()).unwrap();
        let mut pictures = Vec::new();
        let mut draw_after = |ns: u64, setting: &str| {
            // What a draw takes here says nothing: each time is set.
            engine.rendering.draw_times.0.iter_mut().for_each(|(.., last)| *last = ns);
            for line in [setting, "CLEAR"] {
                goes_to_its_thread(&mut engine, &mut session, line);
            }
            let is_long = goes_to_its_thread(&mut engine, &mut session, "DRAW m");
            pictures.push(engine.memory().bytes().to_vec());
            is_long
        };
        let same = "SHADE phong";
        assert!(draw_after(0, same), "the first draw");
        assert!(!draw_after(LONG_NS, same));
        assert!(draw_after(LONG_NS + 1, same));
        assert!(draw_after(0, "SHADE flat"), "of another mode");
        assert!(!draw_after(0, "SHADE flat"));
        assert!(draw_after(0, "LOOKAT 0 0 0.5 0 0 0 0 1 0"), "from within");
        assert!(!draw_after(0, "LOOKAT 0 0 5 0 0 0 0 1 0"));
        assert!(draw_after(0, "SCALE 100000 100000 1"), "whose faces are large");
        assert!(pictures[0] == pictures[1] && pictures[1] == pictures[2] && pictures[0] != pictures[3]);
        assert!(pictures[3] == pictures[4]);
    }
}

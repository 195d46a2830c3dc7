//! Times of the last draws, by which the render thread runs a draw that the estimate calls long.
//!
//! The estimate of a draw takes every face of a larger mesh to fill the viewport, so that nearly
//! each such draw would go to the drawing thread, which costs a small one up to half its time. A
//! program that draws a mesh again and again is better served by what the last draw took.
//!
//! In: draws that the estimate calls long, and the times of those that ran. Out: whether the next
//! one may run on the render thread. It may if
//!
//! - the last draw with the same geometry and modes took at most [`LONG_NS`],
//! - the tile renderer draws it, and all that it needs of its meshes has been computed, and
//! - an upper bound of its time, wherever its meshes lie in view, is at most [`MOST_NS`].
//!
//! The answer is right if the other clients never wait longer than [`MOST_NS`]; `benches/waits.py`
//! tries it. The bound adds what faces, vertices, light and pixels take at worst, with the pixels
//! bounded by `MeshExtent`. The times decide only which thread draws: the bytes are the same.

use super::drawing::{Drawing, LONG_NS, bound_ns, items_ns};
use fbptr_core::pipeline::{Renderer, Target};
use fbptr_core::scene::{Cull, Filter, Geometry, HiddenSurface, ShadeMode};
use std::sync::{Arc, Weak};
use std::time::Duration;

/// Greatest bound, in nanoseconds, of a draw that the render thread runs: a wait that a user of a
/// window hardly notices.
pub(super) const MOST_NS: u64 = 40_000_000;
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
    filter: Option<Filter>,
}

/// Times of the last draws in nanoseconds, by their first geometry and modes; the oldest entry first.
#[derive(Debug, Default)]
pub(super) struct DrawTimes(Vec<(Weak<Geometry>, Modes, u64)>);

impl DrawTimes {
    /// Returns whether a draw on `target` by `renderer` is short by the last one like it.
    pub fn is_short(&self, drawing: &Drawing, target: &Target, renderer: &mut Renderer) -> bool {
        let Some((first, modes)) = key_of(drawing) else { return false };
        let was_short = self.0.iter().any(|(of, m, ns)| is_of(of, first) && *m == modes && *ns <= LONG_NS);
        was_short && bound_of(drawing, target, renderer).is_some_and(|ns| ns <= MOST_NS)
    }

    /// Notes what a draw took that was not refused.
    pub fn note(&mut self, drawing: &Drawing, took: Duration) {
        let Some((first, modes)) = key_of(drawing) else { return };
        self.set(first, modes, u64::try_from(took.as_nanos()).unwrap_or(u64::MAX));
    }

    /// Sets the last time of draws of this geometry and these modes. A full list loses the entries of
    /// dropped geometries, or else its oldest one.
    fn set(&mut self, first: &Arc<Geometry>, modes: Modes, ns: u64) {
        match self.0.iter_mut().find(|(of, m, _)| is_of(of, first) && *m == modes) {
            Some((.., last)) => *last = ns,
            None => {
                if self.0.len() >= MOST_KEPT {
                    self.0.retain(|(of, ..)| of.strong_count() > 0);
                }
                if self.0.len() >= MOST_KEPT {
                    self.0.remove(0);
                }
                self.0.push((Arc::downgrade(first), modes, ns));
            }
        }
    }
}

/// Returns an upper bound of the nanoseconds of a draw on one thread; `None` if there is none, or if
/// the faces alone may take more than [`MOST_NS`].
fn bound_of(drawing: &Drawing, target: &Target, renderer: &mut Renderer) -> Option<u64> {
    let frame = u64::from(target.memory.width()) * u64::from(target.memory.height());
    let mut items = 0u64;
    drawing.sum_of_calls(frame, &mut |call| {
        // Measuring the extents of too many faces would itself take long.
        items = items.saturating_add(items_ns(call));
        if items > MOST_NS {
            return None;
        }
        Some(bound_ns(call, frame, renderer.coverage_by_tiles(target, call)?))
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
                filter: draw.texture.as_ref().map(|_| draw.sampling.filter),
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
                filter: first.texture.as_ref().map(|(_, sampling)| sampling.filter),
            };
            Some((&first.geometry, modes))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::{Engine, Progress, Request};
    use crate::{Audience, Budget, Session};
    use fbptr_command::Command;

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

    /// Returns an engine with a mesh `m`, and a session.
    fn engine_with_a_knot() -> (Engine, Session) {
        let (mut engine, mut session) = (Engine::new(320, 240).unwrap(), Session::new(1, Audience::Owner));
        let knot = Command::parse(b"MESH m KNOT 40 20", None).unwrap();
        let _ = engine.run(&mut session, knot, &mut Vec::new()).unwrap();
        (engine, session)
    }

    #[test]
    fn only_prepared_draws_of_the_tile_renderer_are_short() {
        let (mut engine, mut session) = engine_with_a_knot();
        let mut draw_after_short = |settings: &[&str]| {
            engine.rendering.draw_times.0.iter_mut().for_each(|(.., last)| *last = 0);
            for line in settings {
                goes_to_its_thread(&mut engine, &mut session, line);
            }
            goes_to_its_thread(&mut engine, &mut session, "DRAW m")
        };
        let unlit = "MATERIAL black black black 1 white";
        assert!(
            draw_after_short(&["LIGHT 0 DIR 0 0 -1 1 1 1", "LOOKAT 0 0 9 0 0 0 0 1 0", unlit]),
            "the first"
        );
        assert!(!draw_after_short(&[unlit]));
        let lit = "MATERIAL #11 #cc black 1";
        assert!(draw_after_short(&[lit]), "normals are prepared");
        assert!(!draw_after_short(&[lit]));
        for (line, why) in [
            ("MATERIAL #11 #cc black 1 black .5", "blended faces are drawn in order"),
            ("LIGHT 0 POINT 1e200 0 0 1 1 1", "the light is out of range for vectors"),
        ] {
            assert!(draw_after_short(&[lit, line]), "{why}");
            assert!(draw_after_short(&[lit, line]), "{why}, again");
        }
        assert!(!draw_after_short(&[lit, "LIGHT 0 DIR 0 0 -1 1 1 1"]));
    }

    #[test]
    fn a_full_list_loses_dropped_geometries_and_then_its_oldest_entry() {
        let geometry = || Arc::new(Geometry { mesh: Default::default(), textures: Vec::new() });
        let modes = Modes {
            objects: 0,
            shade: ShadeMode::Phong,
            hide: HiddenSurface::ZBuffer,
            cull: Cull::Back,
            lights: 1,
            filter: None,
        };
        let mut times = DrawTimes::default();
        let kept: Vec<_> = (0..MOST_KEPT).map(|_| geometry()).collect();
        times.set(&kept[0], modes, 1);
        // Each of these is dropped at once.
        (1..MOST_KEPT).for_each(|i| times.set(&geometry(), modes, i as u64));
        times.set(&kept[1], modes, 1);
        assert_eq!(times.0.len(), 2);
        kept.iter().for_each(|geometry| times.set(geometry, modes, 2));
        assert_eq!((times.0.len(), times.0[0].2), (MOST_KEPT, 2));
        times.set(&kept[0], Modes { lights: 2, ..modes }, 3);
        assert!(times.0.len() == MOST_KEPT && is_of(&times.0[0].0, &kept[1]));
    }

    #[test]
    fn a_draw_goes_to_the_drawing_thread_until_one_like_it_was_short() {
        let (mut engine, mut session) = engine_with_a_knot();
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

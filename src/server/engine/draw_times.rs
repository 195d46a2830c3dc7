//! Times of the last draws, by which a draw that may take long is taken for a short one.
//!
//! The estimate of a draw takes every face of a larger mesh to fill the viewport, so that nearly
//! each such draw would go to the drawing thread, which costs a small one a third of its time. A
//! program that draws a mesh again and again is better served by what the last draw took.
//!
//! In: draws that the estimate calls long, and the times of those that ran. Out: whether the next
//! one may run on the render thread. The answer is right if the other clients wait no longer than
//! for a draw of [`MOST_NS`]: so the last time must be below [`LONG_NS`], with the same geometry
//! and modes, and an upper bound of what the draw costs from wherever it is seen must be below
//! [`MOST_NS`]. The bound adds the faces' areas in space, times the largest scale that the
//! projection gives them in the mesh's box: a face cannot cover more. A mesh whose box reaches the
//! eye's plane has no bound. The times decide only who draws: the bytes are the same.

use super::drawing::{Drawing, LONG_NS, PixelBound, bound_ns};
use crate::pipeline::Renderer;
use crate::scene::{Cull, Geometry, HiddenSurface, ShadeMode};
use glam::{DMat4, DVec3};
use std::sync::{Arc, Weak};
use std::time::Duration;

/// Greatest bound, in nanoseconds, of a draw that is taken for a short one.
pub(super) const MOST_NS: u64 = 40_000_000;
/// Greatest number of faces of a geometry whose areas are added up.
const MOST_FACES: usize = 400_000;
/// Greatest number of objects of a scene that is remembered.
const MOST_OBJECTS: usize = 16;
/// Number of draws, and of geometries, that are remembered.
const MOST_KEPT: usize = 64;

/// What draws must have in common to take similar times.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Modes {
    objects: usize,
    shade: ShadeMode,
    hide: HiddenSurface,
    cull: Cull,
    lights: usize,
    has_texture: bool,
}

/// Times of the last draws, and sizes of their geometries, the oldest first.
#[derive(Debug, Default)]
pub(super) struct DrawTimes {
    times: Vec<(Weak<Geometry>, Modes, u64)>,
    extents: Vec<(Weak<Geometry>, Extent)>,
}

impl DrawTimes {
    /// Returns whether a draw by `renderer` is short by the last one like it. `frame` is the number
    /// of pixels of the frame.
    pub fn is_short(&mut self, drawing: &Drawing, frame: u64, renderer: &Renderer) -> bool {
        let Some((first, modes)) = key_of(drawing) else { return false };
        let was_short =
            self.times.iter().any(|(of, m, ns)| is_of(of, first) && *m == modes && *ns <= LONG_NS);
        was_short && self.bound_ns(drawing, frame, renderer).is_some_and(|ns| ns <= MOST_NS)
    }

    /// Notes what a draw took.
    pub fn note(&mut self, drawing: &Drawing, took: Duration) {
        let Some((first, modes)) = key_of(drawing) else { return };
        let ns = u64::try_from(took.as_nanos()).unwrap_or(u64::MAX);
        match self.times.iter_mut().find(|(of, m, _)| is_of(of, first) && *m == modes) {
            Some((.., last)) => *last = ns,
            None => keep(&mut self.times, (Arc::downgrade(first), modes, ns)),
        }
    }

    /// Returns an upper bound of the nanoseconds of a draw, if there is one. Preparing a geometry
    /// takes longer than many draws, so there is none for one that is not prepared.
    fn bound_ns(&mut self, drawing: &Drawing, frame: u64, renderer: &Renderer) -> Option<u64> {
        drawing.sum_of_calls(frame, &mut |geometry, call| {
            if !renderer.is_cached(geometry) {
                return None;
            }
            let extent = self.extent_of(geometry)?;
            bound_ns(call, frame, |to_clip, view| extent.pixels(to_clip, view))
        })
    }

    fn extent_of(&mut self, geometry: &Arc<Geometry>) -> Option<Extent> {
        if let Some((_, extent)) = self.extents.iter().find(|(of, _)| is_of(of, geometry)) {
            return Some(*extent);
        }
        let extent = Extent::of(geometry)?;
        keep(&mut self.extents, (Arc::downgrade(geometry), extent));
        Some(extent)
    }
}

/// Returns whether `kept` refers to this geometry. Until it is dropped, no other one has the same
/// address.
fn is_of(kept: &Weak<Geometry>, geometry: &Arc<Geometry>) -> bool {
    std::ptr::eq(kept.as_ptr(), Arc::as_ptr(geometry))
}

/// Adds an item to a list, which loses its oldest one if it is full.
fn keep<T>(list: &mut Vec<T>, item: T) {
    if list.len() >= MOST_KEPT {
        list.remove(0);
    }
    list.push(item);
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

/// Size of a geometry in object space.
#[derive(Clone, Copy, Debug)]
struct Extent {
    /// Sum of the faces' areas.
    area: f64,
    /// Corners of the box around all positions.
    low: DVec3,
    high: DVec3,
}

impl Extent {
    /// Returns the size of a mesh of faces alone; `None` for other and for large ones.
    fn of(geometry: &Geometry) -> Option<Self> {
        let mesh = &geometry.mesh;
        if mesh.triangles.len() > MOST_FACES || !(mesh.lines.is_empty() && mesh.points.is_empty()) {
            return None;
        }
        let position =
            |corner: u32| mesh.positions.get(mesh.corners.get(corner as usize)?.position as usize).copied();
        let mut area = 0.0;
        for &[a, b, c] in &mesh.triangles {
            let (a, b, c) = (position(a)?, position(b)?, position(c)?);
            area += (b - a).cross(c - a).length() / 2.0;
        }
        let (low, high) = mesh.bounds()?;
        Some(Extent { area, low, high })
    }

    /// Returns upper bounds of the pixels that the faces cover, in a viewport of `view` pixels;
    /// `None` if they may reach the eye's plane.
    fn pixels(&self, to_clip: &DMat4, view: [f64; 2]) -> Option<PixelBound> {
        let (mut nearest, mut low, mut high) = (f64::INFINITY, [f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for corner in 0..8 {
            let side = |axis: usize| if corner >> axis & 1 == 0 { self.low[axis] } else { self.high[axis] };
            let clip = *to_clip * DVec3::new(side(0), side(1), side(2)).extend(1.0);
            if !clip.is_finite() || clip.w <= 0.0 {
                return None;
            }
            nearest = nearest.min(clip.w);
            for axis in 0..2 {
                let at = (clip[axis] / clip.w).clamp(-1.0, 1.0);
                (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
            }
        }
        // The derivative of x / w is (dx - x / w dw) / w, and |x / w| is at most `reach` where the
        // faces are seen.
        let scale = |axis: usize| {
            let reach = low[axis].abs().max(high[axis].abs());
            let [row, w] = [axis, 3].map(|row| to_clip.row(row).truncate().length());
            (row + reach * w) / nearest * view[axis] / 2.0
        };
        let side = |axis: usize| (high[axis] - low[axis]) * view[axis] / 2.0 + 1.0;
        Some(PixelBound { covered: self.area * scale(0) * scale(1), seen: side(0) * side(1) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    #[cfg(feature = "server")]
    use crate::command::Command;
    use crate::scene::{Camera, LookAt, Projection, shapes};
    #[cfg(feature = "server")]
    use crate::server::engine::{Engine, Progress, Request};
    #[cfg(feature = "server")]
    use crate::server::{Audience, Budget, Session};

    fn knot() -> Geometry {
        Geometry { mesh: shapes::knot(120, 24).unwrap(), textures: Vec::new() }
    }

    /// Returns the projection of an eye at `from` on the z axis, onto 400x300 pixels.
    fn seen_from(from: f64, projection: Projection) -> DMat4 {
        let look_at = LookAt { eye: DVec3::new(0.0, 0.0, from), ..Camera::default().look_at };
        let matrices = Camera { look_at, projection }.matrices(4.0 / 3.0).unwrap();
        matrices.projection * matrices.view
    }

    #[test]
    fn no_view_of_a_mesh_covers_more_pixels_than_the_bound() {
        let geometry = knot();
        let extent = Extent::of(&geometry).unwrap();
        let view = [400.0, 300.0];
        let parallel = Projection::Ortho { window: [-4.0, 4.0, -3.0, 3.0], near: 0.1, far: 100.0 };
        for projection in [Camera::default().projection, parallel] {
            for (from, turn) in [(5.0, 0.0), (5.0, 1.1), (8.0, 0.4), (20.0, 2.0)] {
                let to_clip = seen_from(from, projection) * DMat4::from_rotation_x(turn);
                let bound = extent.pixels(&to_clip, view).unwrap();
                let on_screen = |corner: u32| {
                    let mesh = &geometry.mesh;
                    let clip =
                        to_clip * mesh.positions[mesh.corners[corner as usize].position as usize].extend(1.0);
                    [0, 1].map(|axis| clip[axis] / clip.w * view[axis] / 2.0)
                };
                let mut covered = 0.0;
                for triangle in &geometry.mesh.triangles {
                    let [a, b, c] = triangle.map(on_screen);
                    covered += ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs() / 2.0;
                }
                // Faces beyond the viewport's sides are not bounded; these views have none.
                assert!(covered <= bound.covered, "{from} {turn}: {covered} {bound:?}");
                assert!(bound.covered < 12.0 * covered, "{from} {turn}: {covered} {bound:?}");
            }
        }
    }

    #[test]
    fn a_mesh_around_the_eye_has_no_bound() {
        let extent = Extent::of(&knot()).unwrap();
        assert!(extent.pixels(&seen_from(0.5, Camera::default().projection), [400.0, 300.0]).is_none());
    }

    /// Runs a command as a stream does, and returns whether it went to the drawing thread.
    #[cfg(feature = "server")]
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

    #[cfg(feature = "server")]
    #[test]
    fn a_draw_goes_to_the_drawing_thread_until_one_like_it_was_short() {
        let (mut engine, mut session) = (Engine::new(320, 240).unwrap(), Session::new(1, Audience::Owner));
        let knot = Command::parse(b"MESH m KNOT 40 20", None).unwrap();
        let _ = engine.run(&mut session, knot, &mut Vec::new()).unwrap();
        let mut pictures = Vec::new();
        let mut draw_after = |ns: u64, setting: &str| {
            // What a draw takes here says nothing: each time is set.
            engine.rendering.draw_times.times.iter_mut().for_each(|(.., last)| *last = ns);
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

    #[test]
    fn lists_keep_the_latest_entries() {
        let mut list = Vec::new();
        (0..MOST_KEPT + 3).for_each(|i| keep(&mut list, i));
        assert_eq!((list.len(), list[0], list.last()), (MOST_KEPT, 3, Some(&(MOST_KEPT + 2))));
    }
}

//! Tracing of a stream: follows one triangle, or what is seen at one pixel, through the commands.
//!
//! In: a probe, each draw after it was made, and each request before it runs. Out: the numbers of
//! the last draw or figure that the probe met, as text. Figures that have numbers of their own are
//! those of [`draw2d::trace`](fbptr_core::draw2d::trace); of all others the verb is named, if they
//! change the pixel.

use super::drawing::Drawing;
use super::request::Request;
use super::{Engine, EngineFrame};
use crate::Session;
use fbptr_command::{Command, Figure, Rect};
use fbptr_core::draw2d::trace::{trace_circle, trace_fill, trace_fill_poly, trace_line, trace_line_aa};
use fbptr_core::memory::{Rgba, VideoMemory};
use fbptr_core::pipeline::trace::{Probe, trace_draw, trace_scene};
use fbptr_core::scene::HiddenSurface;

/// Largest difference between the depths of the tile renderer and of the reference, which a trace
/// follows.
const DEPTH_TOLERANCE: f64 = 1e-6;

/// The probe, and the numbers found so far.
#[derive(Debug)]
pub(super) struct Tracing {
    probe: Probe,
    /// Number of triangles in the draws so far; triangles are numbered through all draws.
    triangles: u64,
    found: Option<String>,
    /// The latest request, which may not have run yet.
    latest: Option<Latest>,
}

/// A request at the probed pixel.
#[derive(Debug)]
struct Latest {
    verb: &'static str,
    /// The pixel before it.
    before: Rgba,
    /// Numbers of a figure that draws the pixel.
    numbers: Option<String>,
}

/// Returns whether a pixel is in a clip rectangle.
fn is_inside(clip: Rect, [x, y]: [i32; 2]) -> bool {
    let side =
        |v: i32, start: i32, len: i32| (0..i64::from(len)).contains(&(i64::from(v) - i64::from(start)));
    side(x, clip.x, clip.w) && side(y, clip.y, clip.h)
}

/// Returns the numbers of a figure at a pixel of a frame of `size` that it draws.
pub(super) fn figure_at(figure: &Figure, size: [u32; 2], at: [i32; 2]) -> Option<String> {
    match figure {
        Figure::Line { p0, p1, color } => trace_line(*p0, *p1, *color, at),
        Figure::LineAa { p0, p1, color } => trace_line_aa(size, [*p0, *p1], *color, at),
        Figure::Circle { cx, cy, r, color } => trace_circle([*cx, *cy], *r, *color, at),
        Figure::Fill { points, colors } => trace_fill(*points, *colors, at),
        Figure::FillPoly { color, points } => trace_fill_poly(points, *color, at),
        _ => None,
    }
}

/// Returns the numbers, as text, of a command that draws a figure at a pixel of a frame of `size`;
/// `None` for other commands, and where the figure does not draw the pixel. State of a session (`CLIP`,
/// `TARGET`) is not regarded.
pub fn figure_numbers(command: &Command, size: [u32; 2], at: [i32; 2]) -> Option<String> {
    match command {
        Command::Figure(figure) => figure_at(figure, size, at),
        _ => None,
    }
}

/// Returns the numbers of a request's figure at a pixel of a frame of `size` that it draws.
fn numbers_at(request: &Request<'_>, size: [u32; 2], at: [i32; 2]) -> Option<String> {
    match request {
        Request::Command(command) => figure_numbers(command, size, at),
        Request::Lines(lines) => lines.iter().rev().find_map(|l| trace_line(l.p0, l.p1, l.color, at)),
        _ => None,
    }
}

impl Tracing {
    pub(super) fn new(probe: Probe) -> Self {
        Tracing { probe, triangles: 0, found: None, latest: None }
    }

    /// Notes a request that is about to run.
    fn note(&mut self, s: &Session, memory: &VideoMemory, request: &Request<'_>) {
        let Probe::Pixel(x, y) = self.probe else { return };
        let Ok(before) = memory.get_pixel(x, y) else { return };
        self.found = self.settled(memory);
        let is_drawn = !s.surfaces.has_target() && s.surfaces.clip.is_none_or(|clip| is_inside(clip, [x, y]));
        let size = [memory.width(), memory.height()];
        let numbers = if is_drawn { numbers_at(request, size, [x, y]) } else { None };
        self.latest = Some(Latest { verb: request.verb(), before, numbers });
    }

    /// Returns what was found, the latest request included.
    fn settled(&self, memory: &VideoMemory) -> Option<String> {
        let (Some(Latest { verb, before, numbers }), Probe::Pixel(x, y)) = (&self.latest, self.probe) else {
            return self.found.clone();
        };
        match (numbers, *verb) {
            (Some(numbers), _) => Some(numbers.trim_end().to_owned()),
            // They are followed by their faces.
            (None, "DRAW" | "DRAWSCENE") => self.found.clone(),
            (None, verb) => match memory.get_pixel(x, y) {
                Ok(now) if now != *before && verb == "CLEAR" => None,
                Ok(now) if now != *before => {
                    let [r, g, b, a] = now;
                    Some(format!(
                        "pixel ({x}, {y}): {verb} made it {r} {g} {b} {a}, by no numbers that are traced"
                    ))
                }
                _ => self.found.clone(),
            },
        }
    }

    /// Takes the numbers found.
    pub(super) fn into_found(self) -> Option<String> {
        self.found
    }

    /// Traces the probe in a draw that was made on `frame`.
    pub(super) fn follow(&mut self, frame: &EngineFrame, drawing: &Drawing) {
        let (size, format) = ([frame.width(), frame.height()], frame.depth_format);
        let count = match drawing {
            Drawing::Mesh(draw) => draw.geometry.mesh.triangles.len() as u64,
            Drawing::Scene(draw) => {
                draw.scene.objects.iter().map(|o| o.geometry.mesh.triangles.len() as u64).sum()
            }
        };
        let before = self.triangles;
        self.triangles += count;
        let within = |n: u64| n.checked_sub(before).filter(|n| *n < count);
        let probe = match self.probe {
            Probe::Triangle(n) => within(n).map(Probe::Triangle),
            Probe::TriangleAt(n, x, y) => within(n).map(|n| Probe::TriangleAt(n, x, y)),
            pixel @ Probe::Pixel(..) => Some(pixel),
        };
        let traced = probe.map(|probe| match drawing {
            Drawing::Mesh(draw) => trace_draw(&draw.call(), size, format, probe).map(|mut trace| {
                trace.object.1.clone_from(&draw.name);
                trace
            }),
            Drawing::Scene(draw) => trace_scene(&draw.scene, &draw.options, size, format, probe),
        });
        let Some(Ok(found)) = traced else { return };
        if let (Probe::Pixel(x, y), Some(pixel), Some(depth)) = (self.probe, &found.pixel, &frame.depth)
            && drawing.hide() == HiddenSurface::ZBuffer
            && let Some(stored) = depth.z(x, y)
            // An earlier draw may be nearer. Transparent faces write no depth, but are seen where
            // they are nearer.
            && pixel.z > stored + DEPTH_TOLERANCE
        {
            return;
        }
        self.found = Some(found.to_string());
    }
}

impl Engine {
    /// Begins to trace a triangle, numbered from 0 through all draws, or what is seen at a pixel.
    pub fn set_trace(&mut self, probe: Probe) {
        self.rendering.tracing = Some(Tracing::new(probe));
    }

    /// Returns the numbers found, as text; `None` if no draw had the triangle, or nothing drew the
    /// pixel.
    pub fn trace(&self) -> Option<String> {
        self.rendering.tracing.as_ref()?.settled(&self.framebuffer.memory)
    }

    /// Returns whether requests are noted before they run.
    #[inline]
    pub(super) fn follows_requests(&self) -> bool {
        self.rendering.tracing.is_some() || self.rendering.draw_log.is_some()
    }

    /// Notes a request that is about to run.
    #[inline]
    pub(super) fn follow_request(&mut self, s: &Session, request: &Request<'_>) {
        if let Some(tracing) = &mut self.rendering.tracing {
            tracing.note(s, &self.framebuffer.memory, request);
        }
        self.log_figures(s, request);
    }

    /// Traces the probe in a draw that was just made.
    pub(super) fn follow_drawing(&mut self, drawing: &Drawing) {
        if let Some(tracing) = &mut self.rendering.tracing {
            tracing.follow(&self.framebuffer, drawing);
        }
    }
}

//! Tracing of a stream: follows one triangle, or the surface seen at one pixel, through the draws.
//!
//! In: a probe, and each draw after it was made. Out: the numbers of the last draw that the probe
//! met, as text.

use super::drawing::Drawing;
use super::{Engine, EngineFrame};
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
}

impl Tracing {
    pub(super) fn new(probe: Probe) -> Self {
        Tracing { probe, triangles: 0, found: None }
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
    /// Begins to trace a triangle, numbered from 0 through all draws, or the surface seen at a
    /// pixel.
    pub fn set_trace(&mut self, probe: Probe) {
        self.rendering.tracing = Some(Tracing::new(probe));
    }

    /// Returns the numbers found, as text; `None` if no draw had the triangle or reached the pixel.
    pub fn trace(&self) -> Option<&str> {
        self.rendering.tracing.as_ref()?.found.as_deref()
    }

    /// Traces the probe in a draw that was just made.
    pub(super) fn follow_drawing(&mut self, drawing: &Drawing) {
        if let Some(tracing) = &mut self.rendering.tracing {
            tracing.follow(&self.framebuffer, drawing);
        }
    }
}

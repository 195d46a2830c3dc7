//! Tracing of a stream: follows one triangle, or the surface seen at one pixel, through the draws.
//!
//! In: a probe, and each draw after it was made. Out: the numbers of the last draw that the probe
//! met, as text.

use super::Engine;
use crate::pipeline::trace::{Probe, Trace, TraceError, trace_draw, trace_scene};
use crate::pipeline::{DrawCall, SceneOptions};
use crate::scene::{HiddenSurface, Scene};

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

impl Engine {
    /// Begins to trace a triangle, numbered from 0 through all draws, or the surface seen at a
    /// pixel.
    pub fn set_trace(&mut self, probe: Probe) {
        self.rendering.tracing = Some(Tracing { probe, triangles: 0, found: None });
    }

    /// Returns the numbers found, as text; `None` if no draw had the triangle or reached the pixel.
    pub fn trace(&self) -> Option<&str> {
        self.rendering.tracing.as_ref()?.found.as_deref()
    }

    /// Traces the probe in a draw that was just made.
    pub(super) fn follow_draw(&mut self, call: &DrawCall, name: &str) {
        let count = call.geometry.mesh.triangles.len() as u64;
        let (size, format) =
            ([self.framebuffer.width(), self.framebuffer.height()], self.framebuffer.depth_format);
        self.follow(count, call.hide, |probe| {
            let mut trace = trace_draw(call, size, format, probe)?;
            trace.object.1 = name.to_owned();
            Ok(trace)
        });
    }

    /// Traces the probe in a scene that was just drawn.
    pub(super) fn follow_scene(&mut self, scene: &Scene, options: &SceneOptions) {
        let count = scene.objects.iter().map(|o| o.geometry.mesh.triangles.len() as u64).sum();
        let (size, format) =
            ([self.framebuffer.width(), self.framebuffer.height()], self.framebuffer.depth_format);
        self.follow(count, options.hide, |probe| trace_scene(scene, options, size, format, probe));
    }

    fn follow(
        &mut self,
        count: u64,
        hide: HiddenSurface,
        trace: impl FnOnce(Probe) -> Result<Trace, TraceError>,
    ) {
        let Some(tracing) = &mut self.rendering.tracing else { return };
        let before = tracing.triangles;
        tracing.triangles += count;
        let within = |n: u64| n.checked_sub(before).filter(|n| *n < count);
        let probe = match tracing.probe {
            Probe::Triangle(n) => within(n).map(Probe::Triangle),
            Probe::TriangleAt(n, x, y) => within(n).map(|n| Probe::TriangleAt(n, x, y)),
            pixel @ Probe::Pixel(..) => Some(pixel),
        };
        let Some(Ok(found)) = probe.map(trace) else { return };
        if let (Probe::Pixel(x, y), Some(pixel), Some(depth)) = (tracing.probe, &found.pixel, &self.framebuffer.depth)
            && hide == HiddenSurface::ZBuffer
            && let Some(stored) = depth.z(x, y)
            // An earlier draw may be nearer. Transparent faces write no depth, but are seen where
            // they are nearer.
            && pixel.z > stored + DEPTH_TOLERANCE
        {
            return;
        }
        tracing.found = Some(found.to_string());
    }
}

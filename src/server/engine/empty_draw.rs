//! Draws that show nothing: counts them for `STATS`, and explains them to clients that get errors.
//!
//! In: the counts of a draw's stages, and the call if they do not suffice. Out: an [`EmptyDraw`],
//! which is reported once for each reason and connection. Runs on the render thread, after the
//! draw. Promises: the contents of the buffers are not read, so the explanation of a draw depends
//! on nothing but its call and the depths that it met; a draw that writes pixels costs at most one
//! pass over its lights.

use super::Engine;
use crate::pipeline::{DrawCall, DrawStats, SceneOptions};
use crate::scene::{Camera, Light, LightingModel, Material, Mesh, Scene, ShadeMode, Viewport};
use crate::server::Session;
use glam::{DMat4, DVec3};

/// Reason for which a draw shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum EmptyDraw {
    NoContent,
    NoViewport,
    NoLight,
    Culled,
    BehindEye,
    OutsideView,
    TooSmall,
    Hidden,
}

impl EmptyDraw {
    /// Returns the explanation, one line.
    pub fn text(self) -> &'static str {
        match self {
            EmptyDraw::NoContent => "nothing is drawn: there are no faces, lines or points in it",
            EmptyDraw::NoViewport => {
                "nothing is drawn: no pixel of the frame lies in its viewport or rectangle"
            }
            EmptyDraw::NoLight => {
                "all of it is black: there is no light (LIGHT i ..., or AMBIENT with a MATERIAL whose ka is not 0)"
            }
            EmptyDraw::Culled => "nothing is drawn: CULL leaves out all faces in view (CULL none draws them)",
            EmptyDraw::BehindEye => "nothing is drawn: all of it lies behind the eye",
            EmptyDraw::OutsideView => "nothing is drawn: all of it lies outside the view",
            EmptyDraw::TooSmall => "nothing is drawn: no face covers the centre of a pixel",
            EmptyDraw::Hidden => {
                "nothing is drawn: all its pixels lie behind what is there (CLEAR resets depths), or outside near and far"
            }
        }
    }

    fn bit(self) -> u8 {
        1 << self as u8
    }

    /// Returns the reason that the stages' counts show, for a draw that had faces, lines or points
    /// and wrote no pixel.
    fn of_counts(stats: &DrawStats, is_behind_eye: impl FnOnce() -> bool) -> EmptyDraw {
        if stats.pixels_tested > 0 || stats.faces_hidden > 0 {
            EmptyDraw::Hidden
        } else if stats.faces_drawn + stats.lines_drawn + stats.points_drawn > 0 {
            EmptyDraw::TooSmall
        } else if stats.faces_culled > 0 {
            EmptyDraw::Culled
        } else if is_behind_eye() {
            EmptyDraw::BehindEye
        } else if stats.faces_empty > 0 && stats.faces_outside == 0 {
            EmptyDraw::TooSmall
        } else {
            EmptyDraw::OutsideView
        }
    }
}

impl Engine {
    /// Returns the reason why a `DRAW` of `call` showed nothing, by the counts of its stages;
    /// `None` if it showed something. `is_dark` is [`is_dark`] of the original call, before
    /// `QUALITY` changed it.
    pub(super) fn empty_call(&self, stats: &DrawStats, call: &DrawCall, is_dark: bool) -> Option<EmptyDraw> {
        let mesh = &call.geometry.mesh;
        Some(match stats.pixels_written {
            0 if is_without_content(mesh) => EmptyDraw::NoContent,
            0 if !self.is_on_frame(call.viewport) => EmptyDraw::NoViewport,
            0 => EmptyDraw::of_counts(stats, || is_behind_eye(&call.camera, mesh.bounds(), call.model)),
            _ if is_dark => EmptyDraw::NoLight,
            _ => return None,
        })
    }

    /// Returns the reason why a `DRAWSCENE` showed nothing; `None` if it showed something.
    pub(super) fn empty_scene(
        &self,
        stats: &DrawStats,
        scene: &Scene,
        options: &SceneOptions,
    ) -> Option<EmptyDraw> {
        let is_empty = || scene.objects.iter().all(|object| is_without_content(&object.geometry.mesh));
        let is_dark = |object| is_dark(&DrawCall::of_object(object, scene, options));
        let camera = scene.camera.unwrap_or(options.camera);
        Some(match stats.pixels_written {
            0 if is_empty() => EmptyDraw::NoContent,
            0 if !self.is_on_frame(options.viewport) => EmptyDraw::NoViewport,
            0 => EmptyDraw::of_counts(stats, || is_behind_eye(&camera, scene.bounds(), DMat4::IDENTITY)),
            _ if scene.lights.iter().all(is_off) && scene.objects.iter().all(is_dark) => EmptyDraw::NoLight,
            _ => return None,
        })
    }

    /// Returns whether a viewport contains any pixel of the frame.
    fn is_on_frame(&self, viewport: Viewport) -> bool {
        let meets = |start: i32, length: u32, side: u32| {
            let (start, end) = (i64::from(start), i64::from(start) + i64::from(length));
            length > 0 && start < i64::from(side) && end > 0
        };
        meets(viewport.x, viewport.width, self.framebuffer.width())
            && meets(viewport.y, viewport.height, self.framebuffer.height())
    }
}

/// Counts a draw that shows nothing, and explains it if the client gets errors and has not been
/// sent this reason before.
pub(super) fn note(s: &mut Session, empty: Option<EmptyDraw>) {
    let Some(reason) = empty else { return };
    s.stats.empty_draws += 1;
    if s.reports_errors() && s.explained_draws & reason.bit() == 0 {
        s.explained_draws |= reason.bit();
        s.remark = Some(reason.text());
    }
}

fn is_without_content(mesh: &Mesh) -> bool {
    mesh.triangles.is_empty() && mesh.lines.is_empty() && mesh.points.is_empty()
}

fn is_off(light: &Light) -> bool {
    light.color == DVec3::ZERO && light.ambient == DVec3::ZERO
}

/// Returns whether a draw is certainly black, whatever it covers: faces only, no light on, no
/// emissive color.
pub(super) fn is_dark(call: &DrawCall) -> bool {
    let reaches = |i: usize| call.light_subset.is_none_or(|subset| subset.contains(&(i as u32)));
    if call.lights.iter().enumerate().any(|(i, light)| !is_off(light) && reaches(i)) {
        return false;
    }
    let mesh = &call.geometry.mesh;
    let is_black = |m: &Material| {
        m.model != LightingModel::Unlit && m.emissive == DVec3::ZERO && m.ka * call.ambient == DVec3::ZERO
    };
    call.shade != ShadeMode::Wire
        && call.fog.is_none()
        && mesh.lines.is_empty()
        && mesh.points.is_empty()
        && is_black(call.material)
        && call.back_material.is_none_or(is_black)
        && mesh.materials.iter().all(is_black)
}

/// Returns whether all corners of a box, transformed to world space by `model`, lie behind the eye.
fn is_behind_eye(camera: &Camera, bounds: Option<(DVec3, DVec3)>, model: DMat4) -> bool {
    // The aspect ratio does not matter here.
    let (Some((low, high)), Ok(matrices)) = (bounds, camera.matrices(1.0)) else { return false };
    (0..8).all(|i| {
        let pick = |k: usize| if i >> k & 1 == 1 { high[k] } else { low[k] };
        (matrices.view * model * DVec3::new(pick(0), pick(1), pick(2)).extend(1.0)).z >= 0.0
    })
}

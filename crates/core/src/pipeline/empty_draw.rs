//! Draws that show nothing, and why.
//!
//! In: the counts of a draw's stages, its call and its clip rectangle where they do not suffice.
//! Out: an [`EmptyDraw`].
//! Promises: the contents of the buffers are not read, so the reason depends on nothing but the call
//! and the depths that it met; for a draw that writes pixels it costs at most one pass over its
//! lights and materials, and over its faces up to the first that is not fully transparent.

use super::{DrawCall, DrawStats, SceneOptions};
use crate::memory::VideoMemory;
use crate::scene::{
    Camera, Light, LightingModel, Material, Mesh, NONE, Scene, ShadeMode, Viewport, box_corners,
};
use glam::{DMat4, DVec3};
use std::fmt;
use std::ops::Range;

/// Reason for which a draw shows nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EmptyDraw {
    /// There are no faces, lines or points in it.
    NoContent,
    /// No pixel of the frame lies in its viewport.
    NoViewport,
    /// All of it is black: no light reaches it, and it emits none.
    NoLight,
    /// All of it is fully transparent.
    Transparent,
    /// All faces in view are left out by the side seen.
    Culled,
    /// All of it lies behind the eye.
    BehindEye,
    /// All of it lies outside the view.
    OutsideView,
    /// No face covers the centre of a pixel.
    TooSmall,
    /// All its pixels lie behind what is there, or outside near and far.
    Hidden,
    /// No pixel of it lies in the clip rectangle.
    Clipped,
}

impl fmt::Display for EmptyDraw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EmptyDraw::NoContent => "there are no faces, lines or points in it",
            EmptyDraw::NoViewport => "no pixel of the frame lies in its viewport",
            EmptyDraw::NoLight => "all of it is black: no light reaches it, and it emits none",
            EmptyDraw::Transparent => "all of it is fully transparent",
            EmptyDraw::Culled => "all faces in view are left out by the side seen",
            EmptyDraw::BehindEye => "all of it lies behind the eye",
            EmptyDraw::OutsideView => "all of it lies outside the view",
            EmptyDraw::TooSmall => "no face covers the centre of a pixel",
            EmptyDraw::Hidden => "all its pixels lie behind what is there, or outside near and far",
            EmptyDraw::Clipped => "no pixel of it lies in the clip rectangle",
        })
    }
}

impl EmptyDraw {
    /// Returns the reason why a draw of `call` on this memory, within its clip rectangle, showed
    /// nothing, by the counts of its stages; `None` if it showed something. `is_dark` is [`is_dark`]
    /// of the call as it was wanted.
    pub fn of_call(
        stats: &DrawStats,
        call: &DrawCall,
        memory: &VideoMemory,
        is_dark: bool,
    ) -> Option<EmptyDraw> {
        let mesh = &call.geometry.mesh;
        let is_behind_eye = || is_behind_eye(&call.camera, mesh.bounds(), call.model);
        Some(match stats.pixels_written {
            0 if is_without_content(mesh) => EmptyDraw::NoContent,
            0 => EmptyDraw::of_counts(stats, call.viewport, memory, is_behind_eye),
            _ if is_clear(call) => EmptyDraw::Transparent,
            _ if is_dark => EmptyDraw::NoLight,
            _ => return None,
        })
    }

    /// Returns the reason why the draw of a scene on this memory, within its clip rectangle, showed
    /// nothing; `None` if it showed something.
    pub fn of_scene(
        stats: &DrawStats,
        scene: &Scene,
        options: &SceneOptions,
        memory: &VideoMemory,
    ) -> Option<EmptyDraw> {
        let is_empty = || scene.objects.iter().all(|object| is_without_content(&object.geometry.mesh));
        let is_dark = |object| is_dark(&DrawCall::of_object(object, scene, options));
        let is_clear = |object| is_clear(&DrawCall::of_object(object, scene, options));
        let camera = scene.camera.unwrap_or(options.camera);
        Some(match stats.pixels_written {
            0 if is_empty() => EmptyDraw::NoContent,
            0 => {
                let is_behind_eye = || is_behind_eye(&camera, scene.bounds(), DMat4::IDENTITY);
                EmptyDraw::of_counts(stats, options.viewport, memory, is_behind_eye)
            }
            _ if scene.objects.iter().all(is_clear) => EmptyDraw::Transparent,
            _ if scene.lights.iter().all(is_off) && scene.objects.iter().all(is_dark) => EmptyDraw::NoLight,
            _ => return None,
        })
    }

    /// Returns the reason why nothing can be drawn in an area of this memory; `None` if a pixel of it
    /// can be.
    #[doc(hidden)]
    pub fn of_area(area: Viewport, memory: &VideoMemory) -> Option<EmptyDraw> {
        if !meets(area, [0..memory.width(), 0..memory.height()]) {
            return Some(EmptyDraw::NoViewport);
        }
        (!meets(area, memory.clip())).then_some(EmptyDraw::Clipped)
    }

    /// Returns the reason that the stages' counts show, for a draw that had faces, lines or points
    /// and wrote no pixel.
    fn of_counts(
        stats: &DrawStats,
        viewport: Viewport,
        memory: &VideoMemory,
        is_behind_eye: impl FnOnce() -> bool,
    ) -> EmptyDraw {
        if let Some(reason) = EmptyDraw::of_area(viewport, memory) {
            return reason;
        }
        let reason = if stats.pixels_tested > 0 || stats.faces_hidden > 0 {
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
        };
        match reason {
            // The stages leave out at the clip rectangle's border what lies outside, as at the view's.
            EmptyDraw::TooSmall | EmptyDraw::OutsideView if memory.is_clipped() => EmptyDraw::Clipped,
            reason => reason,
        }
    }
}

/// Returns whether a viewport contains any pixel of these columns and rows.
fn meets(viewport: Viewport, [columns, rows]: [Range<u32>; 2]) -> bool {
    let meets = |start: i32, length: u32, within: Range<u32>| {
        let (start, end) = (i64::from(start), i64::from(start) + i64::from(length));
        length > 0 && start < i64::from(within.end) && end > i64::from(within.start)
    };
    meets(viewport.x, viewport.width, columns) && meets(viewport.y, viewport.height, rows)
}

fn is_without_content(mesh: &Mesh) -> bool {
    mesh.triangles.is_empty() && mesh.lines.is_empty() && mesh.points.is_empty()
}

fn is_off(light: &Light) -> bool {
    light.color == DVec3::ZERO && light.ambient == DVec3::ZERO
}

/// Returns whether a draw is certainly black, whatever it covers: faces only, no light on, no
/// emissive color.
pub fn is_dark(call: &DrawCall) -> bool {
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

/// Returns the material of each face, line and point of a draw.
fn materials_of<'a>(call: &'a DrawCall) -> impl Iterator<Item = &'a Material> {
    let mesh = &call.geometry.mesh;
    let polygons = mesh.polygons.iter().map(|polygon| polygon.material);
    let lines = (0..mesh.lines.len()).map(|i| mesh.line_materials.get(i).copied().unwrap_or(NONE));
    let points = (0..mesh.points.len()).map(|i| mesh.point_materials.get(i).copied().unwrap_or(NONE));
    let numbers = polygons.chain(lines).chain(points);
    numbers.map(|number| mesh.materials.get(number as usize).unwrap_or(call.material))
}

/// Returns whether all of a draw is fully transparent, whatever it covers.
fn is_clear(call: &DrawCall) -> bool {
    let is_clear = |m: &Material| m.transparency >= 1.0;
    let mut all = call.geometry.mesh.materials.iter().chain([call.material]);
    all.any(is_clear) && call.back_material.is_none_or(is_clear) && materials_of(call).all(is_clear)
}

/// Returns whether light would show any face of a scene: its material reflects light, and its
/// texture or the vertices' colors are not black.
#[doc(hidden)]
pub fn reflects_light(scene: &Scene, options: &SceneOptions) -> bool {
    let is_lit = |m: &Material| m.model != LightingModel::Unlit;
    let reflects = |m: &Material| is_lit(m) && (m.kd != DVec3::ZERO || m.ks != DVec3::ZERO);
    let has_color = |texture: &crate::scene::Texture| {
        texture.bytes().as_chunks::<4>().0.iter().any(|[r, g, b, a]| [r, g, b] != [&0; 3] && *a > 0)
    };
    scene.fog.is_none()
        && scene.objects.iter().any(|object| {
            let call = DrawCall::of_object(object, scene, options);
            let mesh = &object.geometry.mesh;
            let mut textures = object.geometry.textures.iter().flatten().map(|t| &**t).chain(call.texture);
            let is_colored =
                mesh.colors.is_empty() || mesh.colors.iter().any(|c| c.truncate() != DVec3::ZERO);
            let is_wire = call.shade == ShadeMode::Wire;
            !is_wire && is_colored && textures.all(has_color) && materials_of(&call).any(reflects)
        })
}

/// Returns whether all corners of a box, transformed to world space by `model`, lie behind the eye.
fn is_behind_eye(camera: &Camera, bounds: Option<(DVec3, DVec3)>, model: DMat4) -> bool {
    // The aspect ratio does not matter here.
    let (Some(bounds), Ok(matrices)) = (bounds, camera.matrices(1.0)) else { return false };
    box_corners(bounds).iter().all(|corner| (matrices.view * model * corner.extend(1.0)).z >= 0.0)
}

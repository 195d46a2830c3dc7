//! Costs of settings: a calibration table of the tile renderer, and estimates made from it.
//!
//! The table is fixed, so that choices are the same on every machine, with every number of threads
//! and vector width. Its figures are measured: docs/notes/error-budget.md has the machine, the
//! command and the frames that they come from. One unit is a nanosecond of that machine.

use crate::pipeline::draw_call::DrawCall;
use crate::pipeline::ndc_box::NdcBox;
use crate::scene::{Filter, Light, LightKind, LightingModel, ShadeMode};
use glam::DVec3;

/// Covered pixel without light: clear, coverage, depth and a constant colour.
const PIXEL: f64 = 4.0;
/// Face without light: transformation, set-up, bins.
const FACE: f64 = 7.0;
/// Pixel of Phong shading, without its lights.
const PHONG: f64 = 2.9;
/// Pixel of Gouraud shading.
const GOURAUD: f64 = 2.2;
/// Pixel of flat shading.
const FLAT: f64 = 0.3;
/// Light from a direction at a pixel.
const DIRECTIONAL: f64 = 0.25;
/// Any other light at a pixel.
const POINT: f64 = 0.4;
/// Specular term of a light at a pixel.
const SPECULAR: f64 = 0.5;
/// Vertex or face that is lit before the pixels, without its lights.
const TABLE_ENTRY: f64 = 9.0;
/// Light, or its specular term, at such a vertex or face.
const TABLE_LIGHT: f64 = 0.25;
/// Face whose angles are measured.
const MEASURED_FACE: f64 = 45.0;
/// Choice of an object's settings, and of one of its lights.
const CHOICE: f64 = 150.0;
const CHOICE_LIGHT: f64 = 15.0;

/// Exact frames that measuring a mesh may cost at most.
const MOST_FRAMES: f64 = 2.0;
/// Part of an object's exact cost that choosing its settings may cost at most.
const CHOICE_PART: f64 = 1.0 / 50.0;

/// Returns the cost of a filter at a pixel.
fn filter_cost(filter: Filter) -> f64 {
    match filter {
        Filter::Nearest => 3.3,
        Filter::Bilinear => 4.7,
        Filter::Mipmap => 7.2,
        Filter::Trilinear => 10.2,
    }
}

/// Cost of drawing an object, in two parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Cost {
    /// Cost of the covered pixels, and of the faces without light.
    pub pixels: f64,
    /// Cost of lighting vertices or faces, seen or not.
    pub tables: f64,
}

/// Pixels of a face from which on it is set up in f64, and light may be interpolated over it.
const LARGE_FACE: f64 = 1000.0;

impl Cost {
    /// Returns the sum.
    pub fn sum(self) -> f64 {
        self.pixels + self.tables
    }
}

/// Numbers that the costs of one draw are computed from.
pub(super) struct ObjectCosts<'a> {
    lights: &'a [Light],
    pixels: f64,
    faces: f64,
    vertices: f64,
    is_lit: bool,
    is_shiny: bool,
    /// Cost of the texture at a pixel.
    texture: f64,
}

impl<'a> ObjectCosts<'a> {
    /// Creates the costs of a draw that covers `pixels` pixels.
    pub fn of(call: &DrawCall<'a>, pixels: f64) -> ObjectCosts<'a> {
        let mesh = &call.geometry.mesh;
        let mut materials = mesh.materials.iter().chain([call.material]);
        ObjectCosts {
            lights: call.lights,
            pixels,
            faces: mesh.triangles.len() as f64,
            vertices: mesh.positions.len().max(mesh.normals.len()).min(mesh.corners.len()) as f64,
            is_lit: materials.any(|m| m.model != LightingModel::Unlit),
            is_shiny: is_shiny(call),
            texture: call.texture.map_or(0.0, |_| filter_cost(call.sampling.filter)),
        }
    }

    /// Returns the cost of drawing in a shading mode under these lights.
    pub fn drawing(&self, shade: ShadeMode, lights: impl Iterator<Item = u32>) -> Cost {
        let (mut at_pixel, mut count) = (0.0, 0.0);
        for light in lights.filter_map(|l| self.lights.get(l as usize)) {
            count += 1.0;
            at_pixel += match light.kind {
                LightKind::Directional { .. } => DIRECTIONAL,
                _ => POINT,
            };
            at_pixel += if self.is_shiny { SPECULAR } else { 0.0 };
        }
        let entry = TABLE_ENTRY + TABLE_LIGHT * count * if self.is_shiny { 2.0 } else { 1.0 };
        let (at_pixel, tables) = match shade {
            _ if !self.is_lit || count == 0.0 => (0.0, 0.0),
            ShadeMode::Phong => (PHONG + at_pixel, 0.0),
            ShadeMode::Gouraud => (GOURAUD, self.vertices * entry),
            ShadeMode::Flat => (FLAT, self.faces * entry),
            ShadeMode::Wire => (0.0, 0.0),
        };
        Cost { pixels: self.faces * FACE + self.pixels * (PIXEL + at_pixel + self.texture), tables }
    }

    /// Returns the cost of so many faces without light.
    pub fn faces_cost(&self, faces: usize) -> f64 {
        FACE * faces as f64
    }

    /// Returns whether faces have so many pixels in the mean that their light may be interpolated.
    pub fn has_large_faces(&self) -> bool {
        self.is_lit && self.pixels >= LARGE_FACE * self.faces
    }

    /// Returns whether choosing among so many lights is cheap beside drawing the object exactly.
    pub fn choice_is_cheap(&self, exact: f64, lights: usize) -> bool {
        CHOICE + CHOICE_LIGHT * lights as f64 <= CHOICE_PART * exact
    }

    /// Returns whether measuring the mesh costs at most two exact frames.
    pub fn measuring_is_cheap(&self, exact: f64) -> bool {
        MEASURED_FACE * self.faces <= MOST_FRAMES * exact
    }
}

/// Returns whether a draw has a material with highlights.
fn is_shiny(call: &DrawCall) -> bool {
    call.geometry.mesh.materials.iter().chain([call.material]).any(|m| m.ks != DVec3::ZERO)
}

/// Returns whether the light of these lights depends on the place, which it does on matte faces only where a
/// light has a place itself.
pub(super) fn depends_on_place(call: &DrawCall, mut lights: impl Iterator<Item = u32>) -> bool {
    let is_shiny = is_shiny(call);
    let has_place = |l: &Light| is_shiny || !matches!(l.kind, LightKind::Directional { .. });
    lights.any(|l| call.lights.get(l as usize).is_some_and(has_place))
}

/// Returns an estimate of the pixels that a mesh covers of a viewport of `area` pixels: half of the
/// rectangle around it, or half of the viewport if there is none.
pub(super) fn covered_pixels(ndc_box: Option<NdcBox>, area: f64) -> f64 {
    let [width, height] = ndc_box.map_or([1.0; 2], |seen| seen.sides());
    area * width * height / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::draw_call::SceneOptions;
    use crate::pipeline::ndc_box::ClipTransform;
    use crate::truth::scenes::{lit_triangle, object};
    use glam::DMat4;

    #[test]
    fn half_of_the_box_on_the_screen_is_counted_as_covered() {
        let covered = |model: DMat4, low: [f64; 3], high: [f64; 3]| {
            let to_clip = ClipTransform::of_projection(model);
            covered_pixels(NdcBox::of((low.into(), high.into()), &to_clip), 8000.0)
        };
        // 5/8 of the frame's width and 3/8 of its height.
        assert_eq!(
            covered(DMat4::IDENTITY, [-0.5, -0.25, 0.0], [0.75, 0.5, 1.0]),
            8000.0 * 15.0 / 64.0 / 2.0
        );
        // The part beside the frame is left out, and with it all of a box that is not on the frame.
        assert_eq!(covered(DMat4::IDENTITY, [-9.0, 0.0, 0.0], [0.0, 9.0, 1.0]), 1000.0);
        assert_eq!(covered(DMat4::IDENTITY, [2.0, 0.0, 0.0], [3.0, 1.0, 1.0]), 0.0);
        let half = DMat4::from_scale(DVec3::splat(0.5));
        assert_eq!(covered(half, [-1.0; 3], [1.0; 3]), 1000.0);
        // A corner beside or behind the eye has no place on the screen: half of the frame.
        let behind = DMat4::from_cols_array(&[
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0,
        ]);
        assert_eq!(covered(behind, [0.0; 3], [1.0; 3]), 4000.0);
        assert_eq!(covered(behind, [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]), 250.0);
    }

    #[test]
    fn measuring_and_choosing_are_cheap_up_to_their_share_of_exact_frames() {
        let scene = lit_triangle();
        let faces = object("ball", crate::scene::shapes::sphere(1.0).unwrap());
        let call = DrawCall::of_object(&faces, &scene, &SceneOptions::new(64, 48));
        let costs = ObjectCosts::of(&call, 100.0);
        let measured = MEASURED_FACE * faces.geometry.mesh.triangles.len() as f64;
        assert!(costs.measuring_is_cheap(measured / MOST_FRAMES));
        assert!(!costs.measuring_is_cheap(measured / MOST_FRAMES * 0.99));
        let choice = (CHOICE + 3.0 * CHOICE_LIGHT) / CHOICE_PART;
        assert!(costs.choice_is_cheap(choice * 1.01, 3) && !costs.choice_is_cheap(choice * 0.99, 3));
    }
}

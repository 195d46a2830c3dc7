//! Costs of settings: a calibration table of the tile renderer, and estimates made from it.
//!
//! The table is fixed, so that choices are the same on every machine, with every number of threads
//! and vector width. Its figures are measured: docs/notes/error-budget.md has the machine, the
//! command and the frames that they come from. One unit is a nanosecond of that machine.

use super::Budget;
use super::settings::QualitySettings;
use crate::scene::{Filter, LightKind, LightingModel, Material, Object, ShadeMode};
use glam::{DVec3, DVec4};

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

impl Cost {
    /// Returns the sum.
    pub fn sum(self) -> f64 {
        self.pixels + self.tables
    }
}

/// Returns the cost of drawing an object that covers `pixels` pixels.
pub(super) fn cost(object: &Object, budget: &Budget, settings: &QualitySettings, pixels: f64) -> Cost {
    let scene = budget.scene;
    let mesh = &object.geometry.mesh;
    let mut materials = mesh.materials.iter().chain([&object.material]);
    let is_lit = materials.clone().any(|m: &Material| m.model != LightingModel::Unlit);
    let is_shiny = materials.any(|m| m.ks != DVec3::ZERO);
    let (mut at_pixel, mut lights) = (0.0, 0.0);
    for light in settings.lights_of(object, scene).iter().filter_map(|l| scene.lights.get(*l as usize)) {
        lights += 1.0;
        at_pixel += match light.kind {
            LightKind::Directional { .. } => DIRECTIONAL,
            _ => POINT,
        };
        at_pixel += if is_shiny { SPECULAR } else { 0.0 };
    }
    let entry = TABLE_ENTRY + TABLE_LIGHT * lights * if is_shiny { 2.0 } else { 1.0 };
    let shade = settings.shade.or(object.shade).unwrap_or(budget.options.shade);
    let (at_pixel, tables) = match shade {
        _ if !is_lit || lights == 0.0 => (0.0, 0.0),
        ShadeMode::Phong => (PHONG + at_pixel, 0.0),
        ShadeMode::Gouraud => (GOURAUD, vertices(object) * entry),
        ShadeMode::Flat => (FLAT, mesh.triangles.len() as f64 * entry),
        ShadeMode::Wire => (0.0, 0.0),
    };
    let filter = object.texture.as_ref().map(|t| filter_cost(settings.filter.unwrap_or(t.1.filter)));
    let faces = mesh.triangles.len() as f64 * FACE;
    Cost { pixels: faces + pixels * (PIXEL + at_pixel + filter.unwrap_or(0.0)), tables }
}

/// Returns an estimate of the vertices of an object's indexed mesh.
fn vertices(object: &Object) -> f64 {
    let mesh = &object.geometry.mesh;
    mesh.positions.len().max(mesh.normals.len()).min(mesh.corners.len()) as f64
}

/// Returns an estimate of the pixels that an object covers: half of its bounding box on the screen.
pub(super) fn covered_pixels(object: &Object, bounds: [DVec3; 2], budget: &Budget) -> f64 {
    let viewport = budget.options.viewport;
    let whole = f64::from(viewport.width) * f64::from(viewport.height);
    let camera = budget.scene.camera.unwrap_or(budget.options.camera);
    let aspect = f64::from(viewport.width) / f64::from(viewport.height);
    let Ok(matrices) = camera.matrices(aspect) else { return 0.0 };
    let to_clip = matrices.projection * matrices.view * object.model;
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for i in 0..8 {
        let corner = |axis: usize| bounds[(i >> axis) & 1][axis];
        let p = to_clip * DVec4::new(corner(0), corner(1), corner(2), 1.0);
        if p.w.is_nan() || p.w <= 0.0 {
            return whole / 2.0;
        }
        for axis in 0..2 {
            let at = (p[axis] / p.w).clamp(-1.0, 1.0);
            (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
        }
    }
    let part = (high[0] - low[0]) * (high[1] - low[1]) / 4.0;
    if part.is_finite() { whole * part / 2.0 } else { 0.0 }
}

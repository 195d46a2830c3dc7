//! Choice by proof: for each object the cheapest settings whose bound is within E.

use super::bounds::{MeshShape, ShadedObject};
use super::costs::{cost, covered_pixels};
use super::settings::QualitySettings;
use super::{Budget, Choice, steps_of_rounding};
use crate::scene::{Geometry, Object, ShadeMode};
use std::sync::Arc;

/// Part of the pixels' saving that lighting vertices or faces may cost at most: an estimate of the
/// pixels that an object covers may be three times too large.
const TABLE_PART: f64 = 1.0 / 3.0;

/// Part of an object's cost that other settings must save: exact settings win ties.
const LEAST_SAVING: f64 = 0.05;

/// Returns the settings that are proven to stay within the budget; `shape_of` returns what is known
/// of a mesh.
pub fn prove(budget: &Budget, mut shape_of: impl FnMut(&Arc<Geometry>) -> Option<MeshShape>) -> Choice {
    if let Some(reason) = budget.exact_reason() {
        return Choice::exact(budget, reason);
    }
    let mut choice = Choice::exact(budget, "");
    choice.notes.clear();
    for (object, settings) in budget.scene.objects.iter().zip(&mut choice.settings) {
        let Some(shape) = shape_of(&object.geometry) else { continue };
        let pixels = covered_pixels(object, shape.bounds, budget);
        let exact = cost(object, budget, settings, pixels).sum();
        choice.costs[0] += exact;
        let (mut least, mut error) = (exact, 0.0);
        for (candidate, bound) in candidates(object, shape, budget) {
            let own = cost(object, budget, &candidate, pixels);
            let saving = exact - own.pixels;
            if own.sum() < least
                && own.tables <= TABLE_PART * saving
                && own.sum() <= (1.0 - LEAST_SAVING) * exact
            {
                (least, error, *settings) = (own.sum(), bound, candidate);
            }
        }
        choice.costs[1] += least;
        choice.proven = choice.proven.max(error);
    }
    if choice.is_exact() {
        choice.notes.push("nothing cheaper is proven to stay within the limit: exact".to_owned());
    }
    choice
}

/// Returns the settings of an object that are proven to stay within E, each with its bound in steps.
fn candidates(object: &Object, shape: MeshShape, budget: &Budget) -> Vec<(QualitySettings, f64)> {
    let Some(shaded) = ShadedObject::of(object, shape) else { return Vec::new() };
    let (scene, own) = (budget.scene, object.shade.unwrap_or(budget.options.shade));
    let lights = QualitySettings::default().lights_of(object, scene);
    // Equal formulas give equal right answers; others are rounded to bytes on top of their difference.
    let total = |delta: f64| steps_of_rounding(object) + if delta > 0.0 { 1.0 + delta } else { 0.0 };
    let mut reflected: Vec<(f64, u32)> = lights
        .iter()
        .filter_map(|l| Some((255.0 * shaded.of_light(scene.lights.get(*l as usize)?)?, *l)))
        .collect();
    reflected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut found = Vec::new();
    for shade in [own, ShadeMode::Gouraud, ShadeMode::Flat] {
        let Some(error) = shaded.of_shade(own, shade, scene, &lights) else { continue };
        let mut delta = 255.0 * error;
        if total(delta) > budget.max_error {
            continue;
        }
        let mut dark: Vec<u32> = Vec::new();
        for (light_steps, light) in &reflected {
            if total(delta + light_steps) > budget.max_error {
                break;
            }
            delta += light_steps;
            dark.push(*light);
        }
        let kept: Vec<u32> = lights.iter().copied().filter(|l| !dark.contains(l)).collect();
        let settings = QualitySettings {
            shade: (shade != own).then_some(shade),
            filter: None,
            lights: (!dark.is_empty()).then_some(kept),
        };
        if settings != QualitySettings::default() {
            found.push((settings, total(delta)));
        }
    }
    found
}

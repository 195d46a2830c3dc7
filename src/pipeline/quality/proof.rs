//! For each object the cheapest settings whose proven bound is within E.

use super::bounds::ShadedObject;
use super::costs::{ObjectCosts, covered_pixels};
use super::settings::QualitySettings;
use super::{Budget, Choice, MeshShapes, steps_of_rounding};
use crate::scene::ShadeMode;

/// Part of the pixels' saving that lighting vertices or faces may cost at most: an estimate of the
/// pixels that an object covers may be three times too large.
const TABLE_PART: f64 = 1.0 / 3.0;

/// Part of an object's cost that other settings must save: exact settings win ties.
const LEAST_SAVING: f64 = 0.05;

/// Returns the settings that are proven to stay within the budget, by what is known of the meshes.
pub fn prove(budget: &Budget, shapes: &mut MeshShapes) -> Choice {
    let mut choice = Choice::exact(budget);
    choice.exact_because = budget.exact_reason();
    if choice.exact_because.is_some() {
        return choice;
    }
    let [width, height] = [budget.options.viewport.width, budget.options.viewport.height].map(f64::from);
    let camera = budget.scene.camera.unwrap_or(budget.options.camera);
    let Some(to_clip) = shapes.clip_matrix(camera, width / height) else { return choice };
    let every_light: Vec<u32> = (0..budget.scene.lights.len() as u32).collect();
    for (i, object) in budget.scene.objects.iter().enumerate() {
        let Some(mesh_box) = shapes.box_of(&object.geometry) else {
            choice.unknown += 1;
            continue;
        };
        let pixels = covered_pixels(object, mesh_box.bounds, to_clip, width * height);
        let costs = ObjectCosts::of(object, budget.scene, pixels);
        let lights = object.lights.as_ref().unwrap_or(&every_light);
        let own = object.shade.unwrap_or(budget.options.shade);
        let exact = costs.drawing(own, lights).sum();
        choice.costs = choice.costs.map(|cost| cost + exact);
        let may_pay = costs.drawing(own, &[]).sum() <= (1.0 - LEAST_SAVING) * exact;
        if !may_pay || !costs.choice_is_cheap(exact, lights.len()) {
            continue;
        }
        let may_measure = own == ShadeMode::Phong && costs.measuring_is_cheap(exact);
        choice.unmeasured += usize::from(own == ShadeMode::Phong && !may_measure);
        let angles = if may_measure { shapes.angles_of(&object.geometry) } else { None };
        let Some(shaded) = ShadedObject::of(object, mesh_box, angles) else { continue };
        if let Some(found) = cheapest(&shaded, own, lights, budget, &costs) {
            choice.costs[1] += found.cost - exact;
            choice.proven = choice.proven.max(found.bound);
            choice.settings[i] = found.settings;
        }
    }
    if choice.is_exact() {
        choice.exact_because = Some("nothing cheaper is proven to stay within the limit: exact");
    }
    choice
}

/// Settings with their bound in steps, and their cost.
struct Proven {
    settings: QualitySettings,
    bound: f64,
    cost: f64,
}

/// Returns the cheapest settings that are proven to stay within E, if they are cheaper than exact
/// ones: a shading mode, without those lights that add least.
fn cheapest(
    shaded: &ShadedObject,
    own: ShadeMode,
    lights: &[u32],
    budget: &Budget,
    costs: &ObjectCosts,
) -> Option<Proven> {
    let scene = budget.scene;
    let exact = costs.drawing(own, lights).sum();
    // Equal formulas give equal right answers; others are rounded to bytes on top of their difference.
    let rounding = steps_of_rounding(shaded.object());
    let total = |delta: f64| rounding + if delta > 0.0 { 1.0 + delta } else { 0.0 };
    let mut reflected: Vec<(f64, u32)> = lights
        .iter()
        .filter_map(|l| Some((255.0 * shaded.of_light(scene.lights.get(*l as usize)?)?, *l)))
        .collect();
    reflected.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut best: Option<Proven> = None;
    for shade in [own, ShadeMode::Gouraud, ShadeMode::Flat] {
        let Some(error) = shaded.of_shade(own, shade, scene, lights) else { continue };
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
        let cost = costs.drawing(shade, &kept);
        let tables_pay = shade == own || cost.tables <= TABLE_PART * (exact - cost.pixels);
        let least = best.as_ref().map_or((1.0 - LEAST_SAVING) * exact, |b| b.cost);
        if tables_pay && cost.sum() < least {
            let settings = QualitySettings {
                shade: (shade != own).then_some(shade),
                lights: (!dark.is_empty()).then_some(kept),
            };
            best = Some(Proven { settings, bound: total(delta), cost: cost.sum() });
        }
    }
    best
}

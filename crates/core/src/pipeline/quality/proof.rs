//! For each draw the cheapest settings whose proven bound is within E.

use super::bounds::{MeshBox, ShadedObject, light_indices};
use super::costs::{ObjectCosts, covered_pixels, depends_on_place};
use super::detail::{self, Detail, WholeReason};
use super::levels::may_have_levels;
use super::settings::QualitySettings;
use super::{Budget, Choice, MeshShapes, exact_reason, steps_of_rounding};
use crate::pipeline::draw_call::DrawCall;
use crate::pipeline::ndc_box::{ClipTransform, NdcBox};
use crate::scene::{MaxError, ShadeMode};
use std::iter;

/// Part of the pixels' saving that lighting vertices or faces may cost at most: an estimate of the
/// pixels that an object covers may be three times too large.
const TABLE_PART: f64 = 1.0 / 3.0;

/// Least error, in steps, that light which is interpolated may have beyond what cannot be seen.
const LEAST_LIGHT_ERROR: f64 = 0.5;

/// Part of an object's cost that other settings must save: exact settings win ties.
const LEAST_SAVING: f64 = 0.05;

/// Returns the settings that are proven to stay within the budget, by what was measured of the
/// meshes.
pub fn prove(budget: &Budget, shapes: &mut MeshShapes) -> Choice {
    let mut choice = Choice::exact(budget);
    choice.exact_because = budget.exact_reason();
    if choice.exact_because.is_some() {
        return choice;
    }
    for (i, object) in budget.scene.objects.iter().enumerate() {
        let call = DrawCall::of_object(object, budget.scene, budget.options);
        let Some(to_clip) = shapes.clip_transform(&call) else { return choice };
        let Some(mut chosen) = choose(&call, budget.max_error, to_clip, shapes) else {
            choice.unknown += 1;
            continue;
        };
        choice.unmeasured += usize::from(chosen.is_unmeasured);
        chosen.detail.take().into_iter().for_each(|detail| choice.note_detail(detail));
        choice.costs = choice.costs.map(|cost| cost + chosen.exact);
        choice.costs[1] += chosen.found.as_ref().map_or(0.0, |found| found.cost - chosen.exact);
        if let Some((settings, bound)) = chosen.settings(&call, budget.max_error.steps) {
            choice.proven = choice.proven.max(bound);
            choice.settings[i] = settings;
        }
    }
    if choice.is_exact() {
        choice.exact_because = Some("nothing cheaper is proven to stay within the limit: exact");
    }
    choice
}

/// Returns the settings of a single draw that are proven to stay within E, as [`prove`] does for a
/// scene of one object; and the rectangle around its mesh on the screen, if it was computed.
#[doc(hidden)]
pub fn settings_of(
    call: &DrawCall,
    max_error: MaxError,
    shapes: &mut MeshShapes,
) -> (QualitySettings, Option<NdcBox>) {
    if exact_reason(call.hide, max_error.steps).is_some() {
        return Default::default();
    }
    let to_clip = shapes.clip_transform(call);
    match to_clip.and_then(|to_clip| choose(call, max_error, to_clip, shapes)) {
        Some(chosen) => {
            let ndc_box = chosen.ndc_box;
            (
                chosen.settings(call, max_error.steps).map(|(settings, _)| settings).unwrap_or_default(),
                ndc_box,
            )
        }
        None => Default::default(),
    }
}

/// Settings chosen for a draw, and the figures behind them.
struct Chosen {
    /// Cost of the exact settings.
    exact: f64,
    /// Cheaper settings, if some are proven to stay within E.
    found: Option<Proven>,
    /// True if measuring the mesh would cost more than two exact frames.
    is_unmeasured: bool,
    /// The level of detail, or why there is none, if the draw has many faces and may shift.
    detail: Option<Detail>,
    /// Rectangle around the mesh on the screen; `None` if it reaches the eye.
    ndc_box: Option<NdcBox>,
    /// True if lights reach the mesh, and its faces have so many pixels that light may be interpolated.
    has_large_faces: bool,
}

impl Chosen {
    /// Returns the settings with their bound in steps; `None` for exact ones. What other settings leave
    /// of E, the light of large faces gets.
    fn settings(self, call: &DrawCall, max_error: f64) -> Option<(QualitySettings, f64)> {
        let rounding = steps_of_rounding(call);
        let is_exact = self.found.is_none();
        let (mut settings, bound) = match self.found {
            Some(found) => (found.settings, found.bound),
            None => (QualitySettings::default(), rounding),
        };
        // Light that differs is rounded to bytes on top of its difference.
        let left = max_error - bound.max(rounding + 1.0);
        let is_lit = settings.shade.unwrap_or(call.shade) == ShadeMode::Phong
            && match &settings.lights {
                Some(lights) => depends_on_place(call, lights.iter().copied()),
                None => depends_on_place(call, light_indices(call)),
            };
        if self.has_large_faces && is_lit && left >= LEAST_LIGHT_ERROR {
            settings.light_error = Some(left);
            return Some((settings, max_error));
        }
        (!is_exact).then_some((settings, bound))
    }
}

/// Returns whether nothing but light makes the colours of a draw: only then it is interpolated.
fn is_light_alone(call: &DrawCall) -> bool {
    steps_of_rounding(call) <= 1.0 && call.fog.is_none() && call.geometry.mesh.colors.is_empty()
}

/// Chooses the settings of a draw; `None` if its mesh is drawn for the first time. `to_clip` is
/// the transform from the world to clip space.
fn choose(
    call: &DrawCall,
    max_error: MaxError,
    to_clip: ClipTransform,
    shapes: &mut MeshShapes,
) -> Option<Chosen> {
    let geometry = call.shared?;
    let mesh_box = shapes.box_of(geometry)?;
    let area = f64::from(call.viewport.width) * f64::from(call.viewport.height);
    let from_object = to_clip.after(&call.model);
    let ndc_box = NdcBox::of(mesh_box.bounds, &from_object);
    let costs = ObjectCosts::of(call, covered_pixels(ndc_box, area));
    let exact = costs.drawing(call.shade, light_indices(call)).sum();
    let has_large_faces =
        costs.has_large_faces() && is_light_alone(call) && ShadedObject::of(call, mesh_box, None).is_some();
    let mut chosen =
        Chosen { exact, found: None, is_unmeasured: false, detail: None, ndc_box, has_large_faces };
    if max_error.shift > 0.0 && may_have_levels(&geometry.mesh) {
        let detail = detail_of(call, max_error, mesh_box, &from_object, shapes);
        chosen.found = with_level(call, max_error, mesh_box, &costs, &detail);
        chosen.detail = Some(detail);
        if chosen.found.is_some() {
            return Some(chosen);
        }
    }
    let may_pay = costs.drawing(call.shade, iter::empty()).sum() <= (1.0 - LEAST_SAVING) * exact;
    if !may_pay || !costs.choice_is_cheap(exact, light_indices(call).count()) {
        return Some(chosen);
    }
    let is_phong = call.shade == ShadeMode::Phong;
    let may_measure = is_phong && costs.measuring_is_cheap(exact);
    chosen.is_unmeasured = is_phong && !may_measure;
    let angles = if may_measure { shapes.angles_of(geometry) } else { None };
    chosen.found = ShadedObject::of(call, mesh_box, angles).and_then(|shaded| {
        cheapest(&shaded, &light_indices(call).collect::<Vec<_>>(), max_error.steps, &costs)
    });
    Some(chosen)
}

/// Returns the level of detail of a draw, or the reason why all faces are drawn.
fn detail_of(
    call: &DrawCall,
    max_error: MaxError,
    mesh_box: MeshBox,
    to_clip: &ClipTransform,
    shapes: &mut MeshShapes,
) -> Detail {
    let whole = match (detail::unproven(call), call.shared) {
        (Some(why), _) => WholeReason::Unproven(why),
        (None, None) => WholeReason::NoLevels,
        (None, Some(geometry)) => match shapes.levels_of(geometry) {
            Ok(levels) => return detail::choose(call, mesh_box, to_clip, levels, &max_error),
            Err(why) => why,
        },
    };
    Detail::Whole(whole)
}

/// Returns the settings of a draw at a level of detail, without the lights that add too little; none
/// if all faces are drawn.
fn with_level(
    call: &DrawCall,
    max_error: MaxError,
    mesh_box: MeshBox,
    costs: &ObjectCosts,
    detail: &Detail,
) -> Option<Proven> {
    let Detail::Level { level, faces, steps, .. } = detail else { return None };
    let lights: Vec<u32> = light_indices(call).collect();
    let left = level.geometry.mesh.triangles.len();
    let mut proven = ShadedObject::of(call, mesh_box, None)
        .and_then(|shaded| cheapest(&shaded, &lights, max_error.steps - 1.0 - steps, costs))
        .unwrap_or(Proven {
            settings: QualitySettings::default(),
            bound: steps_of_rounding(call),
            cost: costs.drawing(call.shade, lights.iter().copied()).sum(),
        });
    proven.bound += 1.0 + steps;
    proven.cost -= costs.faces_cost(faces - left);
    proven.settings.level = Some(level.clone());
    Some(proven)
}

/// Settings with their bound in steps, and their cost.
struct Proven {
    settings: QualitySettings,
    bound: f64,
    cost: f64,
}

/// Returns the cheapest settings that are proven to stay within E, if they are cheaper than exact
/// ones: a shading mode, without those lights that add least.
fn cheapest(shaded: &ShadedObject, lights: &[u32], max_error: f64, costs: &ObjectCosts) -> Option<Proven> {
    let call = shaded.call();
    let own = call.shade;
    let exact = costs.drawing(own, lights.iter().copied()).sum();
    // Equal formulas give equal right answers; others are rounded to bytes on top of their difference.
    let rounding = steps_of_rounding(call);
    let total = |delta: f64| rounding + if delta > 0.0 { 1.0 + delta } else { 0.0 };
    let mut reflected: Vec<(f64, u32)> = lights
        .iter()
        .filter_map(|l| Some((255.0 * shaded.of_light(call.lights.get(*l as usize)?)?, *l)))
        .collect();
    reflected.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut best: Option<Proven> = None;
    for shade in [own, ShadeMode::Gouraud, ShadeMode::Flat] {
        let Some(error) = shaded.of_shade(shade, lights) else { continue };
        let mut delta = 255.0 * error;
        if total(delta) > max_error {
            continue;
        }
        let mut dark: Vec<u32> = Vec::new();
        for (light_steps, light) in &reflected {
            if total(delta + light_steps) > max_error {
                break;
            }
            delta += light_steps;
            dark.push(*light);
        }
        let kept: Vec<u32> = lights.iter().copied().filter(|l| !dark.contains(l)).collect();
        let cost = costs.drawing(shade, kept.iter().copied());
        let tables_pay = shade == own || cost.tables <= TABLE_PART * (exact - cost.pixels);
        let least = best.as_ref().map_or((1.0 - LEAST_SAVING) * exact, |b| b.cost);
        if tables_pay && cost.sum() < least {
            let settings = QualitySettings {
                shade: (shade != own).then_some(shade),
                lights: (!dark.is_empty()).then_some(kept),
                light_error: None,
                level: None,
            };
            best = Some(Proven { settings, bound: total(delta), cost: cost.sum() });
        }
    }
    best
}

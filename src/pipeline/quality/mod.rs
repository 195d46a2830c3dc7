//! The error budget: a search for the cheapest quality settings that keep a scene within a given
//! error.
//!
//! In: a scene, and E, the largest allowed 99.9th percentile of the colour error, in 1/255 steps
//! over the pixels that are drawn on. Out: a [`Choice`]: for every object its shading mode, texture
//! filter and lights, and the interpolation across faces; with the trials and the reasons. Coverage
//! and depth are not changed.
//!
//! ```text
//! 1 draw exactly: which pixels are drawn on, and by which object
//! 2 compute the reference colours of a seeded sample of them
//! 3 draw a picture with each recipe, and compare it with that sample
//! 4 each object takes its cheapest recipe within E
//! 5 compare the picture of all objects with a fresh sample
//! 6 where that fails, the object with the largest error takes a better recipe
//! ```
//!
//! The search reads no clock: costs come from a fixed table, so a scene gets the same choice
//! everywhere. The promise rests on the fresh sample of [`CERTIFY`] random pixels: if more than 1
//! in 1000 of all pixels were over E, the chance that the sample has few enough to pass is less
//! than 1 %, over all tries. Small pictures are checked completely, which leaves no doubt.

mod cache;
mod choice;
mod probe_pixels;
mod settings;

pub use cache::ChoiceCache;
pub use choice::{Choice, Trial};
pub use settings::{Levels, QualitySettings};

use super::draw_call::{PipelineError, SceneOptions};
use super::renderer::Renderer;
use crate::memory::DepthFormat;
use crate::scene::{Interpolation, Light, Object, Scene};
use probe_pixels::{Reference, ReferenceSet};
use settings::DetailLevels;

/// Number of pixels on which settings are compared.
pub const SELECT: usize = 3000;
/// Number of pixels of a fresh sample on which a choice is certified.
pub const CERTIFY: usize = 12_000;
/// Number of drawn pixels up to which a picture is checked completely.
pub const LOOK_AT_ALL: usize = 30_000;
/// Maximum number of choices that are certified before falling back to exact drawing.
const TRIES: usize = 4;
/// Maximum probability that a certified choice is wrong, over all tries.
const DOUBT: f64 = 0.01;
/// Fraction of the pixels that may be over E.
const PART_OVER: f64 = 0.001;

/// Input of a search: the scene, how it is drawn, and the allowed error.
#[derive(Clone, Copy, Debug)]
pub struct Budget<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// Options of the exact drawing.
    pub options: &'a SceneOptions,
    /// A scene, or single draws with transparent faces among the others.
    pub kind: BudgetKind,
    /// Format of the depth memory.
    pub depth_format: DepthFormat,
    /// Width of the frame in pixels.
    pub width: u32,
    /// Height of the frame in pixels.
    pub height: u32,
    /// E, the allowed error in 1/255 steps.
    pub max_error: f64,
}

/// The kind of drawing that a budget is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum BudgetKind {
    /// A scene: transparent faces after the opaque ones.
    #[default]
    Scene,
    /// Single draws, one per object, in order.
    Draws,
}

/// Returns the cheapest settings that stay within the budget.
///
/// # Errors
/// As [`super::draw_scene`].
pub fn choose(renderer: &mut Renderer, budget: &Budget) -> Result<Choice, PipelineError> {
    if budget.max_error < 1.0 {
        return Ok(Choice::exact(budget, "under one step nothing but exact is sure".into()));
    }
    let reference_set = ReferenceSet::new(renderer, budget)?;
    if reference_set.drawn_on.is_empty() {
        return Ok(Choice::exact(budget, "no pixel is drawn on".into()));
    }
    let chosen = Search { renderer, budget, reference_set, trials: Vec::new(), notes: Vec::new() }.run()?;
    Ok(chosen)
}

/// Returns the maximum bytes of a search, without the renderer's working memory: frames with depths
/// and ids, the order and owners of pixels, the reference, and copies of the scene's objects.
pub fn search_bytes(scene: &Scene, width: u32, height: u32) -> u64 {
    let object = size_of::<Object>() + scene.lights.len() * size_of::<Light>();
    u64::from(width) * u64::from(height) * PIXEL_BYTES + (4 * scene.objects.len() * object) as u64
}

/// Bytes of a search per pixel.
const PIXEL_BYTES: u64 = 160;

/// State of a search.
struct Search<'a> {
    renderer: &'a mut Renderer,
    budget: &'a Budget<'a>,
    reference_set: ReferenceSet,
    trials: Vec<Trial>,
    notes: Vec<String>,
}

/// Settings of each object, and the interpolation across faces.
#[derive(Clone, Debug, PartialEq)]
struct Candidate {
    recipes: Vec<QualitySettings>,
    interp: Interpolation,
}

/// Result of drawing all objects at the same levels.
struct Evaluation {
    levels: Levels,
    interp: Interpolation,
    /// For each group, whether its error stays within the limit.
    holds: Vec<bool>,
    /// Cost of each group.
    costs: Vec<f64>,
}

impl Search<'_> {
    fn run(mut self) -> Result<Choice, PipelineError> {
        let budget = self.budget;
        let sample = self.reference_set.selection();
        let reference = Reference::of(budget, &self.reference_set, &sample)?;
        let limit = reference.limit(budget.max_error);
        let exact = Candidate {
            recipes: vec![QualitySettings::default(); budget.scene.objects.len()],
            interp: budget.options.interp,
        };
        let details_of_objects: Vec<DetailLevels> =
            budget.scene.objects.iter().map(|o| DetailLevels::of(o, budget.scene, budget.options)).collect();
        let details_of_objects =
            self.with_few_lights(details_of_objects, &exact, &sample, &reference, limit)?;
        let mut evaluations = Vec::new();
        for interp in settings::interpolations(budget.options.interp) {
            self.evaluate(interp, &details_of_objects, &sample, &reference, limit, &mut evaluations)?;
        }
        let mut choice = Choice::exact(budget, String::new());
        choice.notes.clear();
        choice.pixels = self.reference_set.drawn_on.len();
        choice.reference = reference.name();
        choice.costs[0] = self.cost(&exact);
        let mut candidate = exact.clone();
        for attempt in 0..TRIES {
            let Some(best) = best(&evaluations, self.reference_set.groups) else { break };
            candidate = self.candidate(&best, &evaluations, &details_of_objects);
            if candidate == exact {
                break;
            }
            let sample = self.reference_set.certification(attempt);
            let reference = Reference::of(budget, &self.reference_set, &sample)?;
            let frame = self.draw(&candidate)?;
            let over: Vec<usize> =
                sample.iter().copied().filter(|&i| f64::from(reference.error(&frame, i)) > limit).collect();
            let is_all = sample.len() == self.reference_set.drawn_on.len();
            let (allowed, doubt) = match is_all {
                true => ((PART_OVER * sample.len() as f64) as usize, 0.0),
                false => probe_pixels::allowed_over(sample.len(), PART_OVER, DOUBT / TRIES as f64),
            };
            (choice.sampled, choice.over) = (sample.len(), over.len());
            choice.confidence = 1.0 - TRIES as f64 * doubt;
            if over.len() <= allowed {
                break;
            }
            self.notes.push(format!(
                "{} of {} fresh pixels over the limit, at most {allowed} may be: another way is looked for",
                over.len(),
                sample.len()
            ));
            candidate = exact.clone();
            let worst = self.worst_group(&over);
            evaluations[best[worst]].holds[worst] = false;
        }
        if candidate == exact {
            (choice.sampled, choice.over, choice.confidence) = (0, 0, 1.0);
            self.notes.push("nothing cheaper holds: exact".into());
        }
        choice.costs[1] = self.cost(&candidate);
        choice.recipes = candidate.recipes;
        choice.interp = candidate.interp;
        choice.trials = self.trials;
        choice.notes = self.notes;
        Ok(choice)
    }

    /// Draws all objects at each combination of levels with interpolation `interp`, and records the
    /// results.
    fn evaluate(
        &mut self,
        interp: Interpolation,
        details_of_objects: &[DetailLevels],
        sample: &[usize],
        reference: &Reference,
        limit: f64,
        evaluations: &mut Vec<Evaluation>,
    ) -> Result<(), PipelineError> {
        // Levels that fail for every group are not combined with further ones.
        let mut hopeless: Vec<Levels> = Vec::new();
        for levels in Levels::of(details_of_objects) {
            if hopeless.iter().any(|h| h.is_within(levels)) {
                continue;
            }
            let candidate =
                Candidate { recipes: details_of_objects.iter().map(|l| l.recipe(levels)).collect(), interp };
            let frame = self.draw(&candidate)?;
            let errors: Vec<u8> = sample.iter().map(|&i| reference.error(&frame, i)).collect();
            let mut holds = self.reference_set.groups_that_hold(sample, &errors, limit);
            if levels == Levels::default() && interp == self.budget.options.interp {
                holds.fill(true); // exact drawing is valid in any case
            }
            let mut costs = vec![0.0; self.reference_set.groups];
            for object in 0..details_of_objects.len() {
                costs[self.reference_set.group_of(object)] += self.object_cost(object, &candidate);
            }
            let over = errors.iter().filter(|&&e| f64::from(e) > limit).count();
            self.trials.push(Trial {
                name: settings::name(levels, details_of_objects, interp, self.budget.options.interp),
                error: probe_pixels::quantile(&errors, 1.0 - PART_OVER),
                over: over as f64 / sample.len().max(1) as f64,
                cost: costs.iter().sum(),
                holds_for: (0..details_of_objects.len())
                    .filter(|&o| holds[self.reference_set.group_of(o)])
                    .count(),
            });
            if !holds.contains(&true) {
                hopeless.push(levels);
            }
            evaluations.push(Evaluation { levels, interp, holds, costs });
        }
        Ok(())
    }

    /// Returns the candidate in which each group uses the levels of its evaluation in `best`.
    fn candidate(
        &self,
        best: &[usize],
        evaluations: &[Evaluation],
        details_of_objects: &[DetailLevels],
    ) -> Candidate {
        let of_object = |object: usize| &evaluations[best[self.reference_set.group_of(object)]];
        Candidate {
            recipes: (0..details_of_objects.len())
                .map(|o| details_of_objects[o].recipe(of_object(o).levels))
                .collect(),
            interp: best.first().map_or(self.budget.options.interp, |&e| evaluations[e].interp),
        }
    }

    /// Returns the group with most of these pixels.
    fn worst_group(&self, over: &[usize]) -> usize {
        let mut counts = vec![0usize; self.reference_set.groups];
        over.iter()
            .filter_map(|&i| self.reference_set.owner[i])
            .for_each(|group| counts[group as usize] += 1);
        (0..counts.len()).rev().max_by_key(|&g| counts[g]).unwrap_or(0)
    }

    /// Finds for each object the lights that can be left out within the limit.
    fn with_few_lights(
        &mut self,
        mut details_of_objects: Vec<DetailLevels>,
        exact: &Candidate,
        sample: &[usize],
        reference: &Reference,
        limit: f64,
    ) -> Result<Vec<DetailLevels>, PipelineError> {
        let lights = self.budget.scene.lights.len();
        if lights == 0 {
            return Ok(details_of_objects);
        }
        // errors[group][light] is the error of leaving the light out.
        let mut errors = vec![Vec::new(); self.reference_set.groups];
        for light in 0..lights as u32 {
            let without = |l: &DetailLevels| QualitySettings {
                lights: Some(l.lights_without(light)),
                ..QualitySettings::default()
            };
            let candidate =
                Candidate { recipes: details_of_objects.iter().map(without).collect(), ..exact.clone() };
            let frame = self.draw(&candidate)?;
            let found: Vec<u8> = sample.iter().map(|&i| reference.error(&frame, i)).collect();
            for (group, errors) in errors.iter_mut().enumerate() {
                errors.push((self.reference_set.quantile_in(group, sample, &found), light));
            }
        }
        for (object, details) in details_of_objects.iter_mut().enumerate() {
            let mut own = errors[self.reference_set.group_of(object)].clone();
            own.sort();
            let mut sum = 0.0;
            let unused: Vec<u32> = own
                .into_iter()
                .take_while(|(error, _)| {
                    sum += f64::from(*error);
                    sum <= limit
                })
                .map(|(_, light)| light)
                .collect();
            details.leave_out(&unused);
        }
        Ok(details_of_objects)
    }

    fn draw(&mut self, candidate: &Candidate) -> Result<Vec<u8>, PipelineError> {
        probe_pixels::draw(self.renderer, self.budget, candidate.interp, &candidate.recipes)
    }

    /// Returns the cost of one object under a candidate's settings.
    fn object_cost(&self, object: usize, candidate: &Candidate) -> f64 {
        settings::cost(
            &self.budget.scene.objects[object],
            self.budget,
            &candidate.recipes[object],
            candidate.interp,
            self.reference_set.pixels_of[object],
        )
    }

    fn cost(&self, candidate: &Candidate) -> f64 {
        (0..candidate.recipes.len()).map(|o| self.object_cost(o, candidate)).sum()
    }
}

/// Returns the index of each group's cheapest valid evaluation, with one interpolation for all
/// groups, such that the total cost is minimal. Returns `None` if no interpolation is valid for
/// every group.
fn best(evaluations: &[Evaluation], groups: usize) -> Option<Vec<usize>> {
    let mut least: Option<(f64, Vec<usize>)> = None;
    for interp in Interpolation::ALL {
        let cheapest = |group: usize| {
            let holding =
                evaluations.iter().enumerate().filter(|(_, e)| e.interp == *interp && e.holds[group]);
            holding.min_by(|a, b| a.1.costs[group].total_cmp(&b.1.costs[group])).map(|(i, _)| i)
        };
        let Some(all) = (0..groups).map(cheapest).collect::<Option<Vec<usize>>>() else { continue };
        let cost = all.iter().enumerate().map(|(group, &e)| evaluations[e].costs[group]).sum();
        if least.as_ref().is_none_or(|(l, _)| cost < *l) {
            least = Some((cost, all));
        }
    }
    least.map(|(_, all)| all)
}

#[cfg(test)]
mod tests;

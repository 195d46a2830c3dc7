//! Choice by trial: one cheaper picture, compared with the exact one at every pixel.
//!
//! In: a state that is drawn again and again, with what is proven for it. Out: the settings of those
//! objects whose pixels stay within the limit. The second picture is drawn only if the calibration says
//! that it is cheaper.

use super::costs::cost;
use super::settings::QualitySettings;
use super::{Budget, BudgetKind, Choice, Trial, steps_of_rounding};
use crate::memory::{PickBuffer, VideoMemory};
use crate::pipeline::draw_call::{DepthUse, PipelineError, SceneOptions, Target};
use crate::pipeline::renderer::Renderer;
use crate::pipeline::scene::calls_of;
use crate::scene::{Cull, FillStyle, Filter, HiddenSurface, Light, Object, Scene, ShadeMode};

/// Part of the pixels that may be over E.
const PART_OVER: f64 = 0.001;
/// Part of the exact picture's cost that the other one must save.
const LEAST_SAVING: f64 = 0.05;
/// Bytes of a trial per pixel: two frames with depths, and pick buffers.
const PIXEL_BYTES: u64 = 48;
/// E from which flat shading is tried where light varies over a face.
const FLAT_FROM: f64 = 8.0;

/// Returns the maximum bytes of a trial, without the renderer's working memory: two frames with
/// depths and ids, and copies of the scene's objects.
pub fn trial_bytes(scene: &Scene, width: u32, height: u32) -> u64 {
    let object = size_of::<Object>() + scene.lights.len() * size_of::<Light>();
    u64::from(width) * u64::from(height) * PIXEL_BYTES + (2 * scene.objects.len() * object) as u64
}

/// A picture, and the object that each pixel shows.
struct Picture {
    memory: VideoMemory,
    ids: PickBuffer,
}

/// Draws the state exactly and once with cheaper settings; returns `proven` with those settings that
/// stay within the budget.
///
/// # Errors
/// As [`super::super::draw_scene`].
pub fn try_out(renderer: &mut Renderer, budget: &Budget, proven: Choice) -> Result<Choice, PipelineError> {
    let mut choice = proven;
    if budget.exact_reason().is_some() {
        return Ok(choice);
    }
    let objects = &budget.scene.objects;
    let exact = picture(renderer, budget, &vec![QualitySettings::default(); objects.len()])?;
    let owners = owners(&exact, budget);
    let mut pixels = vec![0.0; objects.len()];
    owners.iter().filter(|o| **o < objects.len()).for_each(|o| pixels[*o] += 1.0);
    let mut settings = choice.settings.clone();
    let mut tried = vec![false; objects.len()];
    choice.costs = [0.0; 2];
    for (i, object) in objects.iter().enumerate() {
        let of = |s: &QualitySettings| cost(object, budget, s, pixels[i]).sum();
        let (whole, mut least) = (of(&QualitySettings::default()), of(&choice.settings[i]));
        for candidate in candidates(object, budget) {
            let own = of(&candidate);
            if own < least && own <= (1.0 - LEAST_SAVING) * whole {
                (least, settings[i], tried[i]) = (own, candidate, true);
            }
        }
        choice.costs[0] += whole;
        choice.costs[1] += of(&choice.settings[i]);
    }
    let saved: f64 = (0..objects.len())
        .map(|i| {
            let of = |s: &QualitySettings| cost(&objects[i], budget, s, pixels[i]).sum();
            of(&choice.settings[i]) - of(&settings[i])
        })
        .sum();
    if saved < LEAST_SAVING * choice.costs[0] || !tried.contains(&true) {
        choice.notes.push("no other settings are cheaper by the calibration".to_owned());
        return Ok(choice);
    }
    let cheaper = picture(renderer, budget, &settings)?;
    let errors = Errors::of(&exact.memory, &cheaper.memory, &owners, objects, budget.max_error);
    let is_apart = !objects.iter().any(is_transparent);
    let holds_for_all = (0..objects.len()).all(|i| errors.holds(i));
    let mut trial = errors.summary();
    trial.objects = tried.iter().filter(|t| **t).count();
    for i in 0..objects.len() {
        if tried[i] && (holds_for_all || is_apart && errors.holds(i)) {
            choice.costs[1] -= cost(&objects[i], budget, &choice.settings[i], pixels[i]).sum();
            choice.costs[1] += cost(&objects[i], budget, &settings[i], pixels[i]).sum();
            choice.settings[i] = settings[i].clone();
            trial.holds_for += 1;
        }
    }
    choice.trial = Some(trial);
    Ok(choice)
}

/// Returns the settings to try for an object. Only what may pay is tried: bilinear for a filter
/// between levels (the same colours where the texture is magnified), Gouraud, and flat.
fn candidates(object: &Object, budget: &Budget) -> Vec<QualitySettings> {
    let own = object.shade.unwrap_or(budget.options.shade);
    let is_slow = object.back_material.is_some()
        || object.two_sided_lighting && object.cull != Cull::Back
        || object.style.stages.is_some()
        || object.style.fill != FillStyle::default()
        || is_transparent(object);
    let mut shades = vec![None];
    if own == ShadeMode::Phong && !is_slow {
        shades.push(Some(ShadeMode::Gouraud));
    }
    if matches!(own, ShadeMode::Phong | ShadeMode::Gouraud) && !is_slow && budget.max_error >= FLAT_FROM {
        shades.push(Some(ShadeMode::Flat));
    }
    let between = [Some(Filter::Trilinear), Some(Filter::Mipmap)];
    let filters: &[Option<Filter>] = match object.texture.as_ref().map(|t| t.1.filter) {
        own if between.contains(&own) => &[None, Some(Filter::Bilinear)],
        _ => &[None],
    };
    let each = shades.iter().flat_map(|shade| {
        filters.iter().map(|filter| QualitySettings { shade: *shade, filter: *filter, lights: None })
    });
    each.filter(|s| *s != QualitySettings::default()).collect()
}

/// Returns whether an object may be transparent.
fn is_transparent(object: &Object) -> bool {
    let mesh = &object.geometry.mesh;
    let mut materials = mesh.materials.iter().chain([&object.material]).chain(&object.back_material);
    let mut textures = object.geometry.textures.iter().flatten().chain(object.texture.iter().map(|t| &t.0));
    materials.any(|m| m.transparency > 0.0)
        || textures.any(|t| t.has_alpha())
        || mesh.colors.iter().any(|c| c.w < 1.0)
}

/// Returns the object of each pixel; an index past the last one where none was drawn.
fn owners(picture: &Picture, budget: &Budget) -> Vec<usize> {
    let width = picture.memory.width() as usize;
    let count = budget.scene.objects.len();
    let pixels = picture.memory.bytes().chunks_exact(4).enumerate();
    let owner = |(i, pixel): (usize, &[u8])| {
        let id = picture.ids.get((i % width) as i32, (i / width) as i32).map(|id| id.0 as usize);
        // Transparent faces have alpha 255 in the frame, and no id.
        if pixel[3] == 0 { count + 1 } else { id.unwrap_or(count).min(count) }
    };
    pixels.map(owner).collect()
}

/// Differences of two pictures, by object.
struct Errors {
    /// Number of pixels by their difference, over all objects.
    all: [usize; 256],
    /// Pixels of each object, and those over the limit; last, pixels of no single object.
    counts: Vec<[usize; 2]>,
    over: usize,
}

impl Errors {
    fn of(exact: &VideoMemory, found: &VideoMemory, owners: &[usize], objects: &[Object], e: f64) -> Errors {
        // The exact picture may be off by its own rounding.
        let limits: Vec<f64> = objects.iter().map(|o| e - steps_of_rounding(o)).collect();
        let least = limits.iter().copied().fold(e - 1.0, f64::min);
        let mut errors = Errors { all: [0; 256], counts: vec![[0; 2]; objects.len() + 1], over: 0 };
        let pairs = exact.bytes().chunks_exact(4).zip(found.bytes().chunks_exact(4));
        for ((a, b), owner) in pairs.zip(owners) {
            let Some(count) = errors.counts.get_mut(*owner) else { continue };
            let error = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
            let is_over = f64::from(error) > limits.get(*owner).copied().unwrap_or(least).max(0.0);
            count[0] += 1;
            count[1] += usize::from(is_over);
            errors.all[usize::from(error)] += 1;
            errors.over += usize::from(is_over);
        }
        errors
    }

    /// Returns whether few enough of an object's pixels, and of those of no single object, are over
    /// the limit.
    fn holds(&self, object: usize) -> bool {
        let is_within = |[all, over]: [usize; 2]| over as f64 <= PART_OVER * all as f64;
        is_within(self.counts[object]) && is_within(self.counts[self.counts.len() - 1])
    }

    fn summary(&self) -> Trial {
        let pixels: usize = self.all.iter().sum();
        let needed = ((1.0 - PART_OVER) * pixels as f64).ceil() as usize;
        let mut sum = 0;
        let quantile = self.all.iter().position(|count| {
            sum += count;
            sum >= needed
        });
        Trial { pixels, over: self.over, error: quantile.unwrap_or(0) as u8, objects: 0, holds_for: 0 }
    }
}

/// Draws the objects with these settings on a cleared frame, without a background.
fn picture(
    renderer: &mut Renderer,
    budget: &Budget,
    settings: &[QualitySettings],
) -> Result<Picture, PipelineError> {
    let mut scene = budget.scene.clone();
    (scene.background.color, scene.sky) = (None, None);
    scene.objects.iter_mut().zip(settings).for_each(|(object, own)| own.apply(object));
    let no_frame = |_| PipelineError::NotFinite { what: "the frame's size" };
    let mut memory = VideoMemory::new(budget.width, budget.height).map_err(no_frame)?;
    memory.bytes_mut().fill(0);
    let mut ids = PickBuffer::new(budget.width, budget.height);
    let mut depth = None;
    let mut target = Target {
        memory: &mut memory,
        depth: &mut depth,
        depth_format: budget.depth_format,
        ids: (budget.options.hide == HiddenSurface::ZBuffer).then_some(&mut ids),
    };
    let options = SceneOptions { first_name: 0, depth_use: DepthUse::Keep, ..budget.options.clone() };
    match budget.kind {
        BudgetKind::Scene => drop(renderer.draw_scene(&mut target, &scene, &options)?),
        BudgetKind::Draws => {
            for call in calls_of(&scene, &options) {
                renderer.draw(&mut target, &call)?;
            }
        }
    }
    Ok(Picture { memory, ids })
}

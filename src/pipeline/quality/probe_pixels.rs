//! Sampled pixels of an error budget, and the reference values at them.

use super::super::draw_call::{DepthUse, PipelineError, SceneOptions, Target};
use super::super::renderer::Renderer;
use super::super::scene::calls_of;
use super::settings::QualitySettings;
use super::{Budget, BudgetKind, CERTIFY, LOOK_AT_ALL, SELECT};
use crate::memory::{PickBuffer, VideoMemory};
use crate::scene::{HiddenSurface, Interpolation, Scene, ShadeMode};
use crate::truth::compare::color_error;
use crate::truth::scenes::Random;
use crate::truth::{self, Settings, Transparency, TruthPicture};

/// Scenes of more triangles are compared with the exact pipeline instead of the 32-digit reference.
const MAX_TRUTH_FACES: usize = 20_000;

/// Seed of the random order of pixels.
const SEED: u64 = 0x5eed_2026;

/// Fraction of a group's pixels in the selection that may be over E: half of the promised one.
const PART_OVER_IN_SELECTION: f64 = 0.0005;

/// The exact picture: its pixels that are drawn on, and their objects.
pub(super) struct ReferenceSet {
    /// Indices (width y + x) of pixels drawn on, in random order.
    pub drawn_on: Vec<usize>,
    /// Group of objects that each pixel shows, if known.
    pub owner: Vec<Option<u32>>,
    /// Number of groups.
    pub groups: usize,
    /// Pixels that each object covers; if that is unknown, all pixels divided in proportion to the
    /// objects' faces.
    pub pixels_of: Vec<f64>,
    /// Bytes of the exact picture.
    bytes: Vec<u8>,
}

impl ReferenceSet {
    /// Draws the exact picture.
    pub fn new(renderer: &mut Renderer, budget: &Budget) -> Result<ReferenceSet, PipelineError> {
        let objects = budget.scene.objects.len();
        let (width, height) = (budget.width, budget.height);
        // Drawn pixels have alpha 255; others keep 0.
        let mut bare = budget.scene.clone();
        bare.background.color = None;
        bare.sky = None;
        let mut memory = VideoMemory::new(width, height).map_err(|_| no_frame())?;
        memory.bytes_mut().fill(0);
        let mut ids = PickBuffer::new(width, height);
        let options = SceneOptions { first_name: 0, ..budget.options.clone() };
        draw_into(renderer, budget, &bare, &options, &mut memory, Some(&mut ids))?;
        let mut drawn_on: Vec<usize> =
            memory.bytes().chunks_exact(4).enumerate().filter(|(_, p)| p[3] == 255).map(|(i, _)| i).collect();
        shuffle(&mut drawn_on);
        // One object per pixel, unless objects are transparent or depth does not decide.
        let is_apart = options.hide == HiddenSurface::ZBuffer && !sees_through(budget.scene);
        let owner: Vec<Option<u32>> = (0..width as usize * height as usize)
            .map(|i| match is_apart {
                true => ids.get((i % width as usize) as i32, (i / width as usize) as i32).map(|id| id.0),
                false => Some(0),
            })
            .collect();
        let mut pixels_of = vec![0.0; objects];
        if is_apart {
            drawn_on.iter().filter_map(|&i| owner[i]).for_each(|o| pixels_of[o as usize] += 1.0);
        } else {
            let faces = |o: usize| budget.scene.objects[o].geometry.mesh.triangles.len() as f64;
            let all: f64 = (0..objects).map(faces).sum();
            pixels_of = (0..objects).map(|o| drawn_on.len() as f64 * faces(o) / f64::max(all, 1.0)).collect();
        }
        let recipes = vec![QualitySettings::default(); objects];
        let bytes = draw(renderer, budget, budget.options.interp, &recipes)?;
        Ok(ReferenceSet { drawn_on, owner, groups: if is_apart { objects } else { 1 }, pixels_of, bytes })
    }

    /// Returns the group of an object.
    pub fn group_of(&self, object: usize) -> usize {
        if self.groups == 1 { 0 } else { object }
    }

    /// Returns the pixels on which settings are compared.
    pub fn selection(&self) -> Vec<usize> {
        self.pixels(0, SELECT)
    }

    /// Returns the fresh pixels of certification number `attempt`.
    pub fn certification(&self, attempt: usize) -> Vec<usize> {
        self.pixels(SELECT + attempt * CERTIFY, CERTIFY)
    }

    /// Returns `count` pixels from index `first` of the random order, or all pixels if there are
    /// few.
    fn pixels(&self, first: usize, count: usize) -> Vec<usize> {
        let all = self.drawn_on.len();
        if all <= LOOK_AT_ALL || first + count > all {
            return self.drawn_on.clone();
        }
        self.drawn_on[first..first + count].to_vec()
    }

    /// Returns for each group whether few enough of its pixels are over `limit`.
    pub fn groups_that_hold(&self, sample: &[usize], errors: &[u8], limit: f64) -> Vec<bool> {
        let mut counts = vec![[0usize; 2]; self.groups];
        for (&i, &error) in sample.iter().zip(errors) {
            if let Some(group) = self.owner[i] {
                counts[group as usize][0] += 1;
                counts[group as usize][1] += usize::from(f64::from(error) > limit);
            }
        }
        counts.iter().map(|[all, over]| *over as f64 <= PART_OVER_IN_SELECTION * *all as f64).collect()
    }

    /// Returns the 99.9th percentile of a group's errors.
    pub fn quantile_in(&self, group: usize, sample: &[usize], errors: &[u8]) -> u8 {
        let own = sample.iter().zip(errors).filter(|(i, _)| self.owner[**i] == Some(group as u32));
        let own: Vec<u8> = own.map(|(_, e)| *e).collect();
        quantile(&own, 0.999)
    }
}

/// Returns the smallest value that at least a fraction `part` of the errors do not exceed; 0 for an
/// empty slice.
pub(super) fn quantile(errors: &[u8], part: f64) -> u8 {
    let mut sorted = errors.to_vec();
    sorted.sort_unstable();
    let needed = (part * sorted.len() as f64).ceil() as usize;
    sorted.get(needed.max(1) - 1).copied().unwrap_or(0)
}

/// Returns how many of `n` random pixels may be over the limit, such that the chance of so few is
/// at most `doubt` if a fraction `p` of all pixels is over it; and that chance. `n` must be so
/// large that the chance of 0 is at most `doubt`.
pub(super) fn allowed_over(n: usize, p: f64, doubt: f64) -> (usize, f64) {
    // Terms of the binomial distribution, each computed from the previous one.
    let mut term = libm::pow(1.0 - p, n as f64);
    let (mut sum, mut k) = (term, 0);
    loop {
        term *= (n - k) as f64 / (k + 1) as f64 * (p / (1.0 - p));
        if k == n || sum + term > doubt {
            return (k, sum);
        }
        sum += term;
        k += 1;
    }
}

/// Shuffles a list into a fixed random order.
fn shuffle(list: &mut [usize]) {
    let mut random = Random::new(SEED);
    for last in (1..list.len()).rev() {
        list.swap(last, random.below(last as u32 + 1) as usize);
    }
}

/// Returns whether any object may be transparent.
fn sees_through(scene: &Scene) -> bool {
    scene.objects.iter().any(|o| {
        let mesh = &o.geometry.mesh;
        let mut materials = mesh.materials.iter().chain([&o.material]).chain(&o.back_material);
        let mut textures = o.geometry.textures.iter().flatten().chain(o.texture.iter().map(|t| &t.0));
        materials.any(|m| m.transparency > 0.0)
            || textures.any(|t| t.has_alpha())
            || mesh.colors.iter().any(|c| c.w < 1.0)
    })
}

/// Returns the bytes of the picture in which objects use these settings.
pub(super) fn draw(
    renderer: &mut Renderer,
    budget: &Budget,
    interp: Interpolation,
    recipes: &[QualitySettings],
) -> Result<Vec<u8>, PipelineError> {
    let mut scene = budget.scene.clone();
    scene.objects.iter_mut().zip(recipes).for_each(|(object, recipe)| recipe.apply(object));
    let mut memory = VideoMemory::new(budget.width, budget.height).map_err(|_| no_frame())?;
    let options = SceneOptions { interp, ..budget.options.clone() };
    draw_into(renderer, budget, &scene, &options, &mut memory, None)?;
    Ok(memory.bytes().to_vec())
}

/// Draws the objects as a scene or as single draws, depending on the budget's kind.
fn draw_into(
    renderer: &mut Renderer,
    budget: &Budget,
    scene: &Scene,
    options: &SceneOptions,
    memory: &mut VideoMemory,
    ids: Option<&mut PickBuffer>,
) -> Result<(), PipelineError> {
    let mut depth = None;
    let mut target = Target { memory, depth: &mut depth, depth_format: budget.depth_format, ids };
    let options = SceneOptions { depth_use: DepthUse::Keep, ..options.clone() };
    match budget.kind {
        BudgetKind::Scene => renderer.draw_scene(&mut target, scene, &options).map(drop),
        BudgetKind::Draws => {
            calls_of(scene, &options).iter().try_for_each(|call| renderer.draw(&mut target, call).map(drop))
        }
    }
}

/// Unreachable in practice: a frame of this size exists already.
fn no_frame() -> PipelineError {
    PipelineError::NotFinite { what: "the frame's size" }
}

/// Reference that errors are measured against.
pub(super) enum Reference {
    /// The right answers of the 32-digit reference.
    Truth(Box<TruthPicture>),
    /// The bytes of the exact pipeline.
    Exact(Vec<u8>),
}

impl Reference {
    /// Computes the reference values at the pixels of `sample`.
    pub fn of(
        budget: &Budget,
        reference_set: &ReferenceSet,
        sample: &[usize],
    ) -> Result<Reference, PipelineError> {
        let mut scene = budget.scene.clone();
        scene.camera = Some(scene.camera.unwrap_or(budget.options.camera));
        let faces: usize = scene.objects.iter().map(|o| o.geometry.mesh.triangles.len()).sum();
        // The 32-digit reference does not support wireframes whose hidden lines are removed by
        // depth.
        let has_wire = budget.options.hide == HiddenSurface::ZBuffer
            && scene.objects.iter().any(|o| o.shade.unwrap_or(budget.options.shade) == ShadeMode::Wire);
        if faces > MAX_TRUTH_FACES || has_wire {
            return Ok(Reference::Exact(reference_set.bytes.clone()));
        }
        let o = budget.options;
        let settings = Settings {
            viewport: Some(o.viewport),
            shade: o.shade,
            hide: o.hide,
            interpolation: o.interp,
            cull: None,
            transparency: match budget.kind {
                BudgetKind::Scene => Transparency::AfterOpaque(o.transparency),
                BudgetKind::Draws => Transparency::AtOnce,
            },
        };
        let width = budget.width as usize;
        let pixels: Vec<[u32; 2]> = sample.iter().map(|i| [(i % width) as u32, (i / width) as u32]).collect();
        let (w, h) = (budget.width, budget.height);
        let picture = truth::render_pixels(&scene, w, h, budget.depth_format, &settings, &pixels)?;
        Ok(Reference::Truth(Box::new(picture)))
    }

    /// Returns the reference's description.
    pub fn name(&self) -> &'static str {
        match self {
            Reference::Truth(_) => "the reference of 32 digits, at the sample's pixels",
            Reference::Exact(_) => {
                "the exact pipeline, itself within a step of the reference: a step is kept back"
            }
        }
    }

    /// Returns the allowed difference from this reference, in steps.
    pub fn limit(&self, max_error: f64) -> f64 {
        match self {
            Reference::Truth(_) => max_error,
            Reference::Exact(_) => max_error - 1.0,
        }
    }

    /// Returns the error of pixel `index` of a frame, in steps.
    pub fn error(&self, frame: &[u8], index: usize) -> u8 {
        let found: [u8; 4] = std::array::from_fn(|c| frame[4 * index + c]);
        match self {
            Reference::Truth(picture) => color_error(picture, index, found),
            Reference::Exact(bytes) => {
                (0..3).map(|c| bytes[4 * index + c].abs_diff(found[c])).max().unwrap_or(0)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_enough_over_is_what_the_binomial_distribution_says() {
        // P(X <= 3) of 12,000 at 1 in 1000: nearly Poisson's e^-12 (1 + 12 + 72 + 288) = 0.00229.
        let (allowed, doubt) = allowed_over(12_000, 0.001, 0.0025);
        assert_eq!(allowed, 3);
        assert!((doubt - 0.00229).abs() < 2e-5, "{doubt}");
        let (allowed, doubt) = allowed_over(6_000, 0.001, 0.0025);
        assert_eq!(allowed, 0);
        assert!((doubt - libm::exp(6_000.0 * libm::log(0.999))).abs() < 1e-12);
    }

    #[test]
    fn a_group_holds_with_one_pixel_in_two_thousand_over_its_limit() {
        // Groups of 4000, 2000 and 1999 pixels, and pixels of no object.
        let sizes = [4000, 2000, 1999];
        let mut owner: Vec<Option<u32>> = vec![None; 100];
        sizes.iter().zip(0..).for_each(|(size, group)| owner.extend(vec![Some(group); *size]));
        let set = ReferenceSet { drawn_on: vec![], owner, groups: 3, pixels_of: vec![], bytes: vec![] };
        let sample: Vec<usize> = (0..set.owner.len()).collect();
        let mut errors = vec![3; sample.len()];
        errors[..100].fill(200);
        assert_eq!(set.groups_that_hold(&sample, &errors, 3.0), [true; 3]);
        for first in [100, 4100, 6100] {
            errors[first] = 4;
        }
        assert_eq!(set.groups_that_hold(&sample, &errors, 3.0), [true, true, false]);
        for second in [101, 4101] {
            errors[second] = 4;
        }
        assert_eq!(set.groups_that_hold(&sample, &errors, 3.0), [true, false, false]);
        errors[102] = 4;
        assert_eq!(set.groups_that_hold(&sample, &errors, 3.0), [false; 3]);
    }

    #[test]
    fn quantiles_leave_one_in_a_thousand_out() {
        let mut errors = vec![0u8; 999];
        errors.push(9);
        assert_eq!((quantile(&errors, 0.999), quantile(&errors, 1.0), quantile(&[], 0.999)), (0, 9, 0));
        errors.push(9);
        assert_eq!(quantile(&errors, 0.999), 9);
    }
}

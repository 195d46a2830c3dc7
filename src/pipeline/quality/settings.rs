//! Quality settings of an object, their levels, and the cost table.
//!
//! Each object has a list of detail levels for shading, filtering and lights, from the exact one to
//! the cheapest. [`Levels`] gives the steps down from exact for all objects; an object with fewer
//! levels uses its last one.

use super::Budget;
use crate::scene::{Filter, Interpolation, Object, Scene, ShadeMode};
use std::fmt;

/// Deviations from drawing an object exactly; `None` leaves a property as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QualitySettings {
    /// Shading mode.
    pub shade: Option<ShadeMode>,
    /// Texture filter.
    pub filter: Option<Filter>,
    /// Indices of the lights that reach the object.
    pub lights: Option<Vec<u32>>,
}

impl QualitySettings {
    /// Applies the settings to an object.
    pub fn apply(&self, object: &mut Object) {
        object.shade = self.shade.or(object.shade);
        if let (Some(filter), Some((_, sampling))) = (self.filter, &mut object.texture) {
            sampling.filter = filter;
        }
        if let Some(lights) = &self.lights {
            object.lights = Some(lights.clone());
        }
    }
}

impl fmt::Display for QualitySettings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shade = self.shade.map(|s| format!("shade {}", s.as_str()));
        let filter = self.filter.map(|t| format!("filter {}", t.as_str()));
        let lights = self.lights.as_ref().map(|l| match l.len() {
            1 => "1 light".to_owned(),
            n => format!("{n} lights"),
        });
        let parts: Vec<String> = [shade, filter, lights].into_iter().flatten().collect();
        if parts.is_empty() { f.write_str("exact") } else { f.write_str(&parts.join(", ")) }
    }
}

/// Steps down from exact in shading, filter and lights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    /// Steps in shading.
    pub shade: usize,
    /// Steps in filtering.
    pub filter: usize,
    /// Steps in lights: 0 or 1.
    pub lights: usize,
}

impl Levels {
    /// Returns all combinations that change some object, fewest steps first.
    pub(super) fn of(details_of_objects: &[DetailLevels]) -> Vec<Levels> {
        let longest =
            |f: fn(&DetailLevels) -> usize| details_of_objects.iter().map(f).max().unwrap_or(1).max(1);
        let shades = longest(|l| l.shades.len());
        let filters = longest(|l| l.filters.len());
        let lights = 1 + usize::from(details_of_objects.iter().any(|l| l.few_lights.is_some()));
        let mut all = Vec::new();
        for shade in 0..shades {
            for filter in 0..filters {
                all.extend((0..lights).map(|lights| Levels { shade, filter, lights }));
            }
        }
        all.sort_by_key(|l| l.shade + l.filter + l.lights);
        all
    }

    /// Returns whether `other` takes at least these steps.
    pub(super) fn is_within(self, other: Levels) -> bool {
        self.shade <= other.shade && self.filter <= other.filter && self.lights <= other.lights
    }
}

/// Detail levels of an object, the exact one first.
#[derive(Clone, Debug)]
pub(super) struct DetailLevels {
    shades: Vec<ShadeMode>,
    filters: Vec<Filter>,
    own_lights: Vec<u32>,
    few_lights: Option<Vec<u32>>,
}

impl DetailLevels {
    /// Returns the levels of an object of `scene`.
    pub fn of(object: &Object, scene: &Scene, options: &super::SceneOptions) -> DetailLevels {
        let own = object.shade.unwrap_or(options.shade);
        let shades = match own {
            ShadeMode::Phong => vec![ShadeMode::Phong, ShadeMode::Gouraud, ShadeMode::Flat],
            ShadeMode::Gouraud => vec![ShadeMode::Gouraud, ShadeMode::Flat],
            other => vec![other],
        };
        let filters = match object.texture.as_ref().map(|t| t.1.filter) {
            None => Vec::new(),
            Some(Filter::Trilinear) => {
                vec![Filter::Trilinear, Filter::Mipmap, Filter::Bilinear, Filter::Nearest]
            }
            Some(Filter::Mipmap) => vec![Filter::Mipmap, Filter::Bilinear, Filter::Nearest],
            Some(Filter::Bilinear) => vec![Filter::Bilinear, Filter::Nearest],
            Some(Filter::Nearest) => vec![Filter::Nearest],
        };
        let own_lights = object.lights.clone().unwrap_or_else(|| (0..scene.lights.len() as u32).collect());
        DetailLevels { shades, filters, own_lights, few_lights: None }
    }

    /// Returns the lights that reach the object, without one of them.
    pub fn lights_without(&self, light: u32) -> Vec<u32> {
        self.own_lights.iter().copied().filter(|&l| l != light).collect()
    }

    /// Sets the reduced light list to all lights except `unused`, if that leaves any out.
    pub fn leave_out(&mut self, unused: &[u32]) {
        let kept: Vec<u32> = self.own_lights.iter().copied().filter(|l| !unused.contains(l)).collect();
        self.few_lights = (kept.len() < self.own_lights.len()).then_some(kept);
    }

    /// Returns the object's settings at these levels.
    pub fn recipe(&self, levels: Levels) -> QualitySettings {
        let at = |steps: usize, len: usize| steps.min(len.saturating_sub(1));
        let (shade, filter) = (at(levels.shade, self.shades.len()), at(levels.filter, self.filters.len()));
        QualitySettings {
            shade: self.shades.get(shade).copied().filter(|_| shade > 0),
            filter: self.filters.get(filter).copied().filter(|_| filter > 0),
            lights: self.few_lights.clone().filter(|_| levels.lights > 0),
        }
    }
}

/// Returns the interpolations to try, the exact one first.
pub(super) fn interpolations(own: Interpolation) -> Vec<Interpolation> {
    match own {
        Interpolation::Perspective => vec![Interpolation::Perspective, Interpolation::Affine],
        Interpolation::Affine => vec![Interpolation::Affine],
    }
}

/// Returns a description of levels for a report.
pub(super) fn name(
    levels: Levels,
    details_of_objects: &[DetailLevels],
    interp: Interpolation,
    own_interp: Interpolation,
) -> String {
    let mut recipes: Vec<String> = Vec::new();
    for details in details_of_objects {
        let text = details.recipe(levels).to_string();
        if !recipes.contains(&text) && recipes.len() < 3 {
            recipes.push(text);
        }
    }
    if interp != own_interp {
        recipes.push(format!("values {}", interp.as_str()));
    }
    recipes.join("; ")
}

/// Groups equal settings, in order of their first object, and counts the objects of each group.
pub(super) fn grouped(recipes: &[QualitySettings]) -> Vec<(&QualitySettings, usize)> {
    let mut groups: Vec<(&QualitySettings, usize)> = Vec::new();
    for recipe in recipes {
        match groups.iter_mut().find(|g| g.0 == recipe) {
            Some(group) => group.1 += 1,
            None => groups.push((recipe, 1)),
        }
    }
    groups
}

// Cost table. A unit is about a nanosecond of a core of 2024, but only the order matters: the
// numbers are the same on every machine, and so are the choices.
/// Cost of a covered pixel, in any mode.
const PIXEL: f64 = 4.0;
/// Cost of perspective-correct interpolation per pixel.
const PERSPECTIVE: f64 = 4.0;
/// Cost of normalizing the normal and interpolating the point, per pixel.
const PHONG: f64 = 14.0;
/// Cost of interpolating a colour per pixel.
const GOURAUD: f64 = 2.0;
/// Cost of one light at one point.
const LIGHT: f64 = 10.0;
/// Cost of preparing a corner or a face for lighting.
const CORNER: f64 = 12.0;

fn filter_cost(filter: Filter) -> f64 {
    match filter {
        Filter::Nearest => 5.0,
        Filter::Bilinear => 14.0,
        Filter::Mipmap => 20.0,
        Filter::Trilinear => 34.0,
    }
}

/// Returns the cost of drawing an object that covers `pixels` pixels.
pub(super) fn cost(
    object: &Object,
    budget: &Budget,
    recipe: &QualitySettings,
    interp: Interpolation,
    pixels: f64,
) -> f64 {
    let lights = match (&recipe.lights, &object.lights) {
        (Some(some), _) | (None, Some(some)) => some.len(),
        (None, None) => budget.scene.lights.len(),
    };
    let lighting = LIGHT * lights as f64;
    let mesh = &object.geometry.mesh;
    let filter = object.texture.as_ref().map(|t| filter_cost(recipe.filter.unwrap_or(t.1.filter)));
    let shade = recipe.shade.or(object.shade).unwrap_or(budget.options.shade);
    let (at_pixels, once) = match shade {
        ShadeMode::Phong => (PHONG + lighting, 0.0),
        ShadeMode::Gouraud => (GOURAUD, mesh.corners.len() as f64 * (CORNER + lighting)),
        ShadeMode::Flat => (0.0, mesh.triangles.len() as f64 * (CORNER + lighting)),
        ShadeMode::Wire => (0.0, 0.0),
    };
    let runs = shade != ShadeMode::Flat || filter.is_some();
    let division = if runs && interp == Interpolation::Perspective { PERSPECTIVE } else { 0.0 };
    once + pixels * (PIXEL + division + at_pixels + filter.unwrap_or(0.0))
}

//! Ways of drawing one scene: as it asks, one other mode at a time, and within error budgets.

use super::super::experiment::{Bound, Standing};
use super::super::picture::scene_options;
use super::scenes::faces;
use super::{LARGEST, PERCENTILE, bound};
use fbptr_core::memory::DepthFormat;
use fbptr_core::pipeline::SceneOptions;
use fbptr_core::pipeline::quality::{Budget, Choice, MeshShapes, prove};
use fbptr_core::scene::{Filter, HiddenSurface, Interpolation, ShadeMode};
use fbptr_truth::scenes::Case;

/// One way of drawing a scene.
pub(super) struct Way {
    /// Name of the alternative.
    pub name: String,
    /// Standing of the alternative.
    pub standing: Standing,
    /// The scene and its modes, drawn this way.
    pub case: Case,
    /// Options of its drawing.
    pub options: SceneOptions,
    /// Promises.
    pub bounds: Vec<Bound>,
}

impl Way {
    /// Creates a mode of which nothing is promised.
    fn mode(name: &str, case: Case) -> Way {
        Way::new(name.into(), Standing::Mode, case, Vec::new())
    }

    fn new(name: String, standing: Standing, case: Case, bounds: Vec<Bound>) -> Way {
        let options = scene_options(&case).unwrap_or(SceneOptions::new(case.width, case.height));
        Way { name, standing, case, options, bounds }
    }
}

/// The budgets that are asked for.
const BUDGETS: [f64; 4] = [1.0, 4.0, 16.0, 40.0];
/// Largest number of faces that are sorted for the painter's algorithm here.
const MOST_SORTED: usize = 10_000;

/// Returns the ways of a case, the default first.
pub(super) fn of(case: &Case) -> Vec<Way> {
    let because = "the limit of textured colours, 2, or of others, 1, by the specification";
    let bounds = vec![bound(LARGEST, limit(case), because)];
    let mut ways = vec![Way::new("as asked".into(), Standing::Default, case.clone(), bounds)];
    for shade in [ShadeMode::Gouraud, ShadeMode::Flat] {
        let mut other = case.clone();
        other.settings.shade = shade;
        other.scene.objects.iter_mut().for_each(|o| o.shade = o.shade.map(|_| shade));
        if case.settings.shade == ShadeMode::Phong {
            ways.push(Way::mode(shade.as_str(), other));
        }
    }
    for &filter in Filter::ALL {
        let mut other = case.clone();
        let mut changed = 0;
        for (_, sampling) in other.scene.objects.iter_mut().filter_map(|o| o.texture.as_mut()) {
            changed += usize::from(std::mem::replace(&mut sampling.filter, filter) != filter);
        }
        if changed > 0 {
            ways.push(Way::mode(filter.as_str(), other));
        }
    }
    let mut affine = case.clone();
    affine.settings.interpolation = Interpolation::Affine;
    ways.push(Way::mode("affine", affine));
    for format in [DepthFormat::U16, DepthFormat::U24, DepthFormat::U32, DepthFormat::Reversed] {
        ways.push(Way::mode(&format!("depth {}", format.as_str()), Case { format, ..case.clone() }));
    }
    if faces(case) <= MOST_SORTED {
        let mut painter = case.clone();
        painter.settings.hide = HiddenSurface::Painter;
        ways.push(Way::mode("painter", painter));
    }
    ways.extend(BUDGETS.iter().filter_map(|e| within(case, *e)));
    ways
}

/// Returns the limit of a case's colours, in 1/255.
pub(super) fn limit(case: &Case) -> f64 {
    let is_textured = |o: &fbptr_core::scene::Object| {
        o.texture.is_some()
            || o.geometry.textures.iter().any(Option::is_some)
            || o.style.stages.is_some()
            || o.style.maps.is_some()
    };
    if case.scene.objects.iter().any(is_textured) || case.scene.sky.is_some() { 2.0 } else { 1.0 }
}

/// Returns the way that a budget chooses; `None` if the scene cannot be drawn.
fn within(case: &Case, max_error: f64) -> Option<Way> {
    let options = scene_options(case)?;
    let budget = Budget { scene: &case.scene, options: &options, max_error: max_error.into() };
    let choice = prove(&budget, &mut MeshShapes::at_once());
    let mut cheaper = case.clone();
    choice.apply(&mut cheaper.scene);
    let name = format!("max-error {max_error}: {}", in_words(&choice));
    // An exact picture keeps its own limit.
    let at_most = if choice.is_exact() { max_error.max(limit(case)) } else { max_error };
    let bounds = vec![bound(PERCENTILE, at_most, "the budget's promise, which is what was asked for")];
    Some(Way::new(name, Standing::Mode, cheaper, bounds))
}

/// Returns what was chosen, in a few words.
fn in_words(choice: &Choice) -> String {
    let cheaper: Vec<String> =
        choice.settings.iter().map(|s| s.to_string()).filter(|s| s != "exact").collect();
    match (cheaper.len(), choice.settings.len()) {
        (0, _) => "exact".into(),
        (1, 1) => cheaper[0].clone(),
        (some, all) => format!("{}, {some} of {all} objects", cheaper[0]),
    }
}

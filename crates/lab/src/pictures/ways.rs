//! Ways of drawing one scene: as it asks, and in one other mode at a time that a stream can choose.

use super::super::experiment::{Bound, Standing};
use super::super::picture::scene_options;
use super::scenes::faces;
use super::{LARGEST, bound};
use fbptr_core::memory::DepthFormat;
use fbptr_core::pipeline::SceneOptions;
use fbptr_core::scene::{HiddenSurface, Interpolation};
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

/// Largest number of faces that are sorted for the painter's algorithm here.
const MOST_SORTED: usize = 10_000;

/// Returns the ways of a case, the default first.
pub(super) fn of(case: &Case) -> Vec<Way> {
    let because = "the limit of textured colours, 2, or of others, 1, by the specification";
    let bounds = vec![bound(LARGEST, limit(case), because)];
    let mut ways = vec![Way::new("as asked".into(), Standing::Default, case.clone(), bounds)];
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
    ways
}

/// Returns the limit of a case's colours, in 1/255.
pub(in super::super) fn limit(case: &Case) -> f64 {
    let is_textured = |o: &fbptr_core::scene::Object| {
        o.texture.is_some()
            || o.geometry.textures.iter().any(Option::is_some)
            || o.style.stages.is_some()
            || o.style.maps.is_some()
    };
    if case.scene.objects.iter().any(is_textured) || case.scene.sky.is_some() { 2.0 } else { 1.0 }
}

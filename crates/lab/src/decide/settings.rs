//! The settings that a report compares, as one table.
//!
//! In: the modes of a scene and the error budgets that are asked for. Out: the settings that apply
//! to it, the exact one first. A further setting is a variant of [`Setting`] and an arm of each
//! function here.

use fbptr_core::pipeline::SceneOptions;
use fbptr_core::pipeline::quality::{Budget, MeshShapes, prove};
use fbptr_core::scene::{Filter, Interpolation, MaxError, Sampling, Scene, ShadeMode};
use std::sync::Arc;

/// A way to draw a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// As the file asks.
    Exact,
    /// Within an error budget.
    Within(MaxError),
    /// With another shading of objects that ask for none.
    Shade(ShadeMode),
    /// With another filter of all textures.
    Filter(Filter),
    /// With textures interpolated without perspective.
    Affine,
    /// With a fan of so many rays along each hidden axis of an N-dimensional scene.
    Fan(u32),
}

impl Setting {
    /// Returns the name in tables.
    pub fn name(&self) -> String {
        match self {
            Setting::Exact => "exact".into(),
            Setting::Within(max_error) => format!("max-error {max_error}"),
            Setting::Shade(shade) => shade.as_str().into(),
            Setting::Filter(filter) => filter.as_str().into(),
            Setting::Affine => "affine".into(),
            Setting::Fan(rays) => format!("fan of {rays} rays"),
        }
    }

    /// Returns whether its error at each pixel is promised for every camera, not only measured for this
    /// one. A shift promises a colour from near the pixel, which is not compared here.
    pub fn is_promised(&self) -> bool {
        match self {
            Setting::Exact => true,
            Setting::Within(most) => most.shift == 0.0,
            _ => false,
        }
    }

    /// Changes a scene and its options to this setting.
    pub(super) fn apply(&self, scene: &mut Scene, options: &mut SceneOptions, shapes: &mut MeshShapes) {
        match *self {
            Setting::Exact | Setting::Fan(_) => {}
            Setting::Within(max_error) => {
                let choice = prove(&Budget { scene, options, max_error }, shapes);
                choice.apply(scene);
            }
            Setting::Shade(shade) => options.shade = shade,
            Setting::Filter(filter) => {
                let textures = scene.objects.iter_mut().filter_map(|o| o.texture.as_mut());
                textures.for_each(|(_, sampling)| sampling.filter = filter);
            }
            Setting::Affine => options.interp = Interpolation::Affine,
        }
    }
}

/// Returns the settings of a scene in three dimensions.
pub(super) fn of_scene(scene: &Scene, budgets: &[MaxError]) -> Vec<Setting> {
    let mut settings = vec![Setting::Exact];
    settings.extend(budgets.iter().map(|e| Setting::Within(*e)));
    settings.extend([ShadeMode::Gouraud, ShadeMode::Flat].map(Setting::Shade));
    if scene.objects.iter().any(|o| o.texture.is_some()) {
        settings.extend(Filter::ALL.iter().map(|filter| Setting::Filter(*filter)));
        settings.push(Setting::Affine);
    }
    settings
}

/// Returns the settings of a stream.
pub(super) fn of_stream(budgets: &[MaxError]) -> Vec<Setting> {
    let mut settings = vec![Setting::Exact];
    settings.extend(budgets.iter().map(|e| Setting::Within(*e)));
    settings
}

/// Returns the settings of a scene of N dimensions.
pub(super) fn of_eye() -> Vec<Setting> {
    let mut settings = vec![Setting::Exact];
    settings.extend([3, 9, 33, 129].map(Setting::Fan));
    settings
}

/// Work that a renderer is given: settings of equal work draw by the same code.
#[derive(Debug, PartialEq)]
pub(super) struct DrawnWork {
    objects: Vec<ObjectWork>,
    interpolation: Interpolation,
}

#[derive(Debug, PartialEq)]
struct ObjectWork {
    /// Address of the geometry, which the scene holds.
    geometry: usize,
    shade: ShadeMode,
    lights: Option<Vec<u32>>,
    sampling: Option<Sampling>,
    light_error: Option<f64>,
}

impl DrawnWork {
    /// Returns the work of a scene as it is given to the renderer.
    pub fn of(scene: &Scene, options: &SceneOptions) -> DrawnWork {
        let of_object = |o: &fbptr_core::scene::Object| ObjectWork {
            geometry: Arc::as_ptr(&o.geometry) as usize,
            shade: o.shade.unwrap_or(options.shade),
            lights: o.lights.clone(),
            sampling: o.texture.as_ref().map(|t| t.1),
            light_error: o.light_error,
        };
        let objects = scene.objects.iter().map(of_object).collect();
        DrawnWork { objects, interpolation: options.interp }
    }
}

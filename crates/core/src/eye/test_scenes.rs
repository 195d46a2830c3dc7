//! Plain scenes for unit tests.

use super::{EyeLight, EyeScene, Facet, Falloff, Pose, SceneParts};

/// Returns a scene without losses, seen from 0 along axis 0: screen sides of `size` at distance
/// `distance`, one for each of `pixels`, and `tan` for every hidden axis.
pub(super) fn scene(
    (distance, size, tan): (f64, f64, f64),
    pixels: &[u32],
    facets: Vec<Vec<Vec<f64>>>,
    lights: Vec<EyeLight>,
) -> EyeScene {
    let dim = facets[0].len();
    let parts = SceneParts {
        dim,
        pixels: pixels.to_vec(),
        distance,
        size: vec![size; pixels.len()],
        aperture_tan: vec![tan; dim - 1 - pixels.len()],
        diffuse: [0.5; 3],
        view: Falloff::OFF,
        background: [0.0; 3],
        pose: Pose::identity(dim),
        lights,
        facets: facets.into_iter().map(|v| Facet { v, color: [255.0; 3] }).collect(),
    };
    EyeScene::new(parts).unwrap()
}

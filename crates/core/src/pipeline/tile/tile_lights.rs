//! Lights that reach a tile, where a draw has many of bounded reach.
//!
//! In: the materials' lights with their reach, and a tile. Out: the materials with the lights whose
//! sphere meets the pyramid that the tile's pixels see from the eye. A light that is left out would
//! give exactly 0 to each of the tile's pixels ([`super::lighting::light`]), so that bytes do not
//! depend on tiles; one knows by pictures of many lights that equal those of all lights at each
//! pixel (tests).

use super::lighting::{FastLight, LightPosition};
use super::shading_state::{ColorSource, Eye, MaterialBinding, Shading};
use crate::math::coverage::PixelRect;
use crate::pipeline::light::MANY_LIGHTS;
use glam::DVec3;

/// Number of materials up to which lights are chosen by tile: each is copied.
const MOST_MATERIALS: usize = 16;

/// Returns the materials of a draw with the lights that may reach the pixels of a tile; `None` where
/// all are to be used.
pub(super) fn lights_of_tile<'a>(shading: &Shading<'a>, tile: PixelRect) -> Option<Vec<MaterialBinding<'a>>> {
    let is_many = |binding: &MaterialBinding<'_>| binding.lighting.lights.len() >= MANY_LIGHTS;
    let bindings = shading.bindings;
    let (ColorSource::Pixels(_), Eye::Perspective { ray }) = (shading.shader.source, shading.shader.eye)
    else {
        return None;
    };
    if bindings.len() > MOST_MATERIALS || !bindings.iter().any(is_many) {
        return None;
    }
    let planes = side_planes(ray, tile)?;
    let mut found = bindings.to_vec();
    for binding in &mut found {
        binding.lighting.lights.retain(|light| may_reach(light, &planes));
    }
    Some(found)
}

/// Returns the inward unit normals of the four planes through the eye and a tile's sides, half a
/// pixel and more outside of the centres; `None` if the tile has no pyramid in f64.
fn side_planes(ray: [[f32; 3]; 3], tile: PixelRect) -> Option<[DVec3; 4]> {
    let [first, right, down] = ray.map(|v| DVec3::from_array(v.map(f64::from)));
    let at = |x: i32, y: i32| first + right * f64::from(x) + down * f64::from(y);
    let (x0, y0, x1, y1) = (tile.x0 - 1, tile.y0 - 1, tile.x1, tile.y1);
    let corners = [at(x0, y0), at(x1, y0), at(x1, y1), at(x0, y1)];
    let middle: DVec3 = corners.iter().sum();
    let mut planes = [DVec3::ZERO; 4];
    for (i, plane) in planes.iter_mut().enumerate() {
        let normal = crate::math::matrix::unit(corners[i].cross(corners[(i + 1) % 4]))?;
        *plane = if normal.dot(middle) < 0.0 { -normal } else { normal };
    }
    Some(planes)
}

/// Returns whether a light may reach a point within the planes.
fn may_reach(light: &FastLight, planes: &[DVec3; 4]) -> bool {
    let LightPosition::At(position) = light.position else { return true };
    if light.reach2 < 0.0 {
        return false;
    }
    // The kernels compare in f32.
    let radius = f64::from(light.reach2).sqrt() * 1.001;
    let position = DVec3::from_array(position.map(f64::from));
    planes.iter().all(|plane| plane.dot(position) >= -radius)
}

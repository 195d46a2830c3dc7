//! Lights that reach a tile, where a draw has many of bounded reach.
//!
//! In: the materials' lights with their reach, and a tile. Out: the materials with the lights whose
//! sphere meets the pyramid that the tile's pixels see from the eye. A light that is left out would
//! give exactly 0 to each of the tile's pixels ([`super::lighting::light`]), so that bytes do not
//! depend on tiles; one knows by pictures of many lights that equal those of all lights at each
//! pixel (tests).

use super::lighting::{FastLight, LightPosition, MaterialLighting};
use super::shading_state::{ColorSource, Eye, MaterialBinding, RecycledBindings, Shading};
use crate::math::coverage::PixelRect;
use crate::pipeline::light::MANY_LIGHTS;
use glam::DVec3;
use std::cell::Cell;

/// Number of materials up to which lights are chosen by tile: each is copied.
const MOST_MATERIALS: usize = 16;

thread_local! {
    /// Lists of the thread's last tile: steady frames ask for no memory.
    static RECYCLED: Cell<RecycledBindings> = Cell::default();
}

/// The materials of a draw with the lights that may reach the pixels of a tile.
pub(super) struct TileLights<'a> {
    /// Materials, in the draw's order.
    pub bindings: Vec<MaterialBinding<'a>>,
    recycled: RecycledBindings,
}

impl Drop for TileLights<'_> {
    fn drop(&mut self) {
        let mut recycled = std::mem::take(&mut self.recycled);
        recycled.take_back(std::mem::take(&mut self.bindings));
        RECYCLED.set(recycled);
    }
}

/// Returns the materials of a draw with the lights that may reach the pixels of a tile; `None` where
/// all are to be used.
pub(super) fn lights_of_tile<'a>(shading: &Shading<'a>, tile: PixelRect) -> Option<TileLights<'a>> {
    let all = shading.bindings;
    let (ColorSource::Pixels(_), Eye::Perspective { ray }) = (shading.shader.source, shading.shader.eye)
    else {
        return None;
    };
    let has_end = |light: &FastLight| light.reach2 < f32::INFINITY;
    let pays = |binding: &MaterialBinding<'_>| {
        let lights = &binding.lighting.lights;
        lights.len() >= MANY_LIGHTS && lights.iter().any(has_end)
    };
    if all.len() > MOST_MATERIALS || !all.iter().any(pays) {
        return None;
    }
    let planes = side_planes(ray, tile)?;
    let most = all.iter().map(|binding| binding.lighting.lights.len()).max().unwrap_or_default();
    let mut recycled = RECYCLED.take();
    let mut bindings: Vec<MaterialBinding<'a>> = std::mem::take(&mut recycled.bindings);
    for binding in all {
        let of = &binding.lighting;
        let mut lights = Vec::new();
        if !of.lights.is_empty() {
            lights = recycled.lights.pop().unwrap_or_default();
            lights.clear();
            lights.reserve(most);
            lights.extend(of.lights.iter().filter(|light| may_reach(light, &planes)));
        }
        let MaterialLighting { diffuse, specular, exponent, model, needs_place, .. } = *of;
        let lighting = MaterialLighting { diffuse, specular, lights, exponent, model, needs_place };
        bindings.push(MaterialBinding { lighting, texture: binding.texture });
    }
    Some(TileLights { bindings, recycled })
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

//! Rendering a scene of R^N, in numbered steps.
//!
//! 1. The frame: facets in eye space, culled, nearest first (`frame`).
//! 2. The screen is split into slabs, one task each, and slabs into tiles.
//! 3. Each tile searches the fibres of its pixels, nearest facets first, until none can be nearer
//!    (`fibre`).
//! 4. The tie rule selects one point for each pixel.
//! 5. Lights and obstacles (`lights`, `occluder`, `bvh`).
//! 6. Colour.
//!
//! Tasks go to the caller's [`Executor`]. The picture has the same bits
//! with any executor.

use super::error::EyeError;
use super::fibre::TILE_PIXELS;
use super::frame::Frame;
use super::method::{Fibre, MAX_FAN_RAYS, Method};
use super::picture::EyePicture;
use super::plan::EyePlan;
use super::scene::{EyeScene, MAX_DIM};
use super::tile::{Output, World};
use crate::executor::{Executor, Task};

/// Calls `$function::<N>` for the scene's dimension: one of those listed, or the largest. A scene's
/// dimension is checked when it is made.
macro_rules! for_dimension {
    ($scene:expr, $function:ident $arguments:tt, $($n:literal)*) => {
        match $scene.dim {
            $($n => $function::<$n> $arguments,)*
            _ => $function::<MAX_DIM> $arguments,
        }
    };
}

const _: () = assert!(MAX_DIM == 8, "the lists of dimensions below end before the largest");

/// Renders a scene with exact fibres, on the calling thread.
pub fn render(scene: &EyeScene) -> EyePicture {
    dispatch(scene, Fibre::Exact, &Executor::default())
}

/// Renders a scene with the given search method, on the threads of `executor`.
///
/// # Errors
/// Fails for a fan without rays, or of more than [`MAX_FAN_RAYS`] in one fibre.
pub fn render_with(scene: &EyeScene, fibre: Fibre, executor: &Executor) -> Result<EyePicture, EyeError> {
    check_fan(scene, fibre)?;
    Ok(dispatch(scene, fibre, executor))
}

/// Returns the plan of rendering the scene: its method, and the facets it searches and skips.
///
/// # Errors
/// Fails as [`render_with`] does.
pub fn plan(scene: &EyeScene, fibre: Fibre) -> Result<EyePlan, EyeError> {
    check_fan(scene, fibre)?;
    Ok(for_dimension!(scene, plan_dim (scene, fibre), 2 3 4 5 6 7))
}

fn plan_dim<const N: usize>(scene: &EyeScene, fibre: Fibre) -> EyePlan {
    let method = Method::new(N, scene.screen_dim(), fibre);
    EyePlan::new(scene, &World::<N>::new(scene, Frame::new(scene, method, &Executor::default())))
}

/// Validates the number of rays of a fan.
fn check_fan(scene: &EyeScene, fibre: Fibre) -> Result<(), EyeError> {
    if let Fibre::Fan(rays) = fibre {
        let total = u64::from(rays).saturating_pow(scene.hidden_dim() as u32);
        if rays == 0 {
            let expected = "at least 1 ray".to_owned();
            return Err(EyeError::Range { path: "fan".into(), expected, found: 0.0 });
        }
        if total > MAX_FAN_RAYS {
            return Err(EyeError::TooBig { path: "fan".into(), limit: MAX_FAN_RAYS, found: total });
        }
    }
    Ok(())
}

fn dispatch(scene: &EyeScene, fibre: Fibre, executor: &Executor) -> EyePicture {
    for_dimension!(scene, render_dim (scene, fibre, executor), 2 3 4 5 6 7)
}

/// Renders a scene of N dimensions.
fn render_dim<const N: usize>(scene: &EyeScene, fibre: Fibre, executor: &Executor) -> EyePicture {
    let method = Method::new(N, scene.screen_dim(), fibre);
    let world = World::<N>::new(scene, Frame::new(scene, method, executor));
    let mut picture = EyePicture::background(scene);
    picture.skipped_facets = world.frame.skipped.clone();
    let sizes = tile_sizes::<N>(&scene.pixels);
    let last = scene.screen_dim() - 1;
    let layer: usize = scene.pixels[..last].iter().map(|&n| n as usize).product();
    let thickness = sizes[last];
    let chunk = layer * thickness as usize;
    let mut tasks: Vec<Task> = Vec::new();
    let mut rest = Output {
        facet: &mut picture.facet,
        dist: &mut picture.dist,
        lit: &mut picture.lit,
        color: &mut picture.color,
    };
    let (mut first, lights) = (0, scene.lights.len());
    while !rest.facet.is_empty() {
        let left = rest.facet.len();
        let (part, others) = rest.split(chunk.min(left), lights);
        rest = others;
        let slab = first..(first + thickness).min(scene.pixels[last]);
        first = slab.end;
        let world = &world;
        tasks.push(Box::new(move || world.render_slab(slab, sizes, part)));
    }
    executor.tasks(tasks);
    picture
}

/// Returns the extents of a tile along the screen axes: 64 pixels, as near to a cube as powers of
/// two allow.
fn tile_sizes<const N: usize>(pixels: &[u32]) -> [u32; N] {
    let mut sizes = [1; N];
    let mut axis = 0;
    let mut stuck = 0;
    while sizes.iter().product::<u32>() < TILE_PIXELS as u32 && stuck < pixels.len() {
        if sizes[axis] < pixels[axis] {
            sizes[axis] *= 2;
            stuck = 0;
        } else {
            stuck += 1;
        }
        axis = (axis + 1) % pixels.len();
    }
    sizes
}

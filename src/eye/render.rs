//! THE EYE AS NUMBERED STEPS: from a scene to its picture.
//!
//! 1. The frame: facets in eye space, culled, nearest first (`frame`).
//! 2. The screen is cut into slabs, one job each, and slabs into tiles.
//! 3. Each tile searches the fibres of its pixels, nearest facets first, until none can be nearer (`fibre`).
//! 4. The tie rule picks a winner a pixel.
//! 5. Lights and obstacles (`lights`, `solid`, `bvh`).
//! 6. Colour.
//!
//! No thread is started here: jobs go to the caller's [`Pool`]. A picture is the same, bit for bit, whoever runs them.

use super::bvh::Bvh;
use super::error::EyeError;
use super::fibre::{Nearest, Run, TILE_PIXELS, search};
use super::frame::Frame;
use super::lights::shade;
use super::method::{Fibre, MAX_FAN_RAYS, Method};
use super::picture::EyePicture;
use super::scene::EyeScene;
use super::solid::Target;
use crate::math::nvec::{dot, max_abs};
use std::ops::Range;

/// A piece of work that may run on any thread.
pub type Job<'a> = Box<dyn FnOnce() + Send + 'a>;

/// Something that runs jobs: all of them, in any order, before it returns.
pub trait Pool {
    /// Runs the jobs.
    fn run<'a>(&self, jobs: Vec<Job<'a>>);
}

/// The thread that asks.
pub struct Here;

impl Pool for Here {
    fn run<'a>(&self, jobs: Vec<Job<'a>>) {
        jobs.into_iter().for_each(|job| job());
    }
}

/// Obstacles from this number on are sorted into boxes.
pub(super) const BVH_FROM: usize = 24;

/// Renders a scene with exact fibres, on this thread.
pub fn render(scene: &EyeScene) -> EyePicture {
    dispatch(scene, Fibre::Exact, &Here)
}

/// Renders a scene with the fibres asked for, on the threads of `pool`.
///
/// # Errors
/// A fan without rays, or of more than [`MAX_FAN_RAYS`] in one fibre.
pub fn render_with(scene: &EyeScene, fibre: Fibre, pool: &dyn Pool) -> Result<EyePicture, EyeError> {
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
    Ok(dispatch(scene, fibre, pool))
}

/// Calls `$function::<N>` for the scene's dimension.
macro_rules! for_dimension {
    ($scene:expr, $function:ident $arguments:tt, $($n:literal)*) => {
        match $scene.dim {
            $($n => $function::<$n> $arguments,)*
            n => unreachable!("a checked scene has 2..=8 dimensions, not {n}"),
        }
    };
}
fn dispatch(scene: &EyeScene, fibre: Fibre, pool: &dyn Pool) -> EyePicture {
    for_dimension!(scene, render_dim (scene, fibre, pool), 2 3 4 5 6 7 8)
}

fn render_dim<const N: usize>(scene: &EyeScene, fibre: Fibre, pool: &dyn Pool) -> EyePicture {
    let frame = Frame::<N>::new(scene, Method::new(N, scene.screen_dim(), fibre));
    let obstacles =
        (!frame.lights.is_empty() && frame.solids.len() >= BVH_FROM).then(|| Bvh::new(&frame.solids));
    let world = World { scene, frame, obstacles };
    let mut picture = EyePicture::background(scene);
    picture.skipped_facets = world.frame.skipped.clone();
    let sizes = tile_sizes::<N>(&scene.pixels);
    let last = scene.screen_dim() - 1;
    let layer: usize = scene.pixels[..last].iter().map(|&n| n as usize).product();
    let thickness = sizes[last] as usize;
    let chunk = layer * thickness;
    let mut jobs: Vec<Job> = Vec::new();
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
        let slab = first..(first + thickness as u32).min(scene.pixels[last]);
        first = slab.end;
        let world = &world;
        jobs.push(Box::new(move || world.render_slab(slab, sizes, part)));
    }
    pool.run(jobs);
    picture
}

/// Extents of a tile along the screen axes: 64 pixels, as near to a cube as powers of two go.
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

/// Where a slab's pixels go.
struct Output<'a> {
    facet: &'a mut [i32],
    dist: &'a mut [f64],
    lit: &'a mut [bool],
    color: &'a mut [[f64; 3]],
}

impl<'a> Output<'a> {
    fn split(self, count: usize, lights: usize) -> (Self, Self) {
        let (facet, facet_rest) = self.facet.split_at_mut(count);
        let (dist, dist_rest) = self.dist.split_at_mut(count);
        let (lit, lit_rest) = self.lit.split_at_mut(count * lights);
        let (color, color_rest) = self.color.split_at_mut(count);
        (
            Output { facet, dist, lit, color },
            Output { facet: facet_rest, dist: dist_rest, lit: lit_rest, color: color_rest },
        )
    }
}

struct World<'a, const N: usize> {
    scene: &'a EyeScene,
    frame: Frame<N>,
    obstacles: Option<Bvh<N>>,
}

impl<const N: usize> World<'_, N> {
    /// Renders the layers `slab` of the last screen axis.
    fn render_slab(&self, slab: Range<u32>, sizes: [u32; N], mut out: Output) {
        let last = self.frame.screen.dim() - 1;
        let reaches = |i: &u32| {
            let [lo, hi] = self.frame.facets[*i as usize].pixels[last];
            lo < slab.end && slab.start < hi
        };
        let near: Vec<u32> = (0..self.frame.facets.len() as u32).filter(reaches).collect();
        let mut nearest = Nearest::new();
        let mut last_blockers = vec![0u32; self.frame.lights.len()];
        let mut low = [0; N];
        low[last] = slab.start;
        loop {
            let high =
                std::array::from_fn(|a| self.scene.pixels.get(a).map_or(1, |&n| (low[a] + sizes[a]).min(n)));
            self.render_tile(low, high, &near, &mut nearest);
            self.resolve_tile(low, high, slab.start, &nearest, &mut last_blockers, &mut out);
            // The next tile of the slab, axis 1 fastest.
            let mut axis = 0;
            while axis < last {
                low[axis] += sizes[axis];
                if low[axis] < self.scene.pixels[axis] {
                    break;
                }
                low[axis] = 0;
                axis += 1;
            }
            if axis >= last {
                return;
            }
        }
    }

    /// Searches the fibres of a tile's pixels.
    fn render_tile(&self, low: [u32; N], high: [u32; N], near: &[u32], nearest: &mut Nearest<N>) {
        nearest.clear();
        let count: usize = (0..N).map(|a| (high[a] - low[a]) as usize).product();
        for_each_run(low, high, |at, local| {
            let direction = self.direction(at);
            for (step, x) in (low[0]..high[0]).enumerate() {
                let c = self.frame.screen.centres[0][x as usize];
                nearest.inverse_length2[local + step] = 1.0 / (dot(&direction, &direction) + c * c);
            }
        });
        let mut worst2 = f64::INFINITY;
        for &index in near {
            let facet = &self.frame.facets[index as usize];
            if facet.nearest * facet.nearest > worst2 {
                break;
            }
            let from: [u32; N] = std::array::from_fn(|a| low[a].max(facet.pixels[a][0]));
            let to: [u32; N] = std::array::from_fn(|a| high[a].min(facet.pixels[a][1]));
            if (0..N).any(|a| from[a] >= to[a]) {
                continue;
            }
            for_each_run(from, to, |at, _| {
                let (mut local, mut stride) = (0, 1);
                for a in 0..N {
                    local += (at[a] - low[a]) as usize * stride;
                    stride *= (high[a] - low[a]) as usize;
                }
                let run = Run { direction: self.direction(at), x: from[0]..to[0], local };
                search(&self.frame, index as usize, &run, nearest);
            });
            worst2 = nearest.worst2(0..count);
        }
    }

    /// The direction of pixel `at` but for c_1, which is 0.
    fn direction(&self, at: [u32; N]) -> [f64; N] {
        let mut direction = [0.0; N];
        direction[0] = self.frame.screen.distance;
        for a in 1..self.frame.screen.dim() {
            direction[a + 1] = self.frame.screen.centres[a][at[a] as usize];
        }
        direction
    }

    /// Picks the winners of a tile, lights and colours them.
    fn resolve_tile(
        &self,
        low: [u32; N],
        high: [u32; N],
        slab_start: u32,
        nearest: &Nearest<N>,
        last_blockers: &mut [u32],
        out: &mut Output,
    ) {
        let lights = self.frame.lights.len();
        for_each_run(low, high, |at, local| {
            let (mut flat, mut stride) = (0, 1);
            for a in 0..self.scene.pixels.len() {
                let from = if a + 1 == self.scene.pixels.len() { slab_start } else { 0 };
                flat += (at[a] - from) as usize * stride;
                stride *= self.scene.pixels[a] as usize;
            }
            for step in 0..(high[0] - low[0]) as usize {
                let Some(winner) = nearest.winner(local + step) else { continue };
                let pixel = flat + step;
                let distance = libm::scalbn(winner.distance2.sqrt(), self.frame.exponent);
                out.facet[pixel] = winner.id as i32;
                out.dist[pixel] = distance;
                let flags = &mut out.lit[pixel * lights..(pixel + 1) * lights];
                let total = self.light(winner.index as usize, &winner.point, flags, last_blockers);
                let base = self.scene.facets[winner.id as usize].color;
                out.color[pixel] = shade(base, total, self.scene.view.at(distance));
            }
        });
    }

    /// The lit flags of point `p` of a visible facet, and the light it gets, a channel.
    fn light(&self, index: usize, p: &[f64; N], flags: &mut [bool], last_blockers: &mut [u32]) -> [f64; 3] {
        let facet = &self.frame.facets[index];
        let solid = &self.frame.solids[facet.solid as usize];
        let eye_side = if facet.offset < 0.0 { 1 } else { -1 };
        let mut total = self.scene.diffuse;
        let p_size = max_abs(p);
        for (l, light) in self.frame.lights.iter().enumerate() {
            let Some((distance, target)) = light.reach(l, solid, eye_side, p) else { continue };
            if self.blocked(p, p_size, &target, &mut last_blockers[l]) {
                continue;
            }
            flags[l] = true;
            let strength = light.falloff.at(libm::scalbn(distance, self.frame.exponent));
            for c in 0..3 {
                total[c] += strength * light.color[c];
            }
        }
        total
    }

    /// Whether anything stands between `p` and the light. `last` is tried first: what it holds changes the time, not the answer.
    fn blocked(&self, p: &[f64; N], p_size: f64, target: &Target<N>, last: &mut u32) -> bool {
        let blocks = |i: u32| self.frame.solids[i as usize].blocks(p, p_size, target);
        if blocks(*last) {
            return true;
        }
        let found = match &self.obstacles {
            Some(bvh) => bvh.find(p, target, blocks),
            None => (0..self.frame.solids.len() as u32).find(|&i| blocks(i)),
        };
        *last = found.unwrap_or(*last);
        found.is_some()
    }
}

/// Calls `run(at, local)` for each run along axis 1 of the box low..high, `local` counting the box's pixels.
fn for_each_run<const N: usize>(low: [u32; N], high: [u32; N], mut run: impl FnMut([u32; N], usize)) {
    let mut at = low;
    let length = (high[0] - low[0]) as usize;
    let mut local = 0;
    loop {
        run(at, local);
        local += length;
        let mut axis = 1;
        while axis < N {
            at[axis] += 1;
            if at[axis] < high[axis] {
                break;
            }
            at[axis] = low[axis];
            axis += 1;
        }
        if axis >= N {
            return;
        }
    }
}

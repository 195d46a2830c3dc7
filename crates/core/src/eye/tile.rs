//! Rendering a slab of the screen, tile by tile: search, selection of the point seen, lighting.
//!
//! In: a frame, and the memory of the slab's pixels. Out: those pixels. Runs on any thread. A pixel
//! depends neither on how the screen is split nor on its neighbours: only facets that cannot be
//! seen are skipped.

use super::bounds;
use super::bvh::Bvh;
use super::fibre::{Nearest, Run, TILE_PIXELS, search};
use super::frame::Frame;
use super::lights::shade;
use super::method::Method;
use super::occluder::LightTarget;
use super::scene::EyeScene;
use crate::math::nvec::{dot, max_abs, unit};
use std::ops::Range;

/// Number of obstacles up to which those that may shadow a tile are selected for each tile; more
/// are put into a hierarchy of boxes.
pub(super) const PICKED_OBSTACLES: usize = 256;

/// Memory of a slab's pixels; fields as in [`EyePicture`](super::EyePicture).
pub(super) struct Output<'a> {
    pub facet: &'a mut [i32],
    pub dist: &'a mut [f64],
    pub lit: &'a mut [bool],
    pub color: &'a mut [[f64; 3]],
}

impl Output<'_> {
    /// Splits into the first `count` pixels and the rest.
    pub fn split(self, count: usize, lights: usize) -> (Self, Self) {
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

/// A tile: pixels low..high along each axis, and the centre and half extent of their directions.
struct Tile<const N: usize> {
    low: [u32; N],
    high: [u32; N],
    middle: [f64; N],
    half: [f64; N],
    /// `middle` as a unit vector.
    axis: [f64; N],
}

/// Working memory reused from tile to tile.
struct TileScratch<const N: usize> {
    nearest: Nearest<N>,
    /// The obstacle that last blocked each light.
    last_blockers: Vec<u32>,
    /// Obstacles that may shadow the tile.
    picked: Vec<u32>,
    seen: Vec<Seen<N>>,
}

/// The point seen by a pixel, and the light it receives.
struct Seen<const N: usize> {
    pixel: usize,
    index: u32,
    point: [f64; N],
    distance: f64,
    total: [f64; 3],
}

/// Everything that rendering a slab reads.
pub(super) struct World<'a, const N: usize> {
    scene: &'a EyeScene,
    pub frame: Frame<N>,
    pub obstacles: Option<Bvh<N>>,
}

impl<'a, const N: usize> World<'a, N> {
    /// Creates the world of a frame, with a hierarchy of its obstacles if there are many.
    pub fn new(scene: &'a EyeScene, frame: Frame<N>) -> Self {
        let obstacles = (frame.occluders.len() > PICKED_OBSTACLES).then(|| Bvh::new(&frame.occluders));
        World { scene, frame, obstacles }
    }

    /// Renders layers `slab` of the last screen axis.
    pub fn render_slab(&self, slab: Range<u32>, sizes: [u32; N], mut out: Output) {
        let last = self.frame.screen.dim() - 1;
        let bands = self.frame.order.iter().zip(&self.frame.bands);
        let near: Vec<u32> =
            bands.filter(|(_, [lo, hi])| *lo < slab.end && slab.start < *hi).map(|(i, _)| *i).collect();
        let mut scratch = TileScratch {
            nearest: Nearest::new(),
            last_blockers: vec![0; self.frame.lights.len()],
            picked: Vec::new(),
            seen: Vec::with_capacity(TILE_PIXELS),
        };
        let mut low = [0; N];
        low[last] = slab.start;
        loop {
            let tile = self.tile(low, sizes);
            self.search_tile(&tile, &near, &mut scratch.nearest);
            self.pick(&tile, slab.start, &mut scratch, &mut out);
            for light in 0..self.frame.lights.len() {
                self.light_tile(light, &mut scratch, &mut out);
            }
            for seen in &scratch.seen {
                let base = self.scene.facets[self.frame.facets[seen.index as usize].id as usize].color;
                out.color[seen.pixel] = shade(base, seen.total, self.scene.view.at(seen.distance));
            }
            // Moves to the next tile of the slab, axis 1 fastest.
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

    /// Returns the tile that begins at pixel `low`, clipped to the screen.
    fn tile(&self, low: [u32; N], sizes: [u32; N]) -> Tile<N> {
        let high =
            std::array::from_fn(|a| self.scene.pixels.get(a).map_or(1, |&n| (low[a] + sizes[a]).min(n)));
        let (mut middle, mut half) = ([0.0; N], [0.0; N]);
        middle[0] = self.frame.screen.distance;
        for (a, centres) in self.frame.screen.centres.iter().enumerate() {
            let ends = (centres[low[a] as usize], centres[high[a] as usize - 1]);
            middle[a + 1] = 0.5 * (ends.0 + ends.1);
            half[a + 1] = 0.5 * (ends.0 - ends.1);
        }
        Tile { low, high, middle, half, axis: unit(middle) }
    }

    /// Searches the fibres of a tile's pixels, nearest facets first.
    fn search_tile(&self, tile: &Tile<N>, near: &[u32], nearest: &mut Nearest<N>) {
        nearest.clear();
        let (low, high) = (tile.low, tile.high);
        let count: usize = (0..N).map(|a| (high[a] - low[a]) as usize).product();
        let mut least_length2 = f64::INFINITY;
        for_each_run(low, high, |at, local| {
            let direction = self.direction(at);
            let rest = dot(&direction, &direction);
            for (step, x) in (low[0]..high[0]).enumerate() {
                let c = self.frame.screen.centres[0][x as usize];
                let length2 = rest + c * c;
                least_length2 = least_length2.min(length2);
                nearest.inverse_length2[local + step] = 1.0 / length2;
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
            if (0..N).any(|a| from[a] >= to[a])
                || self.is_missed(index as usize, tile)
                || self.is_behind(index as usize, tile, least_length2, worst2)
            {
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

    /// Returns whether the entire tile lies outside a face of the facet's outline on the screen.
    fn is_missed(&self, index: usize, tile: &Tile<N>) -> bool {
        if !matches!(self.frame.method, Method::Ray | Method::Plane) {
            return false;
        }
        let doubt = self.frame.facets[index].doubt;
        self.frame.planes_of(index).iter().zip(self.frame.hulls_of(index)).any(|(plane, hull)| {
            let spread = (1..N).fold(0.0, |sum, a| sum + plane[a].abs() * tile.half[a]);
            hull * dot(plane, &tile.middle) + spread * hull.abs() < -2.0 * doubt
        })
    }

    /// Returns whether every point found for the tile's pixels is nearer than the facet. The
    /// facet's distance is bounded along the tile's central direction, and by its hyperplane in any
    /// of the pixels' fibres: q = c^2 / (<n,P>^2 / |P|^2 + n_hidden^2), with the largest <n,P> and
    /// the least |P|.
    fn is_behind(&self, index: usize, tile: &Tile<N>, least_length2: f64, worst2: f64) -> bool {
        if worst2 == f64::INFINITY {
            return false;
        }
        let facet = &self.frame.facets[index];
        let along = bounds::along(&facet.v, &tile.axis, facet.farthest);
        if along > 0.0 && along * along * (1.0 - 1e-9) > worst2 {
            return true;
        }
        let spread = (1..N).fold(0.0, |sum, a| sum + facet.normal[a].abs() * tile.half[a]);
        let along = dot(&facet.normal, &tile.middle).abs() + spread;
        let trace = along * along / least_length2 + facet.normal_hidden2;
        facet.offset * facet.offset * (1.0 - 1e-9) > worst2 * trace
    }

    /// Returns the direction of pixel `at`, except c_1, which is 0.
    fn direction(&self, at: [u32; N]) -> [f64; N] {
        let mut direction = [0.0; N];
        direction[0] = self.frame.screen.distance;
        for a in 1..self.frame.screen.dim() {
            direction[a + 1] = self.frame.screen.centres[a][at[a] as usize];
        }
        direction
    }

    /// Selects the point seen by each pixel of a tile.
    fn pick(&self, tile: &Tile<N>, slab_start: u32, scratch: &mut TileScratch<N>, out: &mut Output) {
        scratch.seen.clear();
        let axes = self.scene.pixels.len();
        for_each_run(tile.low, tile.high, |at, local| {
            let (mut flat, mut stride) = (0, 1);
            for a in 0..axes {
                let from = if a + 1 == axes { slab_start } else { 0 };
                flat += (at[a] - from) as usize * stride;
                stride *= self.scene.pixels[a] as usize;
            }
            for step in 0..(tile.high[0] - tile.low[0]) as usize {
                let Some(winner) = scratch.nearest.winner(local + step) else { continue };
                let distance = libm::scalbn(winner.distance2.sqrt(), self.frame.exponent);
                out.facet[flat + step] = winner.id as i32;
                out.dist[flat + step] = distance;
                scratch.seen.push(Seen {
                    pixel: flat + step,
                    index: winner.index,
                    point: winner.point,
                    distance,
                    total: self.scene.diffuse,
                });
            }
        });
    }

    /// Sets the lit flags of light `index` in a tile, and adds its light.
    fn light_tile(&self, index: usize, scratch: &mut TileScratch<N>, out: &mut Output) {
        let light = &self.frame.lights[index];
        let mut reached: [Option<(f64, LightTarget<N>)>; TILE_PIXELS] = [None; TILE_PIXELS];
        let (mut least, mut most) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
        for (seen, reached) in scratch.seen.iter().zip(&mut reached) {
            let facet = &self.frame.facets[seen.index as usize];
            let placement = &self.frame.placements_of(facet.occluder as usize)[index];
            let eye_side = if facet.offset < 0.0 { 1 } else { -1 };
            *reached =
                light.reach(placement, &self.frame.occluders[facet.occluder as usize], eye_side, &seen.point);
            if reached.is_some() {
                for a in 0..N {
                    least[a] = least[a].min(seen.point[a]);
                    most[a] = most[a].max(seen.point[a]);
                }
            }
        }
        let Some((_, target)) = reached.iter().flatten().next() else { return };
        if self.obstacles.is_none() {
            let middle = std::array::from_fn(|a| 0.5 * (least[a] + most[a]));
            let half = std::array::from_fn(|a| 0.5 * (most[a] - least[a]) + 1e-15 * middle[a].abs());
            let may_block = |i: &u32| {
                let placement = &self.frame.placements_of(*i as usize)[index];
                self.frame.occluders[*i as usize].may_block(&middle, &half, target, placement)
            };
            scratch.picked.clear();
            scratch.picked.extend((0..self.frame.occluders.len() as u32).filter(may_block));
        }
        let TileScratch { seen, picked, last_blockers, .. } = scratch;
        for (seen, reached) in seen.iter_mut().zip(&reached) {
            let Some((distance, target)) = reached else { continue };
            if self.is_blocked(index, &seen.point, target, picked, &mut last_blockers[index]) {
                continue;
            }
            out.lit[seen.pixel * self.frame.lights.len() + index] = true;
            let strength = light.falloff.at(libm::scalbn(*distance, self.frame.exponent));
            for c in 0..3 {
                seen.total[c] += strength * light.color[c];
            }
        }
    }

    /// Returns whether an obstacle stands between `p` and the light. `last` is tried first; it
    /// affects the time, not the result.
    fn is_blocked(
        &self,
        light: usize,
        p: &[f64; N],
        target: &LightTarget<N>,
        picked: &[u32],
        last: &mut u32,
    ) -> bool {
        let p_size = max_abs(p);
        let blocks = |i: u32| {
            let placement = &self.frame.placements_of(i as usize)[light];
            self.frame.occluders[i as usize].blocks(p, p_size, target, placement)
        };
        let found = match &self.obstacles {
            Some(_) if blocks(*last) => return true,
            Some(bvh) => bvh.find(p, target, blocks),
            None => picked.iter().copied().find(|&i| blocks(i)),
        };
        *last = found.unwrap_or(*last);
        found.is_some()
    }
}

/// Calls `run(at, local)` for each run of pixels along axis 1 of the box low..high; `local` is the
/// index of its first pixel in the box.
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

#[cfg(test)]
mod tests;

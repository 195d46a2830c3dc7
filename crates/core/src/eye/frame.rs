//! Data computed once for each picture: the scene in eye space, and each facet's derived numbers.
//!
//! In: a validated scene. Out: facets as seen from the eye at the origin, in a unit of length that
//! is a power of two (so that a scene 2^20 times as large gives the same bits), nearest first,
//! without those that cannot be seen.
//!
//! The vertices of every facet are in one order (by coordinates), so a ridge that two facets share
//! is computed with the same operations in both, and no ray slips between them.

use super::bounds;
use super::eye_space::{EyeSpace, Screen, Visible, exponent_of, rescale};
use super::frame_light::{FrameLight, frame_lights};
use super::method::Method;
use super::occluder::{LightPlacement, Occluder, TAU};
use super::scene::EyeScene;
use crate::executor::{Executor, Task};
use crate::math::nvec::{ROUNDING, dot, max_abs, sub, unit, wedge};

/// A ratio of pivots below this makes a facet degenerate.
const DEGENERATE: f64 = 1e-12;

/// Number of facets computed in one task; scenes with more are split into several.
const FACETS_PER_TASK: usize = 2048;

/// A scene in eye space.
pub(super) struct Frame<const N: usize> {
    /// A length here times 2^exponent is a length of the scene.
    pub exponent: i32,
    /// The screen in eye space.
    pub screen: Screen<N>,
    /// Search method for fibres.
    pub method: Method,
    /// The lights in eye space.
    pub lights: Vec<FrameLight<N>>,
    /// Hidden coordinates of the fan's rays on the screen, empty without a fan.
    pub fan: Vec<[f64; N]>,
    /// Facets that may be visible, in the scene's order.
    pub facets: Vec<Visible<N>>,
    /// Indices into `facets`, in the order of increasing `nearest`.
    pub order: Vec<u32>,
    /// Pixel ranges of these facets along the last screen axis, in the same order.
    pub bands: Vec<[u32; 2]>,
    /// Functionals x -> det(x, ...) of each visible facet's faces: `Method::planes_per_facet` for
    /// each facet.
    pub planes: Vec<[f64; N]>,
    /// Sign of each functional on the facet: 1, -1, or 0 where it takes both.
    pub hulls: Vec<f64>,
    /// All facets that are not degenerate, as obstacles to light; empty where there are no lights.
    pub occluders: Vec<Occluder<N>>,
    /// Placement of each light relative to each occluder, `lights` entries for each occluder.
    pub placements: Vec<LightPlacement>,
    /// Degenerate facets, by index in the scene.
    pub skipped: Vec<u32>,
    /// Number of facets seen edge-on.
    pub edge_on: usize,
}

/// Results for a range of the scene's facets.
#[derive(Default)]
struct FacetBatch<const N: usize> {
    facets: Vec<Visible<N>>,
    planes: Vec<[f64; N]>,
    hulls: Vec<f64>,
    occluders: Vec<Occluder<N>>,
    placements: Vec<LightPlacement>,
    skipped: Vec<u32>,
    edge_on: usize,
}

impl<const N: usize> Frame<N> {
    /// Computes the frame, in several tasks if the scene is large.
    pub fn new(scene: &EyeScene, method: Method, executor: &Executor) -> Self {
        let exponent = length_exponent(scene);
        let eye = EyeSpace::new(scene, exponent);
        let screen = Screen::new(scene);
        let lights = frame_lights(scene, &eye);
        let mut parts: Vec<FacetBatch<N>> = Vec::new();
        parts.resize_with(scene.facets.len().div_ceil(FACETS_PER_TASK), FacetBatch::default);
        let job = |(index, part): (usize, &mut FacetBatch<N>)| {
            let first = index * FACETS_PER_TASK;
            let last = (first + FACETS_PER_TASK).min(scene.facets.len());
            for id in first..last {
                part.add(id as u32, &scene.facets[id].v, &eye, &screen, &lights, method);
            }
        };
        if parts.len() > 1 {
            let job = &job;
            executor.tasks(parts.iter_mut().enumerate().map(|p| Box::new(move || job(p)) as Task).collect());
        } else {
            parts.iter_mut().enumerate().for_each(job);
        }
        let all = parts.into_iter().reduce(FacetBatch::join).unwrap_or_default();
        let order =
            nearest_first(all.facets.iter().enumerate().map(|(i, f)| (f.nearest, i as u32)).collect());
        let last = screen.dim() - 1;
        Frame {
            exponent,
            method,
            fan: method.fan_rays::<N>(&screen),
            bands: order.iter().map(|&i| all.facets[i as usize].pixels[last]).collect(),
            screen,
            lights,
            order,
            facets: all.facets,
            planes: all.planes,
            hulls: all.hulls,
            occluders: all.occluders,
            placements: all.placements,
            skipped: all.skipped,
            edge_on: all.edge_on,
        }
    }

    /// Returns the number of bytes of the facets' data.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.facets)
            + size_of_val(&*self.order)
            + size_of_val(&*self.bands)
            + size_of_val(&*self.planes)
            + size_of_val(&*self.hulls)
            + size_of_val(&*self.occluders)
            + size_of_val(&*self.placements)
            + size_of_val(&*self.fan)
    }

    /// Returns the functionals of visible facet `index`.
    #[inline(always)]
    pub fn planes_of(&self, index: usize) -> &[[f64; N]] {
        let count = self.method.planes_per_facet(N);
        &self.planes[index * count..(index + 1) * count]
    }

    /// Returns the signs of these functionals on the facet.
    #[inline(always)]
    pub fn hulls_of(&self, index: usize) -> &[f64] {
        let count = self.method.planes_per_facet(N);
        &self.hulls[index * count..(index + 1) * count]
    }

    /// Returns the placements of the lights relative to occluder `index`.
    #[inline(always)]
    pub fn placements_of(&self, index: usize) -> &[LightPlacement] {
        &self.placements[index * self.lights.len()..(index + 1) * self.lights.len()]
    }
}

impl<const N: usize> FacetBatch<N> {
    /// Adds a facet of the scene: as an obstacle if there are lights, and as visible unless it is
    /// culled. A degenerate one is only recorded as skipped.
    fn add(
        &mut self,
        id: u32,
        points: &[Vec<f64>],
        eye: &EyeSpace<N>,
        screen: &Screen<N>,
        lights: &[FrameLight<N>],
        method: Method,
    ) {
        let world: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| points[i][j]));
        if is_degenerate(&world, eye.exponent) {
            return self.skipped.push(id);
        }
        let mut v = world.map(|point| eye.point(&point));
        sort_by_coordinates(&mut v);
        let (normal, offset) = hyperplane(&v);
        if !lights.is_empty() {
            let occluder = Occluder::new(&v, normal, offset);
            self.placements.extend(lights.iter().map(|light| occluder.placement(light)));
            self.occluders.push(occluder);
        }
        let size = v.iter().map(max_abs).fold(0.0, f64::max);
        // Seen edge-on, by the tolerance that lights have.
        if offset.abs() <= TAU * size {
            self.edge_on += 1;
            return;
        }
        let Some(pixels) = bounds::pixel_box(&v, screen) else { return };
        let m = screen.dim();
        let farthest = v.iter().map(|p| dot(p, p)).fold(0.0, f64::max).sqrt();
        let facet = Visible {
            id,
            occluder: self.occluders.len().saturating_sub(1) as u32,
            normal_hidden2: (m + 1..N).fold(0.0, |sum, a| sum + normal[a] * normal[a]),
            nearest: bounds::nearest(&v, farthest).max(offset.abs() - ROUNDING * (4 * N) as f64 * farthest)
                * (1.0 - 1e-9),
            farthest,
            doubt: doubt(&v, screen, &pixels, matches!(method, Method::Fan(_))),
            v,
            normal,
            offset,
            pixels,
        };
        method.push_planes(&facet, m, &mut self.planes, &mut self.hulls);
        self.facets.push(facet);
    }

    /// Appends the results for the next range of facets.
    fn join(mut self, mut next: Self) -> Self {
        let first_solid = self.occluders.len() as u32;
        next.facets.iter_mut().for_each(|f| f.occluder += first_solid);
        self.facets.append(&mut next.facets);
        self.planes.append(&mut next.planes);
        self.hulls.append(&mut next.hulls);
        self.occluders.append(&mut next.occluders);
        self.placements.append(&mut next.placements);
        self.skipped.append(&mut next.skipped);
        self.edge_on += next.edge_on;
        self
    }
}

/// Returns the indices in order of increasing distance. Not generic over the dimension, so it is
/// compiled once.
fn nearest_first(mut keys: Vec<(f64, u32)>) -> Vec<u32> {
    keys.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    keys.into_iter().map(|(_, i)| i).collect()
}

/// Sorts points lexicographically, by insertion: there are at most eight, and the standard
/// library's sorts would be compiled again for each dimension.
fn sort_by_coordinates<const N: usize>(v: &mut [[f64; N]; N]) {
    let is_after = |a: &[f64; N], b: &[f64; N]| {
        a.iter().zip(b).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).is_some_and(|o| o.is_gt())
    };
    for end in 1..N {
        let mut at = end;
        while at > 0 && is_after(&v[at - 1], &v[at]) {
            v.swap(at - 1, at);
            at -= 1;
        }
    }
}

/// Returns the exponent that scales all vertices and the eye to at most 1.
fn length_exponent(scene: &EyeScene) -> i32 {
    let points = scene.facets.iter().flat_map(|f| f.v.iter()).chain([&scene.pose.position]);
    exponent_of(points.flatten().fold(0.0, |m: f64, x| m.max(x.abs()))) + 1
}

/// Returns the unit normal n of the hyperplane through N points, and n.x on it.
fn hyperplane<const N: usize>(v: &[[f64; N]; N]) -> ([f64; N], f64) {
    let mut edges = [[0.0; N]; N];
    for i in 1..N {
        let edge = sub(&v[i], &v[0]);
        let exponent = exponent_of(max_abs(&edge));
        edges[i] = edge.map(|x| libm::scalbn(x, -exponent));
    }
    let normal = unit(wedge(&edges[1..], N));
    // The vertex nearest to the eye gives the least rounding error.
    let mut base = &v[0];
    for point in &v[1..] {
        if max_abs(point) < max_abs(base) {
            base = point;
        }
    }
    (normal, dot(&normal, base))
}

/// Returns whether the smallest pivot of the edges is below 1e-12 of the largest (elimination with
/// full pivoting).
fn is_degenerate<const N: usize>(v: &[[f64; N]; N], exponent: i32) -> bool {
    let mut edges: [[f64; N]; N] = std::array::from_fn(|i| {
        std::array::from_fn(|j| rescale(v[i][j], exponent) - rescale(v[0][j], exponent))
    });
    let mut first_pivot = 0.0;
    for step in 1..N {
        let (mut row, mut column, mut pivot) = (step, 0, 0.0);
        for (i, edge) in edges.iter().enumerate().skip(step) {
            for (j, x) in edge.iter().enumerate() {
                if x.abs() > pivot {
                    (row, column, pivot) = (i, j, x.abs());
                }
            }
        }
        if step == 1 {
            first_pivot = pivot;
        }
        if pivot == 0.0 || pivot < DEGENERATE * first_pivot {
            return true;
        }
        edges.swap(step, row);
        let top = edges[step];
        for edge in &mut edges[step + 1..] {
            let factor = edge[column] / top[column];
            for j in 0..N {
                edge[j] -= factor * top[j];
            }
            edge[column] = 0.0;
        }
    }
    false
}

/// Returns a bound on the rounding error of the facet's functionals at any of its pixels.
///
/// A functional is a determinant of d v_a - c_a v_0. Both the sum of its terms' magnitudes and the
/// effect of rounding these entries are below the product of the rows' absolute sums; the result is
/// this product times a few ulp.
fn doubt<const N: usize>(v: &[[f64; N]; N], screen: &Screen<N>, pixels: &[[u32; 2]; N], fan: bool) -> f64 {
    let axes = if fan { N - 1 } else { screen.dim() };
    let mut product = 1.0 / screen.distance.powi(axes as i32 - 1);
    for a in 1..=axes {
        let reach = if a <= screen.dim() {
            let centres = &screen.centres[a - 1];
            centres[pixels[a - 1][0] as usize].abs().max(centres[pixels[a - 1][1] as usize - 1].abs())
        } else {
            screen.tan[a] * screen.distance
        };
        product *= v.iter().fold(0.0, |sum, p| sum + screen.distance * p[a].abs() + reach * p[0].abs());
    }
    // Differences of vertices may be twice as long as the vertices.
    let steps = (8 * (axes + 1) * (axes + 1)) << (axes - 1);
    product * steps as f64 * ROUNDING
}

#[cfg(test)]
mod tests;

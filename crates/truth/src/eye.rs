//! Reference of the N-dimensional eye, written in the plainest way: every pixel, every facet, every
//! set of active inequalities, every occluder. It shares no code with the renderer but the scene.
//!
//! In: a scene whose eye is not rotated, so that all its numbers are rational. Out: facet, distance,
//! lit flags and colour of pixels. It is generic over [`Number`]: with
//! [`Rational`](super::Rational) nothing is rounded, and small scenes take seconds; with
//! [`DoubleDouble`] there are 32 digits.

use super::double_double::DoubleDouble;
use fbptr_core::eye::{EyeLightKind, EyeScene, Falloff};

/// Arithmetic of the reference.
pub trait Number: Clone + PartialOrd {
    /// Converts an f64 exactly.
    fn of(x: f64) -> Self;
    /// Returns the nearest f64, within an ulp.
    fn to_f64(&self) -> f64;
    /// Returns -1, 0 or 1.
    fn sign(&self) -> i32;
    /// Returns the sum.
    fn plus(&self, other: &Self) -> Self;
    /// Returns the difference.
    fn minus(&self, other: &Self) -> Self;
    /// Returns the product.
    fn times(&self, other: &Self) -> Self;
    /// Returns the quotient.
    fn over(&self, other: &Self) -> Self;
    /// Returns the number with the other sign.
    fn negated(&self) -> Self;
    /// Returns the solution of `rows` [a.. | b], or `None` if it is not unique.
    fn solve(rows: Vec<Vec<Self>>) -> Option<Vec<Self>>;

    /// Returns the absolute value.
    fn size(&self) -> Self {
        if self.sign() < 0 { self.negated() } else { self.clone() }
    }
}

impl Number for DoubleDouble {
    fn of(x: f64) -> DoubleDouble {
        DoubleDouble::new(x)
    }

    fn to_f64(&self) -> f64 {
        DoubleDouble::to_f64(*self)
    }

    fn sign(&self) -> i32 {
        i32::from(*self > DoubleDouble::ZERO) - i32::from(*self < DoubleDouble::ZERO)
    }

    fn plus(&self, other: &DoubleDouble) -> DoubleDouble {
        *self + *other
    }

    fn minus(&self, other: &DoubleDouble) -> DoubleDouble {
        *self - *other
    }

    fn times(&self, other: &DoubleDouble) -> DoubleDouble {
        *self * *other
    }

    fn over(&self, other: &DoubleDouble) -> DoubleDouble {
        *self / *other
    }

    fn negated(&self) -> DoubleDouble {
        -*self
    }

    /// By Gauss's elimination, the largest pivot of each column first; a pivot that is 24 digits
    /// below the largest entry is none.
    fn solve(mut rows: Vec<Vec<DoubleDouble>>) -> Option<Vec<DoubleDouble>> {
        let n = rows.len();
        let largest = rows.iter().flatten().fold(0.0f64, |m, x| m.max(x.to_f64().abs()));
        for k in 0..n {
            let pivot =
                (k..n).max_by(|&a, &b| rows[a][k].abs().to_f64().total_cmp(&rows[b][k].abs().to_f64()))?;
            if rows[pivot][k].to_f64().abs() <= 1e-24 * largest {
                return None;
            }
            rows.swap(k, pivot);
            let top = rows[k].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(r, _)| *r != k) {
                let factor = row[k] / top[k];
                for (entry, above) in row.iter_mut().zip(&top) {
                    *entry = *entry - factor * *above;
                }
            }
        }
        Some((0..n).map(|k| rows[k][n] / rows[k][k]).collect())
    }
}

/// Returns the scalar product.
fn dot<N: Number>(a: &[N], b: &[N]) -> N {
    a.iter().zip(b).fold(N::of(0.0), |sum, (x, y)| sum.plus(&x.times(y)))
}

/// Returns the determinant, expanded along the first row.
fn determinant<N: Number>(rows: &[Vec<N>]) -> N {
    if rows.is_empty() {
        return N::of(1.0);
    }
    (0..rows.len()).fold(N::of(0.0), |sum, c| {
        let rest: Vec<Vec<N>> = rows[1..].iter().map(|r| without(r, c)).collect();
        let term = rows[0][c].times(&determinant(&rest));
        if c % 2 == 0 { sum.plus(&term) } else { sum.minus(&term) }
    })
}

/// Returns the entries of a row but one.
fn without<N: Clone>(row: &[N], left_out: usize) -> Vec<N> {
    row.iter().enumerate().filter(|(k, _)| *k != left_out).map(|(_, x)| x.clone()).collect()
}

/// Result at one pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct SeenPoint {
    /// Number of the facet, -1 on a miss.
    pub facet: i32,
    /// Distance; infinite on a miss.
    pub distance: f64,
    /// Lights that reach the point.
    pub lit: Vec<bool>,
    /// Colour, 0 to 255.
    pub color: [f64; 3],
}

struct Simplex<N> {
    v: Vec<Vec<N>>,
    normal: Vec<N>,
    offset: N,
    size: N,
}

struct Hit<N> {
    id: usize,
    distance2: N,
    facing: N,
    point: Vec<N>,
}

fn vector<N: Number>(x: &[f64]) -> Vec<N> {
    x.iter().map(|&x| N::of(x)).collect()
}

fn difference<N: Number>(a: &[N], b: &[N]) -> Vec<N> {
    a.iter().zip(b).map(|(x, y)| x.minus(y)).collect()
}

fn plus_scaled<N: Number>(a: &[N], s: &N, b: &[N]) -> Vec<N> {
    a.iter().zip(b).map(|(x, y)| x.plus(&s.times(y))).collect()
}

fn larger<N: Number>(a: N, b: N) -> N {
    if a < b { b } else { a }
}

fn largest<'a, N: Number + 'a>(numbers: impl IntoIterator<Item = &'a N>) -> N {
    numbers.into_iter().fold(N::of(0.0), |m, x| larger(m, x.size()))
}

fn falloff(f: Falloff, distance: f64) -> f64 {
    (f.k / libm::pow(1.0 + distance, f.n)).min(1.0)
}

/// Returns what the listed pixels see, by their numbers along the first axis, then the second.
///
/// # Panics
/// If the eye is rotated.
pub fn see<N: Number>(scene: &EyeScene, pixels: impl IntoIterator<Item = usize>) -> Vec<SeenPoint> {
    assert!(scene.pose.rotations.is_empty(), "an eye along its axes");
    let origin = vector::<N>(&scene.pose.position);
    let simplices: Vec<Simplex<N>> = scene.facets.iter().map(|f| simplex(&f.v, &origin)).collect();
    let seen = pixels.into_iter().map(|flat| {
        let mut rest = flat;
        let mut direction = vec![N::of(scene.distance)];
        for (n, size) in scene.pixels.iter().zip(&scene.size) {
            let (n, j) = (i64::from(*n), (rest % *n as usize) as i64);
            rest /= n as usize;
            direction.push(N::of(*size).times(&N::of((n - 1 - 2 * j) as f64)).over(&N::of((2 * n) as f64)));
        }
        pixel(scene, &simplices, &direction, &origin)
    });
    seen.collect()
}

fn simplex<N: Number>(v: &[Vec<f64>], origin: &[N]) -> Simplex<N> {
    let v: Vec<Vec<N>> = v.iter().map(|p| difference(&vector(p), origin)).collect();
    let edges: Vec<Vec<N>> = v[1..].iter().map(|p| difference(p, &v[0])).collect();
    let normal: Vec<N> = (0..v.len())
        .map(|a| {
            let minor: Vec<Vec<N>> = edges.iter().map(|e| without(e, a)).collect();
            if a % 2 == 0 { determinant(&minor) } else { determinant(&minor).negated() }
        })
        .collect();
    let offset = dot(&normal, &v[0]);
    let size = largest(v.iter().flatten());
    Simplex { v, normal, offset, size }
}

fn pixel<N: Number>(scene: &EyeScene, simplices: &[Simplex<N>], direction: &[N], origin: &[N]) -> SeenPoint {
    let hits: Vec<Hit<N>> =
        simplices.iter().enumerate().filter_map(|(id, s)| nearest(scene, s, id, direction)).collect();
    let least = hits.iter().map(|h| h.distance2.clone()).reduce(|a, b| if b < a { b } else { a });
    let Some(least) = least else {
        let lit = Vec::new();
        return SeenPoint { facet: -1, distance: f64::INFINITY, lit, color: scene.background };
    };
    // D <= D_min (1 + 1e-9), squared.
    let tie = N::of(1.0).plus(&N::of(1e-9));
    let most = least.times(&tie.times(&tie));
    let near: Vec<&Hit<N>> = hits.iter().filter(|h| h.distance2 <= most).collect();
    let winner = if scene.hidden_dim() == 0 {
        near[0]
    } else {
        let most = near.iter().fold(N::of(0.0), |m, h| larger(m, h.facing.clone()));
        let enough = most.times(&N::of(1.0).minus(&N::of(1e-9)));
        near.iter().find(|h| h.facing >= enough).unwrap_or(&near[0])
    };
    let distance = winner.distance2.to_f64().sqrt();
    let mut total = scene.diffuse;
    let mut lit = Vec::new();
    for light in &scene.lights {
        let reached = light_reaches(simplices, winner, &light.kind, origin);
        lit.push(reached.is_some());
        if let Some(light_distance) = reached {
            let strength = falloff(light.falloff, light_distance);
            (0..3).for_each(|c| total[c] += strength * light.color[c]);
        }
    }
    let base = scene.facets[winner.id].color;
    let view = falloff(scene.view, distance);
    let color = std::array::from_fn(|c| (total[c].min(1.0) * view * base[c]).clamp(0.0, 255.0));
    SeenPoint { facet: winner.id as i32, distance, lit, color }
}

/// Returns the point of the simplex in the pixel's fibre that is nearest to the eye, over all sets
/// of active inequalities.
fn nearest<N: Number>(scene: &EyeScene, s: &Simplex<N>, id: usize, direction: &[N]) -> Option<Hit<N>> {
    if is_in_plane(&s.normal, &s.offset, &s.size) {
        return None; // edge-on
    }
    let (n, m, hidden) = (scene.dim, scene.screen_dim(), scene.hidden_dim());
    // Equations in lambda: sum = 1, and d x_a - c_a x_0 = 0.
    let mut equations: Vec<(Vec<N>, N)> = vec![(vec![N::of(1.0); n], N::of(1.0))];
    for a in 1..=m {
        let of = |v: &Vec<N>| direction[0].times(&v[a]).minus(&direction[a].times(&v[0]));
        let row: Vec<N> = s.v.iter().map(of).collect();
        if row.iter().all(|f| f.sign() > 0) || row.iter().all(|f| f.sign() < 0) {
            return None;
        }
        equations.push((row, N::of(0.0)));
    }
    let sides = sides(scene, s);
    let gram: Vec<Vec<N>> = s.v.iter().map(|a| s.v.iter().map(|b| dot(a, b)).collect()).collect();
    let mut best: Option<(N, Vec<N>)> = None;
    for active in subsets(sides.len(), hidden) {
        let mut all = equations.clone();
        all.extend(active.iter().map(|&i| (sides[i].clone(), N::of(0.0))));
        let Some(lambda) = least_norm(&gram, &all) else { continue };
        let coordinate =
            |k: usize| s.v.iter().zip(&lambda).fold(N::of(0.0), |sum, (v, l)| sum.plus(&l.times(&v[k])));
        let point: Vec<N> = (0..n).map(coordinate).collect();
        // An active side holds by its equation.
        let is_outside = |(i, side): (usize, &Vec<N>)| !active.contains(&i) && dot(side, &lambda).sign() < 0;
        if point[0].sign() <= 0 || sides.iter().enumerate().any(is_outside) {
            continue;
        }
        let distance2 = dot(&point, &point);
        if best.as_ref().is_none_or(|(d, _)| distance2 < *d) {
            best = Some((distance2, point));
        }
    }
    let (distance2, point) = best?;
    // q = c^2 / (<n,P>^2 / |P|^2 + sum of n_hidden^2).
    let along = dot(&s.normal[..=m], direction);
    let hidden2 = dot(&s.normal[m + 1..], &s.normal[m + 1..]);
    let trace = along.times(&along).over(&dot(direction, direction)).plus(&hidden2);
    let facing = s.offset.times(&s.offset).over(&trace);
    Some(Hit { id, distance2, facing, point })
}

/// Returns the inequalities in lambda: lambda_i >= 0, tan x_0 -+ x_j >= 0.
fn sides<N: Number>(scene: &EyeScene, s: &Simplex<N>) -> Vec<Vec<N>> {
    let n = scene.dim;
    let unit = |i: usize| (0..n).map(|k| N::of(f64::from(u8::from(i == k)))).collect();
    let mut sides: Vec<Vec<N>> = (0..n).map(unit).collect();
    for (slot, tan) in scene.aperture_tan.iter().enumerate() {
        for sign in [1.0, -1.0] {
            let axis = scene.screen_dim() + 1 + slot;
            let row = |v: &Vec<N>| N::of(*tan).times(&v[0]).plus(&N::of(sign).times(&v[axis]));
            sides.push(s.v.iter().map(row).collect());
        }
    }
    sides
}

/// Minimizes lambda^T G lambda under the equations, by Lagrange's system; `None` if it is singular.
fn least_norm<N: Number>(gram: &[Vec<N>], equations: &[(Vec<N>, N)]) -> Option<Vec<N>> {
    let (n, count) = (gram.len(), equations.len());
    if count > n {
        return None;
    }
    let mut rows = Vec::new();
    for i in 0..n {
        let mut row = gram[i].clone();
        row.extend(equations.iter().map(|(a, _)| a[i].clone()));
        row.push(N::of(0.0));
        rows.push(row);
    }
    for (a, b) in equations {
        let mut row = a.clone();
        row.extend((0..count).map(|_| N::of(0.0)));
        row.push(b.clone());
        rows.push(row);
    }
    N::solve(rows).map(|mut x| {
        x.truncate(n);
        x
    })
}

/// Returns all subsets of 0..n with at most `most` members.
fn subsets(n: usize, most: usize) -> Vec<Vec<usize>> {
    let mut all = vec![vec![]];
    let mut last: Vec<Vec<usize>> = vec![vec![]];
    for _ in 0..most {
        last = last
            .iter()
            .flat_map(|set| {
                let from = set.last().map_or(0, |l| l + 1);
                (from..n).map(move |i| [set.clone(), vec![i]].concat())
            })
            .collect();
        all.extend(last.iter().cloned());
    }
    all
}

/// Returns whether a height n.x over a hyperplane is within the tolerance: 1e-10 of `size`, for a unit
/// normal.
fn is_in_plane<N: Number>(normal: &[N], height: &N, size: &N) -> bool {
    let tau = N::of(1e-10).times(size);
    height.times(height) <= tau.times(&tau).times(&dot(normal, normal))
}

/// Returns the distance of the light if it reaches the hit's point on the side that the eye sees.
fn light_reaches<N: Number>(
    simplices: &[Simplex<N>],
    hit: &Hit<N>,
    kind: &EyeLightKind,
    origin: &[N],
) -> Option<f64> {
    let own = &simplices[hit.id];
    let p = &hit.point;
    // The path from p to the light: a vector, and whether it ends there.
    let (way, ends, distance) = match kind {
        EyeLightKind::Sun { direction } => {
            (vector::<N>(direction).iter().map(N::negated).collect(), false, 0.0)
        }
        EyeLightKind::Radial { position } => {
            let way = difference(&difference(&vector(position), origin), p);
            let distance = dot(&way, &way).to_f64().sqrt();
            (way, true, distance)
        }
        EyeLightKind::Plane { direction, point } => {
            let (u, at) = (vector::<N>(direction), difference(&vector(point), origin));
            let h = dot(&difference(&at, p), &u).over(&dot(&u, &u));
            let way: Vec<N> = u.iter().map(|x| x.times(&h)).collect();
            let distance = dot(&way, &way).to_f64().sqrt();
            (way, true, distance)
        }
    };
    let side = dot(&own.normal, &way);
    let is_in_plane = match kind {
        EyeLightKind::Radial { .. } => is_in_plane(&own.normal, &side, &own.size),
        _ => side.sign() == 0,
    };
    if side.sign() != -own.offset.sign() || is_in_plane {
        return None;
    }
    let is_blocked = simplices.iter().any(|g| blocks(g, p, &way, ends));
    (!is_blocked).then_some(distance)
}

/// Returns whether the simplex lies on the way from p, by more than the specification's tolerance.
fn blocks<N: Number>(g: &Simplex<N>, p: &[N], way: &[N], ends: bool) -> bool {
    let tau = N::of(1e-10).times(&larger(largest(p), g.size.clone()));
    let least = tau.times(&tau).times(&dot(&g.normal, &g.normal));
    let over = |h: &N| h.times(h) > least;
    let height = dot(&g.normal, p).minus(&g.offset);
    let change = dot(&g.normal, way);
    if !over(&height) || change.sign() != -height.sign() {
        return false;
    }
    let other = height.plus(&change);
    if ends && (!over(&other) || other.sign() == height.sign()) {
        return false;
    }
    let s = height.negated().over(&change);
    inside(g, &plus_scaled(p, &s, way))
}

/// Returns whether a point of the simplex's hyperplane lies in the closed simplex.
fn inside<N: Number>(s: &Simplex<N>, x: &[N]) -> bool {
    // sum of lambda_i (v_i, 1) = (x, 1), without the coordinate along which the normal is longest.
    let n = x.len();
    let dropped = (0..n).fold(0, |best, a| if s.normal[best].size() < s.normal[a].size() { a } else { best });
    let mut rows: Vec<Vec<N>> = (0..n)
        .filter(|&a| a != dropped)
        .map(|a| s.v.iter().map(|v| v[a].clone()).chain([x[a].clone()]).collect())
        .collect();
    rows.push(vec![N::of(1.0); n + 1]);
    N::solve(rows).is_some_and(|lambda| lambda.iter().all(|l| l.sign() >= 0))
}

#[cfg(test)]
mod tests;

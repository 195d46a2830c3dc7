//! The N-dimensional eye in rational numbers, written in the plainest way: every pixel, every
//! facet, every set of active inequalities, every occluder. It shares no code with the renderer but
//! the scene.
//!
//! The eye must not be rotated, so that all its numbers are rational.

use super::rational::{Q, determinant, dot, solve};
use fbptr::eye::{EyeLightKind, EyeScene, Falloff};

/// Result at one pixel.
pub struct Seen {
    pub facet: i32,
    /// Distance; infinite on a miss.
    pub distance: f64,
    pub lit: Vec<bool>,
    pub color: [f64; 3],
}

struct Simplex {
    v: Vec<Vec<Q>>,
    normal: Vec<Q>,
    offset: Q,
    size: Q,
}

struct Hit {
    id: usize,
    distance2: Q,
    facing: Q,
    point: Vec<Q>,
}

fn q(x: f64) -> Q {
    Q::from_f64(x)
}

fn vector(x: &[f64]) -> Vec<Q> {
    x.iter().map(|&x| q(x)).collect()
}

fn minus(a: &[Q], b: &[Q]) -> Vec<Q> {
    a.iter().zip(b).map(|(x, y)| x - y).collect()
}

fn plus_scaled(a: &[Q], s: &Q, b: &[Q]) -> Vec<Q> {
    a.iter().zip(b).map(|(x, y)| x + &(s * y)).collect()
}

fn largest<'a>(numbers: impl IntoIterator<Item = &'a Q>) -> Q {
    numbers.into_iter().fold(Q::zero(), |m, x| m.max(x.abs()))
}

fn falloff(f: Falloff, distance: f64) -> f64 {
    (f.k / (1.0 + distance).powf(f.n)).min(1.0)
}

pub fn render(scene: &EyeScene) -> Vec<Seen> {
    assert!(scene.pose.rotations.is_empty());
    let origin = vector(&scene.pose.position);
    let simplices: Vec<Simplex> = scene.facets.iter().map(|f| simplex(&f.v, &origin)).collect();
    let mut seen = Vec::new();
    for flat in 0..scene.pixel_count() {
        let mut rest = flat;
        let mut direction = vec![q(scene.distance)];
        for (n, size) in scene.pixels.iter().zip(&scene.size) {
            let (n, j) = (i64::from(*n), (rest % *n as usize) as i64);
            rest /= n as usize;
            direction.push(&(&q(*size) * &q((n - 1 - 2 * j) as f64)) / &q((2 * n) as f64));
        }
        seen.push(pixel(scene, &simplices, &direction, &origin));
    }
    seen
}

fn simplex(v: &[Vec<f64>], origin: &[Q]) -> Simplex {
    let v: Vec<Vec<Q>> = v.iter().map(|p| minus(&vector(p), origin)).collect();
    let edges: Vec<Vec<Q>> = v[1..].iter().map(|p| minus(p, &v[0])).collect();
    let normal: Vec<Q> = (0..v.len())
        .map(|a| {
            let minor: Vec<Vec<Q>> = edges
                .iter()
                .map(|e| e.iter().enumerate().filter(|(k, _)| *k != a).map(|(_, x)| x.clone()).collect())
                .collect();
            if a % 2 == 0 { determinant(&minor) } else { -&determinant(&minor) }
        })
        .collect();
    let offset = dot(&normal, &v[0]);
    let size = largest(v.iter().flatten());
    Simplex { v, normal, offset, size }
}

fn pixel(scene: &EyeScene, simplices: &[Simplex], direction: &[Q], origin: &[Q]) -> Seen {
    let hits: Vec<Hit> =
        simplices.iter().enumerate().filter_map(|(id, s)| nearest(scene, s, id, direction)).collect();
    let Some(least) = hits.iter().map(|h| h.distance2.clone()).min() else {
        let lit = Vec::new();
        return Seen { facet: -1, distance: f64::INFINITY, lit, color: scene.background };
    };
    // D <= D_min (1 + 1e-9), squared.
    let tie = &q(1.0) + &q(1e-9);
    let near: Vec<&Hit> = hits.iter().filter(|h| h.distance2 <= &least * &(&tie * &tie)).collect();
    let winner = if scene.hidden_dim() == 0 {
        near[0]
    } else {
        let most = near.iter().map(|h| h.facing.clone()).max().unwrap();
        let enough = &most * &(&q(1.0) - &q(1e-9));
        near.iter().find(|h| h.facing >= enough).unwrap()
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
    Seen { facet: winner.id as i32, distance, lit, color }
}

/// Returns the point of the simplex in the pixel's fibre that is nearest to the eye, over all sets
/// of active inequalities.
fn nearest(scene: &EyeScene, s: &Simplex, id: usize, direction: &[Q]) -> Option<Hit> {
    if s.offset.sign() == 0 {
        return None; // edge-on
    }
    let (n, m, hidden) = (scene.dim, scene.screen_dim(), scene.hidden_dim());
    // Equations in lambda: sum = 1, and d x_a - c_a x_0 = 0.
    let mut equations: Vec<(Vec<Q>, Q)> = vec![(vec![q(1.0); n], q(1.0))];
    for a in 1..=m {
        let row: Vec<Q> = s.v.iter().map(|v| &(&direction[0] * &v[a]) - &(&direction[a] * &v[0])).collect();
        if row.iter().all(|f| f.sign() > 0) || row.iter().all(|f| f.sign() < 0) {
            return None;
        }
        equations.push((row, Q::zero()));
    }
    // Inequalities: lambda_i >= 0, tan x_0 -+ x_j >= 0.
    let mut sides: Vec<Vec<Q>> =
        (0..n).map(|i| (0..n).map(|k| q(f64::from(u8::from(i == k)))).collect()).collect();
    for (slot, tan) in scene.aperture_tan.iter().enumerate() {
        for sign in [1.0, -1.0] {
            let row = |v: &Vec<Q>| &(&q(*tan) * &v[0]) + &(&q(sign) * &v[m + 1 + slot]);
            sides.push(s.v.iter().map(row).collect());
        }
    }
    let gram: Vec<Vec<Q>> = s.v.iter().map(|a| s.v.iter().map(|b| dot(a, b)).collect()).collect();
    let mut best: Option<(Q, Vec<Q>)> = None;
    for active in subsets(sides.len(), hidden) {
        let mut all = equations.clone();
        all.extend(active.iter().map(|&i| (sides[i].clone(), Q::zero())));
        let Some(lambda) = least_norm(&gram, &all) else { continue };
        let point: Vec<Q> = (0..n)
            .map(|k| s.v.iter().zip(&lambda).fold(Q::zero(), |sum, (v, l)| &sum + &(l * &v[k])))
            .collect();
        if point[0].sign() <= 0 || sides.iter().any(|side| dot(side, &lambda).sign() < 0) {
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
    let trace = &(&(&along * &along) / &dot(direction, direction)) + &hidden2;
    let facing = &(&s.offset * &s.offset) / &trace;
    Some(Hit { id, distance2, facing, point })
}

/// Minimizes lambda^T G lambda under the equations, by Lagrange's system; `None` if it is singular.
fn least_norm(gram: &[Vec<Q>], equations: &[(Vec<Q>, Q)]) -> Option<Vec<Q>> {
    let (n, count) = (gram.len(), equations.len());
    if count > n {
        return None;
    }
    let mut rows = Vec::new();
    for i in 0..n {
        let mut row = gram[i].clone();
        row.extend(equations.iter().map(|(a, _)| a[i].clone()));
        row.push(Q::zero());
        rows.push(row);
    }
    for (a, b) in equations {
        let mut row = a.clone();
        row.extend((0..count).map(|_| Q::zero()));
        row.push(b.clone());
        rows.push(row);
    }
    solve(rows).map(|mut x| {
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

/// Returns the distance of the light if it reaches the hit's point on the side that the eye sees.
fn light_reaches(simplices: &[Simplex], hit: &Hit, kind: &EyeLightKind, origin: &[Q]) -> Option<f64> {
    let own = &simplices[hit.id];
    let p = &hit.point;
    // The path from p to the light: a vector, and whether it ends there.
    let (way, ends, distance) = match kind {
        EyeLightKind::Sun { direction } => (vector(direction).iter().map(|x| -x).collect(), false, 0.0),
        EyeLightKind::Radial { position } => {
            let way = minus(&minus(&vector(position), origin), p);
            let distance = dot(&way, &way).to_f64().sqrt();
            (way, true, distance)
        }
        EyeLightKind::Plane { direction, point } => {
            let (u, at) = (vector(direction), minus(&vector(point), origin));
            let h = &dot(&minus(&at, p), &u) / &dot(&u, &u);
            let way: Vec<Q> = u.iter().map(|x| x * &h).collect();
            let distance = dot(&way, &way).to_f64().sqrt();
            (way, true, distance)
        }
    };
    if dot(&own.normal, &way).sign() != -own.offset.sign() {
        return None;
    }
    let blocked = simplices.iter().any(|g| {
        let tau = &q(1e-10) * &largest(p).max(g.size.clone());
        let over = |h: &Q| (h * h) > (&(&tau * &tau) * &dot(&g.normal, &g.normal));
        let height = &dot(&g.normal, p) - &g.offset;
        let change = dot(&g.normal, &way);
        if !over(&height) || height.sign() == -change.sign() && change.sign() == 0 {
            return false;
        }
        let other = &height + &change;
        if ends && (!over(&other) || other.sign() == height.sign()) {
            return false;
        }
        if change.sign() != -height.sign() {
            return false;
        }
        let s = &(-&height) / &change;
        inside(g, &plus_scaled(p, &s, &way))
    });
    (!blocked).then_some(distance)
}

/// Returns whether a point of the simplex's hyperplane lies in the closed simplex.
fn inside(s: &Simplex, x: &[Q]) -> bool {
    // sum of lambda_i (v_i, 1) = (x, 1), without a coordinate along which the normal is not 0.
    let n = x.len();
    let dropped = (0..n).find(|&a| s.normal[a].sign() != 0).unwrap();
    let mut rows: Vec<Vec<Q>> = (0..n)
        .filter(|&a| a != dropped)
        .map(|a| s.v.iter().map(|v| v[a].clone()).chain([x[a].clone()]).collect())
        .collect();
    rows.push(vec![q(1.0); n + 1]);
    solve(rows).is_some_and(|lambda| lambda.iter().all(|l| l.sign() >= 0))
}

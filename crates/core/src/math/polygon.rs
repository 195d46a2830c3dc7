//! Triangulation of polygons in space.

use glam::DVec3;
use std::collections::BTreeSet;

/// Returns the triangles of a simple, roughly planar polygon, as indices into `points`, in the
/// polygon's own winding.
///
/// A convex polygon is fanned at its first corner: (0,1,2), (0,2,3), ... A concave one is cut into
/// ears in order of its corners, projected along Newell's normal on the plane of the two largest
/// extents. Degenerate polygons are fanned.
pub fn triangulate(points: &[DVec3]) -> Vec<[u32; 3]> {
    let n = points.len();
    let fan = |n: usize| (1..n.saturating_sub(1) as u32).map(|i| [0, i, i + 1]).collect::<Vec<_>>();
    if n <= 3 {
        return fan(n);
    }
    let normal = newell_normal(points);
    let axis = normal.abs().max_position();
    if !(normal.abs().max_element() > 0.0 && normal.is_finite()) {
        return fan(n);
    }
    let flip = normal[axis] < 0.0;
    let flat: Vec<[f64; 2]> = points
        .iter()
        .map(|p| {
            let (a, b) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
            if flip { [b, a] } else { [a, b] }
        })
        .collect();
    if (0..n).all(|i| turn(&flat, i, (i + 1) % n, (i + 2) % n) >= 0.0) {
        return fan(n);
    }
    cut_ears(&flat)
}

/// Number of times that all corners of a degenerate polygon are checked again before the rest is
/// fanned.
const MAX_RECHECKS: u32 = 8;

/// Cuts a concave polygon that is counter-clockwise in the plane into ears: always the first ear,
/// counted from the second remaining corner; the first remaining corner comes last.
///
/// An ear is a convex corner whose triangle holds no other corner. Only corners that are not convex
/// need to be tested, and cutting an ear can change only its two neighbours: n corners, r of them
/// reflex, cost O(n r). Self-crossing or degenerate polygons run out of ears: the rest is fanned,
/// so that no face is lost.
fn cut_ears(flat: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let n = flat.len();
    let mut next: Vec<usize> = (0..n).map(|i| (i + 1) % n).collect();
    let mut prev: Vec<usize> = (0..n).map(|i| (i + n - 1) % n).collect();
    let mut is_left = vec![true; n];
    let convex = |i: usize, prev: &[usize], next: &[usize]| turn(flat, prev[i], i, next[i]) > 0.0;
    let mut reflex = Set::of((0..n).filter(|&i| !convex(i, &prev, &next)), n);
    let is_ear = |i: usize, prev: &[usize], next: &[usize], reflex: &Set| {
        convex(i, prev, next) && !holds_any(flat, [prev[i], i, next[i]], &reflex.members)
    };
    let mut ears: BTreeSet<usize> = (0..n).filter(|&i| is_ear(i, &prev, &next, &reflex)).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    let (mut left, mut first, mut rechecks) = (n, 0, 0);
    while left > 3 {
        // The first remaining corner has the smallest index: it is taken only if there is no other
        // ear.
        let Some(i) = ears.iter().copied().find(|&i| i != first).or_else(|| ears.first().copied()) else {
            rechecks += 1;
            let all = (0..n).filter(|&i| is_left[i]);
            if rechecks <= MAX_RECHECKS {
                ears = all.filter(|&i| is_ear(i, &prev, &next, &reflex)).collect();
            }
            if ears.is_empty() {
                break;
            }
            continue;
        };
        let (a, c) = (prev[i], next[i]);
        triangles.push([a as u32, i as u32, c as u32]);
        (next[a], prev[c], is_left[i]) = (c, a, false);
        left -= 1;
        first = if i == first { c } else { first };
        ears.remove(&i);
        reflex.remove(i);
        for k in [a, c] {
            if convex(k, &prev, &next) {
                reflex.remove(k);
            }
        }
        for k in [a, c] {
            match is_ear(k, &prev, &next, &reflex) {
                true => ears.insert(k),
                false => ears.remove(&k),
            };
        }
    }
    let (mut b, mut c) = (next[first], next[next[first]]);
    while c != first {
        triangles.push([first as u32, b as u32, c as u32]);
        (b, c) = (c, next[c]);
    }
    triangles
}

/// Unordered set of corner indices with removal in constant time.
struct Set {
    members: Vec<usize>,
    /// Index of a corner in `members`; `usize::MAX` if it is not a member.
    slot: Vec<usize>,
}

impl Set {
    fn of(members: impl Iterator<Item = usize>, n: usize) -> Self {
        let members: Vec<usize> = members.collect();
        let mut slot = vec![usize::MAX; n];
        members.iter().enumerate().for_each(|(at, &i)| slot[i] = at);
        Set { members, slot }
    }

    fn remove(&mut self, i: usize) {
        let at = std::mem::replace(&mut self.slot[i], usize::MAX);
        if at < self.members.len() {
            self.members.swap_remove(at);
            if let Some(&moved) = self.members.get(at) {
                self.slot[moved] = at;
            }
        }
    }
}

/// Returns whether one of `candidates` lies in the triangle. The bounding box rejects most of them.
fn holds_any(flat: &[[f64; 2]], corners: [usize; 3], candidates: &[usize]) -> bool {
    let [p, q, r] = corners.map(|i| flat[i]);
    let lo = [p[0].min(q[0]).min(r[0]), p[1].min(q[1]).min(r[1])];
    let hi = [p[0].max(q[0]).max(r[0]), p[1].max(q[1]).max(r[1])];
    candidates.iter().any(|&i| {
        let [x, y] = flat[i];
        x >= lo[0] && x <= hi[0] && y >= lo[1] && y <= hi[1] && holds(flat, corners, i)
    })
}

/// Returns twice the signed area of corners a, b, c, positive if they turn left.
fn turn(flat: &[[f64; 2]], a: usize, b: usize, c: usize) -> f64 {
    let (p, q, r) = (flat[a], flat[b], flat[c]);
    (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
}

/// Returns whether corner `p` lies in the triangle or on its edges, and not at one of its corners.
fn holds(flat: &[[f64; 2]], [a, b, c]: [usize; 3], p: usize) -> bool {
    let at_corner = flat[a] == flat[p] || flat[b] == flat[p] || flat[c] == flat[p];
    turn(flat, a, b, p) >= 0.0 && turn(flat, b, c, p) >= 0.0 && turn(flat, c, a, p) >= 0.0 && !at_corner
}

/// Returns Newell's normal: its length is twice the polygon's area; zero for a degenerate polygon.
pub fn newell_normal(points: &[DVec3]) -> DVec3 {
    let Some(&origin) = points.first() else { return DVec3::ZERO };
    // Relative to the first corner, so that a polygon far from the origin keeps its digits.
    points.windows(2).fold(DVec3::ZERO, |sum, w| sum + (w[0] - origin).cross(w[1] - origin))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
    }

    #[test]
    fn convex_is_fanned_and_concave_is_cut_into_ears_that_fill_it() {
        assert_eq!(triangulate(&flat(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)])), [[0, 1, 2], [0, 2, 3]]);
        let arrow = flat(&[(0., 0.), (4., 0.), (1., 1.), (0., 4.)]);
        let cut = triangulate(&arrow);
        let area = |t: &[u32; 3]| newell_normal(&t.map(|i| arrow[i as usize])).z / 2.0;
        assert_eq!(cut.len(), 2);
        assert!(cut.iter().all(|t| area(t) > 0.0));
        assert_eq!(cut.iter().map(area).sum::<f64>(), newell_normal(&arrow).z / 2.0);
        assert_eq!(triangulate(&flat(&[(0., 0.), (1., 0.)])), [] as [[u32; 3]; 0]);
        assert_eq!(triangulate(&flat(&[(1., 1.); 5])).len(), 3);
    }

    #[test]
    fn the_reflex_corner_may_be_any() {
        let arrow = [(0., 0.), (4., 0.), (1., 1.), (0., 4.)];
        for first in 0..4 {
            let points = flat(&[0, 1, 2, 3].map(|i| arrow[(first + i) % 4]));
            // Only the diagonal from the reflex corner lies inside.
            let reflex = (6 - first) % 4;
            let cut = triangulate(&points);
            let area = |t: &[u32; 3]| newell_normal(&t.map(|i| points[i as usize])).z / 2.0;
            assert!(cut.iter().all(|t| t.contains(&(reflex as u32)) && area(t) == 2.0), "{first}: {cut:?}");
        }
    }

    #[test]
    fn a_corner_within_a_side_makes_no_convex_polygon_concave() {
        let square = [(0., 0.), (1., 0.), (2., 0.), (2., 2.), (0., 2.)];
        let fan = [[0, 1, 2], [0, 2, 3], [0, 3, 4]];
        assert_eq!(triangulate(&flat(&square)), fan);
        let reversed: Vec<DVec3> = flat(&square).into_iter().map(|p| DVec3::new(p.y, p.x, 0.0)).collect();
        assert_eq!(triangulate(&reversed), fan);
    }

    #[test]
    fn polygons_without_a_normal_are_fanned() {
        // A figure eight whose halves cancel, in each plane of two axes.
        let eight = [(0., 0.), (2., 2.), (2., 0.), (0., 2.)];
        for turn in 0..3 {
            let points: Vec<DVec3> = eight
                .iter()
                .map(|&(a, b)| {
                    let mut p = DVec3::ZERO;
                    (p[turn], p[(turn + 1) % 3]) = (a, b);
                    p
                })
                .collect();
            assert_eq!(newell_normal(&points), DVec3::ZERO);
            assert_eq!(triangulate(&points), [[0, 1, 2], [0, 2, 3]], "{turn}");
        }
    }

    /// The definition, one corner at a time: after each cut, all corners are checked again from the
    /// second on.
    fn plain_ears(flat: &[[f64; 2]]) -> Vec<[u32; 3]> {
        let mut ring: Vec<usize> = (0..flat.len()).collect();
        let mut triangles = Vec::new();
        while ring.len() > 3 {
            let m = ring.len();
            let around = |i: usize| [ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]];
            let is_ear = |i: usize| {
                let [a, b, c] = around(i);
                turn(flat, a, b, c) > 0.0 && !ring.iter().any(|&p| holds(flat, [a, b, c], p))
            };
            let Some(i) = (0..m).map(|k| (k + 1) % m).find(|&i| is_ear(i)) else { break };
            triangles.push(around(i).map(|k| k as u32));
            ring.remove(i);
        }
        triangles.extend((2..ring.len()).map(|k| [ring[0] as u32, ring[k - 1] as u32, ring[k] as u32]));
        triangles
    }

    proptest! {
        #[test]
        fn simple_polygons_are_cut_as_defined_and_filled(radii in prop::collection::vec(1u32..100, 4..60)) {
            // Star-shaped about the origin: simple, and concave at random.
            let n = radii.len() as f64;
            let corner = |(k, r): (usize, &u32)| {
                let (sin, cos) = libm::sincos(k as f64 / n * std::f64::consts::TAU);
                [f64::from(*r) * cos, f64::from(*r) * sin]
            };
            let polygon: Vec<[f64; 2]> = radii.iter().enumerate().map(corner).collect();
            let cut = cut_ears(&polygon);
            prop_assert_eq!(&cut, &plain_ears(&polygon));
            prop_assert_eq!(cut.len(), polygon.len() - 2);
            let areas = cut.iter().map(|t| turn(&polygon, t[0] as usize, t[1] as usize, t[2] as usize));
            prop_assert!(areas.clone().all(|a| a >= 0.0));
            let whole: f64 = (0..polygon.len())
                .map(|i| {
                    let (p, q) = (polygon[i], polygon[(i + 1) % polygon.len()]);
                    p[0] * q[1] - p[1] * q[0]
                })
                .sum();
            prop_assert!((areas.sum::<f64>() / whole - 1.0).abs() < 1e-9);
        }

        #[test]
        fn any_corners_give_n_minus_2_triangles(points in prop::collection::vec((0i8..6, 0i8..6, 0i8..3), 3..24)) {
            let points: Vec<DVec3> =
                points.into_iter().map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into())).collect();
            let cut = triangulate(&points);
            prop_assert_eq!(cut.len(), points.len() - 2);
            prop_assert!(cut.iter().flatten().all(|i| (*i as usize) < points.len()));
        }
    }
}

//! One collapse: the star of a vertex u is drawn anew as a fan from a neighbour v, and the change is
//! bounded.
//!
//! In: the ring of neighbours around u, in object space, with unit normals and colours. Out: for
//! the best neighbour, bounds on how far a point moves and how much its normal and colour change.
//!
//! Both patches have the ring as boundary, and both are graphs over the plane at right angles to an
//! axis: all their faces are counter-clockwise in it, and the ring goes around u once. So moving
//! along the axis maps one patch onto the other, one to one. Their edges cut the plane into pieces
//! on which all values are affine; a norm of a difference of affine functions is convex, and has its
//! maximum at a corner of a piece: u, or a place where an edge of u crosses an edge of v. On the ring
//! nothing changes. Normals N = m/|m|, m interpolated, are compared by their slopes t = m_p/m_a (p
//! across and a along the axis), between which there is at least the angle of the normals:
//!
//! ```text
//! t' - t = (m'_p - m_p)/m_a' + m_p (m_a - m_a')/(m_a m_a')
//! angle <= max |m'_p - m_p| / min m_a + max |m_p| max |m_a' - m_a| / (min m_a)^2
//! ```
//!
//! One knows that it is right if points and normals of random stars, moved along the axis, stay
//! within the bounds (tests).

use glam::{DMat3, DVec2, DVec3, DVec4};

/// Largest number of neighbours of a vertex that is removed.
pub(super) const MOST_NEIGHBOURS: usize = 12;

/// Least cosine between the axis and a face's normal, and between the axis and a corner's.
const LEAST_COSINE: f64 = 0.25;

/// Part by which sums are larger than what f64 makes of them.
const ROUNDED_UP: f64 = 1.0 + 1e-9;

/// Corner of a face: a position with its normal and colour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point {
    pub position: DVec3,
    /// Unit normal.
    pub normal: DVec3,
    pub color: DVec4,
}

/// Largest change that surface points had on their way: distance in object space, angle between
/// normals in radians, colour in each channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Change {
    /// Distance in object space.
    pub distance: f64,
    /// Angle between the normals, in radians.
    pub turn: f64,
    /// Difference of the colours' channels.
    pub color: f64,
}

impl Change {
    /// Returns the larger of each.
    pub fn max(self, other: Change) -> Change {
        Change {
            distance: self.distance.max(other.distance),
            turn: self.turn.max(other.turn),
            color: self.color.max(other.color),
        }
    }

    /// Returns the change of going through both.
    pub fn then(self, next: Change) -> Change {
        Change {
            distance: (self.distance + next.distance) * ROUNDED_UP,
            turn: (self.turn + next.turn) * ROUNDED_UP,
            color: (self.color + next.color) * ROUNDED_UP,
        }
    }

    /// Returns whether each is at most that of `limit`.
    pub fn is_within(self, limit: Change) -> bool {
        self.distance <= limit.distance && self.turn <= limit.turn && self.color <= limit.color
    }
}

/// Corner of a star: its place in the plane, its height, and what is interpolated.
#[derive(Clone, Copy, Debug, Default)]
struct Flat {
    at: DVec2,
    height: f64,
    across: DVec2,
    along: f64,
    color: DVec4,
}

impl Flat {
    /// Returns the point at `part` of the way to `other`.
    fn mix(&self, other: &Flat, part: f64) -> Flat {
        Flat {
            at: self.at.lerp(other.at, part),
            height: self.height + (other.height - self.height) * part,
            across: self.across.lerp(other.across, part),
            along: self.along + (other.along - self.along) * part,
            color: self.color.lerp(other.color, part),
        }
    }
}

/// Star of a vertex, over its plane. The vertex is at the origin.
pub(super) struct Star {
    center: Flat,
    ring: [Flat; MOST_NEIGHBOURS],
    len: usize,
    /// Square of the distance to the farthest neighbour.
    reach2: f64,
}

impl Star {
    /// Creates the star of `center`, whose neighbours are `ring`, counter-clockwise. Returns `None`
    /// unless it is the graph of a function over a plane.
    pub fn of(center: &Point, ring: &[Point]) -> Option<Star> {
        let len = ring.len();
        if !(3..=MOST_NEIGHBOURS).contains(&len) {
            return None;
        }
        let spoke = |i: usize| ring[i % len].position - center.position;
        let faces = (0..len).map(|i| spoke(i).cross(spoke(i + 1)));
        let axis = crate::math::matrix::unit(faces.sum::<DVec3>())?;
        let first = axis.any_orthonormal_vector();
        let frame = DMat3::from_cols(first, axis.cross(first), axis).transpose();
        let flat = |p: &Point| {
            let (place, normal) = (frame * (p.position - center.position), frame * p.normal);
            Flat {
                at: place.truncate(),
                height: place.z,
                across: normal.truncate(),
                along: normal.z,
                color: p.color,
            }
        };
        let mut star =
            Star { center: flat(center), ring: [Flat::default(); MOST_NEIGHBOURS], len, reach2: 0.0 };
        for (flat_point, point) in star.ring.iter_mut().zip(ring) {
            *flat_point = flat(point);
            star.reach2 = star.reach2.max(flat_point.at.length_squared());
        }
        (star.is_graph() && star.least_along() >= LEAST_COSINE).then_some(star)
    }

    /// Returns whether all faces are counter-clockwise in the plane and not steep, and the ring goes
    /// around the vertex once.
    fn is_graph(&self) -> bool {
        let mut turns = 0;
        for i in 0..self.len {
            let (a, b) = (&self.ring[i], &self.ring[(i + 1) % self.len]);
            let area = a.at.perp_dot(b.at);
            let [a3, b3] = [a, b].map(|p| p.at.extend(p.height));
            // Negated, so that numbers that are not finite are refused.
            if !(area > LEAST_COSINE * a3.cross(b3).length() && area > 1e-9 * self.reach2) {
                return false;
            }
            turns += usize::from(a.at.y < 0.0 && b.at.y >= 0.0);
        }
        turns == 1
    }

    /// Returns the least part of a corner's normal along the axis.
    fn least_along(&self) -> f64 {
        self.ring[..self.len].iter().fold(self.center.along, |least, p| least.min(p.along))
    }

    /// Returns the height, normal and colour at the vertex's place of the fan from neighbour `v`, and
    /// the number of ring edges from v to those of the face that lies there; `None` if the fan is not a graph over the plane.
    fn fan_at_center(&self, v: usize) -> Option<(Flat, usize)> {
        let (len, from) = (self.len, &self.ring[v]);
        let mut found = None;
        for k in 1..len - 1 {
            let (a, b) = (&self.ring[(v + k) % len], &self.ring[(v + k + 1) % len]);
            let area = (a.at - from.at).perp_dot(b.at - from.at);
            let sides = [a, b].map(|p| (p.at - from.at).extend(p.height - from.height));
            if !(area > LEAST_COSINE * sides[0].cross(sides[1]).length() && area > 1e-6 * self.reach2) {
                return None;
            }
            // Parts of the corners at the origin.
            let [of_a, of_b] = [b.at.perp_dot(from.at), from.at.perp_dot(a.at)].map(|part| part / area);
            if found.is_none() && a.at.perp_dot(b.at) >= 0.0 && of_a >= 0.0 && of_b >= -1e-12 {
                let rest = 1.0 - of_a - of_b;
                let sum = |value: fn(&Flat) -> f64| value(from) * rest + value(a) * of_a + value(b) * of_b;
                let middle = Flat {
                    at: DVec2::ZERO,
                    height: sum(|p| p.height),
                    across: from.across * rest + a.across * of_a + b.across * of_b,
                    along: sum(|p| p.along),
                    color: from.color * rest + a.color * of_a + b.color * of_b,
                };
                found = Some((middle, k));
            }
        }
        found
    }

    /// Returns a measure of what collapsing to neighbour `v` changes at the vertex itself, in parts
    /// of `limit`; `None` if the fan is not a graph over the plane.
    pub fn cost(&self, v: usize, limit: &Change) -> Option<f64> {
        let (fan, _) = self.fan_at_center(v)?;
        let mut bound = ChangeBound::new(self);
        bound.add(&self.center, &fan);
        let change = bound.change();
        let length = self.ring[v].at.length_squared() / self.reach2;
        Some(change.distance / limit.distance + change.turn / limit.turn + 0.01 * length)
    }

    /// Returns bounds on the change of every point of each face of the fan from neighbour `v`, by the
    /// number of ring edges from v to the face's own edge; `before` has those of the star's faces,
    /// from the ring's first edge on. `None` if the fan is not a graph over the plane.
    pub fn change(&self, v: usize, before: &[Change]) -> Option<[Change; MOST_NEIGHBOURS]> {
        let (len, from) = (self.len, &self.ring[v]);
        let (fan, middle) = self.fan_at_center(v)?;
        let mut bounds = [ChangeBound::new(self); MOST_NEIGHBOURS];
        // A face of the fan keeps its outer edge, and that is not all that it shares with the star.
        let mut past: [Change; MOST_NEIGHBOURS] = std::array::from_fn(|k| before[(v + k) % len]);
        bounds[middle].add(&self.center, &fan);
        past[middle] = before.iter().fold(Change::default(), |most, change| most.max(*change));
        for k in 2..len - 1 {
            // The edge from v to `to` crosses edges from the origin.
            let to = &self.ring[(v + k) % len];
            let along = to.at - from.at;
            for (i, old) in self.ring[..len].iter().enumerate() {
                let cross = old.at.perp_dot(along);
                // from + t along = s old
                let (s, t) = (from.at.perp_dot(along) / cross, from.at.perp_dot(old.at) / cross);
                // Rounding may bring a crossing beyond an end, where nothing changes.
                let is_inside = |part: f64| (-1e-9..=1.0 + 1e-9).contains(&part);
                if is_inside(s) && is_inside(t) {
                    let (a, b) = (self.center.mix(old, s), from.mix(to, t));
                    let beside = before[i].max(before[(i + len - 1) % len]);
                    for face in [k - 1, k] {
                        bounds[face].add(&a, &b);
                        past[face] = past[face].max(beside);
                    }
                }
            }
        }
        Some(std::array::from_fn(|k| past[k].then(bounds[k].change())))
    }
}

/// Largest differences seen so far.
#[derive(Clone, Copy)]
struct ChangeBound {
    least_along: f64,
    most_across: f64,
    height: f64,
    across: f64,
    along: f64,
    color: f64,
}

impl ChangeBound {
    fn new(star: &Star) -> ChangeBound {
        let points = || star.ring[..star.len].iter().chain([&star.center]);
        ChangeBound {
            least_along: star.least_along(),
            most_across: points().fold(0.0f64, |most, p| most.max(p.across.length_squared())).sqrt(),
            height: 0.0,
            across: 0.0,
            along: 0.0,
            color: 0.0,
        }
    }

    /// Adds a corner of the pieces, before and after.
    fn add(&mut self, old: &Flat, new: &Flat) {
        self.height = self.height.max((old.height - new.height).abs());
        self.across = self.across.max(old.across.distance_squared(new.across));
        self.along = self.along.max((old.along - new.along).abs());
        self.color = self.color.max((old.color - new.color).abs().max_element());
    }

    fn change(&self) -> Change {
        let slope = self.across.sqrt() + self.most_across * self.along / self.least_along;
        Change { distance: self.height, turn: slope / self.least_along, color: self.color }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::scenes::Random;
    use std::f64::consts::TAU;

    fn point(r: &mut Random, at: DVec2, bend: f64) -> Point {
        let height = bend * at.length_squared() + r.real(-0.02, 0.02);
        let normal = DVec3::new(-2.0 * bend * at.x, -2.0 * bend * at.y, 1.0) + r.point(-0.05, 0.05);
        Point {
            position: at.extend(height) + DVec3::new(3.0, -2.0, 1.0),
            normal: normal.normalize(),
            color: r.point(0.0, 1.0).extend(1.0),
        }
    }

    /// Returns the patch's interpolated values above a place in the plane, if a face lies there.
    fn above(faces: &[[Flat; 3]], at: DVec2) -> Option<Flat> {
        faces.iter().find_map(|[a, b, c]| {
            let area = (b.at - a.at).perp_dot(c.at - a.at);
            let of_b = (at - a.at).perp_dot(c.at - a.at) / area;
            let of_c = (b.at - a.at).perp_dot(at - a.at) / area;
            let rest = 1.0 - of_b - of_c;
            (of_b >= 0.0 && of_c >= 0.0 && rest >= 0.0).then(|| Flat {
                at,
                height: a.height * rest + b.height * of_b + c.height * of_c,
                across: a.across * rest + b.across * of_b + c.across * of_c,
                along: a.along * rest + b.along * of_b + c.along * of_c,
                color: a.color * rest + b.color * of_b + c.color * of_c,
            })
        })
    }

    #[test]
    fn every_point_and_normal_stays_within_the_bound_which_is_not_wide() {
        let mut r = Random::new(11);
        let (mut checked, mut widest) = (0, [0.0f64; 3]);
        for _ in 0..400 {
            let len = 3 + (r.real(0.0, 6.0) as usize);
            let bend = r.real(-0.3, 0.3);
            let center = point(&mut r, DVec2::ZERO, bend);
            let ring: Vec<Point> = (0..len)
                .map(|i| {
                    let (sin, cos) = libm::sincos((i as f64 + r.real(0.1, 0.9)) / len as f64 * TAU);
                    let far = r.real(0.3, 1.0);
                    point(&mut r, DVec2::new(cos, sin) * far, bend)
                })
                .collect();
            let Some(star) = Star::of(&center, &ring) else { continue };
            for v in 0..len {
                let Some(bounds) = star.change(v, &[Change::default(); MOST_NEIGHBOURS][..len]) else {
                    continue;
                };
                let bound = bounds[1..len - 1].iter().fold(Change::default(), |most, b| most.max(*b));
                let corner = |i: usize| star.ring[i % len];
                let old: Vec<_> = (0..len).map(|i| [star.center, corner(i), corner(i + 1)]).collect();
                let new: Vec<_> =
                    (1..len - 1).map(|k| [corner(v), corner(v + k), corner(v + k + 1)]).collect();
                let mut most = Change::default();
                for _ in 0..200 {
                    let at = r.point(-1.0, 1.0).truncate();
                    let (Some(a), Some(b)) = (above(&old, at), above(&new, at)) else { continue };
                    let [m, n] = [a, b].map(|p| p.across.extend(p.along));
                    most = most.max(Change {
                        distance: (a.height - b.height).abs(),
                        turn: m.angle_between(n),
                        color: (a.color - b.color).abs().max_element(),
                    });
                    checked += 1;
                }
                let seen = [most.distance, most.turn, most.color];
                let bounds = [bound.distance, bound.turn, bound.color];
                for (i, (seen, bound)) in seen.into_iter().zip(bounds).enumerate() {
                    assert!(seen <= bound + 1e-7, "{i}: {seen} of {bound}, fan {v} of {len}");
                    widest[i] = widest[i].max(seen / bound);
                }
            }
        }
        assert!(checked > 50_000 && widest.iter().all(|part| *part > 0.8), "{checked}, {widest:?}");
    }

    #[test]
    fn a_ring_that_folds_or_goes_around_twice_is_refused() {
        let at =
            |x: f64, y: f64| Point { position: DVec3::new(x, y, 0.0), normal: DVec3::Z, color: DVec4::ONE };
        let center = at(0.0, 0.0);
        let around = |turns: f64, len: usize| {
            let place = |i: usize| libm::sincos(turns * TAU * i as f64 / len as f64);
            (0..len).map(|i| at(place(i).1, place(i).0)).collect::<Vec<_>>()
        };
        assert!(Star::of(&center, &around(1.0, 6)).is_some());
        assert!(Star::of(&center, &around(2.0, 7)).is_none());
        let mut folded = around(1.0, 6);
        folded.swap(2, 3);
        assert!(Star::of(&center, &folded).is_none());
        let mut turned = around(1.0, 6);
        turned[1].normal = DVec3::X;
        assert!(Star::of(&center, &turned).is_none());
        // Flat stars change nothing.
        let flat = Star::of(&center, &around(1.0, 6)).unwrap();
        let change = flat.change(2, &[Change::default(); 6]).unwrap()[2];
        assert!(change.distance < 1e-15 && change.turn < 1e-15 && change.color < 1e-15, "{change:?}");
    }
}

//! Interpolator nodes: values between keys. Source: ISO/IEC 19775-1 clause 19 (normals on the unit
//! sphere: 19.4.4).
//!
//! Keys do not decrease (checked when the file is read). Before the first key the first value
//! applies, after the last one the last; at equal keys the later value applies from there on.

use super::graph::{GraphView, NodeId};
use super::value::{Kind, Value};
use glam::{DQuat, DVec3};

/// Returns the type of an interpolator's values; `None` for other nodes.
pub(super) fn kind(name: &str) -> Option<Kind> {
    match name {
        "ScalarInterpolator" => Some(Kind::Sf(1)),
        "PositionInterpolator" | "ColorInterpolator" | "SplinePositionInterpolator" => Some(Kind::Sf(3)),
        "OrientationInterpolator" => Some(Kind::Sf(4)),
        "CoordinateInterpolator" | "NormalInterpolator" => Some(Kind::Mf(3)),
        _ => None,
    }
}

/// Returns an interpolator's value at a fraction; `None` if it has no keys, or if the numbers
/// overflow.
pub(super) fn evaluate(view: &GraphView, id: NodeId, fraction: f64) -> Option<Value> {
    let (key, values) = (view.reals(id, "key"), view.reals(id, "keyValue"));
    let tuple = if key.is_empty() { 0 } else { values.len() / key.len() };
    if tuple == 0 {
        return None;
    }
    let at = |i: usize| &values[i * tuple..(i + 1) * tuple];
    let span = span(key, fraction);
    let found: Vec<f64> = match (view.name(id), span) {
        (_, Span::At(i)) => at(i).to_vec(),
        ("ColorInterpolator", Span::Between(i, s)) => {
            color(triple(at(i)), triple(at(i + 1)), s).to_array().into()
        }
        ("OrientationInterpolator", Span::Between(i, s)) => orientation(at(i), at(i + 1), s).into(),
        ("NormalInterpolator", Span::Between(i, s)) => {
            let pairs = at(i).chunks_exact(3).zip(at(i + 1).chunks_exact(3));
            pairs.flat_map(|(a, b)| normal(triple(a), triple(b), s).to_array()).collect()
        }
        ("SplinePositionInterpolator", Span::Between(i, s)) => {
            let points: Vec<DVec3> = values.chunks_exact(3).map(triple).collect();
            let velocities: Vec<DVec3> = view.reals(id, "keyVelocity").chunks_exact(3).map(triple).collect();
            let spline = Spline {
                key,
                points: &points[..key.len()],
                velocities: &velocities,
                is_closed: view.bool(id, "closed"),
                normalize: view.bool(id, "normalizeVelocity"),
            };
            spline.at(i, s).to_array().into()
        }
        (_, Span::Between(i, s)) => at(i).iter().zip(at(i + 1)).map(|(a, b)| a + (b - a) * s).collect(),
    };
    found.iter().all(|x| x.is_finite()).then(|| Value::Reals(found.into()))
}

fn triple(values: &[f64]) -> DVec3 {
    DVec3::new(values[0], values[1], values[2])
}

/// Position of a fraction among the keys.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Span {
    /// At this key, before the first, or after the last: the key's value applies.
    At(usize),
    /// Between key i and the next, at the parameter 0 < s < 1.
    Between(usize, f64),
}

fn span(key: &[f64], fraction: f64) -> Span {
    let after = key.partition_point(|k| *k <= fraction);
    match after {
        0 => Span::At(0),
        _ if after == key.len() || key[after - 1] == fraction => Span::At(after - 1),
        _ => Span::Between(after - 1, (fraction - key[after - 1]) / (key[after] - key[after - 1])),
    }
}

/// Interpolates two colours, linearly in HSV with the hue on the shorter way round. A grey has no
/// hue and takes that of the other colour.
fn color(a: DVec3, b: DVec3, s: f64) -> DVec3 {
    let (mut a, mut b) = (hsv(a), hsv(b));
    if a.y == 0.0 {
        a.x = b.x;
    }
    if b.y == 0.0 {
        b.x = a.x;
    }
    let mut turn = b.x - a.x;
    if turn > 3.0 {
        turn -= 6.0;
    } else if turn < -3.0 {
        turn += 6.0;
    }
    rgb(DVec3::new(a.x + turn * s, a.y + (b.y - a.y) * s, a.z + (b.z - a.z) * s))
}

/// Returns hue in sixths of the circle [0,6), saturation, value.
fn hsv(c: DVec3) -> DVec3 {
    let (max, min) = (c.max_element(), c.min_element());
    let delta = max - min;
    let hue = if delta == 0.0 {
        0.0
    } else if c.x == max {
        (c.y - c.z) / delta
    } else if c.y == max {
        2.0 + (c.z - c.x) / delta
    } else {
        4.0 + (c.x - c.y) / delta
    };
    let saturation = if max == 0.0 { 0.0 } else { delta / max };
    DVec3::new(if hue < 0.0 { hue + 6.0 } else { hue }, saturation, max)
}

/// Returns the colour of a hue (any number of turns), saturation, value.
fn rgb(hsv: DVec3) -> DVec3 {
    let hue = hsv.x - 6.0 * libm::floor(hsv.x / 6.0);
    // Distance from the channel's own hue: full within one sixth, zero beyond two.
    let channel = |own: f64| {
        let away = (hue - own).abs();
        let away = if away > 3.0 { 6.0 - away } else { away };
        let share = (2.0 - away).clamp(0.0, 1.0);
        hsv.z * (1.0 - hsv.y * (1.0 - share))
    };
    DVec3::new(channel(0.0), channel(2.0), channel(4.0))
}

/// Returns the unit quaternion of an X3D rotation: axis x y z, angle in radians. A zero axis gives
/// the identity.
fn quaternion(r: &[f64]) -> DQuat {
    let Some(axis) = fbptr_core::math::matrix::unit(triple(r)) else { return DQuat::IDENTITY };
    let (sin, cos) = libm::sincos(r[3] / 2.0);
    DQuat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos)
}

/// Interpolates two rotations on the shorter way along the unit sphere; returns axis and angle.
fn orientation(a: &[f64], b: &[f64], s: f64) -> [f64; 4] {
    let (p, mut q) = (quaternion(a), quaternion(b));
    let mut cos = dot(p, q);
    if cos < 0.0 {
        q = DQuat::from_xyzw(-q.x, -q.y, -q.z, -q.w);
        cos = -cos;
    }
    // The angle is taken from both sine and cosine, so that nearly equal rotations keep their
    // precision.
    let difference = DQuat::from_xyzw(q.x - cos * p.x, q.y - cos * p.y, q.z - cos * p.z, q.w - cos * p.w);
    let sin = dot(difference, difference).sqrt();
    let angle = libm::atan2(sin, cos);
    let (wp, wq) = if sin < 1e-12 {
        (1.0 - s, s)
    } else {
        (libm::sin((1.0 - s) * angle) / sin, libm::sin(s * angle) / sin)
    };
    let at = |a: f64, b: f64| wp * a + wq * b;
    let (x, y, z, w) = (at(p.x, q.x), at(p.y, q.y), at(p.z, q.z), at(p.w, q.w));
    let length = (x * x + y * y + z * z).sqrt();
    if length == 0.0 {
        return [0.0, 0.0, 1.0, 0.0];
    }
    [x / length, y / length, z / length, 2.0 * libm::atan2(length, w)]
}

/// Interpolates two directions along the great circle through both; returns a unit vector. Opposite
/// directions define no great circle: the nearer one is returned. A zero vector takes the other's
/// direction.
fn normal(a: DVec3, b: DVec3, s: f64) -> DVec3 {
    let unit = fbptr_core::math::matrix::unit;
    let (a, b) = match (unit(a), unit(b)) {
        (Some(a), Some(b)) => (a, b),
        (a, b) => return a.or(b).unwrap_or(DVec3::Z),
    };
    // The angle is taken from both sine and cosine, so that nearly equal directions keep their
    // precision.
    let (sin, cos) = (a.cross(b).length(), a.dot(b));
    if sin < 1e-12 {
        return if s < 0.5 { a } else { b };
    }
    let angle = libm::atan2(sin, cos);
    (a * libm::sin((1.0 - s) * angle) + b * libm::sin(s * angle)) / sin
}

fn dot(p: DQuat, q: DQuat) -> f64 {
    p.x * q.x + p.y * q.y + p.z * q.z + p.w * q.w
}

/// Curve of a SplinePositionInterpolator: piecewise cubic Hermite.
struct Spline<'a> {
    key: &'a [f64],
    points: &'a [DVec3],
    velocities: &'a [DVec3],
    is_closed: bool,
    normalize: bool,
}

impl Spline<'_> {
    /// Returns the point at 0 < s < 1 of piece i.
    ///
    /// v(s) = (2s^3 - 3s^2 + 1) v_i + (-2s^3 + 3s^2) v_{i+1} + (s^3 - 2s^2 + s) T0_i + (s^3 - s^2)
    /// T1_{i+1}
    fn at(&self, i: usize, s: f64) -> DVec3 {
        let (s2, s3) = (s * s, s * s * s);
        self.points[i] * (2.0 * s3 - 3.0 * s2 + 1.0)
            + self.points[i + 1] * (3.0 * s2 - 2.0 * s3)
            + self.tangents(i)[0] * (s3 - 2.0 * s2 + s)
            + self.tangents(i + 1)[1] * (s3 - s2)
    }

    /// Returns whether the curve is closed: its last point equals the first, and no velocities are
    /// given.
    fn runs_round(&self) -> bool {
        let n = self.points.len();
        self.is_closed && n > 2 && self.velocities.is_empty() && self.points[0] == self.points[n - 1]
    }

    /// Returns T0_i and T1_i: the velocity at key i, scaled for unevenly spaced keys.
    ///
    /// F+_i = 2 (t_i - t_{i-1}) / (t_{i+1} - t_{i-1}), F-_i = 2 (t_{i+1} - t_i) / (t_{i+1} -
    /// t_{i-1}), T0_i = F+_i T_i, T1_i = F-_i T_i.
    fn tangents(&self, i: usize) -> [DVec3; 2] {
        let (n, t) = (self.points.len(), self.key);
        let velocity = self.velocity(i);
        let is_end = i == 0 || i == n - 1;
        let (before, after) = match is_end {
            true if self.runs_round() => (t[n - 1] - t[n - 2], t[1] - t[0]),
            true => return [velocity, velocity],
            false => (t[i] - t[i - 1], t[i + 1] - t[i]),
        };
        let whole = before + after;
        if whole <= 0.0 {
            return [velocity, velocity];
        }
        [velocity * (2.0 * before / whole), velocity * (2.0 * after / whole)]
    }

    /// Returns T_i: the given keyVelocity (one per key, or for the two ends), else half the vector
    /// from the key before to the key after.
    fn velocity(&self, i: usize) -> DVec3 {
        let n = self.points.len();
        let given = match self.velocities.len() {
            count if count == n => Some(self.velocities[i]),
            2 if i == 0 => Some(self.velocities[0]),
            2 if i == n - 1 => Some(self.velocities[1]),
            _ => None,
        };
        match given {
            Some(velocity) if self.normalize => {
                let total: f64 = self.points.windows(2).map(|w| w[0].distance(w[1])).sum();
                fbptr_core::math::matrix::unit(velocity).map_or(DVec3::ZERO, |unit| unit * total)
            }
            Some(velocity) => velocity,
            None if i > 0 && i < n - 1 => (self.points[i + 1] - self.points[i - 1]) / 2.0,
            None if self.runs_round() => (self.points[1] - self.points[n - 2]) / 2.0,
            None => DVec3::ZERO,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn close(a: &[f64], b: &[f64]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} is not {b:?}");
    }

    #[test]
    fn keys_hold_their_values_and_equal_keys_jump() {
        let key = [0.0, 0.5, 0.5, 1.0];
        assert_eq!(span(&key, -1.0), Span::At(0));
        assert_eq!(span(&key, 0.0), Span::At(0));
        assert_eq!(span(&key, 0.25), Span::Between(0, 0.5));
        assert_eq!(span(&key, 0.5), Span::At(2));
        assert_eq!(span(&key, 0.75), Span::Between(2, 0.5));
        assert_eq!(span(&key, 2.0), Span::At(3));
    }

    #[test]
    fn colours_go_round_the_hue_the_shorter_way() {
        let (red, green, blue) = (DVec3::X, DVec3::Y, DVec3::Z);
        close(&color(red, green, 0.5).to_array(), &[1.0, 1.0, 0.0]);
        close(&color(red, blue, 0.5).to_array(), &[1.0, 0.0, 1.0]);
        close(&color(blue, red, 0.25).to_array(), &[0.5, 0.0, 1.0]);
        close(&color(DVec3::ONE, blue, 0.5).to_array(), &[0.5, 0.5, 1.0]);
        close(&color(DVec3::new(0.2, 0.4, 0.1), DVec3::ZERO, 0.0).to_array(), &[0.2, 0.4, 0.1]);
        for c in
            [red, green, blue, DVec3::ONE, DVec3::ZERO, DVec3::new(0.3, 0.7, 0.2), DVec3::new(0.9, 0.1, 0.4)]
        {
            close(&rgb(hsv(c)).to_array(), &c.to_array());
        }
    }

    #[test]
    fn rotations_take_the_shorter_way() {
        close(&orientation(&[0.0, 1.0, 0.0, 0.0], &[0.0, 1.0, 0.0, PI], 0.5), &[0.0, 1.0, 0.0, FRAC_PI_2]);
        close(&orientation(&[0.0, 2.0, 0.0, 0.2], &[0.0, 3.0, 0.0, 0.6], 0.25), &[0.0, 1.0, 0.0, 0.3]);
        // From 0 to 3/2 turns about z is a quarter turn the other way.
        close(
            &orientation(&[0.0, 0.0, 1.0, 0.0], &[0.0, 0.0, 1.0, 1.5 * PI], 0.5),
            &[0.0, 0.0, -1.0, PI / 4.0],
        );
        close(&orientation(&[1.0, 0.0, 0.0, 0.7], &[1.0, 0.0, 0.0, 0.7], 0.5), &[1.0, 0.0, 0.0, 0.7]);
        // A quarter about x and one about y: half way lies between the axes.
        let half = orientation(&[1.0, 0.0, 0.0, FRAC_PI_2], &[0.0, 1.0, 0.0, FRAC_PI_2], 0.5);
        assert!((half[0] - half[1]).abs() < 1e-15 && half[2].abs() < 1e-15, "{half:?}");
    }

    #[test]
    fn normals_run_along_the_great_circle() {
        let third = normal(DVec3::X * 2.0, DVec3::Y, 1.0 / 3.0);
        close(&third.to_array(), &[0.75_f64.sqrt(), 0.5, 0.0]);
        let half = normal(DVec3::X, DVec3::new(-1.0, 0.0, 1e-3), 0.5);
        assert!((half.length() - 1.0).abs() < 1e-9 && half.z > 0.99, "{half}");
        assert_eq!(normal(DVec3::X, DVec3::NEG_X, 0.25), DVec3::X);
        assert_eq!(normal(DVec3::X, DVec3::NEG_X, 0.75), DVec3::NEG_X);
        assert_eq!(normal(DVec3::ZERO, DVec3::Y, 0.1), DVec3::Y);
        assert_eq!(normal(DVec3::Y, DVec3::Y * 5.0, 0.3), DVec3::Y);
    }

    #[test]
    fn a_spline_meets_its_keys_and_bends_between_them() {
        let points = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)];
        let spline = Spline {
            key: &[0.0, 0.5, 1.0],
            points: &points,
            velocities: &[],
            is_closed: false,
            normalize: false,
        };
        // Piece 0 at s = 1/2: (v0 + v1)/2 + T0_0/8 - T1_1/8, with T_0 = 0 and T_1 = (v2 - v0)/2 =
        // (0.5, 0.5, 0).
        close(&spline.at(0, 0.5).to_array(), &[0.5 - 0.0625, -0.0625, 0.0]);
        let uneven = Spline { key: &[0.0, 0.25, 1.0], ..spline };
        // F-_1 = 2 * 0.75 / 1, F+_1 = 2 * 0.25 / 1.
        close(&uneven.tangents(1)[1].to_array(), &[0.75, 0.75, 0.0]);
        close(&uneven.tangents(1)[0].to_array(), &[0.25, 0.25, 0.0]);
        let given = Spline { velocities: &[DVec3::Y, DVec3::ZERO], ..spline };
        close(&given.at(0, 0.5).to_array(), &[0.5 - 0.0625, 0.125 - 0.0625, 0.0]);
        let normalized = Spline { normalize: true, ..given };
        close(&normalized.velocity(0).to_array(), &[0.0, 2.0, 0.0]);
        let round = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ZERO];
        let key = [0.0, 0.3, 0.6, 1.0];
        let closed = Spline { key: &key, points: &round, is_closed: true, ..spline };
        close(&closed.velocity(0).to_array(), &[0.5, -0.5, 0.0]);
        assert_eq!(closed.velocity(0), closed.velocity(3));
    }
}

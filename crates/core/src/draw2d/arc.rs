//! Parts of rings between two directions, with exact coverage: arcs of any width, slices of a pie.
//!
//! The exact answer: pixel (i,j) is lit when its centre is at least `inner` and less than `outer`
//! from (cx, cy), in a direction from `from` up to but without `to`. Directions turn from the x
//! axis towards the y axis, clockwise on the screen. An angle means the vector of its cosine and
//! sine in f64, exact at multiples of a right angle; on which side of that vector a centre lies is
//! the sign of a cross product, decided in integers wherever rounding could change it. So rings and
//! sectors that share a border share no pixel and leave none out.

use super::band::{Band, on_all_rows};
use super::blend::Paint;
use super::disc::Disc;
use super::row_search::{both, half_row, join, sign_of_sum};
use super::{Blend, DrawError};
use crate::math::coverage::exact_int::parts;
use crate::memory::{Rgba, VideoMemory};
use num_bigint::BigInt;
use std::cmp::Ordering;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::ops::Range;

/// A part of a ring: between two radii and two directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arc {
    /// Centre, in pixels.
    pub center: [f64; 2],
    /// Inner and outer radius, in pixels; with an inner radius of 0 it is a slice of a disc.
    pub radii: [f64; 2],
    /// The two directions in radians, from the x axis towards the y axis. The arc goes from the
    /// smaller angle up to the greater one; a whole turn or more is the whole ring.
    pub angles: [f64; 2],
}

/// Lights the pixels whose centres are in the part of a ring.
///
/// The cost is that of the visible rows and pixels. Numbers that are not finite draw nothing. A
/// negative radius is an error.
pub fn arc(memory: &mut VideoMemory, arc: Arc, color: Rgba, blend: Blend) -> Result<(), DrawError> {
    on_all_rows(memory, |band| arc_on(band, arc, color, blend))
}

/// Does what [`arc`] does within a band.
pub(super) fn arc_on(band: &mut Band<'_>, arc: Arc, color: Rgba, blend: Blend) -> Result<(), DrawError> {
    let Arc { center: centre, radii, angles } = arc;
    if let Some(&r) = radii.iter().find(|r| **r < 0.0) {
        return Err(DrawError::NegativeRadius { r: r.into() });
    }
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    if ![centre, radii, angles].as_flattened().iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    let clip = band.clip();
    let [inner, outer] = radii.map(|r| Disc::new(centre, r));
    let sector = Sector::new(centre, angles);
    for y in outer.rows(clip.y0..clip.y1) {
        let ring = outer.row(y, clip.x0..clip.x1);
        if ring.is_empty() {
            continue;
        }
        let hole = inner.row(y, clip.x0..clip.x1);
        let parts = match hole.is_empty() {
            true => [ring, 0..0],
            false => [ring.start..hole.start, hole.end..ring.end],
        };
        for side in sector.row(y, clip.x0..clip.x1) {
            for part in parts.iter().map(|part| both(part, &side)).filter(|part| !part.is_empty()) {
                paint.run(band.run_mut(y, part));
                band.mark_row(y as u32);
            }
        }
    }
    Ok(())
}

/// Relation of a sector's two borders.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Opening {
    /// All directions.
    Whole,
    /// Less than half a turn: behind the first border and before the second.
    Narrow,
    /// Half a turn: the borders are opposite.
    Half,
    /// More than half a turn: behind the first border or before the second.
    Wide,
}

/// The directions from one angle up to another.
struct Sector {
    centre: [f64; 2],
    borders: [[f64; 2]; 2],
    opening: Opening,
}

impl Sector {
    fn new(centre: [f64; 2], angles: [f64; 2]) -> Self {
        let [from, to] = [angles[0].min(angles[1]), angles[0].max(angles[1])];
        let borders @ [u, v] = [from, to].map(direction);
        let sweep = to - from;
        let opening = if sweep >= TAU {
            Opening::Whole
        } else if sweep < FRAC_PI_2 {
            Opening::Narrow
        } else if sweep > PI + FRAC_PI_2 {
            Opening::Wide
        } else {
            match cross_sign(u, v) {
                Ordering::Greater => Opening::Narrow,
                Ordering::Equal => Opening::Half,
                Ordering::Less => Opening::Wide,
            }
        };
        Sector { centre, borders, opening }
    }

    /// Returns the pixels of row `y` in these directions: runs in order that do not touch.
    fn row(&self, y: i32, xs: Range<i32>) -> Vec<Range<i32>> {
        if self.opening == Opening::Whole {
            return vec![xs];
        }
        let [u, v] = self.borders;
        // u x (p - c) grows with x where u points up.
        let behind =
            half_row(xs.clone(), self.crossing(u, y), u[1] < 0.0, |x| self.side(u, x, y) != Ordering::Less);
        let before =
            half_row(xs.clone(), self.crossing(v, y), v[1] > 0.0, |x| self.side(v, x, y) == Ordering::Less);
        let mut runs = match self.opening {
            Opening::Narrow => vec![both(&behind, &before)],
            Opening::Wide => vec![behind, before],
            Opening::Whole => vec![xs],
            Opening::Half => {
                // On the line of both borders, the part in the first one's direction.
                let on_line = |x: &i32| self.side(u, *x, y) == Ordering::Equal && self.is_ahead(u, *x, y);
                let ends = [behind.start, behind.end - 1];
                let mut on_border: Vec<_> = ends.into_iter().filter(on_line).map(|x| x..x + 1).collect();
                if u[1] == 0.0 {
                    // In its own row the border is a run.
                    on_border =
                        vec![half_row(xs, self.centre[0] - 0.5, u[0] > 0.0, |x| self.is_ahead(u, x, y))];
                    on_border.retain(|run| !run.is_empty() && on_line(&run.start) && on_line(&(run.end - 1)));
                }
                on_border.push(before);
                on_border
            }
        };
        join(&mut runs);
        runs
    }

    /// Returns about the column where a border's line meets row `y`.
    fn crossing(&self, u: [f64; 2], y: i32) -> f64 {
        self.centre[0] + (f64::from(y) + 0.5 - self.centre[1]) * u[0] / u[1] - 0.5
    }

    /// Returns the sign of u x (p - c) for the centre p of pixel (x, y). The centre of the sector
    /// counts as lying in the direction of the x axis.
    fn side(&self, u: [f64; 2], x: i32, y: i32) -> Ordering {
        let p = self.offset(x, y);
        let products = ([u[0], p[1]], [-u[1], p[0]]);
        if p == [0.0, 0.0] {
            return (-u[1]).partial_cmp(&0.0).unwrap_or(Ordering::Equal);
        }
        sign_of_sum(products.0, products.1)
            .unwrap_or_else(|| exact_side(u, [self.exact_offset(x, 0), self.exact_offset(y, 1)]))
    }

    /// Returns whether the pixel on a border's line is in the border's direction, not opposite.
    fn is_ahead(&self, u: [f64; 2], x: i32, y: i32) -> bool {
        let p = self.offset(x, y);
        let p = if p == [0.0, 0.0] { [1.0, 0.0] } else { p };
        // The signs alone: on the line, both are parallel.
        if u[0].abs() >= u[1].abs() { (u[0] > 0.0) == (p[0] > 0.0) } else { (u[1] > 0.0) == (p[1] > 0.0) }
    }

    fn offset(&self, x: i32, y: i32) -> [f64; 2] {
        [f64::from(x) + 0.5 - self.centre[0], f64::from(y) + 0.5 - self.centre[1]]
    }

    /// Returns v + 1/2 - c along an axis, as an integer times a power of two.
    fn exact_offset(&self, v: i32, axis: usize) -> (BigInt, i32) {
        let (mantissa, exponent) = parts(self.centre[axis]);
        let unit = exponent.min(-1);
        let half_odd = BigInt::from(2 * i64::from(v) + 1) << (-1 - unit).unsigned_abs();
        (half_odd - (BigInt::from(mantissa) << (exponent - unit).unsigned_abs()), unit)
    }
}

/// Returns the sign of u x p, exactly.
fn exact_side(u: [f64; 2], [px, py]: [(BigInt, i32); 2]) -> Ordering {
    let product =
        |a: f64, (b, exponent): &(BigInt, i32)| (BigInt::from(parts(a).0) * b, parts(a).1 + exponent);
    let (p, q) = (product(u[0], &py), product(u[1], &px));
    let unit = p.1.min(q.1);
    (p.0 << (p.1 - unit).unsigned_abs()).cmp(&(q.0 << (q.1 - unit).unsigned_abs()))
}

/// Returns the sign of u x v for two directions.
fn cross_sign(u: [f64; 2], v: [f64; 2]) -> Ordering {
    let exact = |a: f64| (BigInt::from(parts(a).0), parts(a).1);
    sign_of_sum([u[0], v[1]], [-u[1], v[0]]).unwrap_or_else(|| exact_side(u, v.map(exact)))
}

/// Returns the vector of an angle: its cosine and sine, exact at multiples of a right angle.
fn direction(angle: f64) -> [f64; 2] {
    let quarter = (angle / FRAC_PI_2).round();
    if quarter * FRAC_PI_2 == angle {
        let axes = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        return axes[quarter.rem_euclid(4.0) as usize % 4];
    }
    [libm::cos(angle), libm::sin(angle)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{lit, memory, picture};
    use crate::draw2d::{fill_circle, fill_rect};
    use proptest::prelude::*;

    /// Returns numbers as integers in their common unit, a power of two that divides half a pixel.
    fn integers<const N: usize>(numbers: [f64; N]) -> ([BigInt; N], u32) {
        let unit = numbers.iter().map(|v| parts(*v).1).fold(-1, i32::min);
        let scaled = numbers.map(|v| BigInt::from(parts(v).0) << (parts(v).1 - unit).unsigned_abs());
        (scaled, (-1 - unit).unsigned_abs())
    }

    fn sign(v: &BigInt) -> i32 {
        match v.cmp(&BigInt::ZERO) {
            Ordering::Less => -1,
            Ordering::Equal => 0,
            Ordering::Greater => 1,
        }
    }

    /// Turns counted from a vector on: 0 in its direction, then 1 in the half turn after it, 2
    /// opposite, 3 in the half turn before it.
    fn quarter(u: &[BigInt; 2], p: &[BigInt; 2]) -> i32 {
        let cross = sign(&(&u[0] * &p[1] - &u[1] * &p[0]));
        let dot = sign(&(&u[0] * &p[0] + &u[1] * &p[1]));
        match (cross, dot) {
            (0, 1) => 0,
            (1, _) => 1,
            (0, _) => 2,
            _ => 3,
        }
    }

    /// Decides a pixel from the definition, in integers, by the order of directions about the
    /// centre.
    fn truth(arc: Arc, x: i32, y: i32) -> bool {
        let ([cx, cy, inner, outer], half_bits) =
            integers([arc.center[0], arc.center[1], arc.radii[0], arc.radii[1]]);
        let centre = |v: i32| BigInt::from(2 * v + 1) << half_bits;
        let p = [centre(x) - cx, centre(y) - cy];
        let square = &p[0] * &p[0] + &p[1] * &p[1];
        let [inner, outer] = [&inner * &inner, &outer * &outer];
        if square < inner || square >= outer {
            return false;
        }
        let (from, to) = (arc.angles[0].min(arc.angles[1]), arc.angles[0].max(arc.angles[1]));
        if to - from >= TAU {
            return true;
        }
        let p = if p == [BigInt::ZERO, BigInt::ZERO] { [BigInt::from(1), BigInt::ZERO] } else { p };
        let [u, v] = [from, to].map(|angle| integers(direction(angle)).0);
        // Both as seen from the first border; within the same half turn the cross product decides.
        let (of_p, of_v) = (quarter(&u, &p), quarter(&u, &v));
        let is_all = to - from > PI + FRAC_PI_2;
        match (of_p, of_v) {
            (0, 0) => is_all,
            (_, 0) => is_all,
            (a, b) if a != b => a < b,
            _ => sign(&(&p[0] * &v[1] - &p[1] * &v[0])) > 0,
        }
    }

    fn check(figure: Arc) {
        let mut m = memory(13, 9);
        arc(&mut m, figure, [255, 255, 255, 100], Blend::Over).unwrap();
        let all = (0..9).flat_map(|y| (0..13).map(move |x| (x, y)));
        let want: Vec<_> = all.filter(|&(x, y)| truth(figure, x, y)).collect();
        assert_eq!(lit(&m, 100), want, "{figure:?}");
    }

    fn place() -> impl Strategy<Value = f64> {
        prop_oneof![
            4 => (-8..30i32).prop_map(|v| f64::from(v) / 2.0),
            4 => -4.0..16.0,
            1 => -1e6..1e6,
            1 => (-1.0..1.0, -320..308i32).prop_map(|(m, e): (f64, i32)| m * 10f64.powi(e)),
        ]
    }

    fn radius() -> impl Strategy<Value = f64> {
        prop_oneof![3 => (0..24i32).prop_map(|v| f64::from(v) / 2.0), 3 => 0.0..14.0, 1 => place().prop_map(f64::abs)]
    }

    fn angle() -> impl Strategy<Value = f64> {
        prop_oneof![
            3 => (-9..9i32).prop_map(|v| f64::from(v) * FRAC_PI_2),
            3 => (-24..24i32).prop_map(|v| (f64::from(v) * 15.0).to_radians()),
            4 => -7.0..7.0,
            1 => -1e4..1e4,
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 800, ..ProptestConfig::default() })]

        #[test]
        fn every_arc_is_its_definition(
            centre in [place(), place()], radii in [radius(), radius()], angles in [angle(), angle()],
        ) {
            check(Arc { center: centre, radii, angles });
        }

        #[test]
        fn slices_of_a_pie_share_no_pixel_and_leave_none_out(
            centre in [place(), place()], r in radius(), mut cuts in prop::collection::vec(0.0..TAU, 1..5), right: bool,
        ) {
            if right {
                cuts = cuts.iter().map(|c| (c / FRAC_PI_2).round() * FRAC_PI_2).collect();
            }
            cuts.sort_by(f64::total_cmp);
            let last = cuts[0] + TAU;
            cuts.push(last);
            let mut pie = memory(13, 9);
            let mut whole = memory(13, 9);
            // Alpha 100 over black is red 100: lit twice, it would be more.
            for pair in cuts.windows(2) {
                let figure = Arc { center: centre, radii: [0.0, r], angles: [pair[0], pair[1]] };
                arc(&mut pie, figure, [255, 255, 255, 100], Blend::Over).unwrap();
            }
            fill_circle(&mut whole, centre, r, [255, 255, 255, 100], Blend::Over).unwrap();
            // The last border is the first one up to the rounding of a whole turn.
            if right || cuts.len() == 2 {
                prop_assert_eq!(pie.bytes(), whole.bytes());
            }
        }
    }

    #[test]
    fn a_half_turn_has_one_of_its_two_borders() {
        for quarter in 0..4 {
            let angles = [f64::from(quarter), f64::from(quarter + 2)].map(|q| q * FRAC_PI_2);
            for centre in [[6.5, 4.5], [6.0, 4.0], [6.5, 4.0], [6.25, 4.5]] {
                check(Arc { center: centre, radii: [0.0, 4.0], angles });
                check(Arc { center: centre, radii: [2.0, 4.0], angles: [angles[1], angles[0]] });
            }
        }
    }

    #[test]
    fn negative_radii_are_refused_and_odd_numbers_draw_nothing() {
        let mut m = memory(5, 5);
        m.take_damage();
        let good = Arc { center: [2.0; 2], radii: [1.0, 2.0], angles: [0.0, 1.0] };
        for radii in [[-1.0, 2.0], [1.0, -2.0]] {
            let refused = arc(&mut m, Arc { radii, ..good }, [255; 4], Blend::Replace).unwrap_err();
            assert_eq!(refused.code().as_str(), "ERANGE");
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for figure in [
                Arc { center: [bad, 2.0], ..good },
                Arc { radii: [0.0, bad.abs()], ..good },
                Arc { angles: [0.0, bad], ..good },
            ] {
                arc(&mut m, figure, [255; 4], Blend::Replace).unwrap();
            }
        }
        // A ring whose inside is not smaller than its outside, an arc without directions.
        arc(&mut m, Arc { radii: [2.0, 2.0], ..good }, [255; 4], Blend::Replace).unwrap();
        arc(&mut m, Arc { angles: [1.0, 1.0], ..good }, [255; 4], Blend::Replace).unwrap();
        assert!(!m.is_damaged());
        fill_rect(&mut m, [0, 0, 1, 1], [1; 4], Blend::Replace).unwrap();
        assert!(m.is_damaged());
    }

    #[test]
    fn three_quarters_of_a_ring_look_like_this() {
        let mut m = memory(13, 10);
        let angles = [0.0, 3.0 * FRAC_PI_2];
        arc(&mut m, Arc { center: [6.5, 5.0], radii: [2.5, 4.5], angles }, [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), RING);
    }

    const RING: &str = "
.............
....##.......
...###.......
..###........
..##.........
..##.....##..
..###...###..
...#######...
....#####....
.............";
}

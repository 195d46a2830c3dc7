//! Cubic Bezier curves of any width with round ends.
//!
//! The exact answer: the four points are rounded to 1/256 pixel, ties to even, as the corners of
//! [`fill`](super::fill) are. The curve is drawn as the polyline through its points at t = 0, 1/n,
//! ..., 1, each rounded to 1/256 pixel (half up). n is the least power of two with n^2 >= 12 m,
//! where m is the greatest absolute coordinate of P0 - 2 P1 + P2 and P1 - 2 P2 + P3 in pixels: then
//! no point of the curve is 0.1 pixel from the polyline (|B''| <= 6 m sqrt 2, and a chord of 1/n is
//! off by at most |B''| / 8 n^2) beside the rounding. A pixel is lit when its centre is nearer than
//! w/2 to one of the segments, which [`Stroke`] decides exactly; each is lit once.

use super::band::{Band, on_all_rows};
use super::blend::Paint;
use super::row_search::join;
use super::wide_line::Stroke;
use super::{Blend, DrawError};
use crate::memory::{Rgba, VideoMemory};

/// Largest absolute coordinate of a curve's points, in pixels: with it, n is at most 8192 and all
/// sums fit 128 bits.
pub const FAR_POINT: i32 = 1 << 20;

/// Units in a pixel.
const UNITS: i64 = 256;

/// Draws the cubic Bezier curve of four points, `width` pixels wide, with round ends.
///
/// The cost is that of the visible rows and of the curve's steps. Numbers that are not finite draw
/// nothing. A negative width, or a point beyond [`FAR_POINT`], is an error.
pub fn bezier(
    memory: &mut VideoMemory,
    points: [[f64; 2]; 4],
    width: f64,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    on_all_rows(memory, |band| bezier_on(band, points, width, color, blend))
}

/// Does what [`bezier`] does within a band.
pub(super) fn bezier_on(
    band: &mut Band<'_>,
    points: [[f64; 2]; 4],
    width: f64,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    if width < 0.0 {
        return Err(DrawError::NegativeWidth { w: width.into() });
    }
    if !points.as_flattened().iter().chain([&width]).all(|v| v.is_finite()) {
        return Ok(());
    }
    if let Some(&at) = points.as_flattened().iter().find(|v| v.abs() > f64::from(FAR_POINT)) {
        return Err(DrawError::FarPoint { most: FAR_POINT, at: at.into() });
    }
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    let clip = band.clip();
    let ys = clip.y0..clip.y1;
    let chain = polyline(points);
    let strokes: Vec<_> = chain
        .windows(2)
        .map(|ends| Stroke::new(ends[0], ends[1], width))
        .map(|stroke| (stroke.rows(ys.clone()), stroke))
        .filter(|(rows, _)| !rows.is_empty())
        .collect();
    let mut runs = Vec::new();
    for y in ys {
        for (_, stroke) in strokes.iter().filter(|(rows, _)| rows.contains(&y)) {
            let run = stroke.row(y, clip.x0..clip.x1);
            let is_whole = run == (clip.x0..clip.x1);
            runs.push(run);
            // The other strokes have nothing to add.
            if is_whole {
                break;
            }
        }
        join(&mut runs);
        for xs in runs.drain(..) {
            paint.run(band.run_mut(y, xs));
            band.mark_row(y as u32);
        }
    }
    Ok(())
}

/// Returns the number of steps that a curve is drawn in, 8192 at most.
pub fn bezier_steps(points: &[[f64; 2]; 4]) -> u64 {
    steps(&snap(points)).unsigned_abs()
}

/// Returns the points in units of 1/256 pixel, at most 2^28 of them.
fn snap(points: &[[f64; 2]; 4]) -> [[i64; 2]; 4] {
    let far = f64::from(FAR_POINT);
    let snapped = |v: f64| (v.clamp(-far, far) * UNITS as f64).round_ties_even() as i64;
    points.map(|point| point.map(snapped))
}

/// Returns n.
fn steps(p: &[[i64; 2]; 4]) -> i64 {
    let bend = |i: usize, axis: usize| (p[i][axis] - 2 * p[i + 1][axis] + p[i + 2][axis]).abs();
    let most = (0..2).flat_map(|i| (0..2).map(move |axis| (i, axis))).map(|(i, axis)| bend(i, axis)).max();
    let most = most.unwrap_or(0);
    let mut n: i64 = 1;
    while n * n * UNITS < 12 * most {
        n *= 2;
    }
    n
}

/// Returns the points of a curve at t = 0, 1/n, ..., 1, rounded to 1/256 pixel.
fn polyline(points: [[f64; 2]; 4]) -> Vec<[f64; 2]> {
    let p = snap(&points);
    let n = steps(&p);
    let at = |k: i64, axis: usize| {
        // Bernstein's polynomials, times n^3: below 2^39 each.
        let (s, t) = (i128::from(n - k), i128::from(k));
        let weights = [s * s * s, 3 * s * s * t, 3 * s * t * t, t * t * t];
        let sum: i128 = weights.iter().zip(p).map(|(w, point)| w * i128::from(point[axis])).sum();
        let cube = i128::from(n).pow(3);
        (2 * sum + cube).div_euclid(2 * cube) as f64 / UNITS as f64
    };
    (0..=n).map(|k| [at(k, 0), at(k, 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{lit, memory, picture};
    use crate::draw2d::wide_line;
    use crate::draw2d::wide_line::tests::is_near;
    use num_bigint::BigInt;
    use num_integer::Integer;
    use proptest::prelude::*;

    /// Returns the polyline by de Casteljau's construction in integers, in units of 1/256 pixel.
    fn casteljau(points: [[f64; 2]; 4]) -> Vec<[BigInt; 2]> {
        let snapped = points.map(|q| q.map(|v| BigInt::from((v * 256.0).round_ties_even() as i64)));
        let second =
            |i: usize, a: usize| &snapped[i][a] - BigInt::from(2) * &snapped[i + 1][a] + &snapped[i + 2][a];
        let most = [second(0, 0), second(0, 1), second(1, 0), second(1, 1)].map(|v| v.magnitude().clone());
        let most = BigInt::from(most.into_iter().max().unwrap());
        let is_enough = |n: &i64| BigInt::from(*n) * *n * 256 >= &most * 12;
        let steps = (0..14).map(|e| 1i64 << e).find(is_enough).unwrap();
        let n = BigInt::from(steps);
        (0..=steps)
            .map(|k| {
                // Each level is n times as large as the one before.
                let (s, t) = (&n - BigInt::from(k), BigInt::from(k));
                let mut level = snapped.to_vec();
                while level.len() > 1 {
                    let between = |w: &[[BigInt; 2]]| [0, 1].map(|a| &w[0][a] * &s + &w[1][a] * &t);
                    level = level.windows(2).map(between).collect();
                }
                let cube: BigInt = &n * &n * &n;
                level.remove(0).map(|v| Integer::div_floor(&(v * 2 + &cube), &(&cube * 2)))
            })
            .collect()
    }

    fn check(points: [[f64; 2]; 4], width: u32) {
        let mut m = memory(13, 9);
        bezier(&mut m, points, f64::from(width) / 4.0, [255, 255, 255, 100], Blend::Over).unwrap();
        let chain = casteljau(points);
        let width = BigInt::from(width * 64);
        let centre = |v: i32| BigInt::from(256 * v + 128);
        let holds = |&(x, y): &(i32, i32)| {
            chain.windows(2).any(|w| is_near(&[centre(x), centre(y)], &w[0], &w[1], &width))
        };
        let want: Vec<_> = (0..9).flat_map(|y| (0..13).map(move |x| (x, y))).filter(holds).collect();
        assert_eq!(lit(&m, 100), want, "{points:?} {width}");
    }

    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![4 => (-8..30i32).prop_map(|v| f64::from(v) / 2.0), 4 => -6.0..20.0, 1 => -300.0..300.0]
    }

    fn point() -> impl Strategy<Value = [f64; 2]> {
        [coordinate(), coordinate()]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

        #[test]
        fn every_curve_is_its_definition(points in [point(), point(), point(), point()], width in 0..30u32) {
            check(points, width);
        }

        #[test]
        fn the_polyline_is_near_the_curve(points in [point(), point(), point(), point()], t in 0.0..1.0f64) {
            let s = 1.0 - t;
            let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let at = [0, 1].map(|a| (0..4).map(|i| weights[i] * points[i][a]).sum::<f64>());
            let distance = |a: [f64; 2], b: [f64; 2]| {
                let d = [b[0] - a[0], b[1] - a[1]];
                let along = ((at[0] - a[0]) * d[0] + (at[1] - a[1]) * d[1]) / (d[0] * d[0] + d[1] * d[1]);
                let along = if along.is_nan() { 0.0 } else { along.clamp(0.0, 1.0) };
                (at[0] - a[0] - along * d[0]).hypot(at[1] - a[1] - along * d[1])
            };
            let nearest = polyline(points).windows(2).map(|w| distance(w[0], w[1])).fold(f64::INFINITY, f64::min);
            // A tenth of a pixel, and the rounding of the points and of the ends.
            prop_assert!(nearest < 0.1 + 0.006, "{} from {:?}", nearest, points);
        }

        #[test]
        fn a_straight_curve_is_a_wide_line(a in [-8..30i32, -8..30i32], b in [-8..30i32, -8..30i32], width in 1..9u32) {
            let [a, b] = [a, b].map(|p| p.map(|v| f64::from(v) / 2.0));
            let [mut curve, mut line] = [memory(13, 9), memory(13, 9)];
            bezier(&mut curve, [a, a, b, b], width.into(), [255; 4], Blend::Replace).unwrap();
            wide_line(&mut line, a, b, width.into(), [255; 4], Blend::Replace).unwrap();
            let differing = curve.bytes().iter().zip(line.bytes()).filter(|(a, b)| a != b).count();
            // Rounding to 1/256 moves a border over few centres.
            prop_assert!(differing <= 4 * 4, "{} of {:?} {:?}", differing, a, b);
        }
    }

    #[test]
    fn odd_curves_are_refused_or_draw_nothing() {
        let mut m = memory(5, 5);
        m.take_damage();
        let far = [[0.0; 2], [1.5e6, 0.0], [0.0; 2], [4.0; 2]];
        let refused = bezier(&mut m, far, 1.0, [255; 4], Blend::Replace).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "the points of a curve are within 1048576 pixels of (0,0), not at 1500000"
        );
        assert_eq!(refused.code().as_str(), "ERANGE");
        let refused = bezier(&mut m, [[0.0; 2]; 4], -0.5, [255; 4], Blend::Replace).unwrap_err();
        assert_eq!(refused.code().as_str(), "ERANGE");
        for bad in [f64::NAN, f64::INFINITY] {
            bezier(&mut m, [[bad, 0.0]; 4], 1.0, [255; 4], Blend::Replace).unwrap();
            bezier(&mut m, [[1.0; 2]; 4], bad, [255; 4], Blend::Replace).unwrap();
        }
        assert!(!m.is_damaged());
        // The longest curve that is allowed.
        let e = f64::from(FAR_POINT);
        assert_eq!(polyline([[-e, e], [e, -e], [-e, e], [e, -e]]).len(), 8193);
        bezier(&mut m, [[-e, e], [e, -e], [-e, e], [e, -e]], 3.0, [255; 4], Blend::Replace).unwrap();
        assert!(m.is_damaged());
    }

    #[test]
    fn a_curve_looks_like_this() {
        let mut m = memory(20, 9);
        let points = [[2.0, 7.0], [6.0, -4.0], [13.0, 14.0], [17.5, 2.0]];
        bezier(&mut m, points, 2.0, [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), CURVE);
    }

    const CURVE: &str = "
....................
.................#..
....###.........##..
...######.......##..
..###..####....##...
..##.....########...
.##.......######....
.##.................
....................";
}

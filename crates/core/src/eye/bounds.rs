//! Conservative bounds of a facet: the pixels that may see it, and its least distance.
//!
//! In: a facet in eye space. Out: for each screen axis the half-open range of pixels whose fibre
//! may meet the facet's part with x_0 > 0 inside the aperture; never too small, `None` if no pixel
//! sees it.

use super::eye_space::Screen;
use crate::math::nvec::{ROUNDING, dot, unit};

/// Returns the pixels that may see the facet, or `None`.
pub(super) fn pixel_box<const N: usize>(v: &[[f64; N]; N], screen: &Screen<N>) -> Option<[[u32; 2]; N]> {
    let m = screen.centres.len();
    // Slopes x_a / x_0 of the part in front of the eye, then of the part inside each side of the
    // aperture, which is also in front of it.
    let mut slopes = slope_ranges(v, m, v.map(|p| p[0]))?;
    for hidden in m + 1..N {
        for side in [1.0, -1.0] {
            // Slightly wider than the aperture: points on its border are inside.
            let tan = screen.tan[hidden] * (1.0 + 1e-9) + 1e-12;
            let part = slope_ranges(v, m, v.map(|p| tan * p[0] - side * p[hidden]))?;
            for a in 0..m {
                slopes[a] = [slopes[a][0].max(part[a][0]), slopes[a][1].min(part[a][1])];
            }
        }
    }
    let mut pixels = [[0, 1]; N];
    for a in 0..m {
        let centres = &screen.centres[a];
        let n = centres.len() as f64;
        // c(j) = c(0) (n-1-2j)/(n-1) falls with j; the pixel index of slope m is (n - 1 - 2 n m d /
        // S) / 2.
        let index = |slope: f64| {
            let step = if centres.len() > 1 { centres[0] - centres[1] } else { 1.0 };
            (centres[0] - slope * screen.distance) / step
        };
        let (first, last) = (index(slopes[a][1]), index(slopes[a][0]));
        if centres.len() > 1 {
            let margin = |i: f64| 1e-9 * (n + i.abs());
            pixels[a][0] = (first - margin(first)).ceil().clamp(0.0, n) as u32;
            pixels[a][1] = ((last + margin(last)).floor() + 1.0).clamp(0.0, n) as u32;
        }
        if pixels[a][0] >= pixels[a][1] {
            return None;
        }
    }
    Some(pixels)
}

/// Returns the range of x_a / x_0, a = 1..=m, over the part of the simplex with x_0 > 0 and g >= 0,
/// where g is the linear function with values `sides` at the vertices; `None` if the part is empty.
///
/// The part's corners are vertices and points of edges. Where the part reaches x_0 = 0 the slope
/// grows without bound towards the sign of x_a there.
fn slope_ranges<const N: usize>(v: &[[f64; N]; N], m: usize, sides: [f64; N]) -> Option<[[f64; 2]; N]> {
    if v.iter().all(|p| p[0] <= 0.0) || sides.iter().all(|&g| g < 0.0) {
        return None;
    }
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; N];
    let mut include = |p: &[f64; N], wide: f64| {
        for (a, range) in ranges.iter_mut().take(m).enumerate() {
            let (lo, hi) = if p[0] > 0.0 {
                let slope = p[a + 1] / p[0];
                let margin = wide * (1.0 + slope.abs());
                (slope - margin, slope + margin)
            } else {
                let lo = if p[a + 1] > 0.0 { f64::INFINITY } else { f64::NEG_INFINITY };
                (lo, if p[a + 1] < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY })
            };
            *range = [range[0].min(lo), range[1].max(hi)];
        }
    };
    for i in 0..N {
        if sides[i] >= 0.0 && v[i][0] > 0.0 {
            include(&v[i], 0.0);
        }
        for j in i + 1..N {
            edge_corners(&v[i], &v[j], sides[i], sides[j], &mut include);
        }
    }
    Some(ranges)
}

/// Calls `include` for the points of edge p..q at which the linear function or x_0 is 0.
fn edge_corners<const N: usize>(
    p: &[f64; N],
    q: &[f64; N],
    side_p: f64,
    side_q: f64,
    include: &mut impl FnMut(&[f64; N], f64),
) {
    let at = |u: f64| -> [f64; N] { std::array::from_fn(|k| p[k] + u * (q[k] - p[k])) };
    let crosses = |a: f64, b: f64| (a < 0.0) != (b < 0.0) && a != b;
    if crosses(side_p, side_q) {
        let point = at(side_p / (side_p - side_q));
        if point[0] > 0.0 {
            include(&point, 1e-9);
        }
    }
    if (p[0] > 0.0) != (q[0] > 0.0) {
        let u = p[0] / (p[0] - q[0]);
        let mut point = at(u);
        point[0] = 0.0;
        // Coordinates that rounding cannot distinguish from 0 may have either sign.
        for k in 1..N {
            if point[k].abs() <= 1e-12 * (p[k].abs() + q[k].abs()) {
                point[k] = 0.0;
            }
        }
        include(&point, 0.0);
    }
}

/// Returns a lower bound of the facet's distance from the eye: the larger of the distance of its
/// bounding box and that of the plane in front of it that faces its middle. `farthest` is at least
/// the largest length of its vertices.
pub(super) fn nearest<const N: usize>(v: &[[f64; N]; N], farthest: f64) -> f64 {
    let middle = unit(std::array::from_fn(|a| v.iter().map(|p| p[a]).sum()));
    // Without a middle there is no such plane: `max` ignores the NaN.
    (nearest_to_box(v) * (1.0 - 1e-12)).max(along(v, &middle, farthest))
}

/// Returns the least x.direction on the facet, minus a bound on rounding errors. As `direction` is
/// a unit vector, no point is nearer to the eye.
///
/// If a large facet passes close by, its products cancel: the error is relative to `farthest`, not
/// to the result.
#[inline]
pub(super) fn along<const N: usize>(v: &[[f64; N]; N], direction: &[f64; N], farthest: f64) -> f64 {
    v.iter().fold(f64::INFINITY, |least, p| least.min(dot(p, direction)))
        - (4 * N) as f64 * ROUNDING * farthest
}

/// Returns the distance of the facet's bounding box from the eye.
fn nearest_to_box<const N: usize>(v: &[[f64; N]; N]) -> f64 {
    let mut sum = 0.0;
    for a in 0..N {
        let lo = v.iter().fold(f64::INFINITY, |m, p| m.min(p[a]));
        let hi = v.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[a]));
        let gap = lo.max(-hi).max(0.0);
        sum += gap * gap;
    }
    sum.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Returns x.x of the point of the facet with barycentrics `weights` as a fraction, with
    /// numerator and denominator in i128: coordinates are integers times a power of two, so no
    /// product is rounded.
    fn length2(v: &[[i64; 4]; 4], weights: [i64; 4]) -> (i128, i128) {
        let sum: i128 = weights.iter().map(|w| i128::from(*w)).sum();
        let coordinate =
            |a: usize| (0..4).map(|i| i128::from(weights[i]) * i128::from(v[i][a])).sum::<i128>();
        ((0..4).map(coordinate).map(|x| x * x).sum(), sum * sum)
    }

    proptest! {
        /// Large facets that pass close by the eye, and small ones far away: none of their points
        /// is nearer than the bounds.
        #[test]
        fn no_point_is_nearer_than_the_bounds(
            near in prop::array::uniform4(prop::array::uniform4(-40i64..40)),
            shift in 0u32..21,
            axis in 0usize..4,
            depth in 1i64..60,
            weights in prop::array::uniform32(0i64..50),
            direction in prop::array::uniform4(-1.0f64..1.0),
        ) {
            // Spread along all axes but one, along which all of it lies slightly in front of the
            // eye.
            let integers: [[i64; 4]; 4] = std::array::from_fn(|i| {
                std::array::from_fn(|a| if a == axis { depth + near[i][a].rem_euclid(5) } else { near[i][a] << shift })
            });
            let unit_of_length = libm::exp2(-(f64::from(shift) + 6.0));
            let v: [[f64; 4]; 4] = integers.map(|p| p.map(|x| x as f64 * unit_of_length));
            let farthest = v.iter().map(|p| dot(p, p)).fold(0.0, f64::max).sqrt();
            let bounds = [nearest(&v, farthest), along(&v, &unit(direction), farthest)];
            for w in weights.chunks(4) {
                let w = [w[0], w[1], w[2], w[3] + 1];
                let (above, below) = length2(&integers, w);
                for bound in bounds {
                    // bound <= sqrt(above / below), squared in integers of 2^-60.
                    let scaled = (bound.max(0.0) / unit_of_length * libm::exp2(20.0)).floor() as i128;
                    prop_assert!(scaled * scaled * below <= above << 40, "{bound} {v:?} {w:?}");
                }
            }
        }
    }

    /// Returns whether a point of the triangle with x_0 > 0 and no negative value of `sides` lies
    /// in the plane f.x = 0. The plane's part is the hull of vertices and of cuts of edges, and any
    /// multiple of a point will do.
    fn meets(v: &[[i64; 3]; 3], f: [i64; 3], sides: &[[i64; 3]]) -> bool {
        type Point = [i128; 3];
        let at = |g: &[i64; 3], p: &Point| (0..3).map(|k| i128::from(g[k]) * p[k]).sum::<i128>();
        let cuts = |g: &[i64; 3], points: &[Point]| -> Vec<Point> {
            let mut cuts = Vec::new();
            for (p, q) in points.iter().flat_map(|p| points.iter().map(move |q| (p, q))) {
                let (a, b) = (at(g, p), at(g, q));
                if a > 0 && b < 0 {
                    cuts.push(std::array::from_fn(|k| p[k] * -b + q[k] * a));
                }
            }
            cuts
        };
        let corners = v.map(|p| p.map(i128::from));
        let mut in_plane = cuts(&f, &corners);
        in_plane.extend(corners.iter().filter(|p| at(&f, p) == 0));
        let mut ends = in_plane.clone();
        ends.extend(sides.iter().flat_map(|g| cuts(g, &in_plane)));
        ends.iter().any(|p| p[0] > 0 && sides.iter().all(|g| at(g, p) >= 0))
    }

    /// Returns the pixels of screen axis `axis`, of `n`, for which [`meets`] holds: d = 5/4, S = 2,
    /// so that 4n times a pixel's direction is an integer.
    fn pixels_that_meet(v: &[[i64; 3]; 3], axis: usize, n: u32, sides: &[[i64; 3]]) -> Vec<u32> {
        let n = i64::from(n);
        let direction = |j: i64| {
            let mut f = [0; 3];
            (f[0], f[axis + 1]) = (-4 * (n - 1 - 2 * j), 5 * n);
            f
        };
        (0..n).filter(|&j| meets(v, direction(j), sides)).map(|j| j as u32).collect()
    }

    fn screen(pixels: &[u32], tan: [f64; 3]) -> Screen<3> {
        let centre = |n: u32, j: u32| (i64::from(n) - 1 - 2 * i64::from(j)) as f64 / f64::from(n);
        let centres = pixels.iter().map(|&n| (0..n).map(|j| centre(n, j)).collect()).collect();
        Screen { distance: 1.25, centres, tan }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]
        /// Without hidden axes: the box's sides are the first and the last pixel whose plane meets
        /// the part in front of the eye.
        #[test]
        fn a_box_holds_the_pixels_between_the_ends_and_no_more(
            v in prop::array::uniform3(prop::array::uniform3(-12i64..12)),
            before in any::<bool>(),
            pixels in prop::array::uniform2(2u32..40),
        ) {
            let v = if before { v.map(|p| [p[0].abs() + 1, p[1], p[2]]) } else { v };
            // If the eye lies in an edge as seen along an axis, any pixel may be added.
            let holds_the_eye = |axis: usize| {
                (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).any(|(i, j)| {
                    let (p, q) = (v[i], v[j]);
                    p[0] * q[axis + 1] == p[axis + 1] * q[0] && p[0] <= 0 && q[0] >= 0
                        && p[axis + 1] * q[axis + 1] <= 0
                })
            };
            let got = pixel_box(&v.map(|p| p.map(|x| x as f64)), &screen(&pixels, [0.0; 3]));
            let want = [0, 1].map(|axis| pixels_that_meet(&v, axis, pixels[axis], &[]));
            if want.iter().all(|w| !w.is_empty()) {
                let boxed = got.expect("a pixel sees it");
                for (axis, ([low, high], want)) in boxed.into_iter().zip(want).enumerate() {
                    prop_assert!(want.iter().all(|j| (low..high).contains(j)), "{boxed:?} {want:?}");
                    if !holds_the_eye(axis) {
                        prop_assert_eq!((low..high).collect::<Vec<_>>(), want);
                    }
                }
            } else if !holds_the_eye(0) && !holds_the_eye(1) {
                prop_assert_eq!(got, None);
            }
        }

        /// With a hidden axis of tan = 1/2: no pixel that sees the part inside is left out, and in
        /// front of the eye the box is that of the parts inside one side each.
        #[test]
        fn an_aperture_cuts_a_box_down(
            v in prop::array::uniform3(prop::array::uniform3(-12i64..12)),
            before in any::<bool>(),
            n in 2u32..40,
        ) {
            let v = if before { v.map(|p| [p[0].abs() + 1, p[1], p[2]]) } else { v };
            let sides = [[1, 0, -2], [1, 0, 2]];
            let got = pixel_box(&v.map(|p| p.map(|x| x as f64)), &screen(&[n], [0.0, 0.0, 0.5]));
            let boxed: Vec<u32> = got.map_or(Vec::new(), |b| (b[0][0]..b[0][1]).collect());
            let want = pixels_that_meet(&v, 0, n, &sides);
            prop_assert!(want.iter().all(|j| boxed.contains(j)), "{boxed:?} {want:?}");
            if before {
                let by_side = sides.map(|side| pixels_that_meet(&v, 0, n, &[side]));
                let in_both: Vec<u32> =
                    by_side[0].iter().copied().filter(|j| by_side[1].contains(j)).collect();
                prop_assert_eq!(boxed, in_both);
            }
        }

        /// `along` is the least product up to rounding, and `nearest` is at least the distance of
        /// the facet's bounding box.
        #[test]
        fn the_bounds_are_of_use(
            v in prop::array::uniform4(prop::array::uniform4(-40.0f64..40.0)),
            direction in prop::array::uniform4(-1.0f64..1.0),
        ) {
            let farthest = v.iter().map(|p| dot(p, p)).fold(0.0, f64::max).sqrt();
            let direction = unit(direction);
            let least = v.iter().map(|p| dot(p, &direction)).fold(f64::INFINITY, f64::min);
            let bound = along(&v, &direction, farthest);
            prop_assert!(bound <= least && bound >= least - 1e-13 * farthest, "{bound} {least}");
            let gaps = std::array::from_fn::<f64, 4, _>(|a| {
                let (low, high) = (v.map(|p| p[a]).into_iter().fold(f64::INFINITY, f64::min),
                    v.map(|p| p[a]).into_iter().fold(f64::NEG_INFINITY, f64::max));
                if low > 0.0 { low } else if high < 0.0 { -high } else { 0.0 }
            });
            prop_assert!(nearest(&v, farthest) >= dot(&gaps, &gaps).sqrt() * (1.0 - 1e-11));
        }
    }

    #[test]
    fn the_pixel_at_which_a_facet_ends_sees_it_whichever_way_its_place_was_rounded() {
        for n in 2..64 {
            for j in 0..i64::from(n) {
                // Exactly on the direction of pixel j: d = 5/4, S = 2.
                let end = [(5 * i64::from(n)) as f64, (4 * (i64::from(n) - 1 - 2 * j)) as f64];
                let far = 9.0 * end[0];
                let facet = |other: f64| [[end[0], end[1], 0.0], [end[0], other, far], [end[0], other, -far]];
                let columns = |other: f64| {
                    let pixels = pixel_box(&facet(other), &screen(&[n, 2], [0.0; 3])).expect("it is seen");
                    i64::from(pixels[0][0])..i64::from(pixels[0][1])
                };
                let (left, right) = (columns(far), columns(-far));
                assert_eq!((left, right), (0..j + 1, j..i64::from(n)), "{j} of {n}");
            }
        }
    }

    #[test]
    fn a_closed_aperture_shows_what_touches_it() {
        // It stands on h = 0, to either side; and slightly above it.
        let wall = |first: f64, side: f64| {
            let h = [first, first, first + 4.0].map(|h| side * h);
            [[3.0, 9.0, h[0]], [3.0, -9.0, h[1]], [3.0, 0.0, h[2]]]
        };
        let closed = screen(&[5], [0.0; 3]);
        for side in [1.0, -1.0] {
            assert_eq!(pixel_box(&wall(0.0, side), &closed), Some([[0, 5], [0, 1], [0, 1]]));
            assert_eq!(pixel_box(&wall(1e-9, side), &closed), None);
        }
    }

    #[test]
    fn bounds_of_a_smaller_facet_are_smaller_by_as_much() {
        let v = [[0.7, 0.9, -0.3, 0.2], [0.5, -0.8, 0.1, 0.4], [0.9, 0.3, 0.6, -0.7], [0.4, 0.1, -0.5, 0.3]];
        let direction = unit([0.9, 0.1, 0.2, -0.1]);
        let bounds = |v: &[[f64; 4]; 4], farthest| [along(v, &direction, farthest), nearest(v, farthest)];
        let (small, whole) = (libm::exp2(-20.0), bounds(&v, 1.25));
        assert!(whole.iter().all(|b| *b > 0.1), "{whole:?}");
        assert_eq!(bounds(&v.map(|p| p.map(|x| x * small)), 1.25 * small), whole.map(|b| b * small));
    }

    #[test]
    fn a_wall_that_the_eye_nearly_touches_has_no_bound_beyond_it() {
        // x_0 = 2^-30 on all of it, and it extends to 1 on all sides: the products of the slanted
        // direction cancel.
        let near = libm::exp2(-30.0);
        let v = [[near, 1.0, 1.0], [near, -1.0, 0.25], [near, 0.3, -1.0]];
        assert!(nearest(&v, 1.5) <= near);
        for k in 0..200 {
            let turn = f64::from(k) * 1e-11;
            let direction = unit([1.0, turn, -turn]);
            assert!(along(&v, &direction, 1.5) <= near, "{k}");
        }
        // The bound is useful: a wall that faces its middle.
        let far = [[3.0, 1.0, 1.0], [3.0, -1.0, 1.0], [3.0, 0.0, -1.0]];
        assert!(nearest(&far, 3.4) > 2.9);
    }
}

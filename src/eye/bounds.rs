//! Which pixels may see a facet, and how near it can be: conservative boxes.
//!
//! In: a facet in eye space. Out: for each screen axis the half-open range of pixels whose fibre may meet the facet's part with
//! x_0 > 0 inside the aperture; never too small, `None` when no pixel sees it.

use super::frame::Screen;

/// The pixels that may see the facet, or `None`.
pub(super) fn pixel_box<const N: usize>(v: &[[f64; N]; N], screen: &Screen<N>) -> Option<[[u32; 2]; N]> {
    let m = screen.centres.len();
    // Slopes x_a / x_0 of the part before the eye; then of the part inside each side of the aperture, which is also before it.
    let mut slopes = slope_ranges(v, m, |p| p[0])?;
    for hidden in m + 1..N {
        for side in [1.0, -1.0] {
            // A hair wider than the aperture: what lies on its border is inside.
            let tan = screen.tan[hidden] * (1.0 + 1e-9) + 1e-12;
            let part = slope_ranges(v, m, |p| tan * p[0] - side * p[hidden])?;
            for a in 0..m {
                slopes[a] = [slopes[a][0].max(part[a][0]), slopes[a][1].min(part[a][1])];
            }
        }
    }
    let mut pixels = [[0, 1]; N];
    for a in 0..m {
        let centres = &screen.centres[a];
        let n = centres.len() as f64;
        // c(j) = c(0) (n-1-2j)/(n-1) falls with j; the pixel index of slope m is (n - 1 - 2 n m d / S) / 2.
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

/// The range of x_a / x_0, a = 1..=m, over the part of the simplex with `inside` >= 0 and x_0 > 0, or `None` when it is empty.
///
/// The part's corners are vertices and points of edges. Where the part reaches x_0 = 0 the slope grows without bound
/// towards the sign of x_a there.
fn slope_ranges<const N: usize>(
    v: &[[f64; N]; N],
    m: usize,
    inside: impl Fn(&[f64; N]) -> f64,
) -> Option<[[f64; 2]; N]> {
    let sides = v.map(|p| inside(&p));
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

/// Calls `include` for the points of the edge p..q where the part's borders `inside` = 0 and x_0 = 0 cut it.
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
        // What rounding cannot tell from 0 may go either way.
        for k in 1..N {
            if point[k].abs() <= 1e-12 * (p[k].abs() + q[k].abs()) {
                point[k] = 0.0;
            }
        }
        include(&point, 0.0);
    }
}

/// A lower bound of the distance of the facet from the eye: that of the box around it.
pub(super) fn nearest<const N: usize>(v: &[[f64; N]; N]) -> f64 {
    let mut sum = 0.0;
    for a in 0..N {
        let lo = v.iter().fold(f64::INFINITY, |m, p| m.min(p[a]));
        let hi = v.iter().fold(f64::NEG_INFINITY, |m, p| m.max(p[a]));
        let gap = lo.max(-hi).max(0.0);
        sum += gap * gap;
    }
    sum.sqrt()
}

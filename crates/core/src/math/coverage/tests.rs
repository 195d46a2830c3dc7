//! Coverage compared with the definition: every pixel's centre, tested against the three edges in
//! big integers.

use super::*;
use proptest::prelude::*;
use std::collections::BTreeMap;

const CLIP: PixelRect = PixelRect { x0: -2, y0: -1, x1: 8, y1: 7 };

/// Strictly inside, or on a top or a left edge: the definition, pixel by pixel.
fn truth(points: [[f64; 2]; 3], clip: PixelRect) -> Vec<(i32, i32)> {
    let mut p = points.map(|q| q.map(snap_big));
    let cross = |a: &[BigInt; 2], b: &[BigInt; 2], q: &[BigInt; 2]| {
        (&b[0] - &a[0]) * (&q[1] - &a[1]) - (&b[1] - &a[1]) * (&q[0] - &a[0])
    };
    let zero = BigInt::from(0);
    let area = cross(&p[0], &p[1], &p[2]);
    if area == zero {
        return Vec::new();
    }
    if area < zero {
        p.swap(1, 2);
    }
    // Clockwise: the inside is to the right of each edge, where `cross` is positive (y down).
    let mut lit = Vec::new();
    for y in clip.y0..clip.y1 {
        for x in clip.x0..clip.x1 {
            let centre = [BigInt::from(x as i64 * 256 + 128), BigInt::from(y as i64 * 256 + 128)];
            let inside = (0..3).all(|i| {
                let (a, b) = (&p[i], &p[(i + 1) % 3]);
                let side = cross(a, b, &centre);
                let top = a[1] == b[1] && b[0] > a[0];
                let left = b[1] < a[1];
                side > zero || side == zero && (top || left)
            });
            if inside {
                lit.push((x, y));
            }
        }
    }
    lit
}

fn covered(points: [[f64; 2]; 3], clip: PixelRect) -> Vec<(i32, i32)> {
    let mut lit = Vec::new();
    SnappedTriangle::new(points).for_each_span(clip, |y, xs| {
        assert!(!xs.is_empty());
        lit.extend(xs.map(|x| (x, y)));
    });
    lit
}

fn polygon(points: &[[f64; 2]], clip: PixelRect) -> Vec<(i32, i32)> {
    let mut lit = Vec::new();
    polygon_spans(points, clip, |y, xs| {
        assert!(!xs.is_empty());
        lit.extend(xs.map(|x| (x, y)));
    });
    lit
}

/// Coordinates: on half pixels, on the 1/256 grid, anywhere near, far off, or very far off.
fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => (-8i32..24).prop_map(|v| v as f64 / 2.0),
        3 => (-1000i32..3000).prop_map(|v| v as f64 / 256.0),
        3 => -6.0..12.0,
        2 => -300.0..300.0,
        2 => -1e9..1e9,
        1 => (-1e9..1e9f64).prop_map(|v| v.round() + 0.5),
        1 => (-1.0..1.0, 9i32..=300).prop_map(|(m, e): (f64, i32)| m * 10f64.powi(e)),
        1 => Just(f64::MAX),
        1 => Just(-f64::MAX),
    ]
}

fn corner() -> impl Strategy<Value = [f64; 2]> {
    [coordinate(), coordinate()]
}

/// Any triangle, or a sliver: the third corner slightly off the line through the first two.
fn triangle() -> impl Strategy<Value = [[f64; 2]; 3]> {
    let sliver = (corner(), corner(), 0.0..1.0, -3i32..=3).prop_map(|(a, b, t, hair): (_, _, f64, _)| {
        let on = |i: usize| a[i] + (b[i] / 2.0 - a[i] / 2.0) * 2.0 * t;
        let third = [on(0), on(1) + hair as f64 / 256.0];
        if third.iter().all(|v: &f64| v.is_finite()) { [a, b, third] } else { [a, b, a] }
    });
    prop_oneof![3 => [corner(), corner(), corner()], 1 => sliver]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60_000, ..ProptestConfig::default() })]

    #[test]
    fn a_rectangle_is_full_or_empty_only_where_its_pixels_are(
        points in triangle(), x in -2i32..7, y in -1i32..6, w in 1i32..6, h in 1i32..6,
    ) {
        let rect = PixelRect { x0: x, y0: y, x1: (x + w).min(8), y1: (y + h).min(7) };
        let lit = covered(points, rect).len() as i32;
        match SnappedTriangle::new(points).filling(rect) {
            Filling::None => prop_assert_eq!(lit, 0),
            Filling::All => prop_assert_eq!(lit, (rect.x1 - rect.x0) * (rect.y1 - rect.y0)),
            Filling::Part => {}
        }
    }

    #[test]
    fn a_rectangle_well_inside_is_full_and_one_well_outside_empty(
        points in [[-60.0..60.0, -60.0..60.0], [-60.0..60.0, -60.0..60.0], [-60.0..60.0, -60.0..60.0]],
        x in -30i32..40, y in -30i32..40, w in 1i32..6, h in 1i32..6,
    ) {
        let [a, b, c] = points;
        let edges = [(a, b), (b, c), (c, a)];
        let length = |p: [f64; 2], q: [f64; 2]| f64::hypot(q[0] - p[0], q[1] - p[1]);
        // Within these bounds snapping moves no edge's line by a quarter of a pixel.
        let is_long = edges.iter().all(|&(p, q)| length(p, q) > 8.0);
        let side = |p: [f64; 2], q: [f64; 2], r: [f64; 2]| {
            (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1])
        };
        let turn = side(a, b, c).signum();
        let corners = [[x, y], [x + w, y], [x, y + h], [x + w, y + h]].map(|p| p.map(f64::from));
        let inside = |p, q, r| side(p, q, r) * turn / length(p, q);
        let filling = SnappedTriangle::new(points).filling(PixelRect { x0: x, y0: y, x1: x + w, y1: y + h });
        if is_long && edges.iter().all(|&(p, q)| corners.iter().all(|&r| inside(p, q, r) > 0.25)) {
            prop_assert_eq!(filling, Filling::All);
        }
        if is_long && edges.iter().any(|&(p, q)| corners.iter().all(|&r| inside(p, q, r) < -0.25)) {
            prop_assert_eq!(filling, Filling::None);
        }
    }

    #[test]
    fn every_triangle_lights_what_the_definition_says(points in triangle()) {
        prop_assert_eq!(covered(points, CLIP), truth(points, CLIP));
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4_000, max_global_rejects: 40_000, ..ProptestConfig::default() })]

    #[test]
    fn winding_and_first_corner_do_not_matter(points in triangle()) {
        let [a, b, c] = points;
        let want = covered(points, CLIP);
        for turned in [[b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]] {
            prop_assert_eq!(&covered(turned, CLIP), &want);
        }
        let sign = SnappedTriangle::new(points).orientation();
        prop_assert_eq!(SnappedTriangle::new([b, c, a]).orientation(), sign);
        prop_assert_eq!(SnappedTriangle::new([a, c, b]).orientation(), sign.reverse());
        prop_assert_eq!(polygon(&points, CLIP), want);
    }

    #[test]
    fn a_shared_edge_is_lit_once(a in corner(), b in corner(), c in corner(), d in corner()) {
        use std::cmp::Ordering::Equal;
        let [left, right] = [[a, b, c], [b, a, d]];
        let (l, r) = (SnappedTriangle::new(left).orientation(), SnappedTriangle::new(right).orientation());
        // With equal windings they lie on either side of ab.
        prop_assume!(l == r && l != Equal);
        let (lit_left, lit_right) = (covered(left, CLIP), covered(right, CLIP));
        prop_assert!(lit_left.iter().all(|p| !lit_right.contains(p)));
        // Nothing between them is missed: the outline of both covers their sum.
        let mut both = [lit_left, lit_right].concat();
        both.sort_by_key(|&(x, y)| (y, x));
        prop_assert_eq!(polygon(&[a, d, b, c], CLIP), both);
    }

    #[test]
    fn a_fan_around_a_vertex_lights_every_pixel_once(
        centre in [-2.0..8.0, -1.0..7.0], spokes in 3usize..12, size in prop_oneof![Just(40.0), Just(1e6), Just(1e20)],
        half in any::<bool>(),
    ) {
        let centre: [f64; 2] = if half { centre.map(|v: f64| v.round() + 0.5) } else { centre };
        // A closed convex ring that contains the whole clip rectangle.
        let ring: Vec<[f64; 2]> = (0..spokes * 4).map(|i| {
            let side = i / spokes;
            let t = (i % spokes) as f64 / spokes as f64 * 2.0 - 1.0;
            [[t, -1.0], [1.0, t], [-t, 1.0], [-1.0, -t]][side].map(|v| v * size)
        }).collect();
        let mut count = BTreeMap::new();
        for i in 0..ring.len() {
            for p in covered([centre, ring[i], ring[(i + 1) % ring.len()]], CLIP) {
                *count.entry(p).or_insert(0) += 1;
            }
        }
        prop_assert_eq!(count.len(), 80);
        prop_assert!(count.values().all(|&n| n == 1));
    }

    #[test]
    fn a_polygon_is_even_odd_of_its_fan(
        points in prop_oneof![4 => prop::collection::vec(corner(), 3..9), 1 => prop::collection::vec(corner(), 17..40)],
    ) {
        let mut parity: BTreeMap<(i32, i32), bool> = BTreeMap::new();
        for i in 1..points.len() - 1 {
            for p in covered([points[0], points[i], points[i + 1]], CLIP) {
                *parity.entry(p).or_default() ^= true;
            }
        }
        let mut want: Vec<_> = parity.into_iter().filter_map(|(p, odd)| odd.then_some(p)).collect();
        want.sort_by_key(|&(x, y)| (y, x));
        prop_assert_eq!(polygon(&points, CLIP), want);
    }
}

#[test]
fn a_rectangle_of_centres_on_an_edge_is_full_where_the_edge_owns_them() {
    // A top edge through the centres of row 0 and a left edge through those of column 0 own them.
    let upper_left = SnappedTriangle::new([[0.5, 0.5], [20.5, 0.5], [0.5, 20.5]]);
    let filling = |t: &SnappedTriangle, x0, y0, x1, y1| t.filling(PixelRect { x0, y0, x1, y1 });
    for (x1, y1) in [(1, 1), (9, 1), (1, 9), (9, 9)] {
        assert_eq!(filling(&upper_left, 0, 0, x1, y1), Filling::All, "{x1} {y1}");
    }
    // A bottom edge and a right edge do not.
    let lower_right = SnappedTriangle::new([[20.5, 20.5], [0.5, 20.5], [20.5, 0.5]]);
    assert_eq!(filling(&lower_right, 12, 20, 20, 21), Filling::None);
    assert_eq!(filling(&lower_right, 20, 12, 21, 20), Filling::None);
    assert_eq!(filling(&lower_right, 12, 12, 20, 20), Filling::All);
}

#[test]
fn what_fills_a_rectangle_and_what_misses_it_is_known_from_its_corners() {
    let triangle = SnappedTriangle::new([[0.0, 0.0], [100.0, 0.0], [0.0, 100.0]]);
    let filling = |x0, y0, x1, y1| triangle.filling(PixelRect { x0, y0, x1, y1 });
    for (x0, y0, x1, y1) in [(10, 10, 40, 40), (0, 0, 50, 50), (0, 0, 1, 1), (0, 0, 99, 1), (49, 49, 50, 50)]
    {
        assert_eq!(filling(x0, y0, x1, y1), Filling::All, "{x0} {y0} {x1} {y1}");
    }
    for (x0, y0, x1, y1) in [
        (60, 60, 90, 90),
        (-20, 0, -10, 10),
        (-1, 0, 0, 100),
        (0, -5, 100, 0),
        (0, 100, 9, 110),
        (50, 50, 51, 51),
        (150, -50, 200, 300),
    ] {
        assert_eq!(filling(x0, y0, x1, y1), Filling::None, "{x0} {y0} {x1} {y1}");
    }
    for (x0, y0, x1, y1) in [(40, 40, 60, 60), (-1, 0, 10, 10), (0, 0, 100, 1), (-10, -10, 110, 110)] {
        assert_eq!(filling(x0, y0, x1, y1), Filling::Part, "{x0} {y0} {x1} {y1}");
    }
    // The other winding covers as much.
    let turned = SnappedTriangle::new([[0.0, 0.0], [0.0, 100.0], [100.0, 0.0]]);
    assert_eq!(turned.filling(PixelRect { x0: 10, y0: 10, x1: 40, y1: 40 }), Filling::All);
    assert_eq!(turned.filling(PixelRect { x0: 60, y0: 60, x1: 90, y1: 90 }), Filling::None);
}

#[test]
fn orientation_is_that_of_the_screen() {
    use std::cmp::Ordering::*;
    let turn = |p| SnappedTriangle::new(p).orientation();
    assert_eq!(turn([[0., 0.], [4., 0.], [0., 4.]]), Greater);
    assert_eq!(turn([[0., 0.], [0., 1e300], [1e300, 0.]]), Less);
    assert_eq!(turn([[0., 0.], [1e300, 1e300], [-1e300, -1e300]]), Equal);
    assert_eq!(turn([[0., 0.], [f64::NAN, 0.], [0., 4.]]), Equal);
    // No area is left once the corners are snapped.
    assert_eq!(turn([[0., 0.], [1e-9, 0.], [0., 1e-9]]), Equal);
}

#[test]
fn a_clip_rectangle_anywhere_in_i32_is_answered_at_once() {
    let far = PixelRect { x0: i32::MIN, y0: i32::MAX - 2, x1: i32::MAX, y1: i32::MAX };
    let huge = [[-f64::MAX, -f64::MAX], [f64::MAX, -f64::MAX], [0.0, f64::MAX]];
    let mut rows = Vec::new();
    SnappedTriangle::new(huge).for_each_span(far, |y, xs| rows.push((y, xs)));
    assert_eq!(rows, [(i32::MAX - 2, i32::MIN..i32::MAX), (i32::MAX - 1, i32::MIN..i32::MAX)]);
    let empty = PixelRect { x0: 4, y0: 4, x1: 4, y1: 9 };
    SnappedTriangle::new(huge).for_each_span(empty, |_, _| panic!("no pixel is inside"));
    polygon_spans(&huge, empty, |_, _| panic!("no pixel is inside"));
    polygon_spans(&huge[..2], far, |_, _| panic!("two points have no inside"));
}

#[test]
fn top_and_left_edges_through_centres_are_lit_bottom_and_right_ones_are_not() {
    let square = [[1.5, 1.5], [4.5, 1.5], [4.5, 4.5], [1.5, 4.5]];
    let want: Vec<_> = (1..4).flat_map(|y| (1..4).map(move |x| (x, y))).collect();
    assert_eq!(polygon(&square, CLIP), want);
    let mut halves = covered([square[0], square[1], square[2]], CLIP);
    halves.extend(covered([square[0], square[2], square[3]], CLIP));
    halves.sort_by_key(|&(x, y)| (y, x));
    assert_eq!(halves, want);
}

#[test]
fn corners_halfway_between_steps_are_snapped_to_the_even_one() {
    // In 1/256 pixel: centres lie at even places, so a corner half a step beside one is snapped
    // onto it, from either side, and one a step and a half away is not. Rounding up, or away from
    // zero, gives other pixels.
    let half = 1.0 / 512.0;
    // Both for 64-bit and 128-bit integers; wider ones have no halves.
    for at in [0.0, -64.0, f64::from(1 << 20), -f64::from(1 << 20)] {
        let origin = at as i32;
        let clip = PixelRect { x0: origin - 2, y0: origin - 2, x1: origin + 8, y1: origin + 8 };
        for (near, far, columns) in [
            (1.5 + half, 4.5 + half, 1..4),
            (1.5 - half, 4.5 - half, 1..4),
            (1.5 + 3.0 * half, 4.5 + 3.0 * half, 2..5),
            (1.5 - 3.0 * half, 4.5 - 3.0 * half, 1..4),
        ] {
            let [near, far] = [at + near, at + far];
            let want: Vec<_> = columns
                .clone()
                .flat_map(|y| columns.clone().map(move |x| (origin + x, origin + y)))
                .collect();
            let square = [[near, near], [far, near], [far, far], [near, far]];
            assert_eq!(polygon(&square, clip), want, "{near} to {far}");
            let mut halves = covered([square[0], square[1], square[2]], clip);
            halves.extend(covered([square[0], square[2], square[3]], clip));
            halves.sort_by_key(|&(x, y)| (y, x));
            assert_eq!(halves, want, "{near} to {far}");
        }
    }
}

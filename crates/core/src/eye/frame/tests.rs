//! Numbers of the frame against what they are said to be.

use super::*;
use crate::eye::test_scenes::scene;

#[test]
fn the_doubt_is_a_product_of_lengths_and_small_beside_it() {
    // Some coordinates are 0, as in most scenes.
    let v = [[3.0, 1.0, 0.0, 0.5], [3.5, -1.0, 0.25, -0.5], [3.25, 0.0, 1.0, 0.0], [2.75, 0.0, -1.0, 0.25]];
    let centres = |n: i32| (0..n).map(|j| f64::from(n - 1 - 2 * j) / f64::from(n)).collect::<Vec<f64>>();
    let screen = Screen { distance: 1.25, centres: vec![centres(8), centres(6)], tan: [0.0, 0.0, 0.0, 0.5] };
    let pixels = [[0, 8], [2, 5], [0, 1], [0, 1]];
    for (fan, factors) in [(false, 2), (true, 3)] {
        let doubt_of = |scale: f64| doubt(&v.map(|p| p.map(|x| x * scale)), &screen, &pixels, fan);
        let whole = doubt_of(1.0);
        // Determinants of this facet are about 10, and their rounding error about 1e-15.
        assert!((1e-15..1e-8).contains(&whole), "{whole}");
        assert_eq!(doubt_of(0.125), whole * 0.125f64.powi(factors));
    }
}

#[test]
fn hulls_say_on_which_side_of_a_plane_the_facet_is() {
    let mut state = 7u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state >> 8) / f64::from(1 << 24) - 0.5
    };
    let facets: Vec<Vec<Vec<f64>>> =
        (0..60).map(|_| (0..4).map(|_| vec![3.0 + next(), next(), next(), next()]).collect()).collect();
    let scene = scene((1.0, 1.0, 0.5), &[4, 4], facets, vec![]);
    let frame = Frame::<4>::new(&scene, Method::Plane, &Executor::default());
    let mut counts = [0; 3];
    for (index, facet) in frame.facets.iter().enumerate() {
        for (plane, hull) in frame.planes_of(index).iter().zip(frame.hulls_of(index)) {
            // Two of the four vertices lie in the plane.
            let mut sides = facet.v.map(|p| dot(plane, &p));
            sides.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            if sides[2].abs() < 1e-3 * max_abs(plane) {
                continue;
            }
            assert!(sides[1].abs() < 1e-12, "{sides:?}");
            let want = if sides[2] * sides[3] < 0.0 { 0.0 } else { sides[3].signum() };
            assert_eq!(*hull, want, "{sides:?}");
            counts[(want + 1.0) as usize] += 1;
        }
    }
    assert!(counts.iter().all(|n| *n > 20), "{counts:?}");
}

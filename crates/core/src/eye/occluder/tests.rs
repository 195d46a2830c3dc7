//! Shadows against their definition: the crossing's barycentrics, from a linear system.

use super::*;
use crate::math::nvec::dot;
use proptest::prelude::*;

/// Numbers nearer than this to where a result changes are left to rounding.
const UNSURE: f64 = 1e-5;

/// Solves the linear system by elimination with the largest pivots; `None` if a pivot is nearly 0.
fn solve<const N: usize>(mut rows: [[f64; N]; N], mut right: [f64; N]) -> Option<[f64; N]> {
    for step in 0..N {
        let best = (step..N).max_by(|&a, &b| rows[a][step].abs().total_cmp(&rows[b][step].abs()))?;
        rows.swap(step, best);
        right.swap(step, best);
        if rows[step][step].abs() < 1e-3 {
            return None;
        }
        for row in (0..N).filter(|&row| row != step) {
            let factor = rows[row][step] / rows[step][step];
            for column in 0..N {
                rows[row][column] -= factor * rows[step][column];
            }
            right[row] -= factor * right[step];
        }
    }
    Some(std::array::from_fn(|i| right[i] / rows[i][i]))
}

/// Returns whether the tetrahedron of R^4 stands on the path from `p` along `way`, which ends at
/// `way` itself if `is_short`; `None` if rounding decides.
fn stands_between(v: &[[f64; 4]; 4], p: &[f64; 4], way: &[f64; 4], is_short: bool) -> Option<bool> {
    // Unknowns: four barycentrics and s. Equations: four coordinates of sum(l v) - s way = p, and
    // sum(l) = 1.
    let mut rows = [[0.0; 5]; 5];
    for (a, row) in rows.iter_mut().enumerate().take(4) {
        *row = std::array::from_fn(|i| if i < 4 { v[i][a] } else { -way[a] });
    }
    rows[4] = [1.0, 1.0, 1.0, 1.0, 0.0];
    let x = solve(rows, [p[0], p[1], p[2], p[3], 1.0])?;
    let ends = [x[4], if is_short { 1.0 - x[4] } else { 1.0 }];
    let all = || x[..4].iter().chain(&ends);
    all().all(|n| n.abs() > UNSURE).then(|| all().all(|n| *n > 0.0))
}

fn occluder_of(v: &[[f64; 4]; 4]) -> Option<Occluder<4>> {
    let across = wedge(&[sub(&v[1], &v[0]), sub(&v[2], &v[0]), sub(&v[3], &v[0])], 4);
    let normal = unit(across);
    (dot(&across, &across) > 1e-2).then(|| Occluder::new(v, normal, dot(&normal, &v[0])))
}

/// Returns a target of each kind, its placement relative to the occluder, and the path to it from
/// `p`.
fn targets(
    occluder: &Occluder<4>,
    place: [f64; 4],
    p: &[f64; 4],
) -> [(LightTarget<4>, LightPlacement, [f64; 4], bool); 3] {
    let placed = |height: f64| LightPlacement { height, side: 0 };
    let direction = unit(place);
    let radial = placed(dot(&occluder.normal, &place) - occluder.offset);
    [
        (LightTarget::Radial { position: place }, radial, sub(&place, p), true),
        // A foot differs from point to point: its placement is that of the light plane's direction.
        (LightTarget::Foot { position: place }, placed(0.0), sub(&place, p), true),
        (
            LightTarget::Sun { direction },
            placed(dot(&occluder.normal, &direction)),
            direction.map(|x| -x),
            false,
        ),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]
    #[test]
    fn a_facet_blocks_what_crosses_it(
        v in prop::array::uniform4(prop::array::uniform4(-2.0f64..2.0)),
        p in prop::array::uniform4(-2.0f64..2.0),
        // Often near the straight path through the facet's middle.
        off in prop::array::uniform4(-1.0f64..1.0),
        through in any::<bool>(),
    ) {
        let Some(occluder) = occluder_of(&v) else { return Ok(()) };
        let middle: [f64; 4] = std::array::from_fn(|a| v.iter().map(|q| q[a]).sum::<f64>() / 4.0);
        let place = if through {
            std::array::from_fn(|a| 2.0 * middle[a] - p[a] + 0.5 * off[a])
        } else {
            off.map(|x| 3.0 * x)
        };
        for (target, placement, way, is_short) in targets(&occluder, place, &p) {
            let Some(want) = stands_between(&v, &p, &way, is_short) else { continue };
            prop_assert_eq!(occluder.blocks(&p, max_abs(&p), &target, &placement), want);
            // A box of this point alone gives the same result.
            if !matches!(target, LightTarget::Foot { .. }) {
                prop_assert_eq!(occluder.may_block(&p, &[0.0; 4], &target, &placement), want);
            }
        }
    }

    /// A box is kept if each of the linear functions is positive in one of its corners.
    #[test]
    fn a_box_is_kept_by_its_best_corners(
        v in prop::array::uniform4(prop::array::uniform4(-2.0f64..2.0)),
        middle in prop::array::uniform4(-2.0f64..2.0),
        half in prop::array::uniform4(0.0f64..0.4),
        place in prop::array::uniform4(-3.0f64..3.0),
        inside in prop::collection::vec(prop::array::uniform4(-1.0f64..1.0), 16),
    ) {
        let Some(occluder) = occluder_of(&v) else { return Ok(()) };
        for (target, placement, _, _) in targets(&occluder, place, &middle) {
            let kept = occluder.may_block(&middle, &half, &target, &placement);
            for part in &inside {
                let p: [f64; 4] = std::array::from_fn(|a| middle[a] + part[a] * half[a]);
                prop_assert!(kept || !occluder.blocks(&p, max_abs(&p), &target, &placement), "{p:?}");
            }
            // The light's own value in a ridge's function, and the side on which the box must
            // reach.
            let (place, with_offset, sign) = match target {
                LightTarget::Foot { .. } => {
                    prop_assert!(kept);
                    continue;
                }
                LightTarget::Radial { position } => (position, 1.0, -placement.height.signum()),
                LightTarget::Sun { direction } => (direction, 0.0, placement.height.signum()),
            };
            let mut best = [f64::NEG_INFINITY; 5];
            for corner in 0..16 {
                let p: [f64; 4] = std::array::from_fn(|a| {
                    middle[a] + if corner >> a & 1 == 0 { half[a] } else { -half[a] }
                });
                let h = dot(&occluder.normal, &p) - occluder.offset;
                best[4] = best[4].max(sign * h);
                let ridges = occluder.ridges.iter().zip(&occluder.ridge_offsets);
                for (best, (ridge, offset)) in best.iter_mut().zip(ridges) {
                    let value = placement.height.abs() * (dot(ridge, &p) - offset)
                        - placement.height.signum() * (dot(ridge, &place) - with_offset * offset) * h;
                    *best = best.max(value);
                }
            }
            if best.iter().all(|b| b.abs() > UNSURE) && placement.height.abs() > UNSURE {
                prop_assert_eq!(kept, best.iter().all(|b| *b > 0.0), "{:?}", best);
            }
        }
    }
}

#[test]
fn a_stand_is_the_side_that_the_light_is_on() {
    // The hyperplane x_0 = 2, its normal towards the eye.
    let v = [[2.0, 1.0, 0.0, 0.0], [2.0, -1.0, 0.0, 0.0], [2.0, 0.0, 1.0, 0.5], [2.0, 0.0, 0.5, 1.0]];
    let occluder = Occluder::new(&v, [-1.0, 0.0, 0.0, 0.0], -2.0);
    let light = |place| FrameLight { place, falloff: crate::eye::Falloff::OFF, color: [1.0; 3] };
    let side = |place| occluder.placement(&light(place)).side;
    for (x0, want) in [(0.0, 1), (1.9, 1), (2.0, 0), (2.0 + 1e-11, 0), (2.1, -1)] {
        assert_eq!(side(LightPlace::Radial { position: [x0, 5.0, 0.0, 0.0] }), want, "{x0}");
        let height = occluder.placement(&light(LightPlace::Radial { position: [x0, 5.0, 0.0, 0.0] })).height;
        assert!((height - (2.0 - x0)).abs() < 1e-14, "{height}");
    }
    // A sun that travels away from the eye is on the eye's side.
    assert_eq!(side(LightPlace::Sun { direction: [1.0, 0.0, 0.0, 0.0] }), 1);
    assert_eq!(side(LightPlace::Sun { direction: [-0.6, 0.8, 0.0, 0.0] }), -1);
    assert_eq!(side(LightPlace::Sun { direction: [0.0, 1.0, 0.0, 0.0] }), 0);
    assert_eq!(side(LightPlace::Plane { direction: [-0.6, 0.8, 0.0, 0.0], offset: 0.3 }), 1);
}

#[test]
fn a_facet_blocks_the_same_in_any_unit_of_length() {
    let v = [[2.0, 1.0, 0.0, 0.0], [2.0, -1.0, 0.0, 0.0], [2.0, 0.0, 1.0, 0.5], [2.0, 0.0, 0.5, 1.0]];
    for unit in [1.0, libm::exp2(-20.0), libm::exp2(-60.0)] {
        let scaled = |p: [f64; 4]| p.map(|x| x * unit);
        let occluder = Occluder::new(&v.map(scaled), [-1.0, 0.0, 0.0, 0.0], -2.0 * unit);
        for (at, want) in [(0.375, true), (3.0, false)] {
            // Straight through (2, 0, at, at).
            let (p, place) = (scaled([3.0, 0.0, at, at]), scaled([1.0, 0.0, at, at]));
            let placement = LightPlacement { height: unit, side: 1 };
            let target = LightTarget::Radial { position: place };
            assert_eq!(occluder.blocks(&p, max_abs(&p), &target, &placement), want, "{unit}");
            assert_eq!(occluder.may_block(&p, &[0.0; 4], &target, &placement), want, "{unit}");
        }
    }
}

#[test]
fn a_box_is_kept_if_its_point_is_blocked_within_the_tolerance_of_the_border() {
    // The line from x_1 = 0 to 1 in the hyperplane x_0 = 0 of the plane, and a light so near its
    // end that the crossing is 5e-13 outside, which counts as inside.
    let occluder = Occluder::new(&[[0.0, 0.0], [0.0, 1.0]], [1.0, 0.0], 0.0);
    let (p, place) = ([1.0, 1.0], [-1e-3, -1e-3 - 5e-13]);
    let (target, placement) =
        (LightTarget::Radial { position: place }, LightPlacement { height: -1e-3, side: -1 });
    assert!(occluder.blocks(&p, 1.0, &target, &placement));
    assert!(occluder.may_block(&p, &[0.0; 2], &target, &placement));
}

//! Culling and shadows of a tile.

use super::*;
use crate::executor::Executor;
use crate::eye::test_scenes::scene;
use crate::eye::{EyeLight, EyeLightKind, Falloff, render};

#[test]
fn a_facet_is_behind_when_no_pixel_sees_its_hyperplane_nearer() {
    for slant in [0.0, 0.3, -0.2] {
        // The hyperplane x_0 = 3 + slant x_1, so wide that its corners say nothing about this tile.
        let corner = |y: f64, z: f64| vec![3.0 + slant * y, y, z];
        let wall = vec![corner(-40.0, -90.0), corner(40.0, -90.0), corner(0.0, 120.0)];
        let scene = scene((1.5, 4.0, 0.0), &[8, 8], vec![wall], vec![]);
        let world = World::<3>::new(&scene, Frame::new(&scene, Method::Ray, &Executor::default()));
        let tile = world.tile([0; 3], [2, 2, 1]);
        // c_1 and c_2 are 1.75 and 1.25 in this tile; the wall is met at x_0 = 3 d / (d - slant c_1).
        let unit = libm::exp2(f64::from(-world.frame.exponent));
        let distances2 = [[1.75, 1.75], [1.75, 1.25], [1.25, 1.75], [1.25, 1.25]].map(|[c1, c2]| {
            let length2 = 1.5 * 1.5 + c1 * c1 + c2 * c2;
            let s = 3.0 / (1.5 - slant * c1) * unit;
            (length2, s * s * length2)
        });
        let least_length2 = distances2.iter().fold(f64::INFINITY, |m, d| m.min(d.0));
        let nearest2 = distances2.iter().fold(f64::INFINITY, |m, d| m.min(d.1));
        let is_behind = |worst2: f64| world.is_behind(0, &tile, least_length2, worst2);
        assert!(!is_behind(nearest2 * (1.0 + 1e-6)) && !is_behind(f64::INFINITY), "{slant}");
        // The bound takes the largest <n,P> and the least |P| of the tile together, which belong to
        // different pixels where the wall is slanted.
        let near_enough = if slant == 0.0 { 1.0 - 1e-6 } else { 0.6 };
        assert!(is_behind(nearest2 * near_enough), "{slant}");
    }
}

/// A lit wall of R^3, and a triangle in the plane x_2 = 0.6 from x_1 = `first` on, between it and
/// the light, which no pixel sees.
fn shadowed(pixels: &[u32], first: f64) -> EyeScene {
    let wall = vec![vec![3.0, -20.0, -20.0], vec![3.0, 20.0, -20.0], vec![3.0, 0.0, 30.0]];
    let roof = vec![vec![1.0, first, 0.6], vec![9.0, first, 0.6], vec![2.0, first + 12.0, 0.6]];
    let kind = EyeLightKind::Radial { position: vec![1.5, 0.0, 5.0] };
    let light = EyeLight { kind, falloff: Falloff::OFF, color: [0.5; 3] };
    scene((1.0, 0.3, 0.0), pixels, vec![wall, roof], vec![light])
}

#[test]
fn points_in_one_plane_through_the_eye_are_shadowed() {
    // One column of pixels: x_1 = 0 at each point, so the tile's box has no width there.
    let picture = render(&shadowed(&[1, 5], -4.0));
    assert_eq!((picture.facet, picture.lit), (vec![0; 5], vec![false; 5]));
    assert_eq!(render(&shadowed(&[1, 5], 1.0)).lit, [true; 5]);
}

#[test]
fn shadows_are_the_same_with_a_hierarchy_of_obstacles() {
    let few = shadowed(&[8, 8], 0.0);
    let mut parts = few.clone().into_parts();
    let small = |k: usize| {
        let (y, z) = ((k % 20) as f64, (k / 20) as f64);
        [[-50.0, y, z], [-50.0, y + 0.5, z], [-50.5, y, z + 0.5]].map(|p| p.to_vec()).to_vec()
    };
    let color = [255.0; 3];
    parts.facets.extend((0..2 * PICKED_OBSTACLES).map(|k| crate::eye::Facet { v: small(k), color }));
    let many = EyeScene::new(parts).unwrap();
    let lit = render(&few).lit;
    assert_eq!(lit.iter().filter(|l| **l).count(), 32, "half of the wall");
    assert_eq!(render(&many).lit, lit);
}

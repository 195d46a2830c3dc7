//! Parts of the eye against their definitions: its axes, its steps, and the comparison of two
//! pictures.

use fbptr::eye::{EyePicture, EyeScene, Pose, render};
use proptest::prelude::*;

/// Returns R e_j as entry j: the product of the rotations' matrices, each in the frame that those
/// before it produced.
fn axes_of(pose: &Pose) -> Vec<Vec<f64>> {
    let dim = pose.position.len();
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    // r[i][j]: coordinate i of axis j.
    let mut r: Vec<Vec<f64>> = (0..dim).map(|i| (0..dim).map(|j| unit(i, j)).collect()).collect();
    for turn in &pose.rotations {
        let (sin, cos) = turn.angle_deg.to_radians().sin_cos();
        let mut g: Vec<Vec<f64>> = (0..dim).map(|i| (0..dim).map(|j| unit(i, j)).collect()).collect();
        (g[turn.a][turn.a], g[turn.b][turn.a]) = (cos, sin);
        (g[turn.a][turn.b], g[turn.b][turn.b]) = (-sin, cos);
        r = (0..dim).map(|i| (0..dim).map(|j| (0..dim).map(|k| r[i][k] * g[k][j]).sum()).collect()).collect();
    }
    (0..dim).map(|j| (0..dim).map(|i| r[i][j]).collect()).collect()
}

proptest! {
    #[test]
    fn the_axes_are_the_product_of_the_turns(
        dim in 2usize..=8,
        turns in prop::collection::vec((0usize..8, 1usize..8, -400.0f64..400.0), 0..9),
        (axis, step) in (0usize..8, -3.0f64..3.0),
    ) {
        let mut pose = Pose::identity(dim);
        let mut all = Pose::identity(dim);
        for (a, further, angle) in turns {
            let (a, b) = (a % dim, (a % dim + 1 + further % (dim - 1)) % dim);
            pose.turn(a, b, angle);
            all.rotations.push(fbptr::eye::Rotation { a, b, angle_deg: angle });
        }
        let want = axes_of(&all);
        // The rotations applied one by one, and those given as a list.
        for got in [pose.axes(), all.axes()] {
            for (got, want) in got.iter().flatten().zip(want.iter().flatten()) {
                prop_assert!((got - want).abs() < 1e-11, "{got} for {want}");
            }
        }
        pose.advance(axis % dim, step);
        for (got, along) in pose.position.iter().zip(&want[axis % dim]) {
            prop_assert!((got - step * along).abs() < 1e-10);
        }
    }
}

fn picture() -> EyePicture {
    let scene = br#"{"dim":2,"pixels":[4],"d":1,"S":[1],"I_d":0.5,
        "lights":[{"type":"radial","position":[1,0]}],
        "facets":[{"v":[[2,-3],[2,0.01]],"color":[250,100,50]},{"v":[[3,1],[3,1]],"color":[9,9,9]}]}"#;
    render(&EyeScene::from_json(scene).unwrap())
}

#[test]
fn pictures_that_differ_in_one_thing_differ_in_that_alone() {
    let good = picture();
    assert_eq!(good.skipped_facets, [1]);
    let hits: Vec<usize> = (0..4).filter(|&i| good.facet[i] == 0).collect();
    assert!((1..4).contains(&hits.len()), "{good:?}");
    let (seen, missed) = (hits[0], (0..4).find(|i| !hits.contains(i)).unwrap());
    let none = good.differences(&good, &[]);
    assert!(none.are_none() && none == Default::default(), "{none:?}");

    let mut other = good.clone();
    other.facet[seen] = 7;
    let found = other.differences(&good, &[]);
    assert!(!found.are_none() && (found.facets, found.flags, found.first) == (1, 0, Some(seen)), "{found:?}");
    assert!(other.differences(&good, &[seen]).are_none());

    let mut other = good.clone();
    other.lit[seen] = !other.lit[seen];
    let found = other.differences(&good, &[]);
    assert!(!found.are_none() && (found.facets, found.flags, found.first) == (0, 1, Some(seen)), "{found:?}");

    // Distances: relative above 1; a miss against a hit differs without bound.
    for (off, is_none) in [(0.9e-9, true), (1.2e-9, false)] {
        let mut other = good.clone();
        other.dist[seen] *= 1.0 + off;
        let found = other.differences(&good, &[]);
        assert!((found.distance - off).abs() < 1e-12 && found.are_none() == is_none, "{found:?}");
    }
    let mut other = good.clone();
    other.dist[missed] = 1.0;
    assert_eq!(other.differences(&good, &[]).distance, f64::INFINITY);
    assert_eq!(good.differences(&other, &[]).distance, f64::INFINITY);

    for channel in 0..3 {
        for (off, is_none) in [(0.9e-6, true), (-0.9e-6, true), (1.2e-6, false), (-1.2e-6, false)] {
            let mut other = good.clone();
            other.color[seen][channel] += off;
            let found = other.differences(&good, &[]);
            assert!((found.color - off.abs()).abs() < 1e-9 && found.are_none() == is_none, "{found:?}");
        }
    }

    let mut other = good.clone();
    other.skipped_facets.clear();
    let found = other.differences(&good, &[]);
    assert!(found.skipped && !found.are_none(), "{found:?}");
    assert_eq!((found.facets, found.flags, found.first), (0, 0, None));
    // Two wrong pixels are counted as two, and the first is reported.
    let mut other = good.clone();
    (other.facet[seen], other.facet[missed]) = (5, 6);
    let found = other.differences(&good, &[]);
    assert_eq!((found.facets, found.first), (2, Some(seen.min(missed))));
}

/// A facet 2^-270 times as large as the scene: all products of its numbers leave the range of f64,
/// and no pixel may be lost.
#[test]
fn a_tiny_facet_close_by_is_seen_as_a_large_one() {
    let scene = |scale: f64, far: bool| {
        let number = |x: f64| format!("{:e}", x * scale);
        let v = [[2.0, -0.6, -0.5, -0.3], [2.2, 0.7, -0.4, 0.2], [1.9, 0.1, 0.8, -0.1], [2.1, 0.0, 0.1, 0.6]]
            .map(|p| format!("[{}]", p.map(number).join(",")));
        let wall = r#",{"v":[[9e3,1,0,0],[9e3,0,1,0],[9e3,0,0,1],[9e3,1,1,1]],"color":[1,1,1]}"#;
        let text = format!(
            r#"{{"dim":4,"pixels":[12,12],"d":1,"S":[1,1],"aperture_tan":[0.3],"I_d":1,
            "facets":[{{"v":[{}],"color":[250,100,50]}}{}]}}"#,
            v.join(","),
            if far { wall } else { "" }
        );
        render(&EyeScene::from_json(text.as_bytes()).unwrap())
    };
    let tiny = (2.0f64).powi(-270);
    let (alone, beside) = (scene(1.0, false), scene(tiny, true));
    assert!(alone.facet.iter().filter(|&&f| f == 0).count() > 20, "{:?}", alone.facet);
    for i in 0..144 {
        assert_eq!(alone.facet[i] == 0, beside.facet[i] == 0, "pixel {i}");
        if alone.facet[i] == 0 {
            let off = beside.dist[i] / tiny / alone.dist[i] - 1.0;
            assert!(off.abs() < 1e-9, "pixel {i}: {} for {}", beside.dist[i] / tiny, alone.dist[i]);
        }
    }
}

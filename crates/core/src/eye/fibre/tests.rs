//! The aperture's border against its equation, |x_j| <= tan(alpha_j) x_0, on facets whose nearest
//! point is a quotient.

use crate::executor::Executor;
use crate::eye::{EyePicture, EyeScene, Facet, Falloff, Fibre, Pose, SceneParts, render, render_with};

/// A facet in the hyperplane x_0 = depth - slant h, h being the last hidden coordinate: from h =
/// `first` to `first` + 4, wide around the axis, with h multiplied by `side` (1 or -1).
#[derive(Clone, Copy, Debug)]
struct Wall {
    depth: f64,
    slant: f64,
    first: f64,
    side: f64,
}

const SCREEN: (f64, f64, u32) = (0.7, 0.3, 5); // d, S, pixels along each axis

fn parts(dim: usize, screen: usize, tan: f64, wall: Wall) -> SceneParts {
    // A simplex of dim - 1 corners around 0 in all axes but the last, and one corner above its
    // middle.
    let mut v = vec![vec![-2.0; dim]; dim];
    v[dim - 1].fill(0.0);
    for (k, point) in v.iter_mut().enumerate() {
        if (1..dim - 1).contains(&k) {
            point[k] += 8.0;
        }
        let h = wall.first + if k == dim - 1 { 4.0 } else { 0.0 };
        (point[0], point[dim - 1]) = (wall.depth - wall.slant * h, wall.side * h);
    }
    SceneParts {
        dim,
        pixels: vec![SCREEN.2; screen],
        distance: SCREEN.0,
        size: vec![SCREEN.1; screen],
        aperture_tan: vec![tan; dim - 1 - screen],
        diffuse: [1.0; 3],
        view: Falloff::OFF,
        background: [0.0; 3],
        pose: Pose::identity(dim),
        lights: Vec::new(),
        facets: vec![Facet { v, color: [255.0; 3] }],
    }
}

fn look(dim: usize, screen: usize, tan: f64, wall: Wall, fibre: Fibre) -> EyePicture {
    let scene = EyeScene::new(parts(dim, screen, tan, wall)).unwrap();
    match fibre {
        Fibre::Exact => render(&scene),
        fan => render_with(&scene, fan, &Executor::default()).unwrap(),
    }
}

/// Returns h at the border of the aperture on the wall, h = tan x_0.
fn border(wall: Wall, tan: f64) -> f64 {
    wall.depth * tan / (1.0 + wall.slant * tan)
}

/// Returns the distance that a pixel sees, with |P|^2 = `length2` d^2: the least of length2 x_0^2 +
/// h^2 from the wall's lower end to the border.
fn wanted(wall: Wall, tan: f64, length2: f64) -> f64 {
    let free = wall.depth * length2 * wall.slant / (1.0 + length2 * wall.slant * wall.slant);
    let h = free.min(border(wall, tan)).max(wall.first);
    (length2 * (wall.depth - wall.slant * h).powi(2) + h * h).sqrt()
}

/// Returns |P|^2 / d^2 of the pixel with flat index `index`.
fn length2(index: usize, screen: usize) -> f64 {
    let (d, size, n) = (SCREEN.0, SCREEN.1, SCREEN.2 as usize);
    let centre = |j: usize| size * (n as f64 - 1.0 - 2.0 * j as f64) / (2.0 * n as f64);
    (0..screen).fold(1.0, |sum, a| sum + (centre(index / n.pow(a as u32) % n) / d).powi(2))
}

/// Dimensions of the space and of the screen: one hidden axis, and two.
const SPACES: [(usize, usize); 4] = [(3, 1), (4, 2), (4, 1), (5, 2)];

#[test]
fn the_aperture_ends_where_its_equation_says() {
    for ((dim, screen), side) in SPACES.into_iter().flat_map(|s| [(s, 1.0), (s, -1.0)]) {
        for (tan, slant) in [0.05, 0.3, 0.8].into_iter().flat_map(|t| [-0.2, 0.0, 0.4].map(|s| (t, s))) {
            let at = |first| Wall { depth: 3.0, slant, first, side };
            let end = border(at(0.0), tan);
            for first in [-0.1, 0.0, 0.5 * end, end * (1.0 - 1e-7)] {
                let picture = look(dim, screen, tan, at(first), Fibre::Exact);
                for (index, dist) in picture.dist.iter().enumerate() {
                    let want = wanted(at(first), tan, length2(index, screen));
                    let error = (dist - want).abs();
                    assert!(error < 1e-12, "{dim} on {screen}, {:?}, {tan}: {dist} for {want}", at(first));
                }
            }
            let beyond = look(dim, screen, tan, at(end * (1.0 + 1e-7)), Fibre::Exact);
            assert!(beyond.dist.iter().all(|d| d.is_infinite()), "{dim} on {screen}, {tan}, {slant}, {side}");
        }
    }
}

#[test]
fn a_wall_that_only_touches_the_border_is_seen_whichever_way_its_place_was_rounded() {
    // x_0 = depth on all of it, so its lower end is exactly on the border up to the rounding of one
    // product.
    for ((dim, screen), side) in SPACES.into_iter().flat_map(|s| [(s, 1.0), (s, -1.0)]) {
        for (i, depth) in (1..=20).flat_map(|i| [0.7, 1.1, 3.0, 5.3].map(|depth| (i, depth))) {
            let tan = f64::from(i) / 23.0;
            let wall = Wall { depth, slant: 0.0, first: tan * depth, side };
            let picture = look(dim, screen, tan, wall, Fibre::Exact);
            for (index, dist) in picture.dist.iter().enumerate() {
                let want = wanted(wall, tan, length2(index, screen));
                assert!((dist - want).abs() < 1e-11 * want, "{dim} on {screen}, {wall:?}, {tan}: {dist}");
            }
        }
    }
}

#[test]
fn the_border_is_as_sharp_close_by_in_a_large_scene() {
    let unit = libm::exp2(-30.0);
    for ((dim, screen), side) in SPACES.into_iter().flat_map(|s| [(s, 1.0), (s, -1.0)]) {
        let end = border(Wall { depth: 3.0, slant: 0.4, first: 0.0, side }, 0.3);
        for (first, is_seen) in [(end * (1.0 - 1e-7), true), (end * (1.0 + 1e-7), false)] {
            let wall = Wall { depth: 3.0, slant: 0.4, first, side };
            let mut parts = parts(dim, screen, 0.3, wall);
            parts.facets[0].v.iter_mut().flatten().for_each(|x| *x *= unit);
            // Behind the eye, where it only sets the unit of length.
            let mut large = parts.facets[0].clone();
            large.v.iter_mut().enumerate().for_each(|(k, p)| {
                p.fill(0.0);
                p[0] = -2.0;
                p[k] -= 1.0;
            });
            parts.facets.push(large);
            let picture = render(&EyeScene::new(parts).unwrap());
            for (index, dist) in picture.dist.iter().enumerate() {
                let want = if is_seen { wanted(wall, 0.3, length2(index, screen)) } else { f64::INFINITY };
                let is_right = dist / unit == want || (dist / unit - want).abs() < 1e-12;
                assert!(is_right, "{dim} on {screen}, {side}: {} for {want}", dist / unit);
            }
        }
    }
}

#[test]
fn the_outermost_rays_of_a_fan_lie_on_the_border() {
    for ((dim, screen), side) in SPACES.into_iter().flat_map(|s| [(s, 1.0), (s, -1.0)]) {
        // It comes nearer as h grows, so the outermost ray sees the nearest point.
        let wall = Wall { depth: 3.0, slant: 0.6, first: -0.1, side };
        let picture = look(dim, screen, 0.3, wall, Fibre::Fan(3));
        for (index, dist) in picture.dist.iter().enumerate() {
            let want = wanted(wall, 0.3, length2(index, screen));
            assert!((dist - want).abs() < 1e-12, "{dim} on {screen}: {dist} for {want}");
        }
    }
}

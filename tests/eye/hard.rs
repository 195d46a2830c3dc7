//! Hard cases of the N-dimensional eye. Each is named, with the expected picture worked out by
//! hand.

use fbptr::eye::{EyePicture, EyeScene, render};
use serde_json::{Value, json};

fn scene(value: &Value) -> EyeScene {
    EyeScene::from_value(value).unwrap()
}

fn see(value: Value) -> EyePicture {
    render(&scene(&value))
}

/// Returns a 2-D scene on 9 pixels with offsets 4, 3, .., -4.
fn plane(facets: Value, lights: Value) -> Value {
    json!({"dim": 2, "pixels": [9], "d": 1, "S": [9], "I_d": 0.5, "lights": lights, "facets": facets})
}

fn facet(v: Value) -> Value {
    json!({"v": v, "color": [200, 100, 50]})
}

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * b.abs().max(1.0), "{a} is not {b}");
}

#[test]
fn h01_facets_through_behind_and_beside_the_eye() {
    let picture = see(plane(
        json!([
            facet(json!([[1, 2], [3, 6]])),     // on the ray of offset 2
            facet(json!([[0, -1], [0, 1]])),    // the eye lies on it
            facet(json!([[-2, -9], [-2, 9]])),  // behind
            facet(json!([[1, 3.5], [3, 9.5]])), // parallel to the ray of offset 3, off it
            facet(json!([[-3, 5], [5, -3]])),   // from behind the eye to before it: x + y = 2
            facet(json!([[7, -70], [7, 70]]))   // a wall
        ]),
        json!([]),
    ));
    // x + y = 2 is met by offset c at t = 2 / (1 + c) where t > 0 and x <= 5: c >= -0.6.
    // Facet 3 is y = 3 x + 0.5: met by offset 4 at t = 0.5, before its first end x = 1: missed.
    assert_eq!(picture.facet, [4, 4, 4, 4, 4, 5, 5, 5, 5]);
    for (i, c) in [4.0, 3.0, 2.0, 1.0, 0.0].into_iter().enumerate() {
        near(picture.dist[i], 2.0 / (1.0 + c) * f64::sqrt(1.0 + c * c));
    }
    near(picture.dist[8], 7.0 * 17f64.sqrt());
}

#[test]
fn h02_rays_through_shared_vertices_hit_the_lower_index() {
    // A zigzag whose vertices lie on the rays, in either order of the facets.
    let zigzag: Vec<Value> = (-4..4)
        .map(|c: i32| {
            let x = |c: i32| if c % 2 == 0 { 2 } else { 3 };
            facet(json!([[x(c), c * x(c)], [x(c + 1), (c + 1) * x(c + 1)]]))
        })
        .collect();
    let picture = see(plane(json!(zigzag), json!([])));
    // Pixel i sees offset 4 - i: facets c = 3 - i and 4 - i meet there; facet index is c + 4.
    assert_eq!(picture.facet, [7, 6, 5, 4, 3, 2, 1, 0, 0]);
    let reversed: Vec<Value> = zigzag.into_iter().rev().collect();
    assert_eq!(see(plane(json!(reversed), json!([]))).facet, [0, 0, 1, 2, 3, 4, 5, 6, 7]);
}

/// Returns triangles around a hub, seen by 9 x 9 pixels with offsets 4..-4.
fn hub(ring: &[[f64; 3]], hub: [f64; 3], eye: Value) -> Value {
    let count = ring.len();
    let facets: Vec<Value> =
        (0..count).map(|i| facet(json!([hub, ring[i], ring[(i + 1) % count]]))).collect();
    json!({"dim": 3, "pixels": [9, 9], "d": 1, "S": [9, 9], "I_d": 0.5, "facets": facets, "eye": eye})
}

#[test]
fn h03_rays_through_the_hub_the_spokes_and_the_rim_of_eight_triangles() {
    // In the plane x = 2: the hub on the axis, the rim a square through the rays of offset 4, its
    // corners and middles the ring.
    let ring = [[8, 0], [8, 8], [0, 8], [-8, 8], [-8, 0], [-8, -8], [0, -8], [8, -8]]
        .map(|[y, z]| [2.0, y as f64, z as f64]);
    let picture = see(hub(&ring, [2.0, 0.0, 0.0], json!({})));
    assert!(picture.facet.iter().all(|&f| f >= 0), "{:?}", picture.facet);
    // The hub, in the middle, belongs to all: the lowest index wins. Spoke i belongs to triangles
    // i-1 and i.
    assert_eq!(picture.facet[4 * 9 + 4], 0);
    let at = |y: i32, z: i32| picture.facet[((4 - z) * 9 + (4 - y)) as usize];
    assert_eq!(
        [at(3, 0), at(3, 3), at(0, 3), at(-3, 3), at(-3, 0), at(-3, -3), at(0, -3), at(3, -3)],
        [0, 0, 1, 2, 3, 4, 5, 6]
    );
    assert_eq!(
        [at(4, 1), at(1, 4), at(-1, 4), at(-4, 1), at(-4, -1), at(-1, -4), at(1, -4), at(4, -1)],
        [0, 1, 2, 3, 4, 5, 6, 7]
    );
    near(picture.dist[0], 2.0 * 33f64.sqrt());
}

#[test]
fn h03_a_mesh_of_odd_numbers_has_no_holes() {
    // The hub lies on the axis of a rotated eye but for rounding, the rim far outside: every pixel
    // hits.
    for turn in 0..40 {
        let angle = f64::from(turn) * 0.37;
        let ring: Vec<[f64; 3]> = (0..8)
            .map(|i| {
                let a = f64::from(i) * std::f64::consts::FRAC_PI_4 + angle;
                [2.0 + 0.3 * a.cos(), 20.1 * a.cos(), 20.7 * a.sin()]
            })
            .collect();
        let eye =
            json!({"position": [0.1, 0.2, 0.3], "rotations": [[0, 1, angle * 10.0], [1, 2, angle * 33.0]]});
        let pose = scene(&hub(&ring, [2.0, 0.0, 0.0], eye.clone())).pose.axes();
        let place = |p: [f64; 3]| -> [f64; 3] {
            std::array::from_fn(|i| [0.1, 0.2, 0.3][i] + (0..3).map(|j| pose[j][i] * p[j]).sum::<f64>())
        };
        let ring: Vec<[f64; 3]> = ring.into_iter().map(place).collect();
        let picture = see(hub(&ring, place([2.0, 0.0, 0.0]), eye));
        assert!(picture.facet.iter().all(|&f| f >= 0), "a hole at turn {turn}: {:?}", picture.facet);
    }
}

#[test]
fn h04_coincident_facets_do_not_shadow_each_other_but_a_near_one_does() {
    let sun = json!([{"type": "parallel", "direction": [1, 0]}]);
    let wall = |x: f64| facet(json!([[x, -20], [x, 20]]));
    // 1e-13 apart: a tie (lowest index), and no shadow between them.
    for walls in [[3.0, 3.0], [3.0, 3.0 - 1e-13], [3.0 - 1e-13, 3.0]] {
        let picture = see(plane(json!([wall(walls[0]), wall(walls[1])]), sun.clone()));
        assert_eq!(picture.facet, [0; 9]);
        assert_eq!(picture.lit, [true; 9]);
    }
    // A thousandth before the wall: visible.
    let screen = facet(json!([[2.999, -2.9], [2.999, 2.9]]));
    let picture =
        see(plane(json!([wall(3.0), screen]), json!([{"type": "parallel", "direction": [1, 0.001]}])));
    assert_eq!(picture.facet, [0, 0, 0, 0, 1, 0, 0, 0, 0]);
    // From the eye, offset 1 meets the wall at (3,3): a small facet there blocks the eye's view.
    let hidden = facet(json!([[2.999, 2.95], [2.999, 3.05]]));
    let picture = see(plane(json!([wall(3.0), hidden]), sun));
    assert_eq!((picture.facet[3], picture.facet[4]), (1, 0));
    // The eye sees past the blocker, the light from above is blocked.
    let light = json!([{"type": "radial", "position": [0, 6], "n": 0}]);
    let blocker = facet(json!([[2.999, 3.0005], [2.9995, 3.0015]]));
    let picture = see(plane(json!([wall(3.0), blocker]), light));
    assert_eq!((picture.facet[3], picture.lit[3]), (0, false));
    assert_eq!((picture.facet[4], picture.lit[4]), (0, true));
}

#[test]
fn h05_a_light_on_a_facet_or_at_its_end_does_not_light_it_nor_is_it_shadowed_by_it() {
    let wall = facet(json!([[5, -50], [5, 50]]));
    let lamp = facet(json!([[2, 1], [4, 3]]));
    for position in [[3.0, 2.0], [2.0, 1.0], [4.0, 3.0], [2.7, 1.7]] {
        let lights = json!([{"type": "radial", "position": position, "n": 0}]);
        let picture = see(plane(json!([wall, lamp]), lights));
        // The facet around the light, on y = x - 1, is met by offset c at t = 1 / (1 - c),
        // 2 <= t <= 4: offsets 0.5 .. 0.75, which no pixel has.
        assert_eq!(picture.facet, [0; 9]);
        assert_eq!(picture.lit, [true; 9], "light at {position:?}");
        let mut narrow =
            plane(json!([wall, lamp]), json!([{"type": "radial", "position": position, "n": 0}]));
        narrow["S"] = json!([2.25]); // offsets 1, 0.75, 0.5, 0.25, ..
        let picture = see(narrow);
        assert_eq!(picture.facet, [0, 1, 1, 0, 0, 0, 0, 0, 0]);
        assert_eq!(picture.lit, [true, false, false, true, true, true, true, true, true]);
    }
}

/// Returns the 12 triangles of a unit cube with its low corner at `at`.
fn cube(at: [f64; 3], color: [f64; 3]) -> Vec<Value> {
    let mut facets = Vec::new();
    for axis in 0..3 {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0.0, 1.0] {
            let corner = |u: f64, w: f64| {
                let mut p = at;
                p[axis] += side;
                p[b] += u;
                p[c] += w;
                p
            };
            for v in [
                [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0)],
                [corner(0.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)],
            ] {
                facets.push(json!({"v": v, "color": color}));
            }
        }
    }
    facets
}

#[test]
fn h08_a_unit_cube_a_million_away() {
    let mut facets = cube([1e6, -0.5, -0.5], [200.0; 3]);
    facets.push(json!({"v": [[1000003, -9, -9], [1000003, 20, -9], [1000003, -9, 20]], "color": [9, 9, 9]}));
    let lights = json!([{"type": "parallel", "direction": [1, 0.3, -0.1]}, {"type": "parallel", "direction": [-1, 0.3, -0.1]}]);
    let picture = see(
        json!({"dim": 3, "pixels": [16, 16], "d": 1, "S": [1.6e-6, 1.6e-6], "I_d": 0.1, "lights": lights, "facets": facets}),
    );
    for j in 0..16 {
        for i in 0..16 {
            // Offsets 0.75, 0.65, .. -0.75 at the cube's front, x = 1e6: the front face has
            // |y| < 0.5 and |z| < 0.5.
            let at = j * 16 + i;
            let on_cube = (3..13).contains(&i) && (3..13).contains(&j);
            if on_cube {
                // Face x = 1e6 is facets 0 and 1, lit by the first sun alone.
                assert!(picture.facet[at] == 0 || picture.facet[at] == 1, "{i} {j}");
                assert_eq!(picture.flags(at), [true, false]);
                near(picture.dist[at], 1e6);
            } else {
                assert_eq!(picture.facet[at], 12, "{i} {j}");
            }
        }
    }
    // The first sun casts the cube's shadow on a wall 3 further away: shifted by 0.9 in y and -0.3
    // in z at most.
    let flag = |i: usize, j: usize| picture.flags(j * 16 + i)[0];
    assert!(!flag(2, 8) && flag(13, 8) && flag(8, 2) && flag(2, 2));
}

#[test]
fn h09_collinear_and_repeated_are_skipped_and_a_needle_is_kept() {
    let picture = see(json!({"dim": 3, "pixels": [3, 3], "d": 1, "S": [0.3, 0.3], "I_d": 1, "facets": [
        facet(json!([[3, 0, 0], [3, 1, 1], [3, 2, 2]])),
        facet(json!([[3, 0.1, 0.1], [3, 0.2, 0.2], [3, 0.3, 0.3]])),
        facet(json!([[2, -1, 0], [2, 1, 1], [2, -1, 0]])),
        facet(json!([[2, 5, 5], [2, 5, 5], [2, 5, 5]])),
        // A million times as long as wide, through the middle.
        facet(json!([[4, -500000, -0.25], [4, 500000, 0], [4, -500000, 0.25]])),
        facet(json!([[9, -90, -90], [9, 90, -90], [9, 0, 90]]))
    ]}));
    assert_eq!(picture.skipped_facets, [0, 1, 2, 3]);
    assert_eq!(picture.facet, [5, 5, 5, 4, 4, 4, 5, 5, 5]);
    // In the plane two equal ends are the only degenerate facet.
    let picture =
        see(plane(json!([facet(json!([[1, 1], [1, 1]])), facet(json!([[1, -4], [1, 4]]))]), json!([])));
    assert_eq!((picture.skipped_facets, picture.facet), (vec![0], vec![1; 9]));
}

#[test]
fn h12_a_triangle_through_the_eye_is_invisible_and_a_duplicate_is_the_lower_index() {
    let triangle = json!([[2, -1, -0.5], [2, 1, -0.5], [2.5, 0, 0.5]]);
    let picture =
        see(json!({"dim": 3, "pixels": [7], "d": 1, "S": [1.4], "aperture_tan": [0.5], "I_d": 1, "facets": [
            // Its plane y = x / 4 contains the eye, and fills the fibres it meets.
            facet(json!([[1, 0.25, -1], [3, 0.75, 1], [1, 0.25, 1]])),
            facet(json!([[1.1, 0.11, -1], [3.3, 0.33, 1], [1.1, 0.11, 1]])),
            facet(triangle.clone()),
            facet(triangle)
        ]}));
    // Offsets 0.6, 0.4, .. -0.6; the triangle spans |y| / x up to 0.5.
    assert_eq!(picture.facet, [-1, 2, 2, 2, 2, 2, -1]);
    // On the axis the nearest point is (2 + (z + 0.5) / 2, 0, z) with least square: z = -0.45 by
    // the foot, within the triangle.
    // Plane x - z / 2 = 2.25: foot = 2.25 (1, 0, -1/2) / 1.25 = (1.8, 0, -0.9) lies below z = -0.5:
    // so (2, 0, -0.5).
    near(picture.dist[3], (4.0f64 + 0.25).sqrt());
}

#[test]
fn rooms_are_lit_everywhere() {
    // Eye and lights inside a closed, rotated cube of R^N: every pixel hits and is lit; an unlit
    // one would be shadow acne.
    for (dim, pixels) in [
        (2, vec![64]),
        (3, vec![24, 24]),
        (3, vec![64]),
        (4, vec![8, 8, 8]),
        (4, vec![12, 12]),
        (5, vec![6, 5]),
        (4, vec![16]),
    ] {
        let mut shape = fbptr::eye::shapes::cube(dim).unwrap();
        for axis in 1..dim {
            shape = shape.turned(0, axis, 17.0 + 5.0 * axis as f64);
        }
        let facets: Vec<Value> = shape
            .placed(3.0, &vec![0.1; dim])
            .facets(|c| [f64::from(c); 3])
            .into_iter()
            .map(|f| json!({"v": f.v, "color": f.color}))
            .collect();
        let place = |x: f64| (0..dim).map(|i| x * (1.0 - 0.3 * i as f64)).collect::<Vec<_>>();
        let hidden = dim - 1 - pixels.len();
        let mut value = json!({"dim": dim, "pixels": pixels, "d": 1, "S": vec![2; pixels.len()], "I_d": 0.1, "facets": facets,
            "lights": [{"type": "radial", "position": place(0.5), "n": 0}, {"type": "radial", "position": place(-0.7), "n": 0}]});
        if hidden > 0 {
            value["aperture_tan"] = json!(vec![0.5; hidden]);
        }
        let picture = see(value);
        assert!(picture.facet.iter().all(|&f| f >= 0), "{dim} on {pixels:?}");
        assert!(picture.lit.iter().all(|&l| l), "acne in {dim} on {pixels:?}");
    }
}

//! Screen vertices compared with the plain path's steps.

use super::*;
use crate::simd::Level;

const UNIT: [[f64; 4]; 3] = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.]];

#[test]
fn records_hold_the_floor_and_the_snap_of_every_position() {
    let to_screen = ToScreen {
        model: UNIT,
        view: UNIT,
        projection: [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 0.5, 0.], [0., 0., 0., 2.0]],
        center: [100.0, 50.0],
        half: [100.0, -50.0],
        sides: [[0.0, 200.0], [0.0, 100.0]],
    };
    let n = 1003;
    // Quarters of 1/256 pixel, so that ties and both neighbours occur, and values off the frame.
    let xs: Vec<f64> = (0..n).map(|i| (i as f64 - 300.0) / 51200.0).collect();
    let ys: Vec<f64> = (0..n).map(|i| (i as f64 * 7.0 - 300.0) / 25600.0 / 4.0).collect();
    let zs: Vec<f64> = (0..n).map(|i| i as f64 / n as f64).collect();
    let mut first: Option<Vec<ScreenVertex>> = None;
    for level in Level::ALL {
        let mut screen_vertices = vec![[0f32; 4]; n];
        level.dispatch(VertexKernel {
            positions: [&xs, &ys, &zs],
            projector: &Projector::new(to_screen, &to_screen.to_view(), [1.0; 3]),
            marks: &[],
            screen_vertices: &mut screen_vertices,
        });
        for i in 0..n {
            let sx = 100.0 + xs[i] * 0.5 * 100.0;
            let sy = 50.0 + ys[i] * 0.5 * -50.0;
            let bits = screen_vertices[i].map(|v| v.to_bits());
            for (axis, s) in [sx, sy].into_iter().enumerate() {
                assert_eq!(bits[axis] as i32, (s * 65536.0).floor() as i32);
                let snapped = ((bits[axis] as i32) >> 8) + (bits[3] >> axis & 1) as i32;
                assert_eq!(snapped as f64, (s * 256.0).round_ties_even(), "vertex {i} at {s}");
            }
            assert!((f32::from_bits(bits[3]) - 0.5).abs() < 3e-7);
        }
        let same = first.get_or_insert_with(|| screen_vertices.clone());
        assert!(
            same.iter().zip(&screen_vertices).all(|(a, b)| a.map(f32::to_bits) == b.map(f32::to_bits)),
            "{level:?}"
        );
    }
}

/// Returns the positions by the plain path's steps: floors in 1/65536 pixel, and the snapped
/// values.
fn steps(t: &ToScreen, p: [f64; 3]) -> [[i64; 2]; 2] {
    let row = |[a, b, c, d]: [f64; 4], [x, y, z]: [f64; 3]| ((a * x + b * y) + c * z) + d;
    let world = t.model.map(|r| row(r, p));
    let view = t.view.map(|r| row(r, world));
    let clip = t.projection.map(|r| row(r, view));
    [0, 1].map(|axis| {
        let s = t.center[axis] + clip[axis] / clip[3] * t.half[axis];
        [(s * 65536.0).floor() as i64, (s * 256.0).round_ties_even() as i64]
    })
}

fn places_are_those_of_the_steps(t: ToScreen, points: &[[f64; 3]]) {
    let axis = |axis: usize| points.iter().map(|p| p[axis]).collect::<Vec<_>>();
    let (xs, ys, zs) = (axis(0), axis(1), axis(2));
    let far = |list: &[f64]| list.iter().fold(0.0f64, |far, v| far.max(v.abs()));
    let projector = &Projector::new(t, &t.to_view(), [far(&xs), far(&ys), far(&zs)]);
    let mut screen_vertices = vec![[0f32; 4]; points.len()];
    Level::best().dispatch(VertexKernel {
        positions: [&xs, &ys, &zs],
        projector,
        marks: &[],
        screen_vertices: &mut screen_vertices,
    });
    for (p, record) in points.iter().zip(&screen_vertices) {
        let bits = record.map(f32::to_bits);
        if bits[3] == 0 {
            continue;
        }
        let found = [0, 1].map(|axis| {
            let floor = bits[axis] as i32;
            [floor as i64, ((floor >> 8) + (bits[3] >> axis & 1) as i32) as i64]
        });
        assert_eq!(found, steps(&t, *p), "{p:?}");
    }
}

#[test]
fn one_matrix_gives_the_places_of_the_steps_where_they_are_ties_too() {
    // An object far from the origin, seen from nearby, turned by a right angle: whole and half
    // 1/256 pixels, hit or just missed.
    for away in [0.0, 1.0 / 3.0, 1e3, 1e6] {
        let t = ToScreen {
            model: [[0., -1.0, 0., away], [1., 0., 0., away], [0., 0., 1., 0.]],
            view: [[1., 0., 0., -away], [0., 1., 0., -away], [0., 0., 1., -3.0]],
            projection: [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., -1.1, -1.1], [0., 0., -1.0, 0.]],
            center: [256.0, 256.0],
            half: [256.0, -256.0],
            sides: [[0.0, 512.0], [0.0, 512.0]],
        };
        let points: Vec<[f64; 3]> = (0..4000)
            .map(|i| {
                [(i % 63 - 31) as f64 / 65536.0 * 2.0, (i / 63 - 31) as f64 / 131072.0, 1.0 + (i % 3) as f64]
            })
            .collect();
        places_are_those_of_the_steps(t, &points);
    }
}

#[test]
fn where_one_matrix_would_put_a_vertex_elsewhere_the_steps_decide() {
    // Scaled by 0.7 and by its inverse: 1 as a product, but not always step by step.
    let scaled = |by: f64| [[by, 0., 0., 0.], [0., by, 0., 0.], [0., 0., 1., 0.]];
    let t = ToScreen {
        model: scaled(0.7),
        view: scaled(1.0 / 0.7),
        projection: [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 0.5, 0.], [0., 0., 0., 1.0]],
        center: [0.0; 2],
        half: [1.0, 1.0],
        sides: [[0.0, 100.0], [0.0, 100.0]],
    };
    // On multiples of 1/65536 pixel, where the last bit decides the floor.
    let points: Vec<[f64; 3]> =
        (0..4000).map(|i| [(i * 1237) as f64 / 65536.0, (i * 977) as f64 / 65536.0, 0.5]).collect();
    let elsewhere = |p: &&[f64; 3]| steps(&t, **p)[0][0] != (p[0] * 65536.0) as i64;
    let moved = points.iter().filter(elsewhere).count();
    assert!(moved > 100, "{moved} of these tell the steps from their product");
    places_are_those_of_the_steps(t, &points);
}

proptest::proptest! {
    #[test]
    fn one_matrix_gives_the_places_of_the_steps(
        model in proptest::array::uniform3(proptest::array::uniform4(-2.0f64..2.0)),
        turn in 0.0f64..6.3,
        size in proptest::sample::select(vec![1e-3, 1.0, 1e4]),
        points in proptest::collection::vec(proptest::array::uniform3(-1.0f64..1.0), 64),
    ) {
        let (sin, cos) = libm::sincos(turn);
        let t = ToScreen {
            model,
            view: [[cos, 0., sin, 0.1], [0., 1., 0., 0.2], [-sin, 0., cos, -4.0 * size]],
            projection: [[1.3, 0., 0.05, 0.], [0., 1.7, 0., 0.], [0., 0., -1.1, -1.1], [0., 0., -1.0, 0.]],
            center: [960.5, 540.0],
            half: [960.0, -540.0],
            sides: [[0.0, 1920.0], [0.0, 1080.0]],
        };
        let points: Vec<[f64; 3]> = points.iter().map(|p| p.map(|v| v * size)).collect();
        places_are_those_of_the_steps(t, &points);
    }
}

#[test]
fn what_a_record_cannot_hold_says_where_it_is() {
    let projection = [[1.0, 0., 0., 0.], [0., 1.0, 0., 0.], [0., 0., 1.0, 0.], [0., 0., 1.0, 0.]];
    let to_screen = ToScreen {
        model: UNIT,
        view: UNIT,
        projection,
        center: [0.0; 2],
        half: [10.0, -10.0],
        sides: [[0.0, 10.0], [0.0, 10.0]],
    };
    let xs = [1.0, 1.0, 1e9, f64::NAN, 1.0];
    let zs = [0.0, -1.0, 1.0, 1.0, 1e-300];
    let mut screen_vertices = vec![[1f32; 4]; 5];
    Level::best().dispatch(VertexKernel {
        positions: [&xs, &[0.0; 5], &zs],
        projector: &Projector::new(to_screen, &to_screen.to_view(), [1e9, 0.0, 1.0]),
        marks: &[],
        screen_vertices: &mut screen_vertices,
    });
    assert!(screen_vertices.iter().all(|r| r[3] == 0.0), "{screen_vertices:?}");
    let codes: Vec<i32> = screen_vertices.iter().map(|r| r[0].to_bits() as i32).collect();
    let right = Outcode::SIDES[1];
    assert_eq!(codes, [Outcode::BEHIND, Outcode::BEHIND | Outcode::NEAR, right, 0, right]);
}

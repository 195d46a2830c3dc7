//! Culled clusters compared with every single face.

use super::*;
use crate::math::coverage::SnappedTriangle;
use crate::pipeline::indexed_mesh::{CLUSTER_FACES, IndexedMesh};
use crate::scene::shapes;
use crate::simd::Level;
use glam::{DMat4, DQuat, DVec3};
use proptest::prelude::*;
use std::cmp::Ordering;

const SIZE: [i32; 2] = [640, 400];

fn rows(m: &DMat4) -> [[f64; 4]; 4] {
    m.transpose().to_cols_array_2d()
}

/// Matrices to a frame of SIZE, and the row of w - z.
fn to_screen(model: DMat4, view: DMat4, projection: DMat4) -> (ToScreen, [f64; 4]) {
    let three = |m: &DMat4| [0, 1, 2].map(|i| rows(m)[i]);
    let half = SIZE.map(|s| s as f64 * 0.5);
    let t = ToScreen {
        model: three(&model),
        view: three(&view),
        projection: rows(&projection),
        center: half,
        half: [half[0], -half[1]],
        sides: [[0.0, SIZE[0] as f64], [0.0, SIZE[1] as f64]],
    };
    (t, (projection.row(3) - projection.row(2)).to_array())
}

/// Returns the cull view of a draw into the whole frame.
fn outlook_of(
    farthest: [f64; 3],
    model: DMat4,
    view: DMat4,
    projection: DMat4,
    winding: Winding,
) -> CullView {
    let (t, complement) = to_screen(model, view, projection);
    let full_view = PixelRect { x0: 0, y0: 0, x1: SIZE[0], y1: SIZE[1] };
    CullView::new(&t, &t.to_view(), farthest, complement, &full_view, winding)
}

fn visibilities(level: Level, clusters: &Clusters, cull_view: &CullView, marks: &[AtomicU8]) -> Vec<u8> {
    let mut visibilities = vec![9; clusters.len()];
    level.dispatch(ClusterKernel { clusters, first: 0, cull_view, visibilities: &mut visibilities, marks });
    visibilities
}

/// Returns whether a single face is culled as `visibility` says, by the steps of set-up.
fn is_left_out(visibility: u8, clip: [DVec4; 3], winding: Winding) -> bool {
    let half = SIZE.map(|s| s as f64 * 0.5);
    let screen = clip.map(|c| [half[0] + c.x / c.w * half[0], half[1] - c.y / c.w * half[1]]);
    let all = |beyond: &dyn Fn(usize) -> bool| (0..3).all(beyond);
    match visibility {
        Visibility::OUTSIDE => {
            let before = all(&|i| clip[i].w > 0.0);
            all(&|i| clip[i].w <= 0.0)
                || all(&|i| clip[i].z < 0.0)
                || all(&|i| clip[i].z > clip[i].w)
                || before
                    && (0..2).any(|axis| {
                        all(&|i| screen[i][axis] < -1.0)
                            || all(&|i| screen[i][axis] > SIZE[axis] as f64 + 1.0)
                    })
        }
        Visibility::CULLED => {
            let inside = all(&|i| {
                let c = clip[i];
                c.w > 0.0
                    && c.z >= 0.0
                    && c.z <= c.w
                    && (0..2).all(|a| (0.0..=SIZE[a] as f64).contains(&screen[i][a]))
            });
            let flip_normal = match winding {
                Winding::CounterClockwise => Ordering::Greater,
                Winding::Clockwise => Ordering::Less,
                Winding::Both => return false,
            };
            inside && SnappedTriangle::new(screen).orientation() == flip_normal
        }
        _ => true,
    }
}

/// Returns clip coordinates as the plain path computes them, one matrix after the other.
fn by_steps([model, view, projection]: [DMat4; 3], position: [f64; 3]) -> DVec4 {
    projection * (view * (model * DVec3::from_array(position).extend(1.0)))
}

/// Compares every face with its cluster's visibility; returns how many clusters are open, culled
/// and outside.
fn check(mesh: &IndexedMesh, model: DMat4, view: DMat4, projection: DMat4, winding: Winding) -> [usize; 3] {
    let cull_view = outlook_of(mesh.farthest, model, view, projection, winding);
    let marks: Vec<AtomicU8> = (0..mesh.vertex_count().div_ceil(WIDTH)).map(|_| AtomicU8::new(0)).collect();
    let found = visibilities(Level::best(), &mesh.clusters, &cull_view, &marks);
    for level in Level::ALL {
        assert_eq!(visibilities(level, &mesh.clusters, &cull_view, &[]), found, "{level:?}");
    }
    let mut counts = [0; 3];
    for f in 0..mesh.triangle_count {
        let visibility = found[f / CLUSTER_FACES];
        counts[visibility as usize] += usize::from(f % CLUSTER_FACES == 0);
        let clip = [0, 1, 2].map(|k| {
            let vertex = mesh.corners[k][f] as usize;
            let marked = marks[vertex / WIDTH].load(Relaxed) == 1;
            assert!(visibility != Visibility::OPEN || marked, "face {f}'s vertex {vertex} is not asked for");
            by_steps([model, view, projection], [0, 1, 2].map(|axis| mesh.positions[axis][vertex]))
        });
        assert!(is_left_out(visibility, clip, winding), "face {f} of fate {visibility}: {clip:?}");
    }
    counts
}

fn knot(nu: u32, nv: u32) -> IndexedMesh {
    IndexedMesh::new(&shapes::knot(nu, nv).expect("a knot"), |_, _| DVec3::Z, &Default::default())
}

fn perspective(near: f64, far: f64) -> DMat4 {
    let (f, aspect) = (1.7, SIZE[0] as f64 / SIZE[1] as f64);
    let a = far / (far - near);
    DMat4::from_cols_array_2d(&[
        [f / aspect, 0.0, 0.0, 0.0],
        [0.0, f, 0.0, 0.0],
        [0.0, 0.0, -a, -1.0],
        [0.0, 0.0, -a * near, 0.0],
    ])
}

fn parallel(height: f64, depth: f64) -> DMat4 {
    let aspect = SIZE[0] as f64 / SIZE[1] as f64;
    DMat4::from_cols_array_2d(&[
        [1.0 / (height * aspect), 0.0, 0.0, 0.0],
        [0.1, 1.0 / height, 0.0, 0.0],
        [0.0, 0.0, -1.0 / depth, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ])
}

#[test]
fn half_of_a_fine_knot_is_left_out_and_every_face_of_it_rightly() {
    let mesh = knot(300, 80);
    let (view, model) = (DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0)), DMat4::from_rotation_x(0.3));
    for (winding, projection) in [
        (Winding::CounterClockwise, perspective(1.0, 10.0)),
        (Winding::Clockwise, perspective(1.0, 10.0)),
        (Winding::CounterClockwise, parallel(2.5, 10.0)),
    ] {
        let [open, culled, outside] = check(&mesh, model, view, projection, winding);
        assert!(
            culled * 3 > open && outside == 0,
            "{winding:?}: {open} open, {culled} culled, {outside} outside"
        );
    }
    let [_, culled, outside] = check(&mesh, model, view, perspective(1.0, 10.0), Winding::Both);
    assert_eq!((culled, outside), (0, 0));
    // From its centre: faces behind the eye, beside the view volume and before near.
    let [open, _, outside] =
        check(&mesh, model, DMat4::IDENTITY, perspective(0.1, 10.0), Winding::CounterClockwise);
    assert!(outside > open, "{open} open, {outside} outside");
}

#[test]
fn coarse_odd_and_broken_meshes_leave_nothing_out_wrongly() {
    assert_eq!(knot(20, 20).clusters.len(), 0, "a mesh of few faces has no clusters");
    let mut mesh = shapes::knot(64, 16).expect("a knot");
    mesh.positions[7] = DVec3::NAN;
    mesh.positions[300] = DVec3::splat(1e300);
    mesh.positions[500] = mesh.positions[501];
    let mesh = IndexedMesh::new(&mesh, |_, _| DVec3::Z, &Default::default());
    let view = DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0));
    let steps = [DMat4::IDENTITY, view, perspective(1.0, 10.0)];
    let outlook_from =
        |farthest, view| outlook_of(farthest, steps[0], view, steps[2], Winding::CounterClockwise);
    let found = visibilities(Level::best(), &mesh.clusters, &outlook_from(mesh.farthest, view), &[]);
    for f in 0..mesh.triangle_count {
        let clip = [0, 1, 2].map(|k| {
            let vertex = mesh.corners[k][f] as usize;
            by_steps(steps, [0, 1, 2].map(|axis| mesh.positions[axis][vertex]))
        });
        let visibility = found[f / CLUSTER_FACES];
        assert!(
            is_left_out(visibility, clip, Winding::CounterClockwise),
            "face {f} of fate {visibility}: {clip:?}"
        );
    }
    // Beside the view volume no cluster with a corner that is not finite counts as outside.
    let view_beside = DMat4::from_translation(DVec3::new(90.0, 0.0, -5.0));
    let found = visibilities(Level::best(), &mesh.clusters, &outlook_from([9.0; 3], view_beside), &[]);
    assert!(found.contains(&Visibility::OUTSIDE));
    for f in 0..mesh.triangle_count {
        let is_nowhere = (0..3).any(|k| mesh.positions[0][mesh.corners[k][f] as usize].is_nan());
        assert!(!is_nowhere || found[f / CLUSTER_FACES] == Visibility::OPEN, "face {f}");
    }
    // Matrices without an inverse, and with NaN.
    for odd in
        [DMat4::ZERO, DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0)), DMat4::NAN, DMat4::IDENTITY * 1e300]
    {
        let cull_view = outlook_of(mesh.farthest, odd, view, steps[2], Winding::CounterClockwise);
        let found = visibilities(Level::best(), &mesh.clusters, &cull_view, &[]);
        assert!(!found.contains(&Visibility::CULLED), "{odd:?}");
    }
}

/// Returns the visibility of a cluster whose faces, large and turned away from an eye at z > 0, all
/// lie at one point.
fn fate_of_point(cull_view: &CullView, point: DVec3) -> u8 {
    let lane = |v: f64| [v; WIDTH];
    let (zero, large) = (lane(0.0), lane(1e9));
    let [x, y, z] = point.to_array().map(lane);
    decide(cull_view, &[x, y, z, zero, zero, zero, lane(-1.0), lane(1.0), large, zero])[0]
}

#[test]
fn what_the_steps_roundings_move_over_a_side_is_left_to_single_faces() {
    // A large translation and its inverse: the steps lose 1e-10, their product nothing.
    let away = DVec3::new(1.1e6, -0.9e6, 1.3e6);
    let model = DMat4::from_translation(away);
    let view = DMat4::from_translation(-away) * DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0));
    let (mut moved, mut visibilities) = ([0; 2], [0; 3]);
    for projection in [perspective(1.0, 10.0), parallel(2.5, 10.0)] {
        let cull_view = outlook_of([3.0; 3], model, view, projection, Winding::CounterClockwise);
        for i in 0..6000u32 {
            // Points all over the view, on one of its planes: within the error of the steps, and
            // slightly beyond.
            let spread = |k: u32| f64::from((i * 7919 + k * 104_729) % 1009) / 504.5 - 1.0;
            let free = DVec3::new(spread(1), spread(2), spread(3));
            let plane = cull_view.planes[i as usize % 6];
            let normal = DVec3::new(plane[0], plane[1], plane[2]);
            let off = spread(4) * if i % 4 == 0 { 1e-2 } else { 2e-10 };
            let point = free - normal * (normal.dot(free) + plane[3] - off);
            let visibility = fate_of_point(&cull_view, point);
            let clip = by_steps([model, view, projection], point.to_array());
            let screen = [0, 1].map(|a| {
                let side = if a == 0 { 0.5 } else { -0.5 } * SIZE[a] as f64;
                SIZE[a] as f64 * 0.5 + clip[a] / clip.w * side
            });
            let is_inside = (0..2).all(|a| (0.0..=SIZE[a] as f64).contains(&screen[a]))
                && (0.0..=clip.w).contains(&clip.z);
            let is_deep = clip.z < 0.0 || clip.z > clip.w;
            moved[0] += usize::from(off > 0.0 && !is_inside);
            moved[1] += usize::from(off < 0.0 && i % 6 > 3 && !is_deep);
            visibilities[visibility as usize] += 1;
            match visibility {
                Visibility::CULLED => assert!(is_inside, "{point:?} at {screen:?} is not wholly inside"),
                Visibility::OUTSIDE => {
                    let is_beside = (0..2).any(|a| screen[a] < -1.0 || screen[a] > SIZE[a] as f64 + 1.0);
                    assert!(is_deep || is_beside, "{point:?} at {screen:?} is not outside");
                }
                _ => {}
            }
        }
    }
    // Without the margin, clusters at points that the steps place on the other side would be
    // culled.
    assert!(moved.iter().all(|m| *m > 100), "{moved:?} points moved over a side");
    assert!(visibilities.iter().all(|f| *f > 100), "open, culled, outside: {visibilities:?}");
}

#[test]
fn where_the_steps_lose_whole_pixels_nothing_is_culled_wrongly() {
    let mesh = knot(300, 80);
    for away in [1e12, 1e13, 2e13, 4e13, 6e13] {
        let away = DVec3::splat(away);
        let model = DMat4::from_translation(away) * DMat4::from_scale(DVec3::splat(0.5));
        let view = DMat4::from_translation(-away) * DMat4::from_translation(DVec3::new(0.0, 0.0, -5.0));
        check(&mesh, model, view, parallel(2.5, 10.0), Winding::CounterClockwise);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn whatever_is_left_out_is_left_out_rightly(
        turn in prop::array::uniform3(-3.2f64..3.2),
        scale in prop::array::uniform3(prop_oneof![-3.0f64..-0.2, 0.2f64..3.0]),
        at in prop::array::uniform3(-4.0f64..4.0),
        far_away in prop_oneof![Just(0.0), Just(1e3), Just(1e6)],
        near in 0.01f64..2.0,
        is_parallel: bool,
        clockwise: bool,
    ) {
        let mesh = knot(64, 24);
        let away = DVec3::splat(far_away);
        let model = DMat4::from_translation(away)
            * DMat4::from_quat(DQuat::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]))
            * DMat4::from_scale(DVec3::from_array(scale));
        let view = DMat4::from_translation(DVec3::from_array(at) - DVec3::Z * 4.0)
            * DMat4::from_translation(-away);
        let projection = if is_parallel { parallel(3.0, 12.0) } else { perspective(near, 12.0) };
        let winding = if clockwise { Winding::Clockwise } else { Winding::CounterClockwise };
        check(&mesh, model, view, projection, winding);
    }
}

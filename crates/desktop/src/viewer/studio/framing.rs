//! Framing: the camera from which a model fills a fixed part of the frame.
//!
//! In: the model's points, the aspect of the frame. Out: a perspective camera at three quarters,
//! from the model's front, in which the box around the drawn points is centred and its larger side
//! is [`FILL`] of the frame's. A perspective picture of a convex hull is the hull of the projected
//! points, so the box of the points is that of all faces between them.

use fbptr_core::scene::{Camera, LookAt, Mesh, Projection, Scene, frame_mesh};
use glam::{DMat3, DVec3};

/// Part of the frame that a model fills: its box is as wide or as high.
pub(in crate::viewer) const FILL: f64 = 0.8;

/// Full angle of the field of view on the frame's smaller side: 35 degrees in radians.
const FOV_RAD: f64 = 35.0 * std::f64::consts::PI / 180.0;

/// Direction from the model to the eye: three quarters, a little from above.
const THREE_QUARTERS: DVec3 = DVec3::new(0.75, 0.42, 1.0);

/// Positions of a turning model for which the frame must have room.
const TURNS: u32 = 24;

/// Corrections of distance and centre; each reduces the error by a factor of three or more.
const ROUNDS: u32 = 40;

/// Returns the camera of a mesh for a frame of `aspect` = width / height; see [`framed_points`].
pub(in crate::viewer) fn framed_mesh(mesh: &Mesh, aspect: f64, is_open: bool, turns: bool) -> Camera {
    let Some(bounds) = mesh.bounds() else { return Camera::default() };
    // The side from which faces are seen, as `fbptr render` chooses it.
    let usual = frame_mesh(mesh, bounds, aspect, is_open);
    let side = usual.look_at.eye - usual.look_at.reference;
    framed_points(used_points(mesh).collect(), side, aspect, turns)
        .filter(|camera| camera.matrices(aspect).is_ok())
        .unwrap_or(usual)
}

/// Returns the camera of all objects of a scene; see [`framed_points`].
pub(in crate::viewer) fn framed_scene(scene: &Scene, aspect: f64, turns: bool) -> Option<Camera> {
    let points = scene
        .objects
        .iter()
        .flat_map(|object| used_points(&object.geometry.mesh).map(|p| object.model.transform_point3(p)));
    framed_points(points.collect(), THREE_QUARTERS, aspect, turns)
}

/// Returns the faces of all objects of a scene as one mesh of positions in world space.
pub(in crate::viewer) fn world_mesh(scene: &Scene) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for object in &scene.objects {
        let mesh = &object.geometry.mesh;
        let first = positions.len() as u32;
        positions.extend(mesh.positions.iter().map(|p| object.model.transform_point3(*p)));
        let position = |corner: u32| first + mesh.corners[corner as usize].position;
        triangles.extend(mesh.triangles.iter().map(|t| t.map(position)));
    }
    Mesh::from_triangles(positions, &triangles)
}

/// Returns the points of a mesh that are corners of something drawn.
fn used_points(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    let mut is_used = vec![false; mesh.positions.len()];
    mesh.corners.iter().for_each(|c| is_used[c.position as usize] = true);
    mesh.positions.iter().zip(is_used).filter(|(_, is_used)| *is_used).map(|(p, _)| *p)
}

/// Returns the camera of some points, on the side of the axes that `side` has the signs of. With
/// `turns`, the points have room while they turn about the upright axis through the middle of their
/// box, and fill [`FILL`] where they are widest. Points without extent have no camera.
fn framed_points(mut points: Vec<DVec3>, side: DVec3, aspect: f64, turns: bool) -> Option<Camera> {
    let z = DVec3::from_array([0, 1, 2].map(|i| THREE_QUARTERS[i] * side[i].signum()));
    points.retain(|p| p.is_finite());
    let [low, high] = points
        .iter()
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], p| [low.min(*p), high.max(*p)]);
    let middle = low / 2.0 + high / 2.0;
    points.iter_mut().for_each(|p| *p -= middle);
    let reach = points.iter().fold(0.0_f64, |m, p| m.max(p.length()));
    if !(reach > 1e-150 && reach < 1e150 && middle.is_finite()) {
        return None;
    }
    let turned = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / f64::from(TURNS);
        DMat3::from_cols(
            DVec3::new(libm::cos(angle), 0.0, -libm::sin(angle)),
            DVec3::Y,
            DVec3::new(libm::sin(angle), 0.0, libm::cos(angle)),
        )
    };
    let turns: Vec<DMat3> = if turns { (0..TURNS).map(turned).collect() } else { vec![DMat3::IDENTITY] };
    let mut camera = fill(&hull_like(points), &turns, z.normalize(), aspect, reach);
    camera.look_at.eye += middle;
    camera.look_at.reference += middle;
    Some(camera)
}

/// Keeps of many points those that lie farthest in some direction, and of few all of them.
fn hull_like(points: Vec<DVec3>) -> Vec<DVec3> {
    const FEW: usize = 4096;
    /// Directions around and up: a point left out is less than 0.1 % of the size inside the hull.
    const AROUND: u32 = 96;
    const UP: u32 = 48;
    if points.len() <= FEW {
        return points;
    }
    // Points in one of many cells of directions: the farthest of each direction is kept.
    let mut farthest = vec![(0.0_f64, None); (AROUND * UP) as usize];
    for p in &points {
        let around = (libm::atan2(p.z, p.x) / std::f64::consts::TAU + 0.5) * f64::from(AROUND);
        let up = (p.y / p.length().max(f64::MIN_POSITIVE) / 2.0 + 0.5) * f64::from(UP);
        let cell = (up as u32).min(UP - 1) * AROUND + (around as u32).min(AROUND - 1);
        let best = &mut farthest[cell as usize];
        if p.length_squared() > best.0 {
            *best = (p.length_squared(), Some(*p));
        }
    }
    // The extremes along many axes are exact, whatever cell they lie in.
    let axes = (0..64).map(|i| {
        let (y, angle) = (1.0 - (f64::from(i) + 0.5) / 32.0, f64::from(i) * 2.399_963_229_728_653);
        let r = (1.0 - y * y).sqrt();
        DVec3::new(r * libm::cos(angle), y, r * libm::sin(angle))
    });
    let extreme =
        axes.filter_map(|axis| points.iter().copied().max_by(|a, b| axis.dot(*a).total_cmp(&axis.dot(*b))));
    let extreme: Vec<DVec3> = extreme.collect();
    farthest.into_iter().filter_map(|(_, p)| p).chain(extreme).collect()
}

/// Returns the camera along `z` in which the points, in all their turns, fill the frame.
fn fill(points: &[DVec3], turns: &[DMat3], z: DVec3, aspect: f64, reach: f64) -> Camera {
    let x = DVec3::Y.cross(z).normalize();
    let y = z.cross(x);
    let tan = libm::tan(FOV_RAD / 2.0);
    let tan = [tan * aspect.max(1.0), tan * (1.0 / aspect).max(1.0)];
    let (mut reference, mut distance) = (DVec3::ZERO, 2.0 * reach / tan[0].min(tan[1]));
    let mut depths = [0.0, 0.0];
    for _ in 0..ROUNDS {
        let eye = reference + z * distance;
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        depths = [f64::INFINITY, f64::NEG_INFINITY];
        for turn in turns {
            for p in points {
                let v = *turn * *p - eye;
                let depth = -v.dot(z);
                depths = [depths[0].min(depth), depths[1].max(depth)];
                for (axis, along) in [x, y].into_iter().enumerate() {
                    let at = v.dot(along) / (depth.max(1e-3 * reach) * tan[axis]);
                    (low[axis], high[axis]) = (low[axis].min(at), high[axis].max(at));
                }
            }
        }
        let part = ((high[0] - low[0]) / 2.0).max((high[1] - low[1]) / 2.0);
        let off = [0, 1].map(|i| (low[i] + high[i]) / 2.0 * distance * tan[i]);
        // A turning model keeps the axis in the middle.
        if turns.len() == 1 {
            reference += x * off[0];
        }
        reference += DVec3::Y * (off[1] / y.y);
        distance *= (part / FILL).clamp(0.5, 2.0);
    }
    let (nearest, farthest) = (depths[0].max(1e-3 * distance), depths[1].max(2e-3 * distance));
    Camera {
        look_at: LookAt { eye: reference + z * distance, reference, up: y },
        projection: Projection::Perspective {
            fov_rad: FOV_RAD,
            near: nearest * 0.5,
            far: farthest * 1.2,
            on_smaller_side: true,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::shapes;

    /// The box of a mesh's points in NDC.
    fn seen(mesh: &Mesh, camera: &Camera, aspect: f64) -> [f64; 4] {
        let m = camera.matrices(aspect).expect("a camera");
        mesh.positions.iter().fold([f64::MAX, f64::MIN, f64::MAX, f64::MIN], |[l, r, b, t], p| {
            let clip = m.projection * (m.view * p.extend(1.0));
            let ndc = clip / clip.w;
            assert!((0.0..1.0).contains(&ndc.z), "{ndc}");
            [l.min(ndc.x), r.max(ndc.x), b.min(ndc.y), t.max(ndc.y)]
        })
    }

    #[test]
    fn a_model_fills_four_fifths_in_the_middle() {
        let long = shapes::cuboid(DVec3::new(9.0, 0.5, 0.5)).expect("a size");
        let tall = shapes::cuboid(DVec3::new(0.1, 70.0, 0.1)).expect("a size");
        let meshes =
            [shapes::teapot(6).expect("a level"), shapes::knot(300, 30).expect("a knot"), long, tall];
        for (i, mesh) in meshes.into_iter().enumerate() {
            for aspect in [0.5, 1.0, 4.0 / 3.0, 2.4] {
                let [l, r, b, t] = seen(&mesh, &framed_mesh(&mesh, aspect, false, false), aspect);
                let part = ((r - l) / 2.0).max((t - b) / 2.0);
                assert!((part - FILL).abs() < 0.01, "mesh {i} at {aspect}: {part}");
                assert!((l + r).abs() < 0.02 && (b + t).abs() < 0.02, "mesh {i} at {aspect}: off the middle");
            }
        }
    }

    #[test]
    fn a_turning_model_stays_in_the_frame() {
        let mesh = shapes::cuboid(DVec3::new(9.0, 0.5, 0.5)).expect("a size");
        let camera = framed_mesh(&mesh, 1.5, false, true);
        let mut widest = 0.0_f64;
        for i in 0..90 {
            let mut turned = mesh.clone();
            let by = DMat3::from_rotation_y(f64::from(i) * 0.07);
            turned.positions.iter_mut().for_each(|p| *p = by * *p);
            let [l, r, b, t] = seen(&turned, &camera, 1.5);
            widest = widest.max((r - l) / 2.0);
            assert!(l > -0.9 && r < 0.9 && b > -0.9 && t < 0.9, "turn {i}: {l} {r} {b} {t}");
        }
        assert!(widest > 0.7, "{widest}");
    }

    #[test]
    fn meshes_without_extent_have_a_camera_too() {
        for points in [vec![], vec![DVec3::ONE; 3], vec![DVec3::splat(f64::NAN); 3]] {
            let count = points.len() as u32;
            let triangles: Vec<[u32; 3]> = if count == 3 { vec![[0, 1, 2]] } else { Vec::new() };
            let camera = framed_mesh(&Mesh::from_triangles(points, &triangles), 1.0, false, false);
            assert!(camera.matrices(1.0).is_ok(), "{camera:?}");
        }
    }
}

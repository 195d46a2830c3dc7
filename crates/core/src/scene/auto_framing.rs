//! Automatic framing: cameras that show a whole scene, for files that name none.

use super::{Camera, LookAt, Mesh, Projection, Scene};
use crate::math::matrix::unit;
use glam::DVec3;

/// Field of view of a framing camera, on the smaller side of the frame: 45 degrees in radians.
pub const FRAME_FOV_RAD: f64 = std::f64::consts::FRAC_PI_4;

/// Margin around a framed scene: it fills 1 / FRAME_MARGIN of the frame.
pub const FRAME_MARGIN: f64 = 1.1;

/// Direction from the scene to the eye: slightly from the right and above.
const DIRECTION: DVec3 = DVec3::new(0.45, 0.3, 1.0);

/// Returns a camera in which the box `bounds` (low and high corner, world space) fills a frame of
/// `aspect` = width / height.
///
/// The eye is to the right of and above +z, y is up, the field of view is [`FRAME_FOV_RAD`]. The
/// near and far planes bound the box closely, to preserve the precision of depth. A box of size 0
/// counts as one of size 1; a box that is not finite as one of size 1 about the origin.
pub fn frame(bounds: (DVec3, DVec3), aspect: f64) -> Camera {
    let z = unit(DIRECTION).expect("a constant with a direction");
    let x = unit(DVec3::Y.cross(z)).expect("not along y");
    frame_along(bounds, [x, z.cross(x), z], FRAME_FOV_RAD, aspect)
}

/// Returns the camera of [`frame`], moved to the front side of an open surface: if the
/// area-weighted sum of the face normals of `mesh` points away from the usual eye, the eye is on
/// the opposite side. For a closed surface the sum is zero and the eye is the usual one.
///
/// With `is_open` (both sides are drawn) only the horizontal part of the sum counts, and the eye
/// stays above the horizon: ground whose faces look down is seen from above, where the viewer's
/// light reaches it.
pub fn frame_mesh(mesh: &Mesh, bounds: (DVec3, DVec3), aspect: f64, is_open: bool) -> Camera {
    let mut sum = DVec3::ZERO;
    let mut total = 0.0;
    for t in &mesh.triangles {
        // A mesh may be broken here: the draw refuses it.
        let position = |i: u32| mesh.positions.get(mesh.corners.get(i as usize)?.position as usize).copied();
        let [Some(a), Some(b), Some(c)] = t.map(position) else { continue };
        let normal = (b - a).cross(c - a);
        sum += normal;
        total += normal.length();
    }
    let usual = unit(DIRECTION).expect("a constant with a direction");
    let kept = if is_open { DVec3::new(0.0, usual.y, 0.0) } else { DVec3::ZERO };
    // A tenth of the area: a smaller sum is rounding, or a missing bottom face.
    let looks_away = sum.dot(usual - kept) < -0.1 * total;
    let z = if looks_away { 2.0 * kept - usual } else { usual };
    let x = unit(DVec3::Y.cross(z)).expect("not along y");
    frame_along(bounds, [x, z.cross(x), z], FRAME_FOV_RAD, aspect)
}

/// Returns the camera of [`frame`] for given view axes (unit: x right, y up, z towards the viewer)
/// and field of view on the smaller side, in radians.
pub fn frame_along(bounds: (DVec3, DVec3), axes: [DVec3; 3], fov_rad: f64, aspect: f64) -> Camera {
    let (center, half) = center_and_half(bounds);
    let aspect = if aspect > 0.0 && aspect.is_finite() { aspect } else { 1.0 };
    let tan = libm::tan(fov_rad / 2.0);
    let tan = [tan * aspect.max(1.0) / FRAME_MARGIN, tan * (1.0 / aspect).max(1.0) / FRAME_MARGIN];
    let [x, y, z] = axes;
    // The farthest distance that any corner needs: at distance d from the centre it is visible
    // where
    // |x| <= tan (d - z).
    let mut distance = 0.0_f64;
    let mut depth = 0.0_f64;
    for i in 0..8 {
        let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        let corner = half * DVec3::new(side(0), side(1), side(2));
        let (cx, cy, cz) = (corner.dot(x).abs(), corner.dot(y).abs(), corner.dot(z));
        distance = distance.max(cx / tan[0] + cz).max(cy / tan[1] + cz);
        depth = depth.max(cz);
    }
    let nearest = (distance - depth).max(distance * 1e-3);
    Camera {
        look_at: LookAt { eye: center + z * distance, reference: center, up: y },
        projection: Projection::Perspective {
            fov_rad,
            near: nearest * 0.5,
            far: (distance + depth) * 1.1,
            on_smaller_side: true,
        },
    }
}

/// Returns the centre and half size of a box; half size 1/2 for a box of size 0.
pub(crate) fn center_and_half((low, high): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let center = low / 2.0 + high / 2.0;
    let half = (high / 2.0 - low / 2.0).abs();
    if !(center.is_finite() && half.is_finite()) {
        return (DVec3::ZERO, DVec3::splat(0.5));
    }
    (center, if half == DVec3::ZERO { DVec3::splat(0.5) } else { half })
}

/// Returns the corners of a box; bit k of a corner's index is set if it lies on the high side of
/// axis k.
pub(crate) fn box_corners((low, high): (DVec3, DVec3)) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    })
}

impl Scene {
    /// Returns a box around all objects in world space, or `None` for a scene without positions. It
    /// encloses the objects' own boxes, so it may be larger than necessary where objects are
    /// rotated.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let corners = self
            .objects
            .iter()
            .filter_map(|o| Some((o, o.geometry.mesh.bounds()?)))
            .flat_map(|(o, bounds)| box_corners(bounds).map(|corner| o.model.transform_point3(corner)));
        corners.filter(|p| p.is_finite()).fold(None, |bounds: Option<(DVec3, DVec3)>, p| {
            Some(bounds.map_or((p, p), |(low, high)| (low.min(p), high.max(p))))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_open_surface_is_seen_from_its_front_and_a_closed_one_as_usual() {
        let points =
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(DVec3::from).to_vec();
        let eye_of = |triangles: &[[u32; 3]]| {
            let mesh = Mesh::from_triangles(points.clone(), triangles);
            let bounds = mesh.bounds().expect("points");
            [false, true].map(|is_open| {
                let camera = frame_mesh(&mesh, bounds, 1.0, is_open);
                let from = camera.look_at.eye - camera.look_at.reference;
                [from.y > 0.0, from.z > 0.0]
            })
        };
        let usual = [[true, true]; 2];
        // A vertical plane.
        assert_eq!(eye_of(&[[0, 1, 2]]), usual);
        assert_eq!(eye_of(&[[0, 2, 1]]), [[false, false], [true, false]]);
        // Ground whose back is seen from above if it is drawn.
        assert_eq!(eye_of(&[[0, 3, 1]]), usual);
        assert_eq!(eye_of(&[[0, 1, 3]]), [[false, false], [true, true]]);
        assert_eq!(eye_of(&[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]), usual);
        assert_eq!(eye_of(&[]), usual);
    }

    #[test]
    fn every_corner_of_the_box_is_inside_the_picture() {
        let boxes = [
            (DVec3::splat(-1.0), DVec3::ONE),
            (DVec3::new(5.0, -2.0, 1e3), DVec3::new(5.0, 40.0, 1e3 + 1.0)),
            (DVec3::splat(7.0), DVec3::splat(7.0)),
            (DVec3::splat(-1e-7), DVec3::splat(2e-7)),
        ];
        for bounds in boxes {
            for aspect in [0.2, 1.0, 16.0 / 9.0, 50.0] {
                let camera = frame(bounds, aspect);
                let m = camera.matrices(aspect).unwrap();
                let (mut widest, (center, half)) = (0.0_f64, center_and_half(bounds));
                for i in 0..8 {
                    let side = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
                    let corner = center + half * DVec3::new(side(0), side(1), side(2));
                    let clip = m.projection * (m.view * corner.extend(1.0));
                    let ndc = clip / clip.w;
                    assert!(clip.w > 0.0 && (0.0..1.0).contains(&ndc.z), "{bounds:?} {aspect} {ndc}");
                    widest = widest.max(ndc.x.abs()).max(ndc.y.abs());
                }
                assert!((widest - 1.0 / FRAME_MARGIN).abs() < 1e-6, "{bounds:?} at {aspect}: {widest}");
            }
        }
        let odd = frame((DVec3::splat(f64::NEG_INFINITY), DVec3::splat(f64::NAN)), f64::NAN);
        assert!(odd.matrices(1.0).is_ok());
    }
}

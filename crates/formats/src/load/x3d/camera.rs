//! Cameras from Viewpoint and OrthoViewpoint nodes. Source: ISO/IEC 19775-1 clause 23 (Navigation).

use super::graph::{GraphView, NodeId};
use fbptr_core::math::matrix::{rotate, unit};
use fbptr_core::scene::{Camera, LookAt, Projection, frame_along};
use glam::{DMat4, DVec3};

/// Default distance of the near plane.
pub(super) const NEAR: f64 = 0.01;
/// Default distance of the far plane.
pub(super) const FAR: f64 = 1000.0;

/// Returns the matrix of an X3D rotation: axis x y z, angle in radians. A zero axis gives the
/// identity.
pub(super) fn rotation(r: [f64; 4]) -> DMat4 {
    rotate(DVec3::new(r[0], r[1], r[2]), r[3]).unwrap_or(DMat4::IDENTITY)
}

/// Returns the standard's default viewpoint, for files without one.
pub(super) fn default_camera() -> Camera {
    Camera {
        look_at: LookAt { eye: DVec3::Z * 10.0, reference: DVec3::ZERO, up: DVec3::Y },
        projection: Projection::Perspective {
            fov_rad: std::f64::consts::FRAC_PI_4,
            near: NEAR,
            far: FAR,
            on_smaller_side: true,
        },
    }
}

/// Returns the camera of a viewpoint node with world matrix `model`. Enclosing groups move and turn
/// it; their scales affect its position only.
///
/// `bounds`: the bounding box of the scene, for viewAll, which moves the camera until it sees
/// everything.
pub(super) fn camera(view: &GraphView, id: NodeId, model: DMat4, bounds: Option<(DVec3, DVec3)>) -> Camera {
    let turn = model * rotation(view.array(id, "orientation"));
    let eye = model.transform_point3(view.vec3(id, "position"));
    let z = unit(turn.transform_vector3(DVec3::Z)).unwrap_or(DVec3::Z);
    let up = turn.transform_vector3(DVec3::Y);
    let y = unit(up - z * up.dot(z)).unwrap_or(if z.y.abs() < 0.5 { DVec3::Y } else { DVec3::X });
    let eye = if eye.is_finite() { eye } else { DVec3::ZERO };
    // The reference point is as far from the eye as the eye from the origin, so that the direction
    // keeps its precision.
    let look_at = LookAt { eye, reference: eye - z * eye.abs().max_element().max(1.0), up: y };
    let given = |field, default: f64| Some(view.real(id, field)).filter(|d| *d > 0.0).unwrap_or(default);
    let (near, mut far) = (given("nearDistance", NEAR), given("farDistance", FAR));
    if far <= near {
        far = near.max(FAR) * 2.0;
    }
    let axes = [y.cross(z), y, z];
    let everything = bounds.filter(|_| view.bool(id, "viewAll"));
    if view.name(id) == "OrthoViewpoint" {
        return ortho(view, id, look_at, [near, far], everything.map(|b| (b, axes)));
    }
    let fov = Some(view.real(id, "fieldOfView")).filter(|f| *f > 0.0 && *f < std::f64::consts::PI);
    let fov_rad = fov.unwrap_or(std::f64::consts::FRAC_PI_4);
    let projection = |far| Projection::Perspective { fov_rad, near, far, on_smaller_side: true };
    match everything {
        Some(bounds) => {
            // Computed for a square frame; every other aspect ratio shows at least as much.
            let framed = frame_along(bounds, axes, fov_rad, 1.0);
            let Projection::Perspective { far: needed, .. } = framed.projection else { return framed };
            Camera { look_at: framed.look_at, projection: projection(far.max(needed)) }
        }
        None => Camera { look_at, projection: projection(far) },
    }
}

/// Returns the camera of an OrthoViewpoint; `everything` is the bounding box and the view's axes,
/// for viewAll.
fn ortho(
    view: &GraphView,
    id: NodeId,
    mut look_at: LookAt,
    [near, mut far]: [f64; 2],
    everything: Option<((DVec3, DVec3), [DVec3; 3])>,
) -> Camera {
    let [l, b, r, t] = view.array::<4>(id, "fieldOfView");
    let mut window = if l < r && b < t { [l, r, b, t] } else { [-1.0, 1.0, -1.0, 1.0] };
    if let Some(((low, high), axes)) = everything {
        let (center, half) = (low / 2.0 + high / 2.0, high / 2.0 - low / 2.0);
        // Half the box's extent along each axis of the view.
        let [x, y, z] = axes.map(|a| a.abs().dot(half));
        let grow = |x: f64| if x > 0.0 { x * fbptr_core::scene::FRAME_MARGIN } else { 0.5 };
        window = [-grow(x), grow(x), -grow(y), grow(y)];
        look_at.eye = center + axes[2] * (z + 2.0 * near + 1.0);
        look_at.reference = center;
        far = far.max(2.0 * (z + near + 1.0));
    }
    Camera { look_at, projection: Projection::OrthoContain { window, near, far } }
}

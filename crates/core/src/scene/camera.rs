//! Cameras: view, projection, and viewport.

use crate::error::{Code, Fault};
use glam::{DMat4, DVec3, DVec4};
use std::fmt;

/// Eye, reference point and up vector in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// Position of the eye.
    pub eye: DVec3,
    /// Point that the eye looks at.
    pub reference: DVec3,
    /// Up vector, of any length.
    pub up: DVec3,
}

/// Kind of oblique projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObliqueKind {
    /// Receding lines keep their length.
    Cavalier,
    /// Receding lines are halved.
    Cabinet,
}

/// Projection from view to clip space. Distances are along the view direction; angles in radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Perspective with the field of view on the height, or on the viewport's smaller side.
    Perspective {
        /// Full angle of the field of view in radians.
        fov_rad: f64,
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
        /// True if the angle is on the viewport's smaller side (FOVMIN; X3D's rule).
        on_smaller_side: bool,
    },
    /// Perspective on a view plane at distance d: rows x, y and w of source 001, row z of FRUSTUM.
    /// No aspect correction.
    Plane {
        /// Distance to the view plane.
        d: f64,
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Perspective with its window on the near plane.
    Frustum {
        /// Left, right, bottom and top of the window on the near plane.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Parallel projection of a box.
    Ortho {
        /// Left, right, bottom and top of the window.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Parallel projection whose window grows in one direction to the viewport's aspect: all of the
    /// window is visible, and shapes keep their proportions (X3D's OrthoViewpoint). No verb selects
    /// it.
    OrthoContain {
        /// Left, right, bottom and top of the window.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Oblique parallel projection: sheared about the plane through the reference point, with z
    /// unchanged.
    Oblique {
        /// Cavalier or cabinet.
        kind: ObliqueKind,
        /// Angle of receding lines in radians.
        angle_rad: f64,
        /// Left, right, bottom and top of the window.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Isometric: two rotations after LOOKAT's, then a parallel box.
    Isometric {
        /// Left, right, bottom and top of the window.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Pseudo-isometric view, then a parallel box.
    PseudoIsometric {
        /// Left, right, bottom and top of the window.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// Viewing transformation (source 000). It has its own view: LOOKAT is not used.
    Window {
        /// View reference point.
        vrp: DVec3,
        /// Centre of projection.
        p: DVec3,
        /// View up vector.
        vup: DVec3,
        /// Window centre (CU, CV) on the view plane.
        center: [f64; 2],
        /// Half extents (SU, SV) of the window.
        half: [f64; 2],
        /// Distance from P to the view plane.
        dp: f64,
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
}

impl Projection {
    /// Returns the distances to the near and far planes.
    pub fn near_far(mut self) -> [f64; 2] {
        self.near_far_mut().map(|d| *d)
    }

    /// Returns mutable references to the distances to the near and far planes.
    pub fn near_far_mut(&mut self) -> [&mut f64; 2] {
        match self {
            Projection::Perspective { near, far, .. }
            | Projection::Plane { near, far, .. }
            | Projection::Frustum { near, far, .. }
            | Projection::Ortho { near, far, .. }
            | Projection::OrthoContain { near, far, .. }
            | Projection::Oblique { near, far, .. }
            | Projection::Isometric { near, far, .. }
            | Projection::PseudoIsometric { near, far, .. }
            | Projection::Window { near, far, .. } => [near, far],
        }
    }
}

/// Rule of the mapping from NDC to pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ViewportRule {
    /// x_s = x0 + (x_ndc + 1) w/2; pixel centres at .5.
    #[default]
    Corners,
    /// x_s = x0 + (x_ndc + 1)(w-1)/2; pixel centres at whole numbers (source 001).
    Centres,
}

/// Rectangle of the frame, y from the top. It clips the drawing and may reach beyond the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Viewport {
    /// Leftmost column.
    pub x: i32,
    /// Top row.
    pub y: i32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mapping from NDC.
    pub rule: ViewportRule,
}

/// Largest coordinate of an eye and of the point that it looks at: squares of more overflow.
pub const FARTHEST_EYE: f64 = 1e150;

/// Error of an unusable camera.
#[derive(Clone, Debug, PartialEq)]
pub enum CameraError {
    /// Eye and reference point coincide.
    NoDirection,
    /// The up vector is zero or parallel to the view direction.
    BadUp,
    /// The near and far planes bound no volume.
    BadDepthRange {
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// The eye or the point that it looks at is so far from the origin that no direction is left.
    TooFar {
        /// The largest coordinate of the two points.
        distance: f64,
    },
    /// The window or angle bounds no area.
    BadExtent {
        /// Name of the number.
        what: &'static str,
        /// Value of the number.
        value: f64,
    },
}

impl fmt::Display for CameraError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CameraError::NoDirection => f.write_str("the eye is at the point it looks at"),
            CameraError::BadUp => f.write_str("the up vector is parallel to the view"),
            CameraError::BadDepthRange { near, far } => {
                write!(f, "near {near} and far {far} bound no volume")
            }
            CameraError::TooFar { distance } => write!(
                f,
                "the eye or the point it looks at is {distance:e} from the origin, beyond {FARTHEST_EYE:e}"
            ),
            CameraError::BadExtent { what, value } => write!(f, "{what} {value} bounds no view"),
        }
    }
}

impl std::error::Error for CameraError {}

impl CameraError {
    /// Returns the protocol's code for this error.
    pub fn code(&self) -> Code {
        Code::Range
    }
}

impl From<CameraError> for Fault {
    fn from(e: CameraError) -> Self {
        Fault::new(e.code(), e.to_string())
    }
}

/// Camera: a view and a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position and orientation.
    pub look_at: LookAt,
    /// Projection to clip space.
    pub projection: Projection,
}

impl Default for Camera {
    /// Returns the command language's initial camera: LOOKAT 0 0 5 0 0 0 0 1 0, PERSPECTIVE pi/4
    /// 0.1 100.
    fn default() -> Self {
        Camera {
            look_at: LookAt { eye: DVec3::new(0.0, 0.0, 5.0), reference: DVec3::ZERO, up: DVec3::Y },
            projection: Projection::Perspective {
                fov_rad: std::f64::consts::FRAC_PI_4,
                near: 0.1,
                far: 100.0,
                on_smaller_side: false,
            },
        }
    }
}

/// Matrices and vectors of a camera for one viewport aspect; by default those of no camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraMatrices {
    /// Matrix from world to view space.
    pub view: DMat4,
    /// Matrix from view to clip space: -w<=x<=w, -w<=y<=w, 0<=z<=w.
    pub projection: DMat4,
    /// Row r with r.p_view = w - z of clip space, without cancellation: 1 - z_ndc = (r.p)/w.
    pub one_minus_z_row: DVec4,
    /// Clip-space w on the near plane (1 for parallel projections); points with less are never
    /// visible.
    pub w_near: f64,
    /// True if w is 1 everywhere: no division, and V is the view axis.
    pub is_parallel: bool,
    /// Eye in world space; for parallel projections a point on the view axis.
    pub eye: DVec3,
    /// Unit world vector from the scene to the viewer: V in parallel projections, the view's +z in
    /// perspective ones.
    pub to_viewer: DVec3,
}

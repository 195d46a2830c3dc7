//! Cameras: where the eye is, how the world is projected, and which part of the frame it fills.

use crate::error::Code;
use glam::{DMat4, DVec3, DVec4};

/// Eye, reference point and up vector, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LookAt {
    /// The eye.
    pub eye: DVec3,
    /// The point that the eye looks at.
    pub reference: DVec3,
    /// Which way is up.
    pub up: DVec3,
}

/// Which oblique projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObliqueKind {
    /// Receding lines keep their length.
    Cavalier,
    /// Receding lines are halved.
    Cabinet,
}

/// How view space becomes clip space. Distances are positive, along the view direction; angles radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// Field of view `fov_rad` on the height, or on the smaller side of the viewport with `on_smaller_side`.
    Perspective {
        /// Full angle, radians.
        fov_rad: f64,
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
        /// Whether the angle is on the smaller side (FOVMIN; X3D's rule).
        on_smaller_side: bool,
    },
    /// View plane at distance d: x, y and w rows of source 001, z row of FRUSTUM. No aspect correction.
    Plane {
        /// Distance to the view plane.
        d: f64,
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// A perspective box with its window at the near plane.
    Frustum {
        /// Left, right, bottom, top at the near plane.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// A parallel box.
    Ortho {
        /// Left, right, bottom, top.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// A parallel box whose window grows on one pair of sides to the viewport's aspect: all of it is seen, and shapes keep their
    /// proportions (X3D's OrthoViewpoint). No verb asks for it.
    OrthoContain {
        /// Left, right, bottom, top.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// A sheared parallel box: about the plane through the reference point, z kept.
    Oblique {
        /// Cavalier or cabinet.
        kind: ObliqueKind,
        /// Angle of receding lines, radians.
        angle_rad: f64,
        /// Left, right, bottom, top.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// The two turns of the isometric view, after LOOKAT's, then a parallel box.
    Isometric {
        /// Left, right, bottom, top.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// The pseudo-isometric view, then a parallel box.
    PseudoIsometric {
        /// Left, right, bottom, top.
        window: [f64; 4],
        /// Distance to the near plane.
        near: f64,
        /// Distance to the far plane.
        far: f64,
    },
    /// The viewing transformation (source 000), which brings its own view: LOOKAT is not used.
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
        /// Near plane.
        near: f64,
        /// Far plane.
        far: f64,
    },
}

impl Projection {
    /// The distances to the near and far planes.
    pub fn near_far(mut self) -> [f64; 2] {
        self.near_far_mut().map(|d| *d)
    }

    /// The same, to be changed.
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

/// Which rule takes NDC to pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum ViewportRule {
    /// x_s = x0 + (x_ndc + 1) w/2; pixel centres at .5.
    #[default]
    Corners,
    /// x_s = x0 + (x_ndc + 1)(w-1)/2; pixel centres at whole numbers (source 001).
    Centres,
}

/// A rectangle of the frame, y from the top; it bounds the drawing and may leave the frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Viewport {
    /// Left column.
    pub x: i32,
    /// Top row.
    pub y: i32,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// The rule.
    pub rule: ViewportRule,
}

/// Why a camera cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// Eye and reference point are the same.
    #[error("the eye is at the point it looks at")]
    NoDirection,
    /// The up vector is parallel to the view, or zero.
    #[error("the up vector is parallel to the view")]
    BadUp,
    /// Near and far do not bound a volume.
    #[error("near {near} and far {far} bound no volume")]
    BadDepthRange {
        /// Near.
        near: f64,
        /// Far.
        far: f64,
    },
    /// The window or angle bounds no area.
    #[error("{what} {value} bounds no view")]
    BadExtent {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

impl CameraError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        Code::Range
    }
}

/// A camera: a view and a projection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is.
    pub look_at: LookAt,
    /// How the world is projected.
    pub projection: Projection,
}

impl Default for Camera {
    /// The command language's start: LOOKAT 0 0 5 0 0 0 0 1 0, PERSPECTIVE pi/4 0.1 100.
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

/// What the pipeline needs of a camera, for one viewport aspect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrices {
    /// World to view space.
    pub view: DMat4,
    /// View to clip space: -w<=x<=w, -w<=y<=w, 0<=z<=w.
    pub projection: DMat4,
    /// The row r with r.p_view = w - z of clip space, free of cancellation: 1 - z_ndc = (r.p)/w.
    pub one_minus_z_row: DVec4,
    /// w on the near plane (1 for parallel projections): what lies at less is never seen.
    pub w_near: f64,
    /// Whether w is 1 everywhere: no division, V is the view axis.
    pub is_parallel: bool,
    /// The eye in world space; for parallel projections a point on the view axis.
    pub eye: DVec3,
    /// Unit world vector from the scene to the viewer in parallel projections (V); for perspective ones the view's +z.
    pub to_viewer: DVec3,
}

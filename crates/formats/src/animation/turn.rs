//! Turntables: a scene turned about its middle, in three dimensions about y, in N of them in given
//! planes. World space; camera, eye and lights stay.

use fbptr_core::eye::{EyeError, EyeScene, sin_cos_deg};
use fbptr_core::scene::{FRAME_FOV_RAD, Scene, frame_along};
use glam::{DMat4, DVec3, DVec4};
use std::fmt;
use std::str::FromStr;

/// A turn of an N-dimensional scene in the plane of two axes, from `a` towards `b`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneTurn {
    /// First axis.
    pub a: usize,
    /// Second axis.
    pub b: usize,
    /// Angle over all frames, in degrees.
    pub angle_deg: f64,
}

/// Reason why a scene cannot be turned so.
#[derive(Clone, Debug, PartialEq)]
pub enum TurnError {
    /// The text has another form.
    Form {
        /// Text that was given.
        found: String,
    },
    /// The scene has three dimensions, and turns about y.
    NotNDimensional,
    /// The axes make no plane of the space.
    Plane {
        /// Last axis of the space.
        last: usize,
        /// First axis.
        a: usize,
        /// Second axis.
        b: usize,
    },
}

impl fmt::Display for TurnError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            TurnError::Form { found } => {
                write!(f, "expected two axes and degrees, as in 0,3,360, found {found:?}")
            }
            TurnError::NotNDimensional => {
                f.write_str("a turn in planes is for N-dimensional scenes; others turn about y")
            }
            TurnError::Plane { last, a, b } => {
                write!(f, "expected two different axes from 0 to {last}, found {a} and {b}")
            }
        }
    }
}

impl std::error::Error for TurnError {}

impl FromStr for PlaneTurn {
    type Err = TurnError;

    fn from_str(text: &str) -> Result<Self, TurnError> {
        let form = || TurnError::Form { found: text.to_owned() };
        let parts: Vec<&str> = text.split(',').collect();
        let [a, b, degrees] = parts[..] else { return Err(form()) };
        match (a.parse(), b.parse(), degrees.parse::<f64>()) {
            (Ok(a), Ok(b), Ok(angle_deg)) if angle_deg.is_finite() => Ok(PlaneTurn { a, b, angle_deg }),
            _ => Err(form()),
        }
    }
}

impl PlaneTurn {
    /// Checks the axes for a space of `dim` dimensions; `None` is a scene in three dimensions.
    pub(super) fn check(&self, dim: Option<usize>) -> Result<(), TurnError> {
        let PlaneTurn { a, b, .. } = *self;
        match dim {
            None => Err(TurnError::NotNDimensional),
            Some(dim) if a == b || a.max(b) >= dim => Err(TurnError::Plane { last: dim - 1, a, b }),
            Some(_) => Ok(()),
        }
    }
}

/// Returns the scene with its facets turned, by a part of each angle, about the middle of their
/// bounding box; the axes must be those of its space.
pub(super) fn turned(scene: &EyeScene, turns: &[PlaneTurn], part: f64) -> Result<EyeScene, EyeError> {
    if turns.is_empty() || scene.facets.is_empty() {
        return Ok(scene.clone());
    }
    let mut parts = scene.clone().into_parts();
    let mut low = vec![f64::INFINITY; parts.dim];
    let mut high = vec![f64::NEG_INFINITY; parts.dim];
    for point in parts.facets.iter().flat_map(|facet| &facet.v) {
        for (axis, &x) in point.iter().enumerate() {
            (low[axis], high[axis]) = (low[axis].min(x), high[axis].max(x));
        }
    }
    let middle: Vec<f64> = low.iter().zip(&high).map(|(low, high)| low / 2.0 + high / 2.0).collect();
    for &PlaneTurn { a, b, angle_deg } in turns {
        let (sin, cos) = sin_cos_deg(angle_deg * part);
        for p in parts.facets.iter_mut().flat_map(|facet| &mut facet.v) {
            let (x, y) = (p[a] - middle[a], p[b] - middle[b]);
            (p[a], p[b]) = (middle[a] + (cos * x - sin * y), middle[b] + (sin * x + cos * y));
        }
    }
    EyeScene::new(parts)
}

/// Rotates all objects about the scene's middle, by a fraction of a full turn about y. The camera
/// and the lights stay; but a camera that only frames the scene, in a picture of `framed` pixels,
/// moves back so that nothing leaves the picture.
pub(super) fn turn(scene: &mut Scene, part: f64, framed: Option<[u32; 2]>) {
    let Some((low, high)) = scene.bounds() else { return };
    let center = low / 2.0 + high / 2.0;
    if let (Some([width, height]), Some(camera)) = (framed, &mut scene.camera) {
        let half = high - center;
        // Bounding box of the cylinder that the rotating box sweeps.
        let radius = libm::hypot(half.x, half.z);
        let half = DVec3::new(radius, half.y, radius);
        let eye = camera.look_at.eye - camera.look_at.reference;
        if let Some(z) = eye.try_normalize() {
            let x = camera.look_at.up.cross(z).normalize_or(DVec3::X);
            let aspect = f64::from(width) / f64::from(height);
            *camera = frame_along((center - half, center + half), [x, z.cross(x), z], FRAME_FOV_RAD, aspect);
        }
    }
    let (sin, cos) = libm::sincos(part * std::f64::consts::TAU);
    let turned =
        DMat4::from_cols(DVec4::new(cos, 0.0, -sin, 0.0), DVec4::Y, DVec4::new(sin, 0.0, cos, 0.0), DVec4::W);
    let about = DMat4::from_translation(center) * turned * DMat4::from_translation(-center);
    scene.objects.iter_mut().for_each(|object| object.model = about * object.model);
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::eye::shapes::{DemoScene, cube};
    use fbptr_core::scene::{Geometry, Mesh};
    use std::sync::Arc;

    #[test]
    fn a_turn_ends_where_it_began_and_nothing_leaves_the_picture() {
        let mesh = Mesh::from_triangles(
            vec![DVec3::new(5.0, 0.0, 0.0), DVec3::new(9.0, 1.0, 0.0), DVec3::new(5.0, 3.0, 0.5)],
            &[[0, 1, 2]],
        );
        let of = |part: f64| {
            let mut scene = Scene::of_mesh(
                Arc::new(Geometry { mesh: mesh.clone(), ..Geometry::default() }),
                "m",
                4.0 / 3.0,
                false,
            );
            turn(&mut scene, part, Some([64, 48]));
            scene
        };
        let corner = |scene: &Scene| scene.objects[0].model.transform_point3(mesh.positions[1]);
        assert!((corner(&of(1.0)) - mesh.positions[1]).length() < 1e-12);
        // Half a turn about the middle of the box, (7, 1.5, 0.25).
        assert!((corner(&of(0.5)) - DVec3::new(5.0, 1.0, 0.5)).length() < 1e-12);
        let camera = of(0.0).camera.unwrap();
        let m = camera.matrices(4.0 / 3.0).unwrap();
        for step in 0..16 {
            let scene = of(f64::from(step) / 16.0);
            assert_eq!(scene.camera, Some(camera), "the camera stands still");
            for &p in &mesh.positions {
                let clip = m.projection * (m.view * scene.objects[0].model.transform_point3(p).extend(1.0));
                assert!(
                    (clip.x / clip.w).abs() < 1.0 && (clip.y / clip.w).abs() < 1.0 && clip.z / clip.w < 1.0
                );
            }
        }
    }

    #[test]
    fn a_tesseract_turns_in_its_planes_about_its_own_middle() {
        let demo = DemoScene { pixels: vec![8, 8], aperture_tan: 0.4, turns: Vec::new() };
        let scene = demo.scene(cube(4).unwrap()).unwrap();
        let turns = ["0,3,360", "1,2,-180"].map(|text| text.parse().unwrap());
        assert_eq!(turned(&scene, &turns, 0.0).unwrap().facets, scene.facets);
        // A quarter of them: 90 degrees of the first are exact, 45 of the second the other way.
        let quarter = turned(&scene, &turns, 0.25).unwrap();
        let (before, after) = (&scene.facets[0].v[0], &quarter.facets[0].v[0]);
        let middle = |axis: usize| {
            let along = || scene.facets.iter().flat_map(|f| &f.v).map(|p| p[axis]);
            (along().fold(f64::MAX, f64::min) + along().fold(f64::MIN, f64::max)) / 2.0
        };
        assert!((after[0] - (middle(0) - (before[3] - middle(3)))).abs() < 1e-12);
        assert!((after[3] - (middle(3) + (before[0] - middle(0)))).abs() < 1e-12);
        let (x, y) = (before[1] - middle(1), before[2] - middle(2));
        assert!((after[1] - middle(1) - 0.5f64.sqrt() * (x + y)).abs() < 1e-12);
        assert!((after[2] - middle(2) - 0.5f64.sqrt() * (y - x)).abs() < 1e-12);
    }

    #[test]
    fn planes_that_a_space_does_not_have_are_refused() {
        for text in ["", "0,1", "0,1,x", "0,1,inf", "0,1,2,3", "-1,1,9"] {
            assert!(matches!(text.parse::<PlaneTurn>(), Err(TurnError::Form { .. })), "{text}");
        }
        let turn: PlaneTurn = "0,3,90".parse().unwrap();
        assert_eq!(turn.check(Some(4)), Ok(()));
        assert_eq!(turn.check(Some(3)), Err(TurnError::Plane { last: 2, a: 0, b: 3 }));
        assert_eq!(turn.check(None), Err(TurnError::NotNDimensional));
        assert!("1,1,5".parse::<PlaneTurn>().unwrap().check(Some(4)).is_err());
    }
}

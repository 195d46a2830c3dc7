//! A validated scene of R^N and the screen it is seen on.
//!
//! World space throughout. Axes of the eye: 0 forward, 1..=M screen (1 left, 2 up, ...), M+1..N
//! hidden.
//!
//! Promise: an [`EyeScene`] holds finite numbers, in range, of matching lengths, so code that takes
//! one need not check again.

use super::error::EyeError;
use super::pose::{Pose, Rotation};
use super::validate::{finite_point, in_range, length, same_length};

/// Largest dimension of a scene.
pub const MAX_DIM: usize = crate::math::nvec::MAX_DIM;
/// Largest number of pixels of one picture.
pub const MAX_PIXELS: u64 = 1 << 26;
/// Largest number of lit flags of one picture: pixels times lights.
pub const MAX_FLAGS: u64 = 1 << 28;

/// Loss of brightness with distance: I(D) = min(1, k / (1 + D)^n).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Falloff {
    /// Strength, at least 0.
    pub k: f64,
    /// Power, at least 0.
    pub n: f64,
}

impl Falloff {
    /// No loss at any distance.
    pub const OFF: Falloff = Falloff { k: 1.0, n: 0.0 };

    /// Returns I(D) in 0..=1 for a distance D >= 0 (source, equation 1, clamped).
    pub fn at(self, distance: f64) -> f64 {
        let base = 1.0 + distance;
        let loss = if self.n == self.n.trunc() && self.n <= 16.0 {
            (0..self.n as u32).fold(1.0, |product, _| product * base)
        } else {
            libm::pow(base, self.n)
        };
        (self.k / loss).min(1.0)
    }
}

/// Kind and position of a light.
#[derive(Clone, Debug, PartialEq)]
pub enum EyeLightKind {
    /// A sun: infinitely far, its light travels along `direction`, without loss over distance.
    Sun {
        /// Direction in which the light travels: not zero, of any length.
        direction: Vec<f64>,
    },
    /// A light plane: the hyperplane through `point` with normal `direction`. It shines from both
    /// faces, along the normal.
    Plane {
        /// Normal of the hyperplane: not zero, of any length.
        direction: Vec<f64>,
        /// Any point of the hyperplane.
        point: Vec<f64>,
    },
    /// A point light, which shines in all directions.
    Radial {
        /// Position of the light.
        position: Vec<f64>,
    },
}

/// A light of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct EyeLight {
    /// Kind and position of the light.
    pub kind: EyeLightKind,
    /// Loss of brightness with distance from the light.
    pub falloff: Falloff,
    /// Colour, 0..=1 for each channel.
    pub color: [f64; 3],
}

/// An (N-1)-simplex of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Facet {
    /// Vertices: N points of N coordinates each.
    pub v: Vec<Vec<f64>>,
    /// Colour, 0..=255 for each channel.
    pub color: [f64; 3],
}

/// Contents of a scene, not validated; [`EyeScene::new`] does that.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneParts {
    /// Dimension N of the space.
    pub dim: usize,
    /// Pixels along each of the M screen axes.
    pub pixels: Vec<u32>,
    /// Distance of the screen from the eye, above 0.
    pub distance: f64,
    /// Width of the screen along each of its axes, above 0.
    pub size: Vec<f64>,
    /// Tangent of the aperture of each of the N-1-M hidden axes, at least 0.
    pub aperture_tan: Vec<f64>,
    /// Diffuse light I_d of each channel, 0..=1.
    pub diffuse: [f64; 3],
    /// Loss of brightness I_R with distance from the eye.
    pub view: Falloff,
    /// Colour of pixels that see nothing, 0..=255 for each channel.
    pub background: [f64; 3],
    /// Position and orientation of the eye.
    pub pose: Pose,
    /// The lights.
    pub lights: Vec<EyeLight>,
    /// The facets. Degenerate ones are allowed here; the renderer skips and reports them.
    pub facets: Vec<Facet>,
}

/// A validated scene; dereferences to its [`SceneParts`].
#[derive(Clone, Debug, PartialEq)]
pub struct EyeScene(SceneParts);

impl std::ops::Deref for EyeScene {
    type Target = SceneParts;

    fn deref(&self) -> &SceneParts {
        &self.0
    }
}

impl EyeScene {
    /// Returns the least and the largest coordinate of the facets on each axis; infinite ones, the
    /// least being the larger, of a scene without facets.
    pub fn bounds(&self) -> Vec<(f64, f64)> {
        let mut bounds = vec![(f64::INFINITY, f64::NEG_INFINITY); self.dim];
        for point in self.facets.iter().flat_map(|f| &f.v) {
            for (b, &x) in bounds.iter_mut().zip(point) {
                *b = (b.0.min(x), b.1.max(x));
            }
        }
        bounds
    }

    /// Returns the middle of the facets' bounds; the origin of a scene without facets.
    pub fn middle(&self) -> Vec<f64> {
        let is_empty = self.facets.is_empty();
        self.bounds().iter().map(|&(l, h)| if is_empty { 0.0 } else { l / 2.0 + h / 2.0 }).collect()
    }

    /// Returns the scene with its eye turned about the middle of the facets, by one rotation after
    /// the other. Rotations in planes that the scene does not have are left out.
    ///
    /// # Errors
    /// If the eye would be out of range.
    pub fn turned(self, rotations: &[Rotation]) -> Result<Self, EyeError> {
        let (dim, middle) = (self.dim, self.middle());
        let mut parts = self.into_parts();
        for r in rotations.iter().filter(|r| r.a != r.b && r.a.max(r.b) < dim && r.angle_deg.is_finite()) {
            parts.pose.turn_about(&middle, r.a, r.b, r.angle_deg);
        }
        EyeScene::new(parts)
    }

    /// Validates lengths and ranges. An error names the offending field by its path in the JSON.
    pub fn new(parts: SceneParts) -> Result<Self, EyeError> {
        let n = parts.dim;
        in_range("dim", n as f64, (2..=MAX_DIM).contains(&n), || {
            format!("a whole number from 2 to {MAX_DIM}")
        })?;
        let m = parts.pixels.len();
        if !(1..n).contains(&m) {
            return Err(length("pixels", format!("1 to {} (one a screen axis)", n - 1), m));
        }
        let mut total = 1u64;
        for (i, &count) in parts.pixels.iter().enumerate() {
            in_range(format!("pixels[{i}]"), count.into(), count >= 1, || "a whole number from 1".into())?;
            total = total.saturating_mul(count.into());
        }
        limit("pixels", total, MAX_PIXELS)?;
        limit("lights", total.saturating_mul(parts.lights.len() as u64), MAX_FLAGS)?;
        positive("d", parts.distance)?;
        same_length("S", parts.size.len(), m)?;
        for (i, &size) in parts.size.iter().enumerate() {
            positive(&format!("S[{i}]"), size)?;
        }
        same_length("aperture_tan", parts.aperture_tan.len(), n - 1 - m)?;
        for (i, &tan) in parts.aperture_tan.iter().enumerate() {
            in_range(format!("aperture_tan[{i}]"), tan, tan.is_finite() && tan >= 0.0, || {
                "a finite tangent of at least 0".into()
            })?;
        }
        color("I_d", &parts.diffuse, 1.0)?;
        falloff("view", parts.view)?;
        color("background", &parts.background, 255.0)?;
        parts.pose.check(n)?;
        for (i, light) in parts.lights.iter().enumerate() {
            check_light(&format!("lights[{i}]"), light, n)?;
        }
        for (i, facet) in parts.facets.iter().enumerate() {
            let place = format!("facets[{i}]");
            same_length(&format!("{place}.v"), facet.v.len(), n)?;
            for (j, point) in facet.v.iter().enumerate() {
                finite_point(&format!("{place}.v[{j}]"), point, n)?;
            }
            color(&format!("{place}.color"), &facet.color, 255.0)?;
        }
        Ok(EyeScene(parts))
    }

    /// Returns the parts, to be changed and validated again.
    pub fn into_parts(self) -> SceneParts {
        self.0
    }

    /// Returns the dimension M of the screen.
    pub fn screen_dim(&self) -> usize {
        self.0.pixels.len()
    }

    /// Returns the number K = N-1-M of hidden retina axes.
    pub fn hidden_dim(&self) -> usize {
        self.0.dim - 1 - self.0.pixels.len()
    }

    /// Returns the number of pixels of the picture.
    pub fn pixel_count(&self) -> usize {
        self.0.pixels.iter().map(|&n| n as usize).product()
    }

    /// Returns the scene seen from another pose. Fails if the pose is not of the scene's dimension.
    pub fn with_pose(mut self, pose: Pose) -> Result<Self, EyeError> {
        pose.check(self.0.dim)?;
        self.0.pose = pose;
        Ok(self)
    }
}

/// Validates a light; `place` is its path in the JSON.
fn check_light(place: &str, light: &EyeLight, n: usize) -> Result<(), EyeError> {
    let direction_place = format!("{place}.direction");
    match &light.kind {
        EyeLightKind::Sun { direction } => {
            nonzero(&direction_place, direction, n)?;
            in_range(format!("{place}.n"), light.falloff.n, light.falloff.n == 0.0, || {
                "0 (a parallel light without a point is infinitely far)".into()
            })?;
        }
        EyeLightKind::Plane { direction, point } => {
            nonzero(&direction_place, direction, n)?;
            finite_point(&format!("{place}.point"), point, n)?;
        }
        EyeLightKind::Radial { position } => finite_point(&format!("{place}.position"), position, n)?,
    }
    falloff(place, light.falloff)?;
    color(&format!("{place}.color"), &light.color, 1.0)
}

fn nonzero(place: &str, vector: &[f64], n: usize) -> Result<(), EyeError> {
    finite_point(place, vector, n)?;
    in_range(place, 0.0, vector.iter().any(|&x| x != 0.0), || "a vector that is not zero".into())
}

fn falloff(place: &str, falloff: Falloff) -> Result<(), EyeError> {
    for (name, value) in [("k", falloff.k), ("n", falloff.n)] {
        in_range(format!("{place}.{name}"), value, value.is_finite() && value >= 0.0, || {
            "a finite number of at least 0".into()
        })?;
    }
    Ok(())
}

fn color(place: &str, color: &[f64; 3], most: f64) -> Result<(), EyeError> {
    for (i, &x) in color.iter().enumerate() {
        in_range(format!("{place}[{i}]"), x, (0.0..=most).contains(&x), || format!("0 to {most}"))?;
    }
    Ok(())
}

fn positive(place: &str, x: f64) -> Result<(), EyeError> {
    in_range(place, x, x.is_finite() && x > 0.0, || "a finite number over 0".into())
}

fn limit(place: &str, found: u64, limit: u64) -> Result<(), EyeError> {
    if found > limit { Err(EyeError::TooBig { path: place.into(), limit, found }) } else { Ok(()) }
}

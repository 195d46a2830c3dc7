//! The level of detail of a draw: the coarsest whose change is within the error that is allowed.
//!
//! In: a draw, the bounds on the change of its mesh's levels, and the largest error. Out: a level, or
//! the reason why the whole mesh is drawn. With a shift S and steps E the promise is:
//!
//! - every pixel of a face has, within E, the colour of the exact surface at a point that lies within
//!   S pixels of the pixel's centre on the screen, and every point of the exact surface has a point
//!   of the drawn one within S pixels;
//! - which of two surfaces is seen may differ where they are nearer to each other, along the line of
//!   sight, than the level's distance: what lies that close on a dense mesh is not for a shift.
//!
//! With p and p' the point on both surfaces, |p - p'| <= d, and at most a between their normals:
//!
//! ```text
//! shift     |P(p) - P(p')| <= d max |J|, J = (rows of M - ndc * row w) * half / w, over the box:
//!           P is the projection; |J| is convex in the device coordinates, so their corners do
//! N, L, V   |N - N'| <= a    |L - L'| <= l = d / distance to the light    |V - V'| <= v = d / to the eye
//! diffuse   |max(N.L,0) - max(N'.L',0)| <= a + l
//! specular  the angle of R and V changes by at most t = 2a + l + v, that of N and H (Blinn) by
//!           a + (l + v) / |L + V|; cos^n has slopes up to s(n) = sqrt(n) (1 - 1/n)^((n-1)/2), n >= 1.
//!           A highlight ends where N.L = 0: there it is at most sin(a + l + g/2)^n (Blinn) or
//!           (2(a + l) - cos g)^n (Phong), g the largest angle of L and V over the box.
//! ```

use super::bounds::{MeshBox, ShadedObject, light_indices};
use super::levels::{Change, Level};
use super::steps_of_rounding;
use crate::pipeline::draw_call::DrawCall;
use crate::pipeline::ndc_box::{ClipTransform, NdcBox};
use crate::scene::{
    CameraMatrices, HiddenSurface, Interpolation, Light, LightKind, LightingModel, Material, MaxError,
    ShadeMode,
};
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt;

/// Level of a draw, or the reason why it has none.
#[derive(Clone, Debug, PartialEq)]
pub enum Detail {
    /// A level is drawn.
    Level {
        /// The level.
        level: Level,
        /// Faces of the whole mesh.
        faces: usize,
        /// Bound on the shift, in pixels.
        shift: f64,
        /// Bound on the change of colour, in steps.
        steps: f64,
    },
    /// The whole mesh is drawn.
    Whole(WholeReason),
}

/// Reason why no level of a mesh is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WholeReason {
    /// The draw has something for which nothing is proven.
    Unproven(&'static str),
    /// The levels are not made before so many draws.
    Unpaid {
        /// Draws so far, this one included.
        draws: u64,
        /// Draws that pay for the levels.
        needed: u64,
    },
    /// There are no levels, or no memory for them.
    NoLevels,
    /// The finest level moves points by more pixels than S.
    TooFar {
        /// Bound on its shift, in pixels.
        shift: f64,
    },
    /// The finest level changes the colour by more than is left of E.
    TooDifferent {
        /// Bound on its change of colour, in steps.
        steps: f64,
    },
}

impl fmt::Display for Detail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Detail::Level { level, faces, shift, steps } => {
                let left = level.geometry.mesh.triangles.len();
                write!(f, "{left} of {faces} faces, at most {shift:.2} pixels and {steps:.2} steps off")
            }
            Detail::Whole(reason) => write!(f, "all faces: {reason}"),
        }
    }
}

impl fmt::Display for WholeReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WholeReason::Unproven(why) => write!(f, "nothing is proven for {why}"),
            WholeReason::Unpaid { draws, needed } => {
                write!(f, "levels pay from {needed} draws on, and this is draw {draws}")
            }
            WholeReason::NoLevels => f.write_str("the mesh has no levels, or there is no memory for them"),
            WholeReason::TooFar { shift } => write!(f, "the finest level is {shift:.2} pixels off"),
            WholeReason::TooDifferent { steps } => {
                write!(f, "the finest level is {steps:.2} steps of colour off")
            }
        }
    }
}

/// Returns what of a draw is not proven for levels, if something is not.
pub(super) fn unproven(call: &DrawCall) -> Option<&'static str> {
    let has_texture = call.texture.is_some() || call.geometry.textures.iter().any(Option::is_some);
    let reasons = [
        (call.shade != ShadeMode::Phong, "shading other than Phong"),
        (call.hide != HiddenSurface::ZBuffer, "hidden surfaces other than by depth"),
        (call.interp != Interpolation::Perspective, "affine interpolation"),
        (has_texture, "textures"),
        (call.fog.is_some(), "fog"),
    ];
    reasons.into_iter().find(|(is_given, _)| *is_given).map(|(_, why)| why)
}

/// Returns the coarsest of the levels, from fine to coarse, that keeps to the largest error.
pub(super) fn choose(
    call: &DrawCall,
    mesh_box: MeshBox,
    to_clip: &ClipTransform,
    levels: &[Level],
    max_error: &MaxError,
) -> Detail {
    let why = |why| Detail::Whole(WholeReason::Unproven(why));
    let Some(shaded) = ShadedObject::of(call, mesh_box, None) else {
        return why("two-sided, transparent or mapped surfaces, or models that change angles");
    };
    let Some(pixels) = pixels_a_unit(call, mesh_box, to_clip) else {
        return why("a mesh that reaches the eye");
    };
    let Some(view) = ViewBounds::of(&shaded) else { return why("this camera") };
    let (mut found, mut whole) = (None, WholeReason::NoLevels);
    for level in levels {
        let shift = level.change.distance * pixels;
        if shift.is_nan() || shift > max_error.shift {
            whole = WholeReason::TooFar { shift };
            break;
        }
        let Some(steps) = view.steps(&level.change) else { return why("these lights") };
        if steps + steps_of_rounding(call) + 1.0 > max_error.steps {
            whole = WholeReason::TooDifferent { steps };
            break;
        }
        found = Some((level, shift, steps));
    }
    match found {
        None => Detail::Whole(whole),
        Some((level, shift, steps)) => {
            let faces = call.geometry.mesh.triangles.len();
            Detail::Level { level: level.clone(), faces, shift, steps }
        }
    }
}

/// Returns an upper bound on the pixels by which a unit of object space within the box is seen.
fn pixels_a_unit(call: &DrawCall, mesh_box: MeshBox, to_clip: &ClipTransform) -> Option<f64> {
    let seen = NdcBox::of(mesh_box.bounds, to_clip)?;
    let rows = to_clip.matrix().transpose();
    let [x, y, w] = [rows.x_axis, rows.y_axis, rows.w_axis].map(|row| row.truncate());
    let half = [call.viewport.width, call.viewport.height].map(|side| f64::from(side) / 2.0);
    let mut most = 0.0f64;
    for at_x in [seen.low[0], seen.high[0]] {
        for at_y in [seen.low[1], seen.high[1]] {
            let (a, b) = ((x - w * at_x) * half[0], (y - w * at_y) * half[1]);
            // The larger singular value of the matrix with rows a and b.
            let (sum, difference) = (a.dot(a) + b.dot(b), DVec2::new(a.dot(a) - b.dot(b), 2.0 * a.dot(b)));
            most = most.max((sum + difference.length()) / 2.0);
        }
    }
    let pixels = most.sqrt() / seen.nearest_w * (1.0 + 1e-6);
    pixels.is_finite().then_some(pixels)
}

/// Bounds on where an object is seen from, and on the light that its points get.
struct ViewBounds<'s, 'c> {
    shaded: &'s ShadedObject<'c>,
    camera: CameraMatrices,
    /// Middle of the box in the world, and a bound on the distance of its points from there.
    middle: DVec3,
    radius: f64,
}

/// Cone of directions: the middle one, and the largest angle from it.
struct Cone {
    axis: DVec3,
    angle: f64,
    /// Lower bound on the distance; infinite for directions alone.
    distance: f64,
}

impl<'s, 'c> ViewBounds<'s, 'c> {
    fn of(shaded: &'s ShadedObject<'c>) -> Option<Self> {
        let call = shaded.call();
        let aspect = f64::from(call.viewport.width) / f64::from(call.viewport.height);
        let (low, high) = shaded.mesh_box.bounds;
        let middle = call.model.transform_point3((low + high) / 2.0);
        let radius = (high - low).length() / 2.0 * shaded.scale * (1.0 + 1e-9);
        let camera = call.camera.matrices(aspect).ok()?;
        (middle.is_finite() && radius.is_finite()).then_some(ViewBounds { shaded, camera, middle, radius })
    }

    /// Returns the cone of directions from the object's points to a point.
    fn towards(&self, point: DVec3) -> Option<Cone> {
        let to = point - self.middle;
        let distance = to.length() - self.radius;
        let axis = crate::math::matrix::unit(to).filter(|_| distance > 0.0)?;
        Some(Cone { axis, angle: libm::asin((self.radius / to.length()).min(1.0)), distance })
    }

    /// Returns a bound on the change of colour, in steps, on a surface that changes by so much; `None`
    /// where nothing is proven.
    fn steps(&self, change: &Change) -> Option<f64> {
        let call = self.shaded.call();
        let moved = change.distance * self.shaded.scale;
        let viewer = match self.camera.is_parallel {
            true => Some(Cone { axis: self.camera.to_viewer, angle: 0.0, distance: f64::INFINITY }),
            false => self.towards(self.camera.eye),
        };
        let is_lit = |m: &&&Material| m.model != LightingModel::Unlit;
        // The brightest light that a vertex colour multiplies, by materials.
        let mut lit: Vec<DVec3> = self.shaded.materials.iter().map(|m| m.ka * call.ambient.abs()).collect();
        let mut sum = 0.0;
        for index in light_indices(call) {
            let light = call.lights.get(index as usize)?;
            for (lit, m) in lit.iter_mut().zip(&self.shaded.materials) {
                *lit += m.ka * light.ambient.abs() + m.kd * light.color.abs();
            }
            // Ambient light of a place is weakened as its other light is.
            let is_directional = matches!(light.kind, LightKind::Directional { .. });
            let is_even = light.color == DVec3::ZERO && (light.ambient == DVec3::ZERO || is_directional);
            if is_even || self.shaded.materials.iter().filter(is_lit).count() == 0 {
                continue;
            }
            let light_cone = self.light_cone(light)?;
            let of = |m: &&Material| {
                let highlight = match (m.ks == DVec3::ZERO, &viewer) {
                    (true, _) => 0.0,
                    (false, Some(viewer)) => highlight_change(m, change.turn, moved, &light_cone, viewer),
                    (false, None) => 1.0,
                };
                let diffuse = change.turn + moved / light_cone.distance;
                ((m.kd * diffuse + m.ks * highlight) * light.color.abs()).max_element()
            };
            sum += self.shaded.materials.iter().filter(is_lit).map(of).fold(0.0, f64::max);
        }
        let of_color = |(lit, m): (&DVec3, &&Material)| match m.model {
            LightingModel::Unlit => m.emissive.abs().max_element(),
            _ => lit.max_element(),
        };
        if !call.geometry.mesh.colors.is_empty() {
            sum += change.color * lit.iter().zip(&self.shaded.materials).map(of_color).fold(0.0, f64::max);
        }
        (sum.is_finite()).then_some(255.0 * sum)
    }

    /// Returns the cone of directions to a light; `None` if its strength depends on the place.
    fn light_cone(&self, light: &Light) -> Option<Cone> {
        match light.kind {
            LightKind::Directional { direction } => {
                let axis = -crate::math::matrix::unit(direction)?;
                Some(Cone { axis, angle: 0.0, distance: f64::INFINITY })
            }
            LightKind::Point { position, .. } if ShadedObject::has_equal_strength(light) => {
                self.towards(position)
            }
            _ => None,
        }
    }
}

/// Returns a bound on the change of a highlight's power, from 0 to 1, where the normal turns by
/// `turn` and the point moves by `moved`.
fn highlight_change(m: &Material, turn: f64, moved: f64, light: &Cone, viewer: &Cone) -> f64 {
    let (l, v) = (moved / light.distance, moved / viewer.distance);
    if m.n.is_nan() || m.n < 1.0 || l + v + turn > 0.5 {
        return 1.0;
    }
    // The angle of a chord of at most 1/2 is at most 1.05 times as large.
    let (l, v) = (1.05 * l, 1.05 * v);
    let between = libm::acos(light.axis.dot(viewer.axis).clamp(-1.0, 1.0));
    let widest = (between + light.angle + viewer.angle).min(PI);
    let (angle, end) = match m.model {
        LightingModel::Blinn => {
            // |L + V| is 2 cos of half the angle.
            let sum = 2.0 * libm::cos(widest / 2.0);
            if sum < 0.1 {
                return 1.0;
            }
            (turn + 1.05 * (l + v) / sum, libm::sin((turn + l + widest / 2.0).min(FRAC_PI_2)))
        }
        _ => (2.0 * turn + l + v, (2.0 * (turn + l) - libm::cos(widest)).clamp(0.0, 1.0)),
    };
    let slope = m.n.sqrt() * libm::pow(1.0 - 1.0 / m.n, (m.n - 1.0) / 2.0);
    (slope * angle).max(libm::pow(end, m.n)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::truth::scenes::Random;

    /// Returns a highlight's power.
    fn power(m: &Material, n: DVec3, l: DVec3, v: DVec3) -> f64 {
        if n.dot(l) <= 0.0 {
            return 0.0;
        }
        let cosine = match m.model {
            LightingModel::Blinn => n.dot((l + v).normalize()),
            _ => (n * (2.0 * n.dot(l)) - l).dot(v),
        };
        libm::pow(cosine.clamp(0.0, 1.0), m.n)
    }

    #[test]
    fn a_highlight_changes_within_the_bound_which_is_not_wide() {
        let (mut r, mut widest) = (Random::new(5), [0.0f64; 2]);
        for i in 0..60_000 {
            let model = if i % 2 == 0 { LightingModel::Phong } else { LightingModel::Blinn };
            let n = libm::exp2(r.real(0.0, 8.0));
            let m = Material { ks: DVec3::ONE, n, model, ..Material::default() };
            let turn = r.real(0.0, 0.02);
            let near =
                |r: &mut Random, v: DVec3, by: f64| (v + r.point(-1.0, 1.0).normalize() * by).normalize();
            let [normal, l, v] = [0; 3].map(|_| r.point(-1.0, 1.0).normalize());
            // Half of the samples look at the highlight.
            let normal = if i % 4 < 2 { near(&mut r, (l + v).normalize(), 0.3) } else { normal };
            let (distance, moved) = (r.real(2.0, 9.0), r.real(0.0, 0.01));
            let cone = |axis| Cone { axis, angle: 0.0, distance };
            let bound = highlight_change(&m, turn, moved, &cone(l), &cone(v));
            let turned = near(&mut r, normal, turn * 0.99);
            let [l2, v2] = [l, v].map(|d| near(&mut r, d, moved / distance * 0.99));
            let found = (power(&m, normal, l, v) - power(&m, turned, l2, v2)).abs();
            assert!(found <= bound + 1e-12, "{found} > {bound}: {model:?} {n}");
            widest[i % 2] = widest[i % 2].max(found / bound);
        }
        assert!(widest.iter().all(|part| *part > 0.6), "{widest:?}");
    }
}

//! Validation of single commands, independent of the state of memory and session.
//!
//! The decoder validates every command that it reads, the engine those that arrive as typed values,
//! so that both paths refuse the same commands with the same codes:
//! - ENUM: a number that is not finite;
//! - ERANGE: a negative width, height, radius, size, byte count, light index, level or error
//!   budget;
//! - EFORMAT: a payload whose length contradicts the words before it, or text that is not UTF-8;
//! - EARGS: a name that cannot stand in a line; no byte to write, no point to join.

use super::args::is_name;
use super::commands::{Command, Figure, LightCommand, MeshSource, Quality, RealRect, Rect, SnapTarget};
use crate::error::{Code, Fault};
use crate::scene::{Attenuation, Projection};
use glam::DVec3;

impl Command {
    /// Checks the command by itself.
    ///
    /// # Errors
    ///
    /// Those listed in the module's documentation.
    pub fn validate(&self) -> Result<(), Fault> {
        self.validate_numbers()?;
        self.validate_sizes()?;
        self.validate_names()?;
        if let Some(payload) = self.payload() {
            self.validate_payload_length(payload.len() as u64)?;
        }
        match self {
            Command::Poke { bytes, .. } if bytes.is_empty() => {
                Err(Fault::new(Code::Args, "there must be a byte to write"))
            }
            Command::Figure(Figure::Poly { points, .. }) if points.is_empty() => no_points(),
            Command::Figure(Figure::FillPoly { points, .. }) if points.is_empty() => no_points(),
            _ => self.validate_text(),
        }
    }

    /// Refuses text that is not UTF-8.
    pub(super) fn validate_text(&self) -> Result<(), Fault> {
        match self {
            Command::Figure(Figure::Text { utf8, .. }) => utf8_or_fault(utf8),
            _ => Ok(()),
        }
    }

    /// Refuses a payload length that the words before it contradict.
    pub(super) fn validate_payload_length(&self, length: u64) -> Result<(), Fault> {
        let wrong = |expected: String| Err(Fault::new(Code::Format, expected).got(format!(":{length}")));
        match self {
            Command::Blit { rect: Rect { w, h, .. }, .. } if *w >= 0 && *h >= 0 => {
                // Both are below 2^31: the product stays below 2^64.
                let expected = *w as u64 * *h as u64 * 4;
                match expected == length {
                    true => Ok(()),
                    false => wrong(format!("the payload of {w} x {h} pixels must be {expected} bytes")),
                }
            }
            Command::Points { .. } if !length.is_multiple_of(8) => {
                wrong("the payload must be 8 bytes a pixel".to_owned())
            }
            Command::PixelRun { .. } if !length.is_multiple_of(4) => {
                wrong("the run must be 4 bytes a pixel".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Refuses negative sizes. Needs no payload, so the decoder calls it before the payload
    /// arrives.
    pub(super) fn validate_sizes(&self) -> Result<(), Fault> {
        match self {
            Command::Blit { rect, .. }
            | Command::Read { rect }
            | Command::Copy { source: rect, .. }
            | Command::Crc { rect: Some(rect) }
            | Command::Figure(Figure::Rect { rect, .. })
            | Command::Viewport { rect, .. }
            | Command::DrawEye { rect, .. } => {
                from_zero("width", rect.w)?;
                from_zero("height", rect.h)
            }
            Command::Figure(Figure::FillRect { rect, .. }) => {
                from_zero("width", rect.w)?;
                from_zero("height", rect.h)
            }
            Command::Figure(Figure::Circle { r, .. }) => from_zero("radius", *r),
            Command::Figure(Figure::FillCircle { r, .. }) => from_zero("radius", *r),
            Command::Peek { n, .. } => from_zero("byte count", *n),
            Command::Light { index, .. } => from_zero("light's index", *index),
            Command::Quality(Quality::MaxError(e)) => from_zero("error", *e),
            Command::Mesh { source, .. } => match **source {
                MeshSource::Obj(_) => Ok(()),
                MeshSource::Box(size) => size.to_array().into_iter().try_for_each(|s| from_zero("side", s)),
                MeshSource::Sphere(r) => from_zero("radius", r),
                MeshSource::Cone(r, h) | MeshSource::Cylinder(r, h) => {
                    from_zero("radius", r)?;
                    from_zero("height", h)
                }
                MeshSource::Teapot(level) => in_i32("level", level),
                MeshSource::Knot(nu, nv) => {
                    in_i32("nu", nu)?;
                    in_i32("nv", nv)
                }
            },
            _ => Ok(()),
        }
    }

    fn validate_names(&self) -> Result<(), Fault> {
        let wrong = |name: &str| {
            Err(Fault::new(Code::Args, "a name is printable text without blanks, with no colon before more")
                .got(name))
        };
        let (name, more) = match self {
            Command::Mesh { name, .. }
            | Command::Texture { name, .. }
            | Command::Eye { name, .. }
            | Command::Free { name }
            | Command::Draw { name }
            | Command::DrawEye { name, .. }
            | Command::UseTexture { name: Some(name), .. }
            | Command::Sync { tag: name }
            | Command::Snap(SnapTarget::File(name)) => (name, None),
            Command::Load { kind: super::FileKind::Scene, path, .. } => (path, None),
            Command::Load { name, path, .. } => (name, Some(path)),
            _ => return Ok(()),
        };
        [Some(name), more].into_iter().flatten().try_for_each(|n| if is_name(n) { Ok(()) } else { wrong(n) })
    }

    /// Refuses numbers that are not finite, which only typed commands can contain.
    fn validate_numbers(&self) -> Result<(), Fault> {
        let reals = |numbers: &[f64]| match numbers.iter().find(|n| !n.is_finite()) {
            Some(n) => Err(Fault::new(Code::Num, "numbers must be finite").got(n.to_string())),
            None => Ok(()),
        };
        let vectors = |vectors: &[DVec3]| vectors.iter().try_for_each(|v| reals(&v.to_array()));
        match self {
            Command::Figure(Figure::Fill { points, .. }) => reals(points.as_flattened()),
            Command::Figure(Figure::FillRect { rect: RealRect { x, y, w, h }, .. }) => {
                reals(&[*x, *y, *w, *h])
            }
            Command::Figure(Figure::FillCircle { cx, cy, r, .. }) => reals(&[*cx, *cy, *r]),
            Command::Figure(Figure::FillPoly { points, .. }) => reals(points.as_flattened()),
            Command::Figure(Figure::LineAa { p0, p1, .. }) => reals([*p0, *p1].as_flattened()),
            Command::Mesh { source, .. } => match **source {
                MeshSource::Obj(_) | MeshSource::Teapot(_) | MeshSource::Knot(..) => Ok(()),
                MeshSource::Box(size) => vectors(&[size]),
                MeshSource::Sphere(r) => reals(&[r]),
                MeshSource::Cone(r, h) | MeshSource::Cylinder(r, h) => reals(&[r, h]),
            },
            Command::LookAt { eye, reference, up } => vectors(&[*eye, *reference, *up]),
            Command::Projection(projection) => match **projection {
                Projection::Perspective { fov_rad, near, far, .. } => reals(&[fov_rad, near, far]),
                Projection::Plane { d, near, far } => reals(&[d, near, far]),
                Projection::Frustum { window: [l, r, b, t], near, far }
                | Projection::Ortho { window: [l, r, b, t], near, far }
                | Projection::OrthoContain { window: [l, r, b, t], near, far }
                | Projection::Isometric { window: [l, r, b, t], near, far }
                | Projection::PseudoIsometric { window: [l, r, b, t], near, far } => {
                    reals(&[l, r, b, t, near, far])
                }
                Projection::Oblique { angle_rad, window: [l, r, b, t], near, far, .. } => {
                    reals(&[angle_rad, l, r, b, t, near, far])
                }
                Projection::Window { vrp, p, vup, center: [cu, cv], half: [su, sv], dp, near, far } => {
                    vectors(&[vrp, p, vup])?;
                    reals(&[cu, cv, su, sv, dp, near, far])
                }
            },
            Command::Translate(v) | Command::Scale(v) | Command::Ambient(v) => vectors(&[*v]),
            Command::Rotate { axis, angle_rad } => {
                vectors(&[*axis])?;
                reals(&[*angle_rad])
            }
            Command::Shear(shears) => reals(&shears[..]),
            Command::Matrix(m) => reals(&m.to_cols_array()),
            Command::Light { light, .. } => {
                let fading = |a: &Attenuation| reals(&[a.c, a.l, a.q]);
                match &**light {
                    LightCommand::Point { position, color, attenuation } => {
                        vectors(&[*position, *color])?;
                        fading(attenuation)
                    }
                    LightCommand::Dir { direction, color } => vectors(&[*direction, *color]),
                    LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation } => {
                        vectors(&[*position, *direction, *color])?;
                        reals(&[*angle_rad, *exponent])?;
                        fading(attenuation)
                    }
                    LightCommand::Off => Ok(()),
                }
            }
            Command::Material(m) => {
                vectors(&[m.ka, m.kd, m.ks, m.emissive])?;
                reals(&[m.n, m.transparency])
            }
            Command::DrawScene { time, .. } => reals(&[*time]),
            Command::Quality(Quality::MaxError(e)) => reals(&[*e]),
            _ => Ok(()),
        }
    }
}

/// Checks that a value is not negative.
fn from_zero<T: Into<f64> + Copy + std::fmt::Display>(what: &str, value: T) -> Result<(), Fault> {
    match value.into() < 0.0 {
        false => Ok(()),
        true => Err(Fault::new(Code::Range, format!("the {what} must be 0 or more")).got(value.to_string())),
    }
}

/// Checks that a value fits in i32, as the text form requires.
fn in_i32(what: &str, value: u32) -> Result<(), Fault> {
    match i32::try_from(value) {
        Ok(_) => Ok(()),
        Err(_) => {
            Err(Fault::new(Code::Range, format!("{what} must be below 2147483648")).got(value.to_string()))
        }
    }
}

fn no_points() -> Result<(), Fault> {
    Err(Fault::new(Code::Args, "there must be a point"))
}

/// Checks that a text is UTF-8; the error gives the offset and value of the first invalid byte.
fn utf8_or_fault(utf8: &[u8]) -> Result<(), Fault> {
    match std::str::from_utf8(utf8) {
        Ok(_) => Ok(()),
        Err(e) => {
            let at = e.valid_up_to();
            let byte = utf8.get(at).copied().unwrap_or(0);
            Err(Fault::new(Code::Format, format!("the text must be UTF-8, and is not at byte {at}"))
                .got(format!("{byte:02x}")))
        }
    }
}

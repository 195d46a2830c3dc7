//! A command's bytes: what the decoder reads back as the same command.
//!
//! Numbers are printed in the shortest form that reads back bit by bit; colours as `rrggbbaa` or `rrggbb`. Defaults are
//! left out where the reader puts them back.

use super::decoder::MAX_LINE_BYTES;
use super::model::{
    AreaColors, Command, ErrorMode, FileKind, LightCommand, MeshSource, Quality, Rect, SnapTarget,
};
use crate::error::{Code, Fault};
use crate::memory::Rgba;
use crate::scene::{Attenuation, Material, ObliqueKind, Projection, Sampling, ViewportRule};
use glam::DVec3;
use std::io::Write;

/// Why a command has no bytes.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    /// The command is refused whoever sends it.
    #[error(transparent)]
    Refused(#[from] Fault),
    /// The line would be over the limit: a long POLY, FILLPOLY or POKE, or a long name.
    #[error("{verb} would take a line of {bytes} bytes, a line has at most {MAX_LINE_BYTES}")]
    LineTooLong {
        /// The verb.
        verb: &'static str,
        /// The line's bytes without LF.
        bytes: usize,
    },
    /// The language has no words for it: a texture called OFF or wrapped differently along its axes, a material with a
    /// file's texture.
    #[error("{verb} has no text for {what}")]
    NoText {
        /// The verb.
        verb: &'static str,
        /// What cannot be said.
        what: &'static str,
    },
}

impl EncodeError {
    /// The protocol's code for this error.
    pub fn code(&self) -> Code {
        match self {
            EncodeError::Refused(fault) => fault.code,
            EncodeError::LineTooLong { .. } => Code::TooBig,
            EncodeError::NoText { .. } => Code::Args,
        }
    }
}

/// Appends a command's bytes to `out`; on an error nothing is appended.
///
/// ```
/// use fbptr::command::{Command, encode};
/// let mut bytes = Vec::new();
/// encode(&Command::Pixel { x: 1, y: -2, color: [255, 128, 0, 255] }, &mut bytes)?;
/// encode(&Command::Text { x: 0, y: 0, color: [9, 9, 9, 0], utf8: b"hi".to_vec() }, &mut bytes)?;
/// assert_eq!(bytes, b"PX 1 -2 ff8000\nTEXT 0 0 09090900 :2\nhi");
/// # Ok::<(), fbptr::command::EncodeError>(())
/// ```
pub fn encode(command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
    command.check()?;
    let start = out.len();
    let result = write(command, out);
    if result.is_err() {
        out.truncate(start);
    }
    result
}

fn write(command: &Command, out: &mut Vec<u8>) -> Result<(), EncodeError> {
    let verb = command.verb();
    match command {
        Command::BinaryPixel { x, y, color } => {
            out.extend_from_slice(b"PB");
            out.extend_from_slice(&x.to_le_bytes());
            out.extend_from_slice(&y.to_le_bytes());
            out.extend_from_slice(color);
            return Ok(());
        }
        Command::PixelRun { x, y, rgba } => {
            let n = u32::try_from(rgba.len() / 4)
                .map_err(|_| Fault::new(Code::TooBig, "a run has at most 4294967295 pixels"))?;
            out.extend_from_slice(b"PXMULTI");
            out.extend_from_slice(&x.to_le_bytes());
            out.extend_from_slice(&y.to_le_bytes());
            out.extend_from_slice(&n.to_le_bytes());
            out.extend_from_slice(rgba);
            return Ok(());
        }
        _ => {}
    }
    let start = out.len();
    out.extend_from_slice(verb.as_bytes());
    let mut line = Line { verb, out };
    line.arguments(command)?;
    if let Some(payload) = command.payload() {
        line.word(format_args!(":{}", payload.len()));
    }
    let bytes = out.len() - start;
    if bytes > MAX_LINE_BYTES {
        return Err(EncodeError::LineTooLong { verb, bytes });
    }
    out.push(b'\n');
    out.extend_from_slice(command.payload().unwrap_or(b""));
    Ok(())
}

/// A text line in the making.
struct Line<'a> {
    verb: &'static str,
    out: &'a mut Vec<u8>,
}

impl Line<'_> {
    fn word(&mut self, word: impl std::fmt::Display) {
        write!(self.out, " {word}").expect("a Vec takes all bytes");
    }

    fn ints(&mut self, numbers: &[i32]) {
        numbers.iter().for_each(|n| self.word(n));
    }

    fn reals(&mut self, numbers: &[f64]) {
        for n in numbers {
            // Debug prints 1e300 short where Display writes 300 zeros; both are the shortest that read back.
            self.word(format_args!("{n:?}"));
        }
    }

    fn vectors(&mut self, vectors: &[DVec3]) {
        vectors.iter().for_each(|v| self.reals(&v.to_array()));
    }

    fn rect(&mut self, Rect { x, y, w, h }: Rect) {
        self.ints(&[x, y, w, h]);
    }

    fn color(&mut self, [r, g, b, a]: Rgba) {
        match a {
            255 => self.word(format_args!("{r:02x}{g:02x}{b:02x}")),
            a => self.word(format_args!("{r:02x}{g:02x}{b:02x}{a:02x}")),
        }
    }

    fn area(&mut self, colors: AreaColors) {
        match colors {
            AreaColors::One(color) => self.color(color),
            AreaColors::Three(colors) => colors.into_iter().for_each(|c| self.color(c)),
        }
    }

    fn switch(&mut self, on: bool) {
        self.word(if on { "on" } else { "off" });
    }

    fn attenuation(&mut self, a: Attenuation) {
        if a != Attenuation::NONE {
            self.reals(&[a.c, a.l, a.q]);
        }
    }

    fn no_text<T>(&self, what: &'static str) -> Result<T, EncodeError> {
        Err(EncodeError::NoText { verb: self.verb, what })
    }

    fn arguments(&mut self, command: &Command) -> Result<(), EncodeError> {
        match command {
            Command::Help
            | Command::Size
            | Command::Quit
            | Command::Stats
            | Command::Points { .. }
            | Command::Identity
            | Command::Push
            | Command::Pop
            | Command::Hello
            | Command::Version
            | Command::BinaryPixel { .. }
            | Command::PixelRun { .. } => {}
            Command::GetPixel { x, y }
            | Command::Offset { x, y }
            | Command::DepthAt { x, y }
            | Command::Pick { x, y } => self.ints(&[*x, *y]),
            Command::Pixel { x, y, color } => {
                self.ints(&[*x, *y]);
                self.color(*color);
            }
            Command::Poke { offset, bytes } => {
                self.ints(&[*offset]);
                self.out.push(b' ');
                for b in bytes {
                    write!(self.out, "{b:02x}").expect("a Vec takes all bytes");
                }
            }
            Command::Peek { offset, n } => self.ints(&[*offset, *n]),
            Command::Blit { rect, .. } | Command::Read { rect } => self.rect(*rect),
            Command::Copy { source, dx, dy } => {
                self.rect(*source);
                self.ints(&[*dx, *dy]);
            }
            Command::Crc { rect } => rect.iter().for_each(|r| self.rect(*r)),
            Command::Clear { color } => self.color(*color),
            Command::Line { p0, p1, color } => {
                self.ints([*p0, *p1].as_flattened());
                self.color(color.from);
                color.to.iter().for_each(|c| self.color(*c));
            }
            Command::Triangle { points, colors } => {
                self.ints(points.as_flattened());
                self.area(*colors);
            }
            Command::Fill { points, colors } => {
                self.reals(points.as_flattened());
                self.area(*colors);
            }
            Command::Rect { rect, color } | Command::FillRect { rect, color } => {
                self.rect(*rect);
                self.color(*color);
            }
            Command::Circle { cx, cy, r, color } => {
                self.ints(&[*cx, *cy, *r]);
                self.color(*color);
            }
            Command::FillCircle { cx, cy, r, color } => {
                self.reals(&[*cx, *cy, *r]);
                self.color(*color);
            }
            Command::Poly { color, points } => {
                self.color(*color);
                self.ints(points.as_flattened());
            }
            Command::FillPoly { color, points } => {
                self.color(*color);
                self.reals(points.as_flattened());
            }
            Command::Text { x, y, color, .. } => {
                self.ints(&[*x, *y]);
                self.color(*color);
            }
            Command::LineAa { p0, p1, color } => {
                self.reals([*p0, *p1].as_flattened());
                self.color(*color);
            }
            Command::Blend { over } => self.word(if *over { "over" } else { "replace" }),
            Command::Mesh { name, source } => {
                self.word(name);
                self.mesh(source);
            }
            Command::Texture { name, .. }
            | Command::Eye { name, .. }
            | Command::Free { name }
            | Command::Draw { name } => self.word(name),
            Command::Scene { .. } => self.word("X3D"),
            Command::Load { kind, name, path } => {
                self.word(match kind {
                    FileKind::Mesh => "MESH",
                    FileKind::Texture => "TEX",
                    FileKind::Scene => "SCENE",
                });
                if *kind != FileKind::Scene {
                    self.word(name);
                } else if !name.is_empty() {
                    return self.no_text("a scene's name");
                }
                self.word(path);
            }
            Command::LookAt { eye, reference, up } => self.vectors(&[*eye, *reference, *up]),
            Command::Projection(projection) => self.projection(projection),
            Command::Viewport { rect, rule } => {
                self.rect(*rect);
                if *rule == ViewportRule::Centres {
                    self.word("centres");
                }
            }
            Command::Translate(v) | Command::Scale(v) | Command::Ambient(v) => self.vectors(&[*v]),
            Command::Rotate { axis, angle_rad } => {
                self.vectors(&[*axis]);
                self.reals(&[*angle_rad]);
            }
            Command::Shear(shears) => self.reals(&shears[..]),
            Command::Matrix(m) => self.reals(&m.transpose().to_cols_array()),
            Command::Light { index, light } => {
                self.ints(&[*index]);
                self.light(light);
            }
            Command::Material(material) => self.material(material)?,
            Command::UseTexture { name, sampling } => self.texture(name.as_deref(), *sampling)?,
            Command::Shade(mode) => self.word(mode.as_str()),
            Command::Cull(mode) => self.word(mode.as_str()),
            Command::Hide(mode) => self.word(mode.as_str()),
            Command::Depth(format) => self.word(format.as_str()),
            Command::Interp(mode) => self.word(mode.as_str()),
            Command::DrawScene { time, sorted } => {
                self.reals(&[*time]);
                if *sorted {
                    self.word("SORTED");
                }
            }
            Command::DrawEye { name, rect } => {
                self.word(name);
                self.rect(*rect);
            }
            Command::Quality(Quality::Exact) => self.word("exact"),
            Command::Quality(Quality::MaxError(e)) => {
                self.word("max-error");
                self.reals(&[*e]);
            }
            Command::Sync { tag } => self.word(tag),
            Command::Auto(on) | Command::Events(on) => self.switch(*on),
            Command::Present { wait } => {
                if *wait {
                    self.word("wait");
                }
            }
            Command::Errors(mode) => self.word(match mode {
                ErrorMode::Count => "count",
                ErrorMode::Report => "report",
                ErrorMode::Close => "close",
            }),
            Command::Snap(SnapTarget::Connection) => self.word(":"),
            Command::Snap(SnapTarget::File(name)) if name == ":" => return self.no_text("a file called :"),
            Command::Snap(SnapTarget::File(name)) => self.word(name),
        }
        Ok(())
    }

    fn mesh(&mut self, source: &MeshSource) {
        match *source {
            MeshSource::Obj(_) => self.word("OBJ"),
            MeshSource::Box(size) => {
                self.word("BOX");
                self.vectors(&[size]);
            }
            MeshSource::Sphere(r) => {
                self.word("SPHERE");
                self.reals(&[r]);
            }
            MeshSource::Cone(r, h) => {
                self.word("CONE");
                self.reals(&[r, h]);
            }
            MeshSource::Cylinder(r, h) => {
                self.word("CYLINDER");
                self.reals(&[r, h]);
            }
            MeshSource::Teapot(level) => {
                self.word("TEAPOT");
                self.word(level);
            }
            MeshSource::Knot(nu, nv) => {
                self.word("KNOT");
                self.word(nu);
                self.word(nv);
            }
        }
    }

    fn projection(&mut self, projection: &Projection) {
        match *projection {
            Projection::Perspective { fov_rad, near, far, on_smaller_side } => {
                self.reals(&[fov_rad, near, far]);
                if on_smaller_side {
                    self.word("FOVMIN");
                }
            }
            Projection::Plane { d, near, far } => self.reals(&[d, near, far]),
            Projection::Frustum { window, near, far }
            | Projection::Ortho { window, near, far }
            | Projection::OrthoContain { window, near, far }
            | Projection::Isometric { window, near, far }
            | Projection::PseudoIsometric { window, near, far } => {
                self.reals(&window);
                self.reals(&[near, far]);
            }
            Projection::Oblique { kind, angle_rad, window, near, far } => {
                self.word(match kind {
                    ObliqueKind::Cavalier => "cavalier",
                    ObliqueKind::Cabinet => "cabinet",
                });
                self.reals(&[angle_rad]);
                self.reals(&window);
                self.reals(&[near, far]);
            }
            Projection::Window { vrp, p, vup, center, half, dp, near, far } => {
                self.vectors(&[vrp, p, vup]);
                self.reals([center, half].as_flattened());
                self.reals(&[dp, near, far]);
            }
        }
    }

    fn light(&mut self, light: &LightCommand) {
        match *light {
            LightCommand::Point { position, color, attenuation } => {
                self.word("POINT");
                self.vectors(&[position, color]);
                self.attenuation(attenuation);
            }
            LightCommand::Dir { direction, color } => {
                self.word("DIR");
                self.vectors(&[direction, color]);
            }
            LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation } => {
                self.word("SPOT");
                self.vectors(&[position, direction]);
                self.reals(&[angle_rad, exponent]);
                self.vectors(&[color]);
                self.attenuation(attenuation);
            }
            LightCommand::Off => self.word("OFF"),
        }
    }

    fn material(&mut self, m: &Material) -> Result<(), EncodeError> {
        let said = Material {
            ka: m.ka,
            kd: m.kd,
            ks: m.ks,
            n: m.n,
            emissive: m.emissive,
            transparency: m.transparency,
            ..Material::default()
        };
        if said != *m {
            return self.no_text("a material's name, texture or other equation");
        }
        self.vectors(&[m.ka, m.kd, m.ks]);
        self.reals(&[m.n]);
        self.vectors(&[m.emissive]);
        self.reals(&[m.transparency]);
        Ok(())
    }

    fn texture(&mut self, name: Option<&str>, sampling: Sampling) -> Result<(), EncodeError> {
        if sampling.wrap_s != sampling.wrap_t {
            return self.no_text("two ways of wrapping");
        }
        match name {
            Some(name) if name.eq_ignore_ascii_case("off") => return self.no_text("a texture called OFF"),
            Some(name) => self.word(name),
            None => self.word("OFF"),
        }
        self.word(sampling.filter.as_str());
        self.word(sampling.wrap_s.as_str());
        Ok(())
    }
}

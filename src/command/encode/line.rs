//! Writer of text lines: words of every kind, and the arguments of each command.

use super::EncodeError;
use crate::command::commands::{
    AreaColors, Command, ErrorMode, FileKind, Quality, RealRect, Rect, SnapTarget,
};
use crate::memory::Rgba;
use crate::scene::ViewportRule;
use glam::DVec3;
use std::io::Write;

/// Writer that appends one text line to a buffer.
pub(super) struct LineWriter<'a> {
    verb: &'static str,
    out: &'a mut Vec<u8>,
}

impl<'a> LineWriter<'a> {
    pub(super) fn new(verb: &'static str, out: &'a mut Vec<u8>) -> Self {
        LineWriter { verb, out }
    }

    /// Appends a blank and a word.
    pub(super) fn word(&mut self, word: impl std::fmt::Display) {
        write!(self.out, " {word}").expect("a Vec takes all bytes");
    }

    pub(super) fn ints(&mut self, numbers: &[i32]) {
        numbers.iter().for_each(|n| self.word(n));
    }

    /// Appends reals in the shortest form that reads back.
    pub(super) fn reals(&mut self, numbers: &[f64]) {
        for n in numbers {
            // Debug prints 1e300 in short form where Display writes 300 zeros; both are the
            // shortest that read back.
            self.word(format_args!("{n:?}"));
        }
    }

    pub(super) fn vectors(&mut self, vectors: &[DVec3]) {
        vectors.iter().for_each(|v| self.reals(&v.to_array()));
    }

    pub(super) fn rect(&mut self, Rect { x, y, w, h }: Rect) {
        self.ints(&[x, y, w, h]);
    }

    /// Appends a colour: `rrggbb` if it is opaque, otherwise `rrggbbaa`.
    pub(super) fn color(&mut self, [r, g, b, a]: Rgba) {
        match a {
            255 => self.word(format_args!("{r:02x}{g:02x}{b:02x}")),
            a => self.word(format_args!("{r:02x}{g:02x}{b:02x}{a:02x}")),
        }
    }

    pub(super) fn area(&mut self, colors: AreaColors) {
        match colors {
            AreaColors::One(color) => self.color(color),
            AreaColors::Three(colors) => colors.into_iter().for_each(|c| self.color(c)),
        }
    }

    pub(super) fn switch(&mut self, on: bool) {
        self.word(if on { "on" } else { "off" });
    }

    /// Returns the error for a part that has no text form.
    pub(super) fn no_text<T>(&self, what: &'static str) -> Result<T, EncodeError> {
        Err(EncodeError::NoText { verb: self.verb, what })
    }

    /// Appends the arguments of a text command, without its payload length.
    pub(super) fn arguments(&mut self, command: &Command) -> Result<(), EncodeError> {
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
            Command::Rect { rect, color } => {
                self.rect(*rect);
                self.color(*color);
            }
            Command::FillRect { rect: RealRect { x, y, w, h }, color } => {
                self.reals(&[*x, *y, *w, *h]);
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
}

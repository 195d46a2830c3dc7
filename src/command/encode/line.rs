//! Writer of text lines: words of every kind, and the arguments of each command.

use super::EncodeError;
use crate::command::commands::{
    AreaColors, Command, ErrorMode, Figure, FileKind, Quality, RampColor, RealRect, Rect, SnapTarget,
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

    /// Appends whole numbers and a colour.
    fn ints_and_color(&mut self, numbers: &[i32], color: Rgba) {
        self.ints(numbers);
        self.color(color);
    }

    /// Appends reals and a colour.
    fn reals_and_color(&mut self, numbers: &[f64], color: Rgba) {
        self.reals(numbers);
        self.color(color);
    }

    /// Appends the end points of a line and its colours, the second if it has one.
    fn line(&mut self, p0: [i32; 2], p1: [i32; 2], color: RampColor) {
        self.ints_and_color([p0, p1].as_flattened(), color.from);
        color.to.iter().for_each(|c| self.color(*c));
    }

    /// Appends an offset and the bytes to store there in hex, as one word.
    fn poke(&mut self, offset: i32, bytes: &[u8]) {
        self.word(offset);
        self.out.push(b' ');
        for b in bytes {
            write!(self.out, "{b:02x}").expect("a Vec takes all bytes");
        }
    }

    /// Appends the arguments of a line, area or text.
    fn figure(&mut self, figure: &Figure) {
        match figure {
            Figure::Line { p0, p1, color } => self.line(*p0, *p1, *color),
            Figure::Triangle { points, colors } => {
                self.ints(points.as_flattened());
                self.area(*colors);
            }
            Figure::Fill { points, colors } => {
                self.reals(points.as_flattened());
                self.area(*colors);
            }
            Figure::Rect { rect: Rect { x, y, w, h }, color } => {
                self.ints_and_color(&[*x, *y, *w, *h], *color)
            }
            Figure::FillRect { rect: RealRect { x, y, w, h }, color } => {
                self.reals_and_color(&[*x, *y, *w, *h], *color);
            }
            Figure::Circle { cx, cy, r, color } => self.ints_and_color(&[*cx, *cy, *r], *color),
            Figure::FillCircle { cx, cy, r, color } => self.reals_and_color(&[*cx, *cy, *r], *color),
            Figure::Poly { color, points } => {
                self.color(*color);
                self.ints(points.as_flattened());
            }
            Figure::FillPoly { color, points } => {
                self.color(*color);
                self.reals(points.as_flattened());
            }
            Figure::LineAa { p0, p1, color } => self.reals_and_color([*p0, *p1].as_flattened(), *color),
            Figure::Text { x, y, color, .. } => self.ints_and_color(&[*x, *y], *color),
        }
    }

    /// Appends the kind of a file, the name that it is given and its path.
    fn load(&mut self, kind: FileKind, name: &str, path: &str) -> Result<(), EncodeError> {
        self.word(match kind {
            FileKind::Mesh => "MESH",
            FileKind::Texture => "TEX",
            FileKind::Scene => "SCENE",
        });
        if kind != FileKind::Scene {
            self.word(name);
        } else if !name.is_empty() {
            return self.no_text("a scene's name");
        }
        self.word(path);
        Ok(())
    }

    fn viewport(&mut self, rect: Rect, rule: ViewportRule) {
        self.rect(rect);
        if rule == ViewportRule::Centres {
            self.word("centres");
        }
    }

    fn draw_scene(&mut self, time: f64, sorted: bool) {
        self.reals(&[time]);
        if sorted {
            self.word("SORTED");
        }
    }

    fn quality(&mut self, quality: Quality) {
        match quality {
            Quality::Exact => self.word("exact"),
            Quality::MaxError(e) => {
                self.word("max-error");
                self.reals(&[e]);
            }
        }
    }

    fn errors(&mut self, mode: ErrorMode) {
        self.word(match mode {
            ErrorMode::Count => "count",
            ErrorMode::Report => "report",
            ErrorMode::Close => "close",
        });
    }

    fn snap(&mut self, target: &SnapTarget) -> Result<(), EncodeError> {
        match target {
            SnapTarget::Connection => self.word(":"),
            SnapTarget::File(name) if name == ":" => return self.no_text("a file called :"),
            SnapTarget::File(name) => self.word(name),
        }
        Ok(())
    }

    /// Appends the arguments of a text command, without its payload length.
    pub(super) fn arguments(&mut self, command: &Command) -> Result<(), EncodeError> {
        use Command as C;
        match command {
            C::Help | C::Size | C::Quit | C::Stats | C::Points { .. } | C::Hello | C::Version => {}
            C::Identity | C::Push | C::Pop | C::BinaryPixel { .. } | C::PixelRun { .. } => {}
            C::GetPixel { x, y } | C::Offset { x, y } | C::DepthAt { x, y } | C::Pick { x, y } => {
                self.ints(&[*x, *y]);
            }
            C::Pixel { x, y, color } => self.ints_and_color(&[*x, *y], *color),
            C::Poke { offset, bytes } => self.poke(*offset, bytes),
            C::Peek { offset, n } => self.ints(&[*offset, *n]),
            C::Blit { rect, .. } | C::Read { rect } => self.rect(*rect),
            C::Copy { source: Rect { x, y, w, h }, dx, dy } => self.ints(&[*x, *y, *w, *h, *dx, *dy]),
            C::Crc { rect } => rect.iter().for_each(|r| self.rect(*r)),
            C::Clear { color } => self.color(*color),
            C::Figure(figure) => self.figure(figure),
            C::Blend { over } => self.word(if *over { "over" } else { "replace" }),
            C::Mesh { name, source } => self.mesh(name, source),
            C::Texture { name, .. } | C::Eye { name, .. } | C::Free { name } | C::Draw { name } => {
                self.word(name);
            }
            C::Scene { .. } => self.word("X3D"),
            C::Load { kind, name, path } => self.load(*kind, name, path)?,
            C::LookAt { eye, reference, up } => self.vectors(&[*eye, *reference, *up]),
            C::Projection(projection) => self.projection(projection),
            C::Viewport { rect, rule } => self.viewport(*rect, *rule),
            C::Translate(v) | C::Scale(v) | C::Ambient(v) => self.vectors(&[*v]),
            C::Rotate { axis, angle_rad } => self.reals(&[axis.x, axis.y, axis.z, *angle_rad]),
            C::Shear(shears) => self.reals(&shears[..]),
            C::Matrix(m) => self.reals(&m.transpose().to_cols_array()),
            C::Light { index, light } => self.light(*index, light),
            C::Material(material) => self.material(material)?,
            C::UseTexture { name, sampling } => self.texture(name.as_deref(), *sampling)?,
            C::Shade(mode) => self.word(mode.as_str()),
            C::Cull(mode) => self.word(mode.as_str()),
            C::Hide(mode) => self.word(mode.as_str()),
            C::Depth(format) => self.word(format.as_str()),
            C::Interp(mode) => self.word(mode.as_str()),
            C::DrawScene { time, sorted } => self.draw_scene(*time, *sorted),
            C::DrawEye { name, rect } => {
                self.word(name);
                self.rect(*rect);
            }
            C::Quality(quality) => self.quality(*quality),
            C::Sync { tag } => self.word(tag),
            C::Auto(on) | C::Events(on) => self.switch(*on),
            C::Present { wait: true } => self.word("wait"),
            C::Present { wait: false } => {}
            C::Errors(mode) => self.errors(*mode),
            C::Snap(target) => self.snap(target)?,
        }
        Ok(())
    }
}

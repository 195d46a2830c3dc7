//! The closed [`Command`] enum: one variant per verb, numbers already parsed and finite.

pub use crate::draw2d::{AreaColors, RampColor, RealRect, Rect};
use crate::memory::{DepthFormat, Rgba};
use crate::scene::{
    Attenuation, Cull, HiddenSurface, Interpolation, Material, Projection, Sampling, ShadeMode, ViewportRule,
};
use glam::{DMat4, DVec3};

/// Source of the mesh that `MESH` defines.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// An OBJ file's bytes.
    Obj(Vec<u8>),
    /// X3D's Box: size x, y, z (default 2 2 2).
    Box(DVec3),
    /// X3D's Sphere: radius (default 1).
    Sphere(f64),
    /// X3D's Cone: bottom radius, height (default 1, 2).
    Cone(f64, f64),
    /// X3D's Cylinder: radius, height (default 1, 2).
    Cylinder(f64, f64),
    /// Newell's teapot, each patch divided into `level` x `level` quads (default 10).
    Teapot(u32),
    /// The torus knot (2,3) as a grid of nu x nv quads.
    Knot(u32, u32),
}

/// Kind of file that `LOAD` reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FileKind {
    /// `LOAD MESH name path`.
    Mesh,
    /// `LOAD TEX name path`.
    Texture,
    /// `LOAD SCENE path`.
    Scene,
}

/// Arguments of `LIGHT i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightCommand {
    /// A point light.
    Point {
        /// World position.
        position: DVec3,
        /// R, G, B.
        color: DVec3,
        /// Attenuation.
        attenuation: Attenuation,
    },
    /// A directional light.
    Dir {
        /// Direction in which the light travels.
        direction: DVec3,
        /// R, G, B.
        color: DVec3,
    },
    /// A spot light.
    Spot {
        /// World position.
        position: DVec3,
        /// Direction of the axis.
        direction: DVec3,
        /// Half angle of the cone in radians.
        angle_rad: f64,
        /// Exponent of the cosine falloff.
        exponent: f64,
        /// R, G, B.
        color: DVec3,
        /// Attenuation.
        attenuation: Attenuation,
    },
    /// Removes the light at this index.
    Off,
}

/// Six shear factors: xy, xz, yx, yz, zx, zy.
pub type Shears = [f64; 6];

/// Argument of `QUALITY`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quality {
    /// The exact pipeline.
    Exact,
    /// The cheapest settings whose 99.9th percentile of colour error stays within this many 1/255
    /// steps.
    MaxError(f64),
}

/// Destination of `SNAP`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SnapTarget {
    /// A file in the snapshot folder; its extension gives the format.
    File(String),
    /// A PNG sent on the connection.
    Connection,
}

/// Line, area or text of two dimensions. Each variant is the verb of that name; its doc comment gives
/// the text form.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields carry the names of the text form in each variant's doc")]
pub enum Figure {
    /// `LINE x0 y0 x1 y1 c0 [c1]`
    Line { p0: [i32; 2], p1: [i32; 2], color: RampColor },
    /// `TRI x0 y0 x1 y1 x2 y2 c0 [c1 c2]`
    Triangle { points: [[i32; 2]; 3], colors: AreaColors },
    /// `FILL x0 y0 x1 y1 x2 y2 c0 [c1 c2]`
    Fill { points: [[f64; 2]; 3], colors: AreaColors },
    /// `RECT x y w h c`
    Rect { rect: Rect, color: Rgba },
    /// `FILLRECT x y w h c`
    FillRect { rect: RealRect, color: Rgba },
    /// `CIRCLE cx cy r c`
    Circle { cx: i32, cy: i32, r: i32, color: Rgba },
    /// `FILLCIRCLE cx cy r c`
    FillCircle { cx: f64, cy: f64, r: f64, color: Rgba },
    /// `POLY c x0 y0 x1 y1 ...`
    Poly { color: Rgba, points: Vec<[i32; 2]> },
    /// `FILLPOLY c x0 y0 ...`
    FillPoly { color: Rgba, points: Vec<[f64; 2]> },
    /// `TEXT x y c :N`
    Text { x: i32, y: i32, color: Rgba, utf8: Vec<u8> },
    /// `LINEAA x0 y0 x1 y1 c`
    LineAa { p0: [f64; 2], p1: [f64; 2], color: Rgba },
}

/// One command. Each variant is the verb of that name; its doc comment gives the text form.
///
/// Numbers are parsed and finite, names are text without blanks, payloads are complete. When it
/// runs, a command can still be refused for ranges, names, formats of payloads, limits and
/// permissions.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "fields carry the names of the text form in each variant's doc")]
pub enum Command {
    /// `HELP`
    Help,
    /// `SIZE`
    Size,
    /// `PX x y`
    GetPixel { x: i32, y: i32 },
    /// `PX x y colour`: translated by OFFSET.
    Pixel { x: i32, y: i32, color: Rgba },
    /// `OFFSET x y`
    Offset { x: i32, y: i32 },
    /// `QUIT`
    Quit,
    /// `STATS`
    Stats,
    /// Binary `PB`: not translated by OFFSET.
    BinaryPixel { x: u16, y: u16, color: Rgba },
    /// Binary `PXMULTI`: RGBA bytes of a run of pixels, linear from (x, y).
    PixelRun { x: u16, y: u16, rgba: Vec<u8> },
    /// `POKE offset hexbytes`
    Poke { offset: i32, bytes: Vec<u8> },
    /// `PEEK offset n`
    Peek { offset: i32, n: i32 },
    /// `BLIT x y w h :N`
    Blit { rect: Rect, rgba: Vec<u8> },
    /// `READ x y w h`
    Read { rect: Rect },
    /// `COPY sx sy w h dx dy`
    Copy { source: Rect, dx: i32, dy: i32 },
    /// `POINTS :N`: x:u16le y:u16le r g b a each.
    Points { packed: Vec<u8> },
    /// `CRC [x y w h]`
    Crc { rect: Option<Rect> },
    /// `CLEAR [colour]`
    Clear { color: Rgba },
    /// `LINE`, `TRI`, `FILL`, `RECT`, `FILLRECT`, `CIRCLE`, `FILLCIRCLE`, `POLY`, `FILLPOLY`, `TEXT`,
    /// `LINEAA`
    Figure(Figure),
    /// `BLEND replace|over`: `over` composes source-over.
    Blend { over: bool },
    /// `MESH name ...`
    Mesh { name: String, source: Box<MeshSource> },
    /// `TEX name :N`
    Texture { name: String, file: Vec<u8> },
    /// `SCENE X3D :N`
    Scene { x3d: Vec<u8> },
    /// `EYE name :N`
    Eye { name: String, json: Vec<u8> },
    /// `FREE name`
    Free { name: String },
    /// `LOAD MESH|TEX name path`, `LOAD SCENE path` (then `name` is empty)
    Load { kind: FileKind, name: String, path: String },
    /// `LOOKAT ex ey ez rx ry rz ux uy uz`
    LookAt { eye: DVec3, reference: DVec3, up: DVec3 },
    /// `PERSPECTIVE`, `PLANE`, `FRUSTUM`, `ORTHO`, `OBLIQUE`, `ISOMETRIC`, `PSEUDOISO`, `WINDOW`
    Projection(Box<Projection>),
    /// `VIEWPORT x y w h [centres|corners]`
    Viewport { rect: Rect, rule: ViewportRule },
    /// `IDENTITY`
    Identity,
    /// `PUSH`
    Push,
    /// `POP`
    Pop,
    /// `TRANSLATE x y z`
    Translate(DVec3),
    /// `ROTATE ax ay az angle`
    Rotate { axis: DVec3, angle_rad: f64 },
    /// `SCALE x y z`
    Scale(DVec3),
    /// `SHEAR xy xz yx yz zx zy`
    Shear(Box<Shears>),
    /// `MATRIX m00..m33`, row by row
    Matrix(Box<DMat4>),
    /// `AMBIENT r g b`
    Ambient(DVec3),
    /// `LIGHT i ...`
    Light { index: i32, light: Box<LightCommand> },
    /// `MATERIAL ka kd ks n [emissive [transparency]]`
    Material(Box<Material>),
    /// `TEXTURE name|OFF [filter] [wrap]`; `None` is OFF
    UseTexture { name: Option<String>, sampling: Sampling },
    /// `SHADE wire|flat|gouraud|phong`
    Shade(ShadeMode),
    /// `CULL back|front|none`
    Cull(Cull),
    /// `HIDE zbuffer|painter|none`
    Hide(HiddenSurface),
    /// `DEPTH u16|u24|u32|f32|reversed`
    Depth(DepthFormat),
    /// `INTERP perspective|affine`
    Interp(Interpolation),
    /// `DRAW name`
    Draw { name: String },
    /// `DRAWSCENE [time] [SORTED]`
    DrawScene { time: f64, sorted: bool },
    /// `DRAWEYE name x y w h`
    DrawEye { name: String, rect: Rect },
    /// `QUALITY max-error E | exact`
    Quality(Quality),
    /// `DEPTHAT x y`
    DepthAt { x: i32, y: i32 },
    /// `PICK x y`
    Pick { x: i32, y: i32 },
    /// `SYNC tag`
    Sync { tag: String },
    /// `HELLO`
    Hello,
    /// `VERSION`
    Version,
    /// `AUTO on|off`
    Auto(bool),
    /// `PRESENT [wait]`
    Present { wait: bool },
    /// `EVENTS on|off`
    Events(bool),
    /// `ERRORS count|report|close`
    Errors(ErrorMode),
    /// `SNAP name` or `SNAP :`
    Snap(SnapTarget),
}

impl Command {
    /// Returns the verb's name in the table.
    pub fn verb(&self) -> &'static str {
        match self {
            Command::Help => "HELP",
            Command::Size => "SIZE",
            Command::GetPixel { .. } | Command::Pixel { .. } => "PX",
            Command::Offset { .. } => "OFFSET",
            Command::Quit => "QUIT",
            Command::Stats => "STATS",
            Command::BinaryPixel { .. } => "PB",
            Command::PixelRun { .. } => "PXMULTI",
            Command::Poke { .. } => "POKE",
            Command::Peek { .. } => "PEEK",
            Command::Blit { .. } => "BLIT",
            Command::Read { .. } => "READ",
            Command::Copy { .. } => "COPY",
            Command::Points { .. } => "POINTS",
            Command::Crc { .. } => "CRC",
            Command::Clear { .. } => "CLEAR",
            Command::Figure(figure) => figure.verb(),
            Command::Blend { .. } => "BLEND",
            Command::Mesh { .. } => "MESH",
            Command::Texture { .. } => "TEX",
            Command::Scene { .. } => "SCENE",
            Command::Eye { .. } => "EYE",
            Command::Free { .. } => "FREE",
            Command::Load { .. } => "LOAD",
            Command::LookAt { .. } => "LOOKAT",
            Command::Projection(projection) => projection_verb(projection),
            Command::Viewport { .. } => "VIEWPORT",
            Command::Identity => "IDENTITY",
            Command::Push => "PUSH",
            Command::Pop => "POP",
            Command::Translate(_) => "TRANSLATE",
            Command::Rotate { .. } => "ROTATE",
            Command::Scale(_) => "SCALE",
            Command::Shear(_) => "SHEAR",
            Command::Matrix(_) => "MATRIX",
            Command::Ambient(_) => "AMBIENT",
            Command::Light { .. } => "LIGHT",
            Command::Material(_) => "MATERIAL",
            Command::UseTexture { .. } => "TEXTURE",
            Command::Shade(_) => "SHADE",
            Command::Cull(_) => "CULL",
            Command::Hide(_) => "HIDE",
            Command::Depth(_) => "DEPTH",
            Command::Interp(_) => "INTERP",
            Command::Draw { .. } => "DRAW",
            Command::DrawScene { .. } => "DRAWSCENE",
            Command::DrawEye { .. } => "DRAWEYE",
            Command::Quality(_) => "QUALITY",
            Command::DepthAt { .. } => "DEPTHAT",
            Command::Pick { .. } => "PICK",
            Command::Sync { .. } => "SYNC",
            Command::Hello => "HELLO",
            Command::Version => "VERSION",
            Command::Auto(_) => "AUTO",
            Command::Present { .. } => "PRESENT",
            Command::Events(_) => "EVENTS",
            Command::Errors(_) => "ERRORS",
            Command::Snap(_) => "SNAP",
        }
    }

    /// Returns the bytes that follow the command's line or header, or `None` for a command without
    /// payload.
    pub fn payload(&self) -> Option<&[u8]> {
        match self {
            Command::PixelRun { rgba, .. } | Command::Blit { rgba, .. } => Some(rgba),
            Command::Points { packed } => Some(packed),
            Command::Figure(Figure::Text { utf8, .. }) => Some(utf8),
            Command::Texture { file, .. } => Some(file),
            Command::Scene { x3d } => Some(x3d),
            Command::Eye { json, .. } => Some(json),
            Command::Mesh { source, .. } => match &**source {
                MeshSource::Obj(file) => Some(file),
                _ => None,
            },
            _ => None,
        }
    }

    /// Returns the payload for writing; `None` as in [`Command::payload`].
    pub(super) fn payload_mut(&mut self) -> Option<&mut Vec<u8>> {
        match self {
            Command::PixelRun { rgba, .. } | Command::Blit { rgba, .. } => Some(rgba),
            Command::Points { packed } => Some(packed),
            Command::Figure(Figure::Text { utf8, .. }) => Some(utf8),
            Command::Texture { file, .. } => Some(file),
            Command::Scene { x3d } => Some(x3d),
            Command::Eye { json, .. } => Some(json),
            Command::Mesh { source, .. } => match &mut **source {
                MeshSource::Obj(file) => Some(file),
                _ => None,
            },
            _ => None,
        }
    }
}

impl Figure {
    /// Returns the verb's name in the table.
    fn verb(&self) -> &'static str {
        match self {
            Figure::Line { .. } => "LINE",
            Figure::Triangle { .. } => "TRI",
            Figure::Fill { .. } => "FILL",
            Figure::Rect { .. } => "RECT",
            Figure::FillRect { .. } => "FILLRECT",
            Figure::Circle { .. } => "CIRCLE",
            Figure::FillCircle { .. } => "FILLCIRCLE",
            Figure::Poly { .. } => "POLY",
            Figure::FillPoly { .. } => "FILLPOLY",
            Figure::Text { .. } => "TEXT",
            Figure::LineAa { .. } => "LINEAA",
        }
    }
}

/// Returns the verb that sets a projection.
fn projection_verb(projection: &Projection) -> &'static str {
    match projection {
        Projection::Perspective { .. } => "PERSPECTIVE",
        Projection::Plane { .. } => "PLANE",
        Projection::Frustum { .. } => "FRUSTUM",
        Projection::Ortho { .. } | Projection::OrthoContain { .. } => "ORTHO",
        Projection::Oblique { .. } => "OBLIQUE",
        Projection::Isometric { .. } => "ISOMETRIC",
        Projection::PseudoIsometric { .. } => "PSEUDOISO",
        Projection::Window { .. } => "WINDOW",
    }
}

/// Error reporting mode of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorMode {
    /// Count errors; STATS reports the number.
    Count,
    /// Send one line per error.
    Report,
    /// Send the first error and close the connection.
    Close,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_queued_command_stays_small() {
        assert!(size_of::<Command>() <= 88, "{} bytes", size_of::<Command>());
    }
}

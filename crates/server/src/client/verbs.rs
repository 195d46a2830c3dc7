//! The verbs that draw and set states: each method queues one command and returns at once.

use super::Client;
use super::methods::client_methods;
use fbptr_command::{
    AreaColors, Command, ErrorMode, Figure, FileKind, LightCommand, MeshSource, Quality, RampColor, RealRect,
    Rect, Shears,
};
use fbptr_command::{unless_written, verbs};
use fbptr_core::memory::{DepthFormat, Rgba};
use fbptr_core::scene::{
    Cull, HiddenSurface, Interpolation, Material, Projection, Sampling, ShadeMode, ViewportRule,
};
use glam::{DMat4, DVec3};

/// Pixels and bytes.
impl Client {
    /// Sends `CLEAR colour`.
    pub fn clear(&self, color: Rgba) {
        self.send(Command::Clear { color });
    }

    /// Sends `PX x y colour`.
    #[doc(alias = "putPixel")]
    pub fn put_pixel(&self, x: i32, y: i32, color: Rgba) {
        self.send(Command::Pixel { x, y, color });
    }

    /// Sends `PB`: a pixel that `OFFSET` does not move.
    pub fn binary_pixel(&self, x: u16, y: u16, color: Rgba) {
        self.send(Command::BinaryPixel { x, y, color });
    }

    /// Sends `PXMULTI`: a run of RGBA pixels from (x, y) on, over the ends of rows.
    pub fn pixel_run(&self, x: u16, y: u16, rgba: Vec<u8>) {
        self.send(Command::PixelRun { x, y, rgba });
    }

    /// Sends `OFFSET`: moves the later pixels of [`Client::put_pixel`] and [`Client::get_pixel`].
    pub fn offset(&self, x: i32, y: i32) {
        self.send(Command::Offset { x, y });
    }

    /// Sends `POKE`: writes bytes at the byte offset (width * y + x) * 4.
    pub fn poke(&self, offset: i32, bytes: Vec<u8>) {
        self.send(Command::Poke { offset, bytes });
    }

    /// Sends `BLIT`: draws RGBA rows.
    pub fn blit(&self, rect: impl Into<Rect>, rgba: Vec<u8>) {
        self.send(Command::Blit { rect: rect.into(), rgba });
    }

    /// Sends `COPY`: copies a rectangle to the place with the upper left corner `dest`.
    pub fn copy(&self, source: impl Into<Rect>, dest: [i32; 2]) {
        self.send(Command::Copy { source: source.into(), dx: dest[0], dy: dest[1] });
    }

    /// Sends `POINTS`: packed pixels of 8 bytes each, x and y as u16 little-endian, r, g, b, a.
    pub fn points(&self, packed: Vec<u8>) {
        self.send(Command::Points { packed });
    }
}

/// Lines, areas and text.
impl Client {
    fn figure(&self, figure: Figure) {
        self.send(Command::Figure(figure));
    }

    /// Sends `LINE`. Two colours are a ramp between the ends.
    pub fn line(&self, p0: [i32; 2], p1: [i32; 2], color: impl Into<RampColor>) {
        self.figure(Figure::Line { p0, p1, color: color.into() });
    }

    /// Sends `LINEAA`.
    pub fn line_aa(&self, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
        self.figure(Figure::LineAa { p0, p1, color });
    }

    /// Sends `TRI`.
    pub fn triangle(&self, points: [[i32; 2]; 3], colors: impl Into<AreaColors>) {
        self.figure(Figure::Triangle { points, colors: colors.into() });
    }

    /// Sends `FILL`. Three colours are interpolated between the corners.
    pub fn fill(&self, points: [[f64; 2]; 3], colors: impl Into<AreaColors>) {
        self.figure(Figure::Fill { points, colors: colors.into() });
    }

    /// Sends `RECT`.
    pub fn rect(&self, rect: impl Into<Rect>, color: Rgba) {
        self.figure(Figure::Rect { rect: rect.into(), color });
    }

    /// Sends `FILLRECT`: fills the pixels whose centres lie in the rectangle.
    pub fn fill_rect(&self, rect: impl Into<RealRect>, color: Rgba) {
        self.figure(Figure::FillRect { rect: rect.into(), color });
    }

    /// Sends `CIRCLE`.
    pub fn circle(&self, [cx, cy]: [i32; 2], r: i32, color: Rgba) {
        self.figure(Figure::Circle { cx, cy, r, color });
    }

    /// Sends `FILLCIRCLE`.
    pub fn fill_circle(&self, [cx, cy]: [f64; 2], r: f64, color: Rgba) {
        self.figure(Figure::FillCircle { cx, cy, r, color });
    }

    /// Sends `POLY`.
    pub fn poly(&self, points: Vec<[i32; 2]>, color: Rgba) {
        self.figure(Figure::Poly { color, points });
    }

    /// Sends `FILLPOLY`.
    pub fn fill_poly(&self, points: Vec<[f64; 2]>, color: Rgba) {
        self.figure(Figure::FillPoly { color, points });
    }

    /// Sends `TEXT`; (x, y) is the upper left corner of its first character.
    pub fn text(&self, [x, y]: [i32; 2], text: &str, color: Rgba) {
        self.figure(Figure::Text { x, y, color, utf8: text.as_bytes().to_vec() });
    }

    /// Sends `PRINT`: one line of text, without control characters.
    pub fn print(&self, [x, y]: [i32; 2], text: &str, color: Rgba) {
        self.figure(Figure::Print { x, y, color, text: text.to_owned() });
    }

    /// Sends `TEXTSIZE`: the magnification of the letters of text, 1 to 8.
    pub fn text_size(&self, size: u8) {
        self.send(Command::TextSize { size: size.into() });
    }

    /// Sends `WIDELINE`: a line of any width with round ends.
    pub fn wide_line(&self, p0: [f64; 2], p1: [f64; 2], width: f64, color: Rgba) {
        self.figure(Figure::WideLine { p0, p1, width, color });
    }

    /// Sends `ELLIPSE`: the rim of a filled ellipse.
    pub fn ellipse(&self, center: [f64; 2], radii: [f64; 2], color: Rgba) {
        self.figure(Figure::Ellipse { center, radii, color });
    }

    /// Sends `FILLELLIPSE`.
    pub fn fill_ellipse(&self, center: [f64; 2], radii: [f64; 2], color: Rgba) {
        self.figure(Figure::FillEllipse { center, radii, color });
    }

    /// Sends `ARC`: a part of a ring.
    pub fn arc(&self, arc: fbptr_core::draw2d::Arc, color: Rgba) {
        let fbptr_core::draw2d::Arc { center, radii, angles } = arc;
        self.figure(Figure::Arc { center, radii, angles, color });
    }

    /// Sends `BEZIER`: a cubic curve of any width with round ends.
    pub fn bezier(&self, points: [[f64; 2]; 4], width: f64, color: Rgba) {
        self.figure(Figure::Bezier { points, width, color });
    }

    /// Sends `IMAGE` with the bytes of a PNG or JPEG file.
    pub fn image(&self, [x, y]: [i32; 2], file: Vec<u8>) {
        self.send(Command::Image { x, y, file });
    }

    /// Sends `CLIP`: later drawing of this client touches a rectangle alone, or with `None` all.
    pub fn clip(&self, rect: Option<Rect>) {
        self.send(Command::Clip { rect });
    }

    /// Sends `CANVAS`: makes a transparent canvas of `w` x `h` pixels.
    pub fn canvas(&self, name: &str, w: i32, h: i32) {
        self.send(Command::Canvas { name: name.into(), w, h });
    }

    /// Sends `TARGET`: draws and reads later on a canvas, or with `None` on the frame.
    pub fn target(&self, name: Option<&str>) {
        self.send(Command::Target { name: name.map(str::to_owned) });
    }

    /// Sends `STAMP`: puts a canvas on the target, but for its pixels of the key's colour.
    pub fn stamp(&self, name: &str, [x, y]: [i32; 2], key: Option<Rgba>) {
        self.send(Command::Stamp { name: name.into(), x, y, key });
    }

    /// Sends `BLEND over` or `BLEND replace`.
    pub fn blend(&self, blend: fbptr_core::draw2d::Blend) {
        self.send(Command::Blend { over: blend == fbptr_core::draw2d::Blend::Over });
    }
}

/// Meshes, textures and scenes by name.
impl Client {
    /// Sends `MESH`.
    pub fn mesh(&self, name: &str, source: MeshSource) {
        self.send(Command::Mesh { name: name.into(), source: Box::new(source) });
    }

    /// Sends `TEX` with the bytes of a PNG or JPEG file.
    pub fn texture(&self, name: &str, file: Vec<u8>) {
        self.send(Command::Texture { name: name.into(), file });
    }

    /// Sends `SCENE X3D` with the bytes of an X3D file.
    pub fn scene(&self, x3d: Vec<u8>) {
        self.send(Command::Scene { x3d });
    }

    /// Sends `EYE` with the JSON of an N-dimensional scene.
    pub fn eye(&self, name: &str, json: Vec<u8>) {
        self.send(Command::Eye { name: name.into(), json });
    }

    /// Sends `LOAD MESH`: an OBJ file of the server's own folder.
    pub fn load_mesh(&self, name: &str, path: &str) {
        self.send(Command::Load { kind: FileKind::Mesh, name: name.into(), path: path.into() });
    }

    /// Sends `LOAD TEX`: a picture of the server's own folder.
    pub fn load_texture(&self, name: &str, path: &str) {
        self.send(Command::Load { kind: FileKind::Texture, name: name.into(), path: path.into() });
    }

    /// Sends `LOAD SCENE`: an X3D file of the server's own folder.
    pub fn load_scene(&self, path: &str) {
        self.send(Command::Load { kind: FileKind::Scene, name: String::new(), path: path.into() });
    }

    /// Sends `FREE`.
    pub fn free(&self, name: &str) {
        self.send(Command::Free { name: name.into() });
    }

    /// Sends `DRAW`.
    pub fn draw(&self, name: &str) {
        self.send(Command::Draw { name: name.into() });
    }

    /// Sends `DRAWSCENE`: the scene at a time in seconds, its transparent faces in file order or
    /// sorted by distance.
    pub fn draw_scene(&self, time: f64, sorted: bool) {
        self.send(Command::DrawScene { time, sorted });
    }

    /// Sends `DRAWEYE`.
    pub fn draw_eye(&self, name: &str, rect: impl Into<Rect>) {
        self.send(Command::DrawEye { name: name.into(), rect: rect.into() });
    }
}

/// Camera, model matrix and lights.
impl Client {
    /// Sends `LOOKAT`.
    pub fn look_at(&self, eye: impl Into<DVec3>, reference: impl Into<DVec3>, up: impl Into<DVec3>) {
        self.send(Command::LookAt { eye: eye.into(), reference: reference.into(), up: up.into() });
    }

    /// Sends the verb of a projection: `PERSPECTIVE`, `PLANE`, `FRUSTUM`, `ORTHO`, `OBLIQUE`,
    /// `ISOMETRIC`, `PSEUDOISO` or `WINDOW`.
    pub fn projection(&self, projection: Projection) {
        self.send(Command::Projection(Box::new(projection)));
    }

    /// Sends `VIEWPORT`.
    pub fn viewport(&self, rect: impl Into<Rect>, rule: ViewportRule) {
        self.send(Command::Viewport { rect: rect.into(), rule });
    }

    /// Sends `IDENTITY`.
    pub fn identity(&self) {
        self.send(Command::Identity);
    }

    /// Sends `PUSH`.
    pub fn push(&self) {
        self.send(Command::Push);
    }

    /// Sends `POP`.
    pub fn pop(&self) {
        self.send(Command::Pop);
    }

    /// Sends `TRANSLATE`.
    pub fn translate(&self, by: impl Into<DVec3>) {
        self.send(Command::Translate(by.into()));
    }

    /// Sends `ROTATE`.
    pub fn rotate(&self, axis: impl Into<DVec3>, angle_rad: f64) {
        self.send(Command::Rotate { axis: axis.into(), angle_rad });
    }

    /// Sends `SCALE`.
    pub fn scale(&self, factors: impl Into<DVec3>) {
        self.send(Command::Scale(factors.into()));
    }

    /// Sends `SHEAR` with the factors xy, xz, yx, yz, zx, zy.
    pub fn shear(&self, factors: Shears) {
        self.send(Command::Shear(Box::new(factors)));
    }

    /// Sends `MATRIX`.
    pub fn matrix(&self, matrix: DMat4) {
        self.send(Command::Matrix(Box::new(matrix)));
    }

    /// Sends `AMBIENT`.
    pub fn ambient(&self, color: impl Into<DVec3>) {
        self.send(Command::Ambient(color.into()));
    }

    /// Sends `LIGHT`.
    pub fn light(&self, index: i32, light: LightCommand) {
        self.send(Command::Light { index, light: Box::new(light) });
    }
}

/// Settings of draws.
impl Client {
    /// Sends `MATERIAL`.
    pub fn material(&self, material: Material) {
        self.send(Command::Material(Box::new(material)));
    }

    /// Sends `TEXTURE`: the texture of later draws, `None` for `OFF`.
    pub fn use_texture(&self, name: Option<&str>, sampling: Sampling) {
        self.send(Command::UseTexture { name: name.map(str::to_owned), sampling });
    }

    /// Sends `SHADE`.
    pub fn shade(&self, mode: ShadeMode) {
        self.send(Command::Shade(mode));
    }

    /// Sends `CULL`.
    pub fn cull(&self, cull: Cull) {
        self.send(Command::Cull(cull));
    }

    /// Sends `HIDE`.
    pub fn hide(&self, method: HiddenSurface) {
        self.send(Command::Hide(method));
    }

    /// Sends `DEPTH`.
    pub fn depth_format(&self, format: DepthFormat) {
        self.send(Command::Depth(format));
    }

    /// Sends `INTERP`.
    pub fn interpolation(&self, interpolation: Interpolation) {
        self.send(Command::Interp(interpolation));
    }

    /// Sends `QUALITY`.
    pub fn quality(&self, quality: Quality) {
        self.send(Command::Quality(quality));
    }
}

/// Frames and the connection.
impl Client {
    /// Sends `TITLE`: names the window.
    pub fn title(&self, text: &str) {
        self.send(Command::Title { text: text.to_owned() });
    }

    /// Sends `WAIT`: pauses what this client sends later for 0 to 60 seconds, where there is a
    /// window.
    pub fn pause(&self, seconds: f64) {
        self.send(Command::Wait { seconds });
    }

    /// Sends `AUTO on|off`: selects whether the display follows the memory or shows complete frames
    /// only.
    pub fn auto(&self, on: bool) {
        self.send(Command::Auto(on));
    }

    /// Sends `EVENTS on|off`: selects whether [`Client::events`] receives the window's events.
    pub fn subscribe(&self, on: bool) {
        self.send(Command::Events(on));
    }

    /// Sends `ERRORS`. An in-process client gets its errors from [`Client::sync`] and
    /// [`Client::errors`] in every mode; `close` ends the connection at the first.
    pub fn error_mode(&self, mode: ErrorMode) {
        self.send(Command::Errors(mode));
    }

    /// Sends `QUIT`: ends the connection when all earlier commands have run.
    pub fn quit(self) {
        self.send(Command::Quit);
    }
}

verbs! { client_methods }

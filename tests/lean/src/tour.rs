//! The verbs of the tour on a framebuffer.

use super::TOUR_SIZE;
use fbptr::Framebuffer;
use fbptr::command::{
    Command, Decoder, EndOfInput, Figure, Flow, LightCommand, Limits, MeshSource, Sink, StreamError,
    StreamPosition, binary_pixel,
};
use fbptr::draw2d::Blend;
use fbptr::glam::DMat4;
use fbptr::{Geometry, Light};
use std::collections::HashMap;
use std::sync::Arc;

const COMMANDS: &[u8] = include_bytes!("../../../demos/tour.fbs");

/// A stream of commands on a framebuffer, and the checksums of its frames.
pub struct Tour {
    framebuffer: Framebuffer,
    meshes: HashMap<String, Arc<Geometry>>,
    models: Vec<DMat4>,
    crcs: Vec<u32>,
    /// Set by the first command that is not the tour's, or fails.
    failure: Option<String>,
}

impl Tour {
    /// Draws all frames.
    ///
    /// # Errors
    /// If the tour has a command that is not understood here.
    pub fn play() -> Result<Tour, String> {
        let framebuffer = Framebuffer::new(TOUR_SIZE[0], TOUR_SIZE[1]).map_err(|e| e.to_string())?;
        let (meshes, models) = (HashMap::new(), Vec::new());
        let mut tour = Tour { framebuffer, meshes, models, crcs: Vec::new(), failure: None };
        let mut decoder = Decoder::new(Limits::default());
        if decoder.feed(COMMANDS, &mut tour) == Flow::Continue {
            let _ = decoder.finish(EndOfInput::File, &mut tour);
        }
        match tour.failure.take() {
            Some(failure) => Err(failure),
            None => Ok(tour),
        }
    }

    /// Returns the CRC-32 of each frame.
    pub fn crcs(&self) -> &[u32] {
        &self.crcs
    }

    fn figure(&mut self, figure: Figure) -> Result<(), String> {
        let fb = &mut self.framebuffer;
        let refused = |e: fbptr::draw2d::DrawError| e.to_string();
        match figure {
            Figure::Line { p0, p1, color } => fb.line(p0, p1, color),
            Figure::Triangle { points, colors } => fb.triangle(points, colors),
            Figure::Fill { points, colors } => fb.fill(points, colors),
            Figure::Rect { rect, color } => fb.rect(rect, color).map_err(refused)?,
            Figure::FillRect { rect, color } => fb.fill_rect(rect, color).map_err(refused)?,
            Figure::Circle { cx, cy, r, color } => fb.circle([cx, cy], r, color).map_err(refused)?,
            Figure::FillCircle { cx, cy, r, color } => fb.fill_circle([cx, cy], r, color).map_err(refused)?,
            Figure::Poly { color, points } => fb.poly(&points, color),
            Figure::FillPoly { color, points } => fb.fill_poly(&points, color),
            Figure::Text { x, y, color, utf8 } => fb.text([x, y], &String::from_utf8_lossy(&utf8), color),
            Figure::LineAa { p0, p1, color } => fb.line_aa(p0, p1, color),
            Figure::Print { x, y, color, text } => fb.text([x, y], &text, color),
            Figure::WideLine { p0, p1, width, color } => {
                fb.wide_line(p0, p1, width, color).map_err(refused)?;
            }
            Figure::Ellipse { center, radii, color } => fb.ellipse(center, radii, color).map_err(refused)?,
            Figure::FillEllipse { center, radii, color } => {
                fb.fill_ellipse(center, radii, color).map_err(refused)?;
            }
            Figure::Arc { center, radii, angles, color } => {
                fb.arc(fbptr::draw2d::Arc { center, radii, angles }, color).map_err(refused)?;
            }
            Figure::Bezier { points, width, color } => fb.bezier(points, width, color).map_err(refused)?,
        }
        Ok(())
    }

    /// Runs a command in space; gives back any other.
    fn space(&mut self, command: Command) -> Result<Option<Command>, String> {
        let state = &mut self.framebuffer.state;
        match command {
            Command::LookAt { eye, reference, up } => {
                state.camera.look_at = fbptr::scene::LookAt { eye, reference, up };
            }
            Command::Projection(projection) => state.camera.projection = *projection,
            Command::Material(material) => state.material = *material,
            Command::Shade(shade) => state.shade = shade,
            Command::Ambient(color) => state.ambient = color,
            Command::Light { light, .. } => state.lights.push(self::light(*light)?),
            Command::Push => self.models.push(state.model),
            Command::Pop => state.model = self.models.pop().ok_or("no matrix")?,
            Command::Rotate { axis, angle_rad } => {
                let turn = fbptr::math::matrix::rotate(axis, angle_rad).ok_or("no axis")?;
                state.model *= turn;
            }
            Command::Mesh { name, source } => {
                let MeshSource::Teapot(level) = *source else { return Err("no teapot".into()) };
                let mesh = fbptr::scene::shapes::teapot(level).map_err(|e| e.to_string())?;
                self.meshes.insert(name, mesh.into());
            }
            Command::Free { name } => drop(self.meshes.remove(&name)),
            Command::Draw { name } => {
                let mesh = self.meshes.get(&name).ok_or("no mesh")?;
                let _ = self.framebuffer.draw(mesh).map_err(|e| e.to_string())?;
            }
            other => return Ok(Some(other)),
        }
        Ok(None)
    }

    fn run(&mut self, command: Command) -> Result<(), String> {
        let Some(command) = self.space(command)? else { return Ok(()) };
        match command {
            Command::Figure(figure) => self.figure(figure)?,
            Command::Clear { color } => self.framebuffer.clear(color),
            Command::Poke { offset, bytes } => {
                let offset = u64::try_from(offset).map_err(|e| e.to_string())?;
                self.framebuffer.poke(offset, &bytes).map_err(|e| e.to_string())?;
            }
            Command::Blend { over } => {
                self.framebuffer.set_blend(if over { Blend::Over } else { Blend::Replace });
            }
            Command::Present { .. } => self.crcs.push(self.framebuffer.crc()),
            // The frame has its size, and there is no window.
            Command::SetSize { .. } | Command::Title { .. } | Command::Wait { .. } => {}
            Command::Auto(_) | Command::Crc { .. } => {}
            other => return Err(format!("{} is not the tour's", other.verb())),
        }
        Ok(())
    }
}

fn light(light: LightCommand) -> Result<Light, String> {
    match light {
        LightCommand::Point { position, color, .. } => Ok(Light::point(position, color)),
        LightCommand::Dir { direction, color } => Ok(Light::directional(direction, color)),
        _ => Err("a light that is not the tour's".into()),
    }
}

impl Sink for Tour {
    fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) {
        self.framebuffer.put_pixel(x, y, color);
    }

    fn binary_pixels(&mut self, records: &[u8]) {
        for record in records.as_chunks().0 {
            let (x, y, color) = binary_pixel(record);
            self.framebuffer.put_pixel(x.into(), y.into(), color);
        }
    }

    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        match self.run(command) {
            Ok(()) => Flow::Continue,
            Err(failure) => {
                self.failure = Some(failure);
                Flow::Stop
            }
        }
    }

    fn error(&mut self, error: StreamError) -> Flow {
        self.failure = Some(error.wire_line());
        Flow::Stop
    }
}

//! The lines and faces that a stream or a scene shows on the screen.
//!
//! Figures of two dimensions are taken from the commands as they are written. A scene's triangles
//! are projected by its camera; those with a corner behind the eye are left out, and so is what a
//! stream draws in three dimensions: then the geometry is not complete, and what it does not explain
//! is judged by the pixels alone.

use crate::command::{Command, Decoder, EndOfInput, Figure, Flow, Limits, Sink, StreamError, StreamPosition};
use crate::draw2d::{AreaColors, RampColor};
use crate::measure::difference::Shape;
use crate::memory::Rgba;
use crate::pipeline::SceneOptions;
use crate::scene::{Scene, ShadeMode};
use glam::DVec4;

/// The figures of a stream.
pub struct Figures {
    pub shapes: Vec<Shape>,
    pub is_complete: bool,
    is_blended: bool,
}

impl Figures {
    /// Reads the figures of a stream; commands that are refused have none.
    pub fn of_stream(bytes: &[u8]) -> Figures {
        let mut figures = Figures { shapes: Vec::new(), is_complete: true, is_blended: false };
        let mut decoder = Decoder::new(Limits::default());
        let _ = decoder.feed(bytes, &mut figures);
        let _ = decoder.finish(EndOfInput::File, &mut figures);
        figures
    }

    fn outline(&mut self, points: &[[i32; 2]], color: Rgba) {
        for (i, &from) in points.iter().enumerate() {
            let to = points[(i + 1) % points.len()];
            self.line([from, to], color.into());
        }
    }

    fn line(&mut self, ends: [[i32; 2]; 2], color: RampColor) {
        let colors = Some([color.from, color.to.unwrap_or(color.from)]);
        self.shapes.push(Shape::Line { ends, colors, is_blended: self.is_blended });
    }

    fn face(&mut self, corners: [[f64; 2]; 3], color: Option<Rgba>) {
        self.shapes.push(Shape::Face { corners, color, is_blended: self.is_blended, number: None });
    }

    fn figure(&mut self, figure: Figure) {
        match figure {
            Figure::Line { p0, p1, color } => self.line([p0, p1], color),
            Figure::Triangle { points, colors: AreaColors::One(color) } => self.outline(&points, color),
            Figure::Triangle { points, colors: AreaColors::Three(colors) } => {
                for (i, next) in [(0, 1), (1, 2), (2, 0)] {
                    let color = RampColor { from: colors[i], to: Some(colors[next]) };
                    self.line([points[i], points[next]], color);
                }
            }
            Figure::Poly { color, points } => self.outline(&points, color),
            Figure::Rect { rect: r, color } => {
                let [x1, y1] = [r.x.saturating_add(r.w - 1), r.y.saturating_add(r.h - 1)];
                self.outline(&[[r.x, r.y], [x1, r.y], [x1, y1], [r.x, y1]], color);
            }
            Figure::Circle { cx, cy, r, color } => self.shapes.push(Shape::Circle {
                center: [cx, cy],
                radius: r,
                color,
                is_blended: self.is_blended,
            }),
            Figure::Fill { points, colors } => {
                let color = match colors {
                    AreaColors::One(color) => Some(color),
                    AreaColors::Three([a, b, c]) => (a == b && a == c).then_some(a),
                };
                self.face(points, color);
            }
            Figure::FillRect { rect: r, color } => {
                let [x0, y0, x1, y1] = [r.x, r.y, r.x + r.w, r.y + r.h];
                self.face([[x0, y0], [x1, y0], [x1, y1]], Some(color));
                self.face([[x0, y0], [x1, y1], [x0, y1]], Some(color));
            }
            // Diagonals of the fan lie inside, or outside where nothing is drawn.
            Figure::FillPoly { color, points } => {
                for pair in points.get(1..).unwrap_or_default().windows(2) {
                    self.face([points[0], pair[0], pair[1]], Some(color));
                }
            }
            _ => self.is_complete = false,
        }
    }
}

impl Sink for Figures {
    fn pixel(&mut self, _: i32, _: i32, _: Rgba) {
        self.is_complete = false;
    }

    fn binary_pixels(&mut self, _: &[u8]) {
        self.is_complete = false;
    }

    fn command(&mut self, command: Command, _: StreamPosition) -> Flow {
        match command {
            Command::Figure(figure) => self.figure(figure),
            Command::Blend { over } => self.is_blended = over,
            Command::Clear { .. } => self.shapes.clear(),
            Command::Present { .. } | Command::SetSize { .. } | Command::Title { .. } => {}
            Command::Quit => return Flow::Stop,
            _ => self.is_complete = false,
        }
        Flow::Continue
    }

    fn error(&mut self, _: StreamError) -> Flow {
        Flow::Continue
    }
}

/// Returns a scene's triangles and lines on the screen, and whether they are all that it shows.
pub fn of_scene(scene: &Scene, options: &SceneOptions, [width, height]: [u32; 2]) -> (Vec<Shape>, bool) {
    let camera = scene.camera.unwrap_or(options.camera);
    let [w, h] = [width, height].map(f64::from);
    let Ok(matrices) = camera.matrices(w / h) else { return (Vec::new(), false) };
    let mut shapes = Vec::new();
    let (mut is_complete, mut first) = (true, 0);
    for object in &scene.objects {
        let mesh = &object.geometry.mesh;
        let to_clip = matrices.projection * matrices.view * object.model;
        let screen = |corner: u32| {
            let position = mesh.positions[mesh.corners[corner as usize].position as usize];
            let clip: DVec4 = to_clip * position.extend(1.0);
            let is_seen = clip.w > 0.0 && (0.0..=clip.w).contains(&clip.z);
            is_seen.then(|| [(clip.x / clip.w + 1.0) / 2.0 * w, (1.0 - clip.y / clip.w) / 2.0 * h])
        };
        let is_wire = object.shade.unwrap_or(options.shade) == ShadeMode::Wire;
        let mut line = |ends: [u32; 2]| match ends.map(screen) {
            [Some(a), Some(b)] => shapes.push(Shape::Line {
                // A whole number comes back from the matrices a little smaller.
                ends: [a, b].map(|p| p.map(|v| (v + 1.0 / 512.0).floor() as i32)),
                colors: None,
                is_blended: false,
            }),
            _ => is_complete = false,
        };
        mesh.lines.iter().for_each(|ends| line(*ends));
        if is_wire {
            for polygon in &mesh.polygons {
                let n = polygon.corner_count;
                (0..n).for_each(|i| line([i, (i + 1) % n].map(|i| polygon.first_corner + i)));
            }
        }
        for (number, triangle) in (first..).zip(&mesh.triangles).filter(|_| !is_wire) {
            match triangle.map(screen) {
                [Some(a), Some(b), Some(c)] => shapes.push(Shape::Face {
                    corners: [a, b, c],
                    color: None,
                    is_blended: false,
                    number: Some(number),
                }),
                _ => is_complete = false,
            }
        }
        first += mesh.triangles.len() as u64;
        is_complete &= mesh.points.is_empty();
    }
    (shapes, is_complete && scene.sky.is_none())
}

//! N-dimensional scenes in the viewer: moving and turning in every plane, including hidden axes.
//!
//! A view is a scene with another pose: the shown picture is the one that the JSON of that scene
//! gives, to the bit.

mod edges;
mod false_color;
mod gallery;
mod glow;
#[cfg(test)]
mod tests;

use super::difference::{Difference, Work};
use super::frame::ViewerFrame;
use super::{Wishes, depth_picture};
use false_color::in_false_color;
use fbptr_core::executor::Executor;
use fbptr_core::eye::{self, ContactSheet, EyePicture, EyeScene, Fibre, MISS, Pose};
use gallery::Gallery;
pub(super) use gallery::captions;

/// Angle of one step, in degrees.
const TURN_DEG: f64 = 5.0;

/// Centre of the eye's rotations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum About {
    /// The eye itself: it looks in another direction.
    Eye,
    /// The middle of the facets: the eye moves around them.
    Middle,
}

/// An N-dimensional scene in the viewer.
pub(super) struct Nd {
    /// The author's scene.
    given: EyeScene,
    pose: Pose,
    is_slice: bool,
    fibre: Fibre,
    plane: usize,
    about: About,
    middle: Vec<f64>,
    /// Length of one step, in units of the scene.
    step: f64,
    picture: Option<EyePicture>,
    pool: Executor,
    gallery: Option<Gallery>,
    /// Set if pictures have a pixel of their own for each of the frame's.
    is_fine: bool,
}

impl Nd {
    /// Shows a scene; in the studio, with a gallery if it has a wireframe.
    pub fn new(given: EyeScene, pool: Executor, studio: bool) -> Self {
        let dim = given.dim;
        let bounds = given.bounds();
        let is_empty = given.facets.is_empty();
        let middle = given.middle();
        let size = bounds.iter().map(|&(l, h)| h - l).fold(0.0, f64::max);
        let holds_eye = bounds.iter().zip(&given.pose.position).all(|(&(l, h), x)| (l..=h).contains(x));
        let gallery = studio.then(|| Gallery::of(&given, &middle)).flatten();
        Nd {
            gallery,
            is_fine: studio && given.screen_dim() == 2,
            pose: given.pose.clone(),
            is_slice: false,
            fibre: Fibre::Exact,
            // The plane of the forward and the first hidden axis; without a hidden axis, of forward
            // and the last axis.
            plane: Pose::planes(dim)
                .iter()
                .position(|p| *p == [0, (given.screen_dim() + 1).min(dim - 1)])
                .unwrap_or(0),
            about: if holds_eye || is_empty { About::Eye } else { About::Middle },
            middle,
            step: round_step(size / 20.0),
            picture: None,
            pool,
            given,
        }
    }

    /// Returns the scene as currently viewed.
    pub fn scene(&self) -> EyeScene {
        let mut parts = self.given.clone().into_parts();
        parts.pose = self.pose.clone();
        if self.is_slice {
            parts.aperture_tan.fill(0.0);
        }
        // `set_pose` accepts only poses in range, so this does not fail.
        EyeScene::new(parts).unwrap_or_else(|_| self.given.clone())
    }

    /// Returns the scene as currently viewed, as it is drawn on a frame of `size`: in the studio with
    /// as many pixels as the frame has.
    fn scene_on(&self, size: [u32; 2]) -> EyeScene {
        let scene = self.scene();
        if !self.is_fine {
            return scene;
        }
        let mut parts = scene.clone().into_parts();
        parts.pixels = size.to_vec();
        EyeScene::new(parts).unwrap_or(scene)
    }

    /// Returns a frame size for the scene's screen: an integer multiple of it, near `usual`.
    pub fn frame_size(scene: &EyeScene, usual: [u32; 2]) -> [u32; 2] {
        let [w, h] = ContactSheet::of(&scene.pixels).picture_size();
        let scale = (usual[0] / w.max(1)).min(usual[1] / h.max(1)).max(1);
        match scene.screen_dim() {
            1 => [w * (usual[0] / w.max(1)).max(1), usual[1] / 2],
            _ => [w * scale, h * scale],
        }
    }

    /// Takes over another scene's pose and settings, if the dimensions are equal.
    pub fn take_place_of(&mut self, old: &Nd) {
        if (old.given.dim, old.given.screen_dim()) == (self.given.dim, self.given.screen_dim()) {
            (self.plane, self.about) = (old.plane, old.about);
            (self.is_slice, self.fibre) = (old.is_slice, old.fibre);
            // An eye that was never moved takes the new file's own pose.
            if old.pose != old.given.pose {
                self.pose = old.pose.clone();
            }
        }
    }

    /// Returns whether the scene has a gallery of wireframe, slice and shadow.
    pub fn has_gallery(&self) -> bool {
        self.gallery.is_some()
    }

    /// Returns to the author's pose.
    pub fn reset(&mut self) {
        self.pose = self.given.pose.clone();
    }

    /// Moves along one of the eye's own axes.
    pub fn walk(&mut self, axis: usize, steps: f64) {
        if axis < self.given.dim {
            let mut pose = self.pose.clone();
            pose.advance(axis, steps * self.step);
            self.set_pose(pose);
        }
    }

    /// Turns from axis `a` towards axis `b`, by a number of steps.
    pub fn turn(&mut self, a: usize, b: usize, steps: f64) {
        self.turn_by(a, b, steps * TURN_DEG);
    }

    /// Turns from axis `a` towards axis `b`, by an angle in degrees.
    pub fn turn_by(&mut self, a: usize, b: usize, angle_deg: f64) {
        if a == b || a.max(b) >= self.given.dim || !angle_deg.is_finite() {
            return;
        }
        let mut pose = self.pose.clone();
        match self.about {
            About::Eye => pose.turn(a, b, angle_deg),
            About::Middle => pose.turn_about(&self.middle, a, b, angle_deg),
        }
        self.set_pose(pose);
    }

    /// Sets the pose if its coordinates are finite and below 1e150.
    fn set_pose(&mut self, pose: Pose) {
        if pose.position.iter().all(|x| x.is_finite() && x.abs() < 1e150) {
            self.pose = pose;
        }
    }

    /// Returns the selected plane of rotation, as its two axes.
    pub fn plane(&self) -> [usize; 2] {
        Pose::planes(self.given.dim)[self.plane]
    }

    /// Selects the plane of rotation that is `by` further in the list of all planes.
    pub fn next_plane(&mut self, by: i32) {
        let count = Pose::planes(self.given.dim).len();
        self.plane = (self.plane as i64 + i64::from(by)).rem_euclid(count as i64) as usize;
    }

    /// Turns in the selected plane by a number of steps.
    pub fn turn_plane(&mut self, steps: f64) {
        let [a, b] = self.plane();
        self.turn(a, b, steps);
    }

    /// Switches the centre of rotation between the eye and the middle of the facets, and returns its
    /// name.
    pub fn turn_about_other(&mut self) -> &'static str {
        self.about = match self.about {
            About::Eye => About::Middle,
            About::Middle => About::Eye,
        };
        self.about_name()
    }

    fn about_name(&self) -> &'static str {
        if self.about == About::Eye { "the eye" } else { "the middle" }
    }

    /// Switches between the aperture as given and the exact slice. Returns whether there is a
    /// hidden axis at all.
    pub fn toggle_slice(&mut self) -> bool {
        self.is_slice = !self.is_slice && self.has_hidden_axis();
        self.has_hidden_axis()
    }

    /// Returns whether any axis of space is not one of the screen's; slices and fibres need one.
    pub fn has_hidden_axis(&self) -> bool {
        self.given.hidden_dim() > 0
    }

    /// Cycles through exact fibres and fans of 3 and of 9 rays for each hidden axis. Returns
    /// whether there is a hidden axis at all.
    pub fn next_fibre(&mut self) -> bool {
        self.fibre = match self.fibre {
            _ if !self.has_hidden_axis() => Fibre::Exact,
            Fibre::Exact => Fibre::Fan(3),
            Fibre::Fan(3) => Fibre::Fan(9),
            Fibre::Fan(_) => Fibre::Exact,
        };
        self.has_hidden_axis()
    }

    /// Returns the status lines: dimensions, search method, aperture, position, plane of rotation.
    pub fn status(&self) -> Vec<String> {
        let [a, b] = self.plane();
        let about = self.about_name();
        let fibre = match self.fibre {
            Fibre::Exact => "exact fibres".to_owned(),
            Fibre::Fan(rays) => format!("fan of {rays}"),
        };
        let aperture = match (self.given.hidden_dim(), self.is_slice) {
            (0, _) => "",
            (_, true) => " | slice",
            (_, false) => " | aperture as given",
        };
        let at: Vec<String> = self.pose.position.iter().map(|x| format!("{x:.3}")).collect();
        vec![
            format!(
                "{}-D on {}-D | {fibre}{aperture} | eye {}",
                self.given.dim,
                self.given.screen_dim(),
                at.join(" ")
            ),
            format!("plane {a}-{b} ({} to {}) | about {about}", self.axis_name(a), self.axis_name(b)),
        ]
    }

    fn axis_name(&self, axis: usize) -> String {
        let m = self.given.screen_dim();
        match axis {
            0 => "ahead".to_owned(),
            1 if m >= 1 => "left".to_owned(),
            2 if m >= 2 => "up".to_owned(),
            _ if axis <= m => format!("screen {axis}"),
            _ => format!("hidden {axis}"),
        }
    }

    /// Renders the scene and draws it in the colours of the shading style.
    pub fn draw(&mut self, wishes: &Wishes, frame: &mut ViewerFrame) -> Result<(), String> {
        if wishes.shows_gallery
            && let Some(mut gallery) = self.gallery.take()
        {
            let drawn = gallery.draw(self, &mut frame.memory);
            self.gallery = Some(gallery);
            if drawn? {
                return Ok(());
            }
        }
        let scene = self.scene_on([frame.memory.width(), frame.memory.height()]);
        let picture = eye::render_with(&scene, self.fibre, &self.pool).map_err(|e| e.to_string())?;
        frame.clear(false);
        paint(&in_false_color(&picture, &scene, wishes.look), frame);
        self.picture = Some(picture);
        Ok(())
    }

    /// Paints distances as greys. Returns the least and the largest, if any.
    pub fn paint_distances(&self, memory: &mut fbptr_core::memory::VideoMemory) -> Option<[f64; 2]> {
        let picture = self.picture.as_ref()?;
        let values = (0..memory.height())
            .flat_map(|y| (0..memory.width()).map(move |x| (x, y)))
            .map(|(x, y)| {
                let i = pixel_at(picture, memory.width(), memory.height(), x, y)?;
                (picture.facet[i] != MISS).then_some(picture.dist[i])
            })
            .collect::<Vec<_>>();
        depth_picture::paint(memory, &values)
    }

    /// Returns the plan of rendering the scene as lines of text.
    pub fn plan(&self) -> Vec<String> {
        match eye::plan(&self.scene(), self.fibre) {
            Ok(plan) => plan.to_string().lines().flat_map(folded).collect(),
            Err(e) => vec![e.to_string()],
        }
    }

    /// Returns facet, distance and lights at a pixel of the frame, as lines of text.
    pub fn inspect(&self, frame: &ViewerFrame, x: u32, y: u32) -> Vec<String> {
        let Some(picture) = &self.picture else { return Vec::new() };
        let Some(i) = pixel_at(picture, frame.memory.width(), frame.memory.height(), x, y) else {
            return vec!["no layer".to_owned()];
        };
        if picture.facet[i] == MISS {
            return vec![format!("pixel {i}: no facet")];
        }
        let lit: String = picture.flags(i).iter().map(|&l| if l { '1' } else { '0' }).collect();
        vec![
            format!("pixel {i}: facet {}", picture.facet[i]),
            format!("distance {:.6}", picture.dist[i]),
            format!("lit {}", if lit.is_empty() { "by none" } else { &lit }),
        ]
    }

    /// Returns the work that computes the difference to the picture of exact fibres.
    pub fn exact(&self, wishes: &Wishes, frame: &ViewerFrame) -> Work {
        let size = [frame.memory.width(), frame.memory.height()];
        let (scene, look, pool) = (self.scene_on(size), wishes.look, self.pool.clone());
        let found = frame.memory.bytes().to_vec();
        Box::new(move || {
            let picture = eye::render_with(&scene, Fibre::Exact, &pool).map_err(|e| e.to_string())?;
            let mut exact = ViewerFrame::new(size).map_err(|e| e.to_string())?;
            paint(&in_false_color(&picture, &scene, look), &mut exact);
            Ok(Difference::of_bytes(&found, exact.memory.bytes()))
        })
    }
}

fn paint(picture: &EyePicture, frame: &mut ViewerFrame) {
    let (w, h) = (frame.memory.width() as i32, frame.memory.height() as i32);
    eye::blit(picture, &mut frame.memory, 0, 0, w, h);
}

/// Returns the flat index of the screen's pixel that a pixel of the frame shows.
fn pixel_at(picture: &EyePicture, width: u32, height: u32, x: u32, y: u32) -> Option<usize> {
    let sheet = ContactSheet::of(&picture.pixels);
    let [w, h] = sheet.size();
    sheet.pixel(eye::nearest(x, width, w), eye::nearest(y, height, h), picture.facet.len())
}

/// Folds a line of a plan after commas, to fit a usual window.
fn folded(line: &str) -> Vec<String> {
    const WIDTH: usize = 74;
    let mut lines = vec![String::new()];
    for part in line.split_inclusive(", ") {
        match lines.last_mut() {
            Some(last) if last.is_empty() || last.len() + part.trim_end().len() <= WIDTH => {
                last.push_str(part)
            }
            _ => lines.push(format!("           {part}")),
        }
    }
    lines.iter().map(|l| l.trim_end().to_owned()).collect()
}

/// Rounds to 1, 2 or 5 times a power of ten, so that steps are easy to read.
fn round_step(length: f64) -> f64 {
    if !(length > 0.0 && length.is_finite()) {
        return 0.1;
    }
    let mut unit = 1.0;
    while unit > length {
        unit /= 10.0;
    }
    while unit * 10.0 <= length {
        unit *= 10.0;
    }
    match length / unit {
        x if x < 1.5 => unit,
        x if x < 3.5 => 2.0 * unit,
        x if x < 7.5 => 5.0 * unit,
        _ => 10.0 * unit,
    }
}

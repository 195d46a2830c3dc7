//! Three-dimensional scenes in the viewer: meshes, and X3D and glTF documents that change over time.

use super::Wishes;
use super::difference::{Difference, Work};
use super::frame::ViewerFrame;
use super::keys::Look;
use super::studio::{self, Backdrop, Ground};
use fbptr_core::executor::Executor;
use fbptr_core::memory::DepthFormat;
use fbptr_core::pipeline::{DepthUse, DrawStats, Part, Renderer, SceneOptions};
use fbptr_core::scene::{
    self, Camera, Geometry, Sampling, Scene, ShadeMode, Texture, TextureUse, TransparencyOrder,
    ViewOverrides, viewers_light,
};
use fbptr_formats::load::gltf::GltfDocument;
use fbptr_formats::load::x3d::X3dDocument;
use fbptr_truth::{self as truth, Transparency};
use glam::DVec3;
use std::sync::Arc;

/// Source of a scene's objects.
pub(super) enum SceneSource {
    Mesh { geometry: Arc<Geometry>, is_open: bool },
    X3d(Box<X3dDocument>),
    Gltf(Box<GltfDocument>),
}

/// A three-dimensional scene in the viewer.
pub(super) struct Space {
    source: SceneSource,
    name: String,
    /// Width and height of the frame in pixels, and their ratio.
    size: [u32; 2],
    aspect: f64,
    /// The author's scene, and the bits of the time it was evaluated at.
    given: Option<(u64, Scene)>,
    /// The mesh without its textures, once it was needed.
    bare: Option<Arc<Geometry>>,
    checker: Option<Arc<Texture>>,
    /// Names of the objects drawn last.
    names: Vec<String>,
    stats: DrawStats,
    /// True if the contents stand in the studio.
    studio: bool,
    /// True if the camera leaves room for the model to turn.
    has_room: bool,
    backdrop: Backdrop,
    /// The ground under a model, once it was needed; `None` inside for a model without extent.
    ground: Option<Option<Ground>>,
}

/// Changes of a scene's camera in one picture.
#[derive(Clone, Copy, Default)]
pub(super) struct Pass {
    /// Pixels by which the picture is moved, right and down.
    pub shift: Option<[f64; 2]>,
    /// Part of its distance at which the near plane stands.
    pub near_part: Option<f64>,
}

/// The renderer and memories that a scene is drawn with.
pub(super) struct Tools<'a> {
    pub renderer: &'a mut Renderer,
    pub pool: &'a Executor,
}

impl Space {
    pub fn new(source: SceneSource, name: &str, size: [u32; 2], studio: bool) -> Self {
        Space {
            source,
            name: name.to_owned(),
            size,
            aspect: f64::from(size[0]) / f64::from(size[1]),
            given: None,
            bare: None,
            checker: None,
            names: Vec::new(),
            stats: DrawStats::default(),
            studio,
            has_room: false,
            backdrop: Backdrop::default(),
            ground: None,
        }
    }

    /// Frames the model with room to turn, or as it stands.
    pub fn leave_room_to_turn(&mut self, has_room: bool) {
        if self.has_room != has_room {
            self.has_room = has_room;
            self.given = None;
        }
    }

    /// Returns whether the camera leaves room for the model to turn.
    pub fn has_room_to_turn(&self) -> bool {
        self.has_room
    }

    /// Returns whether the studio has a ground for the contents: under meshes and glTF models, but
    /// not in scenes whose author has placed a camera.
    pub fn has_ground(&self) -> bool {
        self.studio
            && match &self.source {
                SceneSource::Mesh { .. } => true,
                SceneSource::Gltf(document) => !document.has_camera(),
                SceneSource::X3d(_) => false,
            }
    }

    /// Returns the ground under the model; a moving one stands on it at the scene's start.
    fn new_ground(&self) -> Option<Ground> {
        match &self.source {
            SceneSource::Mesh { geometry, .. } => Ground::under(&geometry.mesh),
            SceneSource::Gltf(document) => Ground::under(&studio::world_mesh(&document.at(0.0, self.aspect))),
            SceneSource::X3d(_) => None,
        }
    }

    pub fn is_animated(&self) -> bool {
        match &self.source {
            SceneSource::Mesh { .. } => false,
            SceneSource::X3d(document) => document.is_animated(),
            SceneSource::Gltf(document) => document.is_animated(),
        }
    }

    /// Returns the author's scene at `time`. A scene without a viewpoint is framed automatically.
    pub fn given(&mut self, time: f64) -> &Scene {
        let time = if self.is_animated() { time } else { 0.0 };
        if self.given.as_ref().is_none_or(|(bits, _)| *bits != time.to_bits()) {
            let mut scene = match &self.source {
                SceneSource::Mesh { geometry, is_open } => {
                    let mut scene = Scene::of_mesh(Arc::clone(geometry), &self.name, self.aspect, *is_open);
                    if self.studio {
                        let camera =
                            studio::framed_mesh(&geometry.mesh, self.aspect, *is_open, self.has_room);
                        scene.camera = Some(camera);
                        studio::light(&mut scene, &camera);
                        scene.objects.iter_mut().for_each(|o| o.material = studio::material());
                    }
                    scene
                }
                SceneSource::Gltf(document) => {
                    let mut scene = document.at(time, self.aspect);
                    if self.studio && !document.has_camera() {
                        let start = document.at(0.0, self.aspect);
                        let own = studio::framed_scene(&start, self.aspect, self.has_room);
                        scene.camera = own.or(scene.camera);
                    }
                    if let (true, false, Some(camera)) = (self.studio, document.has_lights(), scene.camera) {
                        studio::light(&mut scene, &camera);
                    }
                    scene
                }
                SceneSource::X3d(document) => {
                    let mut scene = document.at_size(time, self.size);
                    if let (false, Some(bounds)) = (document.has_viewpoint(), scene.bounds()) {
                        let own =
                            self.studio.then(|| studio::framed_scene(&scene, self.aspect, self.has_room));
                        let frame = own.flatten().unwrap_or_else(|| scene::frame(bounds, self.aspect));
                        if document.depends_on_viewer() {
                            scene = document.seen_at(time, Some(&frame));
                        }
                        scene.look_through(frame);
                    }
                    scene
                }
            };
            if self.studio {
                studio::enlarge_points(&mut scene, self.size);
            }
            self.given = Some((time.to_bits(), scene));
        }
        // Set above.
        &self.given.as_ref().expect("a scene").1
    }

    /// Returns the author's camera at `time`.
    pub fn given_camera(&mut self, time: f64) -> Camera {
        self.given(time).camera.unwrap_or_default()
    }

    /// Returns whether any object has a texture, and whether any has texture coordinates.
    pub fn textures(&mut self, time: f64) -> (bool, bool) {
        let objects = &self.given(time).objects;
        let has =
            objects.iter().any(|o| o.texture.is_some() || o.geometry.textures.iter().any(Option::is_some));
        (has, objects.iter().any(|o| !o.geometry.mesh.texcoords.is_empty()))
    }

    /// Returns the order of transparent faces: glTF files have none that counts.
    fn transparency(&self) -> TransparencyOrder {
        match &self.source {
            SceneSource::Gltf(_) => TransparencyOrder::Sorted,
            SceneSource::Mesh { .. } | SceneSource::X3d(_) => TransparencyOrder::default(),
        }
    }

    /// Returns the scene with the viewer's overrides applied.
    fn seen(&mut self, wishes: &Wishes) -> Scene {
        let mut scene = self.given(wishes.time).clone();
        let mut view_overrides = wishes.view_overrides();
        if wishes.turned_rad != 0.0 {
            let given = scene.camera.unwrap_or_default();
            view_overrides.navigator.orbit(&given, DVec3::Y, wishes.turned_rad, 0.0);
        }
        if view_overrides.textures == TextureUse::Off
            && let SceneSource::Mesh { geometry, .. } = &self.source
        {
            let bare = self.bare.get_or_insert_with(|| Arc::new(geometry.without_textures()));
            scene.objects.iter_mut().for_each(|o| o.geometry = Arc::clone(bare));
        }
        if wishes.look == Look::Textured && self.textures(wishes.time) == (false, true) {
            let checker = self.checker.get_or_insert_with(|| Arc::new(checker()));
            for object in scene.objects.iter_mut().filter(|o| !o.geometry.mesh.texcoords.is_empty()) {
                object.texture = Some((Arc::clone(checker), Sampling::default()));
            }
        }
        view_overrides.apply(&mut scene, Camera::default(), self.aspect);
        if let (SceneSource::X3d(document), Some(camera), false) =
            (&self.source, scene.camera, view_overrides.navigator.is_home())
            && document.depends_on_viewer()
        {
            let time = if document.is_animated() { wishes.time } else { 0.0 };
            let mut turned = document.seen_at(time, Some(&camera));
            turned.look_through(camera);
            let view_overrides = ViewOverrides { navigator: Default::default(), ..view_overrides };
            view_overrides.apply(&mut turned, camera, self.aspect);
            return turned;
        }
        let has_lights = match &self.source {
            SceneSource::Mesh { .. } => false,
            SceneSource::X3d(_) => true,
            SceneSource::Gltf(document) => document.has_lights(),
        };
        if let (false, Some(camera), false) = (has_lights, scene.camera, view_overrides.navigator.is_home()) {
            // A file without lights of its own is lit by the viewer.
            match self.studio {
                true => studio::light(&mut scene, &camera),
                false => scene.lights = vec![viewers_light(&camera)],
            }
        }
        scene
    }

    /// Returns the viewer's camera.
    pub fn camera(&mut self, wishes: &Wishes) -> Camera {
        self.seen(wishes).camera.unwrap_or_default()
    }

    fn options(&self, wishes: &Wishes, frame: &ViewerFrame) -> SceneOptions {
        let ViewOverrides { hide, shade, .. } = wishes.view_overrides();
        let usual = if wishes.studio { ShadeMode::Phong } else { ShadeMode::default() };
        SceneOptions {
            shade: shade.unwrap_or(usual),
            hide: hide.unwrap_or_default(),
            depth_use: if wishes.keeps_depth { DepthUse::Keep } else { DepthUse::SceneOnly },
            transparency: self.transparency(),
            ..SceneOptions::new(frame.memory.width(), frame.memory.height())
        }
    }

    /// Draws the scene with the viewer's overrides applied.
    pub fn draw(
        &mut self,
        wishes: &Wishes,
        frame: &mut ViewerFrame,
        tools: Tools<'_>,
        pass: Pass,
    ) -> Result<(), String> {
        let mut scene = self.seen(wishes);
        if let Some(camera) = &mut scene.camera {
            if let Some(part) = pass.near_part {
                let [near, _] = camera.projection.near_far_mut();
                *near *= part;
            }
            if let Some(shift) = pass.shift {
                *camera = studio::shifted(*camera, shift, [frame.memory.width(), frame.memory.height()]);
            }
        }
        let options = self.options(wishes, frame);
        frame.clear(wishes.keeps_depth);
        if wishes.studio && !wishes.is_bare {
            self.paint_behind(wishes, &mut scene, frame, tools.pool);
        }
        let drawn = tools.renderer.draw_scene(&mut frame.target(), &scene, &options);
        self.names = scene.objects.into_iter().map(|o| o.name).collect();
        self.stats = drawn.map_err(|e| e.to_string())?;
        Ok(())
    }

    /// Paints the studio behind a scene: the gradient where the author left the background black,
    /// and the ground.
    fn paint_behind(&mut self, wishes: &Wishes, scene: &mut Scene, frame: &mut ViewerFrame, pool: &Executor) {
        if scene.sky.is_some() || scene.background.color.is_some_and(|c| c != DVec3::ZERO) {
            return;
        }
        scene.background.color = None;
        self.backdrop.paint(&mut frame.memory);
        let (true, Some(camera), false) = (self.has_ground(), &scene.camera, wishes.hides_ground) else {
            return;
        };
        if self.ground.is_none() {
            self.ground = Some(self.new_ground());
        }
        if let Some(Some(ground)) = &self.ground {
            ground.paint(&mut frame.memory, camera, pool);
        }
    }

    /// Returns the plan of drawing as lines of text: what is used, what is left out, and the counts
    /// of the last drawing.
    pub fn plan(&mut self, wishes: &Wishes, frame: &mut ViewerFrame, renderer: &Renderer) -> Vec<String> {
        let scene = self.seen(wishes);
        let options = self.options(wishes, frame);
        let plan = renderer.plan_scene(&frame.target(), &scene, &options);
        let mut lines = vec![format!("plan: {}, {} bytes", plan.title, plan.bytes())];
        for item in plan.items().iter().filter(|i| i.used) {
            let (name, unit) = item.part.as_str();
            let bytes = if item.bytes > 0 { format!(", {} bytes", item.bytes) } else { String::new() };
            lines.push(format!("+ {name:<20}{} {unit}{bytes}", item.count));
        }
        let absent: Vec<&str> =
            Part::ALL.into_iter().filter(|&p| !plan.uses(p)).map(|p| p.as_str().0).collect();
        lines.extend(wrapped("- ", &absent, 60));
        let s = &self.stats;
        lines.push(format!(
            "faces {}: {} culled, {} outside, {} empty, {} drawn",
            s.faces, s.faces_culled, s.faces_outside, s.faces_empty, s.faces_drawn
        ));
        lines.push(format!(
            "pixels {} tested, {} lit, {} written",
            s.pixels_tested, s.pixels_lit, s.pixels_written
        ));
        lines
    }

    /// Returns the depth and the face at a pixel, as lines of text.
    pub fn inspect(&self, frame: &ViewerFrame, x: i32, y: i32) -> Vec<String> {
        let z = frame.depth.as_ref().and_then(|d| d.z(x, y));
        let hit = frame.ids.as_ref().and_then(|ids| ids.get(x, y));
        let name = hit.and_then(|(name, triangle)| Some((self.names.get(name as usize)?, triangle)));
        vec![
            z.map_or_else(|| "no depth".to_owned(), |z| format!("depth {z:.9}")),
            name.map_or_else(|| "no face".to_owned(), |(name, triangle)| format!("{name} face {triangle}")),
        ]
    }

    /// Returns the work that computes the difference to the exact picture.
    pub fn exact(&mut self, wishes: &Wishes, frame: &ViewerFrame) -> Work {
        let scene = self.seen(wishes);
        let view_overrides = wishes.view_overrides();
        let settings = truth::Settings {
            shade: self.options(wishes, frame).shade,
            hide: view_overrides.hide.unwrap_or_default(),
            transparency: Transparency::AfterOpaque(self.transparency()),
            ..truth::Settings::default()
        };
        let (width, height) = (frame.memory.width(), frame.memory.height());
        let found = frame.memory.bytes().to_vec();
        Box::new(move || {
            let exact = truth::render(&scene, width, height, DepthFormat::default(), &settings)
                .map_err(|e| e.to_string())?;
            Ok(Difference::new(&found, |i| {
                let [x, y] = [i as u32 % width, i as u32 / width];
                let pixel = &found[i * 4..i * 4 + 3];
                let is_right =
                    |s: &&truth::PixelState| (0..3).all(|c| (s.lo[c]..=s.hi[c]).contains(&pixel[c]));
                let states = exact.states(x, y);
                if exact.is_free(x, y) {
                    return [[0; 3], [255; 3]];
                }
                let state = states.iter().find(is_right).or(states.first());
                state.map_or([[0; 3], [255; 3]], |s| [s.lo, s.hi])
            }))
        })
    }
}

/// Creates the texture for meshes that have coordinates but no texture: eight by eight squares, red
/// to the right, green up.
fn checker() -> Texture {
    const SIDE: u32 = 128;
    let texel = |x: u32, y: u32| {
        let is_light = (x / 16 + y / 16).is_multiple_of(2);
        let [r, g] = [x, SIDE - 1 - y].map(|v| (v * 2) as u8);
        if is_light { [255, 255, 255, 255] } else { [r, g, 128, 255] }
    };
    let bytes = (0..SIDE * SIDE).flat_map(|i| texel(i % SIDE, i / SIDE)).collect();
    Texture::new(SIDE, SIDE, bytes).expect("a size and its bytes")
}

/// Joins words into lines of at most `width` characters, each line after `mark`.
pub(super) fn wrapped(mark: &str, words: &[&str], width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in words {
        match lines.last_mut() {
            Some(line) if line.len() + 2 + word.len() <= width => {
                line.push_str(", ");
                line.push_str(word);
            }
            _ => lines.push(format!("{mark}{word}")),
        }
    }
    lines
}

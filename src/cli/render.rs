//! `fbptr render`: a scene file to a picture, or to the pictures of its animation.

use super::args::color::color;
use super::mesh_args::MeshArgs;
use super::progress::Progress;
use super::render_args::RenderArgs;
use super::scene_file::{self, ReadOptions, SceneError, SceneFile};
use super::trace::{self, TraceAt};
use super::{FrameSize, Status, output, say_as_program};
use crate::eye::{self, EyeScene};
use crate::memory::{DepthFormat, DepthMemory, Rgba, VideoMemory};
use crate::pipeline::quality::{Budget, BudgetKind, choose};
use crate::pipeline::{DepthUse, Renderer, SceneOptions, Target};
use crate::save::{self, Movie, MovieFormat, SaveError};
use crate::scene::{FRAME_FOV_RAD, Scene, ShadeMode, TransparencyOrder, frame_along};
use crate::server::Limits;
use clap::Args;
use glam::{DMat4, DVec3, DVec4};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Render a scene file.
#[derive(Debug, Args)]
pub struct Render {
    /// The scene: .gltf, .glb, .x3d, .x3dz, .obj, .stl, .ply, or .json for N dimensions
    #[arg(value_name = "SCENE")]
    scene: PathBuf,
    /// The picture: .png, .ppm or .raw; with --frames a movie too: .gif, .apng, .y4m, or - for y4m on standard output
    #[arg(short, long, value_name = "OUT", required_unless_present = "trace")]
    out: Option<PathBuf>,
    /// The picture's size [default: 640x480, or an N-dimensional screen's own]
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// The colour behind scenes that have no background of their own, in hex or by its CSS name
    #[arg(long, value_name = "COLOUR", value_parser = color, default_value = "black")]
    background: Rgba,
    /// Let the scene read files from this folder, not only from its own
    #[arg(long, value_name = "DIR")]
    root: Option<PathBuf>,
    /// How faces get their colours: wire, flat, gouraud or phong
    #[arg(long, value_name = "S", value_parser = shade)]
    shade: Option<ShadeMode>,
    /// Distance to the near plane
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    near: Option<f64>,
    /// Distance to the far plane
    #[arg(long, value_name = "F", value_parser = positive, allow_negative_numbers = true)]
    far: Option<f64>,
    /// Write the depth too
    #[arg(long, value_name = "OUT.pfm")]
    depth_out: Option<PathBuf>,
    /// Draw the cheapest way whose 99.9th percentile of colour error is at most E steps of 255
    #[arg(long, value_name = "E", value_parser = not_negative, allow_negative_numbers = true)]
    max_error: Option<f64>,
    /// Print what the scene needs, and why
    #[arg(long)]
    explain: bool,
    /// Print every number that a triangle (N), a pixel (X,Y) or a triangle at a pixel (N@X,Y) has on its way
    #[arg(long, value_name = "N|X,Y|N@X,Y")]
    trace: Option<TraceAt>,
    /// Seconds since the scene's start
    #[arg(long, value_name = "T", value_parser = finite, default_value = "0", allow_negative_numbers = true)]
    time: f64,
    /// How many pictures, one turn of a scene without an animation; but in a movie, their names have a number before the ending
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Pictures a second
    #[arg(long, value_name = "F", value_parser = positive, default_value = "25", allow_negative_numbers = true)]
    fps: f64,
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

fn shade(text: &str) -> Result<ShadeMode, String> {
    ShadeMode::from_keyword(text).ok_or_else(|| "expected wire, flat, gouraud or phong".to_owned())
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|n: &f64| n.is_finite()).ok_or_else(|| "expected a finite number".to_owned())
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|n| *n > 0.0).ok_or_else(|| "expected a finite number above 0".to_owned())
}

fn not_negative(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|n| *n >= 0.0).ok_or_else(|| "expected a finite number of 0 or more".to_owned())
}

impl Render {
    /// Renders all pictures, and returns the exit status.
    pub(super) fn run(self) -> Status {
        match self.render() {
            Ok(()) => Status::Success,
            Err(error) => error.say(),
        }
    }

    fn render(&self) -> Result<(), SceneError> {
        let bad = |message: String| SceneError::NoFile(message);
        if let Some(out) = self.out.as_ref().filter(|out| !is_movie(out)) {
            let error = |_| SaveError::UnknownEnding { path: out.clone(), expected: ENDINGS };
            save::SnapshotFormat::of_path(out).map_err(|e| bad(error(e).to_string()))?;
        }
        if let Some(path) = &self.depth_out {
            save::check_depth_path(path).map_err(|e| bad(e.to_string()))?;
        }
        if self.out.as_deref() == Some(Path::new("-")) && (self.explain || self.trace.is_some()) {
            return Err(bad(
                "-o -: standard output is the movie's, and --explain and --trace print there".to_owned()
            ));
        }
        if let (Some(near), Some(far)) = (self.near, self.far)
            && near >= far
        {
            return Err(bad(format!("--near {near} must be less than --far {far}")));
        }
        let size = self.size.unwrap_or(FrameSize::DEFAULT);
        Limits::default().check_frame(size.width, size.height).map_err(|e| bad(e.message))?;
        let file =
            scene_file::read(&self.scene, ReadOptions { root: self.root.as_deref(), meshes: &self.meshes })?;
        if let SceneFile::Eye(scene) = file {
            if self.trace.is_some() {
                return Err(bad("--trace follows triangles of scenes in three dimensions".to_owned()));
            }
            let flags = [
                ("--near", self.near.is_some()),
                ("--far", self.far.is_some()),
                ("--shade", self.shade.is_some()),
                ("--cull", self.meshes.cull.is_some()),
            ];
            if let Some((flag, _)) = flags.iter().find(|(_, is_given)| *is_given) {
                let scene = self.scene.display();
                return Err(bad(format!(
                    "{flag} is for scenes in three dimensions: {scene} is an N-dimensional one"
                )));
            }
            return self.render_eye(&scene);
        }
        let mut plans = String::new();
        let mut renderer = self.drawing.renderer();
        let mut output = self.output([size.width, size.height])?;
        let frames = self.frames.unwrap_or(1);
        let transparency = transparency(&file);
        let is_turntable = frames > 1 && !is_animated(&file);
        if is_turntable {
            let scene = self.scene.display();
            say_as_program(format_args!("{scene} has no animation: the {frames} frames are one turn"));
        }
        for i in 0..frames {
            if output.has_hung_up {
                break;
            }
            let time = self.time + f64::from(i) / self.fps;
            let mut scene = self.scene_at(&file, time, size);
            self.meshes.apply_cull(&mut scene);
            if is_turntable {
                let has_camera = match &file {
                    SceneFile::X3d(document) => document.has_viewpoint(),
                    SceneFile::Gltf(document) => document.has_camera(),
                    SceneFile::Mesh { .. } | SceneFile::Eye(_) => false,
                };
                turn(&mut scene, f64::from(i) / f64::from(frames), (!has_camera).then_some(size));
            }
            self.set_planes(&mut scene)?;
            let plan = self.draw(&mut renderer, &scene, transparency, &mut output)?;
            if !plans.ends_with(&plan) {
                plans.push_str(&plan);
            }
        }
        if self.explain {
            output::print(plans);
        }
        Ok(())
    }

    /// Returns the scene at a time; a mesh is framed for pictures of `size`.
    fn scene_at(&self, file: &SceneFile, time: f64, size: FrameSize) -> Scene {
        let aspect = f64::from(size.width) / f64::from(size.height);
        match file {
            SceneFile::X3d(document) => document.at(time),
            SceneFile::Gltf(document) => document.at(time, aspect),
            SceneFile::Mesh { geometry, is_open } => {
                let name = self.scene.file_stem().map(|n| n.to_string_lossy()).unwrap_or_default();
                Scene::of_mesh(Arc::clone(geometry), &name, aspect, *is_open)
            }
            SceneFile::Eye(_) => Scene::default(),
        }
    }

    /// Sets the near and far planes given by the arguments.
    fn set_planes(&self, scene: &mut Scene) -> Result<(), SceneError> {
        let Some(camera) = &mut scene.camera else { return Ok(()) };
        let [near, far] = camera.projection.near_far_mut();
        *near = self.near.unwrap_or(*near);
        *far = self.far.unwrap_or(*far);
        camera.matrices(1.0).map(drop).map_err(|e| SceneError::NoFile(format!("camera: {e}")))
    }

    /// Draws and writes one picture. Returns its plan.
    fn draw(
        &self,
        renderer: &mut Renderer,
        scene: &Scene,
        transparency: TransparencyOrder,
        output: &mut Output,
    ) -> Result<String, SceneError> {
        let refused = |message: String| SceneError::Refused(message);
        let size = self.size.unwrap_or(FrameSize::DEFAULT);
        let mut memory = VideoMemory::new(size.width, size.height).map_err(|e| refused(e.to_string()))?;
        if self.background != VideoMemory::CLEAR {
            memory.clear(self.background);
        }
        let mut depth = None;
        let mut options = SceneOptions {
            shade: self.shade.unwrap_or_default(),
            depth_use: if self.depth_out.is_some() { DepthUse::Keep } else { DepthUse::SceneOnly },
            transparency,
            ..SceneOptions::new(size.width, size.height)
        };
        let mut cheaper = None;
        let mut plan = String::new();
        if let Some(max_error) = self.max_error {
            let budget = Budget {
                scene,
                options: &options,
                kind: BudgetKind::Scene,
                depth_format: DepthFormat::default(),
                width: size.width,
                height: size.height,
                max_error,
            };
            let choice =
                choose(renderer, &budget).map_err(|e| refused(format!("{}: {e}", self.scene.display())))?;
            plan.push_str(&choice.to_string());
            let mut changed = scene.clone();
            choice.apply(&mut changed, &mut options);
            cheaper = Some(changed);
        }
        let scene = cheaper.as_ref().unwrap_or(scene);
        let mut target = Target {
            memory: &mut memory,
            depth: &mut depth,
            depth_format: DepthFormat::default(),
            ids: None,
        };
        if self.explain {
            plan.insert_str(0, &renderer.plan_scene(&target, scene, &options).to_string());
        }
        if let Some(trace) = self.trace {
            trace::print(scene, &options, [size.width, size.height], trace).map_err(refused)?;
        }
        renderer
            .draw_scene(&mut target, scene, &options)
            .map_err(|e| refused(format!("{}: {e}", self.scene.display())))?;
        self.write(&memory, depth.as_ref(), output)?;
        Ok(plan)
    }

    /// Opens the output of the pictures.
    fn output(&self, [width, height]: [u32; 2]) -> Result<Output, SceneError> {
        let bad = |e: SaveError| SceneError::NoFile(e.to_string());
        if self.frames.is_some() {
            self.out.iter().chain(&self.depth_out).for_each(|path| save::remove_leftovers_beside(path));
        }
        let movie = match self.out.as_ref().filter(|out| is_movie(out)) {
            Some(out) => Some(Movie::create(out, width, height, self.fps).map_err(bad)?),
            None => None,
        };
        let progress = Progress::new("frames", self.frames.unwrap_or(1).into());
        Ok(Output { movie, done: 0, has_hung_up: false, progress })
    }

    /// Writes one picture, and its depth if requested.
    fn write(
        &self,
        memory: &VideoMemory,
        depth: Option<&DepthMemory>,
        output: &mut Output,
    ) -> Result<(), SceneError> {
        let refused = |e: SaveError| SceneError::Refused(e.to_string());
        let number = self.frames.map(|_| output.done);
        output.done += 1;
        output.progress.advance(1);
        match (&mut output.movie, &self.out) {
            (Some(movie), _) => match movie.push(memory) {
                // The reader has closed the pipe.
                Err(SaveError::Io { kind: std::io::ErrorKind::BrokenPipe, .. }) => output.has_hung_up = true,
                pushed => pushed.map_err(refused)?,
            },
            (None, Some(out)) => save::to_path(memory, &numbered(out, number)).map_err(refused)?,
            (None, None) => {}
        }
        let Some(path) = &self.depth_out else { return Ok(()) };
        let path = numbered(path, number);
        match depth {
            Some(depth) => save::depth_to_path(depth, &path),
            None => {
                let far = DepthMemory::new(memory.width(), memory.height(), DepthFormat::F32);
                save::depth_to_path(&far, &path)
            }
        }
        .map_err(refused)
    }

    /// Renders an N-dimensional scene; all requested frames are the same picture.
    fn render_eye(&self, scene: &EyeScene) -> Result<(), SceneError> {
        let refused = |message: String| SceneError::Refused(message);
        let exact = eye::Fibre::Exact;
        if self.explain {
            let plan = eye::plan(scene, exact).map_err(|e| refused(e.to_string()))?;
            output::print(format!("{plan}\n"));
            if self.max_error.is_some() {
                output::print(
                    "budget: exact; no fan of rays is both cheaper than the exact fibre and as near\n",
                );
            }
        }
        let [width, height] = match self.size {
            Some(FrameSize { width, height }) => [width, height],
            None => eye::ContactSheet::of(&scene.pixels).picture_size(),
        };
        let picture =
            eye::render_with(scene, exact, &super::eye::pool(None)).map_err(|e| refused(e.to_string()))?;
        let mut memory = VideoMemory::new(width, height).map_err(|e| refused(e.to_string()))?;
        eye::blit(&picture, &mut memory, 0, 0, width as i32, height as i32);
        let mut output = self.output([width, height])?;
        for _ in 0..self.frames.unwrap_or(1) {
            self.write(&memory, None, &mut output)?;
        }
        Ok(())
    }
}

/// Returns the order of a file's transparent faces; in glTF there is none that counts.
fn transparency(file: &SceneFile) -> TransparencyOrder {
    match file {
        SceneFile::Gltf(_) => TransparencyOrder::Sorted,
        SceneFile::X3d(_) | SceneFile::Mesh { .. } | SceneFile::Eye(_) => TransparencyOrder::default(),
    }
}

fn is_animated(file: &SceneFile) -> bool {
    match file {
        SceneFile::X3d(document) => document.is_animated(),
        SceneFile::Gltf(document) => document.is_animated(),
        SceneFile::Mesh { .. } | SceneFile::Eye(_) => false,
    }
}

/// Rotates all objects about the scene's middle, by a fraction of a full turn about y. The camera
/// and the lights stay; but a camera that only frames the scene, in a picture of `framed` pixels,
/// moves back so that nothing leaves the picture.
fn turn(scene: &mut Scene, part: f64, framed: Option<FrameSize>) {
    let Some((low, high)) = scene.bounds() else { return };
    let center = low / 2.0 + high / 2.0;
    if let (Some(FrameSize { width, height }), Some(camera)) = (framed, &mut scene.camera) {
        let half = high - center;
        // Bounding box of the cylinder that the rotating box sweeps.
        let radius = libm::hypot(half.x, half.z);
        let half = DVec3::new(radius, half.y, radius);
        let eye = camera.look_at.eye - camera.look_at.reference;
        if let Some(z) = eye.try_normalize() {
            let x = camera.look_at.up.cross(z).normalize_or(DVec3::X);
            let aspect = f64::from(width) / f64::from(height);
            *camera = frame_along((center - half, center + half), [x, z.cross(x), z], FRAME_FOV_RAD, aspect);
        }
    }
    let (sin, cos) = libm::sincos(part * std::f64::consts::TAU);
    let turned =
        DMat4::from_cols(DVec4::new(cos, 0.0, -sin, 0.0), DVec4::Y, DVec4::new(sin, 0.0, cos, 0.0), DVec4::W);
    let about = DMat4::from_translation(center) * turned * DMat4::from_translation(-center);
    scene.objects.iter_mut().for_each(|object| object.model = about * object.model);
}

/// Destination of the pictures, and their number so far.
struct Output {
    movie: Option<Movie>,
    done: u64,
    /// Set when the reader of the movie has closed the pipe.
    has_hung_up: bool,
    progress: Progress,
}

/// File extensions of the output.
const ENDINGS: &str = ".png, .ppm or .raw, or for a movie .gif, .apng or .y4m (- for y4m on standard output)";

/// Returns whether a name is that of a movie, one file of all pictures. `.png` stays one file for
/// each picture.
fn is_movie(path: &Path) -> bool {
    !matches!(MovieFormat::of_path(path), Err(_) | Ok(MovieFormat::NumberedPng))
}

/// Returns the name of picture `number`, or `path` itself if there is only one.
fn numbered(path: &Path, number: Option<u64>) -> PathBuf {
    number.map_or_else(|| path.to_owned(), |number| save::numbered_path(path, number))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Geometry, Mesh};

    #[test]
    fn a_turn_ends_where_it_began_and_nothing_leaves_the_picture() {
        let mesh = Mesh::from_triangles(
            vec![DVec3::new(5.0, 0.0, 0.0), DVec3::new(9.0, 1.0, 0.0), DVec3::new(5.0, 3.0, 0.5)],
            &[[0, 1, 2]],
        );
        let size = FrameSize { width: 64, height: 48 };
        let of = |part: f64| {
            let mut scene = Scene::of_mesh(
                Arc::new(Geometry { mesh: mesh.clone(), ..Geometry::default() }),
                "m",
                4.0 / 3.0,
                false,
            );
            turn(&mut scene, part, Some(size));
            scene
        };
        let corner = |scene: &Scene| scene.objects[0].model.transform_point3(mesh.positions[1]);
        assert!((corner(&of(1.0)) - mesh.positions[1]).length() < 1e-12);
        // Half a turn about the middle of the box, (7, 1.5, 0.25).
        assert!((corner(&of(0.5)) - DVec3::new(5.0, 1.0, 0.5)).length() < 1e-12);
        let camera = of(0.0).camera.unwrap();
        let m = camera.matrices(4.0 / 3.0).unwrap();
        for step in 0..16 {
            let scene = of(f64::from(step) / 16.0);
            assert_eq!(scene.camera, Some(camera), "the camera stands still");
            for &p in &mesh.positions {
                let clip = m.projection * (m.view * scene.objects[0].model.transform_point3(p).extend(1.0));
                assert!(
                    (clip.x / clip.w).abs() < 1.0 && (clip.y / clip.w).abs() < 1.0 && clip.z / clip.w < 1.0
                );
            }
        }
    }

    #[test]
    fn pictures_of_an_animation_have_numbers_before_their_ending() {
        assert_eq!(numbered(Path::new("a/b.c.png"), Some(7)), Path::new("a/b.c-0007.png"));
        assert_eq!(numbered(Path::new("b.png"), None), Path::new("b.png"));
    }
}

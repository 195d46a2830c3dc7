//! `fbptr render`: a scene file to a picture, or to the pictures of its animation.

use super::batch::ShardArgs;
use super::black_picture::BlackPicture;
use super::expect::ExpectArgs;
use super::mesh_args::MeshArgs;
use super::picture_args::PictureArgs;
use super::render_args::RenderArgs;
use super::render_output::{ENDINGS, RenderOutput};
use super::scene_file::{self, ReadOptions, SceneError, SceneFile};
use super::table::Table;
use super::trace::{self, TraceAt};
use super::{Status, output, say_as_program};
use crate::animation::{Animation, FrameOptions, LoadedScene, PlaneTurn};
use crate::executor::Executor;
use crate::eye;
use crate::measure::{self, all_stages};
use crate::memory::{DepthFormat, DepthMemory, VideoMemory};
use crate::pipeline::quality::{Budget, MeshShapes, prove};
use crate::pipeline::{DepthUse, EmptyDraw, Renderer, SceneOptions, Target};
use crate::save::{self, MovieFormat, SaveError};
use crate::scene::{MaxError, Scene};
use crate::server::worker_pool;
use crate::viewer::{Model, STUDIO_SIZE, Viewer, ViewerOptions, turntable_rate};
use clap::Args;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

/// Render a scene file.
#[derive(Debug, Args)]
pub struct Render {
    /// The scene: .gltf, .glb, .x3d, .x3dz, .x3dv, .wrl, .obj, .stl, .ply, or .json for N dimensions; or a built-in
    /// model, as teapot
    #[arg(value_name = "SCENE", required_unless_present = "list")]
    scene: Option<PathBuf>,
    /// Print the names of the built-in models
    #[arg(long, exclusive = true)]
    list: bool,
    /// The picture: .png, .ppm or .raw; with --frames a movie too: .gif, .apng, .y4m, or - for y4m on standard output
    #[arg(short, long, value_name = "OUT", required_unless_present_any = ["trace", "list", "expect", "table"])]
    out: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
    /// Make the picture that `fbptr view` shows: framed, lit by three lights, on a ground, with smooth edges [its size: 960x720]
    #[arg(long, conflicts_with_all = ["background", "shade", "near", "far", "depth_out", "max_error", "explain", "all_stages", "trace", "table"])]
    studio: bool,
    /// Write the depth too
    #[arg(long, value_name = "OUT.pfm")]
    depth_out: Option<PathBuf>,
    /// Draw more cheaply where the 99.9th percentile of colour error stays within E steps of 255; and each pixel shows what is exact within S pixels
    #[arg(long, value_name = "E[,S]", allow_negative_numbers = true)]
    max_error: Option<MaxError>,
    /// Print what the scene needs, and why, and what each stage cost
    #[arg(long)]
    explain: bool,
    /// Run every stage that keeps the picture, needed or not: with --explain, what leaving them out saves
    #[arg(long)]
    all_stages: bool,
    /// Print every number that a triangle (N), a pixel (X,Y) or a triangle at a pixel (N@X,Y) has on its way
    #[arg(long, value_name = "N|X,Y|N@X,Y")]
    trace: Option<TraceAt>,
    /// Print the picture, or its depths, as a table of text; up to 64x64 pixels
    #[arg(long, value_name = "color|depth", num_args = 0..=1, require_equals = true, default_missing_value = "color", conflicts_with = "frames")]
    table: Option<Table>,
    #[command(flatten)]
    expect: ExpectArgs,
    /// Number of pictures, one turn of a scene without an animation; but in a movie, their names have a number before the ending
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Pictures a second
    #[arg(long, value_name = "F", value_parser = positive, default_value = "25", allow_negative_numbers = true)]
    fps: f64,
    /// Turn an N-dimensional scene in the plane of two axes by so many degrees over all frames; again for further planes
    #[arg(long, value_name = "A,B,DEGREES", requires = "frames", allow_hyphen_values = true)]
    turn: Vec<PlaneTurn>,
    #[command(flatten)]
    shard: ShardArgs,
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|n: &f64| n.is_finite()).ok_or_else(|| "expected a finite number".to_owned())
}

pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text).ok().filter(|n| *n > 0.0).ok_or_else(|| "expected a finite number above 0".to_owned())
}

/// One drawn picture.
struct Drawn {
    /// Its plan, if requested.
    plan: String,
    /// Reason for which it shows nothing of the scene, if it does not.
    empty_reason: Option<String>,
}

/// Returns the reason why nothing of a scene is shown, with the argument that would show it if that
/// is the distance of the near or far plane.
fn explained(reason: EmptyDraw, scene: &Scene, options: &SceneOptions) -> String {
    let camera = scene.camera.unwrap_or(options.camera);
    let (eye, [near, far]) = (camera.look_at.eye, camera.projection.near_far());
    let Some((low, high)) = scene.bounds() else { return reason.to_string() };
    let nearest = eye.clamp(low, high).distance(eye);
    let farthest = (eye - low).abs().max((eye - high).abs()).length();
    // In f32, for few digits.
    let [nearest, farthest, near, far] = [nearest, farthest, near, far].map(|distance| distance as f32);
    if nearest > far {
        format!("{reason}; all of it is {nearest} or more away, and the far plane is at {far}: see --far")
    } else if farthest < near {
        format!("{reason}; all of it is within {farthest}, and the near plane is at {near}: see --near")
    } else {
        reason.to_string()
    }
}

impl Render {
    /// Renders all pictures, and returns the exit status.
    pub(super) fn run(self) -> Status {
        if self.list {
            return scene_file::list_models();
        }
        match self.render() {
            Ok(()) => Status::Success,
            Err(error) => error.say(),
        }
    }

    fn scene(&self) -> &Path {
        self.scene.as_deref().unwrap_or(Path::new(""))
    }

    fn render(&self) -> Result<(), SceneError> {
        self.check()?;
        let expected = self.expect.check(&self.drawing).map_err(SceneError::NoFile)?;
        let budget = &self.drawing.budget();
        let options = ReadOptions { root: self.picture.root.as_deref(), meshes: &self.meshes };
        let LoadedScene { file, crc, held: _held, .. } =
            scene_file::read(self.scene(), options, &self.drawing.reading_budget(budget))?;
        let renderer = self.drawing.renderer_within(budget);
        if matches!(file, SceneFile::Eye(_)) {
            self.check_for_eye()?;
        }
        let name = self.scene().file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let animation = Animation::new(file, name, self.frame_options())
            .map_err(|e| SceneError::NoFile(format!("--turn: {e}")))?;
        let [width, height] = animation.size();
        self.table.map_or(Ok(()), |table| table.check(width, height)).map_err(SceneError::NoFile)?;
        let mut output = self.output(&animation, crc)?;
        output.expect(expected);
        if animation.is_turntable() {
            let (scene, frames) = (self.scene().display(), animation.options.count);
            say_as_program(format_args!("{scene} has no animation: the {frames} frames are one turn"));
        } else if animation.is_still() && animation.options.count > 1 {
            let (scene, frames) = (self.scene().display(), animation.options.count);
            say_as_program(format_args!(
                "the {frames} frames are the same: --turn A,B,DEGREES turns {scene} in the plane of two axes, \
                 as --turn 0,1,360"
            ));
        }
        if self.studio {
            return self.render_studio(animation, output, renderer);
        }
        let is_mesh = matches!(animation.file, SceneFile::Mesh { .. });
        let plans = match animation.file {
            SceneFile::Eye(_) => self.render_eye(&animation, &mut output, renderer)?,
            _ => self.render_solid(&animation, &mut output, renderer)?,
        };
        if self.explain {
            output::print(plans);
        }
        output.finish()?;
        if is_mesh && self.out.is_some() && std::io::stderr().is_terminal() {
            say_as_program("--studio makes a picture with three lights, a ground and smooth edges");
        }
        Ok(())
    }

    /// Renders all pictures as the viewer shows them.
    fn render_studio(
        &self,
        animation: Animation,
        mut output: RenderOutput,
        renderer: Renderer,
    ) -> Result<(), SceneError> {
        let scene = self.scene().display();
        let refused = |e: String| SceneError::Refused(format!("{scene}: {e}"));
        let (size, turntable) = (animation.size(), animation.is_turntable());
        let Animation { file, name, options } = animation;
        let viewer_options = ViewerOptions {
            name,
            size,
            time: options.begin_s,
            fps: if turntable { turntable_rate(options.count) } else { options.rate },
            cull: options.cull,
            point_size: options.point_size,
            studio: true,
            turntable,
            split: None,
            renderer,
            pool: Executor::of_pool(worker_pool(None)),
        };
        let mut viewer = Viewer::new(Model::from(file), viewer_options).map_err(refused)?;
        let mut at = 0;
        while let Some(frame) = output.next_frame() {
            viewer.step(i64::from(frame) - at);
            at = i64::from(frame);
            viewer.smooth_fully();
            match viewer.failure() {
                None => output.write(frame, viewer.shown(), None)?,
                Some(failure) => {
                    let error = DrawError::Scene(SceneError::Refused(format!("{scene}: {failure}")));
                    output.failed(frame, error)?;
                }
            }
        }
        output.finish()
    }

    /// Checks the arguments that need no scene.
    fn check(&self) -> Result<(), SceneError> {
        let bad = |message: String| SceneError::NoFile(message);
        if let Some(out) = self.out.as_ref().filter(|out| !is_movie(out)) {
            let error = |_| SaveError::UnknownEnding { path: out.clone(), expected: ENDINGS };
            save::SnapshotFormat::of_path(out).map_err(|e| bad(error(e).to_string()))?;
        }
        if let Some(path) = &self.depth_out {
            save::check_depth_path(path).map_err(|e| bad(e.to_string()))?;
        }
        let prints = self.explain || self.trace.is_some() || self.table.is_some();
        if self.out.as_deref() == Some(Path::new("-")) && prints {
            return Err(bad(
                "-o -: standard output is the movie's, and --explain, --trace and --table print there"
                    .to_owned(),
            ));
        }
        if self.expect.expect.is_some() && self.frames.is_some() {
            return Err(bad("--expect is for one picture, not for --frames".to_owned()));
        }
        if self.shard.is_given() {
            self.shard.check(self.frames.unwrap_or(1)).map_err(bad)?;
            match &self.out {
                Some(out) if !is_movie(out) => {}
                _ => {
                    return Err(bad(
                        "a part of the frames is written as pictures, -o NAME.png, .ppm or .raw; \
                         `fbptr batch movie` joins them"
                            .to_owned(),
                    ));
                }
            }
        }
        self.picture.check().map_err(bad)
    }

    /// Checks that no argument is for scenes in three dimensions.
    fn check_for_eye(&self) -> Result<(), SceneError> {
        if self.trace.is_some() {
            let message = "--trace follows triangles of scenes in three dimensions";
            return Err(SceneError::NoFile(message.to_owned()));
        }
        let own = [("--max-error", self.max_error.is_some()), ("--studio", self.studio)];
        let own = own.iter().find(|(_, is_given)| *is_given).map(|(flag, _)| *flag);
        match self.picture.not_for_eye(&self.meshes).or(own) {
            None => Ok(()),
            Some(flag) => {
                let scene = self.scene().display();
                Err(SceneError::NoFile(format!(
                    "{flag} is for scenes in three dimensions: {scene} is an N-dimensional one"
                )))
            }
        }
    }

    fn frame_options(&self) -> FrameOptions {
        let options = self.picture.frame_options(&self.meshes);
        FrameOptions {
            count: self.frames.unwrap_or(1),
            rate: self.fps,
            size: options.size.or(self.studio.then_some(STUDIO_SIZE)),
            turns: self.turn.clone(),
            ..options
        }
    }

    /// Opens the output of the pictures; `crc` is the checksum of the scene's files.
    fn output(&self, animation: &Animation, crc: u32) -> Result<RenderOutput, SceneError> {
        // What changes a frame beside the options of the animation.
        // Recipes of before the option stay valid.
        let points = self.meshes.point_size.map_or(String::new(), |size| format!(" points {size}"));
        let studio = if self.studio { " studio" } else { "" };
        let reading = self.meshes.reading().map_or(String::new(), |reading| format!(" {reading:?}"));
        let steps = self.max_error.map(|most| most.steps);
        let shift = self.max_error.map_or(0.0, |most| most.shift);
        let shift = if shift > 0.0 { format!(" shift {shift}") } else { String::new() };
        let more = format!("{:?} {steps:?}{shift}{points}{reading}{studio}", self.meshes.smoothing());
        let recipe = animation.recipe(crc, &more);
        let (out, depth_out) = (self.out.as_deref(), self.depth_out.as_deref());
        RenderOutput::open(out, depth_out, self.frames, self.shard, animation, recipe)
    }

    /// Draws the frames of a scene in three dimensions. Returns their plans.
    fn render_solid(
        &self,
        animation: &Animation,
        output: &mut RenderOutput,
        mut renderer: Renderer,
    ) -> Result<String, SceneError> {
        let frames = self.frames.unwrap_or(1).into();
        let (mut plans, mut shapes) = (String::new(), MeshShapes::at_once().expecting(frames));
        shapes.set_budget(&self.drawing.budget());
        let mut is_reported = false;
        while let Some(frame) = output.next_frame() {
            match self.draw((&mut renderer, &mut shapes), animation, frame, output, !is_reported) {
                Ok(drawn) => {
                    if !plans.ends_with(&drawn.plan) {
                        plans.push_str(&drawn.plan);
                    }
                    if let Some(reason) = drawn.empty_reason {
                        is_reported = true;
                        say_as_program(format_args!("{}: frame {frame}: {reason}", self.scene().display()));
                    }
                }
                Err(error) => output.failed(frame, error)?,
            }
        }
        Ok(plans)
    }

    /// Draws and writes one picture; `explains` asks for the reason if it shows nothing.
    fn draw(
        &self,
        (renderer, shapes): (&mut Renderer, &mut MeshShapes),
        animation: &Animation,
        frame: u32,
        output: &mut RenderOutput,
        explains: bool,
    ) -> Result<Drawn, DrawError> {
        let refused = |message: String| DrawError::Scene(SceneError::Refused(message));
        let scene =
            &animation.scene(frame).map_err(|e| DrawError::Scene(SceneError::NoFile(e.to_string())))?;
        let [width, height] = animation.size();
        let mut memory = VideoMemory::new(width, height).map_err(|e| refused(e.to_string()))?;
        if self.picture.background != VideoMemory::CLEAR {
            memory.clear(self.picture.background);
        }
        let mut depth = None;
        let options = SceneOptions {
            depth_use: match self.depth_out.is_some() || self.table == Some(Table::Depth) {
                true => DepthUse::Keep,
                false => DepthUse::SceneOnly,
            },
            ..animation.scene_options()
        };
        let mut cheaper = None;
        let mut plan = String::new();
        if let Some(max_error) = self.max_error {
            // A trace follows the triangles of the whole mesh.
            let shift = if self.trace.is_some() { 0.0 } else { max_error.shift };
            let max_error = MaxError { shift, ..max_error };
            let choice = prove(&Budget { scene, options: &options, max_error }, shapes);
            plan.push_str(&choice.to_string());
            let mut changed = scene.clone();
            choice.apply(&mut changed);
            cheaper = Some(changed);
        }
        let scene = cheaper.as_ref().unwrap_or(scene);
        let every = self.all_stages.then(|| all_stages(scene, &options));
        let (scene, options) = every.as_ref().map_or((scene, &options), |(scene, options)| (scene, options));
        let mut target = Target {
            memory: &mut memory,
            depth: &mut depth,
            depth_format: DepthFormat::default(),
            ids: None,
        };
        if self.explain {
            plan.insert_str(0, &renderer.plan_scene(&target, scene, options).to_string());
        }
        if let Some(trace) = self.trace {
            trace::print(scene, options, [width, height], trace).map_err(refused)?;
        }
        let stats = renderer
            .draw_scene(&mut target, scene, options)
            .map_err(|e| refused(format!("{}: {e}", self.scene().display())))?;
        let mut reason = None;
        if explains {
            let black = BlackPicture { scene, options, memory: &memory, background: self.picture.background };
            reason = EmptyDraw::of_scene(&stats, scene, options, &memory)
                .or_else(|| black.is_unlit(renderer).then_some(EmptyDraw::NoLight))
                // The reader of a mesh has said that there is nothing in it.
                .filter(|r| *r != EmptyDraw::NoContent || !matches!(animation.file, SceneFile::Mesh { .. }));
        }
        self.write(&memory, depth.as_ref(), frame, output)?;
        // Once, and after the frame, whose bytes it cannot change.
        if self.explain && self.frames.is_none_or(|n| n == 1) {
            let bill = measure::bill(renderer, [width, height], scene, options)
                .map_err(|e| refused(e.to_string()))?;
            plan.push_str(&bill.to_string());
        }
        let empty_reason = reason.map(|reason| explained(reason, scene, options));
        Ok(Drawn { plan, empty_reason })
    }

    /// Writes one picture, and its depth if requested.
    fn write(
        &self,
        memory: &VideoMemory,
        depth: Option<&DepthMemory>,
        frame: u32,
        output: &mut RenderOutput,
    ) -> Result<(), DrawError> {
        if let Some(table) = self.table {
            table.print(memory, depth);
        }
        let far = match (&self.depth_out, depth) {
            (Some(_), None) => {
                let [width, height] = [memory.width(), memory.height()];
                Some(DepthMemory::new(width, height, DepthFormat::F32))
            }
            _ => None,
        };
        output.write(frame, memory, depth.or(far.as_ref())).map_err(DrawError::Output)
    }

    /// Renders an N-dimensional scene; without turns all frames are the same picture. Returns its
    /// plan.
    fn render_eye(
        &self,
        animation: &Animation,
        output: &mut RenderOutput,
        mut renderer: Renderer,
    ) -> Result<String, SceneError> {
        let refused = |e: eye::EyeError| SceneError::Refused(e.to_string());
        let exact = eye::Fibre::Exact;
        if self.explain
            && let SceneFile::Eye(scene) = &animation.file
        {
            let plan = eye::plan(scene, exact).map_err(refused)?;
            output::print(format!("{plan}\n"));
            if self.max_error.is_some() {
                output::print(
                    "budget: exact; no fan of rays is both cheaper than the exact fibre and as near\n",
                );
            }
        }
        let executor = super::eye::pool(None);
        let mut still = None;
        while let Some(frame) = output.next_frame() {
            let drawn = match still.take() {
                Some(memory) => Ok(memory),
                None => animation.draw(frame, &mut renderer, &executor),
            };
            let written = drawn
                .map_err(|e| DrawError::Scene(SceneError::Refused(e.to_string())))
                .and_then(|memory| self.write(&memory, None, frame, output).map(|()| memory));
            match written {
                Ok(memory) => still = animation.is_still().then_some(memory),
                Err(error) => output.failed(frame, error)?,
            }
        }
        Ok(String::new())
    }
}

/// Reason why a frame is not in the output.
pub(super) enum DrawError {
    /// The scene cannot be drawn at that frame; others may be.
    Scene(SceneError),
    /// The output cannot be written.
    Output(SceneError),
}

/// Returns whether a name is that of a movie, one file of all pictures. `.png` stays one file for
/// each picture.
pub(super) fn is_movie(path: &Path) -> bool {
    !matches!(MovieFormat::of_path(path), Err(_) | Ok(MovieFormat::NumberedPng))
}

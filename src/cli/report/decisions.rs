//! `fbptr report --scene`: the settings of pictures of a user's own files, compared.
//!
//! In: the files, read and framed as `fbptr render` reads them, streams as `fbptr play` plays them.
//! Out: a decision for each. The command line of a setting has the words of this one that `render`
//! takes too.

use super::super::mesh_args::MeshArgs;
use super::super::picture_args::PictureArgs;
use super::super::play::{open_stream, size_of_stream};
use super::super::render_args::RenderArgs;
use super::super::scene_file::{self, ReadOptions, SceneError, SceneFile};
use crate::animation::{Animation, LoadedScene};
use crate::load::SandboxDir;
use crate::measure::Effort;
use crate::measure::decide::{
    DecideError, Decision, Question, Setting, Subject, USUAL_BUDGETS, USUAL_LIMIT, decide, quality_line,
};
use crate::memory::VideoMemory;
use crate::scene::MaxError;
use crate::server::Limits;
use glam::DVec3;
use std::io::Read;
use std::path::Path;

/// Ways to read and draw the files, and the questions about them.
pub(super) struct Asked<'a> {
    pub picture: &'a PictureArgs,
    pub meshes: &'a MeshArgs,
    pub drawing: &'a RenderArgs,
    /// Error budgets of the command line.
    pub budgets: &'a [MaxError],
    pub load_dir: Option<&'a Path>,
}

impl Asked<'_> {
    /// Compares the settings of a file's picture.
    pub fn decide(&self, effort: &Effort, path: &Path) -> Result<Decision, SceneError> {
        match scene_file::is_scene(path)? {
            true => self.of_scene(effort, path),
            false => self.of_stream(effort, path),
        }
    }

    /// Returns a question; its size and subject are the file's.
    fn question<'q>(
        &self,
        path: &Path,
        subject: Subject<'q>,
        size: [u32; 2],
        command: &'q dyn Fn(&Setting) -> Option<String>,
    ) -> Question<'q> {
        let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let budgets = if self.budgets.is_empty() {
            USUAL_BUDGETS.map(MaxError::from).into()
        } else {
            self.budgets.to_vec()
        };
        let limit = self.budgets.iter().map(|most| most.steps).reduce(f64::max).unwrap_or(USUAL_LIMIT);
        Question { name, subject, size, budgets, limit, command }
    }

    fn of_scene(&self, effort: &Effort, path: &Path) -> Result<Decision, SceneError> {
        let name = path.display().to_string();
        let refused = |e: String| SceneError::Refused(format!("{name}: {e}"));
        let budget = &self.drawing.budget();
        let options = ReadOptions { root: self.picture.root.as_deref(), meshes: self.meshes };
        let LoadedScene { file, held: _held, .. } =
            scene_file::read(path, options, &self.drawing.reading_budget(budget))?;
        let is_eye = matches!(file, SceneFile::Eye(_));
        let not_for_eye =
            self.picture.not_for_eye(self.meshes).or((!self.budgets.is_empty()).then_some("--max-error"));
        if let (true, Some(flag)) = (is_eye, not_for_eye) {
            let message = format!("{flag} is for scenes in three dimensions: {name} is an N-dimensional one");
            return Err(SceneError::NoFile(message));
        }
        let stem = path.file_stem().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        let animation = Animation::new(file, stem.clone(), self.picture.frame_options(self.meshes))
            .map_err(|e| SceneError::NoFile(e.to_string()))?;
        let command = |setting: &Setting| of_render(&name, &stem, setting);
        let decided = match &animation.file {
            SceneFile::Eye(scene) => {
                decide(effort, self.question(path, Subject::Eye(scene), animation.size(), &command))
            }
            _ => {
                let mut scene = animation.scene(0).map_err(|e| SceneError::NoFile(e.to_string()))?;
                let options = animation.scene_options();
                scene.camera.get_or_insert(options.camera);
                let background = self.picture.background;
                if background != VideoMemory::CLEAR {
                    let [r, g, b, _] = background.map(|v| f64::from(v) / 255.0);
                    scene.background.color.get_or_insert(DVec3::new(r, g, b));
                }
                let (shade, order) = (options.shade, options.transparency);
                let subject = Subject::Solid { scene: Box::new(scene), shade, order };
                decide(effort, self.question(path, subject, animation.size(), &command))
            }
        };
        decided.map_err(|e| refused(e.to_string()))
    }

    fn of_stream(&self, effort: &Effort, path: &Path) -> Result<Decision, SceneError> {
        let name = path.display().to_string();
        let (mut file, _) = open_stream(path, &name).map_err(SceneError::NoFile)?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).map_err(|e| SceneError::NoFile(format!("{name}: {e}")))?;
        let own = size_of_stream(&bytes).map_err(|e| SceneError::Refused(format!("{name}: {e}")))?;
        let [width, height] = own
            .or(self.picture.size)
            .map_or(crate::animation::DEFAULT_SIZE, |size| [size.width, size.height]);
        let too_large = Limits::default().check_frame(width, height);
        too_large.map_err(|e| SceneError::NoFile(format!("{name}: {}", e.message)))?;
        let open = |folder: &Path| {
            SandboxDir::open(folder).map_err(|e| SceneError::NoFile(format!("{}: {e}", folder.display())))
        };
        let load_dir = self.load_dir.map(open).transpose()?;
        let line = quality_line(&bytes);
        let folder = self
            .load_dir
            .map_or(String::new(), |folder| format!(" --load-dir {}", quoted(&folder.display().to_string())));
        let end = format!("--headless --snap frame.png --size {width}x{height}{folder}");
        let command = |setting: &Setting| of_play(&name, setting, line, &end);
        let subject = Subject::Stream { bytes: &bytes, load_dir };
        decide(effort, self.question(path, subject, [width, height], &command)).map_err(|e| match e {
            DecideError::Stream(line) => {
                SceneError::Refused(line.replacen("stream:", &format!("{name}:"), 1))
            }
            e => SceneError::Refused(format!("{name}: {e}")),
        })
    }
}

/// Returns the command that renders a scene with a setting; `None` if `render` has none.
fn of_render(name: &str, stem: &str, setting: &Setting) -> Option<String> {
    let own = match setting {
        Setting::Exact => String::new(),
        // A single picture is drawn whole.
        Setting::Within(max_error) if max_error.shift > 0.0 => return None,
        Setting::Within(max_error) => format!(" --max-error {max_error}"),
        Setting::Shade(shade) => format!(" --shade {}", shade.as_str()),
        Setting::Fan(rays) => {
            return Some(format!(
                "fbptr eye {} --fan {rays} > {}",
                quoted(name),
                quoted(&format!("{stem}.json"))
            ));
        }
        Setting::Filter(_) | Setting::Affine => return None,
    };
    let picture = quoted(&format!("{stem}.png"));
    let dropped = |word: &str| match setting {
        Setting::Shade(_) => word == "--shade",
        _ => false,
    };
    let words: String = words_of_render(dropped).iter().map(|word| format!(" {}", quoted(word))).collect();
    Some(format!("fbptr render {} -o {picture}{words}{own}", quoted(name)))
}

/// Returns the command that plays a stream with a setting. `QUALITY` stands in the place of `SIZE`,
/// which only files have: in the line with this number, or before the first one; `end` are the options.
fn of_play(name: &str, setting: &Setting, line: usize, end: &str) -> Option<String> {
    let file = quoted(name);
    match setting {
        Setting::Exact => Some(format!("fbptr play {file} {end}")),
        Setting::Within(MaxError { steps, shift }) => {
            let quality = format!("echo QUALITY max-error {steps} {shift}");
            let stream = match line {
                0 => format!("{quality}; cat {file}"),
                n => format!("{quality}; tail -n +{} {file}", n + 1),
            };
            Some(format!("({stream}) | fbptr play - {end}"))
        }
        _ => None,
    }
}

/// Returns the words of this command that `render` takes too, but for those of a dropped option.
fn words_of_render(dropped: impl Fn(&str) -> bool) -> Vec<String> {
    const WITH_VALUE: [&str; 6] = ["--scene", "--out", "--max-error", "--peers", "--threads", "--load-dir"];
    let mut words =
        std::env::args().skip(1).skip_while(|word| word != "report").skip(1).filter(|word| word != "--quick");
    let mut kept = Vec::new();
    while let Some(word) = words.next() {
        let (option, has_value) = word.split_once('=').map_or((&*word, false), |(option, _)| (option, true));
        if WITH_VALUE.contains(&option) || dropped(option) {
            if !has_value {
                words.next();
            }
        } else {
            kept.push(word);
        }
    }
    kept
}

/// Quotes a word for a POSIX shell, if it needs that.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
    match !word.is_empty() && word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

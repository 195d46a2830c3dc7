//! `fbptr eye`: the N-dimensional eye. Prints a scene's picture as JSON, creates scenes, and
//! compares fans with the exact fibre.

mod bench;
mod make;

use super::{Status, output, say, say_as_program};
use crate::executor::Executor;
use crate::eye::{EyeScene, Fibre, plan, render_with};
use crate::server::worker_pool;
use clap::Args;
use std::io::Read;
use std::path::{Path, PathBuf};

/// See a scene of N dimensions on a screen of M.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  fbptr eye --make tesseract > scene.json
  fbptr eye scene.json > picture.json
  fbptr eye --make cube --dim 5 --pixels 64x64x64 | fbptr eye --explain - > volume.json
  fbptr eye --make prism --mesh model.obj --pixels 320x240 > prism.json
  fbptr eye --bench --out fan.html")]
pub struct Eye {
    /// The scene, as JSON; `-` is standard input
    #[arg(value_name = "SCENE.json", required_unless_present_any = ["shape", "bench"], conflicts_with_all = ["shape", "bench"])]
    scene: Option<PathBuf>,
    /// Sample each fibre by so many rays along every hidden axis, not exactly
    #[arg(long, value_name = "RAYS", conflicts_with_all = ["shape", "bench"])]
    fan: Option<u32>,
    /// Threads to render on; as many as there are cores unless given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Say on standard error what the scene needs, and what is left out
    #[arg(long)]
    explain: bool,
    #[command(flatten)]
    make: make::Make,
    #[command(flatten)]
    bench: bench::Bench,
}

impl Eye {
    /// Prints the requested output, and returns the exit status.
    pub(super) fn run(self) -> Status {
        if self.bench.bench {
            return self.bench.run();
        }
        let text = match (&self.scene, self.make.shape) {
            (_, Some(shape)) => match self.make.scene(shape) {
                Ok(scene) => scene.to_value().to_string(),
                Err(message) => {
                    say_as_program(message);
                    return Status::BadArguments;
                }
            },
            (Some(path), None) => match self.picture(path) {
                Ok(text) => text,
                Err(refusal) => return refusal.say(),
            },
            // clap requires one of them.
            (None, None) => return Status::BadArguments,
        };
        output::print(text + "\n");
        Status::Success
    }

    /// Renders the scene at `path` to JSON.
    fn picture(&self, path: &Path) -> Result<String, Refusal> {
        let scene = read_scene(path)?;
        let fibre = self.fan.map_or(Fibre::Exact, Fibre::Fan);
        let refused = |e: crate::eye::EyeError| Refusal::Arguments(format!("--{e}"));
        if self.explain {
            say(&plan(&scene, fibre).map_err(refused)?.to_string());
        }
        let picture = render_with(&scene, fibre, &pool(self.threads)).map_err(refused)?;
        Ok(picture.to_json())
    }
}

/// Error of rendering a scene.
enum Refusal {
    /// The arguments are invalid.
    Arguments(String),
    /// The file is invalid.
    File(String),
}

impl Refusal {
    /// Prints the error, and returns the exit status.
    fn say(self) -> Status {
        match self {
            Refusal::Arguments(message) => {
                say_as_program(message);
                Status::BadArguments
            }
            Refusal::File(message) => {
                say_as_program(message);
                Status::Failed
            }
        }
    }
}

/// Creates the executor: a thread pool, or the calling thread if one is requested or no more are
/// available.
pub(super) fn pool(threads: Option<u16>) -> Executor {
    Executor::of_pool(worker_pool(threads.map(usize::from)))
}

/// Limit of the size of a scene's file.
const MAX_SCENE_BYTES: u64 = 4 << 30;

fn read_scene(path: &Path) -> Result<EyeScene, Refusal> {
    let mut text = Vec::new();
    let read = match path == Path::new("-") {
        true => std::io::stdin().lock().read_to_end(&mut text).map(drop),
        false => crate::save::read_input(path, MAX_SCENE_BYTES).map(|bytes| text = bytes),
    };
    read.map_err(|e| Refusal::Arguments(format!("{}: {e}", path.display())))?;
    EyeScene::from_json(&text).map_err(|e| Refusal::File(format!("{}: {}: {e}", path.display(), e.code())))
}

//! `fbptr batch movie`: the frames of a batch joined to a movie.

use super::check::Checked;
use super::manifest::MAX_FRAME_BYTES;
use crate::cli::progress::Progress;
use crate::cli::scene_file::SceneError;
use crate::cli::{Status, say_as_program};
use crate::save::{Movie, SaveError, read_frame};
use clap::Args;
use std::io::ErrorKind;
use std::path::PathBuf;

/// Join the frames of a folder to a movie.
#[derive(Debug, Args)]
pub struct JoinMovie {
    /// The folder of the frames
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// The movie: .gif, .apng, .y4m, or - for y4m on standard output
    #[arg(short, long, value_name = "OUT")]
    out: PathBuf,
    /// Frames a second [default: those that the frames were drawn for]
    #[arg(long, value_name = "F", value_parser = crate::cli::render::positive, allow_negative_numbers = true)]
    fps: Option<f64>,
}

impl JoinMovie {
    /// Verifies all frames, then writes the movie. Returns the exit status.
    pub fn run(&self) -> Result<Status, SceneError> {
        let refused = |e: SaveError| SceneError::Refused(e.to_string());
        if !crate::cli::render::is_movie(&self.out) {
            let expected = ".gif, .apng or .y4m, or - for y4m on standard output";
            let error = SaveError::UnknownEnding { path: self.out.clone(), expected };
            return Err(SceneError::NoFile(error.to_string()));
        }
        let checked = Checked::read(&self.folder)?;
        if !checked.is_right() {
            say_as_program(format_args!("no movie is made: {}", checked.to_string().trim_end()));
            return Ok(Status::Failed);
        }
        let size = checked.newest.size;
        let fps = self.fps.unwrap_or(checked.newest.fps);
        let mut movie =
            Movie::create(&self.out, size[0], size[1], fps).map_err(|e| SceneError::NoFile(e.to_string()))?;
        let mut progress = Progress::new("frames", checked.newest.of.into());
        for record in checked.whole.values() {
            let path = self.folder.join(&record.files[0].name);
            let bytes = crate::save::read_regular(&path, MAX_FRAME_BYTES)
                .map_err(|e| SceneError::Refused(format!("{}: {e}", path.display())))?;
            match movie.push(&read_frame(&path, &bytes, size).map_err(refused)?) {
                // The reader of the movie has closed the pipe.
                Err(SaveError::Io { kind: ErrorKind::BrokenPipe, .. }) => break,
                pushed => pushed.map_err(refused)?,
            }
            progress.advance(1);
        }
        Ok(Status::Success)
    }
}

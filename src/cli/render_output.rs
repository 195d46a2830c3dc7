//! The destination of the pictures of `fbptr render`: a movie, a file each, or the files of a batch.

use super::batch::{BatchPlan, BatchWriter, ShardArgs, written_file};
use super::expect::Expected;
use super::progress::Progress;
use super::render::{DrawError, is_movie};
use super::say_as_program;
use super::scene_file::SceneError;
use crate::animation::Animation;
use crate::memory::{DepthMemory, VideoMemory};
use crate::save::{self, Movie, SaveError, SnapshotFormat};
use std::path::{Path, PathBuf};

/// File extensions of the output.
pub(super) const ENDINGS: &str =
    ".png, .ppm or .raw, or for a movie .gif, .apng or .y4m (- for y4m on standard output)";

/// Destination of the pictures, and the frames that are to be drawn.
pub(super) struct RenderOutput {
    movie: Option<Movie>,
    batch: Option<BatchWriter>,
    out: Option<PathBuf>,
    depth_out: Option<PathBuf>,
    /// Set if the pictures' names have numbers.
    is_numbered: bool,
    frames: std::vec::IntoIter<u32>,
    /// Frames of a batch that the scene has refused.
    failed: Vec<u32>,
    /// Picture that the frames are compared with, and whether one differs.
    expected: Option<Expected>,
    differs: bool,
    /// Set when the reader of the movie has closed the pipe.
    has_hung_up: bool,
    progress: Progress,
}

impl RenderOutput {
    /// Opens the output of an animation. `frames` is the number that was asked for; `recipe` is the
    /// checksum of what changes a frame.
    pub fn open(
        out: Option<&Path>,
        depth_out: Option<&Path>,
        frames: Option<u32>,
        shard: ShardArgs,
        animation: &Animation,
        recipe: u32,
    ) -> Result<RenderOutput, SceneError> {
        let ([width, height], fps) = (animation.size(), animation.options.rate);
        let count = animation.options.count;
        if frames.is_some() {
            out.into_iter().chain(depth_out).for_each(save::remove_leftovers_beside);
        }
        let bad = |e: SaveError| SceneError::NoFile(e.to_string());
        let movie = match out.filter(|out| is_movie(out)) {
            Some(out) => Some(Movie::create(out, width, height, fps).map_err(bad)?),
            None => None,
        };
        let batch = match out.filter(|_| shard.is_given()) {
            Some(out) => {
                let plan = BatchPlan { out, depth_out, shard, count, size: [width, height], fps, recipe };
                Some(BatchWriter::open(&plan)?)
            }
            None => None,
        };
        let frames_to_draw = match &batch {
            Some(batch) => batch.missing(),
            None => (0..count).collect(),
        };
        if let Some(batch) = batch.as_ref().filter(|batch| batch.there() > 0) {
            let (there, all) = (batch.there(), batch.there() + frames_to_draw.len());
            say_as_program(format_args!("{there} of {all} frames are there already"));
        }
        Ok(RenderOutput {
            movie,
            batch,
            out: out.map(Path::to_owned),
            depth_out: depth_out.map(Path::to_owned),
            is_numbered: frames.is_some(),
            progress: Progress::new("frames", frames_to_draw.len() as u64),
            frames: frames_to_draw.into_iter(),
            failed: Vec::new(),
            expected: None,
            differs: false,
            has_hung_up: false,
        })
    }

    /// Sets the picture that the frame is compared with.
    pub fn expect(&mut self, expected: Option<Expected>) {
        self.expected = expected;
    }

    /// Returns the next frame to draw; none if the reader of the movie is gone.
    pub fn next_frame(&mut self) -> Option<u32> {
        let frame = self.frames.next().filter(|_| !self.has_hung_up)?;
        if let Some(batch) = &mut self.batch {
            batch.begin();
        }
        Some(frame)
    }

    /// Writes a frame, and its depth if requested.
    pub fn write(
        &mut self,
        frame: u32,
        memory: &VideoMemory,
        depth: Option<&DepthMemory>,
    ) -> Result<(), SceneError> {
        let refused = |e: SaveError| SceneError::Refused(e.to_string());
        let numbered = |path: &Path| match self.is_numbered {
            true => save::numbered_path(path, frame.into()),
            false => path.to_owned(),
        };
        if let Some(movie) = &mut self.movie {
            match movie.push(memory) {
                // The reader has closed the pipe.
                Err(SaveError::Io { kind: std::io::ErrorKind::BrokenPipe, .. }) => self.has_hung_up = true,
                pushed => pushed.map_err(refused)?,
            }
        }
        let mut files = Vec::new();
        if let (None, Some(out)) = (&self.movie, &self.out) {
            let format = SnapshotFormat::of_path(out).map_err(refused)?;
            let path = numbered(out);
            let written = written_file(&path, !self.is_numbered, |out| format.write(memory, out));
            files.push(written.map_err(|e| self.unwritten(&e))?);
        }
        if let (Some(path), Some(depth)) = (&self.depth_out, depth) {
            let path = numbered(path);
            let written = written_file(&path, !self.is_numbered, |out| save::pfm(depth, out));
            files.push(written.map_err(|e| self.unwritten(&e))?);
        }
        if let Some(expected) = &self.expected {
            self.differs |= !expected.is_met_by(memory);
        }
        if let Some(batch) = &mut self.batch {
            batch.record(frame, save::crc32(memory), files)?;
        }
        self.progress.advance(1);
        Ok(())
    }

    /// Returns the error of a file that was not written.
    fn unwritten(&self, error: &SaveError) -> SceneError {
        match &self.batch {
            Some(batch) => batch.interrupted(error.to_string()),
            None => SceneError::Refused(error.to_string()),
        }
    }

    /// Takes the error of a frame. A batch goes on with the others if the scene alone is at fault;
    /// anything else ends the run.
    pub fn failed(&mut self, frame: u32, error: DrawError) -> Result<(), SceneError> {
        match error {
            DrawError::Scene(SceneError::NoFile(message) | SceneError::Refused(message))
                if self.batch.is_some() =>
            {
                say_as_program(format_args!("frame {frame}: {message}"));
                self.failed.push(frame);
                self.progress.advance(1);
                Ok(())
            }
            DrawError::Scene(error) | DrawError::Output(error) => Err(error),
        }
    }

    /// Ends the output.
    ///
    /// # Errors
    /// If frames of a batch were refused, or the picture is not the expected one.
    pub fn finish(self) -> Result<(), SceneError> {
        if self.differs {
            return Err(SceneError::Refused("the picture is not the expected one".to_owned()));
        }
        match self.failed.len() {
            0 => Ok(()),
            count => {
                let frames = super::batch::ranges(&self.failed);
                Err(SceneError::Refused(format!(
                    "{count} frames were refused: {frames}; all others are there"
                )))
            }
        }
    }
}

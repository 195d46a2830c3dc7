//! `fbptr compare`: a picture beside the exact one, every wrong pixel in a class, in words.
//!
//! Exit status: 0 if they are equal within the tolerance, 1 if not, 2 for an error.

mod geometry;
mod source;

pub(super) use source::{Exact, Reading, is_picture};

use super::expect::{TOLERANCE, parse_tolerance};
use super::mesh_args::MeshArgs;
use super::render_args::RenderArgs;
use super::{FrameSize, Status, check_folder, output, say_as_program};
use crate::save::golden::Tolerance;
use clap::Args;
use std::path::{Path, PathBuf};

/// Compare a picture with the exact one, and say what is wrong with each wrong pixel.
#[derive(Debug, Args)]
pub struct Compare {
    /// The picture: .png or .ppm; or a stream or scene, which is drawn
    #[arg(value_name = "MINE")]
    mine: PathBuf,
    /// The exact picture, or better a stream or scene of which it is drawn: then the lines and faces are known
    #[arg(value_name = "EXACT")]
    exact: PathBuf,
    /// The size that streams and scenes are drawn in [default: that of the other picture, or their own]
    #[arg(long, value_name = "WxH")]
    size: Option<FrameSize>,
    /// Seconds since a scene's start
    #[arg(long, value_name = "T", value_parser = super::render::finite, default_value = "0", allow_negative_numbers = true)]
    time: f64,
    #[arg(long, value_name = "N[,PIXELS]", default_value = "0", help = TOLERANCE)]
    tolerance: String,
    /// Print the numbers as JSON
    #[arg(long)]
    json: bool,
    /// Write a page with both pictures, the wrong pixels by class, and some of each magnified
    #[arg(long, value_name = "OUT.html")]
    page: Option<PathBuf>,
    /// Let a stream's LOAD read files from this folder
    #[arg(long, value_name = "DIR")]
    load_dir: Option<PathBuf>,
    #[command(flatten)]
    meshes: MeshArgs,
    #[command(flatten)]
    drawing: RenderArgs,
}

impl Compare {
    /// Compares, and returns the exit status.
    pub(super) fn run(self) -> Status {
        match self.compare() {
            Ok(true) => Status::Success,
            Ok(false) => Status::Failed,
            Err(message) => {
                say_as_program(message);
                Status::BadArguments
            }
        }
    }

    fn compare(&self) -> Result<bool, String> {
        let tolerance: Tolerance = parse_tolerance(&self.tolerance)?;
        if let Some(page) = &self.page {
            check_folder(page)?;
        }
        let reading = Reading {
            size: self.size.map(|size| [size.width, size.height]),
            time: self.time,
            load_dir: self.load_dir.as_deref(),
            meshes: Some(&self.meshes),
            drawing: &self.drawing,
        };
        // What is a picture gives the size of what is drawn.
        let (mine, exact) = match is_picture(&self.mine) || !is_picture(&self.exact) {
            true => {
                let mine = Exact::read(&self.mine, reading)?;
                let exact = Exact::read(&self.exact, reading.in_size_of(&mine))?;
                (mine, exact)
            }
            false => {
                let exact = Exact::read(&self.exact, reading)?;
                (Exact::read(&self.mine, reading.in_size_of(&exact))?, exact)
            }
        };
        let difference = exact.difference(&mine.memory, tolerance.per_channel);
        if let Some(page) = &self.page {
            let name = |path: &Path| path.display().to_string();
            let html = difference.page([&name(&self.mine), &name(&self.exact)]);
            let write = |out: &mut dyn std::io::Write| out.write_all(html.as_bytes());
            crate::save::replace(page, write).map_err(|e| e.to_string())?;
        }
        match self.json {
            true => output::print(format!("{}\n", difference.json())),
            false => output::print(difference.to_string()),
        }
        Ok(difference.size == difference.exact_size && difference.wrong <= tolerance.pixels)
    }
}

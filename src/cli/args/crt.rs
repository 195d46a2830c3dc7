//! `--crt`: the look of a cathode ray tube, in the window and, if asked, in files.

use crate::draw2d::crt::{Crt, picture_size};
use crate::memory::VideoMemory;
use crate::save::{self, SaveError};
use clap::Args;
use std::path::Path;

/// The argument of commands that write files, too.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(in crate::cli) struct CrtArgs {
    /// Show the frame as a cathode ray tube does, with scan lines, a phosphor mask and old modes at 4:3; K changes it (F8
    /// where a program takes the keys). =files: --snap, --movie and F12 have that look, too, three times as large
    #[arg(long, value_name = "WHERE", num_args = 0..=1, require_equals = true, default_missing_value = "window")]
    crt: Option<Place>,
}

/// Places that have the look.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Place {
    /// The window alone
    Window,
    /// The window and files
    Files,
}

impl CrtArgs {
    /// Returns whether the window begins with that look.
    #[cfg_attr(not(feature = "window"), expect(dead_code, reason = "there is no window"))]
    pub fn in_window(self) -> bool {
        self.crt.is_some()
    }

    /// Returns whether files have it.
    pub fn in_files(self) -> bool {
        self.crt == Some(Place::Files)
    }

    /// Returns the size of the pictures in files.
    pub fn size_in_files(self, [width, height]: [u32; 2]) -> [u32; 2] {
        match self.in_files() {
            true => picture_size([width as usize, height as usize]).map(|side| side as u32),
            false => [width, height],
        }
    }

    /// Writes a picture of the frame.
    pub fn save(self, memory: &VideoMemory, path: &Path) -> Result<(), String> {
        let written = |e: SaveError| e.to_string();
        match self.in_files() {
            true => {
                let picture = Crt::picture(memory).map_err(|e| format!("{}: {e}", path.display()))?;
                save::to_path(&picture, path).map_err(written)
            }
            false => save::to_path(memory, path).map_err(written),
        }
    }
}

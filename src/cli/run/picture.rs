//! The pictures of a run: `--snap` and `--expect`.

use super::super::args::crt::CrtArgs;
use super::super::check_picture;
use super::{Refusal, Run};
use crate::memory::VideoMemory;
use crate::save::golden::{self, Mode, Tolerance};
use std::path::PathBuf;

/// Pictures that are asked for.
#[derive(Debug)]
pub struct Pictures {
    snap: Option<PathBuf>,
    /// Look of the picture of `snap`; comparisons are of the frame itself.
    crt: CrtArgs,
    expect: Option<(PathBuf, Tolerance)>,
}

impl Pictures {
    /// Checks the arguments before anything is run.
    pub fn new(args: &Run) -> Result<Pictures, Refusal> {
        let refuse = |message: String| Refusal { status: 2, message };
        if let Some(snap) = &args.snap {
            check_picture(snap).map_err(refuse)?;
        }
        let tolerance = tolerance(&args.tolerance).ok_or_else(|| {
            refuse(format!("--tolerance: N or N,PIXELS is expected, N to 255, not {:?}", args.tolerance))
        })?;
        Ok(Pictures {
            snap: args.snap.clone(),
            crt: args.crt,
            expect: args.expect.clone().map(|path| (path, tolerance)),
        })
    }

    /// Returns whether any is asked for.
    pub fn are_wanted(&self) -> bool {
        self.snap.is_some() || self.expect.is_some()
    }

    /// Writes and compares the pictures. `None` if none is expected, else whether it is equal.
    ///
    /// # Errors
    /// The first picture that cannot be written.
    pub fn take(&self, memory: &VideoMemory) -> Result<Option<bool>, String> {
        if let Some(path) = &self.snap {
            self.crt.save(memory, path)?;
        }
        let Some((path, tolerance)) = &self.expect else { return Ok(None) };
        match golden::check(memory, path, *tolerance, Mode::from_env()) {
            Ok(()) => Ok(Some(true)),
            Err(error) => {
                super::say_as_program(error);
                Ok(Some(false))
            }
        }
    }
}

/// Parses `N` or `N,PIXELS`.
fn tolerance(text: &str) -> Option<Tolerance> {
    let (channel, pixels) = text.split_once(',').unwrap_or((text, "0"));
    Some(Tolerance { per_channel: channel.parse().ok()?, pixels: pixels.parse().ok()? })
}

//! The pictures of a run: `--snap` and `--expect`.

use super::super::args::crt::CrtArgs;
use super::super::check_picture;
use super::super::expect::Expected;
use super::super::render_args::RenderArgs;
use super::{Refusal, Run};
use crate::memory::VideoMemory;
use std::path::PathBuf;

/// Pictures that are asked for.
#[derive(Debug)]
pub struct Pictures {
    snap: Option<PathBuf>,
    /// Look of the picture of `snap`; comparisons are of the frame itself.
    crt: CrtArgs,
    expect: Option<Expected>,
}

impl Pictures {
    /// Checks the arguments before anything is run.
    pub fn new(args: &Run) -> Result<Pictures, Refusal> {
        let refuse = |message: String| Refusal { status: 2, message };
        if let Some(snap) = &args.snap {
            check_picture(snap).map_err(refuse)?;
        }
        Ok(Pictures {
            snap: args.snap.clone(),
            crt: args.crt,
            expect: args.expect.check(&RenderArgs::default()).map_err(refuse)?,
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
        Ok(self.expect.as_ref().map(|expected| expected.is_met_by(memory)))
    }
}

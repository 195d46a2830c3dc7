//! Reasons for which there is nothing to decide.

use fbptr_core::eye::EyeError;
use fbptr_core::memory::MemoryError;
use fbptr_core::pipeline::PipelineError;
use fbptr_core::scene::CameraError;
use std::fmt;

/// Reason why the settings of a picture cannot be compared.
#[derive(Clone, Debug, PartialEq)]
pub enum DecideError {
    /// The frame does not fit in memory.
    Memory(MemoryError),
    /// The pipeline refused the scene.
    Pipeline(PipelineError),
    /// The camera makes no picture.
    Camera(CameraError),
    /// The N-dimensional eye refused the scene.
    Eye(EyeError),
    /// A command of the stream was refused: its place and the reason.
    Stream(String),
    /// Nothing of it is seen, for this reason.
    Nothing(String),
}

impl fmt::Display for DecideError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DecideError::Memory(e) => write!(f, "{e}"),
            DecideError::Pipeline(e) => write!(f, "{e}"),
            DecideError::Camera(e) => write!(f, "{e}"),
            DecideError::Eye(e) => write!(f, "{e}"),
            DecideError::Stream(line) => f.write_str(line),
            DecideError::Nothing(why) => write!(f, "nothing to compare, the picture is empty: {why}"),
        }
    }
}

impl std::error::Error for DecideError {}

impl From<MemoryError> for DecideError {
    fn from(e: MemoryError) -> Self {
        DecideError::Memory(e)
    }
}

impl From<PipelineError> for DecideError {
    fn from(e: PipelineError) -> Self {
        DecideError::Pipeline(e)
    }
}

impl From<CameraError> for DecideError {
    fn from(e: CameraError) -> Self {
        DecideError::Camera(e)
    }
}

impl From<EyeError> for DecideError {
    fn from(e: EyeError) -> Self {
        DecideError::Eye(e)
    }
}

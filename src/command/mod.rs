//! WHAT MAY BE ASKED: the closed list of commands, and the codecs that read and write them.
//!
//! No I/O here: bytes come in as slices, commands go out as values. A typed [`Command`] is what the in-process handle
//! sends and what the decoder makes of a stream.

mod model;

pub use model::{
    AreaColors, Command, ErrorMode, FileKind, LightCommand, MeshSource, Quality, RampColor, Rect, Shears,
    SnapTarget,
};

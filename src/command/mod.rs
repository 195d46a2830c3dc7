//! WHAT MAY BE ASKED: the closed list of commands, and the codecs that read and write them.
//!
//! No I/O here: bytes come in as slices, commands go out as values. A typed [`Command`] is what the in-process handle
//! sends and what the decoder makes of a stream.

mod args;
mod check;
mod decoder;
mod encode;
mod help;
mod long_line;
mod model;
mod parse;
mod scan;
mod sink;
mod spare;
mod stream_error;
mod suggest;
mod table;
mod verb;

pub use crate::memory::{parse_color, parse_light_color};
pub use decoder::{Decoder, EndOfInput, Limits, MAX_LINE_BYTES};
pub use encode::{EncodeError, encode};
pub use help::help_text;
pub use model::{
    AreaColors, Command, ErrorMode, FileKind, LightCommand, MeshSource, Quality, RampColor, RealRect, Rect,
    Shears, SnapTarget,
};
pub use sink::{BINARY_PIXEL_BYTES, Flow, Place, Sink, binary_pixel};
pub use spare::SparePayload;
pub use stream_error::{
    StreamError, Subject, format_error, format_fault, format_play_error, format_play_fault,
};
pub use verb::{Counts, Form, Group, Payload, Verb};

//! The command language: the closed list of commands, and the codecs that read and write them.
//!
//! No I/O: bytes come in as slices, commands go out as values. A typed [`Command`] is both what the
//! in-process handle sends and what the decoder produces from a stream.
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod args;
mod arguments;
mod arity;
mod binary_pixels;
mod codec;
mod commands;
mod decoder;
mod encode;
#[cfg(test)]
pub(crate) mod example;
mod figure;
pub mod framebuffer;
mod help;
mod long_line;
mod methods;
mod payload_pool;
mod pixel_lexer;
mod plain_line;
mod scan;
mod sink;
mod stream_error;
mod suggest;
mod table;
mod validate;
mod verb;
mod verb_macros;

pub use arity::Arity;
pub use commands::{
    AreaColors, Command, ErrorMode, Figure, FileKind, LightCommand, MeshSource, Quality, RampColor, RealRect,
    Rect, Shears, SnapTarget,
};
#[doc(hidden)]
pub use decoder::BYTE_ORDER_MARK;
pub use decoder::{Decoder, EndOfInput, LentPayload, Limits};
pub use encode::{EncodeError, MAX_LINE_BYTES, encode};
pub use fbptr_core::memory::{color_names, parse_color, parse_light_color};
#[doc(hidden)]
pub use figure::DrawFigure;
pub use framebuffer::Framebuffer;
pub use help::{help_on, help_text};
pub(crate) use methods::each_figure;
pub use payload_pool::PayloadPool;
pub use sink::{BINARY_PIXEL_BYTES, Flow, Sink, binary_pixel};
pub use stream_error::{
    StreamError, StreamPosition, Subject, format_error, format_fault, format_play_error, format_play_fault,
};
#[doc(hidden)]
pub use suggest::nearest;
pub use verb::{Encoding, Form, Group, Parameter, ParameterKind, Payload, Reach, Reply, Verb};

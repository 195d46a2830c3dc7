//! THE RENDER THREAD, sessions, transports.

mod display;

pub use display::{Display, EventSender, Input, InputEvent, PixelInfo, ShownFrame};

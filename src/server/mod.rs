//! THE RENDER THREAD, sessions, transports.

mod display;
pub mod engine;
mod limits;
mod names;
mod session;
mod stats;
mod stream;

pub use display::{Display, EventSender, Input, InputEvent, PixelInfo, ShownFrame};
pub use engine::{Effect, Engine};
pub use limits::Limits;
pub use names::{Kind, Names, Resource};
pub use session::{Audience, Session};
pub use stats::Stats;
pub use stream::{Budget, Complaint, Output, Pace, Standing, Stream};

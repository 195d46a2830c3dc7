//! Video memory: the emulated framebuffer, byte pointers into it, and its depth and pick buffers.
//!
//! In: bytes and pixels from every drawing module. Out: bytes to the window, files and the network.
//! Only the render thread holds a `VideoMemory` mutably.
//!
//! Layout (Trabalho 1, "putPixel"): width x height pixels of four bytes R, G, B, A, row 0 at the
//! top, no padding, `offset = (width * y + x) * 4`.

mod aligned;
mod budget;
mod color;
mod color_names;
mod compositing;
mod depth;
#[cfg(target_os = "linux")]
mod device;
mod fbptr;
mod pending_clear;
mod pick_buffer;
mod shared;
mod video;

pub use budget::{MemoryBudget, MemoryUse, OverBudget, Reservation};
#[doc(hidden)]
pub use color::read_hex;
pub use color::{color_names, parse_color, parse_light_color};
pub use compositing::over;
pub(crate) use compositing::{blend, opaque};
pub(crate) use depth::DepthCells;
pub use depth::{DepthFormat, DepthMemory, DepthWords};
#[cfg(target_os = "linux")]
#[doc(hidden)]
pub use device::DeviceMemory;
pub use fbptr::FbPtr;
pub(crate) use pending_clear::{RowCells, STRIP_CELL, TILE_CELL};
pub use pick_buffer::PickBuffer;
pub(crate) use pick_buffer::{NO_FACE as NOT_PICKED, PickCells};
pub use shared::{SHARED_HEADER_BYTES, SHARED_MAGIC, SharedError, SharedFile};
pub use video::{MAX_SIDE, MemoryError, Rgba, VideoMemory};

//! The emulated framebuffer device of `fbptr run`: the program's side of it.
//!
//! In: what programs write into the device's memory and its control page, through the preload
//! library (`preload/`), which runs in their processes. Out: rows of video memory, on the render
//! thread; vertical blanks; input events as the kernel's devices give them. Promises: whatever a
//! program writes into the shared memories, nothing here panics or reads outside of them; nothing
//! is left of the device when this process has ended, however it ended. Tested by
//! `tests/serving/run/` with real programs.

#[path = "../../preload/attributes.rs"]
mod attributes;
mod device;
#[path = "../../preload/elf.rs"]
pub mod elf;
mod input;
#[path = "../../preload/keys.rs"]
pub mod keys;
// The preload library uses the rest of them.
#[path = "../../preload/layout.rs"]
#[allow(dead_code)]
mod layout;
#[path = "../../preload/mode.rs"]
#[allow(dead_code)]
mod mode;
mod scanout;
mod sysfs;

pub use device::{Device, DeviceOptions, GLUT_LIBRARY};
pub use input::{InputDevices, typing};
pub use layout::{ENVIRONMENT, OPENS_AT, TERMINALS};
pub use mode::{FORMATS, Format};
pub use scanout::ScanOut;

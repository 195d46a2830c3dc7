//! Windows: display of frames on the screen, and their keys. The only module that uses minifb and
//! its 0RGB words.
//!
//! In: the newest frame of a [`Display`](fbptr_server::Display), a file to view, or a program that
//! draws by itself ([`program`]), on the main thread (some systems allow windows nowhere else).
//! Out: user input.
//!
//! Promises: at a scale of 1 the screen shows the frame's R, G and B byte for byte; an unchanged
//! frame is not converted or uploaded again; no window size, key or pointer position causes a
//! panic.
//!
//! Losing the window system cannot be handled in every moment: Xlib exits the process. The window
//! of a render thread asks before each use of it (`presence`), and the commands of the program end
//! in order where that comes too late (`cli/main_thread.rs`).

#[cfg_attr(not(target_os = "linux"), path = "no_clicks.rs")]
mod clicks;
mod display_window;
mod frame_input;
#[cfg_attr(not(target_os = "linux"), path = "no_fullscreen.rs")]
mod fullscreen;
mod hud;
mod keys;
mod layout;
mod look;
mod overlay;
#[cfg_attr(not(target_os = "linux"), path = "no_presence.rs")]
mod presence;
pub mod program;
mod program_arguments;
mod scanout;
mod smooth;
mod status;
#[cfg_attr(not(target_os = "linux"), path = "no_upload.rs")]
mod upload;
mod view;
mod viewer;
#[cfg(target_os = "linux")]
mod x_window;

pub use display_window::{Options, run};
pub use frame_input::FrameInput;
pub use keys::{Action, BINDINGS, Binding, help_lines};
pub use layout::{Layout, Scaling};
pub use look::ScreenLook;
pub use scanout::{convert, word};
pub use status::ServerStatus;
pub use viewer::{ViewerOptions, run_viewer};

use fbptr_core::memory::MemoryError;
use fbptr_formats::save::SaveError;
use minifb::{InputCallback, Key, ScaleMode, WindowOptions};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::error::Error;
use std::fmt;
use std::rc::Rc;
use std::time::Duration;

/// Largest side of a window in pixels; some window systems abort on larger ones.
const MAX_WINDOW_SIDE: usize = 16_384;
/// Screen size that a new window must fit, in pixels.
const USUAL_SCREEN: [usize; 2] = [1280, 800];
/// Time between two looks at a display or a file.
const TICK: Duration = Duration::from_millis(8);

/// Error of opening a window.
#[derive(Debug)]
pub enum WindowError {
    /// The window system is not available: no display, no libraries.
    Unavailable(String),
    /// The frame is larger than a window can be.
    TooLarge {
        /// Width of the frame in pixels.
        width: u32,
        /// Height of the frame in pixels.
        height: u32,
    },
    /// The frame cannot be made.
    Frame(MemoryError),
    /// An argument of the program is malformed.
    Argument(String),
    /// The last frame cannot be saved.
    Snapshot(SaveError),
}

impl fmt::Display for WindowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            WindowError::Unavailable(reason) => write!(f, "no window: {reason}"),
            WindowError::TooLarge { width, height } => {
                write!(f, "no window: a {width}x{height} frame is larger ")?;
                write!(f, "than the {MAX_WINDOW_SIDE} pixels a side of a window")
            }
            WindowError::Frame(e) => write!(f, "{e}"),
            WindowError::Argument(reason) => f.write_str(reason),
            WindowError::Snapshot(e) => write!(f, "{e}"),
        }
    }
}

impl Error for WindowError {}

impl From<MemoryError> for WindowError {
    fn from(e: MemoryError) -> Self {
        WindowError::Frame(e)
    }
}

impl From<SaveError> for WindowError {
    fn from(e: SaveError) -> Self {
        WindowError::Snapshot(e)
    }
}

/// A keyboard report of the window system.
enum KeyReport {
    Key(Key, bool),
    Char(char),
}

/// Collects all keyboard reports in order, including taps shorter than a frame.
struct Collector(Rc<RefCell<VecDeque<KeyReport>>>);

impl InputCallback for Collector {
    fn add_char(&mut self, code: u32) {
        if let Some(c) = char::from_u32(code) {
            self.0.borrow_mut().push_back(KeyReport::Char(c));
        }
    }

    fn set_key_state(&mut self, key: Key, is_down: bool) {
        self.0.borrow_mut().push_back(KeyReport::Key(key, is_down));
    }
}

/// Opens a window whose contents are not scaled by minifb.
fn open(title: &str, size: [usize; 2]) -> Result<minifb::Window, WindowError> {
    let options =
        WindowOptions { resize: true, scale_mode: ScaleMode::UpperLeft, ..WindowOptions::default() };
    minifb::Window::new(title, size[0], size[1], options).map_err(|e| WindowError::Unavailable(e.to_string()))
}

/// Returns the steps of a wheel report. Some systems report fractions of a step, some tens: only
/// the sign counts.
fn wheel_steps((dx, dy): (f32, f32)) -> [i32; 2] {
    [dx, dy].map(|v| if v == 0.0 { 0 } else { v.signum() as i32 })
}

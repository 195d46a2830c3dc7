//! Windows: display of frames on the screen, and their keys. The only module that uses minifb and
//! its 0RGB words.
//!
//! In: the newest frame from the [`Display`], on the main thread (some systems allow windows
//! nowhere else). Out: user input, sent to the display.
//!
//! Promises: at a scale of 1 the screen shows the frame's R, G and B byte for byte; an unchanged
//! frame is not converted or uploaded again; no window size, key or pointer position causes a
//! panic.
//!
//! Losing the window system cannot be handled: Xlib exits the process. Snapshots are written when
//! requested, not at the end, and a server that must survive runs headless.

#[cfg_attr(not(target_os = "linux"), path = "no_clicks.rs")]
mod clicks;
#[cfg_attr(not(target_os = "linux"), path = "no_fullscreen.rs")]
mod fullscreen;
mod hud;
mod keys;
mod layout;
mod overlay;
mod scanout;
mod status;
mod view;
mod viewer;

pub use keys::{Action, BINDINGS, Binding, help_lines};
pub use layout::{Layout, Scaling};
pub use scanout::{convert, word};
pub use status::ServerStatus;
pub use viewer::{ViewerOptions, run_viewer};

use crate::server::{Display, EventSender, InputEvent};
use clicks::Clicks;
use fullscreen::Fullscreen;
use minifb::{InputCallback, Key, MouseButton, MouseMode, ScaleMode, WindowOptions};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;
use view::View;

/// Largest side of a window in pixels; some window systems abort on larger ones.
const MAX_WINDOW_SIDE: usize = 16_384;
/// Screen size that a new window must fit, in pixels.
const USUAL_SCREEN: [usize; 2] = [1280, 800];
/// Time between two polls of the display.
const TICK: Duration = Duration::from_millis(8);

/// Settings of a window.
#[derive(Clone, Debug)]
pub struct Options {
    /// Title of the window.
    pub title: String,
    /// Folder that F12 saves snapshots in.
    pub snapshot_dir: PathBuf,
    /// Window pixels for each frame pixel at the start; `None` selects the largest factor that fits
    /// a usual screen.
    pub scale: Option<usize>,
    /// Set to close the window when the stream has ended.
    pub close_at_end: bool,
    /// Set to open the window fullscreen.
    pub fullscreen: bool,
    /// Scaling of the frame.
    pub scaling: Scaling,
    /// Set to show the overlay of F3 from the start.
    pub shows_rates: bool,
    /// Addresses and counters of a server for that overlay, if there is one.
    pub server: Option<ServerStatus>,
}

impl Default for Options {
    fn default() -> Self {
        Options {
            title: "fbptr".into(),
            snapshot_dir: PathBuf::from("."),
            scale: None,
            close_at_end: false,
            fullscreen: false,
            scaling: Scaling::default(),
            shows_rates: false,
            server: None,
        }
    }
}

/// Error of opening a window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// The window system is not available: no display, no libraries.
    #[error("no window: {0}")]
    Unavailable(String),
    /// The frame is larger than a window can be.
    #[error(
        "no window: a {width}x{height} frame is larger than the {MAX_WINDOW_SIDE} pixels a side of a window"
    )]
    TooLarge {
        /// Width of the frame in pixels.
        width: u32,
        /// Height of the frame in pixels.
        height: u32,
    },
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

/// Shows `display` until the window is closed or the program ends. Must be called on the main
/// thread.
///
/// Returns at once, without a change to `display`, if no window can be opened.
pub fn run(display: Arc<Display>, options: Options) -> Result<(), WindowError> {
    let size = [display.width() as usize, display.height() as usize];
    if size.iter().any(|&s| s > MAX_WINDOW_SIDE) {
        return Err(WindowError::TooLarge { width: display.width(), height: display.height() });
    }
    let largest = (MAX_WINDOW_SIDE / size[0]).min(MAX_WINDOW_SIDE / size[1]);
    let scale = options.scale.unwrap_or_else(|| Layout::opening_scale(size, USUAL_SCREEN)).clamp(1, largest);
    let mut window = open(&options.title, size.map(|s| s * scale))?;
    window.set_target_fps(0);
    let reports = Rc::new(RefCell::new(VecDeque::new()));
    window.set_input_callback(Box::new(Collector(reports.clone())));
    let mut view = View::new(display.clone(), options.snapshot_dir);
    view.set_scaling(options.scaling);
    view.set_server(options.server, options.shows_rates);
    let mut fullscreen = Fullscreen::default();
    let mut toggles_fullscreen = options.fullscreen;
    let mut pointer = Pointer::new(display.event_sender(), Clicks::new(&window));
    while window.is_open() && !display.is_leaving() && !view.wants_to_quit() {
        let window_size = <[usize; 2]>::from(window.get_size());
        pointer.look(&window, &view.layout(window_size), window_size);
        view.set_pointer(window.get_unscaled_mouse_pos(MouseMode::Discard));
        let uploaded = match view.redraw(window_size) {
            Some(words) => window.update_with_buffer(words, window_size[0], window_size[1]).is_ok(),
            None => {
                window.update();
                false
            }
        };
        if uploaded {
            view.note_uploaded();
        }
        for report in reports.borrow_mut().drain(..) {
            match report {
                KeyReport::Key(key, is_down) => view.key(key, is_down),
                KeyReport::Char(c) => display.send(InputEvent::Text(c)),
            }
        }
        if std::mem::take(&mut toggles_fullscreen) || view.take_fullscreen_request() {
            fullscreen.toggle(&window).unwrap_or_else(|why| view.say(why));
        }
        if options.close_at_end && display.is_finished() && view.is_up_to_date() {
            break;
        }
        std::thread::sleep(TICK);
    }
    display.close();
    Ok(())
}

/// Opens a window whose contents are not scaled by minifb.
fn open(title: &str, size: [usize; 2]) -> Result<minifb::Window, WindowError> {
    let options =
        WindowOptions { resize: true, scale_mode: ScaleMode::UpperLeft, ..WindowOptions::default() };
    minifb::Window::new(title, size[0], size[1], options).map_err(|e| WindowError::Unavailable(e.to_string()))
}

/// Sends changes of mouse and window state as events.
struct Pointer {
    events: EventSender,
    clicks: Option<Clicks>,
    mouse: Option<(i32, i32, u8)>,
    window_size: Option<[usize; 2]>,
}

impl Pointer {
    fn new(events: EventSender, clicks: Option<Clicks>) -> Self {
        Pointer { events, clicks, mouse: None, window_size: None }
    }

    /// Polls mouse and window, and sends what changed.
    fn look(&mut self, window: &minifb::Window, layout: &Layout, window_size: [usize; 2]) {
        if self.window_size.replace(window_size).is_some_and(|last| last != window_size) {
            let [width, height] = window_size.map(|s| s as u32);
            self.events.send(InputEvent::Resize { width, height });
        }
        if let Some((x, y)) = window.get_unscaled_mouse_pos(MouseMode::Pass) {
            let buttons = [MouseButton::Left, MouseButton::Middle, MouseButton::Right];
            let held = (0..).zip(buttons).map(|(i, b)| (window.get_mouse_down(b) as u8) << i).sum();
            self.send_missed(layout, held);
            let [x, y] = layout.frame_coordinates(x, y);
            if self.mouse.replace((x, y, held)) != Some((x, y, held)) {
                self.events.send(InputEvent::Mouse { x, y, buttons: held });
            }
        }
        if let Some((dx, dy)) = window.get_scroll_wheel() {
            // Some systems report fractions of a step, some tens: only the sign counts.
            let step = |v: f32| if v == 0.0 { 0 } else { v.signum() as i32 };
            self.events.send(InputEvent::Wheel { dx: step(dx), dy: step(dy) });
        }
    }

    /// Sends the presses that the button state has not shown, each with its release.
    fn send_missed(&mut self, layout: &Layout, held: u8) {
        let before = self.mouse.map_or(0, |(_, _, held)| held);
        let Some(clicks) = &mut self.clicks else { return };
        let Some(([x, y], missed)) = clicks.missed(before, held) else { return };
        let [x, y] = layout.frame_coordinates(x, y);
        for (button, count) in missed.into_iter().enumerate() {
            for buttons in std::iter::repeat_n([held | 1 << button, held], count as usize).flatten() {
                self.events.send(InputEvent::Mouse { x, y, buttons });
            }
        }
        self.mouse = Some((x, y, held));
    }
}

//! PIXELS OUT to the screen: the minifb window and its keys. The only room that knows minifb and its 0RGB words.
//!
//! In: the newest frame from the [`Display`], on the main thread (some systems allow windows nowhere else). Out: what the
//! user does, to the display. Promises: at a scale of 1 the screen holds the frame's R, G and B byte for byte; a frame that
//! did not change is not converted or uploaded again; no size of the window, no key and no pointer position panics.
//!
//! What cannot be caught: the window system going away ends the process (Xlib exits it). Snapshots are written when
//! asked for, not at the end, and a server that must survive runs headless.

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

/// Larger windows than this many pixels a side make some window systems abort.
const MAX_WINDOW_SIDE: usize = 16_384;
/// The size of screen that an opening window is made for.
const USUAL_SCREEN: [usize; 2] = [1280, 800];
/// Between two looks at the display.
const TICK: Duration = Duration::from_millis(8);

/// How the window is opened.
#[derive(Clone, Debug)]
pub struct Options {
    /// Its title.
    pub title: String,
    /// Where F12 saves.
    pub snapshot_dir: PathBuf,
    /// Window pixels a frame pixel at the start; `None` takes what fits a usual screen.
    pub scale: Option<usize>,
    /// Whether the window closes by itself when the stream has ended.
    pub close_at_end: bool,
    /// Whether it opens over the whole screen.
    pub fullscreen: bool,
    /// How the frame is enlarged.
    pub scaling: Scaling,
    /// Whether the overlay of F3 is shown from the start.
    pub shows_rates: bool,
    /// A server's addresses and counters for that overlay.
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

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// The window system refused: no display, no libraries.
    #[error("no window: {0}")]
    Unavailable(String),
    /// The frame is larger than a window can be.
    #[error(
        "no window: a {width}x{height} frame is larger than the {MAX_WINDOW_SIDE} pixels a side of a window"
    )]
    TooLarge {
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
}

/// What the window system reported since the last look, in order.
enum KeyReport {
    Key(Key, bool),
    Char(char),
}

/// Collects every key, taps shorter than a frame included.
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

/// Shows `display` until its user closes the window or the program ends. Call it on the main thread.
///
/// Where there is no window to be had it returns at once, having changed nothing.
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

fn open(title: &str, size: [usize; 2]) -> Result<minifb::Window, WindowError> {
    let options =
        WindowOptions { resize: true, scale_mode: ScaleMode::UpperLeft, ..WindowOptions::default() };
    minifb::Window::new(title, size[0], size[1], options).map_err(|e| WindowError::Unavailable(e.to_string()))
}

/// Turns the state of mouse and window into events, when it changes.
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
            // Some systems report fractions of a step, some tens: a step is a step.
            let step = |v: f32| if v == 0.0 { 0 } else { v.signum() as i32 };
            self.events.send(InputEvent::Wheel { dx: step(dx), dy: step(dy) });
        }
    }

    /// Sends the presses that the state of the buttons has not shown, each with its release.
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

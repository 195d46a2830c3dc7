//! The window of a render thread: shows the frames of a [`Display`], and sends it the user's input.
//!
//! In: the display's newest frame. Out: [`InputEvent`]s. Runs on the main thread.

use super::clicks::Clicks;
use super::fullscreen::Fullscreen;
use super::layout::{Layout, Scaling};
use super::look::ScreenLook;
use super::presence::Presence;
use super::status::ServerStatus;
use super::upload::Upload;
use super::view::{Redrawn, View};
use super::{Collector, KeyReport, MAX_WINDOW_SIDE, TICK, USUAL_SCREEN, WindowError, open, wheel_steps};
use fbptr_core::input::InputEvent;
use fbptr_server::{Display, EventSender};
use minifb::{MouseButton, MouseMode};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::PathBuf;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

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
    /// Set to show the frame as a cathode ray tube does; K changes it.
    pub crt: bool,
    /// Set to save snapshots with that look, too.
    pub saves_crt: bool,
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
            crt: false,
            saves_crt: false,
            shows_rates: false,
            server: None,
        }
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
    let look = ScreenLook::new(options.crt);
    let natural = look.natural_size(size);
    let largest = (MAX_WINDOW_SIDE / natural[0]).min(MAX_WINDOW_SIDE / natural[1]);
    let scale = options.scale.unwrap_or_else(|| look.opening_scale(size, USUAL_SCREEN)).clamp(1, largest);
    let mut window = open(&options.title, natural.map(|s| s * scale))?;
    window.set_target_fps(0);
    let reports = Rc::new(RefCell::new(VecDeque::new()));
    window.set_input_callback(Box::new(Collector(reports.clone())));
    let mut view = View::new(display.clone(), options.snapshot_dir);
    view.set_scaling(options.scaling);
    view.set_look(look, options.saves_crt);
    view.set_server(options.server, options.shows_rates);
    let mut fullscreen = Fullscreen::default();
    let mut toggles_fullscreen = options.fullscreen;
    let mut pointer = Pointer::new(display.event_sender(), Clicks::new(&window));
    let mut presence = Presence::new(&window);
    let mut upload = Upload::new(&window);
    while window.is_open() && !display.is_leaving() && !view.wants_to_quit() {
        let begun = Instant::now();
        if presence.is_lost() {
            break;
        }
        let window_size = <[usize; 2]>::from(window.get_size());
        pointer.look(&window, &view.layout(window_size), window_size);
        view.set_pointer(window.get_unscaled_mouse_pos(MouseMode::Discard));
        if let Some(title) = display.take_title() {
            window.set_title(&title);
        }
        let redrawn = view.redraw(window_size);
        // Converting a frame takes long enough to be destroyed in.
        if presence.is_lost() {
            break;
        }
        match redrawn {
            None => upload.idle(&mut window),
            Some(Redrawn { words, rows }) => match upload.show(&mut window, words, window_size, rows) {
                true => view.note_uploaded(),
                false => view.redraw_all(),
            },
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
        std::thread::sleep(TICK.saturating_sub(begun.elapsed()));
    }
    if presence.is_lost() {
        // Its end would ask Xlib to destroy it once more, which ends the process.
        std::mem::forget(window);
    }
    display.close();
    Ok(())
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
        if let Some(wheel) = window.get_scroll_wheel() {
            let [dx, dy] = wheel_steps(wheel);
            self.events.send(InputEvent::Wheel { dx, dy });
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

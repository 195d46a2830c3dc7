//! Contents of the window: the frame with its overlays, redrawn only when something changed.
//!
//! Uses no window system: keys and pointer positions come in, words go out, so all of it is tested
//! without a screen.

use super::frame_input::key_name;
use super::keys::{self, Action};
use super::layout::{Layout, Scaling};
use super::look::ScreenLook;
use super::overlay::{self, Canvas, Corner};
use super::status::ServerStatus;
use fbptr_core::draw2d::crt::Crt;
use fbptr_core::input::InputEvent;
use fbptr_core::memory::VideoMemory;
use fbptr_server::{Display, ShownFrame};
use minifb::Key;
use std::collections::HashSet;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time for which a message is shown.
const MESSAGE_TIME: Duration = Duration::from_secs(3);

/// State of a window.
pub struct View {
    display: Arc<Display>,
    frame: ShownFrame,
    words: Vec<u32>,
    /// Layout and look of the words.
    layout: Option<(Layout, bool)>,
    snapshot_dir: PathBuf,
    pointer: Option<(f32, f32)>,
    keys_down: HashSet<Key>,
    shows_help: bool,
    shows_rate: bool,
    inspects: bool,
    quit: bool,
    wants_fullscreen: bool,
    scaling: Scaling,
    look: ScreenLook,
    /// True if snapshots have the look of a tube.
    saves_crt: bool,
    server: Option<ServerStatus>,
    message: Option<(String, Instant)>,
    rate: FrameRate,
    /// Lines of the overlay drawn into `words`.
    drawn_lines: Vec<String>,
    /// True once any pixel was not black: until then a server's window says how to draw.
    was_drawn: bool,
    /// Corner of the overlay.
    corner: Option<Corner>,
    is_uploaded: bool,
}

/// The window's words, and the rows of them that changed.
pub struct Redrawn<'a> {
    pub words: &'a [u32],
    pub rows: Range<usize>,
}

/// Frame rate measurement: frames shown since a time, and the last measured rate.
struct FrameRate {
    since: Instant,
    frames: u32,
    per_second: f64,
}

impl View {
    pub fn new(display: Arc<Display>, snapshot_dir: PathBuf) -> Self {
        View {
            display,
            frame: ShownFrame::default(),
            words: Vec::new(),
            layout: None,
            snapshot_dir,
            pointer: None,
            keys_down: HashSet::new(),
            shows_help: false,
            shows_rate: false,
            inspects: false,
            quit: false,
            wants_fullscreen: false,
            scaling: Scaling::default(),
            look: ScreenLook::default(),
            saves_crt: false,
            server: None,
            message: None,
            rate: FrameRate { since: Instant::now(), frames: 0, per_second: 0.0 },
            drawn_lines: Vec::new(),
            was_drawn: false,
            corner: None,
            is_uploaded: false,
        }
    }

    pub fn wants_to_quit(&self) -> bool {
        self.quit
    }

    pub fn set_scaling(&mut self, scaling: Scaling) {
        self.scaling = scaling;
    }

    /// Sets the look of the frame, and whether snapshots have the look of a tube.
    pub fn set_look(&mut self, look: ScreenLook, saves_crt: bool) {
        (self.look, self.saves_crt) = (look, saves_crt);
    }

    /// Sets the server, if any, whose status the overlay of F3 shows, and whether that overlay is
    /// shown.
    pub fn set_server(&mut self, server: Option<ServerStatus>, shows_rates: bool) {
        (self.server, self.shows_rate) = (server, shows_rates);
    }

    /// Returns whether F11 was pressed since the last call.
    pub fn take_fullscreen_request(&mut self) -> bool {
        std::mem::take(&mut self.wants_fullscreen)
    }

    /// Returns the layout of the frame in a window of this size.
    pub fn layout(&self, window_size: [usize; 2]) -> Layout {
        let frame = [self.display.width() as usize, self.display.height() as usize];
        self.look.layout(frame, window_size, self.scaling)
    }

    /// Sets the pointer's position in window pixels; `None` outside the window.
    pub fn set_pointer(&mut self, at: Option<(f32, f32)>) {
        self.pointer = at;
    }

    /// Returns whether the newest frame is on the screen.
    pub fn is_up_to_date(&mut self) -> bool {
        self.is_uploaded && self.display.copy_changes(self.frame.version, &mut self.frame.clone()).is_none()
    }

    /// Records that the words were uploaded to the screen.
    pub fn note_uploaded(&mut self) {
        self.is_uploaded = true;
        self.display.note_shown(self.frame.frame);
    }

    /// Makes the next call of [`redraw`](View::redraw) return the whole window.
    pub fn redraw_all(&mut self) {
        self.layout = None;
    }

    /// Handles a key press or release.
    pub fn key(&mut self, key: Key, is_down: bool) {
        let is_repeat = match is_down {
            true => !self.keys_down.insert(key),
            false => {
                self.keys_down.remove(&key);
                false
            }
        };
        if !is_repeat {
            self.display.send(InputEvent::Key { name: key_name(key), down: is_down });
        }
        let Some(binding) = keys::binding(key).filter(|b| is_down && (b.repeats || !is_repeat)) else {
            return;
        };
        // While clients listen to keys, only Esc and the F keys act on the window.
        if binding.is_kept() || !self.display.has_listeners() {
            self.act(binding.action);
        }
    }

    fn act(&mut self, action: Action) {
        match action {
            Action::Quit => self.quit = true,
            Action::Snapshot => self.snapshot(),
            Action::Pause => self.display.set_paused(!self.display.is_paused()),
            Action::Step => {
                if self.display.is_paused() {
                    self.display.step();
                }
            }
            Action::Help => self.shows_help = !self.shows_help,
            Action::FrameRate => self.shows_rate = !self.shows_rate,
            Action::Fullscreen => self.wants_fullscreen = true,
            Action::Scaling => self.scaling = self.scaling.next(),
            Action::Inspect => self.inspects = !self.inspects,
            Action::Crt => drop(self.look.set_crt(!self.look.is_crt())),
        }
    }

    /// Shows a message for a few seconds.
    pub fn say(&mut self, text: String) {
        self.message = Some((text, Instant::now()));
    }

    /// Saves the shown frame, without overlays, under the first free name.
    fn snapshot(&mut self) {
        self.update_frame();
        let free =
            (1..10_000).map(|i| self.snapshot_dir.join(format!("fbptr-{i:04}.png"))).find(|p| !p.exists());
        let Some(path) = free else { return self.say("no free snapshot name".into()) };
        let saved = VideoMemory::new(self.frame.width, self.frame.height)
            .map_err(|e| e.to_string())
            .and_then(|mut memory| {
                memory.bytes_mut().copy_from_slice(&self.frame.bytes);
                if self.saves_crt {
                    memory = Crt::picture(&memory).map_err(|e| e.to_string())?;
                }
                fbptr_formats::save::to_path(&memory, &path).map_err(|e| e.to_string())
            });
        let text = match saved {
            Ok(_) => format!("saved {}", path.display()),
            Err(e) => format!("not saved: {e}"),
        };
        eprintln!("fbptr: {text}");
        self.say(text);
    }

    /// Copies the changes of the frame. Returns the changed rows, if there is a new version.
    fn update_frame(&mut self) -> Option<Range<usize>> {
        let rows = self.display.copy_changes(self.frame.version, &mut self.frame)?;
        self.rate.frames += 1;
        let rows = rows.start as usize..rows.end as usize;
        if !self.was_drawn {
            let stride = self.frame.width as usize * 4;
            let changed = self.frame.bytes.get(rows.start * stride..rows.end * stride).unwrap_or(&[]);
            self.was_drawn = changed.as_chunks::<4>().0.iter().any(|p| p[..3] != [0; 3]);
        }
        Some(rows)
    }

    /// Returns the window's words and their changed rows, if any changed since the last call; `None`
    /// if the screen is up to date.
    pub fn redraw(&mut self, window_size: [usize; 2]) -> Option<Redrawn<'_>> {
        if window_size.contains(&0) {
            return None;
        }
        let layout = self.layout(window_size);
        let rows = self.update_frame();
        let mut lines = self.overlay_lines(&layout);
        let welcome = self.welcome_lines();
        // The welcome is drawn elsewhere, but with the other lines it decides what is out of date.
        let others = lines.len();
        lines.extend(welcome.iter().cloned());
        let shown = (layout, self.look.is_crt());
        let is_new_layout = self.layout.replace(shown) != Some(shown);
        if is_new_layout {
            self.words.clear();
            self.words.resize(window_size[0] * window_size[1], 0);
        }
        // Overlays are drawn into the words: if there were or are any, the entire frame is
        // converted again.
        let is_whole = is_new_layout || lines != self.drawn_lines;
        let rows = match (rows, is_whole, lines.is_empty()) {
            (None, false, _) => return None,
            (_, true, _) | (Some(_), _, false) => {
                self.words.fill(0);
                0..layout.frame[1]
            }
            (Some(rows), false, true) if rows.is_empty() => {
                // Only the frame number changed: nothing to upload, but the frame counts as shown.
                self.display.note_shown(self.frame.frame);
                return None;
            }
            (Some(rows), false, true) => rows,
        };
        let changed = match is_whole || !lines.is_empty() || layout.is_smooth || self.look.is_crt() {
            true => 0..window_size[1],
            false => layout.window_rows(rows.clone()),
        };
        self.look.convert(&self.frame.bytes, &layout, rows, &mut self.words);
        if !lines.is_empty() {
            let mut canvas = Canvas { words: &mut self.words, width: window_size[0], height: window_size[1] };
            overlay::draw_middle(&mut canvas, &welcome);
        }
        if others > 0 {
            let mut canvas = Canvas { words: &mut self.words, width: window_size[0], height: window_size[1] };
            let lines = &lines[..others];
            let fits = |scale| overlay::box_size(lines, scale)[0] + 8 <= window_size[0];
            let scale = if window_size[1] >= 480 && fits(2) { 2 } else { 1 };
            let size = overlay::box_size(lines, scale);
            let corner = Corner::choose(self.corner, &Corner::ALL, &canvas, size);
            self.corner = Some(corner);
            overlay::draw_box(&mut canvas, corner.place(window_size, size), lines, scale);
        }
        self.drawn_lines = lines;
        self.is_uploaded = false;
        Some(Redrawn { words: &self.words, rows: changed })
    }

    /// Returns what a server's window says while nothing was drawn.
    fn welcome_lines(&self) -> Vec<String> {
        match &self.server {
            Some(server) if !self.was_drawn => server.welcome(),
            _ => Vec::new(),
        }
    }

    /// Returns the current lines of the overlay, and updates the frame rate.
    fn overlay_lines(&mut self, layout: &Layout) -> Vec<String> {
        let mut lines = Vec::new();
        if self.shows_help {
            lines.extend(keys::help_lines(self.display.has_listeners(), self.display.is_paused()));
        }
        let elapsed = self.rate.since.elapsed();
        if elapsed >= Duration::from_millis(500) {
            self.rate.per_second = self.rate.frames as f64 / elapsed.as_secs_f64();
            (self.rate.frames, self.rate.since) = (0, Instant::now());
        }
        if self.shows_rate {
            lines.extend(self.server.iter_mut().flat_map(ServerStatus::lines));
            lines.push(format!("{:.1} frames/s", self.rate.per_second));
        }
        if self.inspects {
            lines.push(self.inspection(layout).unwrap_or_else(|| "pointer off the frame".into()));
        }
        if self.display.is_paused() {
            lines.push("paused: . is one step, space goes on".into());
        }
        if self.message.as_ref().is_some_and(|(_, at)| at.elapsed() > MESSAGE_TIME) {
            self.message = None;
        }
        lines.extend(self.message.as_ref().map(|(text, _)| text.clone()));
        lines
    }

    /// Returns the line about the pixel under the pointer, if it is on the frame.
    fn inspection(&self, layout: &Layout) -> Option<String> {
        let (x, y) = self.pointer?;
        let [x, y] = layout.pixel_at(x, y)?;
        let info = self.display.pixel_info(x as i32, y as i32)?;
        let [r, g, b, a] = info.rgba;
        let depth = info.depth.map_or_else(|| "-".into(), |z| format!("{z:.6}"));
        Some(format!("x {x} y {y} {} R {r} G {g} B {b} A {a} depth {depth}", info.offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view_of(memory: &VideoMemory) -> (Arc<Display>, View) {
        let display = Display::new(memory.width(), memory.height());
        display.publish(memory, 0..memory.height(), 1, None);
        (display.clone(), View::new(display, std::env::temp_dir()))
    }

    #[test]
    fn an_unchanged_frame_is_uploaded_once() {
        let mut memory = VideoMemory::new(6, 4).unwrap();
        memory.put_pixel(2, 1, [1, 2, 3, 255]);
        let (display, mut view) = view_of(&memory);
        let words = view.redraw([6, 4]).expect("the first look draws").words.to_vec();
        assert_eq!(words[6 + 2], 0x0001_0203);
        view.note_uploaded();
        assert_eq!(display.frame_on_screen(), 1);
        assert!(view.redraw([6, 4]).is_none() && view.is_up_to_date());
        memory.put_pixel(5, 3, [9, 9, 9, 0]);
        display.publish(&memory, 3..4, 2, None);
        assert_eq!(view.redraw([6, 4]).expect("changed").words[23], 0x0009_0909);
        display.publish(&memory, 0..0, 3, None);
        assert!(view.redraw([6, 4]).is_none());
        assert_eq!(display.frame_on_screen(), 3, "an unchanged frame counts as shown");
        assert!(view.redraw([12, 8]).is_some(), "a new size is drawn anew");
        assert!(view.redraw([0, 8]).is_none());
    }

    #[test]
    fn overlays_come_and_go_without_a_trace() {
        let (_, mut view) = view_of(&VideoMemory::new(300, 200).unwrap());
        let plain = view.redraw([300, 200]).expect("first").words.to_vec();
        for key in [Key::F1, Key::I, Key::F3] {
            view.set_pointer(Some((10.0, 10.0)));
            view.key(key, true);
            assert_ne!(view.redraw([300, 200]).expect("overlay on").words, plain, "{key:?}");
            view.key(key, true);
            assert!(view.redraw([300, 200]).is_none(), "a held key does not toggle again");
            view.key(key, false);
            view.key(key, true);
            view.key(key, false);
            assert_eq!(view.redraw([300, 200]).expect("overlay off").words, plain, "{key:?}");
        }
    }

    #[test]
    fn a_servers_window_says_how_to_draw_until_something_is_drawn() {
        let mut memory = VideoMemory::new(480, 320).unwrap();
        let (display, mut view) = view_of(&memory);
        let plain = view.redraw([480, 320]).expect("first").words.to_vec();
        let board = fbptr_server::MetricsBoard::new();
        view.set_server(Some(ServerStatus::new(vec!["tcp 127.0.0.1:1337".into()], board)), false);
        assert_ne!(view.redraw([480, 320]).expect("the welcome").words, plain);
        assert_eq!(view.frame.bytes, memory.bytes(), "nothing of it is in the frame");
        view.key(Key::F1, true);
        view.redraw([480, 320]).expect("the welcome and the keys");
        view.key(Key::F1, false);
        view.key(Key::F1, true);
        memory.put_pixel(3, 3, [0, 0, 200, 255]);
        display.publish(&memory, 3..4, 2, None);
        let drawn = view.redraw([480, 320]).expect("drawn").words.to_vec();
        assert_eq!(drawn.iter().filter(|w| **w != 0).count(), 1, "the pixel alone");
        memory.put_pixel(3, 3, [0, 0, 0, 255]);
        display.publish(&memory, 3..4, 3, None);
        assert_eq!(view.redraw([480, 320]).expect("black").words, plain, "it does not come back");
    }

    #[test]
    fn the_rows_that_changed_are_enough_to_keep_a_screen_up_to_date() {
        let mut memory = VideoMemory::new(40, 30).unwrap();
        let (display, mut view) = view_of(&memory);
        let (mut screen, mut uploaded, mut whole) = (Vec::new(), 0, 0);
        let sizes = [[40, 30], [90, 70], [90, 70], [31, 17], [320, 240]];
        for turn in 0u64..400 {
            let size = sizes[(turn / 80) as usize];
            if turn % 20 == 7 {
                let key = [Key::F10, Key::F3, Key::F3, Key::K, Key::K][(turn / 20 % 5) as usize];
                view.key(key, true);
                view.key(key, false);
            }
            let row = (turn * 7 % 30) as u32;
            memory.put_pixel((turn % 40) as i32, row as i32, [turn as u8, 255, 3, 255]);
            display.publish(&memory, row..row + 1, turn + 2, None);
            let Some(Redrawn { words, rows }) = view.redraw(size) else { continue };
            screen.resize(words.len(), 0);
            let of_rows = rows.start * size[0]..rows.end * size[0];
            screen[of_rows.clone()].copy_from_slice(&words[of_rows]);
            assert!(screen == words, "turn {turn}");
            (uploaded, whole) = (uploaded + rows.len(), whole + size[1]);
        }
        assert!(uploaded * 4 < whole * 3, "{uploaded} of {whole} rows");
    }

    #[test]
    fn the_look_of_a_tube_comes_and_goes_by_k_and_snapshots_have_it_only_if_asked() {
        let mut memory = VideoMemory::new(30, 20).unwrap();
        memory.clear([200, 100, 50, 255]);
        let (display, mut view) = view_of(&memory);
        let folder = std::env::temp_dir().join(format!("fbptr-view-crt-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        view.snapshot_dir = folder.clone();
        let size = [120, 80];
        let press = |view: &mut View, key| {
            view.key(key, true);
            view.key(key, false);
        };
        let plain = view.redraw(size).expect("first").words.to_vec();
        press(&mut view, Key::K);
        let crt = view.redraw(size).expect("another look").words.to_vec();
        assert!(crt != plain && view.redraw(size).is_none());
        view.snapshot();
        let saved = |number: u32| {
            let path = folder.join(format!("fbptr-{number:04}.png"));
            fbptr_formats::save::golden::read_png(&path).unwrap()
        };
        assert_eq!(saved(1).bytes(), memory.bytes(), "no look of a tube in a file");
        view.set_look(ScreenLook::new(true), true);
        view.snapshot();
        assert_eq!(saved(2).bytes(), Crt::picture(&memory).unwrap().bytes());
        std::fs::remove_dir_all(&folder).unwrap();
        view.message = None;
        display.set_listeners(1);
        press(&mut view, Key::K);
        assert!(view.look.is_crt(), "the key is the clients'");
        press(&mut view, Key::F8);
        assert_eq!(view.redraw(size).expect("the look as before").words, plain);
    }

    #[test]
    fn keys_do_what_the_table_says_and_clients_that_listen_get_letters() {
        let (display, mut view) = view_of(&VideoMemory::new(8, 8).unwrap());
        view.key(Key::Period, true);
        assert!(!display.take_step(), "a running stream has no steps");
        view.key(Key::Space, true);
        assert!(display.is_paused());
        view.key(Key::Period, true);
        view.key(Key::Period, true);
        assert!(display.take_step() && display.take_step() && !display.take_step());
        display.set_listeners(1);
        view.key(Key::Q, true);
        assert!(!view.wants_to_quit());
        view.key(Key::Escape, true);
        assert!(view.wants_to_quit());
        assert_eq!((key_name(Key::Key7), key_name(Key::Left)), ("7".into(), "left".into()));
    }
}

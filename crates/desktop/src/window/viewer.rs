//! Window of the viewer: a loop that passes keys, pointer and time to a [`Viewer`], and shows its
//! picture.
//!
//! Runs on the main thread. Files are written here, in the requested folder: PNG by F12, GIF by F9,
//! views by J. All input since the last iteration is handled in order before the next picture is
//! drawn, so no tap is lost however long a picture takes.

use super::fullscreen::Fullscreen;
use super::hud::{self, ListPanel};
use super::layout::Scaling;
use super::look::ScreenLook;
use super::overlay::{Canvas, Corner};
use super::upload::Upload;
use super::{Collector, KeyReport, Layout, MAX_WINDOW_SIDE, USUAL_SCREEN, WindowError, open};
use crate::viewer::{Key, Model, Overlay, Request, Viewer};
use fbptr_formats::save::{self, Movie};
use minifb::{MouseButton, MouseMode};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Frames per second of a GIF recorded by F9.
const GIF_RATE: f64 = 25.0;
/// Time between two looks at keys and clock: a fraction of a frame at 60 frames a second.
const VIEWER_TICK: Duration = Duration::from_millis(3);
/// Time between two checks of the file.
const WATCH_EVERY: Duration = Duration::from_millis(250);

/// A follower of the pictures.
type OnPicture<'a> = dyn FnMut(&mut Viewer, bool) -> bool + 'a;

/// Settings of the viewer's window.
pub struct ViewerOptions<'a> {
    /// Title of the window.
    pub title: String,
    /// Set to show the picture as a cathode ray tube does; K changes it.
    pub crt: bool,
    /// Set to scale a frame as large as the window smoothly from the start; F10 changes it.
    pub is_smooth: bool,
    /// Folder that F9, F12 and J save in.
    pub save_dir: PathBuf,
    /// Movie of all that is shown, from the start, and its frames per second.
    pub movie: Option<(Movie, f64)>,
    /// Time after which the window closes by itself.
    pub ends_after: Option<Duration>,
    /// Called with each picture, and whether it is new. Returns whether the window is to close.
    pub on_picture: Box<OnPicture<'a>>,
    /// Returns the file's new contents if it has changed since the last call, or an error if they
    /// cannot be read.
    pub reload: Box<dyn FnMut() -> Option<Result<Model, String>> + 'a>,
}

/// A movie and the time at which it began.
struct Recording {
    movie: Movie,
    rate: f64,
    begun: Instant,
}

impl Recording {
    fn new(movie: Movie, rate: f64) -> Self {
        Recording { movie, rate, begun: Instant::now() }
    }

    /// Adds the frames that are due.
    fn tick(&mut self, memory: &fbptr_core::memory::VideoMemory) -> Result<(), save::SaveError> {
        let due = (self.begun.elapsed().as_secs_f64() * self.rate) as u64 + 1;
        while self.movie.frames() < due {
            self.movie.push(memory)?;
        }
        Ok(())
    }
}

/// Shows `viewer` until the window is closed. Must be called on the main thread.
///
/// # Errors
/// Fails if no window can be opened; `viewer` is unchanged then.
pub fn run_viewer(viewer: &mut Viewer, options: &mut ViewerOptions<'_>) -> Result<(), WindowError> {
    let frame = [viewer.shown().width() as usize, viewer.shown().height() as usize];
    if frame.iter().any(|&s| s > MAX_WINDOW_SIDE) {
        return Err(WindowError::TooLarge { width: frame[0] as u32, height: frame[1] as u32 });
    }
    let natural = ScreenLook::new(options.crt).natural_size(frame);
    let scale = Layout::opening_scale(natural, USUAL_SCREEN);
    let mut window = open(&options.title, natural.map(|s| s * scale))?;
    window.set_target_fps(0);
    let reports = Rc::new(RefCell::new(VecDeque::new()));
    window.set_input_callback(Box::new(Collector(reports.clone())));
    let mut movie = options.movie.take().map(|(movie, rate)| Recording::new(movie, rate));
    let mut gif: Option<Recording> = None;
    let mut screen = FrameOnScreen::new(frame, options.crt);
    if options.is_smooth && scale == 1 {
        screen.scaling = Scaling::Smooth;
    }
    let (mut fullscreen, mut upload) = (Fullscreen::default(), Upload::new(&window));
    let (begun, mut last, mut watched) = (Instant::now(), Instant::now(), Instant::now());
    while window.is_open() && options.ends_after.is_none_or(|time| begun.elapsed() < time) {
        let size = <[usize; 2]>::from(window.get_size());
        look_at_pointer(viewer, &window, &screen.layout(size));
        if watched.elapsed() >= WATCH_EVERY {
            watched = Instant::now();
            match (options.reload)() {
                Some(Ok(model)) => viewer.reload(model),
                Some(Err(message)) => {
                    eprintln!("fbptr: {message}");
                    viewer.say(message);
                }
                None => {}
            }
        }
        let now = Instant::now();
        viewer.advance(now - std::mem::replace(&mut last, now));
        let is_new = viewer.refresh();
        match screen.redraw(viewer, size, is_new) {
            Some(words) if upload.show(&mut window, words, size, 0..size[1]) => {}
            Some(_) => screen.redraw_all(),
            None => upload.idle(&mut window),
        }
        let mut quits = (options.on_picture)(viewer, is_new);
        for report in reports.borrow_mut().drain(..) {
            let KeyReport::Key(key, is_down) = report else { continue };
            match translate(key).and_then(|key| viewer.key(key, is_down)) {
                Some(Request::Quit) => quits = true,
                Some(Request::Fullscreen) => match fullscreen.toggle(&window) {
                    Ok(()) => screen.fill_screen(),
                    Err(why) => viewer.say(why),
                },
                Some(Request::Scaling) => screen.toggle_scaling(),
                Some(Request::Crt) => screen.toggle_crt(),
                Some(Request::Record) => toggle_gif(viewer, &mut gif, &options.save_dir),
                Some(request) => serve(viewer, request, &options.save_dir),
                None => {}
            }
        }
        for recording in [&mut movie, &mut gif] {
            if let Some(Err(e)) = recording.as_mut().map(|r| r.tick(viewer.shown())) {
                *recording = None;
                tell(viewer, format!("the recording ends early: {e}"));
            }
        }
        viewer.set_recording(gif.is_some());
        if quits {
            break;
        }
        // A picture at rest becomes smoother at once.
        if !viewer.has_more_to_smooth() {
            let to_frame = viewer.time_to_next_frame().map(|time| time.saturating_sub(last.elapsed()));
            std::thread::sleep(to_frame.map_or(VIEWER_TICK, |time| time.min(VIEWER_TICK)));
        }
    }
    Ok(())
}

/// The window's words and the state they were drawn from.
struct FrameOnScreen {
    frame: [usize; 2],
    words: Vec<u32>,
    size: [usize; 2],
    scaling: Scaling,
    look: ScreenLook,
    overlay: Overlay,
    corner: Corner,
}

impl FrameOnScreen {
    fn new(frame: [usize; 2], crt: bool) -> Self {
        FrameOnScreen {
            frame,
            words: Vec::new(),
            size: [0, 0],
            scaling: Scaling::default(),
            look: ScreenLook::new(crt),
            overlay: Overlay::default(),
            corner: Corner::BottomLeft,
        }
    }

    /// Returns the layout of the frame above the list, if one is shown. Where whole factors leave no
    /// room beside the list, the frame is reduced smoothly.
    fn layout(&self, size: [usize; 2]) -> Layout {
        let height = size[1].saturating_sub(ListPanel::new(&self.overlay.list, size).height);
        let is_reduced = self.look.natural_size(self.frame)[1] > height && !self.overlay.list.is_empty();
        let scaling = if is_reduced { Scaling::Smooth } else { self.scaling };
        Layout { window: size, ..self.look.layout(self.frame, [size[0], height], scaling) }
    }

    /// Makes the next call of `redraw` return the whole window.
    fn redraw_all(&mut self) {
        self.size = [0, 0];
    }

    fn toggle_scaling(&mut self) {
        self.scaling = self.scaling.next();
        self.redraw_all();
    }

    /// Uses the whole screen: bars as wide as a whole factor leaves them are no fullscreen picture.
    fn fill_screen(&mut self) {
        if self.scaling == Scaling::Whole {
            self.scaling = Scaling::Smooth;
            self.redraw_all();
        }
    }

    fn toggle_crt(&mut self) {
        self.look.set_crt(!self.look.is_crt());
        self.redraw_all();
    }

    /// Returns the window's words if any changed.
    fn redraw(&mut self, viewer: &mut Viewer, size: [usize; 2], is_new: bool) -> Option<&[u32]> {
        if size.contains(&0) {
            return None;
        }
        let overlay = viewer.overlay();
        let is_same = !is_new && size == self.size && overlay == self.overlay;
        if is_same {
            return None;
        }
        (self.size, self.overlay) = (size, overlay);
        self.words.clear();
        self.words.resize(size[0] * size[1], 0);
        let layout = self.layout(size);
        self.look.convert(viewer.shown().bytes(), &layout, 0..self.frame[1], &mut self.words);
        let mut canvas = Canvas { words: &mut self.words, width: size[0], height: size[1] };
        let captions = self.overlay.captions.iter().map(|&c| layout.window_rectangle(c)).collect::<Vec<_>>();
        let panel = ListPanel::new(&self.overlay.list, size);
        hud::draw(&mut canvas, &self.overlay, &panel, &captions, &mut self.corner);
        Some(&self.words)
    }
}

/// Passes the pointer and the wheel to the viewer.
fn look_at_pointer(viewer: &mut Viewer, window: &minifb::Window, layout: &Layout) {
    let buttons = [MouseButton::Left, MouseButton::Middle, MouseButton::Right];
    let held = (0..).zip(buttons).map(|(i, b)| (window.get_mouse_down(b) as u8) << i).sum();
    let at = window.get_unscaled_mouse_pos(MouseMode::Pass).map(|(x, y)| {
        let place = |v: f32, axis: usize| {
            let shown = layout.shown[axis].max(1) as f64;
            (f64::from(v) - layout.origin[axis] as f64) * layout.frame[axis] as f64 / shown
        };
        [place(x, 0), place(y, 1)]
    });
    viewer.pointer(at, held);
    if let Some((_, dy)) = window.get_scroll_wheel().filter(|(_, dy)| *dy != 0.0) {
        // Some systems report fractions of a step, some tens: only the sign counts.
        viewer.wheel(f64::from(dy.signum()));
    }
}

/// Shows a message in the window and prints it on stderr.
fn tell(viewer: &mut Viewer, text: String) {
    eprintln!("fbptr: {text}");
    viewer.say(text);
}

/// Returns the first free path `fbptr-0001` and up with this extension.
fn free_name(folder: &Path, ending: &str) -> Option<PathBuf> {
    (1..10_000).map(|i| folder.join(format!("fbptr-{i:04}.{ending}"))).find(|p| !p.exists())
}

/// Starts a GIF recording, or ends the current one.
fn toggle_gif(viewer: &mut Viewer, gif: &mut Option<Recording>, folder: &Path) {
    if let Some(recording) = gif.take() {
        let (frames, path) = (recording.movie.frames(), recording.movie.path().display());
        return tell(viewer, format!("saved {path}: {frames} frames"));
    }
    let (width, height) = (viewer.shown().width(), viewer.shown().height());
    let movie = free_name(folder, "gif")
        .ok_or_else(|| "no free name for a GIF".to_owned())
        .and_then(|path| Movie::create(&path, width, height, GIF_RATE).map_err(|e| e.to_string()));
    match movie {
        Ok(movie) => {
            tell(viewer, format!("recording {}", movie.path().display()));
            *gif = Some(Recording::new(movie, GIF_RATE));
        }
        Err(e) => tell(viewer, format!("not recorded: {e}")),
    }
}

/// Executes a request of the viewer to save or print something.
fn serve(viewer: &mut Viewer, request: Request, folder: &Path) {
    let (ending, bytes) = match request {
        Request::Snapshot => ("png", None),
        Request::Save { ending, bytes } => (ending, Some(bytes)),
        Request::Print(text) => {
            // Standard output may be closed.
            let _ = std::io::stdout().lock().write_all(text.as_bytes());
            return viewer.say("the camera is on standard output".to_owned());
        }
        Request::Quit | Request::Record | Request::Fullscreen | Request::Scaling | Request::Crt => return,
    };
    let Some(path) = free_name(folder, ending) else {
        return tell(viewer, format!("no free name for a .{ending}"));
    };
    let saved = match bytes {
        Some(bytes) => save::atomically(&path, |out| out.write_all(&bytes)),
        None => save::to_path(viewer.shown(), &path),
    };
    match saved {
        Ok(()) => tell(viewer, format!("saved {}", path.display())),
        Err(e) => tell(viewer, format!("not saved: {e}")),
    }
}

/// Translates minifb's key to the viewer's.
fn translate(key: minifb::Key) -> Option<Key> {
    use minifb::Key as K;
    Some(match key {
        K::Escape => Key::Escape,
        K::F1 => Key::F1,
        K::F2 => Key::F2,
        K::F3 => Key::F3,
        K::F9 => Key::F9,
        K::F10 => Key::F10,
        K::F11 => Key::F11,
        K::F12 => Key::F12,
        K::Key0 | K::NumPad0 => Key::Zero,
        K::Key1 | K::NumPad1 => Key::One,
        K::Key2 | K::NumPad2 => Key::Two,
        K::Key3 | K::NumPad3 => Key::Three,
        K::Key4 | K::NumPad4 => Key::Four,
        K::Key5 | K::NumPad5 => Key::Five,
        K::A => Key::A,
        K::B => Key::B,
        K::C => Key::C,
        K::D => Key::D,
        K::E => Key::E,
        K::G => Key::G,
        K::H => Key::H,
        K::I => Key::I,
        K::J => Key::J,
        K::K => Key::K,
        K::N => Key::N,
        K::O => Key::O,
        K::P => Key::P,
        K::Q => Key::Q,
        K::R => Key::R,
        K::S => Key::S,
        K::T => Key::T,
        K::U => Key::U,
        K::V => Key::V,
        K::W => Key::W,
        K::Z => Key::Z,
        K::Space => Key::Space,
        K::Period | K::NumPadDot => Key::Period,
        K::Comma => Key::Comma,
        K::Left => Key::Left,
        K::Right => Key::Right,
        K::Up => Key::Up,
        K::Down => Key::Down,
        K::PageUp => Key::PageUp,
        K::PageDown => Key::PageDown,
        K::Equal | K::NumPadPlus => Key::Equal,
        K::Minus | K::NumPadMinus => Key::Minus,
        K::LeftBracket => Key::LeftBracket,
        K::RightBracket => Key::RightBracket,
        K::Tab => Key::Tab,
        K::Backspace => Key::Backspace,
        _ => return None,
    })
}

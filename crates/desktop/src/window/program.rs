//! A window for a program that draws by itself: its frame, 60 times a second, with the input since
//! the last one.
//!
//! In: a function that draws a frame. Out: the frame on the screen, enlarged by a whole factor, or
//! as a cathode ray tube shows it (keys K and F8). Runs on the calling thread, which must be the main
//! one, until the window is closed or the program sets [`FrameInput::close`]. The server's window
//! (`window::run`) is another: it shows frames of a render thread.

use super::frame_input::FrameInput;
use super::layout::{Layout, Scaling};
use super::look::ScreenLook;
use super::program_arguments::ProgramArguments;
use super::upload::Upload;
use super::{Collector, KeyReport, MAX_WINDOW_SIDE, USUAL_SCREEN, WindowError, open, wheel_steps};
use fbptr_command::framebuffer::Framebuffer;
use fbptr_formats::save;
use minifb::{MouseButton, MouseMode, Window};
use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;
use std::time::Instant;

/// Frames drawn in a second.
const FRAMES_PER_SECOND: usize = 60;

/// Opens a window, and calls `frame` 60 times a second with a framebuffer of `width` x `height`
/// pixels, which keeps its contents, and with the input since the last call. Returns when the window
/// is closed or [`FrameInput::close`] is set. K and F8 switch the look of a cathode ray tube on and
/// off ([`FrameInput::crt`]). Must be called on the main thread.
///
/// The program then takes three arguments, beside its own: `--headless` opens no window and draws
/// one frame, each next one 1/60 second later and without input; `--frames N` ends after that many;
/// `--snap FILE` saves the last frame (.png, .ppm or .raw).
///
/// ```no_run
/// fbptr_desktop::window::program::run(160, 120, |fb, input| {
///     let [x, y] = input.mouse;
///     fb.put_pixel(x, y, [255, 255, 0, 255]);
///     input.close = input.is_down("escape");
/// })?;
/// # Ok::<(), fbptr_desktop::window::WindowError>(())
/// ```
///
/// # Errors
/// If a side of the frame is 0 or larger than a window can be, the system has no memory for it,
/// there is no window system, an argument is malformed, or the last frame cannot be saved.
pub fn run(
    width: u32,
    height: u32,
    mut frame: impl FnMut(&mut Framebuffer, &mut FrameInput),
) -> Result<(), WindowError> {
    let size = [width as usize, height as usize];
    if size.iter().any(|&side| side > MAX_WINDOW_SIDE) {
        return Err(WindowError::TooLarge { width, height });
    }
    let arguments = ProgramArguments::of(std::env::args_os().skip(1)).map_err(WindowError::Argument)?;
    let mut framebuffer = Framebuffer::new(width, height)?;
    match arguments.headless {
        true => without_window(&mut framebuffer, &mut frame, &arguments),
        false => in_window(&mut framebuffer, &mut frame, &arguments)?,
    }
    arguments.snap.map_or(Ok(()), |path| Ok(save::to_path(framebuffer.memory(), &path)?))
}

/// Draws the frames without a window.
fn without_window(
    framebuffer: &mut Framebuffer,
    frame: &mut impl FnMut(&mut Framebuffer, &mut FrameInput),
    arguments: &ProgramArguments,
) {
    let mut input = FrameInput::default();
    loop {
        input.begin(1.0 / FRAMES_PER_SECOND as f64);
        frame(framebuffer, &mut input);
        if input.close || arguments.ends_with(input.frame) {
            return;
        }
    }
}

/// Shows the frames in a window.
fn in_window(
    framebuffer: &mut Framebuffer,
    frame: &mut impl FnMut(&mut Framebuffer, &mut FrameInput),
    arguments: &ProgramArguments,
) -> Result<(), WindowError> {
    let size = [framebuffer.memory().width() as usize, framebuffer.memory().height() as usize];
    let scale = Layout::opening_scale(size, USUAL_SCREEN);
    let mut window = open("fbptr", size.map(|side| side * scale))?;
    window.set_target_fps(FRAMES_PER_SECOND);
    let reports = Rc::new(RefCell::new(VecDeque::new()));
    window.set_input_callback(Box::new(Collector(reports.clone())));
    let mut input = FrameInput::default();
    let (mut screen, mut upload) = (Screen::default(), Upload::new(&window));
    let mut last = Instant::now();
    while window.is_open() && !input.close {
        let layout = screen.look.layout(size, window.get_size().into(), Scaling::Whole);
        let now = Instant::now();
        input.begin((now - std::mem::replace(&mut last, now)).as_secs_f64());
        for report in reports.borrow_mut().drain(..) {
            match report {
                KeyReport::Key(key, is_down) => input.key(key, is_down),
                KeyReport::Char(c) => input.text.push(c),
            }
        }
        input.crt ^= input.was_pressed("k") || input.was_pressed("f8");
        read_mouse(&window, &layout, &mut input);
        frame(framebuffer, &mut input);
        screen.look.set_crt(input.crt);
        screen.show(framebuffer, size, &mut window, &mut upload);
        input.close |= arguments.ends_with(input.frame);
    }
    Ok(())
}

/// Reads position, buttons and wheel of the mouse.
fn read_mouse(window: &Window, layout: &Layout, input: &mut FrameInput) {
    if let Some((x, y)) = window.get_unscaled_mouse_pos(MouseMode::Pass) {
        input.mouse = layout.frame_coordinates(x, y);
    }
    input.buttons =
        [MouseButton::Left, MouseButton::Middle, MouseButton::Right].map(|b| window.get_mouse_down(b));
    input.wheel = window.get_scroll_wheel().map_or([0; 2], wheel_steps);
}

/// The window's words.
#[derive(Default)]
struct Screen {
    words: Vec<u32>,
    /// Layout to which they belong.
    layout: Option<Layout>,
    look: ScreenLook,
}

impl Screen {
    /// Converts the frame, uploads it, and waits until the next frame is due.
    fn show(
        &mut self,
        framebuffer: &Framebuffer,
        frame: [usize; 2],
        window: &mut Window,
        upload: &mut Upload,
    ) {
        let [width, height] = <[usize; 2]>::from(window.get_size());
        if width == 0 || height == 0 {
            return window.update();
        }
        let layout = self.look.layout(frame, [width, height], Scaling::Whole);
        if self.layout.replace(layout) != Some(layout) {
            // What is not covered by the frame is black.
            self.words.clear();
            self.words.resize(width * height, 0);
        }
        self.look.convert(framebuffer.memory().bytes(), &layout, 0..frame[1], &mut self.words);
        // What is not shown is drawn with the next frame.
        upload.show(window, &self.words, [width, height], 0..height);
    }
}

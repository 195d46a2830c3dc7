//! The display: the newest frame to be shown, shared by the render thread and the window.
//!
//! In: rows of video memory from the render thread ([`Display::publish`]); input from the window's
//! thread. Out: changed rows to the window, input to the render thread. The frame is a copy: the
//! video memory belongs to the render thread alone, and the window shows what was published last,
//! complete. [`DisplayObserver`] publishes what an engine draws. Promise: no side waits for the
//! other for longer than a copy takes.

mod observer;

pub use observer::DisplayObserver;

use super::events::Input;
use crossbeam_channel::{Receiver, Sender, bounded};
use fbptr_core::input::InputEvent;
use fbptr_core::memory::{DepthMemory, FbPtr, MemoryBudget, MemoryUse, Reservation, Rgba, VideoMemory};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Most inputs that may be queued for a busy render thread; later ones are dropped. Flags are never
/// lost.
const INPUT_ROOM: usize = 4096;

/// The window's own copy of the shown frame.
#[derive(Clone, Debug, Default)]
pub struct ShownFrame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// RGBA rows, row 0 at the top.
    pub bytes: Vec<u8>,
    /// Version of the display that this copy holds; 0 before the first.
    pub version: u64,
    /// Number of `PRESENT` commands when it was published.
    pub frame: u64,
}

/// Facts about one pixel under the pointer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelInfo {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Byte offset of its red value in video memory.
    pub offset: FbPtr,
    /// Its bytes as shown: R, G, B, A.
    pub rgba: Rgba,
    /// Its depth, 0 near to 1 far, if there is a depth buffer and the render thread has answered.
    pub depth: Option<f64>,
}

struct Shown {
    frame: ShownFrame,
    /// Version in which each row changed last.
    row_versions: Vec<u64>,
    /// The pixel whose depth the window asks for, and the last answer.
    probe: Option<(u32, u32)>,
    probe_depth: Option<f64>,
    /// The memory budget's reservation for the frame.
    held: Option<Reservation>,
}

/// The newest frame to be shown, with the flags that the window and the render thread exchange.
pub struct Display {
    width: u32,
    height: u32,
    shown: Mutex<Shown>,
    /// Title that the window is to have, until it has it.
    title: Mutex<Option<String>>,
    version: AtomicU64,
    frame_on_screen: AtomicU64,
    steps_asked: AtomicUsize,
    paused: AtomicBool,
    closed: AtomicBool,
    finished: AtomicBool,
    leaving: AtomicBool,
    listeners: AtomicUsize,
    to_render: Sender<Input>,
    from_window: Receiver<Input>,
}

impl std::fmt::Debug for Display {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Display({}x{}, version {})", self.width, self.height, self.version.load(Ordering::Relaxed))
    }
}

impl Display {
    /// Sets the window's title, as `TITLE` does.
    pub(super) fn set_title(&self, title: String) {
        *self.title.lock().unwrap_or_else(PoisonError::into_inner) = Some(title);
    }

    /// Takes the title that the window is to have from now on, if one was set.
    pub fn take_title(&self) -> Option<String> {
        self.title.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Creates a display of `width` x `height` opaque black pixels, at version 0.
    pub fn new(width: u32, height: u32) -> Arc<Display> {
        let (to_render, from_window) = bounded(INPUT_ROOM);
        let bytes = VideoMemory::CLEAR.repeat(width as usize * height as usize);
        let frame = ShownFrame { width, height, bytes, version: 0, frame: 0 };
        let row_versions = vec![0; height as usize];
        Arc::new(Display {
            width,
            height,
            shown: Mutex::new(Shown { frame, row_versions, probe: None, probe_depth: None, held: None }),
            title: Mutex::new(None),
            version: AtomicU64::new(0),
            frame_on_screen: AtomicU64::new(0),
            steps_asked: AtomicUsize::new(0),
            paused: AtomicBool::new(false),
            closed: AtomicBool::new(false),
            finished: AtomicBool::new(false),
            leaving: AtomicBool::new(false),
            listeners: AtomicUsize::new(0),
            to_render,
            from_window,
        })
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    fn lock(&self) -> MutexGuard<'_, Shown> {
        // An interrupted copy leaves valid bytes, so the frame can still be shown after a panic.
        self.shown.lock().unwrap_or_else(PoisonError::into_inner)
    }

    // ---- the render thread's side ----

    /// Shows `rows` of `memory`, and sets the number of `PRESENT` commands so far to `frame`.
    ///
    /// The memory must have the display's size; rows below it are ignored. Costs a copy of the
    /// rows.
    pub fn publish(&self, memory: &VideoMemory, rows: Range<u32>, frame: u64, depth: Option<&DepthMemory>) {
        debug_assert_eq!((memory.width(), memory.height()), (self.width, self.height));
        let rows = rows.start.min(self.height)..rows.end.min(self.height);
        let mut shown = self.lock();
        let version = shown.frame.version + 1;
        if rows.start < rows.end {
            let stride = memory.stride_bytes();
            let bytes = rows.start as usize * stride..rows.end as usize * stride;
            shown.frame.bytes[bytes.clone()].copy_from_slice(&memory.bytes()[bytes]);
            shown.row_versions[rows.start as usize..rows.end as usize].fill(version);
        }
        shown.frame.version = version;
        shown.frame.frame = frame;
        if let Some((x, y)) = shown.probe {
            shown.probe_depth = depth.and_then(|d| d.z(x as i32, y as i32));
        }
        self.version.store(version, Ordering::Release);
    }

    /// Counts this copy of the frame as long as the display exists. It is not refused if memory is
    /// short, because whoever runs the server asked for it.
    fn reserve_copy(&self, budget: &MemoryBudget) {
        let mut shown = self.lock();
        let mut held = budget.empty(MemoryUse::Frame);
        held.set(shown.frame.bytes.len() as u64);
        shown.held = Some(held);
    }

    /// Answers the window's request for the depth under the pointer, if there is one.
    pub fn answer_probe(&self, depth: Option<&DepthMemory>) {
        let mut shown = self.lock();
        if let Some((x, y)) = shown.probe {
            shown.probe_depth = depth.and_then(|d| d.z(x as i32, y as i32));
        }
    }

    /// Returns the receiver of the window's input.
    pub fn inputs(&self) -> Receiver<Input> {
        self.from_window.clone()
    }

    /// Notes that the stream has ended: the window stays open with the last picture until its user
    /// closes it.
    pub fn finish(&self) {
        self.finished.store(true, Ordering::Release);
    }

    /// Notes that the program ends: the window must close at once.
    pub fn leave(&self) {
        self.leaving.store(true, Ordering::Release);
    }

    /// Sets the number of clients that listen to events.
    pub fn set_listeners(&self, count: usize) {
        self.listeners.store(count, Ordering::Release);
    }

    /// Takes one step that the window has asked for. Returns whether there was one.
    pub fn take_step(&self) -> bool {
        self.steps_asked.fetch_update(Ordering::AcqRel, Ordering::Acquire, |n| n.checked_sub(1)).is_ok()
    }

    /// Returns the newest frame number that is on the screen.
    pub fn frame_on_screen(&self) -> u64 {
        self.frame_on_screen.load(Ordering::Acquire)
    }

    // ---- the window's side ----

    /// Copies the rows that changed since version `last_seen` into `into`. Returns their range, or
    /// `None` if nothing is new.
    ///
    /// `into` takes the display's size, version and frame number; if its size was another one, as
    /// in an empty frame, all rows are copied. An empty range means that only the frame number is
    /// new.
    pub fn copy_changes(&self, last_seen: u64, into: &mut ShownFrame) -> Option<Range<u32>> {
        let is_sized = into.bytes.len() == self.width as usize * self.height as usize * 4
            && (into.width, into.height) == (self.width, self.height);
        if is_sized && self.version.load(Ordering::Acquire) == last_seen {
            return None;
        }
        let shown = self.lock();
        let rows = match is_sized {
            true => {
                let is_new = |v: &u64| *v > last_seen;
                let start = shown.row_versions.iter().position(is_new).unwrap_or(0) as u32;
                let end = shown.row_versions.iter().rposition(is_new).map_or(start, |last| last as u32 + 1);
                start..end
            }
            false => {
                into.bytes.clear();
                into.bytes.resize(shown.frame.bytes.len(), 0);
                0..self.height
            }
        };
        let stride = self.width as usize * 4;
        let bytes = rows.start as usize * stride..rows.end as usize * stride;
        into.bytes[bytes.clone()].copy_from_slice(&shown.frame.bytes[bytes]);
        (into.width, into.height) = (self.width, self.height);
        (into.version, into.frame) = (shown.frame.version, shown.frame.frame);
        Some(rows)
    }

    /// Notes that `frame` (of a [`ShownFrame`]) is on the screen, so that `PRESENT wait` is
    /// answered.
    pub fn note_shown(&self, frame: u64) {
        if self.frame_on_screen.fetch_max(frame, Ordering::AcqRel) < frame {
            self.wake();
        }
    }

    /// Returns the position, bytes and depth of the pixel under the pointer; `None` off the frame.
    /// To be called whenever the window is drawn: the render thread supplies the depth a moment
    /// after the first call for a pixel.
    pub fn pixel_info(&self, x: i32, y: i32) -> Option<PixelInfo> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        if x >= self.width || y >= self.height {
            return None;
        }
        let offset = FbPtr::of_pixel(self.width, x, y);
        let mut shown = self.lock();
        let at = offset.offset_bytes() as usize;
        let rgba = std::array::from_fn(|i| shown.frame.bytes[at + i]);
        let is_new = shown.probe.replace((x, y)) != Some((x, y));
        if is_new {
            shown.probe_depth = None;
        }
        let depth = shown.probe_depth;
        drop(shown);
        if is_new {
            self.wake();
        }
        Some(PixelInfo { x, y, offset, rgba, depth })
    }

    /// Returns the version of the shown frame; it grows with every change.
    pub fn version(&self) -> u64 {
        self.version.load(Ordering::Acquire)
    }

    /// Returns whether streams are paused.
    pub fn is_paused(&self) -> bool {
        self.paused.load(Ordering::Acquire)
    }

    /// Pauses the streams, or continues them.
    pub fn set_paused(&self, paused: bool) {
        self.paused.store(paused, Ordering::Release);
        if !paused {
            self.steps_asked.store(0, Ordering::Release);
        }
        self.wake();
    }

    /// Runs one step of a paused stream: up to its next `PRESENT` if `AUTO` is off, to the next
    /// command that changes the picture if it is on.
    pub fn step(&self) {
        self.steps_asked.fetch_add(1, Ordering::AcqRel);
        self.wake();
    }

    /// Notes that the window is closed: streams stop, and a server ends.
    pub fn close(&self) {
        if !self.closed.swap(true, Ordering::AcqRel) {
            self.send(InputEvent::Close);
        }
        self.wake();
    }

    /// Returns whether the window was closed.
    pub fn is_closed(&self) -> bool {
        self.closed.load(Ordering::Acquire)
    }

    /// Returns whether the stream has ended.
    pub fn is_finished(&self) -> bool {
        self.finished.load(Ordering::Acquire)
    }

    /// Returns whether the window must close because the program ends.
    pub fn is_leaving(&self) -> bool {
        self.leaving.load(Ordering::Acquire)
    }

    /// Returns whether any client listens to events, in which case keys are sent to it.
    pub fn has_listeners(&self) -> bool {
        self.listeners.load(Ordering::Acquire) > 0
    }

    /// Sends an event to the clients that listen; drops it if thousands are queued already.
    pub fn send(&self, event: InputEvent) {
        let _ = self.to_render.try_send(Input::Event(event));
    }

    /// Returns a handle that sends events and can be moved to another thread or a callback.
    pub fn event_sender(self: &Arc<Self>) -> EventSender {
        EventSender(self.clone())
    }

    fn wake(&self) {
        // A full channel means that the render thread has enough input to wake it.
        let _ = self.to_render.try_send(Input::Look);
    }
}

/// Sends events of the window to the clients that listen to events.
#[derive(Clone, Debug)]
pub struct EventSender(Arc<Display>);

impl EventSender {
    /// Sends `event` to the clients that listen; drops it if thousands are queued already.
    pub fn send(&self, event: InputEvent) {
        self.0.send(event);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::memory::DepthFormat;

    #[test]
    fn the_window_gets_just_the_rows_that_changed_since_it_looked() {
        let display = Display::new(3, 5);
        let mut memory = VideoMemory::new(3, 5).unwrap();
        let mut window = ShownFrame::default();
        assert_eq!(display.copy_changes(0, &mut window), Some(0..5), "a fresh copy is filled whole");
        assert_eq!(display.copy_changes(window.version, &mut window), None);
        for y in [1, 3] {
            memory.put_pixel(2, y, [1, 2, 3, 4]);
            display.publish(&memory, y as u32..y as u32 + 1, 7, None);
        }
        assert_eq!(display.copy_changes(window.version, &mut window), Some(1..4));
        assert_eq!((window.bytes.as_slice(), window.frame), (memory.bytes(), 7));
        display.publish(&memory, 0..0, 8, None);
        assert_eq!(display.copy_changes(window.version, &mut window), Some(0..0), "a frame number alone");
        assert_eq!(window.frame, 8);
    }

    #[test]
    fn the_pixel_under_the_pointer_has_offset_colour_and_depth() {
        let display = Display::new(4, 2);
        let mut memory = VideoMemory::new(4, 2).unwrap();
        let depth = DepthMemory::new(4, 2, DepthFormat::F32);
        memory.put_pixel(1, 1, [9, 8, 7, 6]);
        display.publish(&memory, 0..2, 0, Some(&depth));
        let info = display.pixel_info(1, 1).unwrap();
        assert_eq!((info.offset.offset_bytes(), info.rgba, info.depth), (20, [9, 8, 7, 6], None));
        assert_eq!(display.inputs().try_recv(), Ok(Input::Look));
        display.answer_probe(Some(&depth));
        assert_eq!(display.pixel_info(1, 1).unwrap().depth, Some(1.0));
        assert_eq!(display.pixel_info(4, 1), None);
        assert_eq!(display.pixel_info(0, -1), None);
    }

    #[test]
    fn flags_reach_the_other_side_even_when_the_channel_is_full() {
        let display = Display::new(1, 1);
        for _ in 0..INPUT_ROOM * 2 {
            display.send(InputEvent::Mouse { x: 1, y: 1, buttons: 0 });
        }
        display.step();
        display.close();
        assert!(display.is_closed() && display.take_step() && !display.take_step());
    }
}

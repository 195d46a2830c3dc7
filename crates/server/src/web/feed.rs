//! The frames on their way to browsers: a display, and the flags by which its two sides pace each
//! other.
//!
//! In: frames of the render thread, or of a program. Out: the newest frame to the web thread, which
//! asks for the next one when it has a viewer for it, so frames that nobody would see are not
//! copied.

use crate::Display;
use mio::Waker;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

/// The newest frame for the browsers.
#[derive(Debug)]
pub struct WebFeed {
    display: Arc<Display>,
    /// Set if the web thread has a viewer for the next frame.
    is_requested: AtomicBool,
    /// Set while the render thread has changes that it did not show because none were wanted.
    is_held_back: AtomicBool,
    waker: OnceLock<Arc<Waker>>,
}

impl WebFeed {
    /// Creates a feed of frames of `width` x `height` pixels.
    pub fn new(width: u32, height: u32) -> Arc<WebFeed> {
        Arc::new(WebFeed {
            display: Display::new(width, height),
            is_requested: AtomicBool::new(false),
            is_held_back: AtomicBool::new(false),
            waker: OnceLock::new(),
        })
    }

    /// Returns the display that the frames are on.
    pub fn display(&self) -> &Arc<Display> {
        &self.display
    }

    /// Returns whether a frame is wanted.
    pub fn is_requested(&self) -> bool {
        self.is_requested.load(Ordering::SeqCst)
    }

    /// Notes that a frame was put on the display, and wakes the web thread.
    pub fn note_frame(&self) {
        self.is_requested.store(false, Ordering::SeqCst);
        self.wake_web();
    }

    pub(super) fn hold_back(&self, is_held_back: bool) {
        self.is_held_back.store(is_held_back, Ordering::SeqCst);
    }

    /// Asks for a frame. Returns whether the render thread must be woken for it.
    pub(super) fn request_frame(&self) -> bool {
        !self.is_requested.swap(true, Ordering::SeqCst) && self.is_held_back.load(Ordering::SeqCst)
    }

    pub(super) fn set_waker(&self, waker: Arc<Waker>) {
        // A feed belongs to one server of the page, so this is the first call.
        let _ = self.waker.set(waker);
    }

    pub(super) fn wake_web(&self) {
        if let Some(waker) = self.waker.get() {
            // Fails if the web thread has ended.
            let _ = waker.wake();
        }
    }
}

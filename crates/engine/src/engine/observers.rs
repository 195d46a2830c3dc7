//! The engine's side of its observers: attaches them, sends them events, and takes in the pixels of
//! other writers.
//!
//! In: what happens in the engine, and the times of the render thread. Out: events. Promises that
//! an event costs one comparison if there is no observer.

use super::observer::{Event, FrameView, Observer, Occasion, PixelRuns};
use super::{Counters, Engine, EngineFrame, Request};
use crate::Session;
use crate::clock::Instant;
use crate::read_files::ReadFile;
use fbptr_command::Command;
use std::any::Any;
use std::ops::Range;

impl<'a> FrameView<'a> {
    fn of(framebuffer: &'a EngineFrame, counters: &Counters) -> Self {
        let EngineFrame { memory, depth, .. } = framebuffer;
        FrameView { memory, depth: depth.as_ref(), frames: counters.frames, is_frozen: counters.frozen > 0 }
    }
}

impl Engine {
    /// Returns the frame as observers see it.
    pub(super) fn frame_view(&self) -> FrameView<'_> {
        FrameView::of(&self.framebuffer, &self.counters)
    }

    /// Attaches an observer, which is sent all later events.
    pub fn attach(&mut self, observer: impl Observer) {
        // A new observer takes the whole frame: what was drawn before is no later event for it.
        self.send_changes();
        let mut observer: Box<dyn Observer> = Box::new(observer);
        observer
            .event(&Event::Attached(&self.quotas.budget), FrameView::of(&self.framebuffer, &self.counters));
        observer.event(
            &Event::Listeners(self.counters.listeners),
            FrameView::of(&self.framebuffer, &self.counters),
        );
        let (mut changed, wants_contents) = (PixelRuns::default(), self.wants_contents());
        observer.take_in(
            &mut self.framebuffer.memory,
            Occasion::Attached,
            wants_contents.then_some(&mut changed),
        );
        self.send_pixels(&changed);
        self.observers.push(observer);
        self.note_followers();
    }

    /// Notes whether any observer needs the events of every figure.
    fn note_followers(&mut self) {
        self.has_followed_figures = self.observers.iter().any(|observer| observer.follows_figures());
    }

    /// Returns the first attached observer of a type.
    pub fn observer<T: Observer>(&self) -> Option<&T> {
        self.observers.iter().find_map(|observer| (&**observer as &dyn Any).downcast_ref())
    }

    /// Detaches all observers of a type.
    pub fn detach<T: Observer>(&mut self) {
        self.observers.retain(|observer| !(&**observer as &dyn Any).is::<T>());
        self.note_followers();
    }

    /// Sends an event to all observers.
    #[inline]
    pub(super) fn send(&mut self, event: &Event<'_>) {
        if !self.observers.is_empty() {
            self.send_to_all(event);
        }
    }

    #[inline(never)]
    fn send_to_all(&mut self, event: &Event<'_>) {
        let frame = FrameView::of(&self.framebuffer, &self.counters);
        self.observers.iter_mut().for_each(|observer| observer.event(event, frame));
    }

    /// Sends the beginning of a request, or of a later part of it.
    #[inline]
    pub(super) fn send_begin(&mut self, s: &Session, request: &Request<'_>) {
        self.send(&Event::Begins { connection: s.id, offset: s.offset, request });
    }

    /// Sends a command of the engine itself, which has taken effect.
    pub(super) fn send_own(&mut self, command: Command) {
        let request = &Request::Command(command);
        self.send(&Event::Begins { connection: 0, offset: [0, 0], request });
        self.send(&Event::Done { connection: 0, files: &[] });
    }

    /// Sends the end of a request that has begun.
    #[inline]
    pub(super) fn send_end(&mut self, s: &Session, is_done: bool, files: &[ReadFile]) {
        self.send(&match is_done {
            true => Event::Done { connection: s.id, files },
            false => Event::Undone,
        });
    }

    /// Sends rows whose contents do not come from requests alone.
    pub(super) fn send_rows(&mut self, rows: Range<u32>) {
        let width = self.framebuffer.width();
        if !rows.is_empty() {
            let run = rows.start * width..rows.end * width;
            self.send(&Event::Pixels(std::slice::from_ref(&run)));
        }
    }

    fn send_pixels(&mut self, changed: &PixelRuns) {
        if !changed.runs().is_empty() {
            self.send(&Event::Pixels(changed.runs()));
        }
    }

    /// Returns whether any observer needs contents of files and foreign pixels.
    pub(super) fn wants_contents(&self) -> bool {
        self.observers.iter().any(|observer| observer.wants_contents())
    }

    /// Lets observers store what others than clients have written. Returns whether it must be shown
    /// at once.
    fn take_in(&mut self, occasion: Occasion) -> bool {
        let (mut changed, mut is_urgent) = (PixelRuns::default(), false);
        let wants_contents = self.wants_contents();
        for observer in &mut self.observers {
            let changed = wants_contents.then_some(&mut changed);
            is_urgent |= observer.take_in(&mut self.framebuffer.memory, occasion, changed);
        }
        self.send_pixels(&changed);
        is_urgent
    }

    /// Sends the rows that have changed since the last call.
    fn send_changes(&mut self) {
        let rows = self.framebuffer.memory.take_damage();
        if rows.start < rows.end {
            self.send(&Event::Changed(rows));
        }
    }

    /// Begins a slice: sets the time of the following commands, and takes in foreign pixels unless
    /// a command is in pieces.
    pub fn begin_slice(&mut self, now: Instant) {
        self.send(&Event::Slice(now));
        if !self.is_in_pieces {
            self.take_in(Occasion::Slice(now));
        }
    }

    /// Sends what was drawn to those who see it beside the replies. Called before these are sent.
    pub fn before_replies(&mut self) {
        if !self.observers.is_empty() {
            self.send_changes();
            self.send(&Event::Replies);
        }
    }

    /// Does the periodic work of the observers. Must be called at [`Engine::next_deadline`] at the
    /// latest.
    pub fn tick(&mut self, now: Instant) {
        if !self.is_in_pieces && self.take_in(Occasion::Tick(now)) {
            self.show();
        }
        self.send_changes();
        self.send(&Event::Tick(now));
    }

    /// Returns the time of the next [`Engine::tick`], if one is needed.
    pub fn next_deadline(&mut self, now: Instant) -> Option<Instant> {
        self.send_changes();
        let is_frozen = self.is_frozen();
        self.observers.iter().filter_map(|observer| observer.deadline(now, is_frozen)).min()
    }

    /// Shows the rows that changed, unless a connection has frozen the display.
    pub fn show(&mut self) {
        self.send_changes();
        self.send(&Event::Show);
    }

    /// Sends the end of a frame.
    pub(super) fn send_present(&mut self) {
        self.send_changes();
        self.send(&Event::Presented);
    }

    /// Returns whether `PRESENT wait` for `frame` can be answered.
    pub fn is_shown(&self, frame: u64) -> bool {
        self.observers.iter().all(|observer| observer.is_shown(frame))
    }

    /// Ends the observers' output.
    pub fn end(&mut self) {
        self.send_changes();
        self.send(&Event::End);
    }
}

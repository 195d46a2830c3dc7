//! Requests on the surface of their connection: the target in place of the frame, and the clip
//! rectangle on its memory.
//!
//! In: a part of a request, and the reach of its verb. Out: the same part, run with the frame or
//! the canvas as the engine's framebuffer, whose memory lets drawing touch the clip rectangle alone.
//! The reach stands in the verb table, so no verb can be forgotten; the memory bounds what drawing
//! touches, so no figure can pass by. Whoever reads the engine's frame otherwise, observers above
//! all, does it outside of these parts, where the frame is whole and in its place.
//!
//! One would know of an error by a pixel outside a clip rectangle, or on the frame while a canvas is
//! the target: `tests/drawing/surfaces.rs` draws with every verb of the table.

use super::{Engine, Fault, Progress, Request, pieces};
use crate::Session;
use fbptr_command::{Command, Reach, Verb};
use fbptr_core::draw2d::{self, Rect};
use fbptr_core::error::Code;
use fbptr_core::memory::Rgba;
use fbptr_core::scene::HiddenSurface;
use std::ops::Range;

/// Returns the reach of a verb.
fn reach_of(verb: &str) -> Reach {
    Verb::named(verb).map_or(Reach::Connection, |verb| verb.reach)
}

impl Engine {
    /// Runs a part of a request of this verb on its connection's surface. Costs one comparison while
    /// neither a canvas is the target nor a clip rectangle is set.
    #[inline]
    pub(super) fn on_surface<T>(
        &mut self,
        s: &mut Session,
        verb: &str,
        part: impl FnOnce(&mut Engine, &mut Session) -> T,
    ) -> T {
        match s.surfaces.are_plain() {
            true => part(self, s),
            false => self.on_other_surface(s, reach_of(verb), part),
        }
    }

    /// Runs a part of a request on the target, within the clip rectangle, as far as its reach says.
    /// The part does not panic.
    #[inline(never)]
    fn on_other_surface<T>(
        &mut self,
        s: &mut Session,
        reach: Reach,
        part: impl FnOnce(&mut Engine, &mut Session) -> T,
    ) -> T {
        if reach == Reach::Connection {
            return part(self, s);
        }
        s.surfaces.swap_target(&mut self.framebuffer);
        if let (Reach::Clip, Some(Rect { x, y, w, h })) = (reach, s.surfaces.clip) {
            let side = |start: i32, length: i32| {
                let end = (i64::from(start) + i64::from(length)).max(0);
                start.max(0) as u32..end.min(i64::from(u32::MAX)) as u32
            };
            self.framebuffer.memory.set_clip(side(x, w), side(y, h));
        }
        let result = part(self, s);
        self.framebuffer.memory.end_clip();
        s.surfaces.swap_target(&mut self.framebuffer);
        result
    }

    /// Clears the part of a canvas that a command was drawing in when it was given up, for a
    /// recording, too: what it has drawn is not known to a replay.
    pub(super) fn reset_canvas(&mut self, s: &mut Session) {
        let color = [0; 4];
        self.on_surface(s, "CLEAR", |engine, s| engine.clear(s, color));
        self.send_begin(s, &Request::Command(Command::Clear { color }));
        self.send_end(s, true, &[]);
    }

    pub(super) fn set_clip(&mut self, s: &mut Session, rect: Option<Rect>) {
        s.surfaces.clip = rect;
    }

    pub(super) fn make_canvas(&mut self, s: &mut Session, name: String, w: i32, h: i32) -> Result<(), Fault> {
        let size = [w, h].map(|side| u32::try_from(side).unwrap_or(0));
        let resource_bytes = s.names.size_bytes();
        let mut make = |engine: &Engine, name: String| {
            let (limits, budget) = (&engine.quotas.limits, &engine.quotas.budget);
            s.surfaces.make(name, size, resource_bytes, limits, budget)
        };
        match make(self, name.clone()) {
            Err(fault) if fault.code == Code::Quota => {
                self.free_caches();
                make(self, name)
            }
            made => made,
        }
    }

    /// Reserves memory for the depth and pick buffers that a draw will allocate. Those of a canvas are
    /// resources of its connection.
    pub(super) fn reserve_target(&mut self, s: &mut Session, hide: HiddenSurface) -> Result<(), Fault> {
        if s.surfaces.has_target() {
            s.surfaces.check_draw(&self.framebuffer, hide, s.names.size_bytes(), &self.quotas.limits)?;
            self.with_room(|_| s.surfaces.reserve_draw())?;
        }
        self.with_room(|engine| engine.framebuffer.reserve_target(hide))
    }

    pub(super) fn set_target(&mut self, s: &mut Session, name: Option<String>) -> Result<(), Fault> {
        s.surfaces.set_target(name)
    }

    /// Runs `STAMP`: draws a canvas on the target as `BLEND` says, without its pixels of the key's
    /// colour.
    pub(super) fn stamp(
        &mut self,
        s: &mut Session,
        name: String,
        x: i32,
        y: i32,
        key: Option<Rgba>,
    ) -> Result<Progress, Fault> {
        let height = self.framebuffer.height();
        let mut next = 0;
        while next < height {
            let rows = next..(next + pieces::band_rows(self)).min(height);
            next = rows.end;
            self.stamp_band(s, &name, [x, y], key, rows)?;
        }
        self.end_stamp(s, &name, [x, y]);
        Ok(Progress::Done(super::Effect::Done))
    }

    /// Returns where a canvas lies on the target that is stamped at a pixel, if there is one.
    pub(super) fn stamped_rect(&self, s: &Session, name: &str, [x, y]: [i32; 2]) -> Option<Rect> {
        let canvas = match s.surfaces.is_target(name) {
            true => &self.framebuffer.memory,
            false => s.surfaces.canvas(name)?,
        };
        let [w, h] = [canvas.width(), canvas.height()].map(|side| side as i32);
        Some(Rect { x, y, w, h })
    }

    /// Draws the part of a stamp that lies in one of the bands of rows, from the top down. A canvas
    /// stamped on itself is read before it is written: its bands are drawn from the bottom up if it
    /// moves down, and each is drawn from a copy.
    pub(super) fn stamp_band(
        &mut self,
        s: &mut Session,
        name: &str,
        at: [i32; 2],
        key: Option<Rgba>,
        rows: Range<u32>,
    ) -> Result<(), Fault> {
        let missing = || Fault::new(Code::NoEnt, "no canvas has this name").got(name);
        let rect = self.stamped_rect(s, name, at).ok_or_else(missing)?;
        let (is_own, height) = (s.surfaces.is_target(name), self.framebuffer.height());
        let rows = if is_own && rect.y > 0 { height - rows.end..height - rows.start } else { rows };
        let (band, bytes) = pieces::part_in(rect, &rows);
        if band.h == 0 {
            return Ok(());
        }
        let memory = &mut self.framebuffer.memory;
        if is_own {
            let copy = memory.bytes()[bytes].to_vec();
            draw2d::stamp(memory, band, &copy, key, s.blend)?;
        } else if let Some(canvas) = s.surfaces.canvas(name) {
            draw2d::stamp(memory, band, &canvas.bytes()[bytes], key, s.blend)?;
        }
        Ok(())
    }

    /// Counts the pixels of a stamp.
    pub(super) fn end_stamp(&mut self, s: &mut Session, name: &str, at: [i32; 2]) {
        if let Some(rect) = self.stamped_rect(s, name, at) {
            let stored = self.framebuffer.visible(rect);
            s.count_pixels(rect.w as usize * rect.h as usize, stored);
        }
    }
}

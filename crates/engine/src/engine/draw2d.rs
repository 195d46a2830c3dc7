//! Pixelflut's verbs and the memory verbs, as commands and as batches.
//!
//! In: pixels and rectangles of one session. Out: changed video memory, replies, counters.

use super::{Call, Decoded, Engine, EngineFrame};
use crate::Session;
use crate::session::DefaultView;
use fbptr_command::{BINARY_PIXEL_BYTES, DrawFigure, Rect};
use fbptr_core::draw2d::{self, Blend, DrawError, FigureTarget, Line};
use fbptr_core::error::{Code, Fault};
use fbptr_core::executor::Executor;
use fbptr_core::memory::{FbPtr, MemoryError, Rgba};
use std::ops::Range;

impl EngineFrame {
    /// Adds OFFSET to the position of a text PX. A sum beyond i32 saturates and stays off the
    /// frame.
    pub(super) fn moved(s: &Session, x: i32, y: i32) -> (i32, i32) {
        (x.saturating_add(s.offset[0]), y.saturating_add(s.offset[1]))
    }

    /// Runs `PX x y colour`, moved by OFFSET.
    #[inline(never)]
    pub(super) fn moved_pixel(&mut self, s: &mut Session, x: i32, y: i32, color: Rgba) {
        let (x, y) = Self::moved(s, x, y);
        self.pixel(s, x, y, color);
    }

    /// Draws one pixel at its final position, and counts it as drawn or clipped.
    #[inline]
    pub(super) fn pixel(&mut self, s: &mut Session, x: i32, y: i32, color: Rgba) {
        let is_inside = self.memory.is_drawable(x, y);
        s.stats.pixels += u64::from(is_inside);
        s.stats.clipped += u64::from(!is_inside);
        match s.blend {
            _ if !is_inside => {}
            Blend::Replace => self.memory.put_pixel(x, y, color),
            Blend::Over => draw2d::put_pixel(&mut self.memory, x, y, color, Blend::Over),
        }
    }

    /// Draws complete `PB` records of 10 bytes each.
    pub(super) fn binary_pixels(&mut self, s: &mut Session, records: &[u8]) {
        let stored = draw2d::binary_pixels(&mut self.memory, records, s.blend);
        s.count_pixels(records.len() / BINARY_PIXEL_BYTES, stored);
    }

    /// Draws text pixels, moved by OFFSET.
    pub(super) fn pixels(&mut self, s: &mut Session, records: &[[u8; 8]]) {
        let stored = draw2d::moved_points(&mut self.memory, records, s.offset, s.blend);
        s.count_pixels(records.len(), stored);
    }

    pub(super) fn pixel_run(&mut self, s: &mut Session, x: u16, y: u16, rgba: &[u8]) -> Result<(), Fault> {
        if !rgba.len().is_multiple_of(4) {
            let message = format!("a run is whole pixels of 4 bytes, not {} bytes", rgba.len());
            return Err(Fault::new(Code::Format, message));
        }
        let stored = draw2d::pixel_run(&mut self.memory, x, y, rgba);
        s.count_pixels(rgba.len() / 4, stored);
        Ok(())
    }

    /// Draws RGBA rows, whatever `BLEND` is, so that reading returns what was written.
    pub(super) fn blit(&mut self, s: &mut Session, rect: Rect, rgba: &[u8]) -> Result<(), Fault> {
        draw2d::blit(&mut self.memory, rect, rgba, Blend::Replace)?;
        let stored = self.visible(rect);
        s.stats.pixels += stored;
        s.stats.clipped += rgba.len() as u64 / 4 - stored;
        Ok(())
    }

    /// Counts the pixels of a picture.
    pub(super) fn count_image(&self, s: &mut Session, rect: Rect) {
        s.count_pixels(rect.w as usize * rect.h as usize, self.visible(rect));
    }

    /// Returns the number of a rectangle's pixels that are on the frame, and in the clip rectangle.
    pub(super) fn visible(&self, Rect { x, y, w, h }: Rect) -> u64 {
        let side = |start: i32, len: i32, within: &std::ops::Range<u32>| {
            let (start, low, high) = (i64::from(start), i64::from(within.start), i64::from(within.end));
            ((start + i64::from(len)).clamp(low, high) - start.clamp(low, high)).max(0) as u64
        };
        let [columns, rows] = self.memory.clip();
        side(x, w, &columns) * side(y, h, &rows)
    }

    /// Does what CLEAR does besides filling the pixels: counts them, and clears the depth and pick
    /// buffers, all within the clip rectangle.
    pub(super) fn end_clear(&mut self, s: &mut Session) {
        if let DefaultView::Framed(_) = s.default_view {
            s.default_view = DefaultView::Unset;
        }
        let [columns, rows] = self.memory.clip();
        s.stats.pixels += columns.len() as u64 * rows.len() as u64;
        match self.memory.is_clipped() {
            true => self.clear_depths_and_ids_within(&columns, &rows),
            false => self.clear_depths_and_ids(),
        }
    }
}

impl Engine {
    pub(super) fn size(&self, call: &mut Call<'_>) {
        call.answer(format_args!("SIZE {} {}", self.framebuffer.width(), self.framebuffer.height()));
    }

    /// Replies with a pixel's colour. The reply has the position that was asked for, not the one
    /// moved by OFFSET, as in other Pixelflut servers.
    pub(super) fn asked_pixel(&self, call: &mut Call<'_>, x: i32, y: i32) -> Result<(), MemoryError> {
        let (mx, my) = EngineFrame::moved(call, x, y);
        let [r, g, b, _] = self.framebuffer.memory.get_pixel(mx, my)?;
        call.answer(format_args!("PX {x} {y} {r:02x}{g:02x}{b:02x}"));
        Ok(())
    }

    /// Runs `PX x y colour`, moved by OFFSET.
    pub(super) fn moved_pixel(&mut self, s: &mut Session, x: i32, y: i32, color: Rgba) {
        self.framebuffer.moved_pixel(s, x, y, color);
    }

    pub(super) fn binary_pixel(&mut self, s: &mut Session, x: u16, y: u16, color: Rgba) {
        self.framebuffer.pixel(s, x.into(), y.into(), color);
    }

    pub(super) fn pixel_run(
        &mut self,
        s: &mut Session,
        x: u16,
        y: u16,
        rgba: impl AsRef<[u8]>,
    ) -> Result<(), Fault> {
        self.framebuffer.pixel_run(s, x, y, rgba.as_ref())
    }

    pub(super) fn poke(&mut self, s: &mut Session, offset: i32, bytes: Vec<u8>) -> Result<(), Fault> {
        self.framebuffer.memory.poke(pointer(offset, bytes.len())?, &bytes)?;
        s.stats.pixels += bytes.len().div_ceil(4) as u64;
        Ok(())
    }

    // The memory verbs store their bytes whatever `BLEND` is, so that reading returns what was
    // written.

    pub(super) fn blit(&mut self, s: &mut Session, rect: Rect, rgba: impl AsRef<[u8]>) -> Result<(), Fault> {
        self.framebuffer.blit(s, rect, rgba.as_ref())
    }

    /// Draws the rows of a picture as `BLEND` says.
    pub(super) fn put_picture(&mut self, s: &Session, rect: Rect, picture: &Decoded) -> Result<(), Fault> {
        Ok(draw2d::blit(&mut self.framebuffer.memory, rect, picture.rgba(), s.blend)?)
    }

    pub(super) fn copy(&mut self, s: &mut Session, source: Rect, dx: i32, dy: i32) -> Result<(), Fault> {
        draw2d::copy(&mut self.framebuffer.memory, source, [dx, dy], Blend::Replace)?;
        s.stats.pixels += self.framebuffer.visible(Rect { x: dx, y: dy, ..source });
        Ok(())
    }

    pub(super) fn crc(&self, call: &mut Call<'_>, rect: Option<Rect>) -> Result<(), Fault> {
        let mut crc = crc32fast::Hasher::new();
        let memory = &self.framebuffer.memory;
        match rect {
            None => crc.update(memory.bytes()),
            Some(rect) => draw2d::rows(memory, rect)?.for_each(|row| crc.update(row)),
        }
        call.answer(format_args!("CRC {:08x}", crc.finalize()));
        Ok(())
    }

    /// Returns the executor of the 2-D verbs: the renderer's threads, never cancelled.
    pub(in crate::engine) fn executor(&self) -> Executor {
        Executor::of_pool(self.rendering.renderer.options().pool.clone())
    }

    /// Draws a line, area or text, within the band of rows to which the memory is restricted; a large
    /// area on all threads of the pool if there is one.
    pub(super) fn figure(&mut self, s: &mut Session, figure: impl DrawFigure) -> Result<(), DrawError> {
        figure.draw(&mut FigureTarget {
            memory: &mut self.framebuffer.memory,
            blend: s.blend,
            text_size: s.text_size,
            pool: self.rendering.renderer.options().pool.as_ref(),
        })
    }

    /// Draws lines in their order, on all threads of the pool if there is one.
    pub(super) fn lines(&mut self, s: &Session, lines: &[Line]) {
        draw2d::lines_on(&self.executor(), &mut self.framebuffer.memory, lines, s.blend);
    }

    pub(super) fn peek(&mut self, call: &mut Call<'_>, offset: i32, n: i32) -> Result<(), Fault> {
        let len = self.peek_head(offset, n, call.replies)?;
        self.peek_digits(offset, 0..len, call.replies)?;
        call.replies.push(b'\n');
        Ok(())
    }

    /// Appends what comes before the digits of a `PEEK`. Returns the number of bytes.
    pub(super) fn peek_head(&mut self, offset: i32, n: i32, out: &mut Vec<u8>) -> Result<usize, Fault> {
        let len = usize::try_from(n)
            .map_err(|_| Fault::new(Code::Range, "the byte count must be 0 or more").got(n.to_string()))?;
        let at = pointer(offset, len)?;
        let _ = self.framebuffer.memory.peek(at, len)?;
        self.check_reply(len as u64 * 2)?;
        out.extend_from_slice(format!("PEEK {offset}").as_bytes());
        if len > 0 {
            out.push(b' ');
        }
        Ok(len)
    }

    /// Appends the digits of some bytes of a `PEEK` from `offset` on.
    pub(super) fn peek_digits(
        &self,
        offset: i32,
        bytes: Range<usize>,
        out: &mut Vec<u8>,
    ) -> Result<(), Fault> {
        const DIGITS: &[u8; 16] = b"0123456789abcdef";
        let at = FbPtr::new(offset.unsigned_abs().into());
        let bytes = &self.framebuffer.memory.peek(at, bytes.end)?[bytes.start..];
        out.extend(bytes.iter().flat_map(|b| [DIGITS[usize::from(b >> 4)], DIGITS[usize::from(b & 15)]]));
        Ok(())
    }

    pub(super) fn read(&mut self, call: &mut Call<'_>, rect: Rect) -> Result<(), Fault> {
        self.read_head(rect, call.replies)?;
        draw2d::rows(&self.framebuffer.memory, rect)?.for_each(|row| call.replies.extend_from_slice(row));
        Ok(())
    }

    /// Appends the line before the rows of `READ`. Returns the number of bytes of the rows.
    pub(super) fn read_head(&mut self, rect: Rect, out: &mut Vec<u8>) -> Result<u64, Fault> {
        drop(draw2d::rows(&self.framebuffer.memory, rect)?);
        let Rect { x, y, w, h } = rect;
        let bytes = w as u64 * h as u64 * 4;
        self.check_reply(bytes)?;
        out.extend_from_slice(format!("READ {x} {y} {w} {h} :{bytes}\n").as_bytes());
        Ok(bytes)
    }

    pub(super) fn points(&mut self, s: &mut Session, packed: impl AsRef<[u8]>) -> Result<(), Fault> {
        let packed = packed.as_ref();
        let stored =
            draw2d::points_on(&self.executor(), &mut self.framebuffer.memory, packed, Blend::Replace)?;
        s.count_pixels(packed.len() / 8, stored);
        Ok(())
    }

    pub(super) fn clear(&mut self, s: &mut Session, color: Rgba) {
        let memory = &mut self.framebuffer.memory;
        match memory.is_clipped() {
            true => memory.clear_rows(0..memory.height(), color),
            false => self.rendering.renderer.clear(memory, color),
        }
        self.framebuffer.end_clear(s);
        self.clear_draw_log(s);
    }

    /// Refuses a reply that is too long, or reserves memory for it until it is queued.
    pub(super) fn check_reply(&mut self, bytes: u64) -> Result<(), Fault> {
        self.quotas.check_reply_length(bytes)?;
        if bytes > SHORT_REPLY_BYTES {
            self.with_room(|engine| engine.quotas.reply.try_cover(bytes))?;
        }
        Ok(())
    }
}

/// Longest reply in bytes for which no memory is reserved. Such replies cannot add up: while
/// earlier ones are unread and memory is short, the connection's commands wait.
const SHORT_REPLY_BYTES: u64 = 16 << 10;

/// Converts the byte offset of a command to a position in the video memory.
fn pointer(offset: i32, len: usize) -> Result<FbPtr, Fault> {
    u64::try_from(offset).map(FbPtr::new).map_err(|_| {
        let message = format!("the {len} bytes must begin at 0 or later");
        Fault::new(Code::Range, message).got(offset.to_string())
    })
}

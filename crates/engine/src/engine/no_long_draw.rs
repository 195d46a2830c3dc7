//! Long draws where there is no thread for them: every draw runs at once.
//!
//! In: draws that may take long, which are handed back. Promise: as there is no [`LongDraw`],
//! nothing but the way back is ever run.

use super::Engine;
use super::drawing::Drawing;
use crate::Session;
use crate::clock::Instant;
use fbptr_core::error::Fault;
use std::convert::Infallible;

/// The drawing thread, of which there is none.
#[derive(Debug)]
pub(super) struct DrawThread(Infallible);

/// A long draw, of which there is none.
#[derive(Debug)]
pub(super) struct LongDraw {
    pub has_depth: bool,
    none: Infallible,
}

impl Engine {
    /// Returns the draw: there is no thread to give.
    ///
    /// # Errors
    /// Always.
    pub(super) fn begin_long_draw(&mut self, drawing: Drawing) -> Result<LongDraw, Drawing> {
        if let Some(thread) = &self.rendering.draw_thread {
            match thread.0 {}
        }
        Err(drawing)
    }

    /// Is never called, as there is no draw for it.
    pub(super) fn run_long_draw(
        &mut self,
        _: &mut Session,
        draw: &mut LongDraw,
        _: Option<Instant>,
    ) -> Result<bool, Fault> {
        match draw.none {}
    }

    /// Is never called, as there is no draw for it.
    pub(super) fn stop_long_draw(&mut self, draw: &mut LongDraw) {
        match draw.none {}
    }
}

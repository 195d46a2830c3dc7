//! The canvases of a connection, its target and its clip rectangle.
//!
//! In: names, sizes, rectangles. Out: the memories that a command draws into, lent by swapping them
//! with the frame's. A canvas is a frame of its own, with depths and pick buffer; all of it, its small
//! blocks included, is counted in the memory budget and among the bytes that its connection may hold,
//! and freed with its connection.

use super::Limits;
use super::engine_frame::EngineFrame;
use super::resources::let_go;
use fbptr_core::draw2d::Rect;
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{MemoryBudget, MemoryUse, OverBudget, Reservation, VideoMemory};
use fbptr_core::scene::HiddenSurface;
use std::collections::BTreeMap;

/// Memory of a name in the table of canvases, in bytes without its letters.
const NAME_BYTES: u64 = 128;

/// Surfaces that a connection may draw on.
#[derive(Debug, Default)]
pub struct Surfaces {
    /// The clip rectangle, in pixels of the target.
    pub clip: Option<Rect>,
    /// Name of the canvas that is drawn on; `None` is the frame.
    target: Option<String>,
    /// The canvases. While a command runs on the target, its place here holds the frame.
    canvases: BTreeMap<String, Canvas>,
}

/// A canvas.
#[derive(Debug)]
struct Canvas {
    frame: Box<EngineFrame>,
    /// The memory budget's reservation for its name and for what its frame takes beside pixels,
    /// depths, numbers and names. It stays here while the frames are swapped.
    held: Reservation,
}

impl Surfaces {
    /// Returns whether commands draw on the frame, all of it.
    #[inline]
    pub fn are_plain(&self) -> bool {
        self.clip.is_none() && self.target.is_none()
    }

    /// Returns whether commands draw on a canvas.
    pub fn has_target(&self) -> bool {
        self.target.is_some()
    }

    /// Returns whether the canvas is the one that commands draw on.
    pub fn is_target(&self, name: &str) -> bool {
        self.target.as_deref() == Some(name)
    }

    /// Returns the width and height of the canvas that commands draw on, if they do.
    pub fn target_size(&self) -> Option<[u32; 2]> {
        let canvas = self.canvases.get(self.target.as_ref()?)?;
        Some([canvas.frame.width(), canvas.frame.height()])
    }

    /// Returns the number of bytes of all canvases. Not for a command on the target, whose place
    /// holds the frame.
    pub fn bytes(&self) -> u64 {
        self.canvases.values().map(Canvas::bytes).sum()
    }

    /// Returns a canvas that is not the target.
    pub fn canvas(&self, name: &str) -> Option<&VideoMemory> {
        self.canvases.get(name).map(|canvas| &canvas.frame.memory)
    }

    /// Swaps the frame with the target's canvas, if there is one. The same call swaps them back.
    pub(crate) fn swap_target(&mut self, frame: &mut EngineFrame) {
        if let Some(canvas) = self.target.as_ref().and_then(|name| self.canvases.get_mut(name)) {
            std::mem::swap(frame, &mut canvas.frame);
        }
    }

    /// Makes a transparent canvas, in place of an old one of its name.
    ///
    /// # Errors
    /// `ETOOBIG` for a size that no frame may have, `EQUOTA` if the limits or the budget have no
    /// room; nothing changes then.
    pub fn make(
        &mut self,
        name: String,
        [width, height]: [u32; 2],
        resource_bytes: u64,
        limits: &Limits,
        budget: &MemoryBudget,
    ) -> Result<(), Fault> {
        limits.check_frame(width, height)?;
        let old = self.canvases.get(&name).map_or(0, Canvas::bytes);
        let fixed = NAME_BYTES + name.len() as u64 + EngineFrame::FIXED_BYTES;
        let bytes = u64::from(width) * u64::from(height) * 4 + fixed;
        check_room(resource_bytes + self.bytes() - old, bytes, &name, limits)?;
        if !self.canvases.contains_key(&name) && self.canvases.len() >= limits.names {
            let message = format!("no more than {} canvases of a connection, all in use", limits.names);
            return Err(Fault::new(Code::Quota, message).got(name));
        }
        let held = budget.try_reserve(MemoryUse::Resources, fixed)?;
        let frame = Box::new(EngineFrame::canvas([width, height], budget)?);
        if let Some(old) = self.canvases.insert(name, Canvas { frame, held }) {
            old.let_go();
        }
        Ok(())
    }

    /// Refuses a draw on the target, which is `canvas`, if the connection has no room for its depth
    /// and pick buffers.
    ///
    /// # Errors
    /// `EQUOTA`.
    pub(crate) fn check_draw(
        &self,
        canvas: &EngineFrame,
        hide: HiddenSurface,
        resource_bytes: u64,
        limits: &Limits,
    ) -> Result<(), Fault> {
        let (Some(name), more @ 1..) = (&self.target, canvas.lacking_target_bytes(hide)) else {
            return Ok(());
        };
        let bytes = |(of, place): (&String, &Canvas)| match of == name {
            true => place.held.bytes() + canvas.held_bytes(),
            false => place.bytes(),
        };
        let in_use = resource_bytes + self.canvases.iter().map(bytes).sum::<u64>();
        check_room(in_use, more + EngineFrame::FIXED_TARGET_BYTES, name, limits)
    }

    /// Reserves memory for the small blocks of the target's depth and pick buffers.
    pub(crate) fn reserve_draw(&mut self) -> Result<(), OverBudget> {
        let Some((name, canvas)) =
            self.target.as_ref().and_then(|name| Some((name, self.canvases.get_mut(name)?)))
        else {
            return Ok(());
        };
        let fixed = EngineFrame::FIXED_BYTES + EngineFrame::FIXED_TARGET_BYTES;
        canvas.held.try_cover(NAME_BYTES + name.len() as u64 + fixed)
    }

    /// Makes a canvas the target, or the frame.
    ///
    /// # Errors
    /// `ENOENT` if there is no such canvas.
    pub fn set_target(&mut self, name: Option<String>) -> Result<(), Fault> {
        match &name {
            Some(canvas) if !self.canvases.contains_key(canvas) => {
                Err(Fault::new(Code::NoEnt, "no canvas has this name").got(canvas.clone()))
            }
            _ => {
                self.target = name;
                Ok(())
            }
        }
    }

    /// Forgets a canvas; the frame is the target then, if the canvas was. Returns whether there was
    /// one.
    pub fn free(&mut self, name: &str) -> bool {
        if self.is_target(name) {
            self.target = None;
        }
        self.canvases.remove(name).map(Canvas::let_go).is_some()
    }
}

impl Drop for Surfaces {
    fn drop(&mut self) {
        std::mem::take(&mut self.canvases).into_values().for_each(Canvas::let_go);
    }
}

impl Canvas {
    /// Returns the bytes that are counted for it.
    fn bytes(&self) -> u64 {
        self.held.bytes() + self.frame.held_bytes()
    }

    /// Drops it, beside this thread if that takes long.
    fn let_go(self) {
        let bytes = self.bytes();
        let_go(self, bytes);
    }
}

/// Refuses `more` bytes beside those that a connection's resources take.
fn check_room(in_use: u64, more: u64, name: &str, limits: &Limits) -> Result<(), Fault> {
    let most = limits.resource_bytes;
    match in_use.saturating_add(more) <= most {
        true => Ok(()),
        false => {
            let message = format!(
                "the resources of a connection may take {most} bytes, {in_use} are in use, and {more} more are \
                 needed"
            );
            Err(Fault::new(Code::Quota, message).got(name))
        }
    }
}

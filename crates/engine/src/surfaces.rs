//! The canvases of a connection, its target and its clip rectangle.
//!
//! In: names, sizes, rectangles. Out: the memories that a command draws into, lent by swapping them
//! with the frame's. A canvas is a frame of its own, with depths and pick buffer; it is counted in
//! the memory budget, and freed with its connection.

use super::Limits;
use super::engine_frame::EngineFrame;
use fbptr_core::draw2d::Rect;
use fbptr_core::error::{Code, Fault};
use fbptr_core::memory::{MemoryBudget, MemoryUse, VideoMemory};
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
    canvases: BTreeMap<String, Box<EngineFrame>>,
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
        Some([canvas.width(), canvas.height()])
    }

    /// Returns the number of bytes of all canvases.
    pub fn bytes(&self) -> u64 {
        self.canvases.iter().map(|(name, canvas)| NAME_BYTES + name.len() as u64 + canvas.held_bytes()).sum()
    }

    /// Returns a canvas that is not the target.
    pub fn canvas(&self, name: &str) -> Option<&VideoMemory> {
        self.canvases.get(name).map(|canvas| &canvas.memory)
    }

    /// Swaps the frame with the target's canvas, if there is one. The same call swaps them back.
    pub(crate) fn swap_target(&mut self, frame: &mut EngineFrame) {
        if let Some(canvas) = self.target.as_ref().and_then(|name| self.canvases.get_mut(name)) {
            std::mem::swap(frame, canvas);
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
        let old = self.canvases.get(&name).map_or(0, |canvas| canvas.held_bytes());
        let bytes = u64::from(width) * u64::from(height) * 4 + NAME_BYTES + name.len() as u64;
        let in_use = resource_bytes + self.bytes() - old;
        if in_use + bytes > limits.resource_bytes {
            let message = format!(
                "the resources of a connection may take {} bytes, and {in_use} are in use",
                limits.resource_bytes
            );
            return Err(Fault::new(Code::Quota, message).got(name));
        }
        if !self.canvases.contains_key(&name) && self.canvases.len() >= limits.names {
            let message = format!("no more than {} canvases of a connection, all in use", limits.names);
            return Err(Fault::new(Code::Quota, message).got(name));
        }
        let mut canvas = EngineFrame::new(width, height, budget, MemoryUse::Resources)?;
        canvas.memory.clear([0; 4]);
        self.canvases.insert(name, Box::new(canvas));
        Ok(())
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
        self.canvases.remove(name).is_some()
    }
}

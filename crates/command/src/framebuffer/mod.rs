//! The framebuffer of a program that draws by itself: video memory, depth memory and pick buffer,
//! with a method for each drawing verb of the command language.
//!
//! In: coordinates in pixels, plain colours, text, meshes and scenes. Out: the bytes of the video
//! memory, files, or the verdict of a golden test. All of it runs on the calling thread; no thread
//! is started and no clock is read. Files are opened by [`Framebuffer::load_obj`],
//! [`Framebuffer::save`] and the golden tests alone.
//!
//! Promise: a method draws the bytes of the verb that its documentation names; figures are clipped
//! to the frame without an error. `tests/drawing/framebuffer.rs` compares every method with its
//! verb.

mod draw2d;
mod draw3d;
#[cfg(feature = "embedded-graphics")]
mod embedded;
mod files;

pub use draw3d::{DrawReport, DrawState, Drawable, InvisibleDraw};

use fbptr_core::draw2d::Blend;
use fbptr_core::memory::{DepthMemory, MemoryError, PickBuffer, Rgba, VideoMemory};
use fbptr_core::pipeline::{Renderer, Target};
use fbptr_formats::save;

/// A frame of pixels with everything that drawing on it needs.
///
/// ```
/// let mut fb = fbptr_command::Framebuffer::new(64, 48)?;
/// fb.clear([0, 0, 64, 255]);
/// fb.line([0, 0], [63, 47], [255, 255, 0, 255]);
/// fb.text([2, 2], "hello", [255, 255, 255, 255]);
/// assert_eq!(fb.get_pixel(0, 0)?, [255, 255, 0, 255]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Framebuffer {
    memory: VideoMemory,
    /// Created by the first draw that needs it.
    depth: Option<DepthMemory>,
    /// `None` until [`Framebuffer::enable_picking`].
    ids: Option<PickBuffer>,
    renderer: Renderer,
    blend: Blend,
    text_size: u8,
    /// Settings of the next [`Framebuffer::draw`].
    pub state: DrawState,
}

impl Framebuffer {
    /// Allocates a frame of `width` x `height` pixels, opaque black.
    ///
    /// # Errors
    /// If a side is not in 1..=[`MAX_SIDE`](fbptr_core::memory::MAX_SIDE), or the system has no memory
    /// for the frame.
    pub fn new(width: u32, height: u32) -> Result<Self, MemoryError> {
        VideoMemory::new(width, height).map(Self::from)
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.memory.width()
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.memory.height()
    }

    /// Returns the video memory: the frame's bytes, and the rows that changed.
    pub fn memory(&self) -> &VideoMemory {
        &self.memory
    }

    /// Returns the video memory for writing.
    pub fn memory_mut(&mut self) -> &mut VideoMemory {
        &mut self.memory
    }

    /// Returns the depth memory, or `None` before the first draw that needed it.
    pub fn depth(&self) -> Option<&DepthMemory> {
        self.depth.as_ref()
    }

    /// Returns the blend mode of single pixels and figures.
    pub fn blend(&self) -> Blend {
        self.blend
    }

    /// Sets the blend mode of single pixels and figures, as `BLEND` does.
    pub fn set_blend(&mut self, blend: Blend) {
        self.blend = blend;
    }

    /// Returns the renderer.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }

    /// Replaces the renderer, for example by one with a pool of threads. The bytes that it draws do
    /// not depend on the pool.
    pub fn set_renderer(&mut self, renderer: Renderer) {
        self.renderer = renderer;
    }

    /// Returns the memories as the target of a draw call of the pipeline.
    pub fn target(&mut self) -> Target<'_> {
        Target {
            memory: &mut self.memory,
            depth: &mut self.depth,
            depth_format: self.state.depth_format,
            ids: self.ids.as_mut(),
        }
    }

    /// Fills the frame with `color`, and clears depth memory and pick buffer, as `CLEAR` does.
    pub fn clear(&mut self, color: Rgba) {
        let [columns, rows] = self.memory.clip();
        match self.memory.is_clipped() {
            true => self.memory.clear_rows(rows.clone(), color),
            false => self.renderer.clear(&mut self.memory, color),
        }
        if let Some(depth) = &mut self.depth {
            if self.memory.is_clipped() { depth.clear_within(&columns, &rows) } else { depth.clear() }
        }
        if let Some(ids) = &mut self.ids {
            if self.memory.is_clipped() { ids.clear_within(&columns, &rows) } else { ids.clear() }
        }
    }

    /// Returns the CRC-32 (ISO-HDLC) of the frame's RGBA bytes, as `CRC` does.
    pub fn crc(&self) -> u32 {
        save::crc32(&self.memory)
    }
}

impl From<VideoMemory> for Framebuffer {
    /// Takes over a frame with its pixels.
    fn from(memory: VideoMemory) -> Self {
        Framebuffer {
            memory,
            depth: None,
            ids: None,
            renderer: Renderer::default(),
            blend: Blend::default(),
            text_size: 1,
            state: DrawState::default(),
        }
    }
}

impl From<Framebuffer> for VideoMemory {
    fn from(framebuffer: Framebuffer) -> Self {
        framebuffer.memory
    }
}

impl AsRef<VideoMemory> for Framebuffer {
    fn as_ref(&self) -> &VideoMemory {
        &self.memory
    }
}

//! Memory of the viewer's pictures: video memory, depth and face ids.

use fbptr_core::memory::{DepthFormat, DepthMemory, MemoryError, PickBuffer, VideoMemory};
use fbptr_core::pipeline::Target;

/// Video memory, with depth and face ids where they are needed.
pub(super) struct ViewerFrame {
    pub memory: VideoMemory,
    pub depth: Option<DepthMemory>,
    pub ids: Option<PickBuffer>,
    pub depth_format: DepthFormat,
}

impl ViewerFrame {
    pub fn new([width, height]: [u32; 2]) -> Result<Self, MemoryError> {
        Ok(ViewerFrame {
            memory: VideoMemory::new(width, height)?,
            depth: None,
            ids: None,
            depth_format: DepthFormat::default(),
        })
    }

    /// Clears everything. Ids are stored only if depth is.
    pub fn clear(&mut self, keeps_depth: bool) {
        self.memory.clear(VideoMemory::CLEAR);
        if !keeps_depth {
            self.ids = None;
        } else if self.ids.is_none() {
            self.ids = Some(PickBuffer::new(self.memory.width(), self.memory.height()));
        }
        self.depth = None;
        self.ids.iter_mut().for_each(PickBuffer::clear);
    }

    pub fn target(&mut self) -> Target<'_> {
        Target {
            memory: &mut self.memory,
            depth: &mut self.depth,
            depth_format: self.depth_format,
            ids: self.ids.as_mut(),
        }
    }
}

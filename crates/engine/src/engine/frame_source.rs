//! Another source of the frame than commands: a device whose memory programs write to.

use super::Engine;
use fbptr_core::memory::VideoMemory;

impl Engine {
    /// Lets `write` change the frame between two commands, and shows what it marked as changed.
    /// `None` while a command is in pieces: the frame is then the command's.
    pub fn write_frame<T>(&mut self, write: impl FnOnce(&mut VideoMemory) -> T) -> Option<T> {
        if self.is_in_pieces {
            return None;
        }
        let result = write(&mut self.framebuffer.memory);
        self.show();
        Some(result)
    }
}

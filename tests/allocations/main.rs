//! Programs under an allocator that counts: what a steady frame asks of the system, what a plan states
//! that it holds, and that draws and decoders stay within their budget.
//!
//! They share no process with other tests, whose memory would be counted with theirs; one counts at a time.

mod counting;
mod decoder_memory;
mod draw_memory;
mod stated_memory;
mod steady_frame;
mod text_of_scenes;

/// Held by the test that counts.
static TURN: std::sync::Mutex<()> = std::sync::Mutex::new(());

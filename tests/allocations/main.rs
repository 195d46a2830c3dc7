//! Tests under a counting allocator: a steady frame allocates nothing, a plan's stated memory
//! matches the memory that is held, objects of connections are counted, and draws and decoders
//! stay within their budget.
//!
//! They share no process with other tests, whose memory would be counted with theirs, and run one
//! at a time.

mod counting;
mod decoder_memory;
mod draw_memory;
mod held_memory;
mod stated_memory;
mod steady_frame;
mod text_of_scenes;

/// Serializes the tests; held by the one that counts.
static TURN: std::sync::Mutex<()> = std::sync::Mutex::new(());

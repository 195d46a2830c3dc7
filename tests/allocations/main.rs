//! Programs under an allocator that counts: what a steady frame asks of the system, and what a plan states that it holds.
//!
//! They share no process with other tests, whose memory would be counted with theirs; one counts at a time.

mod counting;
mod stated_memory;
mod steady_frame;

/// Held by the test that counts.
static TURN: std::sync::Mutex<()> = std::sync::Mutex::new(());

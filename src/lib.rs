//! An emulated video memory that programs draw into by commands.
//!
//! The rooms, in the order that data walks through them; imports go down the layers only (`tests/layers.rs` checks it).
#![deny(unsafe_code)]
#![warn(missing_docs)]

// 0: numbers, kernels, refusal codes
pub mod error;
pub mod math;
pub mod simd;
// 1: what there is
pub mod memory;
pub mod scene;
// 2: drawing
pub mod draw2d;
pub mod eye;
pub mod pipeline;
pub mod truth;
// 3: in and out, without a thread
pub mod command;
pub mod load;
pub mod save;
// 4: the render thread
pub mod server;
// 5: the screen, the measurements
pub mod measure;
#[cfg(feature = "window")]
pub mod window;
// 6: the command line
pub mod cli;

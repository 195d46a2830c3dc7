//! An emulated video memory that programs draw into by commands.
#![deny(unsafe_code)]
#![warn(missing_docs)]

pub mod command;
pub mod error;
pub mod math;
pub mod memory;
pub mod scene;

//! Values of arguments: addresses, colours, frame sizes, the CRT look.

pub(in crate::cli) mod address;
pub(in crate::cli) mod color;
pub(in crate::cli) mod crt;
pub(in crate::cli) mod size;

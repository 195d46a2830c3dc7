//! Values of arguments: addresses, colours, frame sizes.

pub(in crate::cli) mod address;
pub(in crate::cli) mod color;
pub(in crate::cli) mod size;

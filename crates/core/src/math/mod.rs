//! Numeric foundations: spaces, matrices, fixed point, exact coverage.
//!
//! No I/O, no threads, no clock. Nothing here uses FMA or the system's libm, so equal input gives
//! equal bits on every machine: `+ - * / sqrt` in a fixed order, and the `libm` crate for the rest.

pub mod bresenham;
pub mod coverage;
pub(crate) mod double_double;
pub mod matrix;
pub mod nvec;
pub mod polygon;
pub mod power;
pub mod projection;
pub(crate) mod snapped_line;
mod sort3;

pub use sort3::sort3;

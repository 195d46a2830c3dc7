//! The tour, drawn by the lean core alone: no thread, no clock, no file.
//!
//! In: the commands of `demos/tour.fbs`, compiled in. Out: the CRC-32 of each frame. Built for
//! WebAssembly it exports [`tour_crc`], which `.ci/lean` calls under Node; the program `crcs` prints
//! the same numbers on other systems. They are equal if the lean core draws the same bytes
//! everywhere.

mod tour;

pub use tour::Tour;

use std::sync::OnceLock;

/// The size that the tour is made for.
pub const TOUR_SIZE: [u32; 2] = [480, 360];

/// Returns the CRC-32 of frame `number` of the tour, from 1; 0 if there is no such frame. The first
/// call draws them all.
// SAFETY: no other function of a program that links this crate has this name.
#[unsafe(no_mangle)]
pub extern "C" fn tour_crc(number: u32) -> u32 {
    static CRCS: OnceLock<Vec<u32>> = OnceLock::new();
    let crcs = CRCS.get_or_init(|| Tour::play().map_or_else(|_| Vec::new(), |tour| tour.crcs().to_vec()));
    crcs.get((number as usize).wrapping_sub(1)).copied().unwrap_or(0)
}

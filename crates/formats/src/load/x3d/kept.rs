//! Append-only storage with stable references: texts and XML trees that others borrow until a scene
//! is read.
//!
//! In: values, through a shared reference. Out: references that live as long as the store. The
//! number of values is limited, as a scene has a limited number of files.

use std::cell::{Cell, OnceCell};

/// Values per block (allocated with its first value), and number of blocks.
const BLOCK: usize = 32;
const BLOCKS: usize = 32;

/// Most values, and so the most files of a scene.
pub(super) const MAX_FILES: usize = BLOCK * BLOCKS;

/// A store of at most [`MAX_FILES`] values that never move.
pub(super) struct Kept<T> {
    blocks: [OnceCell<Box<[OnceCell<T>]>>; BLOCKS],
    count: Cell<usize>,
}

impl<T> Kept<T> {
    pub(super) fn new() -> Self {
        Kept { blocks: [const { OnceCell::new() }; BLOCKS], count: Cell::new(0) }
    }

    /// Stores a value and returns a reference to it; `None` if there are [`MAX_FILES`] already.
    pub(super) fn push(&self, value: T) -> Option<&T> {
        let at = self.count.get();
        let block = self.blocks.get(at / BLOCK)?;
        self.count.set(at + 1);
        let block = block.get_or_init(|| (0..BLOCK).map(|_| OnceCell::new()).collect());
        Some(block[at % BLOCK].get_or_init(|| value))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stay_and_there_is_an_end() {
        let kept = Kept::new();
        let all: Vec<&String> = (0..MAX_FILES).map(|i| kept.push(i.to_string()).unwrap()).collect();
        assert!(all.iter().enumerate().all(|(i, s)| **s == i.to_string()));
        assert!(kept.push(String::new()).is_none());
    }
}

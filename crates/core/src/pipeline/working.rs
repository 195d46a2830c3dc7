//! Working memory of draws: its parts, and their reservation in a budget.
//!
//! Each part is kept from draw to draw and grows to the most that any draw needed, so a renderer
//! holds the sum of the maxima; it reserves that in its budget before it draws. Nothing is allocated
//! here.

use crate::memory::{MemoryBudget, MemoryUse, OverBudget, Reservation};
use std::ops::{Index, IndexMut};

/// Bytes per face of a list of faces, (object index, triangle index).
pub(crate) const FACE_ENTRY_BYTES: u64 = size_of::<(usize, u32)>() as u64;
/// Bytes per key for sorting such a list: a depth and the face.
pub(crate) const SORT_KEY_BYTES: u64 = size_of::<(f64, usize, u32)>() as u64;

/// One part of the working memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Working {
    /// Screen vertices.
    ScreenVertices,
    /// Vertex depths in f64.
    DepthVertices,
    /// Normals in shading space.
    Normals,
    /// Light at vertices: all of it, or the part that a texture multiplies.
    Lit,
    /// Light at vertices that no texture multiplies.
    Specular,
    /// Positions in shading space.
    Positions,
    /// Materials and lights in the kernels' layout.
    Surfaces,
    /// Face lists of the tiles.
    Lists,
    /// Data and face lists of batched small draws.
    DrawBatch,
    /// Vertices of the plain path.
    Vertices,
    /// Lists of faces drawn in submission order.
    Order,
    /// Keys for sorting such faces.
    Sort,
    /// Prepared faces of such lists.
    Made,
    /// Edges of a wireframe; freed after each draw.
    Edges,
    /// Objects of a scene.
    Objects,
}

/// Number of parts.
const COUNT: usize = Working::Objects as usize + 1;

/// Bytes of each part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct WorkingBytes([u64; COUNT]);

impl Index<Working> for WorkingBytes {
    type Output = u64;

    fn index(&self, memory: Working) -> &u64 {
        &self.0[memory as usize]
    }
}

impl IndexMut<Working> for WorkingBytes {
    fn index_mut(&mut self, memory: Working) -> &mut u64 {
        &mut self.0[memory as usize]
    }
}

impl WorkingBytes {
    /// Returns the total, saturating.
    pub fn sum(&self) -> u64 {
        self.0.iter().fold(0, |sum, bytes| sum.saturating_add(*bytes))
    }

    /// Raises each part to at least its size in `other`.
    pub fn cover(&mut self, other: &WorkingBytes) {
        self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own = (*own).max(other));
    }
}

/// A renderer's budget reservation for its working memory.
#[derive(Debug)]
pub(crate) struct WorkingMemory {
    held: Reservation,
    /// Size that each part may have grown to.
    bytes: WorkingBytes,
}

impl Default for WorkingMemory {
    fn default() -> Self {
        WorkingMemory::of(&MemoryBudget::unlimited())
    }
}

/// Unused bytes that stay reserved between draws, so that small draws reserve once.
const SLACK_BYTES: u64 = 32 << 20;

impl WorkingMemory {
    /// Creates an empty reservation from `budget`.
    pub fn of(budget: &MemoryBudget) -> Self {
        WorkingMemory { held: budget.empty(MemoryUse::Draws), bytes: WorkingBytes::default() }
    }

    /// Returns the budget.
    pub fn budget(&self) -> &MemoryBudget {
        self.held.budget()
    }

    /// Returns the reserved bytes.
    pub fn bytes(&self) -> u64 {
        self.held.bytes()
    }

    /// Reserves the bytes still missing for each part to grow to `required`.
    ///
    /// # Errors
    /// When the budget has less than that free.
    pub fn reserve(&mut self, required: &WorkingBytes) -> Result<(), OverBudget> {
        let mut all = self.bytes;
        all.cover(required);
        if all != self.bytes {
            self.held.try_cover(all.sum())?;
            self.bytes = all;
        }
        Ok(())
    }

    /// Returns whether the reservation exceeds the slack that is kept between draws.
    pub fn is_large(&self) -> bool {
        self.held.bytes() > SLACK_BYTES
    }

    /// Records the bytes held after a draw for the tiles' lists and the draw batch, and that edges
    /// were freed. Gives back the excess if it is more than the slack.
    pub fn shrink_reservation(&mut self, lists: u64, draw_batch: u64) {
        let mut now = self.bytes;
        (now[Working::Lists], now[Working::DrawBatch], now[Working::Edges]) = (lists, draw_batch, 0);
        if self.bytes.sum() > now.sum() + SLACK_BYTES {
            self.bytes = now;
            self.held.shrink_to(now.sum());
        }
    }

    /// Records that all parts were freed.
    pub fn clear(&mut self) {
        self.bytes = WorkingBytes::default();
        self.held.shrink_to(0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(parts: &[(Working, u64)]) -> WorkingBytes {
        let mut bytes = WorkingBytes::default();
        parts.iter().for_each(|(memory, size)| bytes[*memory] = *size);
        bytes
    }

    #[test]
    fn each_memory_is_reserved_at_its_largest_until_it_is_given_back() {
        let budget = MemoryBudget::new(5000);
        let mut working = WorkingMemory::of(&budget);
        let mut reserve = |parts: &[(Working, u64)]| working.reserve(&of(parts)).is_ok();
        assert!(reserve(&[(Working::Lit, 1000), (Working::Lists, 300)]) && budget.used() == 1300);
        assert!(reserve(&[(Working::Lit, 400), (Working::Lists, 500)]) && budget.used() == 1500);
        assert!(!reserve(&[(Working::Specular, 3501)]) && budget.used() == 1500);
        assert!(reserve(&[(Working::Specular, 3500)]) && budget.used() == 5000);
        assert_eq!(working.bytes(), 5000);
        working.clear();
        assert_eq!((working.bytes(), budget.used()), (0, 0));
        // Freed parts must be reserved again.
        working.reserve(&of(&[(Working::Lit, 700)])).unwrap();
        assert_eq!((working.bytes(), budget.used()), (700, 700));
    }

    #[test]
    fn reserved_bytes_that_nothing_holds_are_given_back_where_they_are_many() {
        for (edges, left) in [(SLACK_BYTES, SLACK_BYTES + 10), (SLACK_BYTES + 1, 10)] {
            let budget = MemoryBudget::unlimited();
            let mut working = WorkingMemory::of(&budget);
            working.reserve(&of(&[(Working::Lit, 10), (Working::Edges, edges)])).unwrap();
            assert!(working.is_large());
            working.shrink_reservation(0, 0);
            assert_eq!((working.bytes(), working.is_large()), (left, left > SLACK_BYTES));
        }
    }
}

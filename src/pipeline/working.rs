//! Working memory of draws: which memories there are, and what each takes at worst.
//!
//! In: a draw and its plan. Out: bytes at worst, memory by memory. A memory is kept from draw to draw and grows to the most that
//! any draw asked of it; so what a renderer holds is the sum of the largest, which it reserves in its budget before it draws.
//! Nothing is allocated here. One would know by tests/allocations/draw_memory.rs, which compares with an allocator that counts.

use super::depth_sort::{FACE_ENTRY_BYTES, SORT_KEY_BYTES};
use super::draw_call::{DrawCall, Target};
use super::lines::wire_bytes;
use super::ordered::face_list_bytes;
use super::plan::{Part, Plan};
use super::tile::{DEPTH_VERTEX_BYTES, SCREEN_VERTEX_BYTES, worst_list_bytes};
use super::tile_frontend::{binding_bytes, working_bytes};
use super::vertex::Vertex;
use crate::memory::{MemoryBudget, MemoryUse, OverBudget, Reservation};
use crate::scene::ShadeMode;
use std::ops::{Index, IndexMut};

/// A memory that draws work in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Working {
    /// Vertices on the screen.
    ScreenVertices,
    /// Their depths in f64.
    DepthVertices,
    /// Normals in the shading frame.
    Normals,
    /// Points that are lit before pixels are: all of it, or what a texture multiplies,
    Lit,
    /// and what it does not.
    Specular,
    /// Positions in the shading frame.
    Positions,
    /// Materials and lights as the kernels read them.
    Surfaces,
    /// Faces that wait for their tiles.
    Lists,
    /// The same of small draws that are drawn together.
    DrawBatch,
    /// Vertices of the plain path.
    Vertices,
    /// Lists of faces that are drawn in order,
    Order,
    /// what sorting them takes,
    Sort,
    /// and faces that are set up for it.
    Made,
    /// Edges of a wireframe; given back after each draw.
    Edges,
    /// Objects of a scene.
    Objects,
}

/// The number of memories.
const COUNT: usize = Working::Objects as usize + 1;

/// Bytes of each memory.
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
    /// The bytes of all memories.
    pub fn sum(&self) -> u64 {
        self.0.iter().fold(0, |sum, bytes| sum.saturating_add(*bytes))
    }

    /// Grows each memory to what `other` asks of it.
    pub fn cover(&mut self, other: &WorkingBytes) {
        self.0.iter_mut().zip(other.0).for_each(|(own, other)| *own = (*own).max(other));
    }
}

/// What a draw asks for at worst by the path that its plan says. `vertices` is the number of its prepared vertices where that is
/// known; its corners are the most that there can be.
pub(crate) fn at_worst(
    call: &DrawCall,
    target: &Target,
    plan: &Plan,
    vertices: Option<u64>,
    (threads, list_bytes): (u64, u64),
) -> WorkingBytes {
    let mesh = &call.geometry.mesh;
    let faces = mesh.triangles.len() as u64;
    if plan.uses(Part::TileRenderer) {
        let most = mesh.corners.len().min(3 * mesh.triangles.len()) as u64;
        let mut bytes = working_bytes(call, target.depth_format, plan, vertices.unwrap_or(most));
        let size = (target.memory.width() as usize, target.memory.height() as usize);
        bytes[Working::Lists] = worst_list_bytes(faces, threads, size, list_bytes);
        return bytes;
    }
    let mut bytes = WorkingBytes::default();
    bytes[Working::Surfaces] = binding_bytes(call);
    if plan.uses(Part::TransformVertices) {
        bytes[Working::Vertices] = mesh.positions.len() as u64 * size_of::<Vertex>() as u64;
    }
    if call.shade == ShadeMode::Wire {
        bytes[Working::Edges] = wire_bytes(mesh);
    } else {
        ordered(&mut bytes, faces, plan.uses(Part::SortFaces));
    }
    bytes
}

/// Draws of so many faces at most are small.
pub(crate) const SMALL_FACES: usize = 512;

/// What a small draw asks for at worst by the tile renderer, whatever its state; its materials take `surfaces` bytes.
pub(crate) fn small_at_worst(
    surfaces: u64,
    target: &Target,
    (threads, list_bytes): (u64, u64),
) -> WorkingBytes {
    let (faces, size) =
        (SMALL_FACES as u64, (target.memory.width() as usize, target.memory.height() as usize));
    let mut bytes = WorkingBytes::default();
    bytes[Working::ScreenVertices] = 3 * faces * SCREEN_VERTEX_BYTES + faces;
    bytes[Working::DepthVertices] = 3 * faces * DEPTH_VERTEX_BYTES;
    for table in [Working::Normals, Working::Lit, Working::Specular, Working::Positions] {
        bytes[table] = 3 * faces * SCREEN_VERTEX_BYTES;
    }
    bytes[Working::Surfaces] = surfaces;
    bytes[Working::Lists] = worst_list_bytes(faces, threads, size, list_bytes);
    bytes
}

/// Adds what drawing `faces` faces in order takes: lists have room for twice their items, and while one moves its old room is there.
pub(crate) fn ordered(bytes: &mut WorkingBytes, faces: u64, is_sorted: bool) {
    bytes[Working::Order] = 3 * faces * FACE_ENTRY_BYTES;
    bytes[Working::Sort] = if is_sorted { 3 * faces * SORT_KEY_BYTES } else { 0 };
    bytes[Working::Made] = face_list_bytes(faces);
}

/// What a renderer holds of its budget for the memories that it works in.
#[derive(Debug)]
pub(crate) struct WorkingMemory {
    held: Reservation,
    /// What each memory may have grown to.
    bytes: WorkingBytes,
}

impl Default for WorkingMemory {
    fn default() -> Self {
        WorkingMemory::of(&MemoryBudget::unlimited())
    }
}

/// Reserved bytes that stay reserved between draws though nothing holds them: small draws then reserve once.
const SLACK_BYTES: u64 = 32 << 20;

impl WorkingMemory {
    /// Nothing yet, of this budget.
    pub fn of(budget: &MemoryBudget) -> Self {
        WorkingMemory { held: budget.empty(MemoryUse::Draws), bytes: WorkingBytes::default() }
    }

    /// The budget.
    pub fn budget(&self) -> &MemoryBudget {
        self.held.budget()
    }

    /// Bytes that are reserved.
    pub fn bytes(&self) -> u64 {
        self.held.bytes()
    }

    /// Reserves what is still missing for the memories to grow to `wanted`.
    ///
    /// # Errors
    /// When it is more than what is free.
    pub fn reserve(&mut self, required: &WorkingBytes) -> Result<(), OverBudget> {
        let mut all = self.bytes;
        all.cover(required);
        if all != self.bytes {
            self.held.try_cover(all.sum())?;
            self.bytes = all;
        }
        Ok(())
    }

    /// Whether much more may be reserved than is held between draws.
    pub fn is_large(&self) -> bool {
        self.held.bytes() > SLACK_BYTES
    }

    /// States what is held for the tiles' lists and for draws that are drawn together after a draw, and that edges were given
    /// back.
    pub fn shrink_reservation(&mut self, lists: u64, draw_batch: u64) {
        let mut now = self.bytes;
        (now[Working::Lists], now[Working::DrawBatch], now[Working::Edges]) = (lists, draw_batch, 0);
        if self.bytes.sum() > now.sum() + SLACK_BYTES {
            self.bytes = now;
            self.held.shrink_to(now.sum());
        }
    }

    /// States that all memories were given back.
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
        // What was given back must be asked for again.
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

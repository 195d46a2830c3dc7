//! Deduplication of corners: each combination of attributes that occurs becomes one vertex.
//!
//! In: the corners of a mesh, face by face. Out: the vertex index of each. Vertices of one position
//! form a linked list, since most positions have one; where a list grows long, its vertices are
//! found by a hash, so that no mesh takes quadratic time. The indices do not depend on the hash:
//! they are assigned in the order of the corners. Runs on the calling thread.
//!
//! Verified by the test below, which puts all corners at two positions.

use crate::scene::Corner;
use glam::DVec3;
use std::collections::HashMap;
use std::hash::{BuildHasher, RandomState};

/// Key of a vertex: its corner without the normal, its material's index, and its normal.
pub(super) type VertexKey = (Corner, u32, DVec3);

/// Length of the longest list that is searched.
const LONGEST_CHAIN: usize = 16;

/// End of a list.
const NONE: i32 = -1;
/// In place of a list's first vertex: the vertices of this position are found by their hash.
const CROWDED: i32 = -2;

/// Bytes that a vertex takes here at most: in the lists, whose capacity is up to twice their items
/// and which move, and in the hash table.
pub(super) const DISTINCT_BYTES: u64 = 3 * (size_of::<VertexKey>() + 4) as u64 + 56;

/// Vertices found so far, with an index by position.
pub(super) struct Distinct {
    /// Last vertex of each position.
    first: Vec<i32>,
    /// For each vertex, the one before it in its list.
    next: Vec<i32>,
    keys: Vec<VertexKey>,
    /// Last vertex of each hash of crowded positions' keys.
    crowded: HashMap<u64, i32>,
    hasher: RandomState,
    /// Number of vertices that the last search passed.
    passed: usize,
}

impl Distinct {
    /// Creates an empty set for this number of positions.
    pub fn new(positions: usize) -> Self {
        Distinct {
            first: vec![NONE; positions],
            next: Vec::new(),
            keys: Vec::new(),
            crowded: HashMap::new(),
            hasher: RandomState::new(),
            passed: 0,
        }
    }

    /// Returns the number of vertices.
    pub fn len(&self) -> usize {
        self.keys.len()
    }

    /// Returns the vertex of a key, if there is one.
    #[inline]
    pub fn find(&mut self, key: &VertexKey) -> Option<i32> {
        let mut vertex = self.first[key.0.position as usize];
        if vertex == CROWDED {
            vertex = self.crowded.get(&self.hash(key)).copied().unwrap_or(NONE);
        }
        self.passed = 0;
        while vertex >= 0 && self.keys[vertex as usize] != *key {
            vertex = self.next[vertex as usize];
            self.passed += 1;
        }
        (vertex >= 0).then_some(vertex)
    }

    /// Adds a key that the last search did not find; returns the index of its vertex.
    #[inline]
    pub fn add(&mut self, key: VertexKey) -> i32 {
        let (vertex, position) = (self.keys.len() as i32, key.0.position as usize);
        self.keys.push(key);
        if self.passed >= LONGEST_CHAIN || self.first[position] == CROWDED {
            self.add_crowded(vertex, position);
        } else {
            self.next.push(std::mem::replace(&mut self.first[position], vertex));
        }
        vertex
    }

    #[cold]
    fn add_crowded(&mut self, vertex: i32, position: usize) {
        self.next.push(NONE);
        let mut at = std::mem::replace(&mut self.first[position], CROWDED);
        while at >= 0 {
            let before = self.next[at as usize];
            self.chain_by_hash(at);
            at = before;
        }
        self.chain_by_hash(vertex);
    }

    fn chain_by_hash(&mut self, vertex: i32) {
        let hash = self.hash(&self.keys[vertex as usize]);
        let last = self.crowded.insert(hash, vertex);
        self.next[vertex as usize] = last.unwrap_or(NONE);
    }

    /// Hashes a key. Equal keys have equal hashes: -0 hashes as 0, and normals are not NaN.
    fn hash(&self, (corner, material, normal): &VertexKey) -> u64 {
        let normal = normal.to_array().map(|v| (v + 0.0).to_bits());
        self.hasher.hash_one((corner.position, corner.texcoord, corner.color, *material, normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene;

    #[test]
    fn many_vertices_at_one_position_are_found_and_numbered_as_few_are() {
        // A linear search of these would take hours.
        const COUNT: u32 = 300_000;
        let key = |i: u32| {
            let corner = Corner { position: i % 2, texcoord: i / 2, color: scene::NONE, normal: scene::NONE };
            let sign = if i.is_multiple_of(3) { -0.0 } else { 0.0 };
            (corner, 7, DVec3::new(1.0, sign, 0.0))
        };
        let mut distinct = Distinct::new(2);
        for i in 0..COUNT {
            assert_eq!(distinct.find(&key(i)), None);
            assert_eq!(distinct.add(key(i)), i as i32);
        }
        assert_eq!(distinct.len(), COUNT as usize);
        for i in 0..COUNT {
            let (corner, material, normal) = key(i);
            assert_eq!(distinct.find(&(corner, material, normal * -1.0 * -1.0)), Some(i as i32));
            assert_eq!(distinct.find(&(corner, material, DVec3::new(1.0, -normal.y, 0.0))), Some(i as i32));
        }
        assert_eq!(distinct.find(&(key(0).0, 8, key(0).2)), None);
        assert_eq!(distinct.find(&(key(0).0, 7, DVec3::Y)), None);
    }
}

//! Two pictures of one size, and what they alone tell about a wrong pixel.

use super::{Class, distance};
use fbptr_core::memory::{Rgba, VideoMemory};
use std::collections::HashMap;

/// Difference up to which two colours of one surface count as the same.
const SURFACE: u8 = 12;
/// Number of neighbours at most that are wrong, too, for a pixel to be an edge's: those along it.
const ALONG_EDGE: usize = 5;

/// The two pictures.
pub(super) struct Pixels<'a> {
    pub mine: &'a VideoMemory,
    pub exact: &'a VideoMemory,
    /// Width and height.
    pub size: [u32; 2],
    /// The commonest colour of the exact picture's border.
    pub background: Rgba,
    per_channel: u8,
}

/// Returns a picture's pixel; `None` outside.
pub(super) fn pixel(memory: &VideoMemory, x: i64, y: i64) -> Option<Rgba> {
    let (w, h) = (i64::from(memory.width()), i64::from(memory.height()));
    if !(0..w).contains(&x) || !(0..h).contains(&y) {
        return None;
    }
    memory.bytes().as_chunks::<4>().0.get((y * w + x) as usize).copied()
}

impl<'a> Pixels<'a> {
    pub fn new(mine: &'a VideoMemory, exact: &'a VideoMemory, per_channel: u8) -> Self {
        let size = [exact.width(), exact.height()];
        Pixels { mine, exact, size, background: background(exact), per_channel }
    }

    pub fn mine_at(&self, [x, y]: [u32; 2]) -> Rgba {
        pixel(self.mine, x.into(), y.into()).unwrap_or_default()
    }

    pub fn exact_at(&self, [x, y]: [u32; 2]) -> Rgba {
        pixel(self.exact, x.into(), y.into()).unwrap_or_default()
    }

    pub fn distance(&self, at: [u32; 2]) -> u8 {
        distance(self.mine_at(at), self.exact_at(at))
    }

    pub fn is_same(&self, a: Rgba, b: Rgba) -> bool {
        distance(a, b) <= self.per_channel
    }

    /// Returns the pixels that differ, row by row.
    pub fn wrong(&self) -> Vec<[u32; 2]> {
        let (a, b) = (self.mine.bytes().as_chunks::<4>().0, self.exact.bytes().as_chunks::<4>().0);
        let pairs = (0u32..).zip(a.iter().zip(b));
        pairs
            .filter(|(_, (a, b))| !self.is_same(**a, **b))
            .map(|(i, _)| [i % self.size[0], i / self.size[0]])
            .collect()
    }

    /// Returns whether mine has, at a place, the colour of a neighbour across an edge in the exact
    /// picture. A pixel in the midst of wrong ones has it by accident.
    pub fn is_from_neighbor(&self, [x, y]: [u32; 2]) -> bool {
        let (found, own) = (self.mine_at([x, y]), self.exact_at([x, y]));
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (i64::from(x) + dx, i64::from(y) + dy)));
        let around = around.filter(|at| *at != (x.into(), y.into()));
        let pairs = around.filter_map(|(x, y)| Some((pixel(self.mine, x, y)?, pixel(self.exact, x, y)?)));
        let (mut is_from, mut wrong) = (false, 0);
        for (mine, exact) in pairs {
            is_from |= distance(exact, found) <= SURFACE.min(distance(exact, own).saturating_sub(1));
            wrong += usize::from(!self.is_same(mine, exact));
        }
        is_from && wrong <= ALONG_EDGE
    }

    /// Returns the class of a pixel that nothing else explains. With a known geometry an edge is
    /// one of the geometry.
    pub fn class(&self, at: [u32; 2], is_known: bool) -> Class {
        let (found, right) = (self.mine_at(at), self.exact_at(at));
        if !is_known && self.is_from_neighbor(at) {
            Class::Edge
        } else if self.is_same(right, self.background) {
            Class::Extra
        } else if self.is_same(found, self.background) {
            Class::Missing
        } else {
            Class::Other
        }
    }
}

/// Returns the commonest colour of a picture's border.
fn background(picture: &VideoMemory) -> Rgba {
    let (w, h) = (i64::from(picture.width()), i64::from(picture.height()));
    let mut counts: HashMap<Rgba, u32> = HashMap::new();
    let sides = (0..w).flat_map(|x| [(x, 0), (x, h - 1)]).chain((0..h).flat_map(|y| [(0, y), (w - 1, y)]));
    for color in sides.filter_map(|(x, y)| pixel(picture, x, y)) {
        *counts.entry(color).or_default() += 1;
    }
    // By colour where counts are equal, so that the answer does not depend on the table's order.
    counts.into_iter().max_by_key(|&(color, n)| (n, color)).map_or([0; 4], |(color, _)| color)
}

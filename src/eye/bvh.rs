//! A hierarchy of boxes over the obstacles, for light rays in scenes of many facets.
//!
//! In: the solids of a frame. Out: those whose box a ray may meet, in a fixed order; never too few: boxes are widened by more
//! than rounding and the closed border of a simplex can reach.

use super::solid::{Solid, Target};
use crate::math::nvec::{max_abs, sub};

/// Facets in a leaf at most.
const LEAF: usize = 4;

/// Boxes are widened by this part of the largest coordinate at hand.
const MARGIN: f64 = 1e-11;

struct Node<const N: usize> {
    low: [f64; N],
    high: [f64; N],
    /// Leaf: first entry in `order`. Inner: index of the second child; the first follows its parent.
    at: u32,
    /// Leaf: number of entries, at least 1. Inner: 0.
    count: u32,
}

/// The hierarchy.
pub(super) struct Bvh<const N: usize> {
    nodes: Vec<Node<N>>,
    order: Vec<u32>,
}

impl<const N: usize> Bvh<N> {
    /// Splits at the median along the widest axis, until few are left.
    pub fn new(solids: &[Solid<N>]) -> Self {
        let mut bvh = Bvh { nodes: Vec::new(), order: (0..solids.len() as u32).collect() };
        let mut order = std::mem::take(&mut bvh.order);
        bvh.build(solids, &mut order, 0);
        bvh.order = order;
        bvh
    }

    fn build(&mut self, solids: &[Solid<N>], order: &mut [u32], first: u32) {
        let of = |i: &u32| &solids[*i as usize];
        let low = std::array::from_fn(|a| {
            order.iter().fold(f64::INFINITY, |m, i| m.min(of(i).low[a] - MARGIN * of(i).size))
        });
        let high = std::array::from_fn(|a| {
            order.iter().fold(f64::NEG_INFINITY, |m, i| m.max(of(i).high[a] + MARGIN * of(i).size))
        });
        let me = self.nodes.len();
        self.nodes.push(Node { low, high, at: first, count: order.len() as u32 });
        if order.len() <= LEAF {
            return;
        }
        let middle = |i: &u32, a: usize| of(i).low[a] + of(i).high[a];
        let spread = |a: usize| {
            let (lo, hi) = order.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), i| {
                (lo.min(middle(i, a)), hi.max(middle(i, a)))
            });
            hi - lo
        };
        let axis = (1..N).fold(0, |best, a| if spread(a) > spread(best) { a } else { best });
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |i, j| middle(i, axis).total_cmp(&middle(j, axis)).then(i.cmp(j)));
        let (left, right) = order.split_at_mut(half);
        self.build(solids, left, first);
        self.nodes[me].at = self.nodes.len() as u32;
        self.nodes[me].count = 0;
        self.build(solids, right, first + half as u32);
    }

    /// The first solid, in the order of the tree, that `test` accepts among those on the way from `p` to the light.
    pub fn find(&self, p: &[f64; N], target: &Target<N>, mut test: impl FnMut(u32) -> bool) -> Option<u32> {
        let (way, end) = match target {
            Target::Point { position, .. } => (sub(position, p), 1.0),
            Target::Sun { direction, .. } => (direction.map(|x| -x), f64::INFINITY),
        };
        let margin = MARGIN * max_abs(p);
        let inverse = way.map(|x| 1.0 / x);
        let mut stack = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let index = stack[depth];
            let node = &self.nodes[index as usize];
            let (mut from, mut to) = (0.0f64, end);
            for a in 0..N {
                let (low, high) = (node.low[a] - margin - p[a], node.high[a] + margin - p[a]);
                if way[a] == 0.0 {
                    if low > 0.0 || high < 0.0 {
                        to = -1.0;
                    }
                } else {
                    let (s, t) = (low * inverse[a], high * inverse[a]);
                    from = from.max(s.min(t));
                    to = to.min(s.max(t));
                }
            }
            if from > to {
                continue;
            }
            if node.count == 0 {
                // Halves at each level: 64 places are enough for 2^32 facets.
                stack[depth] = node.at;
                stack[depth + 1] = index + 1;
                depth += 2;
            } else {
                let leaf = &self.order[node.at as usize..(node.at + node.count) as usize];
                if let Some(&found) = leaf.iter().find(|&&i| test(i)) {
                    return Some(found);
                }
            }
        }
        None
    }
}

//! A bounding volume hierarchy of the obstacles, for light rays in scenes of many facets.
//!
//! In: the occluders of a frame. Out: those whose box a ray may meet, in a fixed order; none is
//! missed, as the boxes are enlarged by more than rounding and the tolerance of a simplex's border.

use super::occluder::{LightTarget, Occluder};
use crate::math::nvec::{max_abs, sub};

/// Largest number of facets in a leaf.
const LEAF: usize = 4;

/// Boxes are enlarged by this fraction of the largest coordinate.
const MARGIN: f64 = 1e-11;

/// A box of the hierarchy.
struct Node<const N: usize> {
    low: [f64; N],
    high: [f64; N],
    /// Leaf: index of the first entry in `order`. Inner node: index of the second child; the first
    /// follows its parent.
    at: u32,
    /// Leaf: number of entries, at least 1. Inner node: 0.
    count: u32,
}

/// The hierarchy, as a flat list of nodes in depth-first order.
pub(super) struct Bvh<const N: usize> {
    nodes: Vec<Node<N>>,
    order: Vec<u32>,
}

/// The enlarged box of an occluder.
struct Item<const N: usize> {
    low: [f64; N],
    high: [f64; N],
}

impl<const N: usize> Bvh<N> {
    /// Builds the hierarchy: splits at the median along the axis with the widest spread of box
    /// centres, until at most `LEAF` facets are left.
    pub fn new(occluders: &[Occluder<N>]) -> Self {
        let item = |occluder: &Occluder<N>| Item {
            low: occluder.low.map(|x| x - MARGIN * occluder.size),
            high: occluder.high.map(|x| x + MARGIN * occluder.size),
        };
        let items: Vec<Item<N>> = occluders.iter().map(item).collect();
        let mut keys: Vec<(f64, u32)> = (0..items.len() as u32).map(|index| (0.0, index)).collect();
        let mut bvh = Bvh { nodes: Vec::with_capacity(items.len()), order: Vec::new() };
        bvh.build(&items, &mut keys, 0);
        bvh.order = keys.into_iter().map(|(_, index)| index).collect();
        bvh
    }

    /// Builds the tree of the items whose indices are in `keys`; the keys' first components are
    /// scratch space.
    fn build(&mut self, items: &[Item<N>], keys: &mut [(f64, u32)], first: u32) {
        let (mut low, mut high) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
        let (mut least, mut most) = (low, high);
        for (_, index) in &*keys {
            let item = &items[*index as usize];
            for a in 0..N {
                low[a] = low[a].min(item.low[a]);
                high[a] = high[a].max(item.high[a]);
                let middle = item.low[a] + item.high[a];
                least[a] = least[a].min(middle);
                most[a] = most[a].max(middle);
            }
        }
        let me = self.nodes.len();
        self.nodes.push(Node { low, high, at: first, count: keys.len() as u32 });
        if keys.len() <= LEAF {
            return;
        }
        let axis =
            (1..N).fold(0, |best, a| if most[a] - least[a] > most[best] - least[best] { a } else { best });
        for (middle, index) in &mut *keys {
            let item = &items[*index as usize];
            *middle = item.low[axis] + item.high[axis];
        }
        let half = keys.len() / 2;
        part_at(keys, half);
        let (left, right) = keys.split_at_mut(half);
        self.build(items, left, first);
        self.nodes[me].at = self.nodes.len() as u32;
        self.nodes[me].count = 0;
        self.build(items, right, first + half as u32);
    }

    /// Returns the number of boxes.
    pub fn boxes(&self) -> usize {
        self.nodes.len()
    }

    /// Returns the first occluder, in the order of the tree, that `test` accepts among those whose
    /// boxes the segment from `p` to the light may meet.
    pub fn find(
        &self,
        p: &[f64; N],
        target: &LightTarget<N>,
        mut test: impl FnMut(u32) -> bool,
    ) -> Option<u32> {
        let (way, end) = match target {
            LightTarget::Radial { position } | LightTarget::Foot { position } => (sub(position, p), 1.0),
            LightTarget::Sun { direction } => (direction.map(|x| -x), f64::INFINITY),
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
                // Each level halves the items: 64 entries are enough for 2^32 facets.
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

/// Moves the `half` least keys to the front. Not generic over the dimension, so it is compiled
/// once.
fn part_at(keys: &mut [(f64, u32)], half: usize) {
    keys.select_nth_unstable_by(half, |a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::nvec::{dot, unit, wedge};

    /// Returns a triangle from the corner `at` along the axes, in one of three directions.
    fn triangle(at: [f64; 3], size: f64, turn: usize) -> Occluder<3> {
        let mut v = [at; 3];
        v[1][turn % 3] += size;
        v[2][(turn + 1) % 3] += size;
        v[2][(turn + 2) % 3] += 0.3 * size;
        let normal = unit(wedge(&[sub(&v[1], &v[0]), sub(&v[2], &v[0])], 3));
        Occluder::new(&v, normal, dot(&normal, &v[0]))
    }

    #[test]
    fn a_leaf_holds_neighbours() {
        // At places 0 to 15 along axis 0, in another order, and of sizes in a third one.
        let place = |k: u32| (k * 5 + 3) % 16;
        let all: Vec<Occluder<3>> = (0..16)
            .map(|k| triangle([f64::from(place(k)), 0.0, 0.0], 0.1 + 0.05 * f64::from(k * 7 % 16), 0))
            .collect();
        let bvh = Bvh::new(&all);
        assert_eq!(bvh.boxes(), 7);
        for (leaf, indices) in bvh.order.chunks(LEAF).enumerate() {
            let mut places: Vec<u32> = indices.iter().map(|&k| place(k)).collect();
            places.sort_unstable();
            let first = 4 * leaf as u32;
            assert_eq!(places, [first, first + 1, first + 2, first + 3]);
        }
    }

    #[test]
    fn a_ray_on_the_border_of_a_box_meets_it_and_one_beside_it_does_not() {
        // From the origin, where the margin of rounding is zero, along axis 0.
        let meets = |low: [f64; 3], high: [f64; 3], target: LightTarget<3>| {
            let bvh = Bvh { nodes: vec![Node { low, high, at: 0, count: 1 }], order: vec![0] };
            bvh.find(&[0.0; 3], &target, |_| true).is_some()
        };
        let sun = || LightTarget::Sun { direction: [-1.0, 0.0, 0.0] };
        let lamp = || LightTarget::Radial { position: [2.0, 0.0, 0.0] };
        let least = f64::MIN_POSITIVE;
        let borders = [(0.0, 1.0, true), (-1.0, 0.0, true), (least, 1.0, false), (-1.0, -least, false)];
        for (low, high, is_met) in borders {
            let [first, second] = [[1.0, low, -1.0], [1.0, -1.0, low]];
            let [first_end, second_end] = [[3.0, high, 1.0], [3.0, 1.0, high]];
            assert_eq!(meets(first, first_end, sun()), is_met, "{low} to {high} along axis 1");
            assert_eq!(meets(second, second_end, sun()), is_met, "{low} to {high} along axis 2");
        }
        let along = [
            (2.0, 2.0, [true, true]),
            (2.0, 3.0, [true, true]),
            (2.0 + 1e-9, 3.0, [true, false]),
            (-1.0, 0.0, [true, true]),
            (-1.0, -least, [false, false]),
        ];
        for (low, high, is_met) in along {
            let (low, high) = ([low, -1.0, -1.0], [high, 1.0, 1.0]);
            assert_eq!([sun(), lamp()].map(|target| meets(low, high, target)), is_met, "{low:?} to {high:?}");
        }
    }

    #[test]
    fn what_lies_on_the_way_is_tested_and_little_else() {
        let places = (0..216u32).map(|k| [k % 6, k / 6 % 6, k / 36].map(f64::from));
        let all: Vec<Occluder<3>> =
            places.zip(0..).map(|(at, k)| triangle(at, 0.3 + 0.02 * (k % 7) as f64, k)).collect();
        let bvh = Bvh::new(&all);
        let from_to = [
            ([-1.0, -1.0, -1.0], [7.0, 6.5, 7.2]),
            ([7.0, 3.0, -1.0], [-1.0, 2.0, 6.0]),
            ([-1.0, 2.1, 3.1], [8.0, 2.1, 3.1]),
            ([2.1, 2.05, 9.0], [2.1, 2.05, -1.0]),
            // It ends in the first layer.
            ([0.1, 0.1, -0.5], [0.1, 0.1, 0.2]),
        ];
        for (p, to) in from_to {
            let targets = [
                (LightTarget::Radial { position: to }, 1.0),
                (LightTarget::Foot { position: to }, 1.0),
                (LightTarget::Sun { direction: unit(sub(&p, &to)) }, 20.0),
            ];
            for (target, length) in targets {
                let mut tested = Vec::new();
                let found = bvh.find(&p, &target, |i| {
                    tested.push(i);
                    false
                });
                assert_eq!(found, None);
                assert!(tested.len() < all.len() / 2, "{} of {}", tested.len(), all.len());
                // Points on the way, and the boxes that hold one of them.
                let way = sub(&to, &p);
                let met = |occluder: &Occluder<3>| {
                    (0..=4000).any(|step| {
                        let u = length * f64::from(step) / 4000.0;
                        (0..3).all(|a| (occluder.low[a]..=occluder.high[a]).contains(&(p[a] + u * way[a])))
                    })
                };
                let on_the_way: Vec<u32> = (0..all.len() as u32).filter(|&i| met(&all[i as usize])).collect();
                assert!(!on_the_way.is_empty());
                for i in on_the_way {
                    assert!(tested.contains(&i), "{i} on the way from {p:?} to {to:?}");
                    assert_eq!(bvh.find(&p, &target, |k| k == i), Some(i));
                }
            }
        }
    }
}

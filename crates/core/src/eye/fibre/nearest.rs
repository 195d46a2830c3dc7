//! The nearest points found so far for the pixels of a tile, and the tie rule.
//!
//! Among hits with D <= D_min (1 + 1e-9) the one with the largest facing value q is selected; of
//! those equal within 1e-9 the one with the lowest facet index. The rule is not a total order, so
//! all hits within the tolerance are stored until the end: then the result depends neither on the
//! order of the facets nor on what was pruned.

use super::TILE_PIXELS;

/// Distances within this fraction of each other are a tie, and so are facing values.
pub(crate) const TIE: f64 = 1e-9;

/// (1 + TIE)^2, for squared distances.
const TIE2: f64 = (1.0 + TIE) * (1.0 + TIE);

/// A point of a facet that a pixel may see.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Candidate<const N: usize> {
    /// Squared distance of the point from the eye.
    pub distance2: f64,
    /// Facing value q; 0 where only the index counts.
    pub facing: f64,
    /// Index of the facet in the scene.
    pub id: u32,
    /// Index of the facet among the visible ones.
    pub index: u32,
    /// The point, in eye space.
    pub point: [f64; N],
}

/// The nearest points found for the pixels of a tile.
pub(crate) struct Nearest<const N: usize> {
    limit2: [f64; TILE_PIXELS],
    found: Vec<Vec<Candidate<N>>>,
    /// 1 / |P|^2 for each pixel's direction.
    pub inverse_length2: [f64; TILE_PIXELS],
}

impl<const N: usize> Nearest<N> {
    pub fn new() -> Self {
        Nearest {
            limit2: [f64::INFINITY; TILE_PIXELS],
            found: (0..TILE_PIXELS).map(|_| Vec::with_capacity(16)).collect(),
            inverse_length2: [0.0; TILE_PIXELS],
        }
    }

    /// Clears the results of all pixels.
    pub fn clear(&mut self) {
        self.limit2 = [f64::INFINITY; TILE_PIXELS];
        self.found.iter_mut().for_each(Vec::clear);
    }

    /// Returns the squared distance beyond which no point can be selected for pixel `local`.
    #[inline(always)]
    pub fn limit2(&self, local: usize) -> f64 {
        self.limit2[local]
    }

    /// Returns the largest [`Self::limit2`] of the tile's pixels in `locals`.
    pub fn worst2(&self, locals: std::ops::Range<usize>) -> f64 {
        self.limit2[locals].iter().fold(0.0, |m: f64, x| m.max(*x))
    }

    /// Stores a candidate if it may be selected.
    #[inline]
    pub fn offer(&mut self, local: usize, candidate: Candidate<N>) {
        let limit2 = &mut self.limit2[local];
        if candidate.distance2 <= *limit2 {
            let found = &mut self.found[local];
            if candidate.distance2 * TIE2 < *limit2 {
                *limit2 = candidate.distance2 * TIE2;
                found.retain(|c| c.distance2 <= candidate.distance2 * TIE2);
            }
            found.push(candidate);
        }
    }

    /// Returns the point selected for pixel `local`.
    pub fn winner(&self, local: usize) -> Option<&Candidate<N>> {
        let found = &self.found[local];
        let facing = found.iter().fold(0.0, |m: f64, c| m.max(c.facing));
        found.iter().filter(|c| c.facing >= facing * (1.0 - TIE)).min_by_key(|c| c.id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn winner(hits: &[(f64, f64, u32)]) -> u32 {
        let mut nearest = Nearest::<2>::new();
        for &(d, facing, id) in hits {
            nearest.offer(0, Candidate { distance2: d * d, facing, id, index: id, point: [d, 0.0] });
        }
        nearest.winner(0).unwrap().id
    }

    #[test]
    fn the_tie_rule_does_not_depend_on_the_order() {
        for (hits, want) in [
            // Nearer by more than 1e-9 wins whatever the facing values.
            (vec![(2.0, 0.1, 5), (2.0 * (1.0 + 3e-9), 9.0, 1)], 5),
            // Within 1e-9 the facing value decides, then the index.
            (vec![(2.0, 0.1, 1), (2.0 * (1.0 + 0.5e-9), 0.2, 7)], 7),
            (vec![(2.0, 0.2, 4), (2.0, 0.2 * (1.0 - 0.5e-9), 3)], 3),
            (vec![(2.0, 0.2, 4), (2.0, 0.2 * (1.0 - 3e-9), 3)], 4),
            // A chain: the last is within 1e-9 of the second only.
            (vec![(2.0, 0.1, 1), (2.0 * (1.0 + 0.8e-9), 0.2, 2), (2.0 * (1.0 + 1.6e-9), 0.3, 3)], 2),
        ] {
            let mut order = hits.clone();
            for _ in 0..order.len() {
                order.rotate_left(1);
                assert_eq!(winner(&order), want, "{order:?}");
            }
            order.reverse();
            assert_eq!(winner(&order), want, "{order:?}");
        }
    }
}

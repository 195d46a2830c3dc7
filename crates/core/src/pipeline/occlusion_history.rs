//! Occlusion history of a mesh, which decides whether hierarchical z is used.
//!
//! In: the counts of each draw of the mesh. Out: whether the next draw is to use hierarchical z
//! (`tile/hierarchical_z.rs`), and why. It costs where nothing is hidden, and what it leaves out is
//! not counted alike by every vector level; so only draws without it, whose counts are the same for
//! every level and number of threads, turn it on. Of draws with it the pixels written count alone,
//! which are the same, too.
//!
//! Promise: the decisions depend on the draws alone, and change no byte.

use super::draw_call::DrawStats;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// Number of draws with hierarchical z between two without it.
const DRAWS: u32 = 31;

/// Fragments of a face, on average, below which the test of a face costs what its fragments do.
const FEW_FRAGMENTS: u64 = 16;

/// Number of faces up to which a mesh is drawn without hierarchical z.
pub(crate) const FEW_FACES: u64 = 512;

/// Result of a mesh's last draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Occlusion {
    /// It has not been drawn.
    Unknown,
    /// Little of it was hidden, or its faces are small.
    Seen,
    /// Most of it was hidden a while ago.
    Outdated,
    /// Most of it was hidden; the number of draws for which this holds.
    Hidden(u32),
}

impl Occlusion {
    /// Returns whether hierarchical z pays.
    pub fn pays(self) -> bool {
        matches!(self, Occlusion::Hidden(_))
    }

    /// Returns the reason of that.
    pub fn reason(self) -> &'static str {
        match self {
            Occlusion::Unknown => "the mesh has not been drawn yet, so it is not known what is hidden",
            Occlusion::Seen => "little of the mesh was hidden when it was last drawn, or its faces are small",
            Occlusion::Outdated => "what is hidden of the mesh is counted again",
            Occlusion::Hidden(_) => {
                "most of the mesh was hidden when it was last drawn: by cells of 16x8 pixels"
            }
        }
    }
}

/// The history of a mesh.
#[derive(Debug, Default)]
pub(crate) struct OcclusionHistory {
    /// An [`Occlusion`]: 0 to 2, or 3 and more for what is hidden.
    state: AtomicU32,
    /// Fragments tested by the draw that found most of the mesh hidden.
    tested: AtomicU64,
}

impl OcclusionHistory {
    /// Returns what the last draws have shown.
    pub fn get(&self) -> Occlusion {
        match self.state.load(Relaxed) {
            0 => Occlusion::Unknown,
            1 => Occlusion::Seen,
            2 => Occlusion::Outdated,
            more => Occlusion::Hidden(more - 3),
        }
    }

    fn set(&self, occlusion: Occlusion) {
        let state = match occlusion {
            Occlusion::Unknown => 0,
            Occlusion::Seen => 1,
            Occlusion::Outdated => 2,
            Occlusion::Hidden(draws) => 3 + draws,
        };
        self.state.store(state, Relaxed);
    }

    /// Takes in the counts of a draw, with or without hierarchical z.
    pub fn note(&self, stats: &DrawStats, is_coarse: bool) {
        let DrawStats { pixels_tested: tested, pixels_written: written, .. } = *stats;
        let is_small = tested < FEW_FRAGMENTS * stats.faces_drawn;
        match (is_coarse, self.get()) {
            (false, _) if 4 * written < tested && !is_small => {
                self.tested.store(tested, Relaxed);
                self.set(Occlusion::Hidden(DRAWS));
            }
            (false, _) => self.set(Occlusion::Seen),
            (true, Occlusion::Hidden(left)) => {
                let is_seen = 2 * written >= self.tested.load(Relaxed);
                self.set(match left.checked_sub(1).filter(|_| !is_seen) {
                    Some(left) => Occlusion::Hidden(left),
                    None => Occlusion::Outdated,
                });
            }
            // Of several draws of the mesh in one scene, an earlier one has ended this.
            (true, _) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stats(tested: u64, written: u64) -> DrawStats {
        DrawStats { pixels_tested: tested, pixels_written: written, ..DrawStats::default() }
    }

    #[test]
    fn a_mesh_is_hidden_until_it_is_seen_or_a_while_has_passed() {
        let history = OcclusionHistory::default();
        assert_eq!((history.get(), history.get().pays()), (Occlusion::Unknown, false));
        for (tested, written) in [(0, 0), (1000, 250), (1000, 1000)] {
            history.note(&stats(tested, written), false);
            assert_eq!(history.get(), Occlusion::Seen, "{written} of {tested}");
        }
        let small = DrawStats { faces_drawn: 63, ..stats(1000, 0) };
        history.note(&small, false);
        assert_eq!(history.get(), Occlusion::Seen, "its faces are small");
        history.note(&DrawStats { faces_drawn: 62, ..stats(1000, 249) }, false);
        for left in (0..=DRAWS).rev() {
            assert_eq!(history.get(), Occlusion::Hidden(left));
            assert!(history.get().pays());
            // The tests of these draws do not count: they depend on the vector level.
            history.note(&stats(499, 499), true);
        }
        assert_eq!((history.get(), history.get().pays()), (Occlusion::Outdated, false));
        history.note(&stats(1000, 0), false);
        history.note(&stats(500, 500), true);
        assert_eq!(history.get(), Occlusion::Outdated, "it is seen");
        history.note(&stats(500, 0), true);
        assert_eq!(history.get(), Occlusion::Outdated, "another draw of the same scene");
    }
}

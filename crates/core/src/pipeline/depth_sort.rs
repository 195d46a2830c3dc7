//! Face lists of draws, in file order or sorted by depth, with buffers that are reused.

use super::prepared_draw::PreparedDraw;
use crate::cancel::CancelToken;
use crate::scene::ShadeMode;
use std::cmp::Ordering;

/// Reuses a list's allocation for items of another lifetime, without its items. Both types must
/// have the same size.
pub(crate) fn recycle<T, U>(mut list: Vec<T>) -> Vec<U> {
    list.clear();
    debug_assert!(size_of::<T>() == size_of::<U>());
    list.into_iter().filter_map(|_| None).collect()
}

/// List of faces as (object index, triangle index), and the buffer for sorting it.
#[derive(Debug, Default)]
pub(crate) struct FaceOrder {
    list: Vec<(usize, u32)>,
    keyed: Vec<(f64, usize, u32)>,
}

impl FaceOrder {
    /// Returns the faces.
    pub fn list(&self) -> &[(usize, u32)] {
        &self.list
    }

    /// Returns the bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.list.capacity() * size_of::<(usize, u32)>()
            + self.keyed.capacity() * size_of::<(f64, usize, u32)>()
    }

    /// Collects the faces of all objects for which `is_included` holds, in file order; wireframes
    /// have none. A cancelled draw leaves the list incomplete.
    pub fn collect_faces(&mut self, all: &[PreparedDraw], is_included: impl Fn(&PreparedDraw, u32) -> bool) {
        self.list.clear();
        for (object, p) in all.iter().enumerate().filter(|(_, p)| p.call.shade != ShadeMode::Wire) {
            let count = p.call.geometry.mesh.triangles.len() as u32;
            for start in (0..count).step_by(FACES_AT_ONCE).take_while(|_| !p.cancel.is_cancelled()) {
                let triangles = start..count.min(start + FACES_AT_ONCE as u32);
                self.list.extend(triangles.filter(|&t| is_included(p, t)).map(|t| (object, t)));
            }
        }
    }

    /// Sorts the faces from far to near by the view z of their centres; equal ones stay in file
    /// order, which is that of their indices. A cancelled sort leaves the list incomplete or
    /// unsorted.
    pub fn sort(&mut self, all: &[PreparedDraw], cancel: &CancelToken) {
        self.keyed.clear();
        for some in self.list.chunks(FACES_AT_ONCE).take_while(|_| !cancel.is_cancelled()) {
            self.keyed.extend(some.iter().map(|&(o, t)| (all[o].center_z(t), o, t)));
        }
        // Far first: view z is more negative there. An unstable sort, because a stable one
        // allocates.
        sort_in_parts(&mut self.keyed, &|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))), cancel);
        self.list.clear();
        self.list.extend(self.keyed.iter().map(|&(_, object, triangle)| (object, triangle)));
    }
}

/// Faces between two checks of the cancel token.
const FACES_AT_ONCE: usize = 1 << 14;

/// Maximum length of a list that is sorted without checking the cancel token: some ten
/// milliseconds.
const SORTED_AT_ONCE: usize = 1 << 18;

/// Sorts a list, splitting it at its median while it is long; stops early when it is cancelled.
fn sort_in_parts<T>(list: &mut [T], compare: &impl Fn(&T, &T) -> Ordering, cancel: &CancelToken) {
    if cancel.is_cancelled() {
        return;
    }
    if list.len() <= SORTED_AT_ONCE {
        return list.sort_unstable_by(compare);
    }
    let middle = list.len() / 2;
    let (low, _, high) = list.select_nth_unstable_by(middle, compare);
    sort_in_parts(low, compare, cancel);
    sort_in_parts(high, compare, cancel);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_lists_count_with_their_capacity() {
        let mut order = FaceOrder::default();
        assert_eq!(order.size_bytes(), 0);
        order.list.reserve_exact(5);
        assert_eq!(order.size_bytes(), 5 * 16);
        order.keyed.reserve_exact(3);
        assert_eq!(order.size_bytes(), 5 * 16 + 3 * 24);
    }

    #[test]
    fn parts_of_a_long_list_are_sorted_as_one() {
        let mut state = 7u64;
        let mut list: Vec<u64> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 44
        })
        .take(3 * SORTED_AT_ONCE + 5)
        .collect();
        let mut want = list.clone();
        want.sort_unstable();
        sort_in_parts(&mut list, &u64::cmp, &CancelToken::default());
        assert!(list == want);
        let cancel = CancelToken::new();
        cancel.cancel();
        list.reverse();
        let before = list.clone();
        sort_in_parts(&mut list, &u64::cmp, &cancel);
        assert!(list == before, "nothing is done any more");
    }
}

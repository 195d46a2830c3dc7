//! Sorts faces by depth or keeps file order, in lists that are kept from draw to draw.

use super::prepared_draw::PreparedDraw;
use crate::cancel::CancelToken;
use crate::scene::ShadeMode;
use std::cmp::Ordering;

/// Recycles an empty list's memory for items of another lifetime.
pub(crate) fn recycle<T, U>(list: Vec<T>) -> Vec<U> {
    debug_assert!(list.is_empty() && size_of::<T>() == size_of::<U>());
    list.into_iter().map(|_| -> U { unreachable!("the list is empty") }).collect()
}

/// Bytes of a face in the list, and what it takes beside that to be sorted.
pub(crate) const FACE_ENTRY_BYTES: u64 = size_of::<(usize, u32)>() as u64;
pub(crate) const SORT_KEY_BYTES: u64 = size_of::<(f64, usize, u32)>() as u64;

/// A list of faces - object, triangle -, and what sorting it takes.
#[derive(Debug, Default)]
pub(crate) struct FaceOrder {
    list: Vec<(usize, u32)>,
    keyed: Vec<(f64, usize, u32)>,
}

impl FaceOrder {
    /// The faces.
    pub fn list(&self) -> &[(usize, u32)] {
        &self.list
    }

    /// Bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.list.capacity() * size_of::<(usize, u32)>()
            + self.keyed.capacity() * size_of::<(f64, usize, u32)>()
    }

    /// Takes the faces of all objects that are wanted, in file order; no wireframe's. Only the
    /// first when it is cancelled.
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

    /// Puts the faces far to near by view z of their centres; equals stay in file order, which is
    /// that of their numbers. When it is cancelled, only the first, or in no order.
    pub fn sort(&mut self, all: &[PreparedDraw], cancel: &CancelToken) {
        self.keyed.clear();
        for some in self.list.chunks(FACES_AT_ONCE).take_while(|_| !cancel.is_cancelled()) {
            self.keyed.extend(some.iter().map(|&(o, t)| (all[o].center_z(t), o, t)));
        }
        // Far first: view z is more negative there. A stable sort would ask for memory.
        sort_in_parts(&mut self.keyed, &|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))), cancel);
        self.list.clear();
        self.list.extend(self.keyed.iter().map(|&(_, object, triangle)| (object, triangle)));
    }
}

/// Faces between two looks whether the list is still wanted.
const FACES_AT_ONCE: usize = 1 << 14;

/// Lists of at most so many items are sorted without looking whether they are still wanted: some
/// ten milliseconds.
const SORTED_AT_ONCE: usize = 1 << 18;

/// Sorts a list, which is split at its median while it is long; leaves off when it is cancelled.
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

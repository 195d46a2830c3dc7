//! Which faces are drawn one after the other, in which order, in lists that are kept from draw to draw.

use super::prepare::Prepared;
use crate::scene::ShadeMode;

/// An empty list's own memory for items of another life.
pub(crate) fn emptied<T, U>(list: Vec<T>) -> Vec<U> {
    debug_assert!(list.is_empty() && size_of::<T>() == size_of::<U>());
    list.into_iter().map(|_| -> U { unreachable!("the list is empty") }).collect()
}

/// Bytes of a face in the list, and what it takes beside that to be sorted.
pub(crate) const LISTED_BYTES: u64 = size_of::<(usize, u32)>() as u64;
pub(crate) const SORTED_BYTES: u64 = size_of::<(f64, usize, u32)>() as u64;

/// A list of faces - object, triangle -, and what sorting it takes.
#[derive(Debug, Default)]
pub(crate) struct Order {
    list: Vec<(usize, u32)>,
    keyed: Vec<(f64, usize, u32)>,
}

impl Order {
    /// The faces.
    pub fn list(&self) -> &[(usize, u32)] {
        &self.list
    }

    /// Bytes that the lists take.
    pub fn size_bytes(&self) -> usize {
        self.list.capacity() * size_of::<(usize, u32)>()
            + self.keyed.capacity() * size_of::<(f64, usize, u32)>()
    }

    /// Takes the faces of all objects that are wanted, in file order; no wireframe's.
    pub fn gather(&mut self, all: &[Prepared], wanted: impl Fn(&Prepared, u32) -> bool) {
        self.list.clear();
        for (object, p) in all.iter().enumerate().filter(|(_, p)| p.call.shade != ShadeMode::Wire) {
            let triangles = 0..p.call.geometry.mesh.triangles.len() as u32;
            self.list.extend(triangles.filter(|&t| wanted(p, t)).map(|t| (object, t)));
        }
    }

    /// Puts the faces far to near by view z of their centres; equals stay in file order, which is that of their numbers.
    pub fn sort(&mut self, all: &[Prepared]) {
        self.keyed.clear();
        self.keyed.extend(self.list.iter().map(|&(o, t)| (all[o].center_z(t), o, t)));
        // Far first: view z is more negative there. A stable sort would ask for memory.
        self.keyed.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        self.list.clear();
        self.list.extend(self.keyed.iter().map(|&(_, object, triangle)| (object, triangle)));
    }
}

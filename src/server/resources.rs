//! Named resources: what `MESH`, `TEX` and `EYE` made, counted against their quota.
//!
//! Each kind has its own names, so a mesh and its texture may share one; `FREE` frees a name in all of them. A name
//! that is given again replaces what it stood for.

use super::Limits;
use crate::error::{Code, Fault};
use crate::eye::{self, EyeScene};
use crate::load::x3d::X3dDocument;
use crate::memory::{Reservation, Rgba};
use crate::scene::{Geometry, Texture};
use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

/// What a name can stand for.
#[derive(Clone, Debug)]
pub enum Resource {
    /// A mesh with its textures.
    Mesh(Arc<Geometry>),
    /// A texture.
    Texture(Arc<Texture>),
    /// An N-dimensional scene.
    Eye(Arc<Eye>),
    /// An X3D scene, and the bytes that it takes, about.
    Scene(Arc<X3dDocument>, u64),
}

/// An N-dimensional scene, and its picture once it was asked for: nothing in it moves, so it is made once.
#[derive(Debug)]
pub struct Eye {
    scene: EyeScene,
    picture: OnceLock<Vec<Rgba>>,
}

impl Eye {
    /// A scene without its picture.
    pub fn new(scene: EyeScene) -> Self {
        Eye { scene, picture: OnceLock::new() }
    }

    /// Columns and rows, and the pixels, row after row. The layers of a third screen axis stand side by side.
    pub fn picture(&self) -> ([usize; 2], &[Rgba]) {
        let pixels = self.picture.get_or_init(|| eye::contact_sheet(&eye::render(&self.scene)).1);
        (eye::ContactSheet::of(&self.scene.pixels).size().map(|n| n as usize), pixels)
    }

    /// Whether the picture was made already.
    pub fn has_picture(&self) -> bool {
        self.picture.get().is_some()
    }

    /// Bytes that making the picture takes: facet, distance, flags, colour.
    pub fn working_bytes(&self) -> u64 {
        self.scene.pixel_count() as u64 * (4 + 8 + 24 + 4 + self.scene.lights.len() as u64)
    }

    /// Bytes that the scene and its picture hold.
    pub fn size_bytes(&self) -> usize {
        let vertices = self.scene.facets.len() * self.scene.dim;
        vertices * (self.scene.dim * 8 + 24) + self.scene.pixel_count() * 4
    }
}

/// A kind of resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResourceKind {
    /// `MESH`
    Mesh,
    /// `TEX`
    Texture,
    /// `EYE`
    Eye,
    /// `SCENE`
    Scene,
}

impl ResourceKind {
    /// The kind in messages.
    pub const fn as_str(self) -> &'static str {
        match self {
            ResourceKind::Mesh => "mesh",
            ResourceKind::Texture => "texture",
            ResourceKind::Eye => "eye",
            ResourceKind::Scene => "scene",
        }
    }
}

impl Resource {
    /// Its kind.
    pub fn kind(&self) -> ResourceKind {
        match self {
            Resource::Mesh(_) => ResourceKind::Mesh,
            Resource::Texture(_) => ResourceKind::Texture,
            Resource::Eye(_) => ResourceKind::Eye,
            Resource::Scene(..) => ResourceKind::Scene,
        }
    }

    /// Bytes that it takes, about.
    pub fn size_bytes(&self) -> u64 {
        let size = match self {
            Resource::Mesh(g) => {
                let textures = g.textures.iter().flatten().map(|t| t.size_bytes()).sum::<usize>();
                g.mesh.size_bytes() + textures
            }
            Resource::Texture(t) => t.size_bytes(),
            Resource::Eye(e) => e.size_bytes(),
            Resource::Scene(_, size) => return *size,
        };
        size as u64
    }
}

/// The names of one connection, or the shared ones.
#[derive(Debug, Default)]
pub struct ResourceTable {
    of: HashMap<(ResourceKind, String), Entry>,
    bytes: u64,
}

/// What a name stands for, and the bytes that it holds.
#[derive(Debug)]
struct Entry {
    resource: Resource,
    bytes: u64,
    /// The same of the memory budget, for as long as the name stands for it.
    _held: Reservation,
}

/// Bytes of a name's entry in the table, the name itself aside.
const ENTRY_BYTES: u64 = 256;

impl ResourceTable {
    /// Whether `name` belongs to all connections.
    pub fn is_shared(name: &str) -> bool {
        name.starts_with('@')
    }

    /// What `name` stands for, of this kind.
    pub fn get(&self, kind: ResourceKind, name: &str) -> Option<&Resource> {
        // A key that borrows both halves does not exist for tuples; names are short.
        self.of.get(&(kind, name.to_owned())).map(|entry| &entry.resource)
    }

    /// Bytes that something new under `name` may hold within `limits`.
    pub fn room(&self, kind: ResourceKind, name: &str, limits: &Limits) -> u64 {
        let old = self.of.get(&(kind, name.to_owned())).map_or(0, |entry| entry.bytes);
        limits.resource_bytes.saturating_sub(self.bytes - old)
    }

    /// Gives `name` to `resource`, in place of what had it. `held` is what is reserved for it.
    ///
    /// # Errors
    /// `EQUOTA` when the names or their bytes would be over `limits`, or the budget has no room for the name; nothing changes
    /// then.
    pub fn insert(
        &mut self,
        name: &str,
        resource: Resource,
        mut held: Reservation,
        limits: &Limits,
    ) -> Result<(), Fault> {
        let key = (resource.kind(), name.to_owned());
        held.try_cover(resource.size_bytes())?;
        let size = held.bytes() + name.len() as u64;
        let old = self.of.get(&key).map(|entry| entry.bytes);
        let whose = if Self::is_shared(name) { "shared names" } else { "names of a connection" };
        if old.is_none() && self.of.len() >= limits.names {
            let message = format!("no more than {} {whose}, all in use", limits.names);
            return Err(Fault::new(Code::Quota, message).got(name));
        }
        let bytes = self.bytes - old.unwrap_or(0) + size;
        if bytes > limits.resource_bytes {
            let message =
                format!("{whose} hold at most {} bytes, and this makes {bytes}", limits.resource_bytes);
            return Err(Fault::new(Code::Quota, message).got(name));
        }
        held.try_grow(name.len() as u64 + ENTRY_BYTES)?;
        self.bytes = bytes;
        if let Some(entry) = self.of.insert(key, Entry { resource, bytes: size, _held: held }) {
            let bytes = entry.bytes;
            let_go(entry, bytes);
        }
        Ok(())
    }

    /// Forgets `name` in every kind; whether there was one.
    pub fn free(&mut self, name: &str) -> bool {
        let mut found = false;
        for kind in [ResourceKind::Mesh, ResourceKind::Texture, ResourceKind::Eye] {
            if let Some(entry) = self.of.remove(&(kind, name.to_owned())) {
                let bytes = entry.bytes;
                let_go(entry, bytes);
                self.bytes -= bytes;
                found = true;
            }
        }
        found
    }

    /// How many names there are.
    pub fn len(&self) -> usize {
        self.of.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    /// Bytes of all of them.
    pub fn size_bytes(&self) -> u64 {
        self.bytes
    }
}

impl Drop for ResourceTable {
    fn drop(&mut self) {
        let_go(std::mem::take(&mut self.of), self.bytes);
    }
}

/// Giving back so many bytes takes the system a millisecond or more.
const LARGE_BYTES: u64 = 16 << 20;

/// Drops what has no name any more, on a thread of its own where that takes long: nobody waits for it.
fn let_go<T: Send + 'static>(what: T, bytes: u64) {
    if bytes >= LARGE_BYTES {
        // Without a thread to spare it is dropped here, with the closure.
        let _ = std::thread::Builder::new().name("fbptr-free".into()).spawn(move || drop(what));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::memory::{MemoryBudget, MemoryUse};
    use crate::scene::Texture;

    fn texture(side: u32) -> Resource {
        Resource::Texture(Arc::new(Texture::new(side, 1, vec![0; side as usize * 4]).unwrap()))
    }

    #[test]
    fn quotas_count_names_and_bytes_and_replacing_gives_back() {
        let limits = Limits { names: 2, resource_bytes: 200, ..Limits::default() };
        let mut names = ResourceTable::default();
        let budget = MemoryBudget::new(2000);
        let insert = |names: &mut ResourceTable, name: &str, side: u32| {
            names.insert(name, texture(side), budget.empty(MemoryUse::Resources), &limits)
        };
        insert(&mut names, "a", 1).unwrap();
        insert(&mut names, "b", 1).unwrap();
        assert_eq!(insert(&mut names, "c", 1).unwrap_err().code, Code::Quota);
        insert(&mut names, "a", 8).unwrap();
        assert_eq!(insert(&mut names, "a", 64).unwrap_err().code, Code::Quota);
        assert_eq!(budget.used(), names.size_bytes() + 2 * ENTRY_BYTES);
        assert!(
            names.get(ResourceKind::Texture, "a").is_some() && names.get(ResourceKind::Mesh, "a").is_none()
        );
        assert!(names.free("a") && !names.free("a"));
        names.free("b");
        assert_eq!((names.len(), names.size_bytes(), budget.used()), (0, 0, 0));
    }
}

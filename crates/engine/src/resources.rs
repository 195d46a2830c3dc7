//! Named resources: meshes, textures, scenes and N-dimensional scenes, counted against a quota.
//!
//! Each kind has names of its own, so a mesh and its texture may have the same name; `FREE` frees a
//! name in all kinds. A name that is defined again replaces its old resource.

use super::Limits;
use fbptr_core::error::{Code, Fault};
use fbptr_core::eye::{self, EyeLight, EyeScene, Facet};
use fbptr_core::memory::{Reservation, Rgba};
use fbptr_core::scene::{Geometry, Texture};
use fbptr_formats::load::x3d::X3dDocument;
use std::collections::{HashMap, HashSet};
use std::sync::{Arc, OnceLock};

/// A named object that commands create and use.
#[derive(Clone, Debug)]
pub enum Resource {
    /// A mesh with its textures.
    Mesh(Arc<Geometry>),
    /// A texture.
    Texture(Arc<Texture>),
    /// An N-dimensional scene.
    Eye(Arc<Eye>),
    /// An X3D scene, and its approximate size in bytes.
    Scene(Arc<X3dDocument>, u64),
}

/// An N-dimensional scene, and its picture, which is rendered once, because nothing in the scene
/// moves.
#[derive(Debug)]
pub struct Eye {
    scene: EyeScene,
    picture: OnceLock<Vec<Rgba>>,
}

impl Eye {
    /// Creates an entry without its picture.
    pub fn new(scene: EyeScene) -> Self {
        Eye { scene, picture: OnceLock::new() }
    }

    /// Returns the numbers of columns and rows, and the pixels, row after row; renders the picture
    /// if that was not done. The layers of a third screen axis are placed side by side.
    pub fn picture(&self) -> ([usize; 2], &[Rgba]) {
        let pixels = self.picture.get_or_init(|| eye::contact_sheet(&eye::render(&self.scene)).1);
        (eye::ContactSheet::of(&self.scene.pixels).size().map(|n| n as usize), pixels)
    }

    /// Returns whether the picture was rendered already.
    pub fn has_picture(&self) -> bool {
        self.picture.get().is_some()
    }

    /// Returns the memory, in bytes, for rendering the picture: facet, distance, flags and colour
    /// of each pixel.
    pub fn working_bytes(&self) -> u64 {
        self.scene.pixel_count() as u64 * (4 + 8 + 24 + 4 + self.scene.lights.len() as u64)
    }

    /// Returns the size of the scene and its picture in bytes.
    pub fn size_bytes(&self) -> usize {
        let vertices = self.scene.facets.len() * self.scene.dim;
        vertices * (self.scene.dim * 8 + 24) + self.scene.pixel_count() * 4
    }
}

/// A kind of resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResourceKind {
    /// Meshes, defined by `MESH`.
    Mesh,
    /// Textures, defined by `TEX`.
    Texture,
    /// N-dimensional scenes, defined by `EYE`.
    Eye,
    /// X3D scenes, defined by `SCENE`.
    Scene,
}

impl ResourceKind {
    /// Returns the kind's name in messages.
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
    /// Returns its kind.
    pub fn kind(&self) -> ResourceKind {
        match self {
            Resource::Mesh(_) => ResourceKind::Mesh,
            Resource::Texture(_) => ResourceKind::Texture,
            Resource::Eye(_) => ResourceKind::Eye,
            Resource::Scene(..) => ResourceKind::Scene,
        }
    }

    /// Returns its approximate size in bytes.
    pub fn size_bytes(&self) -> u64 {
        let size = match self {
            Resource::Mesh(g) => {
                // Materials that name the same picture share its texture.
                let mut counted = HashSet::new();
                let textures = g.textures.iter().flatten().filter(|t| counted.insert(Arc::as_ptr(t)));
                g.mesh.size_bytes() + textures.map(|t| t.size_bytes()).sum::<usize>()
            }
            Resource::Texture(t) => t.size_bytes(),
            Resource::Eye(e) => e.size_bytes(),
            Resource::Scene(_, size) => return *size,
        };
        size as u64
    }
}

impl Resource {
    /// Returns the bytes of its small blocks, which are not a part of its size: of many small
    /// resources they are most of it.
    fn fixed_bytes(&self) -> u64 {
        let bytes = match self {
            Resource::Mesh(_) => size_of::<Geometry>(),
            Resource::Eye(eye) => {
                // The lists of the screen's axes and of the eye's.
                let axes = (eye.scene.dim + 8) * eye.scene.dim * 8;
                let lights = eye.scene.lights.len() * size_of::<EyeLight>();
                size_of::<Eye>() + eye.scene.facets.len() * size_of::<Facet>() + lights + axes
            }
            Resource::Texture(_) | Resource::Scene(..) => return 0,
        };
        (bytes + 2 * size_of::<usize>()) as u64
    }
}

/// The resources of one connection, or the shared ones, by name.
#[derive(Debug, Default)]
pub struct ResourceTable {
    of: HashMap<(ResourceKind, String), Entry>,
    bytes: u64,
}

/// A resource, and the bytes that are counted for it.
#[derive(Debug)]
struct Entry {
    resource: Resource,
    bytes: u64,
    /// The memory budget's reservation for it.
    _held: Reservation,
}

/// Memory of a name's entry in the table, in bytes without the name itself.
const ENTRY_BYTES: u64 = 256;

impl ResourceTable {
    /// Returns whether `name` belongs to all connections.
    pub fn is_shared(name: &str) -> bool {
        name.starts_with('@')
    }

    /// Returns the resource of this kind and name.
    pub fn get(&self, kind: ResourceKind, name: &str) -> Option<&Resource> {
        // Tuples of borrowed halves cannot be looked up; names are short, so they are copied.
        self.of.get(&(kind, name.to_owned())).map(|entry| &entry.resource)
    }

    /// Returns the largest size in bytes, within `limits`, of a new resource under `name`.
    pub fn room(&self, kind: ResourceKind, name: &str, limits: &Limits) -> u64 {
        let old = self.of.get(&(kind, name.to_owned())).map_or(0, |entry| entry.bytes);
        limits.resource_bytes.saturating_sub(self.bytes - old)
    }

    /// Stores `resource` under `name`, in place of an old one. `held` is the memory reserved for
    /// it.
    ///
    /// # Errors
    /// `EQUOTA` if the names or their bytes would exceed `limits`, or the budget has no room for
    /// the name; nothing changes then.
    pub fn insert(
        &mut self,
        name: &str,
        resource: Resource,
        mut held: Reservation,
        limits: &Limits,
    ) -> Result<(), Fault> {
        let key = (resource.kind(), name.to_owned());
        let fixed = ENTRY_BYTES + resource.fixed_bytes();
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
        held.try_grow(name.len() as u64 + fixed)?;
        self.bytes = bytes;
        if let Some(entry) = self.of.insert(key, Entry { resource, bytes: size, _held: held }) {
            let bytes = entry.bytes;
            let_go(entry, bytes);
        }
        Ok(())
    }

    /// Removes `name` in every kind. Returns whether there was one.
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

    /// Returns the number of names.
    pub fn len(&self) -> usize {
        self.of.len()
    }

    /// Returns whether there are no names.
    pub fn is_empty(&self) -> bool {
        self.of.is_empty()
    }

    /// Returns the total size of the resources in bytes.
    pub fn size_bytes(&self) -> u64 {
        self.bytes
    }
}

impl Drop for ResourceTable {
    fn drop(&mut self) {
        let_go(std::mem::take(&mut self.of), self.bytes);
    }
}

/// Size in bytes from which freeing memory takes the system a millisecond or more.
const LARGE_BYTES: u64 = 16 << 20;

/// Drops a resource that has lost its name, on a thread of its own if that takes long.
pub(crate) fn let_go<T: Send + 'static>(what: T, bytes: u64) {
    if bytes >= LARGE_BYTES {
        // If no thread can be started, it is dropped here, with the closure.
        let _ = std::thread::Builder::new().name("fbptr-free".into()).spawn(move || drop(what));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::memory::{MemoryBudget, MemoryUse};
    use fbptr_core::scene::Texture;

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

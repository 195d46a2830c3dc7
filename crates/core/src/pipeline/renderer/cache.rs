//! Cache of facts about shared geometries, from draw to draw.

use crate::cancel::CancelToken;
use crate::pipeline::geometry_cache::GeometryInfo;
use crate::scene::Geometry;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// Maximum number of geometries in the cache.
const MOST_ENTRIES: usize = 1 << 15;

/// Maximum bytes of cached geometry facts, apart from those in use.
const MOST_BYTES: usize = 1 << 30;

/// Cached facts about shared geometries, by address.
#[derive(Debug, Default)]
pub(super) struct Cache {
    entries: HashMap<usize, Entry>,
    /// Number of look-ups so far.
    clock: u64,
}

/// Cached facts about one geometry.
#[derive(Debug)]
struct Entry {
    /// Keeps the address from being reused for another geometry, but not the geometry alive.
    /// Changing a geometry in place while this exists either moves it to a new address
    /// (`Arc::make_mut`) or fails (`Arc::get_mut`).
    geometry: Weak<Geometry>,
    geometry_info: Arc<GeometryInfo>,
    /// Value of the cache's clock at the last look-up.
    last_used: u64,
}

impl Cache {
    /// Returns the facts about a shared geometry, and caches them.
    pub fn geometry_info(&mut self, shared: &Arc<Geometry>, cancel: &CancelToken) -> Arc<GeometryInfo> {
        self.clock += 1;
        let address = Arc::as_ptr(shared).addr();
        if let Some(entry) = self.entries.get_mut(&address) {
            entry.last_used = self.clock;
            return Arc::clone(&entry.geometry_info);
        }
        self.forget();
        let geometry_info = Arc::new(GeometryInfo::of(shared, cancel.clone()));
        let geometry = Arc::downgrade(shared);
        self.entries.insert(
            address,
            Entry { geometry, geometry_info: Arc::clone(&geometry_info), last_used: self.clock },
        );
        geometry_info
    }

    /// Returns the facts about a shared geometry, if they are cached.
    pub fn get(&self, shared: &Arc<Geometry>) -> Option<Arc<GeometryInfo>> {
        self.entries.get(&Arc::as_ptr(shared).addr()).map(|entry| Arc::clone(&entry.geometry_info))
    }

    /// Returns the bytes of all facts.
    pub fn size_bytes(&self) -> usize {
        self.entries.values().map(|e| e.geometry_info.size_bytes()).sum()
    }

    /// Drops the entries of geometries that no longer exist.
    pub fn forget_dropped(&mut self) {
        self.entries.retain(|_, e| e.geometry.strong_count() > 0);
    }

    /// Drops the entries of geometries that no longer exist and, if that is not enough, the older
    /// half of the rest.
    fn forget(&mut self) {
        // Scans all entries only when their number has doubled or is at its limit.
        if self.entries.len().is_power_of_two() || self.entries.len() >= MOST_ENTRIES {
            self.forget_dropped();
            if self.entries.len() >= MOST_ENTRIES || self.size_bytes() > MOST_BYTES {
                let mut times: Vec<u64> = self.entries.values().map(|e| e.last_used).collect();
                times.sort_unstable();
                let middle = times[times.len() / 2];
                self.entries.retain(|_, e| e.last_used > middle);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;

    #[test]
    fn a_geometry_is_known_by_its_address_as_long_as_that_is_its_own() {
        let mut cache = Cache::default();
        let geometry = |n| Arc::new(Geometry { mesh: shapes::knot(n, 4).expect("a knot"), textures: vec![] });
        let mut first = geometry(5);
        let never = &CancelToken::default();
        let geometry_info = cache.geometry_info(&first, never);
        assert!(Arc::ptr_eq(&geometry_info, &cache.geometry_info(&first, never)));
        // Changing it in place moves it, because the cache holds a weak reference.
        Arc::make_mut(&mut first).mesh.positions[0].x = 9.0;
        assert!(!Arc::ptr_eq(&geometry_info, &cache.geometry_info(&first, never)));
        drop(first);
        for n in 6..40 {
            let other = geometry(n);
            let geometry_info = cache.geometry_info(&other, never);
            assert_eq!(geometry_info.prepared(&other.mesh, false).triangle_count, n as usize * 8);
        }
        assert!(cache.entries.len() < 20, "{} of dropped geometries are left", cache.entries.len());
    }

    #[test]
    fn the_geometries_used_last_stay_when_there_are_too_many() {
        let (mut cache, never) = (Cache::default(), &CancelToken::default());
        let all: Vec<_> = (0..=MOST_ENTRIES).map(|_| Arc::new(Geometry::default())).collect();
        for geometry in &all[..MOST_ENTRIES] {
            cache.geometry_info(geometry, never);
        }
        assert_eq!(cache.entries.len(), MOST_ENTRIES);
        // The oldest is used again, so the second oldest is the first to go.
        cache.geometry_info(&all[0], never);
        cache.geometry_info(&all[MOST_ENTRIES], never);
        let is_cached = |i: usize| cache.get(&all[i]).is_some();
        let middle = MOST_ENTRIES / 2;
        assert!(is_cached(0) && !is_cached(1) && !is_cached(middle));
        assert!(is_cached(middle + 2) && is_cached(MOST_ENTRIES - 1) && is_cached(MOST_ENTRIES));
    }
}

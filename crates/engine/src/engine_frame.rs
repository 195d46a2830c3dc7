//! The framebuffer: the video memory, the depths, and the pick buffer with the names of its numbers.
//!
//! In: formats, names of objects, requests for room. Out: a render target; depths and names at
//! pixels. Depth and pick buffer exist from the first draw on that needs them. All of them are
//! counted in the memory budget.

use fbptr_core::error::Fault;
use fbptr_core::memory::{
    DepthFormat, DepthMemory, MemoryBudget, MemoryError, MemoryUse, OverBudget, PickBuffer, Reservation,
    VideoMemory,
};
use fbptr_core::pipeline::Target;
use fbptr_core::scene::{HiddenSurface, Object, Scene};
use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

/// Memory of a name in the tables of object names, in bytes without its letters.
const NAME_BYTES: u64 = 96;

/// Bytes that a block of pixels, depths or numbers of faces takes beside them: its begin and its end
/// are rounded to cache lines.
const BLOCK_BYTES: u64 = 128;

/// Number of names at which those that no pixel refers to are removed.
const MAX_ID_NAMES: usize = 1 << 16;

/// The memories that commands draw into.
#[derive(Debug)]
pub(super) struct EngineFrame {
    pub memory: VideoMemory,
    pub depth: Option<DepthMemory>,
    pub depth_format: DepthFormat,
    pub ids: Option<PickBuffer>,
    /// Names of the pick buffer's numbers.
    names: IdNames,
    /// The memory budget's reservations for the frame and its copies, for depths, pick buffer and
    /// names.
    frame_held: Reservation,
    depth_held: Reservation,
    ids_held: Reservation,
    names_held: Reservation,
}

/// Name of an object, and if a level of detail of its mesh was drawn, the triangle of the mesh that
/// each of the level's is left from.
#[derive(Debug)]
struct IdName {
    name: Arc<str>,
    origins: Option<Origins>,
}

/// Triangle of a mesh for each triangle of one of its levels.
pub(crate) type Origins = Arc<[u32]>;

/// Names of the objects whose numbers are in the pick buffer.
#[derive(Debug, Default)]
struct IdNames {
    names: Vec<IdName>,
    /// Numbers of whole meshes.
    numbers: HashMap<Arc<str>, u32>,
    /// Bytes of memory that they take.
    bytes: u64,
    /// Number of the first object of the last drawn scene.
    last_scene: u32,
}

impl EngineFrame {
    /// Creates a cleared frame, whose memory is counted as of this use.
    pub fn new(width: u32, height: u32, budget: &MemoryBudget, of_use: MemoryUse) -> Result<Self, Fault> {
        Self::of(VideoMemory::new, [width, height], budget, of_use)
    }

    /// Creates a transparent canvas. None of its pixels is touched, however many there are.
    pub fn canvas(size: [u32; 2], budget: &MemoryBudget) -> Result<Self, Fault> {
        Self::of(VideoMemory::transparent, size, budget, MemoryUse::Resources)
    }

    /// Creates a frame with the memory that `make` returns, once it is reserved.
    fn of(
        make: fn(u32, u32) -> Result<VideoMemory, MemoryError>,
        [width, height]: [u32; 2],
        budget: &MemoryBudget,
        of_use: MemoryUse,
    ) -> Result<Self, Fault> {
        let empty = || budget.empty(of_use);
        let mut frame_held = empty();
        frame_held.try_grow(u64::from(width) * u64::from(height) * 4)?;
        Ok(EngineFrame {
            memory: make(width, height)?,
            depth: None,
            depth_format: DepthFormat::default(),
            ids: None,
            names: IdNames::default(),
            frame_held,
            depth_held: empty(),
            ids_held: empty(),
            names_held: budget.empty(MemoryUse::Resources),
        })
    }

    /// Bytes of a frame without its pixels: of many small frames they are more than the pixels.
    pub const FIXED_BYTES: u64 = size_of::<EngineFrame>() as u64 + BLOCK_BYTES;
    /// Bytes of depth buffer, pick buffer and table of names without what they hold.
    pub const FIXED_TARGET_BYTES: u64 = 3 * BLOCK_BYTES;

    /// Returns the number of bytes reserved for pixels, depths, pick buffer and names.
    pub fn held_bytes(&self) -> u64 {
        let held = [&self.frame_held, &self.depth_held, &self.ids_held, &self.names_held];
        held.into_iter().map(Reservation::bytes).sum()
    }

    /// Returns the width in pixels.
    #[inline]
    pub fn width(&self) -> u32 {
        self.memory.width()
    }

    /// Returns the height in pixels.
    #[inline]
    pub fn height(&self) -> u32 {
        self.memory.height()
    }

    /// Returns the number of pixels.
    pub fn area(&self) -> u64 {
        u64::from(self.width()) * u64::from(self.height())
    }

    /// Counts a copy of the frame that exists as long as the server. It is not refused if memory is
    /// short, because whoever runs the server asked for it.
    pub fn count_copy(&mut self) {
        self.frame_held.set(self.frame_held.bytes() + self.memory.bytes().len() as u64);
    }

    /// Returns the sizes in bytes of the depth buffer and of the pick buffer.
    pub fn depth_and_id_bytes(&self) -> [u64; 2] {
        let depth = self.depth.as_ref().map_or(0, |d| d.size_bytes());
        let ids = self.ids.as_ref().map_or(0, |i| i.size_bytes());
        [depth as u64, ids as u64]
    }

    /// Sets the format of the depth buffer, which all connections share. A change discards its
    /// contents.
    pub fn set_depth_format(&mut self, format: DepthFormat) {
        if format != self.depth_format {
            self.depth_format = format;
            self.depth = None;
            self.depth_held.shrink_to(0);
        }
    }

    /// Returns the bytes of the depth and pick buffers that a draw will allocate; zero for one that
    /// exists or is not needed.
    fn target_bytes(&self, hide: HiddenSurface) -> [u64; 2] {
        let needs_depth = self.depth.is_none() && hide == HiddenSurface::ZBuffer;
        // Each row has one word of cells whose clear is pending.
        let cells = self.area() * self.depth_format.bytes_per_pixel() as u64 + u64::from(self.height()) * 16;
        // Only a depth test says which face a PICK means.
        let needs_ids = self.ids.is_none() && hide == HiddenSurface::ZBuffer;
        let ids = PickBuffer::bytes_for(self.width(), self.height());
        [if needs_depth { cells } else { 0 }, if needs_ids { ids } else { 0 }]
    }

    /// Returns the bytes that [`Self::reserve_target`] will reserve.
    pub fn lacking_target_bytes(&self, hide: HiddenSurface) -> u64 {
        let [depth, ids] = self.target_bytes(hide);
        depth.saturating_sub(self.depth_held.bytes()) + ids.saturating_sub(self.ids_held.bytes())
    }

    /// Reserves memory for the depth and pick buffers that a draw will need, and creates the pick
    /// buffer: a PICK may follow a draw that tests depths, and no other.
    pub fn reserve_target(&mut self, hide: HiddenSurface) -> Result<(), OverBudget> {
        let [depth, ids] = self.target_bytes(hide);
        self.ids_held.try_cover(ids)?;
        self.depth_held.try_cover(depth)?;
        if ids > 0 {
            self.ids = Some(PickBuffer::new(self.width(), self.height()));
        }
        Ok(())
    }

    /// Sets the reservations to the sizes of the depth and pick buffers.
    pub fn count_target(&mut self) {
        let [depth, ids] = self.depth_and_id_bytes();
        self.depth_held.set(depth);
        self.ids_held.set(ids);
    }

    /// Returns the target of draws.
    pub fn target(&mut self) -> Target<'_> {
        Target {
            memory: &mut self.memory,
            depth: &mut self.depth,
            depth_format: self.depth_format,
            ids: self.ids.as_mut(),
        }
    }

    /// Clears these columns and rows of the depth and pick buffers.
    pub fn clear_depths_and_ids_within(&mut self, columns: &Range<u32>, rows: &Range<u32>) {
        if let Some(depth) = &mut self.depth {
            depth.clear_within(columns, rows);
        }
        if let Some(ids) = &mut self.ids {
            ids.clear_within(columns, rows);
        }
    }

    /// Clears the depth and pick buffers.
    pub fn clear_depths_and_ids(&mut self) {
        if let Some(depth) = &mut self.depth {
            depth.clear();
        }
        if let Some(ids) = &mut self.ids {
            ids.clear();
            self.names = IdNames::default();
        }
    }

    /// Returns the name and the triangle of the face seen at a pixel, if there is one.
    pub fn face_at(&self, x: i32, y: i32) -> Option<(&str, u32)> {
        let (number, triangle) = self.ids.as_ref()?.get(x, y)?;
        let IdName { name, origins } = self.names.names.get(number as usize)?;
        let whole = match origins {
            Some(origins) => *origins.get(triangle as usize)?,
            None => triangle,
        };
        Some((name, whole))
    }

    /// Returns the number of `name` in the pick buffer.
    pub fn id_of(&mut self, name: &str) -> u32 {
        if !self.names.numbers.contains_key(name) {
            let is_full = self.names_held.budget().available() < name.len() as u64 + NAME_BYTES;
            if is_full || self.names.names.len() >= MAX_ID_NAMES {
                self.forget_unused_ids();
            }
        }
        let number = self.names.number(name);
        self.names_held.set(self.names.bytes);
        number
    }

    /// Returns the number of a level of detail of `name` in the pick buffer.
    pub fn id_of_level(&mut self, name: &str, origins: &Origins) -> u32 {
        if self.names.names.len() >= MAX_ID_NAMES {
            self.forget_unused_ids();
        }
        let number = self.names.level_number(name, origins);
        self.names_held.set(self.names.bytes);
        number
    }

    /// Returns the number of the scene's first object in the pick buffer; those of the others
    /// follow it.
    pub fn ids_of(&mut self, scene: &Scene) -> u32 {
        self.ids_of_levels(scene, &[])
    }

    /// Returns the number of the scene's first object in the pick buffer; those of the others follow
    /// it. Objects that are drawn at a level of detail have origins.
    pub fn ids_of_levels(&mut self, scene: &Scene, origins: &[Option<Origins>]) -> u32 {
        if self.names.names.len() + scene.objects.len() > MAX_ID_NAMES {
            self.forget_unused_ids();
        }
        let names = &mut self.names.names;
        let start = self.names.last_scene as usize;
        let origins_of = |i: usize| origins.get(i).and_then(Option::as_ref);
        let is_same = |(i, (known, object)): (usize, (&IdName, &Object))| {
            *known.name == *object.name && is_same_level(known.origins.as_ref(), origins_of(i))
        };
        let is_there = names.len() >= start + scene.objects.len()
            && names[start..].iter().zip(&scene.objects).enumerate().all(is_same);
        if !is_there {
            self.names.last_scene = names.len() as u32;
            names.extend(scene.objects.iter().enumerate().map(|(i, object)| IdName {
                name: Arc::from(object.name.as_str()),
                origins: origins_of(i).cloned(),
            }));
            let bytes: u64 = scene.objects.iter().map(|o| o.name.len() as u64 + NAME_BYTES).sum();
            self.names.bytes += bytes;
            self.names_held.set(self.names.bytes);
        }
        self.names.last_scene
    }

    /// Removes the names that no pixel refers to, and numbers the others anew.
    fn forget_unused_ids(&mut self) {
        let old = std::mem::take(&mut self.names);
        let Some(ids) = &mut self.ids else { return };
        let (width, height) = (ids.width() as usize, ids.height() as usize);
        for index in 0..width * height {
            if let Some((number, triangle)) = ids.get((index % width) as i32, (index / width) as i32) {
                let IdName { name, origins } = &old.names[number as usize];
                let number = match origins {
                    Some(origins) => self.names.level_number(name, origins),
                    None => self.names.number(name),
                };
                ids.set(index, number, triangle);
            }
        }
    }
}

/// Returns whether two names mean the same level, or both a whole mesh.
fn is_same_level(a: Option<&Origins>, b: Option<&Origins>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b),
        (a, b) => a.is_none() && b.is_none(),
    }
}

impl IdNames {
    /// Returns the number of a level of a name; adds it if it is new.
    fn level_number(&mut self, name: &str, origins: &Origins) -> u32 {
        let is_same =
            |known: &IdName| *known.name == *name && is_same_level(known.origins.as_ref(), Some(origins));
        if let Some(number) = self.names.iter().rposition(is_same) {
            return number as u32;
        }
        self.bytes += name.len() as u64 + NAME_BYTES;
        self.names.push(IdName { name: name.into(), origins: Some(origins.clone()) });
        self.names.len() as u32 - 1
    }

    /// Returns the number of a name; adds the name if it is new.
    fn number(&mut self, name: &str) -> u32 {
        if let Some(&number) = self.numbers.get(name) {
            return number;
        }
        let (name, number): (Arc<str>, _) = (name.into(), self.names.len() as u32);
        self.bytes += name.len() as u64 + NAME_BYTES;
        self.names.push(IdName { name: name.clone(), origins: None });
        self.numbers.insert(name, number);
        number
    }
}

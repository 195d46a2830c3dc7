//! Facts about the meshes that a stream draws, each measured once.
//!
//! In: the meshes of one draw after the other. Out: their boxes, and the angles between their
//! normals, each measured once; and their levels of detail, which are made when so many draws might
//! have used them that these pay for it. A stream's mesh is measured the second time that it is seen, so that
//! meshes made for one frame cost nothing. Meshes are compared by identity, and are not kept alive.
//! The order of the draws alone decides which meshes are forgotten.

use super::detail::WholeReason;
use super::levels::{Level, build_bytes, make_levels};
use super::{MeshAngles, MeshBox};
use crate::cancel::NEVER;
use crate::memory::{MemoryBudget, MemoryUse, Reservation};
use crate::pipeline::draw_call::DrawCall;
use crate::pipeline::ndc_box::ClipTransform;
use crate::scene::{Camera, Geometry};
use std::collections::HashMap;
use std::sync::{Arc, Weak};

/// Number of meshes after which those are forgotten that were not seen since as many before.
const KEPT: usize = 1024;

/// Draws that pay for the levels of a mesh: making them takes some 4.3 microseconds a face
/// (docs/report.md), and drawing a face that levels leave out 7 nanoseconds.
const DRAWS_FOR_LEVELS: u64 = 512;

/// Boxes, angles and levels of the most recent meshes.
#[derive(Debug, Default)]
pub struct MeshShapes {
    /// By address, which is not used again while there is a `Weak` of it.
    recent: HashMap<usize, MeshEntry>,
    older: HashMap<usize, MeshEntry>,
    /// Box of the mesh of the last draw, by its address: the next draw is often of the same.
    last_box: Option<(usize, MeshBox)>,
    measures_at_once: bool,
    measured_faces: u64,
    /// Draws that each mesh is known to have, if they are known.
    expected_draws: Option<u64>,
    /// Budget of the levels.
    budget: MemoryBudget,
    /// The last camera and aspect, and the transform to clip space: the next draw mostly has the same.
    last_camera: Option<(Camera, f64, Option<ClipTransform>)>,
}

/// Measurements of a mesh.
#[derive(Debug)]
struct MeshEntry {
    /// Keeps the address from being used again.
    mesh: Weak<Geometry>,
    was_drawn: bool,
    mesh_box: Option<MeshBox>,
    /// `None` if they were not measured, `Some(None)` if there are none.
    angles: Option<Option<MeshAngles>>,
    /// Draws for which a level would have been drawn, had there been one.
    detail_draws: u64,
    levels: Option<MeshLevels>,
}

/// Levels of a mesh.
#[derive(Debug)]
struct MeshLevels {
    levels: Vec<Level>,
    /// The memory budget's reservation for them; `None` if there was no room.
    _held: Option<Reservation>,
}

impl MeshShapes {
    /// Creates an empty table that measures meshes the first time that they are seen.
    pub fn at_once() -> MeshShapes {
        MeshShapes { measures_at_once: true, ..MeshShapes::default() }
    }

    /// Takes each mesh as one that is drawn so often, as in the frames of an animation.
    #[must_use]
    pub fn expecting(self, draws: u64) -> MeshShapes {
        MeshShapes { expected_draws: Some(draws), ..self }
    }

    /// Counts the levels that are made from now on in this budget.
    pub fn set_budget(&mut self, budget: &MemoryBudget) {
        self.budget = budget.clone();
    }

    /// Returns whether the next draw that may have a level makes those of this mesh.
    pub fn is_due(&self, geometry: &Arc<Geometry>) -> bool {
        let address = Arc::as_ptr(geometry) as usize;
        let entry = self.recent.get(&address).or_else(|| self.older.get(&address));
        entry.is_some_and(|entry| entry.levels.is_none() && self.draws(entry) >= DRAWS_FOR_LEVELS)
    }

    /// Returns the number of draws that a mesh has with the next one: those of an animation are known
    /// from its first frame on, so that all frames are drawn alike, and each part of them alone.
    fn draws(&self, entry: &MeshEntry) -> u64 {
        self.expected_draws.unwrap_or(entry.detail_draws + 1)
    }

    /// Reserves memory to make the levels of a mesh; `None` if there is no room.
    pub fn reserve_levels(&self, geometry: &Geometry) -> Option<Reservation> {
        self.budget.try_reserve(MemoryUse::Resources, build_bytes(&geometry.mesh)).ok()
    }

    /// Keeps the levels of a mesh, and the reservation for making them as far as they need it.
    pub fn keep_levels(
        &mut self,
        geometry: &Arc<Geometry>,
        levels: Vec<Level>,
        mut held: Option<Reservation>,
    ) {
        if let Some(held) = &mut held {
            held.set(levels.iter().map(Level::size_bytes).sum());
        }
        self.entry(geometry).levels = Some(MeshLevels { levels, _held: held });
    }

    /// Drops the levels of meshes that are gone.
    pub fn forget_gone(&mut self) {
        for entry in self.recent.values_mut().chain(self.older.values_mut()) {
            if entry.mesh.strong_count() == 0 {
                entry.levels = None;
            }
        }
    }

    /// Counts a draw of a mesh that may have a level, and returns the levels; makes them if the draws
    /// pay for them.
    pub(super) fn levels_of(&mut self, geometry: &Arc<Geometry>) -> Result<&[Level], WholeReason> {
        let is_due = self.is_due(geometry);
        if is_due {
            self.forget_gone();
            let held = self.reserve_levels(geometry);
            let levels = if held.is_some() { make_levels(&geometry.mesh, &NEVER) } else { Vec::new() };
            self.keep_levels(geometry, levels, held);
        }
        let expected = self.expected_draws;
        let entry = self.entry(geometry);
        entry.detail_draws += 1;
        let draws = expected.unwrap_or(entry.detail_draws);
        match &entry.levels {
            None => Err(WholeReason::Unpaid { draws, needed: DRAWS_FOR_LEVELS }),
            Some(kept) if kept.levels.is_empty() => Err(WholeReason::NoLevels),
            Some(kept) => Ok(&kept.levels),
        }
    }

    /// Returns the number of faces whose angles were measured so far.
    pub fn measured_faces(&self) -> u64 {
        self.measured_faces
    }

    /// Counts a draw of a mesh, and returns its box; `None` the first time that it is seen.
    pub(super) fn box_of(&mut self, geometry: &Arc<Geometry>) -> Option<MeshBox> {
        let address = Arc::as_ptr(geometry) as usize;
        if let Some((last, mesh_box)) = self.last_box
            && last == address
        {
            return Some(mesh_box);
        }
        let measures_at_once = self.measures_at_once;
        let entry = self.entry(geometry);
        if entry.mesh_box.is_none() && (entry.was_drawn || measures_at_once) {
            entry.mesh_box = Some(MeshBox::of(&geometry.mesh));
        }
        entry.was_drawn = true;
        let mesh_box = entry.mesh_box;
        self.last_box = mesh_box.map(|mesh_box| (address, mesh_box));
        mesh_box
    }

    /// Returns the angles of a mesh, if it has any.
    pub(super) fn angles_of(&mut self, geometry: &Arc<Geometry>) -> Option<MeshAngles> {
        let entry = self.entry(geometry);
        if let Some(angles) = entry.angles {
            return angles;
        }
        let angles = MeshAngles::of(&geometry.mesh);
        entry.angles = Some(angles);
        self.measured_faces += geometry.mesh.triangles.len() as u64;
        angles
    }

    /// Returns the transform of a draw from the world to clip space, if its camera has one.
    pub(super) fn clip_transform(&mut self, call: &DrawCall) -> Option<ClipTransform> {
        let aspect = f64::from(call.viewport.width) / f64::from(call.viewport.height);
        if let Some((last, last_aspect, to_clip)) = &self.last_camera
            && (*last, *last_aspect) == (call.camera, aspect)
        {
            return *to_clip;
        }
        let to_clip = call.camera.matrices(aspect).ok().map(|matrices| ClipTransform::of(&matrices));
        self.last_camera = Some((call.camera, aspect, to_clip));
        to_clip
    }

    /// Returns the entry of a mesh, which is a new one if the mesh is.
    fn entry(&mut self, geometry: &Arc<Geometry>) -> &mut MeshEntry {
        let address = Arc::as_ptr(geometry) as usize;
        if self.recent.len() >= KEPT {
            self.older = std::mem::take(&mut self.recent);
        }
        let new = || MeshEntry {
            mesh: Arc::downgrade(geometry),
            was_drawn: false,
            mesh_box: None,
            angles: None,
            detail_draws: 0,
            levels: None,
        };
        self.recent.entry(address).or_insert_with(|| self.older.remove(&address).unwrap_or_else(new))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::shapes;
    use glam::DVec3;

    fn cuboid() -> Arc<Geometry> {
        Arc::new(Geometry { mesh: shapes::cuboid(DVec3::ONE).unwrap(), textures: Vec::new() })
    }

    #[test]
    fn a_mesh_is_measured_once_and_from_its_second_draw_on() {
        let (mut shapes, mesh) = (MeshShapes::default(), cuboid());
        assert_eq!(shapes.box_of(&mesh), None);
        let measured = shapes.box_of(&mesh);
        assert!(measured.is_some());
        for _ in 0..3 {
            // The last mesh is not looked up again; another one in between is told from it.
            assert_eq!(shapes.box_of(&mesh), measured);
            assert!(shapes.angles_of(&mesh).is_some());
        }
        assert_eq!(shapes.measured_faces(), 12);
        let other =
            Arc::new(Geometry { mesh: shapes::cuboid(DVec3::splat(2.0)).unwrap(), textures: Vec::new() });
        assert_eq!(shapes.box_of(&other), None);
        assert_ne!(shapes.box_of(&other), measured);
        assert_eq!(shapes.box_of(&mesh), measured);
        assert!(MeshShapes::at_once().box_of(&mesh).is_some());
    }

    #[test]
    fn meshes_that_are_drawn_stay_and_others_are_forgotten() {
        let (mut shapes, kept, left) = (MeshShapes::default(), cuboid(), cuboid());
        for mesh in [&kept, &left] {
            shapes.box_of(mesh);
        }
        for _ in 0..3 * KEPT {
            // A mesh of its own does not outlive the draw.
            assert_eq!(shapes.box_of(&cuboid()), None);
            assert!(shapes.box_of(&kept).is_some());
        }
        assert_eq!(shapes.box_of(&left), None);
        assert!(shapes.recent.len() + shapes.older.len() <= 2 * KEPT);
    }
}

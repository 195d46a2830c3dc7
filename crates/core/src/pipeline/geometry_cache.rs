//! Cached facts about a mesh: validity, attributes in use, bounds, normals, indexed mesh.

use super::draw_call::PipelineError;
use super::indexed_mesh::{FaceTable, IndexedMesh};
use super::mesh_extent::MeshExtent;
use super::normals::{Normals, polygon_normal};
use super::occlusion_history::OcclusionHistory;
use crate::cancel::CancelToken;
use crate::math::matrix::unit;
use crate::memory::{MemoryBudget, MemoryUse, OverBudget, Reservation};
use crate::scene::{Corner, Geometry, Mesh};
use glam::{DVec2, DVec3, DVec4};
use std::cell::Cell;
use std::sync::{Mutex, OnceLock, PoisonError};

/// The facts that a draw needs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Needs {
    /// `Some` for polygon normals; `Some(true)` for the means at the positions too.
    pub normals: Option<bool>,
    /// `Some` for the indexed mesh; `Some(true)` with normals.
    pub prepared: Option<bool>,
    /// True for the table of flat-shaded faces.
    pub faces: bool,
}

/// Faces between two checks of the cancel token.
const FACES_AT_ONCE: usize = 4096;

/// Facts about one geometry. The public fields are computed at once, the others on first use.
#[derive(Debug)]
pub(crate) struct GeometryInfo {
    /// Result of checking that all indices are within the mesh's arrays.
    pub checked: Result<(), PipelineError>,
    /// True if the file gives every corner's normal.
    pub all_normals_given: bool,
    /// True if some vertex colour has alpha below 1.
    pub has_clear_colors: bool,
    /// One polygon index per material in use, in order of first use.
    pub materials: Vec<u32>,
    /// Object-space bounding box of all positions; `None` if there are none.
    pub bounds: Option<(DVec3, DVec3)>,
    /// Largest range of u or v over a face; infinite if a corner has no texture coordinates, or some
    /// that f32 does not reach.
    pub texcoord_run: f64,
    face_normals: OnceLock<Normals>,
    smooth_normals: OnceLock<Normals>,
    unlit: OnceLock<IndexedMesh>,
    lit: OnceLock<IndexedMesh>,
    faces: OnceLock<FaceTable>,
    /// True if the faces bound a convex body; empty until the planner asks.
    pub convex_body: OnceLock<bool>,
    /// Extent of the faces, computed when a stream first asks for a bound of a draw's time.
    pub extent: OnceLock<MeshExtent>,
    /// Token that ends the computation of normals, tables and indexed meshes early; a result is
    /// then empty or incomplete.
    cancel: CancelToken,
    /// Budget reservation for the cached parts.
    held: Mutex<Option<Reservation>>,
    /// Occlusion found by its draws.
    pub occlusion: OcclusionHistory,
}

impl GeometryInfo {
    /// Checks the mesh and computes the public facts; `cancel` ends later computations early.
    pub fn of(geometry: &Geometry, cancel: CancelToken) -> Self {
        let mesh = &geometry.mesh;
        let given = |c: &Corner| mesh.normals.get(c.normal as usize).is_some_and(|n| *n != DVec3::ZERO);
        let mut seen = vec![false; mesh.materials.len() + 1];
        let mut materials = Vec::new();
        for (i, p) in mesh.polygons.iter().enumerate() {
            let slot = (p.material as usize).min(mesh.materials.len());
            if !std::mem::replace(&mut seen[slot], true) {
                materials.push(i as u32);
            }
        }
        GeometryInfo {
            checked: check(mesh),
            all_normals_given: mesh.corners.iter().all(given),
            has_clear_colors: mesh.colors.iter().any(|c| c.w < 1.0),
            materials,
            bounds: mesh.bounds(),
            texcoord_run: texcoord_run(mesh),
            face_normals: OnceLock::new(),
            smooth_normals: OnceLock::new(),
            unlit: OnceLock::new(),
            lit: OnceLock::new(),
            faces: OnceLock::new(),
            convex_body: OnceLock::new(),
            extent: OnceLock::new(),
            cancel,
            held: Mutex::new(None),
            occlusion: OcclusionHistory::default(),
        }
    }

    /// Computes those facts in `needs` that are missing: normals, the indexed mesh for the tile
    /// renderer, the table of flat-shaded faces.
    ///
    /// # Errors
    /// When they do not fit `budget`; earlier facts stay.
    pub fn prepare(&self, mesh: &Mesh, needs: Needs, budget: &MemoryBudget) -> Result<(), OverBudget> {
        if self.has(needs) {
            return Ok(());
        }
        let mut held = self.held.lock().unwrap_or_else(PoisonError::into_inner);
        let held = held.get_or_insert_with(|| budget.empty(MemoryUse::Resources));
        let result = self.make(mesh, needs, held);
        held.set(self.size_bytes() as u64);
        result
    }

    /// Returns whether all facts in `needs` have been computed.
    pub fn has(&self, needs: Needs) -> bool {
        let normals = match needs.normals {
            None => true,
            Some(false) => self.face_normals.get().is_some(),
            Some(true) => self.smooth_normals.get().is_some(),
        };
        let prepared = match needs.prepared {
            None => true,
            Some(false) => self.lit.get().is_some() || self.unlit.get().is_some(),
            Some(true) => self.lit.get().is_some(),
        };
        normals && prepared && (!needs.faces || self.faces.get().is_some())
    }

    /// Computes the missing facts in `needs`, reserving their bytes in `held` first.
    fn make(&self, mesh: &Mesh, needs: Needs, held: &mut Reservation) -> Result<(), OverBudget> {
        let have = || self.size_bytes() as u64;
        let (polygons, positions) = (mesh.polygons.len() as u64, mesh.positions.len() as u64);
        let wants_smooth = needs.normals == Some(true)
            || needs.prepared == Some(true) && self.lit.get().is_none() && !self.all_normals_given;
        if wants_smooth && self.smooth_normals.get().is_none() {
            // Includes the sums and the last polygon per position, which are freed afterwards.
            held.try_cover(have() + polygons * 24 + positions * (24 + 32 + 4))?;
            self.normals(mesh, true);
        }
        if (needs.normals == Some(false) || needs.faces) && self.face_normals.get().is_none() {
            held.try_cover(have() + polygons * 24)?;
            self.normals(mesh, false);
        }
        if needs.faces && self.faces.get().is_none() {
            held.try_cover(have() + mesh.triangles.len() as u64 * (24 + 16 + 16))?;
            self.faces(mesh);
        }
        match needs.prepared {
            Some(true) if self.lit.get().is_none() => {
                let made = self.prepare_lit(mesh, |bytes| held.try_cover(have() + bytes))?;
                let _ = self.lit.set(made);
            }
            Some(false) if self.lit.get().is_none() && self.unlit.get().is_none() => {
                let room = |bytes| held.try_cover(have() + bytes);
                let _ = self.unlit.set(IndexedMesh::within(mesh, |_, _| DVec3::ZERO, room, &self.cancel)?);
            }
            _ => {}
        }
        Ok(())
    }

    /// Builds the indexed mesh with a normal per corner: the file's, else the mean at the position,
    /// else the polygon's. `room` reserves its bytes.
    fn prepare_lit(
        &self,
        mesh: &Mesh,
        room: impl FnMut(u64) -> Result<(), OverBudget>,
    ) -> Result<IndexedMesh, OverBudget> {
        let means = (!self.all_normals_given).then(|| self.normals(mesh, true));
        // Consecutive triangles share a polygon, which may have many corners.
        let last = Cell::new((u32::MAX, None));
        let face_normal = |t: u32| {
            let polygon = mesh.triangle_polygon[t as usize];
            if last.get().0 != polygon {
                let position = |c: &Corner| mesh.positions[c.position as usize];
                let corners = mesh.polygon_corners(polygon as usize);
                last.set((polygon, polygon_normal(corners.iter().map(position))));
            }
            last.get().1.unwrap_or_else(|| triangle_normal(mesh, t))
        };
        let normal_of = |t, corner: &Corner| {
            let given = mesh.normals.get(corner.normal as usize).and_then(|&n| unit(n));
            let mean = || {
                let mean = *means?.of_position.get(corner.position as usize)?;
                Some(mean).filter(|n| *n != DVec3::ZERO)
            };
            given.or_else(mean).unwrap_or_else(|| face_normal(t))
        };
        IndexedMesh::within(mesh, normal_of, room, &self.cancel)
    }

    /// Returns the polygons' normals and, if `smooth`, the means at the positions.
    pub fn normals(&self, mesh: &Mesh, smooth: bool) -> &Normals {
        match smooth {
            true => self.smooth_normals.get_or_init(|| Normals::of(mesh, true, &self.cancel)),
            false => self.face_normals.get_or_init(|| Normals::of(mesh, false, &self.cancel)),
        }
    }

    /// Returns the indexed mesh, with normals if `is_lit`.
    pub fn prepared(&self, mesh: &Mesh, is_lit: bool) -> &IndexedMesh {
        if let (false, Some(lit)) = (is_lit, self.lit.get()) {
            return lit;
        }
        if !is_lit {
            return self.unlit.get_or_init(|| {
                let made = IndexedMesh::within(mesh, |_, _| DVec3::ZERO, |_| Ok(()), &self.cancel);
                made.expect("nothing refuses")
            });
        }
        self.lit.get_or_init(|| self.prepare_lit(mesh, |_| Ok(())).expect("nothing refuses"))
    }

    /// Returns the table of flat-shaded faces.
    pub fn faces(&self, mesh: &Mesh) -> &FaceTable {
        self.faces.get_or_init(|| {
            let normals = self.normals(mesh, false);
            let mut table = FaceTable::default();
            let faces = mesh.triangles.len();
            table.centers.iter_mut().for_each(|list| list.reserve_exact(faces));
            table.normals.reserve_exact(faces);
            table.colors.reserve_exact(if mesh.colors.is_empty() { 0 } else { faces });
            // Consecutive triangles share a polygon, which may have many corners.
            let (mut last, mut center, mut color) = (u32::MAX, DVec3::ZERO, DVec4::ONE);
            for (t, &polygon) in mesh.triangle_polygon.iter().enumerate().take(mesh.triangles.len()) {
                // A cancelled computation of normals leaves none to read here.
                if t % FACES_AT_ONCE == 0 && self.cancel.is_cancelled() {
                    break;
                }
                if polygon != last {
                    last = polygon;
                    (center, color) = means_of(mesh, mesh.polygon_corners(polygon as usize));
                }
                for (axis, list) in table.centers.iter_mut().enumerate() {
                    list.push(center[axis]);
                }
                let normal = match normals.of_polygon[polygon as usize] {
                    n if n != DVec3::ZERO => n,
                    _ => triangle_normal(mesh, t as u32),
                };
                table.normals.push(normal.extend(0.0).as_vec4().to_array());
                if !mesh.colors.is_empty() {
                    table.colors.push(color.as_vec4().to_array());
                }
            }
            table
        })
    }

    /// Returns the vertex count of the indexed mesh, if it has been computed.
    pub fn vertex_count(&self) -> Option<u64> {
        self.lit.get().or(self.unlit.get()).map(|p| p.vertex_count() as u64)
    }

    /// Returns the bytes of all cached facts.
    pub fn size_bytes(&self) -> usize {
        let normals = |n: Option<&Normals>| n.map_or(0, |n| (n.of_polygon.len() + n.of_position.len()) * 24);
        let mesh = |m: Option<&IndexedMesh>| m.map_or(0, IndexedMesh::size_bytes);
        normals(self.face_normals.get())
            + normals(self.smooth_normals.get())
            + mesh(self.unlit.get())
            + mesh(self.lit.get())
            + self.faces.get().map_or(0, |f| f.normals.len() * 40 + f.colors.len() * 16)
    }
}

/// Returns [`GeometryInfo::texcoord_run`].
fn texcoord_run(mesh: &Mesh) -> f64 {
    if mesh.texcoords.is_empty() {
        return f64::INFINITY;
    }
    let is_carried = |uv: &DVec2| uv.abs().max_element() <= f64::from(f32::MAX) && !uv.is_nan();
    let texcoord = |corner: u32| {
        let corner = mesh.corners.get(corner as usize)?;
        mesh.texcoords.get(corner.texcoord as usize).copied().filter(is_carried)
    };
    let run = |triangle: &[u32; 3]| match triangle.map(texcoord) {
        [Some(a), Some(b), Some(c)] => (a.max(b).max(c) - a.min(b).min(c)).max_element(),
        _ => f64::INFINITY,
    };
    mesh.triangles.iter().map(run).fold(0.0, f64::max)
}

/// Returns the object-space unit normal of a triangle; zero without area.
fn triangle_normal(mesh: &Mesh, triangle: u32) -> DVec3 {
    let corners = mesh.triangles[triangle as usize].map(|c| &mesh.corners[c as usize]);
    let position = |c: &Corner| mesh.positions[c.position as usize];
    polygon_normal(corners.into_iter().map(position)).unwrap_or(DVec3::ZERO)
}

/// Returns the mean position and mean colour of a polygon's corners.
fn means_of(mesh: &Mesh, corners: &[Corner]) -> (DVec3, DVec4) {
    let count = corners.len() as f64;
    let sum = corners.iter().fold(DVec3::ZERO, |sum, c| sum + mesh.positions[c.position as usize]);
    let color = |c: &Corner| mesh.colors.get(c.color as usize).copied().unwrap_or(DVec4::ONE);
    (sum / count, corners.iter().fold(DVec4::ZERO, |sum, c| sum + color(c)) / count)
}

/// Checks that all indices of a mesh are within its arrays.
fn check(mesh: &Mesh) -> Result<(), PipelineError> {
    let inside = |what: &'static str, index: u64, len: usize| match index < len as u64 {
        true => Ok(()),
        false => Err(PipelineError::BadIndex { what, index, len: len as u64 }),
    };
    for c in &mesh.corners {
        inside("position", c.position.into(), mesh.positions.len())?;
    }
    for p in &mesh.polygons {
        inside("corner", p.first_corner as u64 + p.corner_count.max(1) as u64 - 1, mesh.corners.len())?;
    }
    inside("triangle", mesh.triangles.len() as u64, mesh.triangle_polygon.len() + 1)?;
    for (t, &p) in mesh.triangles.iter().zip(&mesh.triangle_polygon) {
        inside("polygon", p.into(), mesh.polygons.len())?;
        for &c in t {
            inside("corner", c.into(), mesh.corners.len())?;
        }
    }
    for &c in mesh.lines.iter().flatten().chain(&mesh.points) {
        inside("corner", c.into(), mesh.corners.len())?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::indexed_mesh::Clusters;
    use crate::scene::shapes;

    fn geometry(mesh: Mesh) -> Geometry {
        Geometry { mesh, textures: Vec::new() }
    }

    #[test]
    fn nothing_is_made_of_a_mesh_whose_draw_is_cancelled() {
        let mut knot = shapes::knot(60, 40).unwrap();
        knot.corners.iter_mut().for_each(|c| c.normal = crate::scene::NONE);
        let knot = geometry(knot);
        let (mesh, cancel) = (&knot.mesh, CancelToken::new());
        let geometry_info = GeometryInfo::of(&knot, cancel.clone());
        cancel.cancel();
        let needs = Needs { normals: Some(true), prepared: Some(true), faces: true };
        geometry_info.prepare(mesh, needs, &MemoryBudget::unlimited()).unwrap();
        assert_eq!(geometry_info.size_bytes(), 0);
        let whole = GeometryInfo::of(&knot, CancelToken::default());
        whole.prepare(mesh, needs, &MemoryBudget::unlimited()).unwrap();
        let made = whole.prepared(mesh, true);
        assert!(!made.clusters.is_empty() && made.triangle_count == mesh.triangles.len());
        assert!(Clusters::of(&made.positions, &made.corners, made.triangle_count, &cancel).is_empty());
    }

    #[test]
    fn coordinates_that_f32_does_not_reach_run_without_end() {
        let mut knot = geometry(shapes::knot(12, 5).unwrap());
        let run = |knot: &Geometry| GeometryInfo::of(knot, CancelToken::default()).texcoord_run;
        assert!(run(&knot) < 10.0);
        for far in [1e39, -1e200, f64::INFINITY, f64::NAN] {
            knot.mesh.texcoords.iter_mut().for_each(|uv| uv.x = far);
            assert_eq!(run(&knot), f64::INFINITY, "all at {far}");
        }
        let mut knot = geometry(shapes::knot(12, 5).unwrap());
        knot.mesh.corners[7].texcoord = crate::scene::NONE;
        assert_eq!(run(&knot), f64::INFINITY, "a corner without coordinates");
    }

    #[test]
    fn means_of_normals_are_not_made_without_room_for_their_sums() {
        let mut knot = shapes::knot(60, 40).unwrap();
        knot.corners.iter_mut().for_each(|c| c.normal = crate::scene::NONE);
        let knot = geometry(knot);
        let (polygons, positions) = (knot.mesh.polygons.len() as u64, knot.mesh.positions.len() as u64);
        let needs = Needs { normals: Some(true), ..Needs::default() };
        let result = (polygons + positions) * 24;
        // At each position a sum of four numbers and the last polygon that was added.
        let sums = positions * (4 * 8 + 4);
        for (room, fits) in [(result + sums, true), (result + sums - 1, false), (result, false)] {
            let geometry_info = GeometryInfo::of(&knot, CancelToken::default());
            let budget = MemoryBudget::new(room);
            assert_eq!(geometry_info.prepare(&knot.mesh, needs, &budget).is_ok(), fits, "{room}");
            // Afterwards only the result is held.
            assert_eq!(budget.used(), if fits { result } else { 0 });
            assert_eq!(geometry_info.size_bytes() as u64, budget.used());
        }
    }

    #[test]
    fn a_polygon_of_many_corners_costs_what_its_triangles_do() {
        // Adding up the corners for every triangle would take hours.
        const COUNT: usize = 300_000;
        let mut mesh = Mesh::from_triangles(vec![DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2]]);
        let corner = |i: usize| Corner { position: (i % 2) as u32, ..mesh.corners[0] };
        mesh.corners = (0..COUNT).map(corner).collect();
        mesh.polygons[0].corner_count = COUNT as u32;
        mesh.triangles = (2..COUNT as u32).map(|i| [0, i - 1, i]).collect();
        mesh.triangle_polygon = vec![0; mesh.triangles.len()];
        let geometry = geometry(mesh);
        let geometry_info = GeometryInfo::of(&geometry, CancelToken::default());
        geometry_info.checked.as_ref().unwrap();
        let needs = Needs { normals: Some(true), prepared: Some(true), faces: true };
        geometry_info.prepare(&geometry.mesh, needs, &MemoryBudget::unlimited()).unwrap();
        let table = geometry_info.faces(&geometry.mesh);
        let last = table.normals.len() - 1;
        assert_eq!((last, table.centers[0][last], table.normals[last]), (COUNT - 3, 0.5, [0.0; 4]));
        assert_eq!(geometry_info.prepared(&geometry.mesh, true).vertex_count(), 2);
    }
}

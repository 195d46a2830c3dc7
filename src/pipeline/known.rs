//! What is found out about a geometry once, however often it is drawn: whether it is sound, what it asks for, its normals,
//! its prepared form.

use super::call::PipelineError;
use super::normals::{Normals, polygon_normal};
use super::tile::{FaceTable, PreparedMesh};
use crate::cancel::CancelToken;
use crate::math::matrix::unit;
use crate::memory::{MemoryBudget, MemoryUse, OverBudget, Reservation};
use crate::scene::{Corner, Geometry, Mesh};
use glam::{DVec3, DVec4};
use std::sync::{Mutex, OnceLock, PoisonError};

/// The parts that a draw asks for.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Needs {
    /// The polygons' normals, and with `true` the means at the positions.
    pub normals: Option<bool>,
    /// The prepared form, and with `true` its normals.
    pub prepared: Option<bool>,
    /// The table of faces that are lit as wholes.
    pub faces: bool,
}

/// See the module's text. Everything but the first part is made when it is first asked for.
#[derive(Debug)]
pub(crate) struct Known {
    /// Whether the mesh points into its own arrays only.
    pub checked: Result<(), PipelineError>,
    /// Whether the file gives every corner's normal.
    pub all_normals_given: bool,
    /// Whether some vertex colour lets light through.
    pub has_clear_colors: bool,
    /// A polygon of each material that occurs, in the order in which they do.
    pub materials: Vec<u32>,
    /// The object-space box around all positions.
    pub bounds: Option<(DVec3, DVec3)>,
    face_normals: OnceLock<Normals>,
    smooth_normals: OnceLock<Normals>,
    unlit: OnceLock<PreparedMesh>,
    lit: OnceLock<PreparedMesh>,
    faces: OnceLock<FaceTable>,
    /// Ends the making of a prepared form early; it then has no faces.
    cancel: CancelToken,
    /// What the parts above hold of the renderer's budget.
    held: Mutex<Option<Reservation>>,
}

impl Known {
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
        Known {
            checked: check(mesh),
            all_normals_given: mesh.corners.iter().all(given),
            has_clear_colors: mesh.colors.iter().any(|c| c.w < 1.0),
            materials,
            bounds: mesh.bounds(),
            face_normals: OnceLock::new(),
            smooth_normals: OnceLock::new(),
            unlit: OnceLock::new(),
            lit: OnceLock::new(),
            faces: OnceLock::new(),
            cancel,
            held: Mutex::new(None),
        }
    }

    /// Makes what a draw asks for, as far as it is not there: normals, the prepared form where the tile renderer draws, the table of
    /// faces that are lit as wholes.
    ///
    /// # Errors
    /// When `budget` has no room for it; what was there before stays.
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

    fn has(&self, needs: Needs) -> bool {
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

    fn make(&self, mesh: &Mesh, needs: Needs, held: &mut Reservation) -> Result<(), OverBudget> {
        let have = || self.size_bytes() as u64;
        let (polygons, positions) = (mesh.polygons.len() as u64, mesh.positions.len() as u64);
        let wants_smooth = needs.normals == Some(true)
            || needs.prepared == Some(true) && self.lit.get().is_none() && !self.all_normals_given;
        if wants_smooth && self.smooth_normals.get().is_none() {
            // Sums, and who was seen last, go again.
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
                let _ = self.unlit.set(PreparedMesh::within(mesh, |_, _| DVec3::ZERO, room, &self.cancel)?);
            }
            _ => {}
        }
        Ok(())
    }

    fn prepare_lit(
        &self,
        mesh: &Mesh,
        room: impl FnMut(u64) -> Result<(), OverBudget>,
    ) -> Result<PreparedMesh, OverBudget> {
        let means = (!self.all_normals_given).then(|| self.normals(mesh, true));
        let normal_of = |t, corner: &Corner| {
            let given = mesh.normals.get(corner.normal as usize).and_then(|&n| unit(n));
            let mean = || {
                let mean = *means?.of_position.get(corner.position as usize)?;
                Some(mean).filter(|n| *n != DVec3::ZERO)
            };
            given.or_else(mean).unwrap_or_else(|| face_normal(mesh, t))
        };
        PreparedMesh::within(mesh, normal_of, room, &self.cancel)
    }

    /// The normals of the polygons, and with `smooth` the means at the positions.
    pub fn normals(&self, mesh: &Mesh, smooth: bool) -> &Normals {
        match smooth {
            true => self.smooth_normals.get_or_init(|| Normals::of(mesh, true)),
            false => self.face_normals.get_or_init(|| Normals::of(mesh, false)),
        }
    }

    /// The prepared form, with normals where `is_lit`.
    pub fn prepared(&self, mesh: &Mesh, is_lit: bool) -> &PreparedMesh {
        if let (false, Some(lit)) = (is_lit, self.lit.get()) {
            return lit;
        }
        if !is_lit {
            return self.unlit.get_or_init(|| {
                let made = PreparedMesh::within(mesh, |_, _| DVec3::ZERO, |_| Ok(()), &self.cancel);
                made.expect("nothing refuses")
            });
        }
        self.lit.get_or_init(|| self.prepare_lit(mesh, |_| Ok(())).expect("nothing refuses"))
    }

    /// The table of faces that are lit as wholes.
    pub fn faces(&self, mesh: &Mesh) -> &FaceTable {
        self.faces.get_or_init(|| {
            let normals = self.normals(mesh, false);
            let mut table = FaceTable::default();
            let faces = mesh.triangles.len();
            table.centers.iter_mut().for_each(|list| list.reserve_exact(faces));
            table.normals.reserve_exact(faces);
            table.colors.reserve_exact(if mesh.colors.is_empty() { 0 } else { faces });
            for (t, &polygon) in mesh.triangle_polygon.iter().enumerate().take(mesh.triangles.len()) {
                let corners = mesh.polygon_corners(polygon as usize);
                let sum =
                    corners.iter().fold(DVec3::ZERO, |sum, c| sum + mesh.positions[c.position as usize]);
                let center = sum / corners.len() as f64;
                for (axis, list) in table.centers.iter_mut().enumerate() {
                    list.push(center[axis]);
                }
                let normal = match normals.of_polygon[polygon as usize] {
                    n if n != DVec3::ZERO => n,
                    _ => face_normal(mesh, t as u32),
                };
                table.normals.push(normal.extend(0.0).as_vec4().to_array());
                if !mesh.colors.is_empty() {
                    let color = |c: &Corner| mesh.colors.get(c.color as usize).copied().unwrap_or(DVec4::ONE);
                    let sum = corners.iter().fold(DVec4::ZERO, |sum, c| sum + color(c));
                    table.colors.push((sum / corners.len() as f64).as_vec4().to_array());
                }
            }
            table
        })
    }

    /// How many vertices the prepared form has, once there is one.
    pub fn vertex_count(&self) -> Option<u64> {
        self.lit.get().or(self.unlit.get()).map(|p| p.vertex_count() as u64)
    }

    /// Bytes that are kept.
    pub fn size_bytes(&self) -> usize {
        let normals = |n: Option<&Normals>| n.map_or(0, |n| (n.of_polygon.len() + n.of_position.len()) * 24);
        let mesh = |m: Option<&PreparedMesh>| m.map_or(0, PreparedMesh::size_bytes);
        normals(self.face_normals.get())
            + normals(self.smooth_normals.get())
            + mesh(self.unlit.get())
            + mesh(self.lit.get())
            + self.faces.get().map_or(0, |f| f.normals.len() * 40 + f.colors.len() * 16)
    }
}

/// The object-space unit normal of a triangle's polygon, or its own; zero without area.
fn face_normal(mesh: &Mesh, triangle: u32) -> DVec3 {
    let position = |c: &Corner| mesh.positions[c.position as usize];
    let polygon = mesh.polygon_corners(mesh.triangle_polygon[triangle as usize] as usize);
    polygon_normal(polygon.iter().map(position))
        .or_else(|| {
            let corners = mesh.triangles[triangle as usize].map(|c| &mesh.corners[c as usize]);
            polygon_normal(corners.into_iter().map(position))
        })
        .unwrap_or(DVec3::ZERO)
}

/// Refuses a mesh that points outside its own arrays.
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

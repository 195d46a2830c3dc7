//! Mesh files of any format: what reading one gives, and the steps that all formats share.
//!
//! In: the bytes of a file. Out: a [`LoadedMesh`] in object space. [`MeshFormat::of`] tells the
//! format by the first bytes; text that is no other format is OBJ.

use super::obj::SideFiles;
use super::{LoadError, LoadErrorKind, LoadMemory, LoadWarning, smooth};
use fbptr_core::scene::{Geometry, Mesh};

/// Mesh of a file, with the materials and textures that were found.
#[derive(Clone, Debug, Default)]
pub struct LoadedMesh {
    /// The mesh, and the texture of each of its materials.
    pub geometry: Geometry,
    /// Skipped parts, in the file's order.
    pub warnings: Vec<LoadWarning>,
    /// True if normals were computed and the surface has an edge with a single face, so that its
    /// back can be seen.
    pub is_open: bool,
}

/// Source of normals for faces that have none in the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Smoothing {
    /// One normal per position index: the mean of the faces' unit normals, computed when the mesh
    /// is drawn.
    #[default]
    Indices,
    /// Smooth across edges whose faces' normals differ by at most this angle in radians and are in
    /// the same smoothing group; equal positions are one vertex.
    Angle(f64),
    /// As `Angle`, with the limit from 27 to 38 degrees, near 30, at which the mesh has the fewest
    /// edges: sides of a round body are all smooth or all flat, and 45-degree chamfers are sharp.
    Automatic,
}

/// File format of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront's text.
    Obj,
    /// Facets of stereolithography, as text or as records of 50 bytes.
    Stl,
    /// The Polygon File Format, as text or binary in either byte order.
    Ply,
}

impl MeshFormat {
    /// Returns the format of a mesh file, by its bytes: STL, PLY, or OBJ if it is neither.
    pub fn of(bytes: &[u8]) -> MeshFormat {
        MeshFormat::recognize(bytes, bytes.len() as u64).unwrap_or(MeshFormat::Obj)
    }

    /// Returns the format of a file of `length` bytes that begins with `first`, if that tells it.
    #[doc(hidden)]
    pub fn recognize(first: &[u8], length: u64) -> Option<MeshFormat> {
        match first {
            _ if super::ply::is_ply(first) => Some(MeshFormat::Ply),
            _ if super::stl::is_stl(first, length) => Some(MeshFormat::Stl),
            _ => None,
        }
    }

    /// Parses a mesh file of this format; the arguments are those of
    /// [`obj::parse_smooth`](super::obj::parse_smooth).
    ///
    /// # Errors
    /// If the file has an error, or `memory` has no room or is cancelled.
    pub fn parse(
        self,
        bytes: &[u8],
        side_files: &mut SideFiles<'_>,
        file_name: &str,
        memory: &mut LoadMemory,
        smoothing: Smoothing,
    ) -> Result<LoadedMesh, LoadError> {
        match self {
            MeshFormat::Obj => super::obj::parse_smooth(bytes, side_files, file_name, memory, smoothing),
            MeshFormat::Stl => super::stl::parse(bytes, file_name, memory, smoothing),
            MeshFormat::Ply => super::ply::parse_textured(bytes, side_files, file_name, memory, smoothing),
        }
    }
}

/// Limit of the sum, over large polygons, of their corner counts squared: a bound on the time of
/// ear clipping.
const MAX_EAR_WORK: u64 = 4_000_000_000;
/// Corner count up to which the cost of a polygon is negligible.
const LARGE_POLYGON: u64 = 64;

/// Sizes of the polygons read so far, against the limits of a mesh.
#[derive(Debug, Default)]
pub(super) struct PolygonSizes {
    corners: u64,
    ear_work: u64,
}

impl PolygonSizes {
    /// Counts an element of `corners` corners, which is triangulated if it is a face.
    ///
    /// # Errors
    /// If there are more corners than indices, or triangulation would take too long.
    pub(super) fn add(&mut self, corners: usize, is_face: bool) -> Result<(), LoadErrorKind> {
        let n = corners as u64;
        self.corners += n;
        let (found, limit) = (self.corners, u64::from(u32::MAX - 1));
        if found > limit {
            return Err(LoadErrorKind::TooBig { what: "corners", found, limit });
        }
        if is_face && n > LARGE_POLYGON {
            self.ear_work = self.ear_work.saturating_add(n.saturating_mul(n));
            let (found, limit) = (self.ear_work, MAX_EAR_WORK);
            if found > limit {
                return Err(LoadErrorKind::TooBig {
                    what: "squared corners of large polygons",
                    found,
                    limit,
                });
            }
        }
        Ok(())
    }
}

/// Computes the normals of faces that have none, and returns whether the surface is open. `groups`
/// is the smoothing group of each polygon, empty for a format without groups.
pub(super) fn add_normals(
    mesh: &mut Mesh,
    groups: &[u32],
    smoothing: Smoothing,
    memory: &LoadMemory,
) -> Result<bool, LoadErrorKind> {
    match smoothing {
        Smoothing::Indices => Ok(false),
        Smoothing::Angle(_) | Smoothing::Automatic => {
            let _work = memory.work(smooth::working_bytes(mesh))?;
            let max_angle_rad = match smoothing {
                Smoothing::Angle(max_angle_rad) => Some(max_angle_rad),
                _ => None,
            };
            Ok(smooth::smooth(mesh, groups, max_angle_rad))
        }
    }
}

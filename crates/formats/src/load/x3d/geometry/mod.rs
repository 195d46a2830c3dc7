//! Conversion of geometry nodes to meshes, in object space.
//!
//! Out: a mesh whose faces are counter-clockwise seen from their front (the order of `ccw='false'`
//! is reversed), with a normal, a texture coordinate (if the shape has a texture) and a colour (if
//! the file has one) at every corner.
//!
//! Sources: ISO/IEC 19775-1 clauses 11 (Rendering), 13 (Geometry3D), 14 (Geometry2D), 15 (Text), 32 (CAD geometry).
//!
//! Beyond the standard: missing parts of a list are replaced with a remark where the rest of the
//! picture can then be shown (`texCoordIndex` and `colorIndex` whose runs differ from those of
//! `coordIndex`, some heights of a grid); a grid without heights or a geometry with coordinates of
//! an unknown type is left out with a remark; so is a face, a line or a point with an index out of
//! range, counted over the file.

pub(super) mod elevation;
mod extrusion;
mod faces;
mod flat;
mod font;
mod lines;
mod normals;
mod solids;
pub(super) mod text;
mod vertices;

pub(super) use vertices::vec2s;

use super::graph::{GraphView, NodeId};
use crate::load::LoadErrorKind;
use fbptr_core::scene::Mesh;

/// Most faces that one Text or Extrusion, or a grid that lacks heights, may have.
const MAX_MADE_FACES: u64 = 1 << 20;

/// Kind of vertex colours of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum ColorUse {
    /// No vertex colours: the material's colour applies.
    #[default]
    None,
    /// R, G, B replace the material's diffuse colour.
    Rgb,
    /// R, G, B as above, and A replaces the material's opacity.
    Rgba,
}

/// Kind of primitives of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum Stuff {
    /// Faces, lit by their material.
    #[default]
    Faces,
    /// Lines or points without normals: unlit, in the emissive colour.
    Bare,
    /// Lines or points with normals: lit like faces.
    Lit,
}

/// Mesh of a geometry node, with the properties needed to draw it.
#[derive(Clone, Debug, Default)]
pub(super) struct Built {
    pub(super) mesh: Mesh,
    pub(super) colors: ColorUse,
    pub(super) stuff: Stuff,
    /// Remarks on repaired defects, for the file's warnings.
    pub(super) remarks: Vec<String>,
    /// Faces, lines and points that are left out.
    pub(super) left_out: LeftOut,
}

/// Parts of geometries that are left out because of an index or a count: the first fault, and their
/// number.
#[derive(Clone, Debug, Default)]
pub(super) struct LeftOut {
    pub(super) first: Option<Fault>,
    pub(super) count: u64,
}

impl LeftOut {
    /// Returns what was made, or counts the part that it is missing from.
    fn keep<T>(&mut self, made: Result<T>) -> Option<T> {
        made.map_err(|fault| self.note(fault)).ok()
    }

    fn note(&mut self, fault: Fault) {
        self.count += 1;
        self.first.get_or_insert(fault);
    }
}

/// Error in a geometry, with the offending field.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    /// Offending node.
    pub(super) node: NodeId,
    /// Offending field of the node, empty for the node as a whole.
    pub(super) field: &'static str,
    pub(super) kind: LoadErrorKind,
}

type Result<T> = std::result::Result<T, Fault>;

/// Checks that an index is less than `count`; the error names `what`, and the node and field in
/// `view_of`.
fn index(view_of: (NodeId, &'static str), what: &'static str, index: i64, count: usize) -> Result<u32> {
    match u32::try_from(index) {
        Ok(i) if (i as usize) < count => Ok(i),
        _ => {
            let kind = LoadErrorKind::Index { what, index, count: count as u64 };
            Err(Fault { node: view_of.0, field: view_of.1, kind })
        }
    }
}

/// Returns the error for a list that is too short.
fn too_few(node: NodeId, field: &'static str, expected: String, found: usize) -> Fault {
    Fault { node, field, kind: LoadErrorKind::Syntax { expected, found: format!("{found}") } }
}

/// Returns the error for more faces than [`MAX_MADE_FACES`].
fn too_big(node: NodeId, field: &'static str, found: u64) -> Fault {
    Fault {
        node,
        field,
        kind: LoadErrorKind::TooBig { what: "faces of one node", found, limit: MAX_MADE_FACES },
    }
}

/// Computes the mesh of a geometry node, with texture coordinates if `is_textured`.
pub(super) fn build(view: &GraphView, id: NodeId, is_textured: bool) -> Result<Built> {
    let lacks_coord = view.graph.missing.get(&id).is_some_and(|m| m.contains(&"coord"));
    if lacks_coord && view.child(id, "coord").is_none() {
        let name = view.name(id);
        let remarks = vec![format!("<{name}> was left out: the node of its coordinates is not known")];
        return Ok(Built { remarks, ..Built::default() });
    }
    Ok(match view.name(id) {
        "TriangleSet"
        | "TriangleFanSet"
        | "TriangleStripSet"
        | "IndexedTriangleSet"
        | "IndexedTriangleFanSet"
        | "IndexedTriangleStripSet"
        | "QuadSet"
        | "IndexedQuadSet" => faces::face_set(view, id, is_textured)?,
        "IndexedFaceSet" => faces::indexed_face_set(view, id, is_textured)?,
        "ElevationGrid" => elevation::build(view, id, is_textured)?,
        "Extrusion" => extrusion::build(view, id, is_textured)?,
        "Box" | "Sphere" | "Cone" | "Cylinder" => solids::build(view, id),
        "PointSet" => lines::points(view, id)?,
        "LineSet" => lines::line_set(view, id)?,
        "IndexedLineSet" => lines::indexed_line_set(view, id)?,
        "Text" => text::build(view, id)?,
        _ => flat::build(view, id),
    })
}

/// Returns whether only the fronts of a geometry's faces are visible.
pub(super) fn is_solid(view: &GraphView, id: NodeId) -> bool {
    view.node(id).ty.field("solid").is_some() && view.bool(id, "solid")
}

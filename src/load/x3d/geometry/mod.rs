//! Geometry nodes to meshes, in object space.
//!
//! Out: a mesh whose faces are counter-clockwise seen from their front (`ccw='false'` is turned round here), with a normal,
//! a texture coordinate (where the shape has a texture) and a colour (where the file gives one) at every corner. Sources:
//! ISO/IEC 19775-1 clauses 11 (Rendering), 13 (Geometry3D), 14 (Geometry2D), 15 (Text).
//!
//! Beside the standard: what a file leaves out of a list is put right with a remark where a picture without it would show the
//! rest (`texCoordIndex` and `colorIndex` whose runs are not those of `coordIndex`, a grid without heights, coordinates of an unknown kind:
//! that geometry is left out); an index that names nothing is refused.

mod elevation;
mod extrusion;
mod faces;
mod flat;
mod lines;
mod normals;
mod solids;
pub(super) mod text;
mod vertices;

pub(super) use vertices::vec2s;

use super::graph::{GraphView, NodeId};
use crate::load::LoadErrorKind;
use crate::scene::Mesh;

/// The most faces that one Text or Extrusion makes.
const MAX_MADE_FACES: u64 = 1 << 20;

/// Vertex colours of a geometry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub(super) enum ColorUse {
    /// None: the material's.
    #[default]
    None,
    /// R, G, B in place of the material's diffuse colour.
    Rgb,
    /// R, G, B, and A in place of its opacity too.
    Rgba,
}

/// What a geometry is made of.
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

/// A geometry node's mesh and how it is to be drawn.
#[derive(Clone, Debug, Default)]
pub(super) struct Built {
    pub(super) mesh: Mesh,
    pub(super) colors: ColorUse,
    pub(super) stuff: Stuff,
    /// What was put right, for the file's warnings.
    pub(super) remarks: Vec<String>,
}

/// What is wrong with a geometry: in which field, and why the file is refused.
#[derive(Clone, Debug)]
pub(super) struct Fault {
    /// The node to blame.
    pub(super) node: NodeId,
    /// Its field.
    pub(super) field: &'static str,
    pub(super) kind: LoadErrorKind,
}

type Result<T> = std::result::Result<T, Fault>;

/// An index that must name one of `count` things.
fn index(view_of: (NodeId, &'static str), what: &'static str, index: i64, count: usize) -> Result<u32> {
    match u32::try_from(index) {
        Ok(i) if (i as usize) < count => Ok(i),
        _ => {
            let kind = LoadErrorKind::Index { what, index, count: count as u64 };
            Err(Fault { node: view_of.0, field: view_of.1, kind })
        }
    }
}

/// The refusal of a list that is too short.
fn too_few(node: NodeId, field: &'static str, expected: String, found: usize) -> Fault {
    Fault { node, field, kind: LoadErrorKind::Syntax { expected, found: format!("{found}") } }
}

/// The refusal of more faces than [`MAX_MADE_FACES`].
fn too_big(node: NodeId, field: &'static str, found: u64) -> Fault {
    Fault {
        node,
        field,
        kind: LoadErrorKind::TooBig { what: "faces of one node", found, limit: MAX_MADE_FACES },
    }
}

/// The mesh of a geometry node. `is_textured`: whether texture coordinates are wanted.
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
        | "IndexedTriangleStripSet" => faces::triangles(view, id, is_textured)?,
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

/// Whether only the fronts of a geometry's faces are seen.
pub(super) fn is_solid(view: &GraphView, id: NodeId) -> bool {
    view.node(id).ty.field("solid").is_some() && view.bool(id, "solid")
}

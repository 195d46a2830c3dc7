//! Sets of triangles and of quads, and IndexedFaceSet.

use super::super::graph::{GraphView, NodeId};
use super::normals::{default_texcoords, push, smooth};
use super::vertices::{Vertices, runs};
use super::{Built, LeftOut, Result, too_few};
use fbptr_core::scene::{Corner, Mesh, NONE};
use std::f64::consts::PI;

/// Builds a set of triangles or quads, a fan or a strip, indexed or not. Missing normals are smooth
/// across shared coordinates, or one per face with normalPerVertex='false'.
pub(super) fn face_set(view: &GraphView, id: NodeId, is_textured: bool) -> Result<Built> {
    let name = view.name(id);
    let vertices = Vertices::read(view, id);
    let mut built = Built { colors: vertices.color_use, ..Built::default() };
    let sides = if name.ends_with("QuadSet") { 4 } else { 3 };
    let (indices, by) = face_indices(view, id, vertices.positions.len(), &mut built.left_out);
    let face_colors = !view.bool(id, "colorPerVertex");
    let face_normals = !view.bool(id, "normalPerVertex");
    let mut mesh = Mesh { positions: vertices.positions.clone(), ..Mesh::default() };
    for (face, indices) in (0_i64..).zip(indices.chunks_exact(sides)) {
        let corner = |i: i64| {
            Ok(Corner {
                position: vertices.position(i, (id, by))?,
                color: vertices.color(if face_colors { face } else { i }, (id, ""))?,
                normal: vertices.normal(if face_normals { face } else { i }, (id, ""))?,
                texcoord: vertices.texcoord(i, (id, ""))?,
            })
        };
        let corners: Result<Vec<Corner>> = indices.iter().map(|i| corner(*i)).collect();
        if let Some(mut corners) = built.left_out.keep(corners) {
            push(&mut mesh, &mut corners, view.bool(id, "ccw"));
        }
    }
    if matches!(name, "TriangleSet" | "QuadSet") && !vertices.positions.len().is_multiple_of(sides) {
        let face = if sides == 3 { "triangle" } else { "quad" };
        built.remarks.push(format!("<{name}> has coordinates left over that make no {face}"));
    }
    finish(&mut mesh, vertices, if face_normals { 0.0 } else { PI }, is_textured);
    Ok(Built { mesh, ..built })
}

/// Returns the coordinate indices of the faces one after the other, three or four each, and the field
/// that contains them (empty if they are implicit).
fn face_indices(
    view: &GraphView,
    id: NodeId,
    count: usize,
    left_out: &mut LeftOut,
) -> (Vec<i64>, &'static str) {
    let mut faces = Vec::new();
    let fan = |run: &[i64], out: &mut Vec<i64>| {
        out.extend(run.windows(2).skip(1).flat_map(|w| [run[0], w[0], w[1]]))
    };
    // Every second triangle of a strip is reversed, so that all have the same front.
    let strip = |run: &[i64], out: &mut Vec<i64>| {
        out.extend(run.windows(3).enumerate().flat_map(|(k, w)| match k % 2 {
            0 => [w[0], w[1], w[2]],
            _ => [w[1], w[0], w[2]],
        }));
    };
    match view.name(id) {
        "TriangleSet" | "QuadSet" => ((0..count as i64).collect(), ""),
        "IndexedTriangleSet" | "IndexedQuadSet" => (view.ints(id, "index").to_vec(), "index"),
        "IndexedTriangleFanSet" => {
            for run in runs(view.ints(id, "index")) {
                fan(run, &mut faces);
            }
            (faces, "index")
        }
        "IndexedTriangleStripSet" => {
            for run in runs(view.ints(id, "index")) {
                strip(run, &mut faces);
            }
            (faces, "index")
        }
        name => {
            let is_fan = name == "TriangleFanSet";
            let field = if is_fan { "fanCount" } else { "stripCount" };
            let mut first = 0;
            for &n in view.ints(id, field) {
                if n < 3 {
                    let expected = format!("expected counts of 3 or more in {field}");
                    left_out.note(too_few(id, field, expected, n.max(0) as usize));
                }
                if first + n > count as i64 {
                    let expected = format!("expected {field} to count no more than the {count} coordinates");
                    left_out.note(too_few(id, field, expected, (first + n) as usize));
                }
                let n = n.clamp(0, count as i64 - first);
                let run: Vec<i64> = (first..first + n).collect();
                match is_fan {
                    true => fan(&run, &mut faces),
                    false => strip(&run, &mut faces),
                }
                first += n;
            }
            (faces, "")
        }
    }
}

/// Builds an IndexedFaceSet. Faces of fewer than three corners are left out; concave ones are
/// triangulated correctly, whatever `convex` is.
pub(super) fn indexed_face_set(view: &GraphView, id: NodeId, is_textured: bool) -> Result<Built> {
    let vertices = Vertices::read(view, id);
    let faces = runs(view.ints(id, "coordIndex"));
    let texcoords = Lookup::per_corner(view, id, "texCoordIndex", Some(vertices.texcoords.len()));
    let lookup = |field, per_vertex: &str, fallback| match view.bool(id, per_vertex) {
        true => Lookup::per_corner(view, id, field, fallback),
        false => Lookup::per_face(view, id, field, fallback),
    };
    let colors = lookup("colorIndex", "colorPerVertex", Some(vertices.colors.len()));
    let normals = lookup("normalIndex", "normalPerVertex", None);
    let mut mesh = Mesh { positions: vertices.positions.clone(), ..Mesh::default() };
    let mut built = Built { colors: vertices.color_use, ..Built::default() };
    let mut thin = 0;
    let corner = |face: usize, k: usize, i: i64| {
        let position = vertices.position(i, (id, "coordIndex"))?;
        let mut corner = Corner { position, normal: NONE, texcoord: NONE, color: NONE };
        if vertices.color_use != super::ColorUse::None {
            let (i, by) = colors.of(face, k, i)?;
            corner.color = vertices.color(i, by)?;
        }
        if !vertices.normals.is_empty() {
            let (i, by) = normals.of(face, k, i)?;
            corner.normal = vertices.normal(i, by)?;
        }
        if !vertices.texcoords.is_empty() {
            let (i, by) = texcoords.of(face, k, i)?;
            corner.texcoord = vertices.texcoord(i, by)?;
        }
        Ok(corner)
    };
    for (face, indices) in faces.iter().enumerate() {
        let corners: Result<Vec<Corner>> = (0..).zip(*indices).map(|(k, i)| corner(face, k, *i)).collect();
        let Some(mut corners) = built.left_out.keep(corners) else { continue };
        match corners.len() {
            0..3 => thin += 1,
            _ => push(&mut mesh, &mut corners, view.bool(id, "ccw")),
        }
    }
    if thin > 0 {
        built
            .remarks
            .push(format!("<IndexedFaceSet> has {thin} faces of fewer than three corners, left out"));
    }
    built.remarks.extend([&texcoords, &colors].iter().filter_map(|l| l.remark(&faces)));
    let is_flat = !view.bool(id, "normalPerVertex");
    finish(&mut mesh, vertices, if is_flat { 0.0 } else { view.real(id, "creaseAngle") }, is_textured);
    Ok(Built { mesh, ..built })
}

/// Source of the index of a corner's colour, normal or texture coordinate. `fallback`: the number
/// of list entries, if missing indices may be replaced.
enum Lookup<'a> {
    /// A separate index list, in runs like the coordinates.
    Corner { node: NodeId, field: &'static str, runs: Vec<&'a [i64]>, fallback: Option<usize> },
    /// The coordinate's own index.
    Shared(NodeId),
    /// A list with one index per face.
    Face { node: NodeId, field: &'static str, list: &'a [i64], fallback: Option<usize> },
    /// The index of the face.
    Counted(NodeId),
}

impl<'a> Lookup<'a> {
    fn per_corner(view: &GraphView<'a>, node: NodeId, field: &'static str, fallback: Option<usize>) -> Self {
        match view.ints(node, field) {
            [] => Lookup::Shared(node),
            list => Lookup::Corner { node, field, runs: runs(list), fallback },
        }
    }

    fn per_face(view: &GraphView<'a>, node: NodeId, field: &'static str, fallback: Option<usize>) -> Self {
        match view.ints(node, field) {
            [] => Lookup::Counted(node),
            list => Lookup::Face { node, field, list, fallback },
        }
    }

    /// Returns the index for corner `k` of face `face`, whose coordinate index is `coordinate`, and
    /// the node and field it came from. A missing one is replaced by `coordinate` or, if that is
    /// too large, by 0.
    fn of(&self, face: usize, k: usize, coordinate: i64) -> Result<(i64, (NodeId, &'static str))> {
        let put_in = |count: usize| if (coordinate as u64) < count as u64 { coordinate } else { 0 };
        match self {
            Lookup::Corner { node, field, runs, fallback } => {
                let run = runs.get(face).copied().unwrap_or_default();
                match (run.get(k), fallback) {
                    (Some(index), _) => Ok((*index, (*node, field))),
                    (None, Some(count)) => Ok((put_in(*count), (*node, ""))),
                    (None, None) => {
                        let expected = format!("expected {field} to have runs like coordIndex");
                        Err(too_few(*node, field, expected, run.len()))
                    }
                }
            }
            Lookup::Shared(node) => Ok((coordinate, (*node, ""))),
            Lookup::Face { node, field, list, fallback } => match (list.get(face), fallback) {
                (Some(index), _) => Ok((*index, (*node, field))),
                (None, Some(_)) => Ok((0, (*node, ""))),
                (None, None) => {
                    let expected = format!("expected {field} to have an index for each face");
                    Err(too_few(*node, field, expected, list.len()))
                }
            },
            Lookup::Counted(node) => Ok((face as i64, (*node, ""))),
        }
    }

    /// Returns a remark if the separate index list does not match the faces.
    fn remark(&self, faces: &[&[i64]]) -> Option<String> {
        match self {
            Lookup::Corner { field, runs, .. } => {
                let differ = faces.iter().zip(runs).filter(|(face, run)| face.len() != run.len()).count();
                let differ = differ + faces.len().abs_diff(runs.len());
                (differ > 0).then(|| {
                    format!("{field} does not have the runs of coordIndex ({differ} differ): what it lacks is put in")
                })
            }
            // Entries beyond the last face are common in files, and are ignored.
            Lookup::Face { field, list, .. } => (list.len() < faces.len()).then(|| {
                let (found, count) = (list.len(), faces.len());
                format!("{field} has {found} indices for {count} faces: the first colour is put in")
            }),
            Lookup::Shared(_) | Lookup::Counted(_) => None,
        }
    }
}

/// Completes a face set: copies the lists of the property nodes, and computes missing normals and
/// texture coordinates.
pub(super) fn finish(mesh: &mut Mesh, vertices: Vertices, crease_rad: f64, is_textured: bool) {
    mesh.colors = vertices.colors;
    match vertices.normals.is_empty() {
        true => smooth(mesh, crease_rad),
        false => mesh.normals = vertices.normals,
    }
    match is_textured {
        true if vertices.texcoords.is_empty() => default_texcoords(mesh),
        true => mesh.texcoords = vertices.texcoords,
        false => mesh.corners.iter_mut().for_each(|c| c.texcoord = NONE),
    }
}

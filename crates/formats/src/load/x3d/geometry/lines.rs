//! PointSet, LineSet and IndexedLineSet.

use super::super::graph::{GraphView, NodeId};
use super::vertices::{Vertices, runs};
use super::{Built, ColorUse, LeftOut, Result, Stuff, too_few};
use fbptr_core::scene::{Corner, Mesh, NONE};

/// Returns a mesh with a geometry's vertices, without corners.
fn start(vertices: Vertices) -> Built {
    let stuff = if vertices.normals.is_empty() { Stuff::Bare } else { Stuff::Lit };
    let mesh = Mesh {
        positions: vertices.positions,
        colors: vertices.colors,
        normals: vertices.normals,
        ..Mesh::default()
    };
    Built { mesh, colors: vertices.color_use, stuff, ..Built::default() }
}

/// Returns a corner whose colour and normal have the index of its coordinate.
fn shared(vertices: &Vertices, id: NodeId, i: i64) -> Result<Corner> {
    Ok(Corner {
        position: vertices.position(i, (id, ""))?,
        normal: vertices.normal(i, (id, ""))?,
        texcoord: NONE,
        color: vertices.color(i, (id, ""))?,
    })
}

/// Adds the segments of a line, if there is one of two corners or more.
fn add_line(line: Option<Vec<Corner>>, corners: &mut Vec<Corner>, lines: &mut Vec<[u32; 2]>) {
    let line = line.filter(|line| line.len() > 1).unwrap_or_default();
    let first = corners.len() as u32;
    lines.extend((1..line.len() as u32).map(|k| [first + k - 1, first + k]));
    corners.extend(line);
}

/// Builds a PointSet.
pub(super) fn points(view: &GraphView, id: NodeId) -> Result<Built> {
    let vertices = Vertices::read(view, id);
    let mut left_out = LeftOut::default();
    let all = 0..vertices.positions.len() as i64;
    let corners = all.filter_map(|i| left_out.keep(shared(&vertices, id, i))).collect();
    let mut built = Built { left_out, ..start(vertices) };
    built.mesh.corners = corners;
    built.mesh.points = (0..built.mesh.corners.len() as u32).collect();
    Ok(built)
}

/// Builds a LineSet; `stripCount` is read where there is no `vertexCount`.
pub(super) fn line_set(view: &GraphView, id: NodeId) -> Result<Built> {
    let vertices = Vertices::read(view, id);
    let count = vertices.positions.len() as i64;
    let (mut corners, mut lines, mut first) = (Vec::new(), Vec::new(), 0);
    let mut left_out = LeftOut::default();
    let field = if view.ints(id, "vertexCount").is_empty() { "stripCount" } else { "vertexCount" };
    for &n in view.ints(id, field) {
        if n < 2 {
            let expected = format!("expected counts of 2 or more in {field}");
            left_out.note(too_few(id, field, expected, n.max(0) as usize));
        }
        if first + n > count {
            let expected = format!("expected {field} to count no more than the {count} coordinates");
            left_out.note(too_few(id, field, expected, (first + n) as usize));
        }
        let n = n.clamp(0, count - first);
        let line: Result<Vec<Corner>> = (first..first + n).map(|i| shared(&vertices, id, i)).collect();
        add_line(left_out.keep(line), &mut corners, &mut lines);
        first += n;
    }
    let mut built = Built { left_out, ..start(vertices) };
    built.mesh.corners = corners;
    built.mesh.lines = lines;
    Ok(built)
}

/// Builds an IndexedLineSet.
pub(super) fn indexed_line_set(view: &GraphView, id: NodeId) -> Result<Built> {
    let vertices = Vertices::read(view, id);
    let per_vertex = view.bool(id, "colorPerVertex");
    let color_index = view.ints(id, "colorIndex");
    let color_runs = match per_vertex && !color_index.is_empty() {
        true => runs(color_index),
        false => Vec::new(),
    };
    let normal_index = view.ints(id, "normalIndex");
    let normal_runs = runs(normal_index);
    let (mut corners, mut lines, mut put_in) = (Vec::new(), Vec::new(), 0);
    let mut left_out = LeftOut::default();
    for (line, run) in runs(view.ints(id, "coordIndex")).into_iter().enumerate() {
        let corner = |(k, &i): (usize, &i64)| {
            let missing = |field: &'static str| {
                too_few(
                    id,
                    field,
                    format!("expected {field} to have an index for each part of coordIndex"),
                    k,
                )
            };
            let color = match (vertices.color_use, per_vertex, color_index.is_empty()) {
                (ColorUse::None, ..) => NONE,
                (_, true, true) => vertices.color(i, (id, ""))?,
                (_, true, false) => match color_runs.get(line).and_then(|r| r.get(k)) {
                    Some(at) => vertices.color(*at, (id, "colorIndex"))?,
                    None => {
                        put_in += 1;
                        let own = if (i as u64) < vertices.colors.len() as u64 { i } else { 0 };
                        vertices.color(own, (id, ""))?
                    }
                },
                (_, false, true) => vertices.color(line as i64, (id, ""))?,
                (_, false, false) => match color_index.get(line) {
                    Some(at) => vertices.color(*at, (id, "colorIndex"))?,
                    None => {
                        put_in += 1;
                        vertices.color(0, (id, ""))?
                    }
                },
            };
            let normal = match (vertices.normals.is_empty(), normal_index.is_empty()) {
                (true, _) => NONE,
                (false, true) if view.bool(id, "normalPerVertex") => vertices.normal(i, (id, ""))?,
                (false, true) => vertices.normal(line as i64, (id, ""))?,
                (false, false) => {
                    let at = match view.bool(id, "normalPerVertex") {
                        true => normal_runs.get(line).and_then(|r| r.get(k)),
                        false => normal_index.get(line),
                    };
                    vertices.normal(*at.ok_or_else(|| missing("normalIndex"))?, (id, "normalIndex"))?
                }
            };
            let position = vertices.position(i, (id, "coordIndex"))?;
            Ok(Corner { position, normal, texcoord: NONE, color })
        };
        let made: Result<Vec<Corner>> = run.iter().enumerate().map(corner).collect();
        add_line(left_out.keep(made), &mut corners, &mut lines);
    }
    let mut built = Built { left_out, ..start(vertices) };
    if put_in > 0 {
        built
            .remarks
            .push(format!("colorIndex does not have the runs of coordIndex: {put_in} indices are put in"));
    }
    built.mesh.corners = corners;
    built.mesh.lines = lines;
    Ok(built)
}

//! ElevationGrid: heights over a grid in x and z.

use super::super::graph::{GraphView, NodeId};
use super::faces::finish;
use super::normals::push;
use super::vertices::Vertices;
use super::{Built, MAX_MADE_FACES, Result, too_few};
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};

/// Returns the number of heights along x and z.
fn dimensions(view: &GraphView, id: NodeId) -> (i64, i64) {
    let dimension = |field| view.ints(id, field).first().copied().unwrap_or(0);
    (dimension("xDimension"), dimension("zDimension"))
}

/// Returns the number of heights that an ElevationGrid lacks and that are taken as 0. It is 0 for a
/// grid without heights, which has no face, and for one with more than [`MAX_MADE_FACES`], which is
/// refused: a few bytes of text stand for any number of faces.
pub(in crate::load::x3d) fn lacking(view: &GraphView, id: NodeId) -> u64 {
    if view.name(id) != "ElevationGrid" {
        return 0;
    }
    let (nx, nz) = dimensions(view, id);
    let found = view.reals(id, "height").len() as i64;
    let has_faces = nx >= 2 && nz >= 2 && found > 0;
    match has_faces && (nx - 1).saturating_mul(nz - 1) <= MAX_MADE_FACES as i64 {
        true => (nx * nz - found).max(0) as u64,
        false => 0,
    }
}

/// Builds an ElevationGrid, one quad per cell of the grid.
pub(super) fn build(view: &GraphView, id: NodeId, is_textured: bool) -> Result<Built> {
    let (nx, nz) = dimensions(view, id);
    let height = view.reals(id, "height");
    let mut vertices = Vertices::read(view, id);
    let mut built = Built { colors: vertices.color_use, ..Built::default() };
    if nx < 2 || nz < 2 {
        built.remarks.push(format!("<ElevationGrid> of {nx} x {nz} heights has no face"));
        return Ok(built);
    }
    if height.is_empty() {
        built.remarks.push(format!("<ElevationGrid> was left out: it has none of its {nx} x {nz} heights"));
        return Ok(built);
    }
    let count = nx.saturating_mul(nz);
    let lacking = lacking(view, id);
    if lacking > 0 {
        let remark = format!("<ElevationGrid> lacks {lacking} of its {nx} x {nz} heights: 0 is taken");
        built.remarks.push(remark);
    } else if (height.len() as i64) < count {
        return Err(too_few(id, "height", format!("expected {nx} x {nz} = {count} heights"), height.len()));
    }
    if height.len() as i64 > count {
        let more = height.len() as i64 - count;
        built.remarks.push(format!("<ElevationGrid> has {more} heights more than its {nx} x {nz}"));
    }
    let (dx, dz) = (view.real(id, "xSpacing"), view.real(id, "zSpacing"));
    let grid = || (0..nz).flat_map(move |j| (0..nx).map(move |i| (i as f64, j as f64)));
    let heights = height.iter().copied().chain(std::iter::repeat(0.0));
    vertices.positions = grid().zip(heights).map(|((i, j), y)| DVec3::new(i * dx, y, j * dz)).collect();
    if is_textured && vertices.texcoords.is_empty() {
        let step = DVec2::new((nx - 1) as f64, (nz - 1) as f64);
        vertices.texcoords = grid().map(|(i, j)| DVec2::new(i, j) / step).collect();
    }
    let face_colors = !view.bool(id, "colorPerVertex");
    let face_normals = !view.bool(id, "normalPerVertex");
    let mut mesh = Mesh { positions: vertices.positions.clone(), ..Mesh::default() };
    for (face, (i, j)) in (0..).zip((0..nz - 1).flat_map(|j| (0..nx - 1).map(move |i| (i, j)))) {
        let at = i + j * nx;
        let mut corners = [Corner { position: 0, normal: NONE, texcoord: NONE, color: NONE }; 4];
        for (corner, at) in corners.iter_mut().zip([at, at + nx, at + nx + 1, at + 1]) {
            corner.position = at as u32;
            corner.color = vertices.color(if face_colors { face } else { at }, (id, ""))?;
            corner.normal = vertices.normal(if face_normals { face } else { at }, (id, ""))?;
            corner.texcoord = vertices.texcoord(at, (id, ""))?;
        }
        push(&mut mesh, &mut corners, view.bool(id, "ccw"));
    }
    finish(&mut mesh, vertices, if face_normals { 0.0 } else { view.real(id, "creaseAngle") }, is_textured);
    Ok(Built { mesh, ..built })
}

//! alphaMode MASK with alpha at vertices: what lies below the cutoff is cut away.
//!
//! In: a mesh whose colours have the vertices' alpha, and the least alpha that is seen. Alpha is
//! linear over a triangle, so the parts that are seen end at a straight line: each triangle becomes
//! the polygon of its part, with attributes in between at the new corners, and every colour is opaque.
//! Alpha of a texture is compared by itself (`image`), which is exact where one of the two is 1.
//!
//! Source: glTF 2.0 Specification, section 3.9.5 (Alpha Coverage).

use fbptr_core::scene::{Corner, Mesh, NONE};

/// Cuts away what is below `least`, of points and lines those with an end below it.
pub(super) fn cut(mesh: &mut Mesh, least: f64) {
    let corners = std::mem::take(&mut mesh.corners);
    let above = |mesh: &Mesh, corner: &Corner| mesh.colors[corner.color as usize].w - least;
    if mesh.polygons.is_empty() {
        let is_seen = |i: u32| above(mesh, &corners[i as usize]) >= 0.0;
        let points = mesh.points.iter().copied().filter(|i| is_seen(*i)).collect();
        let lines = mesh.lines.iter().copied().filter(|[a, b]| is_seen(*a) && is_seen(*b)).collect();
        (mesh.points, mesh.lines, mesh.corners) = (points, lines, corners);
    } else {
        let triangles = std::mem::take(&mut mesh.triangles);
        mesh.polygons.clear();
        mesh.triangle_polygon.clear();
        for t in triangles {
            let t = t.map(|i| corners[i as usize]);
            let part = seen_part(mesh, &t, t.map(|corner| above(mesh, &corner)));
            mesh.push_polygon(&part, NONE);
        }
    }
    mesh.colors.iter_mut().for_each(|color| color.w = 1.0);
}

/// Returns the corners of the part of a triangle that is not below the cutoff; `above` is the
/// distance of each corner's alpha from it.
fn seen_part(mesh: &mut Mesh, t: &[Corner; 3], above: [f64; 3]) -> Vec<Corner> {
    let mut part = Vec::with_capacity(4);
    for k in 0..3 {
        let next = (k + 1) % 3;
        if above[k] >= 0.0 {
            part.push(t[k]);
        }
        if (above[k] >= 0.0) != (above[next] >= 0.0) {
            // From the lower index, so that both triangles at an edge get the same bits.
            let (a, b) = if t[k].position < t[next].position { (k, next) } else { (next, k) };
            let at = above[a] / (above[a] - above[b]);
            part.push(between(mesh, t[a], t[b], at));
        }
    }
    part
}

/// Adds a vertex between two others, at a part of the way, and returns its corner.
fn between(mesh: &mut Mesh, a: Corner, b: Corner, at: f64) -> Corner {
    macro_rules! add {
        ($list:ident, $index:ident) => {
            match (mesh.$list.get(a.$index as usize), mesh.$list.get(b.$index as usize)) {
                (Some(from), Some(to)) => {
                    let value = *from + (*to - *from) * at;
                    mesh.$list.push(value);
                    mesh.$list.len() as u32 - 1
                }
                _ => NONE,
            }
        };
    }
    Corner {
        position: add!(positions, position),
        normal: add!(normals, normal),
        texcoord: add!(texcoords, texcoord),
        color: add!(colors, color),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, DVec4};

    #[test]
    fn a_triangle_ends_where_its_alpha_falls_below_the_cutoff() {
        let with = |alphas: [f64; 3]| {
            let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
            let mut mesh = Mesh::from_triangles(positions, &[[0, 1, 2]]);
            mesh.colors = alphas.map(|a| DVec4::new(1.0, 0.0, 0.0, a)).to_vec();
            mesh.corners.iter_mut().for_each(|c| c.color = c.position);
            cut(&mut mesh, 0.5);
            assert!(mesh.colors.iter().all(|c| *c == DVec4::new(1.0, 0.0, 0.0, 1.0)));
            (0..mesh.polygons.len())
                .flat_map(|p| mesh.polygon_corners(p).to_vec())
                .map(|c| mesh.positions[c.position as usize])
                .collect::<Vec<_>>()
        };
        assert_eq!(with([0.5, 1.0, 0.5]), [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!(with([0.4, 0.0, 0.3]), []);
        let half = |a: DVec3, b: DVec3| (a + b) / 2.0;
        assert_eq!(
            with([1.0, 0.0, 0.0]),
            [DVec3::ZERO, half(DVec3::ZERO, DVec3::X), half(DVec3::ZERO, DVec3::Y)]
        );
        let quad = with([0.0, 1.0, 1.0]);
        assert_eq!(quad, [half(DVec3::ZERO, DVec3::X), DVec3::X, DVec3::Y, half(DVec3::ZERO, DVec3::Y)]);
    }
}

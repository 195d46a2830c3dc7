//! Default normals from the faces, and default texture coordinates from the bounding box.

use fbptr_core::math::matrix::unit;
use fbptr_core::math::polygon::newell_normal;
use fbptr_core::math::sort3;
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};

/// Most faces at one position for which a crease angle between 0 and pi is evaluated; above it,
/// each face keeps its own normal. The comparison of all pairs would take too long.
const MAX_MEETING: usize = 256;

/// Computes normals for the corners of every polygon, smooth where faces meet at less than
/// `crease_rad`.
///
/// N = the normalized sum of the unit normals of the faces at the corner's position whose angle
/// with its own face is less than the crease angle, its own included; a sum that vanishes is
/// replaced by the face's own normal. Degenerate faces do not count.
pub(super) fn smooth(mesh: &mut Mesh, crease_rad: f64) {
    let faces: Vec<Option<DVec3>> = mesh
        .polygons
        .iter()
        .map(|p| {
            let corners = &mesh.corners[p.first_corner as usize..(p.first_corner + p.corner_count) as usize];
            let points: Vec<DVec3> = corners.iter().map(|c| mesh.positions[c.position as usize]).collect();
            // Scaled to its own size first: a product of coordinates of 1e200 would overflow, one
            // of 1e-200 would underflow.
            let origin = points[0];
            let size = points.iter().fold(0.0_f64, |m, p| m.max((*p - origin).abs().max_element()));
            let scaled: Vec<DVec3> = points.iter().map(|p| (*p - origin) / size).collect();
            if size > 0.0 && size.is_finite() { unit(newell_normal(&scaled)) } else { None }
        })
        .collect();
    // Files write pi with few digits.
    let is_round = crease_rad >= std::f64::consts::PI - 1e-4;
    let is_flat = crease_rad <= 0.0;
    let mut meeting: Vec<Vec<u32>> = Vec::new();
    let mut sums: Vec<DVec3> = Vec::new();
    if !is_flat {
        meeting.resize(if is_round { 0 } else { mesh.positions.len() }, Vec::new());
        sums.resize(if is_round { mesh.positions.len() } else { 0 }, DVec3::ZERO);
        for (face, polygon) in mesh.polygons.iter().enumerate() {
            let Some(normal) = faces[face] else { continue };
            let first = polygon.first_corner as usize;
            let corners = &mesh.corners[first..first + polygon.corner_count as usize];
            for (k, corner) in corners.iter().enumerate() {
                // A face that visits a position twice counts there once.
                if corners[..k].iter().any(|c| c.position == corner.position) {
                    continue;
                }
                match is_round {
                    true => sums[corner.position as usize] += normal,
                    false => meeting[corner.position as usize].push(face as u32),
                }
            }
        }
    }
    let cos = libm::cos(crease_rad);
    for (face, polygon) in mesh.polygons.iter().enumerate() {
        let Some(own) = faces[face] else { continue };
        let first = polygon.first_corner as usize;
        let face_index = mesh.normals.len() as u32;
        mesh.normals.push(own);
        for corner in &mut mesh.corners[first..first + polygon.corner_count as usize] {
            let at = corner.position as usize;
            let sum = match () {
                _ if is_flat => own,
                _ if is_round => sums[at],
                _ if meeting[at].len() > MAX_MEETING => own,
                _ => meeting[at]
                    .iter()
                    .filter(|g| **g as usize == face || faces[**g as usize].is_some_and(|n| n.dot(own) > cos))
                    .fold(DVec3::ZERO, |sum, g| sum + faces[*g as usize].unwrap_or(DVec3::ZERO)),
            };
            // The remainder of cancelled unit vectors is rounding error, not a direction.
            let normal = if sum.length() > 1e-9 { unit(sum).unwrap_or(own) } else { own };
            corner.normal = if normal == own {
                face_index
            } else {
                mesh.normals.push(normal);
                mesh.normals.len() as u32 - 1
            };
        }
    }
}

/// Gives corners without a texture coordinate the standard's default: the larger two sides of the
/// bounding box carry S and T, S from 0 to 1 along the largest, T along the next from 0 to their
/// ratio. Ties: x before y before z.
pub(super) fn default_texcoords(mesh: &mut Mesh) {
    let used = mesh.corners.iter().map(|c| mesh.positions[c.position as usize]);
    let Some((low, high)) =
        used.fold(None, |b: Option<(DVec3, DVec3)>, p| Some(b.map_or((p, p), |(l, h)| (l.min(p), h.max(p)))))
    else {
        return;
    };
    let size = high - low;
    let mut axes = [0, 1, 2];
    sort3(&mut axes, |a, b| size[*b].total_cmp(&size[*a]).is_lt());
    let [s, t, _] = axes;
    let first = mesh.texcoords.len() as u32;
    let scale = if size[s] > 0.0 { size[s] } else { 1.0 };
    let at = |p: &DVec3| DVec2::new((p[s] - low[s]) / scale, (p[t] - low[t]) / scale);
    mesh.texcoords.extend(mesh.positions.iter().map(at));
    for corner in mesh.corners.iter_mut().filter(|c| c.texcoord == NONE) {
        corner.texcoord = first + corner.position;
    }
}

/// Adds a polygon, reversed if the file winds its faces clockwise.
pub(super) fn push(mesh: &mut Mesh, corners: &mut [Corner], is_ccw: bool) {
    if !is_ccw {
        corners.reverse();
    }
    mesh.push_polygon(corners, NONE);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two quads that meet at a right angle along the y axis: one in z = 0, one in x = 0.
    fn book() -> Mesh {
        let mut mesh = Mesh {
            positions: [[0, 0, 0], [0, 1, 0], [1, 0, 0], [1, 1, 0], [0, 0, 1], [0, 1, 1]]
                .map(|p| DVec3::from(p.map(f64::from)))
                .into(),
            ..Mesh::default()
        };
        for face in [[0, 2, 3, 1], [0, 1, 5, 4]] {
            let corners = face.map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE });
            mesh.push_polygon(&corners, NONE);
        }
        mesh
    }

    #[test]
    fn the_crease_angle_parts_smooth_from_sharp() {
        let normal = |crease: f64| {
            let mut mesh = book();
            smooth(&mut mesh, crease);
            mesh.normals[mesh.corners[0].normal as usize]
        };
        assert_eq!(normal(0.0), DVec3::Z);
        assert_eq!(normal(1.5), DVec3::Z);
        let half = (DVec3::Z + DVec3::X) / 2f64.sqrt();
        for crease in [1.6, 3.0, std::f64::consts::PI, 10.0] {
            assert!((normal(crease) - half).length() < 1e-15, "{crease}");
        }
    }

    #[test]
    fn opposite_faces_keep_their_own_normals() {
        let mut mesh = Mesh::from_triangles(vec![DVec3::ZERO, DVec3::X, DVec3::Y], &[[0, 1, 2], [0, 2, 1]]);
        smooth(&mut mesh, std::f64::consts::PI);
        assert_eq!(mesh.normals[mesh.corners[0].normal as usize], DVec3::Z);
        assert_eq!(mesh.normals[mesh.corners[3].normal as usize], DVec3::NEG_Z);
    }

    #[test]
    fn the_default_texture_runs_along_the_two_longest_sides() {
        let mut mesh = Mesh::from_triangles(
            vec![DVec3::ZERO, DVec3::new(0.0, 4.0, 0.0), DVec3::new(1.0, 0.0, 2.0)],
            &[[0, 1, 2]],
        );
        default_texcoords(&mut mesh);
        assert_eq!(mesh.texcoords, [DVec2::ZERO, DVec2::new(1.0, 0.0), DVec2::new(0.0, 0.5)]);
    }
}

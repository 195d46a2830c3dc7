//! Extrusion: a cross-section swept along a spine. Source: ISO/IEC 19775-1 clause 13.3.5.
//!
//! Each spine point has a plane with axes X, Y, Z: Y along the spine, Z the normal of its bend, X =
//! Y x Z. The cross-section's points (x, z) are scaled, rotated by that point's orientation, and
//! placed in the plane.

use super::super::graph::{GraphView, NodeId};
use super::normals::{push, smooth};
use super::vertices::{vec2s, vec3s};
use super::{Built, MAX_MADE_FACES, Result, too_big};
use fbptr_core::math::matrix::{rotate, unit};
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DMat3, DMat4, DVec2, DVec3};

/// Builds an Extrusion: a quad for each segment of the cross-section and of the spine, and the
/// caps.
pub(super) fn build(view: &GraphView, id: NodeId, is_textured: bool) -> Result<Built> {
    let spine = vec3s(view.reals(id, "spine"));
    let section = vec2s(view.reals(id, "crossSection"));
    let (n, m) = (spine.len(), section.len());
    let mut built = Built::default();
    if n < 2 || m < 2 {
        built.remarks.push(format!("<Extrusion> of {m} points along {n} has no face"));
        return Ok(built);
    }
    let faces = (n as u64 - 1) * (m as u64 - 1) + 2;
    if faces > MAX_MADE_FACES {
        return Err(too_big(id, "spine", faces));
    }
    let is_ccw = view.bool(id, "ccw");
    // A closed ring or tube has its ends at shared positions, so that it can be smooth there.
    let is_ring = section[0] == section[m - 1];
    let rings = rings(view, id, &spine, &section);
    let is_tube = spine[0] == spine[n - 1] && rings[0] == rings[n - 1];
    let (ring, tube) = (m - usize::from(is_ring), n - usize::from(is_tube));
    let mut mesh = Mesh {
        positions: rings[..tube].iter().flat_map(|r| &r[..ring]).copied().collect(),
        ..Mesh::default()
    };
    let position = |i: usize, j: usize| ((i % tube) * ring + j % ring) as u32;
    for i in 0..n - 1 {
        for j in 0..m - 1 {
            let mut corners = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| Corner {
                position: position(i, j),
                normal: NONE,
                texcoord: if is_textured { (i * m + j) as u32 } else { NONE },
                color: NONE,
            });
            push(&mut mesh, &mut corners, is_ccw);
        }
    }
    smooth(&mut mesh, view.real(id, "creaseAngle"));
    if is_textured {
        let step = DVec2::new((m - 1) as f64, (n - 1) as f64);
        mesh.texcoords =
            (0..n).flat_map(|i| (0..m).map(move |j| DVec2::new(j as f64, i as f64) / step)).collect();
    }
    for (field, i, is_end) in [("beginCap", 0, false), ("endCap", n - 1, true)] {
        if view.bool(id, field) && ring >= 3 {
            let cap = Cap { first: position(i, 0), ring, section: &section, is_textured };
            cap.add(&mut mesh, is_end == is_ccw);
        }
    }
    Ok(Built { mesh, ..built })
}

/// One flat end of the extrusion.
struct Cap<'a> {
    /// Index of its first position.
    first: u32,
    /// Number of its positions.
    ring: usize,
    section: &'a [DVec2],
    is_textured: bool,
}

impl Cap<'_> {
    fn add(&self, mesh: &mut Mesh, is_forward: bool) {
        let first_texcoord = mesh.texcoords.len() as u32;
        if self.is_textured {
            // The larger side of the cross-section's bounding box spans the texture.
            let section = &self.section[..self.ring];
            let (low, high) =
                section.iter().fold((section[0], section[0]), |(l, h), p| (l.min(*p), h.max(*p)));
            let size = (high - low).max_element();
            let scale = if size > 0.0 { size } else { 1.0 };
            mesh.texcoords.extend(section.iter().map(|p| (*p - low) / scale));
        }
        let mut corners: Vec<Corner> = (0..self.ring as u32)
            .map(|j| Corner {
                position: self.first + j,
                normal: NONE,
                texcoord: if self.is_textured { first_texcoord + j } else { NONE },
                color: NONE,
            })
            .collect();
        let mut own = Mesh { positions: mesh.positions.clone(), ..Mesh::default() };
        push(&mut own, &mut corners, is_forward);
        smooth(&mut own, 0.0);
        if let Some(normal) = own.normals.first() {
            mesh.normals.push(*normal);
            let index = mesh.normals.len() as u32 - 1;
            corners.iter_mut().for_each(|c| c.normal = index);
        }
        mesh.push_polygon(&corners, NONE);
    }
}

/// Returns the points of the cross-section at each spine point.
fn rings(view: &GraphView, id: NodeId, spine: &[DVec3], section: &[DVec2]) -> Vec<Vec<DVec3>> {
    let scales = vec2s(view.reals(id, "scale"));
    let turns: Vec<DMat3> = view
        .reals(id, "orientation")
        .as_chunks::<4>()
        .0
        .iter()
        .map(|r| DMat3::from_mat4(rotate(DVec3::new(r[0], r[1], r[2]), r[3]).unwrap_or(DMat4::IDENTITY)))
        .collect();
    // A list that is too short is continued with its last value.
    let scale = |i: usize| scales.get(i).or(scales.last()).copied().unwrap_or(DVec2::ONE);
    let turn = |i: usize| turns.get(i).or(turns.last()).copied().unwrap_or(DMat3::IDENTITY);
    let planes = planes(spine);
    (0..spine.len())
        .map(|i| {
            let place = |p: &DVec2| {
                let flat = *p * scale(i);
                spine[i] + planes[i] * (turn(i) * DVec3::new(flat.x, 0.0, flat.y))
            };
            section.iter().map(place).collect()
        })
        .collect()
}

/// Returns the axes X, Y, Z (columns) of the plane at each spine point.
fn planes(spine: &[DVec3]) -> Vec<DMat3> {
    let n = spine.len();
    let is_closed = spine[0] == spine[n - 1];
    let along = |i: usize| -> Option<DVec3> {
        match i {
            _ if is_closed && (i == 0 || i == n - 1) => unit(spine[1] - spine[n - 2]),
            0 => unit(spine[1] - spine[0]),
            _ if i == n - 1 => unit(spine[n - 1] - spine[n - 2]),
            _ => unit(spine[i + 1] - spine[i - 1]),
        }
    };
    let across = |i: usize| -> Option<DVec3> {
        let (before, after) = match i {
            _ if is_closed && (i == 0 || i == n - 1) => (spine[n - 2], spine[1]),
            0 => return None,
            _ if i == n - 1 => return None,
            _ => (spine[i - 1], spine[i + 1]),
        };
        let (a, b) = (unit(after - spine[i])?, unit(before - spine[i])?);
        // The bend of directions this close to one line is only rounding error.
        let bend = a.cross(b);
        if bend.length() > 1e-9 { unit(bend) } else { None }
    };
    let ys = filled((0..n).map(along).collect());
    let mut zs: Vec<Option<DVec3>> = (0..n).map(across).collect();
    let Some(first_y) = ys[0] else { return vec![DMat3::IDENTITY; n] };
    if zs.iter().all(Option::is_none) {
        // A straight spine: the rotation that takes the y axis to it also takes the z axis.
        return ys.iter().map(|y| turned_to(y.unwrap_or(first_y))).collect();
    }
    zs = filled(zs);
    let mut planes: Vec<DMat3> = Vec::with_capacity(n);
    let mut last_z: Option<DVec3> = None;
    for (y, z) in ys.iter().zip(zs) {
        let y = y.unwrap_or(first_y);
        let mut z = z.unwrap_or(DVec3::Z);
        if last_z.is_some_and(|last| last.dot(z) < 0.0) {
            z = -z;
        }
        last_z = Some(z);
        let plane = match unit(y.cross(z)) {
            Some(x) => DMat3::from_cols(x, y, x.cross(y)),
            None => turned_to(y),
        };
        planes.push(plane);
    }
    planes
}

/// Fills gaps with the last value before them, those at the start with the first one after.
fn filled(values: Vec<Option<DVec3>>) -> Vec<Option<DVec3>> {
    let mut last = values.iter().copied().flatten().next();
    values
        .into_iter()
        .map(|v| {
            last = v.or(last);
            last
        })
        .collect()
}

/// Returns the rotation about y x to that takes the y axis to `to`.
fn turned_to(to: DVec3) -> DMat3 {
    let axis = DVec3::Y.cross(to);
    let angle = libm::atan2(axis.length(), DVec3::Y.dot(to));
    match rotate(axis, angle) {
        Some(m) => DMat3::from_mat4(m),
        // Parallel to y, or opposite.
        None if to.y < 0.0 => DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
        None => DMat3::IDENTITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_spine_along_x_turns_the_plane_about_z() {
        let planes = planes(&[DVec3::ZERO, DVec3::X, DVec3::X * 3.0]);
        for plane in planes {
            assert!((plane.y_axis - DVec3::X).length() < 1e-15);
            assert!((plane.z_axis - DVec3::Z).length() < 1e-15);
            assert!((plane.x_axis - DVec3::NEG_Y).length() < 1e-15);
        }
    }

    #[test]
    fn a_bend_gives_its_plane_and_the_ends_take_it_over() {
        // From the origin along x, then along y: the bend's normal is (y dir) x (-x dir) = z.
        let planes = planes(&[DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)]);
        assert_eq!(planes[0].y_axis, DVec3::X);
        assert_eq!(planes[2].y_axis, DVec3::Y);
        for plane in &planes {
            assert!((plane.z_axis - DVec3::Z).length() < 1e-15, "{plane:?}");
        }
        let half = DVec3::new(1.0, 1.0, 0.0) / 2f64.sqrt();
        assert!((planes[1].y_axis - half).length() < 1e-15);
    }

    #[test]
    fn an_s_bend_does_not_flip_the_plane() {
        let spine = [[0., 0.], [1., 0.], [1., 1.], [2., 1.]].map(|[x, y]: [f64; 2]| DVec3::new(x, y, 0.0));
        let planes = planes(&spine);
        assert!(planes.windows(2).all(|w| w[0].z_axis.dot(w[1].z_axis) > 0.0));
    }

    #[test]
    fn points_on_one_spot_keep_the_axes() {
        assert_eq!(planes(&[DVec3::ONE, DVec3::ONE]), [DMat3::IDENTITY; 2]);
        assert_eq!(turned_to(DVec3::NEG_Y).y_axis, DVec3::NEG_Y);
    }
}

//! Combination of `tobj`'s arrays with the properties of the checked elements to a [`Mesh`].

use super::lexer::{Element, ElementKind, FirstUse};
use super::through_tobj::RawMesh;
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3, DVec4};

/// Fills `mesh` with the used vertices and the elements, both in the file's order.
///
/// `material_of_use` is the material index of each `usemtl` name. An error describes how `tobj`'s
/// result differs from what the check expected.
pub(super) fn assemble(
    mesh: &mut Mesh,
    raw: RawMesh,
    elements: &[Element],
    order: &[FirstUse; 3],
    material_of_use: &[u32],
) -> Result<(), String> {
    let ranks: [Vec<u32>; 3] = std::array::from_fn(|list| order[list].ranks());
    let counts = [raw.positions.len() / 3, raw.texcoords.len() / 2, raw.normals.len() / 3];
    for (list, what) in ["positions", "texture coordinates", "normals"].into_iter().enumerate() {
        if counts[list] != ranks[list].len() {
            return Err(format!("{} {what} are used, and {} came back", ranks[list].len(), counts[list]));
        }
    }
    mesh.positions = in_file_order(raw.positions.as_chunks::<3>().0, &ranks[0], |p| DVec3::from_array(*p));
    mesh.colors =
        in_file_order(raw.colors.as_chunks::<3>().0, &ranks[0], |c| DVec4::new(c[0], c[1], c[2], 1.0));
    mesh.texcoords = in_file_order(raw.texcoords.as_chunks::<2>().0, &ranks[1], |t| DVec2::from_array(*t));
    mesh.normals = in_file_order(raw.normals.as_chunks::<3>().0, &ranks[2], |n| DVec3::from_array(*n));
    let has_colors = !mesh.colors.is_empty();

    let at = |indices: &[u32], list: usize, corner: usize, has: bool| -> Result<u32, String> {
        if !has {
            return Ok(NONE);
        }
        let rank = indices.get(corner).and_then(|i| ranks[list].get(*i as usize));
        rank.copied().ok_or_else(|| format!("corner {corner} came back without its index"))
    };
    mesh.corners.reserve_exact(raw.indices.len());
    mesh.polygons.reserve(elements.len());
    mesh.triangles.reserve(elements.len());
    mesh.triangle_polygon.reserve(elements.len());
    let mut first = 0;
    let mut corners: Vec<Corner> = Vec::new();
    for (i, element) in elements.iter().enumerate() {
        let arity =
            if raw.arities.is_empty() { 3 } else { raw.arities.get(i).copied().unwrap_or(0) } as usize;
        corners.clear();
        for corner in first..first + arity {
            let position = at(&raw.indices, 0, corner, true)?;
            corners.push(Corner {
                position,
                normal: at(&raw.normal_indices, 2, corner, element.has_normals)?,
                texcoord: at(&raw.texcoord_indices, 1, corner, element.has_texcoords)?,
                color: if has_colors { position } else { NONE },
            });
        }
        first += arity;
        let material = material_of_use.get(element.material_use as usize).copied().unwrap_or(NONE);
        let first_corner = mesh.corners.len() as u32;
        let numbers = first_corner..first_corner + arity as u32;
        match element.kind {
            ElementKind::Face => mesh.push_polygon(&corners, material),
            ElementKind::Line => {
                mesh.corners.extend_from_slice(&corners);
                mesh.lines.extend(numbers.skip(1).map(|c| [c - 1, c]));
                mesh.line_materials.resize(mesh.lines.len(), material);
            }
            ElementKind::Points => {
                mesh.corners.extend_from_slice(&corners);
                mesh.points.extend(numbers);
                mesh.point_materials.resize(mesh.points.len(), material);
            }
        }
    }
    for materials in [&mut mesh.line_materials, &mut mesh.point_materials] {
        if materials.iter().all(|m| *m == NONE) {
            materials.clear();
        }
    }
    match first == raw.indices.len() {
        true => Ok(()),
        false => Err(format!("{first} corners were handed out, and {} came back", raw.indices.len())),
    }
}

/// Returns `values`, which are in order of first use, sorted by their ranks.
fn in_file_order<T, U: Default + Clone>(values: &[T], ranks: &[u32], make: impl Fn(&T) -> U) -> Vec<U> {
    let mut sorted = vec![U::default(); values.len()];
    for (value, rank) in values.iter().zip(ranks) {
        sorted[*rank as usize] = make(value);
    }
    sorted
}

//! Prisms: a shape of R^N extruded along a new axis, and shapes from meshes of R^3.

use super::{Shape, ShapeError};
use crate::scene::Mesh;

/// Returns the sides of the prism over `shape`, extruded from `low` to `high` along a new last
/// axis. The ends stay open.
///
/// A simplex v_0 < .. < v_(n-1), ordered by point index, gives n simplices with v_0 .. v_i at one
/// end and v_i .. v_(n-1) at the other, so neighbours split their common side identically.
pub fn extrude(shape: &Shape, low: f64, high: f64) -> Shape {
    let count = shape.points.len() as u32;
    let end = |h: f64| shape.points.iter().map(move |p| [p.as_slice(), &[h]].concat());
    let mut out = Shape {
        dim: shape.dim + 1,
        points: end(low).chain(end(high)).collect(),
        simplices: Vec::new(),
        cells: Vec::new(),
    };
    for (simplex, &cell) in shape.simplices.iter().zip(&shape.cells) {
        let mut sorted = simplex.clone();
        // Insertion sort, counting swaps: their parity preserves the winding.
        let mut is_odd = false;
        for i in 1..sorted.len() {
            for j in (1..=i).rev() {
                if sorted[j - 1] > sorted[j] {
                    sorted.swap(j - 1, j);
                    is_odd = !is_odd;
                }
            }
        }
        let last = sorted.len() - 1;
        for i in 0..=last {
            let mut part: Vec<u32> = sorted[..=i].to_vec();
            part.extend(sorted[i..].iter().map(|p| p + count));
            if is_odd != ((last - i) % 2 == 1) {
                part.swap(0, 1);
            }
            out.simplices.push(part);
            out.cells.push(cell);
        }
    }
    out
}

/// Returns the triangles of a mesh in the eye's axes: 0 is the mesh's -z, 1 its -x, 2 its y. A cell
/// is a polygon.
pub fn from_mesh(mesh: &Mesh) -> Result<Shape, ShapeError> {
    if mesh.triangles.is_empty() {
        return Err(ShapeError::Empty);
    }
    let position = |&corner: &u32| mesh.corners[corner as usize].position;
    Ok(Shape {
        dim: 3,
        points: mesh.positions.iter().map(|p| vec![-p.z, -p.x, p.y]).collect(),
        simplices: mesh.triangles.iter().map(|t| t.iter().map(position).collect()).collect(),
        cells: mesh.triangle_polygon.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::shapes::{cell24, cross_polytope, cube, simplex};
    use crate::math::nvec::{MAX_DIM, dot, wedge};

    #[test]
    fn sides_of_a_prism_have_the_winding_of_closed_shapes() {
        let bases =
            [cube(2), cube(3), simplex(2), simplex(4), cross_polytope(3), cross_polytope(5), cell24(4)];
        for base in bases.map(Result::unwrap) {
            let prism = extrude(&base, -1.0, 2.0);
            assert_eq!(prism.simplices.len(), base.simplices.len() * base.dim);
            for simplex in &prism.simplices {
                // Relative to the middle of the prism.
                let row = |&i: &u32| -> [f64; MAX_DIM] {
                    let mut row = [0.0; MAX_DIM];
                    row[..prism.dim].copy_from_slice(&prism.points[i as usize]);
                    row[base.dim] -= 0.5;
                    row
                };
                let rows: Vec<_> = simplex.iter().map(row).collect();
                assert!(dot(&wedge(&rows[1..], rows.len()), &rows[0]) > 0.0, "{}: {simplex:?}", base.dim);
            }
        }
    }
}

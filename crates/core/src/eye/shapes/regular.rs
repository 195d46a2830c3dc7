//! The regular polytopes: simplex, cube and cross-polytope of any N, and the 24-cell of R^4.
//! Centred on 0.

use super::{Shape, ShapeError};
use crate::eye::scene::MAX_DIM;
use crate::math::nvec::{dot, wedge};

/// Returns an error for dimensions that the eye does not support.
fn check(shape: &'static str, dim: usize) -> Result<(), ShapeError> {
    if (2..=MAX_DIM).contains(&dim) {
        Ok(())
    } else {
        Err(ShapeError::Dimension { shape, expected: "2 to 8", found: dim })
    }
}

/// Swaps two points of a simplex if its determinant is negative.
fn wind(points: &[Vec<f64>], simplex: &mut [u32]) {
    let rows: Vec<[f64; MAX_DIM]> = simplex
        .iter()
        .map(|&i| std::array::from_fn(|k| points[i as usize].get(k).copied().unwrap_or(0.0)))
        .collect();
    if dot(&wedge(&rows[1..], rows.len()), &rows[0]) < 0.0 {
        simplex.swap(0, 1);
    }
}

/// Creates a shape from its points and its cells' simplices.
fn shape(dim: usize, points: Vec<Vec<f64>>, cells: Vec<Vec<Vec<u32>>>) -> Shape {
    let mut out = Shape { dim, points, simplices: Vec::new(), cells: Vec::new() };
    for (cell, simplices) in cells.into_iter().enumerate() {
        for mut simplex in simplices {
            wind(&out.points, &mut simplex);
            out.simplices.push(simplex);
            out.cells.push(cell as u32);
        }
    }
    out
}

/// Creates the regular simplex: N+1 points at distance 1 from 0, N+1 cells. Cell i is the one
/// without point i.
pub fn simplex(dim: usize) -> Result<Shape, ShapeError> {
    check("simplex", dim)?;
    let n = dim as f64;
    // The unit axes and a point on the diagonal at the same distance from all of them: (1 -
    // sqrt(N+1)) / N each.
    let last = (1.0 - (n + 1.0).sqrt()) / n;
    let centre = (1.0 + last) / (n + 1.0);
    let mut points: Vec<Vec<f64>> =
        (0..dim).map(|i| (0..dim).map(|k| f64::from(u8::from(i == k)) - centre).collect()).collect();
    points.push(vec![last - centre; dim]);
    for p in &mut points {
        let norm = p.iter().map(|x| x * x).sum::<f64>().sqrt();
        p.iter_mut().for_each(|x| *x /= norm);
    }
    let cell = |i: u32| vec![(0..=dim as u32).filter(|&k| k != i).collect()];
    Ok(shape(dim, points, (0..=dim as u32).map(cell).collect()))
}

/// Creates the cube with corners at +-1 (N = 4: the tesseract): 2N cells of (N-1)! simplices.
///
/// Cell 2a is the one at x_a = -1, cell 2a+1 at x_a = 1. A cell is split along the monotone paths
/// from its lowest corner to its highest (Freudenthal, 1942), so neighbours split their common face
/// identically.
pub fn cube(dim: usize) -> Result<Shape, ShapeError> {
    check("cube", dim)?;
    let corner = |i: usize| (0..dim).map(|k| if i >> k & 1 == 1 { 1.0 } else { -1.0 }).collect();
    let points: Vec<Vec<f64>> = (0..1 << dim).map(corner).collect();
    let mut cells = Vec::new();
    for axis in 0..dim {
        let ways = permutations(&(0..dim).filter(|&k| k != axis).collect::<Vec<_>>());
        for side in [0u32, 1 << axis] {
            let along = |way: &Vec<usize>| {
                let mut at = side;
                let mut simplex = vec![at];
                for &k in way {
                    at |= 1 << k;
                    simplex.push(at);
                }
                simplex
            };
            cells.push(ways.iter().map(along).collect());
        }
    }
    Ok(shape(dim, points, cells))
}

/// Returns all permutations of `items`.
fn permutations(items: &[usize]) -> Vec<Vec<usize>> {
    if items.is_empty() {
        return vec![vec![]];
    }
    let mut all = Vec::new();
    for (i, &first) in items.iter().enumerate() {
        let rest = [&items[..i], &items[i + 1..]].concat();
        all.extend(permutations(&rest).into_iter().map(|tail| [vec![first], tail].concat()));
    }
    all
}

/// Creates the cross-polytope with points at +-1 on each axis (N = 3: the octahedron): 2^N cells.
pub fn cross_polytope(dim: usize) -> Result<Shape, ShapeError> {
    check("cross-polytope", dim)?;
    let point = |i: usize| (0..dim).map(|k| if k == i / 2 { [1.0, -1.0][i % 2] } else { 0.0 }).collect();
    let cell = |signs: u32| vec![(0..dim as u32).map(|k| 2 * k + (signs >> k & 1)).collect()];
    Ok(shape(dim, (0..2 * dim).map(point).collect(), (0..1 << dim).map(cell).collect()))
}

/// Creates the 24-cell with points at the permutations of (+-1, +-1, 0, 0): 24 octahedra of 4
/// tetrahedra. Only in R^4.
pub fn cell24(dim: usize) -> Result<Shape, ShapeError> {
    if dim != 4 {
        return Err(ShapeError::Dimension { shape: "24-cell", expected: "4", found: dim });
    }
    let mut points = Vec::new();
    for (a, b) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
        for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            let mut p = vec![0.0; 4];
            (p[a], p[b]) = (s, t);
            points.push(p);
        }
    }
    // The dual 24-cell's points are the cells' directions: the axes and the corners of a cube. A
    // cell's points have product 1 with its direction.
    let axes = (0..8).map(|i| (0..4).map(|k| if k == i / 2 { [1.0, -1.0][i % 2] } else { 0.0 }).collect());
    let corners = (0..16).map(|i| (0..4).map(|k| if i >> k & 1 == 1 { 0.5 } else { -0.5 }).collect());
    let directions: Vec<Vec<f64>> = axes.chain(corners).collect();
    let product = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(x, y)| x * y).sum::<f64>();
    let cell = |direction: &Vec<f64>| {
        let mut of_cell: Vec<u32> =
            (0..24).filter(|&i| product(&points[i as usize], direction) == 1.0).collect();
        // Around the diagonal of the first point and its opposite: adjacent points of the equator
        // are at right angles.
        let centre: Vec<f64> = direction.iter().map(|x| x / product(direction, direction)).collect();
        let from_centre =
            |i: u32| -> Vec<f64> { points[i as usize].iter().zip(&centre).map(|(x, c)| x - c).collect() };
        let top = of_cell.remove(0);
        let bottom = of_cell.iter().position(|&i| product(&from_centre(i), &from_centre(top)) < 0.0);
        let bottom = of_cell.remove(bottom.unwrap_or_default());
        let mut tetrahedra = Vec::new();
        for (k, &i) in of_cell.iter().enumerate() {
            for &j in &of_cell[k + 1..] {
                if product(&from_centre(i), &from_centre(j)) == 0.0 {
                    tetrahedra.push(vec![top, bottom, i, j]);
                }
            }
        }
        tetrahedra
    };
    let cells = directions.iter().map(cell).collect();
    Ok(shape(4, points, cells))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

    /// Asserts that each ridge of a closed boundary is shared by two simplices, with opposite
    /// winding.
    fn assert_closed(shape: &Shape) {
        let mut ridges: HashMap<Vec<u32>, i32> = HashMap::new();
        let mut count: HashMap<Vec<u32>, u32> = HashMap::new();
        for simplex in &shape.simplices {
            assert_eq!(simplex.len(), shape.dim);
            for left_out in 0..simplex.len() {
                let mut ridge: Vec<u32> = simplex.clone();
                ridge.remove(left_out);
                let mut sign = if left_out % 2 == 0 { 1 } else { -1 };
                for i in 0..ridge.len() {
                    for j in i + 1..ridge.len() {
                        if ridge[i] > ridge[j] {
                            sign = -sign;
                        }
                    }
                }
                ridge.sort_unstable();
                *ridges.entry(ridge.clone()).or_default() += sign;
                *count.entry(ridge).or_default() += 1;
            }
        }
        assert!(ridges.values().all(|&sum| sum == 0), "wound alike");
        assert!(count.values().all(|&n| n == 2), "two simplices a ridge");
    }

    /// Returns the enclosed volume: sum of determinants over N!.
    fn volume(shape: &Shape) -> f64 {
        let det = |s: &Vec<u32>| {
            let rows: Vec<[f64; MAX_DIM]> = s
                .iter()
                .map(|&i| std::array::from_fn(|k| shape.points[i as usize].get(k).copied().unwrap_or(0.0)))
                .collect();
            dot(&wedge(&rows[1..], rows.len()), &rows[0])
        };
        shape.simplices.iter().map(det).sum::<f64>() / (1..=shape.dim).map(|i| i as f64).product::<f64>()
    }

    #[test]
    fn regular_polytopes_are_closed_and_have_their_volume() {
        let factorial = |n: usize| (1..=n).map(|i| i as f64).product::<f64>();
        for dim in 2..=6 {
            let cube = cube(dim).unwrap();
            assert_closed(&cube);
            assert_eq!(
                (cube.simplices.len() as f64, volume(&cube)),
                (2.0 * dim as f64 * factorial(dim - 1), 2f64.powi(dim as i32))
            );
            let cross = cross_polytope(dim).unwrap();
            assert_closed(&cross);
            assert_eq!((cross.simplices.len(), cross.cells.last()), (1 << dim, Some(&((1 << dim) - 1))));
            assert!((volume(&cross) - 2f64.powi(dim as i32) / factorial(dim)).abs() < 1e-12);
            let simplex = simplex(dim).unwrap();
            assert_closed(&simplex);
            // Edge a of the simplex of circumradius 1: a^2 = 2 (N+1) / N; volume a^N sqrt(N+1) /
            // (N! 2^(N/2)).
            let (n, edge) = (dim as f64, (2.0 * (dim as f64 + 1.0) / dim as f64).sqrt());
            let want = edge.powi(dim as i32) * (n + 1.0).sqrt() / (factorial(dim) * 2f64.powf(n / 2.0));
            assert!((volume(&simplex) - want).abs() < 1e-12, "{dim}");
            // The last point is that on the negative half of the diagonal, opposite the face of the
            // unit axes.
            let last = simplex.points.last().unwrap();
            assert!(last.iter().all(|x| (x + 1.0 / n.sqrt()).abs() < 1e-12), "{dim}: {last:?}");
        }
        let cell24 = cell24(4).unwrap();
        assert_closed(&cell24);
        assert_eq!((cell24.points.len(), cell24.simplices.len()), (24, 96));
        // Edge sqrt 2: volume 2 a^4.
        assert!((volume(&cell24) - 8.0).abs() < 1e-12);
        assert!(super::cell24(3).is_err() && super::cube(1).is_err() && super::simplex(9).is_err());
    }
}

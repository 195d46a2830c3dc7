//! The edges of a polytope, found in a boundary that is split into simplices.
//!
//! In: facets, (N-1)-simplices of R^N. Out: the distinct points, the pairs of them that are edges of
//! the polytope, and the simplices' triangles. A side of a simplex may also be a diagonal, within a
//! cell or a face. It is an edge where the hyperplanes of the simplices around it meet in a line
//! alone: where their normals span N-1 dimensions.

use fbptr_core::eye::EyeScene;
use std::collections::{BTreeMap, BTreeSet};

/// Most facets of a scene that is shown as a wireframe.
const MAX_FACETS: usize = 6000;

/// Points, edges and triangles of a scene.
pub(super) struct Wireframe {
    /// Distinct points of N coordinates.
    pub points: Vec<Vec<f64>>,
    /// Edges, as indices of two points.
    pub edges: Vec<[usize; 2]>,
    /// Triangles of all simplices, as indices of three points.
    pub triangles: Vec<[usize; 3]>,
}

impl Wireframe {
    /// Returns the wireframe of a scene; `None` below four dimensions, for a scene without facets,
    /// and for one of too many.
    pub fn of(scene: &EyeScene) -> Option<Wireframe> {
        if scene.dim < 4 || scene.facets.is_empty() || scene.facets.len() > MAX_FACETS {
            return None;
        }
        let mut index = BTreeMap::new();
        let mut points = Vec::new();
        let mut simplices = Vec::new();
        for facet in &scene.facets {
            let corner = |p: &Vec<f64>| {
                // Zeros of both signs are one.
                let key: Vec<u64> = p.iter().map(|x| (x + 0.0).to_bits()).collect();
                *index.entry(key).or_insert_with(|| {
                    points.push(p.clone());
                    points.len() - 1
                })
            };
            simplices.push(facet.v.iter().map(corner).collect::<Vec<usize>>());
        }
        let mut normals_of: BTreeMap<[usize; 2], Vec<usize>> = BTreeMap::new();
        let mut triangles = BTreeSet::new();
        let mut normals = Vec::with_capacity(simplices.len());
        for (s, simplex) in simplices.iter().enumerate() {
            normals.push(normal(&simplex.iter().map(|&i| points[i].as_slice()).collect::<Vec<_>>()));
            let mut corners = simplex.clone();
            corners.sort_unstable();
            corners.dedup();
            for (i, &a) in corners.iter().enumerate() {
                for (j, &b) in corners.iter().enumerate().skip(i + 1) {
                    normals_of.entry([a, b]).or_default().push(s);
                    triangles.extend(corners[j + 1..].iter().map(|&c| [a, b, c]));
                }
            }
        }
        let is_edge = |around: &Vec<usize>| {
            let around = around.iter().filter_map(|&s| normals[s].as_deref());
            rank(around) >= scene.dim - 1
        };
        let edges = normals_of.iter().filter(|(_, around)| is_edge(around)).map(|(pair, _)| *pair).collect();
        Some(Wireframe { points, edges, triangles: triangles.into_iter().collect() })
    }
}

/// Length of a unit vector's rest below which it lies in the span of others.
const FLAT: f64 = 1e-6;

/// Subtracts from `v` its parts along orthonormal vectors. Returns the length of the rest.
fn rest(v: &mut [f64], basis: &[Vec<f64>]) -> f64 {
    // Twice: the second pass removes what rounding left.
    for b in basis.iter().chain(basis) {
        let along: f64 = v.iter().zip(b).map(|(x, y)| x * y).sum();
        v.iter_mut().zip(b).for_each(|(x, y)| *x -= along * y);
    }
    length(v)
}

fn length(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Returns the unit normal of a simplex's hyperplane, of either sign; `None` if it is degenerate.
fn normal(corners: &[&[f64]]) -> Option<Vec<f64>> {
    let (first, others) = corners.split_first()?;
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for corner in others {
        let mut v: Vec<f64> = corner.iter().zip(*first).map(|(x, o)| x - o).collect();
        let whole = length(&v);
        let left = rest(&mut v, &basis);
        if left <= FLAT * whole {
            return None;
        }
        v.iter_mut().for_each(|x| *x /= left);
        basis.push(v);
    }
    // The coordinate axis that lies least in the hyperplane has the longest rest.
    let candidates = (0..first.len()).map(|axis| {
        let mut v = vec![0.0; first.len()];
        v[axis] = 1.0;
        let left = rest(&mut v, &basis);
        (left, v)
    });
    let (left, mut v) = candidates.max_by(|a, b| a.0.total_cmp(&b.0))?;
    v.iter_mut().for_each(|x| *x /= left);
    Some(v)
}

/// Returns the number of dimensions that unit vectors span.
fn rank<'a>(vectors: impl Iterator<Item = &'a [f64]>) -> usize {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for vector in vectors {
        let mut v = vector.to_vec();
        let left = rest(&mut v, &basis);
        if left > FLAT {
            v.iter_mut().for_each(|x| *x /= left);
            basis.push(v);
        }
    }
    basis.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::eye::shapes::{DemoScene, Shape, cell24, cross_polytope, cube, simplex};

    #[test]
    fn regular_polytopes_have_the_edges_of_the_textbook() {
        let shapes: [(Shape, usize, usize); 6] = [
            (cube(4).expect("a cube"), 16, 32),
            (cell24(4).expect("a 24-cell"), 24, 96),
            (cross_polytope(4).expect("a cross-polytope"), 8, 24),
            (simplex(4).expect("a simplex"), 5, 10),
            (cube(5).expect("a cube"), 32, 80),
            (simplex(5).expect("a simplex"), 6, 15),
        ];
        for (shape, points, edges) in shapes {
            let demo = DemoScene {
                pixels: vec![4, 4],
                aperture_tan: 0.2,
                turns: vec![(0, 1, 20.0), (1, 3, 30.0), (0, 2, 15.0)],
            };
            let scene = demo.scene(shape).expect("a scene");
            let wireframe = Wireframe::of(&scene).expect("a wireframe");
            let used: BTreeSet<usize> = wireframe.edges.iter().flatten().copied().collect();
            assert_eq!((used.len(), wireframe.edges.len()), (points, edges), "{} dimensions", scene.dim);
            let lengths = wireframe.edges.iter().map(|[a, b]| {
                let (a, b) = (&wireframe.points[*a], &wireframe.points[*b]);
                length(&a.iter().zip(b).map(|(x, y)| x - y).collect::<Vec<_>>())
            });
            let lengths: Vec<f64> = lengths.collect();
            assert!(lengths.iter().all(|l| (l - lengths[0]).abs() < 1e-9), "equal edges: {lengths:?}");
        }
    }
}

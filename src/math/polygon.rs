//! Cutting a polygon in space into triangles.

use glam::DVec3;

/// Triangles of a simple, roughly planar polygon, as indices into `points`, in the polygon's own winding.
///
/// A convex polygon is fanned at its first corner: (0,1,2), (0,2,3), ... A concave one is cut into ears in order of its
/// corners, projected along Newell's normal on the plane of the two largest extents. Degenerate polygons are fanned.
pub fn triangulate(points: &[DVec3]) -> Vec<[u32; 3]> {
    let n = points.len();
    let fan = |n: usize| (1..n.saturating_sub(1) as u32).map(|i| [0, i, i + 1]).collect::<Vec<_>>();
    if n <= 3 {
        return fan(n);
    }
    let normal = newell_normal(points);
    let axis = normal.abs().max_position();
    if !(normal.abs().max_element() > 0.0 && normal.is_finite()) {
        return fan(n);
    }
    let flip = normal[axis] < 0.0;
    let flat: Vec<[f64; 2]> = points
        .iter()
        .map(|p| {
            let (a, b) = (p[(axis + 1) % 3], p[(axis + 2) % 3]);
            if flip { [b, a] } else { [a, b] }
        })
        .collect();
    let turn = |a: usize, b: usize, c: usize| {
        let (p, q, r) = (flat[a], flat[b], flat[c]);
        (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])
    };
    if (0..n).all(|i| turn(i, (i + 1) % n, (i + 2) % n) >= 0.0) {
        return fan(n);
    }
    let mut ring: Vec<usize> = (0..n).collect();
    let mut triangles = Vec::with_capacity(n - 2);
    while ring.len() > 3 {
        let m = ring.len();
        let is_ear = |i: usize| {
            let (a, b, c) = (ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]);
            let inside = |&&p: &&usize| {
                let at_corner = [a, b, c].iter().any(|&k| flat[k] == flat[p]);
                !at_corner && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
            };
            turn(a, b, c) > 0.0 && !ring.iter().any(|p| inside(&p))
        };
        // Corner 1 first, so that a polygon that happens to be convex comes out as the fan.
        let Some(i) = (0..m).map(|k| (k + 1) % m).find(|&i| is_ear(i)) else {
            // Self-crossing or degenerate: what is left is fanned, so that no face is lost.
            triangles.extend(fan(m).iter().map(|t| t.map(|k| ring[k as usize] as u32)));
            return triangles;
        };
        triangles.push([ring[(i + m - 1) % m], ring[i], ring[(i + 1) % m]].map(|k| k as u32));
        ring.remove(i);
    }
    triangles.push([ring[0], ring[1], ring[2]].map(|k| k as u32));
    triangles
}

/// Newell's normal: its length is twice the polygon's area; zero for a degenerate polygon.
pub fn newell_normal(points: &[DVec3]) -> DVec3 {
    let Some(&origin) = points.first() else { return DVec3::ZERO };
    // Relative to the first corner, so that a polygon far from the origin keeps its digits.
    points.windows(2).fold(DVec3::ZERO, |sum, w| sum + (w[0] - origin).cross(w[1] - origin))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(points: &[(f64, f64)]) -> Vec<DVec3> {
        points.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect()
    }

    #[test]
    fn convex_is_fanned_and_concave_is_cut_into_ears_that_fill_it() {
        assert_eq!(triangulate(&flat(&[(0., 0.), (1., 0.), (1., 1.), (0., 1.)])), [[0, 1, 2], [0, 2, 3]]);
        let arrow = flat(&[(0., 0.), (4., 0.), (1., 1.), (0., 4.)]);
        let cut = triangulate(&arrow);
        let area = |t: &[u32; 3]| newell_normal(&t.map(|i| arrow[i as usize])).z / 2.0;
        assert_eq!(cut.len(), 2);
        assert!(cut.iter().all(|t| area(t) > 0.0));
        assert_eq!(cut.iter().map(area).sum::<f64>(), newell_normal(&arrow).z / 2.0);
        assert_eq!(triangulate(&flat(&[(0., 0.), (1., 0.)])), [] as [[u32; 3]; 0]);
        assert_eq!(triangulate(&flat(&[(1., 1.); 5])).len(), 3);
    }
}

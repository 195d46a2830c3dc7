//! Bounds of clusters: sixteen consecutive faces that a draw may cull as one.
//!
//! For each cluster of a mesh these are computed once: a sphere around its corners, a cone around
//! its normals, its least face area and longest edge, all rounded outwards. The culling itself is
//! that of the tile renderer, whose tests compare it with single faces.

use crate::cancel::CancelToken;
use glam::DVec3;

/// Vertices of a block, which is transformed as one or not at all.
pub const BLOCK_VERTICES: usize = 8;

/// Faces of a cluster: one vector of the widest level.
pub const CLUSTER_FACES: usize = 16;

/// Smallest number of faces of a mesh with clusters: a smaller one is drawn in less time than the
/// test of its clusters would take.
pub const LEAST_FACES: usize = 1024;

/// Clusters between two checks for cancellation.
const CLUSTERS_AT_ONCE: usize = 512;

/// Approximate bytes of a cluster: its bounds, and a list of six blocks.
pub const CLUSTER_BYTES: u64 = 40 + 4 + 6 * 4 + 1;

/// Largest average number of vertex blocks of a cluster: beyond it consecutive faces are not
/// neighbours.
const MOST_BLOCKS: usize = 12;

/// Bounds of a mesh's clusters, with the blocks of vertices that they use.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// Number of clusters; the lists are padded to whole vectors.
    count: usize,
    /// Centres of the spheres, x, y, z, and their radii.
    pub spheres: [Vec<f32>; 4],
    /// Unit axes of the cones, x, y, z, and the cosines of their half angles.
    pub cones: [Vec<f32>; 4],
    /// Least doubled area of a face; 0 where normals diverge.
    pub least_areas: Vec<f32>,
    /// Longest edge of a face.
    pub longest_edges: Vec<f32>,
    /// Start of each cluster's list in `blocks`, and the end of the last; empty if clusters use too
    /// many blocks.
    starts: Vec<u32>,
    /// Blocks of [`BLOCK_VERTICES`] vertices that the clusters use.
    blocks: Vec<u32>,
}

impl Clusters {
    /// Builds the clusters of the faces with these corners; none if the mesh has fewer than
    /// [`LEAST_FACES`], or on cancellation.
    pub fn of(
        positions: &[Vec<f64>; 3],
        corners: &[Vec<i32>; 3],
        faces: usize,
        cancel: &CancelToken,
    ) -> Self {
        let mut clusters = Clusters::default();
        if faces < LEAST_FACES {
            return clusters;
        }
        let at = |vertex: i32| DVec3::from_array([0, 1, 2].map(|axis| positions[axis][vertex as usize]));
        // Last cluster that used each block, so that a block is listed once.
        let mut last = vec![u32::MAX; positions[0].len().div_ceil(BLOCK_VERTICES)];
        let mut points = [[DVec3::ZERO; 3]; CLUSTER_FACES];
        for (cluster, start) in (0..faces).step_by(CLUSTER_FACES).enumerate() {
            if cluster % CLUSTERS_AT_ONCE == 0 && cancel.is_cancelled() {
                return Clusters::default();
            }
            let count = CLUSTER_FACES.min(faces - start);
            clusters.starts.push(clusters.blocks.len() as u32);
            for (i, points) in points[..count].iter_mut().enumerate() {
                for (k, point) in points.iter_mut().enumerate() {
                    let vertex = corners[k][start + i];
                    *point = at(vertex);
                    let block = vertex as usize / BLOCK_VERTICES;
                    if last[block] != cluster as u32 {
                        last[block] = cluster as u32;
                        clusters.blocks.push(block as u32);
                    }
                }
            }
            clusters.add(&points[..count]);
        }
        clusters.count = clusters.least_areas.len();
        let padded = clusters.count.next_multiple_of(BLOCK_VERTICES);
        let lists = clusters.spheres.iter_mut().chain(&mut clusters.cones);
        for list in lists.chain([&mut clusters.least_areas, &mut clusters.longest_edges]) {
            list.resize(padded, 0.0);
        }
        if clusters.blocks.len() > clusters.len() * MOST_BLOCKS {
            (clusters.starts, clusters.blocks) = (Vec::new(), Vec::new());
        } else {
            clusters.starts.push(clusters.blocks.len() as u32);
        }
        clusters.blocks.shrink_to_fit();
        clusters
    }

    /// Adds the sphere and the cone of these faces, rounded outwards.
    fn add(&mut self, faces: &[[DVec3; 3]]) {
        let points = || faces.iter().flatten();
        let mut bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for p in points() {
            bounds = (bounds.0.min(*p), bounds.1.max(*p));
        }
        let middle = ((bounds.0 + bounds.1) * 0.5).as_vec3();
        // No sphere contains a point that is not finite: `max` would skip NaN.
        let radius2 = match points().all(|p| p.is_finite()) {
            true => points().fold(0.0f64, |r, p| r.max(p.distance_squared(middle.as_dvec3()))),
            false => f64::INFINITY,
        };
        let (mut normals, mut sum) = ([DVec3::ZERO; CLUSTER_FACES], DVec3::ZERO);
        let (mut area, mut edge2) = (f64::INFINITY, 0.0f64);
        for (normal, [a, b, c]) in normals.iter_mut().zip(faces) {
            let doubled = (*b - *a).cross(*c - *a);
            let length = doubled.length();
            *normal = if length > 0.0 { doubled / length } else { DVec3::ZERO };
            sum += *normal;
            area = area.min(length);
            edge2 = edge2.max(a.distance_squared(*b)).max(b.distance_squared(*c)).max(c.distance_squared(*a));
        }
        let axis = sum.normalize_or_zero().as_vec3();
        let cosine = normals[..faces.len()].iter().fold(1.0f64, |least, n| least.min(n.dot(axis.as_dvec3())));
        // Where normals diverge, some face may look anywhere. An axis in f32 is not quite of length
        // 1, which only wide cones would notice.
        let area = if cosine > 0.05 { area } else { 0.0 };
        for (list, value) in
            self.spheres.iter_mut().zip(middle.to_array().into_iter().chain([up(radius2.sqrt())]))
        {
            list.push(value);
        }
        for (list, value) in
            self.cones.iter_mut().zip(axis.to_array().into_iter().chain([cosine as f32 - 1e-5]))
        {
            list.push(value);
        }
        self.least_areas.push(((area * (1.0 - 1e-6)) as f32).next_down().max(0.0));
        self.longest_edges.push(up(edge2.sqrt()));
    }

    /// Returns the number of clusters.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Returns whether there are no clusters.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the blocks of vertices that a cluster's faces use; empty if that is not recorded.
    #[inline(always)]
    pub fn blocks_of(&self, cluster: usize) -> &[u32] {
        match self.starts.get(cluster..cluster + 2) {
            Some([start, end]) => &self.blocks[*start as usize..*end as usize],
            _ => &[],
        }
    }

    /// Returns whether the vertices that each cluster uses are recorded.
    pub fn knows_blocks(&self) -> bool {
        !self.starts.is_empty()
    }

    /// Returns the bytes of the lists.
    pub fn size_bytes(&self) -> usize {
        self.least_areas.len() * 40 + (self.starts.len() + self.blocks.len()) * 4
    }
}

/// Rounds up to f32, also where f32 has few bits.
fn up(value: f64) -> f32 {
    ((value * (1.0 + 1e-6)) as f32).next_up()
}

//! Triangle set-up: culls and bounds faces and computes their edge functions and depth plane, a
//! vector of faces at a time.
//!
//! In: screen vertices, three indices a face. Out: the faces that may cover a pixel, in file order,
//! binned into tiles. There are three kinds of set-up:
//! - [`Tiny`]: at most 8 pixels a side; its coverage is computed here, one bit for each pixel, and
//!   a face without coverage is dropped. A vector of faces that cover one or two pixels each
//!   becomes [`fragments`].
//! - [`Small`]: edge functions that are exact in i32.
//! - [`ExactFace`]: all others, by the plain path's own set-up in f64.

use super::bin_fragments::bin_fragments;
use super::bins::{Chunk, Small, TinyWords, Winding};
use super::clusters::Visibility;
use super::edges::ones;
use super::exact_faces::ExactFace;
use super::face_vectors::{DepthPlanes, EdgeFunctions, FaceClasses, FaceCorners, PixelBoxes};
use super::fragments;
use super::grid::Grid;
use super::vertex::ScreenVertex;
use crate::math::coverage::PixelRect;
use crate::pipeline::draw_call::DrawStats;
use crate::pipeline::indexed_mesh::CLUSTER_FACES;
use crate::simd::{F32, I32, Kernel, Mask, Simd, prefetch};

/// Sets up one face, by its index, as the plain path does, if screen vertices cannot represent it;
/// `None` if nothing of it is drawn.
pub type PlainSetup<'a> = &'a (dyn Fn(u32, &mut DrawStats) -> Option<ExactFace> + Sync);

/// Sets up and bins the faces of a chunk.
pub struct SetupKernel<'a> {
    /// Vertices of the mesh on the screen.
    pub screen_vertices: &'a [ScreenVertex],
    /// Vertex indices of the three corners of this chunk's faces, padded to whole vectors.
    pub corners: [&'a [i32]; 3],
    /// Number of faces in this chunk.
    pub faces: usize,
    /// Visibility of this chunk's clusters; empty if all are open.
    pub visibilities: &'a [u8],
    /// Index of the chunk's first face in the mesh.
    pub first_face: u32,
    /// Windings that are drawn.
    pub winding: Winding,
    /// Pixels that may be drawn.
    pub view: PixelRect,
    /// Grid of tiles.
    pub grid: Grid,
    /// Set-up by the plain path.
    pub plain: PlainSetup<'a>,
    /// Limit in bytes of the lists of all chunks: beyond it no further cluster is begun.
    pub most_bytes: usize,
    /// True if the first cluster is set up regardless of that limit.
    pub is_first: bool,
    /// Output: the bins and counts of the chunk.
    pub chunk: &'a mut Chunk,
}

/// Distance in clusters of the prefetch.
const AHEAD: usize = 3;

/// Largest number of tiles that a vector of tiny faces is binned to as a whole; beyond, it is
/// binned face by face.
const MOST_TILES: usize = 4;

/// Number of fields that the vector stage passes to the scalar stage, a row of lanes each.
const FIELDS: usize = 16;

/// Fields and tiny faces of one vector, for the stage that takes its faces one by one.
struct Lanes {
    fields: [[i32; 16]; FIELDS],
    tiny: [TinyWords; 16],
}

/// Sums over the faces of a chunk, lane by lane.
struct Sums<S: Simd> {
    /// Covered pixels of tiny faces.
    pixels_in: S::I,
    /// Largest [`DepthPlanes::spread`].
    spread: S::F,
}

/// Tiny faces of a vector: the lanes, and the words that [`super::bins::Tiny`] reads.
struct TinyFaces<S: Simd> {
    lanes: S::M,
    words: [S::I; 8],
}

impl Kernel for SetupKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) {
        let mut lanes = Lanes { fields: [[0; 16]; FIELDS], tiny: [[0; 8]; 16] };
        let mut sums = Sums { pixels_in: s.splat_i(0), spread: s.splat(0.0) };
        let mut done = self.faces;
        for start in (0..self.faces).step_by(S::LANES) {
            if start.is_multiple_of(CLUSTER_FACES)
                && self.chunk.bytes.get() > self.most_bytes
                && !(start == 0 && self.is_first)
            {
                done = start;
                break;
            }
            let count = (self.faces - start).min(S::LANES);
            if self.is_hidden(start, count) {
                continue;
            }
            self.ask_ahead(start);
            self.set_up(s, start, count, &mut sums, &mut lanes);
        }
        self.chunk.done = done;
        self.chunk.spread = f32::from_bits(sums.spread.bits().reduce_max() as u32);
        s.store_i(sums.pixels_in, &mut lanes.fields[0]);
        for count in &lanes.fields[0][..S::LANES] {
            self.chunk.stats.pixels_tested += *count as u64;
        }
    }
}

impl SetupKernel<'_> {
    /// Returns whether the cluster of the faces from `start` on is not drawn; counts `count` of its
    /// faces then.
    #[inline(always)]
    fn is_hidden(&mut self, start: usize, count: usize) -> bool {
        let visibility = self.visibilities.get(start / CLUSTER_FACES).copied().unwrap_or(Visibility::OPEN);
        if visibility == Visibility::OPEN {
            return false;
        }
        let (stats, count) = (&mut self.chunk.stats, count as u64);
        stats.faces += count;
        match visibility {
            Visibility::CULLED => stats.faces_culled += count,
            _ => stats.faces_outside += count,
        }
        true
    }

    /// Sets up and bins a vector of faces, and adds them to `sums`.
    #[inline(always)]
    fn set_up<S: Simd>(&mut self, s: S, start: usize, count: usize, sums: &mut Sums<S>, lanes: &mut Lanes) {
        let none = s.splat_i(0);
        let corners = FaceCorners::gather(s, self.screen_vertices, self.corners, start, count);
        let FaceClasses { seen, by_plain, is_counter } =
            corners.classify(s, &self.view, self.winding, &mut self.chunk.stats);
        let boxes = corners.pixel_boxes(s, &self.view);
        let mut work = seen & boxes.size.0.gt(none) & boxes.size.1.gt(none);
        if !(work | by_plain).any() {
            return;
        }
        let edges = corners.edges(s, is_counter, &boxes);
        let is_tiny = boxes.is_tiny(s, work);
        let (low, high) = boxes.coverage(s, is_tiny, &edges);
        // A tiny face that covers no centre is done.
        work = work & !(is_tiny & (low | high).eq(none));
        if !(work | by_plain).any() {
            return;
        }
        let planes = corners.depth_planes(s, &boxes);
        let rough = work & planes.is_rough & planes.is_gentle;
        let mut by_plain = by_plain | (work & !planes.is_gentle) | (rough & !is_tiny);
        let rough = rough & is_tiny & !by_plain;
        if rough.any() {
            by_plain = by_plain | boxes.has_edge_pixels(s, rough, &edges, (low, high));
        }
        let tiny = work & is_tiny & !by_plain;
        let others = (work & !is_tiny) | by_plain;
        let spread = s.select(work & !(by_plain | planes.is_rough), planes.spread, s.splat(0.0));
        sums.spread = spread.max(sums.spread);
        let pixels_in = &mut sums.pixels_in;
        *pixels_in = *pixels_in + ones(s, s.select_i(tiny, low, none));
        let high_words = tiny & !high.eq(none);
        if high_words.any() {
            *pixels_in = *pixels_in + ones(s, s.select_i(high_words, high, none));
        }
        let words = [
            low,
            high,
            s.iota() + s.splat_i((self.first_face as usize + start) as i32),
            boxes.left | boxes.top.shl::<16>(),
            planes.z.bits(),
            planes.zx.bits(),
            planes.zy.bits(),
            boxes.size.0 | boxes.size.1.shl::<8>(),
        ];
        let tiny = TinyFaces { lanes: tiny, words };
        if !others.any() {
            self.bin_tiny(s, &tiny, &boxes, &planes, lanes);
            return;
        }
        s.compress8(tiny.lanes, words, &mut lanes.tiny);
        lanes.store(s, &boxes, &edges, &planes);
        self.bin_one_by_one(start, [work.bits(), tiny.lanes.bits(), by_plain.bits()], lanes);
    }

    /// Bins a vector of which all faces are tiny. Most often all lie in one tile, or in two: those
    /// get the whole vector.
    #[inline(always)]
    fn bin_tiny<S: Simd>(
        &mut self,
        s: S,
        tiny: &TinyFaces<S>,
        boxes: &PixelBoxes<S>,
        planes: &DepthPlanes<S>,
        lanes: &mut Lanes,
    ) {
        let TinyFaces { lanes: tiny, words } = *tiny;
        let (least, most) = (s.splat_i(i32::MAX), s.splat_i(0));
        let bounds = [
            s.select_i(tiny, boxes.left, least).reduce_min(),
            s.select_i(tiny, boxes.top, least).reduce_min(),
            s.select_i(tiny, boxes.right, most).reduce_max(),
            s.select_i(tiny, boxes.bottom, most).reduce_max(),
        ];
        let tiles = self.grid.tiles_of(bounds);
        let [first_column, first_row, last_column, last_row] = tiles;
        let reach = bounds.map(|bound| bound as i16);
        let few_tiles = (last_column - first_column + 1) * (last_row - first_row + 1) <= MOST_TILES;
        if few_tiles && !(tiny & !fragments::has_few(s, (words[0], words[1]))).any() {
            let depth = [planes.z, planes.zx, planes.zy];
            let (vectors, count) = fragments::of(s, tiny, words[2], words[0], words[3], depth);
            bin_fragments(s, self.chunk, &self.grid, &vectors[..count], tiles, reach);
        } else if (first_column == last_column) & (first_row == last_row) {
            let tile = first_row * self.grid.columns + first_column;
            self.chunk.add_vector(s, tiny, words, tile, reach);
        } else if !few_tiles {
            let count = s.compress8(tiny, words, &mut lanes.tiny);
            for face in &lanes.tiny[..count] {
                self.chunk.add_tiny(face, &self.grid);
            }
        } else {
            for row in first_row..=last_row {
                let y0 = self.grid.y0 + row as i32 * Grid::TILE_ROWS;
                let in_row =
                    tiny & boxes.bottom.gt(s.splat_i(y0)) & s.splat_i(y0 + Grid::TILE_ROWS).gt(boxes.top);
                for column in first_column..=last_column {
                    let columns = self.grid.pixels_of(column);
                    let inside = in_row
                        & boxes.right.gt(s.splat_i(columns.start))
                        & s.splat_i(columns.end).gt(boxes.left);
                    if inside.any() {
                        self.chunk.add_vector(s, inside, words, row * self.grid.columns + column, reach);
                    }
                }
            }
        }
    }

    /// Bins the faces of a vector in their order; the bits are the faces set up here, those of them
    /// that are tiny, and those that the plain path sets up.
    #[inline(always)]
    fn bin_one_by_one(&mut self, start: usize, [work, tiny, by_plain]: [u32; 3], lanes: &Lanes) {
        let mut left_over = work | by_plain;
        let mut next_tiny = 0;
        while left_over != 0 {
            let lane = left_over.trailing_zeros() as usize & 15;
            left_over &= left_over - 1;
            let face = self.first_face + (start + lane) as u32;
            if by_plain >> lane & 1 != 0 {
                let mut own = DrawStats::default();
                let exact_face = (self.plain)(face, &mut own);
                if let Some(exact_face) = exact_face.filter(|w| !w.bounds.is_empty()) {
                    self.chunk.add_exact(exact_face, &self.grid);
                }
                // The vectors' decisions are counted already.
                if work >> lane & 1 == 0 {
                    self.chunk.stats += own;
                }
            } else if tiny >> lane & 1 != 0 {
                self.chunk.add_tiny(&lanes.tiny[next_tiny & 15], &self.grid);
                next_tiny += 1;
            } else {
                self.chunk.add_small(&lanes.small(lane, face), &self.grid);
            }
        }
    }

    /// Prefetches the indices of an open cluster ahead.
    #[inline(always)]
    fn ask_ahead(&self, start: usize) {
        let at = start / CLUSTER_FACES + AHEAD;
        if !start.is_multiple_of(CLUSTER_FACES) || self.visibilities.get(at) != Some(&Visibility::OPEN) {
            return;
        }
        for list in self.corners {
            prefetch::for_read(list, at * CLUSTER_FACES);
        }
    }
}

impl Lanes {
    /// Stores the fields of a vector of small faces.
    #[inline(always)]
    fn store<S: Simd>(
        &mut self,
        s: S,
        boxes: &PixelBoxes<S>,
        edges: &EdgeFunctions<S>,
        planes: &DepthPlanes<S>,
    ) {
        let EdgeFunctions { e, steps_x, steps_y } = edges;
        let fields = [
            e[0],
            e[1],
            e[2],
            steps_x[0],
            steps_x[1],
            steps_x[2],
            steps_y[0],
            steps_y[1],
            steps_y[2],
            planes.z.bits(),
            planes.zx.bits(),
            planes.zy.bits(),
            boxes.left,
            boxes.top,
            boxes.right,
            boxes.bottom,
        ];
        let mut field = 0;
        while field < FIELDS {
            s.store_i(fields[field], &mut self.fields[field]);
            field += 1;
        }
    }

    /// Gathers the fields of a lane into a small face.
    #[inline(always)]
    fn small(&self, lane: usize, face: u32) -> Small {
        let lanes = &self.fields;
        Small {
            face,
            bounds: [
                lanes[12][lane] as i16,
                lanes[13][lane] as i16,
                lanes[14][lane] as i16,
                lanes[15][lane] as i16,
            ],
            edges: [lanes[0][lane], lanes[1][lane], lanes[2][lane]],
            steps_x: [lanes[3][lane], lanes[4][lane], lanes[5][lane]],
            steps_y: [lanes[6][lane], lanes[7][lane], lanes[8][lane]],
            depth: [real(lanes[9][lane]), real(lanes[10][lane]), real(lanes[11][lane])],
        }
    }
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the
// level's instructions.

#[inline(always)]
fn real(bits: i32) -> f32 {
    f32::from_bits(bits as u32)
}

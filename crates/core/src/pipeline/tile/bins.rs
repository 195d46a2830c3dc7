//! Bins: per-tile lists of faces that are set up.

use super::exact_faces::ExactFace;
use super::fragments::{FragmentList, Fragments};
use super::grid::Grid;
use super::list_bytes::ListBytes;
use crate::pipeline::draw_call::DrawStats;
use crate::simd::Simd;

/// Largest side in pixels of a box whose edge functions are exact in i32: 2 * (64 * 256)^2 < 2^31.
pub const SMALL_SIDE: i32 = 62;

/// Largest side in pixels of a face whose coverage is a word of bits.
pub const TINY_SIDE: i32 = 8;

/// Face of at most 8x8 pixels.
#[derive(Clone, Copy, Debug)]
pub struct Tiny {
    /// Coverage: bit 8 j + i is pixel (x + i, y + j).
    pub mask: u64,
    /// Index of the triangle in the mesh.
    pub face: u32,
    /// First column and row.
    pub at: [i16; 2],
    /// Depth at the centre of that pixel, and its steps per column and row.
    pub depth: [f32; 3],
    /// Number of columns and rows.
    pub size: [u8; 2],
}

/// Tiny face as eight words, as vectors write it: the low and the high half of the mask, the face,
/// column and row in one, the depth with its two steps, the size in one.
pub type TinyWords = [i32; 8];

impl Tiny {
    /// Decodes the face from its words.
    #[inline(always)]
    pub fn of([low, high, face, at, z, zx, zy, size]: TinyWords) -> Tiny {
        Tiny {
            mask: u64::from(low as u32) | u64::from(high as u32) << 32,
            face: face as u32,
            at: [at as i16, (at >> 16) as i16],
            depth: [f32::from_bits(z as u32), f32::from_bits(zx as u32), f32::from_bits(zy as u32)],
            size: [size as u8, (size >> 8) as u8],
        }
    }

    /// Returns the columns and rows that the face reaches, half-open: x0, y0, x1, y1.
    #[inline(always)]
    pub fn bounds(&self) -> [i16; 4] {
        let ([x, y], [columns, rows]) = (self.at, self.size);
        [x, y, x + i16::from(columns), y + i16::from(rows)]
    }
}

/// Face whose edge functions fit i32.
#[derive(Clone, Copy, Debug)]
pub struct Small {
    /// Index of the triangle in the mesh.
    pub face: u32,
    /// Columns and rows that may hold covered pixels, half-open, inside the clip rectangle: x0, y0,
    /// x1, y1.
    pub bounds: [i16; 4],
    /// Edge functions at the centre of pixel (x0, y0), biased so that >= 0 is inside.
    pub edges: [i32; 3],
    /// Steps of the edge functions per column.
    pub steps_x: [i32; 3],
    /// Steps of the edge functions per row.
    pub steps_y: [i32; 3],
    /// Depth at the centre of pixel (x0, y0), and its steps per column and row.
    pub depth: [f32; 3],
}

/// List of tiny faces, with room at its end that vectors may write before their face count is
/// known.
#[derive(Debug, Default)]
pub struct TinyList {
    words: Vec<TinyWords>,
    count: usize,
}

impl TinyList {
    /// Returns the room behind the last face, at least `places` elements.
    #[inline(always)]
    pub fn room(&mut self, places: usize, bytes: &ListBytes) -> &mut [TinyWords] {
        let least = self.count + places;
        if self.words.len() < least {
            bytes.lengthen(&mut self.words, least, [0; 8]);
        }
        &mut self.words[self.count..]
    }

    /// Appends the first `faces` elements of the room to the list.
    #[inline(always)]
    pub fn grow(&mut self, faces: usize) {
        self.count = (self.count + faces).min(self.words.len());
    }

    /// Adds a face.
    #[inline(always)]
    pub fn push(&mut self, face: TinyWords, bytes: &ListBytes) {
        self.room(1, bytes)[0] = face;
        self.count += 1;
    }

    /// Removes all faces; the allocation is reused.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Returns the capacity in bytes.
    pub fn size_bytes(&self) -> usize {
        self.words.capacity() * size_of::<TinyWords>()
    }
}

impl std::ops::Deref for TinyList {
    type Target = [TinyWords];

    #[inline(always)]
    fn deref(&self) -> &[TinyWords] {
        &self.words[..self.count]
    }
}

/// Entry of a bin for a face that is not tiny, or for an order break.
#[derive(Clone, Copy, Debug)]
pub struct Larger {
    /// Number of the bin's fragments that precede it.
    pub fragments_before: u32,
    /// Number of the bin's tiny faces that precede it; those since the last `Larger` are drawn
    /// after its fragments.
    pub tiny_before: u32,
    /// List that holds the face, and the index in it.
    pub entry: BinEntry,
}

/// List that holds a face that is not tiny, and the index in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinEntry {
    /// Index in the bin's small faces.
    Small(u32),
    /// Index in the chunk's exact faces.
    Exact(u32),
    /// No face: fragments follow tiny faces.
    OrderBreak,
}

/// Windings that are drawn, by the sign of the area on the screen (rows grow downwards).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Winding {
    /// Counter-clockwise as seen.
    CounterClockwise,
    /// Clockwise as seen.
    Clockwise,
    /// Both.
    Both,
}

/// Faces of a chunk in one tile. Each tile has copies of its own, so that it reads them
/// sequentially.
#[derive(Debug)]
pub struct Bin {
    /// Fragments of vectors of faces whose faces all cover at most two pixels, in file order.
    pub fragments: FragmentList,
    /// Faces of at most 8x8 pixels from all other vectors, in file order.
    pub tiny: TinyList,
    /// All other faces and the order breaks, in file order.
    pub larger: Vec<Larger>,
    /// Faces with edge functions in i32, in file order.
    pub small: Vec<Small>,
    /// Columns and rows that the faces reach, half-open: x0, y0, x1, y1.
    pub reach: [i16; 4],
}

impl Bin {
    /// Empty bounds.
    pub const NOTHING: [i16; 4] = [i16::MAX, i16::MAX, 0, 0];

    /// Returns the bytes of an empty bin for each tile of a grid, and of its entry in the list of
    /// reached tiles.
    pub fn grid_bytes(grid: &Grid) -> usize {
        grid.columns * grid.rows * (size_of::<Bin>() + 2 * size_of::<u32>())
    }

    /// Returns whether no face reaches the tile.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.fragments.is_empty() && self.tiny.is_empty() && self.larger.is_empty()
    }

    /// Returns the union of two bounds.
    #[inline(always)]
    pub fn around(r: [i16; 4], [x0, y0, x1, y1]: [i16; 4]) -> [i16; 4] {
        [r[0].min(x0), r[1].min(y0), r[2].max(x1), r[3].max(y1)]
    }

    /// Appends a larger face or an order break.
    #[inline(always)]
    fn add_larger(&mut self, entry: BinEntry, bytes: &ListBytes) {
        let (fragments_before, tiny_before) = (self.fragments.len() as u32, self.tiny.len() as u32);
        bytes.push(&mut self.larger, Larger { fragments_before, tiny_before, entry });
    }

    /// Extends the bin's reach by `bounds`.
    #[inline(always)]
    pub fn reach(&mut self, bounds: [i16; 4]) {
        self.reach = Self::around(self.reach, bounds);
    }
}

impl Default for Bin {
    fn default() -> Self {
        Bin {
            fragments: FragmentList::default(),
            tiny: TinyList::default(),
            larger: Vec::new(),
            small: Vec::new(),
            reach: Bin::NOTHING,
        }
    }
}

/// Bins of a chunk of faces, and its counts.
#[derive(Debug, Default)]
pub struct Chunk {
    /// Faces set up in f64.
    pub exact_faces: Vec<ExactFace>,
    /// Bins of the tiles, row by row.
    pub bins: Vec<Bin>,
    /// Tiles that are reached.
    pub reached: Vec<u32>,
    /// Largest [`spread`](super::face_vectors::DepthPlanes::spread) of its faces.
    pub spread: f32,
    /// Counts of culled and drawn faces.
    pub stats: DrawStats,
    /// Number of faces, from the first on, that are in the lists.
    pub done: usize,
    /// Counter of the lists' capacity, shared with the other chunks.
    pub bytes: ListBytes,
}

impl Chunk {
    /// Prepares for a draw over `tiles` tiles: empties the lists and reuses their allocations. The
    /// lists are counted in `bytes`, which is one counter from draw to draw.
    pub fn reset(&mut self, tiles: usize, bytes: &ListBytes) {
        if !self.bytes.is_same(bytes) {
            self.bytes = bytes.clone();
        }
        self.done = 0;
        self.exact_faces.clear();
        for tile in self.reached.drain(..) {
            let bin = &mut self.bins[tile as usize];
            bin.fragments.clear();
            bin.tiny.clear();
            bin.larger.clear();
            bin.small.clear();
            bin.reach = Bin::NOTHING;
        }
        if self.bins.len() < tiles {
            let before = self.bins.capacity();
            self.bins.resize_with(tiles, Bin::default);
            self.bytes.grew::<Bin>(before, self.bins.capacity());
        }
        self.stats = DrawStats::default();
    }

    /// Adds a tiny face to the tiles that it reaches.
    #[inline(always)]
    pub fn add_tiny(&mut self, words: &TinyWords, grid: &Grid) {
        let bounds = Tiny::of(*words).bounds();
        let [left, top, right, bottom] = grid.tiles_of(bounds.map(i32::from));
        for row in top..=bottom {
            for column in left..=right {
                let bin = touch(&mut self.bins, &mut self.reached, row * grid.columns + column);
                bin.tiny.push(*words, &self.bytes);
                bin.reach(bounds);
            }
        }
    }

    /// Adds the tiny faces of the set lanes to a tile; all lie within `reach`.
    #[inline(always)]
    pub fn add_vector<S: Simd>(&mut self, s: S, lanes: S::M, words: [S::I; 8], tile: usize, reach: [i16; 4]) {
        let bin = touch(&mut self.bins, &mut self.reached, tile);
        let count = s.compress8(lanes, words, bin.tiny.room(S::LANES, &self.bytes));
        bin.tiny.grow(count);
        bin.reach(reach);
    }

    /// Adds the vectors' fragments whose lanes are set in `inside` to a tile; all lie within
    /// `reach`.
    #[inline(always)]
    pub fn add_fragments<S: Simd>(
        &mut self,
        s: S,
        fragments: &[Fragments<S>],
        inside: [S::M; 2],
        tile: usize,
        reach: [i16; 4],
    ) {
        let bin = touch(&mut self.bins, &mut self.reached, tile);
        if bin.tiny.len() > bin.larger.last().map_or(0, |last| last.tiny_before as usize) {
            bin.add_larger(BinEntry::OrderBreak, &self.bytes);
        }
        for (fragments, inside) in fragments.iter().zip(inside) {
            bin.fragments.add(s, inside, fragments, &self.bytes);
        }
        bin.reach(reach);
    }

    /// Adds a small face to the tiles that it reaches.
    #[inline(always)]
    pub fn add_small(&mut self, face: &Small, grid: &Grid) {
        self.add_larger(face.bounds, grid, |bin, bytes| {
            bytes.push(&mut bin.small, *face);
            BinEntry::Small(bin.small.len() as u32 - 1)
        });
    }

    /// Adds an exact face to the chunk, and its index to the tiles of its bounds.
    #[inline(always)]
    pub fn add_exact(&mut self, face: ExactFace, grid: &Grid) {
        let place = BinEntry::Exact(self.exact_faces.len() as u32);
        let b = face.bounds;
        self.bytes.push(&mut self.exact_faces, face);
        self.add_larger([b.x0 as i16, b.y0 as i16, b.x1 as i16, b.y1 as i16], grid, |_, _| place);
    }

    #[inline(always)]
    fn add_larger(
        &mut self,
        bounds: [i16; 4],
        grid: &Grid,
        place: impl Fn(&mut Bin, &ListBytes) -> BinEntry,
    ) {
        let [left, top, right, bottom] = grid.tiles_of(bounds.map(i32::from));
        for row in top..=bottom {
            for column in left..=right {
                let bin = touch(&mut self.bins, &mut self.reached, row * grid.columns + column);
                let place = place(bin, &self.bytes);
                bin.add_larger(place, &self.bytes);
                bin.reach(bounds);
            }
        }
    }
}

/// Returns the bin of a tile, and lists the tile as reached if the bin was empty.
#[inline(always)]
fn touch<'b>(bins: &'b mut [Bin], reached: &mut Vec<u32>, tile: usize) -> &'b mut Bin {
    let bin = &mut bins[tile];
    if bin.is_empty() {
        reached.push(tile as u32);
    }
    bin
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_counted_by_their_capacity() {
        let (bytes, mut list, mut tiny) = (ListBytes::default(), Vec::new(), TinyList::default());
        for i in 0..1000u64 {
            bytes.push(&mut list, i);
            assert_eq!(bytes.get(), list.capacity() * 8);
        }
        for _ in 0..100 {
            tiny.push([7; 8], &bytes);
            assert_eq!(bytes.get(), list.capacity() * 8 + tiny.size_bytes());
        }
        assert!((100 * 32..400 * 32).contains(&tiny.size_bytes()));
    }

    #[test]
    fn a_grid_takes_a_bin_and_its_place_in_the_list_of_reached_tiles() {
        for rows in 2..50 {
            let grid = Grid::of_frame((3 * Grid::TILE_COLUMNS as usize, rows * Grid::TILE_ROWS as usize));
            let tiles = grid.columns * grid.rows;
            assert_eq!(tiles, 3 * rows);
            let (mut chunk, bytes) = (Chunk::default(), ListBytes::default());
            chunk.reset(tiles, &bytes);
            for tile in 0..tiles {
                let _ = touch(&mut chunk.bins, &mut chunk.reached, tile);
            }
            // A list that has grown item by item has room for up to twice as many.
            let reached = chunk.reached.capacity() * size_of::<u32>();
            let stated = Bin::grid_bytes(&grid);
            assert!(stated >= chunk.bins.capacity() * size_of::<Bin>() + reached, "{tiles}");
            assert!(stated <= tiles * (size_of::<Bin>() + 8), "{tiles}");
        }
    }
}

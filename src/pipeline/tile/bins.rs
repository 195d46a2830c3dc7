//! Where faces that are set up wait for their tiles: the tiles of a view, and each one's lists.

use super::exact_faces::ExactFace;
use super::fragments::{FragmentList, Fragments};
use crate::memory::DEPTH_CELL;
use crate::pipeline::draw_call::DrawStats;
use crate::simd::Simd;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Bytes that the lists of all chunks of a draw have room for. They are counted where a list grows, which is seldom, and on any
/// thread.
#[derive(Clone, Debug, Default)]
pub struct ListBytes(Arc<AtomicUsize>);

impl ListBytes {
    /// Bytes that there is room for.
    #[inline(always)]
    pub fn get(&self) -> usize {
        self.0.load(Relaxed)
    }

    /// A list has grown from room for `before` items to room for `after`.
    fn grew<T>(&self, before: usize, after: usize) {
        self.0.fetch_add((after - before) * size_of::<T>(), Relaxed);
    }

    /// States that all lists were given back.
    pub fn clear(&self) {
        self.0.store(0, Relaxed);
    }

    /// Makes `list` at least `least` items long.
    #[cold]
    #[inline(never)]
    pub fn lengthen<T: Copy>(&self, list: &mut Vec<T>, least: usize, value: T) {
        let before = list.capacity();
        list.resize(least, value);
        self.grew::<T>(before, list.capacity());
    }

    /// Adds an item to a list.
    #[inline(always)]
    pub fn push<T>(&self, list: &mut Vec<T>, item: T) {
        if list.len() == list.capacity() {
            self.make_room(list);
        }
        list.push(item);
    }

    #[cold]
    #[inline(never)]
    fn make_room<T>(&self, list: &mut Vec<T>) {
        let before = list.capacity();
        list.reserve(1);
        self.grew::<T>(before, list.capacity());
    }
}

/// A face of at most 8x8 pixels.
#[derive(Clone, Copy, Debug)]
pub struct Tiny {
    /// Bit 8 j + i is pixel (x + i, y + j).
    pub mask: u64,
    /// The triangle's number in the mesh.
    pub face: u32,
    /// The first column and row.
    pub at: [i16; 2],
    /// Depth at the centre of that pixel, and its steps per column and row.
    pub depth: [f32; 3],
    /// Columns and rows.
    pub size: [u8; 2],
}

/// A tiny face as eight words, as vectors write it: the mask's low and high half, the number, column and row in one, the
/// depth, the size in one.
pub type TinyWords = [i32; 8];

impl Tiny {
    /// The face of these words.
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

    /// Columns and rows that it reaches, half-open: x0, y0, x1, y1.
    #[inline(always)]
    pub fn bounds(&self) -> [i16; 4] {
        let ([x, y], [columns, rows]) = (self.at, self.size);
        [x, y, x + i16::from(columns), y + i16::from(rows)]
    }
}

/// A face whose edge functions fit i32.
#[derive(Clone, Copy, Debug)]
pub struct Small {
    /// The triangle's number in the mesh.
    pub face: u32,
    /// Columns and rows that may hold covered pixels, half-open, inside the view: x0, y0, x1, y1.
    pub bounds: [i16; 4],
    /// Edge functions at the centre of pixel (x0, y0), biased so that >= 0 is inside.
    pub edges: [i32; 3],
    /// Their steps from column to column.
    pub steps_x: [i32; 3],
    /// Their steps from row to row.
    pub steps_y: [i32; 3],
    /// Depth at the centre of pixel (x0, y0), and its steps.
    pub depth: [f32; 3],
}

/// Tiny faces, with room behind them that vectors may write before it is known how many they hold.
#[derive(Debug, Default)]
pub struct TinyList {
    words: Vec<TinyWords>,
    count: usize,
}

impl TinyList {
    /// The places behind the last face, at least so many.
    #[inline(always)]
    pub fn room(&mut self, places: usize, bytes: &ListBytes) -> &mut [TinyWords] {
        let least = self.count + places;
        if self.words.len() < least {
            bytes.lengthen(&mut self.words, least, [0; 8]);
        }
        &mut self.words[self.count..]
    }

    /// So many more of the places behind the last face hold faces.
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

    /// Forgets all faces; keeps their memory.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Bytes of its memory.
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

/// In a bin, a face that is not tiny, or a break of the order.
#[derive(Clone, Copy, Debug)]
pub struct Larger {
    /// How many fragments of the bin come before it.
    pub fragments_before: u32,
    /// How many tiny faces come before it; those since the last `Larger` are drawn after its fragments.
    pub tiny_before: u32,
    /// Its list and its index there.
    pub entry: BinEntry,
}

/// The list that holds a face that is not tiny, and its index there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BinEntry {
    /// Among the bin's small faces.
    Small(u32),
    /// Among the chunk's exact faces.
    Exact(u32),
    /// Nowhere: fragments come after tiny faces.
    OrderBreak,
}

/// The windings that are drawn, by the sign of the area on the screen (rows grow downwards).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Winding {
    /// Those that are counter-clockwise as seen.
    CounterClockwise,
    /// Those that are clockwise as seen.
    Clockwise,
    /// Both.
    Both,
}

/// The pixels that may be drawn, half-open.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClipRect {
    /// Left column.
    pub x0: i32,
    /// Top row.
    pub y0: i32,
    /// One beyond the right column.
    pub x1: i32,
    /// One beyond the bottom row.
    pub y1: i32,
}

/// How the view is cut into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Tiles in a row, at least one.
    pub columns: usize,
    /// Rows of tiles.
    pub rows: usize,
    /// The first pixel row of the first tiles.
    pub y0: i32,
    /// Pixels in a row of the frame: the last tile goes on to its end.
    pub width: i32,
}

impl Grid {
    /// Columns of a tile, those of a cell of depth memory; the last one of a row has fewer than twice as many.
    pub const TILE_COLUMNS: i32 = DEPTH_CELL as i32;
    /// Rows of a tile.
    pub const TILE_ROWS: i32 = 32;

    /// The tiles of a view in a frame of this width.
    pub fn new(view: &ClipRect, width: usize) -> Self {
        Grid {
            columns: (width / Self::TILE_COLUMNS as usize).max(1),
            rows: ((view.y1 - view.y0).max(0) as usize).div_ceil(Self::TILE_ROWS as usize),
            y0: view.y0,
            width: width as i32,
        }
    }

    /// Bytes of an empty list for each tile, and of its number among those that are reached.
    pub fn bytes(&self) -> usize {
        self.columns * self.rows * (size_of::<Bin>() + 2 * size_of::<u32>())
    }

    /// The tiles that bounds (half-open, not empty) reach: the first column and row, the last ones.
    #[inline(always)]
    pub fn tiles_of(&self, [x0, y0, x1, y1]: [i32; 4]) -> [usize; 4] {
        [self.column_of(x0), self.row_of(y0), self.column_of(x1 - 1), self.row_of(y1 - 1)]
    }

    /// The tile column of a pixel column.
    #[inline(always)]
    fn column_of(&self, x: i32) -> usize {
        ((x / Self::TILE_COLUMNS) as usize).min(self.columns - 1)
    }

    /// The tile row of a pixel row.
    #[inline(always)]
    fn row_of(&self, y: i32) -> usize {
        ((y - self.y0) / Self::TILE_ROWS) as usize
    }

    /// The pixel columns of a tile column.
    pub fn pixels_of(&self, column: usize) -> std::ops::Range<i32> {
        let end =
            if column + 1 == self.columns { self.width } else { (column as i32 + 1) * Self::TILE_COLUMNS };
        column as i32 * Self::TILE_COLUMNS..end
    }
}

/// A chunk's faces in one tile: each by itself, so that a tile reads its faces in one run.
#[derive(Debug)]
pub struct Bin {
    /// Fragments of faces that cover a pixel or two, from vectors that have no others, in file order.
    pub fragments: FragmentList,
    /// Faces of at most 8x8 pixels from all other vectors, in file order.
    pub tiny: TinyList,
    /// The others, in file order.
    pub larger: Vec<Larger>,
    /// Faces with edge functions in i32, in file order.
    pub small: Vec<Small>,
    /// Columns and rows that they reach, half-open: x0, y0, x1, y1.
    pub reach: [i16; 4],
}

impl Bin {
    /// Bounds of nothing.
    pub const NOTHING: [i16; 4] = [i16::MAX, i16::MAX, 0, 0];

    /// Whether no face reaches the tile.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.fragments.is_empty() && self.tiny.is_empty() && self.larger.is_empty()
    }

    /// Bounds of both.
    #[inline(always)]
    pub fn around(r: [i16; 4], [x0, y0, x1, y1]: [i16; 4]) -> [i16; 4] {
        [r[0].min(x0), r[1].min(y0), r[2].max(x1), r[3].max(y1)]
    }

    /// Adds a larger face, or a break of the order.
    #[inline(always)]
    fn add_larger(&mut self, entry: BinEntry, bytes: &ListBytes) {
        let (fragments_before, tiny_before) = (self.fragments.len() as u32, self.tiny.len() as u32);
        bytes.push(&mut self.larger, Larger { fragments_before, tiny_before, entry });
    }

    /// Something within these bounds reaches the tile.
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

/// What a chunk of faces became.
#[derive(Debug, Default)]
pub struct Chunk {
    /// Faces set up in f64.
    pub exact_faces: Vec<ExactFace>,
    /// For each tile, row by row, the faces that reach it.
    pub bins: Vec<Bin>,
    /// The tiles that are reached.
    pub reached: Vec<u32>,
    /// What was left out, and drawn.
    pub stats: DrawStats,
    /// The number of its faces, from the first on, that wait in the lists.
    pub done: usize,
    /// What its lists have room for, together with those of the others.
    pub bytes: ListBytes,
}

impl Chunk {
    /// Makes room for `tiles` tiles and forgets the last draw; keeps its memory. Its lists are counted in `bytes`, which is the
    /// same counter from draw to draw.
    pub fn reset(&mut self, tiles: usize, bytes: &ListBytes) {
        if !Arc::ptr_eq(&self.bytes.0, &bytes.0) {
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

    /// Adds the tiny faces of the lanes that are set to a tile; all lie within `reach`.
    #[inline(always)]
    pub fn add_vector<S: Simd>(&mut self, s: S, lanes: S::M, words: [S::I; 8], tile: usize, reach: [i16; 4]) {
        let bin = touch(&mut self.bins, &mut self.reached, tile);
        let count = s.compress8(lanes, words, bin.tiny.room(S::LANES, &self.bytes));
        bin.tiny.grow(count);
        bin.reach(reach);
    }

    /// Adds fragments to a tile, those of the vectors' lanes that are `inside`; all lie within `reach`.
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

    /// Adds an exact face, and its index among the exact ones to the tiles of its bounds.
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

/// The list of a tile, which something reaches now.
#[inline(always)]
fn touch<'b>(bins: &'b mut [Bin], reached: &mut Vec<u32>, tile: usize) -> &'b mut Bin {
    let bin = &mut bins[tile];
    if bin.is_empty() {
        reached.push(tile as u32);
    }
    bin
}

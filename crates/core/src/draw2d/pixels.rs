//! Single pixels, and packed lists of them in the layout of the protocol.

use super::band::on_bands;
use super::blend::{Paint, run_of_many};
use super::{Blend, DrawError, over, pixels_mut};
use crate::executor::Executor;
use crate::memory::{Rgba, VideoMemory};
use crate::simd::prefetch::ForWrite;
use std::sync::atomic::{AtomicU64, Ordering};

/// Draws pixel (x, y). Does nothing if it is outside the frame.
#[doc(alias = "putPixel")]
#[inline]
pub fn put_pixel(memory: &mut VideoMemory, x: i32, y: i32, color: Rgba, blend: Blend) {
    match blend {
        Blend::Replace => memory.draw_pixel(x, y, color),
        Blend::Over if memory.is_drawable(x, y) => compose_pixel(memory, x, y, color),
        Blend::Over => {}
    }
}

/// Draws pixel (x, y) with [`Blend::Over`].
fn compose_pixel(memory: &mut VideoMemory, x: i32, y: i32, color: Rgba) {
    match Paint::new(color, Blend::Over) {
        Some(Paint::Store(color)) => memory.put_pixel(x, y, color),
        Some(Paint::Compose(color)) => {
            if let Ok(dest) = memory.get_pixel(x, y) {
                memory.put_pixel(x, y, over(color, dest));
            }
        }
        None => {}
    }
}

/// Draws the pixels of a `POINTS` payload: records of 8 bytes, x:u16le y:u16le r g b a, in order.
/// Returns the number of pixels inside the frame.
///
/// Pixels outside the frame are skipped. A list that ends within a record is an error, and nothing
/// is drawn.
pub fn points(memory: &mut VideoMemory, packed: &[u8], blend: Blend) -> Result<u64, DrawError> {
    let (records, []) = packed.as_chunks::<8>() else {
        return Err(DrawError::BrokenRecord { record: 8, found: packed.len() as u64 });
    };
    Ok(list(memory, records, read_point, blend))
}

/// Draws the pixels of a `POINTS` payload as [`points`] does, on all threads of `executor` if there
/// are enough of them.
///
/// Each thread draws one band of rows and takes the records in order, so the result has the same
/// bytes with any number of threads.
pub fn points_on(
    executor: &Executor,
    memory: &mut VideoMemory,
    packed: &[u8],
    blend: Blend,
) -> Result<u64, DrawError> {
    let (records, broken) = packed.as_chunks::<8>();
    let (width, height) = (memory.width(), memory.height());
    let bands = executor.threads().clamp(1, height as usize);
    if bands < FEWEST_BANDS || records.len() < FEW_POINTS || !broken.is_empty() || memory.is_clipped() {
        return points(memory, packed, blend);
    }
    let is_far = memory.bytes().len() > NEAR_BYTES;
    let count = AtomicU64::new(0);
    on_bands(executor, memory, 0..height as i32, bands, |band| {
        let rows = (band.clip().y1 - band.clip().y0) as u32;
        let mut points = PointBand { top: band.top(), width, rows, lit: Lit::NONE };
        match is_far {
            true => points.draw::<true>(band.pixels_mut(), records, blend),
            false => points.draw::<false>(band.pixels_mut(), records, blend),
        }
        band.mark_rows(points.lit.low..points.lit.high);
        count.fetch_add(points.lit.count, Ordering::Relaxed);
    });
    Ok(count.into_inner())
}

/// Number of bands from which they pay: each thread reads all records, which takes a third of the time
/// in which one thread draws them.
const FEWEST_BANDS: usize = 3;
/// Number of points below which one thread is done before another is awake.
const FEW_POINTS: usize = 30_000;
/// Number of records filtered at once, a power of two; the matching ones stay in the L1 cache.
const BLOCK: usize = 256;

/// Pixels that were drawn: their rows and their number.
struct Lit {
    low: u32,
    high: u32,
    count: u64,
}

impl Lit {
    const NONE: Lit = Lit { low: u32::MAX, high: 0, count: 0 };

    #[inline(always)]
    fn add(&mut self, y: u32) {
        (self.low, self.high, self.count) = (self.low.min(y), self.high.max(y + 1), self.count + 1);
    }
}

/// A band of rows of the frame, drawn by one thread.
struct PointBand {
    top: u32,
    rows: u32,
    width: u32,
    lit: Lit,
}

impl PointBand {
    /// Draws the records that fall into the band, whose pixels are `pixels`; with `IS_FAR`, cache
    /// lines are prefetched one block before they are written.
    fn draw<const IS_FAR: bool>(&mut self, pixels: &mut [Rgba], records: &[[u8; 8]], blend: Blend) {
        let soon = ForWrite::new();
        let (mut here, mut earlier) = ([[0; 8]; BLOCK], [[0; 8]; BLOCK]);
        let mut waiting = 0;
        for block in records.chunks(BLOCK) {
            let count = self.filter(block, &mut here);
            if IS_FAR {
                // Outside the frame this is the address of another pixel or of none.
                here[..count].iter().for_each(|record| soon.record(pixels, self.place(record).0));
            }
            self.store(pixels, &earlier[..waiting], blend);
            (here, earlier, waiting) = (earlier, here, count);
        }
        self.store(pixels, &earlier[..waiting], blend);
    }

    /// Copies the records whose rows are in the band to `here`, in order, and returns their number.
    /// Membership is close to random, so it is computed without a branch.
    #[inline(always)]
    fn filter(&self, block: &[[u8; 8]], here: &mut [[u8; 8]; BLOCK]) -> usize {
        let mut count = 0;
        for record in block {
            here[count % BLOCK] = *record;
            let y = u32::from(u16::from_le_bytes([record[2], record[3]]));
            count += usize::from(y.wrapping_sub(self.top) < self.rows);
        }
        count
    }

    /// Returns the place of a record among the band's pixels, and its column.
    #[inline(always)]
    fn place(&self, record: &[u8; 8]) -> (usize, u32) {
        let ((x, y), _) = read_point(record);
        ((y.wrapping_sub(self.top) as usize).wrapping_mul(self.width as usize).wrapping_add(x as usize), x)
    }

    /// Draws records whose rows are in the band.
    #[inline(always)]
    fn store(&mut self, pixels: &mut [Rgba], records: &[[u8; 8]], blend: Blend) {
        for record in records {
            let (at, x) = self.place(record);
            let ((_, y), color) = read_point(record);
            // Always `Some` for a column of the frame.
            if x < self.width
                && let Some(pixel) = pixels.get_mut(at)
            {
                *pixel = if blend == Blend::Replace { color } else { over(color, *pixel) };
                self.lit.add(y);
            }
        }
    }
}

/// Reads a record of `POINTS`.
#[inline(always)]
fn read_point(&[a, b, c, d, color @ ..]: &[u8; 8]) -> ((u32, u32), Rgba) {
    (xy([a, b, c, d]), color)
}

/// Draws the pixels of complete binary `PB` records: 10 bytes, `PB` x:u16le y:u16le r g b a, in
/// order. Returns the number of pixels inside the frame.
///
/// The letters are not checked again, and an incomplete last record is ignored.
pub fn binary_pixels(memory: &mut VideoMemory, records: &[u8], blend: Blend) -> u64 {
    let records = records.as_chunks::<10>().0;
    list(memory, records, |&[_, _, a, b, c, d, color @ ..]| (xy([a, b, c, d]), color), blend)
}

/// Draws the pixels of 8-byte records in the layout of [`points`], each translated by `offset` (x,
/// y), in order. Returns the number of pixels inside the frame.
pub fn moved_points(memory: &mut VideoMemory, records: &[[u8; 8]], offset: [i32; 2], blend: Blend) -> u64 {
    // A coordinate below 0 wraps to one far beyond the frame: no frame is 2^31 pixels wide or high.
    let [dx, dy] = offset.map(|d| d as u32);
    let moved = |record: &[u8; 8]| {
        let ((x, y), color) = read_point(record);
        ((x.wrapping_add(dx), y.wrapping_add(dy)), color)
    };
    list(memory, records, moved, blend)
}

/// Stores a run of RGBA pixels linearly from (x, y), across row ends, up to the end of the memory
/// (`PXMULTI`).
///
/// An incomplete last pixel is ignored. Blending does not apply: the bytes are replaced. Returns the
/// number of pixels that were stored.
pub fn pixel_run(memory: &mut VideoMemory, x: u16, y: u16, rgba: &[u8]) -> u64 {
    let width = memory.width() as usize;
    if memory.is_clipped() {
        let start = u64::from(memory.width()) * u64::from(y) + u64::from(x);
        let in_frame =
            (start..u64::from(memory.width()) * u64::from(memory.height())).zip(rgba.as_chunks::<4>().0);
        let place = |at: u64| ((at % width as u64) as u32, (at / width as u64) as u32);
        return clipped_list(memory, in_frame.map(|(at, color)| (place(at), *color)), Blend::Replace);
    }
    let start = width * usize::from(y) + usize::from(x);
    let source = rgba.as_chunks::<4>().0;
    let dest = pixels_mut(memory).get_mut(start..).unwrap_or_default();
    let n = source.len().min(dest.len());
    if n > 0 {
        run_of_many(Blend::Replace, &source[..n], &mut dest[..n]);
        memory.mark_rows((start / width) as u32..((start + n - 1) / width) as u32 + 1);
    }
    n as u64
}

/// Reads x:u16le y:u16le.
#[inline]
fn xy([a, b, c, d]: [u8; 4]) -> (u32, u32) {
    (u16::from_le_bytes([a, b]).into(), u16::from_le_bytes([c, d]).into())
}

/// Prefetch distance: the number of pixels between a cache line's prefetch and its write.
const AHEAD: usize = 64;
/// Size in bytes up to which a frame fits the L2 cache, where prefetching gains nothing.
const NEAR_BYTES: usize = 1 << 20;

/// Draws pixels in order and marks their rows as damaged; those outside the frame are skipped.
/// Returns the number inside.
#[inline]
fn list<R>(
    memory: &mut VideoMemory,
    records: &[R],
    read: impl Fn(&R) -> ((u32, u32), Rgba),
    blend: Blend,
) -> u64 {
    match memory.bytes().len() > NEAR_BYTES {
        _ if memory.is_clipped() => clipped_list(memory, records.iter().map(read), blend),
        true => list_of::<R, true>(memory, records, read, blend),
        false => list_of::<R, false>(memory, records, read, blend),
    }
}

/// Draws pixels in order where the clip rectangle lets them through. Returns their number.
#[cold]
fn clipped_list(
    memory: &mut VideoMemory,
    pixels: impl Iterator<Item = ((u32, u32), Rgba)>,
    blend: Blend,
) -> u64 {
    let mut lit = 0;
    for ((x, y), color) in pixels {
        let (x, y) = (x as i32, y as i32);
        if memory.is_drawable(x, y) {
            put_pixel(memory, x, y, color, blend);
            lit += 1;
        }
    }
    lit
}

/// Implementation of [`list`]; with `IS_FAR`, cache lines are prefetched before they are written.
#[inline]
fn list_of<R, const IS_FAR: bool>(
    memory: &mut VideoMemory,
    records: &[R],
    read: impl Fn(&R) -> ((u32, u32), Rgba),
    blend: Blend,
) -> u64 {
    let (width, height) = (memory.width(), memory.height());
    let pixels = pixels_mut(memory);
    let soon = ForWrite::new();
    let ask_for = |pixels: &[Rgba], record: &R| {
        let ((x, y), _) = read(record);
        // Outside the frame this is the address of another pixel or of none: a prefetch has no
        // effect on either.
        soon.record(pixels, (width as usize).wrapping_mul(y as usize).wrapping_add(x as usize));
    };
    if IS_FAR {
        records.iter().take(AHEAD).for_each(|record| ask_for(pixels, record));
    }
    let mut lit = Lit::NONE;
    for (i, record) in records.iter().enumerate() {
        if IS_FAR && let Some(later) = records.get(i + AHEAD) {
            ask_for(pixels, later);
        }
        let ((x, y), color) = read(record);
        if x < width && y < height {
            // Always `Some`: x and y are inside the frame.
            if let Some(pixel) = pixels.get_mut(width as usize * y as usize + x as usize) {
                *pixel = if blend == Blend::Replace { color } else { over(color, *pixel) };
            }
            lit.add(y);
        }
    }
    memory.mark_rows(lit.low..lit.high);
    lit.count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{golden, memory};

    /// Returns a generator of pseudo-random numbers below its argument.
    fn numbers(mut state: u32) -> impl FnMut(u32) -> u32 {
        move |n| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        }
    }

    #[test]
    fn the_golden_frame_holds_the_golden_bytes() {
        let golden = golden("seed001_putpixel.json");
        let (inputs, expected) = (&golden["inputs"], &golden["expected"]);
        let side = |name: &str| inputs[name].as_u64().unwrap() as u32;
        let mut m = memory(side("width"), side("height"));
        for write in inputs["writes"].as_array().unwrap() {
            let coordinate = |name: &str| write[name].as_i64().unwrap() as i32;
            let color = serde_json::from_value(write["rgba"].clone()).unwrap();
            put_pixel(&mut m, coordinate("x"), coordinate("y"), color, Blend::Replace);
        }
        let mut want = memory(side("width"), side("height")).bytes().to_vec();
        assert_eq!(want.len() as u64, expected["buffer_length"].as_u64().unwrap());
        for bytes in expected["bytes"].as_array().unwrap() {
            let at = bytes["offset"].as_u64().unwrap() as usize;
            let value: Rgba = serde_json::from_value(bytes["value"].clone()).unwrap();
            want[at..at + 4].copy_from_slice(&value);
        }
        assert_eq!(m.bytes(), want);
    }

    #[test]
    fn packed_lists_are_their_pixels_and_are_clipped() {
        let list = [
            (0u16, 0u16, [1, 2, 3, 4]),
            (4, 0, [9; 4]),
            (3, 2, [5; 4]),
            (0, 3, [9; 4]),
            (65535, 65535, [9; 4]),
        ];
        for blend in [Blend::Replace, Blend::Over] {
            let (mut want, mut got, mut got_pb) = (memory(4, 3), memory(4, 3), memory(4, 3));
            for m in [&mut got, &mut got_pb] {
                m.take_damage();
            }
            let (mut packed, mut pb) = (Vec::new(), Vec::new());
            for (x, y, color) in list {
                put_pixel(&mut want, x.into(), y.into(), color, blend);
                let record = [x.to_le_bytes().as_slice(), &y.to_le_bytes(), &color].concat();
                packed.extend(&record);
                pb.extend([b"PB".as_slice(), &record].concat());
            }
            points(&mut got, &packed, blend).unwrap();
            binary_pixels(&mut got_pb, &pb, blend);
            assert_eq!((got.bytes(), got_pb.bytes()), (want.bytes(), want.bytes()));
            assert_eq!((got.take_damage(), got_pb.take_damage()), (0..3, 0..3));
        }
        let mut m = memory(4, 3);
        let broken = points(&mut m, &[0; 15], Blend::Replace);
        assert_eq!(broken, Err(DrawError::BrokenRecord { record: 8, found: 15 }));
        assert_eq!(m.bytes(), memory(4, 3).bytes());
    }

    #[test]
    fn lists_of_every_length_are_their_pixels_on_frames_near_and_far() {
        let mut next = numbers(11);
        for (width, height) in [(64, 64), (600, 500)] {
            assert_eq!(width * height * 4 > NEAR_BYTES as u32, width == 600);
            for count in [0, 1, AHEAD - 1, AHEAD, AHEAD + 1, 5 * AHEAD + 3] {
                for blend in [Blend::Replace, Blend::Over] {
                    let [mut want, mut got] = [memory(width, height), memory(width, height)];
                    let (mut pb, mut lit) = (Vec::new(), 0);
                    let mut packed = Vec::new();
                    for i in 0..count {
                        // Every eighth point may be anywhere; the last one has the largest
                        // coordinates.
                        let [x, y] = match i {
                            _ if i + 1 == 5 * AHEAD + 3 => [65535; 2],
                            _ if i % 8 == 7 => [next(65536) as u16, next(65536) as u16],
                            _ => [next(width) as u16, next(height) as u16],
                        };
                        let color = [0; 4].map(|_: u8| next(256) as u8);
                        put_pixel(&mut want, x.into(), y.into(), color, blend);
                        lit += u64::from(u32::from(x) < width && u32::from(y) < height);
                        let record: [u8; 8] = [x.to_le_bytes().as_slice(), &y.to_le_bytes(), &color]
                            .concat()
                            .try_into()
                            .unwrap();
                        pb.extend([b"PB".as_slice(), &record].concat());
                        packed.push(record);
                    }
                    let what = format!("{count} on {width}x{height}, {blend:?}");
                    let [mut listed, mut moved, mut moved_back] = [(); 3].map(|()| memory(width, height));
                    assert_eq!(binary_pixels(&mut got, &pb, blend), lit);
                    points(&mut listed, packed.as_flattened(), blend).unwrap();
                    assert!(got.bytes() == want.bytes() && listed.bytes() == want.bytes(), "{what}");
                    assert_eq!(got.take_damage(), want.take_damage(), "{what}");
                    // Up and to the left: points that leave the frame wrap to coordinates beyond
                    // it.
                    let [dx, dy] = [-7, -9];
                    for &[a, b, c, d, color @ ..] in &packed {
                        let (x, y) = xy([a, b, c, d]);
                        put_pixel(&mut moved_back, x as i32 + dx, y as i32 + dy, color, blend);
                    }
                    moved_points(&mut moved, &packed, [dx, dy], blend);
                    assert!(moved.bytes() == moved_back.bytes(), "{what}, moved");
                }
            }
        }
    }

    #[test]
    fn bands_of_threads_light_what_one_thread_does() {
        let mut next = numbers(7);
        // Some points are outside the frame and many coincide, with every alpha.
        let mut packed = Vec::new();
        for _ in 0..2 * FEW_POINTS {
            packed.extend((next(110) as u16).to_le_bytes());
            packed.extend((2 + next(90) as u16).to_le_bytes());
            packed.extend([0; 4].map(|_: u8| next(256) as u8));
        }
        for blend in [Blend::Replace, Blend::Over] {
            let mut want = memory(100, 77);
            want.take_damage();
            points(&mut want, &packed, blend).unwrap();
            let rows = want.take_damage();
            for threads in [2, 3, 16, 100] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                let mut got = memory(100, 77);
                got.take_damage();
                points_on(&Executor::of_pool(Some(pool.into())), &mut got, &packed, blend).unwrap();
                assert!(got.bytes() == want.bytes(), "{threads} threads, {blend:?}");
                assert_eq!(got.take_damage(), rows);
            }
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let pool = Executor::of_pool(Some(pool.into()));
        let mut m = memory(100, 77);
        let broken = points_on(&pool, &mut m, &packed[1..], Blend::Replace);
        assert_eq!(broken, Err(DrawError::BrokenRecord { record: 8, found: 16 * FEW_POINTS as u64 - 1 }));
    }

    #[test]
    fn a_run_goes_on_over_row_ends_and_stops_at_the_end_of_the_memory() {
        let mut m = memory(3, 3);
        m.take_damage();
        pixel_run(&mut m, 2, 1, &[7; 8]);
        assert_eq!(m.take_damage(), 1..3);
        assert_eq!((m.get_pixel(2, 1), m.get_pixel(0, 2)), (Ok([7; 4]), Ok([7; 4])));
        pixel_run(&mut m, 1, 2, &[8; 400]);
        assert_eq!((m.get_pixel(0, 2), m.get_pixel(2, 2)), (Ok([7; 4]), Ok([8; 4])));
        let before = m.bytes().to_vec();
        pixel_run(&mut m, 65535, 65535, &[8; 400]);
        pixel_run(&mut m, 0, 3, &[8; 400]);
        pixel_run(&mut m, 0, 0, &[8; 3]);
        assert_eq!(m.bytes(), before);
    }
}

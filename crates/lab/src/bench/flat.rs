//! Workloads W6 and W7: lines and pixels, compared with the simplest loops that draw them.

use super::check::Check;
use super::frame::BACKGROUND;
use super::{BenchOptions, BenchRun, Workload, Xorshift};
use fbptr_core::draw2d::{self, Blend, Line, RampColor};
use fbptr_core::executor::Executor;
use fbptr_core::memory::{Rgba, VideoMemory};

/// Compact line as a program would store it: half the bytes of [`Line`].
#[derive(Clone, Copy, Debug)]
struct Packed {
    p0: [i16; 2],
    p1: [i16; 2],
    color: Rgba,
}

impl From<Packed> for Line {
    #[inline(always)]
    fn from(p: Packed) -> Line {
        let wide = |p: [i16; 2]| [i32::from(p[0]), i32::from(p[1])];
        Line { p0: wide(p.p0), p1: wide(p.p1), color: RampColor { from: p.color, to: None } }
    }
}

/// Returns a colour for each line that shows the drawing order.
fn color(i: usize) -> Rgba {
    let [a, b, c, _] = (i as u32).wrapping_mul(2_654_435_761).to_le_bytes();
    [a, b, c, 255]
}

/// Returns the lines of all compared programs: two random numbers each; short lines reach at most
/// 11 pixels each way, clamped to the frame.
fn packed_lines(count: usize, is_short: bool, width: u32, height: u32) -> Vec<Packed> {
    let mut random = Xorshift::new();
    let place = |r: u32| [(((r & 0xffff) * width) >> 16) as i16, (((r >> 16) * height) >> 16) as i16];
    let held = |v: i32, limit: u32| v.clamp(0, limit as i32 - 1) as i16;
    (0..count)
        .map(|i| {
            let (a, b) = (random.next(), random.next());
            let p0 = place(a);
            let near = [
                held(i32::from(p0[0]) + (b % 23) as i32 - 11, width),
                held(i32::from(p0[1]) + ((b >> 16) % 23) as i32 - 11, height),
            ];
            Packed { p0, p1: if is_short { near } else { place(b) }, color: color(i) }
        })
        .collect()
}

/// Draws a line by Bresenham's loop in its usual form, one error term for all octants, with the
/// project's rule for ties.
fn naive_line(pixels: &mut [Rgba], width: i32, line: Packed) {
    let [mut x, mut y] = line.p0.map(i32::from);
    let [x1, y1] = line.p1.map(i32::from);
    let (dx, dy) = ((x1 - x).abs(), -(y1 - y).abs());
    let (sx, sy) = (if x < x1 { 1 } else { -1 }, if y < y1 { 1 } else { -1 });
    let mut error = dx + dy;
    loop {
        pixels[(y * width + x) as usize] = line.color;
        if x == x1 && y == y1 {
            return;
        }
        let twice = 2 * error;
        if twice > dy {
            error += dy;
            x += sx;
        }
        if twice < dx {
            error += dx;
            y += sy;
        }
    }
}

/// Drawing with the simplest loop that draws the same.
pub(super) trait FlatDrawing {
    /// Name of the simplest loop.
    const TWIN: &str;
    fn draw(&self, memory: &mut VideoMemory);
    fn draw_twin(&self, memory: &mut VideoMemory);
    fn threads(&self) -> usize;
}

/// Workload whose reference is its twin, byte for byte.
pub(super) struct Flat<K> {
    drawing: K,
    memory: VideoMemory,
    twin: VideoMemory,
}

impl<K: FlatDrawing> Flat<K> {
    fn new(drawing: K, options: &BenchOptions) -> Self {
        let size = options.size;
        let [memory, twin] = [0, 1]
            .map(|_| VideoMemory::new(size.width, size.height).expect("the size of a benchmark's frame"));
        Flat { drawing, memory, twin }
    }
}

impl<K: FlatDrawing> BenchRun for Flat<K> {
    fn frame(&mut self) {
        self.memory.clear(BACKGROUND);
        self.drawing.draw(&mut self.memory);
    }

    fn bytes(&self) -> &[u8] {
        self.memory.bytes()
    }

    fn spoil(&mut self) {
        self.memory.clear([1, 254, 77, 3]);
    }

    fn truth(&mut self) -> VideoMemory {
        self.twin_frame();
        self.twin.clone()
    }

    fn check(&mut self) -> Check {
        self.twin_frame();
        Check::of_bytes(self.memory.bytes(), self.twin.bytes(), BACKGROUND)
    }

    fn twin(&self) -> Option<&'static str> {
        Some(K::TWIN)
    }

    fn twin_frame(&mut self) {
        self.twin.clear(BACKGROUND);
        self.drawing.draw_twin(&mut self.twin);
    }

    fn threads(&self) -> usize {
        self.drawing.threads()
    }

    fn simd(&self) -> &'static str {
        "none"
    }
}

pub(super) struct Lines {
    lines: Vec<Packed>,
    executor: Executor,
}

impl Lines {
    pub fn run_of(workload: Workload, options: &BenchOptions) -> Flat<Self> {
        let (is_short, size) = (workload == Workload::LinesShort, options.size);
        let count = if is_short { 5_000_000 } else { 1_000_000 } / size.divisor as usize;
        let lines = packed_lines(count, is_short, size.width, size.height);
        Flat::new(Lines { lines, executor: Executor::of_pool(options.render.pool.clone()) }, options)
    }
}

impl FlatDrawing for Lines {
    const TWIN: &str = "naive";

    fn draw(&self, memory: &mut VideoMemory) {
        draw2d::lines_on(&self.executor, memory, &self.lines, Blend::Replace);
    }

    fn draw_twin(&self, memory: &mut VideoMemory) {
        let width = memory.width() as i32;
        let pixels = memory.bytes_mut().as_chunks_mut().0;
        self.lines.iter().for_each(|&line| naive_line(pixels, width, line));
    }

    fn threads(&self) -> usize {
        self.executor.threads()
    }
}

pub(super) struct Pixels {
    count: usize,
}

impl Pixels {
    pub fn run_of(options: &BenchOptions) -> Flat<Self> {
        Flat::new(Pixels { count: 100_000_000 / options.size.divisor as usize }, options)
    }

    /// Calls `put` with every pixel, generated on the fly.
    #[inline(always)]
    fn each(&self, width: u32, height: u32, mut put: impl FnMut(u32, u32, Rgba)) {
        let mut random = Xorshift::new();
        for _ in 0..self.count {
            let r = random.next();
            let [a, b, c, _] = r.to_le_bytes();
            put(((r & 0xffff) * width) >> 16, ((r >> 16) * height) >> 16, [a, b, c, 255]);
        }
    }
}

impl FlatDrawing for Pixels {
    const TWIN: &str = "raw_store";

    fn draw(&self, memory: &mut VideoMemory) {
        self.each(memory.width(), memory.height(), |x, y, color| {
            draw2d::put_pixel(memory, x as i32, y as i32, color, Blend::Replace);
        });
    }

    fn draw_twin(&self, memory: &mut VideoMemory) {
        let (width, height) = (memory.width(), memory.height());
        let pixels = memory.bytes_mut().as_chunks_mut().0;
        self.each(width, height, |x, y, color| pixels[(y * width + x) as usize] = color);
    }

    fn threads(&self) -> usize {
        1
    }
}

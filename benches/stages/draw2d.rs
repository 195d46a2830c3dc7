//! Benchmarks of the 2-D functions, each beside the plainest loop or copy with the same effect; the
//! pictures are compared. All run on one thread, packed points on three as well.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use fbptr::draw2d::{self, AreaColors, Blend, Line, RampColor, Rect};
use fbptr::executor::Executor;
use fbptr::framebuffer::Framebuffer;
use fbptr::memory::{Rgba, VideoMemory};
use fbptr::server::worker_pool;
use std::hint::black_box;

const W: u32 = 1920;
const H: u32 = 1080;
const COLOR: Rgba = [255, 204, 51, 255];

fn frame() -> VideoMemory {
    VideoMemory::new(W, H).expect("a frame of ordinary size")
}

/// Returns the ends of lines all over the frame, or at most 12 pixels long.
fn ends(n: usize, is_short: bool) -> Vec<[[i32; 2]; 2]> {
    let mut state = 0x1234_5678u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state
    };
    let place = |r: u32| [(((r & 0xffff) * W) >> 16) as i32, (((r >> 16) * H) >> 16) as i32];
    let near = |[x, y]: [i32; 2], r: u32| {
        let (dx, dy) = (r % 23, (r >> 16) % 23);
        [(x + dx as i32 - 11).clamp(0, W as i32 - 1), (y + dy as i32 - 11).clamp(0, H as i32 - 1)]
    };
    (0..n)
        .map(|_| {
            let (a, b) = (next(), next());
            [place(a), if is_short { near(place(a), b) } else { place(b) }]
        })
        .collect()
}

/// Bresenham's loop in its usual form, with the same rule for ties.
fn naive_line(pixels: &mut [Rgba], [p0, p1]: [[i32; 2]; 2]) {
    let [[mut x, mut y], [x1, y1]] = [p0, p1];
    let (dx, dy) = ((x1 - x).abs(), (y1 - y).abs());
    let (sx, sy) = (if x < x1 { 1 } else { -1 }, if y < y1 { 1 } else { -1 });
    let mut d = 2 * dx.min(dy) - dx.max(dy);
    for _ in 0..=dx.max(dy) {
        pixels[(y * W as i32 + x) as usize] = COLOR;
        if dx >= dy {
            x += sx;
        } else {
            y += sy;
        }
        if d > 0 {
            d -= 2 * dx.max(dy);
            if dx >= dy {
                y += sy;
            } else {
                x += sx;
            }
        }
        d += 2 * dx.min(dy);
    }
}

fn lines(c: &mut Criterion) {
    for (name, n, is_short) in [("long lines", 10_000, false), ("short lines", 100_000, true)] {
        let ends = ends(n, is_short);
        let (mut ours, mut naive) = (frame(), frame());
        let color = RampColor { from: COLOR, to: None };
        let draw = |m: &mut VideoMemory| {
            ends.iter().for_each(|&[p0, p1]| draw2d::line(m, p0, p1, color, Blend::Replace));
        };
        let draw_naive = |m: &mut VideoMemory| {
            let pixels = m.bytes_mut().as_chunks_mut().0;
            ends.iter().for_each(|&line| naive_line(pixels, line));
        };
        let draw_batch = |m: &mut VideoMemory| {
            draw2d::lines(m, ends.iter().map(|&[p0, p1]| Line { p0, p1, color }), Blend::Replace);
        };
        draw_batch(&mut ours);
        let batch = ours.bytes().to_vec();
        ours.clear(VideoMemory::CLEAR);
        draw(&mut ours);
        assert!(ours.bytes() == batch, "the pictures differ: no time is worth printing");
        draw_naive(&mut naive);
        assert!(ours.bytes() == naive.bytes(), "the pictures differ: no time is worth printing");
        let mut group = c.benchmark_group(name);
        group.throughput(Throughput::Elements(n as u64));
        group.bench_function("draw2d", |b| b.iter(|| draw(black_box(&mut ours))));
        group.bench_function("draw2d, as a batch", |b| b.iter(|| draw_batch(black_box(&mut ours))));
        group.bench_function("naive", |b| b.iter(|| draw_naive(black_box(&mut naive))));
        group.finish();
    }
}

fn pixels(c: &mut Criterion) {
    const N: usize = 1_000_000;
    let places: Vec<[i32; 2]> = ends(N / 2, false).into_iter().flatten().collect();
    let (mut ours, mut raw) = (frame(), frame());
    let put = |m: &mut VideoMemory| {
        places
            .iter()
            .for_each(|&[x, y]| draw2d::put_pixel(m, x, y, [x as u8, y as u8, 7, 255], Blend::Replace));
    };
    let store = |m: &mut VideoMemory| {
        let pixels: &mut [Rgba] = m.bytes_mut().as_chunks_mut().0;
        places
            .iter()
            .for_each(|&[x, y]| pixels[y as usize * W as usize + x as usize] = [x as u8, y as u8, 7, 255]);
    };
    put(&mut ours);
    store(&mut raw);
    assert!(ours.bytes() == raw.bytes(), "the pictures differ: no time is worth printing");
    let mut group = c.benchmark_group("put_pixel at random");
    group.throughput(Throughput::Elements(N as u64));
    group.bench_function("draw2d", |b| b.iter(|| put(black_box(&mut ours))));
    group.bench_function("raw store", |b| b.iter(|| store(black_box(&mut raw))));
    group.finish();
}

fn points(c: &mut Criterion) {
    const N: usize = 1_000_000;
    let record = |[x, y]: [i32; 2]| {
        let [[x0, x1], [y0, y1]] = [x, y].map(|v| (v as u16).to_le_bytes());
        [x0, x1, y0, y1, x as u8, y as u8, 7, 255]
    };
    let packed: Vec<u8> = ends(N / 2, false).into_iter().flatten().flat_map(record).collect();
    let mut raw = frame();
    let store = |m: &mut VideoMemory| {
        let pixels: &mut [Rgba] = m.bytes_mut().as_chunks_mut().0;
        for &[a, b, c, d, ref color @ ..] in packed.as_chunks::<8>().0 {
            let [x, y] = [[a, b], [c, d]].map(|v| usize::from(u16::from_le_bytes(v)));
            pixels[y * W as usize + x] = *color;
        }
    };
    store(&mut raw);
    let mut group = c.benchmark_group("packed points at random");
    group.throughput(Throughput::Elements(N as u64));
    for threads in [1, 3] {
        let (executor, mut ours) = (Executor::of_pool(worker_pool(Some(threads))), frame());
        let draw = |m: &mut VideoMemory| {
            draw2d::points_on(&executor, m, &packed, Blend::Replace).expect("complete records");
        };
        draw(&mut ours);
        assert!(ours.bytes() == raw.bytes(), "the pictures differ: no time is worth printing");
        group.bench_function(format!("draw2d, {threads} threads"), |b| b.iter(|| draw(black_box(&mut ours))));
    }
    group.bench_function("raw store", |b| b.iter(|| store(black_box(&mut raw))));
    group.finish();
}

fn areas(c: &mut Criterion) {
    let whole = Rect { x: 0, y: 0, w: W as i32, h: H as i32 };
    let part = Rect { x: 100, y: 100, w: 1700, h: 900 };
    let source: Vec<u8> = (0..W * H).flat_map(u32::to_le_bytes).collect();
    let mut m = frame();
    let mut group = c.benchmark_group("areas");
    group.throughput(Throughput::Bytes(u64::from(W) * u64::from(H) * 4));
    group.bench_function("memset of the frame", |b| b.iter(|| black_box(&mut m).bytes_mut().fill(7)));
    group.bench_function("clear", |b| b.iter(|| black_box(&mut m).clear(COLOR)));
    group.bench_function("fill_rect whole", |b| {
        b.iter(|| draw2d::fill_rect(black_box(&mut m), whole, COLOR, Blend::Replace));
    });
    group.bench_function("memcpy of the frame", |b| {
        b.iter(|| black_box(&mut m).bytes_mut().copy_from_slice(&source));
    });
    group.bench_function("blit", |b| {
        b.iter(|| draw2d::blit(black_box(&mut m), whole, &source, Blend::Replace));
    });
    group.bench_function("blit over", |b| {
        b.iter(|| draw2d::blit(black_box(&mut m), whole, &source, Blend::Over));
    });
    group.throughput(Throughput::Bytes(part.w as u64 * part.h as u64 * 4));
    group.bench_function("fill_rect part", |b| {
        b.iter(|| draw2d::fill_rect(black_box(&mut m), part, COLOR, Blend::Replace));
    });
    group.bench_function("fill_rect over", |b| {
        b.iter(|| draw2d::fill_rect(black_box(&mut m), part, [9, 8, 7, 100], Blend::Over));
    });
    group.finish();
}

fn figures(c: &mut Criterion) {
    let corners = [[10.3, 20.7], [1900.1, 300.9], [700.5, 1070.2]];
    let colors = AreaColors::Three([[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]]);
    let mut m = frame();
    let mut group = c.benchmark_group("figures");
    for (name, colors) in [("one colour", AreaColors::One(COLOR)), ("three colours", colors)] {
        group.bench_function(format!("fill {name}"), |b| {
            b.iter(|| draw2d::fill(black_box(&mut m), corners, colors, Blend::Replace));
        });
    }
    group.bench_function("fill three colours, corners at 1e23", |b| {
        let far = corners.map(|p| p.map(|v| (v - 700.0) * 1e20));
        b.iter(|| draw2d::fill(black_box(&mut m), far, colors, Blend::Replace));
    });
    group.bench_function("fill_circle r 400", |b| {
        b.iter(|| draw2d::fill_circle(black_box(&mut m), [960.2, 540.7], 400.0, COLOR, Blend::Replace));
    });
    group.bench_function("circle r 400", |b| {
        b.iter(|| draw2d::circle(black_box(&mut m), [960, 540], 400, COLOR, Blend::Replace));
    });
    group.bench_function("line_aa across", |b| {
        b.iter(|| draw2d::line_aa(black_box(&mut m), [3.1, 5.9], [1900.4, 1000.2], COLOR));
    });
    let ramp = RampColor { from: COLOR, to: Some([0, 0, 255, 255]) };
    group.bench_function("line ramp across", |b| {
        b.iter(|| draw2d::line(black_box(&mut m), [3, 5], [1900, 1000], ramp, Blend::Replace));
    });
    group.finish();
}

/// Figures of a few pixels through [`Framebuffer`], as a program draws them, each compared with its
/// definition before.
fn small(c: &mut Criterion) {
    const FIGURES: usize = 10_000;
    let places: Vec<[i32; 2]> = ends(FIGURES, true).iter().map(|[p0, _]| *p0).collect();
    let lines = ends(FIGURES, true);
    type Draw<'a> = Box<dyn Fn(&mut Framebuffer) + 'a>;
    type Defined<'a> = Box<dyn Fn(&mut VideoMemory) + 'a>;
    let cases: [(&str, Draw<'_>, Defined<'_>); 4] = [
        (
            "rectangle 4x4",
            Box::new(|fb| {
                places.iter().for_each(|&[x, y]| fb.fill_rect([x, y, 4, 4], COLOR).expect("in range"));
            }),
            Box::new(|m| each_pixel(m, &places, 0..4, |_, _| true)),
        ),
        (
            "line",
            Box::new(|fb| lines.iter().for_each(|&[p0, p1]| fb.line(p0, p1, COLOR))),
            Box::new(|m| lines.iter().for_each(|&line| naive_line(m.bytes_mut().as_chunks_mut().0, line))),
        ),
        (
            "disc r = 3",
            Box::new(|fb| {
                let center = |&[x, y]: &[i32; 2]| [f64::from(x), f64::from(y)];
                places.iter().for_each(|p| fb.fill_circle(center(p), 3.0, COLOR).expect("in range"));
            }),
            // Centres of pixels within the circle: (2 dx + 1)^2 + (2 dy + 1)^2 <= (2 r)^2.
            Box::new(|m| {
                each_pixel(m, &places, -4..4, |dx, dy| (2 * dx + 1).pow(2) + (2 * dy + 1).pow(2) <= 36);
            }),
        ),
        (
            "letter",
            Box::new(|fb| places.iter().for_each(|&p| fb.text(p, "g", COLOR))),
            Box::new(|m| {
                let glyph = draw2d::font::glyph('g');
                each_pixel(m, &places, 0..8, |dx, dy| glyph[dy as usize] >> (7 - dx) & 1 != 0);
            }),
        ),
    ];
    let mut group = c.benchmark_group("small figures");
    group.throughput(Throughput::Elements(FIGURES as u64));
    for (name, draw, defined) in &cases {
        let (mut fb, mut truth) = (Framebuffer::new(W, H).expect("a frame of ordinary size"), frame());
        draw(&mut fb);
        defined(&mut truth);
        assert!(fb.memory().bytes() == truth.bytes(), "{name}");
        group.bench_function(*name, |b| b.iter(|| draw(black_box(&mut fb))));
    }
    group.finish();
}

/// Draws the pixels at offsets within `side` of each place for which `is_inside` holds.
fn each_pixel(
    memory: &mut VideoMemory,
    places: &[[i32; 2]],
    side: std::ops::Range<i32>,
    is_inside: impl Fn(i32, i32) -> bool,
) {
    for [x, y] in places {
        for (dx, dy) in side.clone().flat_map(|dy| side.clone().map(move |dx| (dx, dy))) {
            if is_inside(dx, dy) {
                memory.put_pixel(x + dx, y + dy, COLOR);
            }
        }
    }
}

criterion_group!(benches, lines, pixels, points, areas, figures, small);
criterion_main!(benches);

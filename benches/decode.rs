//! Benchmark of the decoder from memory, on one core. Every figure is of a run whose pixels were
//! verified.
//!
//! `cargo bench --bench decode [-- NAME]` prints the best and the median of the rounds, in millions
//! per second. The streams are larger than the inner caches and smaller than the last one, as a
//! socket's batches are; they are fed in pieces of 256 KiB, which cut commands anywhere.

use fbptr::command::{
    Command, Decoder, EndOfInput, Flow, Limits, PayloadPool, Rect, Sink, StreamError, StreamPosition,
    binary_pixel,
};
use std::hint::black_box;
use std::time::Instant;

const PIECE: usize = 256 << 10;
const ROUNDS: usize = 300;
const WIDTH: usize = 1920;
const HEIGHT: usize = 1080;

/// A sink that sums its calls independently of their order, so that any wrong pixel changes the
/// hash.
#[derive(Default)]
struct Sums {
    pixels: u64,
    hash: u64,
    commands: u64,
    bytes: u64,
    errors: u64,
}

impl Sums {
    #[inline(always)]
    fn add(&mut self, x: i32, y: i32, color: [u8; 4]) {
        self.pixels += 1;
        let place = (x as u32 as u64) << 32 | y as u32 as u64;
        self.hash = self.hash.wrapping_add(
            (place ^ u64::from(u32::from_le_bytes(color)) << 16).wrapping_mul(0x9e37_79b9_7f4a_7c15),
        );
    }
}

impl Sink for Sums {
    #[inline]
    fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) {
        self.add(x, y, color);
    }
    fn binary_pixels(&mut self, records: &[u8]) {
        for record in records.as_chunks().0 {
            let (x, y, color) = binary_pixel(record);
            self.add(x.into(), y.into(), color);
        }
    }
    fn command(&mut self, command: Command, place: StreamPosition) -> Flow {
        self.commands += 1;
        black_box((command, place));
        Flow::Continue
    }
    fn error(&mut self, _: StreamError) -> Flow {
        self.errors += 1;
        Flow::Continue
    }
    fn blit(&mut self, _: Rect, rgba: &[u8], _: StreamPosition) -> Flow {
        self.commands += 1;
        self.bytes += black_box(rgba).len() as u64;
        Flow::Continue
    }
    fn pixel_run(&mut self, _: u16, _: u16, rgba: &[u8], _: StreamPosition) -> Flow {
        self.commands += 1;
        self.bytes += black_box(rgba).len() as u64;
        Flow::Continue
    }
}

/// A sink that draws as a server does: bounds, offset, one store.
struct Frame(Vec<[u8; 4]>);

impl Sink for Frame {
    #[inline]
    fn pixel(&mut self, x: i32, y: i32, color: [u8; 4]) {
        if (x as u32 as usize) < WIDTH
            && let Some(pixel) = self.0.get_mut(y as u32 as usize * WIDTH + x as u32 as usize)
        {
            *pixel = color;
        }
    }
    fn binary_pixels(&mut self, records: &[u8]) {
        for record in records.as_chunks().0 {
            let (x, y, color) = binary_pixel(record);
            self.pixel(x.into(), y.into(), color);
        }
    }
    fn command(&mut self, _: Command, _: StreamPosition) -> Flow {
        Flow::Continue
    }
    fn error(&mut self, _: StreamError) -> Flow {
        Flow::Continue
    }
}

/// A small random number generator, so that the streams are the same on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

struct Case {
    name: &'static str,
    unit: &'static str,
    /// Number of units in the stream.
    units: u64,
    stream: Vec<u8>,
    expected: Sums,
}

fn pixels(
    name: &'static str,
    n: usize,
    random_places: bool,
    mut line: impl FnMut(usize, usize, [u8; 4]) -> (Vec<u8>, [u8; 4]),
) -> Case {
    let mut random = Random(0x1234_5678_9abc_def1);
    let (mut stream, mut expected) = (Vec::new(), Sums::default());
    for i in 0..n {
        let (x, y) = match random_places {
            true => (random.below(WIDTH), random.below(HEIGHT)),
            false => (i % WIDTH, i / WIDTH % HEIGHT),
        };
        let (bytes, color) = line(x, y, (random.next() as u32).to_le_bytes());
        stream.extend(bytes);
        expected.add(x as i32, y as i32, color);
    }
    Case { name, unit: "Mpx/s", units: n as u64, stream, expected }
}

fn hex([r, g, b, _]: [u8; 4]) -> String {
    format!("{r:02x}{g:02x}{b:02x}")
}

fn cases() -> Vec<Case> {
    let opaque = |[r, g, b, _]: [u8; 4]| [r, g, b, 255];
    let n = 100_000;
    let mut cases = vec![
        pixels("text PX rrggbb, random places", n, true, |x, y, c| {
            (format!("PX {x} {y} {}\n", hex(c)).into(), opaque(c))
        }),
        pixels("text PX rrggbb, row by row", n, false, |x, y, c| {
            (format!("PX {x} {y} {}\n", hex(c)).into(), opaque(c))
        }),
        pixels("text PX RRGGBB, random places", n, true, |x, y, c| {
            (format!("PX {x} {y} {}\n", hex(c).to_uppercase()).into(), opaque(c))
        }),
        pixels("text PX rrggbbaa", n, true, |x, y, c| {
            (format!("PX {x} {y} {}{:02x}\n", hex(c), c[3]).into(), c)
        }),
        pixels("text PX gg", n, true, |x, y, c| {
            (format!("PX {x} {y} {:02x}\n", c[0]).into(), [c[0], c[0], c[0], 255])
        }),
        pixels("text PX rrggbb, CR LF", n, true, |x, y, c| {
            (format!("PX {x} {y} {}\r\n", hex(c)).into(), opaque(c))
        }),
        pixels("text PX name (general reader)", n / 4, true, |x, y, _| {
            (format!("PX {x} {y} tomato\n").into(), [255, 99, 71, 255])
        }),
        pixels("binary PB", n, true, |x, y, c| {
            ([b"PB".as_slice(), &(x as u16).to_le_bytes(), &(y as u16).to_le_bytes(), &c].concat(), c)
        }),
    ];
    let mut random = Random(99);
    let mut lines = String::new();
    for _ in 0..20_000 {
        let [a, b, c, d] = std::array::from_fn(|_| random.below(2000));
        lines += &format!("LINE {a} {b} {c} {d} {}\n", hex((random.next() as u32).to_le_bytes()));
    }
    cases.push(Case {
        name: "LINE",
        unit: "M/s",
        units: 20_000,
        stream: lines.into(),
        expected: Sums { commands: 20_000, ..Sums::default() },
    });
    let row = |x: u16| {
        [b"PXMULTI".as_slice(), &x.to_le_bytes(), &[0, 0], &(WIDTH as u32).to_le_bytes(), &vec![7; WIDTH * 4]]
            .concat()
    };
    cases.push(Case {
        name: "PXMULTI rows",
        unit: "Mpx/s",
        units: (WIDTH * HEIGHT) as u64,
        stream: (0..HEIGHT as u16).flat_map(row).collect(),
        expected: Sums { commands: HEIGHT as u64, bytes: (WIDTH * HEIGHT * 4) as u64, ..Sums::default() },
    });
    cases.push(Case {
        name: "BLIT of a frame",
        unit: "Mpx/s",
        units: (WIDTH * HEIGHT) as u64,
        stream: [
            format!("BLIT 0 0 {WIDTH} {HEIGHT} :{}\n", WIDTH * HEIGHT * 4).into_bytes(),
            vec![7; WIDTH * HEIGHT * 4],
        ]
        .concat(),
        expected: Sums { commands: 1, bytes: (WIDTH * HEIGHT * 4) as u64, ..Sums::default() },
    });
    cases
}

/// Decodes a stream in pieces; returns the seconds taken.
fn play(stream: &[u8], pool: &PayloadPool, sink: &mut impl Sink) -> f64 {
    let mut decoder = Decoder::with_payload_pool(Limits::default(), pool);
    let start = Instant::now();
    for piece in stream.chunks(PIECE) {
        assert_eq!(decoder.feed(black_box(piece), sink), Flow::Continue);
    }
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!(decoder.finish(EndOfInput::Stream, sink), Flow::Continue);
    let lf = stream.iter().filter(|&&b| b == b'\n').count() as u64;
    let end = decoder.place();
    assert_eq!((end.line, end.byte), (1 + lf, stream.len() as u64), "the decoder lost count");
    seconds
}

/// Returns the best and the median rate, in millions of units per second.
fn rates(units: u64, mut seconds: Vec<f64>) -> (f64, f64) {
    seconds.sort_by(f64::total_cmp);
    let rate = |s: f64| units as f64 / s / 1e6;
    (rate(seconds[0]), rate(seconds[seconds.len() / 2]))
}

fn main() {
    let pool = PayloadPool::default();
    let filter = std::env::args().skip(1).find(|a| !a.starts_with('-')).unwrap_or_default();
    println!("{:34} {:>9} {:>9}         {:>7}", "one core, from memory", "best", "median", "GB/s");
    for case in cases().iter().filter(|c| c.name.contains(&filter)) {
        let mut seconds = Vec::new();
        for _ in 0..ROUNDS {
            let mut sums = Sums::default();
            seconds.push(play(&case.stream, &pool, &mut sums));
            let e = &case.expected;
            assert_eq!(
                (sums.pixels, sums.hash, sums.commands, sums.bytes, sums.errors),
                (e.pixels, e.hash, e.commands, e.bytes, 0),
                "{}: the decoder read something else",
                case.name
            );
        }
        let (best, median) = rates(case.units, seconds);
        let bytes = best * case.stream.len() as f64 / case.units as f64 / 1e3;
        println!("{:34} {best:9.1} {median:9.1} {:6} {bytes:7.2}", case.name, case.unit);
    }
    if filter.is_empty() || "painting".contains(&filter) {
        for case in &cases()[..2] {
            let mut frame = Frame(vec![[0; 4]; WIDTH * HEIGHT]);
            let seconds = (0..ROUNDS).map(|_| play(&case.stream, &pool, &mut frame)).collect();
            assert!(frame.0.iter().filter(|p| p[3] == 255).count() > 20_000, "nothing was painted");
            let (best, median) = rates(case.units, seconds);
            println!("{:34} {best:9.1} {median:9.1} {:6}", format!("painting: {}", case.name), case.unit);
        }
    }
}

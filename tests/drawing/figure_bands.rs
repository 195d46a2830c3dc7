//! Verifies that figures drawn in bands of rows by several threads are those that one thread draws.
//!
//! Guards against a figure whose rows depend on where a band begins, against bands that overlap or
//! leave out a row, and against rows that are not marked as changed.

use crate::fast_forms::from_env;
use crate::small_draws::of_threads;
use fbptr::draw2d::{self, Arc, Area, AreaColors, Blend, DrawError, Line, RampColor, RealRect};
use fbptr::executor::Executor;
use fbptr::memory::{Rgba, VideoMemory};
use fbptr_engine::{Audience, Budget, Engine, Output, Stream};
use proptest::prelude::*;
use std::ops::Range;
use std::sync::LazyLock;

const SIZE: [u32; 2] = [97, 71];
const BACKGROUND: Rgba = [30, 60, 90, 120];

/// Executors of 1, 2, 3 and 16 threads.
static EXECUTORS: LazyLock<Vec<Executor>> = LazyLock::new(|| {
    let of = |threads| Executor::of_pool(of_threads(threads).options().pool.clone());
    [1, 2, 3, 16].into_iter().map(of).collect()
});

/// Draws an area by the function of its figure.
fn draw_whole(memory: &mut VideoMemory, area: &Area<'_>, blend: Blend) -> Result<(), DrawError> {
    match *area {
        Area::Rect(rect, color) => draw2d::fill_rect(memory, rect, color, blend),
        Area::Disc(centre, r, color) => draw2d::fill_circle(memory, centre, r, color, blend),
        Area::Ellipse(centre, radii, color) => draw2d::fill_ellipse(memory, centre, radii, color, blend),
        Area::WideLine([a, b], width, color) => draw2d::wide_line(memory, a, b, width, color, blend),
        Area::Arc(arc, color) => draw2d::arc(memory, arc, color, blend),
        Area::Curve(points, width, color) => draw2d::bezier(memory, points, width, color, blend),
        Area::Triangle(points, colors) => {
            draw2d::fill(memory, points, colors, blend);
            Ok(())
        }
        Area::Polygon(points, color) => {
            draw2d::fill_poly(memory, points, color, blend);
            Ok(())
        }
        Area::SmoothLine([a, b], color) => {
            draw2d::line_aa(memory, a, b, color);
            Ok(())
        }
    }
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => -60.0..160.0f64,
        4 => (-60..160i32).prop_map(|v| f64::from(v) / 2.0),
        1 => -1e9..1e9f64,
        1 => prop::sample::select(vec![0.0, 1e300, -1e300, 5e-324, f64::NAN, f64::INFINITY]),
    ]
}

fn point() -> impl Strategy<Value = [f64; 2]> {
    [number(), number()]
}

/// Numbers that make any area.
#[derive(Clone, Debug)]
struct Numbers {
    kind: usize,
    points: Vec<[f64; 2]>,
    sizes: [f64; 2],
    colors: [Rgba; 3],
}

impl Numbers {
    fn area(&self) -> Area<'_> {
        let ([a, b, c, d, ..], [s, t], [color, ..]) = (self.points.as_slice(), self.sizes, self.colors)
        else {
            unreachable!("at least four points")
        };
        match self.kind {
            0 => Area::Rect(RealRect { x: a[0], y: a[1], w: s, h: t }, color),
            1 => Area::Disc(*a, s, color),
            2 => Area::Ellipse(*a, [s, t], color),
            3 => Area::Triangle([*a, *b, *c], AreaColors::One(color)),
            4 => Area::Triangle([*a, *b, *c], AreaColors::Three(self.colors)),
            5 => Area::Polygon(&self.points, color),
            6 => Area::WideLine([*a, *b], s, color),
            7 => Area::SmoothLine([*a, *b], color),
            8 => Area::Arc(Arc { center: *a, radii: [s, t], angles: *b }, color),
            _ => Area::Curve([*a, *b, *c, *d], s, color),
        }
    }
}

fn numbers() -> impl Strategy<Value = Numbers> {
    let sizes = [number(), number()].prop_map(|sizes| sizes.map(|v| if v < -50.0 { v } else { v.abs() }));
    let points = prop::collection::vec(point(), 4..12);
    (0..10usize, points, sizes, any::<[Rgba; 3]>()).prop_map(|(kind, points, sizes, colors)| Numbers {
        kind,
        points,
        sizes,
        colors,
    })
}

/// Columns and rows of a clip rectangle.
fn clip() -> impl Strategy<Value = Option<[Range<u32>; 2]>> {
    let range = |side: u32| (0..side, 0..side).prop_map(|(a, b)| a.min(b)..a.max(b) + 1);
    prop::option::of((range(SIZE[0]), range(SIZE[1])).prop_map(|(columns, rows)| [columns, rows]))
}

fn memory(clip: &Option<[Range<u32>; 2]>) -> VideoMemory {
    let mut memory = VideoMemory::new(SIZE[0], SIZE[1]).unwrap();
    memory.clear(BACKGROUND);
    memory.take_damage();
    if let Some([columns, rows]) = clip.clone() {
        memory.set_clip(columns, rows);
    }
    memory
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(from_env("BAND_CASES", 300)))]

    #[test]
    fn areas_in_bands_are_whole_ones(
        numbers in numbers(), clip in clip(), bands in 1..90usize, window in prop::option::of((0..71u32, 0..71u32)),
        is_over in any::<bool>(),
    ) {
        let blend = if is_over { Blend::Over } else { Blend::Replace };
        let area = numbers.area();
        let begun = || {
            let mut memory = memory(&clip);
            if let Some((a, b)) = window {
                memory.set_window(a.min(b)..a.max(b) + 1);
            }
            memory
        };
        let mut want = begun();
        let want_result = draw_whole(&mut want, &area, blend);
        let rows = want.take_damage();
        for executor in EXECUTORS.iter() {
            let mut got = begun();
            let result = area.draw_in_bands(executor, &mut got, bands, blend);
            prop_assert!(got.bytes() == want.bytes(), "{area:?} in {bands} bands");
            prop_assert_eq!(got.take_damage(), rows.clone());
            prop_assert_eq!(&result, &want_result);
        }
    }

    #[test]
    fn lists_of_areas_are_drawn_in_their_order(
        all in prop::collection::vec(numbers(), 1..9), clip in clip(), band_rows in 1..80u32, is_over in any::<bool>(),
    ) {
        let blend = if is_over { Blend::Over } else { Blend::Replace };
        let mut want = memory(&clip);
        // Many times, so that it is worth threads.
        let all: Vec<_> = all.iter().cycle().take(400).collect();
        for numbers in &all {
            // One that is refused draws nothing.
            let _ = draw_whole(&mut want, &numbers.area(), blend);
        }
        for executor in EXECUTORS.iter() {
            let mut got = memory(&clip);
            if draw2d::areas_on(executor, &mut got, &all, band_rows, blend, |n| Some((0..SIZE[1], n.area()))) {
                prop_assert!(got.bytes() == want.bytes());
            }
        }
    }

    #[test]
    fn lines_within_a_clip_rectangle_are_those_of_one_thread(
        ends in prop::collection::vec([-40..140i32, -40..110, -40..140, -40..110], 1..40),
        colors in any::<[Rgba; 2]>(), clip in clip(), is_over in any::<bool>(),
    ) {
        let blend = if is_over { Blend::Over } else { Blend::Replace };
        let line = |(i, e): (usize, &[i32; 4])| {
            let to = (i % 3 == 0).then_some(colors[1]);
            Line { p0: [e[0], e[1]], p1: [e[2], e[3]], color: RampColor { from: colors[0], to } }
        };
        // So many that threads are worth it.
        let lines: Vec<_> = ends.iter().cycle().take(3500).enumerate().map(line).collect();
        let mut want = memory(&clip);
        lines.iter().for_each(|line| draw2d::line(&mut want, line.p0, line.p1, line.color, blend));
        for executor in EXECUTORS.iter() {
            let mut got = memory(&clip);
            draw2d::lines_on(executor, &mut got, &lines, blend);
            prop_assert!(got.bytes() == want.bytes());
            prop_assert_eq!(got.take_damage(), want.clone().take_damage());
        }
    }
}

/// Draws a stream of large figures on an engine of so many threads.
fn played(threads: usize, stream: &str) -> Vec<u8> {
    let mut engine = Engine::new(1100, 700).unwrap();
    engine.set_renderer(of_threads(threads));
    let mut out = Output::default();
    let _ =
        Stream::new(&engine, 1, Audience::Owner).feed(&mut engine, stream.as_bytes(), &mut out, Budget::NONE);
    assert!(out.notices.is_empty(), "{:?}", out.notices);
    engine.memory().bytes().to_vec()
}

#[test]
fn streams_of_large_figures_have_the_same_bytes_with_any_number_of_threads() {
    let alone = "BLEND over
FILL -500 0 1600 -80 400 1500 ff000080 00ff0080 0000ff40
FILLPOLY 10c0f080 550 5 900 690 20 260 1080 255 200 690
CLIP 30 40 1000 600
FILLELLIPSE 500 300 520 340 ffffff30
WIDELINE 20 30 1070 660 200 80402080
LINEAA 3 5 1090 690 ffff00
ARC 550 350 100 340 0.3 5.5 20f02090
BEZIER 20 600 300 -200 700 900 1080 30 120 f0404060
CLIP off
";
    let together: String = (0..30)
        .map(|i| format!("FILLCIRCLE {} {} 300 {:02x}40{:02x}60\n", 40 * i, 350 + i, 8 * i, 255 - 8 * i))
        .chain((0..9).map(|i| format!("FILLRECT {} {} 700 500 20{:02x}ff70\n", 50 * i, 20 * i, 28 * i)))
        .collect();
    for stream in [alone.to_owned(), together.clone(), format!("{alone}{together}")] {
        let want = played(1, &stream);
        for threads in [2, 3, 16] {
            assert!(played(threads, &stream) == want, "{threads} threads");
        }
    }
}

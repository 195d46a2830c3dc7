//! Whole pictures beside the renderer's: a page of lines, and the tesseract.

use super::super::clock::Work;
use super::super::experiment::{Bound, Effort, Row, Standing};
use super::super::eye::two_tesseracts;
use super::super::lines::area;
use super::compared::{Compared, Range};
use super::{LARGEST, compared_pixels};
use fbptr_core::draw2d::{self, Blend, RampColor};
use fbptr_core::executor::Executor;
use fbptr_core::eye::{EyePicture, Fibre, render_with};
use fbptr_core::memory::VideoMemory;
use fbptr_truth::DoubleDouble;
use fbptr_truth::eye::see;
use fbptr_truth::scenes::Random;

/// Colour of the lines.
const WHITE: [u8; 4] = [255; 4];

type Draw = fn(&mut VideoMemory, [i32; 2], [i32; 2]);

/// Returns the rows of a page of lines, drawn by `LINE` and by `LINEAA`.
pub(super) fn page_of_lines(effort: &Effort) -> Vec<Row> {
    let (width, height) = effort.pick((320u32, 240u32), (640, 480));
    let count = effort.pick(200, 800);
    let mut r = Random::new(1965);
    let mut end = || [r.below(width) as i32, r.below(height) as i32];
    let segments: Vec<[[i32; 2]; 2]> = (0..count).map(|_| [end(), end()]).collect();
    let (compared, most_lines) = lines_truth(effort, width, height, &segments);
    let aliased: Draw = |memory, p0, p1| {
        draw2d::line(memory, p0, p1, RampColor { from: WHITE, to: None }, Blend::Replace);
    };
    let smooth: Draw = |memory, p0, p1| draw2d::line_aa(memory, p0.map(f64::from), p1.map(f64::from), WHITE);
    // Coverage and composition are each rounded to the nearest step, for each line over a pixel.
    let because = "a step for each line over the pixel: coverage and composition are rounded once each";
    let rounded = Bound { column: LARGEST, at_most: most_lines as f64, because };
    let ways =
        [("LINE", aliased, Standing::Mode, Vec::new()), ("LINEAA", smooth, Standing::Mode, vec![rounded])];
    let subject = format!("page of {count} lines");
    let mut memories = ways.each_ref().map(|_| VideoMemory::new(width, height).expect("a small frame"));
    let mut works: Vec<Work<()>> = Vec::new();
    for ((_, draw, ..), memory) in ways.iter().zip(&mut memories) {
        let segments = &segments;
        works.push(Box::new(move || {
            memory.clear(VideoMemory::CLEAR);
            std::hint::black_box(segments).iter().for_each(|&[p0, p1]| draw(memory, p0, p1));
        }));
    }
    let timings = effort.run_in_turns(works);
    let mut rows = Vec::new();
    for (((name, _, standing, bounds), memory), ((), timing)) in ways.into_iter().zip(&memories).zip(timings)
    {
        let found = compared.of_bytes(memory.bytes());
        let row = compared.judged(effort, (&subject, name, standing), bounds, &found);
        rows.push(row.timed(timing, f64::from(width * height)));
    }
    rows
}

/// Returns compared pixels of the page, each with the colour of all lines one over the other, and
/// the largest number of lines over one of them. Half of the pixels lie on a line.
fn lines_truth(effort: &Effort, width: u32, height: u32, segments: &[[[i32; 2]; 2]]) -> (Compared, usize) {
    let mut r = Random::new(1974);
    let pixel = |i: usize| {
        if i.is_multiple_of(2) {
            return [r.below(width), r.below(height)];
        }
        let [p0, p1] = segments[i % segments.len()];
        let t = r.real(0.0, 1.0);
        [0, 1].map(|k| libm::round(f64::from(p0[k]) + t * f64::from(p1[k] - p0[k])) as u32)
    };
    let pixels: Vec<[u32; 2]> = (0..compared_pixels(effort)).map(pixel).collect();
    let mut most_lines = 0;
    let color = |&[x, y]: &[u32; 2]| -> Vec<Range> {
        let areas = segments.iter().map(|&[p0, p1]| area(p0, p1, x as i32, y as i32)).filter(|a| *a > 0.0);
        let (mut dark, mut lines) = (1.0, 0);
        for area in areas {
            (dark, lines) = (dark * (1.0 - area), lines + 1);
        }
        most_lines = most_lines.max(lines);
        vec![[[255.0 * (1.0 - dark); 2]; 3]]
    };
    let accepted = pixels.iter().map(color).collect();
    (Compared::new(width, pixels, accepted), most_lines)
}

/// Returns the rows of two tesseracts, seen exactly and by fans of rays.
pub(super) fn tesseract(effort: &Effort) -> Vec<Row> {
    let size = effort.pick([96, 72], [320, 240]);
    let scene = two_tesseracts(size);
    let mut r = Random::new(1888);
    let places: Vec<usize> =
        (0..effort.pick(64, 256)).map(|_| r.below(scene.pixel_count() as u32) as usize).collect();
    let truth = see::<DoubleDouble>(&scene, places.iter().copied());
    let accepted: Vec<Vec<Range>> = truth.iter().map(|s| vec![s.color.map(|c| [c; 2])]).collect();
    let pixels = places.iter().map(|i| [*i as u32, 0]).collect();
    let compared = Compared::new(scene.pixel_count() as u32, pixels, accepted);
    let because = "exact fibres: the colour falls by less than 255 a unit of distance, 12 digits";
    let exact = Bound { column: LARGEST, at_most: 255.0 * 1e-11, because };
    let ways = [
        ("exact fibres", Fibre::Exact, Standing::Default, vec![exact]),
        ("fan of 3 rays", Fibre::Fan(3), Standing::Mode, Vec::new()),
        ("fan of 9 rays", Fibre::Fan(9), Standing::Mode, Vec::new()),
        ("fan of 33 rays", Fibre::Fan(33), Standing::Mode, Vec::new()),
        ("fan of 129 rays", Fibre::Fan(129), Standing::Mode, Vec::new()),
    ];
    let draw = |fibre| render_with(&scene, fibre, &Executor::default()).expect("fans of at most 129 rays");
    let work = |&(_, fibre, ..): &(_, Fibre, _, _)| Box::new(move || draw(fibre)) as Work<EyePicture>;
    let drawn = effort.run_in_turns(ways.iter().map(work).collect());
    let mut rows = Vec::new();
    for ((name, _, standing, bounds), (picture, timing)) in ways.into_iter().zip(drawn) {
        let found: Vec<[f64; 3]> = places.iter().map(|i| picture.color[*i]).collect();
        let row = compared.judged(effort, ("two tesseracts, 4-D on a plane", name, standing), bounds, &found);
        rows.push(row.timed(timing, scene.pixel_count() as f64));
    }
    rows
}

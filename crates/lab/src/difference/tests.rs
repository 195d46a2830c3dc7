//! Causes that are put into a picture come out again, and their controls do not.

use super::{Class, Geometry, Shape, Surface, WrongPixels};
use fbptr_core::draw2d::{self, AreaColors, Blend};
use fbptr_core::memory::{Rgba, VideoMemory};

const RED: Rgba = [255, 0, 0, 255];
const BLUE: Rgba = [0, 0, 255, 255];
const SIZE: [u32; 2] = [64, 48];

fn memory() -> VideoMemory {
    VideoMemory::new(SIZE[0], SIZE[1]).unwrap()
}

fn no_surface(_: u64, _: [u32; 2]) -> Option<Surface> {
    None
}

fn compare(mine: &VideoMemory, exact: &VideoMemory, shapes: &[Shape]) -> WrongPixels {
    let geometry = Geometry { shapes: shapes.to_vec(), surface: &no_surface, is_complete: true };
    let d = WrongPixels::new(mine, exact, 0, Some(&geometry));
    check(&d);
    d
}

fn pictures(mine: &VideoMemory, exact: &VideoMemory) -> WrongPixels {
    let d = WrongPixels::new(mine, exact, 0, None);
    check(&d);
    d
}

/// Every wrong pixel is in one class, and the texts say something.
fn check(d: &WrongPixels) {
    assert_eq!(d.findings.iter().map(|f| f.pixels).sum::<u64>(), d.wrong, "{d}");
    assert!(d.findings.iter().all(|f| !f.text.is_empty() && !f.examples.is_empty()), "{d}");
    assert_eq!(d.is_equal(), d.findings.is_empty());
}

/// Returns the only class.
#[track_caller]
fn only(d: &WrongPixels, class: Class) {
    assert_eq!(d.findings.iter().map(|f| f.class).collect::<Vec<_>>(), [class], "{d}");
}

fn line(ends: [[i32; 2]; 2], color: Rgba) -> (VideoMemory, Shape) {
    let mut exact = memory();
    draw2d::line(&mut exact, ends[0], ends[1], color.into(), Blend::Replace);
    (exact, Shape::Line { ends, colors: Some([color; 2]), is_blended: false })
}

fn face(corners: [[f64; 2]; 3], color: Rgba) -> Shape {
    Shape::Face { corners, color: Some(color), is_blended: false, number: None }
}

/// A picture without symmetry: two faces of different colours and a ramp.
fn motif() -> VideoMemory {
    let mut m = memory();
    draw2d::fill(&mut m, [[14.0, 10.0], [44.0, 14.0], [20.0, 34.0]], AreaColors::One(RED), Blend::Replace);
    let colors = [[10, 80, 30, 255], [200, 120, 60, 255], [90, 240, 150, 255]];
    draw2d::fill(
        &mut m,
        [[30.0, 20.0], [52.0, 24.0], [40.0, 40.0]],
        AreaColors::Three(colors),
        Blend::Replace,
    );
    m
}

fn moved(m: &VideoMemory, source: impl Fn(i32, i32) -> (i32, i32)) -> VideoMemory {
    let mut out = memory();
    for y in 0..SIZE[1] as i32 {
        for x in 0..SIZE[0] as i32 {
            let (sx, sy) = source(x, y);
            if let Ok(color) = m.get_pixel(sx, sy) {
                out.put_pixel(x, y, color);
            }
        }
    }
    out
}

#[test]
fn equal_pictures_and_other_sizes() {
    let d = pictures(&motif(), &motif());
    assert!(d.is_equal() && d.to_string().starts_with("equal"), "{d}");
    let d = WrongPixels::new(&motif(), &VideoMemory::new(5, 4).unwrap(), 0, None);
    assert!(!d.is_equal());
    assert_eq!(d.to_string(), "the picture has 64x48 pixels, the exact one 5x4\n");
}

#[test]
fn outside_the_ideal_line() {
    // y = x 13/50: truncation draws up to one pixel off where rounding is right.
    let (exact, shape) = line([[2, 5], [52, 18]], RED);
    let mut mine = memory();
    (0..=50).for_each(|k| mine.put_pixel(2 + k, 5 + k * 13 / 50, RED));
    let d = compare(&mine, &exact, std::slice::from_ref(&shape));
    only(&d, Class::OutsideLine);
    assert!(d.findings[0].text.contains("by 0.98 pixel"), "{d}");
    assert!(d.findings[0].text.contains("the line from (2, 5) to (52, 18)"), "{d}");
    // Along y, too.
    let (exact, shape) = line([[5, 40], [18, 2]], RED);
    let mut mine = memory();
    (0..=38).for_each(|k| mine.put_pixel(5 + k * 13 / 38, 40 - k, RED));
    only(&compare(&mine, &exact, &[shape]), Class::OutsideLine);
}

#[test]
fn a_tie_is_right_either_way_and_a_neighbour_that_is_none_is_not() {
    // At x = 5 the ideal line passes midway: y = 2.5.
    let (mut exact, shape) = line([[0, 0], [10, 5]], RED);
    let mut mine = memory();
    draw2d::line(&mut mine, [0, 0], [10, 5], RED.into(), Blend::Replace);
    for k in [1, 3, 5] {
        let at = [k / 2, k / 2 + 1].map(|y| mine.get_pixel(k, y).unwrap() == RED);
        let (old, new) = if at[0] { (k / 2, k / 2 + 1) } else { (k / 2 + 1, k / 2) };
        mine.put_pixel(k, old, [0, 0, 0, 255]);
        mine.put_pixel(k, new, RED);
    }
    // The memory begins transparent or opaque: the same background on both.
    let background = exact.get_pixel(0, 40).unwrap();
    (0..48).flat_map(|y| (0..64).map(move |x| (x, y))).for_each(|(x, y)| {
        for m in [&mut mine, &mut exact] {
            if m.get_pixel(x, y).unwrap() != RED {
                m.put_pixel(x, y, background);
            }
        }
    });
    let d = compare(&mine, &exact, std::slice::from_ref(&shape));
    assert!(d.is_equal() && d.ties == 6, "{d}");
    assert!(d.to_string().contains("6 more differ and are right"), "{d}");
    // So is one in a colour that may differ.
    let mut near = mine.clone();
    for y in [2, 3] {
        if near.get_pixel(5, y).unwrap() == RED {
            near.put_pixel(5, y, [254, 0, 0, 255]);
        }
    }
    let geometry = Geometry { shapes: vec![shape.clone()], surface: &no_surface, is_complete: true };
    let d = WrongPixels::new(&near, &exact, 1, Some(&geometry));
    assert!(d.is_equal() && d.ties == 6, "{d}");
    // Both pixels of a tie are one too many.
    mine.put_pixel(5, 2, RED);
    mine.put_pixel(5, 3, RED);
    let d = compare(&mine, &exact, &[shape]);
    assert_eq!(d.wrong, 1, "{d}");
}

#[test]
fn missing_at_the_end_and_a_gap() {
    let (exact, shape) = line([[2, 5], [52, 18]], RED);
    let background = exact.get_pixel(0, 40).unwrap();
    let mut mine = exact.clone();
    mine.put_pixel(52, 18, background);
    only(&compare(&mine, &exact, std::slice::from_ref(&shape)), Class::MissingAtEnd);
    mine.put_pixel(51, exact_row(&exact, 51), background);
    mine.put_pixel(2, 5, background);
    let d = compare(&mine, &exact, std::slice::from_ref(&shape));
    only(&d, Class::MissingAtEnd);
    assert_eq!(d.wrong, 3);
    let mut mine = exact.clone();
    mine.put_pixel(20, exact_row(&exact, 20), background);
    only(&compare(&mine, &exact, &[shape]), Class::GapInLine);
}

#[test]
fn a_whole_line_is_missing() {
    let ends = [[[2, 5], [52, 18]], [[52, 18], [30, 40]], [[8, 40], [9, 40]]];
    let mut mine = memory();
    draw2d::line(&mut mine, ends[0][0], ends[0][1], RED.into(), Blend::Replace);
    let mut exact = mine.clone();
    ends[1..].iter().for_each(|[a, b]| draw2d::line(&mut exact, *a, *b, RED.into(), Blend::Replace));
    let shapes = ends.map(|ends| Shape::Line { ends, colors: Some([RED; 2]), is_blended: false });
    // The end that both have is lit.
    let d = compare(&mine, &exact, &shapes);
    only(&d, Class::MissingLine);
    assert!(
        d.wrong == 24 && d.to_string().contains("a whole line is missing: the line from (52, 18)"),
        "{d}"
    );
}

fn exact_row(exact: &VideoMemory, x: i32) -> i32 {
    (0..48).find(|y| exact.get_pixel(x, *y).unwrap() == RED).unwrap()
}

#[test]
fn a_circle_that_is_off() {
    let mut exact = memory();
    draw2d::circle(&mut exact, [30, 24], 15, RED, Blend::Replace).unwrap();
    let shape = Shape::Circle { center: [30, 24], radius: 15, color: RED, is_blended: false };
    let mut mine = memory();
    for k in 0..720 {
        let (s, c) = (f64::from(k) * std::f64::consts::PI / 360.0).sin_cos();
        mine.put_pixel((30.0 + 15.0 * c) as i32, (24.0 + 15.0 * s) as i32, RED);
    }
    let d = compare(&mine, &exact, &[shape]);
    assert!(d.count(Class::OutsideLine) * 10 >= d.wrong * 9, "{d}");
}

#[test]
fn a_ramp_of_another_place() {
    let ends = [[2, 5], [52, 18]];
    let ramp = draw2d::RampColor { from: RED, to: Some(BLUE) };
    let (mut exact, mut mine) = (memory(), memory());
    draw2d::line(&mut exact, ends[0], ends[1], ramp, Blend::Replace);
    draw2d::line(
        &mut mine,
        ends[0],
        ends[1],
        draw2d::RampColor { from: BLUE, to: Some(RED) },
        Blend::Replace,
    );
    let shape = Shape::Line { ends, colors: Some([RED, BLUE]), is_blended: false };
    only(&compare(&mine, &exact, &[shape]), Class::Ramp);
}

#[test]
fn a_square_of_two_triangles_blended_twice_on_its_seam() {
    let half = [0, 0, 255, 128];
    let corners = [[[4.0, 4.0], [40.0, 4.0], [40.0, 40.0]], [[4.0, 4.0], [40.0, 40.0], [4.0, 40.0]]];
    let mut exact = memory();
    exact.clear([90, 60, 30, 255]);
    corners.iter().for_each(|c| draw2d::fill(&mut exact, *c, half.into(), Blend::Over));
    let mut mine = exact.clone();
    (4..40).for_each(|i| draw2d::put_pixel(&mut mine, i, i, half, Blend::Over));
    let shape =
        |c: &[[f64; 2]; 3]| Shape::Face { corners: *c, color: Some(half), is_blended: true, number: None };
    let shapes: Vec<Shape> = corners.iter().map(shape).collect();
    let d = compare(&mine, &exact, &shapes);
    only(&d, Class::CountedTwice);
    assert_eq!(d.wrong, 36);
    // An opaque face is never counted twice.
    let opaque: Vec<Shape> = corners.iter().map(|c| face(*c, BLUE)).collect();
    assert_eq!(compare(&mine, &exact, &opaque).count(Class::CountedTwice), 0);
}

#[test]
fn edge_pixels_by_the_fill_rule() {
    // Both triangles have the pixels whose centres lie on the diagonal on their edge.
    let corners = [[[4.0, 4.0], [40.0, 4.0], [40.0, 40.0]], [[4.0, 4.0], [40.0, 40.0], [4.0, 40.0]]];
    let mut exact = memory();
    draw2d::fill(&mut exact, corners[0], RED.into(), Blend::Replace);
    draw2d::fill(&mut exact, corners[1], BLUE.into(), Blend::Replace);
    let mut mine = exact.clone();
    let other = |c: Rgba| if c == RED { BLUE } else { RED };
    (4..40).for_each(|i| mine.put_pixel(i, i, other(exact.get_pixel(i, i).unwrap())));
    let d = compare(&mine, &exact, &[face(corners[0], RED), face(corners[1], BLUE)]);
    only(&d, Class::Edge);
    assert!(d.findings[0].text.contains("the centre of 36 lies on the edge itself"), "{d}");
    only(&pictures(&mine, &exact), Class::Edge);
    // A pixel in the middle of a face is no edge pixel.
    let mut mine = exact.clone();
    mine.put_pixel(30, 10, BLUE);
    only(&compare(&mine, &exact, &[face(corners[0], RED)]), Class::Other);
    only(&pictures(&mine, &exact), Class::Other);
}

#[test]
fn an_upright_box_with_the_wrong_rule_is_not_a_shift() {
    let corners = [[[4.5, 4.5], [20.5, 4.5], [20.5, 20.5]], [[4.5, 4.5], [20.5, 20.5], [4.5, 20.5]]];
    let mut exact = memory();
    corners.iter().for_each(|c| draw2d::fill(&mut exact, *c, RED.into(), Blend::Replace));
    let mine = moved(&exact, |x, y| (x - 1, y - 1));
    let shapes = corners.map(|c| face(c, RED));
    only(&compare(&mine, &exact, &shapes), Class::Edge);
    only(&pictures(&mine, &exact), Class::Whole);
}

#[test]
fn a_picture_of_almost_nothing_is_not_a_shift() {
    let mut exact = memory();
    let corners = [[10.0, 8.0], [40.0, 8.0], [24.0, 40.0]];
    draw2d::fill(&mut exact, corners, RED.into(), Blend::Replace);
    let mut mine = memory();
    mine.put_pixel(1, 1, RED);
    assert_eq!(pictures(&mine, &exact).count(Class::Whole), 0);
    let mine = moved(&exact, |x, y| (x - 9, y + 6));
    only(&pictures(&mine, &exact), Class::Whole);
}

#[test]
fn another_face_in_front() {
    let near = [[10.0, 8.0], [40.0, 8.0], [24.0, 40.0]];
    let far = [[16.0, 6.0], [50.0, 30.0], [12.0, 36.0]];
    let (mut exact, mut mine) = (memory(), memory());
    for (first, second, m) in [((far, BLUE), (near, RED), &mut exact), ((near, RED), (far, BLUE), &mut mine)]
    {
        draw2d::fill(m, first.0, first.1.into(), Blend::Replace);
        draw2d::fill(m, second.0, second.1.into(), Blend::Replace);
    }
    let number = |n| Some(n);
    let shape = |corners, n| Shape::Face { corners, color: None, is_blended: false, number: number(n) };
    let surface = |n: u64, _: [u32; 2]| {
        Some(Surface { color: if n == 0 { RED } else { BLUE }, opacity: 1.0, z: 0.25 + n as f64 / 2.0 })
    };
    let geometry =
        Geometry { shapes: vec![shape(near, 0), shape(far, 1)], surface: &surface, is_complete: true };
    let d = WrongPixels::new(&mine, &exact, 0, Some(&geometry));
    check(&d);
    only(&d, Class::OtherFace);
    assert!(d.findings[0].text.contains("triangle 1 at ("), "{d}");
    // A colour that no face has there is not another face's.
    let mut mine = exact.clone();
    mine.put_pixel(24, 20, [1, 2, 3, 255]);
    let d = WrongPixels::new(&mine, &exact, 0, Some(&geometry));
    only(&d, Class::Other);
}

#[test]
fn colours_by_a_law() {
    let exact = motif();
    let with = |f: &dyn Fn(f64) -> f64| {
        let mut m = exact.clone();
        for p in m.bytes_mut().as_chunks_mut::<4>().0.iter_mut().filter(|p| p[..3] != [0; 3]) {
            (0..3).for_each(|c| p[c] = f(f64::from(p[c])).round().clamp(0.0, 255.0) as u8);
        }
        m
    };
    let cases: [(VideoMemory, &str); 3] = [
        (with(&|v| v * 0.8), "a factor: 0.80"),
        (with(&|v| v + 20.0), "a summand: 20"),
        (with(&|v| 255.0 * (v / 255.0).powf(1.0 / 2.2)), "a power: 255 (c/255)^0.45"),
    ];
    for (mine, words) in cases {
        let d = pictures(&mine, &exact);
        assert!(d.count(Class::ColorLaw) * 10 >= d.wrong * 9, "{d}");
        assert!(d.to_string().contains(words), "{words}: {d}");
    }
    let mut mine = exact.clone();
    mine.bytes_mut().as_chunks_mut::<4>().0.iter_mut().for_each(|p| p.swap(0, 2));
    let d = pictures(&mine, &exact);
    assert!(d.to_string().contains("red and blue are exchanged"), "{d}");
    // Colours at random follow no law.
    let mut mine = exact.clone();
    let mut seed = 1u32;
    for p in mine.bytes_mut().as_chunks_mut::<4>().0.iter_mut().filter(|p| p[..3] != [0; 3]) {
        p[..3].iter_mut().for_each(|v| {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *v = (seed >> 24) as u8;
        });
    }
    let d = pictures(&mine, &exact);
    assert_eq!((d.count(Class::ColorLaw), d.count(Class::Whole)), (0, 0), "{d}");
}

#[test]
fn whole_pictures() {
    let (exact, [w, h]) = (motif(), SIZE.map(|v| v as i32));
    let moves: [(VideoMemory, &str); 6] = [
        (moved(&exact, |x, y| (x, h - 1 - y)), "upside down"),
        (moved(&exact, |x, y| (w - 1 - x, y)), "mirrored"),
        (moved(&exact, |x, y| (w - 1 - x, h - 1 - y)), "180 degrees"),
        (moved(&exact, |x, y| (x - 1, y)), "by pixels: 1 to the right;"),
        (moved(&exact, |x, y| (x + 7, y - 6)), "by pixels: 7 to the left and 6 to the bottom;"),
        (
            moved(&exact, |x, y| {
                let from = |v: i32, side: i32| {
                    let middle = f64::from(side) / 2.0;
                    ((f64::from(v) + 0.5 - middle) / 0.75 + middle).floor() as i32
                };
                (from(x, w), from(y, h))
            }),
            "scaled by 0.7",
        ),
    ];
    for (mine, words) in moves {
        let d = pictures(&mine, &exact);
        only(&d, Class::Whole);
        assert!(d.to_string().contains(words), "{words}: {d}");
    }
}

#[test]
fn extra_and_missing_pixels_and_the_outputs() {
    let exact = motif();
    let background = exact.get_pixel(0, 0).unwrap();
    let mut mine = exact.clone();
    mine.put_pixel(3, 3, [7, 200, 7, 255]);
    mine.put_pixel(22, 20, background);
    let d = pictures(&mine, &exact);
    assert_eq!((d.wrong, d.count(Class::Extra), d.count(Class::Missing)), (2, 1, 1), "{d}");
    let json = d.json();
    assert_eq!(json["wrong"], 2);
    assert_eq!(json["findings"][0]["class"], "extra");
    assert_eq!(json["findings"][0]["first"][0], serde_json::json!([3, 3]));
    let page = d.page(["a<b.png", "exact.png"]);
    assert!(page.contains("a&lt;b.png") && page.matches("<img").count() == 3 + 4, "{}", page.len());
}

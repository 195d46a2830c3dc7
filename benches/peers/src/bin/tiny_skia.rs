//! The figures of `fbptr bench 2d` on tiny-skia, for `two_d.py`.
//!
//! In: `tiny_skia STREAM FRAMES PICTURE [read]`, a stream that `fbptr bench 2d --export` wrote. Out: the least
//! processor milliseconds of a frame on stdout, with paints, paths and pictures made before, and the
//! picture as RGBA bytes. Status 2 if tiny-skia has no such figure. Anti-aliased lines are smooth, all
//! else is filled by centres of pixels, as its definitions and those of fbptr say. With `read` the
//! pixels of pictures are read from the stream's file in each frame.

use rustix::time::{ClockId, clock_gettime};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::process::exit;
use tiny_skia::*;

const SIZE: [u32; 2] = [1920, 1080];

/// A figure with everything that drawing it needs.
enum Figure {
    Fill(Path, Paint<'static>),
    Stroke(Path, Stroke, Paint<'static>),
    Rect(Rect, Paint<'static>),
    Picture(i32, i32, Pixmap),
}

fn paint(word: &str, anti_alias: bool) -> Paint<'static> {
    let byte = |i: usize| word.get(2 * i..2 * i + 2).map_or(255, |hex| u8::from_str_radix(hex, 16).expect("hex"));
    let mut paint = Paint { anti_alias, ..Paint::default() };
    paint.set_color_rgba8(byte(0), byte(1), byte(2), byte(3));
    paint
}

fn polygon(numbers: &[f32]) -> Path {
    let mut path = PathBuilder::new();
    for (i, point) in numbers.chunks_exact(2).enumerate() {
        if i == 0 { path.move_to(point[0], point[1]) } else { path.line_to(point[0], point[1]) }
    }
    path.close();
    path.finish().expect("a polygon")
}

fn line(n: &[f32], shift: f32, width: f32, paint: Paint<'static>) -> Figure {
    let mut path = PathBuilder::new();
    path.move_to(n[0] + shift, n[1] + shift);
    path.line_to(n[2] + shift, n[3] + shift);
    let line_cap = if width > 1.0 { LineCap::Round } else { LineCap::Butt };
    Figure::Stroke(path.finish().expect("a line"), Stroke { width, line_cap, ..Stroke::default() }, paint)
}

/// Reads a figure; `pixels` follow the line. `None` if it is no figure that tiny-skia has.
fn figure(words: &[&str], pixels: &[u8]) -> Option<Figure> {
    let (verb, words) = words.split_first()?;
    let (colors, words): (Vec<&str>, Vec<&str>) = match *verb {
        "FILLPOLY" => words.iter().partition(|word| **word == words[0]),
        "BLIT" => (vec!["000000"], words[..4].to_vec()),
        "FILL" => (words[6..].to_vec(), words[..6].to_vec()),
        "LINE" | "LINEAA" | "FILLRECT" => (words[4..].to_vec(), words[..4].to_vec()),
        "WIDELINE" => (words[5..].to_vec(), words[..5].to_vec()),
        "FILLCIRCLE" => (words[3..].to_vec(), words[..3].to_vec()),
        _ => return None,
    };
    let numbers: Vec<f32> = words.iter().map(|word| word.parse().expect("a number")).collect();
    let n = &numbers[..];
    if colors.len() > 1 {
        return None;
    }
    let paint = paint(colors[0], *verb == "LINEAA");
    Some(match *verb {
        "FILLRECT" => Figure::Rect(Rect::from_xywh(n[0], n[1], n[2], n[3])?, paint),
        "FILLCIRCLE" => Figure::Fill(PathBuilder::from_circle(n[0], n[1], n[2])?, paint),
        "FILL" | "FILLPOLY" => Figure::Fill(polygon(n), paint),
        "LINE" => line(n, 0.5, 0.0, paint),
        "LINEAA" => line(n, 0.5, 1.0, paint),
        "WIDELINE" => line(n, 0.0, n[4], paint),
        _ => {
            let size = IntSize::from_wh(n[2] as u32, n[3] as u32)?;
            Figure::Picture(n[0] as i32, n[1] as i32, Pixmap::from_vec(pixels.to_vec(), size)?)
        }
    })
}

fn figures(mut stream: &[u8]) -> Vec<Figure> {
    let mut found = Vec::new();
    while let Some(lf) = stream.iter().position(|&byte| byte == b'\n') {
        let line = std::str::from_utf8(&stream[..lf]).expect("a line of text");
        stream = &stream[lf + 1..];
        let words: Vec<&str> = line.split(' ').collect();
        let length = words.last().and_then(|word| word.strip_prefix(':')).map_or(0, |n| n.parse().expect("a length"));
        let (pixels, rest) = stream.split_at(length);
        stream = rest;
        match figure(&words, pixels) {
            Some(figure) => found.push(figure),
            None if matches!(words[0], "PRINT" | "FILL") => exit(2),
            None => {}
        }
    }
    found
}

fn draw(frame: &mut Pixmap, figures: &[Figure]) {
    let place = Transform::identity();
    for figure in figures {
        match figure {
            Figure::Rect(rect, paint) => frame.fill_rect(*rect, paint, place, None),
            Figure::Fill(path, paint) => frame.fill_path(path, paint, FillRule::EvenOdd, place, None),
            Figure::Stroke(path, stroke, paint) => frame.stroke_path(path, paint, stroke, place, None),
            Figure::Picture(x, y, picture) => {
                let paint = PixmapPaint { blend_mode: BlendMode::Source, ..PixmapPaint::default() };
                frame.draw_pixmap(*x, *y, picture.as_ref(), &paint, place, None);
            }
        }
    }
}

/// Draws pictures, each of which is read before.
fn read_and_draw(frame: &mut Pixmap, figures: &mut [Figure], file: &mut BufReader<File>) -> std::io::Result<()> {
    file.rewind()?;
    let mut line = Vec::new();
    for figure in figures {
        line.clear();
        file.read_until(b'\n', &mut line)?;
        if let Figure::Picture(_, _, picture) = figure {
            file.read_exact(picture.data_mut())?;
        }
        draw(frame, std::slice::from_ref(figure));
    }
    Ok(())
}

/// Returns the processor time of this process in milliseconds.
fn processor_ms() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 / 1e6
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let [_, stream, frames, picture, read @ ..] = &words[..] else { panic!("tiny_skia STREAM FRAMES PICTURE [read]") };
    let mut figures = figures(&std::fs::read(stream).expect("the stream"));
    let mut file = (!read.is_empty()).then(|| BufReader::new(File::open(stream).expect("the stream")));
    let mut frame = Pixmap::new(SIZE[0], SIZE[1]).expect("a frame");
    let mut least = f64::INFINITY;
    for _ in 0..frames.parse::<u32>().expect("a number of frames") {
        frame.fill(Color::BLACK);
        let begun = processor_ms();
        match &mut file {
            Some(file) => read_and_draw(&mut frame, &mut figures, file).expect("the stream"),
            None => draw(&mut frame, &figures),
        }
        least = least.min(processor_ms() - begun);
    }
    std::fs::write(picture, frame.data()).expect("the picture");
    println!("{least}");
}

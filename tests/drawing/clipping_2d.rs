//! Verifies that a clipped figure lights the same pixels as the unclipped one.
//!
//! Every verb is drawn into a small frame and, moved by whole pixels, into a large one that holds
//! the small one as a window. The window must hold the same bytes, and nothing else may change when
//! the frame is one pixel wide.

use fbptr::draw2d::{self, AreaColors, Blend, RampColor, RealRect, Rect};
use fbptr::memory::{Rgba, VideoMemory};
use proptest::prelude::*;

const BACKGROUND: Rgba = [30, 60, 90, 120];

/// One figure, in coordinates of the small frame.
#[derive(Clone, Debug)]
enum Figure {
    Line([i32; 2], [i32; 2], RampColor),
    Triangle([[i32; 2]; 3], AreaColors),
    Fill([[f64; 2]; 3], AreaColors),
    Rect(Rect, Rgba),
    FillRect(RealRect, Rgba),
    Circle([i32; 2], i32, Rgba),
    FillCircle([f64; 2], f64, Rgba),
    Poly(Vec<[i32; 2]>, Rgba),
    FillPoly(Vec<[f64; 2]>, Rgba),
    Text([i32; 2], String, Rgba),
    LineAa([f64; 2], [f64; 2], Rgba),
    Blit(Rect, Vec<u8>),
}

fn draw(memory: &mut VideoMemory, figure: &Figure, by: [i32; 2], blend: Blend) {
    let at = |p: &[i32; 2]| [p[0] + by[0], p[1] + by[1]];
    let real = |p: &[f64; 2]| [p[0] + f64::from(by[0]), p[1] + f64::from(by[1])];
    let rect = |r: &Rect| Rect { x: r.x + by[0], y: r.y + by[1], ..*r };
    match figure {
        Figure::Line(p0, p1, color) => draw2d::line(memory, at(p0), at(p1), *color, blend),
        Figure::Triangle(p, colors) => draw2d::triangle_outline(memory, p.map(|p| at(&p)), *colors, blend),
        Figure::Fill(p, colors) => draw2d::fill(memory, p.map(|p| real(&p)), *colors, blend),
        Figure::Rect(r, color) => draw2d::rect(memory, rect(r), *color, blend).unwrap(),
        Figure::FillRect(r, color) => {
            let [x, y] = real(&[r.x, r.y]);
            draw2d::fill_rect(memory, RealRect { x, y, ..*r }, *color, blend).unwrap();
        }
        Figure::Circle(c, r, color) => draw2d::circle(memory, at(c), *r, *color, blend).unwrap(),
        Figure::FillCircle(c, r, color) => draw2d::fill_circle(memory, real(c), *r, *color, blend).unwrap(),
        Figure::Poly(p, color) => {
            draw2d::poly(memory, &p.iter().map(at).collect::<Vec<_>>(), *color, blend);
        }
        Figure::FillPoly(p, color) => {
            draw2d::fill_poly(memory, &p.iter().map(real).collect::<Vec<_>>(), *color, blend);
        }
        Figure::Text(p, text, color) => {
            draw2d::text(memory, at(p), text.as_bytes(), *color, blend).unwrap();
        }
        Figure::LineAa(p0, p1, color) => draw2d::line_aa(memory, real(p0), real(p1), *color),
        Figure::Blit(r, rgba) => draw2d::blit(memory, rect(r), rgba, blend).unwrap(),
    }
}

fn whole() -> impl Strategy<Value = [i32; 2]> {
    [-40..60i32, -40..50i32]
}

/// Generates points on the grid of 1/256, so that moving them rounds nothing.
fn real() -> impl Strategy<Value = [f64; 2]> {
    let v = |low: i32, high: i32| (low * 256..high * 256).prop_map(|v| f64::from(v) / 256.0);
    [v(-40, 60), v(-40, 50)]
}

fn rect() -> impl Strategy<Value = Rect> {
    (whole(), 0..60i32, 0..60i32).prop_map(|([x, y], w, h)| Rect { x, y, w, h })
}

fn areas() -> impl Strategy<Value = AreaColors> {
    prop_oneof![any::<Rgba>().prop_map(AreaColors::One), any::<[Rgba; 3]>().prop_map(AreaColors::Three)]
}

fn ramp() -> impl Strategy<Value = RampColor> {
    any::<(Rgba, Option<Rgba>)>().prop_map(|(from, to)| RampColor { from, to })
}

fn figure() -> impl Strategy<Value = Figure> {
    prop_oneof![
        (whole(), whole(), ramp()).prop_map(|(a, b, c)| Figure::Line(a, b, c)),
        ([whole(), whole(), whole()], areas()).prop_map(|(p, c)| Figure::Triangle(p, c)),
        ([real(), real(), real()], areas()).prop_map(|(p, c)| Figure::Fill(p, c)),
        (rect(), any::<Rgba>()).prop_map(|(r, c)| Figure::Rect(r, c)),
        (real(), [0..60 * 256i32, 0..60 * 256i32], any::<Rgba>()).prop_map(|([x, y], size, c)| {
            let [w, h] = size.map(|v| f64::from(v) / 256.0);
            Figure::FillRect(RealRect { x, y, w, h }, c)
        }),
        (whole(), 0..60i32, any::<Rgba>()).prop_map(|(p, r, c)| Figure::Circle(p, r, c)),
        (real(), 0..60 * 256i32, any::<Rgba>()).prop_map(|(p, r, c)| Figure::FillCircle(
            p,
            f64::from(r) / 256.0,
            c
        )),
        (prop::collection::vec(whole(), 0..7), any::<Rgba>()).prop_map(|(p, c)| Figure::Poly(p, c)),
        (prop::collection::vec(real(), 0..7), any::<Rgba>()).prop_map(|(p, c)| Figure::FillPoly(p, c)),
        (whole(), "[ -~\u{a0}-\u{101}\n]{0,20}", any::<Rgba>()).prop_map(|(p, t, c)| Figure::Text(p, t, c)),
        (real(), real(), any::<Rgba>()).prop_map(|(a, b, c)| Figure::LineAa(a, b, c)),
        (rect(), any::<u8>()).prop_map(|(r, seed)| {
            let n = r.w as usize * r.h as usize * 4;
            Figure::Blit(r, (0..n).map(|i| (i * 31) as u8 ^ seed).collect())
        }),
    ]
}

fn frame(width: u32, height: u32) -> VideoMemory {
    let mut memory = VideoMemory::new(width, height).unwrap();
    memory.clear(BACKGROUND);
    memory.take_damage();
    memory
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3_000, ..ProptestConfig::default() })]

    #[test]
    fn clipped_equals_whole(
        figure in figure(), w in prop_oneof![Just(1u32), 1..24u32], h in prop_oneof![Just(1u32), 1..20u32], over: bool,
    ) {
        let blend = if over { Blend::Over } else { Blend::Replace };
        let (mut small, mut large) = (frame(w, h), frame(256, 224));
        let by = [110, 100];
        draw(&mut small, &figure, [0, 0], blend);
        draw(&mut large, &figure, by, blend);
        let window = Rect { x: by[0], y: by[1], w: w as i32, h: h as i32 };
        let seen = draw2d::read(&large, window).unwrap();
        if matches!(figure, Figure::LineAa(..)) {
            // Areas are computed in f64: a coverage on the border of two steps may be rounded
            // either way.
            prop_assert!(small.bytes().iter().zip(&seen).all(|(a, b)| a.abs_diff(*b) <= 1));
        } else {
            prop_assert_eq!(small.bytes(), seen);
        }
        // Every changed pixel is inside the damage.
        let damage = small.take_damage();
        for (y, row) in small.bytes().chunks(small.stride_bytes()).enumerate() {
            prop_assert!(damage.contains(&(y as u32)) || row.as_chunks().0.iter().all(|p| *p == BACKGROUND));
        }
    }

    #[test]
    fn every_verb_answers_any_number_in_any_frame(
        v: [i32; 6], bits: [u64; 6], edge in prop::collection::vec(0..8usize, 6), c: [Rgba; 3], w in 1..9u32, h in 1..9u32, over: bool,
    ) {
        // Half of the numbers are extremes of their type.
        let odd = [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX - 1, i32::MAX];
        let odd_real = [f64::MAX, -f64::MAX, 5e-324, -0.0, 0.5, 2_147_483_648.0, -9.3e18];
        let v: [i32; 6] = std::array::from_fn(|i| odd.get(edge[i]).copied().unwrap_or(v[i]));
        let r: [f64; 6] = std::array::from_fn(|i| odd_real.get(edge[i]).copied().unwrap_or(f64::from_bits(bits[i])));
        let blend = if over { Blend::Over } else { Blend::Replace };
        let mut m = frame(w, h);
        let rect = Rect { x: v[0], y: v[1], w: v[2], h: v[3] };
        let (p, q) = ([[v[0], v[1]], [v[2], v[3]], [v[4], v[5]]], [[r[0], r[1]], [r[2], r[3]], [r[4], r[5]]]);
        draw2d::put_pixel(&mut m, v[0], v[1], c[0], blend);
        draw2d::line(&mut m, p[0], p[1], RampColor { from: c[0], to: Some(c[1]) }, blend);
        draw2d::triangle_outline(&mut m, p, AreaColors::Three(c), blend);
        draw2d::fill(&mut m, q, AreaColors::Three(c), blend);
        draw2d::fill(&mut m, q, AreaColors::One(c[0]), blend);
        draw2d::poly(&mut m, &p, c[0], blend);
        draw2d::fill_poly(&mut m, &q, c[0], blend);
        draw2d::line_aa(&mut m, q[0], q[1], c[0]);
        draw2d::text(&mut m, p[0], "añ\n\u{7}".as_bytes(), c[0], blend).unwrap();
        let refused = [
            draw2d::rect(&mut m, rect, c[0], blend).is_err(),
            draw2d::fill_rect(&mut m, rect, c[0], blend).is_err(),
        ];
        prop_assert_eq!(refused, [v[2] < 0 || v[3] < 0; 2]);
        let area = RealRect { x: r[0], y: r[1], w: r[2], h: r[3] };
        prop_assert_eq!(draw2d::fill_rect(&mut m, area, c[0], blend).is_err(), r[2] < 0.0 || r[3] < 0.0);
        prop_assert_eq!(draw2d::circle(&mut m, p[0], v[2], c[0], blend).is_err(), v[2] < 0);
        prop_assert_eq!(draw2d::fill_circle(&mut m, q[0], r[2], c[0], blend).is_err(), r[2] < 0.0);
        let inside = |a: i32, n: i32, limit: u32| a >= 0 && i64::from(a) + i64::from(n) <= limit.into();
        let is_sound = v[2] >= 0 && v[3] >= 0;
        let is_source = is_sound && (v[2] == 0 || v[3] == 0 || inside(v[0], v[2], w) && inside(v[1], v[3], h));
        prop_assert_eq!(draw2d::read(&m, rect).is_ok(), is_source);
        prop_assert_eq!(draw2d::copy(&mut m, rect, p[2], blend).is_ok(), is_source);
        prop_assert_eq!(draw2d::blit(&mut m, rect, &[], blend).is_ok(), is_sound && (v[2] == 0 || v[3] == 0));
    }
}

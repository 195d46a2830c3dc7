//! The gallery of a polytope: its glowing wireframe, and beside it its slice and its shadow.
//!
//! In: a scene of four or more dimensions, its wireframe, the eye's pose. Out: a frame of three
//! pictures, each above its caption. With r the coordinates of a point from the middle, along the
//! eye's axes (0 ahead, 1 left, 2 up, 3 and on hidden), and R the largest distance:
//!
//! - Wireframe: each hidden axis k, from the last, scales the others by D / (D - r_k), D = 2.4 R;
//!   what remains is tilted, and seen in perspective from 3.4 R. Near edges are bright, far ones
//!   dim; the colour is that of the first hidden coordinate, from blue to gold.
//! - Slice: the space of the visible axes through the eye, by the renderer of N dimensions, each pixel
//!   the mean of four; a light at the eye shows faces that no other light reaches.
//! - Shadow: all hidden axes and the direction of view left out.

use super::Nd;
use super::edges::Wireframe;
use super::glow::{End, Glow};
use crate::viewer::studio::Backdrop;
use fbptr_core::draw2d::font::CELL;
use fbptr_core::draw2d::look::{LESSER, MARGIN, PAPER, TEXT, letters};
use fbptr_core::draw2d::{AreaColors, Blend, fill, line_aa};
use fbptr_core::eye::{self, EyeLight, EyeLightKind, EyeScene, Falloff, Fibre};
use fbptr_core::memory::VideoMemory;

/// Distance of the eye along a hidden axis, in radii.
const HIDDEN_EYE: f64 = 2.4;
/// Distance of the eye along the direction of view, in radii.
const EYE: f64 = 3.4;
/// Tilt of the wireframe to the left and down: sine and cosine of 24 and 17 degrees.
const TILT: [[f64; 2]; 2] = [[0.406_736_6, 0.913_545_5], [0.292_371_7, 0.956_304_8]];
/// Colours of the first hidden coordinate, from the least to the largest: blue, teal, gold.
const COLORS: [[f32; 3]; 3] = [[0.25, 0.45, 1.0], [0.16, 0.80, 0.74], [1.0, 0.66, 0.10]];
/// Least diffuse light of a slice, and the brightness of the light at the eye.
const SLICE_LIGHT: [f64; 2] = [0.3, 0.6];
/// Smallest side of a frame with room for three pictures.
const LEAST_SIDE: usize = 160;

/// A scene prepared for its gallery, computed once.
pub(super) struct Gallery {
    wireframe: Wireframe,
    radius: f64,
    backdrop: Backdrop,
}

/// A rectangle of the frame.
#[derive(Clone, Copy)]
struct Panel {
    at: [usize; 2],
    size: [usize; 2],
}

/// Positions of the pictures and captions in a frame.
struct GalleryLayout {
    /// Wireframe, slice and shadow.
    panels: [Panel; 3],
    /// Distance of a caption from its picture.
    gap: usize,
    /// Scale of the captions' letters.
    scale: usize,
}

impl GalleryLayout {
    /// Returns the layout of a frame of `size`; `None` if it is too small.
    fn new(size: [usize; 2]) -> Option<GalleryLayout> {
        if size.iter().any(|&s| s < LEAST_SIDE) {
            return None;
        }
        let margin = if size[0] >= 640 { MARGIN } else { MARGIN / 4 };
        // The longest line of the right column has 17 letters.
        let scale = if size[0] / 3 >= 17 * 2 * CELL { 2 } else { 1 };
        let gap = margin / 2;
        let caption = scale * CELL + gap;
        let (left, height) = (size[0] * 2 / 3 - margin, size[1] - 2 * margin - caption);
        let right = size[0] - left - 3 * margin;
        let lower = (size[1] - 3 * margin - 2 * caption) / 2;
        let main = Panel { at: [margin, margin], size: [left, height] };
        let slice = Panel { at: [left + 2 * margin, margin], size: [right, lower] };
        let shadow = Panel { at: [slice.at[0], 2 * margin + caption + lower], size: slice.size };
        Some(GalleryLayout { panels: [main, slice, shadow], gap, scale })
    }

    /// Returns the rectangle of a picture's caption: left, top, right, bottom.
    fn caption(&self, panel: Panel) -> [usize; 4] {
        let ([x, y], [w, h]) = (panel.at, panel.size);
        let top = y + h + self.gap;
        [x, top, x + w, top + self.scale * CELL]
    }
}

/// Returns the rectangles of the captions in a frame of `size`: left, top, right, bottom. None if
/// it is too small for a gallery.
pub(in crate::viewer) fn captions(size: [usize; 2]) -> Vec<[usize; 4]> {
    GalleryLayout::new(size)
        .map_or(Vec::new(), |layout| layout.panels.map(|panel| layout.caption(panel)).to_vec())
}

impl Gallery {
    /// Returns the gallery of a scene; `None` if it has no wireframe, or its screen is no picture.
    pub fn of(scene: &EyeScene, middle: &[f64]) -> Option<Gallery> {
        let wireframe = Wireframe::of(scene).filter(|w| !w.edges.is_empty())?;
        let away = |p: &Vec<f64>| p.iter().zip(middle).map(|(x, m)| (x - m) * (x - m)).sum::<f64>().sqrt();
        let radius = wireframe.points.iter().map(away).fold(0.0, f64::max);
        let fits = scene.screen_dim() == 2 && radius > 0.0 && radius.is_finite();
        fits.then_some(Gallery { wireframe, radius, backdrop: Backdrop::default() })
    }

    /// Draws the gallery. Returns false, with nothing drawn, if the frame is too small.
    pub fn draw(&mut self, nd: &Nd, memory: &mut VideoMemory) -> Result<bool, String> {
        let size = [memory.width() as usize, memory.height() as usize];
        let Some(layout) = GalleryLayout::new(size) else { return Ok(false) };
        self.backdrop.paint(memory);
        let [main, slice, shadow] = layout.panels;
        let points = self.points_from_eye(nd);
        self.paint_wireframe(&points, memory, main);
        paint_slice(nd, memory, slice)?;
        self.paint_shadow(&points, memory, shadow);
        let [a, b] = nd.plane();
        let lines = [
            (main, format!("{} edges, turning in plane {a}-{b}", self.wireframe.edges.len())),
            (slice, "slice: in our 3-D".to_owned()),
            (shadow, "shadow: all, flat".to_owned()),
        ];
        for (panel, line) in lines {
            let most = panel.size[0] / CELL / layout.scale;
            let line: String = line.chars().take(most).collect();
            let color = if panel.at == main.at { TEXT } else { LESSER };
            let [left, top, ..] = layout.caption(panel);
            letters(memory, [left, top], &line, color, layout.scale);
        }
        Ok(true)
    }

    /// Returns the points' coordinates along the eye's axes, from the middle, in radii.
    fn points_from_eye(&self, nd: &Nd) -> Vec<Vec<f64>> {
        let axes = nd.pose.axes();
        let along = |p: &Vec<f64>, axis: &Vec<f64>| {
            let sum: f64 = p.iter().zip(&nd.middle).zip(axis).map(|((x, m), e)| (x - m) * e).sum();
            sum / self.radius
        };
        self.wireframe.points.iter().map(|p| axes.iter().map(|axis| along(p, axis)).collect()).collect()
    }

    fn paint_wireframe(&self, points: &[Vec<f64>], memory: &mut VideoMemory, panel: Panel) {
        let mut glow = Glow::new(panel.size);
        let hidden = points.first().map_or(0, |p| p.len() - 3) as i32;
        // A point at distance 1 is seen at sqrt(D^2 / (D^2 - 1)) at most, for each perspective.
        let spread = |distance: f64| distance / (distance * distance - 1.0).sqrt();
        let widest = libm::pow(spread(HIDDEN_EYE), f64::from(hidden)) * spread(EYE);
        let half = panel.size[0].min(panel.size[1]) as f64 / 2.0;
        let ends: Vec<End> = points.iter().map(|p| end(p, panel, 0.97 * half / widest)).collect();
        for &[a, b] in &self.wireframe.edges {
            glow.add(ends[a], ends[b]);
        }
        glow.paint(memory, panel.at);
    }

    fn paint_shadow(&self, points: &[Vec<f64>], memory: &mut VideoMemory, panel: Panel) {
        let [w, h] = panel.size;
        let scale = 0.94 * w.min(h) as f64 / 2.0;
        let place = |p: &Vec<f64>| {
            let [_, left, up] = tilted([p[0], p[1], p[2]]);
            [w as f64 / 2.0 - left * scale, h as f64 / 2.0 - up * scale]
        };
        let places: Vec<[f64; 2]> = points.iter().map(place).collect();
        // Twice the size, so that the mean of four is smooth before it is blurred.
        let Ok(mut mask) = VideoMemory::new(2 * w as u32, 2 * h as u32) else { return };
        let white = [255; 4];
        for triangle in &self.wireframe.triangles {
            let corners = triangle.map(|i| places[i].map(|v| 2.0 * v));
            fill(&mut mask, corners, AreaColors::One(white), Blend::Replace);
        }
        let dark = blurred(&mask, [w, h], (h / 60).max(1));
        let width = memory.width() as usize;
        let pixels = memory.bytes_mut().as_chunks_mut::<4>().0;
        for y in 0..h {
            for x in 0..w {
                // A pool of light on a wall, and the shadow in it.
                let off = [(x as f64 + 0.5) / w as f64 - 0.5, (y as f64 + 0.5) / h as f64 - 0.5];
                let pool = (1.0 - 1.9 * (off[0] * off[0] + off[1] * off[1])).max(0.0);
                let light = pool * (1.0 - 0.76 * f64::from(dark[y * w + x]));
                let pixel = &mut pixels[(panel.at[1] + y) * width + panel.at[0] + x];
                for (byte, wall) in pixel.iter_mut().zip([196.0, 190.0, 176.0]) {
                    *byte = (14.0 + light * wall) as u8;
                }
            }
        }
        for &[a, b] in &self.wireframe.edges {
            let [a, b] = [a, b].map(|i| [0, 1].map(|k| places[i][k] + panel.at[k] as f64));
            line_aa(memory, a, b, [10, 13, 20, 70]);
        }
    }
}

/// Tilts a point of three dimensions: ahead, left, up.
fn tilted([ahead, left, up]: [f64; 3]) -> [f64; 3] {
    let [[sin, cos], [down_sin, down_cos]] = TILT;
    let (ahead, left) = (cos * ahead + sin * left, cos * left - sin * ahead);
    [down_cos * ahead - down_sin * up, left, down_cos * up + down_sin * ahead]
}

/// Returns a point of the wireframe on its panel, with its light and colour.
fn end(p: &[f64], panel: Panel, scale: f64) -> End {
    let mut seen = [p[0], p[1], p[2]];
    for &hidden in p[3..].iter().rev() {
        let nearer = HIDDEN_EYE / (HIDDEN_EYE - hidden);
        seen = seen.map(|v| v * nearer);
    }
    let [ahead, left, up] = tilted(seen);
    let nearer = EYE / (EYE + ahead);
    let hidden = ((p[3] + 1.0).clamp(0.0, 2.0)) as f32;
    let (from, part) = if hidden < 1.0 { (0, hidden) } else { (1, hidden - 1.0) };
    let color = std::array::from_fn(|c| COLORS[from][c] + (COLORS[from + 1][c] - COLORS[from][c]) * part);
    // Depth cue: three times as bright at the front as at the back.
    let light = (0.9 - 0.75 * ahead).clamp(0.16, 1.9) as f32;
    let middle = panel.size.map(|s| s as f64 / 2.0);
    let at = [middle[0] - left * nearer * scale, middle[1] - up * nearer * scale];
    End { at: at.map(|v| v as f32), light, color }
}

/// Draws the slice through the eye into a panel.
fn paint_slice(nd: &Nd, memory: &mut VideoMemory, panel: Panel) -> Result<(), String> {
    let mut parts = nd.scene().into_parts();
    parts.aperture_tan.fill(0.0);
    parts.pixels = panel.size.map(|s| 2 * s as u32).to_vec();
    let [w, h] = panel.size.map(|s| s as f64);
    let least = parts.size.iter().copied().fold(f64::INFINITY, f64::min);
    parts.size = [w, h].map(|s| least * s / w.min(h)).to_vec();
    parts.background = [PAPER[0], PAPER[1], PAPER[2]].map(f64::from);
    let [least, brightness] = SLICE_LIGHT;
    parts.diffuse = parts.diffuse.map(|channel| channel.max(least));
    parts.lights.push(EyeLight {
        kind: EyeLightKind::Radial { position: parts.pose.position.clone() },
        falloff: Falloff { k: brightness, n: 0.0 },
        color: [1.0; 3],
    });
    let scene = EyeScene::new(parts).map_err(|e| e.to_string())?;
    let picture = eye::render_with(&scene, Fibre::Exact, &nd.pool).map_err(|e| e.to_string())?;
    let [w, h] = panel.size.map(|s| 2 * s as u32);
    let mut fine = VideoMemory::new(w, h).map_err(|e| e.to_string())?;
    eye::blit(&picture, &mut fine, 0, 0, w as i32, h as i32);
    paint_means(&fine, memory, panel);
    Ok(())
}

/// Paints a picture of twice a panel's size into the panel: each pixel is the mean of four.
fn paint_means(fine: &VideoMemory, memory: &mut VideoMemory, panel: Panel) {
    let [w, h] = panel.size;
    let width = memory.width() as usize;
    let (fine, pixels) = (fine.bytes().as_chunks::<4>().0, memory.bytes_mut().as_chunks_mut::<4>().0);
    for y in 0..h {
        for x in 0..w {
            let first = (2 * y * w + x) * 2;
            let of_four = [first, first + 1, first + 2 * w, first + 2 * w + 1].map(|i| fine[i]);
            let mean = |c: usize| (of_four.iter().map(|p| u32::from(p[c])).sum::<u32>() + 2) / 4;
            pixels[(panel.at[1] + y) * width + panel.at[0] + x] = std::array::from_fn(|c| mean(c) as u8);
        }
    }
}

/// Returns the mean of a mask of twice the size, in 0..=1, blurred by three boxes of `radius`.
fn blurred(mask: &VideoMemory, [w, h]: [usize; 2], radius: usize) -> Vec<f32> {
    let bytes = mask.bytes();
    let at = |x: usize, y: usize| f32::from(bytes[(y * 2 * w + x) * 4]);
    let mean = |i: usize| {
        let (x, y) = (i % w * 2, i / w * 2);
        (at(x, y) + at(x + 1, y) + at(x, y + 1) + at(x + 1, y + 1)) / 1020.0
    };
    let mut map: Vec<f32> = (0..w * h).map(mean).collect();
    let width = (2 * radius + 1) as f32;
    for pass in 0..4 {
        let (lines, length) = if pass % 2 == 0 { (h, w) } else { (w, h) };
        let index = |line: usize, i: usize| if pass % 2 == 0 { line * w + i } else { i * w + line };
        for line in 0..lines {
            let before: Vec<f32> = (0..length).map(|i| map[index(line, i)]).collect();
            for i in 0..length {
                let span = i.saturating_sub(radius)..(i + radius + 1).min(length);
                map[index(line, i)] = before[span].iter().sum::<f32>() / width;
            }
        }
    }
    map
}

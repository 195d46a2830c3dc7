//! The picture that the reference makes: for each pixel, every answer that the specification calls right.
//!
//! A pixel holds a list of states, nearly always one; none is kept for a pixel that nothing has touched. A fragment whose decision turns (see `fragment`) splits them; equal
//! states are merged. A pixel whose list grows past `MAX_STATES` is free: it is counted, and accepts anything.

use super::coverage::Coverage;
use super::double_double::{DoubleDouble, DoubleDouble4};
use super::fragment::{ColorRange, Fragment};
use crate::memory::{DepthFormat, Rgba};
use glam::DVec3;

/// More states than this and the pixel is free.
pub const MAX_STATES: usize = 48;

/// Who drew: the key of a face among all that a picture has seen.
pub type FaceKey = u32;

/// What a picture remembers of a face.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceRecord {
    /// The object's name.
    pub name: String,
    /// Number of the object in its draw.
    pub object: u32,
    /// Number of the triangle in its object, in file order.
    pub triangle: u32,
    /// Clip positions in an order that does not depend on the first corner or on the winding.
    positions: [DoubleDouble4; 3],
}

/// One right answer for a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelState {
    /// Least bytes.
    pub lo: [u8; 3],
    /// Largest bytes.
    pub hi: [u8; 3],
    /// Colour before it became bytes: the least and the largest, unclamped.
    pub real: [DVec3; 2],
    /// Depth in 0..=1: the least and the largest.
    pub z: [DoubleDouble; 2],
    /// The face whose depth this is.
    pub depth_owner: Option<FaceKey>,
    /// The face that was drawn last.
    pub drawn: Option<FaceKey>,
    /// Whether a texture had a part in the colour.
    pub is_textured: bool,
}

/// A picture with all right answers.
#[derive(Clone, Debug)]
pub struct TruthPicture {
    width: u32,
    height: u32,
    format: DepthFormat,
    /// The one answer of the pixels that nothing has touched: those whose list is empty.
    blank: PixelState,
    states: Vec<Vec<PixelState>>,
    free: Vec<bool>,
    faces: Vec<FaceRecord>,
}

/// How a fragment meets the depth memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DepthUse {
    /// Neither tested nor written.
    Ignore,
    /// Tested only: transparent faces.
    Test,
    /// Tested and written.
    TestAndWrite,
}

/// A fragment with what the resolve needs besides.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The fragment.
    pub fragment: Fragment,
    /// Its face.
    pub face: FaceKey,
    /// What it does to depth.
    pub depth_use: DepthUse,
    /// Whether it is blended over what is there.
    pub is_transparent: bool,
    /// Whether a texture coloured it.
    pub is_textured: bool,
}

/// floor(255 clamp(c, 0, 1) + 0.5); what is not a number counts as 0.
pub fn byte(c: f64) -> u8 {
    if c.is_nan() { 0 } else { (255.0 * c.clamp(0.0, 1.0) + 0.5).floor() as u8 }
}

fn bytes(c: DVec3) -> [u8; 3] {
    c.to_array().map(byte)
}

impl TruthPicture {
    /// A cleared picture: opaque black, depth 1.
    pub fn new(width: u32, height: u32, format: DepthFormat) -> TruthPicture {
        let pixels = width as usize * height as usize;
        let blank = PixelState {
            lo: [0; 3],
            hi: [0; 3],
            real: [DVec3::ZERO; 2],
            z: [DoubleDouble::ONE; 2],
            depth_owner: None,
            drawn: None,
            is_textured: false,
        };
        TruthPicture {
            width,
            height,
            format,
            blank,
            states: vec![Vec::new(); pixels],
            free: vec![false; pixels],
            faces: Vec::new(),
        }
    }

    /// Width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How depths are stored.
    pub fn depth_format(&self) -> DepthFormat {
        self.format
    }

    /// The right answers for pixel (x, y). Empty lists do not occur.
    ///
    /// # Panics
    /// Off the picture.
    pub fn states(&self, x: u32, y: u32) -> &[PixelState] {
        assert!(x < self.width && y < self.height, "({x},{y}) is off the picture");
        self.states_at((self.width * y + x) as usize)
    }

    fn states_at(&self, index: usize) -> &[PixelState] {
        match &self.states[index][..] {
            [] => std::slice::from_ref(&self.blank),
            some => some,
        }
    }

    /// Each pixel's first answer.
    fn firsts(&self) -> impl Iterator<Item = &PixelState> {
        self.states.iter().map(|s| s.first().unwrap_or(&self.blank))
    }

    /// Whether so much turns at pixel (x, y) that any answer is accepted.
    pub fn is_free(&self, x: u32, y: u32) -> bool {
        self.free[(self.width * y + x) as usize]
    }

    /// What is known of a face that drew.
    pub fn face(&self, key: FaceKey) -> &FaceRecord {
        &self.faces[key as usize]
    }

    /// The RGBA bytes of each pixel's first answer, row 0 at the top.
    pub fn bytes(&self) -> Vec<u8> {
        self.firsts().flat_map(|s| [s.lo[0], s.lo[1], s.lo[2], 255]).collect()
    }

    /// The unclamped colour of each pixel's first answer.
    pub fn real_colors(&self) -> Vec<[f64; 3]> {
        self.firsts().map(|s| s.real[0].to_array()).collect()
    }

    /// The exact depth of each pixel's first answer.
    pub fn depths(&self) -> Vec<f64> {
        self.firsts().map(|s| s.z[0].to_f64()).collect()
    }

    /// Colour everywhere, depth 1 everywhere: what CLEAR does.
    pub fn clear(&mut self, color: Rgba) {
        let rgb = [color[0], color[1], color[2]];
        let real = DVec3::from_array(rgb.map(|c| c as f64 / 255.0));
        self.blank =
            PixelState { z: [DoubleDouble::ONE; 2], depth_owner: None, ..painted(&self.blank, real) };
        self.states.iter_mut().for_each(Vec::clear);
        self.free.fill(false);
    }

    /// A colour over the pixels of x0..x1, y0..y1 that exist; depth stays.
    pub fn paint(&mut self, [x0, x1, y0, y1]: [i64; 4], color: DVec3) {
        let (width, height) = (self.width as i64, self.height as i64);
        let covers_frame = x0 <= 0 && y0 <= 0 && x1 >= width && y1 >= height;
        for y in y0.max(0)..y1.min(height) {
            for x in x0.max(0)..x1.min(width) {
                let at = (width * y + x) as usize;
                self.free[at] = false;
                let states = &mut self.states[at];
                if states.is_empty() && !covers_frame {
                    states.push(self.blank);
                }
                states.iter_mut().for_each(|s| *s = painted(s, color));
                merge(states);
            }
        }
        if covers_frame {
            self.blank = painted(&self.blank, color);
        }
    }

    /// A colour over one pixel, as opaque as it says; depth stays.
    pub(super) fn paint_pixel(&mut self, x: i64, y: i64, color: DVec3, opacity: f64) {
        let at = (self.width as i64 * y + x) as usize;
        self.free[at] = false;
        let states = &mut self.states[at];
        if states.is_empty() {
            states.push(self.blank);
        }
        let old = |b: [u8; 3]| DVec3::from_array(b.map(|c| c as f64 / 255.0));
        for state in states.iter_mut() {
            *state = painted(state, old(state.lo) * (1.0 - opacity) + color * opacity);
        }
        merge(states);
    }

    /// Remembers a face; layers name it by the key.
    pub fn register(&mut self, name: &str, object: u32, triangle: u32, clip: [DoubleDouble4; 3]) -> FaceKey {
        let mut positions = clip;
        positions.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        self.faces.push(FaceRecord { name: name.to_owned(), object, triangle, positions });
        (self.faces.len() - 1) as FaceKey
    }

    /// Puts layers on pixel `index` (= width y + x), in one of the orders that are right.
    pub fn resolve(&mut self, index: usize, orders: &[Vec<&Layer>]) {
        let before = self.states_at(index).to_vec();
        let mut after = Vec::new();
        for order in orders {
            let mut states = before.clone();
            for layer in order {
                states = self.put(layer, &states);
                if states.len() > MAX_STATES {
                    self.free[index] = true;
                    states.truncate(1);
                }
            }
            after.extend(states);
        }
        merge(&mut after);
        self.states[index] = after;
    }

    /// One layer over each state: kept, replaced, or both.
    fn put(&self, layer: &Layer, states: &[PixelState]) -> Vec<PixelState> {
        let mut after = Vec::new();
        for state in states {
            let passes = match layer.depth_use {
                DepthUse::Ignore => Coverage::Yes,
                DepthUse::Test | DepthUse::TestAndWrite => self.is_nearer(layer, state),
            }
            .min(layer.fragment.presence);
            if passes != Coverage::No {
                after.extend(layer.fragment.colors.iter().map(|range| draw_over(layer, range, state)));
            }
            if passes != Coverage::Yes {
                after.push(*state);
            }
        }
        merge(&mut after);
        after
    }

    /// Whether what the fragment would store is strictly nearer than what is stored.
    fn is_nearer(&self, layer: &Layer, state: &PixelState) -> Coverage {
        let z = layer.fragment.z;
        if let Some(owner) = state.depth_owner
            && self.is_same_depth(layer.face, owner)
        {
            return Coverage::No;
        }
        match self.format {
            DepthFormat::U16 | DepthFormat::U24 | DepthFormat::U32 => {
                let new = self.format.words_around(z);
                let old = self.format.words_around(state.z);
                decide(new[1] < old[0], new[0] >= old[1])
            }
            DepthFormat::F32 | DepthFormat::Reversed => {
                // Nothing passes against the cleared depth at z = 1 exactly.
                let one = DoubleDouble::ONE;
                if z[0] >= one {
                    return Coverage::No;
                }
                let far_end = state.z[1].max(z[1]);
                let turn = match self.format {
                    DepthFormat::Reversed => 2.0 * ulp_f32((one - state.z[0].min(z[0])).to_f64()),
                    _ => 2.0 * ulp_f32(far_end.to_f64()),
                };
                let turn = DoubleDouble::new(turn);
                decide(z[1] + turn < state.z[0], z[0] > state.z[1] + turn)
            }
        }
    }

    /// Whether two faces have equal depths for certain: the same positions, or one constant depth.
    fn is_same_depth(&self, a: FaceKey, b: FaceKey) -> bool {
        let (a, b) = (&self.faces[a as usize].positions, &self.faces[b as usize].positions);
        let level = |p: &[DoubleDouble4; 3]| p.iter().all(|q| q[2] == p[0][2] && q[3] == p[0][3]);
        a == b || (level(a) && level(b) && a[0][2] == b[0][2] && a[0][3] == b[0][3])
    }
}

fn decide(certainly: bool, certainly_not: bool) -> Coverage {
    match (certainly, certainly_not) {
        (true, _) => Coverage::Yes,
        (_, true) => Coverage::No,
        _ => Coverage::Maybe,
    }
}

/// The distance from |x| to the next larger f32.
pub fn ulp_f32(x: f64) -> f64 {
    let bits = (x.abs() as f32).to_bits();
    (f32::from_bits(bits + 1) - f32::from_bits(bits)) as f64
}

/// What the reference asks of a depth format.
pub trait StoredDepth {
    /// The largest word of an integer format as a number.
    fn steps(self) -> Option<f64>;
    /// The least and largest word that may be stored for depths z[0]..z[1]: within 0.501 of a step.
    fn words_around(self, z: [DoubleDouble; 2]) -> [u64; 2];
}

impl StoredDepth for DepthFormat {
    fn steps(self) -> Option<f64> {
        match self {
            DepthFormat::U16 => Some(65_535.0),
            DepthFormat::U24 => Some(16_777_215.0),
            DepthFormat::U32 => Some(4_294_967_295.0),
            DepthFormat::F32 | DepthFormat::Reversed => None,
        }
    }

    fn words_around(self, z: [DoubleDouble; 2]) -> [u64; 2] {
        let steps = self.steps().unwrap_or(0.0);
        // w is right when |w - steps z| <= 0.501.
        let [lo, hi] = z.map(|z| z.max(DoubleDouble::ZERO).min(DoubleDouble::ONE) * DoubleDouble::new(steps));
        let least = (lo - DoubleDouble::new(0.501)).to_f64().ceil().max(0.0);
        let largest = (hi + DoubleDouble::new(0.501)).to_f64().floor().min(steps);
        [least as u64, largest as u64]
    }
}

/// The state under a colour that is no face's.
fn painted(state: &PixelState, color: DVec3) -> PixelState {
    let rgb = bytes(color);
    PixelState { lo: rgb, hi: rgb, real: [color; 2], drawn: None, is_textured: false, ..*state }
}

/// The state after a tone is drawn over it: new = old t + rgb (1 - t) on bytes, or the colour alone.
fn draw_over(layer: &Layer, range: &ColorRange, state: &PixelState) -> PixelState {
    let real = if layer.is_transparent {
        let old = |b: [u8; 3]| DVec3::from_array(b.map(|c| c as f64 / 255.0));
        let mix = |old: DVec3, new: DVec3, alpha: f64| old * (1.0 - alpha) + new * alpha;
        let ends = range.alpha.map(|a| [mix(old(state.lo), range.lo, a), mix(old(state.hi), range.hi, a)]);
        [ends[0][0].min(ends[1][0]), ends[0][1].max(ends[1][1])]
    } else {
        [range.lo, range.hi]
    };
    let writes = layer.depth_use == DepthUse::TestAndWrite;
    PixelState {
        lo: bytes(real[0]),
        hi: bytes(real[1]),
        real,
        z: if writes { layer.fragment.z } else { state.z },
        depth_owner: if writes { Some(layer.face) } else { state.depth_owner },
        drawn: Some(layer.face),
        is_textured: layer.is_textured || (layer.is_transparent && state.is_textured),
    }
}

/// Leaves one of each state, in order.
fn merge(states: &mut Vec<PixelState>) {
    let mut kept: Vec<PixelState> = Vec::with_capacity(states.len());
    for s in states.drain(..) {
        if !kept.contains(&s) {
            kept.push(s);
        }
    }
    *states = kept;
}

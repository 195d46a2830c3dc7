//! Reference picture: for each pixel, every result that the specification accepts.
//!
//! A pixel holds a list of states, nearly always one; the list of an untouched pixel is empty and
//! stands for the blank state. A fragment with a borderline decision (see `fragment`) splits the
//! states; equal states are merged. A pixel whose list exceeds `MAX_STATES` is unconstrained: it is
//! counted, and accepts any colour.

use super::coverage::Coverage;
use super::double_double::{DoubleDouble, DoubleDouble4};
use super::fragment::{ColorRange, Fragment};
use fbptr_core::memory::{DepthFormat, Rgba};
use glam::DVec3;

/// Number of states above which a pixel becomes unconstrained.
pub const MAX_STATES: usize = 48;

/// Index of a face among all faces that a picture has recorded.
pub type FaceKey = u32;

/// Record of a face of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceRecord {
    /// Name of the object.
    pub name: String,
    /// Number of the object in its draw.
    pub object: u32,
    /// Number of the triangle in its object, in file order.
    pub triangle: u32,
    /// Clip positions in an order that is independent of the first corner and of the winding.
    positions: [DoubleDouble4; 3],
}

/// One accepted result for a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelState {
    /// Smallest accepted bytes.
    pub lo: [u8; 3],
    /// Largest accepted bytes.
    pub hi: [u8; 3],
    /// Smallest and largest accepted colour before quantization, unclamped.
    pub real: [DVec3; 2],
    /// Smallest and largest accepted depth in 0..=1.
    pub z: [DoubleDouble; 2],
    /// Face that wrote this depth.
    pub depth_owner: Option<FaceKey>,
    /// Face that was drawn last.
    pub drawn: Option<FaceKey>,
    /// True if a texture contributed to the colour.
    pub is_textured: bool,
}

/// Picture with all accepted results.
#[derive(Clone, Debug)]
pub struct TruthPicture {
    width: u32,
    height: u32,
    format: DepthFormat,
    /// State of untouched pixels, whose lists are empty.
    blank: PixelState,
    states: Vec<Vec<PixelState>>,
    free: Vec<bool>,
    faces: Vec<FaceRecord>,
}

/// Use of the depth memory by a fragment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DepthUse {
    /// Neither tested nor written.
    Ignore,
    /// Tested, not written: transparent faces.
    Test,
    /// Tested and written.
    TestAndWrite,
    /// Tested and written without a colour: faces that hide edges.
    DepthOnly,
    /// Tested as an edge of faces that are in the depth memory, and written: passes if not behind.
    Edge([DoubleDouble; 2]),
}

/// Fragment with the data for resolving it.
#[derive(Clone, Debug)]
pub struct Layer {
    /// The fragment.
    pub fragment: Fragment,
    /// Key of its face.
    pub face: FaceKey,
    /// Depth test and write.
    pub depth_use: DepthUse,
    /// True if it is blended over the pixel.
    pub is_transparent: bool,
    /// True if it is textured.
    pub is_textured: bool,
}

/// Quantizes a colour channel: floor(255 clamp(c, 0, 1) + 0.5); NaN counts as 0.
pub fn byte(c: f64) -> u8 {
    if c.is_nan() { 0 } else { (255.0 * c.clamp(0.0, 1.0) + 0.5).floor() as u8 }
}

fn bytes(c: DVec3) -> [u8; 3] {
    c.to_array().map(byte)
}

impl TruthPicture {
    /// Creates a cleared picture: opaque black, depth 1.
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

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the format of stored depths.
    pub fn depth_format(&self) -> DepthFormat {
        self.format
    }

    /// Returns the accepted results for pixel (x, y), at least one.
    ///
    /// # Panics
    /// If the pixel is off the picture.
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

    /// Returns each pixel's first accepted result.
    fn firsts(&self) -> impl Iterator<Item = &PixelState> {
        self.states.iter().map(|s| s.first().unwrap_or(&self.blank))
    }

    /// Returns whether pixel (x, y) has so many borderline decisions that any colour is accepted.
    pub fn is_free(&self, x: u32, y: u32) -> bool {
        self.free[(self.width * y + x) as usize]
    }

    /// Returns the record of a face.
    pub fn face(&self, key: FaceKey) -> &FaceRecord {
        &self.faces[key as usize]
    }

    /// Returns the RGBA bytes of each pixel's first accepted result, row 0 at the top.
    pub fn bytes(&self) -> Vec<u8> {
        self.firsts().flat_map(|s| [s.lo[0], s.lo[1], s.lo[2], 255]).collect()
    }

    /// Returns the unclamped colour of each pixel's first accepted result.
    pub fn real_colors(&self) -> Vec<[f64; 3]> {
        self.firsts().map(|s| s.real[0].to_array()).collect()
    }

    /// Returns the exact depth of each pixel's first accepted result.
    pub fn depths(&self) -> Vec<f64> {
        self.firsts().map(|s| s.z[0].to_f64()).collect()
    }

    /// Sets every pixel to `color` with depth 1, as CLEAR does.
    pub fn clear(&mut self, color: Rgba) {
        let rgb = [color[0], color[1], color[2]];
        let real = DVec3::from_array(rgb.map(|c| c as f64 / 255.0));
        self.blank =
            PixelState { z: [DoubleDouble::ONE; 2], depth_owner: None, ..painted(&self.blank, real) };
        self.states.iter_mut().for_each(Vec::clear);
        self.free.fill(false);
    }

    /// Fills the pixels of x0..x1, y0..y1 within the picture with a colour; depth is unchanged.
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

    /// Blends a colour over one pixel with the given opacity; depth is unchanged.
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

    /// Records a face and returns its key for layers.
    pub fn register(&mut self, name: &str, object: u32, triangle: u32, clip: [DoubleDouble4; 3]) -> FaceKey {
        let mut positions = clip;
        positions.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        self.faces.push(FaceRecord { name: name.to_owned(), object, triangle, positions });
        (self.faces.len() - 1) as FaceKey
    }

    /// Draws layers over pixel `index` (= width * y + x), in any one of the accepted orders.
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

    /// Draws one layer over each state, which is kept, replaced, or both.
    fn put(&self, layer: &Layer, states: &[PixelState]) -> Vec<PixelState> {
        let mut after = Vec::new();
        for state in states {
            let passes = match layer.depth_use {
                DepthUse::Ignore => Coverage::Yes,
                DepthUse::Test | DepthUse::TestAndWrite | DepthUse::DepthOnly => self.is_nearer(layer, state),
                DepthUse::Edge(z) => self.is_in_view(z, state),
            }
            .min(layer.fragment.presence);
            if passes != Coverage::No && layer.depth_use == DepthUse::DepthOnly {
                after.push(PixelState { z: layer.fragment.z, depth_owner: Some(layer.face), ..*state });
            } else if let DepthUse::Edge(_) = layer.depth_use
                && passes != Coverage::No
            {
                after.extend(self.draw_edge(layer, state));
            } else if passes != Coverage::No {
                after.extend(layer.fragment.colors.iter().map(|range| draw_over(layer, range, state)));
            }
            if passes != Coverage::Yes {
                after.push(*state);
            }
        }
        merge(&mut after);
        after
    }

    /// Draws an edge of a wireframe over a state, which keeps the nearer depth.
    fn draw_edge(&self, layer: &Layer, state: &PixelState) -> Vec<PixelState> {
        let nearer = if layer.is_transparent { Coverage::No } else { self.is_nearer(layer, state) };
        let mut after = Vec::new();
        for range in &layer.fragment.colors {
            let drawn = draw_over(layer, range, state);
            if nearer != Coverage::No {
                after.push(PixelState { z: layer.fragment.z, depth_owner: Some(layer.face), ..drawn });
            }
            if nearer != Coverage::Yes {
                after.push(drawn);
            }
        }
        after
    }

    /// Returns whether an edge at depth `z` is seen: it may lie two steps of the format behind the
    /// stored depth, and each of the two depths may be off by one.
    fn is_in_view(&self, z: [DoubleDouble; 2], state: &PixelState) -> Coverage {
        let step = match self.format {
            DepthFormat::F32 => ulp_f32(state.z[1].to_f64().min(1.0)),
            DepthFormat::Reversed => ulp_f32((DoubleDouble::ONE - state.z[1].min(z[0])).to_f64()),
            _ => 1.0 / self.format.steps().unwrap_or(1.0),
        };
        let steps = |n: f64| DoubleDouble::new(n * step);
        decide(z[1] <= state.z[0], z[0] > state.z[1] + steps(4.0))
    }

    /// Returns whether the depth that the fragment would store is strictly nearer than the stored
    /// one.
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

    /// Returns whether two faces certainly have equal depths: the same positions, or one constant
    /// depth.
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

/// Returns the distance from |x| to the next larger f32.
pub fn ulp_f32(x: f64) -> f64 {
    let bits = (x.abs() as f32).to_bits();
    (f32::from_bits(bits + 1) - f32::from_bits(bits)) as f64
}

/// Properties of a depth format for the reference.
pub trait StoredDepth {
    /// Returns the largest word of an integer format, or `None`.
    fn steps(self) -> Option<f64>;
    /// Returns the smallest and largest word that is accepted for depths z[0]..z[1]: within 0.501
    /// of a step.
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
        // A word w is accepted if |w - steps z| <= 0.501.
        let [lo, hi] = z.map(|z| z.max(DoubleDouble::ZERO).min(DoubleDouble::ONE) * DoubleDouble::new(steps));
        let least = (lo - DoubleDouble::new(0.501)).to_f64().ceil().max(0.0);
        let largest = (hi + DoubleDouble::new(0.501)).to_f64().floor().min(steps);
        [least as u64, largest as u64]
    }
}

/// Returns the state painted with a colour that belongs to no face.
fn painted(state: &PixelState, color: DVec3) -> PixelState {
    let rgb = bytes(color);
    PixelState { lo: rgb, hi: rgb, real: [color; 2], drawn: None, is_textured: false, ..*state }
}

/// Returns the state with a layer's colour drawn over it: new = old t + rgb (1 - t) on bytes, or
/// the colour alone if opaque.
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

/// Removes duplicates and keeps the order.
fn merge(states: &mut Vec<PixelState>) {
    let mut kept: Vec<PixelState> = Vec::with_capacity(states.len());
    for s in states.drain(..) {
        if !kept.contains(&s) {
            kept.push(s);
        }
    }
    *states = kept;
}

//! Split screen: one scene in two modes side by side, and their difference magnified.
//!
//! In: a scene and a [`Split`]. Out: a frame of four parts: the two pictures, below them the
//! difference |a - b|, times the factor that makes its largest byte 255, and what it says in
//! numbers. Captions stand under the pictures, never on them. No picture is smoothed: the
//! difference is that of the bytes.

use super::Wishes;
use super::difference::Difference;
use super::frame::ViewerFrame;
use super::keys::Look;
use super::scene3d::{Pass, Space, Tools};
use super::studio::Backdrop;
use fbptr_core::draw2d::font::CELL;
use fbptr_core::draw2d::look::{LESSER, MARGIN, TEXT, letters};
use fbptr_core::executor::Executor;
use fbptr_core::memory::{DepthFormat, Rgba, VideoMemory};
use fbptr_core::pipeline::{RenderOptions, RenderPath, Renderer};

/// Two modes that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Split {
    /// Gouraud shading and Phong shading.
    Shading,
    /// The plain path in f64, and the fast one.
    Path,
    /// Depth in f32 and in u16, with the near plane close to the eye.
    Depth,
}

/// Part of its distance at which the near plane stands when depth formats are compared: 16 bits
/// are then too few.
const NEAR_PART: f64 = 1.0 / 500.0;

/// Height of a caption.
const CAPTION: usize = 24;
/// Number of lines in the fourth part, and their distance before scaling.
const NUMBER_LINES: usize = 7;
const LINE_HEIGHT: usize = 12;

impl Split {
    /// Returns the next comparison; `None` after the last.
    pub(super) fn after(split: Option<Split>) -> Option<Split> {
        match split {
            None => Some(Split::Shading),
            Some(Split::Shading) => Some(Split::Path),
            Some(Split::Path) => Some(Split::Depth),
            Some(Split::Depth) => None,
        }
    }

    /// Returns the captions of both pictures.
    fn names(self) -> [&'static str; 2] {
        match self {
            Split::Shading => ["Gouraud: lit at the vertices", "Phong: lit at every pixel"],
            Split::Path => ["exact: f64, face by face", "fast: tiles, in vectors"],
            Split::Depth => ["depth in f32", "depth in u16"],
        }
    }

    /// Returns lines about why the pictures differ.
    fn reason(self) -> [&'static str; 2] {
        match self {
            Split::Shading => ["Corners' colours are mixed:", "highlights between get lost."],
            Split::Path => ["Both round the same formulas;", "the outlines are the same."],
            Split::Depth => ["The near plane is very near:", "16 bits mix up close faces."],
        }
    }
}

/// Memories of a split screen.
pub(super) struct SplitScreen {
    frames: [ViewerFrame; 2],
    /// The renderer of the plain path.
    plain: Renderer,
    backdrop: Backdrop,
}

impl SplitScreen {
    /// Creates the memories for a frame of `size`; `None` if it is too small.
    pub fn new(size: [u32; 2], options: &RenderOptions) -> Option<SplitScreen> {
        let [w, h] = Self::panel(size.map(|s| s as usize))?.map(|s| s as u32);
        let frames = [ViewerFrame::new([w, h]).ok()?, ViewerFrame::new([w, h]).ok()?];
        let plain = Renderer::new(RenderOptions { path: RenderPath::Plain, ..options.clone() });
        Some(SplitScreen { frames, plain, backdrop: Backdrop::default() })
    }

    /// Returns whether a frame of `size` has room for the pictures.
    pub fn fits(size: [u32; 2]) -> bool {
        Self::panel(size.map(|s| s as usize)).is_some()
    }

    /// Returns width and height of each picture.
    fn panel([width, height]: [usize; 2]) -> Option<[usize; 2]> {
        let w = width.checked_sub(3 * MARGIN)? / 2;
        let h = height.checked_sub(3 * MARGIN + 2 * CAPTION)? / 2;
        (w >= 8 && h >= 8).then_some([w, h])
    }

    /// Returns the rectangles of the text in a frame of `size` pixels: left, top, right, bottom.
    pub fn captions(size: [usize; 2]) -> Vec<[usize; 4]> {
        let Some([w, h]) = Self::panel(size) else { return Vec::new() };
        let [a, b, difference, [x, y]] = Self::places([w, h]);
        let below = |[x, y]: [usize; 2]| [x, y + h, x + w, y + h + CAPTION];
        let numbers = [x, y, x + w, y + NUMBER_LINES * LINE_HEIGHT * scale_of(w)];
        vec![below(a), below(b), below(difference), numbers]
    }

    /// Draws a scene in both modes into `memory`, whose size is that of [`SplitScreen::new`].
    pub fn draw(
        &mut self,
        split: Split,
        space: &mut Space,
        wishes: &Wishes,
        renderer: &mut Renderer,
        pool: &Executor,
        memory: &mut VideoMemory,
    ) -> Result<(), String> {
        for (i, frame) in self.frames.iter_mut().enumerate() {
            let mut wishes = Wishes { keeps_depth: split == Split::Depth, ..wishes.clone() };
            let (mut pass, mut with) = (Pass::default(), &mut *renderer);
            match (split, i) {
                (Split::Shading, 0) => wishes.look = Look::Gouraud,
                (Split::Shading, _) => wishes.look = Look::Phong,
                (Split::Path, 0) => with = &mut self.plain,
                (Split::Path, _) => {}
                (Split::Depth, i) => {
                    pass.near_part = Some(NEAR_PART);
                    frame.depth_format = [DepthFormat::F32, DepthFormat::U16][i];
                }
            }
            space.draw(&wishes, frame, Tools { renderer: with, pool }, pass)?;
        }
        let [a, b] = self.frames.each_ref().map(|f| f.memory.bytes());
        let difference = Difference::of_bytes(a, b);
        let size = [self.frames[0].memory.width() as usize, self.frames[0].memory.height() as usize];
        self.backdrop.paint(memory);
        let places = Self::places(size);
        for (bytes, at) in [a, b, &difference.rgba].into_iter().zip(places) {
            put(memory, at, bytes, size[0]);
        }
        write(memory, split, &difference, places, size);
        Ok(())
    }

    /// Returns the upper left corners of the four parts.
    fn places([w, h]: [usize; 2]) -> [[usize; 2]; 4] {
        let (right, low) = (2 * MARGIN + w, 2 * MARGIN + CAPTION + h);
        [[MARGIN, MARGIN], [right, MARGIN], [MARGIN, low], [right, low]]
    }
}

/// Returns the scale of the text beside and below pictures of `width` pixels: the longest line has
/// 28 letters.
fn scale_of(width: usize) -> usize {
    if width >= 28 * 2 * CELL { 2 } else { 1 }
}

/// Copies a picture of `width` pixels into a frame.
fn put(memory: &mut VideoMemory, [x, y]: [usize; 2], rgba: &[u8], width: usize) {
    let stride = memory.width() as usize * 4;
    let rows = memory.bytes_mut()[y * stride..].chunks_mut(stride);
    for (to, from) in rows.zip(rgba.chunks(width * 4)) {
        to[x * 4..(x + width) * 4].copy_from_slice(from);
    }
}

/// Writes the captions, and the fourth part's numbers.
fn write(
    memory: &mut VideoMemory,
    split: Split,
    difference: &Difference,
    places: [[usize; 2]; 4],
    [w, h]: [usize; 2],
) {
    let [left, right] = split.names();
    let scale = scale_of(w);
    let shown = format!("difference, x{}", difference.factor);
    let mut line = |at: [usize; 2], line: &str, color: Rgba, scale: usize| {
        let line: String = line.chars().take(w / CELL / scale).collect();
        letters(memory, at, &line, color, scale);
    };
    for ([x, y], name) in places.into_iter().zip([left, right, &shown]) {
        line([x, y + h + (CAPTION - CELL * scale) / 2], name, TEXT, scale);
    }
    let all = difference.rgba.len() / 4;
    let numbers = match difference.pixels {
        0 => [format!("no pixel of {all}"), "differs".to_owned()],
        n => [format!("{n} pixels differ of"), format!("{all}, by up to {}/255", difference.largest)],
    };
    let [x, y] = places[3];
    let lines = numbers.iter().map(|l| (l.as_str(), TEXT)).chain([("", TEXT)]);
    let lines =
        lines.chain(split.reason().map(|l| (l, LESSER))).chain([("", TEXT), ("V: the next two", LESSER)]);
    for (i, (words, color)) in lines.enumerate() {
        line([x, y + i * LINE_HEIGHT * scale], words, color, scale);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn captions_are_the_rectangles_of_all_text() {
        for size in [[1280u32, 720], [960, 720], [320, 240], [96, 128]] {
            let mut memory = VideoMemory::new(size[0], size[1]).expect("a frame");
            let panel = SplitScreen::panel(size.map(|s| s as usize)).expect("room");
            let difference = Difference::of_bytes(&[0, 0, 0, 255], &[9, 0, 0, 255]);
            write(&mut memory, Split::Shading, &difference, SplitScreen::places(panel), panel);
            let mut captions: Vec<([usize; 4], usize)> =
                SplitScreen::captions(size.map(|s| s as usize)).into_iter().map(|c| (c, 0)).collect();
            assert_eq!(captions.len(), 4);
            let blank = VideoMemory::new(1, 1).expect("a frame").get_pixel(0, 0);
            for (x, y) in (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x as usize, y as usize))) {
                if memory.get_pixel(x as i32, y as i32) != blank {
                    let holds = |c: &[usize; 4]| (c[0]..c[2]).contains(&x) && (c[1]..c[3]).contains(&y);
                    let count = captions.iter_mut().find(|(c, _)| holds(c));
                    count.unwrap_or_else(|| panic!("{size:?}: text at {x} {y}")).1 += 1;
                }
            }
            assert!(captions.iter().all(|(_, pixels)| *pixels > 0), "{size:?}: {captions:?}");
        }
    }
}

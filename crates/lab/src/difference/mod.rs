//! The difference of a drawn picture from the exact one, pixel by pixel, in words that teach.
//!
//! In: two pictures of one size, the difference that a channel may have, and, where the exact
//! picture was drawn from commands or a scene, its lines and faces on the screen. Out: a
//! [`WrongPixels`]: every wrong pixel in one [`Class`], with counts, places and a sentence each.
//!
//! Right is: the classes' counts sum to the number of wrong pixels; a pixel is in a class only if
//! the cause, applied to the exact picture, gives the bytes that were found (within two steps of
//! 255). What no cause explains is [`Class::Other`]. Where an ideal line passes midway between two
//! pixels, either is right, and neither is counted as wrong. One would know an error by a cause
//! that was put into a picture and comes out as another (the tests, with a control for each).
//!
//! Order of the causes: ties of lines, then what moved or scaled the whole picture, then lines,
//! double blending, other faces and edges by their geometry, then a law of colour over the whole
//! picture.

mod law;
mod page;
mod pixels;
mod shapes;
#[cfg(test)]
mod tests;
mod whole;
mod write;

use fbptr_core::memory::{Rgba, VideoMemory};
pub use law::Law;
pub use page::page_head;
use pixels::Pixels;
pub use shapes::{Geometry, Shape, Surface};
use shapes::{Judge, Verdict};
pub use whole::Whole;

/// Cause of a wrong pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Class {
    /// The whole picture is upside down, mirrored, shifted or scaled.
    Whole,
    /// Farther from the ideal line than half a pixel, or missing because of such a pixel.
    OutsideLine,
    /// All of a line is missing, but perhaps its ends.
    MissingLine,
    /// A line's pixels up to its end are missing.
    MissingAtEnd,
    /// A pixel inside a line is missing.
    GapInLine,
    /// A line's colour belongs to another place of its ramp.
    Ramp,
    /// A transparent colour was blended twice.
    CountedTwice,
    /// Another face, which is farther away, is in front.
    OtherFace,
    /// A pixel on an edge went to the face on the other side.
    Edge,
    /// The colour follows from the exact one by a law.
    ColorLaw,
    /// Drawn where the exact picture has its background.
    Extra,
    /// Background where the exact picture has something.
    Missing,
    /// Not explained.
    Other,
}

impl Class {
    /// All classes, in the order of the texts.
    pub const ALL: [Class; 13] = [
        Class::Whole,
        Class::OutsideLine,
        Class::MissingLine,
        Class::MissingAtEnd,
        Class::GapInLine,
        Class::Ramp,
        Class::CountedTwice,
        Class::OtherFace,
        Class::Edge,
        Class::ColorLaw,
        Class::Extra,
        Class::Missing,
        Class::Other,
    ];

    /// Returns the name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Class::Whole => "whole",
            Class::OutsideLine => "outside-line",
            Class::MissingLine => "missing-line",
            Class::MissingAtEnd => "missing-at-end",
            Class::GapInLine => "gap-in-line",
            Class::Ramp => "ramp",
            Class::CountedTwice => "counted-twice",
            Class::OtherFace => "other-face",
            Class::Edge => "edge",
            Class::ColorLaw => "color",
            Class::Extra => "extra",
            Class::Missing => "missing",
            Class::Other => "other",
        }
    }
}

/// The wrong pixels of one class.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Their cause.
    pub class: Class,
    /// Their number.
    pub pixels: u64,
    /// The cause in words, with its numbers.
    pub text: String,
    /// The first of them (x, y), row by row.
    pub examples: Vec<[u32; 2]>,
}

/// The wrong pixels of a picture, by their causes.
#[derive(Clone, Debug)]
pub struct WrongPixels {
    /// Width and height of the drawn picture.
    pub size: [u32; 2],
    /// Width and height of the exact picture.
    pub exact_size: [u32; 2],
    /// Number of wrong pixels.
    pub wrong: u64,
    /// Number of pixels that differ, and are right because the ideal line passes midway.
    pub ties: u64,
    /// Largest difference of a channel at a wrong pixel.
    pub largest: u8,
    /// The classes that occur, in the order of [`Class::ALL`].
    pub findings: Vec<Finding>,
    mine: Vec<u8>,
    exact: Vec<u8>,
    /// Class of each pixel.
    classes: Vec<Option<Class>>,
}

/// Number of places that a finding has.
const EXAMPLES: usize = 4;

impl WrongPixels {
    /// Compares `mine` with `exact`; a pixel is wrong if one of its channels differs by more than
    /// `per_channel`. `geometry` is that of the exact picture, where it is known.
    pub fn new(
        mine: &VideoMemory,
        exact: &VideoMemory,
        per_channel: u8,
        geometry: Option<&Geometry<'_>>,
    ) -> WrongPixels {
        let size = |m: &VideoMemory| [m.width(), m.height()];
        let mut difference = WrongPixels {
            size: size(mine),
            exact_size: size(exact),
            wrong: 0,
            ties: 0,
            largest: 0,
            findings: Vec::new(),
            mine: mine.bytes().to_vec(),
            exact: exact.bytes().to_vec(),
            classes: Vec::new(),
        };
        if difference.size != difference.exact_size {
            return difference;
        }
        let pixels = Pixels::new(mine, exact, per_channel);
        let judge = geometry.map(|geometry| Judge::new(geometry, &pixels));
        let mut wrong = pixels.wrong();
        let before = wrong.len();
        if let Some(judge) = &judge {
            wrong.retain(|&at| !judge.is_tie(at));
        }
        difference.ties = (before - wrong.len()) as u64;
        difference.wrong = wrong.len() as u64;
        difference.largest = wrong.iter().map(|&at| pixels.distance(at)).max().unwrap_or(0);
        difference.classify(&pixels, judge.as_ref(), geometry.is_some_and(|g| g.is_complete), &wrong);
        difference
    }

    /// Returns whether no pixel is wrong.
    pub fn is_equal(&self) -> bool {
        self.size == self.exact_size && self.wrong == 0
    }

    /// Puts every wrong pixel into its class.
    fn classify(
        &mut self,
        pixels: &Pixels<'_>,
        judge: Option<&Judge<'_>>,
        is_complete: bool,
        wrong: &[[u32; 2]],
    ) {
        let judged = |allow: bool| -> Vec<Option<Verdict>> {
            wrong.iter().map(|&at| judge.and_then(|judge| judge.verdict(at, allow))).collect()
        };
        let mut verdicts = judged(true);
        let behind = verdicts.iter().flatten().filter(|v| v.class == Class::OtherFace).count();
        // A wrong order shows a hidden face nearly wherever there is one; shades of one surface do by
        // accident.
        if behind > 0 && behind * 10 < judge.map_or(0, |judge| judge.hidden(wrong)) * 6 {
            verdicts = judged(false);
        }
        let exact_edges = verdicts.iter().flatten().filter(|v| v.is_certain).count();
        // A wrong rule at the edges of upright boxes looks like a shift.
        let whole = match exact_edges * 10 >= wrong.len() * 9 {
            true => None,
            // What figures explain, only a change that explains all of it explains better.
            false => {
                let explained = verdicts.iter().flatten().count();
                Whole::find(pixels, wrong, if explained * 10 >= wrong.len() * 9 { 100 } else { 10 })
            }
        };
        let (law, explained) = Law::find(pixels, wrong);
        let mut words = Words { whole, law, ..Words::default() };
        for (i, &at) in wrong.iter().enumerate() {
            let by_law = law.is_some() && explained[i];
            let class = match verdicts[i].take() {
                _ if words.whole.is_some() => Class::Whole,
                // Nearly everything follows one law, and a face's colour by accident.
                Some(v) if !(by_law && v.class == Class::OtherFace && law.is_some_and(|l| l.is_clear())) => {
                    words.note(&v);
                    v.class
                }
                // Any two colours follow some law.
                _ if by_law && (law.is_some_and(|l| l.is_clear()) || !pixels.is_from_neighbor(at)) => {
                    Class::ColorLaw
                }
                _ => pixels.class(at, is_complete),
            };
            words.count(class, at);
        }
        self.classes = vec![None; self.size[0] as usize * self.size[1] as usize];
        for (class, places) in Class::ALL.iter().zip(&words.places) {
            for &[x, y] in places {
                self.classes[(y * self.size[0] + x) as usize] = Some(*class);
            }
            if !places.is_empty() {
                self.findings.push(Finding {
                    class: *class,
                    pixels: places.len() as u64,
                    text: words.text(*class),
                    examples: places.iter().copied().take(EXAMPLES).collect(),
                });
            }
        }
    }
}

/// What the sentences of the findings need.
#[derive(Debug, Default)]
struct Words {
    whole: Option<Whole>,
    law: Option<Law>,
    /// Places of each class.
    places: [Vec<[u32; 2]>; 13],
    /// Largest distance from the ideal line, and the line.
    outside: Option<(f64, String)>,
    /// First line of a class.
    subjects: [Option<String>; 13],
    on_edge: u64,
    beside_edge: f64,
}

impl Words {
    fn count(&mut self, class: Class, at: [u32; 2]) {
        self.places[class as usize].push(at);
    }

    fn note(&mut self, verdict: &Verdict) {
        if let (Class::OutsideLine, Some(d)) = (verdict.class, verdict.distance)
            && self.outside.as_ref().is_none_or(|(most, _)| d > *most)
        {
            self.outside = Some((d, verdict.subject.clone()));
        }
        if verdict.class == Class::Edge {
            match verdict.distance {
                Some(0.0) => self.on_edge += 1,
                d => self.beside_edge = self.beside_edge.max(d.unwrap_or(0.0)),
            }
        }
        self.subjects[verdict.class as usize].get_or_insert_with(|| verdict.subject.clone());
    }

    /// Returns the sentence of a class.
    fn text(&self, class: Class) -> String {
        let subject = self.subjects[class as usize].as_deref().unwrap_or("");
        match class {
            Class::Whole => self.whole.map(|whole| whole.to_string()).unwrap_or_default(),
            Class::OutsideLine => match &self.outside {
                Some((d, line)) => format!(
                    "outside the ideal line by {d:.2} pixel at most, where 0.50 is allowed, and the pixels \
                     that they replace: {line}"
                ),
                None => format!("missing beside a pixel outside the ideal line: {subject}"),
            },
            Class::MissingLine => format!("a whole line is missing: {subject}"),
            Class::MissingAtEnd => format!(
                "missing at the end: both ends of a line belong to it, so a line of n steps has n + 1 \
                 pixels: {subject}"
            ),
            Class::GapInLine => format!("missing inside a line: {subject}"),
            Class::Ramp => format!(
                "the line's colour of another place: at step k of n it is c0 + (c1 - c0) k/n: {subject}"
            ),
            Class::CountedTwice => format!(
                "blended twice: each pixel of one figure is blended once, on seams and joints too: {subject}"
            ),
            Class::OtherFace => format!(
                "another face is in front: it is farther away than the right one (depth test, or the order \
                 of drawing): {subject}"
            ),
            Class::Edge if self.on_edge > 0 || self.beside_edge > 0.0 => self.edge_text(),
            Class::Edge => "an edge pixel has the colour across the edge: by the fill rule it belongs to \
                            the side on which its centre lies"
                .to_owned(),
            Class::ColorLaw => self.law.map(|law| law.to_string()).unwrap_or_default(),
            Class::Extra => "drawn where the exact picture has its background".to_owned(),
            Class::Missing => "background where the exact picture has something".to_owned(),
            Class::Other => "another colour, by no law that was found".to_owned(),
        }
    }

    fn edge_text(&self) -> String {
        let mut text = "edge pixels on the wrong side".to_owned();
        if self.on_edge > 0 {
            text += &format!(
                ": the centre of {} lies on the edge itself, where the top-left rule gives it to the face \
                 below or right of the edge",
                self.on_edge
            );
        }
        if self.beside_edge > 0.0 {
            text += &format!(
                "{}centres up to {:.2} pixel beside the edge belong to the side on which they lie",
                if self.on_edge > 0 { "; " } else { ": " },
                self.beside_edge
            );
        }
        text
    }
}

/// Returns the largest difference of a channel.
fn distance(a: Rgba, b: Rgba) -> u8 {
    (0..4).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0)
}

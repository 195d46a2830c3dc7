//! The rendered picture: facet, distance, lit flags and colour of every pixel, with JSON input and
//! output and comparison.
//!
//! Flat arrays, axis 1 (left to right) fastest, then axis 2 (top to bottom), then the others.
//! Colours are reals in 0..=255, not rounded.

use super::error::EyeError;
use super::json::Node;
use super::scene::EyeScene;
use serde_json::Value;
use std::fmt::Write;

/// Facet index of a pixel that sees nothing.
pub const MISS: i32 = -1;

/// The rendered picture of an N-dimensional scene.
#[derive(Clone, Debug, PartialEq)]
pub struct EyePicture {
    /// Pixels along each screen axis.
    pub pixels: Vec<u32>,
    /// Number of lights of the scene: flags for each pixel in `lit`.
    pub lights: usize,
    /// Index of the facet seen by each pixel, or [`MISS`].
    pub facet: Vec<i32>,
    /// Distance of the point seen from the eye, in units of the scene; infinite on a miss.
    pub dist: Vec<f64>,
    /// True for each light that reaches the point seen; `lights` flags for each pixel, false on a
    /// miss.
    pub lit: Vec<bool>,
    /// Colour of each pixel, 0..=255 for each channel.
    pub color: Vec<[f64; 3]>,
    /// Indices of degenerate facets, which are not drawn, ascending.
    pub skipped_facets: Vec<u32>,
}

impl EyePicture {
    /// Creates the empty picture of a scene: background everywhere.
    pub(super) fn background(scene: &EyeScene) -> Self {
        let (count, lights) = (scene.pixel_count(), scene.lights.len());
        EyePicture {
            pixels: scene.pixels.clone(),
            lights,
            facet: vec![MISS; count],
            dist: vec![f64::INFINITY; count],
            lit: vec![false; count * lights],
            color: vec![scene.background; count],
            skipped_facets: Vec::new(),
        }
    }

    /// Returns the lit flags of pixel `index`.
    pub fn flags(&self, index: usize) -> &[bool] {
        &self.lit[index * self.lights..(index + 1) * self.lights]
    }

    /// Returns the picture as JSON `{facet, dist, lit, color, skipped_facets}`. On a miss `dist` is
    /// null and `lit` []. Numbers are in the shortest form that reads back to the same bits.
    pub fn to_json(&self) -> String {
        let count = self.facet.len();
        let mut out = String::with_capacity(count * 64);
        list(&mut out, "{\"facet\":", 0..count, |out, i| write!(out, "{}", self.facet[i]));
        list(&mut out, ",\"dist\":", 0..count, |out, i| match self.facet[i] {
            MISS => write!(out, "null"),
            _ => write!(out, "{:?}", self.dist[i]),
        });
        list(&mut out, ",\"lit\":", 0..count, |out, i| {
            let flags = if self.facet[i] == MISS { &[] } else { self.flags(i) };
            list(out, "", 0..flags.len(), |out, l| write!(out, "{}", flags[l]));
            Ok(())
        });
        list(&mut out, ",\"color\":", 0..count, |out, i| {
            let [r, g, b] = self.color[i];
            write!(out, "[{r:?},{g:?},{b:?}]")
        });
        list(&mut out, ",\"skipped_facets\":", 0..self.skipped_facets.len(), |out, i| {
            write!(out, "{}", self.skipped_facets[i])
        });
        out.push('}');
        out
    }

    /// Reads a picture of `scene` from `{facet, dist, lit, color, skipped_facets}`. A `fragile`
    /// list is allowed and ignored.
    pub fn from_value(value: &Value, scene: &EyeScene) -> Result<Self, EyeError> {
        let root = Node { value, path: "expected".into() };
        root.object(&["facet", "dist", "lit", "color", "fragile", "skipped_facets"])?;
        let mut picture = EyePicture::background(scene);
        let count = picture.facet.len();
        let lists = ["facet", "dist", "lit", "color"].map(|key| root.field(key).and_then(|n| n.array()));
        let [facet, dist, lit, color] = lists;
        let (facet, dist, lit, color) = (facet?, dist?, lit?, color?);
        for (name, list) in [("facet", &facet), ("dist", &dist), ("lit", &lit), ("color", &color)] {
            if list.len() != count {
                let (path, expected) = (format!("expected.{name}"), count.to_string());
                return Err(EyeError::Length { path, expected, found: list.len() });
            }
        }
        for i in 0..count {
            picture.facet[i] = facet[i].number()? as i32;
            picture.color[i] = color[i].triple()?;
            if picture.facet[i] == MISS {
                continue;
            }
            picture.dist[i] = dist[i].number()?;
            let flags = lit[i].array()?;
            if flags.len() != picture.lights {
                let (path, expected) = (lit[i].path.clone(), picture.lights.to_string());
                return Err(EyeError::Length { path, expected, found: flags.len() });
            }
            for (l, flag) in flags.iter().enumerate() {
                picture.lit[i * picture.lights + l] = flag.value.as_bool().ok_or_else(|| EyeError::Type {
                    path: flag.path.clone(),
                    expected: "true or false".into(),
                    found: flag.value.to_string(),
                })?;
            }
        }
        let skipped = root.optional("skipped_facets").map_or(Ok(Vec::new()), |n| n.numbers())?;
        picture.skipped_facets = skipped.into_iter().map(|i| i as u32).collect();
        Ok(picture)
    }

    /// Compares this picture with `other`, ignoring the pixels whose flat indices are in `fragile`.
    ///
    /// # Panics
    /// Panics if the pictures differ in their number of pixels or lights.
    pub fn differences(&self, other: &EyePicture, fragile: &[usize]) -> Differences {
        assert_eq!((&self.pixels, self.lights), (&other.pixels, other.lights), "pictures of one screen");
        let mut out =
            Differences { skipped: self.skipped_facets != other.skipped_facets, ..Differences::default() };
        for i in (0..self.facet.len()).filter(|i| !fragile.contains(i)) {
            let before = (out.facets, out.flags);
            out.facets += usize::from(self.facet[i] != other.facet[i]);
            out.flags += usize::from(self.flags(i) != other.flags(i));
            if (out.facets, out.flags) != before && out.first.is_none() {
                out.first = Some(i);
            }
            if self.dist[i] != other.dist[i] {
                let (a, b) = (self.dist[i], other.dist[i]);
                let off = (a - b).abs() / b.abs().max(1.0);
                // A hit against a miss counts as an infinite difference.
                out.distance = out.distance.max(if off.is_nan() { f64::INFINITY } else { off });
            }
            for c in 0..3 {
                out.color = out.color.max((self.color[i][c] - other.color[i][c]).abs());
            }
        }
        out
    }
}

/// Appends a name and a JSON array.
fn list(
    out: &mut String,
    name: &str,
    entries: std::ops::Range<usize>,
    mut entry: impl FnMut(&mut String, usize) -> std::fmt::Result,
) {
    out.push_str(name);
    out.push('[');
    for i in entries.clone() {
        if i > entries.start {
            out.push(',');
        }
        entry(out, i).expect("writing to a string cannot fail");
    }
    out.push(']');
}

/// Differences between two pictures.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// Number of pixels that see another facet.
    pub facets: usize,
    /// Number of pixels with other lit flags.
    pub flags: usize,
    /// Largest difference of distances, relative for distances above 1.
    pub distance: f64,
    /// Largest difference of a colour channel, in the unit of 0..=255.
    pub color: f64,
    /// True if the lists of skipped facets differ.
    pub skipped: bool,
    /// Index of the first pixel whose facet or flags differ.
    pub first: Option<usize>,
}

impl Differences {
    /// Returns whether the pictures agree within the test cases' tolerances: facets and flags
    /// equal, distance within 1e-9, colour within 1e-6.
    pub fn are_none(&self) -> bool {
        self.facets == 0 && self.flags == 0 && !self.skipped && self.distance <= 1e-9 && self.color <= 1e-6
    }
}

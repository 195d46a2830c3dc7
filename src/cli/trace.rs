//! `--trace`: prints the intermediate numbers of a triangle or pixel on stdout.

use super::output;
use crate::memory::DepthFormat;
use crate::pipeline::SceneOptions;
use crate::pipeline::trace::{Probe, trace_scene};
use crate::scene::Scene;
use std::str::FromStr;

/// Parsed argument `N`, `X,Y` or `N@X,Y`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TraceAt(Probe);

impl FromStr for TraceAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "expected the number of a triangle (7), a pixel (320,200) or both (7@320,200), found {text:?}"
            )
        };
        let triangle = |s: &str| s.parse::<u64>().map_err(|_| expected());
        let pixel = |s: &str| {
            let (x, y) = s.split_once(',')?;
            Some((x.trim().parse::<i32>().ok()?, y.trim().parse::<i32>().ok()?))
        };
        let pixel = |s: &str| pixel(s).ok_or_else(expected);
        Ok(TraceAt(match text.split_once('@') {
            Some((number, place)) => {
                let (x, y) = pixel(place)?;
                Probe::TriangleAt(triangle(number)?, x, y)
            }
            None if text.contains(',') => {
                let (x, y) = pixel(text)?;
                Probe::Pixel(x, y)
            }
            None => Probe::Triangle(triangle(text)?),
        }))
    }
}

impl TraceAt {
    /// Returns the triangle or pixel to trace.
    pub(super) fn probe(self) -> Probe {
        self.0
    }
}

/// Prints the numbers of one triangle or pixel of `scene`, drawn with `options` into a frame of
/// `size`.
pub(super) fn print(
    scene: &Scene,
    options: &SceneOptions,
    size: [u32; 2],
    TraceAt(probe): TraceAt,
) -> Result<(), String> {
    if let Probe::Pixel(x, y) = probe {
        let is_inside = |v: i32, end: u32| u32::try_from(v).is_ok_and(|v| v < end);
        let [width, height] = size;
        if !is_inside(x, width) || !is_inside(y, height) {
            return Err(format!("--trace: pixel ({x}, {y}) is outside the frame of {width} x {height}"));
        }
    }
    let trace = trace_scene(scene, options, size, DepthFormat::default(), probe)
        .map_err(|e| format!("--trace: {e}"))?;
    output::print(format!("{trace}\n"));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_triangle_a_pixel_or_both() {
        let probe = |text: &str| text.parse().map(|TraceAt(p)| p);
        assert_eq!(probe("7"), Ok(Probe::Triangle(7)));
        assert_eq!(probe("3,-4"), Ok(Probe::Pixel(3, -4)));
        assert_eq!(probe("7@3, 4"), Ok(Probe::TriangleAt(7, 3, 4)));
        for wrong in ["", "-1", "a", "1,", "1,2,3", "@1,2", "1@2", "1@", "99999999999999999999"] {
            assert!(probe(wrong).is_err(), "{wrong:?}");
        }
    }
}

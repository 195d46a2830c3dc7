//! Stages 8 and 9 at one pixel: attributes on the face's plane, then its colour, in f64.
//!
//! In: an assembled face, the inputs of its shading, a pixel. Out: its colour and opacity. Both
//! render paths use it: the reference for every pixel, the tile renderer where f32 is too coarse.

use super::assemble::Face;
use super::draw_call::DrawStats;
use super::light::Lighting;
use super::plane_equation::{FacePlane, Weights};
use super::sampler::Footprint;
use super::shade::{FaceShade, uv_from_first};
use super::viewport::ViewportTransform;
use crate::scene::Interpolation;
use glam::{DVec2, DVec3};

/// Rules of a draw by which a face's attributes and colour at a pixel are found.
#[derive(Clone, Copy)]
pub(crate) struct PixelRules<'r> {
    /// NDC to pixels.
    pub screen: &'r ViewportTransform,
    pub lighting: &'r Lighting,
    /// Interpolation of attributes.
    pub interp: Interpolation,
    /// True unless w is 1 everywhere.
    pub divide: bool,
}

impl Face {
    /// Returns the colour and opacity of the face at the centre of a pixel; `None` where its plane
    /// has no point in front of the eye.
    pub fn pixel(
        &self,
        shade: &FaceShade,
        [x, y]: [i32; 2],
        rules: &PixelRules,
        stats: &mut DrawStats,
    ) -> Option<(DVec3, f64)> {
        if let Some(solid) = shade.solid() {
            return Some(solid);
        }
        let weights = self.plane.clamped(self.plane.weights_at(rules.screen.ndc_of_pixel(x, y)))?;
        self.color_at(&weights, shade, [x, y], rules, stats)
    }

    /// Stages 8 and 9: returns the interpolated colour at these weights.
    #[inline]
    pub fn color_at(
        &self,
        weights: &Weights,
        shade: &FaceShade,
        at: [i32; 2],
        rules: &PixelRules,
        stats: &mut DrawStats,
    ) -> Option<(DVec3, f64)> {
        let PixelRules { screen, lighting, interp, divide } = *rules;
        let plane = &self.plane;
        let shares_of = |weights: &Weights| plane.barycentrics(weights, interp, divide);
        let barycentrics = shares_of(weights)?;
        let footprint = |uv: &[DVec2; 3]| footprint(plane, screen, shares_of, at, uv);
        Some(shade.at(barycentrics, footprint, lighting, stats))
    }
}

/// Returns the steps of u, v from a pixel to its neighbours on the right and below, on the face's
/// plane.
pub(crate) fn footprint(
    plane: &FacePlane,
    screen: &ViewportTransform,
    shares_of: impl Fn(&Weights) -> Option<[f64; 3]>,
    [x, y]: [i32; 2],
    uv: &[DVec2; 3],
) -> Footprint {
    let at = |x: i32, y: i32| {
        let ndc = screen.ndc_of_pixel(x, y);
        shares_of(&plane.weights_at(ndc)).map(|s| uv_from_first(uv, s))
    };
    match (at(x, y), at(x + 1, y), at(x, y + 1)) {
        (Some(here), Some(right), Some(below)) => Footprint::Steps(right - here, below - here),
        _ => Footprint::Horizon,
    }
}

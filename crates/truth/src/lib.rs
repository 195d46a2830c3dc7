//! Reference renderer: written directly from the formulas, it defines which pictures are correct.
//!
//! In: a [`Scene`](fbptr_core::scene::Scene) and [`Settings`]. Out: a [`TruthPicture`], which holds
//! for each pixel every result that the specification accepts: bytes, unclamped colour, exact
//! depth, and the visible face. Nearly everywhere that is one result; where an exact decision is
//! borderline, both sides are accepted.
//!
//! It is independent of the pipeline, so that an error must be made twice to go unnoticed: they
//! share only the scene's data types. Matrices, planes, depths and texture coordinates are computed
//! with 32 digits ([`DoubleDouble`]), pixel by pixel, from homogeneous coordinates (a face through
//! the eye plane needs no clipping); coverage is tested at each pixel's centre in integers. It is
//! slow: for pictures of some 10^4 pixels and scenes of some 10^3 faces.
//!
//! Accepted at borderline decisions: 2 ulp of stored depth (0.501 of a step for integers), 1/256
//! texel for `nearest`, 1e-6 of a mip level, of N.L = 0, of a spot's edge; a centre covered by the
//! snapped outline but outside the true face; 1.5/256 pixel around the outline of a face with some
//! w <= 0; a snapping tie that lies within the rounding error of plain f64; the order of faces
//! whose sorting keys agree to 12 digits.
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

mod camera;
pub mod compare;
mod coverage;
mod double_double;
pub mod eye;
mod face;
mod fragment;
mod hard_cases;
mod light;
mod lines;
mod maps;
pub mod metrics;
mod normals;
mod picture;
mod pixel_mask;
mod rational;
mod render;
pub mod scenes;
mod settings;
mod sky;
mod texture;

pub use camera::{Sight, ViewerPosition};
pub use compare::{Comparison, compare};
pub use coverage::{Coverage, Outline};
pub use double_double::DoubleDouble;
pub use hard_cases::hard_cases;
pub use picture::{FaceKey, FaceRecord, PixelState, TruthPicture, byte, ulp_f32};
pub use rational::Rational;
pub use render::{render, render_pixels};
pub use settings::{Settings, Transparency};

#[cfg(test)]
mod golden;

#[cfg(test)]
mod tests {
    use super::render;
    use super::scenes::random;

    #[test]
    fn a_seed_gives_one_scene_and_scenes_show_something() {
        assert_eq!(format!("{:?}", random(5)), format!("{:?}", random(5)));
        let mut drawn = 0;
        for seed in 0..30 {
            let case = random(seed);
            let truth = render(&case.scene, case.width, case.height, case.format, &case.settings).unwrap();
            let pixels = case.width * case.height;
            let seen = (0..pixels)
                .filter(|i| truth.states(i % case.width, i / case.width).iter().any(|s| s.drawn.is_some()));
            drawn += u32::from(seen.count() as u32 > pixels / 20);
        }
        assert!(drawn > 15, "only {drawn} of 30 random scenes show something");
    }
}

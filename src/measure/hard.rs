//! Numerical stability: every hard case, what is promised of it, what was measured, and whether it holds.

use super::experiment::Bound;
use super::picture::{draw_case, truth};
use crate::eye::{EyeScene, render as render_eye};
use crate::memory::DepthFormat;
use crate::truth::compare::compare;
use crate::truth::hard_cases;
use crate::truth::scenes::{Case, Random};
use serde_json::json;

/// One hard case.
#[derive(Clone, Debug, PartialEq)]
pub struct HardRow {
    /// What it is.
    pub case: String,
    /// What theory or the specification says of it.
    pub promise: String,
    /// What was found.
    pub measured: String,
    /// Whether the promise is kept.
    pub passed: bool,
}

/// All hard cases, the limits of f32, and the eye at all scales. `progress` hears of each part before it begins.
pub fn hard(progress: &mut dyn FnMut(&str)) -> Vec<HardRow> {
    progress("Hard cases through the pipeline");
    let mut rows: Vec<HardRow> = hard_cases().iter().map(through_the_pipeline).collect();
    progress("Limits of f32");
    rows.extend(limits_of_f32());
    progress("The eye at all scales");
    rows.extend(eye_scales());
    rows
}

/// What the specification allows for a case.
fn promise(case: &Case) -> String {
    let depth = match case.format {
        DepthFormat::F32 => "depth to 2 ulp or 4e-7",
        DepthFormat::Reversed => "depth to 4 ulp of what is stored",
        _ => "depth to 0.501 of a step",
    };
    let textured = case.scene.objects.iter().any(|o| o.texture.is_some());
    format!("0 pixels off in coverage, colour to {}/255, {depth}", if textured { 2 } else { 1 })
}

fn through_the_pipeline(case: &Case) -> HardRow {
    let drawn = draw_case(case);
    let report = compare(&drawn.memory, drawn.depth.as_ref(), &truth(case));
    let measured = format!(
        "off: coverage {}, colour {}, depth {}; colour to {}/255, depth to {:.2} of its limit{}",
        report.coverage_off,
        report.color_off,
        report.depth_off,
        report.max_color,
        report.max_depth,
        if report.turns > 0 {
            format!("; {} of {} pixels may be either way", report.turns, report.pixels)
        } else {
            String::new()
        }
    );
    HardRow { case: case.name.clone(), promise: promise(case), measured, passed: report.is_right() }
}

/// The largest power of two at which `holds`, from 2^-30 on.
fn last_power_that(holds: impl Fn(f64) -> bool) -> f64 {
    let mut last = 0.0;
    for k in -30..60 {
        let x = libm::exp2(k as f64);
        if !holds(x) {
            break;
        }
        last = x;
    }
    last
}

/// A limit as theory has it and as it is found, which must be the same power of two.
fn limit(case: &str, theory: (f64, &str), found: f64) -> HardRow {
    HardRow {
        case: case.into(),
        promise: format!("f32 holds to {:e} {}", theory.0, theory.1),
        measured: format!("holds to {found:e}, fails at {:e}", 2.0 * found),
        passed: found == theory.0,
    }
}

fn limits_of_f32() -> Vec<HardRow> {
    let spacing = |x: f64| crate::truth::ulp_f32(x);
    let texels = last_power_that(|x| spacing(x) <= 1.0 / 256.0);
    let pixels = last_power_that(|x| spacing(x) <= 1.0 / 256.0 && (x as f32 + 1.0 / 256.0) as f64 > x);
    // An edge function of corners 2^k apart, asked half a unit from the edge: products of 2^(2k).
    let edge = last_power_that(|x| {
        let (d, p) = ([x as f32, x as f32 - 1.0], [x as f32 * 0.5, (x as f32 - 1.0) * 0.5 + 0.5]);
        d[0] * p[1] - d[1] * p[0] != 0.0
    });
    let exponent = last_power_that(|n| {
        let x = 1.0f32 - f32::EPSILON;
        (libm::pow(x as f64, n) - libm::pow(1.0 - 2.0 * f32::EPSILON as f64, n)).abs() < 0.5 / 255.0
    });
    vec![
        limit(
            "a texture coordinate in f32, to 1/256 texel",
            (65_536.0 / 2.0, "texels from the origin"),
            texels,
        ),
        limit("a screen coordinate in f32, to 1/256 pixel", (32_768.0, "pixels"), pixels),
        limit("the edge function in f32, half a unit beside the edge", (16_777_216.0, "units"), edge),
        limit("Phong's power of a cosine in f32, to half a step", (8192.0 * 2.0, "as exponent"), exponent),
    ]
}

/// The same world in units from 1e-6 to 1e6: the same facets, distances that scale with it.
fn eye_scales() -> Vec<HardRow> {
    let picture = |scale: f64| {
        let mut r = Random::new(77);
        let facets: Vec<_> = (0..20)
            .map(|_| {
                let c = [r.real(3.0, 6.0), r.real(-1.0, 1.0), r.real(-1.0, 1.0)];
                let v: Vec<Vec<f64>> =
                    (0..3).map(|_| c.iter().map(|c| scale * (c + r.real(-0.7, 0.7))).collect()).collect();
                json!({ "v": v, "color": [200, 100, 50] })
            })
            .collect();
        let text = json!({
            "dim": 3, "pixels": [64], "d": scale, "S": [1.6 * scale], "aperture_tan": [0.5], "I_d": 0.3,
            "view": { "k": 2, "n": 1 }, "lights": [], "facets": facets,
        });
        let scene =
            EyeScene::from_json(text.to_string().as_bytes()).expect("a scene of this file's own making");
        render_eye(&scene)
    };
    let unit = picture(1.0);
    [1e-6, 1e-3, 1e3, 1e6]
        .map(|scale| {
            let scaled = picture(scale);
            let other = unit.facet.iter().zip(&scaled.facet).filter(|(a, b)| a != b).count();
            let off = unit.dist.iter().zip(&scaled.dist).filter(|(a, _)| a.is_finite());
            let worst = off.fold(0f64, |m, (a, b)| m.max((b / scale / a - 1.0).abs()));
            let bounds = [Bound { column: 0, at_most: 0.0 }, Bound { column: 1, at_most: 1e-12 }];
            HardRow {
                case: format!("an N-dimensional world in units of {scale:e}"),
                promise: format!("the same facets, distances to {:e} of themselves", bounds[1].at_most),
                measured: format!("{other} other facets, distances to {worst:.1e}"),
                passed: other as f64 <= bounds[0].at_most && worst <= bounds[1].at_most,
            }
        })
        .to_vec()
}

//! Numerical stability: the hard cases with the promised and the measured results.

use super::experiment::Bound;
use super::picture::{draw_case, truth};
use crate::eye::{EyeScene, render as render_eye};
use crate::memory::DepthFormat;
use crate::truth::compare::compare;
use crate::truth::hard_cases;
use crate::truth::scenes::{Case, Random};
use serde_json::json;

/// Result of one hard case.
#[derive(Clone, Debug, PartialEq)]
pub struct HardRow {
    /// Name of the case.
    pub case: String,
    /// Result promised by theory or by the specification.
    pub promise: String,
    /// Measured result.
    pub measured: String,
    /// True if the promise is kept.
    pub passed: bool,
}

/// Runs all hard cases, the limits of f32, and the eye at all scales. `progress` is called with the
/// title of each part before it begins.
pub fn hard(progress: &mut dyn FnMut(&str)) -> Vec<HardRow> {
    progress("Hard cases through the pipeline");
    let mut rows: Vec<HardRow> = hard_cases().iter().map(through_the_pipeline).collect();
    progress("Limits of f32");
    rows.extend(limits_of_f32().iter().map(Limit::row));
    progress("The eye at all scales");
    rows.extend(eye_scales());
    rows
}

/// Returns the errors that the specification allows for a case.
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

/// Returns the largest power of two, from 2^-30 on, up to which `holds` is true.
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

/// Limit of f32: derived from the format, and measured.
struct Limit {
    case: &'static str,
    /// Largest power of two at which the property holds, by theory.
    theory: f64,
    /// Derivation of the limit.
    because: &'static str,
    /// Tests the property at a power of two.
    holds: fn(f64) -> bool,
}

impl Limit {
    fn row(&self) -> HardRow {
        let found = last_power_that(self.holds);
        HardRow {
            case: self.case.into(),
            promise: format!("holds to {:e}: {}", self.theory, self.because),
            measured: format!("holds to {found:e}, fails at {:e}", 2.0 * found),
            passed: found == self.theory,
        }
    }
}

/// Returns cases in which f32 must fail. An f32 has a significand of 24 bits: from 2^k to 2^(k+1)
/// its values are 2^(k-23) apart.
fn limits_of_f32() -> [Limit; 5] {
    let power_under = |x: f64| libm::exp2(libm::floor(libm::log2(x)));
    [
        Limit {
            case: "a texture coordinate in f32, to 1/256 texel, texels from the origin",
            theory: libm::exp2(23.0 - 8.0),
            because: "2^(k-23) <= 2^-8 up to k = 15",
            holds: |x| {
                let next = f32::from_bits((x as f32).to_bits() + 1);
                next as f64 - x <= 1.0 / 256.0
            },
        },
        Limit {
            case: "a screen coordinate in f32, to 1/256 pixel",
            theory: libm::exp2(23.0 - 8.0),
            because: "a step of 1/256 is lost where numbers stand 1/128 apart, from 2^16 on",
            holds: |x| (x as f32 + 1.0 / 256.0) as f64 == x + 1.0 / 256.0,
        },
        Limit {
            case: "the edge function in f32, a point half a unit beside an edge through the origin",
            theory: libm::exp2(24.0),
            because: "the corner (x, x - 1) is on the diagonal once x - 1 takes more than 24 bits",
            holds: |x| {
                let (d, p) = ([x as f32, (x - 1.0) as f32], [(x * 0.5) as f32, (x * 0.5) as f32]);
                d[0] * p[1] - d[1] * p[0] != 0.0
            },
        },
        Limit {
            case: "Phong's power of a cosine in f32, to half a step of 255, as exponent",
            // Neighbours below 1 are 2^-24 apart; the nearest power is off by d(x^n) = n x^(n-1)
            // 2^-24 at most, x near 1.
            theory: power_under(0.5 / 255.0 * libm::exp2(24.0)),
            because: "n 2^-24 <= 0.5/255",
            holds: |n| {
                let below = 1.0 - libm::exp2(-24.0);
                (1.0 - libm::pow(below, n)).abs() <= 0.5 / 255.0
            },
        },
        Limit {
            case: "a depth of f32 behind a near plane at 1, two surfaces a unit apart, distance from the eye",
            // z = 1 - 1/d with the far plane at infinity; numbers below 1 are 2^-24 apart.
            theory: libm::exp2(11.0),
            because: "1/(d (d+1)) > 2^-24 holds for all d under 2^12, so from 2^11 to its double",
            holds: |d| {
                let z = |d: f64| (1.0 - 1.0 / d) as f32;
                // Any two surfaces a unit apart up to here.
                (0..64).all(|i| z(d + d * i as f64 / 64.0) < z(d + d * i as f64 / 64.0 + 1.0))
            },
        },
    ]
}

/// Compares the same world in units from 1e-6 to 1e6: equal facets, and distances in proportion.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn f32_holds_up_to_each_limit_and_not_beyond() {
        for limit in limits_of_f32() {
            assert!((limit.holds)(limit.theory), "{} at {}", limit.case, limit.theory);
            assert!(!(limit.holds)(2.0 * limit.theory), "{} at {}", limit.case, 2.0 * limit.theory);
        }
    }

    #[test]
    fn f64_is_nowhere_near_these_limits() {
        // The same edge, corner and point in f64, as in the pipeline, far on both sides of f32's
        // limit.
        for k in [20, 24, 25, 40, 52] {
            let x = libm::exp2(k as f64);
            assert!(x * (x * 0.5) - (x - 1.0) * (x * 0.5) == x * 0.5, "2^{k}");
        }
    }
}

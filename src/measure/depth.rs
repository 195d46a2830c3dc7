//! Depth formats: the smallest separation that each keeps in order, compared with theory.

use super::experiment::{Bound, Effort, Experiment, Row};
use crate::memory::DepthFormat;
use crate::truth::metrics::misordered_pairs;
use crate::truth::scenes::Random;
use std::hint::black_box;

/// Experiment on depth formats.
pub(super) const DEPTH: Experiment = Experiment {
    id: "depth",
    title: "Depth formats",
    about: "Pairs of surfaces at about the geometric mean of near and far, a relative separation apart. The smallest separation, \
            in steps of the fourth root of 2, at which every pair is still ordered; beside it the theory: one step (or ulp) of the \
            format, times d (f - n) / (f n).",
    columns: &["smallest separation kept, part of d", "theory, part of d", "measured / theory"],
    plotted: 0,
    unit: "depth stored",
    rows,
};

/// Returns z = f (d - n) / (d (f - n)) and 1 - z = n (f - d) / (d (f - n)), without cancellation.
fn depths(near: f64, far: f64, d: f64) -> (f64, f64) {
    let scale = 1.0 / (d * (far - near));
    (far * (d - near) * scale, near * (far - d) * scale)
}

/// Returns the spacing of the format's values at this depth.
fn spacing(format: DepthFormat, z: f64, complement: f64) -> f64 {
    match format {
        DepthFormat::U16 => 1.0 / 65_535.0,
        DepthFormat::U24 => 1.0 / 16_777_215.0,
        DepthFormat::U32 => 1.0 / 4_294_967_295.0,
        DepthFormat::F32 => crate::truth::ulp_f32(z),
        DepthFormat::Reversed => crate::truth::ulp_f32(complement),
    }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let pairs = effort.pick(200, 2000);
    let mut rows = Vec::new();
    for decade in 1..=7 {
        let (near, far) = (1.0, libm::pow(10.0, decade as f64));
        let middle = (near * far).sqrt();
        for format in DepthFormat::ALL {
            let mut r = Random::new(1974 + decade);
            let places: Vec<f64> = (0..pairs).map(|_| middle * r.real(0.95, 1.05)).collect();
            let stored = |d: f64| {
                let (z, complement) = depths(near, far, d);
                (format.encode(z, complement), z)
            };
            // From 1/2 down to 2^-40: the last separation before a pair is lost.
            let mut kept = 1.0;
            for k in 4..160 {
                let separation = libm::exp2(-(k as f64) / 4.0);
                if places.iter().any(|&d| misordered_pairs(&[stored(d), stored(d * (1.0 + separation))]) > 0)
                {
                    break;
                }
                kept = separation;
            }
            let (z, complement) = depths(near, far, middle);
            let theory = spacing(format, z, complement) * middle * (far - near) / (far * near);
            let (_, timing) =
                effort.run(|| black_box(&places).iter().fold(0u32, |sum, &d| sum.wrapping_add(stored(d).0)));
            rows.push(Row {
                subject: format!("near : far = 1 : 1e{decade}"),
                alternative: format.as_str().into(),
                is_default: format == DepthFormat::default(),
                errors: vec![kept, theory, kept / theory],
                // Where a step is a quarter of the distance, the search from 1/2 down finds nothing
                // to compare with theory.
                bounds: if theory > 0.25 { Vec::new() } else { vec![Bound { column: 2, at_most: 2.5 }] },
                is_run: true,
                timing,
                work: pairs as f64,
                picture: None,
            });
        }
    }
    rows
}

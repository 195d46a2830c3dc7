//! Growth of cost: times for growing sizes, the fitted exponent, and peak memory.

use super::clock::Timing;

/// Measurement at one size.
#[derive(Clone, Debug, PartialEq)]
pub struct ScalingPoint {
    /// Size: number of whatever grows.
    pub x: f64,
    /// Timing of one run, if times are taken.
    pub timing: Option<Timing>,
    /// Peak resident set of the whole process meanwhile in bytes, if the system reports it.
    pub peak_bytes: Option<u64>,
}

/// Series of times for growing sizes.
#[derive(Clone, Debug, PartialEq)]
pub struct Scaling {
    /// Description of the work.
    pub title: String,
    /// Plural name of whatever grows.
    pub grows: &'static str,
    /// Promised exponent, if there is one.
    pub at_most: Option<f64>,
    /// Measurements, smallest size first.
    pub points: Vec<ScalingPoint>,
}

impl Scaling {
    /// Returns b of the line log t = a + b log x that fits the times best (least squares), or
    /// `None` without two different sizes.
    pub fn exponent(&self) -> Option<f64> {
        let timed = self
            .points
            .iter()
            .filter_map(|p| Some((libm::log(p.x), libm::log(p.timing.as_ref()?.median_s()))));
        let logs: Vec<(f64, f64)> = timed.collect();
        let n = logs.len() as f64;
        let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / n;
        let (x, y) = (mean(|l| l.0), mean(|l| l.1));
        let spread: f64 = logs.iter().map(|l| (l.0 - x) * (l.0 - x)).sum();
        let slope: f64 = logs.iter().map(|l| (l.0 - x) * (l.1 - y)).sum();
        (logs.len() > 1 && spread > 0.0).then(|| slope / spread)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scaling(time: impl Fn(f64) -> f64, sizes: &[f64]) -> Scaling {
        let point = |&x: &f64| {
            let timing = Some(Timing::single(time(x)));
            ScalingPoint { x, timing, peak_bytes: None }
        };
        let points = sizes.iter().map(point).collect();
        Scaling { title: String::new(), grows: "things", at_most: None, points }
    }

    #[test]
    fn a_power_law_gives_its_exponent() {
        let sizes = [100.0, 1e3, 1e4, 1e5];
        for exponent in [0.0, 0.6, 1.0, 2.0] {
            let found = scaling(|x| 3e-6 * libm::pow(x, exponent), &sizes).exponent().unwrap();
            assert!((found - exponent).abs() < 1e-12, "{found}");
        }
        assert_eq!(scaling(|x| x, &[7.0]).exponent(), None);
        assert_eq!(scaling(|x| x, &[7.0, 7.0]).exponent(), None);
    }
}

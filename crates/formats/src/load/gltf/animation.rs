//! Animations of a glTF file: keyframes for the transforms of nodes and the weights of targets.
//!
//! In: keyframe times and values. Out: the value of each channel at a time. All animations play at
//! once and begin again after their own longest channel; where two move the same property of a node,
//! the first in the file does. Before the first and after the last keyframe their values hold.
//!
//! ```text
//! STEP         v(k)
//! LINEAR       v(k) + (v(k+1) - v(k)) t; rotations along the shorter arc (slerp)
//! CUBICSPLINE  Hermite with the tangents b(k) and a(k+1), times the interval; rotations made unit
//! ```
//!
//! Source: glTF 2.0 Specification, section 3.11 (Animations) and appendix C.

use super::attributes::attribute;
use super::image::Source;
use super::json::Json;
use super::nodes::quaternion;
use crate::load::{LoadError, LoadErrorKind};
use glam::DQuat;
use std::collections::HashSet;

/// Property that a channel moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Interpolation {
    Step,
    Linear,
    CubicSpline,
}

/// One channel of an animation.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    pub(super) node: usize,
    pub(super) path: Path,
    /// Times of the keyframes in seconds, increasing.
    times: Vec<f64>,
    /// Values of all keyframes; for a spline in-tangent, value and out-tangent of each.
    values: Vec<f64>,
    /// Numbers of a value.
    width: usize,
    interpolation: Interpolation,
    /// Seconds after which the animation begins again.
    period: f64,
}

/// Reads the channels of all animations of a file; `weights` is the number of weights of a node.
pub(super) fn read_all(
    source: &mut Source,
    nodes: usize,
    weights: impl Fn(usize) -> usize,
) -> Result<Vec<Channel>, LoadError> {
    let (mut all, mut taken) = (Vec::new(), HashSet::new());
    for animation in source.root.member("animations").items()? {
        let first = all.len();
        let samplers = animation.member("samplers");
        for json in animation.member("channels").items()? {
            let target = json.member("target");
            let Some(node) = target.member("node").index_if_there("node", nodes)? else { continue };
            let path = match target.member("path").word() {
                Some("translation") => Path::Translation,
                Some("rotation") => Path::Rotation,
                Some("scale") => Path::Scale,
                Some("weights") => Path::Weights,
                _ => {
                    source.warn(target.warning("an animation of another property is left out"));
                    continue;
                }
            };
            if !taken.insert((node, path)) {
                continue;
            }
            let sampler = samplers.item(json.member("sampler").index("sampler", samplers.count())?);
            let width = match path {
                Path::Translation | Path::Scale => 3,
                Path::Rotation => 4,
                Path::Weights => weights(node),
            };
            all.extend(read(source, &sampler, node, path, width)?);
        }
        let of_this: &mut [Channel] = &mut all[first..];
        let period = of_this.iter().filter_map(|c| c.times.last()).fold(0.0, |a: f64, b| a.max(*b));
        of_this.iter_mut().for_each(|c| c.period = period);
    }
    Ok(all)
}

/// Reads a channel; `None` if it has no values.
fn read(
    source: &mut Source,
    sampler: &Json,
    node: usize,
    path: Path,
    width: usize,
) -> Result<Option<Channel>, LoadError> {
    let interpolation = match sampler.member("interpolation").one_of(&["LINEAR", "STEP", "CUBICSPLINE"]) {
        "STEP" => Interpolation::Step,
        "CUBICSPLINE" => Interpolation::CubicSpline,
        _ => Interpolation::Linear,
    };
    let input = sampler.member("input");
    let times = attribute(source, &input, &[1])?.values;
    if times.is_empty() || width == 0 {
        return Ok(None);
    }
    if times[0] < 0.0 || times.windows(2).any(|w| w[0] > w[1]) {
        let reason = "the times of keyframes do not increase from 0 on".to_owned();
        return Err(input.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
    }
    let output = sampler.member("output");
    let values = attribute(source, &output, &[if path == Path::Weights { 1 } else { width }])?.values;
    let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
    if values.len() != times.len() * width * parts {
        let reason = format!("{} numbers for {} keyframes of {width}", values.len(), times.len());
        return Err(output.refuse(LoadErrorKind::Undecodable { format: "glTF", reason }));
    }
    let bytes = ((times.len() + values.len()) * 8) as u64;
    source.context.memory.reserve_result(bytes).map_err(|kind| sampler.refuse(kind))?;
    Ok(Some(Channel { node, path, times, values, width, interpolation, period: 0.0 }))
}

impl Channel {
    /// Returns the seconds after which the channel's animation begins again.
    pub(super) fn period(&self) -> f64 {
        self.period
    }

    /// Returns the value at `time`, in seconds from the start; a time that is not finite is 0.
    pub(super) fn at(&self, time: f64) -> Vec<f64> {
        let time = if time.is_finite() { time.max(0.0) } else { 0.0 };
        let time = if self.period > 0.0 { time % self.period } else { 0.0 };
        // The number of keyframes at or before this time.
        let passed = self.times.partition_point(|t| *t <= time);
        let last = self.times.len() - 1;
        let is_held = passed == 0 || passed > last;
        let k = passed.saturating_sub(1);
        if is_held || self.interpolation == Interpolation::Step {
            return self.value(k).to_vec();
        }
        let interval = self.times[k + 1] - self.times[k];
        let t = (time - self.times[k]) / interval;
        let (from, to) = (self.value(k), self.value(k + 1));
        match (self.interpolation, self.path) {
            (Interpolation::CubicSpline, path) => {
                let (out, into) = (self.part(k, 2), self.part(k + 1, 0));
                let (t2, t3) = (t * t, t * t * t);
                let spline = |i: usize| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * from[i]
                        + interval * (t3 - 2.0 * t2 + t) * out[i]
                        + (3.0 * t2 - 2.0 * t3) * to[i]
                        + interval * (t3 - t2) * into[i]
                };
                let values: Vec<f64> = (0..self.width).map(spline).collect();
                // Rotations are made unit when they are used.
                debug_assert!(path != Path::Rotation || values.len() == 4);
                values
            }
            (_, Path::Rotation) => {
                let of = |v: &[f64]| quaternion([v[0], v[1], v[2], v[3]]);
                slerp(of(from), of(to), t).to_array().to_vec()
            }
            _ => from.iter().zip(to).map(|(a, b)| a + (b - a) * t).collect(),
        }
    }

    /// Returns the value of a keyframe.
    fn value(&self, k: usize) -> &[f64] {
        match self.interpolation {
            Interpolation::CubicSpline => self.part(k, 1),
            _ => &self.values[k * self.width..][..self.width],
        }
    }

    /// Returns a spline's in-tangent, value or out-tangent.
    fn part(&self, k: usize, part: usize) -> &[f64] {
        &self.values[(3 * k + part) * self.width..][..self.width]
    }
}

/// Interpolates unit quaternions along the shorter arc.
pub(super) fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    let dot = a.dot(b);
    let (b, dot) = if dot < 0.0 { (-b, -dot) } else { (b, dot) };
    // Nearly equal: the arc is straight.
    let (wa, wb) = match dot > 1.0 - 1e-9 {
        true => (1.0 - t, t),
        false => {
            let angle = libm::acos(dot.clamp(-1.0, 1.0));
            let sin = libm::sin(angle);
            (libm::sin((1.0 - t) * angle) / sin, libm::sin(t * angle) / sin)
        }
    };
    quaternion((a * wa + b * wb).to_array())
}

//! ROUTEs: resolution of their field names, and the propagation of one timestamp's events.
//!
//! A timestamp's events begin at the time sensors. Each route carries one event per timestamp,
//! which is the standard's rule for loops. Source: ISO/IEC 19775-1 clause 4.4.8 (event model).

use super::graph::{Graph, GraphView, NodeId, Overrides};
use super::interpolate;
use super::time;
use super::value::{Kind, Value};
use std::collections::{HashMap, VecDeque};

/// Output of a node that a route can start at.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Output {
    /// TimeSensor.fraction_changed.
    Fraction,
    /// TimeSensor.time.
    Time,
    /// TimeSensor.elapsedTime.
    Elapsed,
    /// TimeSensor.cycleTime.
    CycleTime,
    /// TimeSensor.isActive.
    Active,
    /// An interpolator's value_changed.
    Value,
    /// isBound of a bindable node.
    Bound,
    /// Any other field, after a change.
    Field(usize),
}

/// Input of a node that a route can lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum RouteInput {
    /// An interpolator's set_fraction.
    Fraction,
    /// set_bind of a bindable node.
    Bind,
    /// Any other field.
    Field(usize),
}

/// A connection between an output and an input.
#[derive(Clone, Copy, Debug)]
pub(super) struct Route {
    pub(super) from: NodeId,
    pub(super) output: Output,
    pub(super) to: NodeId,
    pub(super) input: RouteInput,
}

fn is_bindable(name: &str) -> bool {
    matches!(name, "Viewpoint" | "OrthoViewpoint" | "NavigationInfo" | "Background" | "Fog")
}

/// Returns the output of this name, with the type of its values.
pub(super) fn output(graph: &Graph, node: NodeId, field: &str) -> Option<(Output, Kind)> {
    let ty = graph.nodes[node as usize].ty;
    match (ty.name, field) {
        ("TimeSensor", "fraction_changed") => Some((Output::Fraction, Kind::Sf(1))),
        ("TimeSensor", "time") => Some((Output::Time, Kind::Sf(1))),
        ("TimeSensor", "elapsedTime") => Some((Output::Elapsed, Kind::Sf(1))),
        ("TimeSensor", "cycleTime") => Some((Output::CycleTime, Kind::Sf(1))),
        ("TimeSensor", "isActive") => Some((Output::Active, Kind::Bool)),
        (name, "isBound") if is_bindable(name) => Some((Output::Bound, Kind::Bool)),
        (name, "value_changed") => interpolate::kind(name).map(|kind| (Output::Value, kind)),
        _ => {
            let name = field.strip_suffix("_changed").unwrap_or(field);
            let index = ty.field(field).or_else(|| ty.field(name))?;
            Some((Output::Field(index), ty.fields[index].kind))
        }
    }
}

/// Returns the input of this name, with the type of its values.
pub(super) fn input(graph: &Graph, node: NodeId, field: &str) -> Option<(RouteInput, Kind)> {
    let ty = graph.nodes[node as usize].ty;
    match field {
        "set_fraction" if interpolate::kind(ty.name).is_some() => Some((RouteInput::Fraction, Kind::Sf(1))),
        "set_bind" if is_bindable(ty.name) => Some((RouteInput::Bind, Kind::Bool)),
        _ => {
            let name = field.strip_prefix("set_").unwrap_or(field);
            let index = ty.field(field).or_else(|| ty.field(name))?;
            Some((RouteInput::Field(index), ty.fields[index].kind))
        }
    }
}

/// Returns the field values that the routes have set at `time` (seconds).
pub(super) fn overrides(graph: &Graph, time: f64) -> Overrides {
    let mut overrides = Overrides::new();
    if graph.routes.is_empty() {
        return overrides;
    }
    let still = Overrides::new();
    let view = GraphView { graph, overrides: &still };
    let mut events: VecDeque<(NodeId, Output, Value)> = VecDeque::new();
    for id in (0..graph.nodes.len() as NodeId).filter(|id| view.name(*id) == "TimeSensor") {
        if let Some(sample) = time::Sensor::read(&view, id).sample(time) {
            let real = |x: f64| Value::Reals([x].into());
            events.extend([
                (id, Output::Active, Value::Bool(sample.is_active)),
                (id, Output::CycleTime, real(sample.cycle_time)),
                (id, Output::Elapsed, real(sample.elapsed)),
                (id, Output::Time, real(sample.time)),
                (id, Output::Fraction, real(sample.fraction)),
            ]);
        }
    }
    let mut leaving: HashMap<(NodeId, Output), Vec<usize>> = HashMap::new();
    for (i, route) in graph.routes.iter().enumerate() {
        leaving.entry((route.from, route.output)).or_default().push(i);
    }
    let mut has_fired = vec![false; graph.routes.len()];
    while let Some((from, output, value)) = events.pop_front() {
        for &i in leaving.get(&(from, output)).into_iter().flatten() {
            let route = &graph.routes[i];
            if std::mem::replace(&mut has_fired[i], true) {
                continue;
            }
            match route.input {
                RouteInput::Fraction => {
                    let Value::Reals(fraction) = &value else { continue };
                    if let Some(value) = interpolate::evaluate(&view, route.to, fraction[0]) {
                        events.push_back((route.to, Output::Value, value));
                    }
                }
                RouteInput::Field(field) => {
                    overrides.insert((route.to, field), value.clone());
                    events.push_back((route.to, Output::Field(field), value.clone()));
                }
                // Binding is resolved once per scene, without events: see `flatten`.
                RouteInput::Bind => {}
            }
        }
    }
    overrides
}

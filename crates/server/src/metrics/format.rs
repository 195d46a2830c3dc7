//! Text forms of the metrics: one list of metric families, in Prometheus' text format or as JSON.
//!
//! Source: Prometheus, "Exposition formats", text format version 0.0.4.

use super::Reading;
use fbptr_command::Verb;
use fbptr_engine::engine::OutputState;
use std::fmt::{self, Write};

/// Media type of [`prometheus`].
pub(super) const PROMETHEUS_TYPE: &str = "text/plain; version=0.0.4; charset=utf-8";

#[derive(Clone, Copy, Debug)]
enum MetricKind {
    Counter,
    Gauge,
}

#[derive(Clone, Copy, Debug)]
enum Value {
    Whole(u64),
    Seconds(f64),
}

impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Value::Whole(n) => write!(f, "{n}"),
            Value::Seconds(s) => write!(f, "{s:.3}"),
        }
    }
}

/// A family of samples under one name.
struct Family {
    name: &'static str,
    kind: MetricKind,
    help: &'static str,
    samples: Samples,
}

enum Samples {
    One(Value),
    /// Values by the value of one label. Neither names nor values contain characters that need
    /// escaping.
    Labeled(&'static str, Vec<(&'static str, Value)>),
}

fn families(reading: &Reading) -> Vec<Family> {
    let (m, refused) = (&reading.metrics, &reading.refused);
    let e = &m.engine;
    let record = e.output("record");
    let counter = |name, help, n| family(name, MetricKind::Counter, help, Samples::One(Value::Whole(n)));
    let gauge = |name, help, n| family(name, MetricKind::Gauge, help, Samples::One(Value::Whole(n)));
    let seconds = |name, help, s: std::time::Duration| {
        family(name, MetricKind::Gauge, help, Samples::One(Value::Seconds(s.as_secs_f64())))
    };
    let labeled = |name, kind, help, label, samples: Vec<(&'static str, u64)>| {
        let samples = samples.into_iter().map(|(value, n)| (value, Value::Whole(n))).collect();
        family(name, kind, help, Samples::Labeled(label, samples))
    };
    let memory = vec![
        ("frame", e.frame_bytes),
        ("depth", e.depth_bytes),
        ("ids", e.id_bytes),
        ("shared_resources", e.shared_resource_bytes),
        ("private_resources", m.private_resource_bytes),
        ("replies", m.reply_bytes),
        ("recording_queue", record.figure("record_queue")),
    ];
    let recording = OutputState::ALL.map(|(state, name)| (name, u64::from(record.state == state)));
    let verbs = Verb::all().iter().zip(&m.verbs).map(|(verb, n)| (verb.name, *n)).collect();
    let refused = vec![
        ("server_full", refused.server_full),
        ("address_full", refused.address_full),
        ("no_resources", refused.no_resources),
    ];
    vec![
        labeled(
            "fbptr_build_info",
            MetricKind::Gauge,
            "The program.",
            "version",
            vec![(env!("CARGO_PKG_VERSION"), 1)],
        ),
        seconds("fbptr_uptime_seconds", "Time since the server started.", reading.uptime),
        seconds(
            "fbptr_snapshot_age_seconds",
            "Age of these values: above 6 while one command keeps the render thread busy.",
            reading.age,
        ),
        counter("fbptr_received_bytes_total", "Stream bytes decoded.", e.totals.bytes),
        counter("fbptr_commands_total", "Commands run or refused.", e.totals.commands),
        counter(
            "fbptr_pixels_total",
            "Pixels stored by pixel, block and CLEAR commands, and by draws.",
            e.totals.pixels,
        ),
        counter("fbptr_clipped_pixels_total", "Pixels that fell outside the frame.", e.totals.clipped),
        counter("fbptr_errors_total", "Commands refused.", e.totals.errors),
        counter("fbptr_empty_draws_total", "Draws that showed nothing.", e.totals.empty_draws),
        counter("fbptr_frames_total", "Frames ended by PRESENT.", e.totals.frames),
        labeled("fbptr_verb_commands_total", MetricKind::Counter, "Commands by verb.", "verb", verbs),
        gauge("fbptr_connections", "Open connections.", e.connections as u64),
        labeled(
            "fbptr_connections_refused_total",
            MetricKind::Counter,
            "Connections refused for a limit, or for want of a descriptor or a thread.",
            "reason",
            refused,
        ),
        counter("fbptr_connections_idle_closed_total", "Connections closed for being idle.", e.idle_closes),
        counter("fbptr_foreign_requests_total", "Connections that spoke HTTP or TLS.", e.foreign_refused),
        gauge("fbptr_queue_bytes", "Bytes received and not run yet.", m.queue_bytes),
        labeled("fbptr_memory_bytes", MetricKind::Gauge, "Memory by use.", "use", memory),
        gauge("fbptr_memory_limit_bytes", "The memory budget.", e.memory_limit_bytes),
        gauge("fbptr_memory_used_bytes", "Bytes charged to the memory budget.", e.memory_used_bytes),
        gauge("fbptr_recorded_bytes", "Bytes of the recording in its file.", record.figure("record_bytes")),
        gauge("fbptr_snap_files_bytes", "Bytes of the files that SNAP wrote.", e.snap_bytes),
        labeled(
            "fbptr_recording",
            MetricKind::Gauge,
            "1 at the recording's state.",
            "state",
            recording.to_vec(),
        ),
    ]
}

fn family(name: &'static str, kind: MetricKind, help: &'static str, samples: Samples) -> Family {
    Family { name, kind, help, samples }
}

/// Formats the values in Prometheus' text format.
pub(super) fn prometheus(reading: &Reading) -> String {
    let mut text = String::with_capacity(8 << 10);
    for Family { name, kind, help, samples } in families(reading) {
        let kind = match kind {
            MetricKind::Counter => "counter",
            MetricKind::Gauge => "gauge",
        };
        // Writing to a String cannot fail.
        let _ = write!(text, "# HELP {name} {help}\n# TYPE {name} {kind}\n");
        let _ = match samples {
            Samples::One(value) => writeln!(text, "{name} {value}"),
            Samples::Labeled(label, samples) => samples
                .iter()
                .try_for_each(|(at, value)| writeln!(text, "{name}{{{label}=\"{at}\"}} {value}")),
        };
    }
    text
}

/// Formats the values as one JSON object: a number for each name, or an object of numbers by label.
pub(super) fn json(reading: &Reading) -> String {
    let number = |value: Value| match value {
        Value::Whole(n) => serde_json::Value::from(n),
        Value::Seconds(s) => serde_json::Value::from(format!("{s:.3}").parse::<f64>().unwrap_or(s)),
    };
    let object: serde_json::Map<String, serde_json::Value> = families(reading)
        .into_iter()
        .map(|family| {
            let value = match family.samples {
                Samples::One(value) => number(value),
                Samples::Labeled(_, samples) => serde_json::Value::Object(
                    samples.into_iter().map(|(at, value)| (at.to_owned(), number(value))).collect(),
                ),
            };
            (family.name.to_owned(), value)
        })
        .collect();
    format!("{}\n", serde_json::Value::Object(object))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{Metrics, MetricsBoard};
    use fbptr_engine::engine::OutputStatus;
    use std::time::Instant;

    #[test]
    fn both_forms_hold_the_same_values() {
        let board = MetricsBoard::new();
        let fill = |m: &mut Metrics| {
            m.engine.totals.pixels = u64::MAX;
            m.engine.frame_bytes = 12;
            m.verbs[2] = 7;
            m.engine.outputs =
                vec![OutputStatus { name: "record", state: OutputState::Failed, figures: Vec::new() }];
        };
        assert!(board.update(Instant::now(), fill));
        let reading = board.read();
        let (text, json) = (prometheus(&reading), json(&reading));
        let json: serde_json::Value = serde_json::from_str(&json).unwrap();
        let mut samples = 0;
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let (name, value) = line.rsplit_once(' ').unwrap();
            let found = match name.split_once('{') {
                None => &json[name],
                Some((name, label)) => &json[name][label.split('"').nth(1).unwrap()],
            };
            assert_eq!(found.as_f64(), Some(value.parse().unwrap()), "{line}");
            samples += 1;
        }
        assert_eq!(samples, 31 + Verb::all().len(), "every value of the JSON is a sample");
        assert!(text.contains(&format!("\nfbptr_pixels_total {}\n", u64::MAX)));
        assert!(text.contains("\nfbptr_verb_commands_total{verb=\"PX\"} 7\n"), "{text}");
        assert!(text.contains("\nfbptr_recording{state=\"failed\"} 1\n"));
    }

    #[test]
    fn no_label_needs_an_escape() {
        for family in families(&MetricsBoard::new().read()) {
            assert!(!family.help.contains(['\\', '\n']), "{}", family.name);
            if let Samples::Labeled(label, samples) = family.samples {
                assert!(!label.contains(['"', '\\', '\n']));
                assert!(samples.iter().all(|(at, _)| !at.contains(['"', '\\', '\n'])));
            }
        }
    }
}

//! TimeSensor: its outputs at a given time. Source: ISO/IEC 19775-1 clause 8 (time component).
//!
//! Times are seconds from the scene's start. The state is a function of the time alone: after its
//! end a sensor keeps its last outputs, so that animated fields stay as they were at the end.

use super::graph::{GraphView, NodeId};

/// Fields of a TimeSensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sensor {
    pub(super) cycle_interval: f64,
    pub(super) enabled: bool,
    pub(super) is_loop: bool,
    pub(super) start: f64,
    pub(super) stop: f64,
    pub(super) pause: f64,
    pub(super) resume: f64,
}

/// Outputs of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sample {
    pub(super) fraction: f64,
    /// Time of the outputs: the given time, or the time at which the sensor ended or was paused.
    pub(super) time: f64,
    /// Seconds since the start, without pauses.
    pub(super) elapsed: f64,
    /// Time at which the current cycle began.
    pub(super) cycle_time: f64,
    pub(super) is_active: bool,
}

impl Sensor {
    /// Reads the fields of a TimeSensor node.
    pub(super) fn read(view: &GraphView, id: NodeId) -> Sensor {
        Sensor {
            cycle_interval: view.real(id, "cycleInterval"),
            enabled: view.bool(id, "enabled"),
            is_loop: view.bool(id, "loop"),
            start: view.real(id, "startTime"),
            stop: view.real(id, "stopTime"),
            pause: view.real(id, "pauseTime"),
            resume: view.real(id, "resumeTime"),
        }
    }

    /// Returns the outputs at time `now`; `None` before the first one.
    ///
    /// f = frac((now - start) / cycleInterval), but 1 in place of 0 after the start.
    pub(super) fn sample(&self, now: f64) -> Option<Sample> {
        let cycle = self.cycle_interval;
        if !self.enabled || cycle <= 0.0 || !now.is_finite() || now < self.start {
            return None;
        }
        // A stop time at or before the start time is ignored.
        let stops = self.stop > self.start;
        let mut time = now;
        if stops {
            time = time.min(self.stop);
        }
        let mut is_paused = false;
        let mut skipped = 0.0;
        if self.pause >= self.start && self.pause != self.resume && time >= self.pause {
            if self.resume > self.pause && time >= self.resume {
                skipped = self.resume - self.pause;
            } else {
                time = self.pause;
                is_paused = true;
            }
        }
        let mut elapsed = time - self.start - skipped;
        let is_over = !self.is_loop && elapsed >= cycle;
        if is_over {
            time -= elapsed - cycle;
            elapsed = cycle;
        }
        let cycles = elapsed / cycle;
        let fraction = cycles - libm::floor(cycles);
        let is_end_of_cycle = fraction == 0.0 && elapsed > 0.0;
        // Too many cycles for a float to count have no fraction.
        let fraction = if is_end_of_cycle || !cycles.is_finite() { 1.0 } else { fraction };
        Some(Sample {
            fraction,
            time,
            elapsed,
            cycle_time: time - fraction * cycle,
            is_active: !(is_over || stops && now >= self.stop && !is_paused),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: Sensor = Sensor {
        cycle_interval: 4.0,
        enabled: true,
        is_loop: true,
        start: 0.0,
        stop: 0.0,
        pause: 0.0,
        resume: 0.0,
    };

    fn fraction(sensor: Sensor, now: f64) -> Option<f64> {
        sensor.sample(now).map(|s| s.fraction)
    }

    #[test]
    fn a_loop_goes_round_and_ends_each_cycle_at_one() {
        let at: Vec<_> =
            [0.0, 1.0, 3.0, 4.0, 5.0, 8.0, 9.0].iter().map(|t| fraction(SENSOR, *t).unwrap()).collect();
        assert_eq!(at, [0.0, 0.25, 0.75, 1.0, 0.25, 1.0, 0.25]);
        assert_eq!(fraction(SENSOR, -0.1), None);
        assert_eq!(fraction(Sensor { enabled: false, ..SENSOR }, 1.0), None);
        assert_eq!(fraction(Sensor { cycle_interval: 0.0, ..SENSOR }, 1.0), None);
        assert_eq!(fraction(SENSOR, f64::NAN), None);
        assert_eq!(SENSOR.sample(9.0).unwrap().cycle_time, 8.0);
        assert_eq!(fraction(Sensor { cycle_interval: 1e-320, ..SENSOR }, 1e9), Some(1.0));
    }

    #[test]
    fn without_loop_it_ends_after_one_cycle_and_keeps_its_last_word() {
        let once = Sensor { is_loop: false, start: 1.0, ..SENSOR };
        assert_eq!(fraction(once, 0.5), None);
        assert_eq!(fraction(once, 3.0), Some(0.5));
        for now in [5.0, 6.0, 1e9] {
            let sample = once.sample(now).unwrap();
            assert_eq!(
                (sample.fraction, sample.time, sample.elapsed, sample.is_active),
                (1.0, 5.0, 4.0, false)
            );
        }
    }

    #[test]
    fn stop_time_counts_only_after_start_time() {
        let stopped = Sensor { start: 2.0, stop: 5.0, ..SENSOR };
        assert_eq!(fraction(stopped, 4.0), Some(0.5));
        assert_eq!(fraction(stopped, 50.0), Some(0.75));
        assert!(!stopped.sample(50.0).unwrap().is_active);
        assert_eq!(fraction(Sensor { start: 5.0, stop: 5.0, ..SENSOR }, 8.0), Some(0.75));
    }

    #[test]
    fn a_pause_freezes_and_a_resume_goes_on_from_there() {
        let paused = Sensor { pause: 1.0, ..SENSOR };
        assert_eq!(fraction(paused, 0.5), Some(0.125));
        assert_eq!(fraction(paused, 3.0), Some(0.25));
        let resumed = Sensor { pause: 1.0, resume: 3.0, ..SENSOR };
        assert_eq!(fraction(resumed, 2.0), Some(0.25));
        assert_eq!(fraction(resumed, 4.0), Some(0.5));
    }
}

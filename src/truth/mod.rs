//! The plain f64 reference, written from the formulas pixel by pixel, and the metrics that hold pictures to it.

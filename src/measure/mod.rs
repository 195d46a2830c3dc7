//! Experiments, benchmarks and the report: speed against error.

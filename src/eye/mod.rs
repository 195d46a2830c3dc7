//! The N-dimensional eye: scenes of R^N on screens of M dimensions.

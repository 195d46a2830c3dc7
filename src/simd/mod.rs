//! Fast kernels, each beside the scalar twin that is its truth: the only room with `unsafe`.
//!
//! The kernel is chosen once at start, by what the CPU has. Every twin pair has the same signature and a property test
//! that they agree bit for bit.

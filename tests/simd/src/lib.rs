//! The unit tests of the crate's vectors alone, for processors that the rest of its tests is not
//! built for: each operation of each level that the processor has, against plain arrays.
#![cfg(test)]
#![allow(dead_code, unused_imports, reason = "only the tests are used")]
#![allow(unexpected_cfgs, reason = "the module asks for features of the crate that it is a part of")]

#[path = "../../../crates/core/src/simd/mod.rs"]
mod simd;

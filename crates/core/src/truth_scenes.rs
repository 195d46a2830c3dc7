//! The random scenes of `fbptr-truth`, compiled once more for this crate's unit tests: those of that
//! crate have the types of another build of this one.
#![allow(dead_code, missing_docs, reason = "the tests use a part")]

#[path = "../../truth/src/scenes/mod.rs"]
pub mod scenes;
#[path = "../../truth/src/settings.rs"]
mod settings;

use settings::{Settings, Transparency};

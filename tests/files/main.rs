//! Files, in and out: X3D scenes, meshes of other projects, snapshots.
//!
//! Verified: an X3D file is read as the standard says, is refused only with need and with a reason,
//! shows and moves as it says, and never crashes the program.

mod animation;
mod classic;
mod course;
mod files;
mod formats;
mod geometry;
// The golden test of docs/library.md, as it stands there.
mod golden_example;
mod groups;
mod hard;
mod made;
mod meshes;
mod pictures;
mod placement;
mod prototypes;
mod save;
mod smoothing;
mod strangers;
mod structure;
mod styles;
mod support;
mod surroundings;
mod tables;
mod unusable;

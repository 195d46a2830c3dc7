//! Files, in and out: X3D scenes, meshes of other projects, snapshots.
//!
//! Fear: an X3D file is read otherwise than the standard says, is refused without need or without saying why, shows something else
//! than it means, moves otherwise than its time sensors say, or brings the program down.

mod animation;
mod files;
mod geometry;
mod groups;
mod hard;
mod made;
mod meshes;
mod pictures;
mod placement;
mod prototypes;
mod save;
mod smoothing;
mod structure;
mod styles;
mod support;
mod surroundings;
mod tables;

//! Files in and out: meshes, scenes and textures to plain data, pixels to pictures and movies, golden
//! comparisons, and the frames of an animated scene file.
//!
//! | module | contents |
//! |---|---|
//! | [`load`] | OBJ, MTL, STL, PLY, X3D, glTF, textures; folders that strangers may name files in |
//! | [`save`] | pictures, movies that are complete after every frame, the golden comparison |
//! | [`models`] | built-in models, which need no file |
//! | [`animation`] | frame k of a scene file: at its time, on its turntable, or turned in N dimensions |
#![forbid(unsafe_code)]
#![deny(missing_docs)]
// `unwrap` is for tests: code says why a value cannot be missing.
#![cfg_attr(not(test), deny(clippy::unwrap_used))]

pub mod animation;
pub mod load;
pub mod models;
pub mod save;

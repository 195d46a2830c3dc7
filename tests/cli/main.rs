//! The programs and pages as users meet them: commands, demos, movies, the report, the docs, and
//! the layers of the sources.

mod api;
mod batch;
mod blocks;
mod claims;
mod compare;
mod decisions;
mod demos;
mod docs;
mod draw;
mod explain;
#[path = "../support/folder.rs"]
mod folder;
mod formats;
mod frame_times;
mod functions;
#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod grade;
mod layers;
mod movie;
mod outputs;
mod play;
mod playground;
mod releases;
mod report;
#[path = "../support/tools.rs"]
mod tools;

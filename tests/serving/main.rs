//! Tests of the server over real sockets, as its clients see it.

mod c_client;
mod crowd;
mod descriptors;
mod display;
mod empty_draws;
mod fairness;
mod files;
#[path = "../support/folder.rs"]
mod folder;
mod gone;
mod hall;
mod loads;
mod memory;
mod metrics;
mod observers;
mod pipes;
mod preemption;
mod process;
mod protocol;
mod python_client;
mod quotas;
#[cfg(all(target_os = "linux", target_env = "gnu", target_pointer_width = "64"))]
mod run;
mod scenes;
mod shell;
mod support;
#[path = "../support/tools.rs"]
mod tools;
mod trust;
mod vnc;
#[cfg(feature = "web")]
mod web;

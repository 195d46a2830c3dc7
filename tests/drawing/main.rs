//! Pictures against what they must be: 2-D figures at every border, the plain renderer against the
//! reference, and the tile renderer against both.

mod against_truth;
mod budget;
mod clipping_2d;
mod clusters;
mod coarse;
mod detail;
mod faces_in_order;
mod far;
mod fast_forms;
mod fast_path;
mod figure_bands;
mod fragments;
mod framebuffer;
mod hard_cases;
mod hostile_arguments;
mod interpolated_light;
mod many_lights;
mod pipeline_truth;
mod plan_paths;
mod recipes;
mod small_draws;
mod surface_maps;
mod surfaces;
mod truth;
mod truth_files;
mod truth_lines;
mod visible_faces;

//! The tile renderer: the default path, several times faster than the plain path and within stated
//! limits of its picture.
//!
//! Deferred shading: faces are set up a vector at a time and binned into tiles, in rows of tiles.
//! Each row of tiles resolves which face is seen at each of its pixels (exact integer coverage,
//! then depth, in file order); then every visible pixel is shaded once. A face that f32 screen
//! vertices cannot represent (behind the eye, steep, huge) is set up in f64 by the plain path, at
//! its place in the order. The picture is the plain path's within these limits: equal coverage,
//! depth within 4e-7, colour within 1/255. Work is split by faces and by rows of tiles,
//! independently of timing: the bytes are equal with any number of threads and at every vector
//! width.
//!
//! Stages: clusters (culling) -> vertex -> setup (cull, bound, cover, bin) -> raster and resolve,
//! one row of tiles after the other.

mod attribute_fetch;
mod bin_fragments;
mod binning;
mod bins;
mod blended_face;
mod blended_texture;
mod cached_face;
mod close_depths;
mod clusters;
mod depth_f64;
mod depth_test;
mod draw_job;
mod edges;
mod exact_faces;
mod exact_raster;
mod f32_error;
mod face_tables;
mod face_vectors;
mod fog;
mod fragments;
mod grid;
mod hierarchical_z;
mod interpolate;
mod kept_ids;
mod light_grid;
mod lighting;
mod linear_light;
mod list_bytes;
mod matte_face;
mod pixel_resolve;
mod raster;
mod resolve;
mod sampler;
mod scratch;
mod setup;
mod shading_state;
mod texel_fetch;
mod texture_queue;
mod tile_buffers;
mod tile_lights;
mod tile_rows;
mod traverse;
mod vertex;
mod vertex_lighting;

pub(crate) use binning::{Binned, Binning, bin_bytes, grid_bytes, list_bound, worst_list_bytes};
pub(crate) use bins::Winding;
pub(crate) use blended_face::{BlendedFace, BlendedFaceKernel, FaceLighting};
pub(crate) use blended_texture::BlendedTexture;
pub(crate) use close_depths::{ReferenceFace, is_rough};
pub(crate) use depth_f64::DepthEncoder;
pub(crate) use draw_job::{DepthF64, DrawJob, FRAME_LIMITS, FrameSlices};
pub(crate) use exact_faces::ExactFace;
pub(crate) use f32_error::{F32Error, Sphere, has_estimate};
pub(crate) use fog::FogParams;
pub(crate) use hierarchical_z::HIERARCHICAL_Z_BYTES;
pub(crate) use light_grid::UNSEEN;
pub(crate) use lighting::{Cone, Exponent, FaintLight, FastLight, LightPosition, MaterialLighting};
pub(crate) use list_bytes::ListBytes;
pub(crate) use sampler::TextureSampler;
pub(crate) use scratch::{DEPTH_VERTEX_BYTES, LIST_BYTES, SCREEN_VERTEX_BYTES, Scratch};
pub(crate) use shading_state::{
    ColorSource, Eye, FragmentShader, MaterialBinding, RecycledBindings, Shading,
};
pub(crate) use tile_rows::{BinnedDraw, Counts, RowProgress, TileRowBuffers, for_each_tile_row};
pub(crate) use vertex::{ToScreen, screen_vertices_of};
pub(crate) use vertex_lighting::VertexLightingKernel;

//! Arguments of one picture of a scene file: its size, background, camera planes, shading and time.

use super::FrameSize;
use super::args::color::color;
use super::mesh_args::MeshArgs;
use super::render::{finite, positive};
use crate::animation::FrameOptions;
use crate::memory::Rgba;
use crate::scene::ShadeMode;
use crate::server::Limits;
use clap::Args;
use std::path::PathBuf;

/// Options of a picture of a scene file.
#[derive(Clone, Debug, Args)]
pub(super) struct PictureArgs {
    /// The picture's size [default: 640x480, or an N-dimensional screen's own]
    #[arg(long, value_name = "WxH")]
    pub size: Option<FrameSize>,
    /// The colour behind scenes that have no background of their own, in hex or by its CSS name
    #[arg(long, value_name = "COLOUR", value_parser = color, default_value = "black")]
    pub background: Rgba,
    /// Let the scene read files from this folder, not only from its own
    #[arg(long, value_name = "DIR")]
    pub root: Option<PathBuf>,
    /// Shading of faces: wire, flat, gouraud or phong
    #[arg(long, value_name = "S", value_parser = shade)]
    pub shade: Option<ShadeMode>,
    /// Distance to the near plane
    #[arg(long, value_name = "N", value_parser = positive, allow_negative_numbers = true)]
    pub near: Option<f64>,
    /// Distance to the far plane
    #[arg(long, value_name = "F", value_parser = positive, allow_negative_numbers = true)]
    pub far: Option<f64>,
    /// Seconds since the scene's start
    #[arg(long, value_name = "T", value_parser = finite, default_value = "0", allow_negative_numbers = true)]
    pub time: f64,
}

fn shade(text: &str) -> Result<ShadeMode, String> {
    ShadeMode::from_keyword(text).ok_or_else(|| "expected wire, flat, gouraud or phong".to_owned())
}

impl PictureArgs {
    /// Checks what needs no scene.
    pub fn check(&self) -> Result<(), String> {
        if let (Some(near), Some(far)) = (self.near, self.far)
            && near >= far
        {
            return Err(format!("--near {near} must be less than --far {far}"));
        }
        let size = self.size.unwrap_or(FrameSize::DEFAULT);
        Limits::default().check_frame(size.width, size.height).map_err(|e| e.message)
    }

    /// Returns the first argument that is given and is for scenes in three dimensions alone.
    pub fn not_for_eye(&self, meshes: &MeshArgs) -> Option<&'static str> {
        let flags = [
            ("--near", self.near.is_some()),
            ("--far", self.far.is_some()),
            ("--shade", self.shade.is_some()),
            ("--cull", meshes.cull.is_some()),
            ("--point-size", meshes.point_size.is_some()),
        ];
        flags.iter().find(|(_, is_given)| *is_given).map(|(flag, _)| *flag)
    }

    /// Returns the options of one frame.
    pub fn frame_options(&self, meshes: &MeshArgs) -> FrameOptions {
        FrameOptions {
            begin_s: self.time,
            size: self.size.map(|size| [size.width, size.height]),
            background: self.background,
            shade: self.shade,
            near: self.near,
            far: self.far,
            cull: meshes.cull,
            point_size: meshes.point_size,
            ..FrameOptions::default()
        }
    }
}

//! Arguments for the meshes of scene files: normals and culling.

use crate::load::Smoothing;
use crate::load::x3d::{Dialect, FieldOfView, Reading};
use crate::scene::{Cull, Geometry, MAX_POINT_SIZE, Material, NONE, Texture};
use clap::Args;
use glam::DVec3;
use std::path::PathBuf;
use std::sync::Arc;

/// Options of reading and showing meshes.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct MeshArgs {
    /// Normals of .obj, .stl and .ply faces that have none: smooth across edges up to an angle (60deg), which smoothing groups of the
    /// file part too; up to about 30deg, where the mesh has the fewest edges (auto); or one for each
    /// position index [default: auto]
    #[arg(long, value_name = "auto|ANGLEdeg|indices", value_parser = smoothing)]
    pub smooth: Option<Smoothing>,
    /// Faces that are left out: back, front or none [default: the scene's own; none for open
    /// surfaces of meshes without normals, lit from both sides, back for others]
    #[arg(long, value_name = "F", value_parser = cull)]
    pub cull: Option<Cull>,
    /// Side of points in pixels, 1 to 64 [default: the scene's own; 1]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_POINT_SIZE)))]
    pub point_size: Option<u32>,
    /// A picture for all of a mesh that has texture coordinates, in place of its materials' textures and diffuse colours
    #[arg(long, value_name = "FILE")]
    pub texture: Option<PathBuf>,
    /// Dialect of an .x3d file: renderizador, a course's, draws scenes of two dimensions in pixels,
    /// y down, in emissive colours [default: the standard's]
    #[arg(long, value_name = "D", value_parser = dialect)]
    pub dialect: Option<Dialect>,
    /// Camera of an .x3d file: diagonal has the field of view on the picture's diagonal, by the
    /// formula of the same course [default: the standard's, on the smaller side]
    #[arg(long, value_name = "C", value_parser = field_of_view)]
    pub camera: Option<FieldOfView>,
    /// Refuse a scene or mesh that is read with a warning
    #[arg(long)]
    pub strict: bool,
}

impl MeshArgs {
    /// Returns the method of computing missing normals.
    pub(super) fn smoothing(&self) -> Smoothing {
        self.smooth.unwrap_or(Smoothing::Automatic)
    }

    /// Returns the reading of X3D; `None` if none was asked for.
    pub(super) fn reading(&self) -> Option<Reading> {
        let is_given = self.dialect.is_some() || self.camera.is_some();
        is_given.then(|| Reading {
            dialect: self.dialect.unwrap_or_default(),
            field_of_view: self.camera.unwrap_or_default(),
        })
    }
}

/// Gives every material of a mesh a texture, at its full colours; faces without a material get one.
pub(super) fn cover(geometry: &mut Geometry, texture: &Arc<Texture>) {
    let mesh = &mut geometry.mesh;
    if mesh.polygons.iter().any(|polygon| polygon.material == NONE) {
        let own = mesh.materials.len() as u32;
        mesh.materials.push(Material { ka: DVec3::splat(0.8), ..Material::default() });
        mesh.polygons.iter_mut().filter(|p| p.material == NONE).for_each(|p| p.material = own);
    }
    mesh.materials.iter_mut().for_each(|material| material.kd = DVec3::ONE);
    geometry.textures = vec![Some(Arc::clone(texture)); geometry.mesh.materials.len()];
}

fn cull(text: &str) -> Result<Cull, String> {
    Cull::from_keyword(text).ok_or_else(|| "expected back, front or none".to_owned())
}

fn dialect(text: &str) -> Result<Dialect, String> {
    match text {
        "renderizador" => Ok(Dialect::Renderizador),
        _ => Err("expected renderizador".to_owned()),
    }
}

fn field_of_view(text: &str) -> Result<FieldOfView, String> {
    match text {
        "diagonal" => Ok(FieldOfView::Diagonal),
        _ => Err("expected diagonal".to_owned()),
    }
}

fn smoothing(text: &str) -> Result<Smoothing, String> {
    if text == "indices" {
        return Ok(Smoothing::Indices);
    }
    if text == "auto" {
        return Ok(Smoothing::Automatic);
    }
    let degrees = text.strip_suffix("deg").and_then(|number| number.parse::<f64>().ok());
    let angle = degrees.filter(|d| (0.0..=180.0).contains(d)).map(|d| Smoothing::Angle(d.to_radians()));
    angle.ok_or_else(|| "expected auto, an angle from 0deg to 180deg, as in 60deg, or indices".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Corner, Mesh};

    #[test]
    fn a_texture_covers_faces_with_and_without_a_material() {
        let texture = Arc::new(Texture::new(1, 1, vec![9, 8, 7, 255]).expect("one texel"));
        let corner = |position| Corner { position, normal: NONE, texcoord: 0, color: NONE };
        let mut mesh = Mesh { positions: vec![DVec3::X, DVec3::Y, DVec3::Z], ..Mesh::default() };
        mesh.materials.push(Material { kd: DVec3::ZERO, ..Material::default() });
        mesh.push_polygon(&[0, 1, 2].map(corner), 0);
        mesh.push_polygon(&[0, 2, 1].map(corner), NONE);
        let mut geometry = Geometry::from(mesh);
        cover(&mut geometry, &texture);
        assert_eq!(geometry.mesh.polygons.iter().map(|p| p.material).collect::<Vec<_>>(), [0, 1]);
        assert!(geometry.mesh.materials.iter().all(|m| m.kd == DVec3::ONE));
        assert_eq!(geometry.textures, [Some(Arc::clone(&texture)), Some(texture)]);
    }

    #[test]
    fn an_angle_has_its_unit() {
        assert_eq!(smoothing("indices"), Ok(Smoothing::Indices));
        assert_eq!(smoothing("auto"), Ok(Smoothing::Automatic));
        assert_eq!(smoothing("180deg"), Ok(Smoothing::Angle(std::f64::consts::PI)));
        assert_eq!(smoothing("0deg"), Ok(Smoothing::Angle(0.0)));
        for bad in ["60", "deg", "-1deg", "181deg", "nandeg", "infdeg", "60rad", "Indices", ""] {
            assert!(smoothing(bad).is_err(), "{bad}");
        }
    }
}

//! Arguments for the meshes of scene files: normals and culling.

use crate::load::Smoothing;
use crate::load::x3d::{Dialect, FieldOfView, Reading};
use crate::scene::{Cull, MAX_POINT_SIZE};
use clap::Args;

/// Options of reading and showing meshes.
#[derive(Clone, Debug, Args)]
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

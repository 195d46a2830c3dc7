//! Arguments of meshes, projections, lights, materials and textures.

use super::EncodeError;
use super::line::LineWriter;
use crate::command::commands::{LightCommand, MeshSource};
use crate::scene::{Attenuation, Material, ObliqueKind, Projection, Sampling};

impl LineWriter<'_> {
    /// Appends an attenuation, unless it is the default.
    fn attenuation(&mut self, a: Attenuation) {
        if a != Attenuation::NONE {
            self.reals(&[a.c, a.l, a.q]);
        }
    }

    pub(super) fn mesh(&mut self, name: &str, source: &MeshSource) {
        self.word(name);
        match *source {
            MeshSource::Obj(_) => self.word("OBJ"),
            MeshSource::Box(size) => {
                self.word("BOX");
                self.vectors(&[size]);
            }
            MeshSource::Sphere(r) => {
                self.word("SPHERE");
                self.reals(&[r]);
            }
            MeshSource::Cone(r, h) => {
                self.word("CONE");
                self.reals(&[r, h]);
            }
            MeshSource::Cylinder(r, h) => {
                self.word("CYLINDER");
                self.reals(&[r, h]);
            }
            MeshSource::Teapot(level) => {
                self.word("TEAPOT");
                self.word(level);
            }
            MeshSource::Knot(nu, nv) => {
                self.word("KNOT");
                self.word(nu);
                self.word(nv);
            }
        }
    }

    pub(super) fn projection(&mut self, projection: &Projection) {
        match *projection {
            Projection::Perspective { fov_rad, near, far, on_smaller_side } => {
                self.reals(&[fov_rad, near, far]);
                if on_smaller_side {
                    self.word("FOVMIN");
                }
            }
            Projection::Plane { d, near, far } => self.reals(&[d, near, far]),
            Projection::Frustum { window, near, far }
            | Projection::Ortho { window, near, far }
            | Projection::OrthoContain { window, near, far }
            | Projection::Isometric { window, near, far }
            | Projection::PseudoIsometric { window, near, far } => {
                self.reals(&window);
                self.reals(&[near, far]);
            }
            Projection::Oblique { kind, angle_rad, window, near, far } => {
                self.word(match kind {
                    ObliqueKind::Cavalier => "cavalier",
                    ObliqueKind::Cabinet => "cabinet",
                });
                self.reals(&[angle_rad]);
                self.reals(&window);
                self.reals(&[near, far]);
            }
            Projection::Window { vrp, p, vup, center, half, dp, near, far } => {
                self.vectors(&[vrp, p, vup]);
                self.reals([center, half].as_flattened());
                self.reals(&[dp, near, far]);
            }
        }
    }

    pub(super) fn light(&mut self, index: i32, light: &LightCommand) {
        self.word(index);
        match *light {
            LightCommand::Point { position, color, attenuation } => {
                self.word("POINT");
                self.vectors(&[position, color]);
                self.attenuation(attenuation);
            }
            LightCommand::Dir { direction, color } => {
                self.word("DIR");
                self.vectors(&[direction, color]);
            }
            LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation } => {
                self.word("SPOT");
                self.vectors(&[position, direction]);
                self.reals(&[angle_rad, exponent]);
                self.vectors(&[color]);
                self.attenuation(attenuation);
            }
            LightCommand::Off => self.word("OFF"),
        }
    }

    pub(super) fn material(&mut self, m: &Material) -> Result<(), EncodeError> {
        let said = Material {
            ka: m.ka,
            kd: m.kd,
            ks: m.ks,
            n: m.n,
            emissive: m.emissive,
            transparency: m.transparency,
            ..Material::default()
        };
        if said != *m {
            return self.no_text("a material's name, texture or other equation");
        }
        self.vectors(&[m.ka, m.kd, m.ks]);
        self.reals(&[m.n]);
        self.vectors(&[m.emissive]);
        self.reals(&[m.transparency]);
        Ok(())
    }

    pub(super) fn texture(&mut self, name: Option<&str>, sampling: Sampling) -> Result<(), EncodeError> {
        if sampling.wrap_s != sampling.wrap_t {
            return self.no_text("two ways of wrapping");
        }
        match name {
            Some(name) if name.eq_ignore_ascii_case("off") => return self.no_text("a texture called OFF"),
            Some(name) => self.word(name),
            None => self.word("OFF"),
        }
        self.word(sampling.filter.as_str());
        self.word(sampling.wrap_s.as_str());
        Ok(())
    }
}

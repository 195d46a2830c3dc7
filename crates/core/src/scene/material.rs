//! Materials: the reflection of light by a surface.

use glam::DVec3;

/// Reflection model, by its specular term.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum LightingModel {
    /// Phong's reflection vector: Ks * max(R.V, 0)^n, R = 2(N.L)N - L, only when N.L > 0.
    #[default]
    Phong,
    /// Blinn's half vector: Ks * max(N.H, 0)^n (X3D with n = 128 * shininess, MTL with n = Ns),
    /// only when N.L > 0.
    Blinn,
    /// Emissive colour only (X3D's UnlitMaterial and shapes without a material).
    Unlit,
}

/// Ka, Kd, Ks, n, emissive colour and transparency. Colours may exceed 1; only bytes are clamped.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Ambient reflection Ka, R, G, B.
    pub ka: DVec3,
    /// Diffuse reflection Kd, R, G, B.
    pub kd: DVec3,
    /// Specular reflection Ks, R, G, B.
    pub ks: DVec3,
    /// Specular exponent n.
    pub n: f64,
    /// Emitted light R, G, B.
    pub emissive: DVec3,
    /// Transparency from 0 (opaque) to 1 (invisible).
    pub transparency: f64,
    /// Reflection model.
    pub model: LightingModel,
    /// File name of the texture as written in MTL's map_Kd; the loader of the file resolves it.
    pub texture: Option<String>,
    /// Name of the material in its file.
    pub name: String,
}

impl Default for Material {
    /// Returns the command language's initial material: Ka 0, Kd .8, Ks 0, n 1, no emission,
    /// opaque, Phong.
    fn default() -> Self {
        Material {
            ka: DVec3::ZERO,
            kd: DVec3::splat(0.8),
            ks: DVec3::ZERO,
            n: 1.0,
            emissive: DVec3::ZERO,
            transparency: 0.0,
            model: LightingModel::Phong,
            texture: None,
            name: String::new(),
        }
    }
}

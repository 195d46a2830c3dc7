//! Materials: how a surface answers light.

use glam::DVec3;

/// Which specular term, and from which standard.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum LightingModel {
    /// Phong's reflection vector: Ks * max(R.V, 0)^n, R = 2(N.L)N - L, only when N.L > 0.
    #[default]
    Phong,
    /// Blinn's half vector: Ks * max(N.H, 0)^n (X3D with n = 128 * shininess, MTL with n = Ns), only when N.L > 0.
    Blinn,
    /// Emissive colour alone (X3D's UnlitMaterial and shapes without a material).
    Unlit,
}

/// Ka, Kd, Ks, n, emissive and transparency. Colours may exceed 1; only bytes are clamped.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Ambient reflection.
    pub ka: DVec3,
    /// Diffuse reflection.
    pub kd: DVec3,
    /// Specular reflection.
    pub ks: DVec3,
    /// Specular exponent.
    pub n: f64,
    /// Light given off.
    pub emissive: DVec3,
    /// 0 opaque to 1 invisible.
    pub transparency: f64,
    /// The equation.
    pub model: LightingModel,
    /// MTL's map_Kd: the texture's file name as written, resolved by the loader of the file.
    pub texture: Option<String>,
    /// The material's name in its file.
    pub name: String,
}

impl Default for Material {
    /// The command language's start: Ka 0, Kd .8, Ks 0, n 1, no emission, opaque, Phong.
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

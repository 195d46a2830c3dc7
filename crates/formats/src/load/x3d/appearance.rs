//! Conversion of Appearance, materials and texture transforms to an object's material.
//!
//! X3D's lighting equation in the terms of [`Material`]: Ka = ambientIntensity * diffuseColor (each
//! light has its own ambient part), Kd = diffuseColor, Ks = specularColor, n = 128 * shininess,
//! Blinn's half vector. Vertex colours multiply the Ka and Kd terms, so a geometry with vertex
//! colours gets Kd = 1 and Ka = ambientIntensity: they replace the diffuse colour. The factors of a
//! CommonSurfaceShader are the colours of a Material, 1 - alphaFactor is its transparency.
//!
//! Source: ISO/IEC 19775-1 clauses 12 (Shape), 17.2.2 (lighting model), 18 (Texturing).

use super::geometry::{ColorUse, Stuff};
use super::graph::{GraphView, NodeId};
use super::stages;
use crate::load::physical;
use fbptr_core::scene::{LightingModel, Material, Sampling, Texture};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Material and texture of a shape's Appearance.
pub(super) struct Appearance {
    pub(super) material: Material,
    /// Material of faces seen from behind, if it is a different one.
    pub(super) back: Option<Material>,
    /// Texture and its sampling.
    pub(super) texture: Option<(Arc<Texture>, Sampling)>,
}

/// Returns the material node of an appearance; a CommonSurfaceShader takes its place.
fn material_node(view: &GraphView, appearance: NodeId) -> Option<NodeId> {
    view.child(appearance, "shaders").or_else(|| view.child(appearance, "material"))
}

/// Returns the texture node of an appearance: the material's own (X3D 4), else the appearance's.
pub(super) fn texture_node(view: &GraphView, appearance: Option<NodeId>) -> Option<NodeId> {
    let appearance = appearance?;
    let of_material = material_node(view, appearance).and_then(|material| {
        let field = match view.name(material) {
            "Material" | "CommonSurfaceShader" => "diffuseTexture",
            "UnlitMaterial" => "emissiveTexture",
            "PhysicalMaterial" => "baseTexture",
            _ => return None,
        };
        view.child(material, field)
    });
    let node = of_material.or_else(|| view.child(appearance, "texture"))?;
    let is_many = view.name(node) == "MultiTexture";
    (is_many || view.graph.textures.contains_key(&node)).then_some(node)
}

/// Reads an appearance for a geometry of this kind.
pub(super) fn read(
    view: &GraphView,
    appearance: Option<NodeId>,
    stuff: Stuff,
    colors: ColorUse,
) -> Appearance {
    let node = appearance.and_then(|a| material_node(view, a));
    let front = Surface::front(view, node);
    let back = match appearance.and_then(|a| view.child(a, "backMaterial")) {
        Some(node) => Some(Surface::front(view, Some(node))),
        None => node.and_then(|n| Surface::back(view, n)),
    };
    let texture = texture_node(view, appearance).filter(|_| stuff == Stuff::Faces).and_then(|node| {
        let texture = view.graph.textures.get(&node)?;
        Some((Arc::clone(texture), stages::sampling(view, node)))
    });
    let dress = |surface: Surface| surface.dressed(stuff, colors);
    Appearance { material: dress(front), back: back.map(dress), texture }
}

/// A material with X3D's parameters.
#[derive(Clone, Copy, Debug)]
struct Surface {
    is_lit: bool,
    ambient_intensity: f64,
    diffuse: DVec3,
    specular: DVec3,
    shininess: f64,
    emissive: DVec3,
    transparency: f64,
}

impl Surface {
    /// Returns a material that has only an emissive colour.
    fn unlit(emissive: DVec3, transparency: f64) -> Surface {
        Surface {
            is_lit: false,
            ambient_intensity: 0.0,
            diffuse: DVec3::ZERO,
            specular: DVec3::ZERO,
            shininess: 0.0,
            emissive,
            transparency,
        }
    }

    /// Reads the front of a material node; without one, it is white and unlit.
    fn front(view: &GraphView, node: Option<NodeId>) -> Surface {
        let Some(node) = node else { return Surface::unlit(DVec3::ONE, 0.0) };
        if view.name(node) == "CommonSurfaceShader" {
            return Surface::of_shader(view, node);
        }
        let transparency = view.real(node, "transparency");
        match view.name(node) {
            "UnlitMaterial" => Surface::unlit(view.vec3(node, "emissiveColor"), transparency),
            "PhysicalMaterial" => Surface::physical(
                view.vec3(node, "baseColor"),
                view.real(node, "metallic"),
                view.real(node, "roughness"),
                Surface::unlit(view.vec3(node, "emissiveColor"), transparency),
            ),
            _ => Surface {
                is_lit: true,
                ambient_intensity: view.real(node, "ambientIntensity"),
                diffuse: view.vec3(node, "diffuseColor"),
                specular: view.vec3(node, "specularColor"),
                shininess: view.real(node, "shininess").clamp(0.0, 1.0),
                emissive: view.vec3(node, "emissiveColor"),
                transparency,
            },
        }
    }

    /// Reads the part of a CommonSurfaceShader that a Material has. Its ambient factor is a colour, of
    /// which the mean is the ambient intensity.
    fn of_shader(view: &GraphView, node: NodeId) -> Surface {
        Surface {
            is_lit: true,
            ambient_intensity: view.vec3(node, "ambientFactor").element_sum() / 3.0,
            diffuse: view.vec3(node, "diffuseFactor"),
            specular: view.vec3(node, "specularFactor"),
            shininess: view.real(node, "shininessFactor").clamp(0.0, 1.0),
            emissive: view.vec3(node, "emissiveFactor"),
            transparency: 1.0 - view.real(node, "alphaFactor"),
        }
    }

    /// Converts a physical material to Phong's parameters: base colour c, metallic m, roughness r.
    fn physical(c: DVec3, metallic: f64, roughness: f64, unlit: Surface) -> Surface {
        let reflection = physical::reflection(c, metallic, roughness);
        Surface {
            is_lit: true,
            diffuse: reflection.kd,
            specular: reflection.ks,
            shininess: reflection.n / 128.0,
            ..unlit
        }
    }

    /// Reads the back of a TwoSidedMaterial, if it has its own colours.
    fn back(view: &GraphView, node: NodeId) -> Option<Surface> {
        let is_separate = view.name(node) == "TwoSidedMaterial" && view.bool(node, "separateBackColor");
        is_separate.then(|| Surface {
            is_lit: true,
            ambient_intensity: view.real(node, "backAmbientIntensity"),
            diffuse: view.vec3(node, "backDiffuseColor"),
            specular: view.vec3(node, "backSpecularColor"),
            shininess: view.real(node, "backShininess").clamp(0.0, 1.0),
            emissive: view.vec3(node, "backEmissiveColor"),
            transparency: view.real(node, "backTransparency"),
        })
    }

    /// Returns the material for a geometry: lines and points without normals are unlit in the
    /// emissive colour; vertex colours replace the colour that they multiply, and those with alpha
    /// also the opacity.
    fn dressed(mut self, stuff: Stuff, colors: ColorUse) -> Material {
        self.is_lit &= stuff != Stuff::Bare;
        if colors != ColorUse::None {
            match self.is_lit {
                true => self.diffuse = DVec3::ONE,
                false => self.emissive = DVec3::ONE,
            }
        }
        if colors == ColorUse::Rgba {
            self.transparency = 0.0;
        }
        Material {
            ka: self.diffuse * self.ambient_intensity.clamp(0.0, 1.0),
            kd: self.diffuse,
            ks: self.specular,
            n: 128.0 * self.shininess,
            emissive: self.emissive,
            transparency: self.transparency.clamp(0.0, 1.0),
            model: if self.is_lit { LightingModel::Blinn } else { LightingModel::Unlit },
            ..Material::default()
        }
    }
}

/// Transformation of texture coordinates by a TextureTransform node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextureMap {
    center: DVec2,
    rotation_rad: f64,
    scale: DVec2,
    translation: DVec2,
}

impl TextureMap {
    /// Reads a TextureTransform node; `None` if it is the identity.
    pub(super) fn read(view: &GraphView, node: NodeId) -> Option<TextureMap> {
        let vec2 = |field| DVec2::from(view.array::<2>(node, field));
        let map = TextureMap {
            center: vec2("center"),
            rotation_rad: view.real(node, "rotation"),
            scale: vec2("scale"),
            translation: vec2("translation"),
        };
        let is_identity =
            map.rotation_rad == 0.0 && map.scale == DVec2::ONE && map.translation == DVec2::ZERO;
        (!is_identity).then_some(map)
    }

    /// Computes Tc' = -C S R C T Tc: translated, then rotated and scaled about -C.
    pub(super) fn apply(&self, tc: DVec2) -> DVec2 {
        let p = tc + self.translation + self.center;
        let (sin, cos) = libm::sincos(self.rotation_rad);
        let turned = DVec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y);
        turned * self.scale - self.center
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_texture_transform_moves_turns_and_scales_in_this_order() {
        let map = TextureMap {
            center: DVec2::new(-0.5, -0.5),
            rotation_rad: FRAC_PI_2,
            scale: DVec2::new(2.0, 1.0),
            translation: DVec2::new(0.0, 0.25),
        };
        // (1, 0.25) -> (1, 0.5) -> about (0.5, 0.5): (0.5, 0) -> turned (0, 0.5) -> scaled (0, 0.5)
        // -> (0.5, 1).
        assert!((map.apply(DVec2::new(1.0, 0.25)) - DVec2::new(0.5, 1.0)).length() < 1e-15);
    }

    #[test]
    fn a_physical_material_is_the_formulas() {
        let of = |m, r| {
            let unlit = Surface::unlit(DVec3::X, 0.25);
            Surface::physical(DVec3::new(0.8, 0.4, 0.2), m, r, unlit).dressed(Stuff::Faces, ColorUse::None)
        };
        let close =
            |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from(b)).length() < 1e-12, "{a} is not {b:?}");
        // Plastic of the greatest roughness: flat. a = 1: n = 0, Ks = 0.
        let rough = of(0.0, 1.0);
        close(rough.kd, [0.8, 0.4, 0.2]);
        close(rough.ks, [0.0; 3]);
        assert_eq!(
            (rough.n, rough.transparency, rough.emissive, rough.ka),
            (0.0, 0.25, DVec3::X, DVec3::ZERO)
        );
        // A metal of roughness 1/sqrt(2): a = 1/2, n = 6, Ks = c (1 - 1/16) / 1.
        let metal = of(1.0, 0.5_f64.sqrt());
        close(metal.kd, [0.4, 0.2, 0.1]);
        close(metal.ks, [0.75, 0.375, 0.1875]);
        assert!((metal.n - 6.0).abs() < 1e-12);
        // Smooth plastic: F0 = 0.04 at its limit, the exponent at its maximum.
        let smooth = of(0.0, 0.0);
        close(smooth.ks, [0.04; 3]);
        assert_eq!(smooth.n, 1000.0);
        assert_eq!(of(0.0, -5.0).n, of(0.0, 0.1).n);
    }

    #[test]
    fn vertex_colours_replace_the_diffuse_colour_and_alpha_the_opacity() {
        let surface = Surface {
            is_lit: true,
            ambient_intensity: 0.25,
            diffuse: DVec3::new(0.4, 0.8, 0.0),
            specular: DVec3::X,
            shininess: 0.5,
            emissive: DVec3::Z,
            transparency: 0.75,
        };
        let plain = surface.dressed(Stuff::Faces, ColorUse::None);
        assert_eq!((plain.ka, plain.kd, plain.n), (DVec3::new(0.1, 0.2, 0.0), surface.diffuse, 64.0));
        assert_eq!((plain.ks, plain.emissive, plain.model), (DVec3::X, DVec3::Z, LightingModel::Blinn));
        let colored = surface.dressed(Stuff::Faces, ColorUse::Rgb);
        assert_eq!((colored.ka, colored.kd, colored.transparency), (DVec3::splat(0.25), DVec3::ONE, 0.75));
        assert_eq!(surface.dressed(Stuff::Faces, ColorUse::Rgba).transparency, 0.0);
        let line = surface.dressed(Stuff::Bare, ColorUse::None);
        assert_eq!((line.model, line.emissive), (LightingModel::Unlit, DVec3::Z));
        assert_eq!(surface.dressed(Stuff::Bare, ColorUse::Rgb).emissive, DVec3::ONE);
        assert_eq!(surface.dressed(Stuff::Lit, ColorUse::None).model, LightingModel::Blinn);
    }
}

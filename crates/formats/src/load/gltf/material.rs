//! Materials of a glTF file in Phong's terms.
//!
//! Colours of the file are linear, pictures are not (sRGB), and the renderer multiplies and adds the
//! numbers that the pixels have. So every colour of the file is encoded first, E(x) being the
//! encoding of sRGB; the product of encoded colours is nearly the encoded product.
//!
//! ```text
//! c  = E(base colour factor), or that of the vertices times it
//! m  = metallic factor  * mean of the blue channel of the metallic-roughness texture
//! r  = roughness factor * mean of its green channel
//! Kd, Ks, n of c, m, r as in load/physical.rs; Ka = Kd; Ke = E(emissive factor * strength)
//! transparency = 1 - alpha of the base colour, if alphaMode is BLEND
//! ```
//!
//! The base-colour texture multiplies Kd and Ka, and with BLEND the opacity. MASK makes each texel
//! opaque or invisible. KHR_materials_unlit: the colour c alone. The mean of the occlusion texture
//! dims Ka. Textures of normals and emission are left out with a warning, the last with the
//! emission that they limit. KHR_materials_pbrSpecularGlossiness: c = E(diffuse), m = 0, r = 1 -
//! glossiness, and Ks scaled to the specular colour.
//!
//! Source: glTF 2.0 Specification, section 3.9 (Materials).

use super::image::{AlphaUse, Images, MadeTexture, Source};
use super::json::Json;
use crate::load::{LoadError, physical};
use fbptr_core::math::power::pow;
use fbptr_core::scene::{LightingModel, Material};
use glam::{DVec2, DVec3};

/// Appearance of a primitive.
pub(super) struct Surface {
    pub(super) material: Material,
    pub(super) texture: Option<MadeTexture>,
    /// Set of texture coordinates of the texture, and their transform.
    pub(super) texcoord: u64,
    pub(super) transform: TextureTransform,
    pub(super) is_double_sided: bool,
    /// Set if alpha of vertices counts.
    pub(super) blends: bool,
    /// Set if nothing of it can be seen (MASK).
    pub(super) is_invisible: bool,
    /// Least alpha of vertices that is seen (MASK).
    pub(super) least_alpha: Option<f64>,
}

/// Encodes a linear number as sRGB does, also beyond 1.
pub(super) fn encoded(linear: f64) -> f64 {
    let x = linear.max(0.0);
    match x <= 0.003_130_8 {
        true => 12.92 * x,
        // 1.055 x^(1/2.4) - 0.055, and 1 at 1.
        false => 1.055 * (pow(x, 1.0 / 2.4) - 1.0) + 1.0,
    }
}

/// Encodes a linear colour.
pub(super) fn encoded_color(linear: [f64; 3]) -> DVec3 {
    DVec3::from_array(linear.map(encoded))
}

/// KHR_texture_transform: T R S applied to coordinates whose v runs down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TextureTransform {
    offset: DVec2,
    rotation_rad: f64,
    scale: DVec2,
}

impl TextureTransform {
    pub(super) const NONE: TextureTransform =
        TextureTransform { offset: DVec2::ZERO, rotation_rad: 0.0, scale: DVec2::ONE };

    pub(super) fn read(extension: &Json) -> Result<Self, LoadError> {
        let pair = |name: &str, default: [f64; 2]| {
            Ok::<_, LoadError>(DVec2::from_array(extension.member(name).numbers()?.unwrap_or(default)))
        };
        Ok(TextureTransform {
            offset: pair("offset", [0.0; 2])?,
            rotation_rad: extension.member("rotation").number_or(0.0)?,
            scale: pair("scale", [1.0; 2])?,
        })
    }

    /// Returns transformed coordinates. A positive angle turns them counter-clockwise as seen, with
    /// v down.
    pub(super) fn apply(&self, uv: DVec2) -> DVec2 {
        let p = uv * self.scale;
        let (sin, cos) = libm::sincos(self.rotation_rad);
        self.offset + DVec2::new(cos * p.x + sin * p.y, cos * p.y - sin * p.x)
    }
}

/// Reads a material; without one, the file's default: white, fully metallic and rough.
pub(super) fn read(source: &mut Source, images: &mut Images, json: &Json) -> Result<Surface, LoadError> {
    warn_of_textures(source, json);
    let glossy = json.extension("KHR_materials_pbrSpecularGlossiness");
    let physical = json.member("pbrMetallicRoughness");
    let (part, factor, texture) = match glossy.is_object() {
        true => (&glossy, "diffuseFactor", "diffuseTexture"),
        false => (&physical, "baseColorFactor", "baseColorTexture"),
    };
    let [r, g, b, alpha] = part.member(factor).numbers()?.unwrap_or([1.0; 4]);
    let color = encoded_color([r, g, b]);
    let mode = json.member("alphaMode").one_of(&["OPAQUE", "MASK", "BLEND"]);
    let is_blended = mode == "BLEND";
    let cutoff = json.member("alphaCutoff").number_or(0.5)?;
    let alpha_use = match mode {
        "BLEND" => AlphaUse::Blend,
        // texel * alpha >= cutoff.
        "MASK" if alpha > 0.0 => AlphaUse::Mask((cutoff / alpha * 255.0).ceil().clamp(0.0, 256.0) as u16),
        "MASK" => AlphaUse::Mask(if cutoff <= 0.0 { 0 } else { 256 }),
        _ => AlphaUse::Opaque,
    };
    let least_alpha = (mode == "MASK" && alpha > 0.0).then(|| cutoff / alpha);
    let info = part.member(texture);
    let (mut made, mut texcoord, mut transform) = (None, 0, TextureTransform::NONE);
    if info.is_object() {
        made = images.texture(source, &info.member("index"), alpha_use)?;
        let extension = info.extension("KHR_texture_transform");
        transform = TextureTransform::read(&extension)?;
        let own = info.member("texCoord").whole_or(0)?;
        texcoord = extension.member("texCoord").whole_or(own)?;
    }
    let (metallic, roughness) = match glossy.is_object() {
        true => (0.0, 1.0 - glossy.member("glossinessFactor").number_or(1.0)?),
        false => roughness(source, images, &physical)?,
    };
    let reflection = physical::reflection(color, metallic, roughness);
    let strength = json.extension("KHR_materials_emissive_strength").member("emissiveStrength");
    let strength = strength.number_or(1.0)?;
    let emissive = json.member("emissiveFactor").numbers()?.unwrap_or([0.0; 3]);
    // Without its texture the factor would make the whole surface glow.
    let emissive = if json.member("emissiveTexture").is_object() { [0.0; 3] } else { emissive };
    let mut material = Material {
        ka: reflection.kd * occlusion(source, images, json)?,
        kd: reflection.kd,
        ks: reflection.ks,
        n: reflection.n,
        emissive: encoded_color(emissive.map(|e| e * strength)),
        transparency: if is_blended { (1.0 - alpha).clamp(0.0, 1.0) } else { 0.0 },
        model: LightingModel::Blinn,
        texture: None,
        name: json.member("name").word().unwrap_or("").to_owned(),
    };
    if glossy.is_object() {
        let specular = glossy.member("specularFactor").numbers()?.unwrap_or([1.0; 3]);
        material.ks *= encoded_color(specular) / 0.04;
        material.ks = material.ks.min(DVec3::ONE);
    }
    if json.extension("KHR_materials_unlit").is_object() {
        material = unlit(color, material);
    }
    let is_invisible = made.is_none() && alpha_use == AlphaUse::Mask(256);
    let is_double_sided = json.member("doubleSided").bool_or(false)?;
    let blends = is_blended;
    let texture = made;
    Ok(Surface { material, texture, texcoord, transform, is_double_sided, blends, is_invisible, least_alpha })
}

/// Returns a material of one colour that no light changes; vertex colours and texture multiply it.
pub(super) fn unlit(color: DVec3, material: Material) -> Material {
    Material {
        ka: DVec3::ZERO,
        kd: DVec3::ZERO,
        ks: DVec3::ZERO,
        emissive: color,
        model: LightingModel::Unlit,
        ..material
    }
}

/// Returns the part of the ambient light that reaches a surface: the mean of its occlusion texture.
fn occlusion(source: &mut Source, images: &mut Images, json: &Json) -> Result<f64, LoadError> {
    let texture = json.member("occlusionTexture");
    let strength = texture.member("strength").number_or(1.0)?.clamp(0.0, 1.0);
    let mean = if texture.is_object() { images.mean(source, &texture.member("index"))? } else { None };
    // The picture is linear, as a factor of light is.
    Ok(mean.map_or(1.0, |[red, ..]| encoded(1.0 + strength * (red - 1.0))))
}

/// Returns metallic and roughness: factors times the means of their texture.
fn roughness(source: &mut Source, images: &mut Images, physical: &Json) -> Result<(f64, f64), LoadError> {
    let mut metallic = physical.member("metallicFactor").number_or(1.0)?;
    let mut roughness = physical.member("roughnessFactor").number_or(1.0)?;
    let texture = physical.member("metallicRoughnessTexture");
    if texture.is_object()
        && let Some([_, green, blue]) = images.mean(source, &texture.member("index"))?
    {
        (metallic, roughness) = (metallic * blue, roughness * green);
    }
    Ok((metallic, roughness))
}

/// Warns of textures that the renderer has no use for.
fn warn_of_textures(source: &mut Source, json: &Json) {
    for name in ["normalTexture", "emissiveTexture"] {
        let texture = json.member(name);
        if texture.is_object() {
            source.warn(texture.warning("textures of this kind are left out"));
        }
    }
}

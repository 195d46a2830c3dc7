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
//! dims Ka; textures of occlusion, normals and emission are maps (`maps`), the last times Ke: its
//! picture is encoded already. KHR_materials_pbrSpecularGlossiness: c = E(diffuse), m = 0, r = 1 -
//! glossiness, and Ks scaled to the specular colour.
//!
//! Source: glTF 2.0 Specification, section 3.9 (Materials).

use super::image::{AlphaUse, Images, Source, Tone};
use super::json::Json;
use super::maps::{MapTexture, MapTextures, mean_occlusion};
use crate::load::{LoadError, physical};
pub(super) use fbptr_core::scene::encoded;
use fbptr_core::scene::{LightingModel, Material};
use glam::DVec3;

/// Most light that is emitted, linear: 333 times white in the picture's numbers.
const MAX_EMISSION: f64 = 1e6;

/// Appearance of a primitive.
pub(super) struct Surface {
    pub(super) material: Material,
    pub(super) texture: Option<MapTexture>,
    pub(super) maps: MapTextures,
    pub(super) is_double_sided: bool,
    /// Set if alpha of vertices counts.
    pub(super) blends: bool,
    /// Set if nothing of it can be seen (MASK).
    pub(super) is_invisible: bool,
    /// Least alpha of vertices that is seen (MASK).
    pub(super) least_alpha: Option<f64>,
}

/// Encodes a linear colour.
pub(super) fn encoded_color(linear: [f64; 3]) -> DVec3 {
    DVec3::from_array(linear.map(encoded))
}

impl Surface {
    /// Leaves the maps out, with a warning, and with the emission that one of them limits.
    pub(super) fn leave_maps_out(&mut self, source: &mut Source, primitive: &Json, what: &str) {
        source.warn(primitive.warning(format!("{what} are left out")));
        if self.maps.emission.is_some() {
            self.material.emissive = DVec3::ZERO;
        }
        self.maps = MapTextures::default();
    }
}

/// Reads a material; without one, the file's default: white, fully metallic and rough.
pub(super) fn read(source: &mut Source, images: &mut Images, json: &Json) -> Result<Surface, LoadError> {
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
    let texture = MapTexture::read(source, images, &part.member(texture), alpha_use)?;
    let (metallic, roughness) = match glossy.is_object() {
        true => (0.0, 1.0 - glossy.member("glossinessFactor").number_or(1.0)?),
        false => roughness(source, images, &physical)?,
    };
    let reflection = physical::reflection(color, metallic, roughness);
    let strength = json.extension("KHR_materials_emissive_strength").member("emissiveStrength");
    let strength = strength.number_or(1.0)?;
    let factor = DVec3::from(json.member("emissiveFactor").numbers()?.unwrap_or([0.0; 3]));
    let mut emission = encoded_color((factor * strength).min(DVec3::splat(MAX_EMISSION)).to_array());
    let occlusion = mean_occlusion(source, images, json)?;
    let mut maps = MapTextures::read(source, images, json, &mut emission, occlusion)?;
    let mut material = Material {
        ka: reflection.kd * occlusion,
        kd: reflection.kd,
        ks: reflection.ks,
        n: reflection.n,
        emissive: emission,
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
        maps = MapTextures::default();
    }
    let is_invisible = texture.is_none() && alpha_use == AlphaUse::Mask(256);
    let is_double_sided = json.member("doubleSided").bool_or(false)?;
    let blends = is_blended;
    Ok(Surface { material, texture, maps, is_double_sided, blends, is_invisible, least_alpha })
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

/// Returns metallic and roughness: factors times the means of their texture.
fn roughness(source: &mut Source, images: &mut Images, physical: &Json) -> Result<(f64, f64), LoadError> {
    let mut metallic = physical.member("metallicFactor").number_or(1.0)?;
    let mut roughness = physical.member("roughnessFactor").number_or(1.0)?;
    let texture = physical.member("metallicRoughnessTexture");
    if texture.is_object()
        && let Some(Tone { mean: [_, green, blue], .. }) = images.tone(source, &texture.member("index"))?
    {
        (metallic, roughness) = (metallic * blue, roughness * green);
    }
    Ok((metallic, roughness))
}

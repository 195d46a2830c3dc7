//! Table of shapes, materials, textures and the font style.

use super::super::value::Kind::{Bool, Image, Int, Mf, Sf, Text, Texts};
use super::structure::BOUNDED;
use super::{FieldDef, NodeDef, f, n};

/// Fields of every texture.
const TEXTURE: &[FieldDef] =
    &[f("description", Text, ""), f("repeatS", Bool, "true"), f("repeatT", Bool, "true")];

/// Fields by which X3D 4 names a lit material's texture coordinates.
const MAPPINGS: &[FieldDef] = &[
    f("emissiveTextureMapping", Text, ""),
    f("normalScale", Sf(1), "1"),
    f("normalTextureMapping", Text, ""),
    f("occlusionStrength", Sf(1), "1"),
    f("occlusionTextureMapping", Text, ""),
];

pub(super) const NODES: &[NodeDef] = &[
    n("Shape", "children", &["appearance", "geometry"], &[&[f("castShadow", Bool, "true")], BOUNDED]),
    n(
        "Appearance",
        "appearance",
        &["material", "backMaterial", "texture", "textureTransform", "fillProperties", "lineProperties"],
        &[&[f("alphaCutoff", Sf(1), "0.5"), f("alphaMode", Text, "AUTO")]],
    ),
    n(
        "Material",
        "material",
        &[
            "ambientTexture",
            "diffuseTexture",
            "emissiveTexture",
            "normalTexture",
            "occlusionTexture",
            "shininessTexture",
            "specularTexture",
        ],
        &[
            &[
                f("ambientIntensity", Sf(1), "0.2"),
                f("ambientTextureMapping", Text, ""),
                f("diffuseColor", Sf(3), "0.8 0.8 0.8"),
                f("diffuseTextureMapping", Text, ""),
                f("emissiveColor", Sf(3), "0 0 0"),
                f("shininess", Sf(1), "0.2"),
                f("shininessTextureMapping", Text, ""),
                f("specularColor", Sf(3), "0 0 0"),
                f("specularTextureMapping", Text, ""),
                f("transparency", Sf(1), "0"),
            ],
            MAPPINGS,
        ],
    ),
    n(
        "TwoSidedMaterial",
        "material",
        &[],
        &[&[
            f("ambientIntensity", Sf(1), "0.2"),
            f("backAmbientIntensity", Sf(1), "0.2"),
            f("backDiffuseColor", Sf(3), "0.8 0.8 0.8"),
            f("backEmissiveColor", Sf(3), "0 0 0"),
            f("backShininess", Sf(1), "0.2"),
            f("backSpecularColor", Sf(3), "0 0 0"),
            f("backTransparency", Sf(1), "0"),
            f("diffuseColor", Sf(3), "0.8 0.8 0.8"),
            f("emissiveColor", Sf(3), "0 0 0"),
            f("separateBackColor", Bool, "false"),
            f("shininess", Sf(1), "0.2"),
            f("specularColor", Sf(3), "0 0 0"),
            f("transparency", Sf(1), "0"),
        ]],
    ),
    n(
        "UnlitMaterial",
        "material",
        &["emissiveTexture", "normalTexture"],
        &[&[
            f("emissiveColor", Sf(3), "1 1 1"),
            f("emissiveTextureMapping", Text, ""),
            f("normalScale", Sf(1), "1"),
            f("normalTextureMapping", Text, ""),
            f("transparency", Sf(1), "0"),
        ]],
    ),
    n(
        "PhysicalMaterial",
        "material",
        &["baseTexture", "emissiveTexture", "metallicRoughnessTexture", "normalTexture", "occlusionTexture"],
        &[
            &[
                f("baseColor", Sf(3), "1 1 1"),
                f("baseTextureMapping", Text, ""),
                f("emissiveColor", Sf(3), "0 0 0"),
                f("metallic", Sf(1), "1"),
                f("metallicRoughnessTextureMapping", Text, ""),
                f("roughness", Sf(1), "1"),
                f("transparency", Sf(1), "0"),
            ],
            MAPPINGS,
        ],
    ),
    n(
        "ImageTexture",
        "texture",
        &[],
        &[
            TEXTURE,
            &[
                f("autoRefresh", Sf(1), "0"),
                f("autoRefreshTimeLimit", Sf(1), "3600"),
                f("load", Bool, "true"),
                f("url", Texts, ""),
            ],
        ],
    ),
    n("PixelTexture", "texture", &[], &[TEXTURE, &[f("image", Image, "0 0 0")]]),
    n(
        "MultiTexture",
        "texture",
        &["texture"],
        &[&[
            f("alpha", Sf(1), "1"),
            f("color", Sf(3), "1 1 1"),
            f("description", Text, ""),
            f("function", Texts, ""),
            f("mode", Texts, ""),
            f("source", Texts, ""),
        ]],
    ),
    n("MultiTextureTransform", "textureTransform", &["textureTransform"], &[&[f("mapping", Text, "")]]),
    n(
        "LineProperties",
        "lineProperties",
        &[],
        &[&[f("applied", Bool, "true"), f("linetype", Int, "1"), f("linewidthScaleFactor", Sf(1), "0")]],
    ),
    n(
        "FillProperties",
        "fillProperties",
        &[],
        &[&[
            f("filled", Bool, "true"),
            f("hatchColor", Sf(3), "1 1 1"),
            f("hatchStyle", Int, "1"),
            f("hatched", Bool, "true"),
        ]],
    ),
    n(
        "TextureTransform",
        "textureTransform",
        &[],
        &[&[
            f("center", Sf(2), "0 0"),
            f("mapping", Text, ""),
            f("rotation", Sf(1), "0"),
            f("scale", Sf(2), "1 1"),
            f("translation", Sf(2), "0 0"),
        ]],
    ),
    n(
        "Text",
        "geometry",
        &["fontStyle"],
        &[&[
            f("length", Mf(1), ""),
            f("maxExtent", Sf(1), "0"),
            f("solid", Bool, "false"),
            f("string", Texts, ""),
        ]],
    ),
    n(
        "FontStyle",
        "fontStyle",
        &[],
        &[&[
            f("family", Texts, "\"SERIF\""),
            f("horizontal", Bool, "true"),
            f("justify", Texts, "\"BEGIN\""),
            f("language", Text, ""),
            f("leftToRight", Bool, "true"),
            f("size", Sf(1), "1"),
            f("spacing", Sf(1), "1"),
            f("style", Text, "PLAIN"),
            f("topToBottom", Bool, "true"),
        ]],
    ),
];

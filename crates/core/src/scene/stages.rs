//! Multitexturing: several textures on one surface, applied in sequence (X3D's MultiTexture).
//!
//! In: the lit colour of the surface (the Ka and Kd terms, times vertex colours) with its opacity,
//! and each stage's texel. Out: the colour and opacity that replace them; the Ks and Ke terms are
//! added afterwards, as with one texture.
//!
//! Source: ISO/IEC 19775-1 clause 18.4.3, tables 18.3 (modes), 18.4 (sources) and 18.5 (functions).
//! DOTPRODUCT3, which the tables leave open, is as in fixed-function hardware.
//!
//! Arg1 is the stage's texel, Arg2 the result of the previous stage (for the first one, the lit
//! colour) or the value that `source` selects. A single MODULATE stage equals a plain texture: its
//! product is not clamped; every other result is clamped to 0..1. A mode without an alpha mode of
//! its own uses itself for alpha if it selects or multiplies, MODULATE if it adds or subtracts, and
//! SELECTARG2 if it blends, so that opaque surfaces stay opaque.

use super::{Sampling, Texture};
use glam::{DVec2, DVec3, DVec4, Vec4Swizzles};
use std::sync::Arc;

/// Largest number of stages of an object.
pub const MAX_STAGES: usize = 8;

/// Combination of a stage's texel with the colour so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum StageMode {
    /// Arg1 * Arg2.
    #[default]
    Modulate,
    /// Arg1.
    Replace,
    /// Arg1 * Arg2 * 2.
    Modulate2x,
    /// Arg1 * Arg2 * 4.
    Modulate4x,
    /// Arg1 + Arg2.
    Add,
    /// Arg1 + Arg2 - 0.5.
    AddSigned,
    /// (Arg1 + Arg2 - 0.5) * 2.
    AddSigned2x,
    /// Arg1 - Arg2.
    Subtract,
    /// Arg1 + Arg2 - Arg1 * Arg2.
    AddSmooth,
    /// Arg1 and Arg2 blended by the lit colour's opacity.
    BlendDiffuseAlpha,
    /// Arg1 and Arg2 blended by the texel's alpha.
    BlendTextureAlpha,
    /// Arg1 and Arg2 blended by the factor's alpha.
    BlendFactorAlpha,
    /// Arg1 and Arg2 blended by the alpha of the previous stage.
    BlendCurrentAlpha,
    /// Arg1.rgb + Arg1.a * Arg2.rgb.
    ModulateAlphaAddColor,
    /// (1 - Arg1.a) * Arg2.rgb + Arg1.rgb.
    ModulateInvAlphaAddColor,
    /// (1 - Arg1.rgb) * Arg2.rgb + Arg1.a.
    ModulateInvColorAddAlpha,
    /// 4 sum((Arg1 - 0.5) (Arg2 - 0.5)), in every channel.
    DotProduct3,
    /// Arg1.
    SelectArg1,
    /// Arg2.
    SelectArg2,
    /// The colour so far, unchanged.
    Off,
}

impl StageMode {
    /// Returns the mode of an X3D keyword in any case, or `None`.
    pub fn from_word(word: &str) -> Option<StageMode> {
        Some(match word.to_ascii_uppercase().as_str() {
            "MODULATE" => StageMode::Modulate,
            "REPLACE" => StageMode::Replace,
            "MODULATE2X" => StageMode::Modulate2x,
            "MODULATE4X" => StageMode::Modulate4x,
            "ADD" => StageMode::Add,
            "ADDSIGNED" => StageMode::AddSigned,
            "ADDSIGNED2X" => StageMode::AddSigned2x,
            "SUBTRACT" => StageMode::Subtract,
            "ADDSMOOTH" => StageMode::AddSmooth,
            "BLENDDIFFUSEALPHA" => StageMode::BlendDiffuseAlpha,
            "BLENDTEXTUREALPHA" => StageMode::BlendTextureAlpha,
            "BLENDFACTORALPHA" => StageMode::BlendFactorAlpha,
            "BLENDCURRENTALPHA" => StageMode::BlendCurrentAlpha,
            "MODULATEALPHA_ADDCOLOR" => StageMode::ModulateAlphaAddColor,
            "MODULATEINVALPHA_ADDCOLOR" => StageMode::ModulateInvAlphaAddColor,
            "MODULATEINVCOLOR_ADDALPHA" => StageMode::ModulateInvColorAddAlpha,
            "DOTPRODUCT3" => StageMode::DotProduct3,
            "SELECTARG1" => StageMode::SelectArg1,
            "SELECTARG2" => StageMode::SelectArg2,
            "OFF" => StageMode::Off,
            _ => return None,
        })
    }

    /// Returns the default alpha mode for this colour mode.
    pub fn of_alpha(self) -> StageMode {
        use StageMode as M;
        match self {
            M::Add | M::AddSigned | M::AddSigned2x | M::Subtract | M::AddSmooth | M::DotProduct3 => {
                M::Modulate
            }
            M::ModulateAlphaAddColor | M::ModulateInvAlphaAddColor | M::ModulateInvColorAddAlpha => {
                M::Modulate
            }
            M::BlendDiffuseAlpha | M::BlendTextureAlpha | M::BlendFactorAlpha | M::BlendCurrentAlpha => {
                M::SelectArg2
            }
            mode => mode,
        }
    }

    /// Returns whether the resulting alpha is 1, given whether each argument's alpha is 1.
    fn makes_opaque(self, arg1: bool, arg2: bool) -> bool {
        use StageMode as M;
        match self {
            M::Replace | M::SelectArg1 | M::ModulateAlphaAddColor | M::ModulateInvAlphaAddColor => arg1,
            M::SelectArg2 | M::Off => arg2,
            M::Add | M::AddSmooth | M::ModulateInvColorAddAlpha => arg1 || arg2,
            M::Subtract => false,
            _ => arg1 && arg2,
        }
    }

    /// Returns R, G, B before clamping; for alpha, the caller passes it in every channel. `blend`
    /// holds the weights of the four blending modes in their order.
    fn join(self, arg1: DVec4, arg2: DVec4, blend: [f64; 4]) -> DVec3 {
        let (a, b) = (arg1.xyz(), arg2.xyz());
        let half = DVec3::splat(0.5);
        let mix = |weight: f64| a * weight + b * (1.0 - weight);
        match self {
            StageMode::Modulate => a * b,
            StageMode::Replace | StageMode::SelectArg1 => a,
            StageMode::SelectArg2 | StageMode::Off => b,
            StageMode::Modulate2x => a * b * 2.0,
            StageMode::Modulate4x => a * b * 4.0,
            StageMode::Add => a + b,
            StageMode::AddSigned => a + b - half,
            StageMode::AddSigned2x => (a + b - half) * 2.0,
            StageMode::Subtract => a - b,
            StageMode::AddSmooth => a + b - a * b,
            StageMode::BlendDiffuseAlpha => mix(blend[0]),
            StageMode::BlendTextureAlpha => mix(blend[1]),
            StageMode::BlendFactorAlpha => mix(blend[2]),
            StageMode::BlendCurrentAlpha => mix(blend[3]),
            StageMode::ModulateAlphaAddColor => a + b * arg1.w,
            StageMode::ModulateInvAlphaAddColor => a + b * (1.0 - arg1.w),
            StageMode::ModulateInvColorAddAlpha => (DVec3::ONE - a) * b + DVec3::splat(arg1.w),
            StageMode::DotProduct3 => DVec3::splat(4.0 * (a - half).dot(b - half)),
        }
    }
}

/// Source of Arg2.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum StageSource {
    /// Result of the previous stage.
    #[default]
    Before,
    /// Lit colour: the Ka and Kd terms.
    Diffuse,
    /// Specular colour: the Ks and Ke terms.
    Specular,
    /// Factor of the stages.
    Factor,
}

/// Function applied to a stage's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum StageFunction {
    /// None.
    #[default]
    None,
    /// Replaces R, G, B by 1 minus themselves.
    Complement,
    /// Replaces R, G, B by alpha.
    AlphaReplicate,
}

/// Texture with the rules of its stage.
#[derive(Clone, Debug)]
pub struct TextureStage {
    /// Texture; a stage without one is off.
    pub texture: Option<Arc<Texture>>,
    /// Filter and wrap modes.
    pub sampling: Sampling,
    /// Texture coordinates, one per corner of the mesh.
    pub texcoords: Arc<[DVec2]>,
    /// Mode for R, G, B.
    pub color: StageMode,
    /// Mode for alpha.
    pub alpha: StageMode,
    /// Source of Arg2.
    pub source: StageSource,
    /// Function applied to the result.
    pub function: StageFunction,
}

/// Texture stages of an object with their common factor; see the module.
#[derive(Clone, Debug, Default)]
pub struct TextureStages {
    /// Stages in the order of application, at most [`MAX_STAGES`].
    pub stages: Vec<TextureStage>,
    /// Factor R, G, B, A.
    pub factor: DVec4,
}

impl TextureStages {
    /// Applies the stages to the lit colour and opacity, and returns the resulting ones. `texel`
    /// returns the R, G, B, A of a stage by its number.
    pub fn combine(
        &self,
        (diffuse, opacity): (DVec3, f64),
        specular: DVec3,
        mut texel: impl FnMut(usize) -> [f64; 4],
    ) -> (DVec3, f64) {
        let light = diffuse.extend(opacity);
        let mut now = light;
        for (number, stage) in self.stages.iter().enumerate() {
            if stage.texture.is_none() || stage.color == StageMode::Off {
                continue;
            }
            let arg1 = DVec4::from(texel(number));
            let arg2 = match stage.source {
                StageSource::Before => now,
                StageSource::Diffuse => light,
                StageSource::Specular => specular.extend(opacity),
                StageSource::Factor => self.factor,
            };
            let blend = [opacity, arg1.w, self.factor.w, now.w];
            let mut color = stage.color.join(arg1, arg2, blend);
            let alpha = stage.alpha.join(DVec4::splat(arg1.w), DVec4::splat(arg2.w), blend).x.clamp(0.0, 1.0);
            match stage.function {
                StageFunction::None => {}
                StageFunction::Complement => color = DVec3::ONE - color,
                StageFunction::AlphaReplicate => color = DVec3::splat(alpha),
            }
            if (stage.color, stage.function) != (StageMode::Modulate, StageFunction::None) {
                color = color.clamp(DVec3::ZERO, DVec3::ONE);
            }
            now = color.extend(alpha);
        }
        (now.xyz(), now.w)
    }

    /// Returns whether the stages may make a surface transparent whose material is opaque.
    pub fn may_be_transparent(&self) -> bool {
        let mut is_opaque = true;
        for stage in &self.stages {
            let Some(texture) = stage.texture.as_ref().filter(|_| stage.color != StageMode::Off) else {
                continue;
            };
            let arg2 = match stage.source {
                StageSource::Before => is_opaque,
                StageSource::Diffuse | StageSource::Specular => true,
                StageSource::Factor => self.factor.w >= 1.0,
            };
            is_opaque = stage.alpha.makes_opaque(!texture.has_alpha(), arg2);
        }
        !is_opaque
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stage(color: StageMode) -> TextureStage {
        TextureStage {
            texture: Some(Arc::new(Texture::new(1, 1, vec![255; 4]).unwrap())),
            sampling: Sampling::default(),
            texcoords: Arc::new([]),
            color,
            alpha: color.of_alpha(),
            source: StageSource::Before,
            function: StageFunction::None,
        }
    }

    /// Result for a light of 0.5 0.25 1 with opacity 0.5, texels of one colour, and a factor of 0.1
    /// 0.2 0.3 0.25.
    fn made(stages: Vec<TextureStage>, texels: &[[f64; 4]]) -> (DVec3, f64) {
        let all = TextureStages { stages, factor: DVec4::new(0.1, 0.2, 0.3, 0.25) };
        all.combine((DVec3::new(0.5, 0.25, 1.0), 0.5), DVec3::new(0.0, 0.5, 0.75), |i| texels[i])
    }

    fn close(found: (DVec3, f64), color: [f64; 3], alpha: f64) {
        let color = DVec3::from(color);
        assert!(
            (found.0 - color).length() < 1e-12 && (found.1 - alpha).abs() < 1e-12,
            "{found:?}, not {color} {alpha}"
        );
    }

    #[test]
    fn every_mode_is_the_tables_formula() {
        use StageMode as M;
        let texel = [0.4, 0.8, 0.25, 0.75];
        for (mode, color, alpha) in [
            (M::Modulate, [0.2, 0.2, 0.25], 0.375),
            (M::Replace, [0.4, 0.8, 0.25], 0.75),
            (M::SelectArg1, [0.4, 0.8, 0.25], 0.75),
            (M::SelectArg2, [0.5, 0.25, 1.0], 0.5),
            (M::Modulate2x, [0.4, 0.4, 0.5], 0.75),
            (M::Modulate4x, [0.8, 0.8, 1.0], 1.0),
            (M::Add, [0.9, 1.0, 1.0], 0.375),
            (M::AddSigned, [0.4, 0.55, 0.75], 0.375),
            (M::AddSigned2x, [0.8, 1.0, 1.0], 0.375),
            (M::Subtract, [0.0, 0.55, 0.0], 0.375),
            (M::AddSmooth, [0.7, 0.85, 1.0], 0.375),
            (M::BlendDiffuseAlpha, [0.45, 0.525, 0.625], 0.5),
            (M::BlendTextureAlpha, [0.425, 0.6625, 0.4375], 0.5),
            (M::BlendFactorAlpha, [0.475, 0.3875, 0.8125], 0.5),
            (M::BlendCurrentAlpha, [0.45, 0.525, 0.625], 0.5),
            (M::ModulateAlphaAddColor, [0.775, 0.9875, 1.0], 0.375),
            (M::ModulateInvAlphaAddColor, [0.525, 0.8625, 0.5], 0.375),
            (M::ModulateInvColorAddAlpha, [1.0, 0.8, 1.0], 0.375),
            (M::DotProduct3, [0.0, 0.0, 0.0], 0.375),
            (M::Off, [0.5, 0.25, 1.0], 0.5),
        ] {
            close(made(vec![stage(mode)], &[texel]), color, alpha);
        }
        // 4 (0.5 * 0 + 0.5 * -0.25 + 0.5 * 0.5).
        close(made(vec![stage(M::DotProduct3)], &[[1.0; 4]]), [0.5; 3], 0.5);
    }

    #[test]
    fn stages_follow_each_other_and_one_product_is_not_clamped() {
        use StageMode as M;
        let three = vec![stage(M::Modulate), stage(M::Add), stage(M::Subtract)];
        // (0.5 0.25 1) * (1 1 0.5) = (0.5 0.25 0.5); + 0.25 = (0.75 0.5 0.75); (1 1 1) - that.
        close(
            made(three, &[[1.0, 1.0, 0.5, 1.0], [0.25, 0.25, 0.25, 1.0], [1.0; 4]]),
            [0.25, 0.5, 0.25],
            0.5,
        );
        let bright = TextureStages { stages: vec![stage(M::Modulate)], factor: DVec4::ONE };
        let (color, _) = bright.combine((DVec3::splat(3.0), 1.0), DVec3::ZERO, |_| [0.5; 4]);
        assert_eq!(color, DVec3::splat(1.5));
    }

    #[test]
    fn sources_functions_and_alpha_modes_are_the_stages_own() {
        use StageMode as M;
        let with = |source| vec![stage(M::Replace), TextureStage { source, ..stage(M::Modulate) }];
        let texels = [[0.2, 0.2, 0.2, 1.0], [1.0, 1.0, 1.0, 1.0]];
        close(made(with(StageSource::Before), &texels), [0.2; 3], 1.0);
        close(made(with(StageSource::Diffuse), &texels), [0.5, 0.25, 1.0], 0.5);
        close(made(with(StageSource::Specular), &texels), [0.0, 0.5, 0.75], 0.5);
        close(made(with(StageSource::Factor), &texels), [0.1, 0.2, 0.3], 0.25);
        let does = |function| vec![TextureStage { function, ..stage(M::Modulate) }];
        close(made(does(StageFunction::Complement), &[[1.0; 4]]), [0.5, 0.75, 0.0], 0.5);
        close(made(does(StageFunction::AlphaReplicate), &[[1.0; 4]]), [0.5; 3], 0.5);
        let own = TextureStage { alpha: M::Replace, ..stage(M::Modulate) };
        close(made(vec![own], &[[1.0, 1.0, 1.0, 0.125]]), [0.5, 0.25, 1.0], 0.125);
        let off = TextureStage { texture: None, ..stage(M::Replace) };
        close(made(vec![off], &[[1.0; 4]]), [0.5, 0.25, 1.0], 0.5);
    }

    #[test]
    fn what_may_let_light_through_is_known_before() {
        let all = |stages, w| TextureStages { stages, factor: DVec4::new(1.0, 1.0, 1.0, w) };
        assert!(!all(vec![stage(StageMode::Add), stage(StageMode::Subtract)], 0.5).may_be_transparent());
        let factor = TextureStage { source: StageSource::Factor, ..stage(StageMode::Modulate) };
        assert!(all(vec![factor.clone()], 0.5).may_be_transparent());
        assert!(!all(vec![factor], 1.0).may_be_transparent());
        let clear = TextureStage { alpha: StageMode::Subtract, ..stage(StageMode::Add) };
        assert!(all(vec![clear], 1.0).may_be_transparent());
        let picture = Texture::new(1, 1, vec![0, 0, 0, 9]).unwrap();
        let with = |mode| TextureStage { texture: Some(Arc::new(picture.clone())), ..stage(mode) };
        assert!(all(vec![with(StageMode::Modulate)], 1.0).may_be_transparent());
        assert!(all(vec![with(StageMode::Replace)], 1.0).may_be_transparent());
        assert!(!all(vec![with(StageMode::BlendTextureAlpha)], 1.0).may_be_transparent());
        assert!(!all(vec![with(StageMode::Off)], 1.0).may_be_transparent());
        assert!(!all(vec![with(StageMode::Modulate), stage(StageMode::Replace)], 1.0).may_be_transparent());
    }

    #[test]
    fn every_word_of_the_table_is_a_mode() {
        for word in [
            "MODULATE",
            "REPLACE",
            "MODULATE2X",
            "MODULATE4X",
            "ADD",
            "ADDSIGNED",
            "ADDSIGNED2X",
            "SUBTRACT",
            "ADDSMOOTH",
            "BLENDDIFFUSEALPHA",
            "BLENDTEXTUREALPHA",
            "BLENDFACTORALPHA",
            "BLENDCURRENTALPHA",
            "MODULATEALPHA_ADDCOLOR",
            "MODULATEINVALPHA_ADDCOLOR",
            "MODULATEINVCOLOR_ADDALPHA",
            "DOTPRODUCT3",
            "SELECTARG1",
            "SELECTARG2",
            "OFF",
        ] {
            assert!(StageMode::from_word(word).is_some(), "{word}");
            assert_eq!(StageMode::from_word(&word.to_lowercase()), StageMode::from_word(word));
        }
        assert_eq!(StageMode::from_word("BUMP"), None);
    }
}

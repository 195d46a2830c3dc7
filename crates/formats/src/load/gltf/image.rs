//! Pictures of a glTF file as textures, made ready for the samplers and materials that use them.
//!
//! Each picture is decoded once. The renderer knows the wraps repeat and clamp, and blends by alpha
//! always, so a texture is made for each use: without alpha for an opaque material; with an alpha of
//! 0 or 255 for a masked one; twice as wide or high for mirrored repetition, beside its mirror image
//! (coordinates are halved then). A picture that cannot be read is left out with a warning.
//!
//! Source: glTF 2.0 Specification, section 3.8 (Texture Data).

use super::buffers::{Buffers, referenced};
use super::json::Json;
use crate::load::{LoadContext, LoadError, LoadErrorKind, LoadWarning, texture};
use fbptr_core::error::Code;
use fbptr_core::scene::{Filter, MAX_TEXTURE_SIDE, Sampling, Texture, Wrap};
use std::collections::HashMap;
use std::sync::Arc;

/// Use of a picture's alpha.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum AlphaUse {
    /// Every texel is opaque.
    Opaque,
    /// Texels of this alpha and above are opaque, the others invisible; above 255 all are.
    Mask(u16),
    /// Alpha as it is.
    Blend,
}

/// A texture as a material needs it.
pub(super) struct MadeTexture {
    pub(super) texture: Arc<Texture>,
    pub(super) sampling: Sampling,
    /// Set for u and for v if their coordinates are halved.
    pub(super) is_mirrored: [bool; 2],
}

/// Pictures of a file.
#[derive(Default)]
pub(super) struct Images {
    decoded: HashMap<usize, Option<Arc<Texture>>>,
    made: HashMap<(usize, AlphaUse, [bool; 2]), Arc<Texture>>,
    tones: HashMap<usize, Tone>,
}

/// Channels R, G, B of a picture.
#[derive(Clone, Copy)]
pub(super) struct Tone {
    /// Means, in 0..1.
    pub(super) mean: [f64; 3],
    /// Set for a channel that is the same everywhere.
    pub(super) is_uniform: [bool; 3],
}

/// Everything that reading a part of a file needs.
pub(super) struct Source<'a, 'b> {
    pub(super) root: Json<'a>,
    pub(super) buffers: Buffers<'a>,
    pub(super) context: LoadContext<'b>,
    pub(super) names_outside: bool,
}

impl Source<'_, '_> {
    /// Adds a warning, unless it is there already or there are enough.
    pub(super) fn warn(&mut self, warning: LoadWarning) {
        self.root.note(warning);
    }
}

impl Images {
    /// Returns the texture with number `index`, for this use of its alpha; `None` if it has no
    /// picture that can be read.
    pub(super) fn texture(
        &mut self,
        source: &mut Source,
        index: &Json,
        alpha: AlphaUse,
    ) -> Result<Option<MadeTexture>, LoadError> {
        let textures = source.root.member("textures");
        let entry = textures.item(index.index("texture", textures.count())?);
        let Some((image, picture)) = self.picture(source, &entry)? else { return Ok(None) };
        let samplers = source.root.member("samplers");
        let sampler = entry.member("sampler").index_if_there("sampler", samplers.count())?;
        let sampler = sampler.map(|i| samplers.item(i));
        let code =
            |name: &str, default| sampler.as_ref().map_or(Ok(default), |s| s.member(name).whole_or(default));
        let wraps = [code("wrapS", 10497)?, code("wrapT", 10497)?];
        let sides = [picture.width(), picture.height()];
        let is_mirrored = [0, 1].map(|i| wraps[i] == 33648 && sides[i] * 2 <= MAX_TEXTURE_SIDE);
        let wrap = |code| if code == 33071 { Wrap::Clamp } else { Wrap::Repeat };
        let filter = match (code("minFilter", 9987)?, code("magFilter", 9729)?) {
            (9728 | 9984, _) | (_, 9728) => Filter::Nearest,
            (9729, _) => Filter::Bilinear,
            (9985 | 9986, _) => Filter::Mipmap,
            _ => Filter::Trilinear,
        };
        let sampling = Sampling { filter, wrap_s: wrap(wraps[0]), wrap_t: wrap(wraps[1]) };
        let alpha =
            if picture.has_alpha() || matches!(alpha, AlphaUse::Mask(_)) { alpha } else { AlphaUse::Blend };
        let key = (image, alpha, is_mirrored);
        if let Some(texture) = self.made.get(&key) {
            return Ok(Some(MadeTexture { texture: Arc::clone(texture), sampling, is_mirrored }));
        }
        let texture = match key {
            (_, AlphaUse::Blend, [false, false]) => picture,
            _ => Arc::new(made(source, &entry, &picture, alpha, is_mirrored)?),
        };
        self.made.insert(key, Arc::clone(&texture));
        Ok(Some(MadeTexture { texture, sampling, is_mirrored }))
    }

    /// Returns the channels of a texture, if it can be read.
    pub(super) fn tone(&mut self, source: &mut Source, index: &Json) -> Result<Option<Tone>, LoadError> {
        let textures = source.root.member("textures");
        let entry = textures.item(index.index("texture", textures.count())?);
        let Some((image, picture)) = self.picture(source, &entry)? else { return Ok(None) };
        let new = || {
            let texels = picture.bytes().as_chunks::<4>().0;
            let sum = |c: usize| texels.iter().map(|t| u64::from(t[c])).sum::<u64>() as f64;
            Tone {
                mean: [0, 1, 2].map(|c| sum(c) / (255.0 * texels.len() as f64)),
                is_uniform: [0, 1, 2].map(|c| texels.iter().all(|t| t[c] == texels[0][c])),
            }
        };
        Ok(Some(*self.tones.entry(image).or_insert_with(new)))
    }

    /// Returns the number of a texture's image, and its picture.
    fn picture(
        &mut self,
        source: &mut Source,
        entry: &Json,
    ) -> Result<Option<(usize, Arc<Texture>)>, LoadError> {
        let images = source.root.member("images");
        // The picture of the extension is the one that the others stand in for.
        let webp = entry.extension("EXT_texture_webp").member("source");
        let number = if webp.is_there() { webp } else { entry.member("source") };
        let Some(image) = number.index_if_there("image", images.count())? else {
            let why = match entry.extension("KHR_texture_basisu").is_there() {
                true => format!("a texture of KTX2 is left out: {}", super::converter("KHR_texture_basisu")),
                false => "a texture without a picture that can be read is left out".to_owned(),
            };
            source.warn(entry.warning(why));
            return Ok(None);
        };
        if let Some(found) = self.decoded.get(&image) {
            return Ok(found.clone().map(|picture| (image, picture)));
        }
        let picture = match decode(source, &images.item(image)) {
            Ok(picture) => Some(Arc::new(picture)),
            Err(error) if error.code() == Code::Quota => return Err(error),
            Err(error) => {
                let message = format!("the picture is left out: {}", error.kind);
                source.warn(LoadWarning { place: error.place, message });
                None
            }
        };
        self.decoded.insert(image, picture.clone());
        Ok(picture.map(|picture| (image, picture)))
    }
}

/// Reads a picture from its file, data URI or buffer view.
fn decode(source: &mut Source, image: &Json) -> Result<Texture, LoadError> {
    let uri = image.member("uri");
    let (root, buffers, context) = (&source.root, &source.buffers, &mut source.context);
    let decoded = match uri.text()? {
        Some(text) => {
            let (bytes, _held) = referenced(&uri, text, context, &mut source.names_outside)?;
            texture::decode_within(&bytes, "picture", context.memory)
        }
        None => {
            let views = root.member("bufferViews");
            let view = image.member("bufferView").index("buffer view", views.count())?;
            let (bytes, _) = buffers.view(&views.item(view))?;
            texture::decode_within(bytes, "picture", context.memory)
        }
    };
    decoded.map_err(|e| image.refuse(e.kind))
}

/// Makes the texture for a use of its alpha, beside its mirror images.
fn made(
    source: &mut Source,
    entry: &Json,
    picture: &Texture,
    alpha: AlphaUse,
    is_mirrored: [bool; 2],
) -> Result<Texture, LoadError> {
    let (w, h) = (picture.width(), picture.height());
    let [wide, high] = is_mirrored.map(|is| if is { 2 } else { 1 });
    let (width, height) = (w * wide, h * high);
    let (bytes, beside) = Texture::bytes_for(width, height);
    let memory = &mut source.context.memory;
    let refused = |kind| entry.refuse(kind);
    memory.reserve_result(bytes).map_err(refused)?;
    let _work = memory.work(beside).map_err(refused)?;
    let texels = picture.bytes().as_chunks::<4>().0;
    let mirrored = |i: u32, side: u32| if i < side { i } else { 2 * side - 1 - i };
    let mut out = Vec::with_capacity(width as usize * height as usize * 4);
    for y in 0..height {
        let row = mirrored(y, h) as usize * w as usize;
        for x in 0..width {
            let [r, g, b, a] = texels[row + mirrored(x, w) as usize];
            let a = match alpha {
                AlphaUse::Blend => a,
                AlphaUse::Opaque => 255,
                AlphaUse::Mask(least) => {
                    if u16::from(a) >= least {
                        255
                    } else {
                        0
                    }
                }
            };
            out.extend([r, g, b, a]);
        }
    }
    Texture::new(width, height, out)
        .map_err(|e| refused(LoadErrorKind::Undecodable { format: "picture", reason: e.to_string() }))
}

//! Picture files: PNG, JPEG, WebP and GIF (first picture), BMP, TGA and PNM to textures.
//!
//! In: the bytes of a file. Out: 8-bit RGBA texels with the values of the file, row 0 at the top;
//! grey becomes three equal channels, pictures without alpha are opaque, 16 bits are rounded to 8.
//! No gamma and no colour profile is applied. Sizes are read from the header and checked before
//! anything is unpacked, so a small file cannot claim much memory.

use super::png_rows::PngRows;
use super::polled::PolledBytes;
use super::{FilePosition, LoadError, LoadErrorKind, LoadMemory, never_panicking};
use crate::save::rgba8;
use fbptr_core::scene::{MAX_TEXTURE_SIDE, Texture, TextureError};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, ImageResult, Limits};
use std::path::Path;

/// Most texels of a texture file.
pub const MAX_TEXELS: u64 = 1 << 26;

/// Bytes that a decoder may allocate for headers: palettes, colour profiles, text.
const HEADER_BYTES: u64 = 8 << 20;

/// Decodes a texture from a file's bytes. Errors name the file "texture".
pub fn decode(bytes: &[u8]) -> Result<Texture, LoadError> {
    decode_file(bytes, "texture")
}

/// Decodes a texture from the bytes of the file `file_name`, which errors refer to.
///
/// The format is detected from the bytes; only if they are ambiguous (TGA) the extension of the
/// name decides.
pub fn decode_file(bytes: &[u8], file_name: &str) -> Result<Texture, LoadError> {
    decode_within(bytes, file_name, &mut LoadMemory::unlimited())
}

/// [`decode_file`] within the limits of `memory`. The texture and the decoder's working memory are
/// reserved once the size is known from the header, before a pixel is unpacked.
///
/// # Errors
/// Those of [`decode_file`], and one if `memory` has no room or is cancelled.
pub fn decode_within(bytes: &[u8], file_name: &str, memory: &mut LoadMemory) -> Result<Texture, LoadError> {
    let fail = |kind| LoadError::new(FilePosition::file(file_name), kind);
    let undecodable = |reason: String| fail(LoadErrorKind::Undecodable { format: "picture", reason });
    if bytes.is_empty() {
        return Err(undecodable("the file is empty".into()));
    }
    if bytes.starts_with(b"\xabKTX 20\xbb") {
        return Err(undecodable("it is KTX2, which `ktx extract` of the KTX software writes as PNG".into()));
    }
    let is_webp = matches!(bytes, [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..]);
    let format = image::guess_format(bytes)
        .or_else(|_| ImageFormat::from_path(Path::new(file_name)))
        .map_err(|_| undecodable("neither its bytes nor its name tell a known format".into()))?;
    let size_error = |width: u32, height: u32| {
        let kind = match u64::from(width.max(height)) {
            side if side > u64::from(MAX_TEXTURE_SIDE) => {
                LoadErrorKind::TooBig { what: "texels a side", found: side, limit: MAX_TEXTURE_SIDE.into() }
            }
            _ => LoadErrorKind::TooBig {
                what: "texels",
                found: u64::from(width) * u64::from(height),
                limit: MAX_TEXELS,
            },
        };
        fail(kind)
    };
    let cancel = memory.cancel().clone();
    let decoded = never_panicking(|| {
        // Some decoders copy the file.
        let mut work = memory.work(HEADER_BYTES + bytes.len() as u64).map_err(fail)?;
        let mut reserve = |width: u32, height: u32, decoded: u64| {
            let pixels = u64::from(width) * u64::from(height);
            if width.max(height) > MAX_TEXTURE_SIDE || pixels > MAX_TEXELS {
                return Err(size_error(width, height));
            }
            let (texture, beside) = Texture::bytes_for(width.max(1), height.max(1));
            memory.reserve_result(texture).map_err(fail)?;
            let unpacking = unpacking_bytes(format, pixels, decoded);
            work.try_grow(unpacking.max(beside)).map_err(|e| fail(LoadErrorKind::OverBudget(e)))?;
            Ok(unpacking)
        };
        if is_webp {
            let wrong = |e: image_webp::DecodingError| undecodable(e.to_string());
            let (width, height, rgba) = webp(PolledBytes::new(bytes, &cancel), &mut reserve, wrong)?;
            return Ok((width, height, rgba, work));
        }
        let input = PolledBytes::new(bytes, &cancel);
        let mut decoder = open(input, bytes.len(), format).map_err(|e| undecodable(e.to_string()))?;
        let (width, height) = decoder.dimensions();
        let unpacking = reserve(width, height, decoder.total_bytes())?;
        let mut limits = Limits::no_limits();
        limits.max_alloc = Some(HEADER_BYTES + unpacking);
        decoder.set_limits(limits).map_err(|e| undecodable(e.to_string()))?;
        let picture = DynamicImage::from_decoder(decoder).map_err(|e| undecodable(e.to_string()))?;
        Ok((picture.width(), picture.height(), rgba8(picture), work))
    });
    // A decoder that was cancelled reports only that it could not read on.
    memory.check_cancelled().map_err(fail)?;
    let (width, height, rgba, _work) = decoded.unwrap_or_else(|reason| Err(undecodable(reason)))?;
    Texture::new(width, height, rgba).map_err(|e| match e {
        TextureError::BadSize { width: 0, .. } | TextureError::BadSize { height: 0, .. } => {
            undecodable("it has no texels".into())
        }
        TextureError::BadSize { width, height } => size_error(width, height),
        e @ TextureError::BadLength { .. } => undecodable(e.to_string()),
    })
}

/// Decodes a WebP file, of several pictures the first, to RGBA bytes. `reserve` is given its size and
/// the bytes of its pixels, and returns those that unpacking may take.
fn webp<E>(
    bytes: PolledBytes,
    reserve: &mut dyn FnMut(u32, u32, u64) -> Result<u64, E>,
    wrong: impl Fn(image_webp::DecodingError) -> E,
) -> Result<(u32, u32, Vec<u8>), E> {
    let mut decoder = image_webp::WebPDecoder::new(bytes).map_err(&wrong)?;
    let (width, height) = decoder.dimensions();
    let has_alpha = decoder.has_alpha();
    let length = u64::from(width) * u64::from(height) * if has_alpha { 4 } else { 3 };
    let unpacking = reserve(width, height, length)?;
    decoder.set_memory_limit((HEADER_BYTES + unpacking) as usize);
    let mut pixels = vec![0; length as usize];
    decoder.read_image(&mut pixels).map_err(&wrong)?;
    if !has_alpha {
        pixels = pixels.as_chunks::<3>().0.iter().flat_map(|[r, g, b]| [*r, *g, *b, 255]).collect();
    }
    Ok((width, height, pixels))
}

/// Reads the header of a picture file of `file_bytes`.
fn open<'a>(
    input: PolledBytes<'a>,
    file_bytes: usize,
    format: ImageFormat,
) -> ImageResult<Box<dyn ImageDecoder + 'a>> {
    if format == ImageFormat::Png {
        return Ok(Box::new(PngRows::new(input, file_bytes, HEADER_BYTES as usize)?));
    }
    let mut reader = ImageReader::with_format(input, format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(HEADER_BYTES);
    reader.limits(limits);
    Ok(Box::new(reader.into_decoder()?))
}

/// Returns an upper bound of the bytes for unpacking a picture, of which `decoded` are the pixels
/// in the file's format. PNG is unpacked row by row; a JPEG decoder may hold all coefficients at 16
/// bits each, a GIF decoder the indices and the previous frame. Pixels that are not 8-bit RGBA
/// exist twice during conversion.
fn unpacking_bytes(format: ImageFormat, pixels: u64, decoded: u64) -> u64 {
    match format {
        ImageFormat::Png => decoded + 4 * pixels,
        _ => 2 * decoded + 12 * pixels,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::error::Code;
    use image::{ExtendedColorType, ImageEncoder};
    use proptest::prelude::*;

    fn png(bytes: &[u8], width: u32, height: u32, color: ExtendedColorType) -> Vec<u8> {
        let mut out = Vec::new();
        image::codecs::png::PngEncoder::new(&mut out).write_image(bytes, width, height, color).unwrap();
        out
    }

    #[test]
    fn every_kind_of_pixel_becomes_rgba() {
        let rgba = [1, 2, 3, 4, 250, 251, 252, 253];
        assert_eq!(decode(&png(&rgba, 2, 1, ExtendedColorType::Rgba8)).unwrap().bytes(), rgba);
        let t = decode(&png(&[7, 200], 1, 2, ExtendedColorType::L8)).unwrap();
        assert_eq!((t.width(), t.height(), t.bytes()), (1, 2, &[7, 7, 7, 255, 200, 200, 200, 255][..]));
        assert!(!t.has_alpha());
        let wide: Vec<u8> = [0u16, 0x8080, 0xffff].iter().flat_map(|v| v.to_ne_bytes()).collect();
        assert_eq!(decode(&png(&wide, 1, 1, ExtendedColorType::Rgb16)).unwrap().bytes(), [0, 128, 255, 255]);
        assert_eq!(decode(b"P6 1 1 255\n\x01\x02\x03").unwrap().bytes(), [1, 2, 3, 255]);
        let mut jpeg = Vec::new();
        image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 100)
            .write_image(&[200; 8 * 8 * 3], 8, 8, ExtendedColorType::Rgb8)
            .unwrap();
        let t = decode(&jpeg).unwrap();
        assert!(
            (t.width(), t.height()) == (8, 8) && t.bytes().iter().all(|b| *b == 255 || b.abs_diff(200) < 3)
        );
        let mut tga = Vec::new();
        image::codecs::tga::TgaEncoder::new(&mut tga)
            .write_image(&rgba, 2, 1, ExtendedColorType::Rgba8)
            .unwrap();
        assert_eq!(decode_file(&tga, "a.TGA").unwrap().bytes(), rgba);
    }

    #[test]
    fn webp_is_read_without_alpha_and_with() {
        // Of 64 x 64 pixels, lossy.
        let file = include_bytes!("../../../../tests/data/formats/strangers/tex.webp");
        let lossy = decode_file(file, "a.bin").unwrap();
        assert_eq!((lossy.width(), lossy.height(), lossy.has_alpha()), (64, 64, false));
        for cut in [12, 20, 30, file.len() / 2] {
            assert_eq!(decode(&file[..cut]).unwrap_err().code(), Code::Format, "cut at {cut}");
        }
        let mut lossless = Vec::new();
        let rgba = [1, 2, 3, 4, 250, 251, 252, 255];
        let encoder = image_webp::WebPEncoder::new(&mut lossless);
        encoder.encode(&rgba, 2, 1, image_webp::ColorType::Rgba8).unwrap();
        assert_eq!(decode(&lossless).unwrap().bytes(), rgba);
        let error = decode(b"\xabKTX 20\xbb\r\n\x1a\n").unwrap_err().to_string();
        assert!(error.contains("`ktx extract`"), "{error}");
    }

    #[test]
    fn what_is_too_large_is_refused_before_it_is_unpacked() {
        let mut bomb = png(&[0; 4], 1, 1, ExtendedColorType::Rgba8);
        let header = |bomb: &mut Vec<u8>, width: u32, height: u32| {
            bomb[16..20].copy_from_slice(&width.to_be_bytes());
            bomb[20..24].copy_from_slice(&height.to_be_bytes());
            let crc = crc32fast::hash(&bomb[12..29]);
            bomb[29..33].copy_from_slice(&crc.to_be_bytes());
        };
        header(&mut bomb, 60_000, 60_000);
        let error = decode_file(&bomb, "bomb.png").unwrap_err();
        assert_eq!(error.code(), Code::TooBig);
        assert_eq!(error.to_string(), "bomb.png: texels a side: 60000 is over the limit of 16384");
        header(&mut bomb, 16_384, 16_384);
        assert_eq!(
            decode(&bomb).unwrap_err().to_string(),
            "texture: texels: 268435456 is over the limit of 67108864"
        );
        assert_eq!(decode(b"P6 100000 100000 255\n").unwrap_err().code(), Code::TooBig);
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        for bytes in
            [&b""[..], b"x", b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff", b"GIF89a", b"BM", b"P6", b"P6 0 1 255\n"]
        {
            let error = decode(bytes).unwrap_err();
            assert_eq!(error.code(), Code::Format, "{bytes:?}: {error}");
        }
        let whole = png(&[9; 64], 4, 4, ExtendedColorType::Rgba8);
        for cut in 0..whole.len() - 12 {
            assert!(decode(&whole[..cut]).is_err(), "cut at {cut}");
        }
    }

    proptest! {
        #[test]
        fn no_bytes_make_it_panic(
            magic in prop::sample::select(vec![
                &b"\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR"[..], b"\xff\xd8\xff\xe0", b"GIF89a", b"BM", b"P5 ", b"P6 9 9 255\n", b"",
            ]),
            rest in prop::collection::vec(any::<u8>(), 0..200),
        ) {
            let _ = decode_file(&[magic, &rest].concat(), "a.tga");
        }

        #[test]
        fn a_picture_with_a_wrong_byte_loads_or_is_refused(at in 0usize..80, byte in any::<u8>()) {
            let mut file = png(&[9; 64], 4, 4, ExtendedColorType::Rgba8);
            let at = at % file.len();
            file[at] = byte;
            let _ = decode(&file);
        }
    }
}

//! Pictures as PNG, and in the text of a page.

/// Encodes RGBA bytes as a PNG in base 64.
pub(crate) fn png_base64(width: u32, rgba: &[u8]) -> String {
    base64(&png_bytes(width, rgba))
}

/// Encodes RGBA bytes as a PNG.
pub(super) fn png_bytes(width: u32, rgba: &[u8]) -> Vec<u8> {
    let height = rgba.len() as u32 / 4 / width.max(1);
    let mut png = std::io::Cursor::new(Vec::new());
    image::write_buffer_with_format(
        &mut png,
        rgba,
        width,
        height,
        image::ExtendedColorType::Rgba8,
        image::ImageFormat::Png,
    )
    .expect("whole rows of RGBA can be written to memory as PNG");
    png.into_inner()
}

/// Encodes bytes in padded base 64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let word = three.iter().enumerate().fold(0u32, |w, (i, b)| w | (*b as u32) << (16 - 8 * i));
        for digit in 0..4 {
            let is_there = digit <= three.len();
            let at = (word >> (18 - 6 * digit)) as usize & 63;
            out.push(if is_there { DIGITS[at] as char } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::base64;

    #[test]
    fn base64_of_the_standards_examples() {
        let cases = [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in cases {
            assert_eq!(base64(plain.as_bytes()), coded);
        }
    }
}

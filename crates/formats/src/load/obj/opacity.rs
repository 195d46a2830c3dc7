//! `map_d`: a picture of the opacity, put into the alpha of a material's texture.
//!
//! In: the texture of the colour, which may lack, and the picture. Out: a texture of the colour's
//! size (of the picture's without one, in white), whose alpha is the product of its own and of the
//! picture at the same place: its alpha, or its luminance if it is opaque all over.
//!
//! Source: the MTL format 4.2 (`map_d`; a scalar texture is the luminance by default).

use crate::load::{LoadErrorKind, LoadMemory};
use fbptr_core::scene::Texture;

/// Returns the texture `color` with the opacity of another picture.
///
/// # Errors
/// If `memory` has no room or is cancelled.
pub(super) fn masked(
    color: Option<Texture>,
    opacity: &Texture,
    memory: &mut LoadMemory,
) -> Result<Texture, LoadErrorKind> {
    let size = color.as_ref().unwrap_or(opacity);
    let (width, height) = (size.width(), size.height());
    let (bytes, beside) = Texture::bytes_for(width, height);
    memory.reserve_result(bytes)?;
    let _work = memory.work(beside)?;
    let has_alpha = opacity.has_alpha();
    let part = |[r, g, b, a]: [u8; 4]| match has_alpha {
        true => u32::from(a),
        // Rec. 709 luma in whole numbers; white is 255.
        false => (54 * u32::from(r) + 183 * u32::from(g) + 19 * u32::from(b)) >> 8,
    };
    let parts = opacity.bytes().as_chunks::<4>().0;
    let mut out = Vec::with_capacity(width as usize * height as usize * 4);
    for y in 0..height {
        // Nearest texel: the middle of each.
        let nearest = |at: u32, of: u32, side: u32| {
            ((2 * u64::from(at) + 1) * u64::from(side) / (2 * u64::from(of))) as usize
        };
        let row = nearest(y, height, opacity.height()) * opacity.width() as usize;
        for x in 0..width {
            let i = (y as usize * width as usize + x as usize) * 4;
            let [r, g, b, a] = match &color {
                Some(color) => [0, 1, 2, 3].map(|c| color.bytes()[i + c]),
                None => [255; 4],
            };
            let alpha = u32::from(a) * part(parts[row + nearest(x, width, opacity.width())]);
            out.extend([r, g, b, ((alpha + 127) / 255) as u8]);
        }
    }
    Texture::new(width, height, out)
        .map_err(|e| LoadErrorKind::Undecodable { format: "picture", reason: e.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opacity_is_alpha_or_luminance_at_the_same_place() {
        let memory = &mut LoadMemory::unlimited();
        let color = Texture::new(2, 1, vec![1, 2, 3, 255, 4, 5, 6, 128]).unwrap();
        let grey = Texture::new(1, 1, vec![255, 255, 255, 255]).unwrap();
        assert_eq!(masked(Some(color.clone()), &grey, memory).unwrap().bytes(), color.bytes());
        let halves =
            Texture::new(4, 1, [[0, 0, 0, 255]; 2].into_iter().chain([[255; 4]; 2]).flatten().collect());
        let found = masked(Some(color), &halves.unwrap(), memory).unwrap();
        assert_eq!(found.bytes(), [1, 2, 3, 0, 4, 5, 6, 128]);
        let alpha = Texture::new(1, 1, vec![0, 0, 0, 77]).unwrap();
        assert_eq!(masked(None, &alpha, memory).unwrap().bytes(), [255, 255, 255, 77]);
    }
}

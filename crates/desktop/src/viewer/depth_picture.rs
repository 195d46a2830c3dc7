//! Depth as a grey picture: near is bright, far is dark, and nothing drawn is black.

use fbptr_core::memory::{DepthMemory, Rgba, VideoMemory};

/// Returns the grey of a value between the least and the largest: 255 for the least, 48 for the
/// largest.
fn grey(value: f64, [least, largest]: [f64; 2]) -> Rgba {
    let part = if largest > least { (value - least) / (largest - least) } else { 0.0 };
    let level = (255.0 - 207.0 * part.clamp(0.0, 1.0) + 0.5).floor() as u8;
    [level, level, level, 255]
}

/// Paints one value for each pixel, row after row; `None` is black. Returns the least and the
/// largest value, if any.
pub(super) fn paint(memory: &mut VideoMemory, values: &[Option<f64>]) -> Option<[f64; 2]> {
    let all = || values.iter().flatten().copied();
    let (least, largest) = all().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let pixels = memory.bytes_mut().as_chunks_mut::<4>().0;
    for (pixel, value) in pixels.iter_mut().zip(values) {
        *pixel = value.map_or(VideoMemory::CLEAR, |v| grey(v, [least, largest]));
    }
    (least <= largest).then_some([least, largest])
}

/// Returns the depths of a frame; `None` where nothing was drawn.
pub(super) fn depths(depth: Option<&DepthMemory>, width: u32, height: u32) -> Vec<Option<f64>> {
    let at = |i: u32| depth.and_then(|d| d.z((i % width) as i32, (i / width) as i32)).filter(|&z| z < 1.0);
    (0..width * height).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_is_bright_far_is_dark_and_nothing_black() {
        let mut memory = VideoMemory::new(4, 1).unwrap();
        let range = paint(&mut memory, &[Some(0.25), None, Some(0.75), Some(0.5)]);
        assert_eq!(range, Some([0.25, 0.75]));
        let reds: Vec<u8> = memory.bytes().iter().step_by(4).copied().collect();
        assert_eq!(reds, [255, 0, 48, 152]);
        assert_eq!(paint(&mut memory, &[None; 4]), None);
        assert_eq!(paint(&mut memory, &[Some(0.5); 4]), Some([0.5, 0.5]));
    }
}

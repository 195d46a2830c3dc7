//! Error metrics between a picture and its reference.
//!
//! In: two pictures of equal size, as RGBA bytes or as unclamped real colours, and depths. Out:
//! plain numbers. Alpha is ignored. All sums are in a fixed order, so the results are identical to
//! the digit on every machine.
//!
//! Source of SSIM: Z. Wang, A. C. Bovik, H. R. Sheikh, E. P. Simoncelli, "Image quality assessment:
//! from error visibility to structural similarity", 2004: a Gaussian window of 11 x 11 with sigma
//! 1.5 over the luma, K1 = 0.01, K2 = 0.03.

use super::picture::ulp_f32;
use fbptr_core::memory::DepthFormat;

/// Colour differences over all pixels and the channels R, G, B.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ColorError {
    /// Largest absolute difference.
    pub max: f64,
    /// Mean absolute difference.
    pub mae: f64,
    /// Root of the mean square difference.
    pub rmse: f64,
}

/// Errors between two pictures of bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureError {
    /// Differences in steps of 1/255.
    pub steps: ColorError,
    /// PSNR, 10 log10(255^2 / mean square), in decibels; infinite for equal pictures.
    pub psnr_db: f64,
    /// Structural similarity of the luma, 1 for equal pictures.
    pub ssim: f64,
    /// Number of pixels with a channel difference of more than one step.
    pub pixels_off: usize,
}

/// Depth differences.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct DepthError {
    /// Largest difference in z.
    pub max_z: f64,
    /// Largest difference in ulp of f32 at the true depth (of 1 - z for the reversed format).
    pub max_ulp: f64,
    /// Largest difference in steps of an integer format; 0 for the others.
    pub max_steps: f64,
}

/// Returns maximum, mean and RMSE of the differences of pairs.
fn color_error(pairs: impl Iterator<Item = (f64, f64)>) -> ColorError {
    let (mut count, mut max, mut sum, mut squares) = (0usize, 0f64, 0f64, 0f64);
    for (a, b) in pairs {
        let d = (a - b).abs();
        count += 1;
        max = max.max(d);
        sum += d;
        squares += d * d;
    }
    let n = count.max(1) as f64;
    ColorError { max, mae: sum / n, rmse: (squares / n).sqrt() }
}

/// Iterates over the R, G and B of RGBA bytes.
fn channels(rgba: &[u8]) -> impl Iterator<Item = f64> {
    rgba.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]]).map(f64::from)
}

/// Returns all metrics of two pictures of RGBA bytes, `width` pixels wide.
///
/// # Panics
/// If the pictures differ in size, or are not whole rows.
pub fn compare_bytes(width: usize, found: &[u8], truth: &[u8]) -> PictureError {
    assert_eq!(found.len(), truth.len(), "pictures of one size");
    assert!(width > 0 && found.len().is_multiple_of(width * 4), "whole rows of {width} pixels");
    let steps = color_error(channels(found).zip(channels(truth)));
    let off = |(a, b): &(&[u8], &[u8])| (0..3).any(|c| a[c].abs_diff(b[c]) > 1);
    PictureError {
        steps,
        psnr_db: psnr_db(steps.rmse),
        ssim: ssim(width, found, truth),
        pixels_off: found.chunks_exact(4).zip(truth.chunks_exact(4)).filter(off).count(),
    }
}

/// Returns 10 log10(255^2 / rmse^2), from an RMSE in steps of 1/255.
pub fn psnr_db(rmse_steps: f64) -> f64 {
    if rmse_steps == 0.0 { f64::INFINITY } else { 20.0 * libm::log10(255.0 / rmse_steps) }
}

/// Returns maximum, mean and RMSE of the differences of unclamped real colours, 1 being full.
///
/// # Panics
/// If the pictures differ in size.
pub fn compare_real(found: &[[f64; 3]], truth: &[[f64; 3]]) -> ColorError {
    assert_eq!(found.len(), truth.len(), "pictures of one size");
    color_error(found.iter().flatten().copied().zip(truth.iter().flatten().copied()))
}

/// Returns the `part` (0..1) quantile of the largest channel difference of each pixel, in steps of
/// 1/255: the smallest value that at least this fraction of the pixels does not exceed.
///
/// # Panics
/// If the pictures differ in size.
pub fn pixel_error_quantile(found: &[u8], truth: &[u8], part: f64) -> u8 {
    assert_eq!(found.len(), truth.len(), "pictures of one size");
    let mut counts = [0usize; 256];
    for (a, b) in found.chunks_exact(4).zip(truth.chunks_exact(4)) {
        let worst = (0..3).map(|c| a[c].abs_diff(b[c])).max().unwrap_or(0);
        counts[worst as usize] += 1;
    }
    let total: usize = counts.iter().sum();
    let needed = (part * total as f64).ceil() as usize;
    let mut seen = 0;
    for (value, count) in counts.iter().enumerate() {
        seen += count;
        if seen >= needed {
            return value as u8;
        }
    }
    255
}

/// Returns the number of pixels that are set in only one of two masks.
///
/// # Panics
/// If the masks differ in size.
pub fn coverage_off(found: &[bool], truth: &[bool]) -> usize {
    assert_eq!(found.len(), truth.len(), "masks of one size");
    found.iter().zip(truth).filter(|(a, b)| a != b).count()
}

/// Returns the largest differences of stored depths, given as pairs (stored word, exact z).
pub fn compare_depths(format: DepthFormat, pairs: impl IntoIterator<Item = (StoredWord, f64)>) -> DepthError {
    let mut worst = DepthError::default();
    for (stored, z) in pairs {
        let off = depth_off(format, stored, z);
        worst.max_z = worst.max_z.max(off.max_z);
        worst.max_ulp = worst.max_ulp.max(off.max_ulp);
        worst.max_steps = worst.max_steps.max(off.max_steps);
    }
    worst
}

/// Stored depth as a word of the depth memory.
pub type StoredWord = u32;

/// Returns the difference of one stored depth from the exact z.
pub fn depth_off(format: DepthFormat, stored: StoredWord, z: f64) -> DepthError {
    let steps = match format {
        DepthFormat::U16 => 65_535.0,
        DepthFormat::U24 => 16_777_215.0,
        DepthFormat::U32 => 4_294_967_295.0,
        DepthFormat::F32 => {
            let max_z = (f32::from_bits(stored) as f64 - z).abs();
            return DepthError { max_z, max_ulp: max_z / ulp_f32(z), max_steps: 0.0 };
        }
        DepthFormat::Reversed => {
            let (complement, exact) = (f32::from_bits(!stored) as f64, 1.0 - z);
            let max_z = (complement - exact).abs();
            return DepthError { max_z, max_ulp: max_z / ulp_f32(exact), max_steps: 0.0 };
        }
    };
    let max_steps = (stored as f64 - z * steps).abs();
    DepthError { max_z: max_steps / steps, max_ulp: max_steps / steps / ulp_f32(z), max_steps }
}

/// Counts the neighbours in `sorted` (exact depths, near to far) that differ and whose stored words
/// are equal or in the wrong order. Words of every format increase with depth (the reversed one is
/// stored complemented).
pub fn misordered_pairs(sorted: &[(StoredWord, f64)]) -> usize {
    sorted.windows(2).filter(|w| w[0].1 < w[1].1 && w[0].0 >= w[1].0).count()
}

/// Returns the largest and the mean distance of lit pixels from the segment p0 p1, in pixels. Pixel
/// centres are at integers, as for lines.
pub fn line_distance(p0: [f64; 2], p1: [f64; 2], lit: &[[i32; 2]]) -> (f64, f64) {
    let d = [p1[0] - p0[0], p1[1] - p0[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let distance = |p: &[i32; 2]| {
        let q = [p[0] as f64 - p0[0], p[1] as f64 - p0[1]];
        let t = if length2 > 0.0 { ((q[0] * d[0] + q[1] * d[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
        let off = [q[0] - t * d[0], q[1] - t * d[1]];
        (off[0] * off[0] + off[1] * off[1]).sqrt()
    };
    let (max, sum) = lit.iter().map(distance).fold((0.0, 0.0), |(m, s): (f64, f64), d| (m.max(d), s + d));
    (max, sum / lit.len().max(1) as f64)
}

/// Returns the luma of Rec. 601: 0.299 R + 0.587 G + 0.114 B.
fn luma(rgba: &[u8]) -> Vec<f64> {
    rgba.chunks_exact(4).map(|p| 0.299 * p[0] as f64 + 0.587 * p[1] as f64 + 0.114 * p[2] as f64).collect()
}

/// Half width of SSIM's window in pixels.
const REACH: isize = 5;

/// Returns the mean structural similarity of the lumas over the pixels whose window fits in the
/// picture. In a picture smaller than the window it is the mean over all pixels, with the window
/// clipped at the border and its weights scaled to sum 1.
pub fn ssim(width: usize, found: &[u8], truth: &[u8]) -> f64 {
    let (a, b) = (luma(found), luma(truth));
    let height = a.len() / width.max(1);
    if a.is_empty() {
        return 1.0;
    }
    let weights: Vec<f64> =
        (-REACH..=REACH).map(|i| libm::exp(-((i * i) as f64) / (2.0 * 1.5 * 1.5))).collect();
    // The window is separable: one blur along rows, one along columns.
    let blur = |v: &[f64]| -> Vec<f64> {
        let across = blur_lines(v, width, height, 1, width, &weights);
        blur_lines(&across, height, width, width, 1, &weights)
    };
    let product = |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x * y).collect() };
    let (mean_a, mean_b) = (blur(&a), blur(&b));
    let (aa, bb, ab) = (blur(&product(&a, &a)), blur(&product(&b, &b)), blur(&product(&a, &b)));
    let (c1, c2) = ((0.01 * 255.0) * (0.01 * 255.0), (0.03 * 255.0) * (0.03 * 255.0));
    let at = |i: usize| {
        let (m, n) = (mean_a[i], mean_b[i]);
        let (var_a, var_b, cov) = (aa[i] - m * m, bb[i] - n * n, ab[i] - m * n);
        ((2.0 * m * n + c1) * (2.0 * cov + c2)) / ((m * m + n * n + c1) * (var_a + var_b + c2))
    };
    let reach = REACH as usize;
    let margin = if width > 2 * reach && height > 2 * reach { reach } else { 0 };
    let mut total = 0.0;
    for y in margin..height - margin {
        total += (margin..width - margin).map(|x| at(width * y + x)).sum::<f64>();
    }
    total / ((width - 2 * margin) * (height - 2 * margin)) as f64
}

/// Blurs `lines` lines of `length` values: value k of line l is at l * line_stride + k * stride.
fn blur_lines(
    v: &[f64],
    length: usize,
    lines: usize,
    stride: usize,
    line_stride: usize,
    weights: &[f64],
) -> Vec<f64> {
    let mut out = vec![0.0; v.len()];
    for line in 0..lines {
        for k in 0..length {
            let (mut sum, mut weight) = (0.0, 0.0);
            for (w, i) in weights.iter().zip(-REACH..) {
                if let Some(at) = k.checked_add_signed(i).filter(|&at| at < length) {
                    sum += w * v[line * line_stride + at * stride];
                    weight += w;
                }
            }
            out[line * line_stride + k * stride] = sum / weight;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gray(values: &[u8]) -> Vec<u8> {
        values.iter().flat_map(|&v| [v, v, v, 255]).collect()
    }

    #[test]
    fn colour_differences_by_hand() {
        let found = [10, 20, 30, 255, 0, 0, 0, 255];
        let truth = [10, 22, 27, 0, 0, 0, 1, 0];
        let e = compare_bytes(2, &found, &truth);
        // Differences 0 2 3 0 0 1: sum 6, squares 14.
        assert_eq!((e.steps.max, e.steps.mae, e.pixels_off), (3.0, 1.0, 1));
        assert!((e.steps.rmse - (14.0f64 / 6.0).sqrt()).abs() < 1e-15);
        assert!((e.psnr_db - 10.0 * (65025.0f64 * 6.0 / 14.0).log10()).abs() < 1e-9);
        let same = compare_bytes(2, &truth, &truth);
        assert_eq!((same.psnr_db, same.ssim), (f64::INFINITY, 1.0));
        let real = compare_real(&[[1.5, 0.0, 0.0]], &[[1.0, 0.0, 0.25]]);
        assert_eq!((real.max, real.mae), (0.5, 0.25));
    }

    #[test]
    fn quantiles_count_pixels() {
        let (found, truth) = (gray(&[0, 1, 2, 9]), gray(&[0, 0, 0, 0]));
        assert_eq!(
            [0.25, 0.5, 0.75, 0.76, 1.0].map(|q| pixel_error_quantile(&found, &truth, q)),
            [0, 1, 2, 9, 9]
        );
        assert_eq!(coverage_off(&[true, false, true], &[true, true, false]), 2);
    }

    #[test]
    fn depths_by_hand() {
        let z = 0.75;
        let off = depth_off(DepthFormat::F32, (0.75f32 + f32::EPSILON).to_bits(), z);
        // The ulp below 1 is 2^-24.
        assert_eq!((off.max_ulp, off.max_z), (2.0, 2f64.powi(-23)));
        assert_eq!(depth_off(DepthFormat::U16, 49_151, z).max_steps, 0.25);
        let reversed = depth_off(DepthFormat::Reversed, !0.25f32.to_bits(), z);
        assert_eq!(reversed.max_ulp, 0.0);
        let words = [(3, 0.1), (3, 0.2), (5, 0.3), (4, 0.4), (4, 0.4)];
        assert_eq!(misordered_pairs(&words), 2);
        assert_eq!(compare_depths(DepthFormat::U16, [(49_151, z), (49_152, z)]).max_steps, 0.75);
    }

    #[test]
    fn lines_by_hand() {
        let (max, mean) = line_distance([0.0, 0.0], [10.0, 0.0], &[[0, 0], [5, 1], [13, 4]]);
        assert_eq!((max, mean), (5.0, 2.0));
        assert_eq!(line_distance([1.0, 1.0], [1.0, 1.0], &[[4, 5]]).0, 5.0);
    }

    /// Constant pictures: only the first factor remains, (2mn + C1)/(m^2 + n^2 + C1).
    #[test]
    fn ssim_of_flat_pictures_by_hand() {
        let (a, b) = (gray(&[100; 144]), gray(&[120; 144]));
        let c1 = 2.55f64 * 2.55;
        let expected = (2.0 * 100.0 * 120.0 + c1) / (100.0 * 100.0 + 120.0 * 120.0 + c1);
        assert!((ssim(12, &a, &b) - expected).abs() < 1e-9);
        // A pattern negated about its mean has a covariance of minus the variance.
        let pattern: Vec<u8> = (0..400).map(|i| if (i + i / 20) % 2 == 0 { 110 } else { 90 }).collect();
        let negative: Vec<u8> = pattern.iter().map(|v| 200 - v).collect();
        assert!(ssim(20, &gray(&pattern), &gray(&negative)) < -0.5);
    }

    /// Pictures of the checks against other programs: a pattern, and the pattern plus one of -5..5.
    fn patterns() -> (Vec<u8>, Vec<u8>) {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for y in 0..30i32 {
            for x in 0..40i32 {
                let noise = (x * 31 + y * 17 + (x * y) % 7) % 11 - 5;
                for v in [(x * 6 + y) % 256, (y * 8) % 256, (x * y) % 256] {
                    a.push(v as u8);
                    b.push((v + noise).clamp(0, 255) as u8);
                }
                a.push(255);
                b.push(255);
            }
        }
        (a, b)
    }

    /// Computed once by scikit-image 0.26.0: structural_similarity(gaussian_weights=True,
    /// sigma=1.5, use_sample_covariance=False, data_range=255) of the lumas,
    /// peak_signal_noise_ratio, mean_squared_error.
    #[test]
    fn an_outside_library_finds_the_same() {
        let (a, b) = patterns();
        let e = compare_bytes(40, &a, &b);
        assert!((e.ssim - 0.966_029_662_022_183_4).abs() < 1e-12, "{}", e.ssim);
        assert!((e.psnr_db - 38.223_099_917_478_75).abs() < 1e-10, "{}", e.psnr_db);
        assert!((e.steps.rmse * e.steps.rmse - 9.789_722_222_222_222).abs() < 1e-12);
        assert!((e.steps.mae - 2.676_388_888_888_889).abs() < 1e-12);
        assert_eq!(e.steps.max, 5.0);
    }

    #[test]
    fn an_outside_crate_finds_the_same_rmse() {
        let (a, b) = patterns();
        let green = |v: &[u8]| {
            let plane = v.chunks(4).map(|p| p[1]).collect();
            image::GrayImage::from_raw(40, 30, plane).unwrap()
        };
        let (a, b) = (green(&a), green(&b));
        let theirs =
            image_compare::gray_similarity_structure(&image_compare::Algorithm::RootMeanSquared, &a, &b)
                .unwrap();
        let rgba = |g: &image::GrayImage| gray(g.as_raw());
        let ours = compare_bytes(40, &rgba(&a), &rgba(&b)).steps.rmse;
        // The other program's score is 1 - RMSE/255, summed in f32.
        assert!((255.0 * (1.0 - theirs.score) - ours).abs() < 1e-3, "{} {ours}", theirs.score);
    }
}

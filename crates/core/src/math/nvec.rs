//! Vectors of R^N, and determinants with an exact sign.
//!
//! In: coordinates as `[f64; N]`, N at most [`MAX_DIM`]. Out: dot products, the hyperplane through
//! N-1 vectors (the cross product of R^N), and [`signed_det`], whose sign is that of the exact
//! determinant of the given numbers. Sums run from axis 0 upwards, without FMA: the same bits on
//! every machine.
//!
//! Verified by the tests below, which compare with the determinant in big integers.
//!
//! Source of the expansions: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast
//! Robust Geometric Predicates", 1997, sections 2.2 to 2.5.

/// Largest dimension that these functions accept.
pub const MAX_DIM: usize = 8;

/// Half an ulp of 1: the relative error of one rounded operation.
pub const ROUNDING: f64 = f64::EPSILON / 2.0;

/// Returns the scalar product.
#[inline(always)]
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    let mut sum = a[0] * b[0];
    for i in 1..N {
        sum += a[i] * b[i];
    }
    sum
}

/// Returns a - b.
#[inline(always)]
pub fn sub<const N: usize>(a: &[f64; N], b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Returns a + s b.
#[inline(always)]
pub fn add_scaled<const N: usize>(a: &[f64; N], s: f64, b: &[f64; N]) -> [f64; N] {
    std::array::from_fn(|i| a[i] + s * b[i])
}

/// Returns `x` scaled to length 1; a zero vector gives NaN.
#[inline(always)]
pub fn unit<const N: usize>(x: [f64; N]) -> [f64; N] {
    let norm = dot(&x, &x).sqrt();
    x.map(|c| c / norm)
}

/// Returns the largest absolute coordinate.
#[inline(always)]
pub fn max_abs<const N: usize>(a: &[f64; N]) -> f64 {
    a.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

/// Returns the coefficients of the functional x -> det(x, vectors...) on the first `len`
/// coordinates; `vectors` are `len` - 1.
///
/// The result is perpendicular to all of them: the normal of the hyperplane through them and 0.
/// Coefficients from `len` on are 0. Equal vectors in equal order give equal bits. Written out up
/// to four coordinates, else Laplace's expansion over subsets of columns.
///
/// # Panics
/// If there are not `len` - 1 `vectors`, or `len` is over N or [`MAX_DIM`].
#[inline]
pub fn wedge<const N: usize>(vectors: &[[f64; N]], len: usize) -> [f64; N] {
    assert!(len >= 1 && len <= N && len <= MAX_DIM && vectors.len() + 1 == len, "len - 1 vectors");
    let mut out = [0.0; N];
    match vectors {
        [] => out[0] = 1.0,
        [a] => (out[0], out[1]) = (a[1], -a[0]),
        [a, b] => {
            let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            (out[0], out[1], out[2]) = (minor(1, 2), minor(2, 0), minor(0, 1));
        }
        [a, b, c] => {
            let minor = |i: usize, j: usize| a[i] * b[j] - a[j] * b[i];
            let (m01, m02, m03, m12, m13, m23) =
                (minor(0, 1), minor(0, 2), minor(0, 3), minor(1, 2), minor(1, 3), minor(2, 3));
            out[0] = m12 * c[3] - m13 * c[2] + m23 * c[1];
            out[1] = -(m02 * c[3] - m03 * c[2] + m23 * c[0]);
            out[2] = m01 * c[3] - m03 * c[1] + m13 * c[0];
            out[3] = -(m01 * c[2] - m02 * c[1] + m12 * c[0]);
        }
        _ => laplace(vectors, len, &mut out),
    }
    out
}

/// Computes [`wedge`] for any number of vectors.
#[inline(never)]
fn laplace<const N: usize>(vectors: &[[f64; N]], len: usize, out: &mut [f64; N]) {
    // minors[set] = determinant of the first |set| rows over the columns in `set`.
    let mut minors = [0.0; 1 << MAX_DIM];
    minors[0] = 1.0;
    let full = (1usize << len) - 1;
    for set in 1..full {
        let row = &vectors[set.count_ones() as usize - 1];
        let (mut sum, mut position) = (0.0, 0u32);
        for (column, value) in row.iter().enumerate().take(len) {
            if set & (1 << column) == 0 {
                continue;
            }
            let term = value * minors[set & !(1 << column)];
            // Expanding along the last of k rows: the sign of column position p is (-1)^(k-1-p).
            sum = if (set.count_ones() - 1 - position) % 2 == 0 { sum + term } else { sum - term };
            position += 1;
        }
        minors[set] = sum;
    }
    for (a, coefficient) in out.iter_mut().enumerate().take(len) {
        let minor = minors[full & !(1 << a)];
        *coefficient = if a % 2 == 0 { minor } else { -minor };
    }
}

/// Returns the determinant of an n x n matrix (`n` rows of which the first `n` columns count) with
/// a reliable sign.
///
/// Up to n = 4 the value is rounded but its sign is exact: 0 only if the determinant of the given
/// numbers is 0. For larger n, a value whose sign rounding could have changed is returned as 0.
/// Numbers whose products leave the range of f64 are not supported.
pub fn signed_det<const N: usize>(rows: &[[f64; N]], n: usize) -> f64 {
    match n {
        0 => 1.0,
        1 => rows[0][0],
        2..=4 => {
            // One size for all N, so that the code below is compiled once.
            let mut few = [[0.0; 4]; 4];
            for (few, row) in few.iter_mut().zip(&rows[..n]) {
                few[..n].copy_from_slice(&row[..n]);
            }
            let mut sum = Expansion::<192>::default();
            add_permutations(&few, n, 0, 0, &[1.0], &mut sum);
            sum.value()
        }
        _ => {
            // Expand det(x, rows 1..) at x = row 0; the bound is the product of the rows' absolute
            // sums.
            let functional = wedge(&rows[1..n], n);
            let value = (0..n).fold(0.0, |sum, a| sum + functional[a] * rows[0][a]);
            let bound: f64 = rows[..n].iter().map(|r| r[..n].iter().map(|x| x.abs()).sum::<f64>()).product();
            if value.abs() <= bound * ROUNDING * (4 * n * n) as f64 { 0.0 } else { value }
        }
    }
}

/// Adds every product of Leibniz's formula that begins with `product` over the columns in `used`.
fn add_permutations(
    rows: &[[f64; 4]; 4],
    n: usize,
    row: usize,
    used: usize,
    product: &[f64],
    sum: &mut Expansion<192>,
) {
    if row == n {
        return product.iter().for_each(|&part| sum.add(part));
    }
    for column in (0..n).filter(|column| used & (1 << column) == 0) {
        let inversions = (column + 1..n).filter(|c| used & (1 << c) != 0).count();
        let factor = if inversions % 2 == 0 { rows[row][column] } else { -rows[row][column] };
        if factor == 0.0 {
            continue;
        }
        let mut longer = Expansion::<8>::default();
        for &part in product {
            let (high, low) = two_product(part, factor);
            longer.add(low);
            longer.add(high);
        }
        add_permutations(rows, n, row + 1, used | 1 << column, longer.parts(), sum);
    }
}

/// Exact sum of numbers that do not overlap, smallest first.
struct Expansion<const CAPACITY: usize> {
    parts: [f64; CAPACITY],
    len: usize,
}

impl<const CAPACITY: usize> Default for Expansion<CAPACITY> {
    fn default() -> Self {
        Expansion { parts: [0.0; CAPACITY], len: 0 }
    }
}

impl<const CAPACITY: usize> Expansion<CAPACITY> {
    /// Adds one number exactly (Shewchuk's grow-expansion, zeros dropped).
    fn add(&mut self, number: f64) {
        let (mut carry, mut kept) = (number, 0);
        for i in 0..self.len {
            let (sum, error) = two_sum(carry, self.parts[i]);
            carry = sum;
            if error != 0.0 {
                self.parts[kept] = error;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.parts[kept] = carry;
            kept += 1;
        }
        self.len = kept;
    }

    fn parts(&self) -> &[f64] {
        &self.parts[..self.len]
    }

    /// Returns the rounded sum; its sign is that of the largest part, which outweighs the others.
    fn value(&self) -> f64 {
        self.parts().iter().sum()
    }
}

/// Returns a + b as a rounded sum and its error.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_virtual = sum - a;
    (sum, (a - (sum - b_virtual)) + (b - b_virtual))
}

/// Returns a b as a rounded product and its error (Dekker, without FMA).
fn two_product(a: f64, b: f64) -> (f64, f64) {
    fn split(x: f64) -> (f64, f64) {
        let wide = x * 134_217_729.0; // 2^27 + 1
        let high = wide - (wide - x);
        (high, x - high)
    }
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    let error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// Returns the exact determinant of multiples of 2^-60, times 2^(60 n).
    fn exact(rows: &[[f64; 5]], n: usize) -> BigInt {
        fn expand(rows: &[Vec<BigInt>]) -> BigInt {
            if rows.is_empty() {
                return BigInt::from(1);
            }
            let mut sum = BigInt::from(0);
            for column in 0..rows.len() {
                let rest: Vec<Vec<BigInt>> = rows[1..]
                    .iter()
                    .map(|r| {
                        r.iter().enumerate().filter(|(c, _)| *c != column).map(|(_, x)| x.clone()).collect()
                    })
                    .collect();
                let term = &rows[0][column] * expand(&rest);
                sum = if column % 2 == 0 { sum + term } else { sum - term };
            }
            sum
        }
        let to_integer = |x: f64| BigInt::from((x * (1u64 << 60) as f64) as i128);
        expand(&rows[..n].iter().map(|r| r[..n].iter().map(|&x| to_integer(x)).collect()).collect::<Vec<_>>())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]
        #[test]
        fn the_sign_of_a_nearly_singular_determinant_is_exact(
            n in 1usize..=4,
            mut rows in prop::array::uniform5(prop::array::uniform5(-40i64..40)),
            nudge in (0usize..5, 0usize..5, -2i64..=2),
            weights in prop::array::uniform5(-3i64..=3),
        ) {
            // The last row is a combination of the others, except for an offset of 2^-48.
            #[allow(clippy::needless_range_loop)]
            for c in 0..n {
                rows[n - 1][c] = (0..n - 1).map(|r| weights[r] * rows[r][c]).sum();
            }
            let mut real = rows.map(|r| r.map(|x| x as f64 / 64.0));
            real[nudge.0 % n][nudge.1 % n] += nudge.2 as f64 / (1u64 << 48) as f64;
            let want = exact(&real, n);
            let got = signed_det(&real, n);
            prop_assert_eq!(got.partial_cmp(&0.0).unwrap(), want.cmp(&BigInt::from(0)));
        }

        #[test]
        fn the_wedge_is_the_determinant(rows in prop::array::uniform5(prop::array::uniform5(-9i64..9))) {
            let real = rows.map(|r| r.map(|x| x as f64));
            let functional = wedge(&real[1..], 5);
            let scale = BigInt::from(1u128 << 60).pow(5);
            prop_assert_eq!(BigInt::from(dot(&functional, &real[0]) as i128) * scale, exact(&real, 5));
            prop_assert!(real[1..].iter().all(|v| dot(&functional, v) == 0.0));
        }
    }

    proptest! {
        #[test]
        fn the_written_out_wedges_are_laplaces(rows in prop::array::uniform3(prop::array::uniform4(-9i64..9))) {
            let real = rows.map(|r| r.map(|x| x as f64));
            for len in 1..=4 {
                let mut want = [0.0; 4];
                laplace(&real[..len - 1], len, &mut want);
                prop_assert_eq!(wedge(&real[..len - 1], len), want);
            }
        }
    }

    #[test]
    fn the_wedge_in_three_dimensions_is_the_cross_product() {
        assert_eq!(wedge(&[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 3), [0.0, 0.0, 1.0]);
        assert_eq!(wedge(&[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], 3), [-3.0, 6.0, -3.0]);
        assert_eq!(wedge(&[[3.0, 5.0, 7.0]], 2), [5.0, -3.0, 0.0]);
    }

    #[test]
    fn large_determinants_that_cannot_be_told_from_zero_are_zero() {
        let mut rows: [[f64; 5]; 5] =
            std::array::from_fn(|r| std::array::from_fn(|c| ((r * 5 + c) as f64).sqrt()));
        rows[4] = std::array::from_fn(|c| rows[0][c] + rows[1][c] / 3.0);
        assert_eq!(signed_det(&rows, 5), 0.0);
        rows[4][4] += 1.0;
        assert!(signed_det(&rows, 5) != 0.0);
    }
}

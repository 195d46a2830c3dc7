//! Logarithm and power with the same bits on every machine: `+ - * /` in a fixed order, no FMA, no
//! table.
//!
//! [`log2`] is within 3 ulp of the exact real number, also next to 1 where it is small, so [`pow`]
//! of a cosine near 1 keeps its digits for exponents up to 1e6: its relative error is below
//! 4e-16 (1 + |y log2 x|).

/// 2 / ln 2.
const TWO_OVER_LN_2: f64 = 2.885_390_081_777_926_8;

/// Coefficients of atanh s = s (1 + s^2/3 + s^4/5 + ...), from the second term on.
const ATANH: [f64; 10] = [
    1.0 / 3.0,
    1.0 / 5.0,
    1.0 / 7.0,
    1.0 / 9.0,
    1.0 / 11.0,
    1.0 / 13.0,
    1.0 / 15.0,
    1.0 / 17.0,
    1.0 / 19.0,
    1.0 / 21.0,
];

/// Coefficients 1 / k! of the series of e^z.
const EXP: [f64; 15] = {
    let mut terms = [1.0; 15];
    let mut k = 1;
    let mut factorial = 1.0;
    while k < 15 {
        factorial *= k as f64;
        terms[k] = 1.0 / factorial;
        k += 1;
    }
    terms
};

/// Returns the logarithm of `x` to base 2: -inf for 0, NaN below 0 and for NaN, +inf for +inf.
///
/// x = 2^e m with m in [sqrt 1/2, sqrt 2); log2 m = (2 / ln 2) atanh(s), s = (m-1)/(m+1), by its
/// series to s^21.
pub fn log2(x: f64) -> f64 {
    if !(x > 0.0 && x < f64::INFINITY) {
        return if x == 0.0 {
            f64::NEG_INFINITY
        } else if x > 0.0 {
            x
        } else {
            f64::NAN
        };
    }
    // Subnormals are brought into the normal range first.
    let (x, bias) = if x < f64::MIN_POSITIVE { (x * 18_014_398_509_481_984.0, -54) } else { (x, 0) };
    let bits = x.to_bits();
    let mut e = (bits >> 52) as i64 - 1023 + bias;
    let mut m = f64::from_bits((bits & 0x000f_ffff_ffff_ffff) | 0x3ff0_0000_0000_0000);
    if m > std::f64::consts::SQRT_2 {
        m *= 0.5;
        e += 1;
    }
    let s = (m - 1.0) / (m + 1.0);
    let q = s * s;
    let series = ATANH.iter().rev().fold(0.0, |sum, c| (sum + c) * q);
    e as f64 + TWO_OVER_LN_2 * (s + s * series)
}

/// Returns 2 to the power `t`; 0 below the normal numbers, +inf above, NaN for NaN. Relative error
/// below 3e-16.
pub fn exp2(t: f64) -> f64 {
    if t.is_nan() || t >= 1024.0 {
        return if t.is_nan() { t } else { f64::INFINITY };
    }
    if t < -1022.0 {
        return 0.0;
    }
    let integer = (t + 0.5).floor();
    let z = (t - integer) * std::f64::consts::LN_2;
    // e^z by its series: |z| < 0.347, so 14 terms leave less than 1e-17.
    let series = EXP.iter().rev().fold(0.0, |sum, c| sum * z + c);
    // In two steps, because 2^1024 overflows even where the product does not.
    let half = (integer as i64) / 2;
    series * power_of_two(half) * power_of_two(integer as i64 - half)
}

fn power_of_two(e: i64) -> f64 {
    f64::from_bits(((e + 1023) as u64) << 52)
}

/// Returns `x` to the power `y` for x >= 0, y >= 0, with 0^0 = 1; negative `x` counts as 0, NaN
/// gives NaN.
pub fn pow(x: f64, y: f64) -> f64 {
    if y <= 0.0 || x == 1.0 {
        1.0
    } else if x <= 0.0 {
        0.0
    } else {
        exp2(y * log2(x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ends_of_the_range() {
        assert_eq!((pow(0.0, 0.0), pow(0.0, 3.0), pow(0.7, 0.0), pow(1.0, 1e6)), (1.0, 0.0, 1.0, 1.0));
        assert_eq!((log2(0.0), log2(1.0), log2(8.0), log2(0.25)), (f64::NEG_INFINITY, 0.0, 3.0, -2.0));
        assert!(log2(-1.0).is_nan() && log2(f64::NAN).is_nan() && pow(f64::NAN, 2.0).is_nan());
        assert_eq!((exp2(-2000.0), exp2(1024.0), exp2(10.0)), (0.0, f64::INFINITY, 1024.0));
        // Below the normal numbers it is 0, without subnormal results in between.
        assert_eq!(exp2(-1022.0), f64::MIN_POSITIVE);
        assert_eq!([(-1022.0f64).next_down(), -1030.0, -1e5, -1e300].map(exp2), [0.0; 4]);
        assert!((log2(5e-324) + 1074.0).abs() < 1e-12);
        assert!((exp2(1023.5) / libm::exp2(1023.5) - 1.0).abs() < 4e-16);
    }

    proptest! {
        #[test]
        fn log2_is_within_3_ulp(mantissa in 0.5f64..2.0, e in -300i32..300, near_one in 0u8..2) {
            let x = if near_one == 1 { 1.0 + (mantissa - 1.0) * 1e-9 } else { mantissa * libm::exp2(e as f64) };
            let (own, other) = (log2(x), libm::log2(x));
            prop_assert!((own - other).abs() <= 4.0 * f64::EPSILON * other.abs(), "{x}: {own} {other}");
        }

        #[test]
        fn pow_keeps_its_digits(x in 0.0f64..1.0, y in 0.0f64..200.0, close in 0.0f64..1.0, large in 0.0f64..1e6) {
            for (x, y) in [(x, y), (1.0 - close * 1e-6, large), (1.0 - close * 1e-4, large / 100.0)] {
                let (own, other) = (pow(x, y), libm::pow(x, y));
                let bound = 5e-16 * (1.0 + (y * libm::log2(x)).abs());
                prop_assert!((own - other).abs() <= bound * other + 1e-300, "{x}^{y}: {own} {other}");
            }
        }
    }
}

//! Approximations of fast or old hardware in lighting, emulated in software for identical results
//! on every machine.

/// Returns 1/sqrt(x) by halving the exponent in the bits, then steps of Newton's method, in f32.
/// Source: C. Lomont, "Fast inverse square root", 2003.
pub(super) fn by_bits(x: f32, newton_steps: u32) -> f32 {
    let mut y = f32::from_bits(0x5f37_5a86 - (x.to_bits() >> 1));
    for _ in 0..newton_steps {
        y *= 1.5 - 0.5 * x * y * y;
    }
    y
}

/// Returns 1/sqrt(x) to 12 bits, like the processors' estimate instructions, then steps of Newton's
/// method, in f32.
pub(super) fn of_12_bits(x: f32, newton_steps: u32) -> f32 {
    let exact = 1.0 / x.sqrt();
    let mut y = f32::from_bits((exact.to_bits() + (1 << 11)) & !((1 << 12) - 1));
    for _ in 0..newton_steps {
        y *= 1.5 - 0.5 * x * y * y;
    }
    y
}

/// Returns x^n for x in 0..1 by C. Schlick, "A fast alternative to Phong's specular model", 1994: x
/// / (n - n x + x).
pub(super) fn power_of_schlick(x: f32, n: f32) -> f32 {
    if x <= 0.0 { 0.0 } else { x / (n - n * x + x) }
}

/// Returns x^n by log2 and exp2 of low degree: the exponent, and a parabola for the mantissa.
pub(super) fn power_by_parabolas(x: f32, n: f32) -> f32 {
    if x <= 0.0 {
        return 0.0;
    }
    let bits = x.to_bits();
    let mantissa = f32::from_bits((bits & 0x007f_ffff) | 0x3f80_0000);
    let exponent = (bits >> 23) as f32 - 127.0;
    // log2 on 1..2, exact at both ends.
    let log = exponent + (-1.0 / 3.0 * mantissa + 2.0) * mantissa - 5.0 / 3.0;
    let t = n * log;
    if t < -126.0 {
        return 0.0;
    }
    let integer = t.floor();
    let part = t - integer;
    // 2^part on 0..1, exact at both ends.
    let base = 1.0 + part * (0.6565 + 0.3435 * part);
    base * f32::from_bits(((integer as i32 + 127) as u32) << 23)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_what_the_papers_say() {
        let worst = |f: &dyn Fn(f32) -> f32| {
            (1..4000).map(|i| i as f32 / 1000.0).fold(0f64, |m, x| {
                let exact = 1.0 / (x as f64).sqrt();
                m.max((f(x) as f64 / exact - 1.0).abs())
            })
        };
        assert!((0.03..0.035).contains(&worst(&|x| by_bits(x, 0))));
        assert!((0.001..0.002).contains(&worst(&|x| by_bits(x, 1))));
        assert!((1e-5..3e-4).contains(&worst(&|x| of_12_bits(x, 0))));
        assert!(worst(&|x| of_12_bits(x, 1)) < 2e-7);
        assert!((power_by_parabolas(0.9, 10.0) - 0.9f32.powi(10)).abs() < 0.02);
        assert_eq!((power_of_schlick(1.0, 50.0), power_of_schlick(0.0, 50.0)), (1.0, 0.0));
    }
}

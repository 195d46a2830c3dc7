//! Rational numbers of any size, with the operations that the reference of the eye needs.

use super::eye::Number;
use num_bigint::BigInt;
use num_integer::Integer;
use std::cmp::Ordering;

/// A number numerator / denominator, reduced, with denominator > 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rational(BigInt, BigInt);

impl Rational {
    /// Creates the quotient of two whole numbers.
    ///
    /// # Panics
    /// If the denominator is 0.
    fn new(numerator: BigInt, denominator: BigInt) -> Rational {
        let zero = BigInt::from(0);
        assert!(denominator != zero, "division by zero");
        let gcd = numerator.gcd(&denominator);
        let gcd = if denominator < zero { -gcd } else { gcd };
        Rational(numerator / &gcd, denominator / &gcd)
    }

    /// Converts an f64 exactly.
    ///
    /// # Panics
    /// If it is not finite.
    fn from_f64(x: f64) -> Rational {
        assert!(x.is_finite());
        let bits = x.abs().to_bits();
        let (exponent, fraction) = ((bits >> 52) as i32, bits & ((1 << 52) - 1));
        let (mantissa, exponent) =
            if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
        let signed = BigInt::from(mantissa) * if x < 0.0 { -1 } else { 1 };
        match exponent >= 0 {
            true => Rational::new(signed << exponent as u32, BigInt::from(1)),
            false => Rational::new(signed, BigInt::from(1) << (-exponent) as u32),
        }
    }

    /// Returns the nearest f64, within an ulp.
    fn nearest_f64(&self) -> f64 {
        let shift = 80 + self.1.bits() as i64 - self.0.bits() as i64;
        let quotient = if shift >= 0 {
            (&self.0 << shift as u64) / &self.1
        } else {
            &self.0 / (&self.1 << (-shift) as u64)
        };
        let value: i128 = quotient.try_into().expect("about 80 bits");
        value as f64 * 2f64.powi(-shift as i32)
    }
}

impl PartialOrd for Rational {
    fn partial_cmp(&self, other: &Rational) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Rational {
    fn cmp(&self, other: &Rational) -> Ordering {
        (&self.0 * &other.1).cmp(&(&other.0 * &self.1))
    }
}

impl Number for Rational {
    fn of(x: f64) -> Rational {
        Rational::from_f64(x)
    }

    fn to_f64(&self) -> f64 {
        self.nearest_f64()
    }

    fn sign(&self) -> i32 {
        match self.0.cmp(&BigInt::from(0)) {
            Ordering::Less => -1,
            Ordering::Equal => 0,
            Ordering::Greater => 1,
        }
    }

    fn plus(&self, o: &Rational) -> Rational {
        Rational::new(&self.0 * &o.1 + &o.0 * &self.1, &self.1 * &o.1)
    }

    fn minus(&self, o: &Rational) -> Rational {
        Rational::new(&self.0 * &o.1 - &o.0 * &self.1, &self.1 * &o.1)
    }

    fn times(&self, o: &Rational) -> Rational {
        Rational::new(&self.0 * &o.0, &self.1 * &o.1)
    }

    fn over(&self, o: &Rational) -> Rational {
        Rational::new(&self.0 * &o.1, &self.1 * &o.0)
    }

    fn negated(&self) -> Rational {
        Rational(-&self.0, self.1.clone())
    }

    /// By integers throughout (E. H. Bareiss, "Sylvester's identity and multistep integer-preserving
    /// Gaussian elimination", 1968).
    fn solve(rows: Vec<Vec<Rational>>) -> Option<Vec<Rational>> {
        let n = rows.len();
        let mut rows: Vec<Vec<BigInt>> = rows.into_iter().map(whole_multiple).collect();
        let mut last = BigInt::from(1);
        for k in 0..n {
            let pivot = (k..n).find(|&r| rows[r][k] != BigInt::from(0))?;
            rows.swap(k, pivot);
            let top = rows[k].clone();
            for (_, row) in rows.iter_mut().enumerate().filter(|(r, _)| *r != k) {
                let factor = row[k].clone();
                for (entry, above) in row.iter_mut().zip(&top) {
                    *entry = (&*entry * &top[k] - &factor * above) / &last;
                }
            }
            last = top[k].clone();
        }
        Some(rows.into_iter().map(|row| Rational::new(row[n].clone(), last.clone())).collect())
    }
}

/// Returns a multiple of the row in integers.
fn whole_multiple(row: Vec<Rational>) -> Vec<BigInt> {
    let common = row.iter().fold(BigInt::from(1), |m, x| m.lcm(&x.1));
    row.into_iter().map(|x| x.0 * (&common / &x.1)).collect()
}

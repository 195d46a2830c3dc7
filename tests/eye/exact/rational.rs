//! Rational numbers of any size, with the operations that the reference needs.

use num_bigint::BigInt;
use num_integer::Integer;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number numerator / denominator, reduced, with denominator > 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Q(BigInt, BigInt);

impl Q {
    pub fn new(numerator: BigInt, denominator: BigInt) -> Q {
        let zero = BigInt::from(0);
        assert!(denominator != zero, "division by zero");
        let gcd = numerator.gcd(&denominator);
        let gcd = if denominator < zero { -gcd } else { gcd };
        Q(numerator / &gcd, denominator / &gcd)
    }

    /// Converts an f64 exactly.
    pub fn from_f64(x: f64) -> Q {
        assert!(x.is_finite());
        let bits = x.abs().to_bits();
        let (exponent, fraction) = ((bits >> 52) as i32, bits & ((1 << 52) - 1));
        let (mantissa, exponent) =
            if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
        let signed = BigInt::from(mantissa) * if x < 0.0 { -1 } else { 1 };
        match exponent >= 0 {
            true => Q::new(signed << exponent as u32, BigInt::from(1)),
            false => Q::new(signed, BigInt::from(1) << (-exponent) as u32),
        }
    }

    /// Returns the nearest f64, within an ulp.
    pub fn to_f64(&self) -> f64 {
        let shift = 80 + self.1.bits() as i64 - self.0.bits() as i64;
        let quotient = if shift >= 0 {
            (&self.0 << shift as u64) / &self.1
        } else {
            &self.0 / (&self.1 << (-shift) as u64)
        };
        let value: i128 = quotient.try_into().expect("about 80 bits");
        value as f64 * 2f64.powi(-shift as i32)
    }

    pub fn zero() -> Q {
        Q::from_f64(0.0)
    }

    pub fn sign(&self) -> i32 {
        match self.0.cmp(&BigInt::from(0)) {
            Ordering::Less => -1,
            Ordering::Equal => 0,
            Ordering::Greater => 1,
        }
    }

    pub fn abs(&self) -> Q {
        if self.sign() < 0 { -self } else { self.clone() }
    }
}

impl PartialOrd for Q {
    fn partial_cmp(&self, other: &Q) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Q {
    fn cmp(&self, other: &Q) -> Ordering {
        (&self.0 * &other.1).cmp(&(&other.0 * &self.1))
    }
}

impl Add for &Q {
    type Output = Q;
    fn add(self, o: &Q) -> Q {
        Q::new(&self.0 * &o.1 + &o.0 * &self.1, &self.1 * &o.1)
    }
}

impl Sub for &Q {
    type Output = Q;
    fn sub(self, o: &Q) -> Q {
        Q::new(&self.0 * &o.1 - &o.0 * &self.1, &self.1 * &o.1)
    }
}

impl Mul for &Q {
    type Output = Q;
    fn mul(self, o: &Q) -> Q {
        Q::new(&self.0 * &o.0, &self.1 * &o.1)
    }
}

impl Div for &Q {
    type Output = Q;
    fn div(self, o: &Q) -> Q {
        Q::new(&self.0 * &o.1, &self.1 * &o.0)
    }
}

impl Neg for &Q {
    type Output = Q;
    fn neg(self) -> Q {
        Q(-&self.0, self.1.clone())
    }
}

pub fn dot(a: &[Q], b: &[Q]) -> Q {
    a.iter().zip(b).fold(Q::zero(), |sum, (x, y)| &sum + &(x * y))
}

/// Returns the solution of `rows` [a.. | b], or `None` if it is not unique, by integers throughout
/// (Bareiss, 1968).
pub fn solve(rows: Vec<Vec<Q>>) -> Option<Vec<Q>> {
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
    Some(rows.into_iter().map(|row| Q::new(row[n].clone(), last.clone())).collect())
}

/// Returns a multiple of the row in integers.
fn whole_multiple(row: Vec<Q>) -> Vec<BigInt> {
    let common = row.iter().fold(BigInt::from(1), |m, x| m.lcm(&x.1));
    row.into_iter().map(|x| x.0 * (&common / &x.1)).collect()
}

pub fn determinant(rows: &[Vec<Q>]) -> Q {
    if rows.is_empty() {
        return Q::from_f64(1.0);
    }
    (0..rows.len()).fold(Q::zero(), |sum, c| {
        let rest: Vec<Vec<Q>> = rows[1..]
            .iter()
            .map(|r| r.iter().enumerate().filter(|(k, _)| *k != c).map(|(_, x)| x.clone()).collect())
            .collect();
        let term = &rows[0][c] * &determinant(&rest);
        if c % 2 == 0 { &sum + &term } else { &sum - &term }
    })
}

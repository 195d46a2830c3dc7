//! The error that a picture may have: steps of colour, and a shift in pixels.

use std::fmt;
use std::str::FromStr;

/// The most that a picture may differ from the exact one: every pixel is right, to within `steps`,
/// for a point that the exact picture shows within `shift` pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MaxError {
    /// Steps of 1/255 of colour.
    pub steps: f64,
    /// Pixels; 0 allows none.
    pub shift: f64,
}

impl From<f64> for MaxError {
    /// Allows an error of colour alone.
    fn from(steps: f64) -> MaxError {
        MaxError { steps, shift: 0.0 }
    }
}

impl FromStr for MaxError {
    type Err = &'static str;

    /// Reads `E` or `E,S`.
    fn from_str(text: &str) -> Result<MaxError, Self::Err> {
        let (steps, shift) = text.split_once(',').unwrap_or((text, "0"));
        let number = |text: &str| text.parse().ok().filter(|n: &f64| n.is_finite() && *n >= 0.0);
        match (number(steps), number(shift)) {
            (Some(steps), Some(shift)) => Ok(MaxError { steps, shift }),
            _ => {
                Err("expected steps of colour E, or E,S with a shift in pixels: finite numbers of 0 or more")
            }
        }
    }
}

impl fmt::Display for MaxError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.shift > 0.0 {
            true => write!(f, "{},{}", self.steps, self.shift),
            false => write!(f, "{}", self.steps),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_or_two_are_read_and_written() {
        for text in ["4", "4,0.5", "0", "0.25,2"] {
            assert_eq!(text.parse::<MaxError>().unwrap().to_string(), text);
        }
        assert_eq!("4,0".parse(), Ok(MaxError::from(4.0)));
        for text in ["", "-1", "4,", "4,-1", "4,x", "nan", "inf,1", "4,0.5,1"] {
            assert!(text.parse::<MaxError>().is_err(), "{text}");
        }
    }
}

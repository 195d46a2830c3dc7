//! Checks of a scene's numbers, whose errors name the number's path.

use super::error::EyeError;

/// Validates that `point` has N finite coordinates.
pub(super) fn finite_point(place: &str, point: &[f64], n: usize) -> Result<(), EyeError> {
    same_length(place, point.len(), n)?;
    for (i, &x) in point.iter().enumerate() {
        in_range(format!("{place}[{i}]"), x, x.is_finite(), || "a finite number".into())?;
    }
    Ok(())
}

/// Returns a length error with the given path unless the lengths are equal.
pub(super) fn same_length(place: &str, found: usize, expected: usize) -> Result<(), EyeError> {
    if found == expected { Ok(()) } else { Err(length(place, expected.to_string(), found)) }
}

/// Creates a length error.
pub(super) fn length(place: &str, expected: String, found: usize) -> EyeError {
    EyeError::Length { path: place.into(), expected, found }
}

/// Returns a range error with the given path unless `holds`.
pub(super) fn in_range(
    place: impl Into<String>,
    found: f64,
    holds: bool,
    expected: impl FnOnce() -> String,
) -> Result<(), EyeError> {
    if holds { Ok(()) } else { Err(EyeError::Range { path: place.into(), expected: expected(), found }) }
}

//! `<unit>` statements: the units of a file's lengths and angles. Source: ISO/IEC 19775-1 clauses
//! 4.3.6 (standard units) and 7.2.5.5 (UNIT statement).
//!
//! The root file's unit of length is that of the world: a scene looks the same in yards and in
//! metres, so its lengths are not converted. The content of Inline and ExternProto files is
//! converted to it by a scale about their origin. Angles are converted as they are read, so that
//! all other code uses radians.

use super::value::Value;
use roxmltree::Node as Element;

/// Units of one file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Units {
    /// Length unit in metres.
    pub(super) length: f64,
    /// Angle unit in radians.
    pub(super) angle: f64,
}

impl Units {
    /// Metres and radians.
    pub(super) const STANDARD: Units = Units { length: 1.0, angle: 1.0 };

    /// Applies a `<unit>` element; an error is a message about it. Units of force and mass affect
    /// no picture.
    pub(super) fn read(&mut self, unit: Element) -> Result<(), String> {
        let factor = unit.attribute("conversionFactor").unwrap_or("");
        let number = factor.trim().parse::<f64>().ok().filter(|f| f.is_finite() && *f > 0.0);
        let place = match unit.attribute("category").unwrap_or("").trim() {
            "length" => &mut self.length,
            "angle" => &mut self.angle,
            "force" | "mass" => return Ok(()),
            other => {
                return Err(format!("<unit> category {other:?} is none of length, angle, force and mass"));
            }
        };
        *place = number
            .ok_or_else(|| format!("<unit> conversionFactor {factor:?} is no number above 0: 1 is taken"))?;
        Ok(())
    }
}

/// Returns which of a field's numbers are angles: every `step`-th from `first` on, as (first,
/// step). `None` for fields without any.
fn angles(node: &str, field: &str) -> Option<(usize, usize)> {
    match (node, field) {
        ("TextureTransform", "rotation") => Some((0, 1)),
        (_, "rotation" | "orientation" | "scaleOrientation") => Some((3, 4)),
        ("OrientationInterpolator", "keyValue") => Some((3, 4)),
        ("Viewpoint", "fieldOfView") => Some((0, 1)),
        ("Arc2D" | "ArcClose2D", "startAngle" | "endAngle") => Some((0, 1)),
        (_, "beamWidth" | "cutOffAngle" | "creaseAngle" | "skyAngle" | "groundAngle") => Some((0, 1)),
        _ => None,
    }
}

/// Converts the angles of a field's value from units of `angle` radians to radians.
pub(super) fn in_radians(value: Value, node: &str, field: &str, angle: f64) -> Value {
    match (angles(node, field), value) {
        (Some((first, step)), Value::Reals(reals)) if angle != 1.0 => {
            let turned = |(i, x): (usize, &f64)| if i % step == first { x * angle } else { *x };
            Value::Reals(reals.iter().enumerate().map(turned).collect())
        }
        (_, value) => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Units, String> {
        let document = roxmltree::Document::parse(text).unwrap();
        let mut units = Units::STANDARD;
        units.read(document.root_element()).map(|()| units)
    }

    #[test]
    fn a_statement_gives_its_factor_or_says_what_is_wrong() {
        let inch = read("<unit category='length' name='inch' conversionFactor='0.0254'/>").unwrap();
        assert_eq!(inch, Units { length: 0.0254, angle: 1.0 });
        assert_eq!(read("<unit category='angle' conversionFactor='.5'/>").unwrap().angle, 0.5);
        assert_eq!(read("<unit category='mass' conversionFactor='x'/>").unwrap(), Units::STANDARD);
        for wrong in ["0", "-1", "nan", "inf", ""] {
            assert!(
                read(&format!("<unit category='angle' conversionFactor='{wrong}'/>")).is_err(),
                "{wrong}"
            );
        }
        assert!(read("<unit category='time' conversionFactor='1'/>").is_err());
    }

    #[test]
    fn only_the_angles_of_a_field_are_multiplied() {
        let reals = |r: &[f64]| Value::Reals(r.into());
        let turn = reals(&[0.0, 1.0, 2.0, 90.0]);
        assert_eq!(in_radians(turn.clone(), "Transform", "rotation", 0.5), reals(&[0.0, 1.0, 2.0, 45.0]));
        assert_eq!(in_radians(reals(&[90.0]), "TextureTransform", "rotation", 0.5), reals(&[45.0]));
        let keys = reals(&[0.0, 1.0, 0.0, 4.0, 0.0, 1.0, 0.0, 8.0]);
        let halved = reals(&[0.0, 1.0, 0.0, 2.0, 0.0, 1.0, 0.0, 4.0]);
        assert_eq!(in_radians(keys, "OrientationInterpolator", "keyValue", 0.5), halved);
        assert_eq!(in_radians(turn.clone(), "ColorRGBA", "color", 0.5), turn);
        assert_eq!(in_radians(turn.clone(), "OrthoViewpoint", "fieldOfView", 0.5), turn);
        assert_eq!(in_radians(reals(&[2.0, 4.0]), "Background", "skyAngle", 0.5), reals(&[1.0, 2.0]));
    }
}

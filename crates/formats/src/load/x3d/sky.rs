//! Background nodes. Source: ISO/IEC 19775-1 clause 24.4.1.
//!
//! The sky has one colour more than it has angles, the first at the zenith; the ground likewise
//! from the nadir, with angles up to pi/2. Colours without an angle and angles without a colour are
//! ignored; an angle less than the one before is replaced by it. Enclosing groups rotate a
//! Background and have no other effect. `transparency` applies to the whole background.

use super::graph::{GraphView, NodeId};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Background, Band, Sky, SkyPictures};
use glam::{DMat3, DMat4, DVec3};
use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

/// Reads a Background with world matrix `model`; the sky is `None` if a single colour is enough.
pub(super) fn read(view: &GraphView, id: NodeId, model: DMat4) -> (Background, Option<Arc<Sky>>) {
    let transparency = view.real(id, "transparency").clamp(0.0, 1.0);
    if transparency == 1.0 {
        return (Background::default(), None);
    }
    let sky = bands(view.reals(id, "skyColor"), view.reals(id, "skyAngle"), PI);
    let ground = bands(view.reals(id, "groundColor"), view.reals(id, "groundAngle"), FRAC_PI_2);
    let pictures = view.graph.skies.get(&id).cloned();
    let zenith = sky.first().map_or(DVec3::ZERO, |b| b.color);
    let is_plain = sky.len() <= 1 && ground.len() <= 1 && pictures.is_none();
    if is_plain && transparency == 0.0 {
        return (Background { color: Some(zenith) }, None);
    }
    let sky = Sky {
        sky,
        // A nadir without an angle is a point.
        ground: if ground.len() > 1 { ground } else { Vec::new() },
        pictures: pictures.unwrap_or_else(SkyPictures::default),
        from_world: turn(model).transpose(),
        opacity: 1.0 - transparency,
    };
    let color = (transparency == 0.0).then_some(zenith);
    (Background { color }, Some(Arc::new(sky)))
}

/// Returns colours with their angles, the first at 0, the others at most `most`.
fn bands(colors: &[f64], angles: &[f64], most: f64) -> Vec<Band> {
    let mut last = 0.0;
    let angles = std::iter::once(0.0).chain(angles.iter().map(|a| a.min(most)));
    let band = |(color, angle): (&[f64; 3], f64)| {
        last = angle.max(last);
        Band { angle_rad: last, color: (*color).into() }
    };
    colors.as_chunks::<3>().0.iter().zip(angles).map(band).collect()
}

/// Returns the rotation part of a matrix: its columns orthonormalized, x first; the identity if it
/// is degenerate.
fn turn(model: DMat4) -> DMat3 {
    let [x, y, z] = [model.x_axis, model.y_axis, model.z_axis].map(|a| a.truncate());
    let turned = || {
        let x = unit(x)?;
        let y = unit(y - x * x.dot(y))?;
        let side = x.cross(y);
        Some(DMat3::from_cols(x, y, if side.dot(z) < 0.0 { -side } else { side }))
    };
    turned().unwrap_or(DMat3::IDENTITY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::math::matrix::{rotate, scale, translate};

    #[test]
    fn colours_go_with_their_angles() {
        let colors = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let at = |angles: &[f64], most: f64| {
            bands(&colors, angles, most).iter().map(|b| b.angle_rad).collect::<Vec<_>>()
        };
        assert_eq!(at(&[1.0, 2.0], PI), [0.0, 1.0, 2.0]);
        assert_eq!(at(&[1.0], PI), [0.0, 1.0]);
        assert_eq!(at(&[1.0, 0.5, 3.0, 3.0], PI), [0.0, 1.0, 1.0]);
        assert_eq!(at(&[1.0, 2.0], FRAC_PI_2), [0.0, 1.0, FRAC_PI_2]);
        assert_eq!(bands(&colors, &[1.0], PI)[1].color, DVec3::Y);
    }

    #[test]
    fn only_the_rotation_around_counts() {
        let quarter = rotate(DVec3::Z, FRAC_PI_2).unwrap();
        let model = translate(DVec3::splat(9.0)) * quarter * scale(DVec3::new(2.0, 3.0, 4.0));
        let found = turn(model);
        assert!((found * DVec3::Y - DVec3::NEG_X).length() < 1e-12);
        assert!((found.determinant() - 1.0).abs() < 1e-12);
        assert_eq!(turn(scale(DVec3::ZERO)), DMat3::IDENTITY);
    }
}

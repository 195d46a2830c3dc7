//! 4x4 matrices over column vectors (p' = M p), in f64, with the same bits on every machine.
//!
//! Source: Trabalho 2 / notes on linear transforms (scale, shear, translation, rotation about any
//! axis, mirror).

use glam::{DMat4, DVec3, DVec4};

/// Returns the matrix of 16 numbers, row by row as written on paper.
pub fn from_rows(rows: [f64; 16]) -> DMat4 {
    DMat4::from_cols_array(&rows).transpose()
}

/// Returns the translation by `t`.
pub fn translate(t: DVec3) -> DMat4 {
    DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, t.extend(1.0))
}

/// Returns the scaling of each axis by its factor; a negative factor mirrors.
pub fn scale(s: DVec3) -> DMat4 {
    DMat4::from_diagonal(s.extend(1.0))
}

/// Returns the shear x' = x + xy*y + xz*z, y' = y + yx*x + yz*z, z' = z + zx*x + zy*y.
pub fn shear(xy: f64, xz: f64, yx: f64, yz: f64, zx: f64, zy: f64) -> DMat4 {
    from_rows([1.0, xy, xz, 0.0, yx, 1.0, yz, 0.0, zx, zy, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
}

/// Returns the rotation by `angle_rad` about `axis` (right-hand rule, through the origin), or
/// `None` for an axis without direction.
///
/// Rodrigues: R = cos I + sin K + (1 - cos) k k^T, K x = k cross x. The axis is scaled before it is
/// normalised, so neither a huge nor a tiny one overflows.
pub fn rotate(axis: DVec3, angle_rad: f64) -> Option<DMat4> {
    let k = unit(axis)?;
    let (s, c) = libm::sincos(angle_rad);
    let t = 1.0 - c;
    Some(from_rows([
        t * k.x * k.x + c,
        t * k.x * k.y - s * k.z,
        t * k.x * k.z + s * k.y,
        0.0,
        t * k.x * k.y + s * k.z,
        t * k.y * k.y + c,
        t * k.y * k.z - s * k.x,
        0.0,
        t * k.x * k.z - s * k.y,
        t * k.y * k.z + s * k.x,
        t * k.z * k.z + c,
        0.0,
        0.0,
        0.0,
        0.0,
        1.0,
    ]))
}

/// Returns `v` at length 1, or `None` if it is zero or not finite. Safe for lengths from 1e-308 to
/// 1e308.
pub fn unit(v: DVec3) -> Option<DVec3> {
    let m = v.abs().max_element();
    if !(m > 0.0 && m.is_finite()) {
        return None;
    }
    let v = v / m;
    Some(v / v.dot(v).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turn_about_z_takes_x_to_y() {
        let p = rotate(DVec3::new(0.0, 0.0, 1e-300), std::f64::consts::FRAC_PI_2)
            .unwrap()
            .transform_point3(DVec3::X);
        assert!((p - DVec3::Y).length() < 1e-15);
        assert!(rotate(DVec3::ZERO, 1.0).is_none());
    }

    #[test]
    fn a_turn_about_any_axis_is_rodrigues_formula() {
        for (i, j) in (0..24).flat_map(|i| (0..12).map(move |j| (i, j))) {
            let (around, up, angle) =
                (f64::from(i) * 0.7, f64::from(j) * 0.55 - 3.0, f64::from(i * j) * 0.31 - 4.0);
            let axis = DVec3::new(up.cos() * around.cos(), up.cos() * around.sin(), up.sin());
            let turn = rotate(axis * 37.5, angle).unwrap();
            for p in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.5, -2.0, 0.25)] {
                let (k, (sin, cos)) = (axis, angle.sin_cos());
                let want = p * cos + k.cross(p) * sin + k * (k.dot(p) * (1.0 - cos));
                let got = turn.transform_point3(p);
                assert!((got - want).length() < 1e-14, "{p} about {k} by {angle}: {got} for {want}");
            }
        }
    }

    #[test]
    fn rows_are_rows() {
        let m = shear(2.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        assert_eq!(m.transform_point3(DVec3::new(1.0, 10.0, 0.0)), DVec3::new(21.0, 10.0, 0.0));
        let m = shear(2.0, 3.0, 5.0, 7.0, 11.0, 13.0);
        // x + 2y + 3z, y + 5x + 7z, z + 11x + 13y
        assert_eq!(m.transform_point3(DVec3::new(1.0, 10.0, 100.0)), DVec3::new(321.0, 715.0, 241.0));
        assert_eq!(translate(DVec3::X) * DVec4::W, DVec4::new(1.0, 0.0, 0.0, 1.0));
    }
}

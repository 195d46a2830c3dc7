//! Backdrop infinitely far away: colours by the angle from the zenith and the nadir, and a cube of
//! pictures.
//!
//! In: directions in world space. Out: colours. The backdrop is always centred at the eye, so that
//! only the direction counts. The pictures are in front of the ground, the ground in front of the
//! sky.
//!
//! Source: X3D's Background (ISO/IEC 19775-1 clause 24.4.1).
//!
//! Colours are interpolated linearly in R, G, B between angles. The sky continues in its last
//! colour; the ground ends at its last angle. A picture is upright when looking along its axis:
//! front -z, back +z, right +x, left -x with y up; top +y with +z up, bottom -y with -z up. It is
//! sampled bilinearly with clamped edges, and the colours behind it show where its alpha is below
//! 1.

use super::Texture;
use glam::{DMat3, DVec3};
use std::sync::Arc;

/// Pictures on the sides of the cube, `None` where a side has none.
#[derive(Clone, Debug, Default)]
pub struct SkyPictures {
    /// Seen along +z.
    pub back: Option<Arc<Texture>>,
    /// Seen along -y, -z up.
    pub bottom: Option<Arc<Texture>>,
    /// Seen along -z.
    pub front: Option<Arc<Texture>>,
    /// Seen along -x.
    pub left: Option<Arc<Texture>>,
    /// Seen along +x.
    pub right: Option<Arc<Texture>>,
    /// Seen along +y, +z up.
    pub top: Option<Arc<Texture>>,
}

impl SkyPictures {
    fn all(&self) -> [Option<&Arc<Texture>>; 6] {
        [&self.back, &self.bottom, &self.front, &self.left, &self.right, &self.top].map(Option::as_ref)
    }
}

impl PartialEq for SkyPictures {
    /// Compares pictures by identity, not by value: those of a scene are created once.
    fn eq(&self, other: &Self) -> bool {
        let is_same = |a: Option<&Arc<Texture>>, b: Option<&Arc<Texture>>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        };
        self.all().into_iter().zip(other.all()).all(|(a, b)| is_same(a, b))
    }
}

/// Colour at an angle from the zenith or the nadir.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// Angle in radians; not less than that of the previous band.
    pub angle_rad: f64,
    /// R, G, B.
    pub color: DVec3,
}

/// Backdrop of a scene; see the module.
#[derive(Clone, Debug, PartialEq)]
pub struct Sky {
    /// Colours by the angle from the zenith; the first is at 0.
    pub sky: Vec<Band>,
    /// Colours by the angle from the nadir; the first is at 0, and the ground ends at the last.
    pub ground: Vec<Band>,
    /// Pictures in front of ground and sky.
    pub pictures: SkyPictures,
    /// Rotation from world directions to the backdrop's own axes, y up.
    pub from_world: DMat3,
    /// Opacity of the backdrop over the frame, from 0 to 1.
    pub opacity: f64,
}

impl Sky {
    /// Returns the colour in a world direction of any length but 0.
    pub fn color(&self, direction: DVec3) -> DVec3 {
        let d = self.from_world * direction;
        let across = (d.x * d.x + d.z * d.z).sqrt();
        let ground = between(&self.ground, libm::atan2(across, -d.y));
        let behind = ground.unwrap_or_else(|| {
            let angle = libm::atan2(across, d.y);
            between(&self.sky, angle).or(self.sky.last().map(|b| b.color)).unwrap_or(DVec3::ZERO)
        });
        match self.picture(d) {
            Some([r, g, b, alpha]) => behind * (1.0 - alpha) + DVec3::new(r, g, b) * alpha,
            None => behind,
        }
    }

    /// Returns R, G, B, A of the picture in a direction of the backdrop's own axes, or `None` if
    /// that side has none.
    fn picture(&self, d: DVec3) -> Option<[f64; 4]> {
        let [x, y, z] = d.abs().to_array();
        let p = &self.pictures;
        let (side, along, up) = match () {
            () if z >= x && z >= y && d.z < 0.0 => (&p.front, DVec3::NEG_Z, DVec3::Y),
            () if z >= x && z >= y => (&p.back, DVec3::Z, DVec3::Y),
            () if x >= y && d.x > 0.0 => (&p.right, DVec3::X, DVec3::Y),
            () if x >= y => (&p.left, DVec3::NEG_X, DVec3::Y),
            () if d.y > 0.0 => (&p.top, DVec3::Y, DVec3::Z),
            () => (&p.bottom, DVec3::NEG_Y, DVec3::NEG_Z),
        };
        let side = side.as_ref()?;
        let depth = d.dot(along);
        let place = |axis: DVec3| (d.dot(axis) / depth + 1.0) / 2.0;
        Some(sample(side, [place(along.cross(up)), place(up)]))
    }
}

/// Returns the colour at an angle, or `None` beyond the last band.
fn between(bands: &[Band], angle_rad: f64) -> Option<DVec3> {
    let after = bands.partition_point(|b| b.angle_rad <= angle_rad);
    match (after.checked_sub(1).map(|i| bands[i]), bands.get(after)) {
        (Some(a), Some(b)) => {
            let t = (angle_rad - a.angle_rad) / (b.angle_rad - a.angle_rad);
            Some(a.color + (b.color - a.color) * t)
        }
        (Some(last), None) if last.angle_rad == angle_rad => Some(last.color),
        (None, Some(first)) => Some(first.color),
        _ => None,
    }
}

/// Samples a picture bilinearly. Returns R, G, B, A in 0..1 at u, v in 0..1, the origin at the
/// lower left.
fn sample(texture: &Texture, [u, v]: [f64; 2]) -> [f64; 4] {
    let (width, height) = (texture.width(), texture.height());
    let place = |at: f64, size: u32| {
        let texels = at.clamp(0.0, 1.0) * f64::from(size) - 0.5;
        let low = texels.floor();
        let inside = |i: f64| i.clamp(0.0, f64::from(size - 1)) as u32;
        ([inside(low), inside(low + 1.0)], texels - low)
    };
    let ((xs, fx), (ys, fy)) = (place(u, width), place(v, height));
    let texel = |i: usize, j: usize| texture.texel(0, xs[i], height - 1 - ys[j]).map(f64::from);
    let rows = [0, 1].map(|j| {
        let (a, b) = (texel(0, j), texel(1, j));
        std::array::from_fn::<f64, 4, _>(|c| a[c] + (b[c] - a[c]) * fx)
    });
    std::array::from_fn(|c| (rows[0][c] + (rows[1][c] - rows[0][c]) * fy) / 255.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

    fn bands(all: &[(f64, DVec3)]) -> Vec<Band> {
        all.iter().map(|&(angle_rad, color)| Band { angle_rad, color }).collect()
    }

    fn sky() -> Sky {
        Sky {
            sky: bands(&[(0.0, DVec3::Z), (FRAC_PI_2, DVec3::ONE)]),
            ground: bands(&[(0.0, DVec3::ZERO), (FRAC_PI_4, DVec3::X)]),
            pictures: SkyPictures::default(),
            from_world: DMat3::IDENTITY,
            opacity: 1.0,
        }
    }

    fn close(a: DVec3, b: DVec3) {
        assert!((a - b).length() < 1e-12, "{a} is not {b}");
    }

    /// Direction at an angle from the zenith, towards x.
    fn at(angle: f64) -> DVec3 {
        DVec3::new(angle.sin(), angle.cos(), 0.0) * 7.0
    }

    #[test]
    fn colours_run_from_the_zenith_down_and_from_the_nadir_up() {
        let sky = sky();
        close(sky.color(DVec3::Y), DVec3::Z);
        close(sky.color(at(FRAC_PI_4)), DVec3::new(0.5, 0.5, 1.0));
        close(sky.color(at(0.3)), DVec3::new(0.3 / FRAC_PI_2, 0.3 / FRAC_PI_2, 1.0));
        // Beyond the last sky angle its colour continues, down to the ground.
        close(sky.color(at(FRAC_PI_2 + 0.5)), DVec3::ONE);
        close(sky.color(at(PI - FRAC_PI_4 - 1e-9)), DVec3::ONE);
        close(sky.color(at(PI - FRAC_PI_4 / 2.0)), DVec3::X * 0.5);
        close(sky.color(DVec3::NEG_Y), DVec3::ZERO);
        let turned = Sky { from_world: DMat3::from_rotation_x(FRAC_PI_2), ..sky };
        close(turned.color(DVec3::NEG_Z), DVec3::Z);
    }

    #[test]
    fn equal_angles_jump_and_one_colour_is_everywhere() {
        let two = bands(&[(0.0, DVec3::X), (1.0, DVec3::Y), (1.0, DVec3::Z)]);
        assert_eq!(between(&two, 1.0), Some(DVec3::Z));
        assert!((between(&two, 0.5).unwrap() - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-15);
        assert_eq!(between(&two, 1.1), None);
        assert_eq!(between(&[], 0.0), None);
        let one = Sky { sky: bands(&[(0.0, DVec3::X)]), ground: Vec::new(), ..sky() };
        for angle in [0.0, 1.0, 3.0, PI] {
            assert_eq!(one.color(at(angle)), DVec3::X);
        }
    }

    /// Picture of 2 x 2 texels with distinct reds: lower left 0, lower right 51, upper left 102,
    /// upper right 153.
    fn corners(green: u8, alpha: u8) -> Option<Arc<Texture>> {
        let bytes = [102, 153, 0, 51].map(|red| [red, green, 0, alpha]).concat();
        Some(Arc::new(Texture::new(2, 2, bytes).unwrap()))
    }

    #[test]
    fn every_side_of_the_cube_is_upright_seen_from_the_middle() {
        let pictures = SkyPictures {
            back: corners(10, 255),
            bottom: corners(20, 255),
            front: corners(30, 255),
            left: corners(40, 255),
            right: corners(50, 255),
            top: corners(60, 255),
        };
        let sky = Sky { pictures, ..sky() };
        // Along, up, green of the side.
        for (along, up, green) in [
            (DVec3::Z, DVec3::Y, 10.0),
            (DVec3::NEG_Y, DVec3::NEG_Z, 20.0),
            (DVec3::NEG_Z, DVec3::Y, 30.0),
            (DVec3::NEG_X, DVec3::Y, 40.0),
            (DVec3::X, DVec3::Y, 50.0),
            (DVec3::Y, DVec3::Z, 60.0),
        ] {
            let right = along.cross(up);
            for (s, t, red) in [(-0.9, -0.9, 0.0), (0.9, -0.9, 51.0), (-0.9, 0.9, 102.0), (0.9, 0.9, 153.0)] {
                let color = sky.color((along + right * s + up * t) * 3.0);
                close(color, DVec3::new(red, green, 0.0) / 255.0);
            }
            // Between the four texels, in the middle.
            close(sky.color(along), DVec3::new(76.5, green, 0.0) / 255.0);
        }
    }

    #[test]
    fn what_is_behind_shows_through_a_pictures_alpha() {
        let pictures = SkyPictures { front: corners(255, 51), ..SkyPictures::default() };
        let sky = Sky { pictures, ..sky() };
        let color = sky.color(DVec3::NEG_Z);
        close(color, DVec3::new(0.8 + 0.2 * 0.3, 1.0, 0.8));
        close(sky.color(DVec3::Z), DVec3::ONE);
    }
}

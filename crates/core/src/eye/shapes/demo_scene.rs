//! Demo scenes: a shape with an eye at a good distance, lights and a screen.

use super::Shape;
use crate::eye::error::EyeError;
use crate::eye::pose::Pose;
use crate::eye::scene::{EyeLight, EyeLightKind, EyeScene, Falloff, SceneParts};
use crate::eye::validate::in_range;

/// Colours of cells, used cyclically.
pub const PALETTE: [[f64; 3]; 8] = [
    [230.0, 60.0, 50.0],
    [70.0, 200.0, 80.0],
    [70.0, 90.0, 240.0],
    [240.0, 230.0, 60.0],
    [170.0, 70.0, 230.0],
    [60.0, 190.0, 220.0],
    [250.0, 170.0, 40.0],
    [240.0, 120.0, 190.0],
];

/// Settings of a shape's demo scene.
#[derive(Clone, Debug, PartialEq)]
pub struct DemoScene {
    /// Pixels along each screen axis.
    pub pixels: Vec<u32>,
    /// Aperture of every hidden axis, as a tangent.
    pub aperture_tan: f64,
    /// Rotations of the shape, in order: two axes and an angle in degrees.
    pub turns: Vec<(usize, usize, f64)>,
}

/// Turns of a shape that show most of its cells: two axes and an angle in degrees.
const ASKEW: [(usize, usize, f64); 6] =
    [(0, 1, 30.0), (0, 2, 20.0), (1, 3, 40.0), (0, 3, 25.0), (2, 4, 35.0), (0, 4, 15.0)];

impl DemoScene {
    /// Creates the usual settings for a shape of `dim` dimensions: 320x240 pixels (320 in two
    /// dimensions), an aperture of tangent 0.4, and turns in those of its axes that exist.
    pub fn of_dim(dim: usize) -> Self {
        DemoScene {
            pixels: if dim == 2 { vec![320] } else { vec![320, 240] },
            aperture_tan: 0.4,
            turns: ASKEW.into_iter().filter(|&(_, b, _)| b < dim).collect(),
        }
    }

    /// Creates the scene: the shape about 0, seen from a distance of 3 radii along axis 0, with a
    /// white point light to the upper left of the eye and a bluish sun from the right. Colours come
    /// from [`PALETTE`].
    pub fn scene(&self, shape: Shape) -> Result<EyeScene, EyeError> {
        self.scene_in_colors(shape, |cell| PALETTE[cell as usize % PALETTE.len()])
    }

    /// Creates the scene of [`Self::scene`] with a colour for each cell.
    pub fn scene_in_colors(
        &self,
        shape: Shape,
        color: impl Fn(u32) -> [f64; 3],
    ) -> Result<EyeScene, EyeError> {
        let dim = shape.dim;
        let mut shape = shape;
        for (i, &(a, b, angle_deg)) in self.turns.iter().enumerate() {
            in_range(format!("turn {i}"), b as f64, a != b && a < dim && b < dim, || {
                format!("two different axes from 0 to {}", dim - 1)
            })?;
            in_range(format!("turn {i}"), angle_deg, angle_deg.is_finite(), || "a finite angle".into())?;
            shape = shape.turned(a, b, angle_deg);
        }
        let radius = shape.radius();
        let along = |components: &[f64]| -> Vec<f64> {
            (0..dim).map(|k| components.get(k).copied().unwrap_or(0.0) * radius).collect()
        };
        let least = self.pixels.iter().copied().filter(|&n| n > 1).min().unwrap_or(1);
        // Lights slightly off the eye's own hidden coordinate show which cells face it.
        let mut light_position = along(&[-2.0, 2.0, 2.5]);
        let mut sun = along(&[0.7, 1.0, -0.4]);
        light_position[dim - 1] += 0.3 * radius;
        sun[dim - 1] += 0.2 * radius;
        let parts = SceneParts {
            dim,
            pixels: self.pixels.clone(),
            distance: 1.0,
            // The sphere around the shape has slope 1 / sqrt 8 from 3 radii.
            size: self.pixels.iter().map(|&n| 0.8 * f64::from(n.max(1)) / f64::from(least)).collect(),
            aperture_tan: vec![self.aperture_tan; (dim - 1).saturating_sub(self.pixels.len())],
            diffuse: [0.15, 0.15, 0.2],
            view: Falloff::OFF,
            background: [12.0, 14.0, 24.0],
            pose: Pose { position: along(&[-3.0]), rotations: Vec::new() },
            lights: vec![
                EyeLight {
                    kind: EyeLightKind::Radial { position: light_position },
                    falloff: Falloff { k: (1.0 + 2.4 * radius) * 0.9, n: 1.0 },
                    color: [1.0, 0.95, 0.85],
                },
                EyeLight {
                    kind: EyeLightKind::Sun { direction: sun },
                    falloff: Falloff { k: 0.4, n: 0.0 },
                    color: [0.6, 0.75, 1.0],
                },
            ],
            facets: shape.facets(color),
        };
        EyeScene::new(parts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::shapes::cross_polytope;

    #[test]
    fn cells_take_the_colours_in_turn_and_the_lights_stand_beside_the_eye() {
        let demo = DemoScene { pixels: vec![4, 4], aperture_tan: 0.3, turns: vec![] };
        let shape = cross_polytope(4).unwrap();
        let cells = shape.cells.clone();
        let scene = demo.scene(shape).unwrap();
        assert!(cells.iter().max() > Some(&8), "more cells than colours");
        for (facet, cell) in scene.facets.iter().zip(cells) {
            assert_eq!(facet.color, PALETTE[(cell % 8) as usize]);
        }
        // The shape's radius is 1. Both lights are off the eye's hidden coordinate, which is 0.
        let kinds: Vec<_> = scene.lights.iter().map(|l| l.kind.clone()).collect();
        let (position, direction) = (vec![-2.0, 2.0, 2.5, 0.3], vec![0.7, 1.0, -0.4, 0.2]);
        assert_eq!(kinds, [EyeLightKind::Radial { position }, EyeLightKind::Sun { direction }]);
        assert_eq!(scene.pose.position, [-3.0, 0.0, 0.0, 0.0]);
    }
}

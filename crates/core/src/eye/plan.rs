//! The plan of rendering a scene, as printed by `--explain`: the method, and what is culled.

use super::method::Method;
use super::scene::{EyeLightKind, EyeScene};
use super::tile::World;
use std::fmt;

/// Method of finding shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObstaclePlan {
    /// No lights: no obstacles are stored and no shadow tests are made.
    None,
    /// This many obstacles; those that may shadow a tile are selected for each tile.
    Picked(usize),
    /// This many obstacles, in a hierarchy of this many boxes.
    Boxes(usize, usize),
}

/// Plan of rendering a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct EyePlan {
    /// Dimension N of the space.
    pub dim: usize,
    /// Pixels along each screen axis.
    pub pixels: Vec<u32>,
    /// Search method for fibres, in words.
    pub fibre: String,
    /// Number of facets of the scene.
    pub facets: usize,
    /// Number of degenerate facets, which are skipped.
    pub skipped: usize,
    /// Number of facets seen edge-on, which are invisible.
    pub edge_on: usize,
    /// Number of facets behind the eye, beside the screen or outside the aperture.
    pub out_of_view: usize,
    /// Number of facets that are searched in the fibres.
    pub searched: usize,
    /// Numbers of suns, light planes and point lights.
    pub lights: [usize; 3],
    /// Method of finding shadows.
    pub obstacles: ObstaclePlan,
    /// Size of the frame's data in bytes.
    pub frame_bytes: usize,
    /// Size of the picture in bytes.
    pub picture_bytes: usize,
}

impl EyePlan {
    pub(super) fn new<const N: usize>(scene: &EyeScene, world: &World<N>) -> Self {
        let frame = &world.frame;
        let rays = frame.fan.len();
        let kind = |k: &EyeLightKind| match k {
            EyeLightKind::Sun { .. } => 0,
            EyeLightKind::Plane { .. } => 1,
            EyeLightKind::Radial { .. } => 2,
        };
        let mut lights = [0; 3];
        scene.lights.iter().for_each(|l| lights[kind(&l.kind)] += 1);
        let occluders = frame.occluders.len();
        EyePlan {
            dim: N,
            pixels: scene.pixels.clone(),
            fibre: match frame.method {
                Method::Ray => "a ray: no hidden axis, so no search in a fibre".into(),
                Method::Plane => "closed form: one hidden axis, a facet meets the fibre in a segment".into(),
                Method::Cone => {
                    format!("nearest point of a polytope: {} hidden axes", scene.hidden_dim())
                }
                Method::Fan(_) => format!("sampled by {rays} rays: never nearer than exact"),
            },
            facets: scene.facets.len(),
            skipped: frame.skipped.len(),
            edge_on: frame.edge_on,
            out_of_view: scene.facets.len() - frame.skipped.len() - frame.edge_on - frame.facets.len(),
            searched: frame.facets.len(),
            lights,
            obstacles: match &world.obstacles {
                _ if scene.lights.is_empty() => ObstaclePlan::None,
                None => ObstaclePlan::Picked(occluders),
                Some(boxes) => ObstaclePlan::Boxes(occluders, boxes.boxes()),
            },
            frame_bytes: frame.bytes(),
            picture_bytes: scene.pixel_count() * (4 + 8 + 24 + scene.lights.len()),
        }
    }
}

impl fmt::Display for EyePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pixels: Vec<String> = self.pixels.iter().map(u32::to_string).collect();
        writeln!(
            f,
            "space      {} dimensions on a screen of {} ({} pixels)",
            self.dim,
            self.pixels.len(),
            pixels.join("x")
        )?;
        writeln!(f, "fibre      {}", self.fibre)?;
        writeln!(
            f,
            "facets     {}: {} degenerate, {} edge-on, {} out of view, {} searched, nearest first",
            self.facets, self.skipped, self.edge_on, self.out_of_view, self.searched
        )?;
        match self.lights {
            [0, 0, 0] => writeln!(f, "lights     none: diffuse light alone")?,
            counts => {
                let named = counts.iter().zip(["sun", "light plane", "point"]).filter(|(n, _)| **n > 0);
                let named: Vec<String> =
                    named.map(|(n, name)| format!("{n} {name}{}", if *n == 1 { "" } else { "s" })).collect();
                writeln!(f, "lights     {}", named.join(", "))?;
            }
        }
        match self.obstacles {
            ObstaclePlan::None => writeln!(f, "shadows    none: no lights")?,
            ObstaclePlan::Picked(n) => writeln!(f, "shadows    {n} obstacles, picked for each tile")?,
            ObstaclePlan::Boxes(n, boxes) => writeln!(f, "shadows    {n} obstacles in {boxes} boxes")?,
        }
        write!(
            f,
            "memory     {} bytes for the frame, {} for the picture",
            self.frame_bytes, self.picture_bytes
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eye::shapes::{DemoScene, cell24, cube};
    use crate::eye::{Facet, Fibre, plan};

    fn demo(dim: usize, pixels: &[u32], change: impl Fn(&mut crate::eye::SceneParts)) -> EyePlan {
        let demo = DemoScene { pixels: pixels.to_vec(), aperture_tan: 0.3, turns: vec![(0, 1, 20.0)] };
        let mut parts = demo.scene(cube(dim).unwrap()).unwrap().into_parts();
        change(&mut parts);
        plan(&EyeScene::new(parts).unwrap(), Fibre::Exact).unwrap()
    }

    #[test]
    fn without_lights_there_are_no_shadows() {
        let plan = demo(3, &[8, 8], |parts| parts.lights.clear());
        assert_eq!((plan.lights, plan.obstacles), ([0; 3], ObstaclePlan::None));
        assert!(plan.to_string().contains("shadows    none: no lights"));
        assert_eq!(demo(3, &[8, 8], |_| {}).obstacles, ObstaclePlan::Picked(12));
    }

    #[test]
    fn without_hidden_axes_no_fibre_is_searched() {
        assert!(demo(3, &[8, 8], |_| {}).fibre.starts_with("a ray"));
        assert!(demo(4, &[8, 8], |_| {}).fibre.starts_with("closed form"));
        assert!(demo(5, &[8, 8], |_| {}).fibre.starts_with("nearest point of a polytope: 2"));
    }

    #[test]
    fn what_cannot_be_seen_is_culled_once_and_counted() {
        let plan = demo(3, &[64, 64], |parts| {
            let mut behind = parts.facets[0].clone();
            behind.v.iter_mut().for_each(|p| p[0] -= 90.0);
            let mut edge_on = behind.clone();
            edge_on.v = vec![vec![-4.0, 0.5, 0.0], vec![4.0, 0.5, 0.0], vec![0.0, 0.5, 1.0]];
            parts.pose.position[1] = 0.5;
            let mut flat = behind.clone();
            flat.v[1] = flat.v[0].clone();
            parts.facets.extend([behind, edge_on, flat]);
        });
        assert_eq!(
            (plan.facets, plan.skipped, plan.edge_on, plan.out_of_view, plan.searched),
            (15, 1, 1, 1, 12)
        );
    }

    #[test]
    fn culled_facets_of_large_scenes_are_all_counted() {
        let plan = demo(3, &[8, 8], |parts| {
            let facet = |v: [[f64; 3]; 3]| Facet { v: v.map(|p| p.to_vec()).to_vec(), color: [1.0; 3] };
            let kinds = [
                facet([[-90.0, 0.0, 0.0], [-90.0, 1.0, 0.0], [-90.0, 0.0, 1.0]]),
                facet([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 1.0]]),
                facet([[1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]),
            ];
            (0..2500).for_each(|_| parts.facets.extend(kinds.clone()));
        });
        assert_eq!((plan.facets, plan.skipped, plan.edge_on), (7512, 2500, 2500));
        // Those behind the eye are out of view, and perhaps some of the cube's twelve.
        assert!((2500..2512).contains(&plan.out_of_view), "{plan}");
        assert_eq!(plan.out_of_view + plan.searched, 2512);
    }

    #[test]
    fn a_hierarchy_is_built_only_for_many_obstacles() {
        let demo = DemoScene { pixels: vec![4, 4], aperture_tan: 0.3, turns: vec![] };
        let mut parts = demo.scene(cell24(4).unwrap()).unwrap().into_parts();
        let facets = parts.facets.clone();
        (0..3).for_each(|_| parts.facets.extend(facets.clone()));
        let plan = plan(&EyeScene::new(parts).unwrap(), Fibre::Exact).unwrap();
        assert!(matches!(plan.obstacles, ObstaclePlan::Boxes(384, boxes) if boxes > 100), "{plan}");
    }
}

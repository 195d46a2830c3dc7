//! `fbptr eye --make`: scenes around regular polytopes and prisms.

use crate::eye::EyeScene;
use crate::eye::shapes::{DemoScene, Shape, cell24, cross_polytope, cube, extrude, from_mesh, simplex};
use crate::load::obj;
use clap::{Args, ValueEnum};
use glam::DVec3;
use std::path::PathBuf;

/// Options of `eye --make`.
#[derive(Debug, Args)]
pub(super) struct Make {
    /// Print a scene around this shape
    #[arg(long = "make", value_name = "SHAPE")]
    pub shape: Option<Made>,
    /// Dimensions of the space [default: 4]
    #[arg(long, value_name = "N", requires = "shape", conflicts_with = "scene")]
    dim: Option<usize>,
    /// Pixels along each axis of the screen, as many numbers as it has axes [default: 320x240, or 320 in two dimensions]
    #[arg(long, value_name = "AxBxC", requires = "shape", conflicts_with = "scene")]
    pixels: Option<String>,
    /// Tangent of the aperture of each hidden axis
    #[arg(long, value_name = "TAN", default_value_t = 0.4, requires = "shape", conflicts_with = "scene")]
    aperture: f64,
    /// Turn the shape in the plane of two axes, from A towards B; again for further turns
    #[arg(
        long,
        value_name = "A,B,DEGREES",
        requires = "shape",
        conflicts_with = "scene",
        allow_hyphen_values = true
    )]
    turn: Vec<String>,
    /// The mesh that a prism stands on
    #[arg(long, value_name = "FILE.obj", requires = "shape", conflicts_with = "scene")]
    mesh: Option<PathBuf>,
    /// Half the length of a prism along each further axis, in radii of its mesh [default: 0.5]
    #[arg(long, value_name = "LENGTH", requires = "shape", conflicts_with = "scene")]
    half: Option<f64>,
}

/// Shapes that can be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Made {
    /// The regular simplex of N dimensions
    Simplex,
    /// The cube of N dimensions
    Cube,
    /// The cube of 4 dimensions
    Tesseract,
    /// The cross-polytope of N dimensions
    CrossPolytope,
    /// The 24-cell of 4 dimensions
    #[value(name = "24-cell", alias = "cell24")]
    Cell24,
    /// A mesh drawn out along the axes from the fourth on
    Prism,
}

impl Make {
    /// Creates the scene, or returns an error message about the arguments.
    pub fn scene(&self, made: Made) -> Result<EyeScene, String> {
        if made != Made::Prism && self.mesh.is_some() {
            return Err("--mesh does nothing here: it is what a prism stands on".to_owned());
        }
        if made != Made::Prism && self.half.is_some() {
            return Err("--half does nothing here: it is a prism's".to_owned());
        }
        let dim = self.dim.unwrap_or(4);
        let shape = match made {
            Made::Simplex => simplex(dim),
            Made::Cube => cube(dim),
            Made::Tesseract if dim != 4 => {
                return Err(format!("--dim: a tesseract has 4 dimensions, not {dim}; cube has any number"));
            }
            Made::Tesseract => cube(dim),
            Made::CrossPolytope => cross_polytope(dim),
            Made::Cell24 => cell24(dim),
            Made::Prism => {
                let (shape, colors) = self.prism(dim)?;
                let scene = self.demo(3)?.scene_in_colors(shape, |cell| colors[cell as usize]);
                return scene.map_err(|e| e.to_string());
            }
        };
        let shape = shape.map_err(|e| format!("--dim: {e}"))?;
        self.demo(shape.dim)?.scene(shape).map_err(|e| e.to_string())
    }

    /// Returns the settings of the demo scene. Without rotations by the user a shape is rotated in
    /// its first `dim` dimensions.
    fn demo(&self, dim: usize) -> Result<DemoScene, String> {
        let usual = DemoScene::of_dim(dim);
        Ok(DemoScene {
            pixels: self.pixels.as_deref().map_or(Ok(usual.pixels), pixels)?,
            aperture_tan: self.aperture,
            turns: if self.turn.is_empty() { usual.turns } else { turns(&self.turn)? },
        })
    }

    /// Returns the mesh centred at 0 and scaled to radius 1, extruded, and a colour for each of its
    /// polygons: that of its direction.
    fn prism(&self, dim: usize) -> Result<(Shape, Vec<[f64; 3]>), String> {
        let path = self.mesh.as_ref().ok_or("--make prism needs --mesh FILE.obj")?;
        let name = path.display().to_string();
        if !(3..=8).contains(&dim) {
            return Err(format!("--dim: a prism has 3 to 8 dimensions, not {dim}"));
        }
        let half = self.half.unwrap_or(0.5);
        if !(half.is_finite() && half > 0.0) {
            return Err(format!("--half: expected a length over 0, found {half}"));
        }
        let bytes = crate::save::read_input(path, 4 << 30).map_err(|e| format!("{name}: {e}"))?;
        // Materials are ignored: colours only distinguish a cell from its neighbours.
        let loaded = obj::parse(&bytes, &mut |_| None, &name).map_err(|e| e.to_string())?;
        let mut shape = from_mesh(&loaded.geometry.mesh).map_err(|e| format!("{name}: {e}"))?;
        let bounds = |a: usize| {
            let along = shape.points.iter().map(|p| p[a]);
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)))
        };
        let middle: Vec<f64> = (0..3).map(|a| -0.5 * (bounds(a).0 + bounds(a).1)).collect();
        shape = shape.placed(1.0, &middle);
        let radius = shape.radius();
        if radius > 0.0 {
            shape = shape.placed(1.0 / radius, &[0.0; 3]);
        }
        let mut colors = vec![[0.0; 3]; shape.cells.iter().max().map_or(0, |&c| c as usize + 1)];
        for (triangle, &cell) in shape.simplices.iter().zip(&shape.cells) {
            let corner = |i: usize| DVec3::from_slice(&shape.points[triangle[i] as usize]);
            let normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalize_or_zero();
            colors[cell as usize] = (DVec3::splat(150.0) + normal * 100.0).to_array();
        }
        for _ in 3..dim {
            shape = extrude(&shape, -half, half);
        }
        Ok((shape, colors))
    }
}

fn pixels(text: &str) -> Result<Vec<u32>, String> {
    let wrong = || format!("--pixels: expected numbers from 1 with an x between, found {text:?}");
    text.split('x').map(|n| n.parse().ok().filter(|&n: &u32| n > 0).ok_or_else(wrong)).collect()
}

fn turns(texts: &[String]) -> Result<Vec<(usize, usize, f64)>, String> {
    let one = |text: &String| {
        let wrong = || format!("--turn: expected two axes and degrees, as in 0,3,30, found {text:?}");
        let parts: Vec<&str> = text.split(',').collect();
        let [a, b, degrees] = parts[..] else { return Err(wrong()) };
        match (a.parse(), b.parse(), degrees.parse()) {
            (Ok(a), Ok(b), Ok(degrees)) => Ok((a, b, degrees)),
            _ => Err(wrong()),
        }
    };
    texts.iter().map(one).collect()
}

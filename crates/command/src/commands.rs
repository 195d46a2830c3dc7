//! The values in commands that no other room knows, and the closed [`Command`] enum itself, which
//! the verb table defines.

use super::codec::Codec;
pub use super::table::{Command, Figure};
pub use fbptr_core::draw2d::{AreaColors, RampColor, RealRect, Rect};
use fbptr_core::scene::{Attenuation, MaxError, Projection};
use glam::DVec3;

/// Source of the mesh that `MESH` defines.
#[derive(Clone, Debug, PartialEq)]
pub enum MeshSource {
    /// An OBJ file's bytes.
    Obj(Vec<u8>),
    /// X3D's Box: size x, y, z (default 2 2 2).
    Box(DVec3),
    /// X3D's Sphere: radius (default 1).
    Sphere(f64),
    /// X3D's Cone: bottom radius, height (default 1, 2).
    Cone(f64, f64),
    /// X3D's Cylinder: radius, height (default 1, 2).
    Cylinder(f64, f64),
    /// Newell's teapot, each patch divided into `level` x `level` quads (default 10).
    Teapot(u32),
    /// The torus knot (2,3) as a grid of nu x nv quads.
    Knot(u32, u32),
}

/// Kind of file that `LOAD` reads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FileKind {
    /// `LOAD MESH name path`.
    Mesh,
    /// `LOAD TEX name path`.
    Texture,
    /// `LOAD SCENE path`.
    Scene,
}

/// Arguments of `LIGHT i`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightCommand {
    /// A point light.
    Point {
        /// World position.
        position: DVec3,
        /// R, G, B.
        color: DVec3,
        /// Attenuation.
        attenuation: Attenuation,
    },
    /// A directional light.
    Dir {
        /// Direction in which the light travels.
        direction: DVec3,
        /// R, G, B.
        color: DVec3,
    },
    /// A spot light.
    Spot {
        /// World position.
        position: DVec3,
        /// Direction of the axis.
        direction: DVec3,
        /// Half angle of the cone in radians.
        angle_rad: f64,
        /// Exponent of the cosine falloff.
        exponent: f64,
        /// R, G, B.
        color: DVec3,
        /// Attenuation.
        attenuation: Attenuation,
    },
    /// Removes the light at this index.
    Off,
}

/// Six shear factors: xy, xz, yx, yz, zx, zy.
pub type Shears = [f64; 6];

/// Argument of `QUALITY`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quality {
    /// The exact pipeline.
    Exact,
    /// The cheapest settings whose 99.9th percentile of colour error stays within so many 1/255
    /// steps; with a shift, of the colours within so many pixels.
    MaxError(MaxError),
}

/// Destination of `SNAP`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SnapTarget {
    /// A file in the snapshot folder; its extension gives the format.
    File(String),
    /// A PNG sent on the connection.
    Connection,
}

impl From<Figure> for Command {
    fn from(figure: Figure) -> Self {
        Command::Figure(figure)
    }
}

impl From<Projection> for Command {
    fn from(projection: Projection) -> Self {
        Command::Projection(Box::new(projection))
    }
}

impl Figure {
    /// Returns the verb's name in the table.
    pub fn verb(&self) -> &'static str {
        Codec::verb(self)
    }
}

impl Command {
    /// Returns the verb's name in the table.
    pub fn verb(&self) -> &'static str {
        Codec::verb(self)
    }

    /// Returns the bytes that follow the command's line or header, or `None` for a command without
    /// payload.
    pub fn payload(&self) -> Option<&[u8]> {
        Codec::payload(self)
    }
}

/// Error reporting mode of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ErrorMode {
    /// Count errors; STATS reports the number.
    Count,
    /// Send one line per error.
    Report,
    /// Send the first error and close the connection.
    Close,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_payload_for_writing_is_the_payload() {
        let bytes = || b"abcdefgh".to_vec();
        let rect = Rect { x: 0, y: 0, w: 1, h: 2 };
        let mesh = |source| Command::Mesh { name: "m".into(), source: Box::new(source) };
        for mut command in [
            Command::PixelRun { x: 0, y: 0, rgba: bytes() },
            Command::Blit { rect, rgba: bytes() },
            Command::Points { packed: bytes() },
            Command::Figure(Figure::Text { x: 0, y: 0, color: [0; 4], utf8: bytes() }),
            Command::Texture { name: "t".into(), file: bytes() },
            Command::Scene { x3d: bytes() },
            Command::Eye { name: "e".into(), json: bytes() },
            mesh(MeshSource::Obj(bytes())),
        ] {
            assert_eq!(command.payload(), Some(&bytes()[..]), "{}", command.verb());
            assert_eq!(Codec::payload_mut(&mut command).cloned(), Some(bytes()), "{}", command.verb());
        }
        for mut command in [Command::Size, Command::Read { rect }, mesh(MeshSource::Teapot(3))] {
            assert_eq!(command.payload(), None);
            assert_eq!(Codec::payload_mut(&mut command), None);
        }
    }

    #[test]
    fn a_queued_command_stays_small() {
        assert!(size_of::<Command>() <= 88, "{} bytes", size_of::<Command>());
    }
}

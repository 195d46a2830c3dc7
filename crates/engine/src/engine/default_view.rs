//! The view of a connection that has set neither a camera nor a light: the first mesh that it draws,
//! framed, and lit from the eye.
//!
//! In: the mesh of the first `DRAW`, in object space. Out: a camera and a light that stay until
//! `CLEAR`, so that what the model matrix does to the mesh is seen. The mesh's bounding sphere, about
//! the centre of its bounding box, fills nine tenths of the frame's smaller side. One would know of
//! an error by a mesh that is cut, or that is still when its matrix turns. `LOOKAT`, a projection,
//! `WINDOW`, `AMBIENT`, `LIGHT` and `SCENE` end it for the connection: such streams are untouched.

use crate::Session;
use crate::session::DefaultView;
use fbptr_core::scene::{Camera, Light, LightKind, LookAt, Mesh, Projection};
use glam::DVec3;

/// Direction to the eye, from the right and above, and the angle of view in radians: 40 degrees.
const TO_EYE: DVec3 = DVec3::new(0.45, 0.3, 1.0);
const FOV_RAD: f64 = 0.698_131_700_797_731_8;
/// Part of the frame's smaller side that the sphere fills.
const FILL: f64 = 0.9;
/// Light from everywhere, beside that from the eye.
const AMBIENT: DVec3 = DVec3::splat(0.2);

/// Positions of a mesh from which a job finds its camera.
const MANY_POSITIONS: usize = 1 << 16;

/// Returns whether it takes long to find the camera for a mesh, which the connection needs.
pub(super) fn takes_long(s: &Session, mesh: &Mesh) -> bool {
    matches!(s.default_view, DefaultView::Unset) && mesh.positions.len() > MANY_POSITIONS
}

/// Returns the camera, the light and the ambient light for a mesh, if the connection has set none
/// of them. `found` is what [`frame`] returns of it, if that was computed.
pub(super) fn of(
    s: &mut Session,
    mesh: &Mesh,
    found: Option<Option<Camera>>,
) -> Option<(Camera, Light, DVec3)> {
    let camera = match &s.default_view {
        DefaultView::Framed(camera) => **camera,
        DefaultView::Unset => {
            let camera = found.unwrap_or_else(|| frame(mesh))?;
            s.default_view = DefaultView::Framed(Box::new(camera));
            camera
        }
        DefaultView::Own => return None,
    };
    let LookAt { eye, reference, .. } = camera.look_at;
    let light = Light {
        kind: LightKind::Directional { direction: reference - eye },
        color: DVec3::ONE,
        ambient: DVec3::ZERO,
        clamp_attenuation: false,
    };
    Some((camera, light, AMBIENT))
}

/// Returns the camera that frames a mesh, or `None` if it has no size that is finite.
pub(super) fn frame(mesh: &Mesh) -> Option<Camera> {
    let (low, high) = mesh.bounds()?;
    let center = low / 2.0 + high / 2.0;
    let radius = mesh.positions.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
    if !(center.is_finite() && radius.is_finite() && radius > 0.0) {
        return None;
    }
    let distance = radius / FILL / libm::sin(FOV_RAD / 2.0);
    let eye = center + TO_EYE / TO_EYE.length() * distance;
    let projection = Projection::Perspective {
        fov_rad: FOV_RAD,
        near: distance / 50.0,
        far: distance * 20.0,
        on_smaller_side: true,
    };
    let camera = Camera { look_at: LookAt { eye, reference: center, up: DVec3::Y }, projection };
    camera.matrices(1.0).is_ok().then_some(camera)
}

#[cfg(test)]
mod tests {
    use crate::{Audience, Budget, Engine, Output, Stream};

    /// Returns the picture of commands, and the `STATS` of their connection.
    fn drawn(commands: &str) -> (Vec<[u8; 4]>, String) {
        let mut engine = Engine::new(80, 60).unwrap();
        let mut stream = Stream::new(&engine, 1, Audience::Owner);
        let mut out = Output::default();
        let commands = format!("{commands}\nSTATS\n");
        let _ = stream.feed(&mut engine, commands.as_bytes(), &mut out, Budget::NONE);
        assert_eq!(out.notices, [], "{commands}");
        (engine.memory().bytes().as_chunks().0.to_vec(), String::from_utf8(out.replies).unwrap())
    }

    /// Returns the columns and rows that are not black: the first of them and the number.
    fn extent(pixels: &[[u8; 4]]) -> [usize; 4] {
        let lit = || (0..80 * 60).filter(|i| pixels[*i] != [0, 0, 0, 255]);
        let side = |of: fn(usize) -> usize| {
            (lit().map(of).min().unwrap_or(0), lit().map(of).max().map_or(0, |last| last + 1))
        };
        let ((x0, x1), (y0, y1)) = (side(|i| i % 80), side(|i| i / 80));
        [x0, y0, x1 - x0, y1 - y0]
    }

    #[test]
    fn a_mesh_without_a_view_is_framed_and_lit() {
        for source in ["SPHERE 1", "SPHERE 1e-6", "SPHERE 1e9"] {
            let (pixels, stats) = drawn(&format!("MESH m {source}\nDRAW m"));
            let [x, y, w, h] = extent(&pixels);
            // Nine tenths of 60 rows are 54.
            assert!((51..=56).contains(&w) && (51..=56).contains(&h), "{source}: {w} x {h}");
            assert!(x.abs_diff(80 - x - w) <= 2 && y.abs_diff(60 - y - h) <= 2, "{source}: {x} {y}");
            assert!(pixels[30 * 80 + 40][0] > 150, "{:?} is dark", pixels[30 * 80 + 40]);
            assert!(stats.contains(" view=default"), "{stats}");
        }
    }

    #[test]
    fn the_first_mesh_stays_framed_until_a_clear() {
        let first = drawn("MESH m BOX\nMESH n SPHERE 9\nDRAW m").0;
        let moved = drawn("MESH m BOX\nDRAW m\nFILLRECT 0 0 80 60 black\nTRANSLATE 1 0 0\nSCALE .5 .5 .5\nHIDE none\nDRAW m").0;
        assert!(extent(&moved)[2] < extent(&first)[2] && extent(&moved)[0] > extent(&first)[0]);
        let again = drawn("MESH m BOX\nMESH n SPHERE 9\nDRAW n\nCLEAR\nDRAW m").0;
        assert!(again == first, "CLEAR frames the next mesh anew");
    }

    #[test]
    fn a_connection_that_sets_a_view_is_untouched() {
        const LIGHT: &str = "LIGHT 0 DIR 0 0 -1 1 1 1";
        for setting in ["LOOKAT 0 0 4 0 0 0 0 1 0", "PERSPECTIVE 0.8 .1 100", "ORTHO -4 4 -3 3 .1 100"] {
            let (own, stats) = drawn(&format!("MESH m BOX\n{setting}\n{LIGHT}\nDRAW m"));
            let (other_order, _) = drawn(&format!("MESH m BOX\n{LIGHT}\n{setting}\nDRAW m"));
            assert!(own == other_order, "{setting}");
            assert!(stats.contains(" view=own"), "{stats}");
        }
        let (lit, stats) = drawn(&format!("MESH m BOX\n{LIGHT}\nDRAW m"));
        let (framed, _) = drawn("MESH m BOX\nDRAW m");
        assert!(lit != framed && stats.contains(" view=own"), "{stats}");
        let (unused, stats) = drawn("MESH m BOX");
        assert!(
            unused.iter().all(|pixel| *pixel == [0, 0, 0, 255]) && stats.contains(" view=unset"),
            "{stats}"
        );
    }
}

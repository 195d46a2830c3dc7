//! Box, Sphere, Cone and Cylinder: the meshes of `scene::shapes` at unit size (half sides of 1),
//! shared by all nodes of a type; the size is part of the object's matrix.

use super::super::graph::{GraphView, NodeId};
use super::Built;
use fbptr_core::scene::shapes::{self, RevolvedParts};
use glam::DVec3;

/// Builds a solid of unit size.
pub(super) fn build(view: &GraphView, id: NodeId) -> Built {
    let part = |field| view.bool(id, field);
    let mesh = match view.name(id) {
        "Box" => shapes::cuboid(DVec3::splat(2.0)),
        "Sphere" => shapes::sphere(1.0),
        "Cone" => {
            let parts = RevolvedParts { side: part("side"), bottom: part("bottom"), top: false };
            shapes::cone_parts(1.0, 2.0, parts)
        }
        _ => {
            let parts = RevolvedParts { side: part("side"), bottom: part("bottom"), top: part("top") };
            shapes::cylinder_parts(1.0, 2.0, parts)
        }
    };
    Built { mesh: mesh.expect("unit sizes are lengths"), ..Built::default() }
}

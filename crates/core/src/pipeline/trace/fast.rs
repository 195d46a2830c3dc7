//! The tile renderer's values of a traced triangle: screen vertices, and the depth and bytes that
//! it stores when drawn alone.

use crate::memory::{DepthFormat, Rgba, VideoMemory};
use crate::pipeline::draw_call::{Backend, DrawCall, Target};
use crate::pipeline::path_plan::plan_call;
use crate::pipeline::plan::Part;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::renderer::Renderer;
use crate::pipeline::tile::{ToScreen, screen_vertices_of};
use crate::scene::{Geometry, Mesh};
use crate::simd::Level;

/// Screen vertex of one corner, a record of 16 bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FastCorner {
    /// x and y on the screen in 1/65536 pixel, rounded down.
    pub position_fixed: [i32; 2],
    /// z, as f32.
    pub z: f32,
    /// 1/w, as f32; 0 if the record cannot represent the corner, and its faces are set up in f64.
    pub inverse_w: f32,
}

/// Values of the tile renderer for one triangle.
#[derive(Clone, Debug, PartialEq)]
pub struct FastTrace {
    /// Reason why the plain path draws it instead; `None` if the tile renderer does.
    pub unsupported_reason: Option<&'static str>,
    /// The corners' screen vertices.
    pub corners: [FastCorner; 3],
    /// Stored depth (if depth is used) and bytes of the pixel, with the triangle drawn alone;
    /// `None` if it does not change the pixel.
    pub stored: Option<(Option<f64>, Rgba)>,
}

/// Returns the tile renderer's values of `triangle` of the prepared draw, and of pixel `at`.
pub(super) fn fast(
    p: &PreparedDraw,
    triangle: u32,
    at: Option<[i32; 2]>,
    size: [u32; 2],
    format: DepthFormat,
) -> Option<FastTrace> {
    let mesh = &p.call.geometry.mesh;
    let to_screen: ToScreen = p.to_screen();
    let points = p.corners(triangle).map(|c| mesh.positions[c.position as usize].to_array());
    let corners = screen_vertices_of(Level::best(), &to_screen, points).map(|[x, y, z, w]| FastCorner {
        position_fixed: [x.to_bits() as i32, y.to_bits() as i32],
        z,
        inverse_w: w,
    });
    // The mesh with this triangle alone: all polygons stay, since normals depend on them.
    let alone = Geometry {
        mesh: Mesh {
            triangles: vec![mesh.triangles[triangle as usize]],
            triangle_polygon: vec![mesh.triangle_polygon[triangle as usize]],
            lines: Vec::new(),
            points: Vec::new(),
            ..mesh.clone()
        },
        textures: p.call.geometry.textures.clone(),
    };
    let call = DrawCall { geometry: &alone, shared: None, ..p.call.clone() };
    // Drawn over two colours: a pixel that keeps both was not written.
    let draw = |background: Rgba| {
        let mut memory = VideoMemory::new(size[0], size[1]).ok()?;
        memory.clear(background);
        let mut depth = None;
        let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
        Renderer::default().draw(&mut target, &call).ok()?;
        let [x, y] = at?;
        let pixel = memory.get_pixel(x, y).ok()?;
        Some((depth.and_then(|d| d.z(x, y)), pixel))
    };
    let reason = match p.parts.uses(Part::TileRenderer) {
        true => None,
        false => {
            let (mut memory, mut depth) = (VideoMemory::new(size[0], size[1]).ok()?, None);
            let target = Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: None };
            let info = Some(p.geometry_info.clone());
            Some(plan_call(p.call, &target, Backend::default(), true, info).item(Part::TileRenderer).reason)
        }
    };
    let (unsupported_reason, stored) = match (draw([0, 0, 0, 255]), draw([255; 4])) {
        (Some((_, [0, 0, 0, 255])), Some((_, [255, 255, 255, 255]))) => (reason, None),
        (Some((z, black)), Some(_)) => (reason, Some((z.filter(|z| *z < 1.0), black))),
        _ => (None, None),
    };
    Some(FastTrace { unsupported_reason, corners, stored })
}

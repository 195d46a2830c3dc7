//! Meshes that tile the frame, drawn by the renderer: who owns each pixel, and how many faces hit it.
//!
//! In: triangles in pixels, and the square of the frame. Out: for each pixel the number of faces
//! that the bytes of a half transparent drawing show, and the owner that those of an opaque one
//! name. Promise: nothing but the bytes of the frame is read.

use super::coverage::Corners;
use super::experiment::Effort;
use super::picture::BenchFrame;
use fbptr_core::math::coverage::PixelRect;
use fbptr_core::scene::{
    Camera, Corner, Cull, LightingModel, LookAt, Material, Mesh, NONE, Projection, Scene,
};
use fbptr_truth::scenes::object;
use glam::DVec3;

/// Number of faces that hit a pixel (2 for more), and the owner.
pub(super) type Hits = Vec<(u32, u32)>;

/// One mesh as two scenes: colours that name its faces, and white that is half transparent.
pub(super) struct DrawnMesh {
    named: Scene,
    counted: Scene,
    /// Frame of the first scene.
    owners: BenchFrame,
}

impl DrawnMesh {
    /// Creates the scenes under a parallel camera whose window is the square of the frame.
    pub fn new(effort: &Effort, triangles: &[Corners], clip: PixelRect) -> DrawnMesh {
        let window = [clip.x0, clip.x1, -clip.y1, -clip.y0].map(f64::from);
        let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
        let camera = Camera { look_at, projection: Projection::Ortho { window, near: 0.5, far: 9.5 } };
        let unlit = |emissive, transparency| Material {
            emissive,
            transparency,
            kd: DVec3::ZERO,
            model: LightingModel::Unlit,
            ..Material::default()
        };
        let scene = |mesh: Mesh| {
            let mut object = object("tiling", mesh);
            object.cull = Cull::None;
            Scene { camera: Some(camera), objects: vec![object], ..Scene::default() }
        };
        let mut named = Mesh::default();
        for (t, corners) in triangles.iter().enumerate() {
            let first = named.positions.len() as u32;
            named.positions.extend(corners.map(|[x, y]| DVec3::new(x, -y, -5.0)));
            let corner = |k| Corner { position: first + k, normal: NONE, texcoord: NONE, color: NONE };
            let [b, g, r, _] = (t as u32 + 1).to_le_bytes().map(|byte| f64::from(byte) / 255.0);
            named.materials.push(unlit(DVec3::new(r, g, b), 0.0));
            named.push_polygon(&[0, 1, 2].map(corner), t as u32);
        }
        let mut counted = named.clone();
        counted.materials = vec![unlit(DVec3::ONE, 0.5)];
        counted.polygons.iter_mut().for_each(|p| p.material = 0);
        let side = (clip.x1 - clip.x0) as u32;
        let owners = BenchFrame::new(effort.renderer(), side, side);
        DrawnMesh { named: scene(named), counted: scene(counted), owners }
    }

    /// Draws the scene whose colours name the faces.
    pub fn draw(&mut self) {
        self.owners.draw(&self.named);
    }

    /// Draws the other scene, after the first. Returns what the bytes of both tell.
    pub fn hits(&self, effort: &Effort) -> Hits {
        let memory = &self.owners.memory;
        let mut counts = BenchFrame::new(effort.renderer(), memory.width(), memory.height());
        counts.draw(&self.counted);
        let pairs = memory.bytes().chunks_exact(4).zip(counts.memory.bytes().chunks_exact(4));
        let hits = pairs.map(|(owner, count)| {
            let name = u32::from_le_bytes([owner[2], owner[1], owner[0], 0]);
            // White at 1/2 over black: 0, 128, 191 or more.
            let count = match count[0] {
                0 => 0,
                1..=140 => 1,
                _ => 2,
            };
            (count, name.wrapping_sub(1))
        });
        hits.collect()
    }
}

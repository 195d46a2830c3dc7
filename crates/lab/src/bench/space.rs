//! Workloads W1 to W5: a knot or 20 layers, drawn by the renderer.
//!
//! The scene: a torus knot (500x70 or 2000x250 steps), rotated by 0.3 about x after 0.4 about y;
//! the eye at (0, 0, 5.2) looks along -z with a field of view of 60 degrees, near 1, far 10; back
//! faces are culled, a smaller depth passes. A light at (3, 4, 5); colour = (0.8, 0.4, 0.2) (0.1 +
//! 0.7 max(N.L, 0)) + 0.5 max(R.V, 0)^32.

use super::check::Check;
use super::frame::SceneFrame;
use super::{BenchOptions, BenchRun, Workload};
use fbptr_core::math::matrix;
use fbptr_core::memory::{DepthMemory, VideoMemory};
use fbptr_core::pipeline::{self, DrawCall};
use fbptr_core::scene::{
    Camera, Corner, Cull, Filter, Fog, Geometry, HiddenSurface, Light, LookAt, Material, Mesh, NONE, Object,
    Projection, Sampling, Scene, ShadeMode, Texture, Wrap, shapes,
};
use fbptr_truth::{self as truth, TruthPicture};
use glam::{DMat4, DVec3, DVec4};
use std::sync::Arc;

const TEXTURE_SIDE: u32 = 1024;
const LAYERS: u32 = 20;

pub(super) struct Space {
    workload: Workload,
    on: SceneFrame,
    scene: Subject,
}

/// Scene and modes of a draw.
pub(super) struct Subject {
    pub geometry: Arc<Geometry>,
    material: Material,
    pub texture: Option<Arc<Texture>>,
    lights: Vec<Light>,
    model: DMat4,
    camera: Camera,
    shade: ShadeMode,
    filter: Filter,
    ambient: DVec3,
    fog: Option<Fog>,
}

impl Space {
    pub fn new(workload: Workload, options: &BenchOptions) -> Self {
        let size = options.size;
        Space {
            workload,
            on: SceneFrame::new(options, [size.width, size.height]),
            scene: Subject { fog: options.air.fog(), ..Subject::new(workload, size.divisor) },
        }
    }

    /// Returns the scene and modes.
    pub fn subject(&self) -> &Subject {
        &self.scene
    }

    /// Draws by the plain path and returns its picture and depths.
    fn plain(&self) -> (VideoMemory, Option<DepthMemory>) {
        let [width, height] = self.on.size();
        let call = DrawCall { shared: None, ..self.scene.call(width, height) };
        self.on.plain(|target| {
            pipeline::draw(target, &call).expect("the scene is sound");
        })
    }

    /// Renders some pixels by the reference.
    pub fn reference(&self, pixels: &[[u32; 2]]) -> TruthPicture {
        let mut picture = self.on.reference();
        let settings = truth::Settings { shade: self.scene.shade, ..truth::Settings::default() };
        picture.draw_at(&self.scene.as_scene(), &settings, Some(pixels)).expect("the camera is sound");
        picture
    }

    /// Draws a frame with texture coordinates shifted by some texels.
    #[cfg(test)]
    pub fn frame_shifted(&mut self, texels: f64) {
        let right = self.scene.geometry.mesh.texcoords.clone();
        let by = glam::DVec2::splat(texels / f64::from(TEXTURE_SIDE));
        Arc::make_mut(&mut self.scene.geometry).mesh.texcoords.iter_mut().for_each(|uv| *uv += by);
        self.frame();
        Arc::make_mut(&mut self.scene.geometry).mesh.texcoords = right;
    }

    /// Draws a frame and changes it in a way that [`BenchRun::check`] must detect.
    #[cfg(test)]
    pub fn frame_changed(&mut self, change: impl FnOnce(&mut VideoMemory, &mut DepthMemory)) {
        self.frame();
        change(&mut self.on.memory, self.on.depth.as_mut().expect("depth is kept"));
    }
}

impl BenchRun for Space {
    fn frame(&mut self) {
        let [width, height] = self.on.size();
        let call = self.scene.call(width, height);
        self.on.draw(|renderer, target| {
            renderer.draw(target, &call).expect("the scene is sound");
        });
    }

    fn bytes(&self) -> &[u8] {
        self.on.memory.bytes()
    }

    fn spoil(&mut self) {
        self.on.spoil();
    }

    fn truth(&mut self) -> VideoMemory {
        self.plain().0
    }

    fn check(&mut self) -> Check {
        self.on.check(self.workload, &self.plain(), |pixels| self.reference(pixels))
    }

    fn threads(&self) -> usize {
        self.on.threads()
    }

    fn simd(&self) -> &'static str {
        self.on.renderer.level().as_str()
    }
}

impl Subject {
    fn new(workload: Workload, divisor: u32) -> Self {
        let knot = |nu: u32, nv| {
            let mesh = shapes::knot((nu / divisor.max(1)).max(16), nv).expect("at most a million faces");
            Geometry { mesh, textures: Vec::new() }
        };
        let lit = Subject {
            geometry: Arc::default(),
            material: Material {
                ka: BASE * 0.1,
                kd: BASE * 0.7,
                ks: DVec3::splat(0.5),
                n: 32.0,
                ..Material::default()
            },
            texture: None,
            lights: vec![Light::point(DVec3::new(3.0, 4.0, 5.0), DVec3::ONE)],
            model: turn(DVec3::X, 0.3) * turn(DVec3::Y, 0.4),
            camera: Camera {
                look_at: look_from(5.2),
                projection: Projection::Perspective {
                    fov_rad: 60f64.to_radians(),
                    near: 1.0,
                    far: 10.0,
                    on_smaller_side: false,
                },
            },
            shade: ShadeMode::Phong,
            filter: Filter::default(),
            ambient: DVec3::ONE,
            fog: None,
        };
        // Shows its own colour: all of the ambient light, and no other.
        let unlit = Material { ka: DVec3::ONE, kd: DVec3::ZERO, ks: DVec3::ZERO, ..Material::default() };
        match workload {
            Workload::Phong1M => Subject { geometry: Arc::new(knot(2000, 250)), ..lit },
            Workload::Gouraud70k => {
                Subject { geometry: Arc::new(knot(500, 70)), shade: ShadeMode::Gouraud, ..lit }
            }
            Workload::Fill20 => Subject {
                geometry: Arc::new(Geometry { mesh: layers(), textures: Vec::new() }),
                material: unlit,
                lights: Vec::new(),
                model: DMat4::IDENTITY,
                // Distances 1 to 3 from an eye at z = 2: device z is -z of the world.
                camera: Camera {
                    look_at: look_from(2.0),
                    projection: Projection::Ortho { window: [-1.0, 1.0, -1.0, 1.0], near: 1.0, far: 3.0 },
                },
                shade: ShadeMode::Flat,
                ..lit
            },
            Workload::Textured(filter) => Subject {
                geometry: Arc::new(knot(500, 70)),
                material: unlit,
                texture: Some(Arc::new(texture())),
                lights: Vec::new(),
                shade: ShadeMode::Flat,
                filter,
                ..lit
            },
            _ => Subject { geometry: Arc::new(knot(500, 70)), ..lit },
        }
    }

    fn sampling(&self) -> Sampling {
        Sampling { filter: self.filter, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat }
    }

    /// Returns the subject as a scene.
    fn as_scene(&self) -> Scene {
        let object = Object {
            name: String::new(),
            geometry: self.geometry.clone(),
            model: self.model,
            material: self.material.clone(),
            back_material: None,
            cull: Cull::Back,
            two_sided_lighting: false,
            shade: None,
            texture: self.texture.clone().map(|t| (t, self.sampling())),
            lights: None,
            light_error: None,
            style: Default::default(),
        };
        Scene {
            camera: Some(self.camera),
            ambient: self.ambient,
            lights: self.lights.clone(),
            fog: self.fog,
            objects: vec![object],
            ..Scene::default()
        }
    }

    fn call(&self, width: u32, height: u32) -> DrawCall<'_> {
        DrawCall {
            model: self.model,
            camera: self.camera,
            ambient: self.ambient,
            lights: &self.lights,
            texture: self.texture.as_deref(),
            sampling: self.sampling(),
            shade: self.shade,
            cull: Cull::Back,
            hide: HiddenSurface::ZBuffer,
            fog: self.fog,
            // As a resource of a server: prepared once, drawn often.
            shared: Some(&self.geometry),
            ..DrawCall::new(&self.geometry, &self.material, width, height)
        }
    }
}

const BASE: DVec3 = DVec3::new(0.8, 0.4, 0.2);

fn turn(axis: DVec3, angle_rad: f64) -> DMat4 {
    matrix::rotate(axis, angle_rad).expect("an axis has a direction")
}

fn look_from(z: f64) -> LookAt {
    LookAt { eye: DVec3::new(0.0, 0.0, z), reference: DVec3::ZERO, up: DVec3::Y }
}

/// Returns full-screen quads of one colour each, far to near, at device z from 0.95 in steps of
/// -0.09.
fn layers() -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..LAYERS {
        let z = 0.09 * f64::from(i) - 0.95;
        let color = [i * 37, i * 91 + 40, i * 151 + 90].map(|c| f64::from(c % 256) / 255.0);
        mesh.colors.push(DVec4::new(color[0], color[1], color[2], 1.0));
        let first = mesh.positions.len() as u32;
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        mesh.positions.extend(corners.map(|(x, y)| DVec3::new(x, y, z)));
        let corner = |k| Corner { position: first + k, normal: NONE, texcoord: NONE, color: i };
        mesh.push_polygon(&[0, 1, 2, 3].map(corner), NONE);
    }
    mesh
}

/// Returns a texture of r = x ^ y, g = squares of 32 texels, b = 3 x + 5 y, row 0 at t = 0.
fn texture() -> Texture {
    let side = TEXTURE_SIDE;
    let texel = |x: u32, y: u32| {
        let square = if ((x >> 5) + (y >> 5)) & 1 == 1 { 224 } else { 64 };
        [(x ^ y) as u8, square, (3 * x + 5 * y) as u8, 255]
    };
    // The top row of a picture is t = 1.
    let bytes = (0..side).rev().flat_map(|y| (0..side).flat_map(move |x| texel(x, y))).collect();
    Texture::new(side, side, bytes).expect("a texture of ordinary size")
}

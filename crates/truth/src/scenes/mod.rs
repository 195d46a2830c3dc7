//! Random scenes from a seed, for property tests of renderers.
//!
//! All features of scenes occur: all projections, both viewport rules, faces through the eye plane,
//! slivers, mirrored models, all light kinds, textures of odd sizes, transparency, fog, n-gons, and
//! meshes with their own normals and colours. Equal seeds give equal scenes on every machine.

mod parts;

use super::{Settings, Transparency};
use fbptr_core::math::matrix;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Cull, Fog, FogKind, Geometry, HiddenSurface, Interpolation, Light, LookAt, Material,
    Mesh, NONE, Object, ObliqueKind, Projection, Scene, ShadeMode, TransparencyOrder, Viewport, ViewportRule,
};
use glam::{DMat4, DVec2, DVec3};
use parts::{random_light, random_object};
use std::sync::Arc;

/// Test case: a scene, its modes, and the size of the frame.
#[derive(Clone, Debug)]
pub struct Case {
    /// Name for messages.
    pub name: String,
    /// Scene, with a camera.
    pub scene: Scene,
    /// Modes of the draw.
    pub settings: Settings,
    /// Format of stored depths.
    pub format: DepthFormat,
    /// Width of the frame in pixels.
    pub width: u32,
    /// Height of the frame in pixels.
    pub height: u32,
}

/// Pseudorandom number generator SplitMix64: G. L. Steele, D. Lea, C. H. Flood, "Fast splittable
/// pseudorandom number generators", 2014.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Creates a generator from a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Returns a number in lo..hi.
    pub fn real(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Returns an integer in 0..n.
    pub fn below(&mut self, n: u32) -> u32 {
        (((self.bits() >> 32) * n as u64) >> 32) as u32
    }

    /// Returns true with probability 1/n.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    /// Returns a random element of a list.
    ///
    /// # Panics
    /// If the list is empty.
    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }

    /// Returns a point of the cube lo..hi.
    pub fn point(&mut self, lo: f64, hi: f64) -> DVec3 {
        DVec3::new(self.real(lo, hi), self.real(lo, hi), self.real(lo, hi))
    }
}

/// Returns one lit triangle in front of the default camera: the smallest scene that uses all
/// stages.
pub fn lit_triangle() -> Scene {
    let positions = vec![DVec3::new(-1.5, -1.0, 0.0), DVec3::new(1.5, -1.2, 0.3), DVec3::new(0.0, 1.4, -0.2)];
    let mesh = Mesh::from_triangles(positions, &[[0, 1, 2]]);
    let light = Light::directional(DVec3::new(-0.3, -0.4, -1.0), DVec3::new(1.0, 0.9, 0.8));
    Scene {
        camera: Some(Camera::default()),
        lights: vec![light],
        objects: vec![object("triangle", mesh)],
        ..Scene::default()
    }
}

/// Returns an object of default material with the identity as model matrix and back faces culled.
pub fn object(name: &str, mesh: Mesh) -> Object {
    Object {
        name: name.into(),
        geometry: Arc::new(Geometry { mesh, textures: Vec::new() }),
        model: DMat4::IDENTITY,
        material: Material::default(),
        back_material: None,
        cull: Cull::Back,
        two_sided_lighting: false,
        shade: None,
        texture: None,
        lights: None,
        light_error: None,
        style: Default::default(),
    }
}

/// Returns a box of half size `h` of quads, with outward faces and texture coordinates over each
/// side.
pub fn box_mesh(h: DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    for i in 0..8 {
        let side = |bit: u32| if i & bit != 0 { 1.0 } else { -1.0 };
        mesh.positions.push(DVec3::new(side(1), side(2), side(4)) * h);
    }
    mesh.texcoords = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from_array).to_vec();
    for quad in [[4, 5, 7, 6], [1, 0, 2, 3], [5, 1, 3, 7], [0, 4, 6, 2], [6, 7, 3, 2], [0, 1, 5, 4]] {
        let corners = [0, 1, 2, 3].map(|k| corner(quad[k], k as u32));
        mesh.push_polygon(&corners, NONE);
    }
    mesh
}

/// Returns a height field of n x n quads over [-1,1]^2 in x and z, facing +y, with texture
/// coordinates 0..`repeats`.
pub fn terrain(n: u32, repeats: f64, mut height: impl FnMut() -> f64) -> Mesh {
    let mut mesh = Mesh::default();
    let at = |k: u32| 2.0 * k as f64 / n as f64 - 1.0;
    for j in 0..=n {
        for i in 0..=n {
            mesh.positions.push(DVec3::new(at(i), height(), at(j)));
            mesh.texcoords.push(DVec2::new(i as f64, j as f64) * (repeats / n as f64));
        }
    }
    for j in 0..n {
        for i in 0..n {
            let k = j * (n + 1) + i;
            let corners = [k, k + n + 1, k + n + 2, k + 1].map(|p| corner(p, p));
            mesh.push_polygon(&corners, NONE);
        }
    }
    mesh
}

fn corner(position: u32, texcoord: u32) -> Corner {
    Corner { position, normal: NONE, texcoord, color: NONE }
}

/// Returns a random test case with all features.
pub fn random(seed: u64) -> Case {
    let mut r = Random::new(seed);
    let (width, height) = (24 + r.below(41), 24 + r.below(41));
    let camera = random_camera(&mut r);
    let lights: Vec<Light> = (0..1 + r.below(4)).map(|_| random_light(&mut r)).collect();
    let objects = (0..1 + r.below(4)).map(|i| random_object(&mut r, i, lights.len() as u32)).collect();
    let scene = Scene {
        camera: Some(camera),
        ambient: if r.one_in(3) { DVec3::ZERO } else { r.point(0.1, 0.6) },
        lights,
        objects,
        background: fbptr_core::scene::Background { color: r.one_in(4).then(|| r.point(0.0, 1.0)) },
        sky: None,
        fog: r.one_in(6).then(|| Fog {
            color: r.point(0.0, 1.0),
            kind: r.pick(&[FogKind::Linear, FogKind::Exponential]),
            visibility_range: r.real(3.0, 15.0),
        }),
    };
    let viewport = r.one_in(3).then(|| Viewport {
        x: r.below(20) as i32 - 10,
        y: r.below(20) as i32 - 10,
        width: 20 + r.below(50),
        height: 20 + r.below(50),
        rule: r.pick(&[ViewportRule::Corners, ViewportRule::Centres]),
    });
    let settings = Settings {
        viewport,
        shade: r.pick(&[ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong, ShadeMode::Phong]),
        hide: r.pick(&[
            HiddenSurface::ZBuffer,
            HiddenSurface::ZBuffer,
            HiddenSurface::ZBuffer,
            HiddenSurface::Painter,
            HiddenSurface::None,
        ]),
        interpolation: if r.one_in(6) { Interpolation::Affine } else { Interpolation::Perspective },
        cull: None,
        transparency: r.pick(&[
            Transparency::AtOnce,
            Transparency::AfterOpaque(TransparencyOrder::FileOrder),
            Transparency::AfterOpaque(TransparencyOrder::Sorted),
        ]),
    };
    let format = r.pick(&DepthFormat::ALL);
    let mut scene = scene;
    if settings.transparency == Transparency::AtOnce {
        // A DRAW of a stream has no background.
        scene.background = fbptr_core::scene::Background::default();
    }
    Case { name: format!("random scene {seed}"), scene, settings, format, width, height }
}

/// Returns a camera at a distance of 4..8 from the origin that looks near it.
pub fn random_camera(r: &mut Random) -> Camera {
    let away = matrix::unit(r.point(-1.0, 1.0)).unwrap_or(DVec3::Z) * r.real(4.0, 8.0);
    let up = if away.y.abs() > 0.95 * away.length() { DVec3::X } else { DVec3::Y };
    let look_at = LookAt { eye: away, reference: r.point(-0.5, 0.5), up: up + r.point(-0.2, 0.2) };
    let (near, far) = (r.pick(&[0.01, 0.1, 1.0, 3.0]), r.pick(&[9.0, 20.0, 1000.0]));
    let size = r.real(1.2, 3.0);
    let window = [-size, size * r.real(0.8, 1.2), -size, size * r.real(0.8, 1.2)];
    let at_near = window.map(|v| v * near / 6.0);
    let projection = match r.below(12) {
        0..5 => {
            Projection::Perspective { fov_rad: r.real(0.3, 1.3), near, far, on_smaller_side: r.one_in(2) }
        }
        5 => Projection::Plane { d: r.real(0.5, 3.0), near, far },
        6 => Projection::Frustum { window: at_near, near, far },
        7 => Projection::Ortho { window, near, far },
        8 => {
            let kind = r.pick(&[ObliqueKind::Cavalier, ObliqueKind::Cabinet]);
            Projection::Oblique { kind, angle_rad: r.real(0.2, 1.4), window, near, far }
        }
        9 => {
            // The rotations are about the eye: the window is moved to the scene's place after them.
            let [x, y] = [away.length() * 0.5f64.sqrt(), away.length() * (1.0f64 / 6.0).sqrt()];
            let window = [window[0] + x, window[1] + x, window[2] + y, window[3] + y];
            Projection::Isometric { window, near: -5.0, far }
        }
        10 => {
            let k = 1.5f64.sqrt();
            let [x, y] = [k * away.length() * 0.5f64.sqrt(), k * away.length() * (1.0f64 / 6.0).sqrt()];
            let window = [window[0] + x, window[1] + x, window[2] + y, window[3] + y];
            Projection::PseudoIsometric { window, near: -5.0, far }
        }
        _ => Projection::Window {
            vrp: away,
            p: look_at.reference,
            vup: look_at.up,
            center: [r.real(-0.2, 0.2), r.real(-0.2, 0.2)],
            half: [r.real(0.3, 1.0), r.real(0.3, 1.0)],
            dp: r.real(0.5, 2.0),
            near,
            far,
        },
    };
    Camera { look_at, projection }
}

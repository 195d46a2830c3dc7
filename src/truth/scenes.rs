//! Scenes to hold renderers to: random ones from a seed, for property tests.
//!
//! Everything that a scene can hold occurs: all projections, both viewport rules, faces through the eye plane, slivers,
//! mirrored models, all light kinds, textures of odd sizes, transparency, fog, n-gons, normals and colours of the file's own.
//! The same seed gives the same scene on every machine.

use super::{Settings, Transparency};
use crate::math::matrix;
use crate::memory::DepthFormat;
use crate::scene::{
    Attenuation, Camera, Corner, Cull, Filter, Fog, FogKind, Geometry, HiddenSurface, Interpolation, Light,
    LightKind, LightingModel, LookAt, Material, Mesh, NONE, Object, ObliqueKind, Projection, Sampling, Scene,
    ShadeMode, Texture, TransparencyOrder, Viewport, ViewportRule, Wrap,
};
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::sync::Arc;

/// A picture to be made: a scene, its modes, and the size of the frame.
#[derive(Clone, Debug)]
pub struct Case {
    /// What it is, for messages.
    pub name: String,
    /// The scene; its camera is given.
    pub scene: Scene,
    /// The modes.
    pub settings: Settings,
    /// How depth is stored.
    pub format: DepthFormat,
    /// Frame width in pixels.
    pub width: u32,
    /// Frame height in pixels.
    pub height: u32,
}

/// A small generator of random numbers: G. L. Steele, D. Lea, C. H. Flood, "Fast splittable pseudorandom number
/// generators", 2014 (SplitMix64).
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// A generator from a seed.
    pub fn new(seed: u64) -> Random {
        Random(seed)
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number in lo..hi.
    pub fn real(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// A whole number in 0..n.
    pub fn below(&mut self, n: u32) -> u32 {
        (((self.bits() >> 32) * n as u64) >> 32) as u32
    }

    /// True once in n times.
    pub fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    /// One of a list.
    pub fn pick<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }

    /// A point of the cube lo..hi.
    pub fn point(&mut self, lo: f64, hi: f64) -> DVec3 {
        DVec3::new(self.real(lo, hi), self.real(lo, hi), self.real(lo, hi))
    }
}

/// One lit triangle in front of the default camera: the smallest scene with all stages.
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

/// An object with default material, in object space = world space, culled at the back.
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
    }
}

/// A box of half size `h` with quads, outward faces, and texture coordinates over each side.
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

/// A height field of n x n quads over [-1,1]^2 in x and z, facing +y, texture coordinates 0..`repeats`.
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

/// A random scene, with everything.
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
        background: crate::scene::Background { color: r.one_in(4).then(|| r.point(0.0, 1.0)) },
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
        // A stream's DRAW brings no background.
        scene.background = crate::scene::Background::default();
    }
    Case { name: format!("random scene {seed}"), scene, settings, format, width, height }
}

/// A camera at some distance 4..8 from the origin that looks near it.
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
            // The turns are about the eye: the window is moved to where the scene comes to lie.
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

fn random_light(r: &mut Random) -> Light {
    let position = r.point(-5.0, 5.0);
    let direction = r.point(-1.0, 1.0);
    let attenuation = r.pick(&[
        Attenuation::NONE,
        Attenuation { c: 0.5, l: 0.1, q: 0.02 },
        Attenuation { c: 0.0, l: 0.0, q: 0.1 },
    ]);
    let radius = if r.one_in(4) { r.real(2.0, 8.0) } else { f64::INFINITY };
    let kind = match r.below(4) {
        0 => LightKind::Directional { direction },
        1 => LightKind::Point { position, attenuation, radius },
        2 => LightKind::Spot {
            position,
            direction: -position + r.point(-1.0, 1.0),
            angle_rad: r.real(0.1, 1.0),
            exponent: r.pick(&[0.0, 1.0, 10.0]),
            attenuation,
        },
        _ => LightKind::X3dSpot {
            position,
            direction: -position + r.point(-1.0, 1.0),
            beam_width_rad: r.real(0.05, 0.8),
            cut_off_rad: r.real(0.1, 0.8),
            attenuation,
            radius,
        },
    };
    let color = r.point(0.2, 1.6);
    let ambient = if r.one_in(3) { color * 0.2 } else { DVec3::ZERO };
    Light { kind, color, ambient, clamp_attenuation: r.one_in(2) }
}

fn random_material(r: &mut Random) -> Material {
    let model =
        r.pick(&[LightingModel::Phong, LightingModel::Phong, LightingModel::Blinn, LightingModel::Unlit]);
    Material {
        ka: r.point(0.0, 1.0),
        kd: r.point(0.0, 1.0),
        ks: if r.one_in(2) { r.point(0.0, 0.8) } else { DVec3::ZERO },
        n: r.pick(&[0.0, 1.0, 5.0, 32.0, 128.0, 1000.0]),
        emissive: if model == LightingModel::Unlit || r.one_in(3) { r.point(0.0, 0.9) } else { DVec3::ZERO },
        transparency: if r.one_in(4) { r.real(0.0, 1.0) } else { 0.0 },
        model: r.pick(&[
            LightingModel::Phong,
            LightingModel::Phong,
            LightingModel::Blinn,
            LightingModel::Unlit,
        ]),
        texture: None,
        name: String::new(),
    }
}

fn random_texture(r: &mut Random) -> (Arc<Texture>, Sampling) {
    let (width, height) = (r.pick(&[1, 2, 5, 16, 33]), r.pick(&[1, 3, 8, 16, 20]));
    let see_through = r.one_in(4);
    let bytes: Vec<u8> = (0..width * height)
        .flat_map(|_| {
            let b = r.bits().to_le_bytes();
            [b[0], b[1], b[2], if see_through { b[3] } else { 255 }]
        })
        .collect();
    let texture = Texture::new(width, height, bytes).expect("sides of 1 to 33 and as many bytes");
    let wrap = [Wrap::Repeat, Wrap::Clamp];
    let sampling = Sampling { filter: r.pick(Filter::ALL), wrap_s: r.pick(&wrap), wrap_t: r.pick(&wrap) };
    (Arc::new(texture), sampling)
}

/// Faces of all sorts, in about [-2,2]^3.
fn random_mesh(r: &mut Random) -> Mesh {
    match r.below(6) {
        0 => box_mesh(r.point(0.3, 1.5)),
        1 => {
            let n = 2 + r.below(6);
            let mut dice = r.clone();
            let mut mesh = terrain(n, r.real(0.5, 8.0), || dice.real(-0.4, 0.4));
            mesh.positions.iter_mut().for_each(|p| *p *= 2.0);
            mesh
        }
        2 => triangle_soup(r, 12, 2.0),
        // Through the eye plane and far behind it.
        3 => triangle_soup(r, 6, 15.0),
        4 => slivers(r),
        _ => star(r),
    }
}

/// Separate triangles with texture coordinates, some with normals and colours of their own.
fn triangle_soup(r: &mut Random, count: u32, reach: f64) -> Mesh {
    let mut mesh = Mesh::default();
    let (normals, colors) = (r.one_in(3), r.one_in(3));
    for _ in 0..count {
        let corners: [Corner; 3] = std::array::from_fn(|_| {
            let i = mesh.positions.len() as u32;
            mesh.positions.push(r.point(-reach, reach));
            mesh.texcoords.push(DVec2::new(r.real(-2.0, 3.0), r.real(-2.0, 3.0)));
            mesh.normals.push(r.point(-1.0, 1.0));
            mesh.colors.push(r.point(0.0, 1.3).extend(1.0));
            let or_none = |on: bool| if on { i } else { NONE };
            Corner { position: i, normal: or_none(normals), texcoord: i, color: or_none(colors) }
        });
        mesh.push_polygon(&corners, NONE);
    }
    mesh
}

/// Triangles as thin as 1e-6 of their length, and fans of them with shared edges.
fn slivers(r: &mut Random) -> Mesh {
    let mut positions = vec![r.point(-1.5, 1.5)];
    let (a, mut b) = (r.point(-2.0, 2.0), r.point(-2.0, 2.0));
    let mut triangles = Vec::new();
    for i in 0..10u32 {
        positions.push(b);
        let thin = r.pick(&[1e-1, 1e-2, 1e-3, 1e-6]);
        b += (a - b) * thin;
        if i > 0 {
            triangles.push([0, i, i + 1]);
        }
    }
    Mesh::from_triangles(positions, &triangles)
}

/// A concave star polygon in a tilted plane.
fn star(r: &mut Random) -> Mesh {
    let mut mesh = Mesh::default();
    let tilt = r.point(-0.5, 0.5);
    let points = 4 + r.below(4);
    let corners: Vec<Corner> = (0..2 * points)
        .map(|i| {
            let (sin, cos) = libm::sincos(std::f64::consts::PI * i as f64 / points as f64);
            let radius = if i % 2 == 0 { 1.8 } else { 0.7 };
            let (x, y) = (radius * cos, radius * sin);
            mesh.positions.push(DVec3::new(x, y, tilt.x * x + tilt.y * y + tilt.z));
            mesh.texcoords.push(DVec2::new(x, y));
            mesh.colors.push(DVec4::new(cos.abs(), sin.abs(), 1.0, 1.0));
            Corner { position: i, normal: NONE, texcoord: i, color: i }
        })
        .collect();
    mesh.push_polygon(&corners, NONE);
    mesh
}

fn random_object(r: &mut Random, index: u32, lights: u32) -> Object {
    let mesh = random_mesh(r);
    let turn = matrix::rotate(r.point(-1.0, 1.0), r.real(0.0, 6.0)).unwrap_or(DMat4::IDENTITY);
    let mut size = r.point(0.6, 1.6);
    if r.one_in(4) {
        size.x = -size.x;
    }
    let mut model = matrix::translate(r.point(-1.0, 1.0)) * turn * matrix::scale(size);
    if r.one_in(5) {
        model *= matrix::shear(r.real(-0.5, 0.5), 0.0, 0.2, 0.0, r.real(-0.5, 0.5), 0.1);
    }
    Object {
        model,
        material: random_material(r),
        back_material: r.one_in(6).then(|| random_material(r)),
        cull: r.pick(&[Cull::Back, Cull::Back, Cull::None, Cull::None, Cull::Front]),
        two_sided_lighting: r.one_in(3),
        shade: r.one_in(5).then(|| r.pick(&[ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong])),
        texture: r.one_in(3).then(|| random_texture(r)),
        lights: (lights > 0 && r.one_in(5)).then(|| (0..lights).filter(|i| i % 2 == 0).collect()),
        ..object(&format!("object {index}"), mesh)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_one_scene_and_scenes_show_something() {
        assert_eq!(format!("{:?}", random(5)), format!("{:?}", random(5)));
        let mut drawn = 0;
        for seed in 0..30 {
            let case = random(seed);
            let truth =
                crate::truth::render(&case.scene, case.width, case.height, case.format, &case.settings)
                    .unwrap();
            let pixels = case.width * case.height;
            let seen = (0..pixels)
                .filter(|i| truth.states(i % case.width, i / case.width).iter().any(|s| s.drawn.is_some()));
            drawn += u32::from(seen.count() as u32 > pixels / 20);
        }
        assert!(drawn > 15, "only {drawn} of 30 random scenes show something");
    }
}

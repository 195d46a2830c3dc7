//! Hard cases as the conformance suites of Vulkan and OpenGL ES have them: borders of tiles and
//! frames, ties, seams, exhaustive blending, extremes of lights, angles and scales.

use super::{case, colored, ortho, triangles, v, with_camera};
use crate::scenes::{Case, box_mesh, object};
use fbptr_core::math::matrix;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{
    Camera, Corner, Cull, Filter, HiddenSurface, Light, LightingModel, LookAt, Material, Mesh, NONE, Object,
    Projection, Sampling, ShadeMode, Texture, Wrap,
};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// Appends all of them.
pub(super) fn all(cases: &mut Vec<Case>) {
    borders(cases);
    frames(cases);
    depth_ties(cases);
    blending(cases);
    seams(cases);
    lighting(cases);
    views(cases);
}

/// Returns the case on a frame of this size, whose pixels are the units of x and y, y up from the
/// lower left corner.
fn in_pixels(name: &str, [width, height]: [u32; 2], objects: Vec<Object>) -> Case {
    let window = [0.0, f64::from(width), 0.0, f64::from(height)];
    let look_at = LookAt { eye: DVec3::ZERO, reference: DVec3::NEG_Z, up: DVec3::Y };
    let projection = Projection::Ortho { window, near: 0.0, far: 8.0 };
    Case { width, height, ..with_camera(case(name, objects), look_at, projection) }
}

fn glowing(name: &str, positions: &[DVec3], faces: &[[u32; 3]], color: DVec3) -> Object {
    colored(triangles(name, positions, faces), color)
}

/// Returns a rectangle at depth z with texture coordinates from `low` to `high`.
fn card(name: &str, [x0, y0, x1, y1]: [f64; 4], z: f64, [low, high]: [[f64; 2]; 2]) -> Object {
    let mut mesh = Mesh {
        positions: vec![v(x0, y0, z), v(x1, y0, z), v(x1, y1, z), v(x0, y1, z)],
        texcoords: [low, [high[0], low[1]], high, [low[0], high[1]]].map(DVec2::from_array).to_vec(),
        ..Mesh::default()
    };
    let corner = |k| Corner { position: k, normal: NONE, texcoord: k, color: NONE };
    mesh.push_polygon(&[0, 1, 2, 3].map(corner), NONE);
    let mut o = colored(object(name, mesh), DVec3::ONE);
    o.cull = Cull::None;
    o
}

fn borders(cases: &mut Vec<Case>) {
    let size = [200, 150];
    let green = v(0.2, 0.8, 0.3);
    // Corners on pixel centres and on the borders of tiles of 16 to 128 pixels.
    for (name, off) in [("on", 0.0), ("at the centres beside", 0.5), ("1/256 pixel off", 1.0 / 256.0)] {
        let corners: Vec<DVec3> = [16.0, 32.0, 64.0, 128.0]
            .iter()
            .flat_map(|&b| {
                [v(b + off, b - off, -4.0), v(b + 16.0 + off, b + off, -4.0), v(b, b + 16.0, -4.0)]
            })
            .collect();
        let faces: Vec<[u32; 3]> = (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let o = glowing("corners", &corners, &faces, green);
        cases.push(in_pixels(&format!("corners {name} the borders of tiles"), size, vec![o]));
    }
    for reach in [32_768.0, 1_048_576.0, 16_777_216.0] {
        let p = [v(-reach, 10.3, -2.0), v(reach, 60.7, -6.0), v(37.1, reach, -4.0), v(150.0, -reach, -4.0)];
        let o = glowing("long", &p, &[[0, 1, 2], [0, 3, 1]], green);
        cases.push(in_pixels(
            &format!("faces that reach {reach} pixels, past every guard band"),
            size,
            vec![o],
        ));
    }
    let [w, h] = size.map(f64::from);
    let positions = vec![
        v(0.5, 0.5, -4.0),
        v(w - 0.5, 0.5, -4.0),
        v(w - 0.5, h - 0.5, -4.0),
        v(0.5, h - 0.5, -4.0),
        v(-40.0, 75.5, -4.0),
        v(w + 40.0, 75.5, -4.0),
        v(64.5, -30.0, -4.0),
        v(64.5, h + 30.0, -4.0),
        v(-20.0, -35.0, -4.0),
        v(w + 20.0, h + 35.0, -4.0),
    ];
    let mut lines = Mesh { positions, ..Mesh::default() };
    lines.corners =
        (0..10).map(|position| Corner { position, normal: NONE, texcoord: NONE, color: NONE }).collect();
    lines.lines = vec![[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [6, 7], [8, 9]];
    let mut points = lines.clone();
    points.lines.clear();
    points.points = (0..10).collect();
    for (name, mesh) in [("lines", lines), ("points", points)] {
        let o = colored(object(name, mesh), v(1.0, 0.6, 0.1));
        cases.push(in_pixels(&format!("{name} along and across the frame's borders"), size, vec![o]));
    }
    let p = [v(-30.5, 20.5, -4.0), v(w + 30.5, 20.5, -4.0), v(100.5, h + 50.5, -4.0)];
    let mut wire =
        in_pixels("a wireframe across the borders", size, vec![glowing("wire", &p, &[[0, 1, 2]], green)]);
    wire.settings.shade = ShadeMode::Wire;
    // The truth has no depths of edges.
    wire.settings.hide = HiddenSurface::None;
    cases.push(wire);
}

fn frames(cases: &mut Vec<Case>) {
    for size in [[1, 37], [53, 1], [1, 1], [4_100, 3], [3, 4_100], [8_200, 2], [2, 8_200]] {
        let [w, h] = size.map(f64::from);
        let p = [v(-1.0, -1.0, -2.0), v(1.5 * w, 0.2 * h, -6.0), v(0.1 * w, 1.7 * h, -4.0)];
        let mut face = triangles("face", &p, &[[0, 1, 2]]);
        face.material.ks = DVec3::splat(0.4);
        cases.push(in_pixels(&format!("a frame of {}x{}", size[0], size[1]), size, vec![face]));
    }
}

fn depth_ties(cases: &mut Vec<Case>) {
    let (red, blue) = (v(1.0, 0.2, 0.1), v(0.1, 0.3, 1.0));
    let p = [v(-1.5, -1.0, -1.0), v(1.5, -1.0, 1.0), v(0.0, 1.4, 0.1)];
    for format in DepthFormat::ALL {
        let both = vec![glowing("first", &p, &[[0, 1, 2]], red), glowing("second", &p, &[[0, 1, 2]], blue)];
        let name = format!("two draws of one face in {}: the first stays", format.as_str());
        cases.push(Case { format, ..case(&name, both) });
        let steps = match format {
            DepthFormat::U16 => 65_535.0,
            DepthFormat::U24 => 16_777_215.0,
            DepthFormat::U32 => 4_294_967_295.0,
            DepthFormat::F32 | DepthFormat::Reversed => 16_777_216.0,
        };
        // z = -depth / 8 in front of the parallel camera: halfway between two stored values.
        let cards = [0.25, 0.5, 0.75].iter().enumerate().map(|(i, part): (usize, &f64)| {
            let z = ((part * steps).floor() + 0.5) / steps;
            let x = 16.0 * i as f64;
            colored(card("tie", [x, 0.0, x + 16.0, 36.0], -8.0 * z, [[0.0; 2], [1.0; 2]]), red)
        });
        let name = format!("depths halfway between two values of {}", format.as_str());
        cases.push(Case { format, ..in_pixels(&name, [48, 36], cards.collect()) });
    }
}

/// Texture of 256 x 256 texels, value along x and opacity along y, over two backgrounds.
fn blending(cases: &mut Vec<Case>) {
    let bytes = (0..65_536u32).flat_map(|i| {
        let (value, alpha) = ((i % 256) as u8, (i / 256) as u8);
        [value, 255 - value, 128, alpha]
    });
    let texture = Arc::new(Texture::new(256, 256, bytes.collect()).expect("256 x 256 texels"));
    let sampling = Sampling { filter: Filter::Nearest, wrap_s: Wrap::Clamp, wrap_t: Wrap::Clamp };
    let wall = colored(
        card("wall", [0.0, 0.0, 256.0, 256.0], -6.0, [[0.0; 2], [1.0; 2]]),
        v(77.0 / 255.0, 200.0 / 255.0, 1.0),
    );
    let mut glass = card("glass", [0.0, 0.0, 256.0, 256.0], -4.0, [[0.0; 2], [1.0; 2]]);
    glass.texture = Some((texture, sampling));
    cases.push(in_pixels(
        "every value at every opacity, 256x256, over a wall",
        [256, 256],
        vec![wall, glass],
    ));
}

fn noise(width: u32, height: u32) -> Arc<Texture> {
    let texel = |i: u32| [(i * 97 % 256) as u8, (i * 57 % 251) as u8, (i * 31 % 241) as u8, 255];
    let bytes = (0..width * height).flat_map(texel).collect();
    Arc::new(Texture::new(width, height, bytes).expect("at most 16,384 texels a side"))
}

fn seams(cases: &mut Vec<Case>) {
    for &filter in Filter::ALL {
        for (wrap_s, wrap_t) in [(Wrap::Repeat, Wrap::Clamp), (Wrap::Clamp, Wrap::Repeat)] {
            // The seams at 0 and 1, 10 pixels a texel.
            let mut o = card("seams", [0.0, 0.0, 100.0, 60.0], -4.0, [[-0.5, -0.5], [1.5, 1.5]]);
            o.texture = Some((noise(5, 3), Sampling { filter, wrap_s, wrap_t }));
            let name = format!("seams under {wrap_s:?} and {wrap_t:?}, {}", filter.as_str());
            cases.push(in_pixels(&name, [100, 60], vec![o]));
        }
        let mut wide = card("wide", [0.0, 0.0, 96.0, 8.0], -4.0, [[0.4990, 0.0], [0.5010, 1.0]]);
        let sampling = Sampling { filter, wrap_s: Wrap::Repeat, wrap_t: Wrap::Clamp };
        wide.texture = Some((noise(16_384, 1), sampling));
        cases.push(in_pixels(
            &format!("a texture 16384 texels wide, {}", filter.as_str()),
            [96, 8],
            vec![wide],
        ));
        // One texel a pixel: D = log2 1 = 0.
        let mut exact =
            card("one to one", [0.0, 0.0, 48.0, 36.0], -4.0, [[0.0; 2], [48.0 / 64.0, 36.0 / 64.0]]);
        exact.texture =
            Some((noise(64, 64), Sampling { filter, wrap_s: Wrap::Repeat, wrap_t: Wrap::Repeat }));
        cases.push(in_pixels(
            &format!("a mip level of exactly 0, {}", filter.as_str()),
            [48, 36],
            vec![exact],
        ));
    }
}

fn lighting(cases: &mut Vec<Case>) {
    let ball = |material: Material| {
        let mut o = object("ball", fbptr_core::scene::shapes::sphere(1.5).expect("a sphere of radius 1.5"));
        o.material = material;
        o
    };
    for n in [0.0, 1.0, 1000.0, 1001.0] {
        let material = Material { ks: DVec3::splat(0.9), n, ..Material::default() };
        cases.push(case(&format!("a ball with a highlight of exponent {n}"), vec![ball(material)]));
    }
    // A white ambient floor under a lit ball: the terminator lies where N.L changes its sign.
    for shade in [ShadeMode::Gouraud, ShadeMode::Phong] {
        let white =
            Material { ka: DVec3::ONE, kd: DVec3::ONE, ks: DVec3::ONE, n: 1.0, ..Material::default() };
        let mut c = case(&format!("a terminator over white, {}", shade.as_str()), vec![ball(white)]);
        c.scene.lights = vec![Light::directional(DVec3::NEG_X, DVec3::ONE)];
        c.scene.ambient = DVec3::splat(0.9);
        c.settings.shade = shade;
        cases.push(c);
    }
    for count in [63, 64, 65, 130] {
        let material = Material { ks: DVec3::splat(0.5), n: 20.0, ..Material::default() };
        let mut c = case(&format!("{count} lights"), vec![ball(material)]);
        let light = |i: u32| {
            let (sin, cos) = libm::sincos(f64::from(i));
            Light::directional(v(cos, sin, -1.0), DVec3::splat(1.0 / f64::from(count)))
        };
        c.scene.lights = (0..count).map(light).collect();
        cases.push(c);
    }
}

fn views(cases: &mut Vec<Case>) {
    let look_at = Camera::default().look_at;
    for degrees in [1e-6, 179.99] {
        let fov_rad = f64::to_radians(degrees);
        let size = 5.0 * libm::tan(fov_rad / 2.0);
        let p = [v(-1.2, -0.7, 0.0) * size, v(1.0, -0.9, 0.0) * size, v(0.2, 0.8, 0.0) * size];
        let projection = Projection::Perspective { fov_rad, near: 0.1, far: 100.0, on_smaller_side: false };
        let face = glowing("face", &p, &[[0, 1, 2]], v(0.3, 0.9, 0.5));
        let name = format!("a field of view of {degrees} degrees");
        cases.push(with_camera(case(&name, vec![face]), look_at, projection));
    }
    for scale in [v(1e6, 1e-6, 1.0), v(1e-6, 1e6, 1e-6)] {
        // A box that the model stretches to the size of the view.
        let half = v(1.0 / scale.x, 0.8 / scale.y, 0.9 / scale.z);
        for shade in [ShadeMode::Flat, ShadeMode::Phong] {
            let mut o = object("box", box_mesh(half));
            o.model = matrix::rotate(v(0.4, 1.0, 0.2), 0.6).unwrap_or_default() * matrix::scale(scale);
            let name = format!("a model scaled {:e} : {:e}, {}", scale.x, scale.y, shade.as_str());
            let mut c = case(&name, vec![o]);
            c.settings.shade = shade;
            cases.push(c);
        }
    }
    // Squares of these normals underflow; their directions do not.
    let mut tiny = object("tiny normals", Mesh::default());
    let mesh = &mut Arc::make_mut(&mut tiny.geometry).mesh;
    mesh.positions = vec![v(-1.5, -1.0, 0.0), v(1.5, -1.0, 0.0), v(0.0, 1.4, 0.0)];
    mesh.normals = vec![v(-1e-170, 0.0, 1e-170), v(1e-170, 0.0, 1e-170), v(0.0, 1e-170, 1e-170)];
    let corner = |k| Corner { position: k, normal: k, texcoord: NONE, color: NONE };
    mesh.push_polygon(&[0, 1, 2].map(corner), NONE);
    cases.push(case("normals of 1e-170, whose squares underflow", vec![tiny]));
    let quarter = [v(-0.5, -0.4, 0.0), v(0.5, -0.4, 0.0), v(0.0, 0.5, 0.0)];
    let mut unlit = glowing("unit", &quarter, &[[0, 1, 2]], v(0.8, 0.5, 0.2));
    unlit.material.model = LightingModel::Unlit;
    cases.push(ortho(case("a face in a window of one unit", vec![unlit]), 1.0));
}

//! Fear: a program that uses the library gives it numbers that no picture has, and it panics.
//!
//! Every method of the library's types is called with coordinates at both ends of their ranges,
//! numbers that are not finite, indices that point nowhere and memories of other sizes. What it
//! answers does not matter here: it must return.

use fbptr::command::Figure;
use fbptr::draw2d::{AreaColors, Blend, RampColor, RealRect, Rect};
use fbptr::glam::{DMat4, DVec2, DVec3, DVec4};
use fbptr::memory::{DepthFormat, DepthMemory, FbPtr, PickBuffer};
use fbptr::pipeline::{DrawCall, RenderOptions, RenderPath, SceneOptions, Target};
use fbptr::scene::{
    Corner, Cull, HiddenSurface, LookAt, Navigator, ObliqueKind, Projection, ProjectionChoice, Sampling,
    ShadeMode, Texture, Viewport, ViewportRule, frame, shapes,
};
use fbptr::{Camera, Framebuffer, Geometry, Light, Material, Mesh, Renderer, Scene, VideoMemory};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

const INTEGERS: [i32; 7] = [i32::MIN, i32::MIN + 1, -1, 0, 5, i32::MAX - 1, i32::MAX];
const REALS: [f64; 9] =
    [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, f64::MIN, 1e300, -1e18, 0.0, 5.5];
const RED: [u8; 4] = [255, 0, 0, 128];

/// The calls that panicked.
#[derive(Default)]
struct Trials {
    count: usize,
    panicked: Vec<String>,
}

impl Trials {
    fn try_call<T>(&mut self, name: &str, call: impl FnOnce() -> T) {
        self.count += 1;
        if catch_unwind(AssertUnwindSafe(|| drop(call()))).is_err() {
            self.panicked.push(name.to_owned());
        }
    }

    fn end(self, least: usize) {
        assert!(self.count >= least, "only {} calls", self.count);
        assert!(self.panicked.is_empty(), "{:#?}", self.panicked);
    }
}

fn small() -> Framebuffer {
    let mut fb = Framebuffer::new(8, 6).expect("a small frame");
    fb.enable_picking();
    fb
}

#[test]
fn pixels_bytes_and_queries_take_any_numbers() {
    let mut t = Trials::default();
    let mut fb = small();
    for a in INTEGERS {
        for b in INTEGERS {
            t.try_call(&format!("pick {a} {b}"), || fb.pick(a, b));
            t.try_call(&format!("depth_at {a} {b}"), || fb.depth_at(a, b));
            t.try_call(&format!("get_pixel {a} {b}"), || fb.get_pixel(a, b));
            t.try_call(&format!("put_pixel {a} {b}"), || fb.put_pixel(a, b, RED));
            t.try_call(&format!("text {a} {b}"), || fb.text([a, b], "a\n\u{1f600}\u{0}b", RED));
            t.try_call(&format!("offset_of {a} {b}"), || fb.memory().offset_of(a.into(), b.into()));
            for [w, h] in [[a, b], [b, a], [3, 2], [i32::MAX, i32::MAX], [0, 0]] {
                let rect = [a, b, w, h];
                t.try_call(&format!("read {rect:?}"), || fb.read(rect));
                t.try_call(&format!("copy {rect:?}"), || fb.copy(rect, [b, a]));
                t.try_call(&format!("blit {rect:?}"), || fb.blit(rect, b"RGBARGBA"));
                t.try_call(&format!("rect {rect:?}"), || fb.rect(rect, RED));
                t.try_call(&format!("fill_rect {rect:?}"), || fb.fill_rect(rect, RED));
            }
        }
    }
    for offset in [0, 191, 192, u64::MAX - 1, u64::MAX] {
        for n in [0, 1, usize::MAX] {
            t.try_call(&format!("peek {offset} {n}"), || fb.peek(offset, n).map(<[u8]>::len));
        }
        t.try_call(&format!("poke {offset}"), || fb.poke(offset, b"abc"));
        t.try_call(&format!("peek_pixel {offset}"), || fb.memory().peek_pixel(FbPtr::new(offset)));
        t.try_call(&format!("poke_pixel {offset}"), || fb.memory_mut().poke_pixel(FbPtr::new(offset), RED));
        t.try_call("FbPtr::pixel", || FbPtr::new(offset).pixel(0));
        t.try_call("FbPtr::checked_add", || FbPtr::new(offset).checked_add(i64::MIN));
    }
    t.try_call("FbPtr::of_pixel", || FbPtr::of_pixel(u32::MAX, u32::MAX, u32::MAX));
    for bytes in [&b""[..], b"a", b"12345678", b"123456789"] {
        t.try_call("points", || fb.points(bytes));
        t.try_call("pixel_run", || fb.pixel_run(u16::MAX, u16::MAX, bytes));
        t.try_call("pixel_run", || fb.pixel_run(7, 5, bytes));
        t.try_call("binary_pixels", || {
            fbptr::draw2d::binary_pixels(fb.memory_mut(), bytes, Blend::Over);
        });
    }
    t.end(1500);
}

#[test]
fn figures_take_any_numbers() {
    let mut t = Trials::default();
    let mut fb = small();
    for blend in [Blend::Replace, Blend::Over] {
        fb.set_blend(blend);
        for a in INTEGERS {
            for b in INTEGERS {
                t.try_call(&format!("line {a} {b}"), || fb.line([a, b], [b, a], [RED; 2]));
                t.try_call(&format!("triangle {a} {b}"), || fb.triangle([[a, b], [b, a], [3, 2]], RED));
                t.try_call(&format!("circle {a} {b}"), || fb.circle([a, b], a, RED));
                t.try_call(&format!("circle {a} {b} 9"), || fb.circle([a, b], 9, RED));
                t.try_call(&format!("poly {a} {b}"), || fb.poly(&[[a, b], [b, b], [2, a]], RED));
            }
        }
        for a in REALS {
            for b in REALS {
                t.try_call(&format!("line_aa {a} {b}"), || fb.line_aa([a, b], [b, 3.0], RED));
                t.try_call(&format!("fill {a} {b}"), || {
                    fb.fill([[a, b], [b, a], [1.0, 2.0]], [RED, RED, [0; 4]])
                });
                t.try_call(&format!("fill_rect {a} {b}"), || fb.fill_rect([a, b, b, a], RED));
                t.try_call(&format!("fill_rect {a} {b} 3 3"), || fb.fill_rect([a, b, 3.0, 3.0], RED));
                t.try_call(&format!("fill_circle {a} {b}"), || fb.fill_circle([a, b], b, RED));
                t.try_call(&format!("fill_circle {a} {b} 3"), || fb.fill_circle([a, b], 3.0, RED));
                t.try_call(&format!("fill_poly {a} {b}"), || fb.fill_poly(&[[a, b], [0.0, a], [b, b]], RED));
            }
        }
        t.try_call("poly of nothing", || fb.poly(&[], RED));
        t.try_call("fill_poly of nothing", || fb.fill_poly(&[], RED));
        let figures = [
            Figure::Text { x: 0, y: 0, color: RED, utf8: vec![255, 254] },
            Figure::Rect { rect: Rect { x: 0, y: 0, w: -1, h: i32::MIN }, color: RED },
            Figure::FillRect { rect: RealRect { x: f64::NAN, y: 0.0, w: -1.0, h: f64::NAN }, color: RED },
            Figure::Fill { points: [[f64::NAN; 2]; 3], colors: AreaColors::One(RED) },
            Figure::Line { p0: [i32::MIN; 2], p1: [i32::MAX; 2], color: RampColor { from: RED, to: None } },
        ];
        for figure in figures {
            t.try_call(&format!("{figure:?}"), || fb.figure(&figure));
        }
    }
    t.end(1000);
}

#[test]
fn memories_take_any_numbers() {
    let mut t = Trials::default();
    for [w, h] in [[0, 0], [0, 5], [u32::MAX, 1], [1, u32::MAX], [u32::MAX, u32::MAX], [1 << 16, 1 << 16]] {
        t.try_call(&format!("VideoMemory::new {w} {h}"), || VideoMemory::new(w, h));
        t.try_call(&format!("Framebuffer::new {w} {h}"), || Framebuffer::new(w, h));
    }
    let mut memory = VideoMemory::new(8, 6).expect("a small frame");
    for a in [0, 5, 6, 7, u32::MAX] {
        t.try_call(&format!("row {a}"), || memory.row(a).map(<[u8]>::len));
        t.try_call(&format!("mark_row {a}"), || memory.mark_row(a));
        for b in [0, 3, 6, 7, u32::MAX] {
            t.try_call(&format!("mark_rows {a} {b}"), || memory.mark_rows(a..b));
            t.try_call(&format!("clear_rows {a} {b}"), || memory.clear_rows(a..b, RED));
            t.try_call(&format!("set_window {a} {b}"), || {
                memory.set_window(a..b);
                fbptr::draw2d::fill_rect(&mut memory, [-9, -9, 99, 99], RED, Blend::Over)
            });
        }
        t.try_call("take_damage", || memory.take_damage());
    }
    let ids = PickBuffer::new(8, 6);
    for format in DepthFormat::ALL {
        let depth = DepthMemory::new(8, 6, format);
        for a in INTEGERS {
            for b in INTEGERS {
                t.try_call(&format!("z {a} {b}"), || depth.z(a, b));
                t.try_call(&format!("PickBuffer::get {a} {b}"), || ids.get(a, b));
            }
        }
        for z in REALS {
            t.try_call(&format!("encode {z}"), || format.encode(z, 1.0 - z));
        }
        t.try_call("decode", || format.decode(u32::MAX));
    }
    t.end(400);
}

/// Returns meshes whose numbers contradict each other.
fn broken_meshes() -> Vec<(&'static str, Mesh)> {
    let corner = |position| Corner { position, normal: 7, texcoord: 8, color: 9 };
    let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y];
    let good = Mesh::from_triangles(positions.clone(), &[[0, 1, 2]]);
    let beyond = Mesh::from_triangles(positions.clone(), &[[0, 1, u32::MAX]]);
    let mut quad = Mesh { positions: positions.clone(), ..Mesh::default() };
    quad.push_polygon(&[corner(0), corner(1), corner(2), corner(99)], 0);
    let mut far = good.clone();
    far.positions[1] = DVec3::new(1e300, f64::MIN, f64::MAX);
    let mut nan = good.clone();
    nan.positions[1] = DVec3::new(f64::NAN, f64::INFINITY, 0.0);
    let mut attributes = Mesh { positions, ..Mesh::default() };
    attributes.push_polygon(&[corner(0), corner(1), corner(2)], 99);
    let mut zero_normals = good.clone();
    zero_normals.normals = vec![DVec3::ZERO; 3];
    zero_normals.corners.iter_mut().enumerate().for_each(|(i, c)| c.normal = i as u32);
    let mut lines = good.clone();
    lines.lines = vec![[0, 99]];
    let mut points = good.clone();
    points.points = vec![99];
    let mut triangles = good.clone();
    triangles.triangles = vec![[0, 1, 99]];
    let mut unowned = good.clone();
    unowned.triangle_polygon = vec![];
    let mut polygon = good.clone();
    polygon.triangle_polygon = vec![42];
    let mut texcoords = good.clone();
    texcoords.texcoords = vec![DVec2::new(f64::NAN, 1e300); 3];
    texcoords.corners.iter_mut().enumerate().for_each(|(i, c)| c.texcoord = i as u32);
    let mut colors = good.clone();
    colors.colors = vec![DVec4::splat(f64::NAN); 3];
    colors.corners.iter_mut().enumerate().for_each(|(i, c)| c.color = i as u32);
    vec![
        ("nothing", Mesh::default()),
        ("good", good),
        ("beyond", beyond),
        ("quad", quad),
        ("far", far),
        ("nan", nan),
        ("attributes", attributes),
        ("zero normals", zero_normals),
        ("lines", lines),
        ("points", points),
        ("triangles", triangles),
        ("unowned", unowned),
        ("polygon", polygon),
        ("texcoords", texcoords),
        ("colors", colors),
        ("index", Mesh { ..Mesh::from_triangles(vec![DVec3::ZERO], &[[0, 0, 0]]) }),
    ]
}

#[test]
fn meshes_that_contradict_themselves_are_refused_or_drawn() {
    let mut t = Trials::default();
    t.try_call("from_triangles", || Mesh::from_triangles(vec![DVec3::ZERO], &[[0, 1, u32::MAX]]));
    t.try_call("push_polygon of nothing", || Mesh::default().push_polygon(&[], u32::MAX));
    for (name, mesh) in broken_meshes() {
        t.try_call(&format!("{name}: bounds"), || mesh.bounds());
        t.try_call(&format!("{name}: polygon_corners"), || mesh.polygon_corners(usize::MAX).len());
        let geometry: Geometry = mesh.into();
        let shared = Arc::new(geometry.clone());
        for shade in [ShadeMode::Wire, ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong] {
            for hide in [HiddenSurface::ZBuffer, HiddenSurface::Painter, HiddenSurface::None] {
                for lit in [false, true] {
                    let mut fb = small();
                    t.try_call(&format!("{name}: show_whole"), || fb.show_whole(&geometry));
                    (fb.state.shade, fb.state.hide, fb.state.cull) = (shade, hide, Cull::None);
                    if !lit {
                        fb.state.lights.clear();
                    }
                    t.try_call(&format!("{name}: draw {shade:?} {hide:?}"), || fb.draw(&geometry));
                    t.try_call(&format!("{name}: draw shared {shade:?} {hide:?}"), || fb.draw(&shared));
                    t.try_call(&format!("{name}: draw_scene {shade:?} {hide:?}"), || {
                        fb.draw_scene(&Scene::of_mesh(shared.clone(), name, 1.0, true))
                    });
                }
            }
        }
    }
    t.end(400);
}

#[test]
fn states_and_cameras_take_any_numbers() {
    let mut t = Trials::default();
    let pot = Arc::new(Geometry::from(shapes::cuboid(DVec3::ONE).expect("small")));
    for a in REALS {
        for b in [f64::NAN, f64::INFINITY, f64::MIN, 0.0, 5.5] {
            let v = DVec3::new(a, b, a);
            let window = [a, b, b, a];
            let [near, far] = [a, b];
            let projections = [
                Projection::Perspective { fov_rad: a, near: b, far: a, on_smaller_side: true },
                Projection::Plane { d: a, near, far },
                Projection::Frustum { window, near, far },
                Projection::Ortho { window, near, far },
                Projection::OrthoContain { window, near, far },
                Projection::Oblique { kind: ObliqueKind::Cabinet, angle_rad: a, window, near, far },
                Projection::Isometric { window, near, far },
                Projection::Window {
                    vrp: v,
                    p: v,
                    vup: v,
                    center: [a, b],
                    half: [b, a],
                    dp: a,
                    near: b,
                    far: a,
                },
            ];
            for projection in projections {
                for look_at in [Camera::default().look_at, LookAt { eye: v, reference: v, up: v }] {
                    let camera = Camera { look_at, projection };
                    t.try_call(&format!("matrices {camera:?}"), || camera.matrices(a));
                    let mut fb = small();
                    fb.show_whole(&pot);
                    fb.state.camera = camera;
                    t.try_call(&format!("draw {camera:?}"), || fb.draw(&pot));
                    let mut way = Navigator::default();
                    t.try_call(&format!("navigate {camera:?}"), || {
                        way.orbit(&camera, v, a, b);
                        way.walk(&camera, [a, b, a]);
                        way.zoom_by(a);
                        ProjectionChoice::default().next(&camera.projection);
                        way.apply(&camera, Some((v, -v)), b)
                    });
                }
            }
            type Change<'a> = &'a dyn Fn(&mut Framebuffer);
            let states: [(&str, Change<'_>); 6] = [
                ("model", &|fb| fb.state.model = DMat4::from_scale(v)),
                ("rows", &|fb| fb.state.model = DMat4::from_cols_array(&[a; 16])),
                ("ambient", &|fb| fb.state.ambient = v),
                ("lights", &|fb| fb.state.lights = vec![Light::directional(v, v), Light::point(v, v)]),
                ("material", &|fb| {
                    fb.state.material = Material { ka: v, kd: v, ks: v, emissive: v, ..Material::default() };
                }),
                ("shininess", &|fb| {
                    fb.state.material = Material { n: a, transparency: b, ..Material::default() };
                }),
            ];
            for (name, set) in states {
                for shade in [ShadeMode::Flat, ShadeMode::Gouraud, ShadeMode::Phong] {
                    let mut fb = small();
                    fb.show_whole(&pot);
                    set(&mut fb);
                    fb.state.shade = shade;
                    t.try_call(&format!("{name} {a} {b} {shade:?}"), || fb.draw(&pot));
                }
            }
            t.try_call(&format!("frame {a} {b}"), || frame((v, -v), a));
            t.try_call(&format!("of_mesh {a}"), || Scene::of_mesh(pot.clone(), "a", a, false));
        }
    }
    t.end(2000);
}

#[test]
fn shapes_and_textures_take_any_sizes() {
    let mut t = Trials::default();
    for a in REALS {
        t.try_call(&format!("sphere {a}"), || shapes::sphere(a));
        t.try_call(&format!("cone {a}"), || shapes::cone(a, a));
        t.try_call(&format!("cylinder {a}"), || shapes::cylinder(a, a));
        t.try_call(&format!("cuboid {a}"), || shapes::cuboid(DVec3::splat(a)));
    }
    for n in [0, 1, 2, u32::MAX] {
        t.try_call(&format!("knot {n}"), || shapes::knot(n, n));
        t.try_call(&format!("teapot {n}"), || shapes::teapot(n));
        t.try_call(&format!("knot_bytes {n}"), || [shapes::knot_bytes(n, n), shapes::teapot_bytes(n)]);
        t.try_call(&format!("Texture::new {n}"), || Texture::new(n, n, vec![0; 4]));
    }
    t.end(50);
}

#[test]
fn targets_of_other_sizes_and_viewports_off_the_frame_are_taken() {
    let mut t = Trials::default();
    let pot = Geometry::from(shapes::teapot(2).expect("small"));
    let material = Material { emissive: DVec3::ONE, ..Material::default() };
    let texture = Texture::new(2, 2, vec![200; 16]).expect("four texels");
    for path in [RenderPath::Fast, RenderPath::Plain] {
        let mut renderer = Renderer::new(RenderOptions { path, ..RenderOptions::default() });
        for [x, y] in [[0, 0], [i32::MIN, i32::MIN], [i32::MAX, 0], [-3, 4]] {
            for [width, height] in [[8, 6], [0, 0], [u32::MAX, 1], [u32::MAX, u32::MAX], [1, 100_000]] {
                let viewport = Viewport { x, y, width, height, rule: ViewportRule::Corners };
                for size in [[8, 6], [3, 9], [20, 20]] {
                    let mut memory = VideoMemory::new(8, 6).expect("a small frame");
                    let mut depth = Some(DepthMemory::new(size[0], size[1], DepthFormat::F32));
                    let mut ids = PickBuffer::new(size[0], size[1]);
                    let mut target = Target {
                        memory: &mut memory,
                        depth: &mut depth,
                        depth_format: DepthFormat::F32,
                        ids: Some(&mut ids),
                    };
                    let call = DrawCall {
                        viewport,
                        texture: Some(&texture),
                        sampling: Sampling::default(),
                        ..DrawCall::new(&pot, &material, 8, 6)
                    };
                    let name = format!("{path:?} {viewport:?} {size:?}");
                    t.try_call(&format!("draw {name}"), || renderer.draw(&mut target, &call));
                    let scene = Scene::of_mesh(Arc::new(pot.clone()), "a", 1.0, false);
                    let options = SceneOptions { viewport, ..SceneOptions::new(8, 6) };
                    t.try_call(&format!("scene {name}"), || {
                        renderer.draw_scene(&mut target, &scene, &options)
                    });
                    t.try_call(&format!("plan {name}"), || renderer.plan_scene(&target, &scene, &options));
                }
            }
        }
    }
    // A program replaces the frame's memory by one of another size.
    for size in [[3, 2], [40, 30]] {
        let mut fb = small();
        let pot = shapes::teapot(2).expect("small");
        fb.show_whole(&pot);
        t.try_call("draw before", || fb.draw(&pot));
        *fb.memory_mut() = VideoMemory::new(size[0], size[1]).expect("a small frame");
        t.try_call(&format!("draw after {size:?}"), || fb.draw(&pot));
        t.try_call("clear", || fb.clear(RED));
        for [x, y] in [[0, 0], [39, 29], [7, 5]] {
            t.try_call(&format!("ask after {size:?}"), || (fb.pick(x, y), fb.depth_at(x, y).ok()));
        }
    }
    t.end(300);
}

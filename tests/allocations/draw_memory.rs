//! Draws within a memory budget: split draws give the same picture, and never hold more memory than
//! the budget.
//!
//! Guards against a few bytes of faces that fill the frame and take gigabytes, and against pieces
//! of a draw that give another picture.

use crate::TURN;
use crate::counting::most_held;
use fbptr::error::Code;
use fbptr::memory::{DepthFormat, MemoryBudget, PickBuffer, VideoMemory};
use fbptr::pipeline::{
    DrawCall, DrawStats, PipelineError, Plan, RenderOptions, RenderPath, Renderer, SceneOptions, Target,
};
use fbptr::scene::{
    Camera, Corner, Geometry, HiddenSurface, Light, Material, Mesh, NONE, Projection, ShadeMode,
};
use fbptr::truth::scenes::{lit_triangle, object};
use glam::DVec3;
use std::sync::{Arc, PoisonError};

const SIZE: (u32, u32) = (192, 128);

/// Reproducible pseudo-random numbers in 0..1 (PCG's linear congruential step).
struct Noise(u32);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
        f64::from(self.0 >> 8) / f64::from(1 << 24)
    }
}

/// Triangles of every size from less than a pixel to more than the frame, in any order and depth.
fn all_sizes(faces: usize, seed: u32) -> Mesh {
    let mut noise = Noise(seed);
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    for i in 0..faces as u32 {
        let size = 3.0 * (8.0 * (noise.next() - 1.0)).exp();
        let center = DVec3::new(noise.next() * 3.0 - 1.5, noise.next() * 2.0 - 1.0, -noise.next());
        for _ in 0..3 {
            let off = DVec3::new(noise.next() - 0.5, noise.next() - 0.5, 0.1 * (noise.next() - 0.5));
            positions.push(center + off * size);
        }
        triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    let mut mesh = Mesh::from_triangles(positions, &triangles);
    mesh.colors =
        (0..faces).map(|_| glam::DVec4::new(noise.next(), noise.next(), noise.next(), 1.0)).collect();
    let colored = |(i, c): (usize, &Corner)| Corner { color: (i / 3) as u32, ..*c };
    mesh.corners = mesh.corners.iter().enumerate().map(colored).collect();
    mesh
}

/// Repeats one triangle that covers the whole frame.
fn full_frames(faces: usize) -> Mesh {
    let corners = [[-9.0, -9.0], [27.0, -9.0], [-9.0, 27.0]];
    let positions = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    Mesh::from_triangles(positions, &vec![[0, 1, 2]; faces])
}

/// Result of a draw: pixels, depths and the pick buffer.
#[derive(PartialEq)]
struct Picture {
    bytes: Vec<u8>,
    depths: Vec<u32>,
    ids: Vec<Option<(u32, u32)>>,
}

fn camera() -> Camera {
    let projection = Projection::Ortho { window: [-1.33, 1.33, -1.0, 1.0], near: 0.1, far: 9.0 };
    let mut camera = Camera { projection, ..Camera::default() };
    camera.look_at.eye = DVec3::new(0.0, 0.0, 3.0);
    camera
}

fn draw(
    renderer: &mut Renderer,
    geometry: &Arc<Geometry>,
    (shade, hide, depth_format): (ShadeMode, HiddenSurface, DepthFormat),
) -> Result<(Picture, DrawStats), PipelineError> {
    let (width, height) = SIZE;
    let (mut memory, mut ids) = (VideoMemory::new(width, height).unwrap(), PickBuffer::new(width, height));
    let mut depth = None;
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: Some(&mut ids) };
    let lights = [Light::directional(DVec3::new(-1.0, -1.0, -2.0), DVec3::ONE)];
    let material = Material::default();
    let call = DrawCall {
        shared: Some(geometry),
        lights: &lights,
        shade,
        hide,
        camera: camera(),
        ..DrawCall::new(geometry, &material, width, height)
    };
    let stats = renderer.draw(&mut target, &call)?;
    let pixels = 0..(width * height) as usize;
    let at = |i: usize| ((i as u32 % width) as i32, (i as u32 / width) as i32);
    Ok((
        Picture {
            bytes: memory.bytes().to_vec(),
            depths: depth.map_or(Vec::new(), |d| pixels.clone().map(|i| d.word(i)).collect()),
            ids: pixels.map(at).map(|(x, y)| ids.get(x, y)).collect(),
        },
        stats,
    ))
}

fn pool(threads: usize) -> Option<Arc<rayon::ThreadPool>> {
    (threads > 1).then(|| Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()))
}

#[test]
fn pieces_draw_the_picture_of_the_whole() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let states = [
        (ShadeMode::Flat, HiddenSurface::ZBuffer, DepthFormat::F32),
        (ShadeMode::Phong, HiddenSurface::None, DepthFormat::F32),
        (ShadeMode::Gouraud, HiddenSurface::ZBuffer, DepthFormat::U16),
    ];
    let meshes = [all_sizes(2500, 7), full_frames(1200)];
    for mesh in meshes {
        let geometry = Arc::new(Geometry { mesh, textures: Vec::new() });
        for state in states {
            let (whole, in_one) = draw(&mut Renderer::default(), &geometry, state).unwrap();
            for threads in [1, 2, 4] {
                let options = RenderOptions { pool: pool(threads), ..RenderOptions::default() };
                // The least budget that suffices, which takes the most pieces, and a larger one.
                let mut did = 0;
                for budget in std::iter::successors(Some(1u64 << 20), |bytes| Some(bytes + bytes / 4)) {
                    let mut renderer = Renderer::new(options.clone());
                    renderer.set_budget(&MemoryBudget::new(budget));
                    let (picture, stats) = match draw(&mut renderer, &geometry, state) {
                        Ok(drawn) => drawn,
                        Err(e) if e.code() == Code::Quota && budget < 64 << 20 => continue,
                        Err(e) => panic!("{budget} bytes: {e}"),
                    };
                    let faces = geometry.mesh.triangles.len();
                    assert!(picture == whole, "{faces} faces, {state:?}, {threads} threads, {budget} bytes");
                    assert_eq!(stats, in_one, "{faces} faces, {state:?}, {threads} threads, {budget} bytes");
                    did += 1;
                    if did == 3 {
                        break;
                    }
                }
            }
        }
    }
}

#[test]
fn pieces_draw_the_picture_of_the_plain_path() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let geometry = Arc::new(Geometry { mesh: full_frames(120), textures: Vec::new() });
    let state = (ShadeMode::Flat, HiddenSurface::ZBuffer, DepthFormat::F32);
    let plain = RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() };
    let (plain, _) = draw(&mut Renderer::new(plain), &geometry, state).unwrap();
    let mut renderer = Renderer::default();
    renderer.set_budget(&MemoryBudget::new(1 << 20));
    let (picture, _) = draw(&mut renderer, &geometry, state).unwrap();
    assert!(picture.ids == plain.ids);
    let off = picture.bytes.iter().zip(&plain.bytes).map(|(a, b)| a.abs_diff(*b)).max();
    assert!(off <= Some(1), "{off:?}");
}

#[test]
fn a_draw_holds_no_more_than_its_budget_and_no_more_than_its_plan_says() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let state = (ShadeMode::Phong, HiddenSurface::ZBuffer, DepthFormat::F32);
    for (mesh, budget) in [(full_frames(2500), 5 << 20), (all_sizes(4000, 3), 12 << 20)] {
        {
            let faces = mesh.triangles.len();
            let geometry = Arc::new(Geometry { mesh, textures: Vec::new() });
            for threads in [1, 2] {
                let options = RenderOptions { pool: pool(threads), ..RenderOptions::default() };
                let mut renderer = Renderer::new(options);
                let shared = MemoryBudget::new(budget);
                renderer.set_budget(&shared);
                // Twice: memory that the first draw leaves cached counts against the budget as
                // well.
                for _ in 0..2 {
                    let (result, held) = most_held(|| draw(&mut renderer, &geometry, state).map(drop));
                    result.unwrap_or_else(|e| panic!("{faces} faces in {budget} bytes: {e}"));
                    // The picture, its depths and ids, and their copies belong to the caller.
                    let own = u64::from(SIZE.0 * SIZE.1) * (4 + 4 + 8 + 4 + 4 + 12);
                    assert!(
                        held <= budget + own + (64 << 10),
                        "{faces} faces, {threads} threads: {held} of {budget}"
                    );
                    assert!(shared.used() <= budget);
                }
            }
        }
    }
}

#[test]
fn a_plan_states_the_working_memory_at_worst() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let (width, height) = SIZE;
    let mut memory = VideoMemory::new(width, height).unwrap();
    let mut depth = None;
    for hide in [HiddenSurface::ZBuffer, HiddenSurface::Painter] {
        for shade in [ShadeMode::Phong, ShadeMode::Wire] {
            for mesh in [full_frames(800), all_sizes(2000, 5)] {
                let geometry = Arc::new(Geometry { mesh, textures: Vec::new() });
                let target = Target {
                    memory: &mut memory,
                    depth: &mut depth,
                    depth_format: DepthFormat::F32,
                    ids: None,
                };
                let material = Material::default();
                let call = DrawCall {
                    shared: Some(&geometry),
                    shade,
                    hide,
                    camera: camera(),
                    ..DrawCall::new(&geometry, &material, width, height)
                };
                let plan = Plan::of_draw(&call, &target);
                let stated = plan.working_bytes();
                assert!(plan.to_string().contains(&format!("working memory at most {stated}")), "{plan}");
                let mut renderer = Renderer::default();
                let (result, held) =
                    most_held(|| draw(&mut renderer, &geometry, (shade, hide, DepthFormat::F32)));
                result.unwrap();
                let frame = u64::from(width * height) * (4 + 4 + 8 + 4 + 4 + 12);
                // Geometry info lives as long as the mesh: three times the mesh's own bytes are
                // more than it takes.
                let known = 3 * geometry.mesh.size_bytes() as u64;
                assert!(
                    held <= stated + frame + known + (64 << 10),
                    "{shade:?} {hide:?}: {held}, {stated} stated"
                );
            }
        }
    }
}

#[test]
fn a_plan_of_a_scene_states_what_all_its_objects_take_together() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let (width, height) = SIZE;
    for (count, faces, hide) in [(6, 3000, HiddenSurface::Painter), (24, 200, HiddenSurface::ZBuffer)] {
        let mut scene = lit_triangle();
        scene.objects = (0..count).map(|i| object("it", all_sizes(faces, 40 + i))).collect();
        let options = SceneOptions { camera: camera(), hide, ..SceneOptions::new(width, height) };
        for threads in [1, 3] {
            let mut renderer =
                Renderer::new(RenderOptions { pool: pool(threads), ..RenderOptions::default() });
            let (mut memory, mut depth) = (VideoMemory::new(width, height).unwrap(), None);
            let mut target =
                Target { memory: &mut memory, depth: &mut depth, depth_format: DepthFormat::F32, ids: None };
            let stated = renderer.plan_scene(&target, &scene, &options).working_bytes();
            let budget = MemoryBudget::unlimited();
            renderer.set_budget(&budget);
            let (stats, held) = most_held(|| renderer.draw_scene(&mut target, &scene, &options));
            assert!(stats.unwrap().faces_drawn > 100);
            let known: usize = scene.objects.iter().map(|o| 3 * o.geometry.mesh.size_bytes()).sum();
            let beside = u64::from(width * height) * (4 + 8) + known as u64 + (64 << 10);
            println!("{count} objects, {threads} threads: {held} held, {stated} stated, {beside} beside");
            assert!(held <= stated + beside, "{hide:?} {threads}: {held} held, {stated} stated");
            assert!(renderer.reserved_bytes() <= stated, "{hide:?} {threads}: {stated} stated");
        }
    }
}

#[test]
fn what_fits_in_no_pieces_is_refused_with_the_figures_and_changes_nothing() {
    let _turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
    let geometry = Arc::new(Geometry { mesh: all_sizes(50_000, 9), textures: Vec::new() });
    for hide in [HiddenSurface::ZBuffer, HiddenSurface::Painter] {
        let mut renderer = Renderer::default();
        let budget = MemoryBudget::new(1 << 20);
        renderer.set_budget(&budget);
        let error =
            draw(&mut renderer, &geometry, (ShadeMode::Flat, hide, DepthFormat::F32)).map(drop).unwrap_err();
        assert_eq!(error.code(), Code::Quota);
        assert!(error.to_string().contains("1048576 bytes that there may be"), "{error}");
        // A small draw after the large one is still drawn.
        let small = Arc::new(Geometry { mesh: full_frames(2), textures: Vec::new() });
        draw(&mut renderer, &small, (ShadeMode::Flat, HiddenSurface::ZBuffer, DepthFormat::F32)).unwrap();
    }
    let corner = geometry.mesh.corners[0];
    assert_eq!(corner.normal, NONE);
}

use super::*;
use crate::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use crate::pipeline::{DrawStats, RenderOptions, RenderPath, Renderer, SceneOptions};
use crate::scene::{Band, HiddenSurface, LineStyle, Mesh, Scene, ShadeMode, Sky, TransparencyOrder, shapes};
use crate::truth::scenes::{lit_triangle, object, random};
use glam::{DMat3, DMat4, DVec3};
use std::sync::Mutex;
use std::sync::atomic::AtomicU32;

const SIZE: (u32, u32) = (320, 240);

type Memories = (VideoMemory, Option<DepthMemory>, PickBuffer);

/// An owner whose target is always due. While it has the target, the draw has memories without
/// pixels.
#[derive(Default)]
struct Impatient {
    memories: Mutex<Option<Memories>>,
    times: AtomicU32,
}

impl TargetOwner for Impatient {
    fn is_due(&self) -> bool {
        true
    }

    fn release(&self, target: &mut Target) {
        self.times.fetch_add(1, Relaxed);
        let ids = target.ids.as_deref_mut().unwrap();
        let memories = (
            std::mem::replace(target.memory, VideoMemory::vacant()),
            target.depth.take(),
            std::mem::replace(ids, PickBuffer::new(0, 0)),
        );
        assert!(memories.0.width() > 0, "the draw has a target to give");
        assert!(self.memories.lock().unwrap().replace(memories).is_none());
    }

    fn acquire(&self, target: &mut Target) {
        let ids = target.ids.as_deref_mut().unwrap();
        (*target.memory, *target.depth, *ids) = self.memories.lock().unwrap().take().unwrap();
    }
}

/// All that a draw leaves.
#[derive(PartialEq)]
struct Outcome {
    bytes: Vec<u8>,
    depths: Vec<u32>,
    ids: Vec<[u32; 2]>,
    stats: DrawStats,
    damage: std::ops::Range<u32>,
}

fn outcome(
    renderer: &mut Renderer,
    (width, height): (u32, u32),
    format: DepthFormat,
    draw: impl Fn(&mut Renderer, &mut Target) -> DrawStats,
) -> Outcome {
    let (mut memory, mut depth) = (VideoMemory::new(width, height).unwrap(), None);
    // Its clear is pending.
    let mut ids = PickBuffer::new(width, height);
    ids.ids_mut().fill([u32::MAX - 1; 2]);
    ids.clear();
    memory.take_damage();
    let mut target =
        Target { memory: &mut memory, depth: &mut depth, depth_format: format, ids: Some(&mut ids) };
    let stats = draw(renderer, &mut target);
    let damage = memory.take_damage();
    assert!(!ids.ids_mut().contains(&[u32::MAX - 1; 2]), "a clear of the pick buffer is lost");
    let depth = depth.iter().flat_map(|d| (0..(width * height) as usize).map(|i| d.word(i)));
    Outcome {
        depths: depth.collect(),
        bytes: memory.bytes().to_vec(),
        ids: ids.ids_mut().to_vec(),
        stats,
        damage,
    }
}

/// Draws with and without preemption, on one thread and on two. Returns how often a draw was
/// preempted at least.
fn is_same(
    what: &str,
    size: (u32, u32),
    format: DepthFormat,
    path: RenderPath,
    draw: impl Fn(&mut Renderer, &mut Target) -> DrawStats,
) -> u32 {
    let mut fewest = u32::MAX;
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let pool = (threads > 1).then(|| Arc::new(pool));
        let options = RenderOptions { pool, path, ..RenderOptions::default() };
        let mut renderer = Renderer::new(options);
        let want = outcome(&mut renderer, size, format, &draw);
        let owner = Arc::new(Impatient::default());
        renderer.set_preemption(Preemption::by(owner.clone()));
        // Twice: with facts about the geometries to compute and without.
        for _ in 0..2 {
            let got = outcome(&mut renderer, size, format, &draw);
            assert!(got.bytes == want.bytes, "{what}, {threads} threads: other bytes");
            assert!(got.depths == want.depths, "{what}, {threads} threads: other depths");
            assert!(got.ids == want.ids, "{what}, {threads} threads: other ids");
            assert_eq!(got.stats, want.stats, "{what}, {threads} threads");
            assert_eq!(got.damage, want.damage, "{what}, {threads} threads");
        }
        fewest = fewest.min(owner.times.load(Relaxed) / 2);
    }
    fewest
}

/// Returns a scene of a large mesh, small ones that are drawn together, transparent ones, lines and
/// points.
fn crowd() -> Scene {
    let mut scene = lit_triangle();
    scene.objects.push(object("knot", shapes::knot(120, 40).expect("a knot")));
    for i in 0..40 {
        let mut one = object("box", shapes::cuboid(DVec3::splat(0.5)).expect("a box"));
        one.model =
            DMat4::from_translation(DVec3::new(f64::from(i % 8) / 2.0 - 2.0, 0.3, 0.1 * f64::from(i)));
        one.material.transparency = if i % 3 == 0 { 0.5 } else { 0.0 };
        scene.objects.push(one);
    }
    let mut lines = Mesh::from_triangles(vec![DVec3::ZERO, DVec3::new(1.0, 2.0, 0.5), DVec3::X], &[]);
    let corner = |position| crate::scene::Corner {
        position,
        normal: crate::scene::NONE,
        texcoord: crate::scene::NONE,
        color: crate::scene::NONE,
    };
    lines.corners = (0..3).map(corner).collect();
    (lines.lines, lines.points) = (vec![[0, 1], [1, 2], [2, 0]], vec![0, 1, 2]);
    let mut lines = object("lines", lines);
    lines.style.line = LineStyle { width: 3, ..LineStyle::default() };
    scene.objects.push(lines);
    scene
}

#[test]
fn preempted_scenes_are_those_drawn_at_once() {
    let mut scene = crowd();
    scene.sky = Some(Arc::new(Sky {
        sky: vec![Band { angle_rad: 0.0, color: DVec3::X }, Band { angle_rad: 1.5, color: DVec3::Z }],
        ground: Vec::new(),
        pictures: Default::default(),
        from_world: DMat3::IDENTITY,
        opacity: 0.8,
    }));
    for (shade, hide, format, path, least) in [
        (ShadeMode::Phong, HiddenSurface::ZBuffer, DepthFormat::F32, RenderPath::Fast, 40),
        (ShadeMode::Gouraud, HiddenSurface::ZBuffer, DepthFormat::U16, RenderPath::Fast, 40),
        (ShadeMode::Flat, HiddenSurface::ZBuffer, DepthFormat::U24, RenderPath::Fast, 40),
        (ShadeMode::Flat, HiddenSurface::Painter, DepthFormat::F32, RenderPath::Fast, 100),
        (ShadeMode::Flat, HiddenSurface::Painter, DepthFormat::F32, RenderPath::Plain, 100),
        (ShadeMode::Phong, HiddenSurface::None, DepthFormat::F32, RenderPath::Fast, 40),
        (ShadeMode::Wire, HiddenSurface::ZBuffer, DepthFormat::Reversed, RenderPath::Fast, 5000),
    ] {
        // The order of transparent faces matters to few stages.
        let transparency = match format {
            DepthFormat::U16 => TransparencyOrder::Sorted,
            _ => TransparencyOrder::FileOrder,
        };
        let options = SceneOptions { shade, hide, transparency, ..SceneOptions::new(SIZE.0, SIZE.1) };
        let what = format!("{shade:?} {hide:?} {format:?} {path:?} {transparency:?}");
        let times = is_same(&what, SIZE, format, path, |renderer, target| {
            renderer.draw_scene(target, &scene, &options).unwrap()
        });
        assert!(times >= least, "{what}: preempted {times} times");
    }
}

#[test]
fn preempted_meshes_are_those_drawn_at_once() {
    let (mut single, mut options) = (crowd(), SceneOptions::new(SIZE.0, SIZE.1));
    single.objects.swap(0, 1);
    for (transparency, hide, least) in [
        (0.0, HiddenSurface::ZBuffer, 20),
        (0.5, HiddenSurface::ZBuffer, 60),
        (0.0, HiddenSurface::Painter, 60),
    ] {
        single.objects[0].material.transparency = transparency;
        options.hide = hide;
        let call = crate::pipeline::DrawCall::of_object(&single.objects[0], &single, &options);
        let what = format!("{transparency} {hide:?}");
        let times = is_same(&what, SIZE, DepthFormat::F32, RenderPath::Fast, |renderer, target| {
            renderer.draw(target, &call).unwrap()
        });
        assert!(times >= least, "{what}: preempted {times} times");
    }
}

#[test]
fn preempted_random_scenes_are_those_drawn_at_once() {
    for seed in 0..60 {
        let case = random(seed);
        let size = (case.width, case.height);
        let mut options = SceneOptions::new(case.width, case.height);
        (options.shade, options.hide) = (case.settings.shade, case.settings.hide);
        options.interp = case.settings.interpolation;
        if let Some(viewport) = case.settings.viewport {
            options.viewport = viewport;
        }
        is_same(&case.name, size, case.format, RenderPath::Fast, |renderer, target| {
            renderer.draw_scene(target, &case.scene, &options).unwrap()
        });
    }
}

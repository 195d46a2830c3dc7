//! Plans against what is drawn: random scenes, many of them with values out of range for vectors, by
//! every backend.
//!
//! Guards against a path that is chosen after the plan: each face must be drawn by the path that the
//! plan of its draw names.

use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{
    CoarseDepth, DepthUse, DrawCall, DrawStats, Part, PathCounts, Plan, RenderOptions, RenderPath, Renderer,
    SceneOptions, Target,
};
use fbptr::scene::{
    Attenuation, Cull, FillStyle, Fog, FogKind, Geometry, Light, LightKind, NONE, Object, Scene, ShadeMode,
    TextureStages, TransparencyOrder,
};
use fbptr::truth::scenes::{Random, random};
use glam::{DMat4, DVec3, DVec4};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Makes an object awkward for one of the paths, most of the time.
fn twist_object(dice: &mut Random, object: &mut Object) {
    object.shade =
        dice.pick(&[None, Some(ShadeMode::Phong), Some(ShadeMode::Flat), Some(ShadeMode::Gouraud)]);
    match dice.below(14) {
        0 => (object.material.ks, object.material.n) = (DVec3::ONE, 4000.0),
        1 => object.material.emissive = DVec3::splat(1e31),
        2 => object.material.transparency = dice.real(0.1, 0.9),
        3 => object.model *= DMat4::from_scale(DVec3::splat(dice.pick(&[1e-30, 1e20]))),
        4 => object.shade = Some(ShadeMode::Wire),
        5 => object.style.fill = FillStyle { is_filled: false, hatch: None },
        6 => {
            let stages = TextureStages { stages: Vec::new(), factor: DVec4::ONE };
            object.style.stages = Some(Arc::new(stages));
        }
        7 => {
            object.back_material = Some(object.material.clone());
            (object.cull, object.two_sided_lighting) = (Cull::None, dice.one_in(2));
        }
        8 | 9 => {
            let Geometry { mesh, textures } = &*object.geometry;
            let (mut mesh, textures) = (mesh.clone(), textures.clone());
            match dice.one_in(2) {
                true => mesh.texcoords.iter_mut().for_each(|uv| *uv *= 1e6),
                false => mesh.corners.iter_mut().step_by(2).for_each(|c| c.texcoord = NONE),
            }
            object.geometry = Arc::new(Geometry { mesh, textures });
        }
        _ => object.material.transparency = 0.0,
    }
}

/// Makes a scene and its drawing awkward for one of the paths, at times.
fn twist_scene(dice: &mut Random, scene: &mut Scene, options: &mut SceneOptions) {
    let far = LightKind::Point {
        position: DVec3::splat(1e20),
        attenuation: Attenuation::NONE,
        radius: f64::INFINITY,
    };
    let steep = LightKind::Spot {
        position: DVec3::Z,
        direction: DVec3::NEG_Z,
        angle_rad: 1.0,
        exponent: 3000.0,
        attenuation: Attenuation::NONE,
    };
    match dice.below(12) {
        0 | 1 => {
            let kind = dice.pick(&[far, steep]);
            scene.lights.push(Light { kind, ..Light::directional(DVec3::X, DVec3::ONE) });
        }
        2 => {
            let visibility_range = dice.pick(&[1e300, 1e-20, 8.0]);
            scene.fog = Some(Fog { color: DVec3::ONE, kind: FogKind::Linear, visibility_range });
        }
        3 => options.viewport.x = 5000,
        _ => {}
    }
    options.depth_use = dice.pick(&[DepthUse::Keep, DepthUse::SceneOnly]);
    options.transparency = dice.pick(&[TransparencyOrder::FileOrder, TransparencyOrder::Sorted]);
}

/// A frame to draw on.
struct Frame {
    memory: VideoMemory,
    format: DepthFormat,
}

impl Frame {
    /// Draws by `draw`, and returns the plan that `plan` makes for it, what drew, the counts, and
    /// whether there is a depth memory.
    fn draw(
        &mut self,
        renderer: &mut Renderer,
        plan: impl FnOnce(&Renderer, &Target) -> Plan,
        draw: impl FnOnce(&mut Renderer, &mut Target) -> DrawStats,
    ) -> (Plan, PathCounts, DrawStats, bool) {
        let mut depth = None;
        let Frame { memory, format } = self;
        let mut target = Target { memory, depth: &mut depth, depth_format: *format, ids: None };
        let plan = plan(renderer, &target);
        let before = renderer.path_counts();
        let stats = draw(renderer, &mut target);
        let after = renderer.path_counts();
        let counts = PathCounts {
            tiles: after.tiles - before.tiles,
            vectors: after.vectors - before.vectors,
            reference: after.reference - before.reference,
        };
        (plan, counts, stats, depth.is_some())
    }
}

/// Returns what has to draw an object with this plan, if `drawn` of its faces are seen.
fn expected(plan: &Plan, object: &Object, shade: ShadeMode, drawn: u64) -> PathCounts {
    let none = PathCounts::default();
    match object.shade.unwrap_or(shade) {
        _ if plan.uses(Part::TileRenderer) => {
            PathCounts { tiles: object.geometry.mesh.triangles.len() as u64, ..none }
        }
        ShadeMode::Wire => none,
        _ if plan.uses(Part::FacesInOrder) => PathCounts { vectors: drawn, ..none },
        _ => PathCounts { reference: drawn, ..none },
    }
}

/// Verifies that nothing was counted of the parts that the plan leaves out.
#[track_caller]
fn assert_stages(plan: &Plan, stats: &DrawStats, has_depth: bool) {
    let lit_first = plan.uses(Part::LightVertices) || plan.uses(Part::LightFaces);
    for (part, is_planned, count) in [
        ("light pixels", plan.uses(Part::LightPixels), stats.pixels_lit),
        ("light corners or faces", lit_first, stats.vertices_lit),
        ("lines", plan.uses(Part::Lines), stats.lines_drawn),
        ("points", plan.uses(Part::Points), stats.points_drawn),
        ("coarse depth", plan.uses(Part::CoarseDepth), stats.faces_hidden),
        ("cull", plan.uses(Part::CullFaces), stats.faces_culled),
    ] {
        assert!(is_planned || count == 0, "{part}: {stats:?}\n{plan}");
    }
    assert_eq!(plan.uses(Part::DepthMemory), has_depth, "{plan}");
}

#[test]
fn each_face_is_drawn_by_the_path_of_its_plan() {
    let mut reasons = BTreeMap::<&str, u32>::new();
    let mut sums = PathCounts::default();
    for seed in 0..300 {
        let mut dice = Random::new(seed);
        let (case, mut size) = (random(seed), dice.pick(&[(48, 40), (70, 33), (150, 64)]));
        if dice.one_in(20) {
            size.0 = 9;
        }
        let mut scene = case.scene;
        let mut options = SceneOptions::new(size.0, size.1);
        (options.shade, options.hide, options.interp) =
            (case.settings.shade, case.settings.hide, case.settings.interpolation);
        twist_scene(&mut dice, &mut scene, &mut options);
        scene.objects.iter_mut().for_each(|object| twist_object(&mut dice, object));
        let threads = dice.pick(&[0, 1, 3]);
        let pool = || Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap());
        let mut renderer = Renderer::new(RenderOptions {
            pool: (threads > 0).then(pool),
            path: if dice.one_in(8) { RenderPath::Plain } else { RenderPath::Fast },
            coarse: dice.pick(&[CoarseDepth::Off, CoarseDepth::On, CoarseDepth::Auto]),
            ..RenderOptions::default()
        });
        let mut frame =
            Frame { memory: VideoMemory::new(size.0, size.1).unwrap(), format: dice.pick(&DepthFormat::ALL) };
        let mut whole = PathCounts::default();
        let is_known_whole = scene.objects.len() == 1;
        for object in &scene.objects {
            let alone = Scene { objects: vec![object.clone()], ..scene.clone() };
            let options = match is_known_whole {
                true => options.clone(),
                false => SceneOptions { depth_use: DepthUse::Keep, ..options.clone() },
            };
            let (plan, counts, stats, has_depth) = frame.draw(
                &mut renderer,
                |renderer, target| renderer.plan_scene(target, &alone, &options),
                |renderer, target| renderer.draw_scene(target, &alone, &options).unwrap(),
            );
            let want = expected(&plan, object, options.shade, stats.faces_drawn);
            assert_eq!(counts, want, "seed {seed}: {stats:?}\n{plan}");
            assert_stages(&plan, &stats, has_depth);
            for part in [Part::TileRenderer, Part::FacesInOrder] {
                *reasons.entry(plan.item(part).reason).or_default() += 1;
            }
            whole.tiles += counts.tiles;
            whole.vectors += counts.vectors;
            whole.reference += counts.reference;
            // The same as one DRAW, for which plans are made without a renderer.
            if renderer.options().path == RenderPath::Fast {
                let call = DrawCall::of_object(object, &scene, &options);
                let (plan, counts, stats, _) = frame.draw(
                    &mut renderer,
                    |_, target| Plan::of_draw(&call, target),
                    |renderer, target| renderer.draw(target, &call).unwrap(),
                );
                let want = expected(&plan, object, options.shade, stats.faces_drawn);
                assert_eq!(counts, want, "seed {seed}, one draw: {stats:?}\n{plan}");
            }
        }
        let (plan, counts, stats, has_depth) = frame.draw(
            &mut renderer,
            |renderer, target| renderer.plan_scene(target, &scene, &options),
            |renderer, target| renderer.draw_scene(target, &scene, &options).unwrap(),
        );
        assert_eq!(counts, whole, "seed {seed}: other paths than one by one\n{plan}");
        assert_eq!(plan.item(Part::TileRenderer).count, counts.tiles, "seed {seed}\n{plan}");
        assert_stages(&plan, &stats, has_depth);
        sums.tiles += counts.tiles;
        sums.vectors += counts.vectors;
        sums.reference += counts.reference;
    }
    println!("{sums:?}\n{reasons:#?}");
    assert!(sums.tiles > 1500 && sums.vectors > 1500 && sums.reference > 1500, "{sums:?}");
    // Each reason that concerns values, not only states, occurs, and so do most others.
    let of_range = reasons.keys().filter(|reason| reason.contains("out of range")).count();
    assert!(of_range == 5 && reasons.len() >= 18, "{reasons:#?}");
    assert!(reasons.contains_key("the viewport is outside the frame"), "{reasons:#?}");
}

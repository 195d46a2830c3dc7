//! Draws of the tile renderer beyond opaque faces with f32 depth: every depth format, fog, blended
//! faces with textures, and back materials. Compared with the plain path, over vector widths and
//! threads, on frames of many sizes, down to a single pixel.
//!
//! Guards against rarely drawn kinds of scenes on an untested path.

use fbptr::memory::{DepthFormat, DepthMemory, PickBuffer, VideoMemory};
use fbptr::pipeline::{
    DrawStats, Part, RenderOptions, RenderPath, Renderer, SceneOptions, Target, plan_scene,
};
use fbptr::scene::{
    Cull, Fog, FogKind, HiddenSurface, Material, Scene, ShadeMode, TransparencyOrder, Viewport,
};
use fbptr::simd::Level;
use fbptr::truth::scenes::{Random, random};
use glam::DVec3;
use std::str::FromStr;
use std::sync::Arc;

/// A scene and the frame into which it is drawn.
pub struct Shot {
    /// Scene.
    pub scene: Scene,
    /// Options of the draw.
    pub options: SceneOptions,
    /// Format of its depth.
    pub format: DepthFormat,
    /// Width and height of the frame.
    pub size: (u32, u32),
}

/// Result of a draw.
pub struct Drawn {
    /// Colours.
    pub bytes: Vec<u8>,
    words: Vec<u32>,
    ids: Vec<Option<(u32, u32)>>,
    stats: DrawStats,
}

/// Returns a renderer with these vectors, threads and path.
pub fn renderer(level: Level, threads: usize, path: RenderPath) -> Renderer {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let options = RenderOptions::default();
    Renderer::new(RenderOptions { pool: Some(Arc::new(pool)), simd: Some(level), path, ..options })
}

/// Returns the number in an environment variable: of scenes or cases, or the first one's seed.
pub fn from_env<T: FromStr>(name: &str, default: T) -> T {
    std::env::var(name).ok().and_then(|n| n.parse().ok()).unwrap_or(default)
}

/// Returns the plain path.
pub fn plain() -> Renderer {
    Renderer::new(RenderOptions { path: RenderPath::Plain, ..RenderOptions::default() })
}

impl Shot {
    /// Returns a random scene for a frame of this size; the seed decides everything.
    pub fn random(seed: u64, size: (u32, u32)) -> Shot {
        let case = random(seed);
        let mut options = SceneOptions::new(size.0, size.1);
        (options.shade, options.hide, options.interp) =
            (case.settings.shade, case.settings.hide, case.settings.interpolation);
        options.transparency = TransparencyOrder::FileOrder;
        Shot { scene: case.scene, options, format: case.format, size }
    }

    /// Draws the shot twice.
    pub fn draw(&self, renderer: &mut Renderer) -> Drawn {
        let (width, height) = self.size;
        let mut memory = VideoMemory::new(width, height).unwrap();
        let (mut depth, mut ids) = (None, PickBuffer::new(width, height));
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: self.format, ids: Some(&mut ids) };
        // Twice: in the second draw depth, ids and colour already exist, and a clear of the depth
        // may be pending.
        let mut stats = renderer.draw_scene(&mut target, &self.scene, &self.options).unwrap();
        if let Some(depth) = target.depth.as_mut() {
            DepthMemory::clear(depth);
        }
        stats += renderer.draw_scene(&mut target, &self.scene, &self.options).unwrap();
        let pixels = 0..(width * height) as usize;
        let at = |i: usize| ((i as u32 % width) as i32, (i as u32 / width) as i32);
        Drawn {
            bytes: memory.bytes().to_vec(),
            words: depth.iter().flat_map(|d| pixels.clone().map(|i| d.word(i))).collect(),
            ids: pixels.map(at).map(|(x, y)| ids.get(x, y)).collect(),
            stats,
        }
    }
}

/// Returns a step of the format in z; for floats, the difference that their limits allow two paths.
fn step(format: DepthFormat) -> f64 {
    match format {
        DepthFormat::U16 => 1.0 / 65_535.0,
        DepthFormat::U24 => 1.0 / 16_777_215.0,
        DepthFormat::U32 => 1.0 / 4_294_967_295.0,
        DepthFormat::F32 => 8e-7,
        DepthFormat::Reversed => 4.8e-7,
    }
}

#[test]
fn every_depth_format_hidden_surface_method_and_projection_is_drawn_as_by_the_plain_path() {
    let mut fast = Renderer::default();
    let levels = Level::ALL.into_iter().filter(|l| l.is_available());
    let others: Vec<_> = levels.flat_map(|l| [1, 2, 3, 16].map(|t| (l, t))).collect();
    let mut others: Vec<_> = others.into_iter().map(|(l, t)| renderer(l, t, RenderPath::Fast)).collect();
    // Narrower than a vector, one pixel high, partial and full tiles, more than one tile row.
    let sizes = [(1, 1), (3, 70), (16, 1), (17, 33), (131, 20), (290, 70)];
    let hides = [HiddenSurface::ZBuffer, HiddenSurface::Painter, HiddenSurface::None];
    let (mut pixels, mut apart, mut seed) = (0u64, [0u64; 2], 0);
    for format in DepthFormat::ALL {
        for hide in hides {
            for size in sizes {
                for _ in 0..4 {
                    seed += 1;
                    let mut shot = Shot::random(seed, size);
                    (shot.format, shot.options.hide) = (format, hide);
                    if seed % 3 == 0 {
                        // The viewport extends beyond every side of the frame.
                        let (width, height) = (size.0 + 40, size.1 + 30);
                        shot.options.viewport =
                            Viewport { x: -17, y: -9, width, height, ..shot.options.viewport };
                    }
                    let (own, same) = (shot.draw(&mut fast), shot.draw(&mut plain()));
                    assert_eq!(
                        own.stats.pixels_tested, same.stats.pixels_tested,
                        "{format:?} {hide:?} {seed}"
                    );
                    assert_eq!(own.words.len(), same.words.len());
                    pixels += own.ids.len() as u64;
                    apart[0] +=
                        own.bytes.iter().zip(&same.bytes).filter(|(a, b)| a.abs_diff(**b) > 1).count() as u64;
                    let z = |word: &u32| format.decode(*word);
                    let is_apart = |(a, b): &(&u32, &u32)| (z(a) - z(b)).abs() > 1.01 * step(format);
                    apart[1] += own.words.iter().zip(&same.words).filter(is_apart).count() as u64;
                    let count = others.len();
                    let other = shot.draw(&mut others[seed as usize % count]);
                    assert!(
                        own.bytes == other.bytes && own.words == other.words,
                        "{format:?} {hide:?} {seed}"
                    );
                    assert!(own.ids == other.ids && own.stats == other.stats, "{format:?} {hide:?} {seed}");
                }
            }
        }
    }
    println!("{apart:?} of {pixels} pixels are apart in colour and depth");
    assert!(apart[0] * 2000 < pixels && apart[1] * 2000 < pixels, "{apart:?} of {pixels}");
}

#[test]
fn whole_numbers_hold_depths_to_half_a_step_of_the_plain_paths() {
    // Rounding only: where both paths show the same face, depth words are equal but for a tie in a
    // thousand.
    let (mut pixels, mut unlike) = ([0u64; 5], [0u64; 5]);
    for (slot, format) in DepthFormat::ALL.into_iter().enumerate() {
        for seed in 500..530 {
            let mut shot = Shot::random(seed, (200, 90));
            (shot.format, shot.options.hide) = (format, HiddenSurface::ZBuffer);
            let (own, same) = (shot.draw(&mut Renderer::default()), shot.draw(&mut plain()));
            for i in (0..own.words.len()).filter(|&i| own.ids[i].is_some() && own.ids[i] == same.ids[i]) {
                pixels[slot] += 1;
                let off = own.words[i].abs_diff(same.words[i]);
                unlike[slot] += u64::from(off > 0);
            }
        }
    }
    println!("{unlike:?} of {pixels:?}");
    for (format, slot) in [(DepthFormat::U16, 0), (DepthFormat::U24, 1), (DepthFormat::Reversed, 4)] {
        assert!(pixels[slot] > 10_000 && unlike[slot] * 1000 < pixels[slot], "{format:?}: {unlike:?}");
    }
}

#[test]
fn blended_faces_have_the_plain_paths_bytes_with_textures_fog_and_every_depth_format() {
    let mut fast = Renderer::default();
    let (mut textured, mut foggy, mut bytes, mut unlike, mut apart) = (0, 0, 0, Vec::new(), Vec::new());
    // In scene 475 bytes differ if highlights up to a quarter of a step are left out.
    let first = from_env("SEED", 427);
    for seed in first..first + from_env("SCENES", 150) {
        let mut shot = Shot::random(seed, (70, 50));
        let mut dice = Random::new(seed);
        shot.scene.fog = None;
        if seed % 2 == 0 {
            let kind = if seed % 4 == 0 { FogKind::Linear } else { FogKind::Exponential };
            shot.scene.fog =
                Some(Fog { color: dice.point(0.0, 1.0), kind, visibility_range: dice.real(4.0, 12.0) });
            foggy += 1;
        }
        for object in &mut shot.scene.objects {
            object.material.transparency = dice.real(0.1, 0.9);
            // Opaque faces alone would be drawn by deferred shading, whose bytes may be a step apart.
            if let Some(back) = object.back_material.as_mut().filter(|_| object.cull == Cull::Front) {
                back.transparency = object.material.transparency;
            }
            textured += u32::from(object.texture.is_some());
        }
        let (own, same) = (shot.draw(&mut fast), shot.draw(&mut plain()));
        let count = own.bytes.iter().zip(&same.bytes).filter(|(a, b)| a != b).count();
        bytes += own.bytes.len();
        let is_apart = |(a, b): &(&[u8], &[u8])| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) > 1);
        let decided_otherwise = own.bytes.chunks(4).zip(same.bytes.chunks(4)).filter(is_apart).count() as u64
            + own.stats.pixels_written.abs_diff(same.stats.pixels_written);
        if decided_otherwise > 0 {
            apart.push((seed, decided_otherwise));
        } else if count > 0 {
            unlike.push((seed, count));
        }
        for (level, threads) in [(Level::Portable, 3), (Level::best(), 2)] {
            let other = shot.draw(&mut renderer(level, threads, RenderPath::Fast));
            assert!(own.bytes == other.bytes && own.words == other.words, "seed {seed}, {level:?}");
        }
    }
    assert!(textured > 20 && foggy > 50, "{textured} {foggy}");
    // Where a centre lies beside a needle, or on the near or the far plane to the last digits,
    // either answer is right; that each difference is such a case is not verified here.
    println!("{apart:?} pixels were decided otherwise");
    assert!(apart.iter().map(|(_, pixels)| pixels).sum::<u64>() * 1_000_000 <= bytes as u64 / 4, "{apart:?}");
    println!("{unlike:?} of {bytes} bytes");
    // One step, in at most a byte of ten million.
    let off: usize = unlike.iter().map(|(_, count)| count).sum();
    assert!(off * 10_000_000 <= bytes, "{unlike:?} of {bytes} bytes");
}

#[test]
fn fog_and_materials_behind_are_the_tile_renderers_and_look_as_by_the_plain_path() {
    let (mut pixels, mut apart, mut most) = (0u64, 0u64, 0);
    for seed in 1..80 {
        let mut shot = Shot::random(seed, (150, 60));
        let mut dice = Random::new(seed);
        let kind = if seed % 2 == 0 { FogKind::Linear } else { FogKind::Exponential };
        shot.scene.fog =
            Some(Fog { color: dice.point(0.0, 1.0), kind, visibility_range: dice.real(4.0, 12.0) });
        (shot.options.hide, shot.options.shade) = (HiddenSurface::ZBuffer, ShadeMode::Phong);
        for object in &mut shot.scene.objects {
            object.material.transparency = 0.0;
            (object.cull, object.shade) = (Cull::None, None);
            object.two_sided_lighting = seed % 3 > 0;
            let kd = dice.point(0.0, 1.0);
            object.back_material = Some(Material { kd, ka: DVec3::splat(0.1), ..Material::default() });
            // A texture without coordinates is left to the plain path.
            let mesh = &object.geometry.mesh;
            let has_texcoords = mesh.corners.iter().all(|c| (c.texcoord as usize) < mesh.texcoords.len());
            object.texture = object.texture.take().filter(|(t, _)| has_texcoords && !t.has_alpha());
        }
        let (mut memory, mut depth) = (VideoMemory::new(150, 60).unwrap(), None);
        let target = Target { memory: &mut memory, depth: &mut depth, depth_format: shot.format, ids: None };
        let plan = plan_scene(&target, &shot.scene, &shot.options);
        let has_clear_colors =
            shot.scene.objects.iter().any(|o| o.geometry.mesh.colors.iter().any(|c| c.w < 1.0));
        if has_clear_colors {
            continue;
        }
        assert!(plan.uses(Part::TileRenderer) && !plan.uses(Part::FacesInOrder), "{plan}");
        let (own, same) = (shot.draw(&mut Renderer::default()), shot.draw(&mut plain()));
        pixels += own.ids.len() as u64;
        for (a, b) in own.bytes.iter().zip(&same.bytes) {
            apart += u64::from(a.abs_diff(*b) > 1);
            most = most.max(a.abs_diff(*b));
        }
        for (level, threads) in [(Level::Portable, 3), (Level::best(), 16)] {
            let other = shot.draw(&mut renderer(level, threads, RenderPath::Fast));
            assert!(own.bytes == other.bytes && own.words == other.words, "seed {seed}, {level:?}");
        }
    }
    println!("{apart} of {pixels} pixels are apart, at most by {most}");
    assert!(pixels > 100_000 && apart * 5000 < pixels, "{apart} of {pixels}, at most by {most}");
}

#[test]
fn the_plan_names_what_draws_faces_in_order() {
    let mut shot = Shot::random(3, (64, 64));
    shot.options.hide = HiddenSurface::Painter;
    let (mut memory, mut depth) = (VideoMemory::new(64, 64).unwrap(), None);
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format: shot.format, ids: None };
    let plan = plan_scene(&target, &shot.scene, &shot.options);
    assert!(!plan.uses(Part::TileRenderer) && plan.uses(Part::FacesInOrder), "{plan}");
    assert!(
        plan.to_string().contains("+ faces in order") && plan.to_string().contains("in vectors"),
        "{plan}"
    );
    shot.options.shade = ShadeMode::Wire;
    shot.scene.objects.iter_mut().for_each(|o| o.shade = None);
    let plan = plan_scene(&target, &shot.scene, &shot.options);
    assert!(!plan.uses(Part::FacesInOrder) && plan.to_string().contains("SHADE wire"), "{plan}");
    let mut narrow = VideoMemory::new(8, 8).unwrap();
    target.memory = &mut narrow;
    shot.options.shade = ShadeMode::Flat;
    let plan = plan_scene(&target, &shot.scene, &shot.options);
    assert!(!plan.uses(Part::FacesInOrder) && plan.to_string().contains("too narrow"), "{plan}");
}

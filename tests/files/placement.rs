//! Textures that an MTL file places, and that end at their edges.

use fbptr::load::obj;
use fbptr::memory::{DepthFormat, VideoMemory};
use fbptr::pipeline::{RenderOptions, RenderPath, Renderer, SceneOptions, Target};
use fbptr::scene::{Filter, Geometry, NONE, Sampling, Scene, Wrap};
use fbptr::simd::Level;
use std::fs;
use std::path::Path;
use std::sync::Arc;

const SIZE: (u32, u32) = (96, 64);

fn file() -> Geometry {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/meshes/made");
    let text = fs::read(folder.join("clamped.obj")).unwrap();
    let loaded = obj::parse(&text, &mut |name| fs::read(folder.join(name)).ok(), "clamped.obj").unwrap();
    assert_eq!(loaded.warnings, [], "everything that it says is done");
    loaded.geometry
}

fn draw(geometry: Geometry, sampling: Sampling, options: RenderOptions) -> Vec<u8> {
    let mut scene = Scene::of_mesh(Arc::new(geometry), "walls", 1.5, true);
    // Sets the draw's sampling rules; the textures of the materials take the place of this texture.
    let other = scene.objects[0].geometry.textures.iter().flatten().next().cloned();
    scene.objects[0].texture = other.map(|texture| (texture, sampling));
    let mut memory = VideoMemory::new(SIZE.0, SIZE.1).unwrap();
    let (mut depth, depth_format) = (None, DepthFormat::F32);
    let mut target = Target { memory: &mut memory, depth: &mut depth, depth_format, ids: None };
    Renderer::new(options).draw_scene(&mut target, &scene, &SceneOptions::new(SIZE.0, SIZE.1)).unwrap();
    memory.bytes().to_vec()
}

/// Returns the mesh with one material for both walls.
fn both(geometry: &Geometry, material: usize) -> Geometry {
    let mut geometry = geometry.clone();
    for polygon in &mut geometry.mesh.polygons {
        assert_ne!(polygon.material, NONE);
        polygon.material = material as u32;
    }
    geometry
}

#[test]
fn a_clamped_picture_is_one_that_repeats_drawn_with_clamp() {
    let file = file();
    for filter in Filter::ALL.iter().copied() {
        let [repeat, clamp] =
            [Wrap::Repeat, Wrap::Clamp].map(|wrap| Sampling { filter, wrap_s: wrap, wrap_t: wrap });
        for simd in Level::ALL.into_iter().filter(|l| l.is_available()) {
            let tiles = || RenderOptions { simd: Some(simd), ..RenderOptions::default() };
            let plain = || RenderOptions { path: RenderPath::Plain, ..tiles() };
            for options in [&tiles as &dyn Fn() -> RenderOptions, &plain] {
                let ends = draw(both(&file, 0), repeat, options());
                assert!(ends == draw(both(&file, 1), clamp, options()), "{filter:?} {simd:?}");
                assert!(ends == draw(both(&file, 0), clamp, options()), "{filter:?} {simd:?}");
                // The right wall of the file has another material.
                assert!(ends != draw(file.clone(), repeat, options()), "{filter:?} {simd:?}");
            }
        }
    }
}

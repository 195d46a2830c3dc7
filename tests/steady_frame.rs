//! A frame like the last one: nothing is made again.
//!
//! Fear: that drawing asks the system for memory in every frame, and stutters when it is slow to answer.

#[path = "support/counting.rs"]
mod counting;

use counting::steady_calls;
use fbptr::memory::VideoMemory;
use fbptr::pipeline::{DrawCall, RenderOptions, Renderer, Target};
use fbptr::scene::{Geometry, Light, Material, ShadeMode, shapes};
use glam::DVec3;
use std::sync::Arc;

/// Frames that are counted.
const FRAMES: usize = 600;

/// A pool is handed each frame through a queue made of blocks; a block holds this many pieces of work, and is the one thing
/// that is asked for again: rayon's, not ours.
const INJECTOR_BLOCK: usize = 63;

/// The calls that one draw a frame makes in `FRAMES` frames, after some that may.
fn calls_of_steady_frames(options: RenderOptions, shade: ShadeMode) -> usize {
    let (width, height) = (320, 200);
    let geometry = Arc::new(Geometry { mesh: shapes::knot(200, 40).unwrap(), textures: Vec::new() });
    let material = Material { ks: DVec3::splat(0.4), n: 20.0, ..Material::default() };
    let lights = [Light::directional(DVec3::new(-1.0, -1.0, -2.0), DVec3::ONE)];
    let call = DrawCall {
        shared: Some(&geometry),
        lights: &lights,
        shade,
        ..DrawCall::new(&geometry, &material, width, height)
    };
    let mut memory = VideoMemory::new(width, height).unwrap();
    let mut depth = None;
    let mut renderer = Renderer::new(options);
    let frame = || {
        memory.clear(VideoMemory::CLEAR);
        if let Some(depth) = &mut depth {
            fbptr::memory::DepthMemory::clear(depth);
        }
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: Default::default(), ids: None };
        let stats = renderer.draw(&mut target, &call).unwrap();
        assert!(stats.pixels_written > 5000, "{stats:?}");
    };
    steady_calls(8, FRAMES, frame)
}

#[test]
fn a_steady_frame_asks_for_no_memory() {
    for shade in [ShadeMode::Phong, ShadeMode::Gouraud, ShadeMode::Flat] {
        assert_eq!(calls_of_steady_frames(RenderOptions::default(), shade), 0, "{shade:?} on one thread");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let options = RenderOptions { pool: Some(Arc::new(pool)), ..RenderOptions::default() };
        let calls = calls_of_steady_frames(options, shade);
        let most = FRAMES / INJECTOR_BLOCK + 1;
        assert!(calls <= most, "{shade:?}: {calls} calls in {FRAMES} frames of two threads, {most} allowed");
    }
}

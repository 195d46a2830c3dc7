//! A frame like the last one: nothing is made again.
//!
//! Fear: that drawing asks the system for memory in every frame, and stutters when it is slow to answer.

use fbptr::memory::VideoMemory;
use fbptr::pipeline::{DrawCall, Renderer, Target};
use fbptr::scene::{Geometry, Light, Material, shapes};
use glam::DVec3;
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Counts what is asked of the system.
struct Counting;

static CALLS: AtomicUsize = AtomicUsize::new(0);
static BYTES: AtomicUsize = AtomicUsize::new(0);

#[allow(unsafe_code)]
// SAFETY: everything is handed on to the system's allocator as it came.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        CALLS.fetch_add(1, Relaxed);
        BYTES.fetch_add(layout.size(), Relaxed);
        // SAFETY: the caller's promise is the system allocator's.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is the system allocator's.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

#[test]
fn a_steady_frame_makes_nothing_of_the_meshs_or_the_frames_size() {
    let (width, height) = (320, 200);
    let geometry = Arc::new(Geometry { mesh: shapes::knot(200, 40).unwrap(), textures: Vec::new() });
    let material = Material { ks: DVec3::splat(0.4), n: 20.0, ..Material::default() };
    let lights = [Light::directional(DVec3::new(-1.0, -1.0, -2.0), DVec3::ONE)];
    let call = DrawCall {
        shared: Some(&geometry),
        lights: &lights,
        ..DrawCall::new(&geometry, &material, width, height)
    };
    let mut memory = VideoMemory::new(width, height).unwrap();
    let mut depth = None;
    let mut renderer = Renderer::default();
    let mut frame = |counted: &mut [usize; 2]| {
        let before = [CALLS.load(Relaxed), BYTES.load(Relaxed)];
        memory.clear(VideoMemory::CLEAR);
        if let Some(depth) = &mut depth {
            fbptr::memory::DepthMemory::clear(depth);
        }
        let mut target =
            Target { memory: &mut memory, depth: &mut depth, depth_format: Default::default(), ids: None };
        let stats = renderer.draw(&mut target, &call).unwrap();
        assert!(stats.pixels_written > 5000, "{stats:?}");
        *counted = [CALLS.load(Relaxed) - before[0], BYTES.load(Relaxed) - before[1]];
    };
    let (mut first, mut steady) = ([0; 2], [0; 2]);
    frame(&mut first);
    frame(&mut steady);
    for _ in 0..10 {
        let mut again = [0; 2];
        frame(&mut again);
        assert_eq!(again, steady, "calls and bytes of a frame");
    }
    // What is left is the plan and the few lights of this draw: nothing that grows with mesh or frame.
    assert!(
        steady[0] <= 8 && steady[1] <= 4096,
        "{steady:?} calls and bytes a frame, {first:?} in the first"
    );
}

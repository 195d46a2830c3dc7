//! Frame of the 3-D workloads: a renderer with colour and depth buffers, and their comparison with
//! a reference.

use super::check::{Check, Drawn, limit_steps};
use super::{BenchOptions, Workload};
use fbptr_core::memory::{DepthFormat, DepthMemory, Rgba, VideoMemory};
use fbptr_core::pipeline::{Renderer, Target};
use fbptr_truth::TruthPicture;

/// Clear colour (0.1, 0.1, 0.15).
pub(super) const BACKGROUND: Rgba = [26, 26, 38, 255];

/// Renderer with the buffers that it draws into.
pub(super) struct SceneFrame {
    pub renderer: Renderer,
    pub memory: VideoMemory,
    pub depth: Option<DepthMemory>,
    depth_format: DepthFormat,
}

impl SceneFrame {
    /// Allocates a frame of this size, with a renderer of these options.
    pub fn new(options: &BenchOptions, [width, height]: [u32; 2]) -> Self {
        SceneFrame {
            renderer: Renderer::new(options.render.clone()),
            memory: VideoMemory::new(width, height).expect("the size of a benchmark's frame"),
            depth: Some(DepthMemory::new(width, height, options.depth_format)),
            depth_format: options.depth_format,
        }
    }

    /// Returns width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.memory.width(), self.memory.height()]
    }

    /// Clears colours and depths, and draws a frame.
    pub fn draw(&mut self, draw: impl FnOnce(&mut Renderer, &mut Target<'_>)) {
        self.renderer.clear(&mut self.memory, BACKGROUND);
        if let Some(depth) = &mut self.depth {
            depth.clear();
        }
        let (memory, depth, depth_format) = (&mut self.memory, &mut self.depth, self.depth_format);
        draw(&mut self.renderer, &mut Target { memory, depth, depth_format, ids: None });
    }

    /// Draws into other buffers of this size, and returns their picture and depths.
    pub fn plain(&self, draw: impl FnOnce(&mut Target<'_>)) -> (VideoMemory, Option<DepthMemory>) {
        let [width, height] = self.size();
        let mut memory = VideoMemory::new(width, height).expect("there is one of this size already");
        memory.clear(BACKGROUND);
        let mut depth = None;
        draw(&mut Target {
            memory: &mut memory,
            depth: &mut depth,
            depth_format: self.depth_format,
            ids: None,
        });
        (memory, depth)
    }

    /// Returns a cleared reference picture of this size.
    pub fn reference(&self) -> TruthPicture {
        let [width, height] = self.size();
        let mut picture = TruthPicture::new(width, height, self.depth_format);
        picture.clear(BACKGROUND);
        picture
    }

    /// Overwrites all buffers with values that no workload produces.
    pub fn spoil(&mut self) {
        self.memory.clear([1, 254, 77, 3]);
        if let Some(depth) = &mut self.depth {
            let pixels = depth.width() as usize * depth.height() as usize;
            (0..pixels).for_each(|i| depth.set_word(i, 0));
        }
    }

    /// Compares the frame with the plain path's picture and depths; `ask` renders suspect pixels by
    /// the reference.
    pub fn check(
        &self,
        workload: Workload,
        (memory, depth): &(VideoMemory, Option<DepthMemory>),
        ask: impl FnOnce(&[[u32; 2]]) -> TruthPicture,
    ) -> Check {
        match (&self.depth, depth) {
            (Some(own), Some(depth)) => {
                let found = Drawn { memory: &self.memory, depth: own };
                Check::of_space(found, Drawn { memory, depth }, limit_steps(workload), ask)
            }
            _ => Check { coverage_off: memory.bytes().len() / 4, ..Check::default() },
        }
    }

    /// Returns the number of threads that draw.
    pub fn threads(&self) -> usize {
        self.renderer.options().pool.as_ref().map_or(1, |p| p.current_num_threads())
    }
}

//! The frame that every workload in space is drawn on, spoilt on and checked on: a renderer, a frame
//! and its depths.

use super::check::{Check, Drawn, limit_steps};
use super::{BenchOptions, Workload};
use crate::memory::{DepthFormat, DepthMemory, Rgba, VideoMemory};
use crate::pipeline::{Renderer, Target};
use crate::truth::TruthPicture;

/// What colour memory is cleared to: (0.1, 0.1, 0.15).
pub(super) const BACKGROUND: Rgba = [26, 26, 38, 255];

/// A renderer, and the memories that it draws into.
pub(super) struct SceneFrame {
    pub renderer: Renderer,
    pub memory: VideoMemory,
    pub depth: Option<DepthMemory>,
    depth_format: DepthFormat,
}

impl SceneFrame {
    /// A frame of this size, for a renderer as the options want it.
    pub fn new(options: &BenchOptions, [width, height]: [u32; 2]) -> Self {
        SceneFrame {
            renderer: Renderer::new(options.render.clone()),
            memory: VideoMemory::new(width, height).expect("the size of a benchmark's frame"),
            depth: Some(DepthMemory::new(width, height, options.depth_format)),
            depth_format: options.depth_format,
        }
    }

    /// Width and height of the frame.
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

    /// What something else draws on a frame like this one: its picture and depths.
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

    /// A reference's picture of this size, cleared.
    pub fn reference(&self) -> TruthPicture {
        let [width, height] = self.size();
        let mut picture = TruthPicture::new(width, height, self.depth_format);
        picture.clear(BACKGROUND);
        picture
    }

    /// Writes what no workload draws into all of it.
    pub fn spoil(&mut self) {
        self.memory.clear([1, 254, 77, 3]);
        if let Some(depth) = &mut self.depth {
            let pixels = depth.width() as usize * depth.height() as usize;
            (0..pixels).for_each(|i| depth.set_word(i, 0));
        }
    }

    /// Holds what is in the frame to the plain path's picture and depths.
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

    /// Threads that draw.
    pub fn threads(&self) -> usize {
        self.renderer.options().pool.as_ref().map_or(1, |p| p.current_num_threads())
    }
}

//! Arguments of the renderer: threads, vectors and memory. They never change a byte of a picture.

use super::bytes::ByteSize;
use crate::memory::MemoryBudget;
use crate::pipeline::{CoarseDepth, RenderOptions, RenderPath, Renderer};
use crate::server::{default_memory_bytes, worker_pool};
use crate::simd::Level;
use clap::Args;

/// Options of drawing.
#[derive(Clone, Debug, Default, Args)]
pub(super) struct RenderArgs {
    /// Threads that draw [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Vectors that draw: auto, avx512, avx2, neon or portable
    #[arg(long, value_name = "S", value_parser = simd, default_value = "auto")]
    simd: Simd,
    /// Leave faces out first that are hidden in their part of a tile: on, off, or auto, for meshes of which most was hidden before
    #[arg(long, value_name = "on|off|auto", value_parser = coarse, default_value = "auto")]
    coarse: Coarse,
    /// Memory for everything that is asked for, K, M or G: what needs more is done in pieces or refused [default: a quarter of
    /// the machine's, or of its control group's; for the files of `render` and `view`, no limit]
    #[arg(long, value_name = "BYTES")]
    max_memory: Option<ByteSize>,
}

/// Coarse depth, as an argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
struct Coarse(CoarseDepth);

impl std::fmt::Display for Coarse {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self.0 {
            CoarseDepth::Auto => "auto",
            CoarseDepth::On => "on",
            CoarseDepth::Off => "off",
        })
    }
}

fn coarse(text: &str) -> Result<Coarse, String> {
    match text {
        "on" => Ok(Coarse(CoarseDepth::On)),
        "off" => Ok(Coarse(CoarseDepth::Off)),
        "auto" => Ok(Coarse(CoarseDepth::Auto)),
        _ => Err("expected on, off or auto".to_owned()),
    }
}

/// A vector level; `None` is the widest available.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
struct Simd(Option<Level>);

impl std::fmt::Display for Simd {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.map_or("auto", Level::as_str))
    }
}

fn simd(text: &str) -> Result<Simd, String> {
    if text.eq_ignore_ascii_case("auto") {
        return Ok(Simd(None));
    }
    match Level::from_name(text) {
        None => Err("expected auto, avx512, avx2, neon or portable".to_owned()),
        Some(level) if !level.is_available() => Err(format!("this CPU has no {}", level.as_str())),
        level => Ok(Simd(level)),
    }
}

impl RenderArgs {
    /// Creates a renderer with its threads and a memory budget of its own.
    pub(super) fn renderer(&self) -> Renderer {
        self.renderer_within(&self.budget())
    }

    /// Creates a renderer with its threads and the given memory budget.
    pub(super) fn renderer_within(&self, budget: &MemoryBudget) -> Renderer {
        let mut renderer = Renderer::new(self.options());
        renderer.set_budget(budget);
        renderer
    }

    /// Creates the memory budget.
    pub(super) fn budget(&self) -> MemoryBudget {
        MemoryBudget::new(self.memory_bytes())
    }

    /// Returns the budget for reading the scene's files: `budget` if its size was asked for. The
    /// default size refuses no file, as estimates of what a file needs are about three times high.
    pub(super) fn reading_budget(&self, budget: &MemoryBudget) -> MemoryBudget {
        match self.max_memory {
            Some(_) => budget.clone(),
            None => MemoryBudget::unlimited(),
        }
    }

    /// Returns the memory budget in bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.max_memory.map_or_else(default_memory_bytes, |size| size.0)
    }

    /// Returns the SIMD level, `None` for the widest available, and the threads, if they are given.
    pub(super) fn level_and_threads(&self) -> (Option<Level>, Option<usize>) {
        (self.simd.0, self.threads.map(usize::from))
    }

    /// Returns the options of a renderer, including its threads.
    pub(super) fn options(&self) -> RenderOptions {
        RenderOptions {
            pool: worker_pool(self.threads.map(usize::from)),
            simd: self.simd.0,
            path: RenderPath::Fast,
            coarse: self.coarse.0,
            ..RenderOptions::default()
        }
    }
}

//! What one connection has of its own: offset, blend, camera, matrices, lights, material, modes, names, counters.
//!
//! It starts as pipeline.md's "settled points" say, and goes with its connection. Nothing in it is shared.

use super::record::FileSet;
use super::{Limits, ResourceTable, Stats};
use crate::command::{ErrorMode, Quality};
use crate::draw2d::Blend;
use crate::memory::Reservation;
use crate::scene::{
    Camera, Cull, HiddenSurface, Interpolation, Light, Material, Sampling, ShadeMode, Viewport,
};
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Who hears of a connection's errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audience {
    /// The connection itself, among its replies, once it has used a verb beyond Pixelflut's, or as `ERRORS` settles it.
    Connection,
    /// Whoever started it (`play`, a [`super::Client`]): every error, beside the replies.
    Owner,
}

/// Where a connection's commands find the files that they name.
#[derive(Debug)]
pub(super) enum FileAccess {
    /// In the load folder.
    LoadFolder,
    /// In the recording that is replayed; these are for the next command that reads files.
    Recording(Arc<FileSet>),
}

/// The state of one connection.
#[derive(Debug)]
pub struct Session {
    /// The connection's number, from 1; 0 is the shared file.
    pub id: u64,
    /// `OFFSET`, for text PX.
    pub offset: [i32; 2],
    /// `BLEND`
    pub blend: Blend,
    /// Who hears of errors.
    pub audience: Audience,
    /// What `ERRORS` said; `None` before it is settled.
    pub error_mode: Option<ErrorMode>,
    /// Whether a verb beyond Pixelflut's was used.
    pub has_used_other_verbs: bool,
    /// Eye and projection.
    pub camera: Camera,
    /// Whether the camera was set since the last `SCENE`, which brings its own.
    pub has_own_camera: bool,
    /// Lights set since the last `SCENE`, which brings its own.
    pub own_lights: BTreeMap<usize, Option<Light>>,
    /// `VIEWPORT`; `None` is the whole frame with the default rule.
    pub viewport: Option<Viewport>,
    /// The model matrix.
    pub model: DMat4,
    /// `PUSH` and `POP`.
    pub stack: Vec<DMat4>,
    /// `AMBIENT`
    pub ambient: DVec3,
    /// `LIGHT i`; `None` where there is none.
    pub lights: Vec<Option<Light>>,
    /// `MATERIAL`
    pub material: Material,
    /// `TEXTURE`: the name bound, with its rules.
    pub texture: Option<(String, Sampling)>,
    /// `SHADE`
    pub shade: ShadeMode,
    /// `CULL`
    pub cull: Cull,
    /// `HIDE`
    pub hide: HiddenSurface,
    /// `INTERP`
    pub interp: Interpolation,
    /// `QUALITY`
    pub quality: Quality,
    /// Its private names.
    pub names: ResourceTable,
    /// `AUTO on`: the display follows the memory.
    pub auto: bool,
    /// `EVENTS on`
    pub events: bool,
    /// What files said that their author should know, until the owner hears it.
    pub warnings: Vec<String>,
    /// What explains the command that has just run, until it is said.
    pub remark: Option<&'static str>,
    /// Why draws showed nothing: the reasons that were explained already, a bit each.
    pub(super) explained_draws: u8,
    /// Where its commands find files.
    pub(super) file_access: FileAccess,
    /// What its matrices hold of the memory budget.
    pub(super) held: Option<Reservation>,
    /// The memory reserved for the payload of the current command, until the command takes it over.
    pub(super) payload_held: Option<Reservation>,
    /// What it did.
    pub stats: Stats,
    /// The part of `stats` that is already in the totals.
    pub(super) counted: Stats,
}

impl Session {
    /// A fresh connection.
    pub fn new(id: u64, audience: Audience) -> Self {
        Session {
            id,
            offset: [0, 0],
            blend: Blend::Replace,
            audience,
            error_mode: None,
            has_used_other_verbs: false,
            camera: Camera::default(),
            has_own_camera: false,
            own_lights: BTreeMap::new(),
            viewport: None,
            model: DMat4::IDENTITY,
            stack: Vec::new(),
            ambient: DVec3::ZERO,
            lights: Vec::new(),
            material: Material::default(),
            texture: None,
            shade: ShadeMode::default(),
            cull: Cull::default(),
            hide: HiddenSurface::default(),
            interp: Interpolation::default(),
            quality: Quality::Exact,
            names: ResourceTable::default(),
            auto: true,
            events: false,
            warnings: Vec::new(),
            remark: None,
            explained_draws: 0,
            file_access: FileAccess::LoadFolder,
            held: None,
            payload_held: None,
            stats: Stats::default(),
            counted: Stats::default(),
        }
    }

    /// Whether an error is told to the audience, and not just counted.
    pub fn reports_errors(&self) -> bool {
        match (self.audience, self.error_mode) {
            (Audience::Owner, _) => true,
            (Audience::Connection, Some(mode)) => mode != ErrorMode::Count,
            (Audience::Connection, None) => self.has_used_other_verbs,
        }
    }

    /// Whether the first error ends the connection.
    pub fn closes_on_error(&self) -> bool {
        self.error_mode == Some(ErrorMode::Close)
    }

    /// Counts pixels, each a command, of which so many were stored.
    pub(super) fn count_pixels(&mut self, commands: usize, stored: u64) {
        self.stats.commands += commands as u64;
        self.stats.pixels += stored;
        self.stats.clipped += commands as u64 - stored;
    }

    /// Sets or clears light `index`.
    pub(super) fn set_light(&mut self, index: usize, light: Option<Light>) {
        self.own_lights.insert(index, light);
        if self.lights.len() <= index && light.is_some() {
            self.lights.resize(index + 1, None);
        }
        if let Some(slot) = self.lights.get_mut(index) {
            *slot = light;
        }
    }

    /// The viewport over a frame of this size.
    pub fn viewport_on(&self, width: u32, height: u32) -> Viewport {
        self.viewport.unwrap_or(Viewport { x: 0, y: 0, width, height, rule: Default::default() })
    }

    /// Whether one more matrix fits.
    pub(super) fn has_stack_room(&self, limits: &Limits) -> bool {
        self.stack.len() < limits.matrix_stack
    }
}

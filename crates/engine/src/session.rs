//! State of one connection: offset, blend, camera, matrices, lights, material, modes, names,
//! counters.
//!
//! It begins with the defaults that pipeline.md lists under "settled points", ends with its
//! connection, and is shared with no other.

use super::read_files::FileSet;
use super::surfaces::Surfaces;
use super::{Limits, ResourceTable, Stats};
use fbptr_command::{ErrorMode, Quality};
use fbptr_core::draw2d::Blend;
use fbptr_core::memory::Reservation;
use fbptr_core::scene::{
    Camera, Cull, HiddenSurface, Interpolation, Light, Material, Sampling, ShadeMode, Viewport,
};
use glam::{DMat4, DVec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Receiver of a connection's errors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Audience {
    /// The connection itself, among its replies, once it has used a verb beyond Pixelflut's, or as
    /// `ERRORS` selects.
    Connection,
    /// The owner who started it (`play`, a `Client`): gets every error, beside the
    /// replies.
    Owner,
}

/// Source of the files that a connection's commands name.
#[derive(Debug)]
pub enum FileAccess {
    /// The load folder.
    LoadFolder,
    /// The recording that is replayed; these files are for the next command that reads any.
    Recording(Arc<FileSet>),
}

/// View of a connection that sets neither camera nor light.
#[derive(Clone, Debug, Default)]
pub(super) enum DefaultView {
    /// The next mesh is framed.
    #[default]
    Unset,
    /// A mesh was framed by this camera, and `CLEAR` has not ended that.
    Framed(Box<Camera>),
    /// The connection has a view of its own.
    Own,
}

impl DefaultView {
    /// Returns the word of `STATS`.
    pub fn word(&self) -> &'static str {
        match self {
            DefaultView::Unset => "unset",
            DefaultView::Framed(_) => "default",
            DefaultView::Own => "own",
        }
    }

    /// Returns the sentence of `--explain`.
    pub fn explanation(&self) -> &'static str {
        match self {
            DefaultView::Unset => "none; the stream has set no camera and no light",
            DefaultView::Framed(_) => {
                "default: the first mesh framed and lit from the eye, until CLEAR; the stream has set no \
                 camera and no light"
            }
            DefaultView::Own => "the stream's own camera and lights",
        }
    }
}

/// The state of one connection.
#[derive(Debug)]
pub struct Session {
    /// Number of the connection, from 1; 0 is the shared file.
    pub id: u64,
    /// Offset of text PX commands, set by `OFFSET`.
    pub offset: [i32; 2],
    /// Blend mode, set by `BLEND`.
    pub blend: Blend,
    /// Magnification of letters, set by `TEXTSIZE`.
    pub text_size: u8,
    /// Its canvases, its target and its clip rectangle.
    pub surfaces: Surfaces,
    /// Receiver of its errors.
    pub audience: Audience,
    /// Mode set by `ERRORS`; `None` if it was not used.
    pub error_mode: Option<ErrorMode>,
    /// Set once a verb beyond Pixelflut's was used.
    pub has_used_other_verbs: bool,
    /// Camera: position and projection.
    pub camera: Camera,
    /// Set if the camera was set since the last `SCENE`, which has one of its own.
    pub has_own_camera: bool,
    /// Lights set since the last `SCENE`, which has lights of its own.
    pub own_lights: BTreeMap<usize, Option<Light>>,
    /// View of meshes until one was set.
    pub(super) default_view: DefaultView,
    /// Viewport, set by `VIEWPORT`; `None` is the full frame with the default rule.
    pub viewport: Option<Viewport>,
    /// Model matrix.
    pub model: DMat4,
    /// Matrix stack of `PUSH` and `POP`.
    pub stack: Vec<DMat4>,
    /// Ambient light, set by `AMBIENT`.
    pub ambient: DVec3,
    /// Lights by their index in `LIGHT i`; `None` if there is none.
    pub lights: Vec<Option<Light>>,
    /// Material, set by `MATERIAL`.
    pub material: Material,
    /// Name and sampling of the bound texture, set by `TEXTURE`.
    pub texture: Option<(String, Sampling)>,
    /// Shading mode, set by `SHADE`.
    pub shade: ShadeMode,
    /// Face culling, set by `CULL`.
    pub cull: Cull,
    /// Hidden-surface method, set by `HIDE`.
    pub hide: HiddenSurface,
    /// Interpolation mode, set by `INTERP`.
    pub interp: Interpolation,
    /// Quality, set by `QUALITY`.
    pub quality: Quality,
    /// Resources of this connection.
    pub names: ResourceTable,
    /// True if the display follows the memory, set by `AUTO`.
    pub auto: bool,
    /// True if the client listens to events, set by `EVENTS`.
    pub events: bool,
    /// Warnings about files, until they are reported to the owner.
    pub warnings: Vec<String>,
    /// Explanation of the command that has just run, until it is reported.
    pub remark: Option<&'static str>,
    /// Reasons of empty draws that were explained already, one bit each.
    pub(super) explained_draws: u16,
    /// Source of files for its commands.
    pub file_access: FileAccess,
    /// The memory budget's reservation for its matrices.
    pub(super) held: Option<Reservation>,
    /// The memory reserved for the payload of the current command, until the command takes it over.
    pub(super) payload_held: Option<Reservation>,
    /// Set once its client is gone: commands that only answer, and waits, are passed over.
    pub is_unread: bool,
    /// Counters of this connection.
    pub stats: Stats,
    /// The part of `stats` that is already in the totals.
    pub(super) counted: Stats,
}

impl Session {
    /// Creates the state of a new connection.
    pub fn new(id: u64, audience: Audience) -> Self {
        Session {
            id,
            offset: [0, 0],
            blend: Blend::Replace,
            text_size: 1,
            surfaces: Surfaces::default(),
            audience,
            error_mode: None,
            has_used_other_verbs: false,
            camera: Camera::default(),
            has_own_camera: false,
            own_lights: BTreeMap::new(),
            default_view: DefaultView::Unset,
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
            is_unread: false,
            stats: Stats::default(),
            counted: Stats::default(),
        }
    }

    /// Returns the camera through which a mesh is seen: that of the default view, if a mesh was framed
    /// by it.
    pub fn seen_camera(&self) -> Camera {
        match &self.default_view {
            DefaultView::Framed(camera) => **camera,
            DefaultView::Unset | DefaultView::Own => self.camera,
        }
    }

    /// Returns whether errors are reported to the audience, and not only counted.
    pub fn reports_errors(&self) -> bool {
        match (self.audience, self.error_mode) {
            (Audience::Owner, _) => true,
            (Audience::Connection, Some(mode)) => mode != ErrorMode::Count,
            (Audience::Connection, None) => self.has_used_other_verbs,
        }
    }

    /// Returns the width and height in pixels of the canvas that commands draw on; `None` if they draw
    /// on the frame.
    pub fn canvas_size(&self) -> Option<[u32; 2]> {
        self.surfaces.target_size()
    }

    /// Returns whether the first error ends the connection.
    pub fn closes_on_error(&self) -> bool {
        self.error_mode == Some(ErrorMode::Close)
    }

    /// Counts pixels that were sent, of which `stored` were on the frame.
    pub(super) fn count_pixels(&mut self, sent: usize, stored: u64) {
        self.stats.pixels += stored;
        self.stats.clipped += sent as u64 - stored;
    }

    /// Sets or clears light `index`.
    pub(super) fn set_light(&mut self, index: usize, light: Option<Light>) {
        self.default_view = DefaultView::Own;
        self.own_lights.insert(index, light);
        if self.lights.len() <= index && light.is_some() {
            self.lights.resize(index + 1, None);
        }
        if let Some(slot) = self.lights.get_mut(index) {
            *slot = light;
        }
    }

    /// Returns the viewport in a frame of this size.
    pub fn viewport_on(&self, width: u32, height: u32) -> Viewport {
        self.viewport.unwrap_or(Viewport { x: 0, y: 0, width, height, rule: Default::default() })
    }

    /// Returns whether one more matrix fits on the stack.
    pub(super) fn has_stack_room(&self, limits: &Limits) -> bool {
        self.stack.len() < limits.matrix_stack
    }
}

//! The modes of a draw, as the reference renderer takes them.

use fbptr_core::scene::{Cull, HiddenSurface, Interpolation, ShadeMode, TransparencyOrder, Viewport};

/// Drawing order of transparent faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Transparency {
    /// In submission order, among the other faces: each object is one `DRAW`.
    #[default]
    AtOnce,
    /// After the opaque faces: `DRAWSCENE` and files.
    AfterOpaque(TransparencyOrder),
}

/// Modes of a draw.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Settings {
    /// Rectangle of the picture to draw into; `None` is the whole frame, with the `corners` rule.
    pub viewport: Option<Viewport>,
    /// Shading of objects without a shading mode of their own.
    pub shade: ShadeMode,
    /// Hidden-surface removal.
    pub hide: HiddenSurface,
    /// Interpolation of attributes across a face.
    pub interpolation: Interpolation,
    /// Culling in place of the objects' own; `None` keeps theirs.
    pub cull: Option<Cull>,
    /// Drawing order of transparent faces.
    pub transparency: Transparency,
}

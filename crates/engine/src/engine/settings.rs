//! The commands that set a state of their connection and can fail by nothing else than their values:
//! offset, blending, model matrix, material, drawing modes.
//!
//! In: values of one session. Out: the session's state.

use super::{Call, Effect, Engine};
use crate::Session;
use crate::session::DefaultView;
use fbptr_command::{ErrorMode, Quality, Shears};
use fbptr_core::draw2d::Blend;
use fbptr_core::error::{Code, Fault};
use fbptr_core::math::matrix;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{Cull, HiddenSurface, Interpolation, Material, ShadeMode};
use glam::{DMat4, DVec3, DVec4};
use std::time::Duration;

/// The connection.
impl Engine {
    pub(super) fn set_offset(&self, s: &mut Session, x: i32, y: i32) {
        s.offset = [x, y];
    }

    pub(super) fn set_error_mode(&self, s: &mut Session, mode: ErrorMode) {
        s.error_mode = Some(mode);
    }

    /// Runs `SIZE w h`: whoever plays the file has made the frame of this size, or of another one
    /// that was asked for.
    pub(super) fn set_size(&self, s: &mut Session, _w: i32, _h: i32) -> Result<(), Fault> {
        match self.takes_size && s.stats.commands == 1 {
            true => Ok(()),
            false => {
                let message =
                    "the size is set by the first command of a file that is played, and nowhere else";
                Err(Fault::new(Code::Perm, message))
            }
        }
    }

    /// Runs `TITLE`: the observer that has a window shows it.
    pub(super) fn set_title(&self, _: &mut Session, _text: String) {}

    pub(super) fn pause(&self, _: &mut Session, seconds: f64) -> Effect {
        Effect::Pause(Duration::from_secs_f64(seconds.clamp(0.0, 60.0)))
    }

    pub(super) fn sync(&self, call: &mut Call<'_>, tag: String) {
        call.answer(format_args!("SYNC {tag}"));
    }

    pub(super) fn quit(&self, _: &mut Session) -> Effect {
        Effect::Quit
    }
}

/// Drawing modes.
impl Engine {
    pub(super) fn set_blend(&self, s: &mut Session, over: bool) {
        s.blend = if over { Blend::Over } else { Blend::Replace };
    }

    pub(super) fn set_text_size(&self, s: &mut Session, size: i32) {
        s.text_size = size.clamp(1, 8) as u8;
    }

    pub(super) fn set_ambient(&self, s: &mut Session, color: DVec3) {
        s.ambient = color;
        s.default_view = DefaultView::Own;
    }

    #[expect(clippy::boxed_local, reason = "the command holds it in a box, for its size")]
    pub(super) fn set_material(&self, s: &mut Session, material: Box<Material>) {
        s.material = *material;
    }

    pub(super) fn set_shade(&self, s: &mut Session, mode: ShadeMode) {
        s.shade = mode;
    }

    pub(super) fn set_cull(&self, s: &mut Session, mode: Cull) {
        s.cull = mode;
    }

    pub(super) fn set_hide(&self, s: &mut Session, mode: HiddenSurface) {
        s.hide = mode;
    }

    pub(super) fn set_interpolation(&self, s: &mut Session, mode: Interpolation) {
        s.interp = mode;
    }

    pub(super) fn set_quality(&self, s: &mut Session, quality: Quality) {
        s.quality = quality;
    }

    /// Sets the format of the depth buffer, which all connections share.
    pub(super) fn set_depth_format(&mut self, _: &mut Session, format: DepthFormat) {
        self.framebuffer.set_depth_format(format);
    }
}

/// The model matrix.
impl Engine {
    pub(super) fn reset_model(&self, s: &mut Session) {
        s.model = DMat4::IDENTITY;
    }

    pub(super) fn translate_model(&self, s: &mut Session, by: DVec3) -> Result<(), Fault> {
        self.multiply_model(s, matrix::translate(by))
    }

    pub(super) fn scale_model(&self, s: &mut Session, by: DVec3) -> Result<(), Fault> {
        self.multiply_model(s, matrix::scale(by))
    }

    pub(super) fn rotate_model(&self, s: &mut Session, axis: DVec3, angle_rad: f64) -> Result<(), Fault> {
        let by = matrix::rotate(axis, angle_rad)
            .ok_or_else(|| Fault::new(Code::Range, "a rotation's axis has a direction, 0 0 0 has none"))?;
        self.multiply_model(s, by)
    }

    #[expect(clippy::boxed_local, reason = "the command holds it in a box, for its size")]
    pub(super) fn shear_model(&self, s: &mut Session, by: Box<Shears>) -> Result<(), Fault> {
        self.multiply_model(s, matrix::shear(by[0], by[1], by[2], by[3], by[4], by[5]))
    }

    /// Multiplies the model matrix by one whose last row is checked.
    #[expect(clippy::boxed_local, reason = "the command holds it in a box, for its size")]
    pub(super) fn multiply_affine(&self, s: &mut Session, by: Box<DMat4>) -> Result<(), Fault> {
        let row = by.row(3);
        if row != DVec4::W {
            let found = format!("{} {} {} {}", row.x, row.y, row.z, row.w);
            return Err(Fault::new(Code::Range, "a model matrix's last row is 0 0 0 1").got(found));
        }
        self.multiply_model(s, *by)
    }

    fn multiply_model(&self, s: &mut Session, by: DMat4) -> Result<(), Fault> {
        let product = s.model * by;
        if !product.is_finite() {
            return Err(Fault::new(Code::Range, "the model matrix would hold a number that is not finite"));
        }
        s.model = product;
        Ok(())
    }
}

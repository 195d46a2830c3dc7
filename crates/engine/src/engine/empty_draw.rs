//! Draws that show nothing: counts them for `STATS`, and explains them to clients that get errors.
//!
//! In: the reason that the pipeline finds ([`EmptyDraw`]). Out: a remark, once for each reason and
//! connection. Runs on the render thread, after the draw.

use crate::Session;
use fbptr_core::pipeline::EmptyDraw;

/// Returns the explanation of a reason, one line.
fn text(reason: EmptyDraw) -> &'static str {
    match reason {
        EmptyDraw::NoContent => "nothing is drawn: there are no faces, lines or points in it",
        EmptyDraw::NoViewport => "nothing is drawn: no pixel of the frame lies in its viewport or rectangle",
        EmptyDraw::NoLight => {
            "all of it is black: there is no light (LIGHT i ..., or AMBIENT with a MATERIAL whose ka is not 0)"
        }
        EmptyDraw::Transparent => "nothing is seen: all of it is fully transparent",
        EmptyDraw::Culled => "nothing is drawn: CULL leaves out all faces in view (CULL none draws them)",
        EmptyDraw::BehindEye => "nothing is drawn: all of it lies behind the eye",
        EmptyDraw::OutsideView => "nothing is drawn: all of it lies outside the view",
        EmptyDraw::TooSmall => "nothing is drawn: no face covers the centre of a pixel",
        EmptyDraw::Hidden => {
            "nothing is drawn: all its pixels lie behind what is there (CLEAR resets depths), or outside near and far"
        }
        EmptyDraw::Clipped => {
            "nothing is drawn: no pixel of it lies in the clip rectangle (CLIP OFF draws everywhere)"
        }
    }
}

/// Counts a draw that shows nothing, and explains it if the client gets errors and has not been
/// sent this reason before.
pub(super) fn note(s: &mut Session, empty: Option<EmptyDraw>) {
    let Some(reason) = empty else { return };
    let bit = 1 << reason as u16;
    s.stats.empty_draws += 1;
    if s.reports_errors() && s.explained_draws & bit == 0 {
        s.explained_draws |= bit;
        s.remark = Some(text(reason));
    }
}

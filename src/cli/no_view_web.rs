//! Builds without the page in the browser: a viewer has none.

use super::web::PreparedWeb;
use crate::viewer::Viewer;

/// A page that never runs.
pub(super) enum ViewerPage {}

impl ViewerPage {
    /// Cannot be called.
    pub fn start(web: PreparedWeb, _: &Viewer) -> Result<ViewerPage, String> {
        web.never()
    }

    /// Cannot be called.
    pub fn step(&mut self, _: &mut Viewer, _: bool) -> bool {
        match *self {}
    }
}

//! Builds without the page in the browser: there are no arguments for it, and nothing is served.

use crate::server::{Engine, RenderThread, Server};
use clap::Args;

/// No arguments.
#[derive(Debug, Args)]
pub(super) struct WebArgs {}

/// A page that never runs.
pub(super) enum WebPage {}

impl Drop for WebPage {
    fn drop(&mut self) {
        match *self {}
    }
}

/// A page that is never prepared.
#[derive(Debug)]
pub(super) enum PreparedWeb {}

impl WebArgs {
    /// Returns false.
    pub fn is_wanted(&self) -> bool {
        false
    }

    /// Returns zero.
    pub fn descriptors(&self) -> usize {
        0
    }

    /// Returns `None`.
    pub fn prepare(&self, _: bool) -> Result<Option<PreparedWeb>, String> {
        Ok(None)
    }
}

impl PreparedWeb {
    /// Cannot be called.
    pub fn attach(&mut self, _: &mut Engine) {
        match *self {}
    }

    /// Cannot be called.
    pub fn never<T>(self) -> T {
        match self {}
    }

    /// Cannot be called.
    pub fn serve(self, _: &Server) -> Result<WebPage, String> {
        match self {}
    }

    /// Cannot be called.
    pub fn serve_thread(self, _: &RenderThread) -> Result<WebPage, String> {
        match self {}
    }
}

//! Warnings collected while a scene is read: limited in number, without duplicates, sorted by file
//! and line.

use super::build::{Builder, File};
use super::graph::Origin;
use crate::load::{FilePosition, LoadWarning};
use roxmltree::Node as Element;
use std::collections::HashSet;

/// Most warnings of a scene.
const MAX_WARNINGS: usize = 1_000;

/// End of a message that stands for all nodes of a type in its file.
pub(super) const REPEATED: &str = "here and wherever it comes again";

/// Warnings of a scene so far.
#[derive(Default)]
pub(super) struct Remarks {
    warnings: Vec<LoadWarning>,
    /// Warnings already given, with their positions: further instances of a prototype repeat none.
    said: HashSet<(usize, usize, String)>,
    /// Messages already given about types of nodes, by file.
    of_types: HashSet<(usize, String)>,
    /// True if a name was refused because it leads out of the root.
    pub(super) names_outside: bool,
}

impl Builder<'_, '_> {
    /// Adds a warning at an element, as [`Builder::warn_at`] does.
    pub(super) fn warn(&mut self, file: &File, element: Element, message: String) {
        let origin = Origin { source: file.source, byte: element.range().start };
        self.warn_at(origin, message);
    }

    /// Adds a warning, up to the limit and without duplicates.
    pub(super) fn warn_at(&mut self, origin: Origin, message: String) {
        if self.has_room() && self.remarks.said.insert((origin.source, origin.byte, message.clone())) {
            let place = self.place(origin);
            self.remarks.warnings.push(LoadWarning { place, message });
        }
    }

    /// Adds a warning about a file as a whole.
    pub(super) fn warn_of_file(&mut self, source: usize, message: String) {
        if self.has_room() {
            let place = FilePosition::file(&self.sources[source].name);
            self.remarks.warnings.push(LoadWarning { place, message });
        }
    }

    /// Returns whether there is room for a warning; the first one beyond the limit is replaced with
    /// a last one that says so.
    fn has_room(&mut self) -> bool {
        let count = self.remarks.warnings.len();
        if count == MAX_WARNINGS {
            let place = FilePosition::file(&self.sources[0].name);
            let message = "further warnings are left out".into();
            self.remarks.warnings.push(LoadWarning { place, message });
        }
        count < MAX_WARNINGS
    }

    /// Warns that a node type is not supported, at its first use in a file.
    pub(super) fn left_out(&mut self, file: &File, element: Element, why: &str) {
        let name = element.tag_name().name();
        self.once(file, element, format!("<{name}> is left out, {REPEATED}: {why}"));
    }

    /// Adds a warning about a type of nodes, at its first use in a file.
    pub(super) fn once(&mut self, file: &File, element: Element, message: String) {
        // Beyond the limit nothing is stored.
        let has_room = self.remarks.warnings.len() <= MAX_WARNINGS;
        if has_room && self.remarks.of_types.insert((file.source, message.clone())) {
            self.warn(file, element, message);
        }
    }

    /// Returns the warnings in the order of the files and of their lines.
    pub(super) fn sorted_warnings(&mut self) -> Vec<LoadWarning> {
        let mut warnings = std::mem::take(&mut self.remarks.warnings);
        let rank = |w: &LoadWarning| {
            let file = self.sources.iter().position(|s| s.name == w.place.file);
            (file, w.place.line, w.place.column)
        };
        // The one beyond the limit says that there were more, and stays last.
        let count = warnings.len().min(MAX_WARNINGS);
        warnings[..count].sort_by_cached_key(rank);
        warnings
    }

    /// Returns the position of an origin in its file.
    pub(super) fn place(&self, origin: Origin) -> FilePosition {
        self.sources[origin.source].place(origin.byte)
    }
}

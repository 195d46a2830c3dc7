//! Files of Inline and ExternProtoDeclare that cannot be used: the reason in words, and removal of
//! what they have added to the graph.
//!
//! URLs are in order of preference, and the first file that can be used is taken (ISO/IEC 19775-1
//! clause 9.2.1). Where there is none, the node is skipped with a warning and the rest of the scene
//! is shown. Limits, Inlines in a cycle and prototypes in themselves remain errors of the scene.

use super::build::{Builder, InlineFile};
use super::classic;
use super::graph::NodeId;
use crate::load::{LoadError, LoadErrorKind};
use std::rc::Rc;

/// Most of the first bytes that are searched for those of a binary format.
const FIRST_BYTES: usize = 256;

/// State of the graph before a file, or before an instance of a prototype in another file.
pub(super) struct Mark {
    nodes: usize,
    routes: usize,
    instances: usize,
    shared: usize,
    meshes: usize,
}

impl Mark {
    /// Returns the first node that is added after this state.
    pub(super) fn first(&self) -> NodeId {
        self.nodes as NodeId
    }
}

impl Builder<'_, '_> {
    /// Returns the present state, for [`Builder::set_aside`].
    pub(super) fn mark(&self) -> Mark {
        Mark {
            nodes: self.graph.nodes.len(),
            routes: self.graph.routes.len(),
            instances: self.protos.instances.len(),
            shared: self.protos.shared_count(),
            meshes: self.meshes.count(),
        }
    }

    /// Undoes what a file with an error has added, and returns the reason why it cannot be used. An
    /// error that concerns more than this file is returned as such.
    #[inline(never)]
    pub(super) fn set_aside(&mut self, mark: &Mark, error: LoadError) -> Result<Rc<str>, LoadError> {
        use LoadErrorKind as Kind;
        match error.kind {
            Kind::TooBig { .. } | Kind::OverQuota { .. } | Kind::OverBudget(_) | Kind::Cancelled => {
                Err(error)
            }
            _ if self.has_cycle => Err(error),
            Kind::Syntax { .. }
            | Kind::Number { .. }
            | Kind::Range { .. }
            | Kind::Index { .. }
            | Kind::Missing { .. }
            | Kind::Undecodable { .. } => {
                self.roll_back(mark);
                Ok(error.to_string().into())
            }
        }
    }

    /// Removes everything that refers to nodes added since `mark`: their indices are given again.
    ///
    /// Other traces stay, out of reach: text and declarations of the file, pictures, and the
    /// reservations of all this, which are then larger than necessary. So do its warnings, and the
    /// counts of routes, faces and nodes of prototypes, which limit the work.
    fn roll_back(&mut self, mark: &Mark) {
        let first = mark.first();
        for id in first..self.graph.nodes.len() as NodeId {
            self.graph.textures.remove(&id);
            self.graph.skies.remove(&id);
            self.graph.inlined.remove(&id);
            self.graph.missing.remove(&id);
        }
        self.graph.nodes.truncate(mark.nodes);
        self.graph.routes.truncate(mark.routes);
        self.protos.instances.truncate(mark.instances);
        self.protos.unshare(mark.shared);
        self.meshes.truncate(mark.meshes);
        // Files that the removed nodes refer to are read again where others refer to them.
        self.inlined.retain(|_, file| !matches!(file, InlineFile::Read(read) if read.scene >= first));
    }
}

/// Returns the name of the format that a file's first bytes show, if it is not X3D.
pub(super) fn other_format(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let is_utf16 = matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]);
    match text {
        _ if text.starts_with(b"#VRML V1") => Some("it is VRML 1.0, whose nodes X3D does not have"),
        _ if classic::is_classic(bytes) => None,
        _ if text.starts_with(b"glTF") => Some("it is a binary glTF model"),
        _ if text.starts_with(b"\xe0\0\0\x01") => Some("it is X3D in the binary encoding, not in XML"),
        _ if text.trim_ascii_start().starts_with(b"{") => Some("it is JSON, as glTF models are, not XML"),
        _ if !is_utf16 && text[..text.len().min(FIRST_BYTES)].contains(&0) => {
            Some("it is binary data, not XML")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::other_format;

    #[test]
    fn first_bytes_tell_other_formats_from_xml() {
        for (bytes, expected) in [
            (&b"#VRML V1.0 ascii\nSeparator {}"[..], "it is VRML 1.0"),
            (b"glTF\x02\0\0\0", "a binary glTF model"),
            (b"\xe0\0\0\x01\0", "in the binary encoding"),
            (b" \n{\"asset\":{}}", "it is JSON"),
            (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "binary data"),
        ] {
            let found = other_format(bytes).unwrap_or("");
            assert!(found.contains(expected), "{bytes:?}: {found:?}");
        }
        let classic = [&b"#VRML V2.0 utf8\nGroup {}"[..], b"\xef\xbb\xbf#X3D V3.3 utf8"];
        for bytes in classic.into_iter().chain([
            &b""[..],
            b"<X3D/>",
            b"hello",
            b"# a comment",
            b"\xff\xfe<\0X\0",
            b"\xfe\xff\0<\0X",
        ]) {
            assert_eq!(other_format(bytes), None, "{bytes:?}");
        }
    }
}

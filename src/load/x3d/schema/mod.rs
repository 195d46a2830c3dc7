//! The X3D nodes that are known: their fields with types and defaults, where they stand, and what may stand in them.
//!
//! One table, so that a default is written once and can be tested once. Source: ISO/IEC 19775-1 (X3D 3.3 and 4.0) node
//! reference; where the two differ the later one counts. Fields that change no picture here are listed too, so that they
//! are read and checked like the others and pass without a warning.

mod appearance;
mod geometry;
mod structure;

use super::value::{self, Kind, Value};
use std::collections::HashMap;
use std::sync::LazyLock;

/// A field: its name, its type, its default as the standard writes it.
#[derive(Debug)]
pub(super) struct FieldDef {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    pub(super) default: &'static str,
}

/// A node type as its table says it.
#[derive(Debug)]
pub(super) struct NodeDef {
    /// The element's name.
    name: &'static str,
    /// The parent's field that holds it unless containerField says otherwise.
    container: &'static str,
    /// The fields of its own that hold nodes.
    accepts: &'static [&'static str],
    /// Its other fields, in groups that node types share.
    fields: &'static [&'static [FieldDef]],
}

/// A node type, ready for use.
#[derive(Debug)]
pub(super) struct NodeType {
    pub(super) name: &'static str,
    pub(super) container: &'static str,
    pub(super) accepts: &'static [&'static str],
    pub(super) fields: Vec<&'static FieldDef>,
    /// The defaults, one a field.
    pub(super) defaults: Vec<Value>,
}

impl NodeType {
    /// The index of the field of this name.
    pub(super) fn field(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|f| f.name == name)
    }
}

/// Shorthand of the tables.
const fn f(name: &'static str, kind: Kind, default: &'static str) -> FieldDef {
    FieldDef { name, kind, default }
}

/// Shorthand of the tables.
const fn n(
    name: &'static str,
    container: &'static str,
    accepts: &'static [&'static str],
    fields: &'static [&'static [FieldDef]],
) -> NodeDef {
    NodeDef { name, container, accepts, fields }
}

static TYPES: LazyLock<HashMap<&'static str, NodeType>> = LazyLock::new(|| {
    let tables = [structure::NODES, appearance::NODES, geometry::NODES];
    let types = tables.into_iter().flatten().map(|def| {
        let fields: Vec<&'static FieldDef> = def.fields.iter().copied().flatten().collect();
        let default =
            |f: &&FieldDef| value::read(f.kind, f.default).expect("the table's defaults are well-formed");
        let defaults = fields.iter().map(default).collect();
        let NodeDef { name, container, accepts, .. } = *def;
        (name, NodeType { name, container, accepts, fields, defaults })
    });
    types.collect()
});

/// The node type of this name.
pub(super) fn lookup(name: &str) -> Option<&'static NodeType> {
    TYPES.get(name)
}

/// Every known node type.
#[cfg(test)]
pub(super) fn all() -> impl Iterator<Item = &'static NodeType> {
    TYPES.values()
}

/// Elements that say things about the scene and are never seen: skipped without a word. Nodes defined in them can be used.
pub(super) fn is_silent(name: &str) -> bool {
    matches!(name, "WorldInfo" | "head" | "meta" | "component") || name.starts_with("Metadata")
}

/// Whether an element, known or not, is a node that a group holds: neither a statement nor metadata.
pub(super) fn is_child(name: &str) -> bool {
    let is_statement =
        matches!(name, "ROUTE" | "IMPORT" | "EXPORT" | "IS" | "ProtoDeclare" | "ExternProtoDeclare");
    !is_statement && !name.starts_with("Metadata")
}

/// Attributes that every element may have and that mean nothing here.
pub(super) fn is_common_attribute(name: &str) -> bool {
    matches!(name, "DEF" | "USE" | "containerField" | "class" | "id" | "style")
}

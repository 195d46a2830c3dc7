//! The supported X3D nodes: their fields with types and defaults, their default container fields,
//! and the fields that take nodes.
//!
//! A single table, so that each default is written and tested once. Source: ISO/IEC 19775-1 (X3D
//! 3.3 and 4.0) node reference; where the two differ the later one applies. Fields that have no
//! effect here are included, so that they are read and checked like the others and cause no
//! warning.

mod appearance;
mod geometry;
mod structure;

use super::value::{self, Kind, Value};
use std::collections::HashMap;
use std::sync::LazyLock;

/// A field: its name, its type, and its default in the standard's notation.
#[derive(Debug)]
pub(super) struct FieldDef {
    pub(super) name: &'static str,
    pub(super) kind: Kind,
    pub(super) default: &'static str,
}

/// A node type as an entry of the tables.
#[derive(Debug)]
pub(super) struct NodeDef {
    /// Name of the element.
    name: &'static str,
    /// Field of the parent that contains it unless containerField names another.
    container: &'static str,
    /// Names of its fields that take nodes.
    accepts: &'static [&'static str],
    /// Its other fields, in groups shared by several node types.
    fields: &'static [&'static [FieldDef]],
}

/// A node type with parsed defaults.
#[derive(Debug)]
pub(super) struct NodeType {
    pub(super) name: &'static str,
    pub(super) container: &'static str,
    pub(super) accepts: &'static [&'static str],
    pub(super) fields: Vec<&'static FieldDef>,
    /// Default values, one per field.
    pub(super) defaults: Vec<Value>,
}

impl NodeType {
    /// Returns the index of a field by its name.
    pub(super) fn field(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|f| f.name == name)
    }
}

/// Creates a field definition; short name for the tables.
const fn f(name: &'static str, kind: Kind, default: &'static str) -> FieldDef {
    FieldDef { name, kind, default }
}

/// Creates a node definition; short name for the tables.
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

/// Returns the node type with this name.
pub(super) fn lookup(name: &str) -> Option<&'static NodeType> {
    TYPES.get(name)
}

/// Iterates over all node types.
#[cfg(test)]
pub(super) fn all() -> impl Iterator<Item = &'static NodeType> {
    TYPES.values()
}

/// Returns whether an element only describes the scene: it is skipped without a warning. USE can
/// refer to nodes in it.
pub(super) fn is_silent(name: &str) -> bool {
    matches!(name, "WorldInfo" | "head" | "meta" | "component") || name.starts_with("Metadata")
}

/// Returns whether an element, of known type or not, is a possible child of a group: neither a
/// statement nor metadata.
pub(super) fn is_child(name: &str) -> bool {
    let is_statement =
        matches!(name, "ROUTE" | "IMPORT" | "EXPORT" | "IS" | "ProtoDeclare" | "ExternProtoDeclare");
    !is_statement && !name.starts_with("Metadata")
}

/// Returns whether an attribute is allowed in every element and has no value of a field.
pub(super) fn is_common_attribute(name: &str) -> bool {
    matches!(name, "DEF" | "USE" | "containerField" | "class" | "id" | "style")
}

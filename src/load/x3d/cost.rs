//! What reading an X3D file takes: estimates before it is read, and what the nodes of its graph hold.
//!
//! In: text, or nodes. Out: bytes, at most. A text is counted, not parsed: its tags, attributes and words bound the tables of the XML
//! reader and the lists of numbers. Runs on whichever thread reads. One would know a wrong figure by tests/allocations/decoder_memory.rs.

use super::geometry::text;
use super::graph::{Child, GraphView, Node, NodeId};
use super::schema::NodeType;
use super::value::Value;
use crate::scene::{MAX_STAGES, Object, TextureStage};

/// Bytes of the XML reader's tables for one `<`: an element and the text before it, and its name and place in our own tables, in
/// lists with room for twice as many that move.
const TAG_BYTES: u64 = 320;
/// The same for one `=`: an attribute.
const ATTRIBUTE_BYTES: u64 = 200;
/// The same for one line's beginning.
const LINE_BYTES: u64 = 24;
/// The same for one number of a field.
const WORD_BYTES: u64 = 24;
/// Copies of the text: decoded, with its references and line ends put right, as a field's value, and of a data URI its name,
/// its bytes and what they encode.
const COPIES: u64 = 7;

/// Bytes that reading a text takes until its graph is built.
pub(super) fn text_bytes(text: &[u8]) -> u64 {
    let (mut tags, mut attributes, mut lines, mut words, mut was_blank) = (0, 0, 0, 0, true);
    for &byte in text {
        let is_blank = byte.is_ascii_whitespace() || byte == b',';
        tags += u64::from(byte == b'<');
        attributes += u64::from(byte == b'=');
        lines += u64::from(byte == b'\n');
        words += u64::from(was_blank && !is_blank);
        was_blank = is_blank;
    }
    COPIES * text.len() as u64
        + (tags + 1) * TAG_BYTES
        + attributes * ATTRIBUTE_BYTES
        + lines * LINE_BYTES
        + words * WORD_BYTES
}

/// Bytes of a node by itself in its graph, which has room for twice as many.
pub(super) fn bare_node_bytes(ty: &NodeType) -> u64 {
    let field = size_of::<Value>() + size_of::<usize>();
    (2 * size_of::<Node>() + ty.defaults.len() * field) as u64
}

/// Bytes of what the text of an element in a prototype's body is read to, once for all instances: the numbers are counted with
/// the nodes that share them.
pub(super) fn read_bytes(ty: &NodeType) -> usize {
    ty.defaults.len() * (size_of::<Value>() + size_of::<usize>()) + 256
}

/// Bytes that a node holds in its graph, with its values.
pub(super) fn node_bytes(node: &Node) -> u64 {
    let given = node.values.iter().zip(&node.ty.defaults).filter(|(own, default)| !is_shared(own, default));
    let values: usize = given.map(|(value, _)| value_bytes(value)).sum();
    let bytes = 2 * size_of::<Node>()
        + node.values.capacity() * size_of::<Value>()
        + node.written.capacity() * size_of::<usize>()
        + node.children.capacity() * size_of::<Child>()
        + node.def.as_ref().map_or(0, String::capacity)
        + values;
    bytes as u64
}

/// Whether a value is the default of its field, which all nodes share.
fn is_shared(value: &Value, default: &Value) -> bool {
    match (value, default) {
        (Value::Ints(a), Value::Ints(b)) => std::sync::Arc::ptr_eq(a, b),
        (Value::Reals(a), Value::Reals(b)) => std::sync::Arc::ptr_eq(a, b),
        (Value::Text(a), Value::Text(b)) => std::sync::Arc::ptr_eq(a, b),
        (Value::Texts(a), Value::Texts(b)) => std::sync::Arc::ptr_eq(a, b),
        _ => false,
    }
}

fn value_bytes(value: &Value) -> usize {
    const COUNTS: usize = 2 * size_of::<usize>();
    match value {
        Value::Bool(_) => 0,
        Value::Ints(ints) => COUNTS + size_of_val(&**ints),
        Value::Reals(reals) => COUNTS + size_of_val(&**reals),
        Value::Text(text) => COUNTS + text.len(),
        Value::Texts(texts) => {
            COUNTS + texts.iter().map(|t| size_of::<String>() + t.capacity()).sum::<usize>()
        }
    }
}

/// Bytes of a mesh and of making it, for each number that its geometry gives: a corner, a part of a polygon and its triangles,
/// normals and their search, in lists with room for twice as many that move.
const ITEM_BYTES: u64 = 200;
/// The same where each number is a triangle of its own, as in fans and strips.
const STRIP_BYTES: u64 = 450;
/// The same for each quad of a grid, an extrusion or a letter.
const QUAD_BYTES: u64 = 700;
/// The same of a solid or a flat shape, whose number of faces is fixed.
const FIXED_BYTES: u64 = 256 << 10;

/// Bytes that making the mesh of a geometry node takes, the mesh included.
pub(super) fn geometry_bytes(view: &GraphView, id: NodeId) -> u64 {
    let items = |id: NodeId| -> u64 {
        let lists = view.node(id).values.iter().map(|value| match value {
            Value::Ints(ints) => ints.len() as u64,
            Value::Reals(reals) => reals.len() as u64,
            _ => 0,
        });
        lists.sum()
    };
    let below = || view.node(id).children.iter().map(|child| items(child.node)).sum::<u64>();
    let bytes = match view.name(id) {
        "Extrusion" => {
            let [section, spine] = ["crossSection", "spine"].map(|field| view.reals(id, field).len() as u64);
            (section / 2 + 1).saturating_mul(spine / 3 + 2).saturating_mul(QUAD_BYTES)
        }
        "Text" => text::squares(view.texts(id, "string")) * QUAD_BYTES,
        "ElevationGrid" => items(id) * QUAD_BYTES + below() * ITEM_BYTES,
        name if name.contains("Fan") || name.contains("Strip") => (items(id) + below()) * STRIP_BYTES,
        _ => (items(id) + below()) * ITEM_BYTES,
    };
    bytes.saturating_add(FIXED_BYTES)
}

/// Bytes of one object of a scene, its name and lights aside: in a list with room for twice as many that moves, and the names of
/// its material.
pub(super) const OBJECT_BYTES: u64 = 3 * size_of::<Object>() as u64 + 160;

/// Bytes of the stages of one object's textures, their coordinates aside.
pub(super) const STAGES_BYTES: u64 = 2 * (MAX_STAGES * size_of::<TextureStage>()) as u64 + 256;

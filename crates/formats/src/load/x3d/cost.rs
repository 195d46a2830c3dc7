//! Memory estimates for X3D files: of a text before it is read, and of nodes of the graph.
//!
//! In: text, or nodes. Out: an upper bound in bytes. A text is not parsed: the counts of its tags,
//! attributes and words bound the tables of the XML reader and the lists of numbers. Runs on the
//! thread that reads. A wrong figure is found by tests/allocations/decoder_memory.rs.

use super::geometry::{elevation, text};
use super::graph::{Child, GraphView, Node, NodeId};
use super::schema::NodeType;
use super::value::Value;
use fbptr_core::scene::{MAX_STAGES, Object, TextureStage};

/// Bytes of the XML reader's tables per `<`: an element, the text before it, its name, and its
/// position in our own tables, all in vectors that are copied as they grow and have up to twice the
/// room.
const TAG_BYTES: u64 = 320;
/// Bytes per `=`: an attribute, in such vectors.
const ATTRIBUTE_BYTES: u64 = 200;
/// Bytes per line: its beginning, in such a vector.
const LINE_BYTES: u64 = 24;
/// Bytes per number of a field, in such a vector.
const WORD_BYTES: u64 = 24;
/// Copies of the text: decoded, with references and line ends resolved, as a field's value, and for
/// a data URI its name, its bytes and its decoded content.
const COPIES: u64 = 7;

/// Returns the bytes for reading a text until its graph is built.
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

/// Bytes of a name in the classic encoding: a node or field of the tree, in a vector of up to twice the
/// room, and what its tag has in the XML beside the name.
const NAME_BYTES: u64 = 3 * 256;

/// Returns the bytes for translating a text in the classic encoding to XML, which has the same numbers
/// and strings.
pub(super) fn classic_bytes(text: &[u8]) -> u64 {
    let (mut names, mut was_inner) = (0, false);
    for &byte in text {
        let is_inner = byte.is_ascii_alphanumeric() || !byte.is_ascii() || b"_-+.:".contains(&byte);
        names += u64::from(!was_inner && (byte.is_ascii_alphabetic() || !byte.is_ascii() || byte == b'"'));
        was_inner = is_inner;
    }
    COPIES * text.len() as u64 + names * NAME_BYTES
}

/// Returns the bytes of a node without contents in its graph, which has up to twice the room.
pub(super) fn bare_node_bytes(ty: &NodeType) -> u64 {
    let field = size_of::<Value>() + size_of::<usize>();
    (2 * size_of::<Node>() + ty.defaults.len() * field) as u64
}

/// Returns the bytes of the parsed fields of an element in a prototype's body, stored once for all
/// instances: the lists of numbers are counted with the nodes that share them.
pub(super) fn read_bytes(ty: &NodeType) -> usize {
    ty.defaults.len() * (size_of::<Value>() + size_of::<usize>()) + 256
}

/// Returns the bytes of a node in its graph, its values included.
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

/// Returns whether a value is the default of its field, which all nodes share.
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

/// Bytes of a mesh and its computation per number of its geometry: a corner, a part of a polygon
/// and its triangles, normals and their tables, in vectors that are copied as they grow and have up
/// to twice the room.
const ITEM_BYTES: u64 = 200;
/// Bytes per number if each is a triangle, as in fans and strips.
const STRIP_BYTES: u64 = 450;
/// Bytes per quad of a grid or an extrusion, or triangle of a letter.
const QUAD_BYTES: u64 = 700;
/// Bytes of a solid or a flat shape, which has a fixed number of faces.
const FIXED_BYTES: u64 = 256 << 10;

/// Returns an upper bound of the bytes for computing the mesh of a geometry node, the mesh
/// included.
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
        "Text" => text::triangles(view.texts(id, "string")) * QUAD_BYTES,
        "ElevationGrid" => (items(id) + elevation::lacking(view, id)) * QUAD_BYTES + below() * ITEM_BYTES,
        name if name.contains("Fan") || name.contains("Strip") => (items(id) + below()) * STRIP_BYTES,
        _ => (items(id) + below()) * ITEM_BYTES,
    };
    bytes.saturating_add(FIXED_BYTES)
}

/// Bytes of one object of a scene without its name and lights: in a vector that is copied as it
/// grows and has up to twice the room, and the names of its material.
pub(super) const OBJECT_BYTES: u64 = 3 * size_of::<Object>() as u64 + 160;

/// Bytes of the stages of one object's textures without their coordinates.
pub(super) const STAGES_BYTES: u64 = 2 * (MAX_STAGES * size_of::<TextureStage>()) as u64 + 256;

//! The scene graph: nodes with typed fields, in a vector. A node is added after its children, so
//! the graph has no cycle.

use super::route::Route;
use super::schema::NodeType;
use super::value::Value;
use fbptr_core::scene::{SkyPictures, Texture};
use std::collections::HashMap;
use std::sync::Arc;

/// Index of a node in [`Graph::nodes`].
pub(super) type NodeId = u32;

/// A child node, and the field of the parent that contains it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Child {
    pub(super) container: &'static str,
    pub(super) node: NodeId,
}

/// Position of an element or attribute.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// Index of the file.
    pub(super) source: usize,
    /// Byte offset in its text.
    pub(super) byte: usize,
}

/// A node with its field values and children.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) ty: &'static NodeType,
    /// One value per field of the type.
    pub(super) values: Vec<Value>,
    /// Byte offset of each field's text in the file; that of the element for a field that is not
    /// given.
    pub(super) written: Vec<usize>,
    pub(super) children: Vec<Child>,
    pub(super) origin: Origin,
    /// Line of the element, from 1.
    pub(super) line: u32,
    /// DEF name.
    pub(super) def: Option<String>,
    pub(super) totals: Totals,
    /// True if it belongs to an instance of a prototype.
    pub(super) is_expanded: bool,
    /// True once its fields are checked and its mesh is computed.
    pub(super) is_checked: bool,
}

/// Totals of a node and everything below it; nodes reached through USE and Inline count each time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Totals {
    /// Length of the longest chain of nodes, itself included.
    pub(super) depth: usize,
    /// Number of nodes that a traversal visits.
    pub(super) visits: u64,
    /// Number of shapes among them.
    pub(super) shapes: u64,
    /// Bytes for computing all their meshes.
    pub(super) geometry_bytes: u64,
    /// Length of the longest name of a shape: the DEF names on the way to it.
    pub(super) name_bytes: u64,
}

impl Totals {
    /// Returns the totals of a node without children.
    pub(super) fn of(ty: &NodeType, def: Option<&str>) -> Totals {
        let name_bytes = def.map_or(0, |d| d.len() as u64 + 1) + ty.name.len() as u64;
        Totals { depth: 1, visits: 1, shapes: u64::from(ty.name == "Shape"), geometry_bytes: 0, name_bytes }
    }

    /// Returns the totals with those of the nodes below added.
    pub(super) fn with(self, below: impl Iterator<Item = Totals>) -> Totals {
        let none = Totals { depth: 0, visits: 0, shapes: 0, geometry_bytes: 0, name_bytes: 0 };
        let sum = below.fold(none, |a, b| Totals {
            depth: a.depth.max(b.depth),
            visits: a.visits.saturating_add(b.visits),
            shapes: a.shapes.saturating_add(b.shapes),
            geometry_bytes: a.geometry_bytes.saturating_add(b.geometry_bytes),
            name_bytes: a.name_bytes.max(b.name_bytes),
        });
        Totals {
            depth: self.depth + sum.depth,
            visits: self.visits.saturating_add(sum.visits),
            shapes: self.shapes.saturating_add(sum.shapes),
            geometry_bytes: self.geometry_bytes.saturating_add(sum.geometry_bytes),
            name_bytes: self.name_bytes.saturating_add(sum.name_bytes),
        }
    }
}

/// All nodes of a file and its Inlines.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<Node>,
    pub(super) routes: Vec<Route>,
    /// Textures of the texture nodes that have one.
    pub(super) textures: HashMap<NodeId, Arc<Texture>>,
    /// Pictures of the Background nodes that have any.
    pub(super) skies: HashMap<NodeId, SkyPictures>,
    /// Scene inside each Inline node, and the factor from its unit of length to ours.
    pub(super) inlined: HashMap<NodeId, (NodeId, f64)>,
    /// Fields of a geometry whose node exists but has an unknown type.
    pub(super) missing: HashMap<NodeId, Vec<&'static str>>,
    /// True if anything depends on the position of the viewer; set when the graph is complete.
    pub(super) depends_on_viewer: bool,
    /// Scene node of the main file.
    pub(super) root: NodeId,
}

/// Field values set by routes, by node and field index.
pub(super) type Overrides = HashMap<(NodeId, usize), Value>;

/// The graph at one moment of its animation.
#[derive(Clone, Copy)]
pub(super) struct GraphView<'a> {
    pub(super) graph: &'a Graph,
    pub(super) overrides: &'a Overrides,
}

impl<'a> GraphView<'a> {
    pub(super) fn node(&self, id: NodeId) -> &'a Node {
        &self.graph.nodes[id as usize]
    }

    /// Returns the name of the node's type.
    pub(super) fn name(&self, id: NodeId) -> &'static str {
        self.node(id).ty.name
    }

    /// Returns the first node in a field.
    pub(super) fn child(&self, id: NodeId, container: &str) -> Option<NodeId> {
        self.node(id).children.iter().find(|c| c.container == container).map(|c| c.node)
    }

    /// Returns the nodes in the field `children`.
    pub(super) fn children(&self, id: NodeId) -> impl Iterator<Item = NodeId> + use<'a> {
        self.node(id).children.iter().filter(|c| c.container == "children").map(|c| c.node)
    }

    /// Returns whether routes have set a field of this node.
    pub(super) fn is_driven(&self, id: NodeId) -> bool {
        !self.overrides.is_empty()
            && (0..self.node(id).values.len()).any(|f| self.overrides.contains_key(&(id, f)))
    }

    /// Returns the value of a field, as set by routes or by the file.
    fn value(&self, id: NodeId, field: &str) -> &'a Value {
        let node = self.node(id);
        let index = node.ty.field(field).expect("callers name fields of the node's table");
        match self.overrides.is_empty() {
            true => &node.values[index],
            false => self.overrides.get(&(id, index)).unwrap_or(&node.values[index]),
        }
    }

    pub(super) fn bool(&self, id: NodeId, field: &str) -> bool {
        matches!(self.value(id, field), Value::Bool(true))
    }

    pub(super) fn reals(&self, id: NodeId, field: &str) -> &'a [f64] {
        match self.value(id, field) {
            Value::Reals(reals) => reals,
            _ => &[],
        }
    }

    /// Returns a single real, 0 if the field is empty.
    pub(super) fn real(&self, id: NodeId, field: &str) -> f64 {
        self.reals(id, field).first().copied().unwrap_or(0.0)
    }

    /// Returns exactly N reals, padded with zeros.
    pub(super) fn array<const N: usize>(&self, id: NodeId, field: &str) -> [f64; N] {
        let reals = self.reals(id, field);
        std::array::from_fn(|i| reals.get(i).copied().unwrap_or(0.0))
    }

    pub(super) fn vec3(&self, id: NodeId, field: &str) -> glam::DVec3 {
        self.array::<3>(id, field).into()
    }

    pub(super) fn ints(&self, id: NodeId, field: &str) -> &'a [i64] {
        match self.value(id, field) {
            Value::Ints(ints) => ints,
            _ => &[],
        }
    }

    pub(super) fn text(&self, id: NodeId, field: &str) -> &'a str {
        match self.value(id, field) {
            Value::Text(text) => text,
            _ => "",
        }
    }

    pub(super) fn texts(&self, id: NodeId, field: &str) -> &'a [String] {
        match self.value(id, field) {
            Value::Texts(texts) => texts,
            _ => &[],
        }
    }
}

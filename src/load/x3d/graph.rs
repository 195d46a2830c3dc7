//! The scene graph: nodes with typed fields, held by index. A node is made after what it holds, so the graph has no cycle.

use super::route::Route;
use super::schema::NodeType;
use super::value::Value;
use crate::scene::{SkyPictures, Texture};
use std::collections::HashMap;
use std::sync::Arc;

/// A node's index in its graph.
pub(super) type NodeId = u32;

/// A node that another one holds, and in which field.
#[derive(Clone, Copy, Debug)]
pub(super) struct Child {
    pub(super) container: &'static str,
    pub(super) node: NodeId,
}

/// Where an element or attribute stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// Which of the files.
    pub(super) source: usize,
    /// The byte in its text.
    pub(super) byte: usize,
}

/// One node.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) ty: &'static NodeType,
    /// One value a field of the type.
    pub(super) values: Vec<Value>,
    /// The byte of each field's text in the file; the element's own where the field is not given.
    pub(super) written: Vec<usize>,
    pub(super) children: Vec<Child>,
    pub(super) origin: Origin,
    /// The element's line, from 1.
    pub(super) line: u32,
    /// Its DEF name.
    pub(super) def: Option<String>,
    pub(super) totals: Totals,
    /// Whether an instance of a prototype made it.
    pub(super) is_expanded: bool,
}

/// What a node holds with everything below it, those behind USE and Inline counted each time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Totals {
    /// The longest chain of nodes, itself counted.
    pub(super) depth: usize,
    /// How many nodes a traversal from here meets.
    pub(super) visits: u64,
    /// How many shapes are among them.
    pub(super) shapes: u64,
    /// The bytes that making all their meshes takes.
    pub(super) geometry_bytes: u64,
    /// The longest name of a shape: the DEF names down to it.
    pub(super) name_bytes: u64,
}

impl Totals {
    /// Of a node by itself.
    pub(super) fn of(ty: &NodeType, def: Option<&str>) -> Totals {
        let name_bytes = def.map_or(0, |d| d.len() as u64 + 1) + ty.name.len() as u64;
        Totals { depth: 1, visits: 1, shapes: u64::from(ty.name == "Shape"), geometry_bytes: 0, name_bytes }
    }

    /// The same with nodes below it.
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
    /// The pictures of texture nodes, where there are any.
    pub(super) textures: HashMap<NodeId, Arc<Texture>>,
    /// The pictures of Background nodes that have any.
    pub(super) skies: HashMap<NodeId, SkyPictures>,
    /// The scene inside an Inline node, and how many of our units of length one of its own is.
    pub(super) inlined: HashMap<NodeId, (NodeId, f64)>,
    /// Fields of a geometry for which there is a node, but none that is known.
    pub(super) missing: HashMap<NodeId, Vec<&'static str>>,
    /// Whether anything depends on where it is seen from; known when everything is built.
    pub(super) depends_on_viewer: bool,
    /// The main file's Scene.
    pub(super) root: NodeId,
}

/// Field values that routes have set, by node and field.
pub(super) type Overrides = HashMap<(NodeId, usize), Value>;

/// The graph as it is at one moment.
#[derive(Clone, Copy)]
pub(super) struct GraphView<'a> {
    pub(super) graph: &'a Graph,
    pub(super) overrides: &'a Overrides,
}

impl<'a> GraphView<'a> {
    pub(super) fn node(&self, id: NodeId) -> &'a Node {
        &self.graph.nodes[id as usize]
    }

    /// The node's type name.
    pub(super) fn name(&self, id: NodeId) -> &'static str {
        self.node(id).ty.name
    }

    /// The first node held in a field.
    pub(super) fn child(&self, id: NodeId, container: &str) -> Option<NodeId> {
        self.node(id).children.iter().find(|c| c.container == container).map(|c| c.node)
    }

    /// The nodes held in `children`.
    pub(super) fn children(&self, id: NodeId) -> impl Iterator<Item = NodeId> + use<'a> {
        self.node(id).children.iter().filter(|c| c.container == "children").map(|c| c.node)
    }

    /// Whether routes have set a field of this node.
    pub(super) fn is_driven(&self, id: NodeId) -> bool {
        !self.overrides.is_empty()
            && (0..self.node(id).values.len()).any(|f| self.overrides.contains_key(&(id, f)))
    }

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

    /// A single real number.
    pub(super) fn real(&self, id: NodeId, field: &str) -> f64 {
        self.reals(id, field).first().copied().unwrap_or(0.0)
    }

    /// Exactly N reals, zeros where there are fewer.
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

//! Creation of graph nodes: their totals, and the reservation of their memory.
//!
//! In: nodes made by `build`. Out: their indices; or an error at the element's position if there is
//! no memory for what a node stores. A missing reservation is found by
//! tests/allocations/decoder_memory.rs.

use super::build::{Builder, File};
use super::cost;
use super::graph::{Child, GraphView, Node, NodeId, Origin, Overrides, Totals};
use super::schema::{self, NodeType};
use crate::load::{LoadError, LoadErrorKind};
use roxmltree::Node as Element;

impl<'d> Builder<'d, '_> {
    /// Adds an empty group in the place of a node that was skipped.
    pub(super) fn nothing(&mut self, file: &File<'d>, element: Element<'d, 'd>) -> Result<NodeId, LoadError> {
        let ty = schema::lookup("Group").expect("the table has Group");
        self.plain_node(file, element, ty, Vec::new())
    }

    /// Adds a node for an element, with the defaults of its type.
    pub(super) fn plain_node(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        children: Vec<Child>,
    ) -> Result<NodeId, LoadError> {
        self.charge_node(file, element, ty)?;
        let byte = element.range().start;
        let totals = self.totals(ty, None, &children, None);
        let node = Node {
            ty,
            values: ty.defaults.clone(),
            written: vec![byte; ty.defaults.len()],
            children,
            origin: Origin { source: file.source, byte },
            line: self.sources[file.source].line(byte),
            def: None,
            totals,
            is_expanded: file.given.is_some(),
            is_checked: false,
        };
        self.add(file, element, node)
    }

    /// Returns the totals of a node and everything below it.
    pub(super) fn totals(
        &self,
        ty: &NodeType,
        def: Option<&str>,
        children: &[Child],
        scene: Option<NodeId>,
    ) -> Totals {
        let below = children.iter().map(|c| c.node).chain(scene);
        let mut totals = Totals::of(ty, def).with(below.map(|n| self.graph.nodes[n as usize].totals));
        let geometry = children.iter().find(|c| ty.name == "Shape" && c.container == "geometry");
        if let Some(geometry) = geometry {
            let still = Overrides::new();
            let view = GraphView { graph: &self.graph, overrides: &still };
            let own = cost::geometry_bytes(&view, geometry.node);
            totals.geometry_bytes = totals.geometry_bytes.saturating_add(own);
        }
        totals
    }

    /// Adds a node whose own bytes are reserved already; those of its contents are reserved here.
    pub(super) fn add(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        node: Node,
    ) -> Result<NodeId, LoadError> {
        let more = cost::node_bytes(&node).saturating_sub(cost::bare_node_bytes(node.ty));
        self.context.memory.reserve_result(more).map_err(|kind| self.over_memory(file, element, kind))?;
        self.graph.nodes.push(node);
        Ok(self.graph.nodes.len() as NodeId - 1)
    }

    /// Reserves working memory until the graph is complete.
    pub(super) fn hold(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        bytes: usize,
    ) -> Result<(), LoadError> {
        let held = self.held.try_grow(bytes as u64).map_err(LoadErrorKind::OverBudget);
        held.map_err(|kind| self.over_memory(file, element, kind))
    }

    /// Returns the error for an element for which there is no memory.
    pub(super) fn over_memory(&self, file: &File, element: Element, kind: LoadErrorKind) -> LoadError {
        LoadError::new(self.sources[file.source].place(element.range().start), kind)
    }
}

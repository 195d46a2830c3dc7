//! DEF and USE names, and the field of the parent that a node belongs to.
//!
//! A name refers to the last node that was given it before its use, in the same scope: a file, or
//! the body of a prototype (ISO/IEC 19775-1 clauses 4.4.3 and 4.4.4.2). Beyond the standard: in a file
//! without such a node to the first one after it, with a warning; one without any is skipped. The
//! field is the one in containerField, if the parent has it and it takes nodes of this kind; else
//! the node's default field (ISO/IEC 19776-1 clause 4.3.4).

use super::build::{Builder, File};
use super::graph::{Child, NodeId};
use super::schema::{self, NodeType};
use super::{unknown, xml};
use crate::load::LoadError;
use roxmltree::Node as Element;
use std::collections::HashMap;

/// Referent of a DEF name.
#[derive(Clone, Copy)]
pub(super) enum Def {
    /// The node is being built: a USE here would make it contain itself.
    Open,
    /// A node of the graph.
    Built(NodeId),
    /// An instance of a prototype, by its index.
    Instance(usize),
    /// A node in a skipped part; built when it is used.
    Hidden(roxmltree::NodeId),
    /// A node of unknown type; all uses are skipped.
    Unknown,
}

/// Returns the kind of nodes that a field takes, named by the default field of such nodes.
pub(super) fn container_of(field: &str) -> &str {
    match field {
        "proxy" | "navigationInfo" => "children",
        "backMaterial" => "material",
        _ if field.ends_with("Texture") => "texture",
        _ => field,
    }
}

/// Returns the field of `parent` for a node of type `ty`; `None` if it cannot be a child there.
pub(super) fn place(
    element: Element,
    ty: &'static NodeType,
    parent: &'static NodeType,
) -> Option<&'static str> {
    if unknown::is_anything(parent) {
        return Some(ty.container);
    }
    let asked = match element.attribute("containerField") {
        Some(asked) if unknown::is_group(parent) => unknown::field_of_group(asked),
        asked => asked.unwrap_or(ty.container),
    };
    let accepts = |field: &str| {
        let field = parent.accepts.iter().copied().find(|a| *a == field)?;
        (container_of(field) == ty.container).then_some(field)
    };
    let own = || accepts(ty.container).filter(|_| !unknown::is_group(parent) || asked == ty.container);
    // A grouping node with another default field (a Viewport) is also valid among children.
    let as_child = || {
        let is_group = ty.accepts.contains(&"children") && ty.container != "children";
        parent.accepts.iter().copied().find(|a| is_group && *a == "children")
    };
    accepts(asked).or_else(own).or_else(as_child)
}

/// Returns whether a field for a single node is occupied.
pub(super) fn is_taken(ty: &NodeType, children: &[Child], container: &str) -> bool {
    let holds_many = matches!(container, "children" | "layers") || ty.name.starts_with("Multi");
    !holds_many && children.iter().any(|c| c.container == container)
}

/// Records the names in a skipped part, so that USE can still find them.
pub(super) fn hide<'d>(file: &mut File<'d>, element: Element<'d, 'd>) {
    for node in element.descendants() {
        if let Some(name) = node.attribute("DEF").filter(|_| node.attribute("USE").is_none()) {
            file.defs.entry(name).or_insert(Def::Hidden(node.id()));
        }
    }
}

/// Returns the DEFs of a file by their names, the first of each, without those of prototypes.
fn all_defs<'d>(document: &'d roxmltree::Document<'d>) -> HashMap<&'d str, roxmltree::NodeId> {
    let mut all = HashMap::new();
    for node in document.descendants().filter(|node| !node.has_attribute("USE")) {
        let is_proto = || node.ancestors().any(|above| above.tag_name().name() == "ProtoDeclare");
        if let Some(name) = node.attribute("DEF").filter(|name| !name.is_empty() && !is_proto()) {
            all.entry(name).or_insert(node.id());
        }
    }
    all
}

impl<'d> Builder<'d, '_> {
    /// Returns a finished node as a child of `parent`, or warns if it cannot be one.
    pub(super) fn placed(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        node: NodeId,
        parent: &'static NodeType,
    ) -> Option<Child> {
        let ty = self.graph.nodes[node as usize].ty;
        let container = place(element, ty, parent);
        if container.is_none() && !unknown::is_group(parent) {
            let (name, own, parent) = (element.tag_name().name(), ty.name, parent.name);
            let message = format!("<{name}> is a <{own}>, which cannot stand in <{parent}>, and was skipped");
            self.warn(file, element, message);
        }
        container.map(|container| Child { container, node })
    }

    /// Records that a DEF's node is being built.
    pub(super) fn open_def(&mut self, file: &mut File<'d>, element: Element<'d, 'd>, def: Option<&'d str>) {
        let Some(name) = def else { return };
        let before = file.defs.insert(name, Def::Open);
        if matches!(before, Some(Def::Built(_) | Def::Instance(_) | Def::Open)) {
            let message = format!("DEF {name:?} is given twice; USE takes the last one before it");
            self.warn(file, element, message);
        }
    }

    /// Returns the node that a USE refers to; `None` if it was skipped.
    pub(super) fn used(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        name: &'d str,
        depth: usize,
    ) -> Result<Option<NodeId>, LoadError> {
        let built = match file.defs.get(name).copied() {
            Some(Def::Built(node)) => Some(node),
            Some(Def::Instance(number)) => self.protos.instances[number].node,
            Some(Def::Hidden(hidden)) => {
                let hidden = file.document.get_node(hidden).expect("ids are of this document");
                let Some(ty) = schema::lookup(hidden.tag_name().name()) else { return Ok(None) };
                return self.node(file, hidden, ty, depth).map(Some);
            }
            Some(Def::Unknown) => None,
            Some(Def::Open) => {
                let expected = format!("USE to name a node that is complete, but {name:?} holds this one");
                return Err(self.refuse(file, element, "USE", expected));
            }
            None => return self.used_early(file, element, name, depth),
        };
        match built {
            Some(node) => self.check_depth(file, element, node, depth).map(|()| Some(node)),
            None => Ok(None),
        }
    }

    /// Returns the element of a DEF that comes after its USE, with a warning; `None` if there is none.
    #[inline(never)]
    fn find_later(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        name: &'d str,
    ) -> Option<(Element<'d, 'd>, &'static NodeType)> {
        let document = file.document;
        // The body of a prototype is no scope of the whole file's names.
        let is_file = file.given.is_none();
        let all =
            file.all_defs.get_or_insert_with(|| if is_file { all_defs(document) } else { HashMap::new() });
        let found = all.get(name).and_then(|id| document.get_node(*id));
        let typed = found.and_then(|found| Some((found, schema::lookup(found.tag_name().name())?)));
        let message = match typed {
            None => format!("USE {name:?} has no DEF, and was skipped"),
            Some((found, _)) => {
                let line = self.sources[file.source].line(found.range().start);
                format!("USE {name:?} stands before its DEF in line {line}, which is used")
            }
        };
        self.warn(file, element, message);
        typed
    }

    /// Returns the node of a DEF that comes after its USE, which is built here; `None` if there is
    /// none.
    fn used_early(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        name: &'d str,
        depth: usize,
    ) -> Result<Option<NodeId>, LoadError> {
        let Some((found, ty)) = self.find_later(file, element, name) else { return Ok(None) };
        let node = self.node(file, found, ty, depth)?;
        file.early.insert(found.id(), node);
        Ok(Some(node))
    }

    /// Checks that a node used again here does not exceed the nesting limit.
    pub(super) fn check_depth(
        &self,
        file: &File,
        element: Element,
        node: NodeId,
        depth: usize,
    ) -> Result<(), LoadError> {
        let deep = depth + self.graph.nodes[node as usize].totals.depth;
        if deep <= xml::MAX_DEPTH {
            return Ok(());
        }
        let limit = xml::MAX_DEPTH as u64;
        let source = self.sources[file.source];
        Err(source.too_big(element.range().start, "nesting of nodes", deep as u64, limit))
    }

    /// Returns a syntax error at an attribute of an element.
    pub(super) fn refuse(
        &self,
        file: &File,
        element: Element,
        attribute: &str,
        expected: String,
    ) -> LoadError {
        let byte = element.attribute_node(attribute).map_or(element.range().start, |a| a.range().start);
        self.sources[file.source].refuse(byte, expected)
    }
}

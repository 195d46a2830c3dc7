//! XML elements to graph nodes: fields read and checked, DEF and USE joined, Inline files and textures fetched.
//!
//! A file's nodes are built in document order, children first. What cannot be understood in well-formed XML is skipped with a
//! warning; a number, index or name that is wrong refuses the file. Nodes that are skipped are still built when USE names
//! them (files keep definitions in their metadata).

use super::cost;
use super::graph::{Child, Graph, Node, NodeId, Origin, Overrides, View};
use super::schema::{self, NodeType};
use super::{texture, xml};
use crate::load::{LoadError, LoadErrorKind, LoadMemory, LoadWarning, Place};
use crate::memory::Reservation;
use roxmltree::Node as Element;
use std::collections::HashMap;
use std::rc::Rc;

/// The most warnings that are kept.
const MAX_WARNINGS: usize = 1_000;
/// The most nodes that a walk through the scene may meet, those behind USE and Inline counted each time.
const MAX_VISITS: u64 = 4_000_000;

/// Finds a file in the scene's folder: the name as written, to bytes.
pub(super) type Opener<'r> = dyn FnMut(&str) -> Option<Vec<u8>> + 'r;

/// What a DEF name stands for.
#[derive(Clone, Copy)]
pub(super) enum Def {
    /// The node is being built: a USE here would hold itself.
    Open,
    /// A node of the graph.
    Built(NodeId),
    /// In a part that is skipped; built when it is used.
    Hidden(roxmltree::NodeId),
    /// A node that is not known; everything about it is skipped.
    Unknown,
}

/// What belongs to one file.
pub(super) struct File<'d> {
    pub(super) source: usize,
    /// The file's folder inside the scene's folder, with `/` at its end unless empty.
    pub(super) folder: String,
    document: &'d roxmltree::Document<'d>,
    pub(super) defs: HashMap<&'d str, Def>,
    routes: Vec<Element<'d, 'd>>,
}

/// Builds one graph from a file and what it inlines.
pub(super) struct Builder<'r> {
    pub(super) graph: Graph,
    pub(super) sources: Vec<Rc<xml::Source>>,
    pub(super) warnings: Vec<LoadWarning>,
    pub(super) opener: &'r mut Opener<'r>,
    /// The main file's folder as the caller names it, for messages about other files.
    pub(super) shown_folder: String,
    /// Inline files by path: `None` while they are being read.
    pub(super) inlined: HashMap<String, Option<NodeId>>,
    pub(super) pictures: texture::Pictures,
    pub(super) memory: &'r mut LoadMemory,
    /// What the sources hold.
    texts: Vec<Reservation>,
}

impl<'r> Builder<'r> {
    pub(super) fn new(opener: &'r mut Opener<'r>, memory: &'r mut LoadMemory) -> Self {
        Builder {
            graph: Graph::default(),
            sources: Vec::new(),
            warnings: Vec::new(),
            opener,
            shown_folder: String::new(),
            inlined: HashMap::new(),
            pictures: texture::Pictures::default(),
            memory,
            texts: Vec::new(),
        }
    }

    /// Reads the main file; its own name counts against cycles of Inlines.
    pub(super) fn main_file(&mut self, bytes: &[u8], name: &str) -> Result<(), LoadError> {
        let own = name.rsplit(['/', '\\']).next().unwrap_or(name);
        self.shown_folder = name[..name.len() - own.len()].to_string();
        self.inlined.insert(own.to_string(), None);
        self.graph.root = self.file(bytes, name, String::new(), 0)?;
        let root = &self.graph.nodes[self.graph.root as usize];
        match root.visits > MAX_VISITS {
            true => {
                let what = "nodes, with those of USE and Inline";
                let kind = LoadErrorKind::TooBig { what, found: root.visits, limit: MAX_VISITS };
                Err(LoadError::new(Place::file(name), kind))
            }
            false => Ok(()),
        }
    }

    /// Reads a file to its Scene node.
    pub(super) fn file(
        &mut self,
        bytes: &[u8],
        name: &str,
        folder: String,
        depth: usize,
    ) -> Result<NodeId, LoadError> {
        let refused = |kind| LoadError::new(Place::file(name), kind);
        let mut tables = self.memory.work(cost::text_bytes(bytes)).map_err(refused)?;
        let source = Rc::new(xml::Source::decode(bytes, name)?);
        self.sources.push(Rc::clone(&source));
        let document = xml::parse(&source)?;
        let mut file = File {
            source: self.sources.len() - 1,
            folder,
            document: &document,
            defs: HashMap::new(),
            routes: Vec::new(),
        };
        let root = document.root_element();
        let scene = match root.tag_name().name() {
            "Scene" => Some(root),
            "X3D" => {
                self.no_text(&file, root)?;
                let mut scene = None;
                for child in root.children().filter(Element::is_element) {
                    match child.tag_name().name() {
                        "Scene" if scene.is_none() => scene = Some(child),
                        "head" => self.head(&file, child),
                        name if schema::is_silent(name) => {}
                        name => {
                            self.warn(&file, child, format!("<{name}> is not known here and was skipped"))
                        }
                    }
                }
                scene
            }
            _ => return Err(source.refuse(root.range().start, "an X3D file, whose root is <X3D>")),
        };
        let Some(scene) = scene else {
            return Err(source.refuse(root.range().start, "a <Scene> inside <X3D>"));
        };
        let ty = schema::lookup("Scene").expect("the table has Scene");
        let id = self.node(&mut file, scene, ty, depth + 1)?;
        for element in std::mem::take(&mut file.routes) {
            self.route(&file, element);
        }
        // The text stays for the places of what is refused later.
        tables.shrink_to(cost::source_bytes(bytes));
        self.texts.push(tables);
        Ok(id)
    }

    /// What a head says changes nothing here, but units would.
    fn head(&mut self, file: &File, head: Element) {
        for unit in head.descendants().filter(|e| e.tag_name().name() == "unit") {
            self.warn(file, unit, "units are not applied: lengths are metres, angles radians".into());
        }
    }

    /// Builds an element that stands in `parent`; `None` when it holds nothing to draw or was skipped.
    fn element<'d>(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        parent: &'static NodeType,
        depth: usize,
    ) -> Result<Option<Child>, LoadError> {
        let name = element.tag_name().name();
        if name == "ROUTE" {
            file.routes.push(element);
            return Ok(None);
        }
        if schema::is_silent(name) {
            hide(file, element);
            return Ok(None);
        }
        let Some(ty) = schema::lookup(name).filter(|ty| ty.name != "Scene") else {
            self.warn(file, element, format!("node <{name}> is not known and was skipped"));
            hide(file, element);
            if let Some(def) = element.attribute("DEF") {
                file.defs.insert(def, Def::Unknown);
            }
            return Ok(None);
        };
        let asked = element.attribute("containerField").unwrap_or(ty.container);
        let place = [asked, ty.container].into_iter().find_map(|c| parent.accepts.iter().find(|a| **a == c));
        let Some(container) = place.copied() else {
            let parent = parent.name;
            self.warn(file, element, format!("<{name}> cannot stand in <{parent}> and was skipped"));
            hide(file, element);
            return Ok(None);
        };
        let node = match element.attribute("USE") {
            Some(used) => self.used(file, element, used, depth)?,
            None => Some(self.node(file, element, ty, depth)?),
        };
        let Some(node) = node else { return Ok(None) };
        let built = self.graph.nodes[node as usize].ty;
        if built.container != ty.container {
            let message =
                format!("<{name}> uses a <{}>, which cannot stand here, and was skipped", built.name);
            self.warn(file, element, message);
            return Ok(None);
        }
        Ok(Some(Child { container, node }))
    }

    /// The node that a USE names.
    fn used<'d>(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        name: &'d str,
        depth: usize,
    ) -> Result<Option<NodeId>, LoadError> {
        match file.defs.get(name).copied() {
            Some(Def::Built(node)) => {
                let deep = depth + self.graph.nodes[node as usize].depth;
                if deep > xml::MAX_DEPTH {
                    let source = &self.sources[file.source];
                    let limit = xml::MAX_DEPTH as u64;
                    return Err(source.too_big(
                        element.range().start,
                        "nesting of nodes",
                        deep as u64,
                        limit,
                    ));
                }
                Ok(Some(node))
            }
            Some(Def::Hidden(hidden)) => {
                let hidden = file.document.get_node(hidden).expect("ids are of this document");
                let Some(ty) = schema::lookup(hidden.tag_name().name()) else { return Ok(None) };
                self.node(file, hidden, ty, depth).map(Some)
            }
            Some(Def::Unknown) => Ok(None),
            Some(Def::Open) => {
                let expected = format!("USE to name a node that is complete, but {name:?} holds this one");
                Err(self.refuse(file, element, "USE", expected))
            }
            None => Err(self.refuse(file, element, "USE", format!("a DEF {name:?} before this USE"))),
        }
    }

    /// A refusal of an attribute of an element.
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

    /// Builds a node and what it holds.
    fn node<'d>(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        depth: usize,
    ) -> Result<NodeId, LoadError> {
        let source = Rc::clone(&self.sources[file.source]);
        let start = element.range().start;
        if depth > xml::MAX_DEPTH {
            return Err(source.too_big(start, "nesting of nodes", depth as u64, xml::MAX_DEPTH as u64));
        }
        self.no_text(file, element)?;
        let def = element.attribute("DEF").filter(|d| !d.is_empty());
        if let Some(name) = def {
            let before = file.defs.insert(name, Def::Open);
            if matches!(before, Some(Def::Built(_) | Def::Open)) {
                self.warn(
                    file,
                    element,
                    format!("DEF {name:?} is given twice; USE takes the last one before it"),
                );
            }
        }
        let (values, written) = self.fields(file, element, ty, &source)?;
        let mut children = Vec::new();
        let (mut below, mut visits) = (0, 1_u64);
        let (mut shapes, mut geometry_bytes, mut name_bytes) = (u64::from(ty.name == "Shape"), 0_u64, 0);
        for child in element.children().filter(Element::is_element) {
            match self.element(file, child, ty, depth + 1)? {
                Some(Child { container, .. }) if is_taken(&children, container) => {
                    let name = child.tag_name().name();
                    let message = format!("<{}> takes one {container}: this <{name}> was skipped", ty.name);
                    self.warn(file, child, message);
                }
                Some(child) => {
                    let node = &self.graph.nodes[child.node as usize];
                    below = below.max(node.depth);
                    visits = visits.saturating_add(node.visits);
                    shapes = shapes.saturating_add(node.shapes);
                    geometry_bytes = geometry_bytes.saturating_add(node.geometry_bytes);
                    name_bytes = name_bytes.max(node.name_bytes);
                    if ty.name == "Shape" && child.container == "geometry" {
                        let still = Overrides::new();
                        let view = View { graph: &self.graph, overrides: &still };
                        geometry_bytes =
                            geometry_bytes.saturating_add(cost::geometry_bytes(&view, child.node));
                    }
                    children.push(child);
                }
                // A Switch counts the nodes that were skipped too.
                None if ty.name == "Switch" && schema::is_child(child.tag_name().name()) => {
                    children.push(Child { container: "children", node: self.nothing(file, child) });
                }
                None => {}
            }
        }
        let mut scene = None;
        if ty.name == "Inline" {
            scene = self.inline(file, element, ty, &values, depth)?;
            if let Some(scene) = scene {
                let node = &self.graph.nodes[scene as usize];
                below = node.depth;
                visits = visits.saturating_add(node.visits);
                shapes = shapes.saturating_add(node.shapes);
                geometry_bytes = geometry_bytes.saturating_add(node.geometry_bytes);
                name_bytes = name_bytes.max(node.name_bytes);
            }
        }
        let picture = self.picture(file, element, ty, &values)?;
        let id = self.graph.nodes.len() as NodeId;
        let node = Node {
            ty,
            values,
            written,
            children,
            origin: Origin { source: file.source, byte: start },
            line: source.line(start),
            def: def.map(str::to_string),
            depth: below + 1,
            visits,
            shapes,
            geometry_bytes,
            name_bytes: name_bytes + def.map_or(0, |d| d.len() as u64 + 1) + ty.name.len() as u64,
        };
        self.memory
            .keep(cost::node_bytes(&node))
            .map_err(|kind| LoadError::new(source.place(start), kind))?;
        self.graph.nodes.push(node);
        self.graph.inlined.extend(scene.map(|scene| (id, scene)));
        self.graph.textures.extend(picture.map(|picture| (id, picture)));
        if let Some(name) = def {
            file.defs.insert(name, Def::Built(id));
        }
        Ok(id)
    }

    /// A node that holds nothing, in the place of one that was skipped.
    fn nothing(&mut self, file: &File, element: Element) -> NodeId {
        let ty = schema::lookup("Group").expect("the table has Group");
        let byte = element.range().start;
        self.graph.nodes.push(Node {
            ty,
            values: ty.defaults.clone(),
            written: vec![byte; ty.defaults.len()],
            children: Vec::new(),
            origin: Origin { source: file.source, byte },
            line: self.sources[file.source].line(byte),
            def: None,
            depth: 1,
            visits: 1,
            shapes: 0,
            geometry_bytes: 0,
            name_bytes: 0,
        });
        self.graph.nodes.len() as NodeId - 1
    }

    pub(super) fn warn(&mut self, file: &File, element: Element, message: String) {
        let origin = Origin { source: file.source, byte: element.range().start };
        self.warn_at(origin, message);
    }

    /// Adds a warning, up to the limit.
    pub(super) fn warn_at(&mut self, origin: Origin, message: String) {
        match self.warnings.len() {
            0..MAX_WARNINGS => {
                let place = self.place(origin);
                self.warnings.push(LoadWarning { place, message });
            }
            MAX_WARNINGS => {
                let place = Place::file(&self.sources[0].name);
                self.warnings.push(LoadWarning { place, message: "further warnings are left out".into() });
            }
            _ => {}
        }
    }

    /// The warnings in the order of the files and of their lines.
    pub(super) fn sorted_warnings(&mut self) -> Vec<LoadWarning> {
        let mut warnings = std::mem::take(&mut self.warnings);
        let rank = |w: &LoadWarning| {
            let file = self.sources.iter().position(|s| s.name == w.place.file);
            (file, w.place.line, w.place.column)
        };
        // The one beyond the limit says that there were more, and stays last.
        let count = warnings.len().min(MAX_WARNINGS);
        warnings[..count].sort_by_cached_key(rank);
        warnings
    }

    /// The place of an origin in its file.
    pub(super) fn place(&self, origin: Origin) -> Place {
        self.sources[origin.source].place(origin.byte)
    }
}

/// Whether a field that holds one node has it already.
fn is_taken(children: &[Child], container: &str) -> bool {
    container != "children" && children.iter().any(|c| c.container == container)
}

/// Notes the names in a part that is skipped, so that USE can still find them.
fn hide<'d>(file: &mut File<'d>, element: Element<'d, 'd>) {
    for node in element.descendants() {
        if let Some(name) = node.attribute("DEF").filter(|_| node.attribute("USE").is_none()) {
            file.defs.entry(name).or_insert(Def::Hidden(node.id()));
        }
    }
}

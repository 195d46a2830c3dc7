//! Construction of the graph from XML elements: fields are read and checked, DEF and USE resolved,
//! Inline files and textures loaded.
//!
//! A file's nodes are built in document order, children first. Unsupported parts of well-formed XML
//! are skipped with a warning; an invalid number, index or name is an error. Skipped nodes are
//! still built when USE refers to them (files keep definitions in their metadata).

use super::cost;
use super::graph::{Child, Graph, Node, NodeId, Origin};
use super::instance::Given;
use super::kept::{Kept, MAX_FILES};
use super::names::{Def, hide, is_taken, place};
use super::proto::Protos;
use super::remarks::{REPEATED, Remarks};
use super::schema::{self, NodeType};
use super::units::Units;
use super::unknown::{self, What};
use super::validate::Meshes;
use super::value::Value;
use super::{classic, texture, unusable, xml};
use crate::load::{FilePosition, LoadContext, LoadError, LoadErrorKind, gzip};
use fbptr_core::memory::{MemoryUse, Reservation};
use roxmltree::Node as Element;
use std::collections::HashMap;
use std::rc::Rc;

/// Most nodes that a traversal of the scene may visit; nodes reached through USE and Inline count
/// each time.
const MAX_VISITS: u64 = 4_000_000;

/// Function that returns the bytes of a file by its name inside the root.
pub(super) type Opener<'r> = dyn FnMut(&str) -> Option<Vec<u8>> + 'r;

/// State of one scope of names: a file, or the body of a prototype in one of its instances.
pub(super) struct File<'d> {
    pub(super) source: usize,
    /// Folder of the file inside the root, with a final `/` unless empty.
    pub(super) folder: Rc<str>,
    pub(super) units: Units,
    pub(super) document: &'d roxmltree::Document<'d>,
    pub(super) defs: HashMap<&'d str, Def>,
    /// Every DEF of the file by its name, the first of each: made when a USE has none before it.
    pub(super) all_defs: Option<HashMap<&'d str, roxmltree::NodeId>>,
    /// Nodes that were built for a USE before their DEF.
    pub(super) early: HashMap<roxmltree::NodeId, NodeId>,
    pub(super) routes: Vec<Element<'d, 'd>>,
    /// Index of the environment with the prototypes declared in this scope.
    pub(super) environment: usize,
    /// Inside a prototype's body: the values that the instance gives to its fields.
    pub(super) given: Option<Given<'d>>,
}

/// Builder of one graph from a file and the files that it inlines.
pub(super) struct Builder<'d, 'r> {
    pub(super) graph: Graph,
    texts: &'d Kept<xml::XmlSource>,
    documents: &'d Kept<roxmltree::Document<'d>>,
    pub(super) sources: Vec<&'d xml::XmlSource>,
    pub(super) remarks: Remarks,
    pub(super) context: LoadContext<'r>,
    /// Folder of the main file as named by the caller, for messages about other files.
    shown_folder: String,
    /// Inline files by path.
    pub(super) inlined: HashMap<String, InlineFile>,
    /// True once an Inline, or a prototype, was found inside itself: an error of the whole scene.
    pub(super) has_cycle: bool,
    /// Meshes of the nodes that are checked already.
    pub(super) meshes: Meshes,
    pub(super) pictures: texture::Pictures,
    pub(super) protos: Protos<'d>,
    /// Number of pairs of fields that ROUTEs have named.
    pub(super) routes_tried: usize,
    /// Working memory until the graph is complete: texts, their XML tables, and tables of
    /// prototypes and instances.
    pub(super) held: Reservation,
}

/// State of an Inline file.
pub(super) enum InlineFile {
    /// It is being read.
    Open,
    Read(Inlined),
    /// It cannot be used, for this reason.
    Unusable(Rc<str>),
}

/// Result of reading a file.
#[derive(Clone, Copy)]
pub(super) struct Inlined {
    /// Scene node of the file.
    pub(super) scene: NodeId,
    pub(super) units: Units,
}

impl<'d, 'r> Builder<'d, 'r> {
    pub(super) fn new(
        context: LoadContext<'r>,
        texts: &'d Kept<xml::XmlSource>,
        documents: &'d Kept<roxmltree::Document<'d>>,
    ) -> Self {
        let held = context.memory.budget().empty(MemoryUse::Decoders);
        Builder {
            graph: Graph { metres: 1.0, ..Graph::default() },
            texts,
            documents,
            sources: Vec::new(),
            remarks: Remarks::default(),
            context,
            shown_folder: String::new(),
            inlined: HashMap::new(),
            has_cycle: false,
            meshes: Meshes::default(),
            pictures: texture::Pictures::default(),
            protos: Protos::default(),
            routes_tried: 0,
            held,
        }
    }

    /// Reads the main file; its name counts against cycles of Inlines.
    pub(super) fn main_file(&mut self, bytes: &[u8], name: &str) -> Result<(), LoadError> {
        let own = name.rsplit(['/', '\\']).next().unwrap_or(name);
        self.shown_folder = name[..name.len() - own.len()].to_string();
        let folder = self.context.folder;
        self.inlined.insert(format!("{folder}{own}"), InlineFile::Open);
        let read = self.file(bytes, name, folder.into(), 0)?;
        (self.graph.root, self.graph.metres) = (read.scene, read.units.length);
        let root = &self.graph.nodes[self.graph.root as usize].totals;
        match root.visits > MAX_VISITS {
            true => {
                let what = "nodes, with those of USE and Inline";
                let kind = LoadErrorKind::TooBig { what, found: root.visits, limit: MAX_VISITS };
                Err(LoadError::new(FilePosition::file(name), kind))
            }
            false => Ok(()),
        }
    }

    /// Returns the name for messages of the file at a path inside the root.
    pub(super) fn shown(&self, path: &str) -> String {
        let own = self.context.folder;
        match path.strip_prefix(own) {
            Some(rest) => format!("{}{rest}", self.shown_folder),
            None => format!("{}{}{path}", self.shown_folder, "../".repeat(own.matches('/').count())),
        }
    }

    /// Opens a file as a scope without names; its text and XML tree are stored until everything is
    /// read.
    pub(super) fn open(&mut self, bytes: &[u8], name: &str, folder: Rc<str>) -> Result<File<'d>, LoadError> {
        let refused = |kind| LoadError::new(FilePosition::file(name), kind);
        let limit = MAX_FILES as u64;
        let too_many =
            || refused(LoadErrorKind::TooBig { what: "files of a scene", found: limit + 1, limit });
        let (source, trailing) = self.decode(bytes, name)?;
        let text = self.texts.push(source).ok_or_else(too_many)?;
        self.sources.push(text);
        if let Some(remark) = text.remark {
            self.warn_of_file(self.sources.len() - 1, remark.to_string());
        }
        if trailing > 0 {
            let message = format!("bytes after the end of the gzip data were skipped: {trailing}");
            self.warn_of_file(self.sources.len() - 1, message);
        }
        let document =
            self.documents.push(xml::parse(text, self.context.memory.cancel())?).ok_or_else(too_many)?;
        Ok(File {
            source: self.sources.len() - 1,
            folder,
            units: Units::STANDARD,
            document,
            defs: HashMap::new(),
            all_defs: None,
            early: HashMap::new(),
            routes: Vec::new(),
            environment: self.protos.add_environment(None),
            given: None,
        })
    }

    /// Returns the text of a file, and the number of bytes after the end of its gzip data.
    fn decode(&mut self, bytes: &[u8], name: &str) -> Result<(xml::XmlSource, usize), LoadError> {
        let refused = |kind| LoadError::new(FilePosition::file(name), kind);
        let memory = &*self.context.memory;
        let inflate = || gzip::inflate(bytes, gzip::MAX_INFLATED, memory).map_err(refused);
        let inflated = gzip::is_gzip(bytes).then(inflate).transpose()?;
        let (content, trailing, _held) = match &inflated {
            Some(gzip::Inflated { bytes, held, trailing }) => (bytes.as_slice(), *trailing, Some(held)),
            None => (bytes, 0, None),
        };
        if let Some(reason) = unusable::other_format(content) {
            let reason = reason.to_string();
            return Err(refused(LoadErrorKind::Undecodable { format: "X3D file", reason }));
        }
        self.context.memory.check_cancelled().map_err(refused)?;
        let is_classic = classic::is_classic(content);
        let bytes = if is_classic { cost::classic_bytes(content) } else { cost::text_bytes(content) };
        self.reserve_text(bytes).map_err(refused)?;
        let source = xml::XmlSource::decode(content, name, is_classic)?;
        if !is_classic {
            return Ok((source, trailing));
        }
        let (text, parts) = classic::to_xml(&source, self.context.memory.cancel())?;
        self.reserve_text(cost::text_bytes(text.as_bytes())).map_err(refused)?;
        Ok((source.translated(text, parts), trailing))
    }

    /// Reserves memory for reading a text, until the graph is complete: prototypes need the trees,
    /// error positions the texts.
    fn reserve_text(&mut self, bytes: u64) -> Result<(), LoadErrorKind> {
        self.held.try_grow(bytes).map_err(LoadErrorKind::OverBudget)
    }

    /// Reads a file and returns its Scene node.
    pub(super) fn file(
        &mut self,
        bytes: &[u8],
        name: &str,
        folder: Rc<str>,
        depth: usize,
    ) -> Result<Inlined, LoadError> {
        let mut file = self.open(bytes, name, folder)?;
        let scene = self.scene_element(&mut file)?;
        let ty = schema::lookup("Scene").expect("the table has Scene");
        let id = self.node(&mut file, scene, ty, depth + 1)?;
        for element in std::mem::take(&mut file.routes) {
            self.route(&file, element);
        }
        Ok(Inlined { scene: id, units: file.units })
    }

    /// Returns the Scene element of a file, and reads the units in its head.
    pub(super) fn scene_element(&mut self, file: &mut File<'d>) -> Result<Element<'d, 'd>, LoadError> {
        let root = file.document.root_element();
        let expected = match root.tag_name().name() {
            "Scene" => return Ok(root),
            "X3D" => match self.inside_root(file, root) {
                Some(scene) => return Ok(scene),
                None => "a <Scene> inside <X3D>",
            },
            _ => "an X3D file, whose root is <X3D>",
        };
        Err(self.sources[file.source].refuse(root.range().start, expected))
    }

    /// Returns the first Scene of an X3D element. Of the head only the units are used.
    fn inside_root(&mut self, file: &mut File<'d>, root: Element<'d, 'd>) -> Option<Element<'d, 'd>> {
        self.stray_text(file, root);
        let mut scene = None;
        for child in root.children().filter(Element::is_element) {
            match child.tag_name().name() {
                "Scene" if scene.is_none() => scene = Some(child),
                "head" => {
                    self.stray_text_in_parts(file, child);
                    for unit in child.descendants().filter(|e| e.tag_name().name() == "unit") {
                        if let Err(wrong) = file.units.read(unit) {
                            self.warn(file, unit, wrong);
                        }
                    }
                }
                name if schema::is_silent(name) => {}
                name => self.warn(file, child, format!("<{name}> is not known here and was skipped")),
            }
        }
        scene
    }

    /// Builds an element below `parent`; `None` if it has no node to draw or was skipped.
    pub(super) fn element(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        parent: &'static NodeType,
        depth: usize,
    ) -> Result<Option<Child>, LoadError> {
        let name = element.tag_name().name();
        match name {
            "ROUTE" => file.routes.push(element),
            "ProtoDeclare" | "ExternProtoDeclare" => self.declare(file, element),
            // Read together with the node that contains it.
            "IS" => self.stray_text_in_parts(file, element),
            "ProtoInstance" => {
                let node = self.instance_or_use(file, element, depth)?;
                return Ok(node.and_then(|node| self.placed(file, element, node, parent)));
            }
            _ if schema::is_silent(name) => hide(file, element),
            _ => match schema::lookup(name).filter(|ty| ty.name != "Scene") {
                Some(ty) => return self.known(file, element, ty, parent, depth),
                None => return self.not_known(file, element, parent, depth),
            },
        }
        Ok(None)
    }

    /// Builds an element of a known type.
    fn known(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        parent: &'static NodeType,
        depth: usize,
    ) -> Result<Option<Child>, LoadError> {
        let name = element.tag_name().name();
        let Some(container) = place(element, ty, parent) else {
            if !unknown::is_group(parent) {
                let parent = parent.name;
                self.warn(file, element, format!("<{name}> cannot stand in <{parent}> and was skipped"));
            }
            hide(file, element);
            return Ok(None);
        };
        let node = match element.attribute("USE") {
            Some(used) => self.used(file, element, used, depth)?,
            None => match file.early.get(&element.id()).copied() {
                Some(early) => self.check_depth(file, element, early, depth).map(|()| Some(early))?,
                None => Some(self.node(file, element, ty, depth)?),
            },
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

    /// Builds the parts of an unknown element that can be shown: the children of a possible
    /// grouping node.
    fn not_known(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        parent: &'static NodeType,
        depth: usize,
    ) -> Result<Option<Child>, LoadError> {
        let name = element.tag_name().name();
        match (unknown::what(element), element.attribute("USE")) {
            (What::LeftOut(why), _) => self.left_out(file, element, why),
            (What::Group, Some(used)) => {
                let node = match file.defs.get(used) {
                    Some(Def::Built(_)) => self.used(file, element, used, depth)?,
                    _ => None,
                };
                return Ok(node.and_then(|node| self.placed(file, element, node, parent)));
            }
            (What::Group, None) => {
                let message =
                    format!("node <{name}> is not known: its children are shown without it, {REPEATED}");
                self.once(file, element, message);
                return self.known(file, element, unknown::group(), parent, depth);
            }
            (What::Nothing, _) => {
                self.once(file, element, format!("node <{name}> is not known and was skipped, {REPEATED}"));
            }
        }
        hide(file, element);
        if let Some(def) = element.attribute("DEF") {
            file.defs.insert(def, Def::Unknown);
        }
        Ok(None)
    }

    /// Builds a node and its children. It is called recursively, so its stack frame is kept small:
    /// all work that does not recurse is in functions that are not inlined.
    pub(super) fn node(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        depth: usize,
    ) -> Result<NodeId, LoadError> {
        let mut node = self.begin_node(file, element, ty, depth)?;
        (node.children, node.missing) = self.children(file, element, ty, depth)?;
        self.end_node(file, element, node)
    }

    /// Checks a node, reserves its memory, and reads its fields.
    #[inline(never)]
    fn begin_node(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        depth: usize,
    ) -> Result<OpenNode, LoadError> {
        if depth > xml::MAX_DEPTH {
            let source = self.sources[file.source];
            let (start, limit) = (element.range().start, xml::MAX_DEPTH as u64);
            return Err(source.too_big(start, "nesting of nodes", depth as u64, limit));
        }
        self.charge_node(file, element, ty)?;
        self.stray_text(file, element);
        self.open_def(file, element, def_of(element));
        let (values, written) = self.fields(file, element, ty)?;
        Ok(OpenNode { ty, depth, values, written, children: Vec::new(), missing: Vec::new() })
    }

    /// Adds a node whose fields and children are read, with the values from IS and the data from
    /// other files.
    #[inline(never)]
    fn end_node(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        mut node: OpenNode,
    ) -> Result<NodeId, LoadError> {
        let def = def_of(element);
        let links = self.connect(file, element, &mut node)?;
        let OpenNode { ty, depth, values, written, children, missing } = node;
        let inlined = self.inline(file, element, ty, &values, depth)?;
        let picture = self.picture(file, element, ty, &values)?;
        let sky = self.sky_pictures(file, element, ty, &values)?;
        let totals = self.totals(ty, def, &children, inlined.map(|i| i.scene));
        let start = element.range().start;
        let node = Node {
            ty,
            values,
            written,
            children,
            origin: Origin { source: file.source, byte: start },
            line: self.sources[file.source].line(start),
            def: def.map(str::to_string),
            totals,
            is_expanded: file.given.is_some(),
            is_checked: false,
        };
        let id = self.add(file, element, node)?;
        if let Some(inlined) = inlined {
            let enlarged = inlined.units.length / file.units.length;
            self.graph.inlined.insert(id, (inlined.scene, enlarged));
        }
        if !missing.is_empty() {
            self.graph.missing.insert(id, missing);
        }
        self.graph.textures.extend(picture.map(|picture| (id, picture)));
        self.graph.skies.extend(sky.map(|pictures| (id, pictures)));
        if let Some(given) = &mut file.given {
            given.link(&links, id);
        }
        if let Some(name) = def {
            file.defs.insert(name, Def::Built(id));
        }
        Ok(id)
    }

    /// Builds the children of an element. Also returns the fields that unknown child nodes were
    /// meant for.
    fn children(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        depth: usize,
    ) -> Result<(Vec<Child>, Vec<&'static str>), LoadError> {
        let mut children: Vec<Child> = Vec::new();
        let mut missing = Vec::new();
        for child in element.children().filter(Element::is_element) {
            let name = child.tag_name().name();
            let built = match self.protos.shared(file, child) {
                Some(shared) => {
                    self.check_depth(file, child, shared.node, depth + 1)?;
                    Some(shared)
                }
                None => {
                    let built = self.element(file, child, ty, depth + 1)?;
                    self.protos.share(file, child, built);
                    built
                }
            };
            match built {
                Some(Child { container, .. }) if is_taken(ty, &children, container) => {
                    let message = format!("<{}> takes one {container}: this <{name}> was skipped", ty.name);
                    self.warn(file, child, message);
                }
                Some(child) => children.push(child),
                // Switch, LOD and LayerSet count skipped nodes too.
                None if matches!(ty.name, "Switch" | "LOD") && schema::is_child(name) => {
                    children.push(Child { container: "children", node: self.nothing(file, child)? });
                }
                None if ty.name == "LayerSet" && schema::is_child(name) => {
                    children.push(Child { container: "layers", node: self.nothing(file, child)? });
                }
                None => missing.extend(unknown::meant_for(ty, child)),
            }
        }
        Ok((children, missing))
    }
}

/// Node whose element is being read.
pub(super) struct OpenNode {
    pub ty: &'static NodeType,
    /// Depth of the element in its file and in the instances around it.
    pub depth: usize,
    pub values: Vec<Value>,
    /// Indices of the fields that the element gives.
    pub written: Vec<usize>,
    pub children: Vec<Child>,
    /// Fields that unknown child nodes were meant for.
    pub missing: Vec<&'static str>,
}

/// Returns the DEF name of an element, unless it is empty.
fn def_of<'d>(element: Element<'d, 'd>) -> Option<&'d str> {
    element.attribute("DEF").filter(|d| !d.is_empty())
}

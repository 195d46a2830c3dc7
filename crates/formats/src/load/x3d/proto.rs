//! ProtoDeclare and ExternProtoDeclare: scopes of prototype names, and the search for their bodies.
//!
//! A declaration is valid from its position on, in its file or, inside a ProtoBody, in that body
//! and its nested declarations (ISO/IEC 19775-1 clause 4.4.4.1 and .2). An ExternProtoDeclare
//! refers to the prototype in another file that its URL's fragment names, or to that file's first
//! one without a fragment (4.4.5.2); the file is loaded when the first instance needs it, from the
//! scene's folder or root only. Where it cannot be used, or the prototype in it has an error, the
//! instances are skipped with a warning at the ExternProtoDeclare. A prototype that contains an
//! instance of itself is an error (4.4.4.3: they are not recursive).

use super::build::{Builder, File};
use super::external_refs::READ_FROM;
use super::graph::Child;
use super::instance::{Field, Instance};
use super::units::Units;
use super::unusable::Mark;
use super::url;
use super::value::{self, Kind, Value};
use crate::load::LoadError;
use roxmltree::Node as Element;
use std::collections::HashMap;
use std::rc::Rc;

/// Longest chain of ExternProtoDeclare that refer to each other.
const MAX_CHAIN: usize = 32;

/// A prototype declaration.
pub(super) struct Proto<'d> {
    pub(super) name: &'d str,
    pub(super) element: Element<'d, 'd>,
    pub(super) source: usize,
    pub(super) folder: Rc<str>,
    pub(super) units: Units,
    pub(super) document: &'d roxmltree::Document<'d>,
    /// Index of the environment of names at its position.
    pub(super) environment: usize,
    /// Its fields, once an instance has needed them.
    pub(super) interface: Option<Rc<[Field<'d>]>>,
    elsewhere: Elsewhere,
}

/// Resolution state of an ExternProtoDeclare.
#[derive(Clone, Copy, PartialEq)]
enum Elsewhere {
    /// Not external: a ProtoDeclare.
    No,
    NotAsked,
    BeingAsked,
    Found(usize),
    Missing,
}

/// Prototype names of one scope.
#[derive(Default)]
struct Environment<'d> {
    own: HashMap<&'d str, usize>,
    first: Option<usize>,
    /// Index of the enclosing scope.
    outer: Option<usize>,
}

/// All prototypes of a scene, their scopes and instances.
#[derive(Default)]
pub(super) struct Protos<'d> {
    pub(super) all: Vec<Proto<'d>>,
    environments: Vec<Environment<'d>>,
    /// Environments of ExternProtoDeclare files by path, or the reason why one cannot be used.
    files: HashMap<String, Result<usize, Rc<str>>>,
    /// Prototypes whose instances are being expanded, outermost first.
    pub(super) expanding: Vec<usize>,
    /// Instances with DEF names.
    pub(super) instances: Vec<Instance>,
    /// Number of nodes, fields and connections created by instances so far.
    pub(super) made: u64,
    /// Parsed fields of elements in bodies, by source and element.
    pub(super) read: HashMap<(usize, roxmltree::NodeId), (Vec<Value>, Vec<usize>)>,
    /// Built parts of bodies that are equal in every instance.
    shared: HashMap<(usize, roxmltree::NodeId), Child>,
    /// Keys of `shared` in the order of their nodes.
    shared_keys: Vec<(usize, roxmltree::NodeId)>,
    /// Cached answers of `is_same`, by source and element.
    is_same: HashMap<(usize, roxmltree::NodeId), bool>,
}

impl<'d> Protos<'d> {
    /// Adds an environment inside `outer` and returns its index.
    pub(super) fn add_environment(&mut self, outer: Option<usize>) -> usize {
        self.environments.push(Environment { outer, ..Environment::default() });
        self.environments.len() - 1
    }

    /// Returns the prototype that a name refers to, in this environment or the enclosing ones.
    pub(super) fn named(&self, environment: usize, name: &str) -> Option<usize> {
        let mut at = Some(environment);
        while let Some(environment) = at.map(|at| &self.environments[at]) {
            if let Some(proto) = environment.own.get(name) {
                return Some(*proto);
            }
            at = environment.outer;
        }
        None
    }

    /// Returns a part of a prototype's body that is equal in every instance, if one has built it.
    pub(super) fn shared(&self, file: &File<'d>, element: Element<'d, 'd>) -> Option<Child> {
        file.given.as_ref().and_then(|_| self.shared.get(&(file.source, element.id())).copied())
    }

    /// Stores a part for later instances if it is equal in all: without names, connected fields,
    /// and prototypes.
    pub(super) fn share(&mut self, file: &File<'d>, element: Element<'d, 'd>, built: Option<Child>) {
        let Some(child) = built.filter(|_| file.given.is_some()) else { return };
        if self.is_same(file.source, element) {
            let key = (file.source, element.id());
            self.shared.insert(key, child);
            self.shared_keys.push(key);
        }
    }

    /// Returns the number of parts stored for later instances.
    pub(super) fn shared_count(&self) -> usize {
        self.shared_keys.len()
    }

    /// Forgets all but the first `count` parts stored for later instances.
    pub(super) fn unshare(&mut self, count: usize) {
        for key in self.shared_keys.drain(count..) {
            self.shared.remove(&key);
        }
    }

    /// Returns whether an element and everything below it is equal in every instance: it has no
    /// names, IS, ROUTE or prototypes.
    fn is_same(&mut self, source: usize, element: Element<'d, 'd>) -> bool {
        let key = (source, element.id());
        if let Some(known) = self.is_same.get(&key) {
            return *known;
        }
        let has_name = element.has_attribute("DEF") || element.has_attribute("USE");
        let is_plain =
            !matches!(element.tag_name().name(), "IS" | "ROUTE" | "ProtoInstance" | "ProtoDeclare");
        let mut inside = element.children().filter(Element::is_element);
        let is_same = is_plain && !has_name && inside.all(|child| self.is_same(source, child));
        self.is_same.insert(key, is_same);
        is_same
    }
}

impl<'d> Builder<'d, '_> {
    /// Adds a declaration to its scope.
    pub(super) fn declare(&mut self, file: &File<'d>, element: Element<'d, 'd>) {
        self.stray_text_in_parts(file, element);
        let Some(name) = element.attribute("name").filter(|n| !n.is_empty()) else {
            let tag = element.tag_name().name();
            return self.warn(file, element, format!("<{tag}> without a name was skipped"));
        };
        let is_extern = element.tag_name().name() == "ExternProtoDeclare";
        let number = self.protos.all.len();
        self.protos.all.push(Proto {
            name,
            element,
            source: file.source,
            folder: Rc::clone(&file.folder),
            units: file.units,
            document: file.document,
            environment: file.environment,
            interface: None,
            elsewhere: if is_extern { Elsewhere::NotAsked } else { Elsewhere::No },
        });
        let environment = &mut self.protos.environments[file.environment];
        environment.first.get_or_insert(number);
        if environment.own.insert(name, number).is_some() && file.given.is_none() {
            let message =
                format!("prototype {name:?} is declared twice; an instance takes the last one before it");
            self.warn(file, element, message);
        }
    }

    /// Resolves a prototype to the declaration that has a body; `None`, with one warning, if there
    /// is none.
    pub(super) fn with_body(&mut self, number: usize, chain: usize) -> Result<Option<usize>, LoadError> {
        match self.protos.all[number].elsewhere {
            Elsewhere::No => return Ok(Some(number)),
            Elsewhere::Found(found) => return Ok(Some(found)),
            Elsewhere::Missing => return Ok(None),
            Elsewhere::BeingAsked => {
                self.warn_of(number, "leads back to itself".into());
                return Ok(None);
            }
            Elsewhere::NotAsked => {}
        }
        self.protos.all[number].elsewhere = Elsewhere::BeingAsked;
        let looked = self.look_elsewhere(number);
        if looked.is_err() {
            self.protos.all[number].elsewhere = Elsewhere::Missing;
        }
        let found = match looked? {
            Some(found) if chain < MAX_CHAIN => self.further(number, found, chain)?,
            Some(_) => {
                self.warn_of(number, format!("leads through more than {MAX_CHAIN} others"));
                None
            }
            None => None,
        };
        self.protos.all[number].elsewhere = found.map_or(Elsewhere::Missing, Elsewhere::Found);
        Ok(found)
    }

    /// Resolves a declaration in another file, which the ExternProtoDeclare `number` refers to.
    fn further(&mut self, number: usize, found: usize, chain: usize) -> Result<Option<usize>, LoadError> {
        let mark = self.mark();
        match self.with_body(found, chain + 1) {
            Err(error) => {
                let reason = self.set_aside(&mark, error)?;
                self.warn_of(number, format!("cannot be used ({reason})"));
                Ok(None)
            }
            body => body,
        }
    }

    /// Warns at the ExternProtoDeclare `named` that its prototype, declared as `number`, cannot be
    /// used because of an error in it, and undoes what the instance has added since `mark`. Any
    /// other error is returned.
    #[inline(never)]
    pub(super) fn refuse_proto(
        &mut self,
        named: usize,
        number: usize,
        mark: &Mark,
        error: LoadError,
    ) -> Result<(), LoadError> {
        // Nodes that the instance gives to the prototype are in its own file.
        let is_own = self.sources[self.protos.all[named].source].name == error.place.file;
        if named == number || is_own {
            return Err(error);
        }
        let reason = self.set_aside(mark, error)?;
        self.warn_of(named, format!("cannot be used ({reason})"));
        // A further instance would have the same error.
        self.protos.all[named].elsewhere = Elsewhere::Missing;
        Ok(())
    }

    /// Warns about an ExternProtoDeclare whose instances are skipped.
    fn warn_of(&mut self, number: usize, what: String) {
        let proto = &self.protos.all[number];
        let message = format!("ExternProtoDeclare {:?} {what}: its instances were skipped", proto.name);
        let origin = super::graph::Origin { source: proto.source, byte: proto.element.range().start };
        self.warn_at(origin, message);
    }

    /// Finds the declaration in another file.
    fn look_elsewhere(&mut self, number: usize) -> Result<Option<usize>, LoadError> {
        let proto = &self.protos.all[number];
        let (folder, element, source) = (Rc::clone(&proto.folder), proto.element, proto.source);
        let text = element.attribute("url").unwrap_or("");
        let Ok(Value::Texts(urls)) = value::read(Kind::Texts, text) else {
            let byte = element.attribute_node("url").map_or(element.range().start, |a| a.range_value().start);
            return Err(
                self.sources[source].refuse(byte, "quoted strings in the url of <ExternProtoDeclare>")
            );
        };
        let mut reasons = Vec::new();
        for name in urls.iter() {
            let shown: String = name.chars().take(60).collect();
            if url::is_outside(&folder, name) {
                self.remarks.names_outside = true;
                reasons.push(format!("{shown:?} lies outside of {READ_FROM}"));
                continue;
            }
            let mut why = "cannot be found in the scene's folder".to_string();
            for path in url::local_paths(&folder, name) {
                let environment = match self.prototypes_of(&path)? {
                    Some(Ok(environment)) => environment,
                    Some(Err(reason)) => {
                        why = format!("cannot be used: {reason}");
                        continue;
                    }
                    None => continue,
                };
                let environment = &self.protos.environments[environment];
                let found = match url::fragment(name) {
                    Some(fragment) => environment.own.get(fragment).copied(),
                    None => environment.first,
                };
                match found {
                    Some(found) => return Ok(Some(found)),
                    None => why = "has no such prototype".into(),
                }
            }
            reasons.push(format!("{shown:?} {why}"));
        }
        let reasons = if reasons.is_empty() { "has no url".into() } else { reasons.join("; ") };
        self.warn_of(number, format!("cannot be had ({reasons})"));
        Ok(None)
    }

    /// Returns the environment of a file's prototypes: `None` if there is no such file, and the
    /// reason if it cannot be used.
    fn prototypes_of(&mut self, path: &str) -> Result<Option<Result<usize, Rc<str>>>, LoadError> {
        if let Some(known) = self.protos.files.get(path) {
            return Ok(Some(known.clone()));
        }
        let Some(bytes) = (self.context.opener)(path) else { return Ok(None) };
        let mark = self.mark();
        let read = match self.declarations(&bytes, path) {
            Ok(environment) => Ok(environment),
            Err(error) => Err(self.set_aside(&mark, error)?),
        };
        self.protos.files.insert(path.to_string(), read.clone());
        Ok(Some(read))
    }

    /// Reads the declarations of a file and returns their environment.
    fn declarations(&mut self, bytes: &[u8], path: &str) -> Result<usize, LoadError> {
        let folder = path.rfind('/').map_or("", |i| &path[..=i]);
        let shown = self.shown(path);
        let mut file = self.open(bytes, &shown, folder.into())?;
        let scene = self.scene_element(&mut file)?;
        let is_declaration = |e: &Element| {
            matches!(e.tag_name().name(), "ProtoDeclare" | "ExternProtoDeclare")
                && !e.ancestors().skip(1).any(|a| a.tag_name().name() == "ProtoDeclare")
        };
        for element in scene.descendants().filter(is_declaration) {
            self.declare(&file, element);
        }
        Ok(file.environment)
    }
}

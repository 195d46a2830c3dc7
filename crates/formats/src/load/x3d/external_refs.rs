//! References of a node beyond its own element: Inline files, pictures, and the two ends of a
//! ROUTE.

use super::build::{Builder, File, InlineFile, Inlined};
use super::instance::Link;
use super::names::Def;
use super::route::{self, Route};
use super::schema::NodeType;
use super::value::Value;
use super::{texture, url, validate};
use crate::load::LoadError;
use fbptr_core::scene::{SkyPictures, Texture};
use roxmltree::Node as Element;
use std::rc::Rc;
use std::sync::Arc;

/// Deepest nesting of Inline files.
const MAX_NESTED_FILES: usize = 64;

/// Most routes; invalid ones count too.
const MAX_ROUTES: usize = 100_000;

/// Description of the root folder in messages about names outside it.
pub(super) const READ_FROM: &str = "the folder that files are read from";

impl<'d> Builder<'d, '_> {
    /// Reads the file of an Inline node, the first of its URLs that can be used; `None` for other
    /// nodes, and, with a warning unless it is not to be loaded, if there is none.
    pub(super) fn inline(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        values: &[Value],
        depth: usize,
    ) -> Result<Option<Inlined>, LoadError> {
        if ty.name != "Inline" {
            return Ok(None);
        }
        let field = |name| &values[ty.field(name).expect("the table has it")];
        let (Value::Texts(urls), Value::Bool(true)) = (field("url"), field("load")) else { return Ok(None) };
        let mut is_outside = false;
        let mut reasons: Vec<Rc<str>> = Vec::new();
        for name in urls.iter() {
            is_outside |= url::is_outside(&file.folder, name);
            for path in url::local_paths(&file.folder, name) {
                match self.inline_file(file, element, &path, depth)? {
                    Some(Ok(inlined)) => return Ok(Some(inlined)),
                    Some(Err(reason)) if !reasons.contains(&reason) => reasons.push(reason),
                    Some(Err(_)) | None => {}
                }
            }
        }
        self.remarks.names_outside |= is_outside;
        let message = match (reasons.is_empty(), is_outside) {
            (false, _) => format!("cannot be used and was skipped: {}", reasons.join("; ")),
            (true, true) => format!("lies outside of {READ_FROM} and was skipped"),
            (true, false) => "cannot be found in the scene's folder and was skipped".into(),
        };
        if !urls.is_empty() {
            self.warn(file, element, format!("Inline {:?} {message}", &urls[..]));
        }
        Ok(None)
    }

    /// Reads an Inline file, once: `None` if there is no such file, and the reason if it cannot be
    /// used. Its nodes are checked here, so that an error in them is known before they are shown.
    fn inline_file(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        path: &str,
        depth: usize,
    ) -> Result<Option<Result<Inlined, Rc<str>>>, LoadError> {
        match self.inlined.get(path) {
            Some(InlineFile::Read(inlined)) => {
                let inlined = *inlined;
                self.check_depth(file, element, inlined.scene, depth)?;
                return Ok(Some(Ok(inlined)));
            }
            Some(InlineFile::Unusable(reason)) => return Ok(Some(Err(Rc::clone(reason)))),
            Some(InlineFile::Open) => {
                self.has_cycle = true;
                let expected = format!("no Inline of {path:?}, which inlines this file (a cycle)");
                return Err(self.refuse(file, element, "url", expected));
            }
            None => {}
        }
        let Some(bytes) = (self.context.opener)(path) else { return Ok(None) };
        let open = self.inlined.values().filter(|f| matches!(f, InlineFile::Open)).count();
        if open > MAX_NESTED_FILES {
            let source = self.sources[file.source];
            let (what, limit) = ("nesting of Inline files", MAX_NESTED_FILES as u64);
            return Err(source.too_big(element.range().start, what, open as u64, limit));
        }
        self.inlined.insert(path.to_string(), InlineFile::Open);
        let folder = path.rfind('/').map_or("", |i| &path[..=i]);
        let mark = self.mark();
        let read = self.file(&bytes, &self.shown(path), folder.into(), depth);
        let checked = read.and_then(|read| validate::nodes(self, mark.first()).map(|()| read));
        let (state, read) = match checked {
            Ok(read) => (InlineFile::Read(read), Ok(read)),
            Err(error) => {
                let reason = self.set_aside(&mark, error)?;
                (InlineFile::Unusable(Rc::clone(&reason)), Err(reason))
            }
        };
        self.inlined.insert(path.to_string(), state);
        Ok(Some(read))
    }

    /// Returns the picture of a texture node; `None` for other nodes, and if it has none or cannot
    /// be loaded.
    pub(super) fn picture(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        values: &[Value],
    ) -> Result<Option<Arc<Texture>>, LoadError> {
        let field = |name| &values[ty.field(name).expect("the table has it")];
        let result = match ty.name {
            "ImageTexture" => match (field("url"), field("load")) {
                (Value::Texts(urls), Value::Bool(true)) if !urls.is_empty() => {
                    self.load_picture(file, element, urls).map(Some)
                }
                _ => Ok(None),
            },
            "PixelTexture" => match field("image") {
                Value::Ints(image) => texture::pixels(image, self.context.memory),
                _ => Ok(None),
            },
            _ => Ok(None),
        };
        match result {
            Ok(picture) => Ok(picture),
            Err(texture::PictureError::OverMemory(kind)) => Err(self.over_memory(file, element, kind)),
            Err(texture::PictureError::Pixels(expected)) => {
                Err(self.refuse(file, element, "image", expected))
            }
            Err(error) => {
                self.warn(file, element, format!("texture left out: {error}"));
                Ok(None)
            }
        }
    }

    /// Returns the pictures of a Background; `None` for other nodes, and if it has none.
    pub(super) fn sky_pictures(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
        values: &[Value],
    ) -> Result<Option<SkyPictures>, LoadError> {
        if ty.name != "Background" {
            return Ok(None);
        }
        let mut pictures = SkyPictures::default();
        let SkyPictures { back, bottom, front, left, right, top } = &mut pictures;
        let sides = [
            ("backUrl", back),
            ("bottomUrl", bottom),
            ("frontUrl", front),
            ("leftUrl", left),
            ("rightUrl", right),
            ("topUrl", top),
        ];
        let mut has_any = false;
        for (field, side) in sides {
            let Value::Texts(urls) = &values[ty.field(field).expect("the table has it")] else { continue };
            if urls.is_empty() {
                continue;
            }
            match self.load_picture(file, element, urls) {
                Ok(picture) => {
                    *side = Some(picture);
                    has_any = true;
                }
                Err(texture::PictureError::OverMemory(kind)) => {
                    return Err(self.over_memory(file, element, kind));
                }
                Err(error) => self.warn(file, element, format!("<Background> {field} left out: {error}")),
            }
        }
        Ok(has_any.then_some(pictures))
    }

    /// Loads the picture of the first usable URL, from the cache or a file.
    fn load_picture(
        &mut self,
        file: &File,
        element: Element,
        urls: &[String],
    ) -> Result<Arc<Texture>, texture::PictureError> {
        if urls.iter().any(|name| url::is_outside(&file.folder, name)) {
            self.remarks.names_outside = true;
        }
        let (folder, mut note) = (&file.folder, None);
        let picture = self.pictures.load(urls, folder, &mut note, self.context.opener, self.context.memory);
        if let (true, Some(note)) = (picture.is_ok(), note) {
            self.warn(file, element, note);
        }
        picture
    }

    /// Adds the routes of a ROUTE element; an invalid one is a warning. At an instance of a
    /// prototype, the route continues to the fields that the instance's field is connected to.
    pub(super) fn route(&mut self, file: &File<'d>, element: Element<'d, 'd>) {
        let attribute = |name: &str| element.attribute(name).unwrap_or("");
        let [from, from_field, to, to_field] = ["fromNode", "fromField", "toNode", "toField"].map(attribute);
        let mut ends: [Vec<Link>; 2] = Default::default();
        for (end, (name, field)) in ends.iter_mut().zip([(from, from_field), (to, to_field)]) {
            match file.defs.get(name) {
                Some(Def::Built(node)) => end.push(Link { node: *node, field: field.to_string() }),
                Some(Def::Instance(number)) => match self.protos.instances[*number].ends(field) {
                    Some(links) => end.extend(links.iter().cloned()),
                    None => {
                        let message =
                            format!("ROUTE names {field:?}, which the prototype of {name:?} does not have");
                        return self.warn(file, element, message);
                    }
                },
                Some(Def::Unknown | Def::Hidden(_)) => return,
                _ => return self.warn(file, element, format!("ROUTE names {name:?}, which no DEF gives")),
            }
        }
        let [from, to] = &ends;
        self.routes_tried = self.routes_tried.saturating_add(from.len().saturating_mul(to.len()));
        if self.routes_tried > MAX_ROUTES {
            let message = format!("ROUTE is beyond the {MAX_ROUTES} that there may be");
            return self.warn(file, element, message);
        }
        for (from, to) in from.iter().flat_map(|from| to.iter().map(move |to| (from, to))) {
            match self.joined(from, to) {
                Ok(route) => self.graph.routes.push(route),
                Err(message) => self.warn(file, element, message),
            }
        }
    }

    /// Returns the route between two fields, or the message that says why it is invalid.
    fn joined(&self, from: &Link, to: &Link) -> Result<Route, String> {
        let missing = |link: &Link| {
            let node = self.graph.nodes[link.node as usize].ty.name;
            format!("ROUTE names {:?}, which <{node}> does not have", link.field)
        };
        let (output, sent) =
            route::output(&self.graph, from.node, &from.field).ok_or_else(|| missing(from))?;
        let (input, taken) = route::input(&self.graph, to.node, &to.field).ok_or_else(|| missing(to))?;
        if sent != taken {
            let (sent, taken) = (sent.describe(), taken.describe());
            return Err(format!(
                "ROUTE from {:?} ({sent}) to {:?} ({taken}) joins different types",
                from.field, to.field
            ));
        }
        Ok(Route { from: from.node, output, to: to.node, input })
    }
}

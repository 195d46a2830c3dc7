//! What a node refers to beyond its own element: Inline files, pictures, and the two ends of a ROUTE.

use super::build::{Builder, Def, File};
use super::graph::NodeId;
use super::route::{self, Route};
use super::schema::NodeType;
use super::value::Value;
use super::{texture, url};
use crate::load::LoadError;
use crate::scene::Texture;
use roxmltree::Node as Element;
use std::sync::Arc;

impl Builder<'_> {
    /// The scene of an Inline; `None` when it is not to be loaded or cannot be found.
    pub(super) fn inline(
        &mut self,
        file: &File,
        element: Element,
        ty: &'static NodeType,
        values: &[Value],
        depth: usize,
    ) -> Result<Option<NodeId>, LoadError> {
        let field = |name| &values[ty.field(name).expect("the table has it")];
        let (Value::Texts(urls), Value::Bool(true)) = (field("url"), field("load")) else { return Ok(None) };
        for name in urls.iter() {
            for path in url::local_paths(&file.folder, name) {
                match self.inlined.get(&path) {
                    Some(Some(scene)) => return Ok(Some(*scene)),
                    Some(None) => {
                        let expected = format!("no Inline of {path:?}, which inlines this file (a cycle)");
                        return Err(self.refuse(file, element, "url", expected));
                    }
                    None => {}
                }
                let Some(bytes) = (self.opener)(&path) else { continue };
                self.inlined.insert(path.clone(), None);
                let folder = path.rfind('/').map_or(String::new(), |i| path[..=i].to_string());
                let shown = format!("{}{path}", self.shown_folder);
                let scene = self.file(&bytes, &shown, folder, depth)?;
                self.inlined.insert(path, Some(scene));
                return Ok(Some(scene));
            }
        }
        if !urls.is_empty() {
            let message =
                format!("Inline {:?} cannot be found in the scene's folder and was skipped", &urls[..]);
            self.warn(file, element, message);
        }
        Ok(None)
    }

    /// The picture of a texture node.
    pub(super) fn picture(
        &mut self,
        file: &File,
        element: Element,
        ty: &'static NodeType,
        values: &[Value],
    ) -> Result<Option<Arc<Texture>>, LoadError> {
        let field = |name| &values[ty.field(name).expect("the table has it")];
        let result = match ty.name {
            "ImageTexture" => match (field("url"), field("load")) {
                (Value::Texts(urls), Value::Bool(true)) if !urls.is_empty() => {
                    self.pictures.load(urls, &file.folder, self.opener, self.memory).map(Some)
                }
                _ => Ok(None),
            },
            "PixelTexture" => match field("image") {
                Value::Ints(image) => texture::pixels(image, self.memory),
                _ => Ok(None),
            },
            _ => Ok(None),
        };
        match result {
            Ok(picture) => Ok(picture),
            Err(texture::PictureError::Unusable(reasons)) => {
                self.warn(file, element, format!("texture left out: {reasons}"));
                Ok(None)
            }
            Err(texture::PictureError::OverMemory(kind)) => {
                let place = self.sources[file.source].place(element.range().start);
                Err(LoadError::new(place, kind))
            }
            Err(texture::PictureError::Pixels(expected)) => {
                Err(self.refuse(file, element, "image", expected))
            }
        }
    }

    /// Joins a ROUTE; one that joins nothing is a warning.
    pub(super) fn route(&mut self, file: &File, element: Element) {
        let attribute = |name: &str| element.attribute(name).unwrap_or("");
        let [from, from_field, to, to_field] = ["fromNode", "fromField", "toNode", "toField"].map(attribute);
        let mut ends = [0; 2];
        for (end, name) in ends.iter_mut().zip([from, to]) {
            match file.defs.get(name) {
                Some(Def::Built(id)) => *end = *id,
                Some(Def::Unknown | Def::Hidden(_)) => return,
                _ => return self.warn(file, element, format!("ROUTE names {name:?}, which no DEF gives")),
            }
        }
        let [from_id, to_id] = ends;
        let missing = |id: NodeId, field: &str| {
            let node = self.graph.nodes[id as usize].ty.name;
            format!("ROUTE names {field:?}, which <{node}> does not have")
        };
        let output = route::output(&self.graph, from_id, from_field);
        let input = route::input(&self.graph, to_id, to_field);
        let message = match (output, input) {
            (None, _) => missing(from_id, from_field),
            (_, None) => missing(to_id, to_field),
            (Some((_, sent)), Some((_, taken))) if sent != taken => {
                let (sent, taken) = (sent.describe(), taken.describe());
                format!("ROUTE from {from_field:?} ({sent}) to {to_field:?} ({taken}) joins different types")
            }
            (Some((output, _)), Some((input, _))) => {
                self.graph.routes.push(Route { from: from_id, output, to: to_id, input });
                return;
            }
        };
        self.warn(file, element, message);
    }
}

//! An element's attributes to the fields of its node; what is wrong in them, at its byte.

use super::build::{Builder, File};
use super::cost;
use super::graph::Origin;
use super::schema::{self, NodeType};
use super::units::in_radians;
use super::unknown;
use super::value::{self, Value, ValueError, ValueFault};
use super::xml;
use crate::load::{FilePosition, LoadError, LoadErrorKind};
use roxmltree::Node as Element;

impl<'d> Builder<'d, '_> {
    /// An element's fields, in radians where they are angles, and the byte at which each is written.
    pub(super) fn fields(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        ty: &'static NodeType,
    ) -> Result<(Vec<Value>, Vec<usize>), LoadError> {
        let key = (file.source, element.id());
        if let Some(read) = self.protos.read.get(&key) {
            return Ok(read.clone());
        }
        let mut values = ty.defaults.clone();
        let mut written = vec![element.range().start; values.len()];
        // An unknown node's fields are not known either.
        let attributes = element.attributes().filter(|a| a.namespace().is_none() && !unknown::is_group(ty));
        for attribute in attributes {
            let name = attribute.name();
            let Some(index) = ty.field(name) else {
                if !schema::is_common_attribute(name) {
                    self.warn(file, element, format!("<{}> has no field {name:?}", ty.name));
                }
                continue;
            };
            let field = ty.fields[index];
            written[index] = attribute.range_value().start;
            let memory = &self.context.memory;
            let read = value::read_until(field.kind, attribute.value(), memory.cancel());
            memory.check_cancelled().map_err(|kind| self.over_memory(file, element, kind))?;
            let value = read.map_err(|e| {
                let place = xml::place_in(self.sources[file.source], &attribute, e.at);
                bad_value(place, ty, field, &e)
            })?;
            values[index] = in_radians(value, ty.name, name, file.units.angle);
        }
        if file.given.is_some() {
            // Every instance of a prototype reads the same text.
            self.hold(file, element, cost::read_bytes(ty))?;
            self.protos.read.insert(key, (values.clone(), written.clone()));
        }
        Ok((values, written))
    }

    /// Warns of text among elements, which no X3D node has, at the place of its first word.
    pub(super) fn stray_text(&mut self, file: &File, element: Element) {
        let source = self.sources[file.source];
        for text in element.children().filter(Element::is_text) {
            let words = text.text().unwrap_or("");
            let begin = words.len() - words.trim_start().len();
            if begin < words.len() {
                let word: String = words[begin..].lines().next().unwrap_or("").chars().take(24).collect();
                // Text with references is shorter than what is written.
                let is_verbatim = source.text.get(text.range()) == Some(words);
                let byte = text.range().start + if is_verbatim { begin } else { 0 };
                let message = format!("text in <{}> was skipped: {word:?}", element.tag_name().name());
                self.warn_at(Origin { source: file.source, byte }, message);
            }
        }
    }
}

/// The refusal of a field's text.
fn bad_value(place: FilePosition, ty: &NodeType, field: &schema::FieldDef, error: &ValueError) -> LoadError {
    let asked = format!("<{}> {} takes {}", ty.name, field.name, field.kind.describe());
    let kind = match &error.fault {
        ValueFault::NotANumber(found) => LoadErrorKind::Number { what: field.name, found: found.clone() },
        ValueFault::NotAnInt(found) | ValueFault::NotABool(found) => {
            LoadErrorKind::Syntax { expected: asked, found: found.clone() }
        }
        ValueFault::Count(count) => {
            LoadErrorKind::Syntax { expected: asked, found: format!("{count} numbers") }
        }
        ValueFault::OpenQuote => {
            LoadErrorKind::Syntax { expected: asked, found: "a quote without its end".into() }
        }
    };
    LoadError::new(place, kind)
}

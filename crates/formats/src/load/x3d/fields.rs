//! Parsing of an element's attributes to field values, with errors at their byte.

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
    /// Parses an element's fields, with angles in radians. Also returns the byte offset of each.
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
        // The fields of an unknown node are unknown too.
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

    /// Warns about text among elements, which no X3D node has, at the position of its first word.
    pub(super) fn stray_text(&mut self, file: &File, element: Element) {
        let source = self.sources[file.source];
        for text in element.children().filter(Element::is_text) {
            let words = text.text().unwrap_or("");
            let begin = words.len() - words.trim_start().len();
            if begin < words.len() {
                let word: String = words[begin..].lines().next().unwrap_or("").chars().take(24).collect();
                // With references, the text is shorter than its source.
                let is_verbatim = source.text.get(text.range()) == Some(words);
                let byte = text.range().start + if is_verbatim { begin } else { 0 };
                let message = format!("text in <{}> was skipped: {word:?}", element.tag_name().name());
                self.warn_at(Origin { source: file.source, byte }, message);
            }
        }
    }

    /// Warns about text in an element that is no node, and in its parts that are none either.
    pub(super) fn stray_text_in_parts(&mut self, file: &File<'d>, element: Element<'d, 'd>) {
        self.stray_text(file, element);
        let children = |e: Element<'d, 'd>| e.children().filter(Element::is_element);
        let inner = children(element).chain(children(element).flat_map(children));
        for part in inner.filter(|e| PARTS.contains(&e.tag_name().name())) {
            self.stray_text(file, part);
        }
    }
}

/// Elements of a file that are no nodes: those of its head and of prototypes.
const PARTS: [&str; 9] =
    ["ProtoInterface", "ProtoBody", "field", "fieldValue", "IS", "connect", "component", "meta", "unit"];

/// Returns the error for a field's text.
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

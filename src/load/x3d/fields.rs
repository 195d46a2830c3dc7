//! An element's attributes to the fields of its node; what is wrong in them, at its byte.

use super::build::{Builder, File};
use super::schema::{self, NodeType};
use super::value::{self, Value, ValueError, ValueFault};
use super::xml;
use crate::load::{LoadError, LoadErrorKind, Place};
use roxmltree::Node as Element;

impl Builder<'_> {
    /// An element's fields, and the byte at which each is written.
    pub(super) fn fields(
        &mut self,
        file: &File,
        element: Element,
        ty: &'static NodeType,
        source: &xml::Source,
    ) -> Result<(Vec<Value>, Vec<usize>), LoadError> {
        let mut values = ty.defaults.clone();
        let mut written = vec![element.range().start; values.len()];
        for attribute in element.attributes().filter(|a| a.namespace().is_none()) {
            let name = attribute.name();
            let Some(index) = ty.field(name) else {
                if !schema::is_common_attribute(name) {
                    self.warn(file, element, format!("<{}> has no field {name:?}", ty.name));
                }
                continue;
            };
            let field = ty.fields[index];
            let range = attribute.range_value();
            written[index] = range.start;
            values[index] = value::read(field.kind, attribute.value()).map_err(|e| {
                // Only a text without references and tabs has the same bytes in the file.
                let is_verbatim =
                    source.text.get(range.clone()).is_some_and(|t| t.len() == attribute.value().len());
                let place = source.place(range.start + if is_verbatim { e.at } else { 0 });
                bad_value(place, ty, field, &e)
            })?;
        }
        Ok((values, written))
    }

    /// Refuses text among elements, which no X3D node has.
    pub(super) fn no_text(&self, file: &File, element: Element) -> Result<(), LoadError> {
        let source = &self.sources[file.source];
        for text in element.children().filter(Element::is_text) {
            let words = text.text().unwrap_or("");
            let begin = words.len() - words.trim_start().len();
            if begin < words.len() {
                let name = element.tag_name().name();
                return Err(source.refuse(text.range().start + begin, format!("only elements in <{name}>")));
            }
        }
        Ok(())
    }
}

/// The refusal of a field's text.
fn bad_value(place: Place, ty: &NodeType, field: &schema::FieldDef, error: &ValueError) -> LoadError {
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

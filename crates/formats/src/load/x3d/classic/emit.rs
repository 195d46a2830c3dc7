//! The tree of a classic text as XML.

use super::parser::{Body, Declared, Field, Name, Node, Proto, Statement, Value};
use crate::load::x3d::schema;
use crate::load::x3d::value::Kind;
use crate::load::x3d::xml::Part;
use std::collections::HashMap;

/// Names of one scope: a file, or the body of a prototype.
#[derive(Default)]
struct Scope<'s> {
    /// Type of the last node with each name so far.
    defs: HashMap<&'s str, &'s str>,
    /// Types of the fields of each prototype declared so far.
    protos: HashMap<&'s str, HashMap<&'s str, &'s str>>,
}

struct Writer<'s> {
    text: String,
    parts: Vec<Part>,
    scopes: Vec<Scope<'s>>,
    /// Type of the first node with each name in the file.
    all_defs: HashMap<&'s str, &'s str>,
}

/// Returns the XML of a file, and the places of its parts.
pub(super) fn document(statements: &[Statement]) -> (String, Vec<Part>) {
    let mut writer = Writer {
        text: String::new(),
        parts: Vec::new(),
        scopes: vec![Scope::default()],
        all_defs: HashMap::new(),
    };
    writer.find_defs(statements);
    writer.raw("<X3D><head>");
    for statement in statements {
        if let Statement::Unit { at, words: [category, name, factor] } = statement {
            writer.open("unit", *at);
            writer.attributes(&[("category", category), ("name", name), ("conversionFactor", factor)]);
            writer.raw("/>");
        }
    }
    writer.raw("</head><Scene>");
    writer.statements(statements, "children");
    writer.raw("</Scene></X3D>");
    (writer.text, writer.parts)
}

/// Returns a name that XML allows for elements and attributes.
fn xml_name(name: &str) -> String {
    let is_inner = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    let mut safe: String = name.chars().map(|c| if is_inner(c) { c } else { '_' }).collect();
    let is_first = |c: char| c.is_ascii_alphabetic() || c == '_';
    if !safe.starts_with(is_first) || matches!(safe.as_str(), "xmlns" | "DEF" | "USE" | "containerField") {
        safe.insert(0, '_');
    }
    safe
}

/// Returns the field of X3D that VRML 97 had under another name.
fn field_of<'s>(ty: &str, field: &'s str) -> &'s str {
    match (ty, field) {
        ("Switch", "choice") | ("LOD", "level") => "children",
        ("Collision", "collide") => "enabled",
        _ => field,
    }
}

/// Returns the text of a string in quotes, without its escapes.
fn unescaped(quoted: &str) -> String {
    let mut characters = quoted[1..quoted.len() - 1].chars();
    let mut text = String::new();
    while let Some(c) = characters.next() {
        match (c, characters.as_str().chars().next()) {
            ('\\', Some(escaped @ ('"' | '\\'))) => {
                characters.next();
                text.push(escaped);
            }
            _ => text.push(c),
        }
    }
    text
}

/// Returns the words of a value with blanks in the place of comments and line ends, so that each word
/// keeps its offset.
fn uncommented(words: &str) -> String {
    let mut is_comment = false;
    let mut blanked = Vec::with_capacity(words.len());
    for &byte in words.as_bytes() {
        is_comment = byte == b'#' || is_comment && !matches!(byte, b'\n' | b'\r');
        blanked.push(if is_comment || byte.is_ascii_whitespace() { b' ' } else { byte });
    }
    String::from_utf8(blanked).expect("only whole comments and ASCII bytes are replaced")
}

impl<'s> Writer<'s> {
    fn find_defs(&mut self, statements: &[Statement<'s>]) {
        for statement in statements {
            match statement {
                Statement::Node(node) => {
                    if let Some(def) = node.def {
                        self.all_defs.entry(def.text).or_insert(node.ty.text);
                    }
                    self.find_defs(&node.inner);
                    let declared = node.declared.iter().filter_map(|d| d.value.as_ref());
                    for value in node.fields.iter().map(|f| &f.value).chain(declared) {
                        if let Value::Nodes(nodes) = value {
                            self.find_defs(nodes);
                        }
                    }
                }
                Statement::Proto(Proto { body: Body::Own(body), .. }) => self.find_defs(body),
                _ => {}
            }
        }
    }

    fn raw(&mut self, text: &str) {
        self.text.push_str(text);
    }

    /// Notes that what is written next comes from a byte offset of the classic text.
    fn from(&mut self, classic: usize, same: usize) {
        self.parts.push(Part { xml: self.text.len(), classic, same });
    }

    /// Begins a tag.
    fn open(&mut self, element: &str, at: usize) {
        self.from(at, 0);
        self.text.push('<');
        self.raw(element);
    }

    /// Writes text inside an attribute.
    fn escaped(&mut self, text: &str) {
        for c in text.chars() {
            match c {
                '&' => self.raw("&amp;"),
                '<' => self.raw("&lt;"),
                '"' => self.raw("&quot;"),
                '\n' => self.raw("&#10;"),
                '\r' => self.raw("&#13;"),
                '\t' => self.raw("&#9;"),
                // XML has no way to write these.
                '\0'..' ' | '\u{fffe}' | '\u{ffff}' => self.text.push('\u{fffd}'),
                c => self.text.push(c),
            }
        }
    }

    fn begin_attribute(&mut self, name: &str) {
        self.raw(" ");
        self.raw(name);
        self.raw("=\"");
    }

    fn attributes(&mut self, all: &[(&str, &str)]) {
        for (name, value) in all {
            self.begin_attribute(name);
            self.escaped(value);
            self.raw("\"");
        }
    }

    /// Writes a field's value as an attribute, if it is one.
    fn attribute(&mut self, name: &str, kind: Option<Kind>, value: &Value) {
        if !matches!(value, Value::Words(_) | Value::Strings(_))
            && (kind.is_none() || !matches!(value, Value::Empty))
        {
            return;
        }
        self.begin_attribute(name);
        match value {
            Value::Words(words) => {
                self.from(words.at, words.text.len());
                self.escaped(&uncommented(words.text));
            }
            Value::Strings(strings) => match (kind, &strings[..]) {
                (Some(Kind::Text), [one]) => {
                    self.from(one.at + 1, 0);
                    self.escaped(&unescaped(one.text));
                }
                _ => {
                    for string in strings {
                        self.from(string.at, 0);
                        self.escaped(string.text);
                        self.raw(" ");
                    }
                }
            },
            _ => {}
        }
        self.raw("\"");
    }

    /// Returns the types of the fields of a prototype.
    fn proto(&self, name: &str) -> Option<&HashMap<&'s str, &'s str>> {
        self.scopes.iter().rev().find_map(|scope| scope.protos.get(name))
    }

    fn statements(&mut self, statements: &[Statement<'s>], container: &str) {
        for statement in statements {
            match statement {
                Statement::Node(node) => self.node(node, container),
                Statement::Use(name) => self.used(*name, container),
                Statement::Proto(proto) => self.declaration(proto),
                Statement::Route { at, from: [from, output], to: [to, input] } => {
                    self.open("ROUTE", *at);
                    self.attributes(&[
                        ("fromNode", from),
                        ("fromField", output),
                        ("toNode", to),
                        ("toField", input),
                    ]);
                    self.raw("/>");
                }
                Statement::Elsewhere(keyword) => {
                    self.open(keyword.text, keyword.at);
                    self.raw("/>");
                }
                Statement::Unit { .. } => {}
            }
        }
    }

    /// Begins the tag of a node of a type in the field `container`. Returns whether it is an instance
    /// of a prototype.
    fn begin(&mut self, ty: &str, at: usize, container: &str) -> bool {
        let is_instance = self.proto(ty).is_some();
        match is_instance {
            true => {
                self.open("ProtoInstance", at);
                self.attributes(&[("name", ty)]);
            }
            false => self.open(&xml_name(ty), at),
        }
        let default = schema::lookup(ty).filter(|_| !is_instance).map_or("children", |ty| ty.container);
        if container != default {
            self.attributes(&[("containerField", container)]);
        }
        is_instance
    }

    fn used(&mut self, name: Name<'s>, container: &str) {
        let own = self.scopes.last().and_then(|scope| scope.defs.get(name.text));
        let ty = own.or_else(|| self.all_defs.get(name.text)).copied();
        // Without any DEF the reader warns of the name, whatever its type.
        self.begin(ty.unwrap_or("Group"), name.at, container);
        self.attributes(&[("USE", name.text)]);
        self.raw("/>");
    }

    fn node(&mut self, node: &Node<'s>, container: &str) {
        let ty = node.ty.text;
        let is_instance = self.begin(ty, node.ty.at, container);
        if let Some(def) = node.def {
            self.attributes(&[("DEF", def.text)]);
        }
        let schema = schema::lookup(ty).filter(|_| !is_instance);
        if !is_instance {
            for Field { name, value } in &node.fields {
                let field = field_of(ty, name.text);
                let kind = schema.and_then(|ty| Some(ty.fields[ty.field(field)?].kind));
                self.attribute(&xml_name(field), kind, value);
            }
        }
        self.raw(">");
        self.connections(node.fields.iter().map(|f| (field_of(ty, f.name.text), &f.value)));
        for field in &node.declared {
            self.declared(field);
        }
        for Field { name, value } in &node.fields {
            match (is_instance, value) {
                (true, Value::Is(_)) => {}
                (true, value) => self.given(ty, *name, value),
                (false, Value::Nodes(nodes)) => self.statements(nodes, field_of(ty, name.text)),
                (false, _) => {}
            }
        }
        self.statements(&node.inner, "children");
        // Valid after the node: a USE inside of it would make it contain itself.
        if let (Some(def), Some(scope)) = (node.def, self.scopes.last_mut()) {
            scope.defs.insert(def.text, ty);
        }
        match is_instance {
            true => self.raw("</ProtoInstance>"),
            false => {
                self.raw("</");
                self.raw(&xml_name(ty));
                self.raw(">");
            }
        }
    }

    /// Writes the IS of a node, if any of its fields has one.
    fn connections<'v>(&mut self, fields: impl Iterator<Item = (&'v str, &'v Value<'s>)>)
    where
        's: 'v,
    {
        let mut is_open = false;
        for (field, value) in fields {
            let Value::Is(outer) = value else { continue };
            if !std::mem::replace(&mut is_open, true) {
                self.raw("<IS>");
            }
            self.open("connect", outer.at);
            self.attributes(&[("nodeField", field), ("protoField", outer.text)]);
            self.raw("/>");
        }
        if is_open {
            self.raw("</IS>");
        }
    }

    /// Writes the value of a prototype's field in an instance.
    fn given(&mut self, proto: &str, name: Name<'s>, value: &Value<'s>) {
        let ty = self.proto(proto).and_then(|fields| fields.get(name.text)).copied();
        self.open("fieldValue", name.at);
        self.attributes(&[("name", name.text)]);
        self.typed(ty.unwrap_or(""), value);
        self.raw("</fieldValue>");
    }

    /// Writes a value of a type as the attribute `value`, ends the tag, and writes the nodes inside.
    fn typed(&mut self, ty: &str, value: &Value<'s>) {
        if !ty.ends_with("Node") {
            self.attribute("value", Some(if ty == "SFString" { Kind::Text } else { Kind::Texts }), value);
        }
        self.raw(">");
        if let Value::Nodes(nodes) = value {
            self.statements(nodes, "children");
        }
    }

    fn declared(&mut self, field: &Declared<'s>) {
        self.open("field", field.name.at);
        self.attributes(&[("accessType", field.access), ("type", field.ty.text), ("name", field.name.text)]);
        match &field.value {
            Some(value) => self.typed(field.ty.text, value),
            None => self.raw(">"),
        }
        self.raw("</field>");
    }

    fn declaration(&mut self, proto: &Proto<'s>) {
        match &proto.body {
            Body::Own(body) => {
                self.open("ProtoDeclare", proto.name.at);
                self.attributes(&[("name", proto.name.text)]);
                self.raw("><ProtoInterface>");
                self.scopes.push(Scope::default());
                proto.interface.iter().for_each(|field| self.declared(field));
                self.raw("</ProtoInterface><ProtoBody>");
                self.statements(body, "children");
                self.scopes.pop();
                self.raw("</ProtoBody></ProtoDeclare>");
            }
            Body::Elsewhere(urls) => {
                self.open("ExternProtoDeclare", proto.name.at);
                self.attributes(&[("name", proto.name.text)]);
                let urls: Vec<&str> = urls.iter().map(|url| url.text).collect();
                self.attributes(&[("url", &urls.join(" "))]);
                self.raw(">");
                proto.interface.iter().for_each(|field| self.declared(field));
                self.raw("</ExternProtoDeclare>");
            }
        }
        let fields = proto.interface.iter().map(|f| (f.name.text, f.ty.text)).collect();
        if let Some(scope) = self.scopes.last_mut() {
            scope.protos.insert(proto.name.text, fields);
        }
    }
}

//! ProtoInstance: expansion of a prototype's body to nodes, with the field values of the instance.
//!
//! The first node of the body takes the place of the instance; the others (sensors, interpolators)
//! only serve routes (ISO/IEC 19775-1 clause 4.4.4.2). Each instance has its own nodes, names and
//! routes (4.4.4.3), except for parts of the body that are equal in every instance, which all of
//! them share. `IS` sets a field of a node in the body to the instance's value of a prototype
//! field, or to that field's default (4.4.4.4); a route to or from the instance continues to the
//! fields connected by IS. Memory for nodes is reserved before they are created, and their number
//! is limited.

use super::build::{Builder, File};
use super::cost;
use super::graph::{Child, NodeId};
use super::names::{Def, hide};
use super::schema::{self, NodeType};
use super::units::Units;
use super::value::{self, Kind, Value, ValueFault};
use super::{unknown, validate, xml};
use crate::load::{LoadError, LoadErrorKind};
use roxmltree::Node as Element;
use std::collections::HashMap;
use std::rc::Rc;

/// Most nodes, prototype fields and connections that the instances of a scene may create.
const MAX_EXPANDED: u64 = 1 << 20;

/// Bytes of an instance and of its environment.
const INSTANCE_BYTES: usize = size_of::<Instance>() + 512;
/// Bytes of an instance's value for one field, and of the field's name and list of links.
const FIELD_BYTES: usize = size_of::<Gift>() + 192;
/// Bytes of one link, in a vector that is copied as it grows and has up to twice the room.
pub(super) const LINK_BYTES: usize = 3 * size_of::<Link>();

/// A field of a prototype.
pub(super) struct Field<'d> {
    name: &'d str,
    /// Declaration of the field; its children are the default of a field of nodes.
    pub(super) element: Element<'d, 'd>,
    pub(super) ty: FieldType,
    default: Option<Value>,
}

/// Type of a field's values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum FieldType {
    Value(Kind),
    Nodes,
}

/// Value that an instance gives to a field.
#[derive(Clone)]
pub(super) enum Gift {
    Nothing,
    Value(GivenValue),
    Nodes(Rc<[NodeId]>),
    /// The nodes in the field's declaration, built when they are first needed.
    DefaultNodes,
}

/// Value of a prototype field, with the properties of the file that gives it.
#[derive(Clone)]
pub(super) struct GivenValue {
    pub(super) value: Value,
    pub(super) kind: Kind,
    /// The file's unit of angle in radians.
    pub(super) angle: f64,
    /// The file's folder, to which the value's relative URLs refer (ISO/IEC 14772-1 clause 4.5.3).
    /// URLs that a body itself contains refer to the prototype's folder, in which its author tried
    /// them, though that clause has them refer to the instance's, too.
    pub(super) folder: Rc<str>,
}

/// A field of a node in the body that IS connects to a field of the prototype.
#[derive(Clone, Debug)]
pub(super) struct Link {
    pub(super) node: NodeId,
    pub(super) field: String,
}

/// Values that an instance gives to the prototype's fields, while its body is being built.
pub(super) struct Given<'d> {
    pub(super) interface: Rc<[Field<'d>]>,
    pub(super) gifts: Vec<Gift>,
    /// For each field, the connections found so far.
    pub(super) links: Vec<Vec<Link>>,
}

impl Given<'_> {
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.interface.iter().position(|f| f.name == name)
    }

    /// Connects a new node: `links` are pairs of a prototype field's index and a node field's name.
    pub(super) fn link(&mut self, links: &[(usize, &str)], node: NodeId) {
        for (number, field) in links {
            self.links[*number].push(Link { node, field: (*field).to_string() });
        }
    }
}

/// A finished instance.
#[derive(Default)]
pub(super) struct Instance {
    /// First node of its body, unless that is of unknown type.
    pub(super) node: Option<NodeId>,
    /// Connections of each field of the prototype, by name.
    links: HashMap<String, Vec<Link>>,
}

impl Instance {
    /// Returns the fields that a route to or from `field` continues to; `None` if the prototype has
    /// no such field.
    pub(super) fn ends(&self, field: &str) -> Option<&[Link]> {
        let bare = field.strip_prefix("set_").or_else(|| field.strip_suffix("_changed"));
        let found = self.links.get(field).or_else(|| self.links.get(bare?));
        found.map(Vec::as_slice)
    }
}

/// Returns the value type of an X3D field type; `None` for types that no supported node has.
fn field_type(name: &str) -> Option<FieldType> {
    let (is_many, base) = match (name.strip_prefix("SF"), name.strip_prefix("MF")) {
        (Some(base), _) => (false, base),
        (_, Some(base)) => (true, base),
        _ => return None,
    };
    let width = match base {
        "Node" => return Some(FieldType::Nodes),
        "Float" | "Double" | "Time" => 1,
        "Vec2f" | "Vec2d" => 2,
        "Vec3f" | "Vec3d" | "Color" => 3,
        "Vec4f" | "Vec4d" | "ColorRGBA" | "Rotation" => 4,
        _ => {
            let kind = match name {
                "SFBool" => Kind::Bool,
                "SFInt32" => Kind::Int,
                "MFInt32" => Kind::Ints,
                "SFImage" => Kind::Image,
                "SFString" => Kind::Text,
                "MFString" => Kind::Texts,
                _ => return None,
            };
            return Some(FieldType::Value(kind));
        }
    };
    Some(FieldType::Value(if is_many { Kind::Mf(width) } else { Kind::Sf(width) }))
}

impl<'d> Builder<'d, '_> {
    /// Returns the node of a ProtoInstance, expanded or referred to by USE; `None` if there is
    /// nothing to show.
    pub(super) fn instance_or_use(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        depth: usize,
    ) -> Result<Option<NodeId>, LoadError> {
        self.stray_text_in_parts(file, element);
        if let Some(used) = element.attribute("USE") {
            return self.used(file, element, used, depth);
        }
        let def = element.attribute("DEF").filter(|d| !d.is_empty());
        self.open_def(file, element, def);
        let instance = self.instance(file, element, depth)?;
        let node = instance.as_ref().and_then(|i| i.node);
        if let Some(name) = def {
            let def = match instance {
                Some(instance) => {
                    self.protos.instances.push(instance);
                    Def::Instance(self.protos.instances.len() - 1)
                }
                None => Def::Unknown,
            };
            file.defs.insert(name, def);
            if let Some(node) = node {
                self.graph.nodes[node as usize].def = Some(name.to_string());
            }
        }
        Ok(node)
    }

    /// Expands an instance; `None`, with a warning, if its prototype cannot be found or used.
    fn instance(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        depth: usize,
    ) -> Result<Option<Instance>, LoadError> {
        let name = element.attribute("name").unwrap_or("");
        let Some(named) = self.protos.named(file.environment, name) else {
            let message =
                format!("no prototype {name:?} is declared before this instance, which was skipped");
            self.warn(file, element, message);
            hide(file, element);
            return Ok(None);
        };
        let Some(number) = self.with_body(named, 0)? else {
            hide(file, element);
            return Ok(None);
        };
        if self.protos.expanding.contains(&number) {
            self.has_cycle = true;
            let expected = format!("no instance of {name:?} inside of itself (prototypes are not recursive)");
            return Err(self.refuse(file, element, "name", expected));
        }
        if depth >= xml::MAX_DEPTH {
            let source = self.sources[file.source];
            let limit = xml::MAX_DEPTH as u64;
            return Err(source.too_big(element.range().start, "nesting of nodes", depth as u64 + 1, limit));
        }
        let interface = match self.interface(number) {
            Ok(interface) => interface,
            Err(error) => {
                self.refuse_proto(named, number, &self.mark(), error)?;
                hide(file, element);
                return Ok(None);
            }
        };
        self.count_expanded(file, element, 1 + interface.len())?;
        self.hold(file, element, INSTANCE_BYTES + interface.len() * FIELD_BYTES)?;
        let given = self.given(file, element, interface, number, depth)?;
        let mark = self.mark();
        self.protos.expanding.push(number);
        let mut made = self.body(number, given, depth);
        self.protos.expanding.pop();
        if named != number && made.is_ok() {
            made = validate::nodes(self, mark.first()).and(made);
        }
        let (node, given) = match made {
            Ok(made) => made,
            Err(error) => return self.refuse_proto(named, number, &mark, error).map(|()| None),
        };
        self.join_outer(file, element, &given)?;
        let own = self.protos.all[number].units;
        let node = node.map(|node| self.aligned(file, element, node, own)).transpose()?;
        let names = given.interface.iter().map(|f| f.name.to_string());
        Ok(Some(Instance { node, links: names.zip(given.links).collect() }))
    }

    /// Returns a prototype's fields, with their defaults.
    fn interface(&mut self, number: usize) -> Result<Rc<[Field<'d>]>, LoadError> {
        let proto = &self.protos.all[number];
        if let Some(interface) = &proto.interface {
            return Ok(Rc::clone(interface));
        }
        let source = self.sources[proto.source];
        let origin = |e: &Element| super::graph::Origin { source: proto.source, byte: e.range().start };
        let declared = proto.element.children().filter(|c| c.tag_name().name() == "ProtoInterface");
        let mut fields: Vec<Field> = Vec::new();
        let mut remarks = Vec::new();
        for element in declared.flat_map(|i| i.children()).filter(|c| c.tag_name().name() == "field") {
            let name = element.attribute("name").unwrap_or("");
            let Some(ty) = element.attribute("type").and_then(|t| field_type(t.trim())) else {
                let ty = element.attribute("type").unwrap_or("");
                remarks.push((
                    origin(&element),
                    format!("field {name:?} has a type, {ty:?}, that is not known"),
                ));
                continue;
            };
            let default = match (ty, element.attribute_node("value")) {
                (FieldType::Value(kind), Some(text)) => Some(read_field(source, name, kind, &text)?),
                // Without a value, the nodes in the body keep their own.
                (FieldType::Value(_), None) | (FieldType::Nodes, _) => None,
            };
            fields.push(Field { name, element, ty, default });
        }
        let interface: Rc<[Field]> = fields.into();
        self.protos.all[number].interface = Some(Rc::clone(&interface));
        for (origin, remark) in remarks {
            self.warn_at(origin, remark);
        }
        Ok(interface)
    }

    /// Returns the values that an instance gives to the fields: its fieldValue, the value that IS
    /// connects from an enclosing instance, or the default.
    fn given(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        interface: Rc<[Field<'d>]>,
        number: usize,
        depth: usize,
    ) -> Result<Given<'d>, LoadError> {
        let proto = &self.protos.all[number];
        let default = |field: &Field| match (&field.default, field.ty) {
            (Some(value), FieldType::Value(kind)) => Gift::Value(GivenValue {
                value: value.clone(),
                kind,
                angle: proto.units.angle,
                folder: Rc::clone(&proto.folder),
            }),
            (None, FieldType::Value(_)) => Gift::Nothing,
            (_, FieldType::Nodes) => Gift::DefaultNodes,
        };
        let gifts = interface.iter().map(default).collect();
        let links = vec![Vec::new(); interface.len()];
        let mut given = Given { interface, gifts, links };
        for child in element.children().filter(Element::is_element) {
            match child.tag_name().name() {
                "fieldValue" => {
                    let name = child.attribute("name").unwrap_or("");
                    let Some(i) = given.find(name) else {
                        let proto = self.protos.all[number].name;
                        self.warn(file, child, format!("prototype {proto:?} has no field {name:?}"));
                        continue;
                    };
                    match (given.interface[i].ty, child.attribute_node("value")) {
                        (FieldType::Value(kind), Some(text)) => {
                            let value = read_field(self.sources[file.source], name, kind, &text)?;
                            given.gifts[i] = Gift::Value(GivenValue {
                                value,
                                kind,
                                angle: file.units.angle,
                                folder: Rc::clone(&file.folder),
                            });
                        }
                        (FieldType::Value(_), None) => {}
                        (FieldType::Nodes, _) => {
                            given.gifts[i] = Gift::Nodes(self.loose_nodes(file, child, depth)?);
                        }
                    }
                }
                "IS" => self.given_by_outer(file, child, &mut given, depth)?,
                name if schema::is_silent(name) => hide(file, child),
                name => {
                    let message = format!("<{name}> cannot stand in <ProtoInstance> and was skipped");
                    self.warn(file, child, message);
                }
            }
        }
        Ok(given)
    }

    /// Builds a prototype's body. Returns its first node, and `given` with the connections added.
    fn body(
        &mut self,
        number: usize,
        given: Given<'d>,
        depth: usize,
    ) -> Result<(Option<NodeId>, Given<'d>), LoadError> {
        let proto = &self.protos.all[number];
        let (element, environment) = (proto.element, proto.environment);
        let (source, folder, document) = (proto.source, Rc::clone(&proto.folder), proto.document);
        let units = proto.units;
        let mut scope = File {
            source,
            folder,
            units,
            document,
            defs: HashMap::new(),
            routes: Vec::new(),
            environment: self.protos.add_environment(Some(environment)),
            given: Some(given),
        };
        let body = element.children().find(|c| c.tag_name().name() == "ProtoBody");
        let mut first = None;
        for child in body.iter().flat_map(|b| b.children()).filter(Element::is_element) {
            let built = self.element(&mut scope, child, unknown::anything(), depth + 1)?;
            if first.is_none() && schema::is_child(child.tag_name().name()) {
                first = Some(built.map(|c| c.node));
            }
        }
        for element in std::mem::take(&mut scope.routes) {
            self.route(&scope, element);
        }
        let given = scope.given.expect("given above, and nothing takes it");
        Ok((first.flatten(), given))
    }

    /// Returns an instance's node converted to the length unit of the file that contains the
    /// instance, by a Transform if necessary.
    fn aligned(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        node: NodeId,
        own: Units,
    ) -> Result<NodeId, LoadError> {
        let enlarged = own.length / file.units.length;
        let built = self.graph.nodes[node as usize].ty;
        if enlarged == 1.0 || built.container != "children" {
            return Ok(node);
        }
        let ty = schema::lookup("Transform").expect("the table has Transform");
        let child = Child { container: "children", node };
        let outer = self.plain_node(file, element, ty, vec![child])?;
        let scale = ty.field("scale").expect("the table has it");
        self.graph.nodes[outer as usize].values[scale] = Value::Reals([enlarged; 3].into());
        Ok(outer)
    }

    /// Reserves the memory of a node before it is created, and counts it if an instance creates it.
    pub(super) fn charge_node(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        ty: &NodeType,
    ) -> Result<(), LoadError> {
        if file.given.is_some() {
            self.count_expanded(file, element, 1)?;
        }
        let kept = self.context.memory.reserve_result(cost::bare_node_bytes(ty));
        kept.map_err(|kind| self.over_memory(file, element, kind))
    }

    /// Counts nodes, fields and connections that an instance is about to create.
    pub(super) fn count_expanded(
        &mut self,
        file: &File<'d>,
        element: Element<'d, 'd>,
        count: usize,
    ) -> Result<(), LoadError> {
        self.protos.made += count as u64;
        if self.protos.made <= MAX_EXPANDED {
            return Ok(());
        }
        let what = "nodes, fields and connections that prototypes make";
        let byte = element.range().start;
        Err(self.sources[file.source].too_big(byte, what, self.protos.made, MAX_EXPANDED))
    }
}

/// Parses the text of a prototype field's value.
fn read_field(
    source: &xml::XmlSource,
    name: &str,
    kind: Kind,
    text: &roxmltree::Attribute,
) -> Result<Value, LoadError> {
    value::read(kind, text.value()).map_err(|e| {
        let found = match e.fault {
            ValueFault::NotANumber(token) | ValueFault::NotAnInt(token) | ValueFault::NotABool(token) => {
                token
            }
            ValueFault::Count(count) => format!("{count} numbers"),
            ValueFault::OpenQuote => "a quote without its end".into(),
        };
        let expected = format!("field {name:?} takes {}", kind.describe());
        LoadError::new(xml::place_in(source, text, e.at), LoadErrorKind::Syntax { expected, found })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_type_of_the_standard_is_known_by_its_width() {
        for (name, kind) in [
            ("SFBool", Kind::Bool),
            ("SFInt32", Kind::Int),
            ("MFInt32", Kind::Ints),
            ("SFImage", Kind::Image),
            ("SFFloat", Kind::Sf(1)),
            ("SFTime", Kind::Sf(1)),
            ("MFDouble", Kind::Mf(1)),
            ("SFVec2f", Kind::Sf(2)),
            ("MFVec2d", Kind::Mf(2)),
            ("SFColor", Kind::Sf(3)),
            ("MFVec3f", Kind::Mf(3)),
            ("SFRotation", Kind::Sf(4)),
            ("MFColorRGBA", Kind::Mf(4)),
            ("SFString", Kind::Text),
            ("MFString", Kind::Texts),
        ] {
            assert_eq!(field_type(name), Some(FieldType::Value(kind)), "{name}");
        }
        assert_eq!(field_type("SFNode"), Some(FieldType::Nodes));
        assert_eq!(field_type("MFNode"), Some(FieldType::Nodes));
        for other in ["", "SF", "Float", "SFMatrix3f", "MFBool", "sffloat"] {
            assert_eq!(field_type(other), None, "{other}");
        }
    }
}

//! `IS`: connections between fields of nodes in a prototype's body and fields of the prototype.
//!
//! A node's field is set to the instance's value of the prototype field, or to that field's
//! default; the types must be equal (ISO/IEC 19775-1 clause 4.4.4.4, table 4.4). Fields of nodes
//! get the nodes themselves, if they are of the kind that the field takes. Connections are recorded
//! for routes too.

use super::build::{Builder, File, OpenNode};
use super::graph::{Child, NodeId};
use super::instance::{FieldType, Gift, Given, GivenValue, LINK_BYTES};
use super::names::{container_of, is_taken};
use super::units::in_radians;
use super::value::Value;
use super::{unknown, url};
use crate::load::LoadError;
use roxmltree::Node as Element;
use std::rc::Rc;

impl<'d> Builder<'d, '_> {
    /// Sets fields of an instance in another prototype's body to the values that IS connects from
    /// the enclosing instance.
    pub(super) fn given_by_outer(
        &mut self,
        file: &mut File<'d>,
        is: Element<'d, 'd>,
        given: &mut Given<'d>,
        depth: usize,
    ) -> Result<(), LoadError> {
        for (connect, outer, field) in self.connections(file, is) {
            let Some(i) = given.find(field) else {
                self.warn(file, connect, format!("IS names {field:?}, which the prototype does not have"));
                continue;
            };
            let gift = self.gift(file, outer, depth)?;
            given.gifts[i] = match (gift, given.interface[i].ty) {
                (gift @ Gift::Nodes(_), FieldType::Nodes) => gift,
                (Gift::Value(value), FieldType::Value(own)) if value.kind == own => Gift::Value(value),
                (Gift::Nothing | Gift::DefaultNodes, _) => continue,
                _ => {
                    self.warn(file, connect, format!("IS joins {field:?} to a field of another type"));
                    continue;
                }
            };
        }
        Ok(())
    }

    /// Returns the enclosing instance's value of its field `number`; default nodes are built here.
    fn gift(&mut self, file: &mut File<'d>, number: usize, depth: usize) -> Result<Gift, LoadError> {
        let Some(given) = &mut file.given else { return Ok(Gift::Nothing) };
        if !matches!(given.gifts[number], Gift::DefaultNodes) {
            return Ok(given.gifts[number].clone());
        }
        let element = given.interface[number].element;
        let nodes = Gift::Nodes(self.loose_nodes(file, element, depth)?);
        if let Some(given) = &mut file.given {
            given.gifts[number] = nodes.clone();
        }
        Ok(nodes)
    }

    /// Builds the nodes in a field or fieldValue, whatever their kind.
    pub(super) fn loose_nodes(
        &mut self,
        file: &mut File<'d>,
        holder: Element<'d, 'd>,
        depth: usize,
    ) -> Result<Rc<[NodeId]>, LoadError> {
        let mut nodes = Vec::new();
        for child in holder.children().filter(Element::is_element) {
            nodes.extend(self.element(file, child, unknown::anything(), depth + 1)?.map(|c| c.node));
        }
        Ok(nodes.into())
    }

    /// Connects the enclosing prototype's fields to the targets of an inner instance's fields.
    pub(super) fn join_outer(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        inner: &Given<'d>,
    ) -> Result<(), LoadError> {
        for is in element.children().filter(|c| c.tag_name().name() == "IS") {
            for (connect, number, field) in self.connections(file, is) {
                let Some(i) = inner.find(field) else { continue };
                let links = &inner.links[i];
                let names: usize = links.iter().map(|l| l.field.len()).sum();
                self.count_expanded(file, connect, links.len())?;
                self.hold(file, connect, links.len() * LINK_BYTES + names)?;
                if let Some(outer) = &mut file.given {
                    outer.links[number].extend(links.iter().cloned());
                }
            }
        }
        Ok(())
    }

    /// Returns the connections of an IS: the element, the index of the prototype's field, the name
    /// of the node's field.
    fn connections(
        &mut self,
        file: &File<'d>,
        is: Element<'d, 'd>,
    ) -> Vec<(Element<'d, 'd>, usize, &'d str)> {
        let mut found = Vec::new();
        for connect in is.children().filter(|c| c.tag_name().name() == "connect") {
            let [field, of_proto] = ["nodeField", "protoField"].map(|a| connect.attribute(a).unwrap_or(""));
            match &file.given {
                None => self.warn(file, connect, "IS stands outside of a ProtoBody and was skipped".into()),
                Some(given) => match given.find(of_proto) {
                    Some(number) => found.push((connect, number, field)),
                    None => {
                        let message = format!("IS names {of_proto:?}, which the prototype does not have");
                        self.warn(file, connect, message);
                    }
                },
            }
        }
        found
    }

    /// Sets the fields of a node in a body that IS connects. Returns pairs of a prototype field's
    /// index and a node field's name.
    pub(super) fn connect(
        &mut self,
        file: &mut File<'d>,
        element: Element<'d, 'd>,
        node: &mut OpenNode,
    ) -> Result<Vec<(usize, &'d str)>, LoadError> {
        let mut links = Vec::new();
        for is in element.children().filter(|c| c.tag_name().name() == "IS") {
            for (connect, number, field) in self.connections(file, is) {
                self.count_expanded(file, connect, 1)?;
                self.hold(file, connect, LINK_BYTES + field.len())?;
                links.push((number, field));
                match self.gift(file, number, node.depth)? {
                    Gift::Nothing | Gift::DefaultNodes => {}
                    Gift::Value(value) => self.connect_value(file, connect, field, value, node)?,
                    Gift::Nodes(nodes) => self.connect_nodes(file, connect, field, &nodes, node),
                }
            }
        }
        Ok(links)
    }

    /// Sets a field of a node in the body to a value.
    fn connect_value(
        &mut self,
        file: &File<'d>,
        connect: Element<'d, 'd>,
        field: &str,
        given: GivenValue,
        open: &mut OpenNode,
    ) -> Result<(), LoadError> {
        let ty = open.ty;
        match ty.field(field) {
            Some(i) if ty.fields[i].kind == given.kind => {
                open.values[i] = match given.value {
                    Value::Texts(urls)
                        if is_url(field)
                            && given.folder != file.folder
                            && urls.iter().any(|name| url::is_relative(name)) =>
                    {
                        self.rebased(file, connect, &urls, &given.folder)?
                    }
                    value => in_radians(value, ty.name, field, given.angle),
                };
            }
            Some(i) => {
                let (own, given) = (ty.fields[i].kind.describe(), given.kind.describe());
                self.warn(
                    file,
                    connect,
                    format!("<{}> {field} takes {own}, and IS gives it {given}", ty.name),
                );
            }
            None if unknown::is_group(ty) => {}
            None => self.warn(file, connect, format!("<{}> has no field {field:?}", ty.name)),
        }
        Ok(())
    }

    /// Returns URLs of a file in the folder `from` as the file of the body would write them.
    fn rebased(
        &mut self,
        file: &File<'d>,
        connect: Element<'d, 'd>,
        urls: &[String],
        from: &str,
    ) -> Result<Value, LoadError> {
        // Some characters of the folder take three.
        let added = 3 * from.len() + "../".len() * file.folder.matches('/').count();
        let bytes = urls.iter().map(|url| url.len() + added + size_of::<String>()).sum();
        self.hold(file, connect, bytes)?;
        let rebased = |name: &String| url::rebased(name, from, &file.folder);
        Ok(Value::Texts(urls.iter().map(rebased).collect()))
    }

    /// Adds nodes from an instance to a field of a node in the body.
    fn connect_nodes(
        &mut self,
        file: &File<'d>,
        connect: Element<'d, 'd>,
        field: &str,
        nodes: &[NodeId],
        open: &mut OpenNode,
    ) {
        let ty = open.ty;
        let Some(container) = ty.accepts.iter().copied().find(|a| *a == field) else {
            if field != "metadata" {
                self.warn(file, connect, format!("<{}> has no field {field:?}", ty.name));
            }
            return;
        };
        for &node in nodes {
            let given = self.graph.nodes[node as usize].ty;
            if given.container != container_of(container) {
                let message = format!("<{}> takes no <{}> as its {field}", ty.name, given.name);
                self.warn(file, connect, message);
            } else if is_taken(ty, &open.children, container) {
                let message = format!("<{}> takes one {field}: a <{}> was skipped", ty.name, given.name);
                self.warn(file, connect, message);
            } else {
                open.children.push(Child { container, node });
            }
        }
    }
}

/// Returns whether a field holds URLs: `url`, `frontUrl` and its kin.
fn is_url(field: &str) -> bool {
    field == "url" || field.ends_with("Url")
}

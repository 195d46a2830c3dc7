//! Elements of unknown type: detection of those that can still be shown as groups.
//!
//! A grouping node has its children in the field `children` (ISO/IEC 19775-1 clause 10.3.2,
//! X3DGroupingNode), so an unknown element that contains nodes of that field is treated as one, and
//! they are shown as in a Group. CADFace and HAnimHumanoid have other fields in its place (clauses
//! 32, CAD geometry, and 26, Humanoid animation). Unknown types and known ones that are not
//! supported (scripts, sensors, particles, names for other files) are reported once per file and
//! type.

use super::schema::{self, NodeType};
use roxmltree::Node as Element;
use std::sync::LazyLock;

/// Treatment of an element that the schema does not have.
pub(super) enum What {
    /// Skipped for this reason.
    LeftOut(&'static str),
    /// Its children are shown.
    Group,
    /// Skipped as unknown.
    Nothing,
}

/// Returns the treatment of an element that the schema does not have.
pub(super) fn what(element: Element) -> What {
    let name = element.tag_name().name();
    match name {
        "Script" => What::LeftOut("scripts are not run"),
        _ if name.ends_with("Sensor") => What::LeftOut("nothing is sensed in a picture"),
        "EXPORT" | "IMPORT" => What::LeftOut("no node has a name in another file"),
        "ParticleSystem" => What::LeftOut("particles are not simulated"),
        _ if name.ends_with("Emitter") || name.ends_with("PhysicsModel") => {
            What::LeftOut("particles are not simulated")
        }
        _ if holds_children(element) || element.attribute("USE").is_some() => What::Group,
        _ => What::Nothing,
    }
}

/// Fields of unknown nodes whose nodes are shown. CADFace has `shape`, HAnimHumanoid `skeleton` and
/// `skin`; its `joints`, `segments` and `sites` only list nodes of the skeleton again.
const SHOWN_FIELDS: [&str; 4] = ["children", "shape", "skeleton", "skin"];

/// Returns the field of [`group`] that a node in a field of an unknown node belongs to.
pub(super) fn field_of_group(asked: &str) -> &str {
    if SHOWN_FIELDS.contains(&asked) { "children" } else { asked }
}

/// Returns whether an element contains, itself or in unknown elements, a node that is shown.
fn holds_children(element: Element) -> bool {
    element.children().filter(Element::is_element).any(|child| {
        let asked = child.attribute("containerField").unwrap_or("children");
        let name = child.tag_name().name();
        SHOWN_FIELDS.contains(&asked)
            && match schema::lookup(name) {
                Some(ty) => ty.container == "children",
                None if name == "ProtoInstance" => true,
                // An assembly may consist of parts that are defined in others.
                None if name.starts_with("CAD") && child.attribute("USE").is_some() => true,
                None => schema::is_child(name) && holds_children(child),
            }
    })
}

static GROUP: LazyLock<NodeType> = LazyLock::new(|| {
    let group = schema::lookup("Group").expect("the table has Group");
    NodeType { fields: group.fields.clone(), defaults: group.defaults.clone(), ..*group }
});

/// Returns the type of an unknown element whose children are shown: a copy of Group.
pub(super) fn group() -> &'static NodeType {
    &GROUP
}

/// Returns whether a type is [`group`]: all attributes of its element are ignored.
pub(super) fn is_group(ty: &'static NodeType) -> bool {
    std::ptr::eq(ty, group())
}

static ANYTHING: LazyLock<NodeType> = LazyLock::new(|| NodeType {
    name: "ProtoBody",
    container: "",
    accepts: &[],
    fields: Vec::new(),
    defaults: Vec::new(),
});

/// Returns the type of a container for nodes of every kind: a prototype's body, or its fields of
/// nodes.
pub(super) fn anything() -> &'static NodeType {
    &ANYTHING
}

/// Returns whether a type is [`anything`].
pub(super) fn is_anything(ty: &'static NodeType) -> bool {
    std::ptr::eq(ty, anything())
}

/// Returns the field of `parent` that a node of unknown type would have filled, by its
/// containerField or its name.
pub(super) fn meant_for(parent: &NodeType, child: Element) -> Option<&'static str> {
    let accepted = |field: &str| parent.accepts.iter().copied().find(|a| *a == field);
    let name = child.tag_name().name();
    let by_name = match name {
        _ if name.contains("TextureCoordinate") => "texCoord",
        _ if name.contains("Coordinate") => "coord",
        _ if name.starts_with("Color") => "color",
        _ => return child.attribute("containerField").and_then(accepted),
    };
    child.attribute("containerField").and_then(accepted).or_else(|| accepted(by_name))
}

//! Property nodes of a geometry: coordinates, colours, normals, texture coordinates.

use super::super::graph::{GraphView, NodeId};
use super::{ColorUse, Fault, Result, index};
use fbptr_core::scene::NONE;
use glam::{DVec2, DVec3, DVec4};

/// Splits a list into vectors of three.
pub(super) fn vec3s(values: &[f64]) -> Vec<DVec3> {
    values.as_chunks::<3>().0.iter().map(|v| (*v).into()).collect()
}

/// Splits a list into vectors of two.
pub(in crate::load::x3d) fn vec2s(values: &[f64]) -> Vec<DVec2> {
    values.as_chunks::<2>().0.iter().map(|v| (*v).into()).collect()
}

/// Contents of a geometry's property nodes; empty for a node that is missing.
pub(super) struct Vertices {
    pub(super) positions: Vec<DVec3>,
    pub(super) colors: Vec<DVec4>,
    pub(super) color_use: ColorUse,
    pub(super) normals: Vec<DVec3>,
    pub(super) texcoords: Vec<DVec2>,
    coord: NodeId,
    color: NodeId,
    normal: NodeId,
    texcoord: NodeId,
}

impl Vertices {
    /// Reads the property nodes of a geometry node.
    pub(super) fn read(view: &GraphView, id: NodeId) -> Vertices {
        let child = |container| view.child(id, container);
        let (coord, color, normal, texcoord) =
            (child("coord"), child("color"), child("normal"), child("texCoord"));
        let mut color_use = ColorUse::None;
        let colors = match color {
            Some(color) if view.name(color) == "ColorRGBA" => {
                color_use = ColorUse::Rgba;
                view.reals(color, "color").as_chunks::<4>().0.iter().map(|c| (*c).into()).collect()
            }
            Some(color) => {
                color_use = ColorUse::Rgb;
                vec3s(view.reals(color, "color")).into_iter().map(|c| c.extend(1.0)).collect()
            }
            None => Vec::new(),
        };
        Vertices {
            positions: coord.map_or(Vec::new(), |n| vec3s(view.reals(n, "point"))),
            colors,
            color_use,
            normals: normal.map_or(Vec::new(), |n| vec3s(view.reals(n, "vector"))),
            texcoords: match texcoord.filter(|n| view.name(*n) == "TextureCoordinate") {
                Some(node) => vec2s(view.reals(node, "point")),
                None => Vec::new(),
            },
            coord: coord.unwrap_or(id),
            color: color.unwrap_or(id),
            normal: normal.unwrap_or(id),
            texcoord: texcoord.unwrap_or(id),
        }
    }

    /// Checks a colour index; [`NONE`] without a colour node.
    pub(super) fn color(&self, i: i64, by: (NodeId, &'static str)) -> Result<u32> {
        match self.color_use {
            ColorUse::None => Ok(NONE),
            _ => index(self.blame(by, (self.color, "color")), "colour", i, self.colors.len()),
        }
    }

    /// Checks a normal index; [`NONE`] without normals.
    pub(super) fn normal(&self, i: i64, by: (NodeId, &'static str)) -> Result<u32> {
        match self.normals.is_empty() {
            true => Ok(NONE),
            false => index(self.blame(by, (self.normal, "vector")), "normal", i, self.normals.len()),
        }
    }

    /// Checks a texture coordinate index; [`NONE`] without texture coordinates.
    pub(super) fn texcoord(&self, i: i64, by: (NodeId, &'static str)) -> Result<u32> {
        match self.texcoords.is_empty() {
            true => Ok(NONE),
            false => {
                let by = self.blame(by, (self.texcoord, "point"));
                index(by, "texture coordinate", i, self.texcoords.len())
            }
        }
    }

    /// Checks a position index.
    pub(super) fn position(&self, i: i64, by: (NodeId, &'static str)) -> Result<u32> {
        index(self.blame(by, (self.coord, "point")), "coordinate", i, self.positions.len())
    }

    /// Returns the place of an invalid index: the list that contains it or, for an implicit index,
    /// the list that is too short.
    fn blame(&self, by: (NodeId, &'static str), list: (NodeId, &'static str)) -> (NodeId, &'static str) {
        if by.1.is_empty() { list } else { by }
    }
}

/// Splits a list into the runs between -1. The last run needs no -1; other negative numbers are
/// errors.
pub(super) fn runs<'a>(list: &'a [i64], by: (NodeId, &'static str)) -> Result<Vec<&'a [i64]>> {
    let kind = |index| crate::load::LoadErrorKind::Index { what: "list", index, count: list.len() as u64 };
    if let Some(&bad) = list.iter().find(|i| **i < -1) {
        return Err(Fault { node: by.0, field: by.1, kind: kind(bad) });
    }
    let mut runs: Vec<&[i64]> = list.split(|i| *i == -1).collect();
    if runs.last().is_some_and(|r| r.is_empty()) {
        runs.pop();
    }
    Ok(runs)
}

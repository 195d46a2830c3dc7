//! Geometry2D nodes: points, lines and faces in the plane z = 0, with their front towards +z.

use super::super::graph::{GraphView, NodeId};
use super::normals::{default_texcoords, smooth};
use super::vertices::vec2s;
use super::{Built, Stuff};
use fbptr_core::scene::{Corner, Mesh, NONE};
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// Segments of a circle, equal to those of the solids.
const SLICES: u32 = 96;

fn corner(position: u32) -> Corner {
    Corner { position, normal: NONE, texcoord: NONE, color: NONE }
}

/// Returns a mesh over points of the plane, with one corner per point.
fn over(points: &[DVec2]) -> Mesh {
    Mesh {
        positions: points.iter().map(|p| p.extend(0.0)).collect(),
        corners: (0..points.len() as u32).map(corner).collect(),
        ..Mesh::default()
    }
}

/// Returns the points of a circle, counter-clockwise from +x.
fn circle(radius: f64) -> Vec<DVec2> {
    (0..SLICES).map(|i| on_circle(2.0 * PI * f64::from(i) / f64::from(SLICES), radius)).collect()
}

fn on_circle(angle_rad: f64, radius: f64) -> DVec2 {
    let (sin, cos) = libm::sincos(angle_rad);
    DVec2::new(cos, sin) * radius
}

/// Returns the points of an arc counter-clockwise from its start to its end, both included; `None` for
/// a whole circle: equal angles, or a turn and more between them (clauses 14.3.1 and 14.3.2).
fn arc(view: &GraphView, id: NodeId, radius: f64) -> Option<Vec<DVec2>> {
    let [start, end] = ["startAngle", "endAngle"].map(|field| view.real(id, field));
    let sweep = end - start;
    if sweep == 0.0 || sweep.abs() >= 2.0 * PI {
        return None;
    }
    let sweep = if sweep < 0.0 { sweep + 2.0 * PI } else { sweep };
    let slices = (sweep / (2.0 * PI) * f64::from(SLICES)).ceil().max(1.0) as u32;
    let angle = |i: u32| start + sweep * f64::from(i) / f64::from(slices);
    Some((0..=slices).map(|i| on_circle(angle(i), radius)).collect())
}

/// Builds an Arc2D as a line, or an ArcClose2D as a face: with its centre (PIE) or without (CHORD).
fn arc_node(view: &GraphView, id: NodeId) -> Built {
    let (name, radius) = (view.name(id), view.real(id, "radius"));
    if radius <= 0.0 {
        return nothing(format!("<{name}> of radius {radius} shows nothing: it must be positive"));
    }
    let points = arc(view, id, radius);
    if name == "Arc2D" {
        return points.map_or_else(|| outline(radius), |points| polyline(&points));
    }
    let Some(mut points) = points else { return disk(0.0, radius) };
    let closure = view.text(id, "closureType").trim();
    let mut built = Built::default();
    if !matches!(closure, "PIE" | "CHORD") {
        built.remarks.push(format!("<ArcClose2D> closureType {closure:?} is not known: PIE is taken"));
    }
    if closure != "CHORD" {
        points.push(DVec2::ZERO);
    }
    face_over(&mut built.mesh, &points, radius);
    built
}

/// Returns a line through points of the plane.
fn polyline(points: &[DVec2]) -> Built {
    let mut mesh = over(points);
    mesh.lines = (1..mesh.corners.len() as u32).map(|i| [i - 1, i]).collect();
    Built { mesh, stuff: Stuff::Bare, ..Built::default() }
}

/// Sets a mesh to one face with these corners, if there are three. The inscribed circle of the
/// texture lies on the circle of this radius.
fn face_over(mesh: &mut Mesh, points: &[DVec2], radius: f64) {
    mesh.positions = points.iter().map(|p| p.extend(0.0)).collect();
    mesh.normals = vec![DVec3::Z];
    mesh.texcoords = points.iter().map(|p| *p / (2.0 * radius) + 0.5).collect();
    let at = |i: u32| Corner { normal: 0, texcoord: i, ..corner(i) };
    if points.len() > 2 {
        mesh.push_polygon(&(0..points.len() as u32).map(at).collect::<Vec<_>>(), NONE);
    }
}

/// Returns a circle as lines.
fn outline(radius: f64) -> Built {
    let mut mesh = over(&circle(radius));
    mesh.lines = (0..SLICES).map(|i| [i, (i + 1) % SLICES]).collect();
    Built { mesh, stuff: Stuff::Bare, ..Built::default() }
}

/// Returns an empty geometry with a remark.
fn nothing(why: String) -> Built {
    Built { remarks: vec![why], ..Built::default() }
}

/// Builds a Geometry2D node.
pub(super) fn build(view: &GraphView, id: NodeId) -> Built {
    match view.name(id) {
        "Polypoint2D" => {
            let mut mesh = over(&vec2s(view.reals(id, "point")));
            mesh.points = (0..mesh.corners.len() as u32).collect();
            Built { mesh, stuff: Stuff::Bare, ..Built::default() }
        }
        "Polyline2D" => polyline(&vec2s(view.reals(id, "lineSegments"))),
        "Arc2D" | "ArcClose2D" => arc_node(view, id),
        "Circle2D" => match view.real(id, "radius") {
            radius if radius > 0.0 => outline(radius),
            radius => nothing(format!("<Circle2D> of radius {radius} has no line")),
        },
        "Disk2D" => disk(view.real(id, "innerRadius"), view.real(id, "outerRadius")),
        "Rectangle2D" => {
            let [w, h] = view.array::<2>(id, "size").map(|side| side / 2.0);
            if !(w > 0.0 && h > 0.0) {
                return nothing("<Rectangle2D> has no face: its sides must be positive".into());
            }
            let points = [(-w, -h), (w, -h), (w, h), (-w, h)].map(|(x, y)| DVec3::new(x, y, 0.0));
            let mut mesh = Mesh {
                positions: points.into(),
                normals: vec![DVec3::Z],
                texcoords: vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
                ..Mesh::default()
            };
            let corners = [0, 1, 2, 3].map(|i| Corner { normal: 0, texcoord: i, ..corner(i) });
            mesh.push_polygon(&corners, NONE);
            Built { mesh, ..Built::default() }
        }
        _ => {
            let points = vec2s(view.reals(id, "vertices"));
            let mut mesh =
                Mesh { positions: points.iter().map(|p| p.extend(0.0)).collect(), ..Mesh::default() };
            for i in 0..points.len() as u32 / 3 {
                mesh.push_polygon(&[3 * i, 3 * i + 1, 3 * i + 2].map(corner), NONE);
            }
            let mut built = Built::default();
            if !points.len().is_multiple_of(3) {
                built.remarks.push("<TriangleSet2D> has vertices left over that make no triangle".into());
            }
            smooth(&mut mesh, 0.0);
            default_texcoords(&mut mesh);
            Built { mesh, ..built }
        }
    }
}

/// Builds a Disk2D: a disk, a ring, or with equal radii a circle. The texture's inscribed circle
/// covers it.
fn disk(inner: f64, outer: f64) -> Built {
    if !(outer > 0.0 && inner >= 0.0 && inner <= outer) {
        return nothing(format!("<Disk2D> from radius {inner} to {outer} has no face"));
    }
    if inner == outer {
        return outline(outer);
    }
    let mut mesh = Mesh::default();
    if inner == 0.0 {
        face_over(&mut mesh, &circle(outer), outer);
        return Built { mesh, ..Built::default() };
    }
    let points: Vec<DVec2> = [outer, inner].into_iter().flat_map(circle).collect();
    mesh.positions = points.iter().map(|p| p.extend(0.0)).collect();
    mesh.normals = vec![DVec3::Z];
    mesh.texcoords = points.iter().map(|p| *p / (2.0 * outer) + 0.5).collect();
    let at = |i: u32| Corner { normal: 0, texcoord: i, ..corner(i) };
    for i in 0..SLICES {
        let next = (i + 1) % SLICES;
        mesh.push_polygon(&[i, next, SLICES + next, SLICES + i].map(at), NONE);
    }
    Built { mesh, ..Built::default() }
}

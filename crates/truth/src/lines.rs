//! Lines and points of the reference: those of a mesh, and the edges of a wireframe.
//!
//! A line is clipped by the six planes in homogeneous coordinates and projected, in numbers of 32
//! digits and without snapping. In each column that it enters, or each row if it is steep, it draws
//! the pixel that contains its point at the column's centre, or its end where it ends before. Depth
//! is that of this point, linear on the screen; colour is linear in space: Ke + Kd (an unlit
//! material's emission) times the vertex colour.
//!
//! The renderer snaps the ends to 1/256 pixel, which moves a point of the line by at most 1/256. So
//! where the point lies that near the border of two pixels both are accepted, and so are both axes
//! where the line is that nearly diagonal. A point of a mesh is the pixel that contains it.
//!
//! The edges of SHADE wire are those of polygons that remain after CULL, each once, from the lower
//! position index. Under HIDE zbuffer an edge's pixel is seen unless a face of the object lies in
//! front of it; of the edge's own faces it may take the depth at the pixel's centre.

use super::coverage::Coverage;
use super::double_double::{DoubleDouble, DoubleDouble3, DoubleDouble4, narrow3};
use super::face::{Face, ObjectView};
use super::fragment::{ColorRange, Fragment, FragmentContext};
use fbptr_core::scene::{Corner, Interpolation, LightingModel, Material, NONE};
use glam::{DVec3, DVec4};
use std::collections::{BTreeMap, HashSet};

/// Distance in pixels from a pixel's border within which a mesh's point may lie beyond it.
const POINT_PX: f64 = 1e-6;

/// Distance in pixels by which snapping its ends may move a point of a line, and rounding.
const SNAP_PX: f64 = 1.0 / 256.0 + 1e-6;

/// Length in pixels below which snapping may turn a line by any angle.
const SHORT_PX: f64 = 0.05;

/// 2 ulp of f32 just below 1.
const DEPTH_EDGE: f64 = 2.0 / 16_777_216.0;

/// Pixel of a line or point.
pub struct LinePixel {
    /// Column of the pixel.
    pub x: i64,
    /// Row of the pixel.
    pub y: i64,
    /// Depth and colours at the pixel.
    pub fragment: Fragment,
    /// Clip positions of the line's ends.
    pub clip: [DoubleDouble4; 2],
    /// True if the pixel is blended with the one behind it.
    pub is_transparent: bool,
    /// Depth by which an edge of a wireframe is hidden: the least of its own and its faces'.
    pub edge_z: Option<[DoubleDouble; 2]>,
}

/// End of a line.
#[derive(Clone, Copy)]
struct End {
    clip: DoubleDouble4,
    world: DoubleDouble3,
    /// R, G, B and opacity.
    color: [DoubleDouble; 4],
}

impl End {
    fn towards(&self, other: &End, t: DoubleDouble) -> End {
        let mix = |a: DoubleDouble, b: DoubleDouble| a + (b - a) * t;
        End {
            clip: std::array::from_fn(|k| mix(self.clip[k], other.clip[k])),
            world: std::array::from_fn(|k| mix(self.world[k], other.world[k])),
            color: std::array::from_fn(|k| mix(self.color[k], other.color[k])),
        }
    }
}

/// Returns the pixels of an object's lines and points in drawing order. `faces` are its triangles
/// that remain after CULL; `is_wire` is true if it is shaded as a wireframe, `is_hidden` if its faces
/// hide edges.
pub fn line_pixels_of(
    view: &ObjectView,
    context: &FragmentContext,
    clip: [i64; 4],
    faces: &[Face],
    is_wire: bool,
    is_hidden: bool,
) -> Vec<LinePixel> {
    let mesh = &view.object.geometry.mesh;
    let pen = Pen { view, context, clip };
    let mut out = Vec::new();
    if is_wire {
        let seen = faces.iter().map(|f| f.triangle).collect();
        for (ends, material) in edges(view, &seen) {
            let start = out.len();
            pen.line(ends.map(|c| pen.end(&c, material)), &mut out);
            if is_hidden {
                let own = faces_on(view, faces, ends);
                for pixel in &mut out[start..] {
                    let ndc = context.sight.ndc_of_pixel(pixel.x, pixel.y);
                    let least = own.iter().filter_map(|f| f.depth_in_plane(ndc)).reduce(DoubleDouble::min);
                    let z = pixel.fragment.z;
                    pixel.edge_z = Some(least.map_or(z, |least| z.map(|z| z.min(least))));
                }
            }
        }
    }
    let material_of = |materials: &[u32], number: usize| {
        let own = materials.get(number).and_then(|&index| mesh.materials.get(index as usize));
        own.unwrap_or(&view.object.material)
    };
    for (i, line) in mesh.lines.iter().enumerate() {
        let material = material_of(&mesh.line_materials, i);
        pen.line(line.map(|c| pen.end(&mesh.corners[c as usize], material)), &mut out);
    }
    for (i, &point) in mesh.points.iter().enumerate() {
        let end = pen.end(&mesh.corners[point as usize], material_of(&mesh.point_materials, i));
        pen.point(&end, &mut out);
    }
    out
}

/// Returns the first two faces that have this edge.
fn faces_on<'a, 'f>(view: &ObjectView, faces: &'f [Face<'a>], ends: [Corner; 2]) -> Vec<&'f Face<'a>> {
    let mesh = &view.object.geometry.mesh;
    let wanted = ends.map(|c| c.position);
    let has_edge = |f: &&Face| {
        let p = mesh.triangles[f.triangle as usize].map(|c| mesh.corners[c as usize].position);
        (0..3).any(|i| {
            let [from, to] = [p[i], p[(i + 1) % 3]];
            [from.min(to), from.max(to)] == wanted
        })
    };
    faces.iter().filter(has_edge).take(2).collect()
}

/// Returns the polygons' edges in the order of their first occurrence in the file, from the lower
/// position index, with their material.
fn edges<'a>(view: &ObjectView<'a>, seen: &HashSet<u32>) -> Vec<([Corner; 2], &'a Material)> {
    let mesh = &view.object.geometry.mesh;
    let polygons: HashSet<u32> = seen.iter().map(|&t| mesh.triangle_polygon[t as usize]).collect();
    let mut seen_edges = HashSet::new();
    let mut out = Vec::new();
    for (p, polygon) in mesh.polygons.iter().enumerate() {
        if !polygons.contains(&(p as u32)) {
            continue;
        }
        let first = polygon.first_corner as usize;
        let corners = &mesh.corners[first..first + polygon.corner_count as usize];
        for (i, &from) in corners.iter().enumerate() {
            let to = corners[(i + 1) % corners.len()];
            let ends = if from.position <= to.position { [from, to] } else { [to, from] };
            if seen_edges.insert(ends.map(|c| c.position)) {
                let material = match polygon.material {
                    NONE => &view.object.material,
                    own => &mesh.materials[own as usize],
                };
                out.push((ends, material));
            }
        }
    }
    out
}

struct Pen<'a> {
    view: &'a ObjectView<'a>,
    context: &'a FragmentContext<'a>,
    clip: [i64; 4],
}

impl Pen<'_> {
    fn end(&self, corner: &Corner, material: &Material) -> End {
        let mesh = &self.view.object.geometry.mesh;
        let vertex = self.view.vertex(mesh.positions[corner.position as usize]);
        let own = if corner.color == NONE { DVec4::ONE } else { mesh.colors[corner.color as usize] };
        let rgb = match material.model {
            LightingModel::Unlit => material.emissive * own.truncate(),
            _ => material.kd * own.truncate() + material.emissive,
        };
        let opacity = (1.0 - material.transparency.clamp(0.0, 1.0)) * own.w;
        End {
            clip: vertex.clip,
            world: vertex.world,
            color: [rgb.x, rgb.y, rgb.z, opacity].map(DoubleDouble::new),
        }
    }

    /// Draws a line.
    fn line(&self, ends: [End; 2], out: &mut Vec<LinePixel>) {
        if !ends.iter().all(|e| e.clip.iter().all(|c| c.is_finite())) {
            return;
        }
        let Some(([a, b], is_sure)) = cut(&ends) else { return };
        let [from, to] = [&a, &b].map(|e| self.place(e));
        if !from.iter().chain(&to).all(|v| v.is_finite()) {
            return;
        }
        let extents = [0, 1].map(|axis| (to[axis] - from[axis]).abs().to_f64());
        let is_short = extents[0].max(extents[1]) < SHORT_PX;
        let axes = (0..2).filter(|&axis| is_short || extents[axis] > extents[1 - axis] - 2.0 * SNAP_PX);
        // For each axis that may be the major one: the pixels, with the range of their depths and
        // colours, and whether they are certain.
        let mut found: BTreeMap<[i64; 2], (usize, [DoubleDouble; 2], ColorRange)> = BTreeMap::new();
        let mut ways = 0;
        for axis in axes {
            ways += 1;
            for (pixel, s, is_certain) in self.steps(axis, from, to, is_short) {
                let (z, range) = self.at(&a, &b, s);
                let entry = found.entry(pixel).or_insert((0, [z; 2], range));
                entry.0 += usize::from(is_certain);
                entry.1 = [entry.1[0].min(z), entry.1[1].max(z)];
                entry.2 = entry.2.hull(range);
            }
        }
        for ([x, y], (count, z, range)) in found {
            self.push([x, y], is_sure && count == ways, z, range, [&a, &b], out);
        }
    }

    /// Draws a point of a mesh.
    fn point(&self, end: &End, out: &mut Vec<LinePixel>) {
        if !end.clip.iter().all(|c| c.is_finite()) {
            return;
        }
        let Some(([end, _], is_sure)) = cut(&[*end; 2]) else { return };
        let [xs, ys] = self.place(&end).map(|v| cells(v, POINT_PX));
        let (z, range) = self.at(&end, &end, DoubleDouble::ZERO);
        for (x, y) in xs.iter().flat_map(|&x| ys.iter().map(move |&y| (x, y))) {
            self.push([x, y], is_sure && xs.len() * ys.len() == 1, [z; 2], range, [&end, &end], out);
        }
    }

    /// Adds a pixel if it is inside the viewport.
    fn push(
        &self,
        [x, y]: [i64; 2],
        is_certain: bool,
        z: [DoubleDouble; 2],
        range: ColorRange,
        ends: [&End; 2],
        out: &mut Vec<LinePixel>,
    ) {
        let [x0, x1, y0, y1] = self.clip;
        if !((x0..x1).contains(&x) && (y0..y1).contains(&y)) {
            return;
        }
        let is_far = z[1] > DoubleDouble::ONE - DoubleDouble::new(DEPTH_EDGE);
        let presence = if is_certain && !is_far { Coverage::Yes } else { Coverage::Maybe };
        let z = z.map(|z| z.max(DoubleDouble::ZERO).min(DoubleDouble::ONE));
        out.push(LinePixel {
            x,
            y,
            fragment: Fragment { presence, z, colors: vec![range] },
            clip: ends.map(|e| e.clip),
            is_transparent: range.alpha[0] < 1.0,
            edge_z: None,
        });
    }

    /// Returns the place of an end on the screen.
    fn place(&self, end: &End) -> [DoubleDouble; 2] {
        let w = end.clip[3];
        self.context.sight.to_screen(end.clip[0] / w, end.clip[1] / w)
    }

    /// Returns the pixels of a line whose major axis is `axis`, the part of the line at which each is
    /// coloured, and whether it is certain.
    fn steps(
        &self,
        axis: usize,
        from: [DoubleDouble; 2],
        to: [DoubleDouble; 2],
        is_short: bool,
    ) -> Vec<([i64; 2], DoubleDouble, bool)> {
        let (a, b) = (from[axis], to[axis]);
        let (low, high) = (a.min(b), a.max(b));
        let sure = cells(low, SNAP_PX).last().copied()..=cells(high, SNAP_PX).first().copied();
        let clip = [self.clip[2 * axis], self.clip[2 * axis + 1]];
        let first = cells(low, SNAP_PX).first().map_or(clip[0], |&c| c.max(clip[0]));
        let last = cells(high, SNAP_PX).last().map_or(clip[1], |&c| c.min(clip[1] - 1));
        let mut out = Vec::new();
        for column in first..=last {
            let centre = DoubleDouble::new(column as f64 + 0.5).max(low).min(high);
            let s = if a == b { DoubleDouble::ZERO } else { (centre - a) / (b - a) };
            let rows = match is_short {
                false => cells(from[1 - axis] + (to[1 - axis] - from[1 - axis]) * s, SNAP_PX),
                true => {
                    let (p, q) = (from[1 - axis], to[1 - axis]);
                    let [p, q] = [cells(p.min(q), SNAP_PX), cells(p.max(q), SNAP_PX)];
                    let ends = [p.first().copied(), q.last().copied()].map(Option::unwrap_or_default);
                    (ends[0]..=ends[1]).collect()
                }
            };
            let is_certain = rows.len() == 1 && sure.contains(&Some(column));
            // A pixel of a short line may be coloured anywhere on it.
            let parts = if is_short { vec![DoubleDouble::ZERO, s, DoubleDouble::ONE] } else { vec![s] };
            for row in rows {
                let pixel = if axis == 0 { [column, row] } else { [row, column] };
                for (k, part) in parts.iter().enumerate() {
                    out.push((pixel, *part, is_certain && k == 0));
                }
            }
        }
        out
    }

    /// Returns depth and colour at part s of the line on the screen.
    fn at(&self, a: &End, b: &End, s: DoubleDouble) -> (DoubleDouble, ColorRange) {
        let [wa, wb] = [a.clip[3], b.clip[3]];
        let (za, zb) = (a.clip[2] / wa, b.clip[2] / wb);
        let t = match self.context.interpolation {
            Interpolation::Affine => s,
            Interpolation::Perspective => (s / wb) / ((DoubleDouble::ONE - s) / wa + s / wb),
        };
        let here = a.towards(b, t);
        let rgb = DVec3::new(here.color[0].to_f64(), here.color[1].to_f64(), here.color[2].to_f64());
        let rgb = self.context.fogged(rgb, narrow3(here.world));
        let alpha = here.color[3].to_f64().clamp(0.0, 1.0);
        (za + (zb - za) * s, ColorRange { lo: rgb, hi: rgb, alpha: [alpha; 2] })
    }
}

/// Clips a line to -w <= x, y <= w, 0 <= z <= w. Returns the visible part and whether it certainly
/// exists.
fn cut([a, b]: &[End; 2]) -> Option<([End; 2], bool)> {
    let heights = |e: &End| {
        let [x, y, z, w] = e.clip;
        [w + x, w - x, w + y, w - y, z, w - z]
    };
    let (mut from, mut to) = (DoubleDouble::ZERO, DoubleDouble::ONE);
    let mut is_sure = true;
    for (p, q) in heights(a).into_iter().zip(heights(b)) {
        let size = p.abs().max(q.abs()).to_f64() * 1e-12;
        is_sure &= p.to_f64().max(q.to_f64()) > size || size == 0.0;
        match (p < DoubleDouble::ZERO, q < DoubleDouble::ZERO) {
            (true, true) => return None,
            (true, false) => from = from.max(p / (p - q)),
            (false, true) => to = to.min(p / (p - q)),
            (false, false) => {}
        }
    }
    if from > to {
        return None;
    }
    let ends = [from, to].map(|t| match t {
        t if t == DoubleDouble::ZERO => *a,
        t if t == DoubleDouble::ONE => *b,
        t => a.towards(b, t),
    });
    let is_sure =
        is_sure && ((to - from).to_f64() > 1e-22 || (from == DoubleDouble::ZERO && to == DoubleDouble::ONE));
    ends.iter().all(|e| e.clip[3] > DoubleDouble::ZERO).then_some((ends, is_sure))
}

/// Returns the columns, or rows, that may contain a coordinate that is uncertain by `margin` pixels.
fn cells(v: DoubleDouble, margin: f64) -> Vec<i64> {
    let [low, high] = [-margin, margin].map(|m| (v + DoubleDouble::new(m)).to_f64().floor() as i64);
    (low..=high).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coordinate_near_a_border_may_lie_on_both_sides() {
        let of = |v: f64| cells(DoubleDouble::new(v), SNAP_PX);
        assert_eq!((of(3.5), of(3.99), of(3.999), of(4.003)), (vec![3], vec![3], vec![3, 4], vec![3, 4]));
        assert_eq!((of(-0.001), of(-0.5)), (vec![-1, 0], vec![-1]));
    }
}

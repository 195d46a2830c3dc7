//! Lines and points of a mesh, and the edges of a wireframe.
//!
//! A line is clipped by the six planes (notes 000), its ends are snapped to 1/256 pixel, and it draws
//! the pixels of [`SnappedLine`]: one a column, or a row if it is steep, each within half a pixel of
//! the segment. The cost is that of the part on the frame. Lines are not lit: their colour is Ke + Kd
//! of their material (an unlit one's emission), times vertex colours. Depth is linear on the screen,
//! that of the unsnapped line at the column's centre. A wide line is that line with each pixel
//! repeated along the minor axis at the same depth. Pattern steps are counted from the first pixel
//! after clipping, and continue along connected lines.
//!
//! SHADE wire draws each polygon edge once, from the lower position index, if CULL leaves one of
//! its polygons. Under HIDE zbuffer hidden lines are removed by depth: the faces are first drawn
//! into the depth memory only, and a line's pixel is visible if its depth, or that of one of its
//! own faces there, is not behind the stored one.

use super::line_clip::{LineEnd, clip_ends};
use crate::math::snapped_line::SnappedLine;
use crate::memory::{blend, opaque};
use crate::pipeline::clip::{ClipVertex, ClippedLine, clip_line};
use crate::pipeline::draw_call::{DrawStats, Target};
use crate::pipeline::light::LitColor;
use crate::pipeline::plan::Part;
use crate::pipeline::plane_equation::FacePlane;
use crate::pipeline::prepared_draw::PreparedDraw;
use crate::pipeline::shade::visibility;
use crate::scene::{Corner, HiddenSurface, LightingModel, LineKind, LineStyle, Material, Mesh};
use glam::{DVec3, DVec4};
use std::collections::HashMap;

/// Depth test of a line's pixels.
#[derive(Clone, Copy)]
enum DepthRule<'p> {
    /// As for faces: passes if strictly nearer.
    Strict,
    /// For an edge of faces already in depth memory: passes if not behind, where a pixel may take
    /// the depth of these faces' planes.
    Edge(&'p [Option<FacePlane>; 2]),
}

/// An edge of a wireframe: corner indices of its ends, lower position first, its polygon, and up to
/// two visible triangles on it.
struct Edge {
    corners: [u32; 2],
    polygon: usize,
    planes: [Option<u32>; 2],
}

/// Steps of a line between two preemption points.
const FEW_STEPS: u64 = 8;

/// Returns the maximum bytes of a wireframe's edges: a list and a hash table by their ends, with
/// doubled capacity and reallocation, and flags of visible faces and polygons.
pub(crate) fn wire_bytes(mesh: &Mesh) -> u64 {
    let edges = mesh.corners.len() as u64;
    let table = 2 * (size_of::<([u32; 2], usize)>() + 1) as u64;
    edges * (2 * size_of::<Edge>() as u64 + table) * 3 / 2
        + (mesh.triangles.len() + mesh.polygons.len()) as u64
}

impl PreparedDraw<'_> {
    /// Draws the edges of all polygons that CULL leaves.
    pub fn draw_wire(&self, target: &mut Target, stats: &mut DrawStats) {
        let mesh = &self.call.geometry.mesh;
        // Finds the visible faces; under zbuffer they hide lines.
        let hides = self.parts.uses(Part::Coverage) && self.call.hide == HiddenSurface::ZBuffer;
        let mut is_face_seen = Vec::with_capacity(mesh.triangles.len());
        let mut is_seen = vec![false; mesh.polygons.len()];
        for t in 0..mesh.triangles.len() as u32 {
            if self.is_cancelled_at(t as usize) {
                return;
            }
            self.preemption.point(target);
            if hides {
                self.draw_depth(t, target, stats);
            }
            let seen = self.assemble(t, &mut DrawStats::default()).is_some();
            is_seen[mesh.triangle_polygon[t as usize] as usize] |= seen;
            is_face_seen.push(seen);
        }
        if !hides {
            stats.faces += mesh.triangles.len() as u64;
        }
        let edges =
            self.preemption.without(target, mesh.corners.len(), || self.edges(&is_seen, &is_face_seen));
        for (i, edge) in edges.into_iter().enumerate() {
            if self.is_cancelled_at(i) {
                return;
            }
            self.preemption.point(target);
            let material = self
                .call
                .material_of(&mesh.polygons[edge.polygon], crate::pipeline::assemble::Facing::Front)
                .0;
            let ends = edge.corners.map(|c| self.line_end(&mesh.corners[c as usize], material));
            let planes = edge.planes.map(|t| FacePlane::new(self.corner_vertices(t?).each_ref()));
            let rule = if hides { DepthRule::Edge(&planes) } else { DepthRule::Strict };
            self.draw_line(ends, material, rule, &mut Pen::THIN.clone(), target, stats);
        }
    }

    /// Returns each edge of the visible polygons once, in file order.
    fn edges(&self, is_seen: &[bool], is_face_seen: &[bool]) -> Vec<Edge> {
        let mesh = &self.call.geometry.mesh;
        let mut edges: Vec<Edge> = Vec::new();
        let mut found: HashMap<[u32; 2], usize> = HashMap::new();
        for (p, polygon) in mesh.polygons.iter().enumerate().filter(|&(p, _)| is_seen[p]) {
            if self.is_cancelled_at(p) {
                return edges;
            }
            for i in 0..polygon.corner_count {
                let corner = |i: u32| polygon.first_corner + i % polygon.corner_count;
                let mut corners = [corner(i), corner(i + 1)];
                let mut positions = corners.map(|c| mesh.corners[c as usize].position);
                if positions[0] > positions[1] {
                    corners.reverse();
                    positions.reverse();
                }
                found.entry(positions).or_insert_with(|| {
                    edges.push(Edge { corners, polygon: p, planes: [None, None] });
                    edges.len() - 1
                });
            }
        }
        // Records the visible triangles on each edge: pixels on them belong to the edge's own
        // surface.
        for (t, triangle) in mesh.triangles.iter().enumerate().filter(|&(t, _)| is_face_seen[t]) {
            if self.is_cancelled_at(t) {
                return edges;
            }
            for i in 0..3 {
                let mut ends =
                    [triangle[i], triangle[(i + 1) % 3]].map(|c| mesh.corners[c as usize].position);
                ends.sort_unstable();
                if let Some(&at) = found.get(&ends)
                    && let Some(free) = edges[at].planes.iter_mut().find(|p| p.is_none())
                {
                    *free = Some(t as u32);
                }
            }
        }
        edges
    }

    /// Returns whether the draw is cancelled, asking the token only at every 64th item.
    fn is_cancelled_at(&self, item: usize) -> bool {
        item.is_multiple_of(64) && self.cancel.is_cancelled()
    }

    /// Draws the mesh's line segments.
    pub fn draw_lines(&self, target: &mut Target, stats: &mut DrawStats) {
        let mesh = &self.call.geometry.mesh;
        let mut pen = Pen { style: self.call.line, ..Pen::THIN };
        let mut last = None;
        for (i, &[from, to]) in mesh.lines.iter().enumerate() {
            if self.is_cancelled_at(i) {
                return;
            }
            self.preemption.point(target);
            // A pattern continues along connected lines.
            if last != Some(from) {
                pen.step = 0;
            }
            last = Some(to);
            let material = self.call.material_of_line(i);
            let ends = [from, to].map(|c| self.line_end(&mesh.corners[c as usize], material));
            self.draw_line(ends, material, DepthRule::Strict, &mut pen, target, stats);
        }
    }

    /// Draws the mesh's points, each as a square or a disc of one depth.
    pub fn draw_points(&self, target: &mut Target, stats: &mut DrawStats) {
        let mesh = &self.call.geometry.mesh;
        let is_parallel = self.assembler.transform.camera.is_parallel;
        let (size, shape) = (self.call.point_size, self.call.point_shape);
        for (i, &c) in mesh.points.iter().enumerate() {
            if self.is_cancelled_at(i) {
                return;
            }
            self.preemption.point(target);
            let material = self.call.material_of_point(i);
            let v = self.line_end(&mesh.corners[c as usize], material).clip;
            if let Some(ClippedLine { ends: [v, _], .. }) = clip_line(v, v) {
                stats.points_drawn += 1;
                let [x, y] = self.pixel(v.pos_clip);
                let w = v.pos_clip.w;
                let point = LinePixel { x, y, z: v.pos_clip.z / w, complement: v.varyings[0] / w };
                let side = shape.side_at(size, w, is_parallel);
                let around = -((i64::from(side) - 1) / 2)..=i64::from(side) / 2;
                let square = around.clone().flat_map(|dy| around.clone().map(move |dx| [dx, dy]));
                for [dx, dy] in square.filter(|at| shape.covers(side, *at)) {
                    let pixel = LinePixel { x: x + dx, y: y + dy, ..point };
                    self.put(pixel, &v.varyings, material, DepthRule::Strict, target, stats);
                }
            }
        }
    }

    /// Returns a corner with the varyings of a line.
    fn line_end(&self, corner: &Corner, material: &Material) -> LineEnd {
        let mesh = &self.call.geometry.mesh;
        let v = self.vertex(corner.position);
        let p = self.assembler.transform.world(mesh.positions[corner.position as usize]);
        let color = mesh.colors.get(corner.color as usize).copied().unwrap_or(DVec4::ONE);
        let LitColor { diffuse_ambient, specular_emissive } = match material.model {
            LightingModel::Unlit => {
                LitColor { diffuse_ambient: material.emissive, specular_emissive: DVec3::ZERO }
            }
            _ => LitColor { diffuse_ambient: material.kd, specular_emissive: material.emissive },
        };
        let rgb = diffuse_ambient * color.truncate() + specular_emissive;
        let varyings = [v.complement, p.x, p.y, p.z, rgb.x, rgb.y, rgb.z, color.w];
        LineEnd { vertex: v, clip: ClipVertex { pos_clip: v.clip, varyings } }
    }

    /// Returns the pixel that contains a clip-space point, clamped to i32.
    fn pixel(&self, clip: DVec4) -> [i64; 2] {
        let range = [i32::MIN, i32::MAX].map(f64::from);
        self.assembler.transform.on_screen(clip).map(|v| v.floor().clamp(range[0], range[1]) as i64)
    }

    /// Clips a line and draws its visible pixels that the pattern leaves on; advances `pen`.
    fn draw_line(
        &self,
        ends: [LineEnd; 2],
        material: &Material,
        rule: DepthRule,
        pen: &mut Pen,
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let Some([a, b]) = clip_ends(self.transform(), ends.each_ref()) else { return };
        stats.lines_drawn += 1;
        let [wa, wb] = [a.pos_clip.w, b.pos_clip.w];
        let (za, zb) = (a.pos_clip.z / wa, b.pos_clip.z / wb);
        let (ca, cb) = (a.varyings[0] / wa, b.varyings[0] / wb);
        let on_screen = [&a, &b].map(|v| self.transform().on_screen(v.pos_clip));
        let line = SnappedLine::new(on_screen[0], on_screen[1]);
        let [from, to] = on_screen.map(|[x, y]| if line.is_x_major { x } else { y });
        let LineStyle { width, kind } = pen.style;
        let first = pen.step;
        pen.step += line.steps();
        for k in line.steps_along(self.assembler.transform.screen.clip) {
            // On a large target each pixel may be in memory that was never used.
            if k % FEW_STEPS == 0 {
                self.preemption.point(target);
            }
            if !kind.is_on(first + k, width) {
                continue;
            }
            let [x, y] = line.at(k);
            let centre = if line.is_x_major { x } else { y } as f64 + 0.5;
            let s = if from == to { 0.0 } else { ((centre - from) / (to - from)).clamp(0.0, 1.0) };
            // Perspective-correct: linear in space, not on the screen.
            let t = if self.is_affine() { s } else { (s / wb) / ((1.0 - s) / wa + s / wb) };
            let varyings = std::array::from_fn(|i| a.varyings[i] + (b.varyings[i] - a.varyings[i]) * t);
            let (z, complement) = (za + (zb - za) * s, ca + (cb - ca) * s);
            let clip = self.assembler.transform.screen.clip;
            let (at, low, high) = match line.is_x_major {
                true => (y, i64::from(clip.y0), i64::from(clip.y1)),
                false => (x, i64::from(clip.x0), i64::from(clip.x1)),
            };
            let start = at - i64::from(width - 1) / 2;
            for across in start.max(low)..(start + i64::from(width)).min(high) {
                let [x, y] = if line.is_x_major { [x, across] } else { [across, y] };
                self.put(LinePixel { x, y, z, complement }, &varyings, material, rule, target, stats);
            }
        }
    }

    /// Draws one pixel of a line or point: depth test, colour, bytes.
    fn put(
        &self,
        pixel: LinePixel,
        varyings: &[f64; 8],
        material: &Material,
        rule: DepthRule,
        target: &mut Target,
        stats: &mut DrawStats,
    ) {
        let screen = &self.assembler.transform.screen;
        let clip = screen.clip;
        let inside = |v: i64, from: i32, to: i32| (from as i64..to as i64).contains(&v);
        if !(inside(pixel.x, clip.x0, clip.x1) && inside(pixel.y, clip.y0, clip.y1)) {
            return;
        }
        stats.pixels_tested += 1;
        let LinePixel { x, y, mut z, mut complement } = pixel;
        if z.is_nan() || z >= 1.0 {
            return;
        }
        let mut opacity = (1.0 - material.transparency.clamp(0.0, 1.0)) * varyings[7];
        opacity = opacity.clamp(0.0, 1.0);
        let index = target.memory.width() as usize * y as usize + x as usize;
        if self.parts.uses(Part::DepthMemory)
            && let Some(depth) = target.depth.as_mut()
        {
            let format = depth.format();
            let own = format.encode(z.max(0.0), complement.max(0.0));
            let stored = depth.word(index);
            let passes = match rule {
                DepthRule::Strict => own < stored,
                DepthRule::Edge(planes) => {
                    let ndc = screen.ndc_of_pixel(x as i32, y as i32);
                    for plane in planes.iter().flatten() {
                        let (pz, pc) = plane.depth_within(&plane.weights_at(ndc));
                        if pz < z {
                            (z, complement) = (pz, pc);
                        }
                    }
                    // A tolerance of two steps: the stored face may be the other half of the same
                    // polygon.
                    format.encode(z.clamp(0.0, 1.0), complement.clamp(0.0, 1.0)).saturating_sub(2) <= stored
                }
            };
            if !passes {
                return;
            }
            if own < stored && opacity >= 1.0 {
                depth.set_word(index, own);
            }
        }
        let mut rgb = DVec3::new(varyings[4], varyings[5], varyings[6]);
        if let Some(fog) = self.call.fog {
            let from_eye =
                DVec3::new(varyings[1], varyings[2], varyings[3]) - self.assembler.transform.camera.eye;
            let clear = visibility(&fog, from_eye.length());
            rgb = fog.color * (1.0 - clear) + rgb * clear;
        }
        let bytes = &mut target.memory.bytes_mut()[index * 4..index * 4 + 4];
        if opacity < 1.0 {
            blend(bytes, rgb, opacity);
        } else {
            bytes.copy_from_slice(&opaque(rgb));
        }
        target.memory.mark_row(y as u32);
        stats.pixels_written += 1;
    }
}

/// Line style of a draw, and the position in its pattern.
#[derive(Clone)]
struct Pen {
    style: LineStyle,
    /// Steps since the pattern began.
    step: u64,
}

impl Pen {
    /// One pixel wide, solid.
    const THIN: Pen = Pen { style: LineStyle { width: 1, kind: LineKind::Solid }, step: 0 };
}

/// A pixel of a line and its depth.
#[derive(Clone, Copy)]
struct LinePixel {
    x: i64,
    y: i64,
    z: f64,
    complement: f64,
}

//! Lines and points of the reference: those of a mesh, and the edges of a wireframe.
//!
//! A line is clipped by the six planes in homogeneous coordinates, its ends are mapped to the
//! pixels that contain them, and Bresenham's midpoint line (source 001) joins them. Depth is linear
//! on the screen, colour linear in space. The colour is Ke + Kd (an unlit material's emission)
//! times the vertex colour. If an end lies so near a pixel's border that plain f64 may put it on
//! either side - always if it was clipped at the side of the view - the lines to both pixels are
//! accepted.
//!
//! The edges of SHADE wire are those of polygons that remain after CULL, each once, from the lower
//! position index. Wireframes with hidden lines removed by depth are not drawn by this reference.

use super::coverage::Coverage;
use super::double_double::{DoubleDouble, DoubleDouble3, DoubleDouble4, narrow3};
use super::face::ObjectView;
use super::fragment::{ColorRange, Fragment, FragmentContext};
use fbptr_core::scene::{Corner, Interpolation, LightingModel, Material, NONE};
use glam::{DVec3, DVec4};
use std::collections::{HashMap, HashSet};

/// Distance in pixels from a pixel's border within which an end may lie beyond it.
const BORDER_PX: f64 = 1e-6;

/// Bound in pixels on the distance of ends from the screen's origin; viewports reach less far. An
/// end beyond it is one that an overflow kept from being clipped, and its line is not drawn.
const FARTHEST_PX: f64 = (1u64 << 40) as f64;

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

/// Returns the pixels of an object's lines and points in drawing order. `seen` are its triangles
/// that remain after CULL; `is_wire` is true if it is shaded as a wireframe.
pub fn line_pixels_of(
    view: &ObjectView,
    context: &FragmentContext,
    clip: [i64; 4],
    seen: &HashSet<u32>,
    is_wire: bool,
) -> Vec<LinePixel> {
    let mesh = &view.object.geometry.mesh;
    let pen = Pen { view, context, clip };
    let mut out = Vec::new();
    if is_wire {
        for (ends, material) in edges(view, seen) {
            pen.line(ends.map(|c| pen.end(&c, material)), &mut out);
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
        pen.line([end; 2], &mut out);
    }
    out
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

    /// Draws a line; two equal ends make a point.
    fn line(&self, ends: [End; 2], out: &mut Vec<LinePixel>) {
        if !ends.iter().all(|e| e.clip.iter().all(|c| c.is_finite())) {
            return;
        }
        let Some(([a, b], is_sure)) = cut(&ends) else { return };
        let pixels = [&a, &b].map(|e| self.pixels_of(e));
        // For every rounding of the ends: the pixels, with the range of their values and the number
        // of roundings that draw them.
        let mut ways = 0;
        let mut found: HashMap<[i64; 2], (usize, [DoubleDouble; 2], ColorRange)> = HashMap::new();
        let mut order = Vec::new();
        for &from in &pixels[0] {
            for &to in &pixels[1] {
                ways += 1;
                for (k, n, [x, y]) in bresenham(from, to, self.clip) {
                    let (z, range) = self.at(&a, &b, k, n);
                    let entry = found.entry([x, y]).or_insert_with(|| {
                        order.push([x, y]);
                        (0, [z; 2], range)
                    });
                    entry.0 += 1;
                    entry.1 = [entry.1[0].min(z), entry.1[1].max(z)];
                    entry.2 = entry.2.hull(range);
                }
            }
        }
        for [x, y] in order {
            let (count, z, range) = found[&[x, y]];
            let is_far = z[1] > DoubleDouble::ONE - DoubleDouble::new(DEPTH_EDGE);
            let presence = if count == ways && is_sure && !is_far { Coverage::Yes } else { Coverage::Maybe };
            let z = z.map(|z| z.max(DoubleDouble::ZERO).min(DoubleDouble::ONE));
            out.push(LinePixel {
                x,
                y,
                fragment: Fragment { presence, z, colors: vec![range] },
                clip: [a.clip, b.clip],
                is_transparent: range.alpha[0] < 1.0,
            });
        }
    }

    /// Returns the pixels that may contain an end; none for an end without a finite place.
    fn pixels_of(&self, end: &End) -> Vec<[i64; 2]> {
        let w = end.clip[3];
        let choices = self.context.sight.to_screen(end.clip[0] / w, end.clip[1] / w).map(|v| {
            let v = v.to_f64();
            let at = v.floor();
            match v - at {
                _ if v.is_nan() || v.abs() >= FARTHEST_PX => Vec::new(),
                part if part < BORDER_PX => vec![at as i64 - 1, at as i64],
                part if part > 1.0 - BORDER_PX => vec![at as i64, at as i64 + 1],
                _ => vec![at as i64],
            }
        });
        choices[0].iter().flat_map(|&x| choices[1].iter().map(move |&y| [x, y])).collect()
    }

    /// Returns depth and colour at step k of n.
    fn at(&self, a: &End, b: &End, k: i64, n: i64) -> (DoubleDouble, ColorRange) {
        let s = if n == 0 {
            DoubleDouble::ZERO
        } else {
            DoubleDouble::new(k as f64) / DoubleDouble::new(n as f64)
        };
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
        is_sure && ((to - from).to_f64() > 1e-9 || (from == DoubleDouble::ZERO && to == DoubleDouble::ONE));
    ends.iter().all(|e| e.clip[3] > DoubleDouble::ZERO).then_some((ends, is_sure))
}

/// Iterates over (step, steps, pixel) of a line's pixels within x0..x1, y0..y1 of `clip`, both ends
/// included. Source 001: the midpoint variable d begins at 2 dy - dx, in integers, for all octants.
/// End points lie within 2^41 of the origin.
///
/// Each step with d > 0 moves along the minor axis. So after k steps along the longer side n, with
/// m the shorter one, the line has moved ceil((2 m k - n) / 2 n) along the minor axis, and never a
/// negative amount: the steps before the clip rectangle need not be computed.
fn bresenham(from: [i64; 2], to: [i64; 2], clip: [i64; 4]) -> impl Iterator<Item = (i64, i64, [i64; 2])> {
    let sign = [0, 1].map(|k| (to[k] - from[k]).signum());
    let length = [0, 1].map(|k| (to[k] - from[k]).abs());
    let (major, minor) = if length[0] >= length[1] { (0, 1) } else { (1, 0) };
    let (n, m) = (length[major], length[minor]);
    let inside = [clip[0]..clip[1], clip[2]..clip[3]];
    // The steps whose major coordinate is inside; a line of one pixel has step 0 only.
    let steps = match sign[major] {
        1.. => inside[major].start - from[major]..inside[major].end - from[major],
        0 => 0..1,
        _ => from[major] - inside[major].end + 1..from[major] - inside[major].start + 1,
    };
    (steps.start.max(0)..steps.end.min(n + 1)).filter_map(move |k| {
        let (n, m, steps) = (i128::from(n), i128::from(m), i128::from(k));
        // ceil(a / b) = -floor(-a / b).
        let across = if k == 0 { 0 } else { (-(n - 2 * m * steps).div_euclid(2 * n)).max(0) as i64 };
        let mut p = from;
        p[major] += sign[major] * k;
        p[minor] += sign[minor] * across;
        (inside[0].contains(&p[0]) && inside[1].contains(&p[1])).then_some((k, n as i64, p))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Draws the line of [`bresenham`] one step at a time.
    fn stepped(from: [i64; 2], to: [i64; 2]) -> Vec<(i64, i64, [i64; 2])> {
        let sign = [0, 1].map(|k| (to[k] - from[k]).signum());
        let length = [0, 1].map(|k| (to[k] - from[k]).abs());
        let (major, minor) = if length[0] >= length[1] { (0, 1) } else { (1, 0) };
        let (n, m) = (length[major], length[minor]);
        let (mut p, mut d) = (from, 2 * m - n);
        let mut out = vec![(0, n, p)];
        for k in 1..=n {
            p[major] += sign[major];
            if d > 0 {
                p[minor] += sign[minor];
                d -= 2 * n;
            }
            d += 2 * m;
            out.push((k, n, p));
        }
        out
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn a_line_is_the_midpoint_algorithms_steps_inside_the_rectangle(
            from in [-40i64..40, -40i64..40], to in [-40i64..40, -40i64..40],
            x in -30i64..30, y in -30i64..30, w in 0i64..40, h in 0i64..40,
        ) {
            let clip = [x, x + w, y, y + h];
            let mut want = stepped(from, to);
            want.retain(|(_, _, [px, py])| (x..x + w).contains(px) && (y..y + h).contains(py));
            prop_assert_eq!(bresenham(from, to, clip).collect::<Vec<_>>(), want);
        }
    }

    #[test]
    fn a_line_of_any_length_costs_its_visible_part() {
        let far = FARTHEST_PX as i64;
        let across: Vec<_> = bresenham([-far, -far], [far, far], [0, 8, 0, 8]).map(|s| s.2).collect();
        assert_eq!(across, (0..8).map(|i| [i, i]).collect::<Vec<_>>());
        assert_eq!(bresenham([3, 3], [3, 3], [0, 8, 0, 8]).collect::<Vec<_>>(), [(0, 0, [3, 3])]);
    }
}

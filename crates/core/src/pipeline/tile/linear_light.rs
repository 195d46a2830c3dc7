//! Bound on how far light differs from its bilinear interpolation over cells of pixels.
//!
//! In: what a face's pixels are lit from, at the four corners of each block of cells, and the lights
//! of its material. Out: an upper bound on the error, in units of colour (1 is 255 steps), of light
//! that is computed at the corners of the block's cells and interpolated between them, for cells of any
//! size ([`CellErrors`]). One knows by dense samples in f64 that stay within the bound, for random
//! faces, lights and blocks (tests).
//!
//! Bilinear interpolation of f errs by at most (max|f_xx| w^2 + max|f_yy| h^2) / 8 over a cell of w by h
//! pixels. The largest derivatives are those of the block; below they are along one of its sides, in
//! units of that side, of which a cell has a part. A unit vector u = v/|v| of a linear v turns by u' and
//! u'':
//!
//! ```text
//! |u'|  = |v x v'| / |v|^2              |v x v'| is convex along the other side: largest at an edge
//! |u''| <= 2 |v'||v x v'| / |v|^3 + |u'|^2
//! ```
//!
//! Over the screen, sums of corners' normals weighted by b/w, the ray, and (light - point) q with
//! q = 1/w are linear, so N, V and L are such vectors. For s = N.L, |s'| <= n' + l' and |s''| <= n'' +
//! 2 n' l' + l''; R = A(N) L with the reflection A turns by R' <= 2 n' + l' and R'' <= 4 n'' + 4 n'^2 + 4
//! n' l' + l''; H = (L + V)/|L + V| as any unit vector of w: |u''| <= |w''|/|w| + 1.155 (|w'|/|w|)^2.
//! A point P = Q/q has P' = C/q^2 and P'' = -2 C q'/q^3 with C = Q'q - Qq' constant along a side. Products
//! and powers follow by the chain rule. max(N.L, 0) has a kink: where f = max(g, 0), the four corners'
//! mean differs from max(mean, 0) by at most -lo hi / (hi - lo) <= (hi - lo) / 4, lo and hi the least
//! and the largest g of a cell. Where light ends at once (a radius, highlights of faces that turn away)
//! nothing is proven.

mod varying;

pub(super) use varying::{BLOCK, CellErrors};

use super::lighting::{Cone, FastLight, LightPosition, MaterialLighting, V3, acos, dot, scale, splat3};
use crate::scene::LightingModel;
use crate::simd::{F32, Simd};
use std::f32::consts::PI;
use varying::{
    Direction, EDGES, LEAST, UNKNOWN, Varying, constant, cosine, curvature, direction, kink, known_where,
    length, of_side, product, raised, selected, subtract, varying,
};

/// Inputs of the light at the four corners of a block: left and right of the upper side, then of the lower.
pub(super) struct BlockCorners<S: Simd> {
    /// 1/w.
    pub q: [S::F; 4],
    /// Positions in shading space, times q.
    pub points: [V3<S>; 4],
    /// Normals towards the light, of any length, linear over the screen.
    pub normals: [V3<S>; 4],
    /// Unit vector towards a viewer at infinity; `None` if the viewer is at the origin.
    pub to_viewer: Option<V3<S>>,
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the
// level's instructions.

/// Returns bounds on the error of interpolated light over the cells of blocks.
#[inline(always)]
pub(super) fn errors_of_cells<S: Simd>(
    s: S,
    lighting: &MaterialLighting,
    block: &BlockCorners<S>,
) -> CellErrors<S> {
    let zero = s.splat(0.0);
    let normal = direction(s, &block.normals);
    let viewer = viewer(s, block);
    let mut sum = CellErrors { by_square: zero, by_side: zero };
    for light in &lighting.lights {
        let own = light_errors(s, lighting, light, block, &normal, &viewer);
        sum.by_square = sum.by_square + own.by_square;
        sum.by_side = sum.by_side + own.by_side;
    }
    sum
}

/// Returns bounds on the error of one light.
#[inline(always)]
fn light_errors<S: Simd>(
    s: S,
    lighting: &MaterialLighting,
    light: &FastLight,
    block: &BlockCorners<S>,
    normal: &Direction<S>,
    viewer: &Direction<S>,
) -> CellErrors<S> {
    let (zero, unknown) = (s.splat(0.0), s.splat(UNKNOWN));
    let (to_light, strength, is_outside) = match light.position {
        LightPosition::Toward(d) => {
            let flat = [zero; 2];
            let to_light = Direction { at: [splat3(s, d); 4], first: flat, second: flat };
            (to_light, constant(s, 1.0), s.mask(0))
        }
        LightPosition::At(p) => from_place(s, light, splat3(s, p), block),
    };
    let facing = cosine(s, normal, &to_light);
    let lit = product(s, &facing, &strength);
    let is_dark = facing.high.le(zero);
    let brightness = s.splat(brightest(light.diffuse));
    let kink = s.select(is_dark, zero, brightness * (kink(s, &facing) * strength.high));
    let mut error = s.select(is_dark, zero, brightness * curvature(s, &lit));
    if light.ambient != [0.0; 3] {
        error = error + s.splat(brightest(light.ambient)) * curvature(s, &strength);
    }
    if light.specular != [0.0; 3] {
        let mirrored = mirrored(s, lighting.model, normal, &to_light, viewer, &facing);
        let is_dull = is_dark | mirrored.high.le(s.splat(light.dark_cosine));
        let highlight = product(s, &raised(s, &mirrored, lighting.exponent), &strength);
        let specular = s.splat(brightest(light.specular)) * curvature(s, &highlight);
        let specular = s.select(facing.low.lt(zero), unknown, specular);
        error = error + s.select(is_dull, zero, specular);
    }
    CellErrors { by_square: s.select(is_outside, zero, error), by_side: s.select(is_outside, zero, kink) }
}

/// Returns the directions to a light at a place, its strength, and the blocks that it does not reach.
#[inline(always)]
fn from_place<S: Simd>(
    s: S,
    light: &FastLight,
    place: V3<S>,
    block: &BlockCorners<S>,
) -> (Direction<S>, Varying<S>, S::M) {
    let mut to_light = [place; 4];
    let mut corner = 0;
    while corner < 4 {
        to_light[corner] = subtract::<S>(scale::<S>(place, block.q[corner]), block.points[corner]);
        corner += 1;
    }
    let direction = direction(s, &to_light);
    let mut strength = constant(s, 1.0);
    let mut is_outside = s.mask(0);
    if light.attenuation.is_some() || light.reach2 < f32::INFINITY {
        let distance = distance(s, &to_light, block);
        if let Some(sum) = light.attenuation {
            strength = attenuation(s, sum, light.is_clamped, &distance);
        }
        if light.reach2 < f32::INFINITY {
            let reach2 = s.splat(light.reach2);
            is_outside = (reach2 * s.splat(1.0001)).lt(distance.low * distance.low);
            if !light.is_reach_faded {
                let is_inside = (distance.high * distance.high).lt(reach2 * s.splat(0.9999));
                strength = known_where(s, is_inside, strength);
            }
        }
    }
    if light.cone != Cone::None {
        let (part, is_beside) = in_cone(s, light, &direction);
        strength = product(s, &strength, &part);
        is_outside = is_outside | is_beside;
    }
    (direction, strength, is_outside)
}

/// Returns the distance of points from a light; `to_light` are the vectors to it, times q.
#[inline(always)]
fn distance<S: Simd>(s: S, to_light: &[V3<S>; 4], block: &BlockCorners<S>) -> Varying<S> {
    let q = &block.q;
    let least_q = q[0].min(q[1]).min(q[2]).min(q[3]);
    let mut place = [to_light[0]; 4];
    let mut at = [q[0]; 4];
    let mut corner = 0;
    while corner < 4 {
        place[corner] = scale::<S>(to_light[corner], s.splat(1.0) / q[corner]);
        at[corner] = length::<S>(place[corner]);
        corner += 1;
    }
    let (mut first, mut bend) = ([s.splat(0.0); 2], [s.splat(0.0); 2]);
    let mut side = 0;
    while side < 2 {
        let [[a, b], [c, d]] = EDGES[side];
        let upper = length::<S>(subtract::<S>(place[b], place[a])) * (q[a] * q[b]);
        let lower = length::<S>(subtract::<S>(place[d], place[c])) * (q[c] * q[d]);
        first[side] = upper.max(lower) / (least_q * least_q);
        let change = (q[b] - q[a]).abs().max((q[d] - q[c]).abs());
        bend[side] = first[side] * (change + change) / least_q;
        side += 1;
    }
    let mut distance = varying(s, at, first, bend);
    distance.low = distance.low.max(s.splat(0.0));
    let nearest = distance.low.max(s.splat(LEAST));
    distance.second = [bend[0] + first[0] * first[0] / nearest, bend[1] + first[1] * first[1] / nearest];
    distance
}

/// Returns 1 / (c + l d + q d^2), clamped to at most 1 if `is_clamped`.
#[inline(always)]
fn attenuation<S: Simd>(s: S, [c, l, q]: [f32; 3], is_clamped: bool, distance: &Varying<S>) -> Varying<S> {
    let one = s.splat(1.0);
    let (c, l, q) = (s.splat(c), s.splat(l), s.splat(q));
    let is_growing = s.splat(0.0).le(c.min(l).min(q));
    let least = c + (l * distance.low + q * (distance.low * distance.low));
    let most = c + (l * distance.high + q * (distance.high * distance.high));
    let slope = l + (q + q) * distance.high;
    let inverse = one / least.max(s.splat(LEAST));
    let mut out = constant(s, 1.0);
    let mut side = 0;
    while side < 2 {
        let (d1, d2) = (distance.first[side], distance.second[side]);
        let first = slope * d1;
        let second = slope * d2 + (q + q) * (d1 * d1);
        let ratio = first * inverse;
        out.first[side] = ratio * inverse;
        out.second[side] = (second * inverse + (ratio + ratio) * ratio) * inverse;
        side += 1;
    }
    out.high = inverse;
    out.low = s.splat(0.0);
    if is_clamped {
        let is_full = most.le(s.splat(0.999));
        let is_even = is_full | s.splat(1.001).le(least);
        out = selected(s, is_full, &constant(s, 1.0), &out);
        return known_where(s, is_growing & is_even, out);
    }
    known_where(s, is_growing, out)
}

/// Returns the part of a light that its cone lets through, and the blocks that lie beside the cone.
#[inline(always)]
fn in_cone<S: Simd>(s: S, light: &FastLight, to_light: &Direction<S>) -> (Varying<S>, S::M) {
    let (zero, one) = (s.splat(0.0), s.splat(1.0));
    let (Cone::Power { axis, .. } | Cone::Linear { axis, .. }) = light.cone else {
        return (constant(s, 1.0), s.mask(0));
    };
    let axis = splat3(s, axis.map(|v| -v));
    let still = Direction { at: [axis; 4], first: [zero; 2], second: [zero; 2] };
    let cosine = cosine(s, &still, to_light);
    match light.cone {
        Cone::None => (constant(s, 1.0), s.mask(0)),
        Cone::Power { cos_angle, exponent, .. } => {
            let is_inside = s.splat(cos_angle + 1e-4).lt(cosine.low);
            let part = known_where(s, is_inside, raised(s, &cosine, exponent));
            (part, cosine.high.lt(s.splat(cos_angle - 1e-4)))
        }
        Cone::Linear { beam, cut_off, .. } => {
            let (nearest, farthest) = (
                acos(s, cosine.high.min(one)) - s.splat(1e-4),
                acos(s, cosine.low.max(-one)) + s.splat(1e-4),
            );
            // The angle curves most near the axis, before the light and behind it.
            let from_axis = nearest.min(s.splat(PI) - farthest).max(s.splat(LEAST));
            let per_angle = one / s.splat(cut_off - beam).max(s.splat(LEAST));
            let mut part = constant(s, 1.0);
            let mut side = 0;
            while side < 2 {
                let (l1, l2) = (to_light.first[side], to_light.second[side]);
                part.first[side] = l1 * per_angle;
                part.second[side] = (l2 + l1 * l1 / from_axis) * per_angle;
                side += 1;
            }
            let is_full = farthest.lt(s.splat(beam.min(cut_off)));
            let is_partial = s.splat(beam).lt(nearest) & farthest.lt(s.splat(cut_off));
            let part = selected(s, is_full, &constant(s, 1.0), &part);
            (known_where(s, is_full | is_partial, part), s.splat(cut_off).lt(nearest))
        }
    }
}

/// Returns R.V or N.H.
#[inline(always)]
fn mirrored<S: Simd>(
    s: S,
    model: LightingModel,
    normal: &Direction<S>,
    to_light: &Direction<S>,
    viewer: &Direction<S>,
    facing: &Varying<S>,
) -> Varying<S> {
    let (one, two, four) = (s.splat(1.0), s.splat(2.0), s.splat(4.0));
    let between = cosine(s, to_light, viewer);
    let is_blinn = matches!(model, LightingModel::Blinn);
    let halfway = (two + two * between.low).max(s.splat(1e-6)).sqrt();
    let (mut at, mut first, mut second) = (facing.at, facing.first, facing.second);
    let mut corner = 0;
    while corner < 4 {
        let seen = dot::<S>(normal.at[corner], viewer.at[corner]);
        at[corner] = match is_blinn {
            true => (facing.at[corner] + seen) / (two + two * between.at[corner]).max(s.splat(1e-6)).sqrt(),
            false => two * facing.at[corner] * seen - between.at[corner],
        };
        corner += 1;
    }
    let mut side = 0;
    while side < 2 {
        let ([n1, n2], [l1, l2], [v1, v2]) =
            (of_side(normal, side), of_side(to_light, side), of_side(viewer, side));
        let (turned1, turned2, other1, other2) = match is_blinn {
            true => {
                let h1 = (l1 + v1) / halfway;
                (h1, (l2 + v2) / halfway + s.splat(1.155) * (h1 * h1), n1, n2)
            }
            false => (two * n1 + l1, four * (n2 + n1 * n1 + n1 * l1) + l2, v1, v2),
        };
        first[side] = turned1 + other1;
        second[side] = turned2 + two * (turned1 * other1) + other2;
        side += 1;
    }
    let mut cosine = varying(s, at, first, second);
    cosine.high = cosine.high.min(one);
    cosine
}

/// Returns the directions to the viewer.
#[inline(always)]
fn viewer<S: Simd>(s: S, block: &BlockCorners<S>) -> Direction<S> {
    if let Some(to_viewer) = block.to_viewer {
        let flat = [s.splat(0.0); 2];
        return Direction { at: [to_viewer; 4], first: flat, second: flat };
    }
    let mut back = block.points;
    let mut corner = 0;
    while corner < 4 {
        back[corner] = scale::<S>(back[corner], s.splat(-1.0));
        corner += 1;
    }
    direction(s, &back)
}

/// Returns the largest channel.
#[inline(always)]
fn brightest(color: [f32; 3]) -> f32 {
    color[0].abs().max(color[1].abs()).max(color[2].abs())
}

#[cfg(test)]
mod tests;

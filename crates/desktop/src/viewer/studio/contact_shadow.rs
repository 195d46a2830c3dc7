//! The soft shadow under a model, as if light came from the whole sky.
//!
//! In: a mesh. Out: for each texel of a square on the ground, the part of the light that is missing.
//! The nearer the model's lowest face over a texel, the darker: 1 at contact, 0 from a fraction of
//! the model's height on. Two such maps, a narrow and a wide one, are blurred and mixed: an ambient
//! occlusion that costs one look at the mesh. It is no shadow of a light; it says where the model
//! stands.

use fbptr_core::scene::Mesh;
use glam::DVec3;

/// Texels on each side of the map.
const SIDE: usize = 128;
/// Room around the model's box on each side, as a part of the box's longer side.
const ROOM: f64 = 0.3;

/// The shadow's map on the ground.
pub(super) struct ContactShadow {
    /// Corner of the map with the least x and z.
    corner: [f32; 2],
    /// Texels for each unit of length.
    texels: f32,
    /// The missing part of the light, row by row along x.
    dark: Vec<f32>,
}

impl ContactShadow {
    /// Computes the shadow of a mesh whose box is `bounds`, on the ground at its lowest point.
    pub fn of(mesh: &Mesh, (low, high): (DVec3, DVec3)) -> Self {
        let size = high - low;
        let side = (size.x.max(size.z) * (1.0 + 2.0 * ROOM)).max(1e-9 * size.y.max(1e-300));
        let corner = [(low.x + high.x - side) / 2.0, (low.z + high.z - side) / 2.0];
        let texels = SIDE as f64 / side;
        let lowest = lowest_faces(mesh, corner, texels, low.y);
        // Height from which nothing is darkened: faces just above the ground, and the whole model.
        let map = |reach: f64, radius: usize| {
            let dark = lowest.iter().map(|h| {
                let near = (1.0 - h / reach).clamp(0.0, 1.0);
                (near * near) as f32
            });
            blurred(dark.collect(), radius)
        };
        let extent = size.y.max(0.05 * size.x.max(size.z));
        let (narrow, wide) = (map(0.12 * extent, 2), map(0.8 * extent, 7));
        let dark = narrow.iter().zip(&wide).map(|(n, w)| 1.0 - (1.0 - 0.5 * n) * (1.0 - 0.6 * w)).collect();
        ContactShadow { corner: corner.map(|v| v as f32), texels: texels as f32, dark }
    }

    /// Returns the missing part of the light at a place of the ground, bilinearly.
    pub fn at(&self, x: f32, z: f32) -> f32 {
        let place = |v: f32, corner: f32| (v - corner) * self.texels - 0.5;
        let (u, v) = (place(x, self.corner[0]), place(z, self.corner[1]));
        let end = (SIDE - 1) as f32;
        if !(u >= 0.0 && v >= 0.0 && u < end && v < end) {
            return 0.0;
        }
        let (i, j) = (u as usize, v as usize);
        let (fu, fv) = (u - i as f32, v - j as f32);
        let row = |j: usize| self.dark[j * SIDE + i] * (1.0 - fu) + self.dark[j * SIDE + i + 1] * fu;
        row(j) * (1.0 - fv) + row(j + 1) * fv
    }
}

/// Returns the height of the lowest face above the ground over each texel's centre, or infinity.
fn lowest_faces(mesh: &Mesh, corner: [f64; 2], texels: f64, ground: f64) -> Vec<f64> {
    let mut lowest = vec![f64::INFINITY; SIDE * SIDE];
    for t in &mesh.triangles {
        // Texel coordinates and height.
        let [a, b, c] = t.map(|i| {
            let p = mesh.positions[mesh.corners[i as usize].position as usize];
            DVec3::new((p.x - corner[0]) * texels - 0.5, (p.z - corner[1]) * texels - 0.5, p.y - ground)
        });
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        let (from, to) = (a.min(b).min(c).ceil(), a.max(b).max(c).floor());
        if area == 0.0 || !(from.is_finite() && to.is_finite() && area.is_finite()) {
            continue;
        }
        let range = |from: f64, to: f64| from.max(0.0) as usize..(to + 1.0).clamp(0.0, SIDE as f64) as usize;
        for j in range(from.y, to.y) {
            for i in range(from.x, to.x) {
                let (x, y) = (i as f64, j as f64);
                let wb = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / area;
                let wc = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / area;
                if wb >= 0.0 && wc >= 0.0 && wb + wc <= 1.0 {
                    let height = a.z + (b.z - a.z) * wb + (c.z - a.z) * wc;
                    let texel = &mut lowest[j * SIDE + i];
                    *texel = texel.min(height);
                }
            }
        }
    }
    lowest
}

/// Returns the map after three means over squares of 2 `radius` + 1 texels, nearly a Gaussian.
/// Outside the map there is no shadow.
fn blurred(mut map: Vec<f32>, radius: usize) -> Vec<f32> {
    let width = (2 * radius + 1) as f32;
    for pass in 0..6 {
        // Rows and columns in turn.
        let at = |line: usize, i: usize| if pass % 2 == 0 { line * SIDE + i } else { i * SIDE + line };
        let before = map.clone();
        for line in 0..SIDE {
            for i in 0..SIDE {
                let span = i.saturating_sub(radius)..(i + radius + 1).min(SIDE);
                map[at(line, i)] = span.map(|k| before[at(line, k)]).sum::<f32>() / width;
            }
        }
    }
    map
}

#[cfg(test)]
mod tests {
    use super::*;
    use fbptr_core::scene::shapes;

    #[test]
    fn it_is_dark_below_the_model_and_light_around() {
        let mesh = shapes::cuboid(DVec3::new(2.0, 1.0, 2.0)).expect("a size");
        let bounds = mesh.bounds().expect("points");
        let shadow = ContactShadow::of(&mesh, bounds);
        let (middle, edge, away) =
            (shadow.at(0.0, 0.0), shadow.at(bounds.1.x as f32, 0.0), shadow.at(99.0, 0.0));
        assert!(middle > 0.7 && edge < middle && edge > 0.1 && away == 0.0, "{middle} {edge} {away}");
        let soft = (0..40).map(|i| shadow.at(bounds.1.x as f32 * (0.7 + 0.02 * i as f32), 0.0));
        let soft: Vec<f32> = soft.collect();
        assert!(soft.windows(2).all(|w| w[1] <= w[0] + 1e-6), "falls outwards: {soft:?}");
        assert!(shadow.at(f32::NAN, 0.0) == 0.0);
    }

    #[test]
    fn what_hovers_high_darkens_less_than_what_stands() {
        let at_height = |height: f64| {
            let mut mesh = shapes::cuboid(DVec3::new(2.0, 1.0, 2.0)).expect("a size");
            let (low, high) = mesh.bounds().expect("points");
            mesh.positions.iter_mut().for_each(|p| p.y += height);
            let bounds = (low, high + DVec3::Y * height);
            ContactShadow::of(&mesh, bounds).at(0.0, 0.0)
        };
        assert!(at_height(0.0) > at_height(1.0) && at_height(1.0) > at_height(9.0));
    }
}

//! Shading: flat, Gouraud and Phong on a sphere, and Phong with approximate square roots and
//! powers.

use super::clock::Work;
use super::experiment::{Bound, Check, Effort, Experiment, Row, Standing, Truth};
use super::{approximations, picture};
use fbptr_core::math::power;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{Light, Material, Scene, ShadeMode, shapes};
use fbptr_truth::compare::nearest_bytes;
use fbptr_truth::metrics::{compare_bytes, pixel_error_quantile};
use fbptr_truth::scenes::{Case, object};
use fbptr_truth::{Settings, byte};
use glam::DVec3;

/// Experiment on shading.
pub(super) const SHADING: Experiment = Experiment {
    id: "shading",
    title: "Shading",
    about: "A sphere of triangles with one light and a highlight of exponent 32. The renderer's flat, Gouraud and Phong against \
            Phong on the same triangles; then, on the sphere itself and without the renderer, Phong in f32 with exact and \
            approximate square root and power.",
    truth: Truth {
        is: "Phong's equation at each pixel of the triangles, and of the sphere",
        digits: "positions 32, lighting 15",
        second_way: "the plain path, a program apart, for the triangles; the angle between V and R for the sphere; in 1/255",
    },
    check,
    columns: &["largest error, 1/255", "RMSE, 1/255", "99.9th percentile, 1/255", "SSIM"],
    plotted: 1,
    unit: "pixel",
    rows,
};

fn light_direction() -> DVec3 {
    DVec3::new(-0.4, -0.5, -0.9)
}

fn material() -> Material {
    Material { kd: DVec3::new(0.6, 0.3, 0.2), ks: DVec3::splat(0.7), n: 32.0, ..Material::default() }
}

fn columns(width: usize, found: &[u8], truth: &[u8]) -> Vec<f64> {
    let e = compare_bytes(width, found, truth);
    vec![e.steps.max, e.steps.rmse, pixel_error_quantile(found, truth, 0.999) as f64, e.ssim]
}

fn rows(effort: &Effort) -> Vec<Row> {
    let mut rows = on_triangles(effort);
    rows.extend(on_a_sphere(effort));
    rows
}

/// Returns the ball of triangles and the light.
fn scene() -> Scene {
    let mut ball = object("ball", shapes::sphere(1.6).expect("a sphere of radius 1.6"));
    ball.material = material();
    let light = Light::directional(light_direction(), DVec3::ONE);
    Scene { lights: vec![light], objects: vec![ball], ..Scene::default() }
}

fn case(effort: &Effort, shade: ShadeMode) -> Case {
    let side = effort.pick(96, 256);
    Case {
        name: "ball".into(),
        scene: scene(),
        settings: Settings { shade, ..Settings::default() },
        format: DepthFormat::F32,
        width: side,
        height: side,
    }
}

/// Compares the reference with the plain path, and the cosine of V and R from the vectors with that
/// of twice the angle between N and L, in the plane of both.
fn check(effort: &Effort) -> Check {
    let on_triangles = picture::plain_against_truth(&case(effort, ShadeMode::Phong));
    let on_sphere = normals_of_a_ball(48).into_iter().flatten().map(|n| {
        let (n, l) = (n / n.length(), -light_direction() / light_direction().length());
        let v = DVec3::Z;
        // R is L turned by twice the angle of N and L in their plane (O. Rodrigues, 1840).
        let axis = l.cross(n);
        let (sin, cos) = (axis.length(), n.dot(l));
        let (sin2, cos2) = (2.0 * sin * cos, 2.0 * cos * cos - 1.0);
        let r = if sin > 0.0 { l * cos2 + (axis / sin).cross(l) * sin2 } else { l };
        let direct = 2.0 * cos * n - l;
        255.0 * (libm::pow(r.dot(v).max(0.0), 32.0) - libm::pow(direct.dot(v).max(0.0), 32.0)).abs()
    });
    Check { difference: on_sphere.fold(on_triangles, f64::max), at_most: 1.0 }
}

fn on_triangles(effort: &Effort) -> Vec<Row> {
    let exact = picture::truth(&case(effort, ShadeMode::Phong));
    let [flat, gouraud] = bounds_of_facets(&scene());
    let flat_because = "flat: the colour's slope over the angle from a facet's corner to its middle";
    let gouraud_because = "gouraud: the colour's slope over twice that angle";
    let phong_because = "phong: the limit of untextured colours, by the specification";
    let modes = [
        (ShadeMode::Flat, flat, flat_because),
        (ShadeMode::Gouraud, gouraud, gouraud_because),
        (ShadeMode::Phong, 1.0, phong_because),
    ];
    let cases = modes.map(|mode| case(effort, mode.0));
    let drawn = picture::drawn_in_turns(effort, &cases);
    let ways = modes.into_iter().zip(cases).zip(drawn);
    ways.map(|(((shade, at_most, because), case), (found, timing))| {
        let standing = if shade == ShadeMode::default() { Standing::Default } else { Standing::Mode };
        let judge = |found: &Vec<u8>| columns(case.width as usize, found, &nearest_bytes(&exact, found));
        let mutate = |found: &mut Vec<u8>, bound: &Bound| picture::raise_error(found, &exact, bound.at_most);
        let bounds = vec![Bound { column: 0, at_most, because }];
        let key = ("sphere of triangles", shade.as_str(), standing);
        let truth = nearest_bytes(&exact, &found);
        Row::judged(effort, key, &found, bounds, judge, mutate)
            .timed(timing, f64::from(case.width * case.height))
            .with_picture(case.width, found, truth)
    })
    .collect()
}

/// Returns bounds for flat and Gouraud shading on a faceted ball, in steps of 1/255. The colour
/// changes with the normal's angle by at most kd; in the highlight, ks cos^n changes by at most
/// sqrt(n / e) per angle of R and V, which rotates twice as fast as the normal, and half as much
/// again because the eye is near. A facet's normals are within an angle of its centroid's, and
/// within twice that angle of each other.
fn bounds_of_facets(scene: &Scene) -> [f64; 2] {
    let mesh = &scene.objects[0].geometry.mesh;
    let widest = mesh.triangles.iter().fold(0f64, |widest, corners| {
        let at = corners.map(|c| mesh.positions[mesh.corners[c as usize].position as usize].normalize());
        let middle = ((at[0] + at[1] + at[2]) / 3.0).normalize();
        at.iter().fold(widest, |w, p| w.max(libm::acos(p.dot(middle).min(1.0))))
    });
    let m = material();
    let slope = m.kd.max_element() + m.ks.max_element() * (m.n / std::f64::consts::E).sqrt() * 2.5;
    // The quantization to bytes adds half a step on either side.
    [1.0, 2.0].map(|angles| (255.0 * slope * widest * angles + 1.0).ceil())
}

type Root = fn(f32) -> f32;
type Power = fn(f32, f32) -> f32;
/// Bound of the largest error with its derivation.
type Limit = Option<(f64, &'static str)>;

fn on_a_sphere(effort: &Effort) -> Vec<Row> {
    let exact_root: Root = |x| 1.0 / x.sqrt();
    let exact_power: Power = |x, n| power::pow(x as f64, n as f64) as f32;
    // f32 loses less than a step of 255; then the root's error e counts twice in R, of which V sees
    // twice that, to the 32nd power, times ks: 255 x 32 x 0.7 x 4 e.
    let exact = Some((1.0, "f32: 8 roundings of 2^-24, to the 32nd power: less than a step"));
    let coarse = Some((6.0, "12 bits: e = 2^-13 of the root, 255 x 32 x 0.7 x 4 e, over two of its steps"));
    let by_bits = Some((41.0, "root by bits: e = 0.00175 (Lomont), 255 x 32 x 0.7 x 4 e, and a step"));
    let ways: [(&str, Root, Power, Limit); 7] = [
        ("f32, exact root and power", exact_root, exact_power, exact),
        ("12-bit root", |x| approximations::of_12_bits(x, 0), exact_power, coarse),
        ("12-bit root and one Newton step", |x| approximations::of_12_bits(x, 1), exact_power, exact),
        ("root by bits, one Newton step", |x| approximations::by_bits(x, 1), exact_power, by_bits),
        ("root by bits, two Newton steps", |x| approximations::by_bits(x, 2), exact_power, exact),
        ("power by parabolas", exact_root, approximations::power_by_parabolas, None),
        ("power of Schlick", exact_root, approximations::power_of_schlick, None),
    ];
    let side = effort.pick(128usize, 512);
    let normals = &normals_of_a_ball(side);
    let truth: Vec<u8> = normals.iter().flat_map(|&n| n.map_or([0, 0, 0, 255], phong_f64)).collect();
    let work = |(_, root, power, _): (&str, Root, Power, Limit)| -> Work<Vec<u8>> {
        let of = move |&n: &Option<DVec3>| n.map_or([0, 0, 0, 255], |n| phong_f32(n, root, power));
        Box::new(move || std::hint::black_box(normals).iter().flat_map(of).collect())
    };
    let drawn = effort.run_in_turns(ways.map(work).into());
    let ways = ways.into_iter().zip(drawn);
    ways.map(|((name, _, _, bound), (bytes, timing))| {
        let bounds = bound.map(|(at_most, because)| Bound { column: 0, at_most, because });
        let key = ("sphere, per pixel", name, Standing::Comparison);
        let judge = |found: &Vec<u8>| columns(side, found, &truth);
        let mutate = |found: &mut Vec<u8>, bound: &Bound| found[0] = truth[0] + bound.at_most as u8 + 1;
        Row::judged(effort, key, &bytes, bounds.into_iter().collect(), judge, mutate)
            .timed(timing, (side * side) as f64)
            .with_picture(side as u32, bytes, truth.clone())
    })
    .collect()
}

/// Returns the normals of a ball seen along -z, with lengths that vary like interpolated ones;
/// `None` outside the ball.
fn normals_of_a_ball(side: usize) -> Vec<Option<DVec3>> {
    let at = |i: usize| (i as f64 + 0.5) / side as f64 * 2.2 - 1.1;
    let mut normals = Vec::with_capacity(side * side);
    for (y, x) in (0..side).flat_map(|y| (0..side).map(move |x| (y, x))) {
        let (nx, ny) = (at(x), -at(y));
        let rest = 1.0 - nx * nx - ny * ny;
        let length = 0.9 + 0.1 * ((x * 7 + y * 3) % 11) as f64 / 10.0;
        normals.push((rest > 0.0).then(|| DVec3::new(nx, ny, rest.sqrt()) * length));
    }
    normals
}

fn phong_f64(n: DVec3) -> [u8; 4] {
    let (n, l) = (n / n.length(), -light_direction() / light_direction().length());
    let n_dot_l = n.dot(l);
    let r = 2.0 * n_dot_l * n - l;
    let m = material();
    let shine = if n_dot_l > 0.0 { libm::pow(r.z.max(0.0), m.n) } else { 0.0 };
    let color = m.kd * n_dot_l.max(0.0) + m.ks * shine;
    [byte(color.x), byte(color.y), byte(color.z), 255]
}

fn phong_f32(n: DVec3, root: Root, power: Power) -> [u8; 4] {
    let n = n.as_vec3();
    let n = n * root(n.length_squared());
    let l = (-light_direction() / light_direction().length()).as_vec3();
    let n_dot_l = n.dot(l);
    let r = 2.0 * n_dot_l * n - l;
    let m = material();
    let shine = if n_dot_l > 0.0 { power(r.z.clamp(0.0, 1.0), m.n as f32) } else { 0.0 };
    let color = m.kd.as_vec3() * n_dot_l.max(0.0) + m.ks.as_vec3() * shine;
    let to_byte = |c: f32| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    [to_byte(color.x), to_byte(color.y), to_byte(color.z), 255]
}

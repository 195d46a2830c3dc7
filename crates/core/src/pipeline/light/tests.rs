use super::*;
use crate::pipeline::golden;

fn vec(v: &serde_json::Value) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|i| v[i].as_f64().unwrap()))
}

fn directional(to_light: DVec3, color: DVec3) -> Light {
    Light {
        kind: LightKind::Directional { direction: -to_light },
        color,
        ambient: DVec3::ZERO,
        clamp_attenuation: false,
    }
}

#[test]
fn golden_x3d_lighting() {
    let golden = golden("extra_x3d_lighting");
    let tolerance = golden["tolerance"]["absolute"].as_f64().unwrap();
    let cases = golden["expected"].as_array().unwrap();
    assert!(cases.len() >= 4);
    for case in cases {
        let i = &case["inputs"];
        let number = |name: &str| i[name].as_f64().unwrap();
        let (od, il) = (vec(&i["Od"]), vec(&i["Il"]));
        let material = Material {
            ka: od * number("Oa"),
            kd: od,
            ks: vec(&i["Os"]),
            n: 128.0 * number("sh"),
            emissive: vec(&i["Oe"]),
            model: LightingModel::Blinn,
            ..Material::default()
        };
        let light = Light { ambient: il * number("Iia"), ..directional(vec(&i["L"]), il * number("Ii")) };
        let lighting = Lighting::new([light].iter(), DVec3::ZERO, ViewerPosition::Axis(vec(&i["Vv"])));
        let lit = lighting.at(SurfacePoint { position: DVec3::ZERO, normal: vec(&i["N"]) }, &material);
        let off = (lit.diffuse_ambient + lit.specular_emissive - vec(&case["colour"])).abs().max_element();
        assert!(off <= tolerance, "{}: off by {off}", case["name"]);
        let off = (lit.specular_emissive - material.emissive - vec(&case["specular"])).abs().max_element();
        assert!(off <= tolerance, "{}: specular off by {off}", case["name"]);
    }
}

fn shiny(n: f64) -> Material {
    Material { ks: DVec3::ONE, n, ..Material::default() }
}

/// Returns the colour at the origin of a face that looks along +z, seen along (0, 0, 1).
fn at_origin(light: Light, material: &Material) -> LitColor {
    let lighting = Lighting::new([light].iter(), DVec3::ZERO, ViewerPosition::Axis(DVec3::Z));
    lighting.at(SurfacePoint { position: DVec3::ZERO, normal: DVec3::Z }, material)
}

#[test]
fn phong_reflects_and_blinn_halves() {
    let l = DVec3::new(0.0, 0.6, 0.8);
    // R = (0, -0.6, 0.8), R.V = 0.8; H = (0, 0.6, 1.8)/|..|, N.H = 1.8/sqrt(3.6).
    let phong = at_origin(directional(l, DVec3::ONE), &shiny(3.0));
    assert!((phong.specular_emissive.x - 0.8f64 * 0.8 * 0.8).abs() < 1e-15);
    assert!((phong.diffuse_ambient.x - 0.8 * 0.8).abs() < 1e-15);
    let blinn = Material { model: LightingModel::Blinn, ..shiny(2.0) };
    assert!(
        (at_origin(directional(l, DVec3::ONE), &blinn).specular_emissive.x - 1.8 * 1.8 / 3.6).abs() < 1e-15
    );
    // From behind there is no light, not even where R.V would be positive.
    let behind = at_origin(directional(DVec3::new(0.0, 0.6, -0.8), DVec3::ONE), &shiny(0.0));
    assert_eq!((behind.diffuse_ambient, behind.specular_emissive), (DVec3::ZERO, DVec3::ZERO));
}

#[test]
fn exponents_0_and_a_million_are_finite_and_in_range() {
    let grazing = directional(DVec3::new(0.0, 1.0, 1e-9).normalize(), DVec3::ONE);
    // R.V is 1e-9 > 0; with n = 0 any power of it is 1, as is 0^0.
    assert_eq!(at_origin(grazing, &shiny(0.0)).specular_emissive, DVec3::ONE);
    assert_eq!(at_origin(directional(DVec3::Z, DVec3::ONE), &shiny(1e6)).specular_emissive, DVec3::ONE);
    let near = at_origin(directional(DVec3::new(0.0, 1e-3, 1.0).normalize(), DVec3::ONE), &shiny(1e6))
        .specular_emissive
        .x;
    // cos(1e-3)^1e6 = exp(1e6 ln cos 1e-3) = exp(-0.5000000833).
    assert!((near - libm::exp(1e6 * libm::log(libm::cos(libm::atan(1e-3))))).abs() < 1e-9, "{near}");
}

fn point(position: DVec3, attenuation: Attenuation, radius: f64, clamp_attenuation: bool) -> Light {
    Light {
        kind: LightKind::Point { position, attenuation, radius },
        color: DVec3::ONE,
        ambient: DVec3::splat(0.5),
        clamp_attenuation,
    }
}

#[test]
fn attenuation_falls_with_distance_and_x3d_clamps_it() {
    let material = Material { ka: DVec3::ONE, ..Material::default() };
    let a = Attenuation { c: 0.1, l: 0.2, q: 0.05 };
    let base = |d: f64, clamp| at_origin(point(DVec3::Z * d, a, 10.0, clamp), &material).diffuse_ambient.x;
    // 1/(0.1 + 0.4 + 0.2) at d = 2, times ambient 0.5 and Kd 0.8.
    assert!((base(2.0, false) - 1.3 / 0.7).abs() < 1e-14);
    assert!((base(2.0, true) - 1.3).abs() < 1e-14);
    assert!((base(9.0, true) - 1.3 / 5.95).abs() < 1e-14);
    assert_eq!(base(10.5, true), 0.0);
    // A light at the surface point contributes nothing.
    assert_eq!(base(0.0, false), 0.0);
    let dark = Attenuation { c: 0.0, l: 0.0, q: 0.0 };
    for p in [DVec3::Z, -DVec3::Z, DVec3::Z * 1e-300, DVec3::Z * 1e200] {
        let lit = at_origin(point(p, dark, f64::INFINITY, false), &material);
        assert!(lit.diffuse_ambient.is_finite() && lit.specular_emissive.is_finite(), "{p}");
    }
}

#[test]
fn spots_end_at_their_angle() {
    let spot = |angle_rad: f64, exponent| Light {
        kind: LightKind::Spot {
            position: DVec3::new(0.0, 3.0, 4.0),
            direction: DVec3::new(0.0, 0.0, -2.0),
            angle_rad,
            exponent,
            attenuation: Attenuation::NONE,
        },
        color: DVec3::ONE,
        ambient: DVec3::ZERO,
        clamp_attenuation: false,
    };
    let base = |light| at_origin(light, &Material::default()).diffuse_ambient.x;
    // The ray to the origin makes an angle of cosine 0.8 with the axis; N.L = 0.8.
    assert!((base(spot(0.65, 2.0)) - 0.8 * 0.8 * 0.64).abs() < 1e-15);
    assert_eq!(base(spot(0.64, 2.0)), 0.0);
    assert!((base(spot(std::f64::consts::PI, 0.0)) - 0.64).abs() < 1e-15);
    let x3d = |beam_width_rad, cut_off_rad| Light {
        kind: LightKind::X3dSpot {
            position: DVec3::new(0.0, 3.0, 4.0),
            direction: -DVec3::Z,
            beam_width_rad,
            cut_off_rad,
            attenuation: Attenuation::NONE,
            radius: 100.0,
        },
        ..spot(0.0, 0.0)
    };
    let angle = libm::acos(0.8);
    assert!((base(x3d(angle + 0.1, angle + 0.2)) - 0.64).abs() < 1e-15);
    assert!((base(x3d(angle - 0.1, angle + 0.3)) - 0.64 * 0.75).abs() < 1e-14);
    assert_eq!(base(x3d(0.1, angle - 0.01)), 0.0);
}

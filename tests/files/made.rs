//! Small scenes made after the features of real files. Each loads with these warnings and this
//! number of objects, equals its stored picture (BLESS=1 rewrites the pictures), and agrees with
//! the reference.

use crate::support::{check, data, draw, load, warnings};
use fbptr::save::golden::{Mode, Tolerance, check as check_picture};
use std::collections::BTreeSet;

/// A scene's name, its number of objects, and the lines of its warnings.
type Made = (&'static str, usize, &'static [u32]);

const MADE: &[Made] = &[
    ("anchor", 1, &[]),
    ("arcs", 6, &[]),
    ("billboard_free", 2, &[]),
    ("billboard_x", 2, &[]),
    ("billboard_y", 4, &[]),
    ("cad", 1, &[7, 7, 7, 7]),
    ("collision_proxy", 1, &[]),
    ("color_long", 1, &[]),
    ("color_short", 1, &[7]),
    ("compressed", 1, &[]),
    ("coordinate_double", 1, &[]),
    ("encodings", 7, &[]),
    ("extern_first", 5, &[]),
    ("extern_fragment", 15, &[]),
    ("extern_missing", 1, &[7]),
    ("generate_camera", 5, &[]),
    ("generate_faces", 1, &[]),
    ("generate_local", 3, &[]),
    ("geo_coordinate", 1, &[7, 7]),
    ("hatch_alone", 3, &[]),
    ("hatch_sphere", 3, &[9]),
    ("hatch_styles", 6, &[]),
    ("inline_compressed", 1, &[]),
    ("layers", 3, &[8]),
    ("layers_order", 2, &[8]),
    ("left_out", 1, &[7, 8, 8, 9]),
    ("line_color_short", 1, &[7]),
    ("line_colors", 1, &[]),
    ("line_depth", 2, &[]),
    ("line_not_applied", 2, &[8]),
    ("line_types", 5, &[]),
    ("line_widths", 5, &[]),
    ("lod_distances", 3, &[]),
    ("lod_few_levels", 1, &[]),
    ("lod_scaled", 1, &[]),
    ("multi_coordinates", 2, &[]),
    ("multi_modes", 9, &[]),
    ("multi_modulate", 3, &[]),
    ("multi_nine", 1, &[7]),
    ("multi_sources", 5, &[]),
    ("multi_sphere", 1, &[]),
    ("multi_transforms", 2, &[]),
    ("no_heights", 1, &[7]),
    ("normal_interpolator", 1, &[]),
    ("outside", 1, &[7, 8]),
    ("physical_grid", 15, &[]),
    ("physical_texture", 2, &[]),
    ("proto_animated", 2, &[]),
    ("proto_children", 3, &[]),
    ("proto_def_use", 6, &[]),
    ("proto_defaults", 1, &[]),
    ("proto_geometry", 2, &[]),
    ("proto_image", 2, &[]),
    ("proto_inner_declare", 6, &[]),
    ("proto_light", 1, &[]),
    ("proto_material", 2, &[]),
    ("proto_missing", 1, &[7]),
    ("proto_nested", 3, &[]),
    ("proto_nodes", 3, &[]),
    ("proto_routes", 2, &[]),
    ("proto_text", 2, &[]),
    ("proto_unknown_first", 1, &[7]),
    ("proto_values", 3, &[]),
    ("quads", 3, &[]),
    ("sky_animated", 1, &[]),
    ("sky_gap", 1, &[]),
    ("sky_gradient", 1, &[]),
    ("sky_ground", 1, &[]),
    ("sky_ortho", 1, &[]),
    ("sky_picture_alpha", 1, &[]),
    ("sky_pictures", 1, &[]),
    ("sky_pictures_up", 0, &[]),
    ("sky_rings", 0, &[]),
    ("sky_turned", 1, &[]),
    ("stray_text", 1, &[7, 8, 9]),
    ("strip_count", 1, &[]),
    ("surface_shader", 2, &[15]),
    ("texcoord_short", 1, &[7]),
    ("text_styles", 6, &[]),
    ("unit_degrees", 2, &[]),
    ("unit_inline", 2, &[]),
    ("unit_main", 2, &[]),
    ("unknown_group", 2, &[7]),
    ("viewport_children", 1, &[]),
];

/// Returns the path of a scene.
fn file(name: &str) -> String {
    let ending = if name == "compressed" { "x3dz" } else { "x3d" };
    format!("made/{name}.{ending}")
}

/// Returns the times at which a scene is drawn: for animated scenes, later ones too.
fn times(name: &str) -> &'static [f64] {
    match name {
        "proto_routes" | "proto_animated" | "sky_animated" | "normal_interpolator" | "encodings" => {
            &[0.0, 1.0]
        }
        _ => &[0.0],
    }
}

#[test]
fn the_list_is_of_all_made_scenes() {
    let names = std::fs::read_dir(data().join("made")).unwrap().map(|e| e.unwrap().path());
    let names = names.filter(|p| p.is_file() && p.extension().is_some_and(|e| e == "x3d" || e == "x3dz"));
    let found: BTreeSet<String> =
        names.map(|p| p.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    assert_eq!(found, MADE.iter().map(|(name, ..)| name.to_string()).collect());
}

#[test]
fn every_made_scene_is_read_as_it_is_said() {
    let mut wrong = Vec::new();
    for (name, objects, lines) in MADE {
        let document = load(&file(name)).unwrap_or_else(|e| panic!("{e}"));
        let scene = document.at(0.0);
        check(&scene);
        let found: Vec<u32> = document.warnings().iter().map(|w| w.place.line).collect();
        if (scene.objects.len(), &found[..]) != (*objects, *lines) {
            wrong.push(format!(
                "(\"{name}\", {}, &{found:?}), {:#?}",
                scene.objects.len(),
                warnings(&document)
            ));
        }
        assert_eq!(document.is_animated(), times(name).len() > 1, "{name}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_made_scene_looks_as_it_did() {
    let mut failures = Vec::new();
    for (name, ..) in MADE {
        let document = load(&file(name)).unwrap();
        for time in times(name) {
            let memory = draw(&document.at(*time), 120, 90);
            let picture = data().join("made/golden").join(format!("{name}-at-{time}.png"));
            failures.extend(check_picture(&memory, picture, Tolerance::EXACT, Mode::from_env()).err());
        }
    }
    let failures: Vec<String> = failures.iter().map(ToString::to_string).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

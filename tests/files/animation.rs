//! Animated values at given times, worked out by hand.

use crate::support::{check, close, document, load, parse, warnings};
use fbptr::load::x3d::X3dDocument;
use fbptr::scene::LightKind;
use glam::DVec3;
use std::f64::consts::PI;

/// Returns a box moved by an interpolator with a clock of 4 seconds.
fn moved(clock: &str, interpolator: &str, field: &str) -> X3dDocument {
    document(&format!(
        "<Transform DEF='T'><Shape><Appearance><Material DEF='M'/></Appearance><Box/></Shape></Transform><TimeSensor DEF='C' \
         cycleInterval='4' {clock}/>{interpolator}<ROUTE fromNode='C' fromField='fraction_changed' toNode='I' \
         toField='set_fraction'/><ROUTE fromNode='I' fromField='value_changed' toNode='T' toField='{field}'/>"
    ))
}

fn place(document: &X3dDocument, time: f64) -> DVec3 {
    let scene = document.at(time);
    check(&scene);
    scene.objects[0].model.w_axis.truncate()
}

const PATH: &str = "<PositionInterpolator DEF='I' key='0 0.5 1' keyValue='0 0 0  10 0 0  10 4 0'/>";

#[test]
fn a_position_runs_through_its_keys() {
    let document = moved("loop='true'", PATH, "translation");
    assert!(document.is_animated());
    for (time, expected) in [
        (-1.0, [0.0, 0.0]),
        (0.0, [0.0, 0.0]),
        (1.0, [5.0, 0.0]),
        (2.0, [10.0, 0.0]),
        (3.0, [10.0, 2.0]),
        (4.0, [10.0, 4.0]),
        (5.0, [5.0, 0.0]),
        (4001.0, [5.0, 0.0]),
        (f64::NAN, [0.0, 0.0]),
        (f64::INFINITY, [0.0, 0.0]),
    ] {
        assert_eq!(place(&document, time).to_array()[..2], expected, "at {time}");
    }
    for field in ["set_translation", "translation_changed"] {
        // The prefix `set_` names an input; the suffix `_changed` names an output, and a route to
        // it only gives a warning.
        let text = format!(
            "<Scene><Transform DEF='T'/><PositionInterpolator DEF='I' key='0' keyValue='1 1 1'/><ROUTE fromNode='I' \
             fromField='value_changed' toNode='T' toField='{field}'/></Scene>"
        );
        assert_eq!(
            parse(&text).unwrap().warnings().len(),
            usize::from(field != "set_translation"),
            "{field}"
        );
    }
}

#[test]
fn normals_move_on_the_unit_sphere() {
    let document = document(
        "<Shape><Appearance><Material/></Appearance><IndexedFaceSet coordIndex='0 1 2'><Coordinate point='0 0 0 1 0 0 0 1 0'/>\
         <Normal DEF='N' vector='0 0 1 0 0 1 0 0 1'/></IndexedFaceSet></Shape><TimeSensor DEF='C' cycleInterval='3' loop='true'/>\
         <NormalInterpolator DEF='I' key='0 1' keyValue='0 0 2 0 0 1 0 0 1 0 5 0 0 0 1 1 0 0'/>\
         <ROUTE fromNode='C' fromField='fraction_changed' toNode='I' toField='set_fraction'/>\
         <ROUTE fromNode='I' fromField='value_changed' toNode='N' toField='vector'/>",
    );
    let third = document.at(1.0).objects[0].geometry.mesh.normals.clone();
    let (sin, cos) = (0.5, 0.75_f64.sqrt());
    close(third[0], DVec3::new(0.0, sin, cos));
    close(third[1], DVec3::Z);
    close(third[2], DVec3::new(sin, 0.0, cos));
}

#[test]
fn clocks_start_stop_and_stay() {
    let at = |clock: &str, time: f64| place(&moved(clock, PATH, "translation"), time).x;
    assert_eq!(at("", 1.0), 5.0);
    assert_eq!(at("", 100.0), 10.0, "without loop it ends at fraction 1");
    assert_eq!(at("enabled='false' loop='true'", 1.0), 0.0);
    assert_eq!(at("startTime='10' loop='true'", 9.0), 0.0);
    assert_eq!(at("startTime='10' loop='true'", 11.0), 5.0);
    assert_eq!(at("stopTime='1' loop='true'", 3.0), 5.0);
    assert_eq!(at("pauseTime='1' loop='true'", 3.0), 5.0);
    assert_eq!(at("pauseTime='1' resumeTime='2' loop='true'", 2.5), 7.5);
}

#[test]
fn rotations_colours_scalars_and_splines_interpolate_in_their_own_ways() {
    let turn = "<OrientationInterpolator DEF='I' key='0 1' keyValue='0 0 1 0  0 0 1 3.141592653589793'/>";
    let model = moved("loop='true'", turn, "set_rotation").at(1.0).objects[0].model;
    close(model.x_axis.truncate(), DVec3::new((PI / 4.0).cos(), (PI / 4.0).sin(), 0.0));
    let spline = "<SplinePositionInterpolator DEF='I' key='0 0.5 1' keyValue='0 0 0  1 0 0  1 1 0'/>";
    // Half way in the first piece: (v0 + v1)/2 - T1/8 with T1 = (v2 - v0)/2.
    close(place(&moved("", spline, "translation"), 1.0), DVec3::new(0.4375, -0.0625, 0.0));
    let hue = document(
        "<Shape><Appearance><Material DEF='M'/></Appearance><Box/></Shape><TimeSensor DEF='C' loop='true'/><ColorInterpolator DEF='I' \
         key='0 1' keyValue='1 0 0 0 1 0'/><ScalarInterpolator DEF='S' key='0 1' keyValue='0 1'/><PointLight DEF='L'/><ROUTE \
         fromNode='C' fromField='fraction_changed' toNode='S' toField='set_fraction'/><ROUTE fromNode='S' fromField='value_changed' \
         toNode='I' toField='set_fraction'/><ROUTE fromNode='I' fromField='value_changed' toNode='M' toField='diffuseColor'/><ROUTE \
         fromNode='M' fromField='diffuseColor_changed' toNode='L' toField='set_color'/><ROUTE fromNode='S' fromField='value_changed' \
         toNode='M' toField='transparency'/>",
    );
    let scene = hue.at(0.5);
    close(scene.objects[0].material.kd, DVec3::new(1.0, 1.0, 0.0));
    close(scene.lights[0].color, DVec3::new(1.0, 1.0, 0.0));
    assert_eq!(scene.objects[0].material.transparency, 0.5);
    close(hue.at(0.25).objects[0].material.kd, DVec3::new(1.0, 0.5, 0.0));
}

#[test]
fn viewpoints_sizes_and_switches_move_too() {
    let document = document(
        "<Viewpoint DEF='V'/><Transform DEF='T'><Shape><Sphere DEF='S'/></Shape></Transform><TimeSensor DEF='C' loop='true'/>\
         <PositionInterpolator DEF='I' key='0 1' keyValue='0 0 10 0 0 20'/><ScalarInterpolator DEF='R' key='0 1' keyValue='1 3'/><ROUTE \
         fromNode='C' fromField='fraction_changed' toNode='I' toField='set_fraction'/><ROUTE fromNode='C' fromField='fraction_changed' \
         toNode='R' toField='set_fraction'/><ROUTE fromNode='I' fromField='value_changed' toNode='V' toField='position'/><ROUTE \
         fromNode='R' fromField='value_changed' toNode='S' toField='radius'/>",
    );
    let scene = document.at(0.5);
    assert_eq!(scene.camera.unwrap().look_at.eye, DVec3::Z * 15.0);
    assert_eq!(scene.objects[0].model.x_axis.x, 2.0);
    assert!(matches!(scene.lights[0].kind, LightKind::Directional { .. }));
}

#[test]
fn coordinates_move_and_normals_follow() {
    let document = document(
        "<Shape><TriangleSet solid='false'><Coordinate DEF='P' point='0 0 0 1 0 0 0 1 0'/></TriangleSet></Shape><TimeSensor DEF='C' \
         loop='true'/><CoordinateInterpolator DEF='I' key='0 1' keyValue='0 0 0 1 0 0 0 1 0  0 0 0 1 0 0 0 0 1'/><ROUTE fromNode='C' \
         fromField='fraction_changed' toNode='I' toField='set_fraction'/><ROUTE fromNode='I' fromField='value_changed' toNode='P' \
         toField='set_point'/>",
    );
    let at = |time: f64| {
        let mesh = document.at(time).objects[0].geometry.mesh.clone();
        (mesh.positions[2], mesh.normals[mesh.corners[0].normal as usize])
    };
    assert_eq!(at(0.0), (DVec3::Y, DVec3::Z));
    assert_eq!(at(0.5).0, DVec3::new(0.0, 0.5, 0.5));
    assert_eq!(at(1.0), (DVec3::Z, DVec3::NEG_Y));
    // The file's own clock: a sensor that starts in 2025 has not begun.
    let file = load("x_ite/Interpolation/CoordinateInterpolator.x3d").unwrap();
    assert_eq!(file.at(3.0).objects[0].geometry.mesh.positions[0], DVec3::new(-0.6990001, 0.3009999, 0.0));
    let begun = file.at(1758751771.312 + 0.5).objects[0].geometry.mesh.positions[0];
    assert!((begun - DVec3::new(0.5, 0.5, 0.0)).length() < 1e-6, "{begun}");
}

#[test]
fn the_demos_are_where_their_files_say() {
    let color = load("x3d-cpp/demos/anim_color.x3d").unwrap();
    // An eighth of the cycle: key 0.125 of 0.333 between red and green, a hue of 0.3754 of the two
    // sixths.
    let expected = DVec3::new(1.0, 2.0 * 0.125 / 0.333, 0.0);
    assert!((color.at(0.5).objects[0].material.kd - expected).length() < 1e-12);
    let position = load("x3d-cpp/demos/anim_position.x3d").unwrap();
    close(place(&position, 0.5), DVec3::new(2.0, 2.0, 0.0));
    close(place(&position, 4.0), DVec3::new(4.0, 0.0, 0.0));
    let orientation = load("x3d-cpp/demos/anim_orientation.x3d").unwrap();
    let y = orientation.at(0.5).objects[0].model.y_axis.truncate();
    let half_of_the_second_key = 15_708e-4 / 2.0;
    assert!((y - DVec3::Y.rotate_x(half_of_the_second_key) * 1.5).length() < 1e-12);
    let inlined = load("x3d-cpp/inline/animated_parent.x3d").unwrap();
    close(place(&inlined, 1.0), DVec3::X * 2.5);
    let dvd = load("x3d-cpp/demos/anim_dvd.x3d").unwrap();
    close(place(&dvd, 0.0), DVec3::new(-6.7610, 3.6384, 0.0));
    assert_eq!(place(&dvd, 1.2345), place(&load("x3d-cpp/demos/anim_dvd.x3d").unwrap(), 1.2345));
}

#[test]
fn routes_that_join_nothing_are_named_with_their_line() {
    let text = "<Scene>\n<TimeSensor DEF='C'/>\n<Transform DEF='T'/>\n<Foo DEF='F'/>\n\
        <ROUTE fromNode='C' fromField='fraction_changed' toNode='T' toField='translation'/>\n\
        <ROUTE fromNode='X' fromField='a' toNode='T' toField='translation'/>\n\
        <ROUTE fromNode='C' fromField='nothing' toNode='T' toField='translation'/>\n\
        <ROUTE fromNode='F' fromField='a' toNode='T' toField='translation'/>\n</Scene>";
    let found = warnings(&parse(text).unwrap());
    let starts = [
        "t.x3d:4:1: warning: node <Foo>",
        "t.x3d:5:1: warning: ROUTE from",
        "t.x3d:6:1: warning: ROUTE names \"X\"",
        "t.x3d:7:1: warning: ROUTE names \"nothing\"",
    ];
    assert_eq!(found.len(), starts.len(), "{found:#?}");
    for (warning, start) in found.iter().zip(starts) {
        assert!(warning.starts_with(start), "{warning}");
    }
}

#[test]
fn routes_in_a_circle_end() {
    let document = document(
        "<Transform DEF='A'/><Transform DEF='B'><Shape><Box/></Shape></Transform><TimeSensor DEF='C' loop='true'/><PositionInterpolator \
         DEF='I' key='0 1' keyValue='0 0 0 1 0 0'/><ROUTE fromNode='C' fromField='fraction_changed' toNode='I' toField='set_fraction'/>\
         <ROUTE fromNode='I' fromField='value_changed' toNode='A' toField='translation'/><ROUTE fromNode='A' \
         fromField='translation_changed' toNode='B' toField='translation'/><ROUTE fromNode='B' fromField='translation' toNode='A' \
         toField='set_translation'/>",
    );
    assert_eq!(place(&document, 0.5).x, 0.5);
}

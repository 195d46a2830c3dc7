//! Grouping nodes beyond Group and Transform: which of their children are visible, and from which
//! camera.

use crate::support::{close, document, parse, scene, warnings};
use fbptr::scene::{Camera, LookAt, Scene};
use glam::DVec3;

/// Returns a point that can be recognized by its position.
fn point(x: u32) -> String {
    format!("<Shape><PointSet><Coordinate point='{x} 0 0'/></PointSet></Shape>")
}

/// Returns the points of a scene, by their x in their own coordinates.
fn seen(scene: &Scene) -> Vec<f64> {
    scene.objects.iter().map(|o| o.geometry.mesh.positions[0].x).collect()
}

fn from(eye: DVec3) -> Camera {
    let up = if eye.x == 0.0 && eye.z == 0.0 { DVec3::NEG_Z } else { DVec3::Y };
    Camera { look_at: LookAt { eye, reference: DVec3::ZERO, up }, ..Camera::default() }
}

#[test]
fn children_are_seen_and_a_proxy_never_is() {
    for node in ["Collision", "Anchor url='a.x3d'", "LOD", "Billboard", "Viewport"] {
        let name = node.split(' ').next().unwrap();
        assert_eq!(seen(&scene(&format!("<{node}>{}</{name}>", point(1)))), [1.0], "{node}");
        assert_eq!(
            seen(&scene(&format!("<{node} visible='false'>{}</{name}>", point(1)))),
            [0.0; 0],
            "{node}"
        );
    }
    let proxy = "<Group containerField='proxy'><Shape><Box/></Shape></Group>";
    assert_eq!(seen(&scene(&format!("<Collision enabled='false'>{proxy}{}</Collision>", point(2)))), [2.0]);
}

#[test]
fn an_unknown_group_shows_the_children_that_stand_in_children() {
    let text = format!(
        "<Scene>\n<CADAssembly name='a'><CADPart translation='nonsense'>{}</CADPart><Shape containerField='other'><Box/></Shape>\
         <Material/></CADAssembly>\n<Sound><AudioClip/></Sound>\n<CADLayer DEF='L' visible='true false'>{}</CADLayer>\
         <Transform translation='0 5 0'><CADLayer USE='L'/></Transform></Scene>",
        point(1),
        point(2)
    );
    let document = parse(&text).unwrap();
    assert_eq!(seen(&document.at(0.0)), [1.0, 2.0, 2.0]);
    assert_eq!(document.at(0.0).objects[2].model.w_axis.y, 5.0);
    let expected = [
        "2:1: warning: node <CADAssembly> is not known: its children are shown without it",
        "2:23: warning: node <CADPart> is not known: its children are shown without it",
        "3:1: warning: node <Sound> is not known and was skipped",
        "4:1: warning: node <CADLayer> is not known: its children are shown without it",
    ];
    let expected = expected.map(|e| format!("t.x3d:{e}, here and wherever it comes again"));
    assert_eq!(warnings(&document), expected);
}

#[test]
fn faces_of_cad_and_skeletons_of_hanim_are_shown_once() {
    let shape =
        |field: &str, x: u32| point(x).replacen("<Shape", &format!("<Shape containerField='{field}'"), 1);
    for (nodes, expected) in [
        // A part is defined once and used again elsewhere.
        (
            format!(
                "<CADAssembly><CADPart DEF='P'><CADFace>{}</CADFace><CADFace>{}</CADFace></CADPart></CADAssembly>\
                 <CADAssembly><CADPart USE='P'/></CADAssembly>",
                shape("shape", 1),
                point(2)
            ),
            vec![1.0, 2.0, 1.0, 2.0],
        ),
        (
            format!(
                "<CADFace><Transform containerField='shape'>{}</Transform></CADFace><CADFace><Foo>{}</Foo></CADFace>",
                point(1),
                shape("other", 2)
            ),
            vec![1.0],
        ),
        // The lists of a humanoid use nodes of its skeleton, by whatever name.
        (
            format!(
                "<HAnimHumanoid><HAnimJoint DEF='J' containerField='skeleton'><HAnimSegment DEF='S'>{}\
                 <HAnimSite DEF='E'>{}</HAnimSite></HAnimSegment><HAnimJoint DEF='K'><HAnimSegment>{}</HAnimSegment>\
                 </HAnimJoint></HAnimJoint>\
                 <HAnimJoint USE='J' containerField='joints'/><HAnimJoint USE='K' containerField='joints'/>\
                 <HAnimSegment USE='S' containerField='segments'/><HAnimSite USE='E' containerField='sites'/>\
                 <HAnimSite USE='E' containerField='viewpoints'/>\
                 <Coordinate DEF='C' containerField='skinCoord' point='4 0 0'/>\
                 <Shape containerField='skin'><PointSet><Coordinate USE='C'/></PointSet></Shape></HAnimHumanoid>",
                point(1),
                point(2),
                point(3)
            ),
            vec![1.0, 2.0, 3.0, 4.0],
        ),
        // Nothing of a list or of a proxy makes a group.
        (
            format!("<HAnimHumanoid><Group containerField='joints'>{}</Group></HAnimHumanoid>", point(1)),
            vec![],
        ),
        (format!("<Foo>{}</Foo>", shape("proxy", 1)), vec![]),
        (
            format!(
                "<Collision><CADPart containerField='proxy'><CADFace>{}</CADFace></CADPart>{}</Collision>",
                shape("shape", 1),
                point(2)
            ),
            vec![2.0],
        ),
        // In known nodes these fields have no meaning of their own.
        (format!("<Group>{}</Group>", shape("skin", 1)), vec![1.0]),
    ] {
        let document = parse(&format!("<Scene>{nodes}</Scene>")).unwrap();
        assert_eq!(seen(&document.at(0.0)), expected, "{nodes}");
    }
}

#[test]
fn names_for_other_files_are_said_once_a_file() {
    let export = "<EXPORT localDEF='A'/><IMPORT inlineDEF='I' importedDEF='B' AS='C'/>";
    let text = format!("<Scene>\n{}<Group>{export}</Group></Scene>", export.repeat(50));
    let expected = ["1: warning: <EXPORT>", "23: warning: <IMPORT>"].map(|begin| {
        format!("t.x3d:2:{begin} is left out, here and wherever it comes again: no node has a name in another file")
    });
    assert_eq!(warnings(&parse(&text).unwrap()), expected);
}

#[test]
fn scripts_sensors_and_particles_are_said_once_a_file() {
    let text = "<Scene><Script/><Group><Script/><TouchSensor/><ParticleSystem><PointEmitter/></ParticleSystem></Group>\
                <ProximitySensor/><TouchSensor/><ParticleSystem/><Script DEF='S'/>\
                <ROUTE fromNode='S' fromField='a' toNode='S' toField='b'/></Scene>";
    let found = warnings(&parse(text).unwrap());
    let names = ["Script", "TouchSensor", "ParticleSystem", "ProximitySensor"];
    assert_eq!(found.len(), names.len(), "{found:#?}");
    for name in names {
        let said = found.iter().filter(|w| w.contains(&format!("<{name}> is left out"))).count();
        assert_eq!(said, 1, "{name}");
    }
}

#[test]
fn a_lod_shows_the_level_of_the_viewers_distance() {
    let lod = format!(
        "<Viewpoint position='0 0 12'/><Transform scale='2 2 2'><LOD range='3 10' center='0 0 1'>{}{}{}</LOD></Transform>",
        point(1),
        point(2),
        point(3)
    );
    let document = document(&lod);
    assert!(document.depends_on_viewer());
    // From z, the centre is (z - 2) / 2 away in the LOD's own units.
    assert_eq!(seen(&document.at(0.0)), [2.0]);
    for (z, expected) in [(7.9, 1.0), (8.0, 2.0), (21.9, 2.0), (22.0, 3.0), (-5.0, 2.0)] {
        let camera = from(DVec3::Z * z);
        let scene = document.seen_at(0.0, Some(&camera));
        assert_eq!(seen(&scene), [expected], "{z}");
        assert_eq!(scene.camera.unwrap().look_at.eye, DVec3::Z * 12.0, "the scene's camera stays its own");
    }
    // Unknown nodes count as levels; a light belongs to its level; a viewpoint of any level can be
    // bound.
    let text = format!(
        "<Scene><NavigationInfo headlight='false'/><LOD range='5'><Foo/>{}</LOD><LOD range='5'><Group>\
         <DirectionalLight global='true'/></Group><Group><Viewpoint position='0 0 4'/></Group></LOD></Scene>",
        point(1)
    );
    let document = parse(&text).unwrap();
    let near = document.at(0.0);
    assert_eq!((seen(&near), near.lights.len()), (vec![], 1));
    assert_eq!(near.camera.unwrap().look_at.eye, DVec3::Z * 4.0);
    let far = document.seen_at(0.0, Some(&from(DVec3::Z * 9.0)));
    assert_eq!((seen(&far), far.lights.len()), (vec![1.0], 0));
}

#[test]
fn a_billboard_turns_its_children_to_the_viewer() {
    let text = |axis: &str| {
        format!(
            "<Transform translation='5 0 0'><Billboard {axis}><Transform translation='0 0 1'>{}</Transform></Billboard></Transform>",
            point(0)
        )
    };
    let place = |axis: &str, eye: DVec3| {
        document(&text(axis)).seen_at(0.0, Some(&from(eye))).objects[0].model.w_axis.truncate()
    };
    // One unit before the billboard, towards the viewer: rotated about y it stays level.
    close(place("", DVec3::new(15.0, 10.0, 0.0)), DVec3::new(6.0, 0.0, 0.0));
    close(place("", DVec3::new(5.0, 1.0, -3.0)), DVec3::new(5.0, 0.0, -1.0));
    close(place("axisOfRotation='0 0 0'", DVec3::new(8.0, 4.0, 0.0)), DVec3::new(5.6, 0.8, 0.0));
    close(place("axisOfRotation='1 0 0'", DVec3::new(99.0, 7.0, 0.0)), DVec3::new(5.0, 1.0, 0.0));
    // Without another camera it faces the scene's own, at 0 0 10.
    let own = document(&text("")).at(0.0).objects[0].model.w_axis.truncate();
    close(own, DVec3::new(5.0, 0.0, 0.0) + DVec3::new(-5.0, 0.0, 10.0).normalize());
}

#[test]
fn layers_are_shown_as_their_order_says() {
    let layers = |fields: &str| {
        let text = format!(
            "<Scene>{}<Viewpoint position='0 0 3'/><LayerSet {fields}><Layer>{}<Viewpoint position='0 0 4'/>\
             <Viewport containerField='viewport' clipBoundary='0 0.5 0 0.5'/></Layer><Foo/><LayoutLayer>{}</LayoutLayer></LayerSet></Scene>",
            point(1),
            point(2),
            point(3)
        );
        let scene = parse(&text).unwrap().at(0.0);
        (seen(&scene), scene.camera.unwrap().look_at.eye.z)
    };
    assert_eq!(layers(""), (vec![1.0], 3.0));
    assert_eq!(layers("order='0 1'"), (vec![1.0, 2.0], 3.0));
    assert_eq!(layers("order='1 3' activeLayer='1'"), (vec![2.0, 3.0], 4.0));
    assert_eq!(layers("order='3 0' activeLayer='3'"), (vec![1.0, 3.0], 3.0));
}

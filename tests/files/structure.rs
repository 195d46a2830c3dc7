//! Groups, transforms, names, lights, viewpoints, environment, materials.

use crate::support::{check, close, document, load, parse, scene, shape, warnings};
use fbptr::load::x3d;
use fbptr::scene::{Cull, FogKind, LightKind, LightingModel, Projection, Scene, Wrap};
use glam::{DMat4, DVec3};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
use std::sync::Arc;

const POINT: &str = "<Shape><PointSet><Coordinate point='2 0 0'/></PointSet></Shape>";
const BOX: &str = "<Shape><Appearance><Material/></Appearance><Box/></Shape>";

/// Returns the world position of the one point of each object.
fn points(scene: &Scene) -> Vec<DVec3> {
    scene.objects.iter().map(|o| o.model.transform_point3(o.geometry.mesh.positions[0])).collect()
}

#[test]
fn a_transform_scales_turns_and_moves_about_its_centre() {
    let at = |fields: &str| points(&scene(&format!("<Transform {fields}>{POINT}</Transform>")))[0];
    assert_eq!(at(""), DVec3::X * 2.0);
    assert_eq!(at("translation='1 2 3' scale='2 3 1'"), DVec3::new(5.0, 2.0, 3.0));
    let turned = "translation='1 2 3' rotation='0 0 1 1.5707963267948966' scale='2 3 1' center='1 0 0'";
    // (2,0,0) - C = (1,0,0), scaled (2,0,0), rotated (0,2,0), + C + T.
    close(at(turned), DVec3::new(2.0, 4.0, 3.0));
    // The scale's axes are rotated by a quarter about z: x is scaled by 3. Then (3,0,0), rotated
    // (0,3,0), + C + T.
    close(at(&format!("{turned} scaleOrientation='0 0 1 1.5707963267948966'")), DVec3::new(2.0, 5.0, 3.0));
    close(at("rotation='0 3 0 1.5707963267948966'"), DVec3::new(0.0, 0.0, -2.0));
    assert_eq!(at("rotation='0 0 0 1'"), DVec3::X * 2.0);
}

#[test]
fn groups_nest_and_use_shares() {
    let scene = scene(&format!(
        "<Transform translation='1 0 0'><Group DEF='G'><StaticGroup><Transform translation='0 1 0'>{POINT}</Transform></StaticGroup>\
         </Group></Transform><Transform scale='2 2 2'><Group USE='G'/></Transform>"
    ));
    assert_eq!(points(&scene), [DVec3::new(3.0, 1.0, 0.0), DVec3::new(4.0, 2.0, 0.0)]);
    assert!(Arc::ptr_eq(&scene.objects[0].geometry, &scene.objects[1].geometry));
    assert_eq!(scene.objects[0].name, "G");
}

#[test]
fn a_switch_shows_its_choice_and_visible_hides() {
    let count = |choice: &str| scene(&format!("<Switch {choice}>{POINT}{BOX}</Switch>")).objects.len();
    assert_eq!(["", "whichChoice='0'", "whichChoice='1'", "whichChoice='2'"].map(count), [0, 1, 1, 0]);
    // Unknown nodes count as children, statements and metadata do not.
    let odd = parse(
        "<Scene><Switch whichChoice='1'><MetadataSet/><ROUTE/><Foo/><Shape><Box/></Shape></Switch></Scene>",
    );
    assert_eq!(odd.unwrap().at(0.0).objects.len(), 1);
    assert_eq!(scene(&format!("<Group visible='false'>{BOX}</Group>{BOX}")).objects.len(), 1);
    assert_eq!(scene("<Shape visible='false'><Box/></Shape>").objects.len(), 0);
}

#[test]
fn solids_of_a_kind_share_a_mesh_and_size_is_in_the_matrix() {
    let scene =
        scene("<Shape><Box size='2 4 6'/></Shape><Shape><Box/></Shape><Shape><Sphere radius='3'/></Shape>");
    assert!(Arc::ptr_eq(&scene.objects[0].geometry, &scene.objects[1].geometry));
    assert_eq!(scene.objects[0].model.to_scale_rotation_translation().0, DVec3::new(1.0, 2.0, 3.0));
    assert_eq!(scene.objects[1].model, DMat4::IDENTITY);
    assert_eq!(scene.bounds(), Some((DVec3::splat(-3.0), DVec3::splat(3.0))));
}

#[test]
fn a_directional_light_reaches_its_group_and_others_reach_all() {
    let off = "<NavigationInfo headlight='false'/>";
    let s = scene(&format!(
        "{off}<Group>{BOX}<DirectionalLight/><Group>{BOX}</Group></Group>{BOX}<PointLight/><Group><SpotLight global='false'/>{BOX}\
         </Group><DirectionalLight on='false'/>"
    ));
    assert_eq!(s.lights.len(), 3);
    let kinds: Vec<bool> = s.lights.iter().map(|l| matches!(l.kind, LightKind::Directional { .. })).collect();
    // The group's own lights come before those of nested groups; the scene's come first of all.
    assert_eq!(kinds, [false, true, false]);
    let lights: Vec<Option<Vec<u32>>> = s.objects.iter().map(|o| o.lights.clone()).collect();
    assert_eq!(lights, [Some(vec![0, 1]), Some(vec![0, 1]), Some(vec![0]), Some(vec![0, 2])]);
    let all = scene(&format!("{BOX}<DirectionalLight/><DirectionalLight global='true'/>"));
    assert!(all.objects[0].lights.is_none(), "all of them");
}

#[test]
fn lights_carry_intensity_ambient_and_scale() {
    let s = scene(
        "<NavigationInfo headlight='false'/><Transform translation='0 0 1' scale='2 2 2' rotation='0 1 0 1.5707963267948966'>\
         <SpotLight color='1 0.5 0' intensity='0.5' ambientIntensity='0.2' location='1 0 0' direction='0 0 -2' radius='3' \
         attenuation='1 2 4' beamWidth='2' cutOffAngle='1'/></Transform><PointLight/>",
    );
    let light = &s.lights[1];
    assert_eq!((light.color, light.ambient), (DVec3::new(0.5, 0.25, 0.0), DVec3::new(0.2, 0.1, 0.0)));
    assert!(light.clamp_attenuation);
    match light.kind {
        LightKind::X3dSpot { position, direction, beam_width_rad, cut_off_rad, attenuation, radius } => {
            close(position, DVec3::new(0.0, 0.0, -1.0));
            close(direction, DVec3::NEG_X);
            assert_eq!((beam_width_rad, cut_off_rad), (1.0, 1.0), "a beam is no wider than its cone");
            // A world distance of 2 is 1 in the light's own units.
            assert!((radius - 6.0).abs() < 1e-12);
            assert!(
                (attenuation.c, attenuation.l - 1.0 < 1e-12, attenuation.q - 1.0 < 1e-12)
                    == (1.0, true, true)
            );
        }
        other => panic!("{other:?}"),
    }
    match s.lights[0].kind {
        LightKind::Point { position, attenuation, radius } => {
            assert_eq!((position, radius, attenuation.c, attenuation.l), (DVec3::ZERO, 100.0, 1.0, 0.0));
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_headlight_shines_along_the_view_unless_it_is_off() {
    let direction = |nodes: &str| {
        let s = scene(&format!("{nodes}{BOX}"));
        s.lights.last().map(|l| match l.kind {
            LightKind::Directional { direction } => direction.normalize(),
            other => panic!("{other:?}"),
        })
    };
    assert_eq!(direction(""), Some(DVec3::NEG_Z));
    assert_eq!(direction("<NavigationInfo/>"), Some(DVec3::NEG_Z));
    assert_eq!(direction("<NavigationInfo headlight='false'/>"), None);
    close(direction("<Viewpoint orientation='0 1 0 1.5707963267948966'/>").unwrap(), DVec3::NEG_X);
    // The first one counts, and one of the viewpoint takes precedence.
    assert_eq!(direction("<NavigationInfo headlight='false'/><NavigationInfo/>"), None);
    let own = "<NavigationInfo/><Viewpoint><NavigationInfo headlight='false' containerField='navigationInfo'/></Viewpoint>";
    assert_eq!(direction(own), None);
}

#[test]
fn the_first_viewpoint_is_the_camera() {
    let camera = |nodes: &str| scene(nodes).camera.unwrap();
    let first = camera("<Viewpoint position='1 2 3' fieldOfView='1'/><Viewpoint/>");
    assert_eq!((first.look_at.eye, first.look_at.up), (DVec3::new(1.0, 2.0, 3.0), DVec3::Y));
    let perspective =
        |fov_rad| Projection::Perspective { fov_rad, near: 0.01, far: 1000.0, on_smaller_side: true };
    assert_eq!(first.projection, perspective(1.0));
    let default = camera(BOX);
    assert_eq!((default.look_at.eye, default.projection), (DVec3::Z * 10.0, perspective(FRAC_PI_4)));
    assert!(document("<Group><Viewpoint/></Group>").has_viewpoint());
    assert!(!document("<Switch><Viewpoint/></Switch>").has_viewpoint());
    let moved = camera(
        "<Transform translation='0 5 0' rotation='0 1 0 1.5707963267948966' scale='2 2 2'><Viewpoint orientation='0 0 1 1.5707963267948966'/>\
         </Transform>",
    );
    close(moved.look_at.eye, DVec3::new(20.0, 5.0, 0.0));
    close((moved.look_at.reference - moved.look_at.eye).normalize(), DVec3::NEG_X);
    close(moved.look_at.up, DVec3::Z);
    let range = camera("<Viewpoint nearDistance='1' farDistance='5'/>").projection;
    assert!(matches!(range, Projection::Perspective { near: 1.0, far: 5.0, .. }), "{range:?}");
}

#[test]
fn an_ortho_viewpoint_has_a_window_and_view_all_shows_all() {
    let camera = |nodes: &str| scene(nodes).camera.unwrap();
    let ortho = camera("<OrthoViewpoint fieldOfView='-1 -2 3 4'/>");
    assert_eq!(ortho.look_at.eye, DVec3::Z * 10.0);
    assert_eq!(
        ortho.projection,
        Projection::OrthoContain { window: [-1.0, 3.0, -2.0, 4.0], near: 0.01, far: 1000.0 }
    );
    let far_box = format!("<Transform translation='500 0 -9000'>{BOX}</Transform>{BOX}");
    for node in ["Viewpoint", "OrthoViewpoint"] {
        let s = scene(&format!("<{node} viewAll='true'/>{far_box}"));
        let m = s.camera.unwrap().matrices(1.5).unwrap();
        for o in &s.objects {
            let clip = m.projection * m.view * o.model.w_axis;
            let ndc = clip / clip.w;
            assert!(ndc.x.abs() < 1.0 && ndc.y.abs() < 1.0 && ndc.z > 0.0 && ndc.z < 1.0, "{node}: {ndc}");
        }
    }
}

#[test]
fn background_and_fog_are_the_first_ones() {
    let s =
        scene("<Background skyColor='0.1 0.2 0.3'/><Background/><Fog visibilityRange='3' color='1 0 0'/>");
    assert_eq!(s.background.color, Some(DVec3::new(0.1, 0.2, 0.3)));
    let fog = s.fog.unwrap();
    assert_eq!((fog.kind, fog.visibility_range, fog.color), (FogKind::Linear, 3.0, DVec3::X));
    assert!(scene(BOX).background.color.is_none());
    assert_eq!(scene("<Background/>").background.color, Some(DVec3::ZERO));
    assert!(scene("<Fog/>").fog.is_none(), "a range of 0 is no fog");
    let scaled =
        scene("<Transform scale='2 2 2'><Fog fogType='EXPONENTIAL' visibilityRange='3'/></Transform>")
            .fog
            .unwrap();
    assert!(scaled.kind == FogKind::Exponential && (scaled.visibility_range - 6.0).abs() < 1e-12);
}

#[test]
fn what_the_bound_viewpoint_binds_by_a_route_counts() {
    let s = scene(
        "<Viewpoint DEF='V'/><Fog visibilityRange='1'/><Fog DEF='F' visibilityRange='2'/>\
         <ROUTE fromNode='V' fromField='isBound' toNode='F' toField='set_bind'/>",
    );
    assert_eq!(s.fog.unwrap().visibility_range, 2.0);
}

#[test]
fn materials_are_the_standards_equation() {
    let of = |appearance: &str| shape(&format!("<Appearance>{appearance}</Appearance>"), "<Box/>");
    let default = of("<Material/>").material;
    assert_eq!((default.kd, default.ks, default.n), (DVec3::splat(0.8), DVec3::ZERO, 25.6));
    close(default.ka, DVec3::splat(0.16));
    assert_eq!(
        (default.model, default.transparency, default.emissive),
        (LightingModel::Blinn, 0.0, DVec3::ZERO)
    );
    let unlit = of("<UnlitMaterial emissiveColor='0 1 0' transparency='0.25'/>").material;
    assert_eq!((unlit.model, unlit.emissive, unlit.transparency), (LightingModel::Unlit, DVec3::Y, 0.25));
    for none in [of(""), shape("", "<Box/>")] {
        assert_eq!((none.material.model, none.material.emissive), (LightingModel::Unlit, DVec3::ONE));
        assert!(none.cull == Cull::Back && !none.two_sided_lighting);
    }
    let colors =
        "separateBackColor='true' diffuseColor='1 0 0' backDiffuseColor='0 0 1' backTransparency='0.5'";
    let both = shape(&format!("<Appearance><TwoSidedMaterial {colors}/></Appearance>"), "<Rectangle2D/>");
    let back = both.back_material.unwrap();
    assert_eq!((both.material.kd, back.kd, back.transparency), (DVec3::X, DVec3::Z, 0.5));
    assert!(both.cull == Cull::None && both.two_sided_lighting);
    assert!(of("<TwoSidedMaterial backDiffuseColor='0 0 1'/>").back_material.is_none());
    let back = of("<Material/><UnlitMaterial containerField='backMaterial'/>").back_material.unwrap();
    assert_eq!(back.model, LightingModel::Unlit);
    let physical = parse(
        "<Scene><Shape><Appearance><PhysicalMaterial baseColor='0 1 0'/></Appearance><Box/></Shape></Scene>",
    );
    let physical = physical.unwrap();
    assert_eq!(warnings(&physical).len(), 0, "{:?}", physical.warnings());
    // A metal of the largest roughness: half its colour, and no reflection.
    let metal = &physical.at(0.0).objects[0].material;
    assert_eq!((metal.kd, metal.ks, metal.n), (DVec3::Y / 2.0, DVec3::ZERO, 0.0));
}

#[test]
fn a_surface_shader_takes_the_place_of_the_material() {
    let factors = "diffuseFactor='1 0 0' ambientFactor='0.1 0.2 0.3' specularFactor='0 1 0' \
                   shininessFactor='0.5' emissiveFactor='0 0 1' alphaFactor='0.75'";
    let shader = format!("<CommonSurfaceShader {factors}/>");
    for appearance in [shader.clone(), format!("<Material diffuseColor='0 1 1'/>{shader}")] {
        let material = shape(&format!("<Appearance>{appearance}</Appearance>"), "<Box/>").material;
        assert_eq!((material.kd, material.ks, material.emissive), (DVec3::X, DVec3::Y, DVec3::Z));
        assert_eq!((material.n, material.transparency, material.model), (64.0, 0.25, LightingModel::Blinn));
        assert!((material.ka - DVec3::X * 0.2).length() < 1e-12, "the mean of the ambient factor");
    }
    let picture = |field: &str| format!("<PixelTexture containerField='{field}' image='1 1 1 0'/>");
    let [drawn, not] = ["diffuseTexture", "specularTexture"].map(picture);
    let textured = parse(&format!(
        "<Scene><Shape><Appearance><CommonSurfaceShader>{not}{drawn}</CommonSurfaceShader></Appearance><Box/></Shape></Scene>"
    ));
    let textured = textured.unwrap();
    assert!(textured.at(0.0).objects[0].texture.is_some());
    let found = warnings(&textured);
    assert!(found.len() == 1 && found[0].ends_with("is drawn without its specularTexture"), "{found:?}");
}

#[test]
fn textures_come_from_files_data_and_pixels() {
    let pixel = "<PixelTexture image='1 2 3 0xff0000 0x0000ff' repeatS='false'/>";
    let object = shape(&format!("<Appearance>{pixel}</Appearance>"), "<Box/>");
    let (texture, rules) = object.texture.unwrap();
    assert_eq!(texture.bytes(), [0, 0, 255, 255, 255, 0, 0, 255]);
    assert_eq!((rules.wrap_s, rules.wrap_t), (Wrap::Clamp, Wrap::Repeat));
    assert!(shape(&format!("<Appearance>{pixel}</Appearance>"), "<Circle2D/>").texture.is_none());
    let own = "<Appearance><Material><PixelTexture image='1 1 1 9' containerField='diffuseTexture'/></Material></Appearance>";
    assert_eq!(shape(own, "<Box/>").texture.unwrap().0.bytes()[0], 9);
    // A file beside the scene, in a folder, and by a data URI; the first URL that yields a picture
    // counts.
    let png = std::fs::read(crate::support::data().join("x3d-cpp/checker.png")).unwrap();
    let text = "<Scene><Shape><Appearance><ImageTexture url='\"http://x/a.png\" \"../b.png\" \"sub/./c%20d.png\"'/></Appearance><Box/>\
                </Shape></Scene>";
    let mut asked = Vec::new();
    let document = x3d::parse(text.as_bytes(), "dir/t.x3d", &mut |name| {
        asked.push(name.to_string());
        (name == "sub/c d.png").then(|| png.clone())
    });
    let scene = document.unwrap().at(0.0);
    assert_eq!(asked, ["sub/c%20d.png", "sub/c d.png"]);
    assert!(scene.objects[0].texture.is_some());
    check(&scene);
}

#[test]
fn inlines_bring_their_scene_and_their_names_stay_their_own() {
    let parent = load("x3d-cpp/inline/parent.x3d").unwrap().at(0.0);
    assert_eq!((parent.objects.len(), parent.objects[0].name.as_str()), (1, "Geo"));
    let files = |name: &str| match name {
        "a/b.x3d" => Some(
            "<Scene><Viewpoint position='7 7 7'/><DirectionalLight/><Inline url='c.x3d'/><Shape DEF='X'><Box/></Shape></Scene>",
        ),
        "a/c.x3d" => Some("<X3D><Scene><Shape DEF='X'><Sphere/></Shape></Scene></X3D>"),
        _ => None,
    };
    let text = "<Scene><NavigationInfo headlight='false'/><Group DEF='X'><Inline url='\"no.x3d\" \"a/b.x3d\"'/></Group><Inline \
                url='a/b.x3d'/><Shape><Cone/></Shape><Inline url='a/c.x3d' load='false'/></Scene>";
    let document = x3d::parse(text.as_bytes(), "t.x3d", &mut |n| files(n).map(|t| t.into())).unwrap();
    let scene = document.at(0.0);
    assert_eq!(scene.objects.len(), 5);
    assert_eq!(scene.camera.unwrap().look_at.eye, DVec3::Z * 10.0, "a viewpoint of an Inline is not bound");
    assert_eq!(scene.lights.len(), 2);
    assert_eq!(scene.objects[0].lights, Some(vec![0]), "an Inline's light reaches what is in it");
    assert_eq!(scene.objects[4].lights, Some(vec![]));
    assert_eq!(warnings(&document), [] as [&str; 0]);
    let missing = parse("<Scene>\n <Inline url='gone.x3d'/></Scene>").unwrap();
    let warning = &warnings(&missing)[0];
    assert!(warning.starts_with("t.x3d:2:2: warning: Inline [\"gone.x3d\"]"), "{warning}");
}

#[test]
fn definitions_in_metadata_can_be_used() {
    let text = "<X3D><head><meta name='a'/></head><Scene><WorldInfo><MetadataSet><Transform DEF='T' translation='1 0 0' \
                containerField='value'><Shape DEF='S'><Box/></Shape></Transform></MetadataSet></WorldInfo><Transform USE='T'/><Shape \
                USE='S'/></Scene></X3D>";
    let document = parse(text).unwrap();
    assert_eq!(warnings(&document), [] as [&str; 0]);
    let models: Vec<_> = document.at(0.0).objects.iter().map(|o| o.model.w_axis.x).collect();
    assert_eq!(models, [1.0, 0.0]);
}

#[test]
fn spot_defaults_are_the_standards() {
    let s = scene("<SpotLight/>");
    assert!(
        matches!(s.lights[0].kind, LightKind::X3dSpot { beam_width_rad, cut_off_rad, .. } if beam_width_rad == FRAC_PI_4 && cut_off_rad == FRAC_PI_2)
    );
}

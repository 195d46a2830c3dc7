//! Test of the schema against a second list of fields and defaults, written from the standard.

use super::schema;
use super::value::{self, Kind};
use std::collections::{BTreeMap, BTreeSet};

/// One node per line: its name, its container field, then field=default with `_` between numbers.
/// Source: ISO/IEC 19775-1, node interfaces. Fields that have no effect here are in the schema
/// only.
const DEFAULTS: &str = "
Scene -
Group children visible=true bboxCenter=0_0_0 bboxSize=-1_-1_-1
StaticGroup children visible=true
Transform children center=0_0_0 rotation=0_0_1_0 scale=1_1_1 scaleOrientation=0_0_1_0 translation=0_0_0 visible=true
Switch children whichChoice=-1 visible=true
Collision children enabled=true visible=true
LOD children center=0_0_0 forceTransitions=false range= visible=true
Billboard children axisOfRotation=0_1_0 visible=true
Anchor children description= parameter= url= visible=true
LayerSet children activeLayer=0 order=0
Layer layers visible=true
LayoutLayer layers visible=true
Viewport viewport clipBoundary=0_1_0_1 visible=true
Inline children load=true url=
Viewpoint children fieldOfView=0.7853981633974483 orientation=0_0_1_0 position=0_0_10 viewAll=false nearDistance=-1 farDistance=-1 centerOfRotation=0_0_0 jump=true
OrthoViewpoint children fieldOfView=-1_-1_1_1 orientation=0_0_1_0 position=0_0_10 viewAll=false
NavigationInfo children headlight=true visibilityLimit=0 speed=1 avatarSize=0.25_1.6_0.75
Background children skyColor=0_0_0 skyAngle= groundColor= groundAngle= transparency=0
Fog children color=1_1_1 fogType=LINEAR visibilityRange=0
Shape children visible=true
Appearance appearance
Material material ambientIntensity=0.2 diffuseColor=0.8_0.8_0.8 emissiveColor=0_0_0 shininess=0.2 specularColor=0_0_0 transparency=0
TwoSidedMaterial material ambientIntensity=0.2 backAmbientIntensity=0.2 backDiffuseColor=0.8_0.8_0.8 backEmissiveColor=0_0_0 backShininess=0.2 backSpecularColor=0_0_0 backTransparency=0 diffuseColor=0.8_0.8_0.8 emissiveColor=0_0_0 separateBackColor=false shininess=0.2 specularColor=0_0_0 transparency=0
UnlitMaterial material emissiveColor=1_1_1 transparency=0
PhysicalMaterial material baseColor=1_1_1 emissiveColor=0_0_0 metallic=1 roughness=1 transparency=0
CommonSurfaceShader shaders alphaFactor=1 ambientFactor=0.2_0.2_0.2 diffuseFactor=0.8_0.8_0.8 emissiveFactor=0_0_0 reflectionFactor=0_0_0 shininessFactor=0.2 specularFactor=0_0_0 transmissionFactor=0_0_0
Text geometry string= length= maxExtent=0 solid=false
FontStyle fontStyle horizontal=true leftToRight=true size=1 spacing=1 topToBottom=true style=PLAIN
ImageTexture texture url= repeatS=true repeatT=true
PixelTexture texture image=0_0_0 repeatS=true repeatT=true
MultiTexture texture alpha=1 color=1_1_1 function= mode= source=
MultiTextureTransform textureTransform
LineProperties lineProperties applied=true linetype=1 linewidthScaleFactor=0
PointProperties pointProperties attenuation=1_0_0 pointSizeMaxValue=1 pointSizeMinValue=1 pointSizeScaleFactor=1
FillProperties fillProperties filled=true hatchColor=1_1_1 hatchStyle=1 hatched=true
TextureTransform textureTransform center=0_0 rotation=0 scale=1_1 translation=0_0
TriangleSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true
TriangleStripSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true stripCount=
TriangleFanSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true fanCount=
IndexedTriangleSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true index=
IndexedTriangleStripSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true index=
IndexedTriangleFanSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true index=
QuadSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true
IndexedQuadSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true index=
IndexedFaceSet geometry ccw=true colorPerVertex=true normalPerVertex=true solid=true colorIndex= convex=true coordIndex= creaseAngle=0 normalIndex= texCoordIndex=
Box geometry size=2_2_2 solid=true
Sphere geometry radius=1 solid=true
Cone geometry bottom=true bottomRadius=1 height=2 side=true solid=true
Cylinder geometry bottom=true height=2 radius=1 side=true solid=true top=true
ElevationGrid geometry ccw=true colorPerVertex=true creaseAngle=0 height= normalPerVertex=true solid=true xDimension=0 xSpacing=1 zDimension=0 zSpacing=1
Extrusion geometry beginCap=true ccw=true convex=true creaseAngle=0 crossSection=1_1_1_-1_-1_-1_-1_1_1_1 endCap=true orientation=0_0_1_0 scale=1_1 solid=true spine=0_0_0_0_1_0
PointSet geometry
LineSet geometry vertexCount=
IndexedLineSet geometry colorIndex= colorPerVertex=true coordIndex=
Coordinate coord point=
CoordinateDouble coord point=
Color color color=
ColorRGBA color color=
Normal normal vector=
TextureCoordinate texCoord point=
TextureCoordinateGenerator texCoord mode=SPHERE parameter=
MultiTextureCoordinate texCoord
Polypoint2D geometry point=
Polyline2D geometry lineSegments=
Circle2D geometry radius=1
Arc2D geometry endAngle=1.5707963267948966 radius=1 startAngle=0
ArcClose2D geometry closureType=PIE endAngle=1.5707963267948966 radius=1 solid=false startAngle=0
Disk2D geometry innerRadius=0 outerRadius=1 solid=false
Rectangle2D geometry size=2_2 solid=false
TriangleSet2D geometry vertices= solid=false
DirectionalLight children ambientIntensity=0 color=1_1_1 direction=0_0_-1 global=false intensity=1 on=true
PointLight children ambientIntensity=0 attenuation=1_0_0 color=1_1_1 global=true intensity=1 location=0_0_0 on=true radius=100
SpotLight children ambientIntensity=0 attenuation=1_0_0 beamWidth=0.7853981633974483 color=1_1_1 cutOffAngle=1.5707963267948966 direction=0_0_-1 global=true intensity=1 location=0_0_0 on=true radius=100
TimeSensor children cycleInterval=1 enabled=true loop=false pauseTime=0 resumeTime=0 startTime=0 stopTime=0
ScalarInterpolator children key= keyValue=
PositionInterpolator children key= keyValue=
OrientationInterpolator children key= keyValue=
ColorInterpolator children key= keyValue=
CoordinateInterpolator children key= keyValue=
NormalInterpolator children key= keyValue=
SplinePositionInterpolator children key= keyValue= keyVelocity= closed=false normalizeVelocity=false
";

#[test]
fn the_table_has_the_standards_fields_and_defaults() {
    let mut seen = BTreeSet::new();
    for line in DEFAULTS.lines().filter(|l| !l.is_empty()) {
        let mut words = line.split(' ');
        let name = words.next().unwrap();
        let ty = schema::lookup(name).unwrap_or_else(|| panic!("no {name}"));
        assert!(seen.insert(name), "{name} twice");
        match words.next().unwrap() {
            "-" => {}
            container => assert_eq!(ty.container, container, "{name}"),
        }
        for word in words {
            let (field, default) = word.split_once('=').unwrap();
            let index = ty.field(field).unwrap_or_else(|| panic!("{name} has no {field}"));
            let expected = value::read(ty.fields[index].kind, &default.replace('_', " ")).unwrap();
            assert_eq!(ty.defaults[index], expected, "{name}.{field}");
        }
    }
    let table: BTreeSet<_> = schema::all().map(|ty| ty.name).collect();
    assert_eq!(table, seen, "nodes of the table and of this list");
}

/// Nodes of the Interchange profile: ISO/IEC 19775-1 annex B, the components of its table B.2 at
/// their levels.
const INTERCHANGE: [&str; 49] = [
    // Core 1, Time 1, Grouping 1, Shape 1, Lighting 1
    "MetadataBoolean",
    "MetadataDouble",
    "MetadataFloat",
    "MetadataInteger",
    "MetadataSet",
    "MetadataString",
    "WorldInfo",
    "TimeSensor",
    "Group",
    "Transform",
    "Appearance",
    "Material",
    "Shape",
    "DirectionalLight",
    // Rendering 3
    "Color",
    "ColorRGBA",
    "Coordinate",
    "IndexedLineSet",
    "IndexedTriangleFanSet",
    "IndexedTriangleSet",
    "IndexedTriangleStripSet",
    "LineSet",
    "Normal",
    "PointSet",
    "TriangleFanSet",
    "TriangleSet",
    "TriangleStripSet",
    // Geometry3D 2
    "Box",
    "Cone",
    "Cylinder",
    "IndexedFaceSet",
    "Sphere",
    // Texturing 2
    "ImageTexture",
    "MultiTexture",
    "MultiTextureCoordinate",
    "MultiTextureTransform",
    "PixelTexture",
    "TextureCoordinate",
    "TextureCoordinateGenerator",
    "TextureTransform",
    // Interpolation 2
    "ColorInterpolator",
    "CoordinateInterpolator",
    "NormalInterpolator",
    "OrientationInterpolator",
    "PositionInterpolator",
    "ScalarInterpolator",
    // Navigation 1, Environmental effects 1
    "NavigationInfo",
    "Viewpoint",
    "Background",
];

#[test]
fn the_interchange_profile_is_whole() {
    let distinct: BTreeSet<_> = INTERCHANGE.iter().collect();
    assert_eq!(distinct.len(), 49);
    for name in INTERCHANGE {
        assert!(schema::lookup(name).is_some() || schema::is_silent(name), "{name}");
    }
}

#[test]
fn the_page_names_every_node() {
    let page = include_str!("../../../../../docs/x3d.md");
    let words: BTreeSet<&str> = page.split(|c: char| !c.is_alphanumeric()).collect();
    let missing: Vec<_> = schema::all().map(|ty| ty.name).filter(|name| !words.contains(name)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}

/// Checks the types of fields whose width is easily mistaken.
#[test]
fn fields_have_the_standards_types() {
    let types: BTreeMap<&str, Kind> = [
        ("Transform.rotation", Kind::Sf(4)),
        ("Transform.scale", Kind::Sf(3)),
        ("Background.skyColor", Kind::Mf(3)),
        ("ColorRGBA.color", Kind::Mf(4)),
        ("Color.color", Kind::Mf(3)),
        ("TextureCoordinate.point", Kind::Mf(2)),
        ("Coordinate.point", Kind::Mf(3)),
        ("Extrusion.orientation", Kind::Mf(4)),
        ("Extrusion.scale", Kind::Mf(2)),
        ("OrientationInterpolator.keyValue", Kind::Mf(4)),
        ("ScalarInterpolator.keyValue", Kind::Mf(1)),
        ("OrthoViewpoint.fieldOfView", Kind::Sf(4)),
        ("Viewpoint.fieldOfView", Kind::Sf(1)),
        ("PixelTexture.image", Kind::Image),
        ("ElevationGrid.xDimension", Kind::Int),
        ("IndexedFaceSet.coordIndex", Kind::Ints),
        ("Fog.fogType", Kind::Text),
        ("Text.string", Kind::Texts),
    ]
    .into();
    for (name, kind) in types {
        let (node, field) = name.split_once('.').unwrap();
        let ty = schema::lookup(node).unwrap();
        assert_eq!(ty.fields[ty.field(field).unwrap()].kind, kind, "{name}");
    }
}

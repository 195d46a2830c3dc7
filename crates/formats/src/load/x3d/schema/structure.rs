//! Table of groups, viewpoints, environment, lights, time and interpolators.

use super::super::value::Kind::{Bool, Int, Ints, Mf, Sf, Text, Texts};
use super::{FieldDef, NodeDef, f, n};

/// Fields of every grouping node.
pub(super) const BOUNDED: &[FieldDef] = &[
    f("bboxCenter", Sf(3), "0 0 0"),
    f("bboxDisplay", Bool, "false"),
    f("bboxSize", Sf(3), "-1 -1 -1"),
    f("visible", Bool, "true"),
];

const CHILDREN: &[&str] = &["children"];

/// Fields of every viewpoint.
const VIEWPOINT: &[FieldDef] = &[
    f("centerOfRotation", Sf(3), "0 0 0"),
    f("description", Text, ""),
    f("farDistance", Sf(1), "-1"),
    f("jump", Bool, "true"),
    f("nearDistance", Sf(1), "-1"),
    f("orientation", Sf(4), "0 0 1 0"),
    f("position", Sf(3), "0 0 10"),
    f("retainUserOffsets", Bool, "false"),
    f("viewAll", Bool, "false"),
];

/// Fields of every light; the default of `global` differs.
const LIGHT: &[FieldDef] = &[
    f("ambientIntensity", Sf(1), "0"),
    f("color", Sf(3), "1 1 1"),
    f("intensity", Sf(1), "1"),
    f("on", Bool, "true"),
    f("shadowIntensity", Sf(1), "1"),
    f("shadows", Bool, "false"),
];

/// Fields of lights with a position.
const PLACED_LIGHT: &[FieldDef] = &[
    f("attenuation", Sf(3), "1 0 0"),
    f("global", Bool, "true"),
    f("location", Sf(3), "0 0 0"),
    f("radius", Sf(1), "100"),
];

/// Fields of every layer.
const LAYER: &[FieldDef] = &[
    f("isPickable", Bool, "true"),
    f("objectType", Texts, "\"ALL\""),
    f("pickable", Bool, "true"),
    f("visible", Bool, "true"),
];

const KEY: &[FieldDef] = &[f("key", Mf(1), "")];

pub(super) const NODES: &[NodeDef] = &[
    n("Scene", "scene", CHILDREN, &[]),
    n("Group", "children", CHILDREN, &[BOUNDED]),
    n("StaticGroup", "children", CHILDREN, &[BOUNDED]),
    n("Switch", "children", CHILDREN, &[&[f("whichChoice", Int, "-1")], BOUNDED]),
    n(
        "Transform",
        "children",
        CHILDREN,
        &[
            &[
                f("center", Sf(3), "0 0 0"),
                f("rotation", Sf(4), "0 0 1 0"),
                f("scale", Sf(3), "1 1 1"),
                f("scaleOrientation", Sf(4), "0 0 1 0"),
                f("translation", Sf(3), "0 0 0"),
            ],
            BOUNDED,
        ],
    ),
    n("Collision", "children", &["children", "proxy"], &[&[f("enabled", Bool, "true")], BOUNDED]),
    n(
        "LOD",
        "children",
        CHILDREN,
        &[
            &[f("center", Sf(3), "0 0 0"), f("forceTransitions", Bool, "false"), f("range", Mf(1), "")],
            BOUNDED,
        ],
    ),
    n("Billboard", "children", CHILDREN, &[&[f("axisOfRotation", Sf(3), "0 1 0")], BOUNDED]),
    n(
        "Anchor",
        "children",
        CHILDREN,
        &[
            &[
                f("autoRefresh", Sf(1), "0"),
                f("autoRefreshTimeLimit", Sf(1), "3600"),
                f("description", Text, ""),
                f("load", Bool, "true"),
                f("parameter", Texts, ""),
                f("url", Texts, ""),
            ],
            BOUNDED,
        ],
    ),
    n("LayerSet", "children", &["layers"], &[&[f("activeLayer", Int, "0"), f("order", Ints, "0")]]),
    n("Layer", "layers", &["children", "viewport"], &[LAYER]),
    n("LayoutLayer", "layers", &["children", "viewport"], &[LAYER]),
    n("Viewport", "viewport", CHILDREN, &[&[f("clipBoundary", Mf(1), "0 1 0 1")], BOUNDED]),
    n(
        "Inline",
        "children",
        &[],
        &[
            &[
                f("autoRefresh", Sf(1), "0"),
                f("autoRefreshTimeLimit", Sf(1), "3600"),
                f("description", Text, ""),
                f("global", Bool, "false"),
                f("load", Bool, "true"),
                f("url", Texts, ""),
            ],
            BOUNDED,
        ],
    ),
    n(
        "Viewpoint",
        "children",
        &["navigationInfo"],
        &[VIEWPOINT, &[f("fieldOfView", Sf(1), "0.7853981633974483")]],
    ),
    n(
        "OrthoViewpoint",
        "children",
        &["navigationInfo"],
        &[VIEWPOINT, &[f("fieldOfView", Sf(4), "-1 -1 1 1")]],
    ),
    n(
        "NavigationInfo",
        "children",
        &[],
        &[&[
            f("avatarSize", Mf(1), "0.25 1.6 0.75"),
            f("headlight", Bool, "true"),
            f("speed", Sf(1), "1"),
            f("transitionTime", Sf(1), "1"),
            f("transitionType", Texts, "\"LINEAR\""),
            f("type", Texts, "\"EXAMINE\" \"ANY\""),
            f("visibilityLimit", Sf(1), "0"),
        ]],
    ),
    n(
        "Background",
        "children",
        &[],
        &[&[
            f("backUrl", Texts, ""),
            f("bottomUrl", Texts, ""),
            f("frontUrl", Texts, ""),
            f("groundAngle", Mf(1), ""),
            f("groundColor", Mf(3), ""),
            f("leftUrl", Texts, ""),
            f("rightUrl", Texts, ""),
            f("skyAngle", Mf(1), ""),
            f("skyColor", Mf(3), "0 0 0"),
            f("topUrl", Texts, ""),
            f("transparency", Sf(1), "0"),
        ]],
    ),
    n(
        "Fog",
        "children",
        &[],
        &[&[f("color", Sf(3), "1 1 1"), f("fogType", Text, "LINEAR"), f("visibilityRange", Sf(1), "0")]],
    ),
    n(
        "DirectionalLight",
        "children",
        &[],
        &[LIGHT, &[f("direction", Sf(3), "0 0 -1"), f("global", Bool, "false")]],
    ),
    n("PointLight", "children", &[], &[LIGHT, PLACED_LIGHT]),
    n(
        "SpotLight",
        "children",
        &[],
        &[
            LIGHT,
            PLACED_LIGHT,
            &[
                f("beamWidth", Sf(1), "0.7853981633974483"),
                f("cutOffAngle", Sf(1), "1.5707963267948966"),
                f("direction", Sf(3), "0 0 -1"),
            ],
        ],
    ),
    n(
        "TimeSensor",
        "children",
        &[],
        &[&[
            f("cycleInterval", Sf(1), "1"),
            f("description", Text, ""),
            f("enabled", Bool, "true"),
            f("loop", Bool, "false"),
            f("pauseTime", Sf(1), "0"),
            f("resumeTime", Sf(1), "0"),
            f("startTime", Sf(1), "0"),
            f("stopTime", Sf(1), "0"),
        ]],
    ),
    n("ScalarInterpolator", "children", &[], &[KEY, &[f("keyValue", Mf(1), "")]]),
    n("PositionInterpolator", "children", &[], &[KEY, &[f("keyValue", Mf(3), "")]]),
    n("ColorInterpolator", "children", &[], &[KEY, &[f("keyValue", Mf(3), "")]]),
    n("CoordinateInterpolator", "children", &[], &[KEY, &[f("keyValue", Mf(3), "")]]),
    n("NormalInterpolator", "children", &[], &[KEY, &[f("keyValue", Mf(3), "")]]),
    n("OrientationInterpolator", "children", &[], &[KEY, &[f("keyValue", Mf(4), "")]]),
    n(
        "SplinePositionInterpolator",
        "children",
        &[],
        &[
            KEY,
            &[
                f("closed", Bool, "false"),
                f("keyValue", Mf(3), ""),
                f("keyVelocity", Mf(3), ""),
                f("normalizeVelocity", Bool, "false"),
            ],
        ],
    ),
];

//! Table of geometry nodes and their property nodes.

use super::super::value::Kind::{Bool, Int, Ints, Mf, Sf, Text};
use super::{FieldDef, NodeDef, f, n};

/// Fields of every composed geometry.
const COMPOSED: &[FieldDef] = &[
    f("ccw", Bool, "true"),
    f("colorPerVertex", Bool, "true"),
    f("normalPerVertex", Bool, "true"),
    f("solid", Bool, "true"),
];
/// Property nodes of a geometry with faces.
const VERTEX_NODES: &[&str] = &["coord", "color", "normal", "texCoord"];
/// Property nodes of a geometry of lines or points.
const LINE_NODES: &[&str] = &["coord", "color", "normal"];
/// Node field that X3D 4 adds to solids: a generator of texture coordinates.
const TEXCOORD: &[&str] = &["texCoord"];
const SOLID: &[FieldDef] = &[f("solid", Bool, "true")];
const NOT_SOLID: &[FieldDef] = &[f("solid", Bool, "false")];
/// Fields of both arcs.
const ARC: &[FieldDef] =
    &[f("endAngle", Sf(1), "1.5707963267948966"), f("radius", Sf(1), "1"), f("startAngle", Sf(1), "0")];
const INDEX: &[FieldDef] = &[f("index", Ints, "")];

pub(super) const NODES: &[NodeDef] = &[
    n("TriangleSet", "geometry", VERTEX_NODES, &[COMPOSED]),
    n("TriangleFanSet", "geometry", VERTEX_NODES, &[COMPOSED, &[f("fanCount", Ints, "")]]),
    n("TriangleStripSet", "geometry", VERTEX_NODES, &[COMPOSED, &[f("stripCount", Ints, "")]]),
    n("IndexedTriangleSet", "geometry", VERTEX_NODES, &[COMPOSED, INDEX]),
    n("IndexedTriangleFanSet", "geometry", VERTEX_NODES, &[COMPOSED, INDEX]),
    n("IndexedTriangleStripSet", "geometry", VERTEX_NODES, &[COMPOSED, INDEX]),
    n("QuadSet", "geometry", VERTEX_NODES, &[COMPOSED]),
    n("IndexedQuadSet", "geometry", VERTEX_NODES, &[COMPOSED, INDEX]),
    n(
        "IndexedFaceSet",
        "geometry",
        VERTEX_NODES,
        &[
            COMPOSED,
            &[
                f("colorIndex", Ints, ""),
                f("convex", Bool, "true"),
                f("coordIndex", Ints, ""),
                f("creaseAngle", Sf(1), "0"),
                f("normalIndex", Ints, ""),
                f("texCoordIndex", Ints, ""),
            ],
        ],
    ),
    n("Box", "geometry", TEXCOORD, &[&[f("size", Sf(3), "2 2 2")], SOLID]),
    n("Sphere", "geometry", TEXCOORD, &[&[f("radius", Sf(1), "1")], SOLID]),
    n(
        "Cone",
        "geometry",
        TEXCOORD,
        &[
            &[
                f("bottom", Bool, "true"),
                f("bottomRadius", Sf(1), "1"),
                f("height", Sf(1), "2"),
                f("side", Bool, "true"),
            ],
            SOLID,
        ],
    ),
    n(
        "Cylinder",
        "geometry",
        TEXCOORD,
        &[
            &[
                f("bottom", Bool, "true"),
                f("height", Sf(1), "2"),
                f("radius", Sf(1), "1"),
                f("side", Bool, "true"),
                f("top", Bool, "true"),
            ],
            SOLID,
        ],
    ),
    n(
        "ElevationGrid",
        "geometry",
        &["color", "normal", "texCoord"],
        &[
            COMPOSED,
            &[
                f("creaseAngle", Sf(1), "0"),
                f("height", Mf(1), ""),
                f("xDimension", Int, "0"),
                f("xSpacing", Sf(1), "1"),
                f("zDimension", Int, "0"),
                f("zSpacing", Sf(1), "1"),
            ],
        ],
    ),
    n(
        "Extrusion",
        "geometry",
        TEXCOORD,
        &[
            &[
                f("beginCap", Bool, "true"),
                f("ccw", Bool, "true"),
                f("convex", Bool, "true"),
                f("creaseAngle", Sf(1), "0"),
                f("crossSection", Mf(2), "1 1 1 -1 -1 -1 -1 1 1 1"),
                f("endCap", Bool, "true"),
                f("orientation", Mf(4), "0 0 1 0"),
                f("scale", Mf(2), "1 1"),
                f("spine", Mf(3), "0 0 0 0 1 0"),
            ],
            SOLID,
        ],
    ),
    n("PointSet", "geometry", LINE_NODES, &[]),
    // Not the standard's: the name that a course's files have for vertexCount.
    n("LineSet", "geometry", LINE_NODES, &[&[f("stripCount", Ints, ""), f("vertexCount", Ints, "")]]),
    n(
        "IndexedLineSet",
        "geometry",
        LINE_NODES,
        &[&[
            f("colorIndex", Ints, ""),
            f("colorPerVertex", Bool, "true"),
            f("coordIndex", Ints, ""),
            f("normalIndex", Ints, ""),
            f("normalPerVertex", Bool, "true"),
        ]],
    ),
    n("Polypoint2D", "geometry", &[], &[&[f("point", Mf(2), "")]]),
    n("Polyline2D", "geometry", &[], &[&[f("lineSegments", Mf(2), "")]]),
    n("Circle2D", "geometry", &[], &[&[f("radius", Sf(1), "1")]]),
    n("Arc2D", "geometry", &[], &[ARC]),
    n("ArcClose2D", "geometry", &[], &[ARC, &[f("closureType", Text, "PIE")], NOT_SOLID]),
    n("Disk2D", "geometry", &[], &[&[f("innerRadius", Sf(1), "0"), f("outerRadius", Sf(1), "1")], NOT_SOLID]),
    n("Rectangle2D", "geometry", &[], &[&[f("size", Sf(2), "2 2")], NOT_SOLID]),
    n("TriangleSet2D", "geometry", &[], &[&[f("vertices", Mf(2), "")], NOT_SOLID]),
    n("Coordinate", "coord", &[], &[&[f("point", Mf(3), "")]]),
    n("CoordinateDouble", "coord", &[], &[&[f("point", Mf(3), "")]]),
    n("Color", "color", &[], &[&[f("color", Mf(3), "")]]),
    n("ColorRGBA", "color", &[], &[&[f("color", Mf(4), "")]]),
    n("Normal", "normal", &[], &[&[f("vector", Mf(3), "")]]),
    n(
        "TextureCoordinateGenerator",
        "texCoord",
        &[],
        &[&[f("mapping", Text, ""), f("mode", Text, "SPHERE"), f("parameter", Mf(1), "")]],
    ),
    n("MultiTextureCoordinate", "texCoord", &["texCoord"], &[&[f("mapping", Text, "")]]),
    n("TextureCoordinate", "texCoord", &[], &[&[f("mapping", Text, ""), f("point", Mf(2), "")]]),
];

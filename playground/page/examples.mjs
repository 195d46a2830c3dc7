// The examples: the steps of the tour, from one pixel to four dimensions. Each is a title and a stream.
import { readFileSync } from "node:fs";

const teapot = (shade, more) => `# ${more}
SIZE 480 360
CLEAR 101020
MESH pot TEAPOT 6
LOOKAT 0 4.2 9 0.2 1.3 0 0 1 0
PERSPECTIVE 45deg 0.1 100
AMBIENT .15 .15 .15
LIGHT 0 POINT 5 9 7 1 1 1
MATERIAL .9 .55 .2 .9 .55 .2 .7 .7 .7 60
SHADE ${shade}
DRAW pot
`;

// The simplex of four dimensions: five corners, and five tetrahedra between them.
function simplex() {
    const corners = [[1.118, 1.118, 1.118, -0.5], [1.118, -1.118, -1.118, -0.5], [-1.118, 1.118, -1.118, -0.5], [-1.118, -1.118, 1.118, -0.5], [0, 0, 0, 2]];
    const colors = ["#ff5d5d", "#ffb000", "#2ec4b6", "#5b8cff", "#9664dc"];
    const facet = (color, i) => `{"color": "${color}", "v": ${JSON.stringify(corners.filter((_, k) => k !== i))}}`;
    return `{"dim": 4, "pixels": [240, 180], "d": 1.2, "S": [1.6, 1.2], "aperture_tan": [0.2],
"I_d": 0.4, "view": {"k": 3, "n": 1}, "background": [14, 20, 32],
"lights": [{"type": "radial", "position": [-4, 3, 4, 1], "k": 30, "n": 2}],
"eye": {"position": [-4.5, 0, 0, 0.4]},
"facets": [
${colors.map(facet).join(",\n")}
]}
`;
}
const cornell = readFileSync(new URL("../../crates/formats/data/cornell.x3d", import.meta.url), "utf8");
const payload = (text) => `:${Buffer.byteLength(text)}\n${text}`;
const animation = Array.from({ length: 60 }, (_, i) => {
    const x = 60 + i * 6, y = Math.round(280 - 200 * Math.abs(Math.sin(i * Math.PI / 20)));
    return `CLEAR #161d2c\nFILLELLIPSE ${x} 316 ${30 + Math.round((280 - y) / 10)} 6 #0e1420\nFILLCIRCLE ${x} ${y} 30 gold\nPRESENT\n`;
}).join("");

export const examples = [
    ["one pixel", `# One pixel. The frame is an array of
# bytes, four a pixel: R G B A. (x,y)
# counts from the upper left corner;
# its offset is (width*y + x)*4.
SIZE 48 36
PX 24 18 ffffff
# The same by its offset: (48*18 +
# 26)*4 = 3560.
POKE 3560 ffb000ff
PX 24 18
PEEK 3560 4
`],
    ["lines", `# Lines after Bresenham: whole
# numbers only, both ends lit, a ramp
# from end to end.
SIZE 160 120
LINE 80 60 156 60 ff0000 ffff00
LINE 80 60 156 24 ff4000 ffff00
LINE 80 60 116 6 ff8000 ffff00
LINE 80 60 80 14 ffc000 ffff00
LINE 80 60 44 6 80ff00 00ffff
LINE 80 60 4 24 40ff00 00ffff
LINE 80 60 4 60 00ff00 00ffff
LINE 80 60 4 96 00ff80 00ffff
LINE 80 60 44 106 0080ff ff00ff
LINE 80 60 116 106 8000ff ff00ff
LINE 80 60 156 96 ff0080 ff00ff
LINE -2000000000 114 2000000000 114 808ca5
`],
    ["areas", `# A pixel belongs to an area when its
# centre lies inside; two that share
# an edge share no pixel.
SIZE 480 360
CLEAR #0e1420
FILLRECT 40 40 160 100 #5b8cff
FILLCIRCLE 360 100 70 #ff5d5d
FILLPOLY gold 120 170 150 270 65 205 175 205 90 270
FILL 220 300 440 280 330 180 ff0000 00ff00 0000ff
WIDELINE 30 320 450 330 7 #2ec4b6
BLEND over
FILLRECT 100 80 300 80 ffffff40
PRINT 16 340 white areas, blending and a ramp
`],
    ["edges of a teapot", teapot("wire", "The edges of Newell's teapot,\n# through a camera.")],
    ["flat", teapot("flat", "Flat: every face has one colour.")],
    ["Phong", teapot("phong", "Phong: the normals run between the\n# vertices, every pixel is lit.\n# Drag to turn it.")],
    ["a texture", `# A picture of two by two pixels on a
# box.
SIZE 480 360
CLEAR #161d2c
TEX chess :50
P3 2 2 255  255 160 0  40 0 80  40 0 80  255 160 0
MESH box BOX
MATERIAL white white black 1
TEXTURE chess nearest
ROTATE 1 1 0 40deg
DRAW box
`],
    ["a knot in two lights", `# Material, two lights, a matrix.
# Click a pixel to read all numbers
# of its way.
SIZE 480 360
CLEAR #0e1420
MESH knot KNOT 160 24
LOOKAT 0 0 6.6 0 0 0 0 1 0
PERSPECTIVE 45deg 0.1 100
AMBIENT .12 .12 .16
LIGHT 0 POINT 5 6 7 1 .9 .7
LIGHT 1 DIR 1 -.3 -.5 .2 .35 .6
MATERIAL .4 .4 .4 .8 .6 .2 .7 .7 .7 50
ROTATE 1 0 0 20deg
DRAW knot
`],
    ["a room (cornell)", `# An X3D scene: the room of \`fbptr
# view cornell\`. Drag to turn it.
SIZE 480 360
SCENE X3D ${payload(cornell)}DRAWSCENE
`],
    ["an animation", `# PRESENT ends a frame. "Play" shows
# them one by one.
SIZE 480 360
AUTO off
${animation}`],
    ["four dimensions", `# The simplex of four dimensions on a
# flat screen. Turn it in the planes
# below the picture.
SIZE 480 360
CLEAR #0e1420
EYE cell ${payload(simplex())}DRAWEYE cell 0 0 480 360
`],
];

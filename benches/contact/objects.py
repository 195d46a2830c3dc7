"""Writes OBJ files that differ in their encoding, not only in their shapes.

Eleven solids and surfaces (spheres with a seam, open surfaces, sharp edges, concave caps), each with
equal positions repeated, shared or apart, as polygons and as triangles, turned inside out, with
smoothing groups, colours, materials and pictures, cut in half; and files in other encodings, with
relative indices, of points and of lines. No two faces of a file overlap.
"""

import math
import os
import struct
import zlib

TURN = 2 * math.pi

MATERIALS = """newmtl red
Kd .9 .2 .15
newmtl blue
Kd .2 .4 .9
Ks .6 .6 .6
Ns 40
newmtl picture
map_Kd check.png
newmtl repeated
map_Kd -s 4 4 1 check.png
newmtl moved
map_Kd -o 0.5 0.25 -s 2 2 -clamp off check.png
newmtl clamped
map_Kd -clamp on -s 3 3 1 -colorspace sRGB with space.png
newmtl glass
Kd .3 .9 .5
d .4
"""


def png(rows):
    """Returns a PNG file of rows of (red, green, blue)."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    raw = b"".join(b"\0" + bytes(c for pixel in row for c in pixel) for row in rows)
    header = struct.pack(">IIBBBBB", len(rows[0]), len(rows), 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(raw, 9))
            + chunk(b"IEND", b""))


def grid(columns, rows, at):
    """Returns positions, faces and texture coordinates of a surface over the unit square."""
    positions = [at(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    coordinates = [(i / columns, j / rows) for j in range(rows + 1) for i in range(columns + 1)]
    width = columns + 1
    faces = [[j * width + i, j * width + i + 1, (j + 1) * width + i + 1, (j + 1) * width + i]
             for j in range(rows) for i in range(columns)]
    return positions, faces, coordinates


def ring(radius, height, u):
    return round(radius * math.cos(TURN * u), 9), round(height, 9), round(-radius * math.sin(TURN * u), 9)


def sphere(u, v):
    return ring(math.cos(math.pi * (v - .5)), math.sin(math.pi * (v - .5)), u)


def torus(u, v):
    return ring(1 + .4 * math.cos(TURN * v), .4 * math.sin(TURN * v), u)


def prism(outline, depth):
    """Returns the solid between two copies of an outline."""
    count = len(outline)
    positions = [(x, y, z) for z in (-depth, depth) for x, y in outline]
    sides = [[i, (i + 1) % count, count + (i + 1) % count, count + i] for i in range(count)]
    return positions, sides + [list(range(count, 2 * count)), list(range(count - 1, -1, -1))], None


def shapes():
    """Returns a dict of name to positions, faces and texture coordinates (or None)."""
    octagon = [(math.cos(TURN * i / 8), math.sin(TURN * i / 8)) for i in range(8)]
    star = [(r * math.cos(TURN * i / 10), r * math.sin(TURN * i / 10)) for i, r in enumerate([1, .45] * 5)]
    return {
        "sphere": grid(24, 12, sphere),
        "torus": grid(24, 12, torus),
        "tube": grid(16, 1, lambda u, v: ring(1, 2 * v - 1, u)),
        "cone": grid(16, 4, lambda u, v: ring(1 - v, 2 * v - 1, u)),
        "wave": grid(16, 16, lambda u, v: (4 * u - 2, .3 * math.sin(6 * u) * math.cos(7 * v), 2 - 4 * v)),
        "saddle": grid(12, 12, lambda u, v: (2 * u - 1, (2 * u - 1) ** 2 - (2 * v - 1) ** 2, 1 - 2 * v)),
        "halfpipe": grid(12, 1, lambda u, v: (math.cos(math.pi * u), -math.sin(math.pi * u), 2 - 4 * v)),
        "cube": prism([(1, 1), (-1, 1), (-1, -1), (1, -1)], 1),
        "prism": prism(octagon, 1),
        "star": ([(x, y, 0) for x, y in star], [list(range(10))], None),
        "star-solid": prism(star, .3),
    }


def shared(positions, faces):
    """Returns the shape with equal positions merged."""
    numbers = {}
    for position in positions:
        numbers.setdefault(tuple(c + 0.0 for c in position), len(numbers))
    index = [numbers[tuple(c + 0.0 for c in position)] for position in positions]
    return list(numbers), [[index[i] for i in face] for face in faces]


def apart(positions, faces):
    """Returns the shape with separate positions for each face."""
    starts = [sum(map(len, faces[:n])) for n in range(len(faces))]
    return ([positions[i] for face in faces for i in face],
            [list(range(start, start + len(face))) for start, face in zip(starts, faces)])


def text(positions, faces, coordinates=None, before="", between=lambda n, count: "", relative=False, colors=False):
    """Returns the OBJ text; `between` gives the lines before face n of count."""
    lines = [before]
    for position in positions:
        extra = " %.3g %.3g %.3g" % tuple((max(-1, min(1, c)) + 1) / 2 for c in position) if colors else ""
        lines.append("v %.9g %.9g %.9g" % position + extra + "\n")
    lines += ["vt %.6g %.6g\n" % pair for pair in coordinates or ()]
    for n, face in enumerate(faces):
        numbers = [i - len(positions) if relative else i + 1 for i in face]
        corners = ["%d/%d" % (i, i) if coordinates else str(i) for i in numbers]
        lines.append(between(n, len(faces)) + "f " + " ".join(corners) + "\n")
    return "".join(lines)


def of_shape(positions, faces, coordinates):
    """Returns the variants of one shape: a dict of name to text."""
    once = shared(positions, faces)
    triangles = [[face[0], face[k], face[k + 1]] for face in once[1] for k in range(1, len(face) - 1)]
    names = ["usemtl red\n", "usemtl blue\n", "usemtl\n", "usemtl glass\n"]
    halves = lambda first, second: lambda n, count: {0: first, (count + 1) // 2: second}.get(n, "")
    kinds = {
        "repeated": text(positions, faces),
        "shared": text(*once),
        "apart": text(*apart(positions, faces)),
        "reversed": text(once[0], [face[::-1] for face in once[1]]),
        "off": text(positions, faces, before="s off\n"),
        "groups": text(*once, between=halves("s 1\n", "s 2\n")),
        "colors": text(*once, colors=True),
        "materials": text(positions, faces, before="mtllib materials.mtl\n",
                          between=lambda n, count: names[4 * n // count]),
        "half": text(once[0], once[1][:len(once[1]) // 2 or 1]),
    }
    # A fan does not triangulate a concave face.
    if all(len(face) <= 8 for face in faces):
        kinds["triangles"] = text(once[0], triangles)
    if coordinates:
        kinds["picture"] = text(positions, faces, coordinates, "mtllib materials.mtl\nusemtl picture\n")
        kinds["placed"] = text(positions, faces, coordinates, "mtllib materials.mtl\n",
                               halves("usemtl repeated\n", "usemtl moved\n"))
        kinds["clamped"] = text(positions, faces, coordinates, "mtllib materials.mtl\nusemtl clamped\n")
    return kinds


def write_all(folder):
    """Writes all files into a folder that exists; returns the paths of the OBJ files, in order."""
    files, all_shapes = {}, shapes()
    for name, shape in all_shapes.items():
        files.update(("%s-%s" % (name, kind), content.encode()) for kind, content in of_shape(*shape).items())
    positions, faces, _ = all_shapes["torus"]
    plain = text(positions, faces)
    files.update({
        "utf-16-le": ("\ufeff" + plain).encode("utf-16-le"),
        "utf-16-be": ("\ufeff" + plain).encode("utf-16-be"),
        "utf-8-bom": ("\ufeff" + plain).encode(),
        "carriage-returns": plain.replace("\n", "\r").encode(),
        "relative": text(positions, faces, relative=True).encode(),
        "points": (text(positions, []) + "p " + " ".join(str(i + 1) for i in range(len(positions))) + "\n").encode(),
        "lines": (text(positions, []) + "".join("l %d %d %d\n" % tuple(i + 1 for i in f[:3]) for f in faces)).encode(),
        "mixed": (text(*all_shapes["cube"][:2]) + "v 2 2 2\nv -2 -2 -2\nl 9 10\np 9 10\n").encode(),
    })
    pictures = {"check.png": [[(230, 80, 60) if (x // 4 + y // 4) % 2 else (250, 240, 200) for x in range(16)]
                              for y in range(16)],
                "with space.png": [[(60, x * 16, y * 16) for x in range(16)] for y in range(16)]}
    for name, rows in pictures.items():
        open(os.path.join(folder, name), "wb").write(png(rows))
    open(os.path.join(folder, "materials.mtl"), "w").write(MATERIALS)
    paths = [os.path.join(folder, name + ".obj") for name in files]
    for path, content in zip(paths, files.values()):
        open(path, "wb").write(content)
    return paths

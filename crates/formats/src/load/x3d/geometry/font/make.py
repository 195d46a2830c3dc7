"""Makes glyphs.bin, the filled outlines of Text, from DejaVu Sans and DejaVu Serif 2.37.

    pip install fonttools shapely
    python3 make.py DejaVuSerif.ttf DejaVuSans.ttf

Curves become lines within a tolerance, and shapes with holes are cut through the middle of each hole,
so that all polygons are simple: no face overlaps another. The layout of the file is in mod.rs.
"""
import struct
import sys

from fontTools.pens.recordingPen import DecomposingRecordingPen
from fontTools.ttLib import TTFont
from shapely import LineString, Polygon, ops, unary_union

EM = 200
TOLERANCE = 1.0
MARKS = [0x300, 0x301, 0x302, 0x303, 0x308, 0x30A, 0x327]
OTHERS = "¡«°·»¿ÆØßæø×–—‘’“”…€"
CODES = [*range(0x20, 0x7F), 0x131, *MARKS, *map(ord, OTHERS)]


def curve(a, b, c):
    """Returns points of a quadratic curve after its start."""
    flat = max(abs(a[i] - 2 * b[i] + c[i]) for i in (0, 1)) / 4
    count = max(1, round((flat / TOLERANCE) ** 0.5 + 0.3))
    ts = [(k + 1) / count for k in range(count)]
    return [tuple((1 - t) ** 2 * a[i] + 2 * t * (1 - t) * b[i] + t * t * c[i] for i in (0, 1)) for t in ts]


def contours(font, code):
    """Returns the advance and the contours of a character, in EM units."""
    scale = EM / font["head"].unitsPerEm
    name = font.getBestCmap()[code]
    pen = DecomposingRecordingPen(font.getGlyphSet())
    font.getGlyphSet()[name].draw(pen)
    found, points = [], []
    for verb, arguments in pen.value:
        arguments = [p and (p[0] * scale, p[1] * scale) for p in arguments]
        if verb == "moveTo":
            points = list(arguments)
        elif verb == "lineTo":
            points += arguments
        elif verb == "qCurveTo":
            *controls, end = arguments
            if end is None:  # no point is on the curve
                end = tuple((controls[-1][i] + controls[0][i]) / 2 for i in (0, 1))
                points = [end]
            for k, b in enumerate(controls):
                n = controls[k + 1] if k + 1 < len(controls) else None
                stop = ((b[0] + n[0]) / 2, (b[1] + n[1]) / 2) if n else end
                points += curve(points[-1], b, stop)
        elif verb in ("closePath", "endPath"):
            found.append(points)
    return round(font["hmtx"][name][0] * scale), found


def pieces(shape):
    """Returns polygons without holes that cover a shape."""
    if not shape.interiors:
        return [shape]
    hole = shape.interiors[0]
    x = (hole.bounds[0] + hole.bounds[2]) / 2
    cut = LineString([(x, shape.bounds[1] - 1), (x, shape.bounds[3] + 1)])
    return [p for part in ops.split(shape, cut).geoms for p in pieces(part)]


def polygons(font, code):
    """Returns the advance and the simple polygons of a character, counter-clockwise, in whole numbers."""
    advance, found = contours(font, code)
    areas = [(Polygon(c), sum(a[0] * b[1] - b[0] * a[1] for a, b in zip(c, c[1:] + c[:1]))) for c in found if len(c) > 2]
    solid = unary_union([p.buffer(0) for p, area in areas if area < 0])
    holes = unary_union([p.buffer(0) for p, area in areas if area > 0])
    shape = solid.difference(holes)
    made = []
    for part in getattr(shape, "geoms", [shape]) if not shape.is_empty else []:
        for piece in pieces(part):
            ring = [(round(x), round(y)) for x, y in piece.exterior.coords[:-1]]
            ring = [p for k, p in enumerate(ring) if p != ring[k - 1]]
            if Polygon(ring).exterior.is_ccw is False:
                ring.reverse()
            made.append(ring)
    return advance, made


def number(n):
    """Returns a whole number of either sign in bytes of seven bits, the low ones first."""
    n = 2 * n if n >= 0 else -2 * n - 1
    out = bytearray()
    while n > 127:
        out.append(n & 127 | 128)
        n >>= 7
    return bytes(out + bytes([n]))


out = bytearray(struct.pack("<H", len(CODES)))
for code in CODES:
    out += struct.pack("<H", code)
for path in sys.argv[1:]:
    font = TTFont(path)
    for code in CODES:
        advance, made = polygons(font, code)
        out += number(advance) + number(len(made))
        last = (0, 0)
        for ring in made:
            out += number(len(ring))
            for x, y in ring:
                out += number(x - last[0]) + number(y - last[1])
                last = (x, y)
open("glyphs.bin", "wb").write(out)

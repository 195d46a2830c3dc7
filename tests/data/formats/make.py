#!/usr/bin/env python3
"""Makes the glTF, STL and PLY files of this folder: python3 make.py. The same bytes each time."""
import base64
import json
import math
import os
import struct
import zlib

HERE = os.path.dirname(os.path.abspath(__file__))


def put(name, data):
    path = os.path.join(HERE, name)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "wb") as file:
        file.write(data.encode() if isinstance(data, str) else data)


def png(width, height, texel):
    """A PNG of RGBA texels; `texel` gives one by column and row."""
    rows = b"".join(b"\0" + b"".join(bytes(texel(x, y)) for x in range(width)) for y in range(height))

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)
    # Stored blocks: the same bytes with any version of zlib.
    packed = zlib.compress(rows, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", packed) + chunk(b"IEND", b"")


def corner_texel(x, y):
    """Eight by eight texels, each corner of the picture in its own colour, one corner invisible."""
    color = [(220, 40, 40), (40, 180, 60), (50, 80, 230), (240, 200, 40)][(x >= 4) + 2 * (y >= 4)]
    shade = 1.0 if (x + y) % 2 == 0 else 0.6
    alpha = 0 if x >= 5 and y >= 5 else 128 if x < 3 and y < 3 else 255
    return [int(c * shade) for c in color] + [alpha]


class File:
    """A glTF file in the making: JSON, and one buffer."""

    CODES = {"b": 5120, "B": 5121, "h": 5122, "H": 5123, "I": 5125, "f": 5126}
    TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}

    def __init__(self):
        self.json = {"asset": {"version": "2.0", "generator": "make.py"}, "scene": 0}
        self.bytes = b""

    def add(self, kind, **item):
        items = self.json.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def view(self, data, **more):
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        offset = len(self.bytes)
        self.bytes += data
        return self.add("bufferViews", buffer=0, byteOffset=offset, byteLength=len(data), **more)

    def accessor(self, rows, form="f", **more):
        rows = [row if isinstance(row, (list, tuple)) else [row] for row in rows]
        pad = -struct.calcsize("<" + form * len(rows[0])) % 4 if len(rows[0]) > 1 else 0
        data = b"".join(struct.pack("<" + form * len(row), *row) + b"\0" * pad for row in rows)
        stride = {"byteStride": len(data) // len(rows)} if pad else {}
        fields = {"bufferView": self.view(data, **stride), "componentType": self.CODES[form]}
        fields |= {"count": len(rows), "type": self.TYPES[len(rows[0])]}
        if form == "f" and len(rows[0]) == 3:
            fields |= {"min": [min(c) for c in zip(*rows)], "max": [max(c) for c in zip(*rows)]}
        return self.add("accessors", **fields, **more)

    def mesh(self, indices=None, material=None, mode=None, targets=None, weights=None, **attributes):
        primitive = {"attributes": attributes}
        for name, value in (("indices", indices), ("material", material), ("mode", mode), ("targets", targets)):
            if value is not None:
                primitive[name] = value
        return self.add("meshes", primitives=[primitive], **({"weights": weights} if weights else {}))

    def show(self, *nodes):
        self.add("scenes", nodes=list(nodes))

    def texture(self, image=None, texel=corner_texel, size=8, **sampler):
        image = image or {"bufferView": self.view(png(size, size, texel)), "mimeType": "image/png"}
        entry = {"source": self.add("images", **image)}
        if sampler:
            entry["sampler"] = self.add("samplers", **sampler)
        return self.add("textures", **entry)

    def gltf(self, name, uri=None):
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(self.bytes).decode()
        self.json["buffers"] = [{"byteLength": len(self.bytes), "uri": uri}]
        put(name, json.dumps(self.json, indent=1) + "\n")

    def glb(self, name):
        if self.bytes:
            self.json["buffers"] = [{"byteLength": len(self.bytes)}]
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        if self.bytes:
            body = self.bytes + b"\0" * (-len(self.bytes) % 4)
            chunks += struct.pack("<I4s", len(body), b"BIN\0") + body
        put(name, struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)


def box():
    """Positions, normals, texture coordinates and triangles of a box from -1 to 1."""
    positions, normals, uv, triangles = [], [], [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            first = len(positions)
            for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                p = [0.0] * 3
                p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, side * s, t
                positions.append(p)
                normals.append([side if i == axis else 0.0 for i in range(3)])
                uv.append([(s + 1) / 2, (1 - t) / 2])
            triangles += [first, first + 1, first + 2, first, first + 2, first + 3]
    return positions, normals, uv, triangles


def sphere(rows=8, columns=12):
    """Positions (also normals) and triangles of a unit sphere."""
    positions = []
    for i in range(rows + 1):
        for k in range(columns + 1):
            a, b = math.pi * i / rows, 2 * math.pi * k / columns
            p = [math.sin(a) * math.sin(b), math.cos(a), math.sin(a) * math.cos(b)]
            positions.append([round(x, 6) + 0.0 for x in p])
    at = lambda i, k: i * (columns + 1) + k
    triangles = []
    for i in range(rows):
        for k in range(columns):
            a, b, c, d = at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)
            triangles += ([a, b, c] if i < rows - 1 else []) + ([a, c, d] if i > 0 else [])
    return positions, triangles


QUAD = ([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], [[0, 1], [1, 1], [1, 0], [0, 0]], [0, 1, 2, 0, 2, 3])


def quad(f, material=None, uv=None, **more):
    positions, coordinates, triangles = QUAD
    return f.mesh(
        POSITION=f.accessor(positions),
        TEXCOORD_0=f.accessor(uv or coordinates),
        NORMAL=f.accessor([[0, 0, 1]] * 4),
        indices=f.accessor(triangles, "H"),
        material=material,
        **more,
    )


def base(texture, **more):
    return {"baseColorTexture": {"index": texture, **more}, "metallicFactor": 0, "roughnessFactor": 1}


def gltf_meshes():
    positions, normals, uv, triangles = box()
    f = File()
    mesh = f.mesh(POSITION=f.accessor(positions), NORMAL=f.accessor(normals), indices=f.accessor(triangles, "H"))
    f.show(f.add("nodes", mesh=mesh, name="a box"))
    f.glb("gltf/box.glb")

    # Every mode, and indices of every width; the triangles have no normals.
    f = File()
    ring = [[math.cos(a * math.pi / 3), math.sin(a * math.pi / 3), 0.0] for a in range(6)]
    ring = [[round(x, 6) for x in p] for p in ring]
    color = f.add("materials", pbrMetallicRoughness={"baseColorFactor": [1, 0.5, 0.1, 1], "metallicFactor": 0})
    nodes = []
    for mode, (form, order) in enumerate(
        [("B", range(6)), ("H", range(6)), ("I", range(6)), ("B", range(6)), ("H", [0, 1, 2, 3, 4, 5]),
         ("I", [0, 1, 5, 2, 4, 3]), (None, None)]
    ):
        indices = f.accessor(list(order), form) if form else None
        mesh = f.mesh(POSITION=f.accessor(ring), indices=indices, mode=mode, material=color)
        nodes.append(f.add("nodes", mesh=mesh, translation=[2.4 * (mode % 4), -2.4 * (mode // 4), 0]))
    f.show(*nodes)
    f.gltf("gltf/modes.gltf")

    # A sphere whose positions are bytes (KHR_mesh_quantization), its poles moved by a sparse accessor.
    f = File()
    points, faces = sphere()
    small = [[round(127 * x) for x in p] for p in points]
    f.json["extensionsUsed"] = f.json["extensionsRequired"] = ["KHR_mesh_quantization"]
    position = f.accessor(small, "b", normalized=True)
    moved = f.view(struct.pack("<2H", 0, len(points) - 1))
    values = f.view(struct.pack("<4b4b", 0, 127, 60, 0, 0, -127, 60, 0))
    f.json["accessors"][position]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": moved, "componentType": 5123},
        "values": {"bufferView": values},
    }
    # Sparse values have no padding in the specification: three bytes an element.
    f.bytes = f.bytes[: f.json["bufferViews"][values]["byteOffset"]] + struct.pack("<3b3b", 0, 127, 60, 0, -127, 60)
    f.json["bufferViews"][values]["byteLength"] = 6
    mesh = f.mesh(POSITION=position, NORMAL=f.accessor(points), indices=f.accessor(faces, "H"))
    f.show(f.add("nodes", mesh=mesh, scale=[2, 1, 2]))
    f.glb("gltf/quantized_sparse.glb")

    # Nodes: matrix, parts, a mirror, a child of a child; a second scene that is not shown.
    f = File()
    mesh = f.mesh(POSITION=f.accessor(positions), NORMAL=f.accessor(normals), indices=f.accessor(triangles, "B"))
    turned = [0, 0, math.sin(math.pi / 8), math.cos(math.pi / 8)]
    tip = f.add("nodes", mesh=mesh, translation=[0, 2.5, 0], rotation=turned, scale=[0.5, 0.5, 0.5])
    arm = f.add("nodes", mesh=mesh, scale=[0.4, 1.0, 0.4], translation=[0, 2, 0], children=[tip])
    shear = [1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1]
    root = f.add("nodes", mesh=mesh, children=[arm])
    mirror = f.add("nodes", mesh=mesh, translation=[-3, 0, 0], scale=[-1, 1, 1])
    sheared = f.add("nodes", mesh=mesh, matrix=shear)
    f.show(f.add("nodes", mesh=mesh))
    f.show(root, mirror, sheared)
    f.json["scene"] = 1
    f.gltf("gltf/nodes.gltf")

    # Colours of vertices as floats, bytes and shorts.
    f = File()
    nodes = []
    for i, (form, full) in enumerate((("f", 1), ("B", 255), ("H", 65535))):
        rgb = [[full, 0, 0], [0, full, 0], [0, 0, full], [full, full, 0]]
        colors = [c + [full] for c in rgb] if form != "f" else rgb
        more = {"normalized": True} if form != "f" else {}
        positions4, uv4, faces4 = QUAD
        mesh = f.mesh(POSITION=f.accessor(positions4), COLOR_0=f.accessor(colors, form, **more),
                      indices=f.accessor(faces4, "B"),
                      material=f.add("materials", extensions={"KHR_materials_unlit": {}}) if i == 0 else
                      f.add("materials", pbrMetallicRoughness={"metallicFactor": 0}))
        nodes.append(f.add("nodes", mesh=mesh, translation=[2.3 * i, 0, 0]))
    f.json["extensionsUsed"] = ["KHR_materials_unlit"]
    f.show(*nodes)
    f.gltf("gltf/vertex_colors.gltf")


def gltf_textures():
    # A folder: the buffer and the picture are files beside.
    positions, normals, uv, triangles = box()
    f = File()
    texture = f.texture({"uri": "four%20colors.png"}, minFilter=9728, magFilter=9728)
    material = f.add("materials", pbrMetallicRoughness=base(texture))
    mesh = f.mesh(POSITION=f.accessor(positions), NORMAL=f.accessor(normals), TEXCOORD_0=f.accessor(uv),
                  indices=f.accessor(triangles, "H"), material=material)
    f.show(f.add("nodes", mesh=mesh))
    put("gltf/beside/four colors.png", png(8, 8, corner_texel))
    put("gltf/beside/box.bin", f.bytes)
    f.gltf("gltf/beside/box.gltf", uri="box.bin")
    put("gltf/four_colors.png", png(8, 8, corner_texel))
    f.json["images"][0]["uri"] = "../four_colors.png"
    f.gltf("gltf/beside/outside.gltf", uri="box.bin")

    # Wraps: repeat, clamp, mirror; filters; coordinates from -1 to 2.
    f = File()
    wide = [[-1, 2], [2, 2], [2, -1], [-1, -1]]
    nodes = []
    for i, (s, t, mag) in enumerate(((10497, 10497, 9728), (33071, 33071, 9728), (33648, 33648, 9728),
                                     (33648, 33071, 9728), (10497, 33648, 9729), (33071, 10497, 9729))):
        texture = f.texture(wrapS=s, wrapT=t, magFilter=mag, minFilter=mag)
        material = f.add("materials", pbrMetallicRoughness=base(texture), extensions={"KHR_materials_unlit": {}})
        nodes.append(f.add("nodes", mesh=quad(f, material, wide), translation=[2.2 * (i % 3), -2.2 * (i // 3), 0]))
    f.json["extensionsUsed"] = ["KHR_materials_unlit"]
    f.show(*nodes)
    f.glb("gltf/wraps.glb")

    # KHR_texture_transform: none, offset, rotation, scale, all, and another set of coordinates.
    f = File()
    nodes = []
    texture = f.texture(magFilter=9728, minFilter=9728)
    for i, transform in enumerate(({}, {"offset": [0.25, 0.5]}, {"rotation": math.pi / 6}, {"scale": [2, 3]},
                                   {"offset": [0.5, 0], "rotation": math.pi / 2, "scale": [1, 2]}, {"texCoord": 1})):
        more = {"extensions": {"KHR_texture_transform": transform}} if transform else {}
        material = f.add("materials", pbrMetallicRoughness=base(texture, **more))
        other = f.accessor([[0, 0], [0, 1], [1, 1], [1, 0]])
        nodes.append(f.add("nodes", mesh=quad(f, material, TEXCOORD_1=other),
                           translation=[2.2 * (i % 3), -2.2 * (i // 3), 0]))
    f.json["extensionsUsed"] = ["KHR_texture_transform"]
    f.show(*nodes)
    f.gltf("gltf/texture_transform.gltf")

    # Alpha: opaque, mask at three cutoffs, blend, blend by the factor; behind them a blue wall.
    f = File()
    wall = f.add("materials", pbrMetallicRoughness={"baseColorFactor": [0.05, 0.1, 0.5, 1], "metallicFactor": 0})
    nodes = [f.add("nodes", mesh=quad(f, wall), scale=[4, 3, 1], translation=[2.2, -1.1, -1])]
    texture = f.texture(magFilter=9728, minFilter=9728)
    for i, alpha in enumerate(({}, {"alphaMode": "MASK"}, {"alphaMode": "MASK", "alphaCutoff": 0.51},
                               {"alphaMode": "MASK", "alphaCutoff": 1.1}, {"alphaMode": "BLEND"},
                               {"alphaMode": "BLEND", "factor": 0.5})):
        factor = [1, 1, 1, alpha.pop("factor", 1)]
        material = f.add("materials", pbrMetallicRoughness={**base(texture), "baseColorFactor": factor}, **alpha)
        nodes.append(f.add("nodes", mesh=quad(f, material), translation=[2.2 * (i % 3), -2.2 * (i // 3), 0]))
    f.show(*nodes)
    f.glb("gltf/alpha.glb")


def gltf_materials():
    # Metallic from left to right, roughness from top to bottom, and a row that is not physical.
    f = File()
    points, faces = sphere(12, 18)
    attributes = {"POSITION": f.accessor(points), "NORMAL": f.accessor(points), "indices": f.accessor(faces, "H")}
    nodes = []
    for row, roughness in enumerate((0.1, 0.4, 1.0)):
        for column, metallic in enumerate((0, 0.5, 1)):
            material = f.add("materials", pbrMetallicRoughness={
                "baseColorFactor": [0.9, 0.35, 0.1, 1], "metallicFactor": metallic, "roughnessFactor": roughness})
            mesh = f.mesh(material=material, **attributes)
            nodes.append(f.add("nodes", mesh=mesh, translation=[2.2 * column, -2.2 * row, 0]))
    unlit = f.add("materials", pbrMetallicRoughness={"baseColorFactor": [0.9, 0.35, 0.1, 1]},
                  extensions={"KHR_materials_unlit": {}})
    glow = f.add("materials", pbrMetallicRoughness={"baseColorFactor": [0, 0, 0, 1]}, emissiveFactor=[0.1, 0.4, 0.1],
                 extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 2.0}})
    glossy = f.add("materials", extensions={"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.1, 0.2, 0.8, 1], "specularFactor": [0.3, 0.3, 0.3], "glossinessFactor": 0.7}})
    for column, material in enumerate((unlit, glow, glossy)):
        nodes.append(f.add("nodes", mesh=f.mesh(material=material, **attributes), translation=[2.2 * column, -6.6, 0]))
    f.json["extensionsUsed"] = ["KHR_materials_unlit", "KHR_materials_emissive_strength",
                                "KHR_materials_pbrSpecularGlossiness"]
    f.show(*nodes)
    f.glb("gltf/materials.glb")

    # The default material, double sided or not: two open boxes seen from inside.
    f = File()
    positions, normals, uv, triangles = box()
    nodes = []
    for i, is_double in enumerate((False, True)):
        material = f.add("materials", doubleSided=is_double)
        mesh = f.mesh(POSITION=f.accessor(positions), NORMAL=f.accessor(normals),
                      indices=f.accessor(triangles[:30], "H"), material=material)
        nodes.append(f.add("nodes", mesh=mesh, translation=[2.5 * i, 0, 0]))
    f.show(*nodes)
    f.gltf("gltf/double_sided.gltf")

    # A metallic-roughness texture by its means; textures that are left out; an extension that is ignored.
    f = File()
    rough = f.texture(texel=lambda x, y: [0, 80, 255 * (x % 2), 255])
    base_texture = f.texture(magFilter=9728, minFilter=9728)
    physical = {"baseColorTexture": {"index": base_texture}, "metallicRoughnessTexture": {"index": rough}}
    material = f.add("materials", pbrMetallicRoughness=physical, normalTexture={"index": rough},
                     extensions={"KHR_materials_clearcoat": {"clearcoatFactor": 1}})
    f.json["extensionsUsed"] = ["KHR_materials_clearcoat"]
    f.show(f.add("nodes", mesh=quad(f, material)))
    f.gltf("gltf/left_out.gltf")


def gltf_cameras_and_lights():
    positions, normals, uv, triangles = box()
    for name, camera in (
        ("perspective", {"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}),
        ("orthographic", {"type": "orthographic", "orthographic": {"xmag": 3, "ymag": 2, "znear": 0.1, "zfar": 50}}),
    ):
        f = File()
        mesh = f.mesh(POSITION=f.accessor(positions), NORMAL=f.accessor(normals), indices=f.accessor(triangles, "H"))
        down = [-math.sin(0.2), 0, 0, math.cos(0.2)]
        eye = f.add("nodes", camera=f.add("cameras", **camera), translation=[0, 3, 6], rotation=down)
        f.show(f.add("nodes", mesh=mesh), f.add("nodes", mesh=mesh, translation=[1.5, 0, -4]), eye)
        f.glb(f"gltf/camera_{name}.glb")

    # A floor under a red point, a green spot and a dim sun.
    f = File()
    floor = f.add("materials", pbrMetallicRoughness={"metallicFactor": 0, "roughnessFactor": 0.9})
    points, faces = sphere(12, 18)
    ball = f.mesh(POSITION=f.accessor(points), NORMAL=f.accessor(points), indices=f.accessor(faces, "H"), material=floor)
    lights = [
        {"type": "point", "color": [1, 0.2, 0.1], "intensity": 12, "range": 8},
        {"type": "spot", "color": [0.2, 1, 0.2], "intensity": 40, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.4}},
        {"type": "directional", "color": [0.6, 0.7, 1], "intensity": 0.4},
    ]
    f.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    f.json["extensionsUsed"] = ["KHR_lights_punctual"]
    flat = [-math.sin(math.pi / 4), 0, 0, math.cos(math.pi / 4)]
    lit = lambda i, **more: f.add("nodes", extensions={"KHR_lights_punctual": {"light": i}}, **more)
    f.show(
        f.add("nodes", mesh=quad(f, floor), scale=[5, 1, 5], rotation=flat),
        f.add("nodes", mesh=ball, translation=[0, 1, 0]),
        lit(0, translation=[-2.5, 1.5, 1]),
        lit(1, translation=[3, 4, 0], rotation=flat),
        lit(2, rotation=[-math.sin(0.5), 0, 0, math.cos(0.5)]),
    )
    f.glb("gltf/lights.glb")


def gltf_animations():
    positions, normals, uv, triangles = box()

    def channel(f, animation, node, path, times, values, interpolation=None):
        sampler = {"input": f.accessor(times), "output": f.accessor(values)}
        if interpolation:
            sampler["interpolation"] = interpolation
        animation["samplers"].append(sampler)
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})

    # Three boxes move by steps, straight, and along a spline; the last turns and grows.
    f = File()
    mesh = f.mesh(POSITION=f.accessor(positions), NORMAL=f.accessor(normals), indices=f.accessor(triangles, "H"))
    nodes = [f.add("nodes", mesh=mesh, scale=[0.4, 0.4, 0.4]) for _ in range(4)]
    animation = {"samplers": [], "channels": []}
    times, ends = [0, 1, 2], [[-2, 0, 0], [0, 1, 0], [2, 0, 0]]
    at = lambda y: [[p[0], p[1] * 0.5 + y, 0] for p in ends]
    channel(f, animation, nodes[0], "translation", times, at(2), "STEP")
    channel(f, animation, nodes[1], "translation", times, at(0.7), "LINEAR")
    flat, steep = [0, 0, 0], [4, 0, 0]
    spline = [row for p in at(-0.6) for row in (flat, p, steep if p[0] == 0 else flat)]
    channel(f, animation, nodes[2], "translation", times, spline, "CUBICSPLINE")
    half = math.sqrt(0.5)
    channel(f, animation, nodes[3], "rotation", times, [[0, 0, 0, 1], [0, 0, half, half], [0, 0, 1, 0]])
    channel(f, animation, nodes[3], "scale", times, [[0.4, 0.4, 0.4], [0.8, 0.3, 0.4], [0.4, 0.4, 0.4]])
    f.json["nodes"][nodes[3]]["translation"] = [0, -2, 0]
    f.json["animations"] = [animation]
    f.show(*nodes)
    f.glb("gltf/animation.glb")

    # A square that is pulled to a kite by a morph target, and another that stays half-way.
    f = File()
    points, uv4, faces4 = QUAD
    move = [{"POSITION": f.accessor([[0, 0, 0], [0, 0, 0], [1, 1, 0], [0, 0, 0]])}]
    mesh = f.mesh(POSITION=f.accessor(points), indices=f.accessor(faces4, "B"), targets=move, weights=[0.5])
    nodes = [f.add("nodes", mesh=mesh), f.add("nodes", mesh=mesh, translation=[3.5, 0, 0])]
    animation = {"samplers": [], "channels": []}
    channel(f, animation, nodes[0], "weights", [0, 1, 2], [0, 1, 0])
    f.json["animations"] = [animation]
    f.show(*nodes)
    f.gltf("gltf/morph.gltf")

    # A strip of three parts on two joints, the upper of which bends.
    f = File()
    rows = [[x, y, 0] for y in (0, 1, 2, 3) for x in (-0.5, 0.5)]
    faces = [i for r in range(3) for i in (2 * r, 2 * r + 1, 2 * r + 3, 2 * r, 2 * r + 3, 2 * r + 2)]
    weights = [[1, 0, 0, 0]] * 4 + [[0.5, 0.5, 0, 0]] * 2 + [[0, 1, 0, 0]] * 2
    material = f.add("materials", doubleSided=True, pbrMetallicRoughness={"metallicFactor": 0})
    mesh = f.mesh(POSITION=f.accessor(rows), indices=f.accessor(faces, "H"), material=material,
                  JOINTS_0=f.accessor([[0, 1, 0, 0]] * 8, "B"), WEIGHTS_0=f.accessor(weights))
    upper = f.add("nodes", translation=[0, 1.5, 0])
    lower = f.add("nodes", children=[upper])
    identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    down = identity[:13] + [-1.5] + identity[14:]
    skin = f.add("skins", joints=[lower, upper], inverseBindMatrices=f.accessor([identity, down]))
    # The node's own matrix does not count.
    skinned = f.add("nodes", mesh=mesh, skin=skin, translation=[9, 9, 9])
    animation = {"samplers": [], "channels": []}
    c, s = round(math.cos(0.6), 6), round(math.sin(0.6), 6)
    channel(f, animation, upper, "rotation", [0, 1, 2], [[0, 0, 0, 1], [0, 0, s, c], [0, 0, 0, 1]])
    f.json["animations"] = [animation]
    f.show(lower, skinned)
    f.glb("gltf/skin.glb")


def gltf_broken():
    positions, _, _, triangles = box()
    f = File()
    f.show(f.add("nodes", mesh=f.mesh(POSITION=f.accessor(positions), indices=f.accessor([*triangles[:-1], 99], "B"))))
    f.gltf("gltf/broken_index.gltf")
    f = File()
    f.show(f.add("nodes", mesh=f.mesh(POSITION=7)))
    f.glb("gltf/broken_accessor.glb")
    # The header's length leaves no room for the header.
    put("gltf/broken_length.glb", struct.pack("<4sII", b"glTF", 2, 4))


def facet_text(points):
    lines = "".join("      vertex {} {} {}\n".format(*p) for p in points)
    return f"  facet normal 0 0 0\n    outer loop\n{lines}    endloop\n  endfacet\n"


def facet_bytes(points):
    return struct.pack("<12fH", 0, 0, 0, *[x for p in points for x in p], 0)


def stl():
    positions, normals, uv, triangles = box()
    cube = [[positions[i] for i in triangles[k : k + 3]] for k in range(0, 36, 3)]
    points, faces = sphere(10, 16)
    ball = [[points[i] for i in faces[k : k + 3]] for k in range(0, len(faces), 3)]
    text = "".join(map(facet_text, cube))
    binary = lambda facets, head=b"": head.ljust(80, b"\0") + struct.pack("<I", len(facets)) + b"".join(map(facet_bytes, facets))
    put("stl/cube_text.stl", f"solid cube\n{text}endsolid cube\n")
    put("stl/cube_binary.stl", binary(cube))
    put("stl/sphere_binary.stl", binary(ball, b"a sphere"))
    put("stl/begins_with_solid.stl", binary(cube, b"solid, but binary"))
    put("stl/upper_case_crlf.stl", f"SOLID\n{text.upper()}ENDSOLID\n".replace("\n", "\r\n"))
    put("stl/two_solids.stl", f"solid a\n{''.join(map(facet_text, cube[:6]))}endsolid a\n"
        f"solid b\n{''.join(facet_text([[x + 3, y, z] for x, y, z in f]) for f in cube)}endsolid b\n")
    put("stl/open_box.stl", binary(cube[:8]))
    put("stl/flat_facets.stl", binary(cube[:2] + [[[0, 0, 0]] * 3, [[0, 0, 0], [1, 1, 1], [2, 2, 2]]] + cube[2:]))
    put("stl/bytes_after.stl", binary(cube) + b"a program's own bytes")
    put("stl/latin_name.stl", b"solid W\xfcrfel\n" + text.encode() + b"endsolid W\xfcrfel\n")
    put("stl/broken_count.stl", binary(cube)[:80] + struct.pack("<I", 4_000_000_000) + binary(cube)[84:])
    put("stl/broken_cut.stl", f"solid cube\n{text}"[:500])


def ply():
    xyz = "property float x\nproperty float y\nproperty float z\n"
    face = "property list uchar int vertex_indices\n"

    def head(form, *elements):
        return f"ply\nformat {form} 1.0\ncomment made by make.py\n" + "".join(elements) + "end_header\n"

    line = lambda *numbers: " ".join(str(n) for n in numbers) + "\n"
    cube = [[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
    rgb = [[(255 if c > 0 else 40) for c in p] for p in cube]
    put("ply/cube_text.ply", head("ascii", f"element vertex 8\n{xyz}", f"element face 6\n{face}")
        + "".join(line(*p) for p in cube) + "".join(line(4, *s) for s in sides))
    colors = "property uchar red\nproperty uchar green\nproperty uchar blue\n"
    for order, sign in (("little", "<"), ("big", ">")):
        body = b"".join(struct.pack(sign + "3f3B", *p, *c) for p, c in zip(cube, rgb))
        body += b"".join(struct.pack(sign + "B4i", 4, *s) for s in sides)
        text = head(f"binary_{order}_endian", f"element vertex 8\n{xyz}{colors}", f"element face 6\n{face}")
        put(f"ply/cube_{order}_endian.ply", text.encode() + body)
    points, faces = sphere(10, 16)
    normals = "property float nx\nproperty float ny\nproperty float nz\n"
    put("ply/sphere_normals.ply", head("binary_little_endian", f"element vertex {len(points)}\n{xyz}{normals}",
        f"element face {len(faces) // 3}\nproperty list uchar ushort vertex_index\n").encode()
        + b"".join(struct.pack("<6f", *p, *p) for p in points)
        + b"".join(struct.pack("<B3H", 3, *faces[k : k + 3]) for k in range(0, len(faces), 3)))
    star = [[round((2 if k % 2 else 0.8) * f(k * math.pi / 5), 6) for f in (math.cos, math.sin)] + [0] for k in range(10)]
    put("ply/star_of_ten_corners.ply", head("ascii", f"element vertex 10\n{xyz}", f"element face 1\n{face}")
        + "".join(line(*p) for p in star) + line(10, *range(10)))
    put("ply/face_colors.ply", head("ascii", f"element vertex 8\n{xyz}", f"element face 6\n{face}{colors}")
        + "".join(line(*p) for p in cube)
        + "".join(line(4, *s, *c) for s, c in zip(sides, ([255, 0, 0], [0, 255, 0], [0, 0, 255]) * 2)))
    put("ply/points.ply", head("ascii", f"element vertex {len(points)}\n{xyz}{colors}")
        + "".join(line(*p, *[round(127 + 127 * c) for c in p]) for p in points))
    edges = [(a, b) for a in range(8) for b in range(a) if (a ^ b) in (1, 2, 4)]
    put("ply/edges.ply", head("ascii", f"element vertex 8\n{xyz}",
        f"element edge {len(edges)}\nproperty int vertex1\nproperty int vertex2\n")
        + "".join(line(*p) for p in cube) + "".join(line(*e) for e in edges))
    strip = [i for k in range(17) for i in (k, k + 17)]
    put("ply/strips.ply", head("ascii", f"element vertex 34\n{xyz}",
        "element tristrips 1\nproperty list int int vertex_indices\n")
        + "".join(line(round(math.sin(k * math.pi / 8), 6), y, round(math.cos(k * math.pi / 8), 6))
                  for y in (1, -1) for k in range(17)) + line(len(strip) + 5, *strip, -1, 0, 4, 8, 12))
    put("ply/other_elements.ply", head("ascii", "element camera 1\nproperty float view_px\nproperty list uchar int v\n",
        f"element vertex 8\n{xyz}property double confidence\n", f"element face 6\n{face}property int flags\n",
        "element material 1\nproperty uchar red\n")
        + "1.5 2 7 8\n" + "".join(line(*p, 0.5) for p in cube) + "".join(line(4, *s, 1) for s in sides) + "9")
    put("ply/broken_count.ply", head("binary_little_endian", f"element vertex 4000000000\n{xyz}"))
    put("ply/broken_index.ply", head("ascii", f"element vertex 8\n{xyz}", f"element face 1\n{face}")
        + "".join(line(*p) for p in cube) + line(4, 0, 1, 2, 8))


if __name__ == "__main__":
    for make in (gltf_meshes, gltf_textures, gltf_materials, gltf_cameras_and_lights, gltf_animations, gltf_broken,
                 stl, ply):
        make()

"""Every verb as a method: none is missing, each does what its text form does, and says what is wrong."""

import json
import struct
import warnings

import pytest

import fbptr
from fbptr import _table
from fbptr._verbs import SERVER_ONLY, WITHOUT_EFFECT

ROWS = _table.rows()
PNG = fbptr.Framebuffer(3, 2).png()
X3D = (
    '<X3D><Scene><Transform><Shape><Appearance><Material/></Appearance><Sphere/></Shape></Transform>'
    "</Scene></X3D>"
)
EYE = json.dumps(
    {
        "dimensions": 2,
        "eye": {"position": [0, 0]},
    }
)


def prepared():
    """Returns a framebuffer that has what the examples name."""
    fb = fbptr.Framebuffer(64, 48)
    fb.mesh("pot", "TEAPOT", 3)
    fb.mesh("shown", "BOX")
    fb.tex("stone", PNG)
    fb.canvas("hero", 16, 16)
    fb.scene(X3D)
    return fb


def payload_of(row):
    """Returns the payload for the verb's example that is valid."""
    return {"IMAGE": PNG, "TEX": PNG, "SCENE": X3D.encode(), "BLIT": b"RGBA", "TEXT": b"hello"}.get(row.verb)


def number(word):
    """Returns a word as the number that it is, or unchanged: six digits are a colour."""
    if len(word) in (6, 8) and word.isalnum():
        return word
    for kind in (int, float):
        try:
            return kind(word)
        except ValueError:
            pass
    return word


def test_no_verb_is_missing_and_each_is_documented():
    for row in ROWS:
        method = getattr(fbptr.Framebuffer, row.name)
        for syntax, about in row.forms:
            assert syntax in method.__doc__ and about in method.__doc__, row.name
        for parameter in row.parameters:
            assert "\n%s: " % parameter.name in method.__doc__, (row.name, parameter.name)
    assert len({row.name for row in ROWS}) == len(ROWS) >= 70


def test_each_example_as_a_method_is_the_example_as_text():
    skipped = set(SERVER_ONLY) | {"HELP", "STATS", "LOAD", "EYE", "DRAWEYE", "SNAP", "SIZE"}
    compared = 0
    for row in ROWS:
        if row.is_binary or row.verb in skipped:
            continue
        text, by_method = prepared(), prepared()
        line = row.example.split("\n")[0]
        words = line.split(" ")[1:]
        payload = payload_of(row)
        if words and words[-1].startswith(":"):
            words.pop()
            payload = payload or row.example.split("\n", 1)[1].encode("latin-1")
            line = "%s :%d\n" % (" ".join([row.verb, *words]), len(payload))
        else:
            line, payload = line + "\n", None
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if row.verb == "POP":
                text.push(), by_method.push()
            reply = text.run(line.encode() + (payload or b""))
            if row.parameters and row.parameters[-1].kind == "text":
                words = line.rstrip("\n").split(" ", len(row.parameters))[1:]
            values = [number(word) for word in words]
            answer = getattr(by_method, row.name)(*values, *([payload] if payload else []))
            # A state shows by what it does to a draw.
            text.draw("shown"), by_method.draw("shown")
            text.line(0, 40, 63, 2, "#ff000080"), by_method.line(0, 40, 63, 2, "#ff000080")
        assert by_method.crc() == text.crc(), row.verb
        # LIGHT returns the index; nothing is seen at the pixel that PICK asks for.
        assert (answer is None) == (reply == b"") or row.verb in ("LIGHT", "PICK"), (row.verb, answer, reply)
        compared += 1
    assert compared > 55


def test_binary_verbs():
    fb = fbptr.Framebuffer(8, 8)
    fb.pb(3, 2, "#01020304")
    fb.pxmulti(7, 2, bytes(range(8)))
    assert fb.read(3, 2, 1, 1) == bytes((1, 2, 3, 4))
    assert fb.read(7, 2, 1, 1) + fb.read(0, 3, 1, 1) == bytes(range(8))
    for wrong in (lambda: fb.pb(-1, 0, "red"), lambda: fb.pb(0, 65536, "red"), lambda: fb.pb(0, 0, "zz")):
        with pytest.raises(fbptr.CommandError):
            wrong()
    with pytest.raises(fbptr.CommandError) as caught:
        fb.pxmulti(0, 0, b"abc")
    assert caught.value.code == "EFORMAT"


def drawn(*calls):
    """Returns the CRC-32 after each call on a framebuffer of its own."""
    found = []
    for call in calls:
        fb = fbptr.Framebuffer(64, 48)
        call(fb)
        found.append(fb.crc())
    assert found[0] != fbptr.Framebuffer(64, 48).crc(), "nothing was drawn"
    return found


def same(*calls):
    found = drawn(*calls)
    assert len(set(found)) == 1, found


def test_arguments_may_be_given_as_a_python_program_has_them():
    numpy = pytest.importorskip("numpy")
    points = [(2, 2), (60, 8), (30, 46)]
    same(
        lambda fb: fb.line(1, 2, 60, 40, "red"),
        lambda fb: fb.line((1, 2), (60, 40), "red"),
        lambda fb: fb.line([1, 2], [60, 40], (255, 0, 0)),
        lambda fb: fb.line(1.0, 2.0, 60.0, 40.0, "#ff0000"),
        lambda fb: fb.line(x0=1, y0=2, x1=60, y1=40, c0="#f00"),
        lambda fb: fb.line(p0=(1, 2), p1=(60, 40), color="ff0000ff"),
        lambda fb: fb.line(1, 2, 60, 40, color=b"\xff\0\0"),
        lambda fb: fb.line(numpy.int32(1), numpy.uint8(2), numpy.float64(60), 40, numpy.array([255, 0, 0])),
        lambda fb: fb.line(*numpy.array([(1, 2), (60, 40)]), "red", None),
    )
    same(
        lambda fb: fb.fill(points, ["red", "lime", "blue"]),
        lambda fb: fb.fill(points, "red", "lime", "blue"),
        lambda fb: fb.fill(2, 2, 60, 8, 30, 46, "red", "lime", "blue"),
        lambda fb: fb.fill(numpy.array(points, float), [(255, 0, 0), (0, 255, 0), (0, 0, 255)]),
        lambda fb: fb.fill(points=points, colors=("red", "lime", "blue")),
        lambda fb: fb.fill((p for p in points), colours=iter(["red", "lime", "blue"])),
    )
    same(
        lambda fb: fb.poly("white", 8, 6, 40, 10, 20, 40),
        lambda fb: fb.poly([(8, 6), (40, 10), (20, 40)], "white"),
        lambda fb: fb.poly((255, 255, 255), (8, 6), (40, 10), (20, 40)),
        lambda fb: fb.poly(points=[(8, 6), (40, 10), (20, 40)], color="white"),
    )
    same(
        lambda fb: fb.circle(32, 24, 20, "gold"),
        lambda fb: fb.circle((32, 24), 20, "gold"),
        lambda fb: fb.circle(center=(32, 24), radius=20, color="gold"),
        lambda fb: fb.circle(cx=32, cy=24, r=20, c="gold"),
    )
    same(
        lambda fb: fb.text(8, 8, "white", "hé\nllo"),
        lambda fb: fb.text((8, 8), "white", "hé\nllo"),
        lambda fb: fb.text(at=(8, 8), color="white", text="hé\nllo"),
        lambda fb: fb.text(8, 8, "white", "hé\nllo".encode()),
    )
    same(
        lambda fb: fb.fillrect(3, 4, 20, 10, "teal"),
        lambda fb: fb.fillrect((3, 4, 20, 10), "teal"),
        lambda fb: fb.fillrect(rect=(3, 4, 20, 10), c="teal"),
        lambda fb: fb.fillrect((3, 4), (20, 10), "teal"),
    )
    picture = numpy.arange(4 * 5 * 4, dtype=numpy.uint8).reshape(4, 5, 4)
    same(
        lambda fb: fb.blit(1, 2, 5, 4, picture.tobytes()),
        lambda fb: fb.blit(1, 2, picture),
        lambda fb: fb.blit(1, 2, 5, 4, picture),
        lambda fb: fb.blit(1, 2, 5, 4, rgba=memoryview(picture.tobytes())),
    )
    assert (lambda fb: fb.array(0, 0, 5, 4).shape)(fbptr.Framebuffer(8, 8)) == (4, 5, 4)


def test_long_lists_are_not_bounded_by_the_length_of_a_line():
    fb = fbptr.Framebuffer(64, 48)
    fb.poly([(i % 64, i * 7 % 48) for i in range(5000)], "white")
    data = bytes(i % 251 for i in range(64 * 48 * 4))
    fb.poke(0, data)
    assert fb.read() == data == fb.peek(0, len(data))


def test_three_dimensions():
    def scene(*calls):
        def run(fb):
            fb.mesh("m", fbptr.box(2, 1, 1))
            fb.lookat(3, 2, 5)
            fb.light("point", (5, 6, 7))
            for call in calls:
                call(fb)
            fb.draw("m", shade="phong")

        return run

    same(
        scene(),
        scene(lambda fb: fb.mesh("m", "BOX", 2, 1, 1)),
        scene(lambda fb: fb.mesh("m", "box", 2, 1, 1)),
        scene(lambda fb: fb.lookat((3, 2, 5), (0, 0, 0), (0, 1, 0))),
        scene(lambda fb: fb.lookat(eye=(3, 2, 5), at=(0, 0, 0), up=(0, 1, 0))),
        scene(lambda fb: fb.lookat(3, 2, 5, 0, 0, 0, 0, 1, 0)),
        scene(lambda fb: fb.light(0, "POINT", 5, 6, 7, 1, 1, 1)),
        scene(lambda fb: fb.light("point", (5, 6, 7), index=0, color="white", attenuation=(1, 0, 0))),
        scene(lambda fb: fb.material(kd=0.8)),
        scene(lambda fb: fb.material(0, 0.8, 0, 1)),
        scene(lambda fb: fb.material(ka=0, kd=(0.8, 0.8, 0.8), ks="black", n=1)),
        scene(lambda fb: fb.matrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])),
        scene(lambda fb: fb.scale(1)),
        scene(lambda fb: fb.rotate("y", 0)),
        scene(lambda fb: fb.rotate(0, 1, 0, "0deg")),
        scene(lambda fb: fb.rotate(axis=(0, 1, 0), angle=0.0)),
        scene(lambda fb: fb.perspective()),
        scene(lambda fb: fb.perspective("45deg", 0.1, 100)),
    )
    fb = fbptr.Framebuffer(64, 48)
    assert [fb.light("dir", (0, -1, 0)), fb.light("spot", (0, 3, 0), (0, -1, 0), 0.4, 2)] == [0, 1]
    fb.light("off", index=0)
    assert fb.light("point", 1, 2, 3) == 0
    fb.light("off")
    assert fb.light("point", (1, 2, 3), "gold") == 0


def test_states_of_one_draw_are_set_back():
    fb = fbptr.Framebuffer(64, 48)
    fb.lookat((3, 2, 5))
    fb.light("point", (5, 6, 7))
    fb.draw(fbptr.sphere())
    plain = fb.crc()
    fb.clear()
    fb.draw(fbptr.sphere(), shade="flat", material={"kd": "red"}, rotate=("x", 1), scale=0.5, hide="painter", cull="none")
    assert fb.crc() != plain
    with pytest.raises(fbptr.CommandError):
        fb.draw("no such mesh", shade="flat")
    with pytest.raises(fbptr.CommandError):
        fb.draw(fbptr.sphere(), shade="pretty")
    with pytest.raises(fbptr.CommandError) as caught:
        fb.draw(fbptr.sphere(), sahde="flat")
    assert "sahde" in str(caught.value)
    fb.clear()
    fb.draw(fbptr.sphere())
    assert fb.crc() == plain


def test_meshes_and_scenes_of_files(tmp_path):
    path = tmp_path / "quad.obj"
    text = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n"
    path.write_text(text)
    vertices = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]

    def draw(source, **kwargs):
        def run(fb):
            fb.mesh("q", source, **kwargs)
            fb.lookat((0, 0, 5))
            fb.light("point", (0, 0, 5))
            fb.draw("q")

        return run

    same(
        draw(path), draw(str(path)), draw(text), draw(text.encode()), draw(fbptr.obj(path)),
        draw(fbptr.faces(vertices, [(0, 1, 2, 3)])), draw(None, vertices=vertices, faces=[(0, 1, 2, 3)]),
    )
    x3d = tmp_path / "scene.x3d"
    x3d.write_text(X3D)
    same(
        lambda fb: (fb.scene(X3D), fb.drawscene()),
        lambda fb: (fb.scene(X3D.encode()), fb.drawscene(0)),
        lambda fb: (fb.scene(x3d), fb.drawscene(time=0.0, sorted=False)),
        lambda fb: (fb.scene("X3D", X3D), fb.drawscene()),
    )
    picture = tmp_path / "picture.png"
    picture.write_bytes(PNG)
    same(lambda fb: (fb.clear("red"), fb.image(1, 2, PNG)), lambda fb: (fb.clear("red"), fb.image(1, 2, str(picture))))
    with pytest.raises(FileNotFoundError):
        fbptr.Framebuffer(8, 8).mesh("m", tmp_path / "none.obj")


def test_replies_are_python_values():
    fb = fbptr.Framebuffer(64, 48)
    fb.mesh("pot", fbptr.teapot(4))
    fb.lookat((0, 2, 8), reference=(0, 1, 0))
    fb.light("point", (5, 6, 7))
    fb.draw("pot")
    assert fb.size() == (64, 48) == (fb.width, fb.height)
    assert fb.px(0, 0) == (0, 0, 0) and fb.get_pixel(0, 0) == (0, 0, 0, 255)
    assert fb.px((1, 0), "red") is None and fb.px((1, 0)) == (255, 0, 0)
    assert fb.px(2, 0, color=b"\1\2\3") is None and fb.px((2, 0), None) == (1, 2, 3)
    assert fb.peek(0, 4) == b"\0\0\0\xff" and fb.peek(0, 0) == b""
    assert len(fb.read()) == len(fb) == 64 * 48 * 4 and len(fb.read(60, 40)) == 4 * 8 * 4
    assert 0 < fb.depthat(32, 24) < 1 == fb.depthat(0, 0)
    assert fb.pick(32, 24)[0] == "pot" and fb.pick(0, 0) is None
    assert fb.stats()["width"] == 64 and fb.sync("tag") == "tag" and fb.hello()[0] == "fbptr"
    assert fb.version() == ["fbptr", fbptr.__version__]
    assert "LINE" in fb.help() and "LINE x0" in fb.help("LINE")
    assert fb.present() is None and fb.present(wait=True) == 2
    assert fb.snap()[:4] == b"\x89PNG" and isinstance(fb.crc(), int)
    numpy = pytest.importorskip("numpy")
    z = fb.depth()
    assert z.shape == (48, 64) and z.dtype == numpy.float64 and abs(z[24, 32] - fb.depthat(32, 24)) < 1e-8
    fb.depth("u24")
    assert (fb.depth() == 1).all()


def test_a_refused_command_has_code_and_place():
    fb = fbptr.Framebuffer(64, 48)
    cases = [
        (lambda: fb.line(1, 2), "EARGS", TypeError),
        (lambda: fb.line(1, 2, 3, 4, "red", "lime", "blue"), "EARGS", TypeError),
        (lambda: fb.line(1, 2, 3, 4, "red", colour="blue", nonsense=1), "EARGS", TypeError),
        (lambda: fb.line(1, 2, 3, 4.5, "red"), "ENUM", ValueError),
        (lambda: fb.line(1, 2, 3, object(), "red"), "ENUM", ValueError),
        (lambda: fb.fill([(0, 0), (1, float("nan")), (1, 1)], "red"), "ENUM", ValueError),
        (lambda: fb.line(0, 0, 1 << 40, 0, "red"), "ENUM", ValueError),
        (lambda: fb.line(1, 2, 3, 4, "no colour"), "EARGS", TypeError),
        (lambda: fb.clear("nocolour"), "ECOLOUR", ValueError),
        (lambda: fb.clear((1, 2)), "ECOLOUR", ValueError),
        (lambda: fb.clear((1, 2, 256)), "ECOLOUR", ValueError),
        (lambda: fb.clear(0.5), "ECOLOUR", ValueError),
        (lambda: fb.circle(1, 2, -3, "red"), "ERANGE", ValueError),
        (lambda: fb.px(64, 0), "ERANGE", ValueError),
        (lambda: fb.draw("pot"), "ENOENT", LookupError),
        (lambda: fb.draw("pot\nCLEAR red"), "EARGS", TypeError),
        (lambda: fb.free(""), "EARGS", TypeError),
        (lambda: fb.print(0, 0, "red", "one\nCLEAR"), "EARGS", TypeError),
        (lambda: fb.mesh("m"), "EARGS", TypeError),
        (lambda: fb.mesh("m", b"f 1 2 3\n"), "EFORMAT", ValueError),
        (lambda: fb.tex("t", b"no picture"), "EFORMAT", ValueError),
        (lambda: fb.shade("pretty"), "EARGS", TypeError),
        (lambda: fb.light("lamp", (1, 2, 3)), "EARGS", TypeError),
        (lambda: fb.light("point", (1, 2)), "EARGS", TypeError),
        (lambda: fb.lookat((0, 0, 0)), "ERANGE", ValueError),
        (lambda: fb.pop(), "ERANGE", ValueError),
        (lambda: fb.load("MESH", "m", "m.obj"), "EPERM", Exception),
        (lambda: fb.snap("a.png"), "EPERM", Exception),
        (lambda: fb.blit(0, 0, 2, 2, b"1234"), "EFORMAT", ValueError),
        (lambda: fb.textsize(99), "ERANGE", ValueError),
    ]
    before = fb.crc()
    for number, (call, code, kind) in enumerate(cases):
        with pytest.raises(fbptr.CommandError) as caught:
            call()
        error = caught.value
        assert error.code == code and isinstance(error, kind), (number, code, error)
        assert code in str(error) and error.verb and error.reason, (number, error)
    assert fb.crc() == before
    nested = []
    nested.append(nested)
    with pytest.raises(fbptr.CommandError):
        fb.line(nested, 1, 2, 3, "red")
    for width, height in ((0, 5), (40000, 5)):
        with pytest.raises(fbptr.CommandError):
            fbptr.Framebuffer(width, height)
    with pytest.raises((TypeError, OverflowError)):
        fbptr.Framebuffer(-1, 5)
    with pytest.raises(TypeError):
        fbptr.Framebuffer("a", 5)


def test_verbs_of_a_server_say_why_they_do_not_run_here():
    fb = fbptr.Framebuffer(8, 8)
    for verb in SERVER_ONLY:
        with pytest.raises(fbptr.CommandError) as caught:
            getattr(fb, verb.lower())()
        assert caught.value.code == "EPERM"
    for verb, value in zip(WITHOUT_EFFECT, ("title", 0, True)):
        assert getattr(fb, verb.lower())(value) is None


def test_text_streams():
    fb = fbptr.Framebuffer(8, 8)
    assert fb.run("CLEAR red\nPX 1 1\nSIZE") == "PX 1 1 ff0000\nSIZE 8 8\n"
    assert fb.run(b"READ 0 0 1 1\n") == b"READ 0 0 1 1 :4\n\xff\0\0\xff"
    assert fb.run("READ 0 0 1 1").encode("utf-8", "surrogateescape").endswith(b"\xff\0\0\xff")
    assert fb.run("BLIT 0 0 1 1 :4\nabcd") == "" and fb.px(0, 0) == (97, 98, 99)
    assert fb.run(b"PB" + struct.pack("<HH4B", 2, 3, 1, 2, 3, 4)) == b"" and fb.get_pixel(2, 3) == (1, 2, 3, 4)
    assert fb.run("") == ""
    # States go on from one text to the next, and to the methods.
    fb.run("BLEND over\nOFFSET 1 1")
    fb.px(0, 0, "ffffff")
    assert fb.run("OFFSET 0 0\nPX 1 1") == "PX 1 1 ffffff\n"
    with pytest.raises(fbptr.CommandError) as caught:
        fb.run("# a comment\nLIEN 1\nSIZE\nLINE 0 0 1 1 zz\nPX 0 0 0000ff\n")
    error = caught.value
    assert [(e[0], e[1], e[2]) for e in error.errors] == [(2, 12, "EVERB"), (4, 24, "ECOLOUR")]
    assert (error.line, error.code, error.replies) == (2, "EVERB", b"SIZE 8 8\n")
    assert fb.px(0, 0) == (0, 0, 255), "the commands after a refused one run"
    with pytest.raises(fbptr.CommandError) as caught:
        fb.run("TEXT 0 0 red :99\nshort")
    assert caught.value.code == "EPROTO"
    assert fb.run("QUIT\nCLEAR red") == "" and fb.px(0, 0) == (0, 0, 255)
    fb.clear("lime")
    assert fb.px(0, 0) == (0, 255, 0)


def test_offsets():
    fb = fbptr.Framebuffer(8, 4)
    at = (8 * 2 + 3) * 4
    fb[at] = 9
    fb[at + 1 : at + 4] = (8, 7, 6)
    assert fb[at : at + 4] == bytes((9, 8, 7, 6)) == fb.read(3, 2, 1, 1)
    assert fb[at] == 9 and fb[-1] == 255 and len(fb) == 128 and fb[::4][:2] == b"\0\0"
    fb[0::4] = bytes(range(32))
    assert fb[4 * 31] == 31 and fb[124:0:-4][0] == 31
    for wrong in (128, -129, 1 << 70):
        with pytest.raises(IndexError):
            fb[wrong]
        with pytest.raises(IndexError):
            fb[wrong] = 1
    for value in (256, -1, "a", 1.5, None):
        with pytest.raises(ValueError):
            fb[0] = value
    with pytest.raises(ValueError):
        fb[0:4] = b"abc"
    for index in ("a", 1.0, None, (1, 2)):
        with pytest.raises(TypeError):
            fb[index]


def test_traces_and_plans():
    fb = fbptr.Framebuffer(64, 48)
    assert "no 3-D draw" in fb.trace(32, 24) and "nothing is drawn in 3-D" in fb.explain()
    fb.lookat((3, 2, 5))
    fb.light("point", (5, 6, 7))
    fb.mesh("ball", fbptr.sphere())
    fb.draw("ball", shade="phong")
    text = fb.trace(32, 24)
    r, g, b, a = fb.get_pixel(32, 24)
    assert '"ball"' in text and "%d %d %d %d = #%02x%02x%02x at FBptr[6272]" % (r, g, b, a, r, g, b) in text
    assert fb.trace((32, 24)) == text and "0 0 0 255 = #000000 at FBptr[0]" in fb.trace(0, 0)
    assert "triangle 0 " in fb.trace(triangle=0) and "no draw" in fb.trace(triangle=10**6)
    assert "off the frame" in fb.trace(-1, 0) and "off the frame" in fb.trace(0, 48)
    assert "light pixels" in fb.explain()
    fb.clear()
    assert "no 3-D draw" in fb.trace(32, 24)
    fb.line((0, 0), (63, 47), "red")
    assert "line (0, 0) (63, 47)" in fb.trace(0, 0) and "decision" in fb.trace(0, 0)


def test_batches_draw_what_their_verbs_draw():
    numpy = pytest.importorskip("numpy")
    rows = numpy.random.default_rng(7).integers(-20, 90, (200, 4))
    colors = numpy.random.default_rng(8).integers(0, 256, (200, 4)).astype(numpy.uint8)
    fb, one = fbptr.Framebuffer(64, 48), fbptr.Framebuffer(64, 48)
    for both in (fb, one):
        both.blend("over")
    ways = {
        "lines": (rows, lambda r, c: one.line(*map(int, r), c)),
        "rects": (abs(rows) * 0.5, lambda r, c: one.fillrect(*r, c)),
        "discs": (abs(rows[:, :3]) * 0.25, lambda r, c: one.fillcircle(*r, c)),
        "points": (rows[:, :2], lambda r, c: one.px(int(r[0]), int(r[1]), c)),
    }
    for name, (numbers, each) in ways.items():
        for taken in (colors, colors[:, :3], "#ff800080"):
            getattr(fb, name)(numbers, taken)
            for i, row in enumerate(numbers):
                each(row, taken if isinstance(taken, str) else tuple(map(int, taken[i])))
            assert fb.crc() == one.crc(), name
    fb.clear()
    fb.lines([(0, 0, 63, 47), (0, 47, 63, 0)], ["red", (0, 255, 0)])
    one.clear()
    one.line(0, 0, 63, 47, "red")
    one.line(0, 47, 63, 0, "#00ff00")
    assert fb.crc() == one.crc()
    for call in (
        lambda: fb.lines([(0, 0, 5)], "red"),
        lambda: fb.lines([(0, 0, 5, 0.5)], "red"),
        lambda: fb.lines([(0, 0, 5, 3e9)], "red"),
        lambda: fb.discs([(0, 0, float("nan"))], "red"),
        lambda: fb.lines([(0, 0, 5, 5)] * 3, ["red", "lime"]),
    ):
        with pytest.raises(ValueError):
            call()
    with pytest.raises(fbptr.CommandError):
        fb.lines([(0, 0, 5, 5)], "no colour")
    with pytest.raises(fbptr.CommandError):
        fb.discs([(0, 0, -1)], "red")


def test_methods_have_signatures_and_second_names():
    import inspect

    assert str(inspect.signature(fbptr.Framebuffer.line)) == "(self, /, x0, y0, x1, y1, c0, c1=None)"
    fb = fbptr.Framebuffer(64, 48)
    assert str(inspect.signature(fb.fill_circle)) == "(cx, cy, r, c)"
    fb.fill_circle(32, 24, 9, "red")
    drawn = fb.crc()
    fb.clear()
    fb.fillcircle(32, 24, 9, "red")
    assert fb.crc() == drawn


def test_errors_of_files_name_save(tmp_path):
    fb = fbptr.Framebuffer(64, 48)
    with pytest.raises(fbptr.CommandError, match="save") as caught:
        fb.save(tmp_path / "a.jpg")
    assert "SNAP" not in str(caught.value) and caught.value.verb == "save"


def test_a_draw_that_shows_nothing_warns():
    fb = fbptr.Framebuffer(64, 48)
    fb.mesh("ball", fbptr.sphere())
    fb.lookat((0, 0, 500))
    with pytest.warns(fbptr.CommandWarning, match="DRAW"):
        fb.draw("ball")


def test_files(tmp_path):
    fb = fbptr.Framebuffer(8, 6, files=tmp_path)
    fb.clear("gold")
    for name in ("a.png", "a.ppm", "a.raw", "a.pfm"):
        fb.save(tmp_path / name)
        assert (tmp_path / name).stat().st_size > 0
    with pytest.raises(fbptr.CommandError):
        fb.save(tmp_path / "a.xyz")
    with pytest.raises(OSError):
        fb.save(tmp_path / "no" / "folder" / "a.png")
    assert fb.snap("b.png") == (8, 6, fb.crc())
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    fb.load("MESH", "m", "m.obj")
    fb.run("LOAD MESH n m.obj")
    with pytest.raises(fbptr.CommandError) as caught:
        fb.load("MESH", "m", "../m.obj")
    assert caught.value.code in ("EPERM", "ENOENT", "EARGS")
    with pytest.raises(OSError):
        fbptr.Framebuffer(8, 6, files=tmp_path / "none")


def test_threads_and_framebuffers_of_any_number():
    def draw(threads):
        fb = fbptr.Framebuffer(200, 150, threads=threads)
        fb.mesh("knot", fbptr.knot(100, 20))
        fb.lookat((0, 0, 9))
        fb.light("point", (5, 6, 7))
        fb.draw("knot", shade="phong")
        return fb.crc()

    assert len({draw(1), draw(2), draw(0)}) == 1


def test_what_is_no_text_is_refused_and_errors_of_files_have_their_numbers(tmp_path):
    fb = fbptr.Framebuffer(8, 8)
    with pytest.raises(TypeError, match="str or bytes, got 3"):
        fb.run(3)
    with pytest.raises(FileNotFoundError) as caught:
        fb.save(tmp_path / "nowhere" / "a.png")
    assert caught.value.errno == 2 and caught.value.filename.endswith("a.png")
    with pytest.raises(fbptr.CommandError) as refused:
        fb.quit()
    assert type(refused.value).__name__ == "RefusedError" and refused.value.code == "EPERM"

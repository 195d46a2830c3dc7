"""Views of the memory, and threads: what is allowed, and what raises."""

import copy
import pickle
import threading
import zlib

import pytest

import fbptr

numpy = pytest.importorskip("numpy")


def in_thread(call):
    """Calls a function on another thread; returns its result or its exception."""
    found = []

    def run():
        try:
            found.append(call())
        except BaseException as error:
            found.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join(60)
    assert found, "the thread has not ended"
    return found[0]


def scene(fb, i):
    fb.clear()
    fb.mesh("knot", fbptr.knot(60, 12))
    fb.lookat((0, 0, 9))
    fb.identity()
    fb.rotate("y", i / 3)
    fb.light("point", (5, 6, 7), index=0)
    fb.draw("knot", shade="phong")
    return fb.crc()


def test_a_view_is_the_memory_and_lives_as_long_as_it_is_used():
    fb = fbptr.Framebuffer(7, 5)
    a = fb.numpy()
    b = numpy.asarray(fb)
    assert numpy.shares_memory(a, b)
    fb.fillrect(0, 0, 7, 5, "#010203")
    assert (a[..., 0] == 1).all() and (b[..., 2] == 3).all()
    view = memoryview(fb)
    assert (view.shape, view.strides, view.format, view.readonly) == ((5, 7, 4), (28, 4, 1), "B", False)
    assert view.c_contiguous and view.nbytes == len(fb) == 7 * 5 * 4
    copy = fb.numpy(copy=True)
    assert not numpy.shares_memory(a, copy)
    # The array keeps its framebuffer.
    crc = fb.crc()
    del fb, view, b
    assert zlib.crc32(a) == crc


def test_no_verb_moves_the_memory():
    fb = fbptr.Framebuffer(64, 48)
    a = fb.numpy()
    address = a.__array_interface__["data"][0]
    fb.canvas("c", 100, 100)
    fb.target("c")
    fb.clear("red")
    assert tuple(a[0, 0]) == (0, 0, 0, 255), "the view is the frame's, whatever the target is"
    fb.target()
    fb.stamp("c", 0, 0)
    scene(fb, 1)
    fb.run("CLEAR gold\nPX 3 4 123456\n")
    assert fb.numpy().__array_interface__["data"][0] == address
    assert tuple(a[4, 3]) == (0x12, 0x34, 0x56, 255)


def test_another_thread_may_not_draw_while_a_view_is_held():
    fb = fbptr.Framebuffer(64, 48)
    a = fb.numpy()
    for call in (
        lambda: fb.clear("red"),
        lambda: fb.px(0, 0, "red"),
        lambda: fb.run("CLEAR red"),
        lambda: fb.crc(),
        lambda: fb[0],
        lambda: fb.__setitem__(0, 1),
        lambda: fb.png(),
        lambda: fb.numpy(),
        lambda: memoryview(fb),
    ):
        error = in_thread(call)
        assert isinstance(error, BufferError) and "numpy(copy=True)" in str(error), error
    assert a.max() == 255 and a[..., :3].max() == 0
    fb.clear("red")
    assert a[..., 0].min() == 255
    del a
    assert in_thread(lambda: fb.clear("blue")) is None
    assert fb.get_pixel(0, 0) == (0, 0, 255, 255)


def test_a_view_of_another_thread_is_its_own():
    fb = fbptr.Framebuffer(64, 48)
    held = in_thread(fb.numpy)
    with pytest.raises(BufferError):
        fb.clear()
    assert held.shape == (48, 64, 4)
    del held
    fb.clear()


def test_a_view_waits_for_the_draw_of_another_thread():
    fb = fbptr.Framebuffer(640, 480)
    fb.mesh("knot", fbptr.knot(400, 60))
    fb.lookat((0, 0, 9))
    fb.light("point", (5, 6, 7))
    fb.draw("knot", shade="phong")
    whole = fb.crc()
    refused, crcs, stop = [], [], threading.Event()

    def draw():
        while not stop.is_set():
            try:
                fb.clear()
                fb.draw("knot", shade="phong")
            except BufferError as error:
                refused.append(error)

    thread = threading.Thread(target=draw)
    thread.start()
    try:
        for _ in range(40):
            try:
                view = fb.numpy()
            except BufferError as error:
                refused.append(error)
                continue
            # Whoever holds a view sees the memory between two calls: nothing changes meanwhile.
            first = zlib.crc32(view)
            crcs.append((first, zlib.crc32(view)))
            del view
    finally:
        stop.set()
        thread.join(60)
    assert crcs and all(first == second for first, second in crcs)
    cleared = zlib.crc32(bytes((0, 0, 0, 255)) * (640 * 480))
    assert {first for first, _ in crcs} <= {whole, cleared}


def test_a_copy_is_of_one_moment_and_stops_no_other_thread():
    fb = fbptr.Framebuffer(640, 480)
    colours = [(10, 0, 0), (0, 20, 0), (0, 0, 30)]
    refused, stop = [], threading.Event()

    def draw():
        i = 0
        while not stop.is_set():
            i += 1
            try:
                fb.clear(colours[i % 3])
            except BufferError as error:
                refused.append(error)

    fb.clear(colours[0])
    thread = threading.Thread(target=draw)
    thread.start()
    try:
        copies = [fb.numpy(copy=True) for _ in range(300)]
    finally:
        stop.set()
        thread.join(60)
    assert not refused, "a copy holds no view while another thread draws"
    assert all(a.flags.writeable and a.flags.c_contiguous for a in copies)
    whole = {(*colour, 255) for colour in colours}
    assert {tuple(a[0, 0]) for a in copies} <= whole
    assert all((a == a[0, 0]).all() for a in copies), "a copy of half a picture"


def test_threads_with_framebuffers_of_their_own_draw_the_same_bytes():
    alone = [scene(fbptr.Framebuffer(160, 120), i) for i in range(8)]
    together = [None] * 8

    def work(i):
        fb = fbptr.Framebuffer(160, 120)
        for _ in range(5):
            together[i] = scene(fb, i)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    [t.start() for t in threads]
    [t.join(120) for t in threads]
    assert together == alone


def test_calls_of_threads_on_one_framebuffer_run_one_after_the_other():
    fb = fbptr.Framebuffer(64, 64)

    def work(i):
        for _ in range(200):
            fb.fillrect(8 * i, 0, 8, 64, (i, i, i))
            fb.pixel(8 * i, 0, (i, i, i))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
    [t.start() for t in threads]
    [t.join(60) for t in threads]
    assert [fb.px(8 * i, 63) for i in range(8)] == [(i, i, i) for i in range(8)]
    assert fb.stats()["errors"] == 0


def test_other_threads_run_while_one_draws():
    fb = fbptr.Framebuffer(1600, 1200)
    fb.mesh("knot", fbptr.knot(600, 100))
    fb.lookat((0, 0, 9))
    fb.light("point", (5, 6, 7))
    counted, counts, stop = [0], [], threading.Event()

    def draw():
        for _ in range(3):
            fb.clear()
            before = counted[0]
            fb.draw("knot", shade="phong")
            counts.append(counted[0] - before)
        stop.set()

    thread = threading.Thread(target=draw)
    thread.start()
    while not stop.is_set():
        counted[0] += 1
    thread.join(60)
    assert max(counts) > 0, "no other thread ran during a draw"


def test_a_released_view_gives_the_framebuffer_back():
    fb = fbptr.Framebuffer(8, 8)
    with memoryview(fb) as view:
        view[0, 0, 0] = 7
        assert fb[0] == 7
        assert isinstance(in_thread(fb.clear), BufferError)
    assert in_thread(fb.clear) is None
    for _ in range(1000):
        assert fb.numpy()[0, 0, 3] == 255


def test_a_framebuffer_and_a_scene_say_how_they_are_sent():
    scene = fbptr.Scene.load(b"v 0 0 0\nv 2 0 0\nv 0 1 1\nf 1 2 3\n", format="obj")
    for made, expected in ((fbptr.Framebuffer(4, 4), r"fb\.png\(\)"), (scene, "path or bytes")):
        for call in (pickle.dumps, copy.copy, copy.deepcopy):
            with pytest.raises(TypeError, match=expected):
                call(made)
    mesh = fbptr.box(1, 2, 3)
    assert pickle.loads(pickle.dumps(mesh)) == copy.deepcopy(mesh) == mesh
    movie = fbptr.animate(lambda fb, i: fb.clear("red"), 2, (8, 8))
    assert pickle.loads(pickle.dumps(movie)).data == movie.data

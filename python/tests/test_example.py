"""The first example: what it draws, and that its array is the memory."""

import zlib

import fbptr


def test_the_example_draws_and_its_array_is_the_memory():
    fb = fbptr.Framebuffer(640, 480)
    fb.clear("navy")
    fb.line(0, 0, 639, 479, "red", "gold")
    fb.fill([(20, 20), (600, 80), (300, 460)], ["red", "lime", "blue"])
    fb.mesh("pot", fbptr.teapot())
    fb.lookat((0, 2, 6))
    assert fb.light("point", (5, 6, 7)) == 0
    fb.draw("pot", shade="phong")
    a = fb.numpy()
    assert a.shape == (480, 640, 4) and a.dtype == "uint8" and not a.flags.owndata and a.flags.writeable
    assert tuple(a[300, 0]) == (0, 0, 128, 255)
    assert zlib.crc32(a.tobytes()) == zlib.crc32(fb) == fb.crc()
    # Both ways, without a copy.
    fb.pixel(3, 2, "#ff8000")
    assert tuple(a[2, 3]) == (255, 128, 0, 255)
    a[5, 7] = (1, 2, 3, 4)
    assert fb.get_pixel(7, 5) == (1, 2, 3, 4)
    assert fb[(640 * 5 + 7) * 4] == 1
    assert fb._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"

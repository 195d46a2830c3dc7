"""Tests of the Python client against a real server.

Run `FBPTR=path/to/fbptr python3 -m unittest` in this folder.
"""

import os
import re
import struct
import subprocess
import tempfile
import unittest
import zlib

from fbptr import Client, CommandError, SharedMemory

BINARY = os.environ.get("FBPTR", "../../target/debug/fbptr")


class Drawing(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.unix = os.path.join(cls.folder.name, "fb.sock")
        cls.shm = os.path.join(cls.folder.name, "frame")
        cls.server = subprocess.Popen(
            [BINARY, "serve", "--headless", "--size", "64x48", "--listen", "127.0.0.1:0"]
            + ["--unix", cls.unix, "--shm", cls.shm],
            stderr=subprocess.PIPE,
            text=True,
        )
        cls.address = None
        for line in cls.server.stderr:
            found = re.search(r"127\.0\.0\.1:(\d+)", line)
            if found:
                cls.address = found.group(0)
            if cls.address and os.path.exists(cls.unix):
                break

    @classmethod
    def tearDownClass(cls):
        cls.server.terminate()
        assert cls.server.wait(10) == 0
        cls.server.stderr.close()
        cls.folder.cleanup()

    def test_pixels_and_lines_read_back(self):
        with Client(self.address) as fb:
            self.assertEqual(fb.size(), (64, 48))
            fb.clear("000000")
            fb.pixel(3, 4, (1, 2, 3))
            fb.pixels([(5, 6, (7, 8, 9)), (6, 6, (1, 1, 1, 1))])
            fb.line(0, 47, 63, 47, "red")
            fb.poke((64 * 2 + 1) * 4, bytes(range(8)))
            self.assertEqual(fb.get_pixel(3, 4), (1, 2, 3))
            self.assertEqual(fb.get_pixel(5, 6), (7, 8, 9))
            self.assertEqual(fb.get_pixel(63, 47), (255, 0, 0))
            self.assertEqual(fb.peek((64 * 2 + 1) * 4, 8), bytes(range(8)))
            frame = fb.read()
            self.assertEqual(len(frame), 64 * 48 * 4)
            self.assertEqual(fb.crc(), zlib.crc32(frame))

    def test_blit_and_read_are_inverse(self):
        picture = bytes(i * 7 % 256 for i in range(20 * 10 * 4))
        with Client("unix:" + self.unix) as fb:
            fb.blit(30, 30, 20, 10, picture)
            self.assertEqual(fb.read(30, 30, 20, 10), picture)
            with self.assertRaises(ValueError):
                fb.blit(0, 0, 2, 2, b"short")

    def test_a_large_frame_in_one_payload(self):
        with Client(self.address) as fb:
            fb.blit(0, 0, 64, 48, bytes(64 * 48 * 4))
            self.assertEqual(fb.read(), bytes(64 * 48 * 4))

    def test_meshes_are_lit_and_have_depth(self):
        with Client(self.address) as fb:
            fb.clear()
            fb.mesh("square", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n")
            fb.look_at((0, 0, 5))
            fb.command("MATERIAL", 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 0.5, 0)
            fb.draw("square")
            self.assertEqual(fb.get_pixel(32, 24), (255, 128, 0))
            self.assertLess(fb.depth_at(32, 24), 1.0)
            self.assertEqual(fb.depth_at(0, 0), 1.0)

    def test_every_verb_is_a_method(self):
        with Client(self.address) as fb:
            lines = fb.help()
            self.assertIn("SIZE: answers SIZE width height", lines)
            verbs = {re.match(r"PB|[A-Z]*", line).group() for line in lines} - {"", "M", "Q"}
            self.assertIn("PXMULTI", verbs)
            self.assertGreater(len(verbs), 70)
            for verb in sorted(verbs):
                self.assertTrue(callable(getattr(fb, verb.lower(), None)), verb)
            self.assertEqual(fb.get_pixel(0, 0), fb.px(0, 0))

    def test_words_are_left_out_spread_and_made_of_values(self):
        with Client(self.address) as fb:
            fb.clear("000000")
            fb.fillrect(1, 2, 3, 4.0, (1, 2, 3))
            self.assertEqual(fb.read(1, 2, 3, 4), bytes((1, 2, 3, 255)) * 12)
            fb.rect(0, 0, 64, 48, "red")
            self.assertEqual((fb.px(63, 47), fb.px(1, 1)), ((255, 0, 0), (0, 0, 0)))
            fb.poly("lime", (10, 10), (20, 10), [20, 20])
            self.assertEqual((fb.px(15, 10), fb.px(20, 15)), ((0, 255, 0), (0, 255, 0)))
            fb.px(5, 5, "blue")
            self.assertEqual(fb.px(5, 5), (0, 0, 255))
            fb.pb(6, 6, "80")
            fb.pxmulti(7, 6, bytes((1, 2, 3, 4, 5, 6, 7, 8)))
            self.assertEqual((fb.px(6, 6), fb.px(7, 6), fb.px(8, 6)), ((128,) * 3, (1, 2, 3), (5, 6, 7)))
            fb.mesh("box", "BOX", 1, 1, 1)
            fb.perspective(1, 0.1, 10, on_smaller_side=True)
            fb.lookat(0, 0, 5, 0, 0, 0, 0, 1, 0)
            fb.ambient(1, 1, 1)
            fb.material("white", "white", "black", 1)
            fb.light(0, "DIR", (0, 0, -1), "white")
            fb.shade("flat")
            fb.draw("box")
            self.assertEqual(fb.px(32, 24), (255, 255, 255))
            fb.scene("<X3D><Scene/></X3D>")
            fb.blend("over")
            self.assertEqual(len(fb.size()), 2)
            self.assertEqual(fb.version()[0], "fbptr")
            fb.sync()
            with self.assertRaises(ValueError):
                fb.pxmulti(0, 0, b"abc")

    def test_snapshots_are_png(self):
        with Client(self.address) as fb:
            data = fb.snapshot(os.path.join(self.folder.name, "a.png"))
            self.assertEqual(data[:8], b"\x89PNG\r\n\x1a\n")
            self.assertEqual(struct.unpack(">II", data[16:24]), (64, 48))

    def test_refusals_are_raised_with_their_place(self):
        with Client(self.address) as fb:
            fb.command("LINE", 1, 2)
            fb.pixel(0, 0, "ffffff")
            with self.assertRaises(CommandError) as caught:
                fb.sync()
            self.assertEqual([(e[0], e[2]) for e in caught.exception.errors], [(2, "EARGS")])
            self.assertEqual(fb.get_pixel(0, 0), (255, 255, 255))
            with self.assertRaises(CommandError):
                fb.get_pixel(-1, 0)
            with self.assertRaises(ValueError):
                fb.command("PX 1 1\nQUIT")

    def test_errors_belong_to_their_own_command(self):
        with Client(self.address) as fb:
            fb.pixel(1, 1, "010203")
            fb.pixel(2, 2, "040506")
            fb.sync()
            # The refused command has the query's verb: the reply is still read, then the error is
            # raised.
            fb.pixel(5, 5, "zz")
            with self.assertRaises(CommandError) as caught:
                fb.get_pixel(1, 1)
            self.assertEqual([e[2] for e in caught.exception.errors], ["ECOLOUR"])
            self.assertEqual(fb.get_pixel(2, 2), (4, 5, 6))
            # An error before a reply with a payload, and a refused query before another one of its
            # verb.
            fb.command("READ", 0, 0, 1)
            with self.assertRaises(CommandError):
                fb.read(0, 0, 3, 3)
            self.assertEqual(fb.read(1, 1, 1, 1), bytes((1, 2, 3, 255)))
            fb.line(0, 0, 1, 1, "zz")
            with self.assertRaises(CommandError) as caught:
                fb.get_pixel(-1, 0)
            self.assertEqual([e[2] for e in caught.exception.errors], ["ECOLOUR", "ERANGE"])
            self.assertEqual(fb.get_pixel(1, 1), (1, 2, 3))

    def test_places_count_payloads_and_what_was_not_flushed(self):
        with Client(self.address) as fb:
            fb.blit(0, 0, 64, 48, bytes(64 * 48 * 4))
            fb.text(0, 0, "white", "\u00e9\n")
            fb.blit(0, 0, 150, 150, bytes(150 * 150 * 4))
            place = fb.command("SIZE", "no")
            with self.assertRaises(CommandError) as caught:
                fb.sync()
            self.assertEqual([(e[1], e[2]) for e in caught.exception.errors], [(place, "EARGS")])

    def test_shared_memory_goes_both_ways(self):
        with SharedMemory(self.shm) as mem, Client(self.address) as fb:
            self.assertEqual((mem.width, mem.height, mem.stride), (64, 48, 256))
            self.assertEqual(mem.info()["width"], "64")
            fb.pixel(10, 11, (9, 8, 7))
            fb.sync()
            at = (64 * 11 + 10) * 4
            self.assertEqual(bytes(mem[at : at + 4]), bytes((9, 8, 7, 255)))
            mem.pixel(12, 13, (1, 2, 3, 4))
            mem.pixel(-1, 0, (1, 2, 3, 4))
            mem.ring()
            for _ in range(100):
                if fb.read(12, 13, 1, 1) == bytes((1, 2, 3, 4)):
                    break
            self.assertEqual(fb.read(12, 13, 1, 1), bytes((1, 2, 3, 4)))
        with self.assertRaises(ValueError):
            with tempfile.NamedTemporaryFile() as other:
                other.write(bytes(8192))
                other.flush()
                SharedMemory(other.name)

    def test_numpy_arrays_when_numpy_is_there(self):
        try:
            import numpy
        except ImportError:
            self.skipTest("numpy is not installed")
        with Client(self.address) as fb:
            picture = numpy.arange(4 * 5 * 4, dtype=numpy.uint8).reshape(4, 5, 4)
            fb.blit(1, 1, 5, 4, picture)
            self.assertTrue((fb.array(1, 1, 5, 4) == picture).all())


if __name__ == "__main__":
    unittest.main()

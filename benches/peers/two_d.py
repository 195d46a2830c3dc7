#!/usr/bin/env python3
"""Compares fbptr with other programs in two dimensions, workload by workload, in alternated rounds.

    pip install skia-python pygame-ce pillow blend2d-py numpy
    cargo build --release --manifest-path benches/peers/Cargo.toml --target-dir target/peers/target
    python3 benches/peers/two_d.py          # nine rounds on one core

The others are Skia, SDL, Pillow, Blend2D and tiny-skia; those that are not installed are left out.

In: the program, whose `bench 2d --export` writes the figures as streams and the exact pictures. Out: a Markdown table:
the medians of the rounds in milliseconds, and the time of the fastest other program over ours, as the median of the
rounds' own ratios with the least and the largest; with `--before BINARY` that of another fbptr over ours as well.

A round draws the same figures by each program right after each other, each round in the other order, on one core, and
takes processor time, so that other work on the machine counts for little: ours by `fbptr play` of the stream ten
times over, parsing included, less the time of an empty stream; tiny-skia by `src/bin/tiny_skia.rs`, the others through
their Python bindings, with paints, paths and surfaces made before, the shorter of two frames. Pictures are read from
the stream's file by all of them, each frame; `pictures_held` are in memory before, and are drawn by ours through its
Python package (`fb.blit`), which must be installed (`pip install ./python`). Before it is timed,
`fbptr bench` compares our picture with the truth. Every other picture is compared with the exact one: where the number
of its pixels that are not black differs by more than two percent, the time has a star. Text is of other letters in
every program and has no such check. Blend2D has smooth edges alone, and its binding neither lines nor pictures.
"""

import argparse
import io
import os
import statistics
import subprocess
import sys
import tempfile
import time

os.environ.setdefault("SDL_VIDEODRIVER", "dummy")
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")

import numpy  # noqa: E402
import pygame  # noqa: E402
import skia  # noqa: E402
from PIL import Image, ImageDraw  # noqa: E402

try:
    import blend2d  # noqa: E402
except ImportError:
    blend2d = None
try:
    import fbptr  # noqa: E402
except ImportError:
    fbptr = None

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
TINY_SKIA = os.path.join(ROOT, "target/peers/target/release/tiny_skia")
SIZE = (1920, 1080)
# Streams that `play` draws at once.
REPEATS = 10
WORKLOADS = (
    "rects rects_over discs discs_over triangles triangles_three triangles_three_over lines lines_aa lines_wide stars "
    "pictures pictures_held text"
).split()


def color_of(digits):
    values = [int(digits[i : i + 2], 16) for i in range(0, len(digits), 2)]
    return tuple(values if len(values) == 4 else values + [255])


def figures_of(stream):
    """Reads a stream of figures: (verb, numbers, colours or text or pixels)."""
    found, source = [], io.BytesIO(stream)
    held = memoryview(stream)
    for line in iter(source.readline, b""):
        words = line.decode().rstrip("\n").split(" ")
        verb = words[0]
        if verb in ("FILL", "LINE", "LINEAA", "WIDELINE", "FILLRECT", "FILLCIRCLE"):
            count = {"FILL": 6, "LINE": 4, "LINEAA": 4, "WIDELINE": 5, "FILLRECT": 4, "FILLCIRCLE": 3}[verb]
            numbers = [int(word) for word in words[1 : count + 1]]
            found.append((verb, numbers, [color_of(word) for word in words[count + 1 :]]))
        elif verb == "FILLPOLY":
            found.append((verb, [int(word) for word in words[2:]], [color_of(words[1])]))
        elif verb == "PRINT":
            found.append((verb, [int(words[1]), int(words[2])], [color_of(words[3]), " ".join(words[4:])]))
        elif verb == "BLIT":
            at = source.tell()
            source.seek(int(words[5][1:]), io.SEEK_CUR)
            found.append((verb, [int(word) for word in words[1:5]], held[at : source.tell()]))
    return found


def pairs(numbers):
    return list(zip(numbers[::2], numbers[1::2]))


class Reader:
    """Reads the pixels of pictures from the stream's file, one picture after the other, into one buffer."""

    def __init__(self, path, figures):
        self.file = open(path, "rb", buffering=0)
        self.buffer = bytearray(max(len(pixels) for _, _, pixels in figures))
        self.places, at = {}, 0
        with open(path, "rb") as lines:
            for _, _, pixels in figures:
                at += len(lines.readline())
                self.places[id(pixels)] = at
                at += len(pixels)
                lines.seek(at)

    def read(self, pixels):
        self.file.seek(self.places[id(pixels)])
        wanted = memoryview(self.buffer)[: len(pixels)]
        done = 0
        while done < len(wanted):
            done += self.file.readinto(wanted[done:])
        return wanted


class Peer:
    """A program in this process: one call for each figure."""

    def start(self, work, figures, path):
        reader = Reader(path, figures) if work == "pictures" else None
        self.pixels_of = reader.read if reader else lambda pixels: pixels
        self.calls = [self.call(work, *figure) for figure in figures]

    def picture_call(self, work, pixels, make, draw):
        """Returns the call that draws a picture: made before, or read and made each time."""
        if work == "pictures":
            return lambda: draw(make(self.pixels_of(pixels)))
        held = make(pixels)
        return lambda: draw(held)

    def draws_all(self):
        return all(self.calls)

    def least_ms(self, frames):
        times = []
        for _ in range(frames):
            self.clear()
            begin = time.thread_time()
            for call in self.calls:
                call()
            times.append(time.thread_time() - begin)
        return min(times) * 1e3


class Skia(Peer):
    name = "Skia"

    def __init__(self, work, figures, stream):
        self.array = numpy.zeros((SIZE[1], SIZE[0], 4), numpy.uint8)
        self.surface = skia.Surface(self.array, colorType=skia.kRGBA_8888_ColorType)
        self.canvas = self.surface.getCanvas()
        self.start(work, figures, stream)

    def call(self, work, verb, n, rest):
        canvas = self.canvas
        paint = skia.Paint(AntiAlias=work == "lines_aa")
        if verb != "BLIT":
            paint.setColor(skia.Color(*rest[0]))
        if verb == "FILLRECT":
            rect = skia.Rect.MakeXYWH(*n)
            return lambda: canvas.drawRect(rect, paint)
        if verb == "FILLCIRCLE":
            return lambda: canvas.drawCircle(n[0], n[1], n[2], paint)
        if verb == "FILL" and len(rest) == 3:
            colors = [skia.Color(*color) for color in rest]
            points = [skia.Point(*point) for point in pairs(n)]
            mode = skia.Vertices.VertexMode.kTriangles_VertexMode
            vertices = skia.Vertices.MakeCopy(mode, points, points, colors)
            white = skia.Paint(Color=skia.ColorWHITE)
            return lambda: canvas.drawVertices(vertices, white, skia.BlendMode.kDst)
        if verb in ("FILL", "FILLPOLY"):
            path = skia.Path()
            path.addPoly([skia.Point(*point) for point in pairs(n)], True)
            path.setFillType(skia.PathFillType.kEvenOdd)
            return lambda: canvas.drawPath(path, paint)
        if verb in ("LINE", "LINEAA", "WIDELINE"):
            shift = 0.5 if verb != "WIDELINE" else 0.0
            paint.setStyle(skia.Paint.kStroke_Style)
            paint.setStrokeWidth({"LINE": 0, "LINEAA": 1, "WIDELINE": n[-1]}[verb])
            paint.setStrokeCap(skia.Paint.kRound_Cap if verb == "WIDELINE" else skia.Paint.kButt_Cap)
            ends = [value + shift for value in n[:4]]
            return lambda: canvas.drawLine(*ends, paint)
        if verb == "BLIT":
            paint.setBlendMode(skia.BlendMode.kSrc)
            sampling = skia.SamplingOptions()

            def make(pixels):
                array = numpy.frombuffer(pixels, numpy.uint8).reshape(n[3], n[2], 4)
                return skia.Image.fromarray(array, skia.kRGBA_8888_ColorType, copy=False)

            return self.picture_call(work, rest, make, lambda image: canvas.drawImage(image, n[0], n[1], sampling, paint))
        font, text = skia.Font(skia.Typeface(), 10), rest[1]
        font.setEdging(skia.Font.Edging.kAlias)
        font.setSubpixel(False)
        return lambda: canvas.drawString(text, n[0], n[1] + 8, font, paint)

    def clear(self):
        self.canvas.clear(skia.ColorBLACK)

    def picture(self):
        return self.array[:, :, :3]


class Sdl(Peer):
    name = "SDL"

    def __init__(self, work, figures, stream):
        pygame.display.init()
        pygame.display.set_mode((16, 16))
        self.surface = pygame.Surface(SIZE, 0, 32)
        self.start(work, figures, stream)

    def call(self, work, verb, n, rest):
        surface, draw = self.surface, pygame.draw
        color = rest[0][:3] if verb != "BLIT" else None
        if work.endswith("_over") and verb == "FILLRECT":
            filled = pygame.Surface((n[2], n[3]), 0, 32)
            filled.fill(color)
            filled.set_alpha(rest[0][3])
            return lambda: surface.blit(filled, (n[0], n[1]))
        if work.endswith("_over") or verb == "FILL" and len(rest) == 3:
            return None
        if verb == "FILLRECT":
            return lambda: surface.fill(color, n)
        if verb == "FILLCIRCLE":
            return lambda: draw.circle(surface, color, (n[0], n[1]), n[2])
        if verb in ("FILL", "FILLPOLY"):
            points = pairs(n)
            return lambda: draw.polygon(surface, color, points)
        if verb == "LINE":
            return lambda: draw.line(surface, color, (n[0], n[1]), (n[2], n[3]))
        if verb == "LINEAA":
            return lambda: draw.aaline(surface, color, (n[0], n[1]), (n[2], n[3]))
        if verb == "WIDELINE":
            return lambda: draw.line(surface, color, (n[0], n[1]), (n[2], n[3]), n[4])
        if verb == "BLIT":

            def make(pixels):
                image = pygame.image.frombuffer(pixels, (n[2], n[3]), "RGBX")
                return image if work == "pictures" else image.convert(surface)

            return self.picture_call(work, rest, make, lambda image: surface.blit(image, (n[0], n[1])))
        return None

    def clear(self):
        self.surface.fill((0, 0, 0))

    def picture(self):
        return pygame.surfarray.array3d(self.surface).swapaxes(0, 1)


class Pillow(Peer):
    name = "Pillow"

    def __init__(self, work, figures, stream):
        self.image = Image.new("RGBA", SIZE)
        self.draw = ImageDraw.Draw(self.image)
        self.start(work, figures, stream)

    def call(self, work, verb, n, rest):
        draw = self.draw
        color = rest[0] if verb != "BLIT" else None
        if work.endswith("_over") or verb == "LINEAA" or verb == "FILL" and len(rest) == 3:
            return None
        if verb == "FILLRECT":
            box = (n[0], n[1], n[0] + n[2] - 1, n[1] + n[3] - 1)
            return lambda: draw.rectangle(box, fill=color)
        if verb == "FILLCIRCLE":
            box = (n[0] - n[2], n[1] - n[2], n[0] + n[2] - 1, n[1] + n[2] - 1)
            return lambda: draw.ellipse(box, fill=color)
        if verb in ("FILL", "FILLPOLY"):
            points = pairs(n)
            return lambda: draw.polygon(points, fill=color)
        if verb in ("LINE", "WIDELINE"):
            width = 1 if verb == "LINE" else n[4]
            return lambda: draw.line(n[:4], fill=color, width=width)
        if verb == "BLIT":
            make = lambda pixels: Image.frombuffer("RGBA", (n[2], n[3]), pixels, "raw", "RGBA", 0, 1)
            return self.picture_call(work, rest, make, lambda image: self.image.paste(image, (n[0], n[1])))
        return None

    def clear(self):
        self.image.paste((0, 0, 0, 255), (0, 0, *SIZE))

    def picture(self):
        return numpy.asarray(self.image)[:, :, :3]


class Blend2d(Peer):
    name = "Blend2D"

    def __init__(self, work, figures, stream):
        self.image = blend2d.Image(*SIZE)
        self.context = blend2d.Context(self.image)
        self.calls = [self.call(*figure) for figure in figures]

    def call(self, verb, n, rest):
        context = self.context
        if verb not in ("FILLRECT", "FILLCIRCLE", "FILL", "FILLPOLY") or len(rest) != 1:
            return None
        color = rest[0]
        if verb == "FILLRECT":
            fill, shape = context.fill_rect, n
        elif verb == "FILLCIRCLE":
            fill, shape = context.fill_circle, n
        else:
            path = blend2d.Path()
            path.move_to(*n[:2])
            for point in pairs(n[2:]):
                path.line_to(*point)
            path.close()
            fill, shape = context.fill_path, (path,)

        def draw():
            context.set_fill_style_rgba(*color)
            fill(*shape)

        return draw

    def clear(self):
        self.context.set_fill_style_rgba(0, 0, 0, 255)
        self.context.fill_all()

    def picture(self):
        return self.image.asarray()[:, :, :3]


class TinySkia:
    """A program of its own, which reads the stream."""

    name = "tiny-skia"

    def __init__(self, work, figures, stream):
        self.stream, self.pixels, self.work = stream, stream + ".rgba", work

    def run(self, frames):
        command = [TINY_SKIA, self.stream, str(frames), self.pixels] + ["read"] * (self.work == "pictures")
        return subprocess.run(command, capture_output=True, text=True)

    def draws_all(self):
        return self.run(1).returncode == 0

    def least_ms(self, frames):
        return float(self.run(frames).stdout)

    def picture(self):
        return numpy.fromfile(self.pixels, numpy.uint8).reshape(SIZE[1], SIZE[0], 4)[:, :, :3]


class Held(Peer):
    """This project's own Python package, with pictures in memory."""

    name = "fbptr"

    def __init__(self, work, figures, stream):
        self.frame = fbptr.Framebuffer(*SIZE)
        self.start(work, [(verb, n, bytes(rest)) for verb, n, rest in figures], stream)

    def call(self, work, verb, n, rest):
        return lambda: self.frame.blit(*n, rest)

    def clear(self):
        self.frame.clear()

    def picture(self):
        return numpy.asarray(self.frame)[:, :, :3]


PEERS = [Skia, Sdl, Pillow]
PEERS += [Blend2d] if blend2d else []
PEERS += [TinySkia] if os.path.exists(TINY_SKIA) else []


def processor_ms(binary, stream):
    command = [binary, "play", "--headless", "--threads", "1", stream]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, used = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(command)}: status {status}")
    return (used.ru_utime + used.ru_stime) * 1e3


def own_ms(binary, folder):
    streams = [os.path.join(folder, name) for name in ("many.fbs", "empty.fbs")]
    many, empty = (processor_ms(binary, stream) for stream in streams)
    return (many - empty) / REPEATS


def is_alike(peer, exact):
    """Returns whether about as many pixels are drawn as in the exact picture."""
    lit = [int((picture != 0).any(axis=2).sum()) for picture in (peer.picture(), exact)]
    return abs(lit[0] - lit[1]) <= 0.02 * lit[1]


def rounds_of(given, folder, work):
    """Returns the times of all programs by name, one for each round, and the names of those whose picture differs."""
    row = "2d_" + work.removesuffix("_held")
    subprocess.run([given.fbptr, "bench", row, "--export", folder], check=True)
    subprocess.run([given.fbptr, "bench", row, "--frames", "1", "--json"], check=True, capture_output=True)
    path = os.path.join(folder, f"{row}.fbs")
    with open(path, "rb") as file:
        stream = file.read()
    figures = figures_of(stream)
    for name, repeats in (("many.fbs", REPEATS), ("empty.fbs", 0)):
        with open(os.path.join(folder, name), "wb") as file:
            file.write(b"SIZE %d %d\n" % SIZE + stream * repeats)
    exact = numpy.asarray(Image.open(os.path.join(folder, f"{row}.ppm")))
    peers = [kind(work, figures, path) for kind in PEERS]
    peers = [peer for peer in peers if peer.draws_all()]
    different = []
    for peer in peers:
        peer.least_ms(1)
        if work != "text" and not is_alike(peer, exact):
            different.append(peer.name)
    if work == "pictures_held":
        own = Held(work, figures, path)
        own.least_ms(1)
        if not (own.picture() == exact).all():
            sys.exit("the Python package draws another picture")
        programs = [("fbptr", lambda: own.least_ms(given.frames))]
    else:
        programs = [("fbptr", lambda: own_ms(given.fbptr, folder))]
        programs += [("before", lambda: own_ms(given.before, folder))] if given.before else []
    programs += [(peer.name, lambda peer=peer: peer.least_ms(given.frames)) for peer in peers]
    times = {name: [] for name, _ in programs}
    for turn in range(given.rounds):
        for name, run in programs if turn % 2 == 0 else programs[::-1]:
            times[name].append(run())
    return times, different


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--fbptr", default=os.path.join(ROOT, "target/release/fbptr"))
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--frames", type=int, default=2, help="frames that each of the others draws in a round")
    parser.add_argument("--before", help="another fbptr to compare with")
    parser.add_argument("--core", type=int, default=0, help="the core on which all of them run")
    parser.add_argument("--only", default=",".join(WORKLOADS), help="workloads, without their 2d_")
    given = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {given.core})
    names = ["fbptr"] + [peer.name for peer in PEERS]
    print(f"| workload | {' | '.join(names)} | fastest other / fbptr (least to largest) | before / now |")
    print("|---" * (len(names) + 3) + "|")
    with tempfile.TemporaryDirectory() as folder:
        for work in given.only.split(","):
            if work == "pictures_held" and not fbptr:
                continue
            times, different = rounds_of(given, folder, work)
            others = [column for name, column in times.items() if name not in ("fbptr", "before")]
            cells = [cell(times, different, name) for name in names]
            cells.append(spread(times["fbptr"], [min(column) for column in zip(*others)]))
            cells.append(spread(times["fbptr"], times.get("before", [])))
            print(f"| {work} | {' | '.join(cells)} |", flush=True)


def cell(times, different, name):
    return f"{statistics.median(times[name]):.1f}{'*' * (name in different)}" if name in times else ""


def spread(own, other):
    """Returns the median of the rounds' ratios with the least and the largest."""
    ratios = sorted(them / us for us, them in zip(own, other))
    return f"{statistics.median(ratios):.1f} ({ratios[0]:.1f} to {ratios[-1]:.1f})" if ratios else ""


if __name__ == "__main__":
    main()

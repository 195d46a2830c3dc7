"""The work of one task: a chunk of items, one after the other, each with its CRC and its time.

In: a job, sent to the worker once, and the numbers of its items. Out: a `Part`. An item that fails
is reported beside the others; a full disk ends the chunk.
"""

import errno
import os
import pickle
import threading
import time
import zlib

import fbptr

from .manifest import host

__all__ = ["MapJob", "Part", "RenderJob", "chunk", "crc_of", "prove"]

# Errors after which no other item can be written either.
FULL = {errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EROFS}
_cache = threading.local()


class Part:
    """The result of a task: `done` holds (index, CRC, value, seconds) of each item, `failed`
    (index, message), `full` the message of a full disk, `ran` the seconds of all."""

    def __init__(self):
        self.worker, self.host, self.version = here(), host(), fbptr.__version__
        self.done, self.failed, self.full, self.ran = [], [], None, 0.0


def here():
    """Returns the worker's address."""
    try:
        from distributed import get_worker

        return get_worker().address
    except (ImportError, ValueError):
        return "this process"


def chunk(job, items, version):
    """Draws items, unless this worker is of another version than the one that asks."""
    part = Part()
    if part.version != version:
        return part
    begun = time.perf_counter()
    for index, param in items:
        before = time.perf_counter()
        try:
            crc, value = job.do(index, param)
        except OSError as error:
            if error.errno in FULL:
                part.full = str(error)
                break
            part.failed.append((index, _words(error)))
        except Exception as error:
            part.failed.append((index, _words(error)))
        else:
            part.done.append((index, crc, value, time.perf_counter() - before))
    part.ran = time.perf_counter() - begun
    return part


def prove(job, index, param, version):
    """Draws one item without writing it."""
    part = Part()
    if part.version == version:
        before = time.perf_counter()
        try:
            part.done.append((index, job.prove(index, param), None, time.perf_counter() - before))
        except Exception as error:
            part.failed.append((index, _words(error)))
    return part


def _words(error):
    return "%s: %s" % (type(error).__name__, error)


class RenderJob:
    """The frames of a scene, with all bytes that it needs."""

    def __init__(self, data, format, name, files, options, pattern, write):
        self.scene = (data, format, name, files, options)
        self.pattern, self.write = pattern, write
        self.key = os.urandom(16)

    def _scene(self):
        # Read once by each thread of a worker: threads of one scene would take turns.
        if getattr(_cache, "key", None) != self.key:
            data, format, name, files, options = self.scene
            _cache.scene = fbptr.Scene(data, format, name, files=files, **options)
            _cache.key = self.key
        return _cache.scene

    def do(self, index, _):
        """Draws a frame. Returns its CRC, and (CRC, length, CRC of the file, the file or None)."""
        scene = self._scene()
        if self.pattern is None:
            return scene.crc(index), None
        path = self.pattern % index
        if self.write == "worker":
            crc, length, file_crc = scene.write(index, path)
            return crc, (crc, length, file_crc, None)
        crc, data = scene.encoded(index, os.path.splitext(path)[1][1:])
        return crc, (crc, len(data), zlib.crc32(data), data)

    def prove(self, index, _):
        """Returns the CRC of a frame."""
        return self._scene().crc(index)


class MapJob:
    """Calls of a function."""

    def __init__(self, fn, pattern, results):
        self.fn, self.pattern, self.results = fn, pattern, results

    def do(self, index, param):
        """Calls the function. Returns the CRC of its result, and the value to send."""
        value = self.fn(param)
        crc = crc_of(value)
        if self.pattern is not None:
            path = self.pattern % index
            if isinstance(value, fbptr.Framebuffer):
                value.save(path)
            else:
                data = value.encode() if isinstance(value, str) else bytes(value)
                fbptr._native.write_file(path, data)
            return crc, path
        if self.results == "crcs":
            return crc, None
        if isinstance(value, fbptr.Framebuffer):
            value = value._repr_png_()
        return crc, value

    def prove(self, index, param):
        """Returns the CRC of the function's result."""
        return crc_of(self.fn(param))


def crc_of(value):
    """Returns the CRC-32 of a result: of its bytes if it has some, else of what would be sent."""
    if isinstance(value, str):
        return zlib.crc32(value.encode())
    if isinstance(value, (tuple, list)):
        crc = zlib.crc32(b"%d" % len(value))
        for item in value:
            crc = zlib.crc32(b"%08x" % crc_of(item), crc)
        return crc
    if isinstance(value, dict):
        return crc_of(sorted((repr(key), crc_of(item)) for key, item in value.items()))
    try:
        return zlib.crc32(memoryview(value).cast("B"))
    except TypeError:
        return zlib.crc32(pickle.dumps(value, protocol=4))

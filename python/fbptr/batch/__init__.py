"""Batches: more frames than one process draws, over the workers of Dask, or here one by one.

    from distributed import Client
    import fbptr.batch
    report = fbptr.batch.render("scene.x3d", frames=1000, out="frames/", size=(640, 480), client=Client())
    results = fbptr.batch.map(draw, params, client=client)

A frame's bytes are the same on every machine, so a batch proves itself: one item in fifty is drawn
by a second worker too, and a worker whose CRC differs from the others' is named, left out, and
what it drew is drawn again. Scheduling is Dask's; without a client the items are drawn in this
process. The frames and their manifest are those of `fbptr render --shard`: `fbptr batch check` and
`fbptr batch movie` take them, and a second call draws only what is missing.
"""

import os
import time

from .. import __version__
from ..scene import Scene, read
from .manifest import Manifest, host, record_of
from .report import BatchError, Report
from .run import run
from .tasks import MapJob, RenderJob

__all__ = ["BatchError", "Report", "map", "render"]


def render(
    scene, frames, out=None, size=None, client=None, *, name="frame", ending="png", first=0, last=None,
    format=None, root=None, fps=25.0, time=0.0, background=None, shade=None, near=None, far=None, turns=(),
    write="worker", verify=50, retries=2, chunk=None, chunk_seconds=0.5, progress=None, cancel=None, errors="raise",
) -> Report:  # fmt: skip
    """Draws frames `first` to `last` (both inclusive, from 0) of `frames`. Returns a `Report`.

    `scene` is a path, or the bytes of a scene with their `format`; `fps`, `time`, `size`, `background`,
    `shade`, `near`, `far` and `turns` are those of `fbptr.Scene.load`. The file and all that it refers to is read
    here and sent to the workers once.

    With `out` each frame is a file `out/NAME-0007.png` (`ending`: png, ppm or raw), whole or absent,
    with its line in `out/frames-0-of-1.jsonl`; frames that are there with the right CRC are not drawn
    again. `write="worker"` needs a folder that all workers see, `write="client"` sends the files
    here. Without `out` the report has the CRCs of the pixels alone.

    `verify` is the number of frames of which one is drawn twice, 0 for none; `retries` the number of
    further attempts at a frame that failed; `chunk` the frames of a task (by default as many as
    take `chunk_seconds`, by measured cost); `progress` a function of (done, all) or False;
    `cancel` a `threading.Event`. With errors="raise" a `BatchError` with the report is raised after
    all other frames are drawn if some could not be; with "return" the report says so.
    """
    data, format, scene_name, root = read(scene, format, None, root)
    options = {"frames": frames, "fps": fps, "time": time, "size": size, "background": background}
    options.update(shade=shade, near=near, far=far, turns=list(turns))
    # The name may be a path here; in a message of a worker its last part is enough.
    scene_name = os.path.basename(scene_name)
    loaded = Scene(data, format, scene_name, folder=root, **options)
    last = frames - 1 if last is None else last
    if not 0 <= first <= last < frames:
        raise ValueError("expected frames from 0 to %d, found %d to %d" % (frames - 1, first, last))
    if ending not in ("png", "ppm", "raw"):
        raise ValueError("expected the ending png, ppm or raw, found %r" % (ending,))
    if write not in ("worker", "client"):
        raise ValueError("expected write='worker' or 'client', found %r" % (write,))
    pattern = None
    manifest = None
    items = range(first, last + 1)
    report = Report(len(items))
    if out is not None:
        out = os.path.abspath(out)
        os.makedirs(out, exist_ok=True)
        pattern = os.path.join(out, name.replace("%", "%%") + "-%04d." + ending)
        template = {"of": frames, "size": list(loaded.size), "fps": float(fps)}
        template.update(version=__version__, recipe="%08x" % loaded.recipe)
        manifest = Manifest(out, template, pattern)
        report.crcs = manifest.there(items)
        report.there = len(report.crcs)
    job = RenderJob(data, format, scene_name, loaded.files, options, pattern, write)
    todo = [(k, None) for k in items if k not in report.crcs]
    try:
        run(job, todo, client, report, _Sink(manifest, pattern, write), verify=verify, retries=retries,
            chunk=chunk, chunk_seconds=chunk_seconds, progress=progress, cancel=cancel)  # fmt: skip
    finally:
        if manifest is not None:
            manifest.close()
    return report.end(errors)


def map(
    fn, params, client=None, *, out=None, name="item", ending="png", results="values", verify=50, retries=2,
    chunk=None, chunk_seconds=0.5, progress=None, cancel=None, errors="raise",
) -> Report:  # fmt: skip
    """Calls `fn(param)` for every one of `params`. Returns a `Report` whose `values` are the results.

    A result is anything that can be sent and whose CRC is the same in every process: numbers, text,
    bytes, arrays, a `Framebuffer`, a tuple or dict of them. Of a `Framebuffer` the pixels count;
    it is sent as the bytes of a PNG. With `out` each result (a `Framebuffer`, bytes or text) is a
    file `out/NAME-0007.ENDING`, and its value the path; with results="crcs" nothing is sent but
    the CRCs. The other arguments are those of `render`.
    """
    if results not in ("values", "crcs"):
        raise ValueError("expected results='values' or 'crcs', found %r" % (results,))
    pattern = None
    if out is not None:
        os.makedirs(out, exist_ok=True)
        pattern = os.path.join(os.path.abspath(out), name.replace("%", "%%") + "-%04d." + ending)
    todo = list(enumerate(params))
    report = Report(len(todo))
    report.values = [None] * len(todo)
    run(MapJob(fn, pattern, results), todo, client, report, _Values(report), verify=verify, retries=retries,
        chunk=chunk, chunk_seconds=chunk_seconds, progress=progress, cancel=cancel)  # fmt: skip
    return report.end(errors)


class _Values:
    """Takes the results of `map`."""

    def __init__(self, report):
        self.report = report

    def take(self, index, value, seconds, host):
        self.report.values[index] = value

    def forget(self, indices):
        for index in indices:
            self.report.values[index] = None


class _Sink:
    """Takes the results of `render`: files from the workers, and the lines of the manifest."""

    def __init__(self, manifest, pattern, write):
        self.manifest, self.pattern, self.write = manifest, pattern, write

    def take(self, index, value, seconds, host_name):
        if self.manifest is None:
            return
        crc, length, file_crc, data = value
        path = self.pattern % index
        if data is not None:
            from .. import _native

            _native.write_file(path, data)
        elif not os.path.exists(path):
            where = "%s: a worker on %s wrote it, but it is not there" % (path, host_name)
            raise FileNotFoundError(where + ": do all workers see this folder? write='client' sends files")
        file = {"name": os.path.basename(path), "bytes": length, "crc": "%08x" % file_crc}
        self.manifest.append(record_of(index, crc, file, seconds, time.time(), host_name or host()))

    def forget(self, indices):
        if self.manifest is not None:
            self.manifest.forget(indices)

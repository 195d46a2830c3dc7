"""Batches: in this process, on a cluster of two processes, and whatever happens to it."""

import errno
import functools
import gc
import json
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
import zlib

import pytest

import fbptr
import fbptr.batch
from fbptr.batch import BatchError, tasks
from fbptr.batch.manifest import Manifest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "examples"))
from nd_sweep import tesseract  # noqa: E402

MESH = b"v 0 0 0\nv 2 0 0\nv 0 1 1\nf 1 2 3\n"
SWEEP = {"format": "json", "turns": ["0,3,360", "1,2,180"]}


def manifest(folder):
    return [json.loads(line) for line in (folder / "frames-0-of-1.jsonl").read_text().splitlines()]


def crcs(frames=60, **options):
    """The CRCs of a sweep, drawn in this process."""
    scene = fbptr.Scene.load(tesseract((32, 24)), frames=frames, **SWEEP, **options)
    return {k: scene.crc(k) for k in range(frames)}


@functools.cache
def expected():
    return crcs()


@pytest.fixture(scope="module")
def cluster():
    distributed = pytest.importorskip("distributed", reason="distributed is not installed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, silence_logs=50, protocol="tcp"
    ) as cluster:
        yield cluster
    # Tasks that the cluster left behind report their exceptions when they are collected. Within `ast.parse`, by which
    # pytest imports, CPython 3.11.7 takes that for an error: "AST constructor recursion depth mismatch".
    gc.collect()


@pytest.fixture
def client(cluster):
    distributed = pytest.importorskip("distributed", reason="distributed is not installed")
    with distributed.Client(cluster) as client:
        client.wait_for_workers(2, timeout=60)
        yield client


# In this process.


def test_a_scene_draws_any_frame_in_any_order():
    scene = fbptr.Scene.load(MESH, format="obj", frames=8, size=(32, 24))
    assert scene.size == (32, 24) and scene.frames == 8
    pixels = [scene.pixels(k) for k in range(8)]
    assert len(set(pixels)) == 8 and len(pixels[0]) == 32 * 24 * 4
    again = fbptr.Scene.load(MESH, format="obj", frames=8, size=(32, 24))
    assert [again.pixels(k) for k in reversed(range(8))] == pixels[::-1]
    assert scene.crc(3) == zlib.crc32(pixels[3])
    with pytest.raises(ValueError, match="from 0 to 7, found 8"):
        scene.pixels(8)
    with pytest.raises(ValueError, match="expected the format"):
        fbptr.Scene.load(MESH, format="dxf")
    for planes, expected in (({"near": 0}, "above 0"), ({"far": float("nan")}, "above 0"), ({"near": 2, "far": 2}, "less than")):
        with pytest.raises(ValueError, match=expected):
            fbptr.Scene.load(MESH, format="obj", **planes)
    with pytest.raises(ValueError, match="from 0 to 3"):
        fbptr.Scene.load(tesseract((8, 8)), format="json", turns=["0,4,90"])


def test_frames_are_files_with_a_manifest_and_only_missing_ones_are_drawn(tmp_path):
    report = fbptr.batch.render(MESH, 6, tmp_path, (32, 24), format="obj", progress=False)
    assert report.missing == 0 and len(manifest(tmp_path)) == 6
    for record in manifest(tmp_path):
        data = (tmp_path / record["files"][0]["name"]).read_bytes()
        assert record["files"][0]["bytes"] == len(data)
        assert record["files"][0]["crc"] == "%08x" % zlib.crc32(data)
        assert record["crc"] == "%08x" % report.crcs[record["frame"]]
    (tmp_path / "frame-0001.png").unlink()
    (tmp_path / "frame-0004.png").write_bytes(b"damaged")
    with open(tmp_path / "frames-0-of-1.jsonl", "ab") as file:
        file.write(b'{"frame":5,"torn')
    again = fbptr.batch.render(MESH, 6, tmp_path, (32, 24), format="obj", progress=False)
    assert again.there == 4 and again.crcs == report.crcs
    assert [record["frame"] for record in manifest(tmp_path)] == [0, 1, 2, 3, 4, 5, 1, 4]
    # Another size is another batch under the same names: everything is drawn.
    assert fbptr.batch.render(MESH, 6, tmp_path, (16, 12), format="obj", progress=False).there == 0
    with pytest.raises(ValueError, match="one batch a folder"):
        fbptr.batch.render(MESH, 6, tmp_path, (16, 12), format="obj", name="other", progress=False)


def test_lines_of_other_frames_stay_when_some_are_forgotten(tmp_path):
    fbptr.batch.render(MESH, 6, tmp_path, (32, 24), format="obj", progress=False)
    before = manifest(tmp_path)
    # What a killed process leaves, and what is nobody's.
    (tmp_path / ".fbptr-1-2.tmp").write_bytes(b"half a picture")
    (tmp_path / ".other.tmp").write_bytes(b"")
    template = {key: before[0][key] for key in ("of", "size", "fps", "version", "recipe")}
    kept = Manifest(tmp_path, template, str(tmp_path / "frame-%04d.png"))
    try:
        assert not (tmp_path / ".fbptr-1-2.tmp").exists() and (tmp_path / ".other.tmp").exists()
        kept.forget([1, 4])
        assert manifest(tmp_path) == [before[k] for k in (0, 2, 3, 5)]
        kept.append({key: value for key, value in before[4].items() if key not in template})
        assert manifest(tmp_path)[-1] == before[4]
        with pytest.raises(BlockingIOError, match="another process"):
            Manifest(tmp_path, template, kept.pattern)
    finally:
        kept.close()
    report = fbptr.batch.render(MESH, 6, tmp_path, (32, 24), format="obj", progress=False)
    assert report.there == 5 and [line["frame"] for line in manifest(tmp_path)] == [0, 2, 3, 5, 4, 1]


def program():
    """The program, if it is built beside the package; the checks build it."""
    targets = [os.environ.get("CARGO_TARGET_DIR", ""), os.path.join(HERE, "..", "..", "target")]
    for target in filter(None, targets):
        for place in ("debug", "release"):
            path = os.path.join(target, place, "fbptr")
            if os.path.exists(path):
                return os.path.abspath(path)
    return shutil.which("fbptr")


def test_the_program_takes_the_frames_for_its_own(tmp_path):
    found = program()
    if found is None:
        pytest.skip("the program fbptr is not built")
    (tmp_path / "mesh.obj").write_bytes(MESH)
    out = tmp_path / "out"
    fbptr.batch.render(tmp_path / "mesh.obj", 6, out, (32, 24), last=3, progress=False)
    line = [found, "render", "mesh.obj", "--frames", "6", "--size", "32x24", "-o", "out/frame.png"]
    run = functools.partial(subprocess.run, cwd=tmp_path, capture_output=True, text=True)
    drawn = run(line + ["--shard", "0/2"])
    assert drawn.returncode == 0 and "2 of 3 frames are there already" in drawn.stderr
    checked = run([found, "batch", "check", "out"])
    assert checked.returncode == 1 and "missing: 5\n" in checked.stdout
    assert fbptr.batch.render(tmp_path / "mesh.obj", 6, out, (32, 24), progress=False).there == 5
    assert run([found, "batch", "check", "out"]).returncode == 0


def fails_at_37(number):
    if number == 37:
        raise ValueError("no picture at 37")
    return number * number


def test_an_item_that_fails_is_named_and_the_others_are_there():
    message = "49 of 50 are there; 37 failed: ValueError: no picture at 37"
    with pytest.raises(BatchError, match=message) as caught:
        fbptr.batch.map(fails_at_37, range(50), progress=False)
    report = caught.value.report
    assert set(report.failed) == {37} and report.values[49] == 49 * 49


def test_a_cancelled_batch_says_so_and_goes_on(tmp_path):
    cancel = threading.Event()
    with pytest.raises(BatchError, match="stopped: cancelled") as caught:
        fbptr.batch.render(
            MESH, 20, tmp_path, (16, 12), format="obj", cancel=cancel,
            progress=lambda done, count: done >= 5 and cancel.set(),
        )  # fmt: skip
    assert len(caught.value.report.crcs) == 5 == len(manifest(tmp_path))
    assert fbptr.batch.render(MESH, 20, tmp_path, (16, 12), format="obj", progress=False).there == 5


LIMITED = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (4096, 4096))
import fbptr.batch
fbptr.batch.render(%r, 60, sys.argv[1], (24, 16), format="obj", ending="raw", progress=False)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of file sizes")
def test_a_full_disk_is_said_and_nothing_is_lost(tmp_path):
    # Files may not grow beyond 4 KiB: the manifest does, after some frames.
    command = [sys.executable, "-c", LIMITED % MESH, str(tmp_path)]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.returncode == 1 and "stopped: [Errno 27]" in ended.stderr, ended.stderr
    lines = manifest(tmp_path)
    assert 0 < len(lines) < 60, "no torn line"
    assert all(name.startswith("frame") for name in os.listdir(tmp_path)), "no temporary file"
    report = fbptr.batch.render(MESH, 60, tmp_path, (24, 16), format="obj", ending="raw", progress=False)
    assert report.there == len(lines) and report.missing == 0


MAPPED = """
import resource, signal, sys
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (64, 64))
import fbptr, fbptr.batch
fbptr.batch.map(lambda i: fbptr.Framebuffer(64, 64), range(9), out=sys.argv[1], ending="raw", progress=False)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of file sizes")
def test_a_full_disk_ends_a_map_of_framebuffers(tmp_path):
    ended = subprocess.run([sys.executable, "-c", MAPPED, str(tmp_path)], capture_output=True, text=True)
    assert ended.returncode == 1 and "0 of 9 are there; stopped: [Errno 27]" in ended.stderr, ended.stderr
    assert os.listdir(tmp_path) == [], "no temporary file"


def test_crcs_do_not_depend_on_the_process():
    frame = fbptr.Framebuffer(8, 8)
    frame.clear("red")
    assert tasks.crc_of(frame) == zlib.crc32(bytes([255, 0, 0, 255]) * 64)
    assert tasks.crc_of({"a": 1, "b": [2, "c"]}) == tasks.crc_of({"b": [2, "c"], "a": 1})
    assert tasks.crc_of([1, 2]) != tasks.crc_of([2, 1])
    assert tasks.crc_of(1.5) != tasks.crc_of(1.25)


# A far plane that comes nearer by 8 a second, from 21: at 1.85 s, frame 37, it is nearer than 6.3.
NEARER = b"""<X3D profile="Interchange" version="4.0"><Scene>
  <Viewpoint DEF="Eye" position="0 0 9" nearDistance="1" farDistance="21"/>
  <Shape><Appearance><Material/></Appearance><Sphere/></Shape>
  <TimeSensor DEF="Clock" cycleInterval="2" loop="true"/>
  <ScalarInterpolator DEF="Far" key="0 1" keyValue="21 5"/>
  <ROUTE fromNode="Clock" fromField="fraction_changed" toNode="Far" toField="set_fraction"/>
  <ROUTE fromNode="Far" fromField="value_changed" toNode="Eye" toField="farDistance"/>
</Scene></X3D>"""


def render_nearer(out, client=None):
    options = {"format": "x3d", "fps": 20, "near": 6.3, "errors": "return", "progress": False}
    return fbptr.batch.render(NEARER, 38, out, (32, 24), client=client, **options)


def test_a_scene_that_fails_at_a_frame_is_named(tmp_path):
    report = render_nearer(tmp_path)
    assert list(report.failed) == [37] and "frame 37: camera" in report.failed[37]
    assert len(manifest(tmp_path)) == 37 == len(report.crcs)
    assert "37 of 38 are there, 37 from before; 37 failed:" in str(render_nearer(tmp_path))


# On a cluster.


def test_a_scene_that_fails_at_a_frame_is_named_by_a_cluster(client, tmp_path):
    report = render_nearer(tmp_path, client)
    assert list(report.failed) == [37] and "frame 37: camera" in report.failed[37]
    assert len(manifest(tmp_path)) == 37 and report.crcs == render_nearer(None).crcs
    assert not report.accused


def render(client, out=None, **options):
    options = {"progress": False, **SWEEP, **options}
    return fbptr.batch.render(tesseract((32, 24)), 60, out, client=client, **options)


def test_a_cluster_draws_the_frames_of_one_process(client, tmp_path):
    report = render(client, tmp_path, verify=10, chunk_seconds=0.05)
    assert report.crcs == expected()
    assert report.verified == 6 and len(report.workers) == 2 and not report.accused
    here = tmp_path / "here"
    fbptr.batch.render(tesseract((32, 24)), 60, here, progress=False, **SWEEP)
    for k in range(60):
        name = "frame-%04d.png" % k
        assert (tmp_path / name).read_bytes() == (here / name).read_bytes(), name
    sent = tmp_path / "sent"
    assert render(client, sent, write="client", last=9).crcs == {k: expected()[k] for k in range(10)}
    assert (sent / "frame-0009.png").read_bytes() == (here / "frame-0009.png").read_bytes()
    assert render(client).crcs == expected(), "CRCs alone"


def draws(number):
    frame = fbptr.Framebuffer(16, 16)
    frame.circle(8, 8, number % 8, "gold")
    return frame


def test_a_function_is_mapped_over_parameters(client, tmp_path):
    report = fbptr.batch.map(draws, range(30), client=client, verify=5, progress=False)
    assert report.verified == 6
    assert [zlib.crc32(bytes(draws(k))) for k in range(30)] == [report.crcs[k] for k in range(30)]
    assert report.values[3].startswith(b"\x89PNG")
    report = fbptr.batch.map(draws, range(8), client=client, out=tmp_path, progress=False)
    assert report.values[5] == str(tmp_path / "item-0005.png") and os.path.exists(report.values[5])
    only = fbptr.batch.map(draws, range(8), client=client, results="crcs", progress=False)
    assert only.crcs == report.crcs and only.values == [None] * 8
    with pytest.raises(BatchError, match="37 failed: ValueError: no picture at 37"):
        fbptr.batch.map(fails_at_37, range(50), client=client, progress=False)


def slow(number):
    time.sleep(0.02)
    return number


def test_workers_that_are_killed_lose_nothing(client):
    killed = []

    def kill(done, count):
        if len(killed) < 2 and done >= 20 * (len(killed) + 1):
            for address, worker in client.run(os.getpid).items():
                if worker not in killed:
                    killed.append(worker)
                    os.kill(worker, signal.SIGKILL)
                    break

    report = fbptr.batch.map(slow, range(100), client=client, chunk=4, progress=kill)
    assert len(killed) == 2
    assert report.values == list(range(100)) and not report.failed
    client.wait_for_workers(2, timeout=60)

    killed.clear()
    report = render(client, chunk=3, progress=kill)
    assert len(killed) == 2 and report.crcs == expected()
    client.wait_for_workers(2, timeout=60)


def set_version(version):
    import fbptr

    fbptr.__version__ = version


def test_a_worker_of_another_version_is_named_and_left_out(client):
    first, second = sorted(client.scheduler_info(n_workers=-1)["workers"])
    client.run(set_version, "0.0.1", workers=[second])
    try:
        report = render(client, chunk=3, verify=10)
        assert report.crcs == expected() and list(report.workers) == [first]
        assert report.accused == {second: "version 0.0.1, expected " + fbptr.__version__}
        assert "not verified" in str(report)
        client.run(set_version, "0.0.1", workers=[first])
        with pytest.raises(BatchError, match="every worker was left out"):
            render(client)
    finally:
        client.run(set_version, fbptr.__version__)


def test_where_one_worker_is_left_out_the_other_may_die_and_come_back(client):
    first, second = sorted(client.scheduler_info(n_workers=-1)["workers"])
    client.run(set_version, "0.0.1", workers=[second])
    killed = []

    def kill(done, count):
        if done >= 20 and not killed:
            killed.append(client.run(os.getpid, workers=[first])[first])
            os.kill(killed[0], signal.SIGKILL)

    try:
        report = render(client, chunk=3, verify=0, progress=kill)
        assert killed and report.crcs == expected() and list(report.accused) == [second]
    finally:
        client.wait_for_workers(2, timeout=120)
        client.run(set_version, fbptr.__version__)


def break_crcs(by):
    """Lets a worker count wrong from now on."""
    from fbptr.batch import tasks

    if not hasattr(tasks, "right_crc_of"):
        tasks.right_crc_of = tasks.crc_of
    tasks.crc_of = lambda value: tasks.right_crc_of(value) ^ by


def test_a_worker_that_disagrees_is_named_and_its_items_are_drawn_again(client):
    first, second = sorted(client.scheduler_info(n_workers=-1)["workers"])
    client.run(break_crcs, 1, workers=[second])
    try:
        report = fbptr.batch.map(slow, range(60), client=client, chunk=2, verify=5, progress=False)
        assert list(report.accused) == [second] and "crc" in report.accused[second]
        assert list(report.workers) == [first]
        assert report.crcs == {k: tasks.crc_of(k) for k in range(60)}
        assert report.values == list(range(60))
    finally:
        client.run(break_crcs, 0)


def random_bytes(number):
    return os.urandom(8) if number == 20 else b"same"


def test_a_function_without_equal_results_blames_no_worker(client):
    options = {"client": client, "chunk": 5, "verify": 20, "progress": False}
    with pytest.raises(BatchError, match="20 failed: .* other ones each time: with verify=0") as caught:
        fbptr.batch.map(random_bytes, range(40), **options)
    report = caught.value.report
    assert not report.accused and len(report.crcs) == 39 and report.values[20] is None
    assert report.verified == 1
    assert not fbptr.batch.map(random_bytes, range(40), **{**options, "verify": 0}).missing


def proofs_fail(count):
    """Lets the next proofs on a worker fail."""
    import functools

    from fbptr.batch import tasks

    prove = tasks.MapJob.__dict__.get("right_prove", tasks.MapJob.prove)
    tasks.MapJob.right_prove = prove
    left = [count]

    @functools.wraps(prove)
    def failing(self, index, param):
        left[0] -= 1
        if left[0] >= 0:
            raise MemoryError("no room for a proof")
        return prove(self, index, param)

    tasks.MapJob.prove = failing


@pytest.mark.parametrize("count", [1, 1000])
def test_a_proof_that_fails_blames_no_worker(client, count):
    client.run(proofs_fail, count)
    try:
        report = fbptr.batch.map(slow, range(40), client=client, chunk=4, verify=20, progress=False)
    finally:
        client.run(proofs_fail, 0)
    assert report.values == list(range(40)) and not report.accused
    assert (report.verified, "not verified: MemoryError: no room" in str(report)) == ((2, False) if count == 1 else (0, True))


def full(number):
    if number == 20:
        raise OSError(errno.ENOSPC, "No space left on device", "a.png")
    return number


def test_a_full_disk_of_a_worker_ends_the_batch(client):
    with pytest.raises(BatchError, match="stopped: .*No space left on device: 'a.png'") as caught:
        fbptr.batch.map(full, range(200), client=client, chunk=5, progress=False)
    report = caught.value.report
    assert 0 < len(report.crcs) < 200 and all(report.values[k] == k for k in report.crcs)


def test_a_batch_on_a_cluster_is_cancelled(client):
    cancel = threading.Event()
    with pytest.raises(BatchError, match="stopped: cancelled") as caught:
        fbptr.batch.map(
            slow, range(400), client=client, chunk=2, cancel=cancel,
            progress=lambda done, count: done >= 10 and cancel.set(),
        )  # fmt: skip
    assert 10 <= len(caught.value.report.crcs) < 400

"""Measures batches on clusters of this machine: frames a second, efficiency, the scheduler's cost.

    python benches/batch.py [--workers 1 2 4] [--frames 400] [--size 640 480] [--runs 5]

Prints the medians of rounds: the tesseract of examples/nd_sweep.py, drawn to CRCs by one process
without Dask, by as many as a cluster has, each on its own, and by clusters of worker processes
with one thread each; the cost of an item that
does nothing, in tasks of 20 and of 1; the time to send a job of 1 and 10 MB to all workers.
"""

import argparse
import contextlib
import multiprocessing
import os
import statistics
import sys
import time

import fbptr.batch

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "examples"))
from nd_sweep import tesseract  # noqa: E402


def nothing(number):
    return number


def part(job):
    """Draws frames in a process of its own."""
    scene, first, count = job
    loaded = fbptr.Scene.load(scene, format="json", frames=1000, turns=["0,3,360", "1,2,180"])
    for frame in range(first, first + count):
        loaded.crc(frame)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--workers", type=int, nargs="+", default=[1, 2, 4])
    parser.add_argument("--frames", type=int, default=400)
    parser.add_argument("--size", type=int, nargs=2, default=(640, 480))
    parser.add_argument("--runs", type=int, default=5)
    args = parser.parse_args()

    from distributed import Client, LocalCluster

    scene = tesseract(args.size)

    def sweep(client=None, frames=args.frames):
        return fbptr.batch.render(scene, 1000, last=frames - 1, client=client, format="json",
                                  progress=False, turns=["0,3,360", "1,2,180"], verify=0)  # fmt: skip

    # Processes that know nothing of each other: the most that this machine gives.
    context = multiprocessing.get_context("spawn")
    most = max(args.workers)
    with contextlib.ExitStack() as stack:
        pool = stack.enter_context(context.Pool(most))
        pool.map(part, [(scene, 0, 2)] * most, chunksize=1)

        def apart(count):
            begun = time.perf_counter()
            share = args.frames // count
            pool.map(part, [(scene, i * share, share) for i in range(count)], chunksize=1)
            return time.perf_counter() - begun

        runs = {"one process": lambda: apart(1)}
        clients = {}
        for count in args.workers:
            cluster = LocalCluster(count, threads_per_worker=1, dashboard_address=":0", protocol="tcp")
            client = clients[count] = stack.enter_context(Client(stack.enter_context(cluster)))
            sweep(client, 10 * count)
            if count > 1:
                runs["%d processes" % count] = lambda count=count: apart(count)
            runs["%d workers" % count] = lambda client=client: sweep(client).seconds
        # One after the other in each round, so that a slow moment of the machine meets all.
        rounds = [{name: run() for name, run in runs.items()} for _ in range(args.runs)]
        print("%d frames, a scene of %d bytes; medians of %d rounds" % (args.frames, len(scene), args.runs))
        for name in runs:
            seconds = statistics.median(row[name] for row in rounds)
            times = [row["one process"] / row[name] for row in rounds]
            print("%s: %.1f frames a second, %.2f times one process (%.2f to %.2f)" % (
                name, args.frames / seconds, statistics.median(times), min(times), max(times)),
                flush=True)  # fmt: skip
        for count in args.workers:
            costs(count, clients[count])


def costs(count, client):
    """Prints the costs of tasks and of sending on a cluster."""
    for size, items in ((20, 2000), (1, 400)):
        runs = [fbptr.batch.map(nothing, range(items), client=client, chunk=size, verify=0, progress=False)
                for _ in range(2)]  # fmt: skip
        ms = min(report.seconds for report in runs) / items * 1e3
        print("%d workers, an item that does nothing, %d a task: %.3f ms an item, %.2f ms a task"
              % (count, size, ms, ms * size), flush=True)  # fmt: skip
    for mega in (1, 10):
        begun = time.perf_counter()
        client.scatter(os.urandom(mega * 1_000_000), broadcast=True, hash=False)
        print("%d workers, %d MB to all: %.1f ms" % (count, mega, (time.perf_counter() - begun) * 1e3),
              flush=True)  # fmt: skip


if __name__ == "__main__":
    main()

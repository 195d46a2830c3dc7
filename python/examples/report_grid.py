"""The grid of a report over scenes: every scene in every shading mode, and its error.

    python report_grid.py ../tests/data/x3d/made/*.x3d
    python report_grid.py --scheduler tcp://head:8786 scenes/*.glb

Prints for each scene and mode the root of the mean squared error of the colours against Phong
shading, in 1/255. The numbers are the same on every machine, so the batch proves itself.
"""

import argparse
import itertools
import os

MODES = ["wire", "flat", "gouraud", "phong"]
SIZE = (320, 240)


def error(item):
    """Returns the colour error of a mode against Phong shading, and its largest step."""
    import numpy

    import fbptr
    from fbptr.scene import read

    data, format, name, root = read(item["scene"])

    def picture(mode):
        scene = fbptr.Scene(data, format, name, folder=root, size=SIZE, shade=mode)
        return scene.numpy(0)[..., :3].astype(numpy.int64)

    difference = picture(item["mode"]) - picture("phong")
    return float(numpy.sqrt(numpy.mean(difference * difference))), int(abs(difference).max())


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--scheduler")
    args = parser.parse_args()

    from distributed import Client

    import fbptr.batch

    client = Client(args.scheduler) if args.scheduler else Client(threads_per_worker=1)
    scenes = [os.path.abspath(scene) for scene in args.scenes]
    grid = [{"scene": scene, "mode": mode} for scene, mode in itertools.product(scenes, MODES)]
    with client:
        report = fbptr.batch.map(error, grid, client=client, errors="return")
    print("| scene | " + " | ".join(MODES) + " |")
    print("|---" + "|---:" * len(MODES) + "|")
    for i, scene in enumerate(scenes):
        row = report.values[i * len(MODES) : (i + 1) * len(MODES)]
        cells = ["refused" if value is None else "%.2f (%d)" % value for value in row]
        print("| %s | %s |" % (os.path.basename(scene), " | ".join(cells)))
    print(report)


if __name__ == "__main__":
    main()

"""A tesseract turned through two planes in 1,000 frames, over the workers of a Dask cluster.

    python nd_sweep.py frames/                     # a cluster of this machine's cores
    python nd_sweep.py frames/ tcp://head:8786     # workers that see the same folder
    fbptr batch check frames && fbptr batch movie frames -o sweep.gif

Run again it draws what is missing. One frame in fifty is drawn by a second worker as a proof.
"""

import argparse
import itertools
import json
import math


def tesseract(pixels):
    """Returns the scene of a cube of 4 dimensions, seen through an aperture, as JSON."""
    colours = ["tomato", "gold", "seagreen", "royalblue", "orchid", "coral", "turquoise", "khaki"]
    facets = []
    for cell, (axis, side) in enumerate(itertools.product(range(4), (-1, 1))):
        rest = [a for a in range(4) if a != axis]
        # Each cell is a cube, cut into six simplices: one for each order of its axes.
        for order in itertools.permutations(rest):
            corner = [-1.0] * 4
            corner[axis] = float(side)
            simplex = [list(corner)]
            for a in order:
                corner[a] = 1.0
                simplex.append(list(corner))
            facets.append({"v": simplex, "color": colours[cell]})
    scene = {
        "dim": 4, "pixels": list(pixels), "d": 1, "S": [0.8, 0.8 * pixels[1] / pixels[0]],
        "aperture_tan": [0.4], "I_d": 0.25, "background": [12, 14, 24],
        "eye": {"position": [-6, 0, 0, 0], "rotations": []},
        "lights": [{"type": "parallel", "direction": [1, -0.4, -0.7, 0.2], "k": 0.75, "n": 0}],
        "facets": facets,
    }  # fmt: skip
    # Turned a little, so that no cell is edge-on in the first frame.
    for a, b, degrees in [(0, 1, 30), (0, 2, 20)]:
        cos, sin = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        for facet in facets:
            for p in facet["v"]:
                p[a], p[b] = cos * p[a] - sin * p[b], sin * p[a] + cos * p[b]
    return json.dumps(scene).encode()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out")
    parser.add_argument("scheduler", nargs="?")
    parser.add_argument("--frames", type=int, default=1000)
    parser.add_argument("--size", type=int, nargs=2, default=(320, 240))
    args = parser.parse_args()

    from distributed import Client

    import fbptr.batch

    # Without an address: worker processes of this machine, one thread each.
    client = Client(args.scheduler) if args.scheduler else Client(threads_per_worker=1)
    with client:
        report = fbptr.batch.render(
            tesseract(args.size), frames=args.frames, out=args.out, format="json", name="tesseract",
            turns=["0,3,360", "1,2,180"], client=client,
        )  # fmt: skip
    print(report)
    for worker, count in sorted(report.workers.items()):
        print("%s: %d frames" % (worker, count))
    drawn = len(report.crcs) - report.there
    print("%.1f frames a second, %.2f ms each" % (drawn / report.seconds, report.cost * 1e3))


if __name__ == "__main__":
    main()

"""The cost of a verb from Python: of the framebuffer in this process, and of a server's client.

    python python/benches/verbs.py path/to/fbptr      # the program, for the server

Prints nanoseconds a call, the least of several rounds: calls of a client are buffered and end with a
reply that is waited for, so that they have taken effect. Then the time of an import, in a process of
its own, without the interpreter's start.
"""

import subprocess
import sys
import time

import fbptr

ROUNDS, CALLS = 7, 5000
PLACE = [(i % 60, i % 40) for i in range(CALLS)]


def least(call):
    """Returns the least nanoseconds of a call among the rounds."""
    found = []
    for _ in range(ROUNDS):
        start = time.perf_counter_ns()
        call()
        found.append((time.perf_counter_ns() - start) / CALLS)
    return min(found)


def each(fb, call):
    """Returns a function that makes all calls and waits for them."""

    def run():
        for x, y in PLACE:
            call(fb, x, y)
        fb.sync()

    return run


VERBS = {
    "px": lambda fb, x, y: fb.pixel(x, y, "ff8000"),
    "line, 20 pixels": lambda fb, x, y: fb.line(x, y, x + 19, y + 4, "red"),
    "fill, 150 pixels": lambda fb, x, y: fb.fill([(x, y), (x + 20, y), (x, y + 15)], "red"),
    "translate": lambda fb, x, y: fb.translate(0.0, 0.0, 0.0),
    "crc 1x1 (a reply)": lambda fb, x, y: fb.crc(x, y, 1, 1),
}


def import_ms():
    """Returns the least milliseconds of an import of the package among several processes."""
    program = "import time; t = time.perf_counter_ns(); import fbptr; print(time.perf_counter_ns() - t)"
    runs = [subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True) for _ in range(9)]
    return sorted(int(run.stdout) / 1e6 for run in runs)


def main(program):
    serve = [program, "serve", "--listen", "127.0.0.1:0", "--size", "64x48", "--headless"]
    server = subprocess.Popen(serve, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    try:
        address = next(w for line in server.stdout for w in line.split() if w.startswith("127.0.0.1:"))
        with fbptr.Client(address) as client:
            own = fbptr.Framebuffer(64, 48)
            print("| verb | here, ns | client, ns |\n|---|---:|---:|")
            for name, call in VERBS.items():
                print("| %s | %.0f | %.0f |" % (name, least(each(own, call)), least(each(client, call))))
            same = own.crc() == client.crc()
            print("| `fb[offset] = v` | %.0f | |" % least(lambda: [own.__setitem__(i, 7) for i in range(CALLS)]))
    finally:
        server.terminate()
    times = import_ms()
    print("import: %.1f ms, median %.1f ms" % (times[0], times[len(times) // 2]))
    print("pictures are the same" if same else "the pictures DIFFER")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1] if len(sys.argv) > 1 else "fbptr"))

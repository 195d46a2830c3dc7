"""Prints the median time of `import fbptr` beyond the interpreter's own start, in milliseconds, of eleven turns."""

import statistics
import subprocess
import sys
import time


def start(code):
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True)
    return (time.perf_counter() - begin) * 1000


start("import fbptr")
print(f'{statistics.median(start("import fbptr") - start("pass") for _ in range(11)):.1f}')

#!/usr/bin/env python3
"""Times `fbptr run` under a program that writes whole frames: the processor time of fbptr alone, and frames a second.

    benches/framebuffer.py target/release/fbptr [--size 1920x1080] [--seconds 10] [--formats bgrx,rgba,rgb565]
                           [--window [--crt] [--screen FILE]]

The program, compiled here with cc, writes every byte of the frame at each vertical blank: the same bytes (no row
changes), or another colour (all rows change). Its own time does not count. A frame counts where it differs from the one
before, by `--after`. With --window, frames are shown in a window of the display that DISPLAY names, with --crt with
the look of a tube; --screen, the file that `Xvfb -fbdir` writes, counts the frames that arrive on that screen.
"""

import argparse
import mmap
import os
import subprocess
import tempfile
import time

WRITER = r"""
#include <fcntl.h>
#include <linux/fb.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>

int main(int count, char **words)
{
    struct fb_var_screeninfo v;
    struct fb_fix_screeninfo f;
    int fd = open("/dev/fb0", O_RDWR), screen = 0;
    if (fd < 0 || ioctl(fd, FBIOGET_VSCREENINFO, &v) || ioctl(fd, FBIOGET_FSCREENINFO, &f))
        return 1;
    size_t page = (size_t)f.line_length * v.yres;
    char *fb = mmap(0, page, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    if (fb == MAP_FAILED)
        return 2;
    for (int i = 0;; i++) {
        memset(fb, count > 1 && !strcmp(words[1], "all") ? 1 + i % 250 : 77, page);
        ioctl(fd, FBIO_WAITFORVSYNC, &screen);
    }
}
"""


def seconds_of(pid):
    """Returns the processor time of a process and all its threads."""
    with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def start(options, more, writer, mode):
    """Starts a run."""
    command = [options.fbptr, "run", "--size", options.size, *more]
    command += [] if options.window else ["--headless"]
    command += ["--crt"] if options.crt else []
    return subprocess.Popen([*command, "--", writer, mode], stderr=subprocess.DEVNULL)


def shown(path, seconds):
    """Returns how many frames a second arrive on the screen: changes of the pixel in its middle."""
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ) as screen:
        at, changes, last = len(screen) // 8 * 4, 0, b""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            now = screen[at : at + 4]
            changes, last = changes + (now != last), now
            time.sleep(0.001)
    return (changes - 1) / seconds


def main():
    """Prints a table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("fbptr")
    parser.add_argument("--size", default="1920x1080")
    parser.add_argument("--seconds", type=float, default=10)
    parser.add_argument("--formats", default="bgrx,rgba,rgb565")
    parser.add_argument("--window", action="store_true")
    parser.add_argument("--crt", action="store_true")
    parser.add_argument("--screen")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        writer = os.path.join(folder, "writer")
        subprocess.run(["cc", "-O2", "-x", "c", "-", "-o", writer], input=WRITER, text=True, check=True)
        print("| format | rows that change | one core | frames a second | shown a second |\n|---|---|---:|---:|---:|")
        for pixels in options.formats.split(","):
            for mode in ("none", "all"):
                run = start(options, ["--format", pixels], writer, mode)
                time.sleep(2)
                begun, before = time.monotonic(), seconds_of(run.pid)
                time.sleep(options.seconds)
                share = (seconds_of(run.pid) - before) / (time.monotonic() - begun)
                on_screen = f"{shown(options.screen, options.seconds):.1f}" if options.screen and mode == "all" else "-"
                run.terminate()
                run.wait()
                rate = "-"
                if mode == "all":
                    frames = int(60 * options.seconds)
                    begun = time.monotonic()
                    start(options, ["--format", pixels, "--after", str(frames)], writer, mode).wait()
                    rate = f"{frames / (time.monotonic() - begun):.1f}"
                print(f"| {pixels} | {mode} | {share:.0%} | {rate} | {on_screen} |", flush=True)


if __name__ == "__main__":
    main()

"""Measures the time from a key to the picture of `fbptr view`, on a virtual X server.

    python3 benches/key_latency.py target/release/fbptr model.obj 100

Needs Xvfb and xdotool. A key goes to the window through `xdotool -`, once the picture has stood
still for 0.7 s; the time ends when a pixel in rows 200 to 519 of the screen's file has changed.
"""
import mmap, os, struct, subprocess, sys, tempfile, time

program, model, count = os.path.abspath(sys.argv[1]), sys.argv[2], int(sys.argv[3])
folder = tempfile.mkdtemp()
server = subprocess.Popen(
    ["Xvfb", ":77", "-screen", "0", "1280x900x24", "-nolisten", "tcp", "-noreset", "-fbdir", folder],
    stderr=subprocess.DEVNULL)
time.sleep(1.5)
environment = {k: v for k, v in os.environ.items() if k != "WAYLAND_DISPLAY"} | {"DISPLAY": ":77"}
viewer = subprocess.Popen([program, "view", model], env=environment)
try:
    time.sleep(3)
    search = ["xdotool", "search", "--onlyvisible", "--name", "fbptr"]
    window = subprocess.check_output(search, env=environment).split()[0].decode()
    subprocess.run(["xdotool", "windowmove", window, "0", "0", "mousemove", "480", "360"], env=environment)
    with open(folder + "/Xvfb_screen0", "rb") as file:
        screen = mmap.mmap(file.fileno(), 0, prot=mmap.PROT_READ)
    # The XWD header: its length, the stride in bytes, the number of colours of 12 bytes each.
    header = struct.unpack(">25I", screen[:100])
    first = header[0] + header[19] * 12
    rows = slice(first + 200 * header[12], first + 520 * header[12])
    keys = subprocess.Popen(["xdotool", "-"], stdin=subprocess.PIPE, env=environment)
    took_ms = []
    for i in range(count):
        before, since = screen[rows], time.perf_counter()
        while time.perf_counter() - since < 0.7:
            time.sleep(0.02)
            if screen[rows] != before:
                before, since = screen[rows], time.perf_counter()
        begun = time.perf_counter()
        keys.stdin.write(b"key Left\n" if i % 2 else b"key Right\n")
        keys.stdin.flush()
        while screen[rows] == before:
            time.sleep(0.0005)
        took_ms.append((time.perf_counter() - begun) * 1e3)
    took_ms.sort()
    p99 = took_ms[min(count - 1, count * 99 // 100)]
    print(f"{count} keys: median {took_ms[count // 2]:.1f} ms, p99 {p99:.1f} ms, "
          f"least {took_ms[0]:.1f} ms, most {took_ms[-1]:.1f} ms")
finally:
    viewer.terminate()
    viewer.wait()
    server.terminate()
    server.wait()

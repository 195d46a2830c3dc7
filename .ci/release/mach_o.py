"""Looks into a program of macOS: mach_o.py PROGRAM. Prints its processor, the oldest macOS that it runs on and the
libraries that it loads; ends with status 1 if it is none, is not linked to its end or loads what not every macOS has."""

import struct
import sys

PROCESSORS = {0x01000007: "x86-64", 0x0100000C: "arm64"}
LOAD_LIBRARY, BUILD_VERSION, OLDEST_VERSION = 0xC, 0x32, 0x24


def version(word):
    return f"{word >> 16}.{word >> 8 & 255}"


def main():
    data = open(sys.argv[1], "rb").read()
    magic, processor, _, kind, count, _, flags = struct.unpack_from("<7I", data)
    # A 64-bit program (MH_EXECUTE) without open symbols (MH_NOUNDEFS).
    if magic != 0xFEEDFACF or kind != 2 or not flags & 1:
        sys.exit(f"{sys.argv[1]} is no linked program of macOS")
    libraries, oldest, at = [], "?", 32
    for _ in range(count):
        command, size = struct.unpack_from("<2I", data, at)
        if command == LOAD_LIBRARY:
            begin = at + struct.unpack_from("<I", data, at + 8)[0]
            libraries.append(data[begin:at + size].split(b"\0")[0].decode())
        elif command == BUILD_VERSION:
            oldest = version(struct.unpack_from("<I", data, at + 12)[0])
        elif command == OLDEST_VERSION:
            oldest = version(struct.unpack_from("<I", data, at + 8)[0])
        at += size
    print(f"macOS {oldest} or later, {PROCESSORS[processor]}, loads {' '.join(libraries)}")
    strange = [name for name in libraries if not name.startswith(("/usr/lib/", "/System/Library/Frameworks/"))]
    if strange:
        sys.exit(f"a library of no macOS: {strange}")


main()

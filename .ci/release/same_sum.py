"""Gives a file of line tables the checksum of its program: same_sum.py PROGRAM TABLES.

A debugger takes a file of line tables only with the checksum (CRC-32) that stands in the program. That of the tables
depends on the folder in which the linker compiled its own C files, so a program with it would have other bytes in each
folder. In: the program before the link is added. Out: TABLES with four bytes more, which no reader of the format looks at,
by which its checksum is that of the program.
"""

import pathlib
import sys
import zlib


def step(value):
    """Returns the register of CRC-32 after one byte."""
    for _ in range(8):
        value = (value >> 1) ^ (0xEDB88320 if value & 1 else 0)
    return value


def main():
    program, tables = map(pathlib.Path, sys.argv[1:])
    after = [step(byte) for byte in range(256)]
    by_top = {value >> 24: byte for byte, value in enumerate(after)}
    wanted = zlib.crc32(program.read_bytes())
    register = wanted ^ 0xFFFFFFFF
    # Back over four bytes of nought: what the register has to be before them.
    for _ in range(4):
        byte = by_top[register >> 24]
        register = ((register ^ after[byte]) << 8 & 0xFFFFFFFF) | byte
    data = tables.read_bytes()
    data += (register ^ zlib.crc32(data) ^ 0xFFFFFFFF).to_bytes(4, "little")
    assert zlib.crc32(data) == wanted
    tables.write_bytes(data)


main()

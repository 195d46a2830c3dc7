"""The framebuffer device for the demos beside this file: 32 bits, B G R X in memory."""

import fcntl
import mmap
import os
import struct
import sys


class Framebuffer:
    """The device's first page, and its vertical blanks."""

    def __init__(self, bits=32):
        self.fd = os.open("/dev/fb0", os.O_RDWR)
        var = bytearray(fcntl.ioctl(self.fd, 0x4600, bytes(160)))  # FBIOGET_VSCREENINFO
        struct.pack_into("I", var, 24, bits)
        var = fcntl.ioctl(self.fd, 0x4601, bytes(var))  # FBIOPUT_VSCREENINFO
        self.width, self.height = struct.unpack_from("2I", var)
        self.line = struct.unpack_from("I", fcntl.ioctl(self.fd, 0x4602, bytes(80)), 48)[0]  # FBIOGET_FSCREENINFO
        self.bytes = mmap.mmap(self.fd, self.line * self.height)

    def row(self, y, pixels):
        """Stores a row's bytes."""
        self.bytes[y * self.line : y * self.line + len(pixels)] = pixels

    def wait(self):
        """Waits for the next vertical blank."""
        fcntl.ioctl(self.fd, 0x40044620, bytes(4))  # FBIO_WAITFORVSYNC


def frames():
    """Counts frames, as many as the command line asks for."""
    return range(int(sys.argv[1]) if len(sys.argv) > 1 else 1 << 40)

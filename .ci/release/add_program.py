"""Adds the program to a wheel, so that `pip install fbptr` puts `fbptr` on the path: add_program.py WHEEL PROGRAM.

In: a wheel of the extension module, the program for the same system. Out: the wheel with the program among its scripts
(PEP 427, `NAME.data/scripts`) and a new RECORD, its members sorted and of one date: the same bytes for the same contents.
"""

import base64
import hashlib
import os
import pathlib
import sys
import time
import zipfile


def record_line(name, data):
    digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
    return f"{name},sha256={digest},{len(data)}\n"


def main():
    wheel, program = map(pathlib.Path, sys.argv[1:])
    name, version = wheel.name.split("-")[:2]
    with zipfile.ZipFile(wheel) as archive:
        files = {info.filename: (archive.read(info), info.external_attr) for info in archive.infolist() if not info.is_dir()}
    files[f"{name}-{version}.data/scripts/{program.name}"] = (program.read_bytes(), 0o100755 << 16)
    record = f"{name}-{version}.dist-info/RECORD"
    del files[record]
    lines = [record_line(path, data) for path, (data, _) in sorted(files.items())]
    files[record] = ("".join([*lines, f"{record},,\n"]).encode(), 0o100644 << 16)
    # Zip knows no date before 1980.
    date = time.gmtime(max(int(os.environ.get("SOURCE_DATE_EPOCH", "0")), 315532800))[:6]
    # RECORD is the last member, as the format asks for.
    order = sorted(files, key=lambda path: (path == record, path))
    made = wheel.with_suffix(".new")
    with zipfile.ZipFile(made, "w") as archive:
        for path in order:
            info = zipfile.ZipInfo(path, date)
            info.external_attr = files[path][1]
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, files[path][0], compresslevel=9)
    made.replace(wheel)


main()

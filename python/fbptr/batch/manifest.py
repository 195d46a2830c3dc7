"""The manifest of a batch, in the form of `fbptr render --shard`: a line of JSON a frame.

Promise: one process writes a manifest, by the system's file lock. A frame counts as drawn if a
manifest of the folder has its line, of the same scene, options and version, and its file has
the CRC of the line.
"""

import json
import os
import re
import socket
import time
import zlib

from .. import _native

__all__ = ["Manifest", "host", "record_of"]

_NAME = re.compile(r"frames(-\d+-(of|to)-\d+)?\.jsonl")
OWN = "frames-0-of-1.jsonl"


def host():
    """Returns the machine's name."""
    return socket.gethostname()


def record_of(frame, crc, file, seconds, when, host_name):
    """Returns what differs from line to line."""
    stamp = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(when))
    record = {"frame": frame, "crc": "%08x" % crc, "files": [file]}
    record.update(seconds=round(seconds, 6), time=stamp, host=host_name)
    return record


def _lock(file):
    """Locks a file; raises BlockingIOError if another process has it. Elsewhere than on Unix, and
    on a file system without locks, it does nothing."""
    try:
        import fcntl
    except ImportError:
        return
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise BlockingIOError("%s: another process draws these frames" % file.name) from None
    except OSError:
        pass


class Manifest:
    """The manifest that this process writes, and those that it reads."""

    def __init__(self, folder, template, pattern):
        self.folder, self.template, self.pattern = folder, template, pattern
        self.file = open(os.path.join(folder, OWN), "a+b", buffering=0)
        try:
            _lock(self.file)
            # What killed processes left; files that a living one writes stay.
            _native.remove_leftovers(folder)
            self._read()
        except BaseException:
            self.file.close()
            raise

    def _read(self):
        self.file.seek(0)
        data = self.file.read()
        # A torn last line is removed.
        self.file.truncate(data.rfind(b"\n") + 1)
        self.lines = {}
        for entry in sorted(os.listdir(self.folder)):
            if not _NAME.fullmatch(entry):
                continue
            with open(os.path.join(self.folder, entry), "rb") as file:
                for line in file.read().splitlines():
                    self._take(line)

    def _take(self, line):
        try:
            record = json.loads(line)
            frame, name = int(record["frame"]), record["files"][0]["name"]
            (record["files"][0]["bytes"], record["version"], int(record["crc"], 16))
        except (ValueError, KeyError, TypeError, IndexError):
            return
        if name != os.path.basename(self.pattern % frame):
            where = "%s: expected no other batch, found the frame %s: one batch a folder"
            raise ValueError(where % (self.folder, name))
        if all(record.get(key) == self.template[key] for key in ("version", "recipe")):
            self.lines.setdefault(frame, []).append(record)

    def there(self, frames):
        """Returns the CRCs of the pixels of those frames that are drawn, by number."""
        found = {}
        for frame in frames:
            for record in self.lines.get(frame, ()):
                file = record["files"][0]
                try:
                    with open(self.pattern % frame, "rb") as data:
                        data = data.read()
                except OSError:
                    continue
                if len(data) == file["bytes"] and "%08x" % zlib.crc32(data) == file["crc"]:
                    found[frame] = int(record["crc"], 16)
                    break
        return found

    def append(self, record):
        """Appends a line; if that fails the manifest stays as it was."""
        record = {**record, **self.template}
        line = (json.dumps(record, separators=(",", ":")) + "\n").encode()
        length = os.fstat(self.file.fileno()).st_size
        try:
            done = 0
            while done < len(line):
                done += self.file.write(line[done:])
        except OSError as error:
            self.file.truncate(length)
            error.filename = error.filename or self.file.name
            raise

    def forget(self, frames):
        """Removes the lines of frames that are to be drawn again.

        Lines move towards the front, by one write in place: whatever ends the process in the middle,
        no line of another frame is lost.
        """
        frames = set(frames)
        self.file.seek(0)
        kept = []
        for line in self.file.read().splitlines(True):
            try:
                if json.loads(line)["frame"] in frames:
                    continue
            except (ValueError, KeyError, TypeError):
                pass
            kept.append(line)
        kept = b"".join(kept)
        with open(self.file.name, "r+b", buffering=0) as file:
            done = 0
            while done < len(kept):
                done += file.write(kept[done:])
            file.truncate(len(kept))

    def close(self):
        """Releases the manifest."""
        self.file.close()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are whole at every moment: the old one, or the new one, never a part of one.

What is written goes to another name in the same folder, is flushed to the disk, and then takes its final name, which
the file systems of all three systems do in one step.
"""

from __future__ import annotations

import errno
import glob
import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# What a process that was killed left behind is taken away by the next that writes the same file, once it is so old, in
# seconds, that nobody can still be writing it.
ABANDONED = 3600.0


@contextmanager
def whole_files(*paths: Path) -> Iterator[list[Path]]:
    """Names to write to instead of ``paths``, with the same suffix; at the end of the block they become ``paths``, in
    that order, and where it raises they go.

    Raises OSError where the folder cannot be written or a final name is taken by a folder.
    """
    unfinished = [path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}") for path in paths]
    try:
        yield unfinished
        for part in unfinished:
            with part.open("r+b") as file:
                os.fsync(file.fileno())
        # Before the first takes its name: of maps that belong together none is new beside an old one.
        for path in paths:
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
        for part, path in zip(unfinished, paths, strict=True):
            os.replace(part, path)
    finally:
        for part in unfinished:
            part.unlink(missing_ok=True)
        for path in paths:
            _remove_abandoned(path)


def _remove_abandoned(path: Path) -> None:
    for part in path.parent.glob(f".{glob.escape(path.stem)}.*.part{path.suffix}"):
        try:
            if time.time() - part.stat().st_mtime > ABANDONED:
                part.unlink()
        except OSError:
            pass  # another process was faster, or it is not ours to remove

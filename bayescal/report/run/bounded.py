"""A file of a run, read no further than a stated size."""

from __future__ import annotations

import stat
from pathlib import Path

from bayescal.errors import InputError
from bayescal.points.tables.text import reason

# Its manifest, and the camera beside the draws, which answers without them.
MANIFEST, CAMERA = "run.json", "camera.npz"
# Bytes: a million draws of twenty parameters.
LARGEST = 1_000_000_000


def bounded(path: Path, again: str) -> bytes:
    """Read a file of a run; refuse a device, a pipe and what is too large to be of a run."""
    try:
        if not stat.S_ISREG(path.stat().st_mode):
            raise InputError(f"{path}: is no regular file; {again}")
        with path.open("rb") as stream:
            raw = stream.read(LARGEST + 1)
    except (OSError, MemoryError) as error:
        raise InputError(f"{path}: {reason(error)}; {again}") from None
    if len(raw) > LARGEST:
        raise InputError(
            f"{path}: holds more than {LARGEST / 1e9:g} GB, the most that is read; {again}"
        )
    return raw

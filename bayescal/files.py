"""Files written whole or not at all."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from bayescal.errors import OutputError


def write_whole(path: Path, content: bytes, *, force: bool = False) -> None:
    """Write a file whole or not at all, beside its place and then moved there.

    Raises
    ------
    OutputError
        Where the file exists (without `force`) or can't be written.
    """
    check_free(path, force=force)
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name[:80]}.")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(content)
            Path(name).chmod(0o666 & ~_umask())
            Path(name).replace(path)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise OutputError(f"{path}: {(error.strerror or str(error)).lower()}") from None


def check_free(path: Path, *, force: bool = False) -> None:
    """Refuse, before any work is done, a place that can't be written to.

    Raises
    ------
    OutputError
        Where the path exists (without `force`), is a directory, or its folder
        does not exist or can't be written.
    """
    if path.is_dir():
        raise OutputError(f"{path}: is a directory; name a file")
    if path.exists() and not force:
        raise OutputError(f"{path}: exists; choose another name or add --force")
    folder = path.parent
    if not folder.is_dir():
        raise OutputError(f"{path}: there is no folder {folder}; make it first")
    if not os.access(folder, os.W_OK):
        raise OutputError(f"{path}: the folder {folder} can't be written to")


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask

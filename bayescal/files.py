"""Files and folders written whole or not at all."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from fnmatch import fnmatch
from pathlib import Path

from bayescal.errors import OutputError

# What marks a folder as a run.
RESULT = "result.json"


def write_whole(path: Path, content: bytes, *, force: bool = False) -> None:
    """Write a file whole or not at all, beside its place and then moved there.

    A symbolic link is followed: what it points to is written.

    Raises
    ------
    OutputError
        Where the file exists (without `force`) or can't be written.
    """
    check_free(path, force=force)
    place = path.resolve()
    try:
        handle, name = tempfile.mkstemp(dir=place.parent, prefix=".bayescal-")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(content)
            Path(name).chmod(0o666 & ~_umask())
            Path(name).replace(place)
        except BaseException:
            Path(name).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise OutputError(f"{path}: {_reason(error)}") from None


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it, unless it is there.

    Raises
    ------
    OutputError
        Where it can't be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OutputError(f"{folder}: {_reason(error)}") from None


def check_free(path: Path, *, force: bool = False) -> None:
    """Refuse, before any work is done, a place that can't be written to.

    Raises
    ------
    OutputError
        Where the path exists (without `force`), is no regular file, or its folder
        does not exist or can't be written.
    """
    try:
        mode = path.stat().st_mode
    except FileNotFoundError:
        pass
    except OSError as error:
        raise OutputError(f"{path}: {_reason(error)}; choose another name") from None
    else:
        if stat.S_ISDIR(mode):
            raise OutputError(f"{path}: is a directory; name a file")
        if not stat.S_ISREG(mode):  # a device would be replaced, not written to
            raise OutputError(f"{path}: is not a regular file; choose another name")
        if not force:
            raise OutputError(f"{path}: exists; choose another name or add --force")
    folder = (path.resolve() if path.is_symlink() else path).parent
    if not folder.is_dir():
        raise OutputError(f"{path}: there is no folder {folder}; make it first")
    if not os.access(folder, os.W_OK):
        raise OutputError(f"{path}: the folder {folder} can't be written to")


@dataclass(frozen=True)
class FolderKind:
    """A kind of folder that the program writes.

    Attributes
    ----------
    name : str
        What the folder is, in a word, for messages.
    marker : str
        The file by which an earlier folder of the kind is known.
    contents : tuple of str
        Patterns of the names in it. A folder that holds anything else is never
        replaced: it may be somebody's work.
    """

    name: str
    marker: str
    contents: tuple[str, ...]


def check_folder(folder: Path, kind: FolderKind, *, force: bool = False) -> None:
    """Refuse, before any work is done, a place where a folder can't be put.

    Parameters
    ----------
    force : bool
        Replace an earlier folder of the kind.

    Raises
    ------
    OutputError
        Where something else stands there, or an earlier one without `force`, or
        the folder around it does not exist.
    """
    try:
        taken = folder.exists() or folder.is_symlink()
        earlier = (folder / kind.marker).is_file()
        names = sorted(entry.name for entry in folder.iterdir()) if earlier else []
    except OSError as error:
        raise OutputError(f"{folder}: {_reason(error)}; choose another name") from None
    if taken and not earlier:
        raise OutputError(f"{folder}: exists and is not a {kind.name}; choose another name")
    if taken and not force:
        raise OutputError(
            f"{folder}: holds an earlier {kind.name}; choose another name or add --force"
        )
    foreign = [n for n in names if not any(fnmatch(n, p) for p in (kind.marker, *kind.contents))]
    if foreign:
        raise OutputError(
            f"{folder}: holds {foreign[0]}, which is no part of a {kind.name}; move it away or "
            "choose another name"
        )
    if folder.is_symlink():
        raise OutputError(f"{folder}: is a link; name the folder it leads to")
    around = folder.absolute().parent
    if not around.is_dir():
        raise OutputError(f"{folder}: there is no folder {folder.parent}; make it first")
    if not os.access(around, os.W_OK):
        raise OutputError(f"{folder}: the folder {folder.parent} can't be written to")


def write_folder(
    folder: Path, kind: FolderKind, fill: Callable[[Path], None], *, force: bool = False
) -> None:
    """Write a folder whole or not at all: made beside its place and then moved there.

    Parameters
    ----------
    kind, force
        As in `check_folder`.
    fill : callable
        Given the empty folder, writes what belongs in it.

    Raises
    ------
    OutputError
        Where it can't be written; nothing is left behind.
    """
    check_folder(folder, kind, force=force)
    try:
        with tempfile.TemporaryDirectory(
            dir=folder.absolute().parent, prefix=".bayescal-", ignore_cleanup_errors=True
        ) as temporary:
            made = Path(temporary) / "made"
            made.mkdir()
            fill(made)
            check_folder(folder, kind, force=force)  # another process may have been quicker
            earlier = Path(temporary) / "earlier"
            if folder.exists():
                folder.rename(earlier)
            try:
                made.rename(folder)
            except OSError:
                if earlier.exists():
                    earlier.rename(folder)
                raise
    except OSError as error:
        raise OutputError(f"{folder}: {_reason(error)}") from None


def _reason(error: OSError) -> str:
    return (error.strerror or str(error)).lower()


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask

"""Cameras that were judged, kept one by one, so that what was interrupted can go on."""

from __future__ import annotations

import contextlib
import json
import os
from collections.abc import Iterator
from pathlib import Path

from bayescal.errors import InputError, OutputError
from bayescal.fleets.record import Record

NAME = "judged.jsonl"


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Keep other runs from a file, as far as the system can; a process that ends lets go of it.

    Raises
    ------
    InputError
        Where another run has it.
    """
    try:
        import fcntl
    except ImportError:  # Windows
        yield
        return
    with path.open("rb") as stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"{path.parent}: another run is at work there; wait for it, or take another folder"
            ) from None
        except OSError:  # a file system without locks
            pass
        yield


class Journal:
    """Records by their keys in a file of JSON lines; only ever added to.

    A line that a crash cut short is dropped when the journal is opened again, and its camera
    counts as missing.
    """

    def __init__(self, folder: Path | None) -> None:
        """Open the journal of a folder; without one, records are kept in memory alone."""
        self._path = None if folder is None else folder / NAME
        self._found: dict[str, Record] = {}
        if self._path is not None and self._path.exists():
            self._read(self._path)

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __contains__(self, key: str) -> bool:
        return key in self._found

    def get(self, key: str) -> Record | None:
        """Record of a camera; None where it is missing."""
        return self._found.get(key)

    def add(self, key: str, record: Record) -> None:
        """Keep a record, on disk before anything else is done.

        Raises
        ------
        OutputError
            Where it can't be written.
        """
        self._found[key] = record
        if self._path is None:
            return
        line = json.dumps({"key": key, **record.to_json()}, allow_nan=False) + "\n"
        try:
            with self._path.open("ab") as stream:
                stream.write(line.encode())
                stream.flush()
                os.fsync(stream.fileno())
        except OSError as error:
            raise OutputError(f"{self._path}: {(error.strerror or str(error)).lower()}") from None

    def _read(self, path: Path) -> None:
        raw = path.read_bytes()
        whole = raw.rfind(b"\n") + 1
        for number, line in enumerate(raw[:whole].splitlines(), 1):
            try:
                kept = json.loads(line)
                key = kept.pop("key")
                self._found[key] = Record.from_json(kept)
            except (AttributeError, KeyError, TypeError, ValueError):
                raise InputError(
                    f"{path}:{number}: is no record of a camera; remove the line, or the file to "
                    "judge all cameras again"
                ) from None
        if whole < len(raw):
            with path.open("r+b") as stream:
                stream.truncate(whole)

"""Ways to spoil a run: its files edited or cut, with hashes forged or not."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import bayescal as bc


def edit(path: Path, *changes: tuple[str, Any]) -> None:
    """Change entries, given by dotted keys, of a JSON file."""
    found = json.loads(path.read_text(encoding="utf-8"))
    for key, value in changes:
        *way, last = key.split(".")
        node = found
        for step in way:
            node = node[int(step) if step.isdigit() else step]
        node[int(last) if last.isdigit() else last] = value
    path.write_text(json.dumps(found), encoding="utf-8")


def forge(folder: Path, name: str) -> None:
    """Give a changed file the hash it has now."""
    manifest = json.loads((folder / "run.json").read_text(encoding="utf-8"))
    manifest["files"][name] = hashlib.sha256((folder / name).read_bytes()).hexdigest()
    (folder / "run.json").write_text(json.dumps(manifest), encoding="utf-8")


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-2000])


def forged(name: str, change: Callable[[Path], None]) -> Callable[[Path], None]:
    def spoil(folder: Path) -> None:
        change(folder / name)
        forge(folder, name)

    return spoil


def result(*changes: tuple[str, Any]) -> Callable[[Path], None]:
    return forged("result.json", lambda path: edit(path, *changes))


def refused_in_a_line(folder: Path, complaint: str) -> None:
    """Check that a run is refused in one line, which names it."""
    with pytest.raises(bc.InputError, match=complaint) as caught:
        bc.open_run(folder)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(folder))

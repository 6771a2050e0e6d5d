"""The rooms of the house: which may import from which.

Truth: the order below. Every import, those for type checking and inside functions included, goes
to the same room or to one that stands before it.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import bayescal

ROOT = Path(bayescal.__file__).parent
ROOMS = (
    *("version", "errors", "arrays", "rounding", "markup", "files"),
    *("points", "detection", "polynomials", "cameras", "prior", "noise"),
    *("linear", "inference", "density", "calibration", "comparison", "simulation"),
    *("report", "reproduction", "api", "__init__", "commands", "cli", "__main__"),
)
FILES = sorted(ROOT.rglob("*.py"))


def room(module: str) -> str:
    """First part of a module's name below the package."""
    return module.removeprefix("bayescal").lstrip(".").split(".")[0] or "__init__"


def imported(text: str) -> Iterator[str]:
    """Modules of the package that a file imports, wherever in it."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module == "bayescal":
            yield from (f"bayescal.{alias.name}" for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


def climbing(own: str, text: str) -> list[str]:
    """Imports of rooms that stand after `own`."""
    names = [name for name in imported(text) if name.split(".")[0] == "bayescal"]
    rooms = [room(name) if room(name) in ROOMS else "__init__" for name in names]
    return [n for n, r in zip(names, rooms, strict=True) if ROOMS.index(r) > ROOMS.index(own)]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_import_goes_back_up(path: Path) -> None:
    own = room("bayescal." + ".".join(path.relative_to(ROOT).with_suffix("").parts))
    assert climbing(own, path.read_text(encoding="utf-8")) == []


def test_a_climbing_import_is_found() -> None:
    """Negative control: in a function, for types, and of the package itself."""
    assert climbing("points", "def f():\n    from bayescal.report import grid\n") != []
    assert climbing("linear", "if X:\n    from bayescal.comparison.results import A\n") != []
    assert climbing("report", "from bayescal import __version__\n") != []
    assert climbing("report", "from bayescal.comparison.results import A\n") == []

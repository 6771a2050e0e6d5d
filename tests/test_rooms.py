"""The rooms of the house: which may import from which, and that nothing imports in a circle.

Truth: the order below. Every import, those for type checking and inside functions included, goes
to the same room or to one that stands before it; and from no module do imports lead back to it,
nor from any room within a room.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import bayescal

ROOT = Path(bayescal.__file__).parent
ROOMS = (
    *("version", "errors", "arrays", "rounding", "markup", "files", "encoding"),
    *("points", "detection", "polynomials", "cameras", "prior", "noise"),
    *("linear", "inference", "density", "calibration", "comparison", "prediction", "simulation"),
    *("fleets", "report", "reproduction", "api", "__init__", "commands", "cli", "__main__"),
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
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


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


def circles(imports: dict[str, set[str]]) -> list[list[str]]:
    """Sets of modules that import each other, each sorted (Tarjan 1972, SIAM J. Comput. 1, 146)."""
    number: dict[str, int] = {}
    lowest: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(name: str) -> None:
        number[name] = lowest[name] = len(number)
        stack.append(name)
        for other in sorted(imports.get(name, ())):
            if other not in number:
                visit(other)
                lowest[name] = min(lowest[name], lowest[other])
            elif other in stack:
                lowest[name] = min(lowest[name], number[other])
        if lowest[name] == number[name]:
            at = stack.index(name)
            circle, stack[at:] = sorted(stack[at:]), []
            if len(circle) > 1 or name in imports.get(name, ()):
                found.append(circle)

    for name in sorted(imports):
        if name not in number:
            visit(name)
    return sorted(found)


def module(path: Path) -> str:
    """Name of the module of a file."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(("bayescal", *(part for part in parts if part != "__init__")))


@pytest.fixture(scope="module")
def imports() -> dict[str, set[str]]:
    """Modules of the package that each of them imports."""
    names = {module(path) for path in FILES}
    found = {module(path): names.intersection(imported(path.read_text("utf-8"))) for path in FILES}
    assert sum(map(len, found.values())) > len(names)
    return found


def test_no_modules_import_in_a_circle(imports: dict[str, set[str]]) -> None:
    assert circles(imports) == []


def parts(room: str, imports: dict[str, set[str]]) -> dict[str, set[str]]:
    """Which parts of a room, its modules and the rooms in it, import which others of it."""
    found: dict[str, set[str]] = {}
    for name, others in imports.items():
        inside = [n.removeprefix(f"{room}.") for n in (name, *others) if n.startswith(f"{room}.")]
        if name.startswith(f"{room}."):
            own, *rest = (n.split(".")[0] for n in inside)
            found.setdefault(own, set()).update(set(rest) - {own})
    return found


@pytest.mark.parametrize("room", sorted({module(path.parent / "__init__.py") for path in FILES}))
def test_no_rooms_within_a_room_import_in_a_circle(room, imports):
    assert circles(parts(room, imports)) == []


def test_rooms_that_import_in_a_circle_are_found() -> None:
    """Negative control: no two modules import each other, but their rooms do."""
    imports = {
        "bayescal.a.low.one": set(),
        "bayescal.a.low.two": {"bayescal.a.high.one"},
        "bayescal.a.high.one": set(),
        "bayescal.a.high.two": {"bayescal.a.low.one"},
    }
    assert circles(imports) == []
    assert circles(parts("bayescal.a", imports)) == [["high", "low"]]


def test_a_circle_is_found() -> None:
    """Negative control: a circle of two, one of three, a module that imports itself."""
    texts = {
        "bayescal.a": "if TYPE_CHECKING:\n    from bayescal.b import B\n",
        "bayescal.b": "def f():\n    import bayescal.a\n",
        "bayescal.c": "from bayescal.d import D\nfrom bayescal.a import A\n",
        "bayescal.d": "from bayescal import e\n",
        "bayescal.e": "from bayescal.c import C\n",
        "bayescal.f": "from bayescal.f import F\n",
        "bayescal.g": "from bayescal.a import A\n",
    }
    found = circles({name: set(imported(text)) for name, text in texts.items()})
    assert found == [
        ["bayescal.a", "bayescal.b"],
        ["bayescal.c", "bayescal.d", "bayescal.e"],
        ["bayescal.f"],
    ]

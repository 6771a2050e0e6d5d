"""Points in two files: world coordinates in one, pixels in the other.

So are those of the direct linear transform (DLTdv, Argus) kept, of OpenPTV's calibration (.fix
and .crd), and control points with their marks of Pix4D. Both may be without a header.
"""

from __future__ import annotations

from collections.abc import Mapping

from bayescal.errors import InputError
from bayescal.points.tables.columns import SIGMAS, Columns
from bayescal.points.tables.content import Content
from bayescal.points.tables.sniffing import parse_table, to_float
from bayescal.points.tables.table import Row, Rows, number, rows_of
from bayescal.points.tables.text import quoted
from bayescal.rounding import counted

WORLD = Columns(("x", "y", "z"), ("x", "y", "z", "label", "group", *SIGMAS[2:]))
PIXELS = Columns(
    ("r", "c"), ("r", "c", "label", "view", *SIGMAS[:2]), also={"r": ("x",), "c": ("y",)}
)
# Columns of files without a header, by how many they have; "" is left aside.
_WORLD = {3: "x y z", 4: "label x y z", 6: "label x y z - -"}
_PIXELS = {2: "r c", 3: "label r c", 4: "view label r c", 5: "view label r c -"}


def read_pair(
    world: Content,
    pixels: Content,
    stated: Mapping[str, str] | None = None,
    view: str | None = None,
) -> Rows:
    """Read both files and put together what belongs together: by label, else by order.

    Raises
    ------
    InputError
        Where a file can't be used, or they don't belong together.
    """
    stated = stated or {}
    points = _rows(world, WORLD, _WORLD, stated)
    seen = _rows(pixels, PIXELS, _PIXELS, stated)
    notes = [*points.notes, *seen.notes]
    for name, rows, axes in ((world.name, points.rows, "xyz"), (pixels.name, seen.rows, "rc")):
        for row in rows:
            for axis in axes:
                if not _missing(row.fields[axis]):
                    number(name, row, axis)
    kept = [row for row in seen.rows if view is None or row.fields.get("view") == view]
    if view is not None and not kept:
        raise InputError(f"{pixels.name}: holds no view {quoted(view)}")
    views = {row.fields.get("view") for row in kept}
    if len(views) > 1:
        names = quoted(", ".join(sorted(map(str, views))))
        raise InputError(f"{pixels.name}: holds {len(views)} views, {names}; choose with --view")
    pairs, left = _joined(world.name, points.rows, pixels.name, kept)
    whole = [
        (p, s)
        for p, s in pairs
        if not any(map(_missing, [*(p.fields[a] for a in "xyz"), *(s.fields[a] for a in "rc")]))
    ]
    left += len(pairs) - len(whole)
    if left:
        notes.append(f"{counted(left, 'point')} without a partner or without numbers left out")
    return Rows(tuple(Row(s.line, {**s.fields, **p.fields}) for p, s in whole), tuple(notes))


def _missing(text: str) -> bool:
    return text == "" or text.lower() == "nan"


def _rows(
    content: Content, columns: Columns, unnamed: Mapping[int, str], stated: Mapping[str, str]
) -> Rows:
    """Read one of the files; one without a header by the number of its columns."""
    table = parse_table(content.name, content.text(), ",".join(columns.required))
    own = {quantity: name for quantity, name in stated.items() if quantity in columns.known}
    axes = set(columns.required) & set(own)
    if table.named or axes:
        return rows_of(table, columns, own)
    names = unnamed.get(len(table.header))
    if names is None:
        example = ",".join(f"{quantity}={i}" for i, quantity in enumerate(columns.required, 1))
        raise InputError(
            f"{table.where(table.line)}: has {len(table.header)} columns without names; say which "
            f"is which: --columns {example}"
        )
    numbered = {n: str(i) for i, n in enumerate(names.split(), 1) if n != "-"}
    return rows_of(table, columns, {**numbered, **own})


def _joined(
    world: str, points: tuple[Row, ...], pixels: str, seen: list[Row]
) -> tuple[list[tuple[Row, Row]], int]:
    """Pairs of rows, and how many found no partner."""
    if not points or not seen:
        raise InputError(f"{world if not points else pixels}: there are no points; add some")
    if "label" in points[0].fields and "label" in seen[0].fields:
        known = _by_label(world, points)
        marks = _by_label(pixels, seen)
        pairs = [(known[label], mark) for label, mark in marks.items() if label in known]
        if not pairs:
            raise InputError(f"{pixels}: has no label in common with {world}; check the columns")
        return pairs, len(known.keys() ^ marks.keys())
    if len(points) != len(seen):
        raise InputError(
            f"{pixels}: has {counted(len(seen), 'point')} where {world} has {len(points)}; add "
            "labels to both, or rows to one"
        )
    return list(zip(points, seen, strict=True)), 0


def _by_label(name: str, rows: tuple[Row, ...] | list[Row]) -> dict[str, Row]:
    found: dict[str, Row] = {}
    for row in rows:
        label = _label(row.fields["label"])
        if label in found:
            raise InputError(f"{name}:{row.line}: label {quoted(label)} stands twice; keep one")
        found[label] = row
    return found


def _label(text: str) -> str:
    """Bring a label to one form: 1 and 1.0 are the same."""
    value = to_float(text)
    return text if value is None or not value.is_integer() else str(int(value))

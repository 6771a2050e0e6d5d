"""Which column of a table is which quantity: the names that people give them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from bayescal.errors import InputError
from bayescal.points.tables.sniffing import SEPARATORS, TextTable, to_float
from bayescal.points.tables.text import quoted

# r is horizontal and c vertical here, so that a file's column number is r and its row number c.
ALIASES: dict[str, tuple[str, ...]] = {
    "x": ("xworld", "worldx", "xw", "e", "east", "easting", "xeasting", "objectx"),
    "y": ("yworld", "worldy", "yw", "n", "north", "northing", "ynorthing", "objecty"),
    "z": ("zworld", "worldz", "zw", "h", "height", "elevation", "altitude", "zaltitude", "objectz"),
    "r": ("u", "px", "col", "column", "xpx", "upx", "pixelx", "xpixel", "imagex", "ximage", "ximg"),
    "c": ("v", "py", "row", "line", "ypx", "vpx", "pixely", "ypixel", "imagey", "yimage", "yimg"),
    "label": ("name", "id", "point", "pointid", "pointname", "pid", "pt", "marker", "no", "nr"),
    "group": ("plane", "placement"),
    "view": ("image", "imagename", "photo", "photograph", "camera", "filename"),
}
REQUIRED = ("x", "y", "z", "r", "c")
PIXEL_SIGMAS = ("sigma_r", "sigma_c")
WORLD_SIGMAS = ("sigma_x", "sigma_y", "sigma_z")
SIGMAS = PIXEL_SIGMAS + WORLD_SIGMAS
TEXTS = ("label", "group", "view")
KNOWN = (*REQUIRED, *TEXTS, *SIGMAS)


@dataclass(frozen=True)
class Columns:
    """Columns of a kind of table: those it must have, all it may have, and more names of some."""

    required: tuple[str, ...]
    known: tuple[str, ...]
    also: Mapping[str, tuple[str, ...]] = field(default_factory=dict)


def match_columns(
    table: TextTable, columns: Columns, stated: Mapping[str, str] | None = None
) -> dict[str, int]:
    """Find the columns by our names first, then by the names in `ALIASES`, in any case.

    Parameters
    ----------
    stated : mapping of str to str, optional
        A column's name or number (from 1) for some quantities, as the user says.

    Raises
    ------
    InputError
        Where one that is required is missing or ambiguous, or a stated one is not there.
    """
    index = _stated(table, stated or _photogrammetric(table, columns), columns)
    if table.named:
        for ours in (True, False):
            for quantity in columns.known:
                if quantity not in index:
                    names = (quantity.replace("_", ""),) if ours else _aliases(quantity, columns)
                    found = _named(table, quantity, names, set(index.values()))
                    if found is not None:
                        index[quantity] = found
        free = "label" in columns.known and "label" not in index and 0 not in index.values()
        if free and any(field and to_float(field) is None for field in table.column(0)):
            index["label"] = 0
    missing = [quantity for quantity in columns.required if quantity not in index]
    if missing:
        raise InputError(_complaint(table, columns.required, missing))
    return {quantity: index[quantity] for quantity in columns.known if quantity in index}


def parse_stated(text: str) -> dict[str, str]:
    """Parse what the user says of columns, such as ``x=E,y=N,z=h,r=u,c=v``.

    Raises
    ------
    InputError
    """
    found: dict[str, str] = {}
    for part in text.split(","):
        quantity, equals, name = (word.strip() for word in part.partition("="))
        if not equals or not name:
            raise InputError(f"columns: {quoted(part)} is no pair such as x=E; write x=E,y=N,...")
        if quantity not in KNOWN:
            raise InputError(f"columns: {quoted(quantity)} is none of {', '.join(KNOWN)}")
        if quantity in found:
            raise InputError(f"columns: {quantity} is stated twice; keep one")
        found[quantity] = name
    return found


def _stated(table: TextTable, stated: Mapping[str, str], columns: Columns) -> dict[str, int]:
    """Columns of what the user states, by their exact name, their name in any case, or number."""
    index: dict[str, int] = {}
    for quantity, name in stated.items():
        if quantity not in columns.known:
            raise InputError(f"columns: {quoted(quantity)} is none of {', '.join(columns.known)}")
        exact = [i for i, own in enumerate(table.header) if own == name]
        loose = [i for i, own in enumerate(table.header) if own.lower() == name.lower()]
        number = [int(name) - 1] if name.isascii() and name.isdigit() and len(name) < 7 else []
        found = exact or loose or [i for i in number if 0 <= i < len(table.header)]
        if not found:
            raise InputError(
                f"{table.where(table.line)}: no column {quoted(name)}, stated for {quantity}; "
                f"there are {_listed(table.header)}"
            )
        if len(found) > 1:
            raise InputError(f"{table.where(table.line)}: column {quoted(name)} stands twice")
        index[quantity] = found[0]
    return index


def _photogrammetric(table: TextTable, columns: Columns) -> dict[str, str]:
    """Columns of a header that calls the world X, Y, Z and the image x, y."""
    names = {"x": "X", "y": "Y", "z": "Z", "r": "x", "c": "y"}
    if set(names) <= set(columns.known) and set(names.values()) <= set(table.header):
        return names
    return {}


def _named(table: TextTable, quantity: str, names: tuple[str, ...], taken: set[int]) -> int | None:
    """Find the column that bears one of the names of a quantity; None where none does."""
    found = [i for i, own in enumerate(table.header) if _plain(own) in names and i not in taken]
    if len(found) < 2 or quantity not in REQUIRED:
        return found[0] if found else None
    where, header = table.where(table.line), [table.header[i] for i in found]
    if header[0].lower() == header[1].lower():
        raise InputError(
            f"{where}: column {quoted(header[0])} stands twice; keep one, or say which by its "
            f"number: --columns {quantity}={found[0] + 1}"
        )
    raise InputError(
        f"{where}: columns {quoted(header[0])} and {quoted(header[1])} could both be {quantity}; "
        f"say which: --columns {quantity}={header[0]}"
    )


def _aliases(quantity: str, columns: Columns) -> tuple[str, ...]:
    """Plain names of a quantity other than our own."""
    if quantity not in SIGMAS:
        return ALIASES.get(quantity, ()) + tuple(columns.also.get(quantity, ()))
    axis = quantity[-1]
    names = (axis, *ALIASES[axis])
    return tuple(f"{word}{name}" for word in ("sigma", "sd", "std") for name in names)


def _plain(name: str) -> str:
    """Bare a header's name of case, units in brackets and punctuation."""
    return re.sub(r"[\W_]+", "", re.sub(r"[\[(].*[\])]\s*$", "", name.lower()))


def _complaint(table: TextTable, required: tuple[str, ...], missing: list[str]) -> str:
    names, where = ",".join(required), table.where(table.line)
    if not table.named:
        example = ",".join(f"{quantity}={i}" for i, quantity in enumerate(required, 1))
        return (
            f"{where}: no column is named; the first line must name {names}, or say which is "
            f"which: --columns {example}"
        )
    wanted = ", ".join(repr(quantity) for quantity in missing)
    return (
        f"{where}: no column {wanted} among {_listed(table.header)}; name them {names}, or say "
        f"which is which: --columns {missing[0]}=NAME"
    )


def _listed(names: Iterable[str]) -> str:
    """Names in a message, no more of them than a line can bear."""
    text = ",".join(names)
    return quoted(text)


def reading_note(
    table: TextTable, index: Mapping[str, int], *, decimal_commas: bool
) -> tuple[str, ...]:
    """Say what was assumed of a table, in one line; none where it uses our own names."""
    told: list[str] = []
    if table.separator not in ",\t":
        told.append(f"columns separated by {SEPARATORS[table.separator]}")
    if decimal_commas:
        told.append("decimal commas")
    renamed = [
        f"{table.header[i] or 'the first column'} as {quantity}"
        if table.named
        else f"column {i + 1} as {quantity}"
        for quantity, i in index.items()
        if table.header[i].lower() != quantity
    ]
    if renamed:
        told.append(", ".join(renamed))
    left = [name for i, name in enumerate(table.header) if i not in index.values()]
    if left:
        told.append(f"ignored {_listed(name or 'a column without a name' for name in left)}")
    return (f"{table.name} was read with {'; '.join(told)}",) if told else ()

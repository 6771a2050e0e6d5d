"""mrcal's and mrgingham's ``corners.vnl``: a corner a line, "filename x y level".

Lines of an image stand together, row by row of the board, x fastest; "-" is a corner not found, and
a level (how often the image was halved to find the corner) of k gives the weight 2^-k
(mrcal.compute_chessboard_corners). A fourth column named weight is one.
"""

from __future__ import annotations

import math

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.setup import LARGEST_PX
from bayescal.points.tables.text import decode, quoted
from bayescal.points.views.board import Board
from bayescal.points.views.formats.arrays import Seen, assembled
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views

NAME = "corners.vnl"
DEEPEST = 30  # level
MISSING = (math.nan, math.nan, math.nan)
SOME_BYTES = 4096
Rows = list[tuple[float, float, float]]


def recognises(source: Source) -> bool:
    """Whether it is called so, or its legend says filename x y."""
    if source.suffix == ".vnl":
        return True
    lines = source.raw[:SOME_BYTES].decode("utf-8", "replace").splitlines()
    return any(
        line.lstrip("# ").split()[:3] == ["filename", "x", "y"]
        for line in lines
        if line.startswith("#")
    )


def read(source: Source) -> Views:
    """Read the corners.

    Raises
    ------
    InputError
        Where there is no board, or a line can't be used; the message names it.
    """
    if source.board is None:
        raise InputError(
            f"{source.name}: holds pixels alone; say what they are of, such as --board 9x6 "
            "--square 0.02"
        )
    board, weighted = source.board, False
    images: dict[str, Rows] = {}
    for number, line in enumerate(decode(source.name, source.raw).splitlines(), 1):
        if line.startswith("#"):
            weighted = weighted or line.lstrip("# ").split()[3:4] == ["weight"]
            continue
        words = line.split()
        if words:
            corner = _corner(f"{source.name}:{number}", words, weighted)
            images.setdefault(words[0], []).append(corner)
    full = {name: rows for name, rows in images.items() if len(rows) > 1}  # one: none was found
    for name, rows in full.items():
        if len(rows) != board.n_points:
            raise InputError(
                f"{source.name}: {quoted(name)} has {len(rows)} corners and a board of {board} "
                f"{board.n_points}; correct --board"
            )
    return _views(source, board, images, weighted)


def _views(
    source: Source,
    board: Board,
    images: dict[str, list[tuple[float, float, float]]],
    weighted: bool,
) -> Views:
    seen, sigma = [], []
    for name, rows in images.items():
        given: Array = np.array(rows if len(rows) > 1 else [MISSING] * board.n_points)
        seen.append(Seen(name, board.points(), given[:, :2]))
        sigma.append(np.where(np.isfinite(given[:, 2]), given[:, 2], 1.0))
    kind = "the column weight" if weighted else "levels"
    differ = any((one != 1.0).any() for one in sigma)
    notes = (f"{kind} say how the points' deviations compare",) if differ else ()
    return assembled(source, seen, (None, None), notes, sigma)


def _corner(where: str, words: list[str], weighted: bool) -> tuple[float, float, float]:
    """Pixel and relative deviation of a line's corner; NaN where it was not found."""
    if not 3 <= len(words) <= 4:
        raise InputError(f"{where}: has {len(words)} fields; a corner is: filename x y level")
    if "-" in words[1:]:
        return MISSING
    try:
        r, c = float(words[1]), float(words[2])
        last = float(words[3]) if len(words) == 4 else float(weighted)
    except ValueError:
        raise InputError(
            f"{where}: {quoted(' '.join(words[1:]))} where numbers should be"
        ) from None
    if not (abs(r) < LARGEST_PX and abs(c) < LARGEST_PX and math.isfinite(last)):
        raise InputError(f"{where}: is no pixel of any image; correct it")
    if r < 0 or c < 0 or last < 0 or (weighted and last == 0):
        return MISSING
    if weighted:
        return r, c, min(max(1.0 / last, 1e-6), 1e6)
    if last > DEEPEST:
        raise InputError(f"{where}: level {last:g} is too deep; no image was halved so often")
    return r, c, 2.0 ** int(last)

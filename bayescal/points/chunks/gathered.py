"""Many points held at once, in a few numbers each: for what looks at every one of them."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

import numpy as np

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError
from bayescal.points.chunks.chunk import numbered
from bayescal.points.correspondences import Correspondences, one_line
from bayescal.rounding import grouped

# Points that are held: 40 bytes each, with deviations and names some hundred more.
MOST = 2_000_000


def gathered(
    source: str,
    chunks: Iterable[Correspondences],
    digest: str,
    notes: tuple[str, ...],
    *,
    labelled: bool,
    most: int = MOST,
) -> Correspondences:
    """Put chunks together, as numbers; a point without a name has its number for one.

    Raises
    ------
    InputError
        Where there are too many points to hold.
    """
    rows: list[Array] = []
    sigma: dict[str, list[Array]] = {}
    labels: list[str] = []
    groups: list[str] | None = None
    lines: list[range | Sequence[int]] = []
    last, n = None, 0
    for chunk in chunks:
        n += len(chunk)
        if n > most:
            raise InputError(
                f"{source}: holds more than {grouped(most)} points, the most for models that look "
                "at each of them at every draw; give fewer (a random sample), or compare orders or "
                "families at the stated position under Gaussian noise, which take any number"
            )
        rows.append(np.column_stack([chunk.world, chunk.pixels]))
        for name, sd in chunk.sigma.items():
            sigma.setdefault(name, []).append(sd)
        if labelled:
            start = n - len(chunk) + 1
            named = one_line(tuple(chunk.labels))
            labels += [name or str(i) for i, name in enumerate(named, start)]
        if chunk.groups is not None:
            groups = groups or []
            groups += map(sys.intern, one_line(tuple(chunk.groups)))
        if chunk.lines is not None:
            _follow(lines, chunk.lines)
        last = chunk
    if last is None:
        raise InputError(f"{source}: there are no points; give at least two")
    world, pixels = (
        frozen(np.concatenate([part[:, columns] for part in rows]))
        for columns in (slice(0, 3), slice(3, 5))
    )
    return Correspondences(
        world,
        pixels,
        tuple(labels) if labelled else numbered(0, n),
        None if groups is None else tuple(groups),
        {name: frozen(np.concatenate(parts)) for name, parts in sigma.items()},
        last.setup,
        source,
        _joined(lines),
        digest,
        notes,
    )


def _follow(lines: list[range | Sequence[int]], more: Sequence[int]) -> None:
    """Add lines of a chunk; a range that goes on from the last one lengthens it."""
    before = lines[-1] if lines else None
    if isinstance(more, range) and isinstance(before, range) and before.stop == more.start:
        lines[-1] = range(before.start, more.stop)
    else:
        lines.append(more)


def _joined(lines: Sequence[range | Sequence[int]]) -> Sequence[int] | None:
    if not lines:
        return None
    return lines[0] if len(lines) == 1 else tuple(line for part in lines for line in part)

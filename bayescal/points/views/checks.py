"""What no set of views can be: refused with a line that says where, what and what to do."""

from __future__ import annotations

import numbers

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.errors import InputError
from bayescal.points.setup import LARGEST_PX
from bayescal.points.tables.text import quoted
from bayescal.points.views.rows import ViewRows
from bayescal.rounding import counted

FEWEST = 4  # points of a view: a pose has six numbers, a point gives two, and one more to check
# Points beyond the middle line spread less than this fraction of those along it: one line.
ON_A_LINE = 1e-6


def check_views(views: ViewRows) -> None:
    """Refuse views that can't be of one target seen by one camera.

    Raises
    ------
    InputError
    """
    for one, part in enumerate(views.slices):
        _check_view(views, one, part)
    _check_target(views)
    if views.image_size is not None:
        _check_size(views, *views.image_size)


def _check_view(views: ViewRows, one: int, part: slice) -> None:
    name = quoted(views.names[one])
    count = part.stop - part.start
    where = views.place(part.start) if views.lines is not None else views.source
    if count < FEWEST:
        raise InputError(
            f"{where}: view {name} has {counted(count, 'point')}; a pose takes at least {FEWEST}: "
            "leave the view out"
        )
    corner = views.corner[part]
    _, first = np.unique(corner, return_index=True)
    if len(first) < count:
        again = part.start + int(np.setdiff1d(np.arange(count), first)[0])
        x, y, z = (f"{v:g}" for v in views.world[again])
        raise InputError(
            f"{views.place(again)}: view {name} has the point ({x}, {y}, {z}) twice; keep one, or "
            "give the second photograph a name of its own"
        )
    for what, points in (("target", views.world[part]), ("image", views.pixels[part])):
        if _on_a_line(points):
            raise InputError(
                f"{where}: the points of view {name} lie on one line of the {what}, so its pose "
                "can't be found; leave the view out"
            )


def _on_a_line(points: Array) -> bool:
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(spread[1] <= ON_A_LINE * spread[0])


def _check_target(views: ViewRows) -> None:
    """Refuse two boards in one file: they overlap, and share next to no points."""
    part = _together(views.view, views.corner, len(views))
    boards = [views.target[np.unique(views.corner[part[views.view] == k])] for k in np.unique(part)]
    for k, board in enumerate(boards[1:], 1):
        if _overlap(boards[0], board, views.diagonal):
            first, other = (views.names[int(np.argmax(part == np.unique(part)[i]))] for i in (0, k))
            raise InputError(
                f"{views.source}: views {quoted(first)} and {quoted(other)} show different "
                "targets: they cover the same place and share fewer than "
                f"{FEWEST} points; give the views of one target at a time"
            )


def _together(view: IntArray, corner: IntArray, n_views: int) -> IntArray:
    """Part of each view, ``(n_views,)``: views of a part share points, directly or through others.

    A view joins the largest part it shares at least `FEWEST` points with; parts that a later
    view joins become one.
    """
    parts: list[tuple[set[int], set[int]]] = []
    bounds = np.searchsorted(view, np.arange(n_views + 1))
    for one in range(n_views):
        seen = set(corner[bounds[one] : bounds[one + 1]].tolist())
        joined = [p for p in parts if len(p[1] & seen) >= FEWEST]
        parts = [p for p in parts if len(p[1] & seen) < FEWEST]
        parts.append(
            (
                set().union({one}, *(p[0] for p in joined)),
                set().union(seen, *(p[1] for p in joined)),
            )
        )
    found = np.zeros(n_views, dtype=np.intp)
    for members, _ in parts:
        found[list(members)] = min(members)
    return found


def _overlap(one: Array, other: Array, size: float) -> bool:
    """Whether the boxes around two sets of points have more than an edge in common."""
    low = np.maximum(one.min(axis=0), other.min(axis=0))
    high = np.minimum(one.max(axis=0), other.max(axis=0))
    return bool((high - low >= -1e-9 * size).all() and (high - low > 1e-9 * size).sum() >= 2)


def _check_size(views: ViewRows, width: int, height: int) -> None:
    """Refuse pixels of another camera's images."""
    size = np.array([width, height])
    off = off_image(views.pixels, width, height)
    far = ((views.pixels < -size) | (views.pixels > 2 * size)).any(axis=1)
    if far.any():
        first = int(np.argmax(far))
        r, c = (f"{v:g}" for v in views.pixels[first])
        raise InputError(
            f"{views.place(first)}: r = {r}, c = {c} is far outside an image of {width} by "
            f"{height} px; correct the pixel or the image size"
        )
    share = np.bincount(views.view, weights=off, minlength=len(views)) / views.counts
    if share.max() > 0.5:
        one = int(np.argmax(share))
        raise InputError(
            f"{views.source}: most points of view {quoted(views.names[one])} lie off an image of "
            f"{width} by {height} px: it is of another size, or r and c are exchanged; all views "
            "must be of one camera"
        )


def off_image(pixels: Array, width: int, height: int) -> Array:
    """1 where a pixel is off the image, ``(n,)``; its edges are half a pixel beyond the centres."""
    low, high = np.full(2, -0.5), np.array([width - 0.5, height - 0.5])
    return ((pixels < low) | (pixels > high)).any(axis=1).astype(float)


def image_side(value: float | None, name: str) -> int | None:
    """Take a width or height of the image, a whole number of px."""
    if value is None:
        return None
    if not isinstance(value, numbers.Real):
        raise InputError(f"image {name} must be a number of px, not {value!r}")
    if not (1 <= value <= LARGEST_PX and float(value).is_integer()):
        raise InputError(
            f"image {name} must be a whole number from 1 to {LARGEST_PX:g} px, not {value:g}"
        )
    return int(value)

"""Named arrays of target and image points, as programs keep them, brought to views."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.points.tables.text import quoted
from bayescal.points.views.checks import FEWEST
from bayescal.points.views.formats.source import Source
from bayescal.points.views.views import Views
from bayescal.rounding import counted

# Names with underscores left out, in any case; a view's number may follow.
OBJECT = (
    *("objectpoints", "objpoints", "objpts", "objectpts", "objp"),
    *("worldpoints", "worldpts", "targetpoints", "points3d", "pts3d"),
)
IMAGE = (
    *("imagepoints", "imgpoints", "imgpts", "imagepts", "imgp"),
    *("corners", "detections", "points2d", "pts2d"),
)
WIDTH, HEIGHT = (
    ("imagewidth", "imgwidth", "width", "nx"),
    ("imageheight", "imgheight", "height", "ny"),
)
SIZE = ("imagesize", "imgsize", "imsize")  # width, height: as OpenCV has them
SHAPE = ("imageshape", "imgshape")  # rows, columns
NEITHER = ("", "")
_NUMBERED = re.compile(r"(?P<stem>.*?)_?(?P<number>\d+)")
_FRAME = re.compile(r"(?P<view>.+)_(?P<what>indices|detections)")


@dataclass(frozen=True, eq=False)
class Seen:
    """What one view shows: target points ``(n, 3)`` and pixels ``(n, 2)``, NaN where missing."""

    name: str
    world: Array
    pixels: Array


def plain(name: str) -> str:
    """Bare an array's name of case and underscores."""
    return name.lower().replace("_", "")


def known(name: str) -> bool:
    """Whether an array of that name is looked at."""
    return _role(name) != NEITHER or plain(name) in (*WIDTH, *HEIGHT, *SIZE, *SHAPE)


def _role(name: str) -> tuple[str, str]:
    """Whether an array has target points or pixels, and of which view; empty where of neither."""
    frame = _FRAME.fullmatch(name)
    if frame:
        return frame["what"], frame["view"]
    for role, names in (("object", OBJECT), ("image", IMAGE)):
        if plain(name) in names:
            return role, ""
        numbered = _NUMBERED.fullmatch(name)
        if numbered and plain(numbered["stem"]) in names:
            return role, numbered["number"]
    return NEITHER


def views_of(source: Source, arrays: Mapping[str, Array]) -> list[Seen]:
    """Pair the points of each view.

    Raises
    ------
    InputError
        Where there are none, two sets, or their shapes don't go together.
    """
    roles: dict[str, dict[str, Array]] = {}
    for name, array in arrays.items():
        role, view = _role(name)
        if role:
            if view in roles.setdefault(role, {}):
                raise InputError(
                    f"{source.name}: {quoted(name)} is a second array of {role} points; keep one"
                )
            roles[role][view] = array
    if "indices" in roles and "detections" in roles:
        return _indexed(source, roles)
    images = _split(source, roles.get("image", {}), 2)
    if not images:
        raise InputError(
            f"{source.name}: holds no image points; name them image_points (views, points, 2) and "
            f"the target's object_points (points, 3); it holds {quoted(', '.join(arrays) or '-')}"
        )
    objects = _split(source, roles.get("object", {}), 3)
    if objects:
        source.refuse_board()
    else:
        objects = {"": _board(source)}
    if set(objects) != set(images) and len(objects) > 1:
        raise InputError(
            f"{source.name}: has target points of {counted(len(objects), 'view')} and pixels of "
            f"{len(images)}; give both for each"
        )
    alone = next(iter(objects.values())) if len(objects) == 1 else None
    seen = []
    for view, pixels in images.items():
        world = objects[view] if alone is None else alone
        if len(world) != len(pixels):
            raise InputError(
                f"{source.name}: view {quoted(view)} has {counted(len(world), 'target point')} and "
                f"{len(pixels)} pixels; give one of each per point"
            )
        seen.append(Seen(view, world, pixels))
    return seen


def _board(source: Source) -> Array:
    if source.board is None:
        raise InputError(
            f"{source.name}: holds pixels alone; say what they are of, such as --board 9x6 "
            "--square 25"
        )
    return source.board.points()


def _indexed(source: Source, roles: Mapping[str, Mapping[str, Array]]) -> list[Seen]:
    """Pair views that name the points they show by their number in the target."""
    (target,) = _split(source, roles.get("object", {}), 3).values() or (_board(source),)
    seen = []
    for view, pixels in roles["detections"].items():
        index = roles["indices"].get(view, np.empty(0)).ravel().astype(np.intp)
        if len(index) != len(pixels) or not ((index >= 0) & (index < len(target))).all():
            raise InputError(
                f"{source.name}: the indices of view {quoted(view)} don't fit its pixels, or the "
                f"{counted(len(target), 'target point')}"
            )
        seen.append(Seen(view, target[index], _points(source, pixels, 2)[0]))
    return seen


def _split(source: Source, arrays: Mapping[str, Array], columns: int) -> dict[str, Array]:
    """One array per view, by the view's number (from 1) or the array's own."""
    if len(arrays) == 1:
        (array,) = arrays.values()
        return {str(i): one for i, one in enumerate(_points(source, array, columns), 1)}
    found = {}
    for view, array in sorted(arrays.items(), key=lambda item: (len(item[0]), item[0])):
        each = _points(source, array, columns)
        if len(each) != 1:
            raise InputError(f"{source.name}: {quoted(view)} holds several views; give it alone")
        found[view] = each[0]
    return found


def _points(source: Source, array: Array, columns: int) -> list[Array]:
    """Points of each view: an array (views, points, 2), or OpenCV's (views, points, 1, 2)."""
    if columns == 3 and array.ndim >= 2 and array.shape[-1] == 2:
        array = np.concatenate([array, np.zeros((*array.shape[:-1], 1))], axis=-1)
    if array.ndim == 4 and 1 in array.shape[1:3]:
        array = array.reshape(array.shape[0], -1, array.shape[3])
    elif array.ndim == 3 and array.shape[1] == 1:  # OpenCV's (points, 1, 2)
        array = array.reshape(1, -1, array.shape[2])
    elif array.ndim == 2:
        array = array[None]
    if array.ndim != 3 or array.shape[2] != columns:
        raise InputError(
            f"{source.name}: points of shape {array.shape} are not understood; give "
            f"(views, points, {columns})"
        )
    return list(array)


def image_size(arrays: Mapping[str, Array]) -> tuple[float | None, float | None]:
    """Width and height of the image, px, under the names that programs use; None where not told."""
    told = {plain(name): array.ravel() for name, array in arrays.items()}
    for names, order in ((SIZE, 1), (SHAPE, -1)):
        for name in names:
            if name in told and 2 <= len(told[name]) <= 3:
                width, height = told[name][:2][::order].tolist()
                return _whole(width), _whole(height)
    sides = [
        next((_whole(told[n][0].item()) for n in names if n in told and len(told[n])), None)
        for names in (WIDTH, HEIGHT)
    ]
    return (sides[0], sides[1]) if None not in sides else (None, None)


def _whole(value: float) -> float | None:
    return value if np.isfinite(value) and value >= 1 and value == int(value) else None


def assembled(
    source: Source,
    seen: list[Seen],
    size: tuple[float | None, float | None],
    notes: tuple[str, ...] = (),
    sigma: list[Array] | None = None,
    sha256: str = "",
) -> Views:
    """Make views of what each shows, leaving out points that are missing and views of too few.

    Parameters
    ----------
    size : tuple
        Image width and height, px, or None.
    notes : tuple of str
        What the format's reader has to say.
    sigma : list of Array, optional
        How the points' deviations compare, ``(n_i,)`` each.
    sha256 : str, optional
        Hash of what was read; of the source's bytes by default.

    Raises
    ------
    InputError
        Where nothing is left, or the views can't be used.
    """
    present = [np.isfinite(s.pixels).all(axis=1) & np.isfinite(s.world).all(axis=1) for s in seen]
    kept = [i for i, there in enumerate(present) if there.sum() >= FEWEST]
    told = list(notes)
    missing = sum(int((~present[i]).sum()) for i in kept)
    if missing:
        total = sum(len(present[i]) for i in kept)
        told.append(f"{missing} of {counted(total, 'point')} are missing in their views")
    few = [seen[i].name for i in range(len(seen)) if i not in set(kept)]
    if few:
        told.append(
            f"{counted(len(few), 'view')} with fewer than {FEWEST} points left out "
            f"(the first: {few[0]})"
        )
    if not kept:
        raise InputError(f"{source.name}: no view has {FEWEST} points; nothing can be made of it")
    relative = sigma is not None and any(np.ptp(sigma[i][present[i]]) > 0 for i in kept)
    each = [np.repeat(sigma[i][present[i], None], 2, axis=1) for i in kept] if sigma else []
    return Views.from_rows(
        [seen[i].name for i in kept for _ in range(int(present[i].sum()))],
        np.concatenate([seen[i].world[present[i]] for i in kept]),
        np.concatenate([seen[i].pixels[present[i]] for i in kept]),
        sigma=np.concatenate(each) if relative else None,
        relative_sigma=relative,
        width=size[0],
        height=size[1],
        source=source.name,
        sha256=sha256 or source.sha256,
        notes=told,
    )

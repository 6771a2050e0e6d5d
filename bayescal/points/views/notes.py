"""What is odd about some views, a line each; nothing here keeps them from being used."""

from __future__ import annotations

import numpy as np

from bayescal.arrays import Array
from bayescal.points.views.checks import off_image
from bayescal.points.views.views import Views
from bayescal.rounding import counted

# A smooth map misses the pixels of a properly named board by a few hundredths of its span.
SCRAMBLED = 0.1
MANY = 1000
ALIKE = 0.02  # of what all points span: views whose points move by less are of one pose


def view_notes(views: Views) -> list[str]:
    """Say it: what the reader assumed, and what is odd about the views."""
    found = list(views.notes)
    if views.image_size is not None:
        found += _off(views, *views.image_size)
    if len(views) == 1:
        found.append(
            "one view only: what the lens does and where it stood can hardly be told apart"
        )
    if len(views) > MANY:
        found.append(f"{len(views)} views: a hundred that differ say nearly as much, sooner")
    odd = scrambled(views)
    return [*found, *_repeated(views), *([odd] if odd else []), *_mirrored(views)]


def alike(views: Views) -> bool:
    """Whether all views are of one pose: the target's points hardly move from one to another."""
    n = len(views.target)
    low, high = np.full((n, 2), np.inf), np.full((n, 2), -np.inf)
    np.minimum.at(low, views.corner, views.pixels)
    np.maximum.at(high, views.corner, views.pixels)
    often = np.bincount(views.corner, minlength=n) > 1
    if not often.any():
        return False
    size = float(np.hypot(*np.ptp(views.pixels, axis=0)))
    return float(np.median(np.hypot(*(high - low)[often].T))) < ALIKE * size


def _off(views: Views, width: int, height: int) -> list[str]:
    off = off_image(views.pixels, width, height)
    count = int(off.sum())
    if not count:
        return []
    first = int(np.argmax(off))
    r, c = (f"{v:g}" for v in views.pixels[first])
    return [
        f"{count} of {counted(views.n_points, 'point')} {'lies' if count == 1 else 'lie'} off the "
        f"image (the first at {views.place(first)}: r = {r}, c = {c}); check its size, or the "
        "readings"
    ]


def _repeated(views: Views) -> list[str]:
    """Find views that are a copy of an earlier one."""
    seen: dict[bytes, str] = {}
    copies = []
    for name, part in zip(views.names, views.slices, strict=True):
        key = views.corner[part].tobytes() + views.pixels[part].tobytes()
        if key in seen:
            copies.append(f"view {name} repeats view {seen[key]} exactly")
        seen.setdefault(key, name)
    if not copies:
        return []
    more = f" ({len(copies)} such views)" if len(copies) > 1 else ""
    return [f"{copies[0]}{more}; copies of one photograph make every interval too narrow"]


def scrambled(views: Views) -> str:
    """Say which views show no flat target, as where points are named in the wrong order."""
    odd = [name for name, (misfit, _) in _senses(views) if misfit > SCRAMBLED]
    if not odd:
        return ""
    return (
        f"view {odd[0]} looks like no picture of a flat target: are its points in another order?"
        f"{_others(odd)}"
    )


def _mirrored(views: Views) -> list[str]:
    """Say which views show a flat target from behind, unlike most."""
    senses = [(name, np.sign(turn)) for name, (_, turn) in _senses(views)]
    most = sum(sense for _, sense in senses)
    odd = [name for name, sense in senses if sense * most < 0]
    if not odd:
        return []
    return [
        f"view {odd[0]} shows the target mirrored, unlike most: is a row or column counted "
        f"backwards there?{_others(odd)}"
    ]


def _senses(views: Views) -> list[tuple[str, tuple[float, float]]]:
    """Name views of a flat target, with what `_smooth` says of each."""
    if not views.planar:
        return []
    plane = _plane(views.target)[views.corner]
    return [
        (name, _smooth(plane[part], views.pixels[part]))
        for name, part in zip(views.names, views.slices, strict=True)
    ]


def _others(names: list[str]) -> str:
    return f" ({counted(len(names), 'view')} in all)" if len(names) > 1 else ""


def _plane(target: Array) -> Array:
    """Coordinates of a flat target's points in its plane, ``(n, 2)``, about -1 to 1."""
    centred = target - target.mean(axis=0)
    _, _, directions = np.linalg.svd(centred, full_matrices=False)
    inside = centred @ directions[:2].T
    return np.asarray(inside / np.abs(inside).max())


def _smooth(plane: Array, pixels: Array) -> tuple[float, float]:
    """How badly a smooth map takes plane to pixels, as a fraction of their span; and its sense."""
    x, y = (plane - plane.mean(axis=0)).T
    terms = [np.ones_like(x), x, y]
    affine = np.column_stack(terms)
    if len(x) >= 12:
        terms += [x * x, x * y, y * y]
    design = np.column_stack(terms)
    linear = np.linalg.lstsq(affine, pixels, rcond=None)[0]
    fitted = design @ np.linalg.lstsq(design, pixels, rcond=None)[0]
    span = np.linalg.norm(np.ptp(pixels, axis=0))
    rms = np.sqrt(((pixels - fitted) ** 2).sum(axis=1).mean())
    return float(rms / span), float(np.linalg.det(linear[1:]))

"""Rows of many views of a target: what they hold, before anybody asks whether it can be."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from bayescal.arrays import Array, IntArray, frozen
from bayescal.errors import InputError
from bayescal.points.heading import SILENT, Heading
from bayescal.points.tables.text import quoted

# Points nearer than this fraction of the target's diagonal are one point, written with rounding.
SAME = 1e-9


@dataclass(frozen=True, eq=False)
class ViewRows:
    """Points of every view, one after the other; the attributes are those of `Views`."""

    names: tuple[str, ...]
    view: IntArray
    world: Array
    pixels: Array
    target: Array
    corner: IntArray
    sigma: Array | None = None
    relative_sigma: bool = False
    labels: tuple[str, ...] | None = None
    width: int | None = None
    height: int | None = None
    source: str = "arrays"
    lines: tuple[int, ...] | None = None
    sha256: str = ""
    notes: tuple[str, ...] = field(default=())
    heading: Heading = SILENT

    def __len__(self) -> int:
        return len(self.names)

    @property
    def image_size(self) -> tuple[int, int] | None:
        """Width and height of the image, px; None where they are not known."""
        return None if self.width is None or self.height is None else (self.width, self.height)

    @property
    def n_points(self) -> int:
        """How many points all views show together."""
        return len(self.view)

    @cached_property
    def counts(self) -> IntArray:
        """Points of each view, ``(n_views,)``."""
        return fixed(np.bincount(self.view, minlength=len(self)))

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where each view's points stand in the arrays."""
        ends = np.cumsum(self.counts).tolist()
        return tuple(map(slice, [0, *ends[:-1]], ends))

    @cached_property
    def extent(self) -> Array:
        """Size of the target along x, y and z, ``(3,)``, the target's unit."""
        return frozen(np.ptp(self.target, axis=0))

    @cached_property
    def diagonal(self) -> float:
        """Diagonal of the target, the target's unit."""
        return float(np.linalg.norm(self.extent))

    @cached_property
    def planar(self) -> bool:
        """Whether the target's points lie in one plane (to a millionth of its size)."""
        spread = np.linalg.svd(self.target - self.target.mean(axis=0), compute_uv=False)
        return len(spread) < 3 or bool(spread[2] <= 1e-6 * spread[0])

    def place(self, point: int) -> str:
        """Where a point (from 0) is, for a message: file and line, or view and label."""
        if self.lines is not None:
            return f"{self.source}:{self.lines[point]}"
        view = self.names[int(self.view[point])]
        return f"{self.source}, view {view}, point {self.label(point)}"

    def label(self, point: int) -> str:
        """Name of a point (from 0): its label, or its number within its view, from 1."""
        own = self.labels[point] if self.labels is not None else ""
        return own or str(point - self.slices[int(self.view[point])].start + 1)


def rows_named(views: ViewRows, name: str) -> IntArray:
    """Rows of a view, or of a point of one: ``"left05.jpg"``, ``"left05.jpg:21"``.

    Raises
    ------
    InputError
        Where there is no such view or point.
    """
    if name in views.names:
        part = views.slices[views.names.index(name)]
        return np.arange(part.start, part.stop)
    view, _, label = name.rpartition(":")
    if view not in views.names:
        raise InputError(
            f"{views.source}: no view is called {quoted(view or name)}; there are "
            f"{quoted(', '.join(views.names))}"
        )
    part = views.slices[views.names.index(view)]
    rows = [i for i in range(part.start, part.stop) if views.label(i) == label]
    if not rows:
        last = views.label(part.stop - 1)
        raise InputError(
            f"{views.source}: view {quoted(view)} has no point {quoted(label)}; its points go "
            f"from {quoted(views.label(part.start))} to {quoted(last)}"
        )
    return np.array(rows)


def fixed(values: IntArray) -> IntArray:
    """Return whole numbers as a read-only array of their own."""
    array = np.array(values, dtype=np.intp)
    array.setflags(write=False)
    return array


def distinct(world: Array) -> tuple[Array, IntArray]:
    """Distinct points, ``(n_corners, 3)``, sorted by z, y, x, and the index of each."""
    size = float(np.linalg.norm(np.ptp(world, axis=0)))
    # Adding 0 makes -0 into 0. Rounded numbers only tell points apart; what is kept is as given.
    rounded = np.round(world / (SAME * size)) + 0.0 if size else np.zeros_like(world)
    _, first, index = np.unique(rounded[:, ::-1], axis=0, return_index=True, return_inverse=True)
    return frozen(world[first]), index.reshape(-1).astype(np.intp)

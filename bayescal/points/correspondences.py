"""World points and their measured pixels."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from bayescal.arrays import Array, ArrayLike, frozen
from bayescal.errors import InputError
from bayescal.points.given import check_bounded, numbers, table
from bayescal.points.setup import AXES, LARGEST_PX, SMALLEST_PX, Setup
from bayescal.points.setup import LARGEST as LARGEST
from bayescal.rounding import counted


@dataclass(frozen=True, eq=False)
class Correspondences:
    """World points whose pixels were measured, with what is known of the camera.

    Attributes
    ----------
    world : Array
        World coordinates x, y, z, ``(n_points, 3)``, in world units.
    pixels : Array
        Measured pixels r, c as recorded (c counted from the top unless the
        recording says otherwise), ``(n_points, 2)``, px.
    labels : sequence of str
        A name per point; "1", "2", ... where none was given.
    groups : sequence of str or None
        Which points share a cause of error.
    sigma : dict of str to Array
        Known standard deviations, ``(n_points,)``: of the pixels ("r", "c"), px, and of
        the world coordinates ("x", "y", "z"), world units.
    setup : Setup
        Camera position, image size, direction of c, stated priors.
    source : str
        Where the points came from.
    lines : sequence of int or None
        The file's line of each point.
    sha256 : str
        Hash of the file's bytes, or of the numbers where there was no file.
    notes : tuple of str
        What had to be assumed to read them.
    drawn_from : int or None
        How many points these were drawn from at random; None where they are all.
    """

    world: Array
    pixels: Array
    labels: Sequence[str]
    groups: Sequence[str] | None = None
    sigma: dict[str, Array] = field(default_factory=dict)
    setup: Setup = field(default_factory=Setup)
    source: str = "arrays"
    lines: Sequence[int] | None = None
    sha256: str = ""
    notes: tuple[str, ...] = ()
    drawn_from: int | None = None

    @classmethod
    def from_arrays(
        cls,
        world: ArrayLike,
        pixels: ArrayLike,
        *,
        labels: Sequence[str] | None = None,
        groups: Sequence[str] | None = None,
        sigma_r: ArrayLike | None = None,
        sigma_c: ArrayLike | None = None,
        sigma_x: ArrayLike | None = None,
        sigma_y: ArrayLike | None = None,
        sigma_z: ArrayLike | None = None,
        setup: Setup | None = None,
    ) -> Correspondences:
        """Build correspondences from arrays.

        Parameters
        ----------
        world : array_like
            x, y, z, ``(n_points, 3)``, world units.
        pixels : array_like
            r, c as measured, ``(n_points, 2)``, px.
        labels, groups : sequence of str, optional
            A name and a group per point.
        sigma_r, sigma_c : array_like, optional
            Known standard deviations of the pixels, ``(n_points,)``, px.
        sigma_x, sigma_y, sigma_z : array_like, optional
            Known standard deviations of the world coordinates, ``(n_points,)``, world
            units; 0 where one is exact.
        setup : Setup, optional
            What is known of the camera; by default it stands at the origin and
            the image size is unknown.

        Raises
        ------
        InputError
            Where shapes disagree or a number is not finite.
        """
        w, p = frozen(table(world, 3, "world")), frozen(table(pixels, 2, "pixels"))
        n = len(w)
        if n == 0:
            raise InputError("there are no points; give at least two")
        if len(p) != n:
            raise InputError(f"pixels must have shape ({n}, 2) like world, not {p.shape}")
        given = {"r": sigma_r, "c": sigma_c, "x": sigma_x, "y": sigma_y, "z": sigma_z}
        stated = {name: s for name, s in given.items() if s is not None}
        sigma = {name: frozen(numbers(s, f"sigma_{name}")) for name, s in stated.items()}
        names = one_line(labels) if labels is not None else ("",) * n
        names = tuple(name or str(i) for i, name in enumerate(names, 1))
        groups = one_line(groups) if groups is not None else None
        for what, values in [("labels", names), ("groups", groups), *sigma.items()]:
            if values is not None and len(values) != n:
                raise InputError(f"{what}: {len(values)} given for {counted(n, 'point')}")
        for what, array, limit in [("world", w, LARGEST), ("pixels", p, LARGEST_PX)]:
            check_bounded(array, what, limit)
        for name, sd in sigma.items():
            low, high = (SMALLEST_PX, LARGEST_PX) if name in AXES else (0.0, LARGEST)
            if not ((sd >= low) & (sd <= high)).all():
                raise InputError(f"sigma_{name} must be from {low:g} to {high:g} throughout")
        digest = hashlib.sha256()
        for array in (w, p, *(sigma[a] for a in sorted(sigma))):
            digest.update(array.tobytes())
        return cls(w, p, names, groups, sigma, setup or Setup(), sha256=digest.hexdigest())

    def __post_init__(self) -> None:
        shapes = [getattr(array, "shape", None) for array in (self.world, self.pixels)]
        arrays = isinstance(self.world, np.ndarray) and isinstance(self.pixels, np.ndarray)
        if not arrays or shapes != [(len(self.labels), 3), (len(self.labels), 2)]:
            raise InputError(
                "Correspondences holds arrays world (n, 3) and pixels (n, 2) and n labels; build "
                "it with bc.load(...) or Correspondences.from_arrays(world, pixels)"
            )

    def __len__(self) -> int:
        return len(self.world)

    @property
    def n(self) -> int:
        """Number of points, those that they were drawn from among them."""
        return len(self) if self.drawn_from is None else self.drawn_from

    def camera_frame(self) -> Array:
        """World points less the camera position, ``(n_points, 3)``, world units."""
        return self.world - frozen(self.setup.position)

    def pixel(self, axis: str) -> Array:
        """Pixels of one axis, ``(n_points,)``, px; c counted as the setup says.

        ``c = height - row`` where the setup counts c from the bottom (Appendix B
        of the thesis).
        """
        if axis == "r":
            return self.pixels[:, 0]
        c = self.pixels[:, 1]
        if self.setup.c_from_bottom:
            assert self.setup.height is not None, "Setup refuses c_from_bottom without a height"
            return self.setup.height - c
        return c

    def checked_pixel(self, axis: str) -> Array:
        """Give `pixel` of an axis, where none is far off the image.

        Raises
        ------
        InputError
            Where one is more than an image size outside it.
        """
        t, size = self.pixel(axis), self.setup.size(axis)
        if size is not None:
            outside = np.flatnonzero((t < -size) | (t > 2 * size))
            if outside.size:
                first = int(outside[0])
                raise InputError(
                    f"{self.place(first)}: {axis} = {t[first]:g} px is far outside an image of "
                    f"{size:g} px; correct the pixel, the image size or the direction of c"
                )
        return t

    def world_sigma(self) -> Array | None:
        """Give the standard deviations of x, y, z, ``(n_points, 3)``, world units; None if unknown.

        A column of the points goes before the setup's value for all of them.
        """
        stated = self.setup.world_sigma
        if stated is None and not any(name in self.sigma for name in "xyz"):
            return None
        columns = [
            self.sigma.get(name, np.full(len(self), stated[i] if stated is not None else 0.0))
            for i, name in enumerate("xyz")
        ]
        return np.column_stack(columns)

    def causes(self) -> tuple[str, Sequence[str]]:
        """Which points share a cause of error: the column `group`, else a plane of z.

        Returns
        -------
        source : str
            ``"column group"`` or ``"plane z"``.
        names : tuple of str
            Group of each point.
        """
        if self.groups is not None:
            return "column group", self.groups
        return "plane z", tuple(f"z = {z:.15g}" for z in self.world[:, 2])

    def place(self, index: int) -> str:
        """Where point `index` (from 0) is, for a message: file and line, or its label."""
        if self.lines is not None:
            return f"{self.source}:{self.lines[index]}"
        return f"{self.source}, point {self.labels[index]}"

    def __repr__(self) -> str:
        return f"<Correspondences: {len(self)} points from {self.source}, {self.setup}>"


def one_line(texts: Sequence[str]) -> tuple[str, ...]:
    """Fold the white space of labels, so that each stays on its line in print and in a file.

    What no text file can hold (null bytes, lone surrogates) counts as white space.
    """
    return tuple(re.sub(r"[\s\0\ud800-\udfff]+", " ", text).strip() for text in texts)

"""Views of a target: points known in the target's own frame, and where photographs show them."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bayescal.arrays import ArrayLike, IntArray, frozen
from bayescal.errors import InputError
from bayescal.points.correspondences import one_line
from bayescal.points.given import check_bounded, table
from bayescal.points.setup import LARGEST, LARGEST_PX, SMALLEST_PX
from bayescal.points.views.checks import check_views, image_side
from bayescal.points.views.rows import ViewRows, distinct, fixed, rows_named
from bayescal.rounding import counted


@dataclass(frozen=True, eq=False)
class Views(ViewRows):
    """Photographs of one target by one camera, point by point.

    Frames are OpenCV's: pixel centres at integers, r from the left and c from the top.
    Points stand in the order of their views.

    Attributes
    ----------
    names : tuple of str
        A name per view.
    view : IntArray
        View of each point, from 0, never falling, ``(n_points,)``.
    world : Array
        x, y, z in the target's frame, ``(n_points, 3)``, the target's unit.
    pixels : Array
        r, c as measured, ``(n_points, 2)``, px.
    target : Array
        The target's distinct points, ``(n_corners, 3)``, the target's unit.
    corner : IntArray
        Which of them each point is, ``(n_points,)``.
    sigma : Array or None
        Standard deviations of r and c, ``(n_points, 2)``, px; None where not stated.
    relative_sigma : bool
        Whether `sigma` says only how the points compare, its scale unknown.
    labels : tuple of str or None
        A name per point.
    width, height : int or None
        Image size, px; None where it is not known.
    source : str
        Where the views came from.
    lines : tuple of int or None
        The file's line of each point.
    sha256 : str
        Hash of the file's bytes, or of the numbers where there was no file.
    notes : tuple of str
        What the reader assumed or left out, a line each.
    heading : Heading
        What the title block of a report says.
    """

    @classmethod
    def from_arrays(
        cls,
        world: Sequence[ArrayLike],
        pixels: Sequence[ArrayLike],
        *,
        names: Sequence[str] | None = None,
        sigma: Sequence[ArrayLike] | None = None,
        width: float | None = None,
        height: float | None = None,
    ) -> Views:
        """Build views from arrays, one of each per view.

        Parameters
        ----------
        world : sequence of array_like
            x, y, z of the target's points that a view shows, ``(n_i, 3)`` each.
        pixels : sequence of array_like
            Their r, c, ``(n_i, 2)`` each, px.
        names : sequence of str, optional
            A name per view; "1", "2", ... by default.
        sigma : sequence of array_like, optional
            Standard deviations of r and c, ``(n_i, 2)`` each, px.
        width, height : float, optional
            Image size, px.

        Raises
        ------
        InputError
            Where shapes disagree, a number is not finite, a view shows fewer than four points
            or one point twice, or the views can't be of one target and one camera.
        """
        if not all(hasattr(given, "__len__") for given in (world, pixels)):
            raise InputError("world and pixels must be lists of arrays, one of each per view")
        if len(world) != len(pixels):
            raise InputError(f"world has {len(world)} views and pixels {len(pixels)}")
        each = [
            (table(w, 3, f"view {i}: world", "n"), table(p, 2, f"view {i}: pixels", "n"))
            for i, (w, p) in enumerate(zip(world, pixels, strict=True), 1)
        ]
        for i, (w, p) in enumerate(each, 1):
            if len(w) != len(p):
                raise InputError(
                    f"view {i}: {counted(len(w), 'point')} in world and {len(p)} in pixels"
                )
        names = [str(i) for i in range(1, len(each) + 1)] if names is None else [*map(str, names)]
        if len(names) != len(each):
            raise InputError(f"names: {len(names)} given for {counted(len(each), 'view')}")
        sds = None
        if sigma is not None:
            if len(sigma) != len(each):
                raise InputError(f"sigma: {len(sigma)} given for {counted(len(each), 'view')}")
            sds = [table(s, 2, f"view {i}: sigma", "n") for i, s in enumerate(sigma, 1)]
        return cls.from_rows(
            [name for name, (w, _) in zip(names, each, strict=True) for _ in w],
            np.concatenate([w for w, _ in each]) if each else np.empty((0, 3)),
            np.concatenate([p for _, p in each]) if each else np.empty((0, 2)),
            sigma=np.concatenate(sds) if sds else None,
            width=width,
            height=height,
        )

    @classmethod
    def from_rows(
        cls,
        view: Sequence[str],
        world: ArrayLike,
        pixels: ArrayLike,
        *,
        sigma: ArrayLike | None = None,
        relative_sigma: bool = False,
        labels: Sequence[str] | None = None,
        width: float | None = None,
        height: float | None = None,
        source: str = "arrays",
        lines: Sequence[int] | None = None,
        sha256: str = "",
        notes: Sequence[str] = (),
    ) -> Views:
        """Build views from rows: for each point the name of its view, x, y, z and r, c."""
        w, p = table(world, 3, "world"), table(pixels, 2, "pixels")
        check_bounded(w, "world", LARGEST)
        check_bounded(p, "pixels", LARGEST_PX)
        n = len(w)
        if n == 0:
            raise InputError(f"{source}: there are no points; give at least one view of four")
        given = one_line(tuple(view))
        sds = None if sigma is None else table(sigma, 2, "sigma")
        columns = (("pixels", p), ("view", given), ("sigma", sds), ("labels", labels))
        for what, values in columns:
            if values is not None and len(values) != n:
                raise InputError(f"{what}: {len(values)} given for {counted(n, 'point')}")
        if sds is not None and not ((sds >= SMALLEST_PX) & (sds <= LARGEST_PX)).all():
            raise InputError(f"{source}: sigma must be from {SMALLEST_PX:g} to {LARGEST_PX:g} px")
        order: dict[str, int] = {}
        index = np.array([order.setdefault(name, len(order)) for name in given], dtype=np.intp)
        rows = np.argsort(index, kind="stable")
        target, corner = distinct(w)
        if not sha256:
            digest = hashlib.sha256(repr(tuple(order)).encode())
            for array in (index, w, p, *(() if sds is None else (sds,))):
                digest.update(array.tobytes())
            sha256 = digest.hexdigest()
        found = cls(
            tuple(order),
            fixed(index[rows]),
            frozen(w[rows]),
            frozen(p[rows]),
            target,
            fixed(corner[rows]),
            None if sds is None else frozen(sds[rows]),
            relative_sigma,
            None if labels is None else one_line(tuple(labels[i] for i in rows)),
            image_side(width, "width"),
            image_side(height, "height"),
            source,
            None if lines is None else tuple(lines[i] for i in rows),
            sha256,
            tuple(notes),
        )
        check_views(found)
        return found

    def select(self, views: Sequence[int]) -> Views:
        """Keep some views (from 0), in the order given; the target stays that of all."""
        if not len(views):
            raise InputError(f"{self.source}: no view is selected; name at least one")
        kept = [self.slices[i] for i in views]
        rows = np.concatenate([np.arange(s.start, s.stop) for s in kept])
        view = np.repeat(np.arange(len(kept)), [s.stop - s.start for s in kept])
        return self._taken(rows, view, [self.names[i] for i in views], str(list(views)))

    def without(self, *names: str) -> Views:
        """Leave out views, or points of them, with a note that says so.

        Parameters
        ----------
        *names : str
            A view (``"left05.jpg"``), or one of its points by label, or by its number within
            the view, from 1, where points have no labels (``"left05.jpg:21"``).

        Raises
        ------
        InputError
            Where there is no such view or point, or what is left can't be used.
        """
        if not names:
            return self
        gone = np.unique(np.concatenate([rows_named(self, name) for name in names]))
        rows = np.delete(np.arange(self.n_points), gone)
        if not len(rows):
            raise InputError(f"{self.source}: no point is left; leave out fewer")
        views, view = np.unique(self.view[rows], return_inverse=True)
        found = self._taken(rows, view, [self.names[i] for i in views], f"without {gone.tolist()}")
        note = f"left out as asked ({counted(len(gone), 'point')}): {', '.join(names)}"
        found = replace(found, notes=(*self.notes, note))
        check_views(found)
        return found

    def _taken(self, rows: IntArray, view: IntArray, names: Sequence[str], said: str) -> Views:
        """Take some rows, as views with these names; `said` tells them from others."""
        return replace(
            self,
            names=tuple(names),
            view=fixed(view.astype(np.intp)),
            world=frozen(self.world[rows]),
            pixels=frozen(self.pixels[rows]),
            corner=fixed(self.corner[rows]),
            sigma=None if self.sigma is None else frozen(self.sigma[rows]),
            labels=None if self.labels is None else tuple(self.labels[i] for i in rows),
            lines=None if self.lines is None else tuple(self.lines[i] for i in rows),
            sha256=hashlib.sha256(f"{self.sha256} {said}".encode()).hexdigest(),
        )

    def with_size(self, width: float, height: float) -> Views:
        """State the image size, px, which is checked against the pixels."""
        found = replace(self, width=image_side(width, "width"), height=image_side(height, "height"))
        check_views(found)
        return found

    def __repr__(self) -> str:
        x, y, z = (f"{v:.6g}" for v in self.extent)
        shape = f"planar target {x} by {y}" if self.planar and z == "0" else f"target {x}, {y}, {z}"
        size = f", image {self.width} by {self.height} px" if self.width and self.height else ""
        return (
            f"<Views: {counted(len(self), 'view')}, {counted(self.n_points, 'point')} of a {shape}"
            f"{size}, from {self.source}>"
        )

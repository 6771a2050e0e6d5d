"""What a caller may give for points: correspondences, or whatever `load` takes."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from bayescal.comparison.many import can_reduce, reduce_points
from bayescal.comparison.settings import Settings
from bayescal.comparison.store import Store
from bayescal.points.chunks.many import ManyPoints, many_points
from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import camera_of, load
from bayescal.points.setup import Setup
from bayescal.points.views.views import Views
from bayescal.polynomials.whole import Whole
from bayescal.rounding import grouped

Given: TypeAlias = Correspondences | str | Path | Any
GivenSetup: TypeAlias = Setup | str | Path | None


def reduced(
    given: Given | ManyPoints,
    setup: GivenSetup,
    orders: Mapping[str, tuple[int, ...]],
    settings: Settings,
) -> tuple[Correspondences, dict[str, Whole] | None, ManyPoints | None]:
    """Make correspondences of what a caller gives, or a sample of many and their reduction.

    Then the many points come with it, to be read again.

    Raises
    ------
    InputError
        As `points_of`.
    """
    many = many_of(given, setup)
    if many is None:
        return points_of(given, setup), None, None
    if not can_reduce(many, settings):
        return many.at_once(), None, None
    return (*reduce_points(many, orders, settings), many)


def many_of(given: Given | ManyPoints, setup: GivenSetup) -> ManyPoints | None:
    """Take points as many, under a setup; None where they are few."""
    many = given if isinstance(given, ManyPoints) else many_points(given)
    if many is None or setup is None:
        return many
    return dataclasses.replace(many, setup=camera_of(setup))


def points_of(given: Given, setup: GivenSetup = None) -> Correspondences:
    """Make correspondences of what a caller gives.

    Parameters
    ----------
    given : Correspondences, str, Path, DataFrame or array_like
        As `load` takes it.
    setup : Setup or str or Path, optional
        What is known of the camera; goes before what the points know.

    Raises
    ------
    InputError
        Where no points can be made of it.
    """
    if not isinstance(given, Correspondences):
        return load(given, setup)
    if given.drawn_from is not None:
        drawn = f"these {len(given)} points were drawn from {grouped(given.drawn_from)}"
        given = dataclasses.replace(given, drawn_from=None, notes=(*given.notes, drawn))
    if setup is None:
        return given
    return dataclasses.replace(given, setup=camera_of(setup))


def resumed(
    folder: str | Path | None, of: Correspondences | Views, settings: Settings, request: object
) -> Store | None:
    """Give the store of an analysis that goes on after an interruption; None without a folder."""
    if folder is None:
        return None
    from bayescal.report.run.unfinished import Unfinished

    return Unfinished(Path(folder), of, settings, request)

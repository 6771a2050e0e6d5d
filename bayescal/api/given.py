"""What a caller may give for points: correspondences, or whatever `load` takes."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any, TypeAlias

from bayescal.points.correspondences import Correspondences
from bayescal.points.reader import camera_of, load
from bayescal.points.setup import Setup

Given: TypeAlias = Correspondences | str | Path | Any
GivenSetup: TypeAlias = Setup | str | Path | None


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
    if setup is None:
        return given
    return dataclasses.replace(given, setup=camera_of(setup))

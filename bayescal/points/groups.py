"""Groups of points that share a cause of error."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.points.correspondences import Correspondences


@dataclass(frozen=True, eq=False)
class Groups:
    """Points that share a cause of error.

    Attributes
    ----------
    source : str
        ``"column group"`` or ``"plane z"``.
    names : tuple of str
    members : Array
        1 where a point belongs to a group, ``(n_groups, n_points)``.
    """

    source: str
    names: tuple[str, ...]
    members: Array


def groups_of(points: Correspondences) -> Groups | None:
    """Form the groups of points that share a cause of error; None where they say nothing."""
    source, names = points.causes()
    unique, index = np.unique(np.array(names), return_inverse=True)
    if not 1 < len(unique) < len(points):
        return None
    members = (index == np.arange(len(unique))[:, None]).astype(float)
    return Groups(source, tuple(unique.tolist()), members)

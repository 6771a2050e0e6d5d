"""Points that err together because they share a wrong world coordinate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.comparison.outliers.records import PointRecord
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.pixel_axis import PIXEL_AXES
from bayescal.rounding import significant


@dataclass(frozen=True)
class SharedError:
    """Bad points that share world coordinates and err together.

    Attributes
    ----------
    points : tuple of str
        Labels of the bad points.
    good : tuple of str
        Labels of the other points that share the coordinates, and don't err.
    coordinates : dict of str to float
        The coordinates shared, world units: both that the axis's regressor is made of.
    error : float
        Mean of how far they are off, px.
    spread : float
        Largest distance from that mean, px.
    together : bool
        Whether they err alike: spread within what noise allows, and nobody else is good.
    explained_by : float or None
        Error of the first coordinate that would explain them, world units.
    """

    points: tuple[str, ...]
    good: tuple[str, ...]
    coordinates: dict[str, float]
    error: float
    spread: float
    together: bool
    explained_by: float | None

    @property
    def where(self) -> str:
        """The coordinates shared, in words."""
        return ", ".join(f"{name} = {value:g}" for name, value in self.coordinates.items())

    @property
    def words(self) -> str:
        """What points that err together tell."""
        names = " and ".join([", ".join(self.points[:-1]), self.points[-1]])
        line = (
            f"points {names} share {self.where} and err by the same {significant(self.error)} px "
            f"(to within {significant(self.spread, 1)} px): one wrong world value rather than "
            "several misreadings"
        )
        if self.explained_by is None:
            return line
        name, stated = next(iter(self.coordinates.items()))
        better = significant(stated + self.explained_by, 3)
        return f"{line}; {name} = {better} in place of {stated:g} would explain it"

    def beside(self, label: str) -> str:
        """Say what sharing coordinates tells of one of the points, in a clause; else nothing."""
        if label not in self.points:
            return ""
        if self.good:
            several = len(self.good) > 1
            return (
                f"; {'points' if several else 'point'} {', '.join(self.good[:4])} with the same "
                f"{self.where} {'do' if several else 'does'} not err, so that a misread pixel is "
                "likelier than a wrong world value"
            )
        others = ", ".join(name for name in self.points if name != label)
        return f"; it shares {self.where} with {others}, but they err differently" if others else ""


def shared_errors(
    data: AxisData,
    records: Sequence[PointRecord],
    world: Array,
    slope: Array,
    sigma: Array,
) -> tuple[SharedError, ...]:
    """Tell one wrong world value from several misreadings.

    Points that share both world coordinates of their regressor share an error of these;
    an error of the pixel they don't share.

    Parameters
    ----------
    data : AxisData
        Of the separable family.
    world : Array
        ``(n_points, 3)``, world units.
    slope : Array
        px per world unit of the regressor's first coordinate, at each point, ``(n_points,)``.
    sigma : Array
        Noise level at each point, ``(n_points,)``, px.
    """
    names = PIXEL_AXES[data.axis].across, "z"
    columns = world[:, ["xyz".index(name) for name in names]]
    by_index = {p.index: p for p in records}
    _, cell = np.unique(columns, axis=0, return_inverse=True)
    found = []
    for number in range(int(cell.max()) + 1):
        members = np.flatnonzero(cell.ravel() == number)
        bad = [i for i in members.tolist() if by_index[i].bad]
        if not bad or len(members) < 2:
            continue
        found.append(_shared(by_index, members, bad, names, columns, slope, sigma))
    return tuple(sorted(found, key=lambda s: (-len(s.points), -abs(s.error))))


def _shared(
    by_index: Mapping[int, PointRecord],
    members: IntArray,
    bad: list[int],
    names: tuple[str, str],
    columns: Array,
    slope: Array,
    sigma: Array,
) -> SharedError:
    off = np.array([by_index[i].off for i in bad])
    error = float(off.mean())
    spread = float(np.abs(off - error).max())
    # Distances from the mean scatter by less than sigma; three of these are left to chance.
    alike = len(bad) > 1 and spread < 3 * float(sigma[bad].max())
    good = [i for i in members.tolist() if i not in bad]
    moved = [o / slope[i] for o, i in zip(off, bad, strict=True) if slope[i] != 0]
    return SharedError(
        tuple(by_index[i].label for i in bad),
        tuple(by_index[i].label for i in good),
        {name: float(v) for name, v in zip(names, columns[bad[0]], strict=True)},
        error,
        spread,
        alike and not good,
        float(np.mean(moved)) if len(moved) == len(bad) else None,
    )

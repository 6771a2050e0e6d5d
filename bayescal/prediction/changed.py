r"""Whether two calibrations are of the same camera: how far apart they predict, and by chance.

At K places where both were calibrated, d is the difference of the estimates' predictions, and E
that of draws about them, a draw of the one less a draw of the other. With C the covariance of E the
statistic is d' C^+ d, over as many directions as the model has parameters beside the turn that
poses absorb; its p-value is the share of E whose E' C^+ E is as large.

Estimates are those of maximum likelihood and E is the error that they have by the noise, not what
is left unknown a posteriori: a prior of precision P draws the means of both posteriors towards its
own, and two such means differ by C_1 + C_2 - C_1 P C_2 - C_2 P C_1 alone, C_i the covariances a
posteriori. Measured by C_1 + C_2 a change would be called too seldom. Of one polynomial at a known
noise level this is the chi-squared test of nested models (Chow 1960). No distribution is assumed:
noise levels that are inferred give the tails of Student's t.

The shift that is shown, its size and its bound are of the posteriors. The mean of d'd is that of
the change and tr C, so that tr C is taken off to say how large the change is. Lenses of many views
are compared after the turn of the one frame to the other; cameras with a place in the world as they
stand, their place included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera, check_comparable
from bayescal.prediction.calibrated.hull import within
from bayescal.prediction.calibrated.members import BoolArray, Member
from bayescal.prediction.maps import NAMES, named_pixels
from bayescal.prediction.sights import Sights, image_grid, sights, spread
from bayescal.rounding import significant

TESTED = (9, 7)  # places over what both were calibrated with
SHOWN = (25, 19)  # places over the image that are drawn
PAIRED = 20  # pairings of the draws: p-values to 5e-5
DRAWN = 4  # for the bound
LEAST = 1e-10  # of the largest variance: directions below it are rounding
LEVEL = 0.05


@dataclass(frozen=True, eq=False)
class Change:
    """How two calibrations of a camera differ.

    Attributes
    ----------
    p_value : float
        Probability of so large a difference if nothing changed, 0 where below 1 in 20 000.
    bound : float
        The largest change where both were calibrated, with 95 % probability no more, px.
    rms : float
        Root mean square of the change there, px, what chance adds taken off; 0 where that is all.
    places : Sights
        Of a grid over the image; `inside` is where both were calibrated.
    shape : tuple of int
        Rows and columns of the grid.
    shift : Array
        Prediction of the second less that of the first, ``(n, 2)``, px as recorded; nan where one
        of them sees nothing.
    sd : Array
        Of the shift, root mean square of r and c, ``(n,)``, px.
    named : Change or None
        The same at the places of the image that have names; None where these are they.
    tested : tuple of str
        The model that p is of, as the first and as the second have it: the same one where any is
        plausible by both.
    by_data : bool
        Whether p is of what the data alone say, not of the posteriors.
    posed : bool
        Whether the cameras' places in the world are compared too.
    hull : Array
        Corners of the hull of the first's calibration points, ``(m, 2)``, px.
    """

    p_value: float
    bound: float
    rms: float
    places: Sights
    shape: tuple[int, int]
    shift: Array
    sd: Array
    named: Change | None
    tested: tuple[str, str]
    by_data: bool
    posed: bool
    hull: Array

    def __repr__(self) -> str:
        return (
            f"<Change: p = {self.p_value:.2g}, {self.rms:.2g} px rms, at most {self.bound:.2g} px>"
        )

    @property
    def extrapolated(self) -> BoolArray:
        """Which places one of the two reaches only by going beyond its points, ``(n,)``."""
        return self.places.found & ~self.places.inside

    @property
    def verdict(self) -> str:
        """What is found, in words."""
        chance = "p < 0.0001" if self.p_value < 1e-4 else f"p = {self.p_value:.2g}"
        most = f"{significant(self.bound)} px where both were calibrated (95%)"
        if not self.changed:
            return f"No change is seen ({chance}). If there is one, it is at most {most}."
        about = f"about {significant(self.rms)} px root mean square, and "
        return (
            f"The camera has changed, or one calibration is surer than it should be ({chance}): by "
            f"{about if self.rms else ''}at most {most}."
        )

    @property
    def changed(self) -> bool:
        """Whether no change is excluded at 5 %."""
        return self.p_value < LEVEL

    @property
    def size(self) -> Array:
        """Length of the shift, ``(n,)``, px."""
        return np.asarray(np.hypot(*self.shift.T))


def changed(
    first: CalibratedCamera,
    second: CalibratedCamera,
    *,
    average: bool | None = None,
    seed: int = 0,
) -> Change:
    """Compare two calibrations of one camera; parameters and errors as of `bayescal.changed`."""
    check_comparable(first, second)
    one, two = first.average(average), second.average(average)
    grid = _common(sights(one, _shared_part(first, second)), one, two)
    if grid.inside.sum() < 4:
        raise InputError("the two calibrations have no part of the image in common")
    plain = one, two
    one, two = (_aligned(camera, first, grid) for camera in plain)
    rng = np.random.default_rng(seed)
    at = grid.world[grid.inside]
    test = _test(*plain, grid, rng)
    apart = _Apart.of(one, two, at, rng)
    moved_by = apart.shift + _paired(apart.away, rng, DRAWN)
    lengths = np.linalg.norm(moved_by.reshape(len(moved_by), -1, 2), axis=2)
    bound = float(np.quantile(lengths.max(axis=1), 1 - LEVEL))
    by_chance = sum(float(d.var(axis=0, ddof=1).sum()) for d in apart.away)
    rms = float(np.sqrt(max((apart.shift**2).sum() - by_chance, 0.0) / len(at)))

    def over(places: Sights, shape: tuple[int, int], named: Change | None) -> Change:
        moved, sd = _over(one, two, places, rng)
        return Change(
            test.p_value, bound, rms, places, shape, moved, sd, named, test.names, test.by_data,
            one.posed, first.pixel_hull,
        )  # fmt: skip

    named = _common(sights(first, named_pixels(first)), first, second)
    shown = _common(sights(first, image_grid(first, *SHOWN)), first, second)
    return over(shown, SHOWN[::-1], over(named, (len(NAMES), 1), None))


def _shared_part(first: CalibratedCamera, second: CalibratedCamera) -> Array:
    """Pixels over the part of the image that both were calibrated with, ``(n, 2)``, px."""
    hulls = first.pixel_hull, second.pixel_hull
    low = np.maximum(*(hull.min(axis=0) for hull in hulls))
    high = np.minimum(*(hull.max(axis=0) for hull in hulls))
    return np.empty((0, 2)) if (low > high).any() else spread(low, high, *TESTED)


def _common(places: Sights, first: CalibratedCamera, second: CalibratedCamera) -> Sights:
    """Places of the first, inside where both were calibrated."""
    both = within(second.pixel_hull, places.pixels) & within(first.pixel_hull, places.pixels)
    if second.posed:
        known = np.nan_to_num(places.world)
        both &= np.all([m.covered(known) for m in second.used[0]], axis=0)
    return replace(places, inside=places.inside & both)


def _aligned(
    camera: CalibratedCamera, reference: CalibratedCamera, grid: Sights
) -> CalibratedCamera:
    """Turn every draw of lenses of many views into one frame, by what both were calibrated with."""
    if camera.posed:
        return camera
    rays, pixels = grid.world[grid.inside], grid.pixels[grid.inside]
    members = tuple(member.aligned(rays, pixels) for member in camera.members)
    return replace(camera, members=members, distance=reference.distance)


class _Test(NamedTuple):
    p_value: float
    names: tuple[str, str]
    by_data: bool


def _test(
    one: CalibratedCamera, two: CalibratedCamera, grid: Sights, rng: np.random.Generator
) -> _Test:
    """Test that nothing changed, by a model that both find plausible."""
    models = _common_models(one, two)
    by_data = all(m.estimate is not None for m in models)
    first, second = (
        _aligned(_with(c, m.by_data(rng) if by_data else m), one, grid)
        for c, m in zip((one, two), models, strict=True)
    )
    apart = _Apart.of(first, second, grid.world[grid.inside], rng)
    covariance = sum(np.cov(d.T) for d in apart.away)
    inverse = _inverse(np.asarray(covariance), max(m.n_free for m in models))
    statistic = float(((apart.shift @ inverse) ** 2).sum())
    by_chance = _paired(tuple(d @ inverse for d in apart.away), rng, PAIRED)
    p_value = float(((by_chance**2).sum(axis=1) >= statistic).mean())
    return _Test(p_value, (models[0].name, models[1].name), by_data)


def _with(camera: CalibratedCamera, member: Member) -> CalibratedCamera:
    return replace(camera, members=(member,), probabilities=(1.0,), averaged=False)


def _common_models(one: CalibratedCamera, two: CalibratedCamera) -> tuple[Member, Member]:
    """Give the model that is most probable by both, as each has it; else the chosen ones."""
    (first, p), (second, q) = one.used, two.used
    other = {m.name: (m, share) for m, share in zip(second, q, strict=True)}
    pairs = [
        (share * other[m.name][1], m, other[m.name][0])
        for m, share in zip(first, p, strict=True)
        if m.name in other
    ]
    if not pairs:
        return one.chosen, two.chosen
    return max(pairs, key=lambda pair: pair[0])[1:]


class _Apart(NamedTuple):
    """Mean of the second's predictions less the first's, ``(2 n,)``; draws of both about theirs."""

    shift: Array
    away: tuple[Array, ...]

    @classmethod
    def of(
        cls, one: CalibratedCamera, two: CalibratedCamera, world: Array, rng: np.random.Generator
    ) -> _Apart:
        drawn = [_draws(camera, world, rng) for camera in (one, two)]
        shift = drawn[1].mean(axis=0) - drawn[0].mean(axis=0)
        return cls(shift, tuple(d - d.mean(axis=0) for d in drawn))


def _paired(away: tuple[Array, ...], rng: np.random.Generator, times: int) -> Array:
    """Draws of the second less draws of the first, each paired so many times."""
    return np.concatenate([rng.permutation(away[1]) - away[0] for _ in range(times)])


def _draws(camera: CalibratedCamera, world: Array, rng: np.random.Generator) -> Array:
    """Predictions as recorded by draws of all models, as probable as they are, ``(m, 2 n)``."""
    members, weights = camera.used
    total = len(members[0].parameters.draws)
    counts = rng.multinomial(total, weights)
    pixels = [
        member.project(rng.permutation(member.parameters.draws)[:count], world)[0]
        for member, count in zip(members, counts, strict=True)
    ]
    return camera.recorded(np.concatenate(pixels)).reshape(total, -1)


def _inverse(covariance: Array, rank: int) -> Array:
    """Root of the inverse over its largest directions, ``(2 n, rank)``."""
    size = len(covariance)
    values, vectors = eigh(covariance, subset_by_index=[max(size - rank, 0), size - 1])
    use = values > LEAST * values[-1]
    return np.asarray(vectors[:, use] / np.sqrt(values[use]))


def _over(
    one: CalibratedCamera, two: CalibratedCamera, places: Sights, rng: np.random.Generator
) -> tuple[Array, Array]:
    """Shift ``(n, 2)`` and its sd ``(n,)``, px; nan where one of the two sees nothing."""
    shift, sd = np.full((len(places.pixels), 2), np.nan), np.full(len(places.pixels), np.nan)
    use = places.found & _seen(one, places.world) & _seen(two, places.world)
    if use.any():
        drawn = [_draws(camera, places.world[use], rng) for camera in (one, two)]
        shift[use] = (drawn[1] - drawn[0]).mean(axis=0).reshape(-1, 2)
        variance = sum(d.var(axis=0, ddof=1) for d in drawn)
        sd[use] = np.sqrt(np.asarray(variance).reshape(-1, 2).mean(axis=1))
    return shift, sd


def _seen(camera: CalibratedCamera, world: Array) -> BoolArray:
    """Which points every used model's mean sees, ``(n,)``."""
    known = np.nan_to_num(world)
    every: Sequence[BoolArray] = [
        member.project(member.parameters.mean[None], known)[1][0] for member in camera.used[0]
    ]
    return np.asarray(np.all(every, axis=0))

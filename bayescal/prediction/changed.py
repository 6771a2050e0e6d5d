r"""Whether two calibrations are of the same camera: how far apart they predict, and by chance.

At K places where both were calibrated, d is the difference of the mean predictions, and E that of
draws about their means, a draw of the one less a draw of the other. With C the covariance of E the
statistic is d' C^+ d, over as many directions as the models have parameters beside the turn that
poses absorb; its p-value is the share of E whose E' C^+ E is as large. The mean of d'd is that of
the change and tr C, so that tr C is taken off to say how large the change is. No distribution is
assumed: noise levels that are inferred give the tails of Student's t. Lenses of many views are
compared after the turn of the one frame to the other; cameras with a place in the world as they
stand, their place included.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from bayescal.arrays import Array
from bayescal.errors import InputError
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.hull import within
from bayescal.prediction.calibrated.members import BoolArray
from bayescal.prediction.maps import NAMES, named_pixels
from bayescal.prediction.sights import Sights, image_grid, sights
from bayescal.rounding import significant

TESTED = (9, 7)  # places over the image that are compared
SHOWN = (25, 19)  # and drawn
PAIRED = 20  # pairings of the draws: p-values to 5e-5
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
    posed: bool
    hull: Array

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
        return (
            f"The camera has changed, or one calibration is surer than it should be ({chance}): by "
            f"about {significant(self.rms)} px root mean square, and at most {most}."
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
    _check(first, second)
    one, two = first.average(average), second.average(average)
    grid = _common(sights(one, image_grid(one, *TESTED)), one, two)
    if grid.inside.sum() < 4:
        raise InputError("the two calibrations have no part of the image in common")
    if not one.posed:
        one, two = (_aligned(camera, first, grid) for camera in (one, two))
    rng = np.random.default_rng(seed)
    at = grid.world[grid.inside]
    drawn = [_draws(camera, at, rng) for camera in (one, two)]
    away = [d - d.mean(axis=0) for d in drawn]
    shift = drawn[1].mean(axis=0) - drawn[0].mean(axis=0)
    by_chance = np.concatenate([rng.permutation(away[1]) - away[0] for _ in range(PAIRED)])
    covariance = np.cov(by_chance.T)
    inverse = _inverse(covariance, max(m.n_free for m in (*one.used[0], *two.used[0])))
    statistic = float(((shift @ inverse) ** 2).sum())
    p_value = float((((by_chance @ inverse) ** 2).sum(axis=1) >= statistic).mean())
    lengths = np.linalg.norm((shift + by_chance).reshape(len(by_chance), -1, 2), axis=2)
    bound = float(np.quantile(lengths.max(axis=1), 1 - LEVEL))
    rms = float(np.sqrt(max((shift**2).sum() - np.trace(covariance), 0.0) / len(at)))

    def over(places: Sights, shape: tuple[int, int], named: Change | None) -> Change:
        moved, sd = _over(one, two, places, rng)
        hull = first.pixel_hull
        return Change(p_value, bound, rms, places, shape, moved, sd, named, one.posed, hull)

    named = _common(sights(first, named_pixels(first)), first, second)
    shown = _common(sights(first, image_grid(first, *SHOWN)), first, second)
    return over(shown, SHOWN[::-1], over(named, (len(NAMES), 1), None))


def _check(first: CalibratedCamera, second: CalibratedCamera) -> None:
    for what, a, b in (
        ("images of {} px", _size(first), _size(second)),
        ("c counted from the {}", _end(first), _end(second)),
        ("{}", _kind(first), _kind(second)),
    ):
        if a != b:
            raise InputError(
                f"these are not two calibrations of one camera: {what.format(a)} and "
                f"{what.format(b)}"
            )


def _size(camera: CalibratedCamera) -> str:
    return "unknown size" if camera.size is None else "{:g} by {:g}".format(*camera.size)


def _end(camera: CalibratedCamera) -> str:
    return "bottom" if camera.c_from_bottom else "top"


def _kind(camera: CalibratedCamera) -> str:
    return "a camera in the world" if camera.posed else "a lens of many views"


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
    rays, pixels = grid.world[grid.inside], grid.pixels[grid.inside]
    members = tuple(member.aligned(rays, pixels) for member in camera.members)
    return replace(camera, members=members, distance=reference.distance)


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

r"""Pixels to the world: rays, points at a known depth or on a known plane, with uncertainty.

Monte Carlo propagation as JCGM 101:2008: every draw of the posterior, with a draw of the pixel's
noise and of the depth, is put through the inverse; models count by their probabilities. Beside it
stands the linear propagation (JCGM 100:2008, 5.1.2) by one-sd steps of each input, which also
gives the parts that noise, coefficients, depth and the choice among models have in it. The error
of a depth or plane is one for all pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array, ArrayLike, IntArray
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import KEPT, BoolArray, Member
from bayescal.prediction.given import Surface, checked

BLOCK = 100_000  # draws times pixels at once
PROBABILITY = 0.95
SOURCES = ("noise", "coefficients", "models", "depth")
FEW = 0.95  # share of the draws that must have an inverse, for 95 % of them to be told
MONTE_CARLO = 3 / np.sqrt(2 * KEPT)  # of an sd: three standard errors
APART = 0.05 + MONTE_CARLO  # relative difference from linear propagation that is told


@dataclass(frozen=True, eq=False)
class Location:
    """What pixels look at: points of the world, or directions where no surface is given.

    Attributes
    ----------
    values : Array
        Means, ``(n, 3)``: world units, or unit vectors; nan where there is no solution.
    sd : Array
        By Monte Carlo, ``(n, 3)``.
    linear_sd : Array
        By linear propagation, ``(n, 3)``.
    parts : dict of str to Array
        Of the linear sd: noise, coefficients, models, depth, ``(n, 3)`` each.
    lower, upper : Array
        Central interval by Monte Carlo, ``(n, 3)``; nan where fewer than 95 % of the draws have a
        solution.
    angle : Array
        Sd of the direction about each of two axes, root mean square, ``(n,)``, rad.
    count : Array
        Number of solutions inside the calibrated domain, ``(n,)``.
    share : Array
        Share of the draws that have a solution, ``(n,)``.
    extrapolated : ndarray of bool
        Which solutions lie beyond the calibrated domain or hull, ``(n,)``.
    outside : ndarray of bool
        Which pixels lie outside the image, ``(n,)``.
    surface : Surface or None
    probability : float
    """

    values: Array
    sd: Array
    linear_sd: Array
    parts: dict[str, Array]
    lower: Array
    upper: Array
    angle: Array
    count: IntArray
    share: Array
    extrapolated: BoolArray
    outside: BoolArray
    surface: Surface | None
    probability: float = PROBABILITY

    @property
    def found(self) -> BoolArray:
        """Which pixels have one solution, ``(n,)``."""
        return np.asarray(np.isfinite(self.values).all(axis=1))

    @property
    def nonlinear(self) -> BoolArray:
        """Where the two propagations differ by more than `APART` of the sd, ``(n,)``."""
        with np.errstate(invalid="ignore", divide="ignore"):
            apart = np.abs(self.sd - self.linear_sd) / self.sd.max(axis=1, keepdims=True)
        return np.asarray((apart > APART).any(axis=1))

    def __len__(self) -> int:
        return len(self.values)


def locate(
    camera: CalibratedCamera,
    pixels: ArrayLike,
    *,
    surface: Surface | None = None,
    average: bool | None = None,
    seed: int = 0,
) -> Location:
    """Find what pixels look at, with uncertainty.

    Parameters
    ----------
    camera : CalibratedCamera
    pixels : array_like
        Measured r, c as recorded, ``(n, 2)``, px.
    surface : Surface, optional
        Where the points lie; without it directions are found.
    average : bool, optional
        As in `bayescal.camera`.
    seed : int, optional
        Of the draws of noise and depth.

    Returns
    -------
    Location

    Raises
    ------
    InputError
        Where pixels have another shape, or a number is not finite.
    """
    measured = checked(pixels, 2, "pixels")
    camera = camera.average(average)
    own = camera.recorded(measured)
    step = max(1, BLOCK // len(camera.chosen.parameters.draws))
    starts = range(0, max(len(own), 1), step)
    parts = [_located(camera, own[i : i + step], surface, (seed, i)) for i in starts]
    return _joined(parts, surface)


def _located(
    camera: CalibratedCamera, pixels: Array, surface: Surface | None, seed: tuple[int, int]
) -> Location:
    """Locate pixels ``(n, 2)`` as the models count them."""
    solved = camera.chosen.solutions(pixels)
    drawn, share = monte_carlo(camera, pixels, surface, seed, _themselves)
    mean, sd, lower, upper = summaries(drawn, np.array(camera.used[1]))
    parts, linear = budget(camera, pixels, surface, _themselves)
    usable = (solved.count == 1) & (share > 0.5) & np.isfinite(linear).all(axis=1)
    for array in (mean, sd, lower, upper, linear, *parts.values()):
        array[~usable] = np.nan
    for array in (lower, upper):
        array[share < FEW] = np.nan
    turn = np.sqrt((sd**2).sum(axis=1) / 2) if surface is None else np.full(len(sd), np.nan)
    beyond, outside = usable & ~solved.inside, camera.outside(camera.recorded(pixels))
    return Location(
        mean, sd, linear, parts, lower, upper, turn, solved.count, share, beyond, outside, surface
    )


def _joined(parts: list[Location], surface: Surface | None) -> Location:
    """Put blocks of pixels one after the other."""

    def all_of(name: str) -> Array:
        return np.concatenate([getattr(part, name) for part in parts])

    return Location(
        all_of("values"),
        all_of("sd"),
        all_of("linear_sd"),
        {name: np.concatenate([part.parts[name] for part in parts]) for name in SOURCES},
        all_of("lower"),
        all_of("upper"),
        all_of("angle"),
        np.concatenate([part.count for part in parts]),
        all_of("share"),
        np.concatenate([part.extrapolated for part in parts]),
        np.concatenate([part.outside for part in parts]),
        surface,
    )


def _themselves(points: Array) -> Array:
    return points


Measure = Callable[[Array], Array]  # of points (m, n, 3): quantities (m, q, e)


def monte_carlo(
    camera: CalibratedCamera,
    pixels: Array,
    surface: Surface | None,
    seed: tuple[int, int],
    measure: Measure,
) -> tuple[Array, Array]:
    """Quantities of every model and draw ``(models, draws, q, e)``, nan where none; their share.

    The errors of lens and surface are one for all pixels, and the same whatever the block.
    """
    members, weights = camera.used
    out = []
    for i, member in enumerate(members):
        kept = member.parameters
        depth = np.random.default_rng([seed[0], i]).standard_normal(len(kept.draws))
        noise = member.noise.draw(np.random.default_rng([*seed, i, 1]), len(pixels))
        start = member.solutions(pixels).scaled
        points = _points(member, kept.draws, pixels - noise, start, surface, depth)
        out.append(measure(points))
    drawn = np.stack(out)
    found = np.isfinite(drawn).all(axis=3).mean(axis=1)
    return drawn, np.asarray(np.array(weights) @ found)


def _points(
    member: Member,
    theta: Array,
    pixels: Array,
    start: Array | None,
    surface: Surface | None,
    depth: Array,
) -> Array:
    """Points, or directions, of pixels at parameters ``(m, n, 3)``; nan where there are none."""
    found = member.rays(theta, pixels, start)
    direction, ok = found.direction, found.found
    if surface is None:
        return np.where(ok[..., None], direction, np.nan)
    normal = np.array(surface.normal)
    away = surface.offset + surface.sd * depth - found.origin @ normal
    with np.errstate(divide="ignore", invalid="ignore"):
        length = away[:, None] / (direction @ normal)
    ahead = ok & (length > 0) & np.isfinite(length)
    points = found.origin[:, None] + np.where(ahead, length, 0.0)[..., None] * direction
    return np.where(ahead[..., None], points, np.nan)


def summaries(drawn: Array, weights: Array) -> tuple[Array, Array, Array, Array]:
    """Mean, sd and interval of weighted draws ``(models, draws, q, e)``, ``(q, e)`` each."""
    flat = drawn.reshape(-1, *drawn.shape[2:])
    each = np.repeat(weights / drawn.shape[1], drawn.shape[1])[:, None, None]
    known = np.isfinite(flat)
    share = np.where(known, each, 0.0)
    share = share / np.maximum(share.sum(axis=0), 1e-300)
    values = np.where(known, flat, 0.0)
    mean = (share * values).sum(axis=0)
    sd = np.sqrt((share * (values - mean) ** 2).sum(axis=0))
    tail = (1 - PROBABILITY) / 2
    lower, upper = (weighted_quantile(values, share, p) for p in (tail, 1 - tail))
    none = ~known.any(axis=0)
    for array in (mean, sd, lower, upper):
        array[none] = np.nan
    return mean, sd, lower, upper


def weighted_quantile(values: Array, share: Array, probability: float) -> Array:
    """Quantile along the first axis of values with weights that sum to 1 there."""
    order = np.argsort(np.where(share > 0, values, np.inf), axis=0)
    below = np.cumsum(np.take_along_axis(share, order, axis=0), axis=0)
    first = np.argmax(below >= probability, axis=0)[None]
    found = np.take_along_axis(values, np.take_along_axis(order, first, axis=0), axis=0)
    return np.asarray(found[0])


def budget(
    camera: CalibratedCamera, pixels: Array, surface: Surface | None, measure: Measure
) -> tuple[dict[str, Array], Array]:
    """Parts of the linear sd by source, and the sd, ``(q, e)`` each."""
    members, weights = camera.used
    alone = [_spread(member, pixels, surface, measure) for member in members]
    share = np.array(weights)[:, None, None]
    centres = np.stack([centre for centre, _ in alone])
    within = {
        name: (share * np.stack([spread[name] for _, spread in alone])).sum(axis=0)
        for name in SOURCES
        if name != "models"
    }
    within["models"] = (share * (centres - (share * centres).sum(axis=0)) ** 2).sum(axis=0)
    parts = {name: np.sqrt(within[name]) for name in SOURCES}
    return parts, np.sqrt(np.stack(list(within.values())).sum(axis=0))


def _spread(
    member: Member, pixels: Array, surface: Surface | None, measure: Measure
) -> tuple[Array, dict[str, Array]]:
    """Quantities of a model's mean ``(q, e)``, and their variance by source."""
    kept, start = member.parameters, member.solutions(pixels).scaled
    mean = kept.mean[None]

    def at(theta: Array, moved: Array, depth: float = 0.0) -> Array:
        shift = np.full(len(theta), depth)
        return measure(_points(member, theta, moved[None], start, surface, shift))

    steps = at(kept.steps, pixels)
    d = (len(kept.steps) - 1) // 2
    spread = {"coefficients": (((steps[1 : 1 + d] - steps[1 + d :]) / 2) ** 2).sum(axis=0)}
    spread["noise"] = np.zeros_like(steps[0])
    for own in _groups(steps.shape[1], len(pixels)):
        for axis in (0, 1):
            step = np.zeros_like(pixels)
            step[own, axis] = member.noise.scale[axis]
            spread["noise"] += ((at(mean, pixels + step) - at(mean, pixels - step))[0] / 2) ** 2
    spread["depth"] = ((at(mean, pixels, 1.0) - at(mean, pixels, -1.0))[0] / 2) ** 2
    return steps[0], spread


def _groups(quantities: int, pixels: int) -> list[slice]:
    """Pixels that can be moved at once: no quantity depends on two of a group."""
    return [slice(i * quantities, (i + 1) * quantities) for i in range(pixels // quantities)]

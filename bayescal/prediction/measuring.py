"""Quantities measured of what pixels look at, with their uncertainty.

Monte Carlo propagation as JCGM 101:2008: every draw of the posterior, with a draw of the pixel's
noise and of the depth, is put through the inverse; models count by their probabilities. Beside it
stands the linear propagation (JCGM 100:2008, 5.1.2) by one-sd steps of each input, which also
gives the parts that noise, coefficients, depth and the choice among models have in it. The error
of a depth or plane is one for all pixels.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.special import ndtri

from bayescal.arrays import Array
from bayescal.prediction.calibrated.camera import CalibratedCamera
from bayescal.prediction.calibrated.members import Member
from bayescal.prediction.given import Surface

BLOCK = 100_000  # draws times pixels at once
PROBABILITY = 0.95
SOURCES = ("noise", "coefficients", "models", "depth")
FEW = 0.95  # share of the draws that must have an inverse, for 95 % of them to be told

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
        depth = _normal(np.random.default_rng([seed[0], i]), len(kept.draws))
        noise = member.noise.draw(np.random.default_rng([*seed, i, 1]), len(pixels))
        start = member.solutions(pixels).scaled
        points = _points(member, kept.draws, pixels - noise, start, surface, depth)
        out.append(measure(points))
    drawn = np.stack(out)
    found = np.isfinite(drawn).all(axis=3).mean(axis=1)
    return drawn, np.asarray(np.array(weights) @ found)


def _normal(rng: np.random.Generator, n: int) -> Array:
    """Draw a normal by its quantiles, in any order, ``(n,)``.

    One error for all pixels does not average out among them: drawn freely, the mean of every
    point would lie a standard error off the stated depth.
    """
    return np.asarray(ndtri((rng.permutation(n) + 0.5) / n))


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

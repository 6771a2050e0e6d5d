"""Which cameras are odd: their parameters and models against the fleet's spread."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtrit

from bayescal.arrays import Array
from bayescal.fleets.record import LENS, Choice, Estimate, Record
from bayescal.rounding import percent, rounded, significant

# Chance that anything at all is called odd in a fleet without odd cameras: half of it for scores,
# half for models.
LEVEL = 0.05
FEWEST = 8  # cameras that have a spread
# Values further from the median than so many median absolute deviations have no weight.
REACH = 9.0
# Degrees of freedom of the scale per camera, so that LEVEL holds from 8 cameras on (by simulation).
FREEDOM = 0.5
SIGMA = "sigma"
PIXELS = (SIGMA, "alpha", "beta", "fx", "fy", "cx", "cy")  # what is in px
FAR = 40.0  # a score beyond which only that is said


@dataclass(frozen=True, eq=False)
class Spread:
    """One quantity over the fleet.

    Attributes
    ----------
    of, name : str
        Such as ``"r"`` and ``"alpha_1"``.
    cameras : tuple of str
        Those that have it.
    values, sds : Array
        Of each camera and its standard deviation (NaN where not known), ``(n,)``.
    median : float
    scale : float or None
        Standard deviation over the fleet that odd cameras do not widen; None of fewer than eight
        cameras, and where more than half of them agree.
    scores : Array
        Distance of each camera from the median in standard deviations, ``(n,)``: the fleet's
        and, where its own is larger than is usual, what that adds. NaN without a scale.
    """

    of: str
    name: str
    cameras: tuple[str, ...]
    values: Array
    sds: Array
    median: float
    scale: float | None
    scores: Array


@dataclass(frozen=True)
class Oddity:
    """Why a camera is odd.

    Attributes
    ----------
    camera, of, name : str
        Name: of the quantity, or ``"model"``.
    score : float
        Standard deviations; of a model those of a normal tail as improbable as the fleet's.
    text : str
        In words.
    """

    camera: str
    of: str
    name: str
    score: float
    text: str


def common_model(choices: Sequence[Choice]) -> str:
    """Model recommended most often; of several the first by name."""
    counts = Counter(choice.model for choice in choices)
    return min(counts, key=lambda model: (-counts[model], model))


def choices_of(records: Mapping[str, Record]) -> dict[str, dict[str, Choice]]:
    """Choices by what they are of and by camera."""
    found: dict[str, dict[str, Choice]] = {}
    for camera, record in records.items():
        for choice in record.choices:
            found.setdefault(choice.of, {})[camera] = choice
    return found


def spreads(records: Mapping[str, Record]) -> tuple[Spread, ...]:
    """Spread of sigma, and of the parameters of the model that the fleet has in common."""
    out = []
    for of, choices in choices_of(records).items():
        model = common_model(list(choices.values()))
        out.append(_spread(of, SIGMA, {c: choice.sigma for c, choice in choices.items()}))
        named: dict[str, dict[str, Estimate]] = {}
        for camera, choice in choices.items():
            for name, estimate in choice.parameters.get(model, {}).items():
                named.setdefault(name, {})[camera] = estimate
        out += [_spread(of, name, estimates) for name, estimates in named.items()]
    return tuple(out)


def _spread(of: str, name: str, estimates: Mapping[str, Estimate]) -> Spread:
    values = np.array([e.value for e in estimates.values()])
    sds = np.array([math.nan if e.sd is None else e.sd for e in estimates.values()])
    # A scale parameter spreads by factors.
    by_factors = name == SIGMA and bool((values > 0).all())
    x, own = (np.log(values), sds / values) if by_factors else (values, sds)
    middle = float(np.median(x))
    scale = biweight_scale(x)
    known = own[np.isfinite(own)]
    extra = own**2 - np.median(known) ** 2 if len(known) else np.zeros_like(x)
    wider = np.where(np.isfinite(extra), np.maximum(extra, 0.0), 0.0)
    scores = np.full(len(x), math.nan)
    if scale is not None:
        scores = (x - middle) / np.sqrt(scale**2 + wider)
    median = math.exp(middle) if by_factors else middle
    if scale is not None and by_factors:
        scale *= median
    return Spread(of, name, tuple(estimates), values, sds, median, scale, scores)


def biweight_scale(x: Array) -> float | None:
    """Measure the spread of most of some numbers, ``(n,)``, as an sd; None where there is none.

    The square root of the biweight midvariance (Beers, Flynn & Gebhardt 1990, Astron. J. 100, 32,
    eq. 9).
    """
    distance = x - np.median(x)
    mad = float(np.median(np.abs(distance)))
    if len(x) < FEWEST or not mad > 0:
        return None
    u = (distance / (REACH * mad)) ** 2
    inside, d, u = u < 1, distance[u < 1], u[u < 1]
    above = len(inside) * np.sum(d**2 * (1 - u) ** 4)
    return float(np.sqrt(above) / abs(np.sum((1 - u) * (1 - 5 * u))))


def score_limit(found: Sequence[Spread]) -> float:
    """Score beyond which a camera is odd: of all scores of a normal fleet one is with LEVEL / 2.

    Student's t, since the fleet's scale is itself estimated; Bonferroni over all scores.
    """
    count = sum(len(s.values) for s in found if s.scale is not None)
    if not count:
        return math.inf
    fewest = min(len(s.values) for s in found if s.scale is not None)
    return -float(stdtrit(FREEDOM * (fewest - 1), LEVEL / 2 / (2 * count)))


def oddities(records: Mapping[str, Record], found: Sequence[Spread]) -> tuple[Oddity, ...]:
    """Say which cameras are odd and why, the oddest first."""
    limit, out = score_limit(found), []
    level = LEVEL / 2 / max(sum(len(record.choices) for record in records.values()), 1)
    for spread in found:
        for i in np.flatnonzero(np.abs(spread.scores) > limit):
            out.append(_far(spread, int(i)))
    for choices in choices_of(records).values():
        common = common_model(list(choices.values()))
        out += [
            odd
            for camera, choice in choices.items()
            if (odd := _excluded(camera, choice, common, level)) is not None
        ]
    return tuple(sorted(out, key=lambda odd: (-odd.score, odd.camera, odd.of, odd.name)))


def unit_of(name: str) -> str:
    """Give the unit of a quantity, after a blank; nothing where it has none."""
    return " px" if name.partition("_")[0] in PIXELS else ""


def _far(spread: Spread, i: int) -> Oddity:
    value, score, scale = spread.values[i], abs(float(spread.scores[i])), spread.scale or 0.0
    what, unit = f"{spread.of}: {spread.name} {rounded(float(value), scale)}", unit_of(spread.name)
    text = f"{what}{unit}, the fleet {rounded(spread.median, scale)}{unit}"
    text += f" with sd {significant(scale)}{unit}"
    return Oddity(spread.cameras[i], spread.of, spread.name, score, text)


def _excluded(camera: str, choice: Choice, common: str, level: float) -> Oddity | None:
    """Say that a camera can't have the fleet's model; None where it may."""
    if not choice.probability or choice.model == common:
        return None
    chance = choice.probability.get(common, 0.0)
    if chance >= level:
        return None
    score = min(-float(ndtri(max(chance, 1e-300) / 2)), FAR)
    kind = "" if choice.of == LENS else "order "
    text = f"{choice.of}: {kind}{choice.model}; {kind}{common}, the fleet's, has {percent(chance)}"
    return Oddity(camera, choice.of, "model", score, text)

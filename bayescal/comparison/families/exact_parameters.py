"""Parameters of joint models in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

from scipy.linalg import block_diag

from bayescal.arrays import Array
from bayescal.inference.posterior import INTERVAL_PROBABILITY
from bayescal.linear.closed_form import ExactPosterior
from bayescal.points.setup import AXES


@dataclass(frozen=True)
class ExactParameter:
    """A parameter of which the closed form knows all.

    Attributes
    ----------
    name : str
        As of the sampled models: ``alpha_1``, ``sigma_r``.
    interval : tuple of float
        Central, of probability 0.95.
    """

    axis: str
    name: str
    mean: float
    sd: float
    interval: tuple[float, float]


def exact_parameters(exact: Sequence[ExactPosterior]) -> list[ExactParameter]:
    """Coefficients and noise of both axes; nothing where there is no closed form."""
    pairs = zip(AXES, exact, strict=False)
    return [p for axis, posterior in pairs for p in _of_axis(axis, posterior)]


def exact_covariance(exact: Sequence[ExactPosterior]) -> tuple[tuple[str, ...], Array]:
    """Names and covariance of the coefficients of both axes."""
    roots = [found.model.factors.monomials.apply(found.root) for found in exact]
    names = [n for found in exact for n in found.model.names[: found.model.size]]
    return tuple(names), block_diag(*(root @ root.T for root in roots))


@lru_cache(maxsize=64)  # pairs of orders share their axes, and intervals take a while
def _of_axis(axis: str, posterior: ExactPosterior) -> tuple[ExactParameter, ...]:
    out = []
    numbers = zip(*posterior.summary, posterior.intervals(INTERVAL_PROBABILITY), strict=True)
    for name, (mean, sd, (low, high)) in zip(posterior.model.names, numbers, strict=True):
        own = name.split("_")[0] == posterior.model.symbol
        named, interval = name if own else f"{name}_{axis}", (float(low), float(high))
        out.append(ExactParameter(axis, named, float(mean), float(sd), interval))
    return tuple(out)

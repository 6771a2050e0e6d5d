"""Where to look for modes among many points, and how wide a likelihood is that is costly to have.

Both only shape a proposal. What is sampled and weighed is the likelihood of all points, so that
nothing here moves a posterior or an evidence.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.inference.optimum import LogDensity, Mode, differences, find_modes

# Of more points than this modes are looked for in a random sample, and climbed from there.
MANY = 20_000


class Sampled(Protocol):
    """A density of points, of which some may be taken."""

    @property
    def t(self) -> Array:
        """Pixels, ``(n_points,)``."""
        ...

    def taken(self, part: IntArray) -> Sampled:
        """Give that of some of the points."""
        ...

    def log_prob(self, theta: Array) -> Array:
        """Log density, ``(n_draws,)``."""
        ...

    def starts(self) -> Array:
        """Places to search for modes from."""
        ...


def starts_of_sample(model: Sampled) -> Array:
    """Modes of a random sample of the points, ``(n_modes, dimension)``: near those of all."""
    kept = np.sort(np.random.default_rng(0).permutation(len(model.t))[:MANY])
    sample = model.taken(kept)
    return np.array([mode.theta for mode in find_modes(sample.log_prob, sample.starts())])


def parabola(log_likelihood: LogDensity, mode: Mode) -> Callable[[Array], Array]:
    """Second order of a log likelihood about a mode, by steps of its deviations."""
    step = np.sqrt((mode.root**2).sum(axis=1))
    centre, up, down, mixed = differences(log_likelihood, mode.theta, np.diag(step))
    slope = (up - down) / 2
    second = np.diag(up + down - 2 * centre)
    i, j = np.triu_indices(len(step), 1)
    second[i, j] = second[j, i] = -mixed

    def value(theta: Array) -> Array:
        u = (theta - mode.theta) / step
        return np.asarray(centre + u @ slope + ((u @ second) * u).sum(axis=1) / 2)

    return value

"""The noise of a new measurement: its posterior, and the shape it gives to predictions.

A new pixel is its place in the image plus noise whose level, and shape where it is robust, are
known by draws. Averaged over them, with both in units of a scale, the noise has one distribution
function F, kept on a grid. A prediction of centre m and epistemic deviation s is then taken as
m + sqrt(scale^2 + s^2) z with z distributed as F: exact where the coefficients' variance is
proportional to sigma^2 (under a flat prior F is Student's t), and a convolution of two nearly
normal parts elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtr

from bayescal.arrays import Array

GRID = np.linspace(-12.0, 12.0, 961)  # scales; beyond it F is 0 or 1
ONE_SIGMA = 0.6826894921370859  # probability within one sd of a normal
SIMULATED = 400  # residuals for each draw of a robust noise
STEPS = 60  # the most; a few suffice
PRECISION = 1e-7  # of the largest scale


@dataclass(frozen=True, eq=False)
class NewNoise:
    """Noise of a new measurement of r and c.

    Attributes
    ----------
    log_sigma : Array
        Draws of ln sigma, ``(n_draws, 2)``, px.
    eta : Array
        Draws of the noise model's own coordinates, ``(n_draws, 2, dimension)``.
    name : str
        Of the noise model.
    nu : float or None
        Degrees of freedom of Student-t noise, where they are fixed.
    bad_offset : bool
        Whether bad points have an offset.
    neighbours : Array or None
        Of a picture of a target whose neighbours share noise, draws of: sd of a point's own, sd
        of the shared (px), its correlation length (world units), ``(n_draws, 3)``; covariance is
        own^2 I + shared^2 exp(-d / length), d the distance on the target.
    """

    log_sigma: Array
    eta: Array
    name: str = "gaussian"
    nu: float | None = None
    bad_offset: bool = False
    neighbours: Array | None = None

    @property
    def gaussian(self) -> bool:
        """Whether the noise is Gaussian given its level."""
        return self.name == "gaussian"

    def draw(self, rng: np.random.Generator, n: int) -> Array:
        """Simulate residuals of `n` points at every draw, ``(n_draws, n, 2)``, px."""
        if self.gaussian:
            shape = (len(self.log_sigma), n, 2)
            return np.exp(self.log_sigma)[:, None, :] * rng.standard_normal(shape)
        from bayescal.noise.choice import NoiseChoice

        model = NoiseChoice(self.name, self.nu, self.bad_offset).model(1.0)
        axes = (model.draw(rng, self.log_sigma[:, i], self.eta[:, i], np.ones(n)) for i in (0, 1))
        return np.stack(list(axes), axis=2)

    @cached_property
    def scale(self) -> Array:
        """Sd of the noise of r and c, px; of robust noise half its central 68.3 %, ``(2,)``."""
        if self.gaussian:
            return np.sqrt(np.exp(2 * self.log_sigma).mean(axis=0))
        ends = np.quantile(self._simulated, [(1 - ONE_SIGMA) / 2, (1 + ONE_SIGMA) / 2], axis=0)
        return np.asarray((ends[1] - ends[0]) / 2)

    @cached_property
    def _simulated(self) -> Array:
        """Residuals of robust noise, ``(n, 2)``, px: always the same ones."""
        return self.draw(np.random.default_rng(0), SIMULATED).reshape(-1, 2)

    @cached_property
    def distribution(self) -> Array:
        """F on `GRID`, of r and of c, ``(2, n_grid)``."""
        if self.gaussian:
            ratio = np.exp(-self.log_sigma) * self.scale
            return np.stack([ndtr(GRID[:, None] * ratio[:, i]).mean(axis=1) for i in (0, 1)])
        drawn = np.sort(self._simulated / self.scale, axis=0)
        below = [np.searchsorted(drawn[:, i], GRID) / len(drawn) for i in (0, 1)]
        return np.stack(below)


def mixture_quantiles(
    distributions: Array, centres: Array, scales: Array, weights: Array, probability: float
) -> Array:
    """Quantile of a mixture of scaled distributions at every point, ``(n,)``.

    Parameters
    ----------
    distributions : Array
        F of each member on `GRID`, ``(m, n_grid)``.
    centres, scales : Array
        ``(m, n)``, px.
    weights : Array
        ``(m,)``.
    """
    own = np.array([np.interp(probability, f, GRID) for f in distributions])
    each = centres + scales * own[:, None]
    if len(each) == 1:
        return np.asarray(each[0])
    return _root(
        lambda at: _below(distributions, centres, scales, weights, at) - probability,
        each.min(axis=0),
        each.max(axis=0),
        PRECISION * float(scales.max()),
    )


def _below(distributions: Array, centres: Array, scales: Array, weights: Array, at: Array) -> Array:
    """Probability below values ``(n,)`` of a mixture."""
    total = np.zeros_like(at)
    for f, w, centre, scale in zip(distributions, weights, centres, scales, strict=True):
        total += w * np.interp((at - centre) / scale, GRID, f, left=0.0, right=1.0)
    return total


def _root(f: Callable[[Array], Array], low: Array, high: Array, precision: float) -> Array:
    """Zeros of growing functions in brackets, ``(n,)``: regula falsi as modified in Illinois."""
    low, high = low.copy(), high.copy()
    at_low, at_high = f(low), f(high)
    last = np.zeros(len(low))
    middle = (low + high) / 2
    for _ in range(STEPS):
        rise = at_high - at_low
        share = np.where(rise > 0, -at_low / np.where(rise > 0, rise, 1.0), 0.5)
        new = low + np.clip(share, 0.0, 1.0) * (high - low)
        moved, middle = np.abs(new - middle), new
        if (np.minimum(moved, high - low) <= precision).all():
            break
        value = f(middle)
        below = value < 0
        low, high = np.where(below, middle, low), np.where(below, high, middle)
        # The end that stays twice running counts half, lest the other creep.
        at_high = np.where(below, np.where(last > 0, at_high / 2, at_high), value)
        at_low = np.where(below, value, np.where(last < 0, at_low / 2, at_low))
        last = np.where(below, 1.0, -1.0)
    return middle

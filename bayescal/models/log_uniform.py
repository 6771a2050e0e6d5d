r"""A scale whose logarithm is uniform between bounds, integrated out in closed form.

sigma of normal residuals, or the strength tau of normal amplitudes, enters a density as
s^-m exp(-q / (2 s^2)): m terms whose squares sum to q. With ln s uniform on [ln a, ln b]

    int s^-m exp(-q / (2 s^2)) d ln s = 1/2 (q/2)^(-m/2) Gamma(m/2) [P(x_a) - P(x_b)],

x_s = q / (2 s^2) and P the regularised incomplete gamma function of m/2; and x, given q,
is a Gamma(m/2) variable between x_b and x_a, from which s is drawn afterwards. What was
integrated out leaves no funnel to sample.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import gammainc, gammaincc, gammainccinv, gammaincinv, gammaln

from bayescal.arrays import Array

# A sum of squares below this fraction of the lower bound's square is as good as none.
TINY = 1e-30


@dataclass(frozen=True)
class LogUniform:
    """A positive scale s, ln s uniform between bounds.

    Attributes
    ----------
    lower, upper : float
        Bounds of s, in its own unit.
    """

    lower: float
    upper: float

    @property
    def log_density(self) -> float:
        """Log density of ln s inside the bounds."""
        return -math.log(math.log(self.upper / self.lower))

    def log_integral(self, q: Array, m: int) -> Array:
        """Log of s^-m exp(-q / (2 s^2)) averaged over the prior.

        Parameters
        ----------
        q : Array
            Sums of squares, ``(n,)``, in the square of s's unit.
        m : int
            How many squares, at least 1.

        Returns
        -------
        Array
            ``(n,)``; with the 2 pi of normal densities still to come.
        """
        q = np.maximum(q, TINY * self.lower**2)
        a, low, high = m / 2, q / (2 * self.upper**2), q / (2 * self.lower**2)
        # The difference of whichever tails are small keeps its digits.
        tail = low > a
        with np.errstate(divide="ignore"):
            between = np.log(
                np.where(
                    tail,
                    gammaincc(a, low) - gammaincc(a, high),
                    gammainc(a, high) - gammainc(a, low),
                )
            )
        out = self.log_density - math.log(2) - a * np.log(q / 2) + gammaln(a) + between
        lost = ~np.isfinite(between)  # below every double: the mass is all at one bound
        return np.asarray(np.where(lost, self._at_bound(q, m), out))

    def _at_bound(self, q: Array, m: int) -> Array:
        """Leading term where q is far from what any s in the bounds makes (Watson's lemma)."""
        nearest = np.where(q > m * self.upper**2, self.upper, self.lower)
        slope = np.maximum(np.abs(q / nearest**2 - m), 1.0)
        log_peak = -m * np.log(nearest) - q / (2 * nearest**2)
        return np.asarray(self.log_density + log_peak - np.log(slope))

    def draw(self, rng: np.random.Generator, q: Array, m: int) -> Array:
        """Draw s given sums of squares ``(n,)`` of m terms each; ``(n,)``."""
        q = np.maximum(q, TINY * self.lower**2)
        a, low, high = m / 2, q / (2 * self.upper**2), q / (2 * self.lower**2)
        u = rng.random(len(q))
        below = gammaincinv(a, _between(u, gammainc(a, low), gammainc(a, high)))
        above = gammainccinv(a, _between(u, gammaincc(a, low), gammaincc(a, high)))
        x = np.clip(np.where(low > a, above, below), low, high)
        return np.asarray(np.clip(np.sqrt(q / (2 * x)), self.lower, self.upper))


def _between(u: Array, start: Array, end: Array) -> Array:
    return np.asarray(start + u * (end - start))

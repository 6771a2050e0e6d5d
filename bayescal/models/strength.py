r"""The strength tau of normal amplitudes, integrated out in closed form.

With m amplitudes b_j ~ N(m_j, (tau s_j)^2), q = sum_j ((b_j - m_j) / s_j)^2 and tau
log-uniform on [lo, hi], the substitution v = q / (2 tau^2) gives

    int prod_j N(b_j) d ln tau / ln(hi / lo)
        = (2 pi)^{-m/2} prod_j s_j^{-1} (2 / q)^{m/2} Gamma(m/2)
          [P(m/2, v_lo) - P(m/2, v_hi)] / (2 ln(hi / lo)),

P the regularised incomplete gamma function (DLMF 8.2.4), v_lo = q / (2 lo^2) and
v_hi = q / (2 hi^2). Given the amplitudes v is Gamma(m/2), truncated to [v_hi, v_lo].
Sampling the amplitudes alone spares the sampler the funnel of tau and amplitudes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.special import gammainc, gammaincc, gammainccinv, gammaincinv, gammaln

from bayescal.arrays import Array

LOG_2PI = math.log(2 * math.pi)
# Below it the integrand does not depend on q any more (and q = 0 would be 0 / 0).
SMALLEST = 1e-30
# Beyond it the upper incomplete gamma function comes from its asymptotic series, before
# it underflows.
LARGE = 500.0
TERMS = 20


@dataclass(frozen=True)
class Strength:
    """A tau, log-uniform between bounds, common to normal amplitudes.

    Attributes
    ----------
    log_bounds : tuple of float
        Bounds of ln tau.
    size : int
        Number of amplitudes m.
    """

    log_bounds: tuple[float, float]
    size: int

    def _limits(self, q: Array) -> tuple[Array, Array, Array]:
        """Clip q, and give v at the upper and at the lower bound of tau."""
        q = np.maximum(q, SMALLEST)
        lower, upper = self.log_bounds
        return q, q / 2 * math.exp(-2 * upper), q / 2 * math.exp(-2 * lower)

    def log_density(self, q: Array) -> Array:
        """Log density of the amplitudes, tau integrated out, but for prod_j 1 / s_j.

        Parameters
        ----------
        q : Array
            Sum of squared amplitudes in units of s_j, ``(n,)``.

        Returns
        -------
        Array
            ``(n,)``.
        """
        a = self.size / 2
        q, first, last = self._limits(q)
        lower, upper = self.log_bounds
        mass = np.empty(len(q))
        near = first <= a
        mass[near] = np.log(gammainc(a, last[near]) - gammainc(a, first[near]))
        mass[~near] = _log_upper(a, first[~near])
        far = ~near & (first < LARGE)
        mass[far] += np.log1p(-gammaincc(a, last[far]) / gammaincc(a, first[far]))
        constant = -a * LOG_2PI + a * math.log(2) + float(gammaln(a))
        return np.asarray(constant - math.log(2 * (upper - lower)) - a * np.log(q) + mass)

    def draw(self, q: Array, rng: np.random.Generator) -> Array:
        """Draw ln tau given the amplitudes, ``(n,)``.

        Parameters
        ----------
        q : Array
            As in `log_density`.
        rng : numpy.random.Generator
        """
        a = self.size / 2
        q, first, last = self._limits(q)
        u = rng.random(len(q))
        v = first + rng.standard_exponential(len(q))  # where nothing else is resolved
        near = first <= a
        low, high = gammainc(a, first[near]), gammainc(a, last[near])
        v[near] = gammaincinv(a, low + u[near] * (high - low))
        far = ~near & (first < LARGE)
        low, high = gammaincc(a, first[far]), gammaincc(a, last[far])
        v[far] = gammainccinv(a, low + u[far] * (high - low))
        return np.asarray(np.clip(np.log(q / 2 / np.clip(v, first, last)) / 2, *self.log_bounds))


def _log_upper(a: float, v: Array) -> Array:
    """Log of the regularised upper incomplete gamma function, v above a."""
    out = np.empty(len(v))
    small = v < LARGE
    out[small] = np.log(gammaincc(a, v[small]))
    large = v[~small]
    # DLMF 8.11.2: Gamma(a, v) ~ v^(a - 1) exp(-v) sum_k (a - 1) ... (a - k) / v^k.
    term, total = np.ones(len(large)), np.ones(len(large))
    for k in range(1, TERMS):
        term = term * (a - k) / large
        total += term
    out[~small] = (a - 1) * np.log(large) - large + np.log(total) - float(gammaln(a))
    return out

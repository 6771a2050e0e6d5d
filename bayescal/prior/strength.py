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

from bayescal.arrays import LOG_2PI, Array

# Below it the integrand does not depend on q any more (and q = 0 would be 0 / 0).
SMALLEST = 1e-30
# Below it an incomplete gamma function comes from a series, before it underflows: many
# residuals that a model fits far below the lowest sigma get there.
TINY = 1e-290
TERMS, ROUNDED = 60, 1e-17
NEGLIGIBLE = 40.0  # nat: what is so far below another adds nothing to it


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
        near = first <= a  # differences of the smaller tail keep their digits
        more, less = np.empty(len(q)), np.empty(len(q))
        more[near] = _log_lower(a, last[near])
        # P(a, v) <= v^a / Gamma(a + 1): far below the other tail it need not be known.
        most = a * np.log(first[near]) - float(gammaln(a + 1))
        some = near.copy()
        some[near] = most > more[near] - NEGLIGIBLE
        less[near], less[some] = -np.inf, _log_lower(a, first[some])
        more[~near], less[~near] = _log_upper(a, first[~near]), _log_upper(a, last[~near])
        mass = more + np.log1p(-np.exp(less - more))
        constant = -a * LOG_2PI + a * math.log(2) + float(gammaln(a))
        return np.asarray(constant - math.log(2 * (upper - lower)) - a * np.log(q) + mass)

    def draw(self, q: Array, rng: np.random.Generator) -> Array:
        """Draw ln tau given the amplitudes, ``(n,)``.

        Parameters
        ----------
        q : Array
            As in `log_density`.
        """
        a = self.size / 2
        q, first, last = self._limits(q)
        u = rng.random(len(q))
        v = np.empty(len(q))
        near = first <= a
        low, high = gammainc(a, first[near]), gammainc(a, last[near])
        v[near] = gammaincinv(a, low + u[near] * (high - low))
        low, high = gammaincc(a, first[~near]), gammaincc(a, last[~near])
        v[~near] = gammainccinv(a, low + u[~near] * (high - low))
        # So far in a tail v keeps to its end, and its density is a power or exponential there.
        at = np.flatnonzero(near)[gammainc(a, last[near]) < TINY]
        v[at] = last[at] * u[at] ** (1 / (a - last[at]))
        at = np.flatnonzero(~near)[low < TINY]
        v[at] = first[at] - np.log1p(-u[at]) / (1 - (a - 1) / first[at])
        return np.asarray(np.clip(np.log(q / 2 / np.clip(v, first, last)) / 2, *self.log_bounds))


def _log_lower(a: float, v: Array) -> Array:
    """Log of the regularised lower incomplete gamma function, v below a where it is tiny."""
    value = np.asarray(gammainc(a, v))
    out = np.log(np.maximum(value, TINY))
    tiny = value < TINY
    if not tiny.any():
        return out
    small = v[tiny]
    # DLMF 8.7.1: gamma(a, v) = v^a exp(-v) sum_k v^k / (a ... (a + k)).
    out[tiny] = a * np.log(small) - small - float(gammaln(a + 1)) + np.log(_sum(small, a, 1))
    return out


def _log_upper(a: float, v: Array) -> Array:
    """Log of the regularised upper incomplete gamma function, v above a where it is tiny."""
    value = np.asarray(gammaincc(a, v))
    out = np.log(np.maximum(value, TINY))
    tiny = value < TINY
    if not tiny.any():
        return out
    large = v[tiny]
    # DLMF 8.11.2: Gamma(a, v) ~ v^(a - 1) exp(-v) sum_k (a - 1) ... (a - k) / v^k.
    out[tiny] = (a - 1) * np.log(large) - large - float(gammaln(a)) + np.log(_sum(large, a, -1))
    return out


def _sum(v: Array, a: float, sign: int) -> Array:
    """Sum of the products of v / (a + k), or of (a - k) / v, k from 1, and 1."""
    term, total = np.ones(len(v)), np.ones(len(v))
    for k in range(1, TERMS):
        term = term * (v / (a + k) if sign > 0 else (a - k) / v)
        total += term
        if (np.abs(term) <= ROUNDED * np.abs(total)).all():
            break
    return total

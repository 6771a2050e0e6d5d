r"""One axis of a linear family at any camera position: its evidence, and draws given the position.

Coefficients integrate out exactly, ln sigma and ln tau by quadrature
(`bayescal.linear.evidence`), whose nodes are placed once and then move along with the
least-squares sigma of each position.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.linear.evidence import Projection, Reduced, log_joint, tau_rule
from bayescal.linear.quadrature import Accuracy, Rule, panels
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData
from bayescal.prior.amplitudes import CoefficientPrior
from bayescal.prior.strength import Strength

Rows = NDArray[np.intp]
CACHED = 300_000  # numbers held at once: few enough for a core's cache
GIBBS = 2  # sweeps that make the quadrature's discrete sigma and tau continuous
# A few thousandths of a nat, tens of thousands of times.
QUICK = Accuracy(resolve=8.0, drop=11.0, panel_nodes=9, tau_nodes=21, panels=10)
# ln sigma is integrated by equal steps, in units of the least width sigma's density can have,
# 1 / sqrt(2 n): for a normal of that width the error is exp(-2 pi^2 / step^2) of the integral.
STEP = 1.4
# They cover what is within so many nat of the highest at the position of reference: at others
# the density lies as it does there in units of the least-squares sigma, but not quite.
MARGIN = 30.0
# Where 1 - leverage is smaller, rounding has taken the digits that leaving a point out needs.
DETERMINED = 1e-10


@dataclass(frozen=True, eq=False)
class MovingAxis:
    """One axis of a linear family as a function of the camera position.

    Attributes
    ----------
    data : AxisData
        At the stated position; its basis stays.
    world : Array
        World points, ``(n_points, 3)``, world units.
    column : int
        Coordinate of the axis's own regressor: 0 for r, 1 for c.
    """

    data: AxisData
    world: Array
    column: int
    order: int
    noise: NoiseLevel
    prior: CoefficientPrior

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return self.data.columns(self.order)

    def design(self, position: Array) -> Array:
        """Design matrices at positions ``(m, 3)``, ``(m, n_points, size)``."""
        away = self.world - position[:, None, :]
        depth = away[:, :, 2]
        x = away[:, :, self.column] / depth
        other = None if self.data.other is None else (away[:, :, 1 - self.column] / depth).ravel()
        moved = replace(self.framed, x=x.ravel(), other=other)
        return moved.design(self.order).reshape(*x.shape, self.size)

    @cached_property
    def framed(self) -> AxisData:
        """The axis with its basis held."""
        first = (self.data.domain,)
        return replace(
            self.data, frame=first if self.data.other is None else (*first, self.data.across)
        )

    def without(self, point: int | IntArray) -> MovingAxis:
        """Give the axis of the other points, its basis and priors kept."""

        def rest(values: Array | None) -> Array | None:
            return None if values is None else np.delete(values, point, axis=0)

        every, labels = self.framed, tuple(self.data.labels)
        data = replace(
            every,
            x=np.delete(every.x, point),
            t=np.delete(every.t, point),
            sd=rest(every.sd),
            x_sd=rest(every.x_sd),
            other=rest(every.other),
            labels=tuple(np.delete(np.array(labels, dtype=object), point).tolist()),
        )
        return replace(self, data=data, world=np.delete(self.world, point, axis=0))

    def reduced(self, position: Array) -> Reduced:
        """Weighted least squares at positions ``(m, 3)``."""
        m, n, p = len(position), len(self.world), self.size
        # Rows of zeros where there are no more points than coefficients.
        augmented = np.zeros((m, max(n, p + 1), p + 1))
        augmented[:, :n, :p], augmented[:, :n, p] = self.design(position), self.data.t
        log_sd = 0.0
        if self.data.sd is not None:
            augmented[:, :n] /= self.data.sd[:, None]
            log_sd = float(np.log(self.data.sd).sum())
        triangle = np.linalg.qr(augmented, mode="r")
        ones, rss = np.ones(m), triangle[:, p, p] ** 2
        return Reduced(triangle[:, :p, :p], triangle[:, :p, p], rss, n * ones, log_sd * ones)

    def offsets(self, position: Array) -> Array:
        """Nodes of ln sigma about that of least squares, from a position ``(3,)``; equal steps.

        Found once, where the density is followed: doing so at every position takes some twenty
        times as many nodes.
        """
        if self.noise.bounds is None:
            return np.zeros(1)
        data, n = self.reduced(position[None]), len(self.world)
        projection = Projection.of(data, self.prior, tau_rule(self.prior, QUICK)[1])
        accuracy = replace(QUICK, drop=MARGIN)
        rule, values = log_joint(data, projection, self.noise, self.prior, accuracy)
        matters = rule.nodes[values.max(axis=(0, 1)) > values.max() - MARGIN]
        centre, step = float(self._log_sigma(data)[0]), STEP / math.sqrt(2 * n)
        # A normal of the least width falls by MARGIN so far from its mean.
        reach = math.sqrt(MARGIN / n)
        low, high = min(matters[0] - centre, -reach), max(matters[-1] - centre, reach)
        return np.asarray(low + step * np.arange(math.ceil((high - low) / step) + 1))

    def _log_sigma(self, data: Reduced) -> Array:
        """Log of the least-squares sigma, ``(m,)``, not below its bound."""
        log_sigma = np.log(np.maximum(data.rss / data.n, 1e-300)) / 2
        return np.asarray(np.maximum(log_sigma, self.noise.log_bounds[0]))

    def log_evidence(self, position: Array, offsets: Array) -> Array:
        """Log evidence of the axis at positions ``(m, 3)``, ``(m,)``; `offsets`: see there."""
        data = self.reduced(position)
        out = np.empty(len(position))
        for rows, _, values in self._integrand(data, offsets):
            out[rows] = logsumexp(values, axis=(1, 2))
        return out

    def _integrand(self, data: Reduced, offsets: Array) -> Iterator[tuple[Rows, Array, Array]]:
        """Rows, ln sigma at nodes, and log of density times weight ``(rows, n_tau, n_sigma)``."""
        rule, log_tau = tau_rule(self.prior, QUICK)
        log_prior = self.noise.log_prior() + self.prior.log_tau_density()
        for rows, nodes, weights in self._nodes(data, offsets):
            step = max(1, CACHED // (len(log_tau) * self.size * len(weights)))
            log_weights = np.log(rule.weights[:, None] * weights) + log_prior
            for first in range(0, len(rows), step):
                part, at = rows[first : first + step], nodes[first : first + step]
                some = data[part]
                projection = Projection.of(some, self.prior, log_tau)
                yield part, at, projection.log_likelihood(some, at[:, None, :]) + log_weights

    def _nodes(self, data: Reduced, offsets: Array) -> Iterator[tuple[Rows, Array, Array]]:
        """Rows, nodes of ln sigma ``(rows, n_sigma)`` and weights ``(n_sigma,)``.

        Equal steps, or panels where these would leave the bounds of sigma.
        """
        n, every = len(self.world), np.arange(len(data.rss))
        if self.noise.value is not None:
            yield every, np.full((len(every), 1), math.log(self.noise.value)), np.ones(1)
            return
        (low, high), centre = self.noise.log_bounds, self._log_sigma(data)
        below, above = centre + offsets[0] <= low, centre + offsets[-1] >= high
        rows = every[~below & ~above]
        yield rows, centre[rows, None] + offsets, np.full(len(offsets), offsets[1] - offsets[0])
        near = min(low + float(offsets[-1] - offsets[0]), high)
        for rows, end in ((every[below & ~above], near), (every[above], high)):
            rule = _panels_from(low, end, n)
            yield rows, np.broadcast_to(rule.nodes, (len(rows), len(rule.nodes))), rule.weights

    def draw(
        self, rng: np.random.Generator, position: Array, offsets: Array
    ) -> tuple[Array, Array, Array]:
        """Draw amplitudes ``(m, size)``, ln sigma and ln tau ``(m,)`` given positions."""
        data = self.reduced(position)
        _, log_tau = tau_rule(self.prior, QUICK)
        log_sigma, tau = np.empty(len(position)), np.empty(len(position))
        for rows, nodes, values in self._integrand(data, offsets):
            flat = values.reshape(len(rows), -1)
            pick = np.argmax(flat + rng.gumbel(size=flat.shape), axis=1)
            i, j = np.divmod(pick, nodes.shape[1])
            log_sigma[rows], tau[rows] = nodes[np.arange(len(rows)), j], log_tau[i]
        for _ in range(GIBBS):
            amplitudes = self._amplitudes(rng, data, log_sigma, tau)
            if self.noise.bounds is not None:
                misfit = data.qt - np.einsum("mij,mj->mi", data.r, amplitudes)
                rss = data.rss + (misfit**2).sum(axis=1)
                log_sigma = Strength(self.noise.log_bounds, len(self.world)).draw(rss, rng)
            if self.prior.infers_tau:
                strong = self.prior.scaled
                z = (amplitudes - self.prior.mean)[:, strong] / self.prior.sd[strong]
                strength = Strength(self.prior.log_tau_bounds, int(strong.sum()))
                tau = strength.draw((z**2).sum(axis=1), rng)
        return self._amplitudes(rng, data, log_sigma, tau), log_sigma, tau

    def _amplitudes(
        self, rng: np.random.Generator, data: Reduced, log_sigma: Array, log_tau: Array
    ) -> Array:
        """Draw from the normal given sigma and tau (Bishop 2006, 3.3)."""
        d, w, to_b = self._projected(data, log_tau)
        variance = np.exp(2 * log_sigma)[:, None]
        total = variance + d**2
        a = d * w / total + np.sqrt(variance / total) * rng.standard_normal(w.shape)
        return np.asarray(self.prior.mean + np.einsum("mpq,mq->mp", to_b, a))

    def _projected(self, data: Reduced, log_tau: Array) -> tuple[Array, Array, Array]:
        """Singular values D, data w and S^{1/2} V: `bayescal.linear.evidence` at each tau."""
        s = self.prior.deviations(log_tau)
        u, d, vt = np.linalg.svd(data.r * s[:, None, :])
        w = np.einsum("mji,mj->mi", u, data.qt - data.r @ self.prior.mean)
        return d, w, s[:, :, None] * vt.transpose(0, 2, 1)

    def log_left_out(self, position: Array, log_sigma: Array, log_tau: Array) -> Array:
        """Log density of each pixel given all others and the draw, ``(m, n_points)``.

        The coefficients integrate out of it (`bayescal.comparison.criteria.leave_one_out`); -inf
        where nothing but the point itself determines its prediction.
        """
        design, t, sd = self.design(position), self.data.t, self.data.deviations
        d, w, to_b = self._projected(self.reduced(position), log_tau)
        rows = (design / sd[:, None]) @ to_b
        variance = np.exp(2 * log_sigma)[:, None]
        total = variance + d**2
        offset = (t - design @ self.prior.mean) / sd
        residual = offset - np.einsum("mnq,mq->mn", rows, d * w / total)
        spare = 1 - np.einsum("mnq,mq->mn", rows**2, 1 / total)
        alone = spare < DETERMINED
        spare = np.where(alone, 1.0, spare)
        log_scale = log_sigma[:, None] + np.log(sd)
        density = np.log(spare) / 2 - (residual**2 / (variance * spare) + LOG_2PI) / 2 - log_scale
        return np.where(alone, -np.inf, density)

    def log_likelihood(self, position: Array, amplitudes: Array, log_sigma: Array) -> Array:
        """Log density of each pixel, ``(m, n_points)``."""
        prediction = np.einsum("mnp,mp->mn", self.design(position), amplitudes)
        log_scale = log_sigma[:, None]
        if self.data.sd is not None:
            log_scale = log_scale + np.log(self.data.sd)
        z = (self.data.t - prediction) * np.exp(-log_scale)
        return np.asarray(-(z**2 + LOG_2PI) / 2 - log_scale)


def _panels_from(low: float, end: float, n: int) -> Rule:
    """Panels in ln sigma from its bound: at first for exp(-n t), then for widths 1 / sqrt(2 n)."""
    equal = np.arange(24 / n, end - low, 5 / math.sqrt(2 * n))
    breaks = np.unique(np.minimum([0.0, 8 / n, *equal, end - low], end - low))
    return panels(low + breaks[:-1], low + breaks[1:], QUICK.panel_nodes)

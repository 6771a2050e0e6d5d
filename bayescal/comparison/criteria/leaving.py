r"""Leaving a point out of a linear Gaussian model, in closed form.

Given sigma and tau the model is a linear smoother, so leaving a point out has a closed
form: with residual e_i at the posterior mean and leverage h_i = x_i' Var(b) x_i / sigma^2,

    t_i | t_{-i}, sigma, tau ~ N(t_i - e_i / (1 - h_i), sigma^2 / (1 - h_i)).

sigma and tau are averaged over their posterior *without* the point, by weighting the
quadrature's nodes with 1 / p(t_i | t_{-i}, sigma, tau). A point so influential that its
removal moves that posterior away from the nodes is refitted instead.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from bayescal.arrays import LOG_2PI, Array, IntArray, in_parts
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.fewest_nodes import fewest_nodes

# A point is refitted where the posterior without it peaks at a node at which the density
# with it is below exp(-REFIT) of its maximum,
REFIT = 4.0
# or where that posterior is not below exp(-EDGE) of its maximum at the last nodes of sigma,
EDGE = 22.0
# or where 1 - leverage is so small that it has lost the digits its closed form needs.
DETERMINED = 1e-7
# Numbers held at once: points times nodes.
CHUNK = 1_000_000
# Nodes of less weight tell nothing of a point that weighs little.
NEGLIGIBLE = 1e-24
# From so many points on most weigh little: those of less leverage, and of a residual whose removal
# moves sigma by less than this share of its deviation.
MANY = 1000
LIGHT, LIGHT_RESIDUAL = 0.02, 0.45
# What few nodes are chosen by: points per coefficient, spread over their leverages, times
# residuals; and how much further a leverage may be than theirs.
PROBES, RESIDUALS, BEYOND_PROBES = 3, 7, 1.5


@dataclass(frozen=True, eq=False)
class Leaving:
    """Leaves out points of an order, any of those that it was fitted to.

    Of many points most weigh little: for these few nodes integrate as well as all
    (`fewest_nodes`), and all are for the others.

    Attributes
    ----------
    few : Array or None
        Weights of all nodes for points that weigh little, ``(n_nodes,)``; None of few points.
    leverage, residual : float
        Those weigh little whose leverage and residual, in sigma, are not beyond these.
    deviations : tuple of float
        And whose deviations are between these.
    """

    exact: ExactPosterior
    few: Array | None = None
    leverage: float = 0.0
    residual: float = 0.0
    deviations: tuple[float, float] = (0.0, np.inf)

    @classmethod
    def of(cls, exact: ExactPosterior, design: Array, sd: Array) -> Leaving:
        """Choose the nodes by what points are like.

        Parameters
        ----------
        design : Array
            Of all points or of a sample, ``(n_points, p)``.
        sd : Array
            Their deviations, 1 where there are none, ``(n_points,)``.
        """
        n = float(exact.model.reduced.n)
        if n < MANY:
            return cls(exact)
        leverage = _leverage(exact, design / sd[:, None])
        light = np.flatnonzero(leverage <= LIGHT)
        if not len(light):
            return cls(exact)
        order = light[np.argsort(leverage[light], kind="stable")]
        some = order[np.linspace(0, len(order) - 1, PROBES * exact.model.size).astype(np.intp)]
        # Without a point sigma moves by residual^2 / sqrt(2 n) of its own deviations.
        largest = math.sqrt(LIGHT_RESIDUAL * math.sqrt(2 * n))
        at = largest * np.cos(np.pi * (np.arange(RESIDUALS) + 0.5) / RESIDUALS)
        rows, deviations = np.repeat(design[some], len(at), axis=0), np.repeat(sd[some], len(at))
        t = rows @ exact.mean + np.tile(at, len(some)) * deviations * _sigma(exact)
        few = exact.weights.ravel().copy()
        few[few < NEGLIGIBLE] = 0.0
        nodes = np.flatnonzero(few)
        without, within, _ = _node_densities(exact, rows, t, deviations, nodes)
        logs = np.concatenate([np.negative(without, out=without), within])
        del without, within  # tens of megabytes
        logs -= logs.max(axis=1, keepdims=True)
        few[nodes] = fewest_nodes(np.exp(logs, out=logs), few[nodes])
        beyond = BEYOND_PROBES * float(leverage[some].max())
        known = float(sd[some].min()), float(sd[some].max())
        return cls(exact, few, min(beyond, LIGHT), largest, known)

    def terms(
        self, design: Array, t: Array, sd: Array
    ) -> tuple[Array, Array, NDArray[np.bool_]] | None:
        """Log density of points given the others, and given all; and which need a refit.

        Parameters
        ----------
        design : Array
            ``(n, p)``, not weighted.
        t, sd : Array
            Pixels and deviations, ``(n,)``, px.

        Returns
        -------
        tuple of Array or None
            Each ``(n,)``. None where the posterior without one does not exist.
        """
        proper, n = self.exact.model.prior.proper, len(t)
        if not proper and float(self.exact.model.reduced.n) - 1 < self.exact.model.size:
            return None
        light = self._light(design, t, sd)
        out, inside, moved = np.empty(n), np.empty(n), np.zeros(n, dtype=bool)
        if self.few is not None:
            nodes = np.flatnonzero(self.few)
            log_weights = np.log(self.few[nodes])
            for part in in_parts(np.flatnonzero(light), len(nodes), CHUNK):
                without, within, _ = _node_densities(
                    self.exact, design[part], t[part], sd[part], nodes
                )
                out[part] = -logsumexp(log_weights - without, axis=1)
                inside[part] = logsumexp(log_weights + within, axis=1)
        for part in in_parts(np.flatnonzero(~light), self.exact.log_joint.size, CHUNK):
            out[part], inside[part], moved[part], alone = self._all_nodes(
                design[part], t[part], sd[part]
            )
            if alone and not proper:
                return None  # without the point the posterior is improper
        return out, inside, moved

    def _light(self, design: Array, t: Array, sd: Array) -> NDArray[np.bool_]:
        """Whether points weigh so little that few nodes are enough."""
        if self.few is None:
            return np.zeros(len(t), dtype=bool)
        residual = np.abs(t - design @ self.exact.mean) / (sd * _sigma(self.exact))
        low, high = self.deviations
        inside = (sd >= low) & (sd <= high) & (residual <= self.residual)
        return inside & (_leverage(self.exact, design / sd[:, None]) <= self.leverage)

    def _all_nodes(
        self, design: Array, t: Array, sd: Array
    ) -> tuple[Array, Array, NDArray[np.bool_], bool]:
        """Terms by every node, which points move the posterior away from them, is one alone."""
        exact = self.exact
        log_weights, density = exact.log_weights.ravel(), exact.log_joint.ravel()
        without, within, spare = _node_densities(exact, design, t, sd, np.arange(density.size))
        alone = spare < DETERMINED  # nothing but the point determines its own prediction
        left = density - without
        far = density[left.argmax(axis=1)] < density.max() - REFIT
        moved = alone | far | _cut_off(exact, left.reshape(-1, *exact.log_joint.shape))
        return (
            -logsumexp(log_weights - without, axis=1),
            logsumexp(log_weights + within, axis=1),
            moved,
            bool(alone.any()),
        )


def _sigma(exact: ExactPosterior) -> float:
    """Posterior mean of sigma, px."""
    return float(exact.weights.sum(axis=0) @ exact.sigma)


def _leverage(exact: ExactPosterior, weighted: Array) -> Array:
    """Leverages of rows of the weighted design in least squares, ``(n,)``."""
    q = solve_triangular(exact.model.reduced.r, weighted.T, trans="T")
    return np.asarray((q**2).sum(axis=0))


def _cut_off(exact: ExactPosterior, density: Array) -> NDArray[np.bool_]:
    """Whether densities are not negligible at an outermost node of sigma short of its bound."""
    out = np.zeros(len(density), dtype=bool)
    if not exact.model.infers_sigma:
        return out
    top = density.max(axis=(1, 2))
    nodes = exact.sigma_rule.nodes
    for side, bound in zip((0, -1), exact.model.noise.log_bounds, strict=True):
        if abs(nodes[side] - bound) > 1e-9:
            out |= density[:, :, side].max(axis=1) > top - EDGE
    return out


def _node_densities(
    exact: ExactPosterior, design: Array, t: Array, sd: Array, nodes: IntArray
) -> tuple[Array, Array, Array]:
    """Log densities of points without and with themselves at some nodes, ``(n, n_nodes)``.

    And the least of 1 - leverage, ``(n,)``; `nodes` are ascending numbers among all.
    """
    conditional = exact.conditional
    design, offset = design / sd[:, None], (t - design @ exact.model.prior.mean) / sd
    variance = exact.sigma**2
    mean, _ = conditional.moments(variance)  # (tau, sigma, p)
    total = conditional.precision * variance[:, None] + conditional.d[:, None, :] ** 2
    taus, sigmas = np.divmod(nodes, len(variance))
    without, within = np.empty((2, len(t), len(nodes)))
    least = np.full(len(t), np.inf)
    for tau in np.unique(taus):
        at = slice(*np.searchsorted(taus, [tau, tau + 1]))
        sigma = sigmas[at]
        rows = design @ conditional.to_b[tau]  # (n, p)
        scaled = (offset[:, None] - rows @ mean[tau, sigma].T) ** 2 / variance[sigma]
        leverage = rows**2 @ (1 / total[tau, sigma]).T
        constant = LOG_2PI + np.log(variance[sigma])
        spare = 1 - leverage
        least = np.minimum(least, spare.min(axis=1))
        spare = np.maximum(spare, DETERMINED)
        without[:, at] = -(constant - np.log(spare) + scaled / spare) / 2
        within[:, at] = -(constant + np.log1p(leverage) + scaled / (1 + leverage)) / 2
    log_sd = np.log(sd)[:, None]
    return without - log_sd, within - log_sd, least

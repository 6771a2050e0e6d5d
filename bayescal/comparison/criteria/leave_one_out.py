r"""Exact leave-one-out predictive densities of linear Gaussian models.

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
from scipy.special import logsumexp

from bayescal.arrays import LOG_2PI, Array, IntArray, frozen
from bayescal.linear.closed_form import ExactPosterior
from bayescal.linear.evidence import log_evidences
from bayescal.linear.quadrature import FINE
from bayescal.linear.reweighting import Rows
from bayescal.polynomials.axis_data import AxisData

# A point is refitted where the posterior without it peaks at a node at which the density
# with it is below exp(-REFIT) of its maximum,
REFIT = 4.0
# or where that posterior is not below exp(-EDGE) of its maximum at the last nodes of sigma,
EDGE = 22.0
# or where 1 - leverage is so small that it has lost the digits its closed form needs.
DETERMINED = 1e-7
# Numbers held at once: points times nodes.
CHUNK = 4_000_000


@dataclass(frozen=True, eq=False)
class LeaveOneOut:
    """Expected log pointwise predictive density (elpd), however its terms were computed.

    Attributes
    ----------
    pointwise : Array
        ln p(unit i | all other units), ``(n_units,)``: a unit is a pixel value of one axis, or r
        and c of a point together.
    p_eff : float or None
        Effective number of parameters: in-sample log predictive density less elpd.
    refitted : tuple of int
        Units whose removal needed a fit or an evidence of its own.
    pareto_k : Array or None
        Shape of each unit's weights where the terms come from draws, ``(n_units,)``: inf where
        there is none, -inf of those refitted; None where the terms are exact.
    k_limit : float or None
        Good below it; fewer draws can judge thinner tails only.
    mcse : float
        Monte Carlo standard error of elpd.
    """

    pointwise: Array
    p_eff: float | None = None
    refitted: tuple[int, ...] = ()
    pareto_k: Array | None = None
    k_limit: float | None = None
    mcse: float = 0.0

    @property
    def elpd(self) -> float:
        """Sum of the terms."""
        return float(self.pointwise.sum())

    @property
    def se(self) -> float:
        """Its standard error: sqrt(n) times the sd (n - 1) of the terms."""
        return _se(self.pointwise)

    @property
    def largest_k(self) -> float | None:
        """Largest Pareto k of those that draws tell of; None where the terms are exact."""
        if self.pareto_k is None:
            return None
        largest = float(self.pareto_k.max())
        return 0.0 if largest == -math.inf else largest

    @property
    def unreliable(self) -> tuple[int, ...]:
        """Units whose Pareto k is not good, the worst first."""
        if self.pareto_k is None or self.k_limit is None:
            return ()
        order = np.argsort(-self.pareto_k, kind="stable")
        return tuple(int(i) for i in order if not self.pareto_k[i] < self.k_limit)

    @property
    def reliable(self) -> bool:
        """Whether it is exact, or every unit's Pareto k is good."""
        return not self.unreliable


def leave_one_out(data: AxisData, exact: ExactPosterior) -> LeaveOneOut | None:
    """Exact leave-one-out of one order; sigma and tau averaged.

    Parameters
    ----------
    data : AxisData
        The points that `exact` was made from.

    Returns
    -------
    LeaveOneOut or None
        None where the posterior without a point does not exist (a flat prior and no
        degree of freedom to spare).
    """
    n = len(data)
    if not exact.model.prior.proper and n - 1 < exact.model.size:
        return None
    log_weights = exact.log_weights.ravel()
    density, nodes = exact.log_joint.ravel(), log_weights.size
    step = max(1, CHUNK // nodes)
    out, inside, moved = np.empty(n), np.empty(n), np.zeros(n, dtype=bool)
    for start in range(0, n, step):
        part = slice(start, min(start + step, n))
        log_without, log_with, spare = _node_densities(data, exact, part)
        alone = spare < DETERMINED  # nothing but the point determines its own prediction
        if alone.any() and not exact.model.prior.proper:
            return None  # without the point the posterior is improper
        out[part] = -logsumexp(log_weights - log_without, axis=1)
        inside[part] = logsumexp(log_weights + log_with, axis=1)
        left = density - log_without
        far = density[left.argmax(axis=1)] < density.max() - REFIT
        moved[part] = alone | far | _cut_off(exact, left.reshape(-1, *exact.log_joint.shape))
    if moved.any():
        out[moved] = exact.log_integral - _refitted(data, exact, np.flatnonzero(moved))
    again = tuple(np.flatnonzero(moved).tolist())
    return LeaveOneOut(frozen(out), float(inside.sum() - out.sum()), again)


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
    data: AxisData, exact: ExactPosterior, part: slice
) -> tuple[Array, Array, Array]:
    """Log densities of points without and with themselves, ``(n_part, n_nodes)``."""
    model, conditional = exact.model, exact.conditional
    design = data.design(model.order)[part]
    t, sd = data.t[part], data.sd[part] if data.sd is not None else np.ones(design.shape[0])
    design, offset = design / sd[:, None], (t - design @ model.prior.mean) / sd
    variance = exact.sigma**2
    mean, _ = conditional.moments(variance)  # (tau, sigma, p)
    rows = design @ conditional.to_b  # (tau, n, p)
    residual = offset[:, None] - np.einsum("tnp,tsp->tns", rows, mean)
    total = conditional.precision * variance[:, None] + conditional.d[:, None, :] ** 2
    leverage = np.einsum("tnp,tsp->tns", rows**2, 1 / total)
    scaled = residual**2 / variance
    constant = LOG_2PI + np.log(variance)
    spare = 1 - leverage
    least = spare.min(axis=(0, 2))
    spare = np.maximum(spare, DETERMINED)
    without = -(constant - np.log(spare) + scaled / spare) / 2
    within = -(constant + np.log1p(leverage) + scaled / (1 + leverage)) / 2
    shape = (design.shape[0], -1)
    log_sd = np.log(sd)[:, None]
    return (
        without.transpose(1, 0, 2).reshape(shape) - log_sd,
        within.transpose(1, 0, 2).reshape(shape) - log_sd,
        least,
    )


def _refitted(data: AxisData, exact: ExactPosterior, points: IntArray) -> Array:
    """Log evidence without each of some points."""
    model = exact.model
    members = np.zeros((len(points), len(data)))
    members[np.arange(len(points)), points] = 1
    sets = Rows.of(data, model.order).without(members)
    return log_evidences(sets.reduced(model.order), model.noise, model.prior, FINE)


def paired_difference(one: LeaveOneOut, other: LeaveOneOut) -> tuple[float, float]:
    """Difference of elpd, `one` less `other`, and its paired standard error."""
    difference = one.pointwise - other.pointwise
    return float(difference.sum()), _se(difference)


def _se(terms: Array) -> float:
    """Give the standard error of a sum: sqrt(n) times the sd (n - 1) of its terms."""
    n = len(terms)
    return math.sqrt(n) * float(terms.std(ddof=1)) if n > 1 else math.nan

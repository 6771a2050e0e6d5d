r"""Independence proposals: densities close to a posterior, to draw from and to evaluate."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from bayescal.arrays import LOG_2PI, Array, IntArray
from bayescal.linear.closed_form import ExactPosterior
from bayescal.noise.level import NoiseLevel
from bayescal.prior.amplitudes import CoefficientPrior

# Share of the proposal that is uniform over the bounds of ln sigma and ln tau, so
# that it covers the whole support of the target.
DEFENSIVE = 0.01


class Proposal(Protocol):
    """A density over a model's parameters that does not depend on the state."""

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw parameters, ``(size, dimension)``."""
        ...

    def log_density(self, theta: Array) -> Array:
        """Normalised log density at parameters, ``(n,)``."""
        ...


class Hats:
    """Linear interpolation between nodes, as a mixture of hat functions.

    Parameters
    ----------
    nodes : Array
        Ascending, ``(n_nodes,)``; one node means that there is no coordinate.
    """

    def __init__(self, nodes: Array) -> None:
        self.nodes = nodes
        gaps = np.diff(nodes)
        self.left = np.append(0.0, gaps)
        self.right = np.append(gaps, 0.0)
        self.mass = (self.left + self.right) / 2 if len(nodes) > 1 else np.ones(1)

    def draw(self, rng: np.random.Generator, index: IntArray) -> Array:
        """Draw one value from the hat of each node in `index`."""
        left, right = self.left[index], self.right[index]
        side = rng.random(len(index)) * (left + right) < left
        length = np.where(side, -left, right)
        drawn: Array = self.nodes[index] + length * (1 - np.sqrt(rng.random(len(index))))
        return drawn

    def locate(self, values: Array) -> tuple[IntArray, Array]:
        """Node to the left of each value and the weight of the node to its right."""
        if len(self.nodes) == 1:
            return np.zeros(len(values), dtype=np.intp), np.zeros(len(values))
        left: IntArray = np.clip(
            np.searchsorted(self.nodes, values) - 1, 0, len(self.nodes) - 2
        ).astype(np.intp)
        return left, (values - self.nodes[left]) / self.right[left]


class LinearProposal:
    """The exact posterior of a linear model, interpolated between quadrature nodes.

    tau and sigma are drawn first, from the hats over the nodes of the closed form's
    quadrature; then the amplitudes, normal given sigma and the node of tau. The
    share DEFENSIVE of draws takes ln sigma and the node of tau uniformly instead.

    Parameters
    ----------
    width : float, optional
        Factor on the amplitudes' proposal deviations (1 is the exact posterior).
    """

    def __init__(self, exact: ExactPosterior, width: float = 1.0) -> None:
        self.exact, self.width = exact, width
        self.model = exact.model
        self._sigma, self._tau = Hats(exact.sigma_rule.nodes), Hats(exact.tau_rule.nodes)
        mass = self._tau.mass[:, None] * self._sigma.mass
        peak = exact.log_joint.max()
        density = np.exp(exact.log_joint - peak)
        self._density = density / (density * mass).sum()
        share = mass * self._density * (1 - DEFENSIVE)
        self._cumulative = np.cumsum(share.ravel())
        self._uniform_tau = self._tau.mass / self._tau.mass.sum()
        self._uniform_sigma = 1 / _width(self.model.noise)
        self._uniform = DEFENSIVE * self._uniform_sigma / _tau_width(self.model.prior)

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw parameters, ``(size, dimension)``."""
        model = self.model
        u = rng.random(size)
        n_sigma = len(self._sigma.nodes)
        flat = np.minimum(
            np.searchsorted(self._cumulative, u, side="right"), self._density.size - 1
        )
        tau, sigma = np.divmod(flat, n_sigma)
        uniform = u >= self._cumulative[-1]
        tau[uniform] = rng.choice(len(self._uniform_tau), uniform.sum(), p=self._uniform_tau)
        columns = []
        if model.infers_sigma:
            log_sigma = self._sigma.draw(rng, sigma)
            log_sigma[uniform] = rng.uniform(*model.noise.log_bounds, uniform.sum())
            columns.append(log_sigma)
            variance = np.exp(2 * log_sigma)
        else:
            variance = np.full(size, self.exact.sigma[0] ** 2)
        if model.infers_tau:
            columns.append(self._tau.draw(rng, tau))
        mean, spread = self._normal(tau, variance)
        a = mean + np.sqrt(spread) * rng.standard_normal(mean.shape)
        to_b = self.exact.conditional.to_b[tau]
        amplitudes = model.prior.mean + np.einsum("npq,nq->np", to_b, a)
        return np.column_stack([amplitudes, *columns])

    def log_density(self, theta: Array) -> Array:
        """Normalised log density at parameters, ``(n,)``."""
        model = self.model
        rest = theta[:, model.size :]
        if model.infers_sigma:
            log_sigma = rest[:, 0]
            variance = np.exp(2 * log_sigma)
        else:
            log_sigma = np.zeros(len(theta))
            variance = np.full(len(theta), self.exact.sigma[0] ** 2)
        log_tau = rest[:, -1] if model.infers_tau else np.zeros(len(theta))
        j, right_sigma = self._sigma.locate(log_sigma)
        i, right_tau = self._tau.locate(log_tau)
        covered = (right_sigma >= 0) & (right_sigma <= 1)
        offset = theta[:, : model.size] - model.prior.mean
        total = np.full(len(theta), -np.inf)
        for side, weight in ((0, 1 - right_tau), (1, right_tau)):
            node = np.minimum(i + side, len(self._tau.nodes) - 1)
            beside = np.minimum(j + 1, len(self._sigma.nodes) - 1)
            density = self._density[node, j] * (1 - right_sigma)
            density += self._density[node, beside] * right_sigma
            mixed = np.where(covered, (1 - DEFENSIVE) * density, 0.0) + self._uniform
            with np.errstate(divide="ignore"):
                log_weight = np.log(weight * mixed)
            total = np.logaddexp(total, log_weight + self._log_normal(node, variance, offset))
        return total

    def _normal(self, node: IntArray, variance: Array) -> tuple[Array, Array]:
        """Mean and variance of a given sigma^2 at a node of tau, ``(n, p)``."""
        conditional = self.exact.conditional
        d, w = conditional.d[node], conditional.w[node]
        total = conditional.precision * variance[:, None] + d**2
        return d * w / total, self.width**2 * variance[:, None] / total

    def _log_normal(self, node: IntArray, variance: Array, offset: Array) -> Array:
        conditional = self.exact.conditional
        mean, spread = self._normal(node, variance)
        a = np.einsum("nqp,np->nq", conditional.from_b[node], offset)
        quadratic = (a - mean) ** 2 / spread + np.log(spread) + LOG_2PI
        density: Array = conditional.log_det[node] - quadratic.sum(axis=1) / 2
        return density


def _width(noise: NoiseLevel) -> float:
    if noise.value is not None:
        return 1.0
    lower, upper = noise.log_bounds
    return upper - lower


def _tau_width(prior: CoefficientPrior) -> float:
    if not prior.infers_tau:
        return 1.0
    lower, upper = prior.log_tau_bounds
    return upper - lower

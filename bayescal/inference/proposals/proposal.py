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
    """

    def __init__(self, exact: ExactPosterior) -> None:
        self.exact, self.model = exact, exact.model
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
        # With a further column, whose weight is 0, beside the last.
        self._table = np.pad(self._density, ((0, 0), (0, 1)))
        # By nodes of tau along the last axis: sums over amplitudes are then sums of rows.
        conditional = exact.conditional
        self._d2, self._w2, self._inverse_variance = (
            np.ascontiguousarray(values.T)
            for values in (conditional.d**2, conditional.w**2, (conditional.from_b**2).sum(axis=1))
        )

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
        amplitudes = theta[:, : model.size]
        squares = np.square(amplitudes.T - model.prior.mean[:, None], order="C")
        misfit = model.reduced.qt - amplitudes @ model.reduced.r.T
        near = np.einsum("np,np->n", misfit, misfit) / variance
        likelihood = -(near + model.size * (np.log(variance) + LOG_2PI)) / 2
        cells = np.ravel_multi_index((i, j), self._table.shape)
        share = (1 - DEFENSIVE) * covered
        sides = []
        for side, weight in ((0, 1 - right_tau), (1, right_tau))[: len(self._tau.nodes)]:
            cell = cells + side * self._table.shape[1]
            density = self._table.take(cell) * (1 - right_sigma)
            density += self._table.take(cell + 1) * right_sigma
            with np.errstate(divide="ignore"):
                log_weight = np.log(weight * (share * density + self._uniform))
            sides.append(log_weight + self._over_likelihood(i + side, variance, squares))
        return np.asarray(likelihood + np.logaddexp.reduce(sides))

    def _normal(self, node: IntArray, variance: Array) -> tuple[Array, Array]:
        """Mean and variance of a given sigma^2 at a node of tau, ``(n, p)``."""
        conditional = self.exact.conditional
        d, w = conditional.d[node], conditional.w[node]
        total = conditional.precision * variance[:, None] + d**2
        return d * w / total, variance[:, None] / total

    def _over_likelihood(self, node: IntArray, variance: Array, squares: Array) -> Array:
        """Log density of amplitudes given sigma^2 and the node of tau, less their likelihood's.

        It is likelihood times prior over evidence: of what depends on tau there are sums of
        squares alone, while the likelihood, which takes the product with R, is the same at
        every node.

        Parameters
        ----------
        squares : Array
            Of the amplitudes' distances from the prior's means, ``(p, n)``.
        """
        conditional, precision = self.exact.conditional, self.exact.conditional.precision
        total = self._d2.take(node, axis=1)
        total += precision * variance
        found: Array = conditional.log_det.take(node) + np.log(total).sum(axis=0) / 2
        if precision:
            prior = self._w2.take(node, axis=1)
            prior /= total
            prior -= self._inverse_variance.take(node, axis=1) * squares
            found += precision / 2 * prior.sum(axis=0)
        return found


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

"""A mixture of multivariate Student-t distributions: a proposal with heavy tails."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import gammaln, logsumexp

from bayescal.arrays import Array

SINGULAR = 1e-5  # of a deviation


@dataclass(frozen=True, eq=False)
class TMixture:
    """Weighted multivariate t components.

    Attributes
    ----------
    weights : Array
        ``(n_components,)``, summing to 1.
    means : Array
        ``(n_components, dimension)``.
    roots : Array
        Lower Cholesky roots of the scale matrices, ``(n_components, dimension, dimension)``.
    dof : Array
        Degrees of freedom, ``(n_components,)``.
    """

    weights: Array
    means: Array
    roots: Array
    dof: Array

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return len(self.means[0])

    @cached_property
    def _whiteners(self) -> list[Array]:
        """Inverse roots: products with them take a third of the time of solving."""
        unit = np.eye(self.dimension)
        return [solve_triangular(root, unit, lower=True) for root in self.roots]

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw parameters, ``(size, dimension)``."""
        which = rng.choice(len(self.weights), size, p=self.weights)
        normal = rng.standard_normal((size, self.dimension))
        chi2 = rng.chisquare(self.dof[which])
        spread = np.einsum("nij,nj->ni", self.roots[which], normal)
        return np.asarray(self.means[which] + spread * np.sqrt(self.dof[which] / chi2)[:, None])

    def log_components(self, theta: Array) -> Array:
        """Log density of each component at parameters, ``(n_components, n)``."""
        return np.array([self._log_t(k, theta)[0] for k in range(len(self.weights))])

    def log_density(self, theta: Array) -> Array:
        """Normalised log density at parameters, ``(n,)``."""
        with np.errstate(divide="ignore"):
            log_weights = np.log(self.weights)[:, None]
        return np.asarray(logsumexp(self.log_components(theta) + log_weights, axis=0))

    def _log_t(self, k: int, theta: Array) -> tuple[Array, Array]:
        """Log density of a component and squared distance from its mean, ``(n,)``."""
        d, dof, root = self.dimension, float(self.dof[k]), self.roots[k]
        z = (theta - self.means[k]) @ self._whiteners[k].T
        distance = np.einsum("ni,ni->n", z, z)
        constant = (
            float(gammaln((dof + d) / 2) - gammaln(dof / 2))
            - d / 2 * math.log(dof * math.pi)
            - float(np.log(np.diag(root)).sum())
        )
        return constant - (dof + d) / 2 * np.log1p(distance / dof), distance

    def refitted(self, theta: Array, weights: Array, steps: int, floor: float) -> TMixture:
        """Fit the mixture to weighted draws by expectation-maximisation.

        Parameters
        ----------
        theta : Array
            ``(n, dimension)``.
        weights : Array
            ``(n,)``, summing to 1.
        floor : float
            Share of the draws' covariance that is added to each component's, so that
            none collapses.

        Returns
        -------
        TMixture
            With the same degrees of freedom (Peel & McLachlan 2000, Stat. Comput. 10, 339).
        """
        mean = weights @ theta
        pooled = (theta - mean).T @ (weights[:, None] * (theta - mean))
        found = self
        for _ in range(steps):
            shares, means, roots = [], [], []
            both = [found._log_t(k, theta) for k in range(len(found.weights))]
            with np.errstate(divide="ignore"):
                logs = np.array([b[0] for b in both]) + np.log(found.weights)[:, None]
            belongs = np.exp(logs - logsumexp(logs, axis=0)) * weights
            for k, (_, distance) in enumerate(both):
                dof = float(found.dof[k])
                pull = belongs[k] * (dof + self.dimension) / (dof + distance)
                share = float(belongs[k].sum())
                if share < 1e-6:
                    shares.append(share)
                    means.append(found.means[k])
                    roots.append(found.roots[k])
                    continue
                centre = pull @ theta / pull.sum()
                offset = theta - centre
                scale = offset.T @ (pull[:, None] * offset) / share + floor * pooled
                shares.append(share)
                means.append(centre)
                roots.append(cholesky(scale))
            total = np.array(shares) / sum(shares)
            found = TMixture(total, np.array(means), np.array(roots), found.dof)
        return found


def cholesky(covariance: Array) -> Array:
    """Lower Cholesky root of a covariance that rounding may have made singular."""
    scale = np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))
    correlation = covariance / np.outer(scale, scale)
    correlation = (correlation + correlation.T) / 2
    try:
        root = np.linalg.cholesky(correlation)
        sound = np.diag(root).min() > SINGULAR  # a coordinate's deviation, the others known
    except np.linalg.LinAlgError:
        sound = False
    if not sound:
        values, vectors = np.linalg.eigh(correlation)
        values = np.maximum(values, 1e-12 * values.max())
        triangle = np.linalg.qr((vectors * np.sqrt(values)).T, mode="r")
        root = triangle.T * np.where(np.diag(triangle) < 0, -1.0, 1.0)
    return np.asarray(scale[:, None] * root)

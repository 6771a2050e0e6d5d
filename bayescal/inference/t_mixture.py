"""A mixture of multivariate Student-t distributions: a proposal with heavy tails."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import gammaln, logsumexp

from bayescal.arrays import Array

SINGULAR = 1e-5  # of a deviation
AT_A_TIME = 1_000_000  # numbers of whitened parameters


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
    def _whiteners(self) -> Array:
        """Inverse roots: products with them take a third of the time of solving."""
        return np.linalg.inv(self.roots)

    def draw(self, rng: np.random.Generator, size: int) -> Array:
        """Draw parameters, ``(size, dimension)``."""
        which = rng.choice(len(self.weights), size, p=self.weights)
        normal = rng.standard_normal((size, self.dimension))
        chi2 = rng.chisquare(self.dof[which])
        spread = np.einsum("nij,nj->ni", self.roots[which], normal)
        return np.asarray(self.means[which] + spread * np.sqrt(self.dof[which] / chi2)[:, None])

    def log_components(self, theta: Array) -> Array:
        """Log density of each component at parameters, ``(n_components, n)``."""
        return self._log_t(self._distances(theta))

    def log_density(self, theta: Array) -> Array:
        """Normalised log density at parameters, ``(n,)``."""
        with np.errstate(divide="ignore"):
            logs = self.log_components(theta) + np.log(self.weights)[:, None]
        top = logs.max(axis=0)
        return np.asarray(top + np.log(np.exp(logs - top).sum(axis=0)))

    def _distances(self, theta: Array) -> Array:
        """Squared distance from the mean of each component, ``(n_components, n)``."""
        out = np.empty((len(self.weights), len(theta)))
        several = max(1, AT_A_TIME // max(1, theta.size))  # one product serves so many
        for i in range(0, len(out), several):
            whiteners = self._whiteners[i : i + several]
            centre = self.means[i]
            away = (whiteners @ (self.means[i : i + several] - centre)[..., None]).ravel()
            z = (theta - centre) @ whiteners.reshape(-1, self.dimension).T - away
            z = z.reshape(len(theta), len(whiteners), self.dimension)
            np.einsum("nkd,nkd->kn", z, z, out=out[i : i + several])
        return out

    def _log_t(self, distances: Array) -> Array:
        """Log density of each component by distances from their means, of the same shape."""
        d, dof = self.dimension, self.dof
        constant = gammaln((dof + d) / 2) - gammaln(dof / 2) - d / 2 * np.log(dof * math.pi)
        constant -= np.log(np.einsum("kii->ki", self.roots)).sum(axis=1)
        tail = ((dof + d) / 2)[:, None] * np.log1p(distances / dof[:, None])
        return np.asarray(constant[:, None] - tail)

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
            distances = found._distances(theta)
            with np.errstate(divide="ignore"):
                logs = found._log_t(distances) + np.log(found.weights)[:, None]
            belongs = np.exp(logs - logsumexp(logs, axis=0)) * weights
            for k, distance in enumerate(distances):
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
    """Lower Cholesky roots of covariances ``(..., d, d)`` that rounding may have made singular."""
    diagonal = np.einsum("...ii->...i", covariance)
    scale = np.sqrt(np.maximum(diagonal, np.finfo(float).tiny))
    correlation = covariance / (scale[..., :, None] * scale[..., None, :])
    correlation = (correlation + correlation.swapaxes(-1, -2)) / 2
    try:
        root = np.linalg.cholesky(correlation)
        # What a coordinate varies by, those before it known.
        sound = bool(np.einsum("...ii->...i", root).min() > SINGULAR)
    except np.linalg.LinAlgError:
        sound = False
    if not sound:
        values, vectors = np.linalg.eigh(correlation)
        values = np.maximum(values, 1e-12 * values.max(axis=-1, keepdims=True))
        sides = (vectors * np.sqrt(values)[..., None, :]).swapaxes(-1, -2)
        triangle = np.linalg.qr(sides, mode="r")
        signs = np.where(np.einsum("...ii->...i", triangle) < 0, -1.0, 1.0)
        root = triangle.swapaxes(-1, -2) * signs[..., None, :]
    return np.asarray(scale[..., None] * root)

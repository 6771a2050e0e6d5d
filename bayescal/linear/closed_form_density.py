"""Densities of reported parameters in closed form, to lay over the draws.

Given sigma and tau the coefficients are normal; the posterior is a mixture over the
quadrature's nodes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bayescal.arrays import Array
from bayescal.linear.closed_form import ExactPosterior

# Nodes of sigma that hold less than this probability, shared among all, can't be seen; nor can
# the lightest normals of a mixture that hold this much together.
UNSEEN, LIGHTEST = 1e-5, 1e-3
REACH = 4.5  # standard deviations, shown on either side of a coefficient's mean
PLACES = 61
BLOCK = 8
LARGEST_CORRELATION = 1 - 1e-12
# Steps of a mesh that the sharpest normal on it must be wide: its sum over the mesh is then 1
# to 1e-4. A small tau leaves a coefficient narrower than a picture shows.
SHARPEST = 0.7


@dataclass(frozen=True, eq=False)
class Surface:
    """Joint density of two parameters over a mesh.

    Attributes
    ----------
    x, y : Array
        Values of the two parameters, ``(n_rows, n_columns)``, px; tau as log10.
    density : Array
        ``(n_rows, n_columns)``, per unit of both.
    mass : Array
        Probability around each place, ``(n_rows, n_columns)``.
    """

    x: Array
    y: Array
    density: Array
    mass: Array

    def thresholds(self, probabilities: tuple[float, ...]) -> list[float]:
        """Densities above which lies so much probability, ascending density."""
        order = np.argsort(-self.density, axis=None)
        enclosed = np.cumsum(self.mass.ravel()[order])
        found = [
            self.density.ravel()[order[np.searchsorted(enclosed, p).clip(max=len(order) - 1)]]
            for p in probabilities
        ]
        return sorted(float(value) for value in found)


class Densities:
    """Densities of a posterior's reported parameters."""

    def __init__(self, exact: ExactPosterior) -> None:
        model = exact.model
        self._size, self._names = model.size, model.names
        self._mean, self._sd = exact.summary
        self._rows = model.factors.monomials.lead(model.order)
        self._prior_mean = model.prior.mean
        # Values of sigma and log10 tau at the nodes, and node widths in them.
        sigma, tau = exact.sigma, exact.tau_rule.nodes / np.log(10)
        self._nodes = {exact.model.noise.parameter: sigma, "tau": tau}
        self._widths = {
            exact.model.noise.parameter: exact.sigma_rule.weights * sigma,
            "tau": exact.tau_rule.weights / np.log(10),
        }
        self._weights = exact.weights  # (n_tau, n_sigma)
        mean, variance = exact.conditional.moments(exact.sigma**2)  # (n_tau, n_sigma, p)
        self._a_mean, self._a_variance = mean, variance
        self._to_b = exact.conditional.to_b

    def marginal(self, name: str) -> tuple[Array, Array]:
        """Give places and density of one parameter, ``(n_places,)`` each; tau as log10."""
        if name in self._nodes and name in self._names:
            mass = self._weights.sum(axis=self._axis(name))
            return self._nodes[name], mass / self._widths[name]
        j = self._names.index(name)
        weights, means, variances = self._heavy([j])
        x = self._places(j, means[:, 0], np.sqrt(variances[:, 0, 0]))
        z = (x[:, None] - means[:, 0]) / np.sqrt(variances[:, 0, 0])
        density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi * variances[:, 0, 0]) @ weights
        return x, density

    def joint(self, first: str, second: str) -> Surface:
        """Joint density of two parameters, the first in x.

        Parameters
        ----------
        first, second : str
            Reported names, in their order.
        """
        if second not in self._nodes:
            return self._two_coefficients(*(self._names.index(n) for n in (first, second)))
        if first not in self._nodes:
            return self._with_node(self._names.index(first), second)
        (sigma, tau), mass = (self._nodes[n] for n in (first, second)), self._weights
        area = np.outer(self._widths[second], self._widths[first])
        x, y = np.meshgrid(sigma, tau)
        return Surface(x, y, mass / area, mass)

    def _axis(self, name: str) -> int:
        """Axis of the weights that `name` does not run along."""
        return 1 if name == "tau" else 0

    def _places(self, j: int, means: Array, sds: Array) -> Array:
        """Places of a coefficient, more of them where a small tau makes a spike."""
        wide, narrow, i = self._sd[j], float(sds.min()), int(sds.argmin())
        x = [self._mean[j] + wide * np.linspace(-REACH, REACH, PLACES)]
        if narrow < wide / 2:
            scales = np.geomspace(narrow, wide, 2 + int(np.log2(wide / narrow)))
            x += [means[i] + s * np.linspace(-REACH, REACH, PLACES) for s in scales]
        return np.unique(np.concatenate(x).clip(x[0][0], x[0][-1]))

    def _moments(self, rows: list[int]) -> tuple[Array, Array]:
        """Mean and covariance of some coefficients at every node."""
        lead = self._rows[rows]
        maps = np.einsum("kp,tpq->tkq", lead, self._to_b)
        means = lead @ self._prior_mean + np.einsum("tkq,tsq->tsk", maps, self._a_mean)
        covariances = np.einsum("tkq,tlq,tsq->tskl", maps, maps, self._a_variance)
        return means, covariances

    def _heavy(self, rows: list[int]) -> tuple[Array, Array, Array]:
        """Weights, means and covariances of some coefficients as a smaller mixture.

        `BLOCK` neighbouring nodes of sigma, which hardly differ, become one normal of
        the same mean and covariance: a tenth of the time, nothing that can be seen.
        """
        seen = self._weights.sum(axis=0) > UNSEEN / self._weights.shape[1]
        means, covariances = (part[:, seen] for part in self._moments(rows))
        weights = self._weights[:, seen]
        starts = np.arange(0, weights.shape[1], BLOCK)
        total = np.add.reduceat(weights, starts, axis=1)
        rising = np.sort(total, axis=None)
        held = np.searchsorted(np.cumsum(rising), LIGHTEST * rising.sum(), side="right")
        some = total >= rising[min(held, rising.size - 1)]
        total = np.where(total > 0, total, 1.0)
        mean = np.add.reduceat(weights[..., None] * means, starts, axis=1) / total[..., None]
        shift = means - np.repeat(mean, np.diff(np.append(starts, weights.shape[1])), axis=1)
        spread = covariances + shift[..., :, None] * shift[..., None, :]
        covariance = np.add.reduceat(weights[..., None, None] * spread, starts, axis=1)
        return total[some], mean[some], (covariance / total[..., None, None])[some]

    def _two_coefficients(self, i: int, j: int) -> Surface:
        """Over a mesh along the posterior's own axes, however narrow it is."""
        weights, means, covariances = self._heavy([i, j])
        mean = weights @ means / weights.sum()
        centred = means - mean
        total = np.einsum("k,kab->ab", weights, covariances)
        total = (total + (weights[:, None] * centred).T @ centred) / weights.sum()
        sd = np.sqrt(np.diag(total))
        rho = np.clip(total[0, 1] / sd.prod(), -LARGEST_CORRELATION, LARGEST_CORRELATION)
        from_mesh = sd[:, None] * np.array([[1, 0], [rho, np.sqrt(1 - rho**2)]])
        to_mesh, area = np.linalg.inv(from_mesh), sd.prod() * np.sqrt(1 - rho**2)
        side, step = np.linspace(-REACH, REACH, PLACES, retstep=True)
        mesh = np.stack([axis.ravel() for axis in np.meshgrid(side, side)], axis=1)
        normals = to_mesh @ covariances @ to_mesh.T, centred @ to_mesh.T
        density = _mixture(mesh, weights, *normals, step).reshape(PLACES, PLACES)
        x, y = (mean + mesh @ from_mesh.T).T.reshape(2, PLACES, PLACES)
        return Surface(x, y, density / area, density * step**2)

    def _with_node(self, i: int, name: str) -> Surface:
        """Lay a coefficient along x, sigma or tau along y."""
        means, covariances = (part[..., 0] for part in self._moments([i]))
        variances = covariances[..., 0]
        if name != "tau":  # nodes of the parameter first
            weights, means, variances = (part.T for part in (self._weights, means, variances))
        else:
            weights = self._weights
        x = self._mean[i] + self._sd[i] * np.linspace(-REACH, REACH, PLACES)
        variances = np.maximum(variances, (SHARPEST * (x[1] - x[0])) ** 2)
        z = (x - means[..., None]) / np.sqrt(variances)[..., None]
        normal = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi * variances)[..., None]
        mass_per_x = np.einsum("no,nox->nx", weights, normal)
        mesh_x, mesh_y = np.meshgrid(x, self._nodes[name])
        density = mass_per_x / self._widths[name][:, None]
        return Surface(mesh_x, mesh_y, density, mass_per_x * (x[1] - x[0]))


def _mixture(mesh: Array, weights: Array, covariances: Array, means: Array, step: float) -> Array:
    """Density of a mixture of normals at places of a mesh, ``(n_places,)``.

    Those sharper than the mesh's step are widened. Every exponent is one row of a matrix
    product, of squares, products and values of the places: twice as fast as one normal
    after the other.
    """
    values, vectors = np.linalg.eigh(covariances)
    values = np.maximum(values, (SHARPEST * step) ** 2)
    precision = (vectors / values[:, None, :]) @ vectors.transpose(0, 2, 1)
    pull = np.einsum("kab,kb->ka", precision, means)
    constant = np.einsum("ka,ka->k", pull, means) + np.log(values).sum(axis=1)
    u, v = mesh.T
    terms = np.stack([u**2, u * v, v**2, u, v, np.ones_like(u)], axis=1)
    weighing = np.stack(
        [precision[:, 0, 0], 2 * precision[:, 0, 1], precision[:, 1, 1], *(-2 * pull.T), constant]
    )
    return np.asarray(np.exp(terms @ weighing / -2) @ weights / (2 * np.pi))

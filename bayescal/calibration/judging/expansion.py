r"""The density with residuals to second order in the lens: its cost knows no number of points.

With u the lens in the posterior's deviations and terms f(u) = (1, u_i, u_i^2, u_i u_j), residuals
are e(u) = sum_k f_k(u) e_k, and their sum of squares, poses and offsets eliminated, is a quartic:

    S(u) = f(u)' Q f(u),    Q_kl = e_k' M e_l,

M the metric of what they leave (`Problem.products`). The e_k come from residuals at u = 0, one
step up and down along each axis, and at the corners between each two.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array
from bayescal.calibration.fitting.stacking import residuals
from bayescal.calibration.judging.by_views import ByViews
from bayescal.calibration.judging.density import Problem, at_steps, both_sides

CHECKED = 30  # lenses where it is compared with the density
NEAR = 0.05  # nat: root mean square over the posterior that it may be off


@dataclass(frozen=True, eq=False)
class Terms:
    """Residuals of a problem to second order about its lens.

    Attributes
    ----------
    x : Array
        Where u = 0, ``(dimension,)``.
    root : Array
        Steps of x for u = 1, ``(dimension, dimension)``, lower triangular.
    values : iterable of (slice, Array)
        The e_k of some views at a time, ``(n_terms, n_views, n_places, 2)``.
    slopes : iterable of (slice, Array)
        By the poses a step up and down each axis, ``(2 dimension, n_views, n_places, 2, 6)``.
    """

    x: Array
    root: Array
    values: Iterable[tuple[slice, Array]]
    slopes: Iterable[tuple[slice, Array]]

    @classmethod
    def of(cls, problem: Problem) -> Terms | None:
        """Find them; None where a point can't be seen from one of the lenses."""
        root, d = problem.spread, problem.model.dimension
        one, other = np.triu_indices(d, 1)
        ends = np.eye(d)
        u = np.concatenate([np.zeros((1, d)), ends, -ends, ends[one] + ends[other]])
        x = problem.x + u @ root.T

        def make(views: slice) -> Array:
            part = problem.between(views)
            found, possible = residuals(part.model, part.data, x, part.poses_at(x))
            if not possible.all():
                raise _UnseenError
            middle, up, down, corners = np.split(found, [1, d + 1, 2 * d + 1])
            slope, bend = (up - down) / 2, (up + down) / 2 - middle
            mixed = corners - up[one] - up[other] + middle
            return np.concatenate([middle, slope, bend, mixed])

        # On the way there are some three times as many numbers.
        values = ByViews(make, problem.data.n_views, 6 * len(x) * problem.data.which.shape[1])
        try:
            for _ in values:
                pass
        except _UnseenError:
            return None
        return cls(problem.x, root, values, problem.slopes)


class _UnseenError(Exception):
    """A point can't be seen from one of the lenses."""


@dataclass(frozen=True, eq=False)
class Expansion:
    """The density of a problem by terms of its residuals.

    Attributes
    ----------
    problem : Problem
        Linearised where the terms were found, under this or another error model.
    """

    problem: Problem
    terms: Terms

    @cached_property
    def _products(self) -> Array:
        """The matrix Q, ``(n_terms, n_terms)``."""
        return products(self.problem, self.terms.values)

    @cached_property
    def _log_det_response(self) -> tuple[Array, Array]:
        return both_sides(self.problem.log_det_of(self.terms.slopes))

    def _u(self, x: Array) -> Array:
        return solve_triangular(self.terms.root, (x - self.terms.x).T, lower=True).T

    def squares(self, x: Array) -> Array:
        """Smallest sum of squares over poses and offsets, ``(n_draws,)``."""
        u = self._u(x)
        one, other = np.triu_indices(u.shape[1], 1)
        f = np.concatenate([np.ones((len(u), 1)), u, u**2, u[:, one] * u[:, other]], axis=1)
        return np.asarray(np.maximum(np.einsum("sk,sk->s", f @ self._products, f), 0.0))

    def log_likelihood(self, x: Array) -> Array:
        """Log likelihood with poses, offsets and sigma integrated, ``(n_draws,)``."""
        change = at_steps(self._u(x), self._log_det_response)
        return self.problem.likelihood_of(self.squares(x), change)

    def log_prob(self, x: Array) -> Array:
        """Log likelihood times prior, ``(n_draws,)``."""
        return self.log_likelihood(x) + self.problem.log_prior(x)

    @property
    def near(self) -> bool:
        """Whether it is the problem's density over the posterior, by lenses drawn from it."""
        rng = np.random.default_rng(0)
        x = self.terms.x + rng.standard_normal((CHECKED, len(self.terms.x))) @ self.terms.root.T
        off = self.log_likelihood(x) - self.problem.log_likelihood(x)
        return bool(np.sqrt(np.mean(off**2)) <= NEAR)


def products(problem: Problem, terms: Iterable[tuple[slice, Array]]) -> Array:
    """Products of terms of the residuals, poses and offsets at their best, ``(p, p)``.

    Parameters
    ----------
    terms : iterable of (slice, Array)
        ``(p, n_views, n_places, 2)`` of some views at a time: the sum of squares of c @ terms is
        c @ products @ c.
    """
    taking, whole, poses, pulled = problem.taking, np.zeros((1, 1)), [], None
    for views, some in terms:
        arranged, weighted, taken, pull = taking.of_views(views, some)
        one, other = (np.moveaxis(a, 2, 0).reshape(len(some), -1) for a in (arranged, weighted))
        whole = whole + one @ other.T
        pulled = pull if pulled is None or pull is None else pulled + pull
        poses.append(taken)
    taken = taking.with_offsets(np.concatenate(poses, axis=1), pulled)
    return np.asarray(whole - taken @ taken.T)


def expanded(problem: Problem) -> Problem | Expansion:
    """Give the expansion of a settled problem, or the problem where it has none."""
    terms = Terms.of(problem)
    return problem if terms is None else Expansion(problem, terms)


def near(problem: Problem) -> Problem | Expansion:
    """Give the expansion of a settled problem where it is near, else the problem itself."""
    found = expanded(problem)
    return problem if isinstance(found, Expansion) and not found.near else found

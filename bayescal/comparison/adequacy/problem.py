"""A fitted model as its adequacy tests see it: an orthonormal design and residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from bayescal.arrays import Array, IntArray
from bayescal.linear.least_squares import LeastSquaresFit
from bayescal.noise.level import NoiseLevel
from bayescal.polynomials.axis_data import AxisData
from bayescal.polynomials.basis import legendre_design

# A column that the design explains up to this fraction of its length adds nothing
# that could be told from rounding.
NEW_DIRECTION = 1e-9
# Singular value of a design of unit columns below which a direction is rounding.
DEPENDENT = 1e-12
# A residual whose variance is below this fraction of sigma^2 is rounding only.
DETERMINED = 1e-8


@dataclass(frozen=True, eq=False)
class Extension:
    """What columns added to the design explain.

    Attributes
    ----------
    rank : int
        Directions that the design did not have.
    gain : float
        Fall of the residual sum of squares, weighted.
    rss : float
        What is left of it.
    dof : int
        Degrees of freedom left.
    shift : Array
        Change of the fitted values, ``(n_points,)``, weighted.
    leverage : Array
        Variance of `shift` at unit noise, ``(n_points,)``.
    exact : bool
        Whether what is left is rounding only.
    """

    rank: int
    gain: float
    rss: float
    dof: int
    shift: Array
    leverage: Array
    exact: bool

    @property
    def f(self) -> float:
        """F statistic of the added columns (Draper & Smith 1998, 6.2)."""
        return self.gain / self.rank / (self.rss / self.dof)


@dataclass(frozen=True, eq=False)
class Problem:
    """An axis, a linear model of it and its noise level; what is weighted is in units of `sd`.

    Attributes
    ----------
    data : AxisData
        Of a model that is not linear: its residuals in place of t.
    design : Array
        Slopes of the predictions, ``(n_points, k)``; columns may depend on each other.
    what : str
        The model in words.
    """

    data: AxisData
    design: Array
    noise: NoiseLevel
    what: str = "the model"

    @classmethod
    def of(cls, data: AxisData, fit: LeastSquaresFit, noise: NoiseLevel) -> Problem:
        """Make the problem of a fitted order."""
        design = legendre_design(scaled(data.x), fit.order)
        return cls(data, design, noise, f"order {fit.order}")

    @property
    def n(self) -> int:
        """Number of points whose residuals are looked at: of a sample where there are many."""
        return len(self.data)

    @property
    def p(self) -> int:
        """Number of coefficients."""
        return int(self.q.shape[1])

    @property
    def dof(self) -> int:
        """Degrees of freedom that the residuals of these points have."""
        return self.n - self.p

    @property
    def unit(self) -> str:
        """Unit of the residuals."""
        return self.data.unit

    @cached_property
    def sd(self) -> Array:
        """Known deviations, or 1 for every point, ``(n_points,)``."""
        return np.ones(self.n) if self.data.sd is None else self.data.sd

    @cached_property
    def s(self) -> Array:
        """Regressor scaled to [-1, 1], ``(n_points,)``."""
        return scaled(self.data.x)

    @cached_property
    def q(self) -> Array:
        """Orthonormal basis of the weighted design, ``(n_points, p)``."""
        weighted = self.design / self.sd[:, None]
        lengths = np.linalg.norm(weighted, axis=0)
        q, r = np.linalg.qr(weighted[:, lengths > 0] / lengths[lengths > 0])
        u, size, _ = np.linalg.svd(r)
        if size[-1] > DEPENDENT * size[0]:
            return q
        independent: Array = q @ u[:, size > DEPENDENT * size[0]]
        return independent

    def residual(self, columns: Array) -> Array:
        """Part of weighted columns that the design does not explain."""
        left = columns - self.q @ (self.q.T @ columns)
        left -= self.q @ (self.q.T @ left)  # twice is enough (Kahan, in Parlett 1980, 6-9)
        return left

    @cached_property
    def e(self) -> Array:
        """Weighted residuals of the fit, ``(n_points,)``."""
        return self.residual(self.data.t / self.sd)

    @cached_property
    def rss(self) -> float:
        """Weighted residual sum of squares."""
        return float(self.e @ self.e)

    @cached_property
    def rounding(self) -> float:
        """Residual sum of squares below which a fit is exact: n (64 eps max|t|)^2."""
        floor = 64 * np.finfo(float).eps * float(np.abs(self.data.t / self.sd).max())
        return self.n * floor**2

    @property
    def exact(self) -> bool:
        """Whether the residuals are rounding only."""
        return self.rss <= self.rounding

    @property
    def sigma_hat(self) -> float | None:
        """Unbiased noise level of the residuals; None where none is left."""
        return math.sqrt(self.rss / self.dof) if self.dof > 0 else None

    @property
    def unusable(self) -> str | None:
        """Why the residuals can't be tested, or None."""
        if self.dof <= 0:
            return f"{self.p} coefficients fit {self.n} points exactly, no residual is left"
        if self.exact:
            return "the fit is exact, the residuals are rounding only"
        return None

    @cached_property
    def free(self) -> Array:
        """Variance of the weighted residuals in units of sigma^2, 1 - leverage."""
        return 1 - (self.q**2).sum(axis=1)

    @cached_property
    def usable(self) -> IntArray:
        """Points whose residual the fit does not determine, as indices."""
        return np.flatnonzero(self.free > DETERMINED)

    @cached_property
    def studentised(self) -> Array:
        """Internally studentised residuals of the `usable` points (Cook & Weisberg 1982)."""
        keep = self.usable
        scale = np.sqrt(self.rss / self.dof * self.free[keep])
        return self.e[keep] / scale

    def extend(self, columns: Array) -> Extension:
        """Fit with columns added to the design, the full design refitted.

        Parameters
        ----------
        columns : Array
            ``(n_points, k)``, not weighted.
        """
        weighted = columns / self.sd[:, None]
        lengths = np.linalg.norm(weighted, axis=0)
        left = self.residual(weighted / np.where(lengths > 0, lengths, 1.0))
        return extension(left, self.e, self.dof, self.rounding)


def extension(left: Array, e: Array, dof: int, rounding: float) -> Extension:
    """Explain residuals by the new part of added columns, by orthogonal projection.

    Parameters
    ----------
    left : Array
        What a base model leaves of columns of unit length, ``(n_points, k)``.
    e : Array
        What it leaves of the pixels, ``(n_points,)``, weighted.
    dof : int
        Degrees of freedom of `e`.
    rounding : float
        Residual sum of squares that counts as none.
    """
    u, size, _ = np.linalg.svd(left, full_matrices=False)
    u = u[:, size > NEW_DIRECTION]
    found = u.T @ e
    shift = u @ found
    rest = e - shift
    rss, rank = float(rest @ rest), u.shape[1]
    leverage = (u**2).sum(axis=1)
    return Extension(rank, float(found @ found), rss, dof - rank, shift, leverage, rss <= rounding)


def other_name(regressor: str) -> str:
    """Name of the regressor that the axis's polynomial leaves out."""
    return {"x/z": "y/z", "y/z": "x/z"}.get(regressor, "other")


def scaled(values: Array) -> Array:
    """Map values to [-1, 1]; zeros where they are all the same up to rounding."""
    low, high = float(values.min()), float(values.max())
    if high - low <= 1e-12 * max(abs(low), abs(high)):
        return np.zeros(len(values))
    return (values - (low + (high - low) / 2)) / ((high - low) / 2)

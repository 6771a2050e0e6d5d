"""Least squares of any design matrix, with the leverage of every point.

For designs that are not nested in a Legendre basis; `least_squares` serves those
that are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular

from bayescal.arrays import Array, frozen
from bayescal.errors import InputError
from bayescal.rounding import counted

# A leverage this close to 1 leaves a point no residual of its own: removing it
# would leave its column undetermined.
FULL_LEVERAGE = 1 - 1e-10


@dataclass(frozen=True, eq=False)
class DesignFit:
    """Least-squares fit of one design.

    Attributes
    ----------
    coefficients : Array
        One per column of the design, ``(n_coefficients,)``, px.
    residuals : Array
        Measured less predicted, ``(n_points,)``, px.
    leverages : Array
        Diagonal h of the projection on the design's columns, ``(n_points,)``; a
        residual's variance is sigma^2 (1 - h).
    rss : float
        Residual sum of squares, px^2.
    exact : bool
        Whether the residuals are rounding: rss below n (64 eps max|t|)^2.
    """

    coefficients: Array
    residuals: Array
    leverages: Array
    rss: float
    exact: bool

    def __len__(self) -> int:
        return len(self.residuals)

    @property
    def n_coefficients(self) -> int:
        """Number of coefficients p."""
        return len(self.coefficients)

    @property
    def dof(self) -> int:
        """Degrees of freedom n - p."""
        return len(self) - self.n_coefficients

    @property
    def rms(self) -> float:
        """Root mean square of the residuals, sqrt(rss / n), px."""
        return float(np.sqrt(self.rss / len(self)))

    @property
    def rms_left_out(self) -> float | None:
        """Root mean square error at each point predicted from the others, px.

        e / (1 - h) is the residual of a point left out of its own fit (Allen 1974,
        Technometrics 16, 125). None where a point can't be left out.
        """
        if (self.leverages >= FULL_LEVERAGE).any():
            return None
        return float(np.sqrt(np.mean((self.residuals / (1 - self.leverages)) ** 2)))


def fit_design(design: Array, t: Array) -> DesignFit:
    """Fit pixels by least squares: QR of the design with its columns scaled to norm 1.

    Scaling leaves the fit unchanged and keeps the factorisation's condition that of
    the columns' directions: at order 5 of the thesis data 24 (r) and 52 (c), where
    the normal matrix of raw monomials has 1.2e5 and 2.7e9.

    Parameters
    ----------
    design : Array
        ``(n_points, n_coefficients)``.
    t : Array
        Measured pixels, ``(n_points,)``, px.

    Raises
    ------
    InputError
        Where shapes disagree, a number is not finite, or the points can't determine
        the coefficients.
    """
    design, t = np.asarray(design, dtype=float), np.asarray(t, dtype=float)
    if design.ndim != 2 or t.shape != design.shape[:1] or design.shape[1] == 0:
        raise InputError(f"design {design.shape} and pixels {t.shape} do not belong together")
    n, p = design.shape
    if not (np.isfinite(design).all() and np.isfinite(t).all()):
        raise InputError("the design and the pixels must be finite")
    if n < p:
        raise InputError(f"{p} coefficients can't be found from {counted(n, 'point')}; add points")
    norms = np.linalg.norm(design, axis=0)
    q, triangle = np.linalg.qr(design / np.where(norms > 0, norms, 1.0))
    values = np.linalg.svd(triangle, compute_uv=False)
    rank = int((values > n * np.finfo(float).eps * values[0]).sum())
    if rank < p:
        raise InputError(
            f"the points determine {rank} of {p} coefficients; take a lower order or add points"
        )
    projected = q.T @ t
    residuals = t - q @ projected
    floor = 64 * np.finfo(float).eps * float(np.abs(t).max())
    rss = float(residuals @ residuals)
    return DesignFit(
        frozen(solve_triangular(triangle, projected) / norms),
        frozen(residuals),
        frozen(np.minimum((q * q).sum(axis=1), 1.0)),
        rss,
        bool(rss < n * floor**2),
    )
